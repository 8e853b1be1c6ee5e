//! Samples of a bucket: jittered places, the nearest opaque surface at each, and lists of what is half transparent.
//!
//! A pixel is cut into strata, one sample in each, so that the samples of a bucket are a grid of strata, held in small cells,
//! and a micropolygon looks only at the cells that its bound touches. A sample holds which micropolygon it sees; what that looks
//! like is asked when nothing more will hide it ([`crate::cpu::visible`]).

use crate::cpu::blur::lens::Moments;
use crate::cpu::lanes::LANES;
use crate::cpu::visible::Micropolygon;
use crate::film::display::{self, Aov, placed};
use crate::film::filter::Filter;
use crate::film::jitter::{Jitter, PERIOD};
use glam::Vec3A;
use sl::ir::Kind;

/// A micropolygon's edge is taken this much wider, pixels, so that rounding opens no crack between neighbours.
pub(crate) const EDGE: f32 = 1.5e-3;

/// Strata along x and y of a cell, whose samples are tested together. Whole cells make up a block.
pub(crate) const CELL: [usize; 2] = [4, LANES / 4];

/// Something that may be half transparent at a sample.
#[derive(Clone, Copy)]
struct Layer {
    z: f32,
    micropolygon: Micropolygon,
    weights: [f32; 2],
    color: [f32; 3],
    opacity: [f32; 3],
    primitive: u64,
    next: u32,
}

const NONE: u32 = u32::MAX;

/// What is sampled, as far as samples care.
#[derive(Clone, Copy)]
pub struct Look {
    /// The grid's number in the bucket.
    pub grid: usize,
    /// All opaque.
    pub opaque: bool,
    /// Colour is interpolated over a micropolygon.
    pub smooth: bool,
    /// Names the primitive, so that a sample on an edge that two of its micropolygons share counts once.
    pub primitive: u64,
}

/// What sampling came to.
#[derive(Clone, Copy, Default)]
pub struct Tally {
    /// Samples tried.
    pub tried: u64,
    /// Whether any took something.
    pub hit: bool,
}

/// What a triangle of a micropolygon looks like.
#[derive(Clone, Copy, Default)]
pub struct Triangle {
    /// Colours of its corners, by their opacity already.
    pub color: [Vec3A; 3],
    /// Opacities.
    pub opacity: [Vec3A; 3],
    /// The corners among the points of all grids.
    pub corners: [usize; 3],
    /// What lies between the corners is between them; else it is as the first is.
    pub smooth: bool,
    /// It leaves a hole.
    pub matte: bool,
}

impl Triangle {
    /// What each corner counts at a place with these weights of the second and third.
    #[inline]
    fn weights(&self, [second, third]: [f32; 2]) -> [f32; 3] {
        if self.smooth { within([1.0 - second - third, second, third]) } else { [1.0, 0.0, 0.0] }
    }

    /// What displays take besides colour at such a place, of what they take at all points.
    fn outputs(&self, all: &[f32], w: [f32; 3], own: &mut [f32]) {
        let depth = own.len();
        for (i, own) in own.iter_mut().enumerate() {
            // What is the same at all corners stays that to the bit.
            let [a, b, c] = self.corners.map(|k| all[k * depth + i]);
            *own = a + (b - a) * w[1] + (c - a) * w[2];
        }
    }
}

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
const BLOCK: usize = 4;

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
    /// In pictures of motion without a lens, a pixel's samples are held together by their times: so many, with those that make
    /// the last cell whole. 0 elsewhere.
    pub(crate) padded: usize,
    /// Cells along x and y.
    pub(crate) columns: usize,
    pub(crate) rows: usize,
    /// Places, pixels from the bucket's first one.
    pub(crate) x: Vec<f32>,
    pub(crate) y: Vec<f32>,
    /// Part of the time that the shutter is open, in pictures of motion without a lens.
    pub(crate) time: Vec<f32>,
    /// Which part of the pattern the places are of, and how many pixels; what depths are where nothing is.
    pattern: Option<([i64; 2], [usize; 2])>,
    empty: Vec<f32>,
    /// Depth of the nearest thing that is opaque.
    pub(crate) z: Vec<f32>,
    /// The number of the micropolygon that it is; none, once its colour is known.
    pub(crate) seen: Vec<u32>,
    /// Where it is met: weights of its second and third corner, if it is smooth.
    pub(crate) weights: [Vec<f32>; 2],
    color: Vec<[f32; 3]>,
    /// Nothing but a hole for `Matte`.
    alpha: Vec<f32>,
    list: Vec<u32>,
    layers: Vec<Layer>,
    /// What displays take besides colour, `depth` numbers of each sample and of each layer.
    outputs: Vec<f32>,
    layer_outputs: Vec<f32>,
    depth: usize,
    /// Of what is seen through a lens.
    pub(crate) moments: Moments,
    block_z: Vec<f32>,
    block_dirty: Vec<bool>,
    blocks: usize,
}

impl Samples {
    /// Start a bucket whose pixels, margin included, begin at (`x0`, `y0`).
    pub fn start(&mut self, jitter: &Jitter, x0: i64, y0: i64, width: usize, height: usize, aovs: &[Aov]) {
        (self.x0, self.y0, self.width, self.height, self.strata) = (x0, y0, width, height, jitter.strata);
        self.depth = display::depth(aovs);
        self.set_places(jitter);
        let n = self.x.len();
        self.z.clear();
        self.z.extend_from_slice(&self.empty);
        self.set_moments(jitter);
        self.seen.clear();
        self.seen.resize(n, Micropolygon::NONE.number());
        self.weights.iter_mut().for_each(|w| w.resize(n, 0.0));
        self.color.clear();
        self.color.resize(n, [0.0; 3]);
        self.alpha.clear();
        self.alpha.resize(n, 0.0);
        self.list.clear();
        self.list.resize(n, NONE);
        self.layers.clear();
        self.outputs.clear();
        self.outputs.resize(n * self.depth, 0.0);
        self.blocks = width.div_ceil(BLOCK);
        self.block_z.clear();
        self.block_z.resize(self.blocks * height.div_ceil(BLOCK), f32::INFINITY);
        self.block_dirty.clear();
        self.block_dirty.resize(self.block_z.len(), false);
    }

    /// Put the samples in their places, which repeat from bucket to bucket.
    fn set_places(&mut self, jitter: &Jitter) {
        let (width, height, [sx, sy]) = (self.width, self.height, self.strata);
        let pattern = ([self.x0, self.y0].map(|x| x.rem_euclid(PERIOD as i64)), [width, height]);
        if self.pattern == Some(pattern) {
            return;
        }
        self.pattern = Some(pattern);
        self.padded = if jitter.moments.is_some() && !jitter.lens { (sx * sy).next_multiple_of(LANES) } else { 0 };
        (self.columns, self.rows) = match self.padded {
            0 => ((width * sx).div_ceil(CELL[0]), (height * sy).div_ceil(CELL[1])),
            padded => (width * padded / LANES, height),
        };
        let n = self.columns * self.rows * LANES;
        for places in [&mut self.x, &mut self.y] {
            places.clear();
            places.resize(n, f32::INFINITY);
        }
        // Lanes of a cell that lie beyond the last stratum are nowhere, and take nothing.
        self.empty.clear();
        self.empty.resize(n, 0.0);
        let moments = jitter.moments.as_ref().filter(|_| self.padded > 0);
        self.time.resize(if moments.is_some() { n } else { 0 }, 0.0);
        for (px, py) in (0..height).flat_map(|py| (0..width).map(move |px| (px, py))) {
            let pixel = [px as i64 + self.x0, py as i64 + self.y0];
            for (row, column) in (0..sy).flat_map(|row| (0..sx).map(move |column| (row, column))) {
                let k = self.index([px, py], [column, row]);
                let mut place = [column, row];
                if let Some(moments) = moments {
                    // In the order of their times.
                    let (sample, [time, ..]) = moments.of(pixel[0], pixel[1], row * sx + column);
                    self.time[k] = time;
                    place = sample.map(usize::from);
                }
                let [x, y] = jitter.in_pixel(pixel, place);
                (self.x[k], self.y[k], self.empty[k]) = (px as f32 + x, py as f32 + y, f32::INFINITY);
            }
        }
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
        let cells = |block: usize, axis: usize, n: usize| {
            let per = match (self.padded, axis) {
                (0, _) => BLOCK * self.strata[axis] / CELL[axis],
                (padded, 0) => BLOCK * padded / LANES,
                _ => BLOCK,
            };
            block * per..((block + 1) * per).min(n)
        };
        let columns = cells(bx, 0, self.columns);
        let row_max = |row: usize| {
            let from = row * self.columns;
            let mut most = [0.0f32; LANES];
            for lanes in self.z[(from + columns.start) * LANES..(from + columns.end) * LANES].chunks_exact(LANES) {
                most.iter_mut().zip(lanes).for_each(|(m, z)| *m = if *z > *m { *z } else { *m });
            }
            most.into_iter().fold(0.0, f32::max)
        };
        cells(by, 1, self.rows).map(row_max).fold(0.0, f32::max)
    }

    /// Where a sample of a pixel is in the columns: that of a stratum, or in pictures of motion, of the time of that number.
    #[inline]
    pub(crate) fn index(&self, [px, py]: [usize; 2], [column, row]: [usize; 2]) -> usize {
        let [sx, sy] = self.strata;
        if self.padded > 0 {
            return (py * self.width + px) * self.padded + row * sx + column;
        }
        let (column, row) = (px * sx + column, py * sy + row);
        let cell = row / CELL[1] * self.columns + column / CELL[0];
        cell * LANES + row % CELL[1] * CELL[0] + column % CELL[0]
    }

    /// Something is met at a sample, nearer than what is opaque there.
    #[inline]
    pub(crate) fn keep(&mut self, k: usize, z: f32, micropolygon: Micropolygon, weights: [f32; 2], look: &Look) {
        if look.opaque {
            self.z[k] = z;
            self.seen[k] = micropolygon.number();
            (self.weights[0][k], self.weights[1][k]) = (weights[0], weights[1]);
            return;
        }
        let mut at = self.list[k];
        while at != NONE {
            let other = &self.layers[at as usize];
            if other.primitive == look.primitive && (other.z - z).abs() <= 1e-4 * z {
                return;
            }
            at = other.next;
        }
        let (primitive, next) = (look.primitive, self.list[k]);
        let (color, opacity) = ([0.0; 3], [0.0; 3]);
        self.layers.push(Layer { z, micropolygon, weights, color, opacity, primitive, next });
        self.list[k] = self.layers.len() as u32 - 1;
    }

    /// Visit what is seen and has no colour yet.
    pub fn for_each_seen(&self, mut visit: impl FnMut(Micropolygon)) {
        let n = self.list.len();
        let seen = self.seen.iter().map(|m| Micropolygon::of_number(*m));
        seen.filter(|m| *m != Micropolygon::NONE).for_each(&mut visit);
        if self.layers.is_empty() {
            return;
        }
        for k in 0..n {
            let mut at = self.list[k];
            while at != NONE {
                let layer = &self.layers[at as usize];
                if layer.micropolygon != Micropolygon::NONE && layer.z < self.z[k] {
                    visit(layer.micropolygon);
                }
                at = layer.next;
            }
        }
    }

    /// Give what is seen its colours; `look` says what a triangle looks like, `outputs` has what displays take besides of all
    /// points.
    pub fn paint(&mut self, look: impl Fn(Micropolygon) -> Triangle, outputs: &[f32]) {
        let mut last = Micropolygon::NONE;
        let mut triangle = Triangle::default();
        for k in 0..self.list.len() {
            let seen = Micropolygon::of_number(std::mem::replace(&mut self.seen[k], Micropolygon::NONE.number()));
            if seen == Micropolygon::NONE {
                continue;
            }
            // Neighbouring samples often see the same micropolygon.
            if seen != last {
                (last, triangle) = (seen, look(seen));
            }
            if triangle.matte {
                (self.color[k], self.alpha[k]) = ([0.0; 3], 0.0);
                continue;
            }
            let w = triangle.weights([self.weights[0][k], self.weights[1][k]]);
            let [a, b, c] = triangle.color;
            self.color[k] = (a * w[0] + b * w[1] + c * w[2]).to_array();
            self.alpha[k] = 1.0;
            if self.depth > 0 {
                triangle.outputs(outputs, w, &mut self.outputs[k * self.depth..][..self.depth]);
            }
        }
        if !self.layers.is_empty() {
            self.paint_layers(look, outputs);
        }
    }

    /// The same of layers that others may be seen through.
    fn paint_layers(&mut self, look: impl Fn(Micropolygon) -> Triangle, outputs: &[f32]) {
        self.layer_outputs.resize(self.layers.len() * self.depth, 0.0);
        for k in 0..self.list.len() {
            let mut at = self.list[k];
            while at != NONE {
                let own = &mut self.layer_outputs[at as usize * self.depth..][..self.depth];
                let layer = &mut self.layers[at as usize];
                let seen = std::mem::replace(&mut layer.micropolygon, Micropolygon::NONE);
                if seen != Micropolygon::NONE && layer.z < self.z[k] {
                    let triangle = look(seen);
                    let w = triangle.weights(layer.weights);
                    let mix = |[a, b, c]: [Vec3A; 3]| (a * w[0] + b * w[1] + c * w[2]).to_array();
                    (layer.color, layer.opacity) = (mix(triangle.color), mix(triangle.opacity));
                    triangle.outputs(outputs, w, own);
                }
                at = layer.next;
            }
        }
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
    pub fn resolve(&mut self, aovs: &[Aov]) {
        let mut stack: Vec<(u32, Layer)> = Vec::new();
        for k in 0..self.list.len() {
            if self.list[k] == NONE {
                continue;
            }
            stack.clear();
            let mut at = self.list[k];
            while at != NONE {
                let v = self.layers[at as usize];
                if v.z < self.z[k] {
                    stack.push((at, v));
                }
                at = v.next;
            }
            // Farthest first; what is equally far keeps the order in which it came.
            stack.sort_by(|a, b| b.1.z.total_cmp(&a.1.z));
            for (layer, v) in &stack {
                for c in 0..3 {
                    self.color[k][c] = v.color[c] + self.color[k][c] * (1.0 - v.opacity[c]);
                }
                let mean = (v.opacity[0] + v.opacity[1] + v.opacity[2]) / 3.0;
                self.alpha[k] = mean + self.alpha[k] * (1.0 - mean);
                if self.depth > 0 {
                    let own = &self.layer_outputs[*layer as usize * self.depth..][..self.depth];
                    let under = &mut self.outputs[k * self.depth..][..self.depth];
                    lay_over(aovs, own, v.opacity, under);
                }
                if mean >= 0.5 {
                    self.z[k] = v.z;
                }
            }
        }
    }

    /// Filter the pixels of the bucket proper, `margin` pixels in from each side.
    pub fn filter(&self, fx: &Filter, fy: &Filter, margin: [usize; 2], aovs: &[Aov]) -> Pixels {
        let [sx, sy] = self.strata;
        let mut out = Pixels::default();
        let mut sums = vec![0.0; self.depth];
        // A box of a pixel takes its own samples and no others.
        let alone = fx.is_pixel() && fy.is_pixel();
        for py in margin[1]..self.height - margin[1] {
            for px in margin[0]..self.width - margin[0] {
                let (cx, cy) = (px as f32 + 0.5, py as f32 + 0.5);
                let (mut sum, mut weight) = ([0.0f32; 4], 0.0f32);
                let mut covered = 0.0;
                sums.fill(0.0);
                for (qx, qy) in (py - margin[1]..=py + margin[1])
                    .flat_map(|qy| (px - margin[0]..=px + margin[0]).map(move |qx| (qx, qy)))
                {
                    for row in 0..sy {
                        for column in 0..sx {
                            let k = self.index([qx, qy], [column, row]);
                            let w = if alone { 1.0 } else { fx.at(self.x[k] - cx) * fy.at(self.y[k] - cy) };
                            if w != 0.0 {
                                for c in 0..3 {
                                    sum[c] += w * self.color[k][c];
                                }
                                sum[3] += w * self.alpha[k];
                                weight += w;
                                if self.depth > 0 {
                                    let own = &self.outputs[k * self.depth..][..self.depth];
                                    sums.iter_mut().zip(own).for_each(|(sum, x)| *sum += w * x);
                                    covered += if self.alpha[k] > 0.0 { w } else { 0.0 };
                                }
                            }
                        }
                    }
                }
                out.color.push(if weight != 0.0 { sum.map(|x| x / weight) } else { [0.0; 4] });
                for (first, aov) in placed(aovs) {
                    let of = match aov.kind {
                        Kind::Color => weight,
                        _ => covered,
                    };
                    match aov.name.as_str() {
                        "z" => out.extra.push(self.nearest(px, py)),
                        "id" => {
                            out.extra.push(self.middle(px, py).map_or(0.0, |k| self.outputs[k * self.depth + first]))
                        }
                        _ => out.extra.extend(
                            sums[first..first + aov.width()].iter().map(|x| if of != 0.0 { x / of } else { 0.0 }),
                        ),
                    }
                }
            }
        }
        out
    }

    /// The samples of a pixel.
    fn of_pixel(&self, px: usize, py: usize) -> impl Iterator<Item = usize> + '_ {
        let [sx, sy] = self.strata;
        (0..sy).flat_map(move |row| (0..sx).map(move |column| self.index([px, py], [column, row])))
    }

    /// The least depth in a pixel; infinity where nothing is.
    fn nearest(&self, px: usize, py: usize) -> f32 {
        let covered = self.of_pixel(px, py).filter(|k| self.alpha[*k] > 0.0);
        covered.map(|k| self.z[k]).fold(f32::INFINITY, f32::min)
    }

    /// The sample nearest the middle of a pixel, if anything is there.
    fn middle(&self, px: usize, py: usize) -> Option<usize> {
        let off = |k: &usize| {
            let (x, y) = (self.x[*k] - px as f32 - 0.5, self.y[*k] - py as f32 - 0.5);
            x * x + y * y
        };
        let nearest = self.of_pixel(px, py).min_by(|a, b| off(a).total_cmp(&off(b)));
        nearest.filter(|k| self.alpha[*k] > 0.0)
    }
}

/// Lay what displays take of a surface over what is behind it: colours by the opacity, other values if it is half opaque.
fn lay_over(aovs: &[Aov], own: &[f32], opacity: [f32; 3], under: &mut [f32]) {
    let mean = (opacity[0] + opacity[1] + opacity[2]) / 3.0;
    for (first, aov) in placed(aovs) {
        for c in 0..aov.width() {
            let k = first + c;
            match aov.kind {
                Kind::Color => under[k] = own[k] + under[k] * (1.0 - opacity[c]),
                _ if mean >= 0.5 => under[k] = own[k],
                _ => {}
            }
        }
    }
}

/// The pixels of a bucket, row by row.
#[derive(Default)]
pub struct Pixels {
    /// Red, green, blue, coverage.
    pub color: Vec<[f32; 4]>,
    /// What displays take besides, one pixel's numbers after another's.
    pub extra: Vec<f32>,
}
