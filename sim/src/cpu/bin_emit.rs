//! Count the bins that each shape's box overlaps, scan, and emit one (bin, shape) pair for each.
//! in   fat_aabb   [n_shapes]  m, world
//! out  bin_level  [n_shapes]  level of the shape's bins
//! out  bin_low    [n_shapes]  bin coordinates of its box's minimum corner
//! out  bin        [n_bin_pairs]
//! out  bin_shape  [n_bin_pairs]
//! Source: paper §3, stages 1–3.
//!
//! The grid is hierarchical: the bins of each level are four times as large as those of the level below. A shape goes to the level
//! whose bins are about its size, so that a chassis among grains is in a few large bins rather than in a million small ones. The bins
//! of a level are indexed brick by brick, so that shapes that are near in space are near in memory; `pair_write` makes tiles of the
//! bricks.

use crate::aabb::Aabb;
use crate::model::Model;
use crate::plan::{Narrow, StepPlan};
use crate::rows::{CHUNK, fill_rows, scatter_rows};
use crate::state::State;
use glam::{UVec3, Vec3A};
use rayon::prelude::*;

/// Number of levels: bin sizes up to 4⁵ times the smallest.
const LEVELS: usize = 6;

/// The bins of a level: cubes of one size over the box of all moving shapes.
#[derive(Clone, Copy, Debug, Default)]
pub struct Level {
    /// Edge of a bin, m.
    pub size: f32,
    /// Bins along each axis.
    pub n: UVec3,
    /// Bricks along each axis, and the bins that the first brick lacks, so that the first and the last are about equal.
    bricks: UVec3,
    lack: UVec3,
    /// Index of the level's first bin; coarser levels come first.
    pub first: u32,
    /// Whether the level has any shape.
    pub used: bool,
}

/// The (bin, shape) pairs, with the grid.
#[derive(Default)]
pub struct Bins {
    /// The grid of bins.
    pub grid: BinGrid,
    /// Bin of each pair (n_bin_pairs).
    pub bin: Vec<u32>,
    /// Shape of each pair (n_bin_pairs).
    pub shape: Vec<u32>,
    /// First pair of each bin with more than one shape, and the end (n_active_bins).
    pub start: Vec<[u32; 2]>,
}

/// The hierarchical grid of bins.
#[derive(Clone, Debug, Default)]
pub struct BinGrid {
    /// Minimum corner, m.
    pub origin: Vec3A,
    /// Maximum corner, m.
    end: Vec3A,
    /// The levels, from the finest.
    pub levels: [Level; LEVELS],
    /// Level of each shape (n_shapes).
    pub level: Vec<u8>,
    /// Bin coordinates of the minimum corner of each shape's box, on its own level (n_shapes).
    pub low: Vec<UVec3>,
    /// Log₂ of the number of bins along the edge of a brick.
    brick: u32,
    /// Number of bins, with those that pad the bricks.
    n_bins: u32,
}

/// Statistics of the moving boxes: their bounds, count, and the sum of their reciprocal widths, 1/m.
#[derive(Clone, Copy)]
struct BoxStatistics {
    bounds: Aabb,
    n: u32,
    inv_width: f64,
}

impl BoxStatistics {
    const NONE: BoxStatistics = BoxStatistics { bounds: Aabb::EMPTY, n: 0, inv_width: 0.0 };

    fn of(b: &Aabb) -> BoxStatistics {
        BoxStatistics { bounds: *b, n: 1, inv_width: 1.0 / (b.max - b.min).max_element() as f64 }
    }

    fn join(self, other: &BoxStatistics) -> BoxStatistics {
        let (a, b) = (self.bounds, other.bounds);
        let bounds = Aabb { min: a.min.min(b.min), max: a.max.max(b.max) };
        BoxStatistics { bounds, n: self.n + other.n, inv_width: self.inv_width + other.inv_width }
    }
}

/// Log₂ of the number of bins along the edge of a brick, which is about a dozen grains long, or half of that where there are few spheres: each
/// thread then has tiles enough. Blocks of other shapes fill their lanes in large tiles alone.
const BRICK: [u32; 2] = [3, 2];
/// Number of spheres up to which there are few.
const FEW_SPHERES: u32 = 50_000;
/// Maximum number of bins.
const MAX_BINS: f32 = 16_000_000.0;

impl BinGrid {
    /// Choose the bins for a set of boxes: a bin of the finest level has three or four shapes of the usual size.
    pub fn choose(&mut self, model: &Model, state: &State, plan: &StepPlan, aabb: &[Aabb]) {
        let moving =
            |s: usize| state.moves(model.shape_body[s] as usize) && aabb[s].min.is_finite() && aabb[s].max.is_finite();
        let chunks: Vec<BoxStatistics> = aabb
            .par_chunks(CHUNK)
            .enumerate()
            .map(|(chunk, boxes)| {
                let own = boxes.iter().enumerate().filter(|(k, _)| moving(chunk * CHUNK + k));
                own.fold(BoxStatistics::NONE, |sum, (_, b)| sum.join(&BoxStatistics::of(b)))
            })
            .collect();
        let BoxStatistics { bounds: Aabb { min, max }, n, inv_width } =
            chunks.iter().fold(BoxStatistics::NONE, |a, b| a.join(b));
        if n == 0 {
            // A grid without bins, which no box overlaps.
            let (level, low) = (vec![0; aabb.len()], vec![UVec3::ZERO; aabb.len()]);
            let Aabb { min: origin, max: end } = Aabb::EMPTY;
            *self = BinGrid { origin, end, level, low, ..BinGrid::default() };
            return;
        }
        (self.origin, self.end) = (min, max);
        self.brick = BRICK[(plan.narrow == Narrow::Spheres && n <= FEW_SPHERES) as usize];
        let extent = max - min;
        // The harmonic mean of the widths: a few large shapes do not coarsen the bins of many small ones.
        let mut size = (1.7 * n as f64 / inv_width) as f32;
        let n_of = |size: f32| (extent / size).ceil().max(Vec3A::ONE);
        while n_of(size).element_product() > MAX_BINS {
            size *= 1.26;
        }
        self.level.resize(aabb.len(), 0);
        let finest = size;
        fill_rows(&mut self.level, |s| {
            let width = (aabb[s].max - aabb[s].min).max_element();
            if width <= 1.3 * finest {
                return 0;
            }
            ((width / (1.3 * finest)).log2() / 2.0).ceil().min((LEVELS - 1) as f32) as u8
        });
        let mut used = [false; LEVELS];
        for s in 0..aabb.len() {
            if !used[self.level[s] as usize] {
                used[self.level[s] as usize] = self.is_binned(model, aabb, s);
            }
        }
        self.n_bins = 0;
        for l in (0..LEVELS).rev() {
            let size = finest * 4f32.powi(l as i32);
            let n = n_of(size).as_uvec3();
            let bricks = (n + (1 << self.brick) - 1) >> self.brick;
            let lack = ((bricks << self.brick) - n) / 2;
            self.levels[l] = Level { size, n, bricks, lack, first: self.n_bins, used: used[l] };
            if used[l] {
                self.n_bins += bricks.element_product() << (3 * self.brick);
            }
        }
        let mut low = std::mem::take(&mut self.low);
        low.resize(aabb.len(), UVec3::ZERO);
        fill_rows(&mut low, |s| self.bin_of(self.level[s] as usize, aabb[s].min));
        self.low = low;
    }

    /// Bin coordinates of a bin on its level.
    #[inline]
    pub fn coordinates(&self, level: usize, index: u32) -> UVec3 {
        let Level { bricks: n, first, .. } = self.levels[level];
        let (inner, k) = (index - first, (index - first) >> (3 * self.brick));
        let brick = UVec3::new(k % n.x, k / n.x % n.y, k / (n.x * n.y));
        let mask = (1 << self.brick) - 1;
        (brick << self.brick) + (UVec3::new(inner, inner >> self.brick, inner >> (2 * self.brick)) & mask)
    }

    /// Index of a bin's brick.
    #[inline]
    pub fn brick(&self, index: u32) -> u32 {
        index >> (3 * self.brick)
    }

    /// Index of the brick with the minimum corner of a shape's box, and the same for bricks that are shifted by half a brick along each
    /// axis.
    pub fn bricks_of(&self, shape: usize) -> [u32; 2] {
        let (level, low) = (self.level[shape] as usize, self.low[shape]);
        let (shifted, n) = ((low + (1 << self.brick >> 1)) >> self.brick, self.levels[level].bricks + 1);
        let second = shifted.x + n.x * (shifted.y + n.y * shifted.z);
        [self.brick(self.index(level, low)), (level as u32) << 28 | second]
    }

    /// Whether a shape is binned: it is not a surface, and its box overlaps that of the moving shapes.
    fn is_binned(&self, model: &Model, aabb: &[Aabb], shape: usize) -> bool {
        !model.shape_kind[shape].is_surface() && aabb[shape].overlaps(&Aabb { min: self.origin, max: self.end })
    }

    /// Bin coordinates of a point on a level; a point outside the grid is in the nearest bin.
    #[inline]
    pub fn bin_of(&self, level: usize, p: Vec3A) -> UVec3 {
        let Level { size, n, lack, .. } = self.levels[level];
        ((p - self.origin) / size).max(Vec3A::ZERO).as_uvec3().min(n - UVec3::ONE) + lack
    }

    /// Index of a bin.
    #[inline]
    pub fn index(&self, level: usize, bin: UVec3) -> u32 {
        let Level { bricks: n, first, .. } = self.levels[level];
        let (brick, inner) = (bin >> self.brick, bin & ((1 << self.brick) - 1));
        let k = brick.x + n.x * (brick.y + n.y * brick.z);
        first + ((k << (3 * self.brick)) | inner.x | inner.y << self.brick | inner.z << (2 * self.brick))
    }

    /// The lowest and the highest bin of a level that a box overlaps; of a box with corners out of the range of numbers, some bin.
    #[inline]
    fn bins_of(&self, level: usize, aabb: &Aabb) -> [UVec3; 2] {
        let low = self.bin_of(level, aabb.min);
        [low, self.bin_of(level, aabb.max).max(low)]
    }

    /// Visit the bins of a level that a box overlaps.
    #[inline]
    pub fn visit(&self, level: usize, aabb: &Aabb, mut found: impl FnMut(u32)) {
        let [lo, hi] = self.bins_of(level, aabb);
        for z in lo.z..=hi.z {
            for y in lo.y..=hi.y {
                for x in lo.x..=hi.x {
                    found(self.index(level, UVec3::new(x, y, z)));
                }
            }
        }
    }

    /// Number of bins.
    pub fn len(&self) -> u32 {
        self.n_bins
    }
}

/// The stage. Surfaces are not binned; `pair_write` tests every shape against them.
pub fn run(model: &Model, state: &State, plan: &StepPlan, bins: &mut Bins) {
    let aabb = state.fat_aabb.as_deref().expect("boxes from `bounds`");
    let Bins { grid, bin, shape, .. } = bins;
    grid.choose(model, state, plan, aabb);
    let (grid, n) = (&*grid, model.n_shapes());
    let mut start = vec![0; n + 1];
    fill_rows(&mut start[..n], |s| {
        if !grid.is_binned(model, aabb, s) {
            return 0;
        }
        let [low, high] = grid.bins_of(grid.level[s] as usize, &aabb[s]);
        (high - low + UVec3::ONE).element_product()
    });
    let n_pairs = gpu::scan::exclusive_cpu(&mut start) as usize;
    bin.resize(n_pairs, 0);
    shape.resize(n_pairs, 0);
    scatter_rows(bin, &start, |s, row| {
        if !row.is_empty() {
            let mut slot = row.iter_mut();
            grid.visit(grid.level[s] as usize, &aabb[s], |b| *slot.next().expect("as many slots as bins") = b);
        }
    });
    scatter_rows(shape, &start, |s, row| row.fill(s as u32));
}
