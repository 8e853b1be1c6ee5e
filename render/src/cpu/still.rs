//! Sampling what stands still before a pinhole: the two triangles of a micropolygon against a cell of samples at a time.

use crate::cpu::lanes::{LANES, Lanes, with_lanes};
use crate::cpu::micropolygon::Micropolygon;
use crate::cpu::samples::{CELL, EDGE, SampledGrid, Samples, Tally};

/// A triangle as planes over the raster from its first corner on: weights of its second and third corner, and depth.
struct Planes {
    second: [f32; 2],
    third: [f32; 2],
    depth: [f32; 3],
    /// Minimum and maximum depth.
    range: [f32; 2],
    /// The minimum weight of each corner inside: an edge's width below 0. Infinite if the triangle has no area.
    min_weight: [f32; 3],
}

impl Planes {
    /// Of the corners `a`, `a + u` and `a + v`: x, y, depth.
    #[inline(always)]
    fn new(z: f32, u: [f32; 3], v: [f32; 3]) -> Planes {
        let area = u[0] * v[1] - v[0] * u[1];
        let inv = 1.0 / area;
        let sound = area != 0.0 && inv.is_finite();
        let inv = if sound { inv } else { 0.0 };
        let side = |x: f32, y: f32| if sound { -EDGE * (x.abs() + y.abs()) * inv.abs() } else { f32::INFINITY };
        Planes {
            second: [v[1] * inv, -v[0] * inv],
            third: [-u[1] * inv, u[0] * inv],
            depth: [z, u[2], v[2]],
            range: [z + u[2].min(v[2]).min(0.0), z + u[2].max(v[2]).max(0.0)],
            min_weight: [side(v[0] - u[0], v[1] - u[1]), side(v[0], v[1]), side(u[0], u[1])],
        }
    }

    /// Weights of the second and third corner at places from the first corner on, and the depth there: infinite outside.
    #[inline(always)]
    fn meet<L: Lanes>(&self, dx: L, dy: L) -> [L; 3] {
        let w1 = L::splat(self.second[0]) * dx + L::splat(self.second[1]) * dy;
        let w2 = L::splat(self.third[0]) * dx + L::splat(self.third[1]) * dy;
        let w0 = L::splat(1.0) - w1 - w2;
        let [z0, z1, z2] = self.depth;
        // Beyond a sliver's edge its plane runs wild.
        let z = L::splat(z0) + L::splat(z1) * w1 + L::splat(z2) * w2;
        let z = z.max(L::splat(self.range[0])).min(L::splat(self.range[1]));
        let [l0, l1, l2] = self.min_weight;
        let inside = w0.ge(L::splat(l0)).and(w1.ge(L::splat(l1))).and(w2.ge(L::splat(l2)));
        [w1, w2, inside.select(z, L::splat(f32::INFINITY))]
    }
}

impl Samples {
    with_lanes! {
        /// Sample micropolygons of a grid in rows of `nu` points, each named by its first point; `raster` has x, y and depth of
        /// every point.
        pub fn still = still_lanes(raster: &[[f32; 3]], nu: usize, micropolygons: &[u32], grid: &SampledGrid<'_>) -> Tally
    }

    #[inline(always)]
    fn still_lanes<L: Lanes>(
        &mut self,
        raster: &[[f32; 3]],
        nu: usize,
        micropolygons: &[u32],
        grid: &SampledGrid<'_>,
    ) -> Tally {
        let mut tally = Tally::default();
        for point in micropolygons {
            let k = *point as usize;
            let corners = [k, k + 1, k + nu + 1, k + nu].map(|k| raster[k]);
            match (grid.opaque, grid.smooth) {
                (true, false) => self.quad::<L, true, false>(corners, k, grid, &mut tally),
                (true, true) => self.quad::<L, true, true>(corners, k, grid, &mut tally),
                (false, _) => self.quad::<L, false, true>(corners, k, grid, &mut tally),
            }
        }
        tally
    }

    #[inline(always)]
    fn quad<L: Lanes, const OPAQUE: bool, const SMOOTH: bool>(
        &mut self,
        corners: [[f32; 3]; 4],
        point: usize,
        grid: &SampledGrid<'_>,
        tally: &mut Tally,
    ) {
        let (ox, oy) = (self.x0 as f32, self.y0 as f32);
        let a = corners[0];
        // All is counted from the first corner: its differences are the same in every bucket.
        let [b, c, d] = [corners[1], corners[2], corners[3]].map(|p| [p[0] - a[0], p[1] - a[1], p[2] - a[2]]);
        let a = [a[0] - ox, a[1] - oy, a[2]];
        let low = |i: usize| b[i].min(c[i]).min(d[i]).min(0.0) - EDGE;
        let high = |i: usize| b[i].max(c[i]).max(d[i]).max(0.0) + EDGE;
        let (low_x, high_x, low_y, high_y) = (low(0), high(0), low(1), high(1));
        // With some room for rounding.
        let (min_x, max_x) = (a[0] + low_x - EDGE, a[0] + high_x + EDGE);
        let (min_y, max_y) = (a[1] + low_y - EDGE, a[1] + high_y + EDGE);
        if !(max_x >= 0.0 && max_y >= 0.0 && min_x < self.width as f32 && min_y < self.height as f32) {
            return;
        }
        let (first, second) = (Planes::new(a[2], b, c), Planes::new(a[2], c, d));
        let cells = |lo: f32, hi: f32, axis: usize, n: usize| {
            let cell = |x: f32| (x * self.strata[axis] as f32) as usize / CELL[axis];
            [cell(lo.max(0.0)), cell(hi).min(n - 1)]
        };
        let ([c0, c1], [r0, r1]) = (cells(min_x, max_x, 0, self.columns), cells(min_y, max_y, 1, self.rows));
        let names = [false, true].map(|second| Micropolygon::new(grid.index, point, second).id());
        let mut hit = false;
        for r in r0..=r1 {
            for cell in r * self.columns + c0..=r * self.columns + c1 {
                let k = cell * LANES;
                let (dx, dy) = (L::load(&self.x, k) - L::splat(a[0]), L::load(&self.y, k) - L::splat(a[1]));
                let [p1, p2, pz] = first.meet(dx, dy);
                let [q1, q2, qz] = second.meet(dx, dy);
                let old = L::load(&self.z, k);
                let later = qz.lt(pz);
                let z = later.select(qz, pz);
                let takes = z.lt(old).and(dx.between(low_x, high_x)).and(dy.between(low_y, high_y));
                let mut taken = takes.bits();
                if taken == 0 {
                    continue;
                }
                hit = true;
                if OPAQUE {
                    takes.select(z, old).store(&mut self.z, k);
                    takes.store_id(later, names, &mut self.visible, k);
                    if SMOOTH {
                        let [w1, w2] = &mut self.weights;
                        takes.select(later.select(q1, p1), L::load(w1, k)).store(w1, k);
                        takes.select(later.select(q2, p2), L::load(w2, k)).store(w2, k);
                    }
                } else {
                    let (z, w1, w2) = (z.to_array(), later.select(q1, p1).to_array(), later.select(q2, p2).to_array());
                    while taken != 0 {
                        let i = taken.trailing_zeros() as usize;
                        taken &= taken - 1;
                        let half = (later.bits() >> i & 1) as usize;
                        let name = Micropolygon::from_id(names[half]);
                        let area = || [b[0] * c[1] - c[0] * b[1], c[0] * d[1] - d[0] * c[1]][half];
                        self.record(k + i, z[i], name, [w1[i], w2[i]], grid, area);
                    }
                }
            }
        }
        tally.tried += ((r1 + 1).saturating_sub(r0) * (c1 + 1).saturating_sub(c0) * LANES) as u64;
        if hit {
            tally.hit = true;
            if OPAQUE {
                let pixel = |cell: usize, axis: usize| cell * CELL[axis] / self.strata[axis];
                let last = |cell: usize, axis: usize| ((cell + 1) * CELL[axis] - 1) / self.strata[axis];
                let (x, y) = (last(c1, 0).min(self.width - 1), last(r1, 1).min(self.height - 1));
                self.mark(pixel(c0, 0), x, pixel(r0, 1), y);
            }
        }
    }
}
