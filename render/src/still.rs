//! Sampling what stands still before a pinhole: the two triangles of a micropolygon against eight samples at a time.

use crate::sample::{EDGE, Kind, LANES, Samples, Tally};
use crate::seen::Micropolygon;

/// A triangle as planes over the raster from its first corner on: weights of its second and third corner, and depth.
struct Planes {
    second: [f32; 2],
    third: [f32; 2],
    depth: [f32; 3],
    /// Least and greatest depth.
    range: [f32; 2],
    /// The least weight of each corner inside: an edge's width below 0. Infinite if the triangle has no area.
    least: [f32; 3],
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
            least: [side(v[0] - u[0], v[1] - u[1]), side(v[0], v[1]), side(u[0], u[1])],
        }
    }

    /// Weights of the second and third corner at places from the first corner on, and the depth there: infinite outside.
    #[inline(always)]
    fn meet(&self, dx: &Lanes, dy: &Lanes) -> [Lanes; 3] {
        let plane = |p: [f32; 2]| each(|i| p[0] * dx[i] + p[1] * dy[i]);
        let (w1, w2) = (plane(self.second), plane(self.third));
        let w0 = each(|i| 1.0 - w1[i] - w2[i]);
        let z = each(|i| self.depth[0] + self.depth[1] * w1[i] + self.depth[2] * w2[i]);
        // Beyond a sliver's edge its plane runs wild.
        let [lo, hi] = self.range;
        let z = each(|i| if z[i] < lo { lo } else { z[i] });
        let z = each(|i| if z[i] > hi { hi } else { z[i] });
        let [l0, l1, l2] = self.least;
        let (in0, in1, in2) = (mask(|i| w0[i] >= l0), mask(|i| w1[i] >= l1), mask(|i| w2[i] >= l2));
        let inside = each(|i| in0[i] & in1[i] & in2[i]);
        [w1, w2, pick(&inside, &z, &[f32::INFINITY; LANES])]
    }
}

/// As many numbers as are worked on at once.
type Lanes = [f32; LANES];

/// What is true of lanes: all bits set where it is.
type Mask = [u32; LANES];

#[inline(always)]
fn each<T: Copy + Default>(f: impl Fn(usize) -> T) -> [T; LANES] {
    let mut out = [T::default(); LANES];
    for (i, out) in out.iter_mut().enumerate() {
        *out = f(i);
    }
    out
}

#[inline(always)]
fn mask(f: impl Fn(usize) -> bool) -> Mask {
    each(|i| if f(i) { u32::MAX } else { 0 })
}

/// `a` where the mask is set, `b` elsewhere; by bits, so that it stays one operation on all lanes.
#[inline(always)]
fn pick(mask: &Mask, a: &Lanes, b: &Lanes) -> Lanes {
    each(|i| f32::from_bits(a[i].to_bits() & mask[i] | b[i].to_bits() & !mask[i]))
}

/// Lanes as they are counted.
const COUNT: [u32; LANES] = [0, 1, 2, 3, 4, 5, 6, 7];

impl Samples {
    /// Sample micropolygons of a grid in rows of `nu` points, each named by its first point; `raster` has x, y and depth of
    /// every point.
    pub fn still(&mut self, raster: &[[f32; 3]], nu: usize, micropolygons: &[u32], kind: &Kind) -> Tally {
        #[cfg(target_arch = "x86_64")]
        if std::arch::is_x86_feature_detected!("avx2") {
            // SAFETY: the processor has AVX2.
            return unsafe { self.still_avx2(raster, nu, micropolygons, kind) };
        }
        self.still_lanes(raster, nu, micropolygons, kind)
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    unsafe fn still_avx2(&mut self, raster: &[[f32; 3]], nu: usize, micropolygons: &[u32], kind: &Kind) -> Tally {
        self.still_lanes(raster, nu, micropolygons, kind)
    }

    #[inline(always)]
    fn still_lanes(&mut self, raster: &[[f32; 3]], nu: usize, micropolygons: &[u32], kind: &Kind) -> Tally {
        let mut tally = Tally::default();
        for point in micropolygons {
            let k = *point as usize;
            let corners = [k, k + 1, k + nu + 1, k + nu].map(|k| raster[k]);
            match (kind.opaque, kind.smooth) {
                (true, false) => self.quad::<true, false>(corners, k, kind, &mut tally),
                (true, true) => self.quad::<true, true>(corners, k, kind, &mut tally),
                (false, _) => self.quad::<false, true>(corners, k, kind, &mut tally),
            }
        }
        tally
    }

    #[inline(always)]
    fn quad<const OPAQUE: bool, const SMOOTH: bool>(
        &mut self,
        corners: [[f32; 3]; 4],
        point: usize,
        kind: &Kind,
        tally: &mut Tally,
    ) {
        let (ox, oy) = (self.x0 as f32, self.y0 as f32);
        let [a, b, c, d] = corners.map(|[x, y, z]| [x - ox, y - oy, z]);
        let low = |i: usize| a[i].min(b[i]).min(c[i].min(d[i])) - EDGE;
        let high = |i: usize| a[i].max(b[i]).max(c[i].max(d[i])) + EDGE;
        let (min_x, max_x, min_y, max_y) = (low(0), high(0), low(1), high(1));
        if !(max_x >= 0.0 && max_y >= 0.0 && min_x < self.width as f32 && min_y < self.height as f32) {
            return;
        }
        let from_a = |p: [f32; 3]| [p[0] - a[0], p[1] - a[1], p[2] - a[2]];
        let (b, c, d) = (from_a(b), from_a(c), from_a(d));
        let (first, second) = (Planes::new(a[2], b, c), Planes::new(a[2], c, d));
        let [sx, sy] = self.strata.map(|s| s as f32);
        let (c0, c1) = ((min_x.max(0.0) * sx) as usize, ((max_x * sx) as usize).min(self.columns - 1));
        let (r0, r1) = ((min_y.max(0.0) * sy) as usize, ((max_y * sy) as usize).min(self.rows - 1));
        let names = [Micropolygon::new(kind.grid, point, false), Micropolygon::new(kind.grid, point, true)];
        let mut hit = [0u32; LANES];
        for r in r0..=r1 {
            let mut column = c0;
            while column <= c1 {
                let k = r * self.columns + column;
                let count = (c1 + 1 - column) as u32;
                column += LANES;
                let (x, y) = (lanes(&mut self.x, k), lanes(&mut self.y, k));
                let (dx, dy) = (each(|i| x[i] - a[0]), each(|i| y[i] - a[1]));
                let [p1, p2, pz] = first.meet(&dx, &dy);
                let [q1, q2, qz] = second.meet(&dx, &dy);
                let old = lanes(&mut self.z, k);
                let later = mask(|i| qz[i] < pz[i]);
                let z = pick(&later, &qz, &pz);
                let (nearer, counted) = (mask(|i| z[i] < old[i]), mask(|i| COUNT[i] < count));
                let takes = each(|i| nearer[i] & counted[i]);
                if takes.iter().fold(0, |any, m| any | m) == 0 {
                    continue;
                }
                if OPAQUE {
                    *old = pick(&takes, &z, old);
                    let seen = lanes(&mut self.seen, k);
                    let second = later.map(|m| m & 1);
                    for i in 0..LANES {
                        seen[i] = names[0].or(second[i]).pick(seen[i], takes[i]);
                    }
                    hit = each(|i| hit[i] | takes[i]);
                    if SMOOTH {
                        let [w1, w2] = &mut self.weights;
                        let (w1, w2) = (lanes(w1, k), lanes(w2, k));
                        *w1 = pick(&takes, &pick(&later, &q1, &p1), w1);
                        *w2 = pick(&takes, &pick(&later, &q2, &p2), w2);
                    }
                } else {
                    for i in (0..LANES).filter(|i| takes[*i] != 0) {
                        let second = later[i] != 0;
                        let weights = if second { [q1[i], q2[i]] } else { [p1[i], p2[i]] };
                        self.keep(k + i, z[i], names[second as usize], weights, kind);
                        hit[i] = 1;
                    }
                }
            }
        }
        tally.tried += ((r1 + 1).saturating_sub(r0) * (c1 + 1).saturating_sub(c0)) as u64;
        if hit.iter().any(|h| *h != 0) {
            tally.hit = true;
            if OPAQUE {
                let [sx, sy] = self.strata;
                self.mark(c0 / sx, c1 / sx, r0 / sy, r1 / sy);
            }
        }
    }
}

/// `LANES` values from `k` on; the columns are padded.
#[inline(always)]
fn lanes<T>(v: &mut [T], k: usize) -> &mut [T; LANES] {
    (&mut v[k..k + LANES]).try_into().expect("the columns are padded")
}
