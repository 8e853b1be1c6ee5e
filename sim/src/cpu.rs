//! The CPU back end: one file a stage, over the columns of the model and the state. [`crate::stages`] has their order.
//!
//! Every stage that runs in parallel cuts its rows into pieces of fixed length, so that results are the same bits for any
//! number of threads.

pub mod bin_emit;
pub mod bin_start;
pub mod bounds;
pub mod collide;
pub mod contact_solve;
pub mod contact_write;
pub mod integrate;
pub mod pair_write;
pub mod warm_start;

use glam::DVec3;
use rayon::prelude::*;

/// Rows that one task handles.
pub const PIECE: usize = 1024;

/// An axis-aligned box, m, world.
#[derive(Clone, Copy, Debug, Default)]
pub struct Aabb {
    /// Least corner.
    pub min: DVec3,
    /// Greatest corner.
    pub max: DVec3,
}

impl Aabb {
    /// Whether two boxes share a point.
    #[inline]
    pub fn overlaps(&self, other: &Aabb) -> bool {
        self.min.cmple(other.max).all() && other.min.cmple(self.max).all()
    }
}

/// Fill `out[i] = f(i)` in parallel.
pub fn fill_rows<T: Send>(out: &mut [T], f: impl Fn(usize) -> T + Sync) {
    let body = |(piece, rows): (usize, &mut [T])| {
        for (i, row) in rows.iter_mut().enumerate() {
            *row = f(piece * PIECE + i);
        }
    };
    if out.len() <= 2 * PIECE {
        out.chunks_mut(PIECE).enumerate().for_each(body);
    } else {
        out.par_chunks_mut(PIECE).enumerate().for_each(body);
    }
}

/// Write each row `i`'s own values to `out[start[i]..start[i+1]]` in parallel; `start` rises and ends at `out.len()`.
pub fn scatter_rows<T: Send>(out: &mut [T], start: &[u32], f: impl Fn(usize, &mut [T]) + Sync) {
    let n = start.len() - 1;
    let mut pieces: Vec<(usize, &mut [T])> = Vec::with_capacity(n.div_ceil(PIECE));
    let mut rest = out;
    for first in (0..n).step_by(PIECE) {
        let last = (first + PIECE).min(n);
        let (own, after) = rest.split_at_mut((start[last] - start[first]) as usize);
        pieces.push((first, own));
        rest = after;
    }
    pieces.into_par_iter().for_each(|(first, mut own)| {
        for i in first..(first + PIECE).min(n) {
            let (row, after) = own.split_at_mut((start[i + 1] - start[i]) as usize);
            f(i, row);
            own = after;
        }
    });
}
