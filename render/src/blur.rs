//! Sampling what moves or is out of focus: every sample has a moment and a place on the lens, and is tried against the
//! micropolygon as it is seen at that moment from there.
//!
//! The strata of time are taken one by one: in each, and from its cell of the lens, a micropolygon covers little, and only the one
//! sample of each pixel that belongs to the stratum is tried.

use crate::camera::Camera;
use crate::jitter::{Jitter, Moments};
use crate::motion::Instant;
use crate::sample::{EDGE, Kind, Samples, Tally, within};
use crate::seen::Micropolygon;

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

/// A sample that has a moment.
#[derive(Clone, Copy)]
pub struct Moment {
    /// Place, pixels of the whole picture: what is decided by it is decided alike in every bucket.
    x: f32,
    y: f32,
    /// Part of the time that the shutter is open.
    time: f32,
    /// Place on the lens.
    lens: [f32; 2],
    /// The sample among all of the bucket.
    sample: u32,
}

/// A micropolygon that moves straight between two times: each number of its corners is one at time 0 plus one a unit of time.
struct Quad {
    x: [[f32; 4]; 2],
    y: [[f32; 4]; 2],
    z: [[f32; 4]; 2],
    /// How far the lens spreads each.
    spread: [[f32; 4]; 2],
    /// Least and greatest x and y of all corners without the lens, at time 0 and a unit of time; and of the spread at all times.
    low: [[f32; 2]; 2],
    high: [[f32; 2]; 2],
    spreads: [f32; 2],
    /// The least depth.
    near: f32,
}

impl Quad {
    fn new(points: [usize; 4], track: &Track<'_>, key: usize) -> Quad {
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
        let mut quad =
            Quad { x, y, z, spread: [[0.0; 4]; 2], low: [[0.0; 2]; 2], high: [[0.0; 2]; 2], spreads: [0.0; 2], near };
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
        // The least of straight lines is nowhere below the line between the least at either end.
        for c in 0..2 {
            let ([lo0, hi0], [lo1, hi1]) = (ends(from, c), ends(to, c));
            (quad.low[c], quad.high[c]) = (line(lo0, lo1).into(), line(hi0, hi1).into());
        }
        quad
    }

    /// Its least and greatest x and y over a stratum.
    #[inline]
    fn bound(&self, [times, lens @ ..]: [[f32; 2]; 3]) -> [[f32; 2]; 2] {
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

    /// Where it is met by a sample at (x, y) of a moment: whether in the second of its triangles, the weights of the place, its
    /// depth.
    #[inline]
    fn meet(&self, x: f32, y: f32, t: f32, [lens_x, lens_y]: [f32; 2]) -> Option<(bool, [f32; 3], f32)> {
        let (mut dx, mut dy) = ([0.0; 4], [0.0; 4]);
        for i in 0..4 {
            let spread = self.spread[0][i] + self.spread[1][i] * t;
            dx[i] = self.x[0][i] + self.x[1][i] * t + lens_x * spread - x;
            dy[i] = self.y[0][i] + self.y[1][i] * t + lens_y * spread - y;
        }
        let cross = |i: usize, j: usize| dx[i] * dy[j] - dx[j] * dy[i];
        let size = |v: &[f32; 4]| {
            let (a, b) = (v[0].min(v[1]).min(v[2].min(v[3])), v[0].max(v[1]).max(v[2].max(v[3])));
            b - a
        };
        let slack = -EDGE * (size(&dx).max(size(&dy)) + 2.0 * EDGE);
        let diagonal = cross(0, 2);
        for (corners, parts) in
            [([0, 1, 2], [cross(1, 2), -diagonal, cross(0, 1)]), ([0, 2, 3], [cross(2, 3), cross(3, 0), diagonal])]
        {
            let area = parts[0] + parts[1] + parts[2];
            let side = area.signum();
            if (parts[0] * side).min(parts[1] * side).min(parts[2] * side) >= slack && area != 0.0 {
                let w = within(parts.map(|p| p / area));
                let z = corners.iter().zip(w).map(|(i, w)| (self.z[0][*i] + self.z[1][*i] * t) * w).sum();
                return Some((corners[1] == 2, w, z));
            }
        }
        None
    }
}

impl Samples {
    /// Give the samples of a bucket their moments: pixel after pixel, in each by strata of time.
    pub fn set_moments(&mut self, jitter: &Jitter) {
        let Some(moments) = &jitter.moments else { return };
        let [sx, sy] = self.strata;
        self.moments.clear();
        for py in 0..self.height {
            for px in 0..self.width {
                for stratum in 0..sx * sy {
                    let ([column, row], [time, lens @ ..]) =
                        moments.of(px as i64 + self.x0, py as i64 + self.y0, stratum);
                    let k = (py * sy + row as usize) * self.columns + px * sx + column as usize;
                    let (x, y) = (self.x[k] + self.x0 as f32, self.y[k] + self.y0 as f32);
                    self.moments.push(Moment { x, y, time, lens, sample: k as u32 });
                }
            }
        }
    }

    /// Sample micropolygons of a grid in rows of `nu` points, each named by its first point.
    pub fn blurred(&mut self, nu: usize, micropolygons: &[u32], track: &Track<'_>, kind: &Kind) -> Tally {
        let mut tally = Tally::default();
        let Some(moments) = &track.jitter.moments else { return tally };
        let last = track.instants.len() - 1;
        for point in micropolygons {
            let k = *point as usize;
            for key in 0..last.max(1) {
                let quad = Quad::new([k, k + 1, k + nu + 1, k + nu], track, key);
                // The last key lasts to the end.
                let until = if key + 1 < last { track.instants[key + 1].time } else { f32::INFINITY };
                self.straight(&quad, [track.instants[key].time, until], moments, k, kind, &mut tally);
            }
        }
        tally
    }

    /// Sample a micropolygon between two times.
    fn straight(
        &mut self,
        quad: &Quad,
        [from, until]: [f32; 2],
        moments: &Moments,
        point: usize,
        kind: &Kind,
        tally: &mut Tally,
    ) {
        let n = self.strata[0] * self.strata[1];
        let (ox, oy) = (self.x0 as f32, self.y0 as f32);
        for (stratum, bounds) in moments.bounds.iter().enumerate() {
            if bounds[0][1] < from || bounds[0][0] >= until {
                continue;
            }
            let [xs, ys] = quad.bound(*bounds).map(|[lo, hi]| [lo - EDGE, hi + EDGE]);
            // Pixels of the bucket, with some room for rounding.
            let (x0, x1) = (xs[0] - ox - EDGE, xs[1] - ox + EDGE);
            let (y0, y1) = (ys[0] - oy - EDGE, ys[1] - oy + EDGE);
            if !(x1 >= 0.0 && y1 >= 0.0 && x0 < self.width as f32 && y0 < self.height as f32) {
                continue;
            }
            let (px0, px1) = (x0.max(0.0) as usize, (x1 as usize).min(self.width - 1));
            let (py0, py1) = (y0.max(0.0) as usize, (y1 as usize).min(self.height - 1));
            for py in py0..=py1 {
                let first = (py * self.width + px0) * n + stratum;
                for px in 0..=px1 - px0 {
                    let Moment { x, y, time, lens, sample } = self.moments[first + px * n];
                    let k = sample as usize;
                    let outside =
                        (x < xs[0]) | (x > xs[1]) | (y < ys[0]) | (y > ys[1]) | (time < from) | (time >= until);
                    if outside || self.z[k] <= quad.near {
                        continue;
                    }
                    tally.tried += 1;
                    let Some((second, w, z)) = quad.meet(x, y, time, lens) else { continue };
                    if z < self.z[k] {
                        tally.hit = true;
                        self.keep(k, z, Micropolygon::new(kind.grid, point, second), [w[1], w[2]], kind);
                        self.mark(px0 + px, px0 + px, py, py);
                    }
                }
            }
        }
    }
}
