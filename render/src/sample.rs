//! Samples of a bucket: jittered places, the nearest opaque surface at each, and lists of what is half transparent.
//!
//! A pixel is cut into strata, one sample in each, so that the samples of a bucket are a grid of strata and a micropolygon looks
//! only at the strata that its bound touches.

use crate::blur::Moment;
use crate::filter::Filter;
use crate::jitter::Jitter;

/// A micropolygon's edge is taken this much wider, pixels, so that rounding opens no crack between neighbours.
pub(crate) const EDGE: f32 = 1.5e-3;

/// Samples that are tested together.
const LANES: usize = 8;

/// `LANES` values from `k` on.
#[inline]
fn lanes(v: &[f32], k: usize) -> &[f32; LANES] {
    v[k..k + LANES].try_into().expect("the columns are padded")
}

/// Something half transparent at a sample.
#[derive(Clone, Copy)]
struct Visible {
    z: f32,
    color: [f32; 3],
    opacity: [f32; 3],
    id: u64,
    next: u32,
}

const NONE: u32 = u32::MAX;

/// Weights of a point in a triangle; of one on the widened edge, those of a point inside nearby, since a sliver's own weights
/// run wild there.
#[inline]
pub(crate) fn within(w: [f32; 3]) -> [f32; 3] {
    if w[0] >= 0.0 && w[1] >= 0.0 && w[2] >= 0.0 {
        return w;
    }
    let w = w.map(|x| x.max(0.0));
    let sum = w[0] + w[1] + w[2];
    w.map(|x| x / sum)
}

/// Pixels along the edge of a block whose greatest depth is kept for culling.
const BLOCK: usize = 8;

/// The samples of a bucket and of the margin that its filter reaches into.
#[derive(Default)]
pub struct Samples {
    /// First pixel.
    pub(crate) x0: i64,
    pub(crate) y0: i64,
    /// Pixels.
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) strata: [usize; 2],
    pub(crate) columns: usize,
    rows: usize,
    /// Places, pixels from the bucket's first one.
    pub(crate) x: Vec<f32>,
    pub(crate) y: Vec<f32>,
    pub(crate) z: Vec<f32>,
    color: Vec<[f32; 3]>,
    /// Nothing but a hole for `Matte`.
    alpha: Vec<f32>,
    list: Vec<u32>,
    pool: Vec<Visible>,
    /// Where the picture is blurred.
    pub(crate) moments: Vec<Moment>,
    block_z: Vec<f32>,
    block_dirty: Vec<bool>,
    blocks: usize,
}

/// A corner of a micropolygon: raster x, y (pixels), depth, and its index in the grid.
pub type Corner = ([f32; 3], u32);

/// What a grid looks like: colour and opacity, one or one a corner.
pub struct Look<'a> {
    /// Ci: one colour, or all reds, all greens, all blues.
    pub color: &'a [f32],
    /// Oi likewise.
    pub opacity: &'a [f32],
    /// Corners in the grid.
    pub n: usize,
    /// Interpolate over the micropolygon.
    pub smooth: bool,
    /// All opaque.
    pub opaque: bool,
    /// It leaves a hole.
    pub matte: bool,
    /// Names the primitive, so that a sample on an edge that two of its micropolygons share counts once.
    pub id: u64,
}

impl Look<'_> {
    #[inline]
    fn of(v: &[f32], n: usize, i: u32) -> [f32; 3] {
        if v.len() == 3 { [v[0], v[1], v[2]] } else { [v[i as usize], v[n + i as usize], v[2 * n + i as usize]] }
    }

    #[inline]
    fn mix(v: &[f32], n: usize, i: [u32; 3], w: [f32; 3]) -> [f32; 3] {
        let [a, b, c] = i.map(|i| Self::of(v, n, i));
        [0, 1, 2].map(|k| a[k] * w[0] + b[k] * w[1] + c[k] * w[2])
    }
}

impl Samples {
    /// Start a bucket whose pixels, margin included, begin at (`x0`, `y0`).
    pub fn start(&mut self, jitter: &Jitter, x0: i64, y0: i64, width: usize, height: usize) {
        (self.x0, self.y0, self.width, self.height, self.strata) = (x0, y0, width, height, jitter.strata);
        let [sx, sy] = self.strata;
        (self.columns, self.rows) = (width * sx, height * sy);
        let n = self.columns * self.rows;
        self.x.clear();
        self.y.clear();
        for row in 0..self.rows {
            for column in 0..self.columns {
                let (px, py) = (column / sx, row / sy);
                let [x, y] = jitter.in_pixel(column as i64 + x0 * sx as i64, row as i64 + y0 * sy as i64);
                self.x.push(px as f32 + x);
                self.y.push(py as f32 + y);
            }
        }
        // The last samples are tested with lanes beyond them.
        self.x.resize(n + LANES, f32::INFINITY);
        self.y.resize(n + LANES, f32::INFINITY);
        self.set_moments(jitter);
        self.z.clear();
        self.z.resize(n, f32::INFINITY);
        self.color.clear();
        self.color.resize(n, [0.0; 3]);
        self.alpha.clear();
        self.alpha.resize(n, 0.0);
        self.list.clear();
        self.list.resize(n, NONE);
        self.pool.clear();
        self.blocks = width.div_ceil(BLOCK);
        self.block_z.clear();
        self.block_z.resize(self.blocks * height.div_ceil(BLOCK), f32::INFINITY);
        self.block_dirty.clear();
        self.block_dirty.resize(self.block_z.len(), false);
    }

    /// Whether everything in a raster rectangle (absolute pixels) at or behind depth `z` is hidden already.
    pub fn hides(&mut self, min: [f32; 2], max: [f32; 2], z: f32) -> bool {
        let Some(([bx0, bx1], [by0, by1])) = self.blocks_of(min, max) else { return true };
        for by in by0..=by1 {
            for bx in bx0..=bx1 {
                let block = by * self.blocks + bx;
                if self.block_dirty[block] {
                    self.block_dirty[block] = false;
                    self.block_z[block] = self.greatest_depth(bx, by);
                }
                if self.block_z[block] >= z {
                    return false;
                }
            }
        }
        true
    }

    fn blocks_of(&self, min: [f32; 2], max: [f32; 2]) -> Option<([usize; 2], [usize; 2])> {
        let (w, h) = (self.width as f32, self.height as f32);
        let (x0, y0) = (min[0] - self.x0 as f32, min[1] - self.y0 as f32);
        let (x1, y1) = (max[0] - self.x0 as f32, max[1] - self.y0 as f32);
        if !(x1 >= -1.0 && y1 >= -1.0 && x0 <= w + 1.0 && y0 <= h + 1.0) {
            return None;
        }
        let block = |x: f32, n: usize| (x.clamp(0.0, n as f32 - 1.0) as usize) / BLOCK;
        Some((
            [block(x0 - EDGE, self.width), block(x1 + EDGE, self.width)],
            [block(y0 - EDGE, self.height), block(y1 + EDGE, self.height)],
        ))
    }

    fn greatest_depth(&self, bx: usize, by: usize) -> f32 {
        let [sx, sy] = self.strata;
        let columns = bx * BLOCK * sx..((bx + 1) * BLOCK).min(self.width) * sx;
        let rows = by * BLOCK * sy..((by + 1) * BLOCK).min(self.height) * sy;
        let row_max = |row: usize| {
            self.z[row * self.columns + columns.start..row * self.columns + columns.end]
                .iter()
                .fold(0.0f32, |a, z| a.max(*z))
        };
        rows.map(row_max).fold(0.0, f32::max)
    }

    /// Sample a micropolygon: corners in the order around it. Returns the samples tried.
    #[inline]
    pub fn quad(&mut self, corners: [Corner; 4], look: &Look<'_>) -> usize {
        let [a, b, c, d] = corners;
        self.triangle([a, b, c], a.1, look) + self.triangle([a, c, d], a.1, look)
    }

    #[inline]
    fn triangle(&mut self, corners: [Corner; 3], flat: u32, look: &Look<'_>) -> usize {
        let (ox, oy) = (self.x0 as f32, self.y0 as f32);
        let [[x0, y0, z0], [x1, y1, z1], [x2, y2, z2]] = corners.map(|(p, _)| [p[0] - ox, p[1] - oy, p[2]]);
        let (ux, uy, vx, vy) = (x1 - x0, y1 - y0, x2 - x0, y2 - y0);
        let area = ux * vy - vx * uy;
        if area == 0.0 || !area.is_finite() {
            return 0;
        }
        let inv = 1.0 / area;
        let (min_x, max_x) = (x0.min(x1).min(x2) - EDGE, x0.max(x1).max(x2) + EDGE);
        let (min_y, max_y) = (y0.min(y1).min(y2) - EDGE, y0.max(y1).max(y2) + EDGE);
        if max_x < 0.0 || max_y < 0.0 || min_x >= self.width as f32 || min_y >= self.height as f32 {
            return 0;
        }
        // The edge's width in barycentric terms.
        let slack = -EDGE * (max_x - min_x).max(max_y - min_y) * inv.abs();
        let [sx, sy] = self.strata;
        let column = |x: f32| (x * sx as f32).max(0.0) as usize;
        let row = |y: f32| (y * sy as f32).max(0.0) as usize;
        let (c0, c1) = (column(min_x), column(max_x).min(self.columns - 1));
        let (r0, r1) = (row(min_y), row(max_y).min(self.rows - 1));
        // Weights of the second and third corner, as planes over the raster from the first corner: the same bits in every bucket.
        let (ax, ay, bx, by) = (vy * inv, -vx * inv, -uy * inv, ux * inv);
        let mut hit = false;
        for r in r0..=r1 {
            for first in (c0..=c1).step_by(LANES) {
                let k = r * self.columns + first;
                let (xs, ys) = (lanes(&self.x, k), lanes(&self.y, k));
                let (mut w1, mut w2, mut least) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
                for i in 0..LANES {
                    let (dx, dy) = (xs[i] - x0, ys[i] - y0);
                    w1[i] = ax * dx + ay * dy;
                    w2[i] = bx * dx + by * dy;
                    let w0 = 1.0 - w1[i] - w2[i];
                    let w = if w1[i] < w2[i] { w1[i] } else { w2[i] };
                    least[i] = if w0 < w { w0 } else { w };
                }
                let inside = (0..LANES).fold(0u32, |m, i| m | ((least[i] >= slack) as u32) << i);
                let mut inside = inside & (u32::MAX >> (31 - (c1 - first).min(31)));
                while inside != 0 {
                    let i = inside.trailing_zeros() as usize;
                    inside &= inside - 1;
                    let w = within([1.0 - w1[i] - w2[i], w1[i], w2[i]]);
                    let z = z0 * w[0] + z1 * w[1] + z2 * w[2];
                    if z < self.z[k + i] {
                        hit = true;
                        self.keep(k + i, z, corners.map(|c| c.1), w, flat, look);
                    }
                }
            }
        }
        if hit {
            self.mark(c0 / sx, c1 / sx, r0 / sy, r1 / sy);
        }
        (r1 + 1 - r0) * (c1 + 1 - c0)
    }

    /// Something is met at a sample, nearer than what is opaque there.
    #[inline]
    pub(crate) fn keep(&mut self, k: usize, z: f32, i: [u32; 3], w: [f32; 3], flat: u32, look: &Look<'_>) {
        let value = |v: &[f32]| if look.smooth { Look::mix(v, look.n, i, w) } else { Look::of(v, look.n, flat) };
        let color = value(look.color);
        if look.opaque {
            self.z[k] = z;
            self.color[k] = if look.matte { [0.0; 3] } else { color };
            self.alpha[k] = if look.matte { 0.0 } else { 1.0 };
            return;
        }
        let mut at = self.list[k];
        while at != NONE {
            let other = &self.pool[at as usize];
            if other.id == look.id && (other.z - z).abs() <= 1e-4 * z {
                return;
            }
            at = other.next;
        }
        let opacity = value(look.opacity);
        self.pool.push(Visible { z, color, opacity, id: look.id, next: self.list[k] });
        self.list[k] = self.pool.len() as u32 - 1;
    }

    /// The depths of these pixels have changed.
    pub(crate) fn mark(&mut self, x0: usize, x1: usize, y0: usize, y1: usize) {
        for by in y0 / BLOCK..=y1 / BLOCK {
            for bx in x0 / BLOCK..=x1 / BLOCK {
                self.block_dirty[by * self.blocks + bx] = true;
            }
        }
    }

    /// Composite the lists: each sample's colour, premultiplied, and its coverage.
    pub fn resolve(&mut self) {
        let mut stack: Vec<Visible> = Vec::new();
        for k in 0..self.list.len() {
            if self.list[k] == NONE {
                continue;
            }
            stack.clear();
            let mut at = self.list[k];
            while at != NONE {
                let v = self.pool[at as usize];
                if v.z < self.z[k] {
                    stack.push(v);
                }
                at = v.next;
            }
            // Farthest first; what is equally far keeps the order in which it came.
            stack.sort_by(|a, b| b.z.total_cmp(&a.z));
            for v in &stack {
                for c in 0..3 {
                    self.color[k][c] = v.color[c] + self.color[k][c] * (1.0 - v.opacity[c]);
                }
                let mean = (v.opacity[0] + v.opacity[1] + v.opacity[2]) / 3.0;
                self.alpha[k] = mean + self.alpha[k] * (1.0 - mean);
            }
        }
    }

    /// Filter the pixels of the bucket proper, `margin` pixels in from each side: red, green, blue, coverage each.
    pub fn filter(&self, fx: &Filter, fy: &Filter, margin: [usize; 2], out: &mut Vec<[f32; 4]>) {
        let [sx, sy] = self.strata;
        out.clear();
        for py in margin[1]..self.height - margin[1] {
            for px in margin[0]..self.width - margin[0] {
                let (cx, cy) = (px as f32 + 0.5, py as f32 + 0.5);
                let (mut sum, mut weight) = ([0.0f32; 4], 0.0f32);
                for row in (py - margin[1]) * sy..(py + margin[1] + 1) * sy {
                    let first = row * self.columns + (px - margin[0]) * sx;
                    for k in first..first + (2 * margin[0] + 1) * sx {
                        let w = fx.at(self.x[k] - cx) * fy.at(self.y[k] - cy);
                        if w != 0.0 {
                            for c in 0..3 {
                                sum[c] += w * self.color[k][c];
                            }
                            sum[3] += w * self.alpha[k];
                            weight += w;
                        }
                    }
                }
                out.push(if weight != 0.0 { sum.map(|x| x / weight) } else { [0.0; 4] });
            }
        }
    }
}
