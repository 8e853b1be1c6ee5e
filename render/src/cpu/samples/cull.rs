//! Culling: whether all samples of a part of the raster are nearer than something.

use crate::cpu::lanes::LANES;
use crate::cpu::samples::{BLOCK, CELL, EDGE, Samples};

impl Samples {
    /// Whether everything in a raster rectangle (absolute pixels) at or behind depth `z` is hidden already.
    pub fn hides(&mut self, min: [f32; 2], max: [f32; 2], z: f32) -> bool {
        let at = [self.x0 as f32, self.y0 as f32];
        let Some(([bx0, bx1], [by0, by1])) = blocks_of(at, [self.width, self.height], min, max) else { return true };
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

    /// The depths of these pixels have changed.
    pub(crate) fn mark(&mut self, x0: usize, x1: usize, y0: usize, y1: usize) {
        for by in y0 / BLOCK..=y1 / BLOCK {
            for bx in x0 / BLOCK..=x1 / BLOCK {
                self.block_dirty[by * self.blocks + bx] = true;
            }
        }
    }
}

/// The blocks that a raster rectangle meets, along x and y the first and the last, of samples of so many pixels from a place on; none if
/// it is beside them.
pub fn blocks_of(
    [left, top]: [f32; 2],
    size: [usize; 2],
    min: [f32; 2],
    max: [f32; 2],
) -> Option<([usize; 2], [usize; 2])> {
    let [w, h] = size.map(|n| n as f32);
    let (x0, y0, x1, y1) = (min[0] - left, min[1] - top, max[0] - left, max[1] - top);
    if !(x1 >= -1.0 && y1 >= -1.0 && x0 <= w + 1.0 && y0 <= h + 1.0) {
        return None;
    }
    let block = |x: f32, n: usize| (x.clamp(0.0, n as f32 - 1.0) as usize) / BLOCK;
    Some((
        [block(x0 - EDGE, size[0]), block(x1 + EDGE, size[0])],
        [block(y0 - EDGE, size[1]), block(y1 + EDGE, size[1])],
    ))
}
