//! Sampling what stands still before a pinhole: the two triangles of a micropolygon against a cell of samples at a time.

use crate::cpu::lanes::{LANES, Lanes, with_lanes};
use crate::cpu::micropolygon::Micropolygon;
use crate::cpu::samples::edges::AtEdge;
use crate::cpu::samples::{CELL, EDGE, SampledGrid, Samples, Tally};

/// Widths of an edge from which on a place inside is at no edge.
const CLEAR: f32 = 4.0;

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
    /// Of the corners `a`, `a + u` and `a + v`: x, y, depth; as if it had no area if that is not of the sign of `side`, unless this is 0.
    #[inline(always)]
    fn new(z: f32, u: [f32; 3], v: [f32; 3], side: f32) -> Planes {
        let area = u[0] * v[1] - v[0] * u[1];
        let inv = 1.0 / area;
        let sound = area != 0.0 && inv.is_finite() && side * area >= 0.0;
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

    /// The same at one place, whether it is inside or not: the weights, and the depth.
    #[inline]
    fn at(&self, [dx, dy]: [f32; 2]) -> [f32; 3] {
        let w1 = self.second[0] * dx + self.second[1] * dy;
        let w2 = self.third[0] * dx + self.third[1] * dy;
        let z = self.depth[0] + self.depth[1] * w1 + self.depth[2] * w2;
        [w1, w2, z.max(self.range[0]).min(self.range[1])]
    }

    /// Whether weights are those of a place that is at no edge.
    #[inline]
    fn is_clear(&self, [w1, w2]: [f32; 2]) -> bool {
        let clear = |w: f32, min: f32| w > CLEAR * min.abs();
        let [l0, l1, l2] = self.min_weight;
        clear(1.0 - w1 - w2, l0) && clear(w1, l1) && clear(w2, l2)
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

/// Samples of a cell about a micropolygon: places from its first corner on; weights and depth in its first triangle, and in its second.
struct Near {
    places: [[f32; LANES]; 2],
    first: [[f32; LANES]; 3],
    second: [[f32; LANES]; 3],
    /// Which are nearer in the second.
    later: u32,
}

impl Near {
    #[inline(always)]
    fn place(&self, i: usize) -> [f32; 2] {
        self.places.map(|v| v[i])
    }

    /// The triangle that has a sample, with the weights and the depth there, if the sample lies at no edge of it, nor in the other.
    #[inline(always)]
    fn clear(&self, planes: [&Planes; 2], i: usize) -> Option<(usize, [f32; 3])> {
        let half = (self.later >> i & 1) as usize;
        let (own, other) = if half == 0 { (&self.first, &self.second) } else { (&self.second, &self.first) };
        let [w1, w2, z] = [own[0][i], own[1][i], own[2][i]];
        (other[2][i] == f32::INFINITY && planes[half].is_clear([w1, w2])).then_some((half, [w1, w2, z]))
    }
}

/// Which triangle of a micropolygon has a sample that lies at an edge, if one has it: the nearer one of two. The micropolygon has its
/// first corner, and the others and the sample from there on; weights and depth there, and where it is.
#[inline(never)]
fn at_edges(
    planes: [&Planes; 2],
    [a, b, c, d]: [[f32; 3]; 4],
    at: [f32; 2],
    point: usize,
    grid: &SampledGrid<'_>,
) -> Option<(usize, [f32; 3], AtEdge)> {
    let corners = [[0.0; 3], b, c, d].map(|p| [p[0] - at[0], p[1] - at[1]]);
    let around = grid.around(point, corners);
    let met = planes.map(|planes| planes.at(at));
    let half = match around.inside() {
        [false, false] => return None,
        [true, true] => (met[1][2] < met[0][2]) as usize,
        [_, second] => second as usize,
    };
    let depths = [a[2], a[2] + b[2], a[2] + c[2], a[2] + d[2]];
    Some((half, met[half], around.at_edge(half == 1, depths)))
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
            match (!grid.as_layers, grid.smooth) {
                (true, false) => self.quad::<L, true, false>(corners, k, grid, &mut tally),
                (true, true) => self.quad::<L, true, true>(corners, k, grid, &mut tally),
                (false, _) => self.quad::<L, false, true>(corners, k, grid, &mut tally),
            }
        }
        tally
    }

    /// Record what is sampled as layers are, for the samples `taken` of those from `k` on; whether any takes it. The micropolygon has its first
    /// corner, and the others from there on.
    #[inline(always)]
    fn quad_layers(
        &mut self,
        near: &Near,
        planes: [&Planes; 2],
        corners: [[f32; 3]; 4],
        (k, mut taken): (usize, u32),
        point: usize,
        grid: &SampledGrid<'_>,
    ) -> bool {
        let mut hit = false;
        while taken != 0 {
            let i = taken.trailing_zeros() as usize;
            taken &= taken - 1;
            let found = match near.clear(planes, i) {
                Some((half, met)) => Some((half, met, AtEdge::default())),
                None => at_edges(planes, corners, near.place(i), point, grid),
            };
            let Some((half, [w1, w2, z], at_edge)) = found.filter(|found| found.1[2] < self.z[k + i]) else { continue };
            hit = true;
            let name = Micropolygon::new(grid.index, point, half == 1);
            let [_, b, c, d] = corners;
            let area = || [b[0] * c[1] - c[0] * b[1], c[0] * d[1] - d[0] * c[1]][half];
            self.record(k + i, z, name, ([w1, w2], at_edge), grid, area);
        }
        hit
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
        let (first, second) = (Planes::new(a[2], b, c, grid.side), Planes::new(a[2], c, d, grid.side));
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
                let taken = takes.bits();
                if taken == 0 {
                    continue;
                }
                if OPAQUE {
                    hit = true;
                    takes.select(z, old).store(&mut self.z, k);
                    takes.store_id(later, names, &mut self.visible, k);
                    if SMOOTH {
                        let [w1, w2] = &mut self.weights;
                        takes.select(later.select(q1, p1), L::load(w1, k)).store(w1, k);
                        takes.select(later.select(q2, p2), L::load(w2, k)).store(w2, k);
                    }
                } else {
                    let near = Near {
                        places: [dx.to_array(), dy.to_array()],
                        first: [p1.to_array(), p2.to_array(), pz.to_array()],
                        second: [q1.to_array(), q2.to_array(), qz.to_array()],
                        later: later.bits(),
                    };
                    hit |= self.quad_layers(&near, [&first, &second], [a, b, c, d], (k, taken), point, grid);
                }
            }
        }
        tally.tried += ((r1 + 1).saturating_sub(r0) * (c1 + 1).saturating_sub(c0) * LANES) as u64;
        if hit {
            tally.hit = true;
            if grid.opaque {
                let pixel = |cell: usize, axis: usize| cell * CELL[axis] / self.strata[axis];
                let last = |cell: usize, axis: usize| ((cell + 1) * CELL[axis] - 1) / self.strata[axis];
                let (x, y) = (last(c1, 0).min(self.width - 1), last(r1, 1).min(self.height - 1));
                self.mark(pixel(c0, 0), x, pixel(r0, 1), y);
            }
        }
    }
}
