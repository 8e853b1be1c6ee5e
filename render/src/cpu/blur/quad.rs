//! A micropolygon over time, and which of some samples meet it.

use crate::cpu::lanes::Lanes;
use crate::cpu::samples::edges::{AtEdge, area_of};
use crate::cpu::samples::{EDGE, SampledGrid, Samples, within};
use crate::film::jitter::Jitter;
use crate::scene::camera::Camera;
use crate::scene::motion::Instant;

/// Widths of an edge from which on a place inside is at no edge.
const CLEAR: f32 = 4.0;

/// The points of a grid over time.
pub struct Track<'a> {
    /// The item's moments.
    pub instants: &'a [Instant],
    /// Raster x, y and depth of every point at each of them.
    pub raster: &'a [Vec<[f32; 3]>],
    /// The camera, for its lens.
    pub camera: &'a Camera,
    /// Where the samples are.
    pub jitter: &'a Jitter,
}

/// A micropolygon that moves straight between two times: each number of its corners is one at time 0 plus one a unit of time.
pub struct Quad {
    x: [[f32; 4]; 2],
    y: [[f32; 4]; 2],
    /// Depths.
    pub z: [[f32; 4]; 2],
    /// How far the lens spreads each.
    spread: [[f32; 4]; 2],
    /// Least and greatest x and y of all corners without the lens, at time 0 and a unit of time; and of the spread at all times.
    low: [[f32; 2]; 2],
    high: [[f32; 2]; 2],
    spreads: [f32; 2],
    /// The least depth.
    pub near: f32,
    /// How far outside a sample may be, as twice an area: an edge's width.
    slack: f32,
    /// The sign of the area of triangles that are there; 0 if both are.
    side: f32,
}

impl Quad {
    /// Of four points of a grid, from a moment of its item on; `side` is [`SampledGrid::side`].
    pub fn new(points: [usize; 4], track: &Track<'_>, key: usize, side: f32) -> Quad {
        let next = (key + 1).min(track.instants.len() - 1);
        let (from, to) = (&track.raster[key], &track.raster[next]);
        let start = track.instants[key].time;
        let length = track.instants[next].time - start;
        let rate = if next > key { 1.0 / length } else { 0.0 };
        // Of two values at the keys, the one at time 0 and the change.
        let line = |a: f32, b: f32| {
            let change = (b - a) * rate;
            (a - change * start, change)
        };
        let lines = |v: &dyn Fn(&[f32; 3]) -> f32| {
            let both = points.map(|p| line(v(&from[p]), v(&to[p])));
            [both.map(|b| b.0), both.map(|b| b.1)]
        };
        let (x, y, z) = (lines(&|p| p[0]), lines(&|p| p[1]), lines(&|p| p[2]));
        let near = points.iter().map(|p| from[*p][2].min(to[*p][2])).fold(f32::INFINITY, f32::min);
        let mut quad = Quad {
            x,
            y,
            z,
            spread: [[0.0; 4]; 2],
            low: [[0.0; 2]; 2],
            high: [[0.0; 2]; 2],
            spreads: [0.0; 2],
            near,
            slack: 0.0,
            side,
        };
        if track.camera.has_lens() {
            let of = |p: &[f32; 3]| track.camera.confusion(p[2]);
            quad.spread = lines(&of);
            let all = points.iter().flat_map(|p| [of(&from[*p]), of(&to[*p])]);
            quad.spreads = all.fold([f32::INFINITY, f32::NEG_INFINITY], |[lo, hi], c| [lo.min(c), hi.max(c)]);
        }
        let ends = |raster: &[[f32; 3]], c: usize| {
            points
                .iter()
                .fold([f32::INFINITY, f32::NEG_INFINITY], |[lo, hi], p| [lo.min(raster[*p][c]), hi.max(raster[*p][c])])
        };
        let mut size = quad.spreads[1] - quad.spreads[0] + 2.0 * EDGE;
        // The least of straight lines is nowhere below the line between the least at either end.
        for c in 0..2 {
            let ([lo0, hi0], [lo1, hi1]) = (ends(from, c), ends(to, c));
            (quad.low[c], quad.high[c]) = (line(lo0, lo1).into(), line(hi0, hi1).into());
            size = size.max(hi0 - lo0).max(hi1 - lo1);
        }
        quad.slack = -EDGE * size;
        quad
    }

    /// Its least and greatest x and y over a stratum.
    #[inline]
    pub fn bound(&self, [times, lens @ ..]: [[f32; 2]; 3]) -> [[f32; 2]; 2] {
        let mut bound = [[0.0; 2]; 2];
        for c in 0..2 {
            let at = |line: [f32; 2], t: f32| line[0] + line[1] * t;
            let (low, high) = (self.low[c], self.high[c]);
            let [a, b, d, e] = [(0, 0), (0, 1), (1, 0), (1, 1)].map(|(i, j)| lens[c][i] * self.spreads[j]);
            bound[c] = [
                at(low, times[0]).min(at(low, times[1])) + a.min(b).min(d.min(e)),
                at(high, times[0]).max(at(high, times[1])) + a.max(b).max(d.max(e)),
            ];
        }
        bound
    }

    /// Where corner `i` is at some moments, from samples on.
    #[inline(always)]
    fn corner<L: Lanes, const LENS: bool>(&self, i: usize, at: &At<L>) -> [L; 2] {
        let (dx, dy) = (on_line(&self.x, i, at.t) - at.x, on_line(&self.y, i, at.t) - at.y);
        if !LENS {
            return [dx, dy];
        }
        let spread = on_line(&self.spread, i, at.t);
        [dx + at.lens[0] * spread, dy + at.lens[1] * spread]
    }

    /// Which triangle has a sample of layers, if one has it: the first of two. The parts of that triangle's area over against its corners,
    /// and where the sample is.
    #[inline(never)]
    pub fn at_edges(
        &self,
        [x, y]: [f32; 2],
        [t, lens @ ..]: [f32; 3],
        point: usize,
        grid: &SampledGrid<'_>,
    ) -> Option<(bool, [f32; 3], AtEdge)> {
        let on_line = |v: &[[f32; 4]; 2], i: usize| v[0][i] + v[1][i] * t;
        let corners = [0, 1, 2, 3].map(|i| {
            let at = [on_line(&self.x, i) - x, on_line(&self.y, i) - y];
            let spread = on_line(&self.spread, i);
            [at[0] + lens[0] * spread, at[1] + lens[1] * spread]
        });
        let around = grid.around(point, corners);
        let second = match around.inside() {
            [false, false] => return None,
            [first, _] => !first,
        };
        let [p, q, r] = if second { [0, 2, 3] } else { [0, 1, 2] }.map(|i| corners[i]);
        let depths = [0, 1, 2, 3].map(|i| on_line(&self.z, i));
        Some((second, [area_of(q, r), area_of(r, p), area_of(p, q)], around.at_edge(second, depths)))
    }

    /// Whether the parts of a triangle's area are those of a place at none of its edges.
    #[inline(always)]
    pub fn is_clear(&self, parts: [f32; 3]) -> bool {
        let sign = if parts[0] + parts[1] + parts[2] < 0.0 { -1.0 } else { 1.0 };
        parts.iter().all(|part| sign * part > -CLEAR * self.slack)
    }

    /// Which of some samples meet it, and where.
    #[inline(always)]
    pub fn meet<L: Lanes, const LENS: bool>(&self, at: &At<L>) -> Met<L> {
        let (a, b) = (self.corner::<L, LENS>(0, at), self.corner::<L, LENS>(1, at));
        let (c, d) = (self.corner::<L, LENS>(2, at), self.corner::<L, LENS>(3, at));
        let diagonal = cross(a, c);
        let first = [cross(b, c), diagonal.negated(), cross(a, b)];
        let second = [cross(c, d), cross(d, a), diagonal];
        let slack = L::splat(self.slack);
        let (mut in_first, mut in_second) = (inside(first, slack), inside(second, slack));
        if self.side != 0.0 {
            (in_first, in_second) = (in_first.and(faces(first, self.side)), in_second.and(faces(second, self.side)));
        }
        Met { in_first, in_second, first, second }
    }

    /// Weights and depth at one of them.
    #[inline(always)]
    pub fn at(&self, second: bool, parts: [f32; 3], t: f32) -> ([f32; 3], f32) {
        let area = parts[0] + parts[1] + parts[2];
        self.at_weights(second, within([parts[0] / area, parts[1] / area, parts[2] / area]), t)
    }

    /// The same without a lens.
    pub fn at_pinhole(&self, second: bool, parts: [f32; 3], t: f32) -> ([f32; 3], f32) {
        let area = parts[0] + parts[1] + parts[2];
        let w = parts.map(|part| (part / area).max(0.0));
        let sum = w[0] + w[1] + w[2];
        self.at_weights(second, w.map(|w| w / sum), t)
    }

    #[inline(always)]
    fn at_weights(&self, second: bool, w: [f32; 3], t: f32) -> ([f32; 3], f32) {
        let corners = if second { [0, 2, 3] } else { [0, 1, 2] };
        let z = |i: usize| self.z[0][i] + self.z[1][i] * t;
        (w, z(corners[0]) * w[0] + z(corners[1]) * w[1] + z(corners[2]) * w[2])
    }
}

/// Samples that are tested together: their places, times, and places on the lens.
pub struct At<L> {
    pub x: L,
    pub y: L,
    pub t: L,
    pub lens: [L; 2],
}

/// Samples of which some are in a micropolygon.
pub struct Met<L> {
    pub in_first: L,
    pub in_second: L,
    /// Twice the areas that lie over against the corners of its first triangle, and of its second.
    pub first: [L; 3],
    pub second: [L; 3],
}

impl<L: Lanes> Met<L> {
    /// Those that are in it, in its bound of a stratum, and in the time of its key.
    #[inline(always)]
    pub fn within(&self, at: &At<L>, [xs, ys]: [[f32; 2]; 2], [from, until]: [f32; 2]) -> L {
        let in_box = at.x.between(xs[0], xs[1]).and(at.y.between(ys[0], ys[1]));
        let in_time = at.t.ge(L::splat(from)).and(at.t.lt(L::splat(until)));
        self.in_first.or(self.in_second).and(in_box).and(in_time)
    }
}

/// What goes straight, at some times.
#[inline(always)]
pub fn on_line<L: Lanes>(v: &[[f32; 4]; 2], i: usize, t: L) -> L {
    L::splat(v[0][i]) + L::splat(v[1][i]) * t
}

#[inline(always)]
fn cross<L: Lanes>(p: [L; 2], q: [L; 2]) -> L {
    p[0] * q[1] - p[1] * q[0]
}

/// Where the parts of a triangle's area are of its sign, or but little of the other.
#[inline(always)]
fn inside<L: Lanes>(parts: [L; 3], slack: L) -> L {
    let area = parts[0] + parts[1] + parts[2];
    let (p, q, r) = (parts[0].xor_sign(area), parts[1].xor_sign(area), parts[2].xor_sign(area));
    p.ge(slack).and(q.ge(slack)).and(r.ge(slack)).and(area.ne(L::splat(0.0)))
}

/// Where the area of a triangle has a sign.
#[inline(always)]
fn faces<L: Lanes>(parts: [L; 3], side: f32) -> L {
    ((parts[0] + parts[1] + parts[2]) * L::splat(side)).ge(L::splat(0.0))
}

impl Samples {
    /// The first and last pixel of the bucket, along x and y, that a rectangle of the raster touches, with some room for rounding.
    #[inline(always)]
    pub(super) fn pixels_within(&self, xs: [f32; 2], ys: [f32; 2]) -> Option<([usize; 2], [usize; 2])> {
        let (ox, oy) = (self.x0 as f32, self.y0 as f32);
        let (x0, x1) = (xs[0] - ox - EDGE, xs[1] - ox + EDGE);
        let (y0, y1) = (ys[0] - oy - EDGE, ys[1] - oy + EDGE);
        let touches = x1 >= 0.0 && y1 >= 0.0 && x0 < self.width as f32 && y0 < self.height as f32;
        touches.then(|| {
            (
                [x0.max(0.0) as usize, (x1 as usize).min(self.width - 1)],
                [y0.max(0.0) as usize, (y1 as usize).min(self.height - 1)],
            )
        })
    }
}
