//! Sampling what moves or is out of focus: every sample has a moment and a place on the lens, and is tried against the
//! micropolygon as it is seen at that moment from there.
//!
//! The strata of time are taken one by one: in each, and from its cell of the lens, a micropolygon covers little, and only the one
//! sample of each pixel that belongs to the stratum is tried.

use crate::camera::Camera;
use crate::jitter::Jitter;
use crate::sample::{EDGE, Look, Samples, within};

/// The points of a grid over time.
pub struct Track<'a> {
    /// Rising, from 0 on.
    pub times: &'a [f32],
    /// Raster x, y and depth of every point at each of these times.
    pub raster: &'a [Vec<[f32; 3]>],
    /// The camera, for its lens.
    pub camera: &'a Camera,
    /// Where the samples are.
    pub jitter: &'a Jitter,
}

impl Track<'_> {
    /// A point at a time; straight between the keys.
    #[inline]
    fn at(&self, point: usize, time: f32) -> [f32; 3] {
        let last = self.times.len() - 1;
        let mut i = 1;
        while i < last && self.times[i] <= time {
            i += 1;
        }
        if i > last {
            return self.raster[last][point];
        }
        let (a, b) = (self.raster[i - 1][point], self.raster[i][point]);
        let t = ((time - self.times[i - 1]) / (self.times[i] - self.times[i - 1])).min(1.0);
        [0, 1, 2].map(|c| a[c] + (b[c] - a[c]) * t)
    }

    /// A point at a moment as it is seen from a place on the lens.
    #[inline]
    fn seen(&self, point: usize, [time, x, y]: [f32; 3]) -> [f32; 3] {
        let p = self.at(point, time);
        let spread = self.camera.confusion(p[2]);
        [p[0] + x * spread, p[1] + y * spread, p[2]]
    }

    /// The raster rectangle of some points over a stratum.
    fn bound(&self, points: [usize; 4], [times, xs, ys]: [[f32; 2]; 3]) -> [[f32; 2]; 2] {
        let mut bound = [[f32::INFINITY, f32::NEG_INFINITY]; 2];
        let inner = self.times.iter().copied().filter(|t| *t > times[0] && *t < times[1]);
        for time in times.into_iter().chain(inner) {
            for point in points {
                let p = self.at(point, time);
                let spread = self.camera.confusion(p[2]);
                for (axis, lens) in [xs, ys].into_iter().enumerate() {
                    let (a, b) = (lens[0] * spread, lens[1] * spread);
                    bound[axis] = [bound[axis][0].min(p[axis] + a.min(b)), bound[axis][1].max(p[axis] + a.max(b))];
                }
            }
        }
        bound
    }
}

/// Weights of a raster point in a triangle, its edges a little widened.
#[inline]
fn weights([a, b, c]: [[f32; 3]; 3], x: f32, y: f32) -> Option<[f32; 3]> {
    let (ux, uy, vx, vy) = (b[0] - a[0], b[1] - a[1], c[0] - a[0], c[1] - a[1]);
    let area = ux * vy - vx * uy;
    if area == 0.0 || !area.is_finite() {
        return None;
    }
    let inv = 1.0 / area;
    let (px, py) = (x - a[0], y - a[1]);
    let (w1, w2) = ((px * vy - vx * py) * inv, (ux * py - px * uy) * inv);
    let w = [1.0 - w1 - w2, w1, w2];
    let size = ux.abs().max(uy.abs()).max(vx.abs()).max(vy.abs()) + 2.0 * EDGE;
    let slack = -EDGE * size * inv.abs();
    (w[0].min(w1).min(w2) >= slack).then(|| within(w))
}

impl Samples {
    /// Sample a micropolygon given by points of a grid in the order around it. Returns the samples tried.
    pub fn blurred_quad(&mut self, points: [usize; 4], track: &Track<'_>, look: &Look<'_>) -> usize {
        let Some(moments) = &track.jitter.moments else { return 0 };
        let [sx, sy] = self.strata;
        let (ox, oy) = (self.x0 as f32, self.y0 as f32);
        let mut tried = 0;
        for stratum in 0..sx * sy {
            let [xs, ys] = track.bound(points, moments.bounds[stratum]);
            let (x0, x1) = (xs[0] - ox - EDGE, xs[1] - ox + EDGE);
            let (y0, y1) = (ys[0] - oy - EDGE, ys[1] - oy + EDGE);
            if !(x1 >= 0.0 && y1 >= 0.0 && x0 < self.width as f32 && y0 < self.height as f32) {
                continue;
            }
            let (px0, px1) = (x0.max(0.0) as usize, (x1 as usize).min(self.width - 1));
            let (py0, py1) = (y0.max(0.0) as usize, (y1 as usize).min(self.height - 1));
            for py in py0..=py1 {
                for px in px0..=px1 {
                    let (place, moment) = moments.of(px as i64 + self.x0, py as i64 + self.y0, stratum);
                    let k = (py * sy + place / sx) * self.columns + px * sx + place % sx;
                    let (x, y) = (self.x[k], self.y[k]);
                    if x < x0 || x > x1 || y < y0 || y > y1 {
                        continue;
                    }
                    tried += 1;
                    let q = points.map(|p| track.seen(p, moment));
                    let (x, y) = (x + ox, y + oy);
                    let first = weights([q[0], q[1], q[2]], x, y).map(|w| ([0, 1, 2], w));
                    let Some((i, w)) = first.or_else(|| weights([q[0], q[2], q[3]], x, y).map(|w| ([0, 2, 3], w)))
                    else {
                        continue;
                    };
                    let z = i.iter().zip(w).map(|(i, w)| q[*i][2] * w).sum::<f32>();
                    if z < self.z[k] {
                        self.keep(k, z, i.map(|i| points[i] as u32), w, points[0] as u32, look);
                        self.mark(px, px, py, py);
                    }
                }
            }
        }
        tried
    }
}
