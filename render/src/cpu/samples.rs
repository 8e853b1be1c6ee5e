//! Samples of a bucket: jittered places, the visibility buffer of what is nearest and opaque, and layers of what is translucent.
//!
//! A pixel is cut into strata, one sample in each, so that the samples of a bucket are a grid of strata, held in small cells,
//! and a micropolygon looks only at the cells that its bound touches. A sample holds the id of the
//! micropolygon that is visible there, which is shaded when nothing more will hide it (`crate::cpu::deferred`).

pub mod cull;
pub mod edges;
pub mod layers;
pub mod pixels;
pub mod solids;
pub mod visible;

use crate::cpu::lanes::LANES;
use crate::cpu::micropolygon::Micropolygon;
pub(crate) use crate::cpu::samples::edges::EDGE;
use crate::cpu::samples::edges::{Around, AtEdge};
use crate::film::display::{self, Aov};
use crate::film::jitter::{Jitter, PERIOD};
use crate::scene::camera::{RasterPlane, is_clipped};

/// Strata along x and y of a cell, whose samples are tested together. Whole cells make up a block.
pub(crate) const CELL: [usize; 2] = [4, LANES / 4];

/// Something that may be translucent at a sample, or several one behind the other.
#[derive(Clone, Copy)]
struct Layer {
    z: f32,
    micropolygon: Micropolygon,
    weights: [f32; 2],
    /// Colour, by the opacity already, and what part of what is behind it is seen.
    color: [f32; 3],
    open: [f32; 3],
    /// Coverage by channel, which is 0 of what leaves a hole: the opacity of all that is laid together.
    alpha: [f32; 3],
    /// Depth of the nearest of them that is half opaque; infinite if none is.
    half_z: f32,
    primitive: u64,
    /// The whole that the primitive is a part of, if others may be, too.
    whole: Option<u32>,
    sample: u32,
    next: u32,
    /// Of a solid, the primitive that is met, and whether the sample's line enters it.
    solid: Option<(u32, bool)>,
    /// Where it is met.
    at_edge: AtEdge,
    /// It counts at the depth where nothing more is seen, too.
    last: bool,
}

const NONE: u32 = u32::MAX;

/// The primitive of layers that are not compared with others of it.
const NO_PRIMITIVE: u64 = u64::MAX;

/// A grid, as far as sampling depends on it.
#[derive(Clone, Copy)]
pub struct SampledGrid<'a> {
    /// Its index among the deferred grids of the bucket.
    pub index: usize,
    /// All opaque.
    pub opaque: bool,
    /// That was not known before it was shaded: it is sampled as layers are.
    pub as_layers: bool,
    /// Colour is interpolated over a micropolygon.
    pub smooth: bool,
    /// Points of the grid along u and v, and whether its first and last along u and along v are edges of the primitive.
    pub size: [usize; 2],
    pub rims: [bool; 4],
    /// Names the primitive, so that a sample on an edge that two of its micropolygons share counts once.
    pub primitive: u64,
    /// The whole that the primitive is a part of, if others may be, too: a sample on an edge that two of these share counts once.
    pub whole: Option<u32>,
    /// The part of the samples, from 0 to 1, that see it.
    pub seen: [f32; 2],
    /// Planes beyond which it is clipped; what is opaque has none.
    pub planes: &'a [RasterPlane],
    /// Of a solid, the primitive that it is a part of, and whether triangles of positive area on the raster are entered.
    pub solid: Option<(u32, bool)>,
    /// The sign of the area on the raster of triangles that are there; 0 if all are.
    pub side: f32,
    /// Nothing is recorded: it is only asked whether any sample takes something.
    pub is_probe: bool,
}

impl SampledGrid<'_> {
    /// A micropolygon, by its first point, with its corners from a sample on.
    #[inline]
    pub(crate) fn around(&self, point: usize, corners: [[f32; 2]; 4]) -> Around {
        let [nu, nv] = self.size;
        let (i, j) = (point % nu, point / nu);
        let outer = [j == 0, i + 2 == nu, j + 2 == nv, i == 0];
        let [low_u, high_u, low_v, high_v] = self.rims;
        Around { corners, outer, rims: [low_v, high_u, high_v, low_u], side: self.side }
    }
}

/// A tally of sampling.
#[derive(Clone, Copy, Default)]
pub struct Tally {
    /// Samples tried.
    pub tried: u64,
    /// Whether any took something.
    pub hit: bool,
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

/// A step that visits all of so many samples, near the golden section.
pub(crate) fn step(n: usize) -> usize {
    let common = |mut a: usize, mut b: usize| {
        while b > 0 {
            (a, b) = (b, a % b);
        }
        a
    };
    (n * 618 / 1000..n).find(|step| common(*step, n) == 1).unwrap_or(1)
}

/// Pixels along the edge of a block whose greatest depth is kept for culling.
pub(crate) const BLOCK: usize = 4;

/// The samples of a bucket through a lens: one stratum of time after another, in each pixel after pixel, which has one sample there.
#[derive(Default)]
pub struct LensSamples {
    /// Place, pixels of the whole image: what is decided by it is decided alike in every bucket.
    pub(crate) x: Vec<f32>,
    pub(crate) y: Vec<f32>,
    /// Part of the time that the shutter is open.
    pub(crate) time: Vec<f32>,
    /// Place on the lens.
    pub(crate) lens: [Vec<f32>; 2],
    /// The sample among all of the bucket.
    pub(crate) sample: Vec<u32>,
}

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
    /// Samples of a pixel, with those that make its last cell whole, in images of motion without a lens, where they lie together by
    /// their times; 0 elsewhere.
    pub(crate) padded: usize,
    /// Cells along x and y.
    pub(crate) columns: usize,
    pub(crate) rows: usize,
    /// Places, pixels from the bucket's first one.
    pub(crate) x: Vec<f32>,
    pub(crate) y: Vec<f32>,
    /// Part of the time that the shutter is open, in images of motion or with a lens.
    pub(crate) time: Vec<f32>,
    /// Which part of the pattern the places are of, and how many pixels; what depths are where nothing is.
    pattern: Option<([i64; 2], [usize; 2])>,
    empty: Vec<f32>,
    /// Depth of the nearest thing that is opaque.
    pub(crate) z: Vec<f32>,
    /// The id of the micropolygon that it is; none, once its colour is known.
    pub(crate) visible: Vec<u32>,
    /// Where it is met: weights of its second and third corner, if it is smooth.
    pub(crate) weights: [Vec<f32>; 2],
    color: Vec<[f32; 3]>,
    /// Nothing but a hole for `Matte`.
    alpha: Vec<f32>,
    list: Vec<u32>,
    layers: Vec<Layer>,
    /// Memory that layers are packed into.
    packed: (Vec<Layer>, Vec<f32>),
    /// How many of the layers have been given their colours, and how many may be there before they are packed.
    n_colored: usize,
    room: usize,
    /// Whether layers have closed samples to what is behind.
    closed: bool,
    /// What displays take besides colour, `depth` numbers of each sample and of each layer.
    outputs: Vec<f32>,
    layer_outputs: Vec<f32>,
    depth: usize,
    /// Of each of these numbers, the channel of the opacity that it counts by.
    weighted: Vec<Option<usize>>,
    /// The identities of what is visible, if these are kept; 0 where nothing is.
    identities: Vec<u64>,
    /// The depths of these.
    identity_z: Vec<f32>,
    /// The samples by their moments, where there is a lens.
    pub(crate) lens: LensSamples,
    block_z: Vec<f32>,
    block_dirty: Vec<bool>,
    blocks: usize,
}

impl Samples {
    /// Start a bucket whose pixels, margin included, begin at (`x0`, `y0`).
    pub fn start(&mut self, jitter: &Jitter, x0: i64, y0: i64, width: usize, height: usize, aovs: &[Aov]) {
        (self.x0, self.y0, self.width, self.height, self.strata) = (x0, y0, width, height, jitter.strata);
        self.depth = display::depth(aovs);
        self.weighted.clear();
        self.weighted.extend(aovs.iter().flat_map(|aov| (0..aov.width()).map(|c| aov.is_weighted().then_some(c))));
        self.set_places(jitter);
        let n = self.x.len();
        self.z.clear();
        self.z.extend_from_slice(&self.empty);
        self.set_lens_samples(jitter);
        self.visible.clear();
        self.visible.resize(n, Micropolygon::NONE.id());
        self.weights.iter_mut().for_each(|w| w.resize(n, 0.0));
        self.color.clear();
        self.color.resize(n, [0.0; 3]);
        self.alpha.clear();
        self.alpha.resize(n, 0.0);
        self.list.clear();
        self.list.resize(n, NONE);
        self.clear_layers();
        self.outputs.clear();
        self.outputs.resize(n * self.depth, 0.0);
        self.identities.clear();
        self.identity_z.clear();
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
        self.time.resize(if jitter.moments.is_some() { n } else { 0 }, 0.0);
        let moments = jitter.moments.as_ref().filter(|_| self.padded > 0);
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

    /// Give the samples of a bucket their moments, where there is a lens.
    fn set_lens_samples(&mut self, jitter: &Jitter) {
        let Some(moments) = jitter.moments.as_ref().filter(|_| jitter.lens) else { return };
        let [sx, sy] = self.strata;
        let mut own = std::mem::take(&mut self.lens);
        let LensSamples { x, y, time, lens: [lens_x, lens_y], sample } = &mut own;
        [&mut *x, y, time, lens_x, lens_y].into_iter().for_each(Vec::clear);
        sample.clear();
        for stratum in 0..sx * sy {
            for (px, py) in (0..self.height).flat_map(|py| (0..self.width).map(move |px| (px, py))) {
                let ([column, row], moment) = moments.of(px as i64 + self.x0, py as i64 + self.y0, stratum);
                let k = self.index([px, py], [column as usize, row as usize]);
                x.push(self.x[k] + self.x0 as f32);
                y.push(self.y[k] + self.y0 as f32);
                time.push(moment[0]);
                self.time[k] = moment[0];
                lens_x.push(moment[1]);
                lens_y.push(moment[2]);
                sample.push(k as u32);
            }
        }
        // The last are tested with lanes beyond them, which are nowhere.
        x.extend([f32::INFINITY; LANES]);
        [y, time, lens_x, lens_y].into_iter().for_each(|v| v.extend([0.0; LANES]));
        self.lens = own;
    }

    /// Where a sample of a pixel is in the columns: that of a stratum, or in images of motion, of the time of that number.
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

    /// A number from 0 to 1 of a sample's own: the samples of a pixel have numbers that are evenly spread, in an order of its own.
    fn part(&self, k: usize) -> f32 {
        let ([sx, sy], x, y) = (self.strata, self.x[k], self.y[k]);
        let n = sx * sy;
        let stratum = |x: f32, strata: usize| ((x.fract() * strata as f32) as usize).min(strata - 1);
        let [px, py] = [(x, self.x0), (y, self.y0)].map(|(x, first)| (x.floor() as i64 + first) as u32);
        let hash = (px.wrapping_mul(0x9e37_79b1) ^ py.wrapping_mul(0x85eb_ca77)).wrapping_mul(0xc2b2_ae3d) >> 12;
        let rank = ((stratum(y, sy) * sx + stratum(x, sx)) * step(n) + hash as usize) % n;
        (rank as f32 + 0.5) / n as f32
    }

    /// Record that a sample meets a micropolygon, nearer than what is opaque there; `area` evaluates the sign of its area on the raster, which solids
    /// need.
    #[inline]
    pub(crate) fn record(
        &mut self,
        k: usize,
        z: f32,
        micropolygon: Micropolygon,
        (weights, at_edge): ([f32; 2], AtEdge),
        grid: &SampledGrid<'_>,
        area: impl FnOnce() -> f32,
    ) {
        if grid.opaque {
            self.z[k] = z;
            self.visible[k] = micropolygon.id();
            (self.weights[0][k], self.weights[1][k]) = (weights[0], weights[1]);
        } else if !grid.is_probe {
            let area = if grid.solid.is_some() { area() } else { 0.0 };
            self.record_layer(k, z, micropolygon, weights, grid, (at_edge, area));
        }
    }

    /// The same of what may be translucent.
    #[inline(never)]
    fn record_layer(
        &mut self,
        k: usize,
        z: f32,
        micropolygon: Micropolygon,
        weights: [f32; 2],
        grid: &SampledGrid<'_>,
        (at_edge, area): (AtEdge, f32),
    ) {
        if grid.seen != [0.0, 1.0] {
            let part = self.part(k);
            if part < grid.seen[0] || part >= grid.seen[1] {
                return;
            }
        }
        if is_clipped(grid.planes, [self.x[k] + self.x0 as f32, self.y[k] + self.y0 as f32], z) {
            return;
        }
        let solid = grid.solid.map(|(leaf, positive)| (leaf, (area > 0.0) == positive));
        // Every surface of a solid counts.
        let (primitive, whole) = if solid.is_some() { (NO_PRIMITIVE, None) } else { (grid.primitive, grid.whole) };
        let next = std::mem::replace(&mut self.list[k], self.layers.len() as u32);
        let (color, open, alpha, half_z) = ([0.0; 3], [1.0; 3], [0.0; 3], f32::INFINITY);
        let (sample, last) = (k as u32, false);
        self.layers.push(Layer {
            z,
            micropolygon,
            weights,
            color,
            open,
            alpha,
            half_z,
            primitive,
            whole,
            sample,
            next,
            solid,
            at_edge,
            last,
        });
    }
}
