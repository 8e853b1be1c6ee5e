//! Count the bins that each shape's box touches, scan, and emit one (bin, shape) pair for each.
//! in   aabb       [n_shapes]      m, world
//! out  pair_start [n_shapes + 1]  first pair of each shape
//!      bin        [n_pairs]       bin of the pair
//!      shape      [n_pairs]       shape of the pair
//! Source: paper §3, stages 1–3.

use super::{Aabb, fill_rows, scatter_rows};
use crate::{Model, ShapeKind};
use glam::{DVec3, UVec3};

/// The grid of bins: cubes of one size over the box of all finite shapes.
#[derive(Clone, Copy, Debug)]
pub struct BinGrid {
    /// Least corner, m.
    pub origin: DVec3,
    /// Edge of a bin, m.
    pub size: f64,
    /// Bins along each axis.
    pub n: UVec3,
}

/// More bins than this would cost more to count than they save.
const MAX_BINS: f64 = 16_000_000.0;

impl BinGrid {
    /// Choose the grid for a set of boxes: bins a little larger than the mean moving shape, which puts three or four shapes in each.
    pub fn choose(model: &Model, aabb: &[Aabb]) -> BinGrid {
        let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (mut width, mut n_moving) = (0.0, 0u32);
        for (s, b) in aabb.iter().enumerate() {
            if model.inv_mass[model.shape_body[s] as usize] > 0.0 {
                min = min.min(b.min);
                max = max.max(b.max);
                width += (b.max - b.min).max_element();
                n_moving += 1;
            }
        }
        if n_moving == 0 || !min.is_finite() || !max.is_finite() {
            return BinGrid { origin: DVec3::ZERO, size: 1.0, n: UVec3::ONE };
        }
        let extent = max - min;
        let mut size = 1.2 * width / n_moving as f64;
        while (extent / size).ceil().max(DVec3::ONE).element_product() > MAX_BINS {
            size *= 1.26;
        }
        BinGrid { origin: min, size, n: (extent / size).ceil().max(DVec3::ONE).as_uvec3() }
    }

    /// The bin that holds a point; points outside fall into the nearest one.
    #[inline]
    pub fn bin_of(&self, p: DVec3) -> UVec3 {
        ((p - self.origin) / self.size).max(DVec3::ZERO).as_uvec3().min(self.n - UVec3::ONE)
    }

    /// Number of a bin.
    #[inline]
    pub fn index(&self, bin: UVec3) -> u32 {
        bin.x + self.n.x * (bin.y + self.n.y * bin.z)
    }

    /// Number of bins.
    pub fn len(&self) -> u32 {
        self.n.element_product()
    }
}

/// The stage. Planes are everywhere and take no bins; `pair_write` meets them on their own.
pub fn run(
    model: &Model,
    aabb: &[Aabb],
    grid: &BinGrid,
    pair_start: &mut Vec<u32>,
    bin: &mut Vec<u32>,
    shape: &mut Vec<u32>,
) {
    let n = model.n_shapes();
    pair_start.clear();
    pair_start.resize(n + 1, 0);
    fill_rows(&mut pair_start[..n], |s| {
        if model.shape_kind[s] == ShapeKind::Plane || outside(&aabb[s], grid) {
            return 0;
        }
        (grid.bin_of(aabb[s].max) - grid.bin_of(aabb[s].min) + UVec3::ONE).element_product()
    });
    let n_pairs = gpu::scan::exclusive_cpu(pair_start) as usize;
    bin.resize(n_pairs, 0);
    shape.resize(n_pairs, 0);
    scatter_rows(bin, pair_start, |s, row| {
        if row.is_empty() {
            return;
        }
        let (lo, hi) = (grid.bin_of(aabb[s].min), grid.bin_of(aabb[s].max));
        let mut slot = row.iter_mut();
        for z in lo.z..=hi.z {
            for y in lo.y..=hi.y {
                for x in lo.x..=hi.x {
                    *slot.next().expect("as many slots as bins") = grid.index(UVec3::new(x, y, z));
                }
            }
        }
    });
    scatter_rows(shape, pair_start, |s, row| row.fill(s as u32));
}

/// Whether a box misses the grid altogether, as a static shape far from anything that moves does.
fn outside(aabb: &Aabb, grid: &BinGrid) -> bool {
    let max = grid.origin + grid.n.as_dvec3() * grid.size;
    !aabb.overlaps(&Aabb { min: grid.origin, max })
}
