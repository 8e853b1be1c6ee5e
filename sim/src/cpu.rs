//! The CPU back end: one file a stage, over the columns of the model and the state. [`crate::stages`] has their order.
//!
//! Every stage that runs in parallel cuts its rows into pieces of fixed length, so that results are the same bits for any
//! number of threads.

mod ball_pairs;
pub mod bin_emit;
pub mod bin_start;
pub mod bounds;
pub mod collide;
mod contact_rows;
pub mod contact_solve;
pub mod contact_write;
pub mod force;
pub mod integrate;
pub mod joint_write;
pub mod pair_write;
pub mod warm_start;

use glam::{DVec3, Vec3A};
use rayon::prelude::*;

/// Rows that one task handles.
pub const PIECE: usize = 1024;

/// An axis-aligned box, m, world, rounded outwards to single precision: four numbers are compared at once.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Aabb {
    /// Least corner.
    pub min: Vec3A,
    /// Greatest corner.
    pub max: Vec3A,
}

impl Aabb {
    /// The box about a centre.
    #[inline]
    pub fn about(centre: DVec3, half: DVec3) -> Aabb {
        /// More than the rounding of a number to single precision.
        const ROUNDING: f32 = 1.2e-7;
        let (min, max) = ((centre - half).as_vec3a(), (centre + half).as_vec3a());
        Aabb { min: min - min.abs() * ROUNDING, max: max + max.abs() * ROUNDING }
    }

    /// A box that overlaps none.
    pub const EMPTY: Aabb = Aabb { min: Vec3A::INFINITY, max: Vec3A::NEG_INFINITY };

    /// Whether another box is inside; an empty one always is.
    #[inline]
    pub fn holds(&self, other: &Aabb) -> bool {
        (self.min.cmple(other.min) & other.max.cmple(self.max)).all()
    }

    /// Whether two boxes share a point.
    #[inline]
    pub fn overlaps(&self, other: &Aabb) -> bool {
        (self.min.cmple(other.max) & other.min.cmple(self.max)).all()
    }
}

/// Rows below which one thread does the work: handing it out would cost more.
pub const ALONE: usize = 4 * PIECE;

/// Fill `out[i] = f(i)` in parallel.
pub fn fill_rows<T: Send>(out: &mut [T], f: impl Fn(usize) -> T + Sync) {
    let body = |(piece, rows): (usize, &mut [T])| {
        for (i, row) in rows.iter_mut().enumerate() {
            *row = f(piece * PIECE + i);
        }
    };
    if out.len() <= ALONE {
        out.chunks_mut(PIECE).enumerate().for_each(body);
    } else {
        out.par_chunks_mut(PIECE).enumerate().for_each(body);
    }
}

/// Sum `f(i)` over the rows, piece by piece in order.
pub fn sum_rows<const K: usize>(n: usize, f: impl Fn(usize) -> [f64; K] + Sync) -> [f64; K] {
    let piece = |p: usize| (p * PIECE..((p + 1) * PIECE).min(n)).fold([0.0; K], |sum, i| add(sum, f(i)));
    let n_pieces = n.div_ceil(PIECE);
    if n <= ALONE {
        return (0..n_pieces).map(piece).fold([0.0; K], add);
    }
    let parts: Vec<[f64; K]> = (0..n_pieces).into_par_iter().map(piece).collect();
    parts.into_iter().fold([0.0; K], add)
}

/// Fold the rows of each piece of a column, `row(sum, i, column[i])`, and merge the pieces in order.
pub fn fold_rows<T: Send, U: Send>(
    column: &mut [U],
    start: impl Fn() -> T + Sync,
    row: impl Fn(T, usize, &mut U) -> T + Sync,
    merge: impl Fn(T, T) -> T,
) -> T {
    let is_little = column.len() <= ALONE;
    let body = |(piece, rows): (usize, &mut [U])| {
        rows.iter_mut().enumerate().fold(start(), |sum, (k, value)| row(sum, piece * PIECE + k, value))
    };
    if is_little {
        return column.chunks_mut(PIECE).enumerate().map(body).fold(start(), merge);
    }
    let parts: Vec<T> = column.par_chunks_mut(PIECE).enumerate().map(body).collect();
    parts.into_iter().fold(start(), merge)
}

/// Run `f(first row, rows)` on pieces of a column and add up what they return, in order.
pub fn sweep<T: Send, const K: usize>(out: &mut [T], f: impl Fn(usize, &mut [T]) -> [f64; K] + Sync) -> [f64; K] {
    let alone = out.len() <= ALONE;
    let body = |(piece, rows): (usize, &mut [T])| f(piece * PIECE, rows);
    if alone {
        return out.chunks_mut(PIECE).enumerate().map(body).fold([0.0; K], add);
    }
    let parts: Vec<[f64; K]> = out.par_chunks_mut(PIECE).enumerate().map(body).collect();
    parts.into_iter().fold([0.0; K], add)
}

/// As [`sweep`], on two columns of one length.
pub fn sweep_two<T: Send, U: Send, const K: usize>(
    a: &mut [T],
    b: &mut [U],
    f: impl Fn(usize, &mut [T], &mut [U]) -> [f64; K] + Sync,
) -> [f64; K] {
    let alone = a.len() <= ALONE;
    let body = |(piece, (a, b)): (usize, (&mut [T], &mut [U]))| f(piece * PIECE, a, b);
    if alone {
        return a.chunks_mut(PIECE).zip(b.chunks_mut(PIECE)).enumerate().map(body).fold([0.0; K], add);
    }
    let parts: Vec<[f64; K]> = a.par_chunks_mut(PIECE).zip(b.par_chunks_mut(PIECE)).enumerate().map(body).collect();
    parts.into_iter().fold([0.0; K], add)
}

/// The sums of two rows of sums.
#[inline]
pub fn add<const K: usize>(mut a: [f64; K], b: [f64; K]) -> [f64; K] {
    for k in 0..K {
        a[k] += b[k];
    }
    a
}

/// Cut a column into parts of these lengths.
pub fn cut<T>(mut column: &mut [T], lengths: impl IntoIterator<Item = usize>) -> Vec<&mut [T]> {
    let part = |n| {
        let (own, rest) = std::mem::take(&mut column).split_at_mut(n);
        column = rest;
        own
    };
    lengths.into_iter().map(part).collect()
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
