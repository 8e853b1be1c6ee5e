//! Count the bins that each shape's box touches, scan, and emit one (bin, shape) pair for each.
//! in   fat_aabb   [n_shapes]  m, world
//! out  bin_level  [n_shapes]  which of the grids of bins a shape is on
//! out  bin_low    [n_shapes]  the bin of its box's least corner
//! out  bin        [n_bin_pairs]
//! out  bin_shape  [n_bin_pairs]
//! Source: paper §3, stages 1–3.
//!
//! Bins come in levels, each four times as large as the one below; a shape goes to the level whose bins are about its size, so
//! that a chassis among grains costs a few large bins and not a million small ones. The bins of a level are numbered brick by
//! brick, so that what is near in space is near in memory; `pair_write` hands the bricks to the threads.

use crate::aabb::Aabb;
use crate::model::Model;
use crate::rows::{CHUNK, fill_rows, scatter_rows};
use crate::state::State;
use glam::{UVec3, Vec3A};
use rayon::prelude::*;

/// How many levels there may be: sizes of up to 4⁵ times the least.
const LEVELS: usize = 6;

/// One level's bins: cubes of one size over the box of all moving shapes.
#[derive(Clone, Copy, Debug, Default)]
pub struct Level {
    /// Edge of a bin, m.
    pub size: f32,
    /// Bins along each axis.
    pub n: UVec3,
    /// Bricks along each axis, and the bins that the first of them lack, so that the first and the last are alike.
    bricks: UVec3,
    lack: UVec3,
    /// Number of the level's first bin; coarser levels come first.
    pub first: u32,
    /// Whether any shape is on it.
    pub used: bool,
}

/// The pairs of a bin and a shape that touches it, with the grids.
#[derive(Default)]
pub struct Bins {
    /// The grids.
    pub grid: BinGrid,
    /// Bin of each pair (n_bin_pairs).
    pub bin: Vec<u32>,
    /// Shape of each pair (n_bin_pairs).
    pub shape: Vec<u32>,
    /// First pair of each bin with more than one shape, and the pair after its last (n_active_bins).
    pub start: Vec<[u32; 2]>,
}

/// The grids of bins.
#[derive(Clone, Debug, Default)]
pub struct BinGrid {
    /// Least corner, m.
    pub origin: Vec3A,
    /// Greatest corner, m.
    end: Vec3A,
    /// The levels, from the finest.
    pub levels: [Level; LEVELS],
    /// Level of each shape (n_shapes).
    pub level: Vec<u8>,
    /// The bin of the least corner of each shape's box, on its own level (n_shapes).
    pub low: Vec<UVec3>,
    /// Bins in all, those that fill the last bricks up among them.
    n_bins: u32,
}

/// Boxes that move: what is around them, how many they are, and the sum of their reciprocal widths.
#[derive(Clone, Copy)]
struct Crowd {
    around: Aabb,
    n: u32,
    inverse: f64,
}

impl Crowd {
    const NONE: Crowd = Crowd { around: Aabb::EMPTY, n: 0, inverse: 0.0 };

    fn of(b: &Aabb) -> Crowd {
        Crowd { around: *b, n: 1, inverse: 1.0 / (b.max - b.min).max_element() as f64 }
    }

    fn join(self, other: &Crowd) -> Crowd {
        let (a, b) = (self.around, other.around);
        let around = Aabb { min: a.min.min(b.min), max: a.max.max(b.max) };
        Crowd { around, n: self.n + other.n, inverse: self.inverse + other.inverse }
    }
}

/// Log₂ of the bins along the edge of a brick, which is a dozen grains.
const BRICK: u32 = 3;
/// More bins than this would cost more to count than they save.
const MAX_BINS: f32 = 16_000_000.0;

impl BinGrid {
    /// Choose the bins for a set of boxes: those of the finest level hold three or four of the usual shapes.
    pub fn choose(&mut self, model: &Model, state: &State, aabb: &[Aabb]) {
        let moving =
            |s: usize| state.moves(model.shape_body[s] as usize) && aabb[s].min.is_finite() && aabb[s].max.is_finite();
        let pieces: Vec<Crowd> = aabb
            .par_chunks(CHUNK)
            .enumerate()
            .map(|(piece, boxes)| {
                let own = boxes.iter().enumerate().filter(|(k, _)| moving(piece * CHUNK + k));
                own.fold(Crowd::NONE, |crowd, (_, b)| crowd.join(&Crowd::of(b)))
            })
            .collect();
        let Crowd { around: Aabb { min, max }, n, inverse } = pieces.iter().fold(Crowd::NONE, |a, b| a.join(b));
        if n == 0 {
            *self = BinGrid { level: vec![0; aabb.len()], low: vec![UVec3::ZERO; aabb.len()], ..BinGrid::default() };
            return;
        }
        (self.origin, self.end) = (min, max);
        let extent = max - min;
        // The harmonic mean: the many small ones count, not the few large ones.
        let mut size = (1.7 * n as f64 / inverse) as f32;
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
                used[self.level[s] as usize] = self.holds(model, aabb, s);
            }
        }
        self.n_bins = 0;
        for l in (0..LEVELS).rev() {
            let size = finest * 4f32.powi(l as i32);
            let n = n_of(size).as_uvec3();
            let bricks = (n + (1 << BRICK) - 1) >> BRICK;
            let lack = ((bricks << BRICK) - n) / 2;
            self.levels[l] = Level { size, n, bricks, lack, first: self.n_bins, used: used[l] };
            if used[l] {
                self.n_bins += bricks.element_product() << (3 * BRICK);
            }
        }
        let mut low = std::mem::take(&mut self.low);
        low.resize(aabb.len(), UVec3::ZERO);
        fill_rows(&mut low, |s| self.bin_of(self.level[s] as usize, aabb[s].min));
        self.low = low;
    }

    /// Where a bin is among those of its level.
    #[inline]
    pub fn place(&self, level: usize, index: u32) -> UVec3 {
        let Level { bricks: n, first, .. } = self.levels[level];
        let (inner, k) = (index - first, (index - first) >> (3 * BRICK));
        let brick = UVec3::new(k % n.x, k / n.x % n.y, k / (n.x * n.y));
        let mask = (1 << BRICK) - 1;
        (brick << BRICK) + (UVec3::new(inner, inner >> BRICK, inner >> (2 * BRICK)) & mask)
    }

    /// The brick of a bin.
    #[inline]
    pub fn brick(&self, index: u32) -> u32 {
        index >> (3 * BRICK)
    }

    /// The brick of the bin that holds the least corner of a shape's box, and the same of bricks that are moved by half a brick
    /// along each axis.
    pub fn bricks_of(&self, shape: usize) -> [u32; 2] {
        let (level, low) = (self.level[shape] as usize, self.low[shape]);
        let (moved, n) = ((low + (1 << BRICK >> 1)) >> BRICK, self.levels[level].bricks + 1);
        let second = moved.x + n.x * (moved.y + n.y * moved.z);
        [self.brick(self.index(level, low)), (level as u32) << 28 | second]
    }

    /// Whether a shape goes into bins: not a surface, and within the box of what moves.
    fn holds(&self, model: &Model, aabb: &[Aabb], shape: usize) -> bool {
        !model.shape_kind[shape].is_surface() && aabb[shape].overlaps(&Aabb { min: self.origin, max: self.end })
    }

    /// The bin of a level that holds a point; points outside fall into the nearest one.
    #[inline]
    pub fn bin_of(&self, level: usize, p: Vec3A) -> UVec3 {
        let Level { size, n, lack, .. } = self.levels[level];
        ((p - self.origin) / size).max(Vec3A::ZERO).as_uvec3().min(n - UVec3::ONE) + lack
    }

    /// Number of a bin.
    #[inline]
    pub fn index(&self, level: usize, bin: UVec3) -> u32 {
        let Level { bricks: n, first, .. } = self.levels[level];
        let (brick, inner) = (bin >> BRICK, bin & ((1 << BRICK) - 1));
        let k = brick.x + n.x * (brick.y + n.y * brick.z);
        first + ((k << (3 * BRICK)) | inner.x | inner.y << BRICK | inner.z << (2 * BRICK))
    }

    /// Visit the bins of a level that a box touches.
    #[inline]
    pub fn visit(&self, level: usize, aabb: &Aabb, mut found: impl FnMut(u32)) {
        let (lo, hi) = (self.bin_of(level, aabb.min), self.bin_of(level, aabb.max));
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

/// The stage. Planes and other surfaces take no bins; `pair_write` meets them on their own.
pub fn run(model: &Model, state: &State, bins: &mut Bins) {
    let aabb = state.fat_aabb.as_deref().expect("boxes from `bounds`");
    let Bins { grid, bin, shape, .. } = bins;
    grid.choose(model, state, aabb);
    let (grid, n) = (&*grid, model.n_shapes());
    let mut start = vec![0; n + 1];
    fill_rows(&mut start[..n], |s| {
        if !grid.holds(model, aabb, s) {
            return 0;
        }
        let level = grid.level[s] as usize;
        (grid.bin_of(level, aabb[s].max) - grid.bin_of(level, aabb[s].min) + UVec3::ONE).element_product()
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
