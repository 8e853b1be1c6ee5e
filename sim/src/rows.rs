//! Parallel loops over rows that give the same bits for any number of threads: rows are cut into pieces of fixed length, and sums go
//! over the pieces in order.

use rayon::prelude::*;

/// Rows that one task handles.
pub const CHUNK: usize = 1024;

/// Rows below which one thread does the work: handing it out would cost more.
pub const ALONE: usize = 4 * CHUNK;

/// Fill `out[i] = f(i)` in parallel.
pub fn fill_rows<T: Send>(out: &mut [T], f: impl Fn(usize) -> T + Sync) {
    let body = |(piece, rows): (usize, &mut [T])| {
        for (i, row) in rows.iter_mut().enumerate() {
            *row = f(piece * CHUNK + i);
        }
    };
    if out.len() <= ALONE {
        out.chunks_mut(CHUNK).enumerate().for_each(body);
    } else {
        out.par_chunks_mut(CHUNK).enumerate().for_each(body);
    }
}

/// Sum `f(i)` over the rows, piece by piece in order.
pub fn sum_rows<const K: usize>(n: usize, f: impl Fn(usize) -> [f64; K] + Sync) -> [f64; K] {
    let piece = |p: usize| (p * CHUNK..((p + 1) * CHUNK).min(n)).fold([0.0; K], |sum, i| add(sum, f(i)));
    let n_pieces = n.div_ceil(CHUNK);
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
        rows.iter_mut().enumerate().fold(start(), |sum, (k, value)| row(sum, piece * CHUNK + k, value))
    };
    if is_little {
        return column.chunks_mut(CHUNK).enumerate().map(body).fold(start(), merge);
    }
    let parts: Vec<T> = column.par_chunks_mut(CHUNK).enumerate().map(body).collect();
    parts.into_iter().fold(start(), merge)
}

/// Run `f(first row, rows)` on pieces of a column and add up what they return, in order.
pub fn sweep<T: Send, const K: usize>(out: &mut [T], f: impl Fn(usize, &mut [T]) -> [f64; K] + Sync) -> [f64; K] {
    let alone = out.len() <= ALONE;
    let body = |(piece, rows): (usize, &mut [T])| f(piece * CHUNK, rows);
    if alone {
        return out.chunks_mut(CHUNK).enumerate().map(body).fold([0.0; K], add);
    }
    let parts: Vec<[f64; K]> = out.par_chunks_mut(CHUNK).enumerate().map(body).collect();
    parts.into_iter().fold([0.0; K], add)
}

/// As [`sweep`], on two columns of one length.
pub fn sweep_two<T: Send, U: Send, const K: usize>(
    a: &mut [T],
    b: &mut [U],
    f: impl Fn(usize, &mut [T], &mut [U]) -> [f64; K] + Sync,
) -> [f64; K] {
    let alone = a.len() <= ALONE;
    let body = |(piece, (a, b)): (usize, (&mut [T], &mut [U]))| f(piece * CHUNK, a, b);
    if alone {
        return a.chunks_mut(CHUNK).zip(b.chunks_mut(CHUNK)).enumerate().map(body).fold([0.0; K], add);
    }
    let parts: Vec<[f64; K]> = a.par_chunks_mut(CHUNK).zip(b.par_chunks_mut(CHUNK)).enumerate().map(body).collect();
    parts.into_iter().fold([0.0; K], add)
}

/// Visit tasks that share no body, side by side unless there is little to do; sums in order.
pub fn reduce_tasks<T: Send, const K: usize>(
    tasks: impl IndexedParallelIterator<Item = T>,
    is_little: bool,
    visit: impl Fn(T) -> [f64; K] + Send + Sync,
) -> [f64; K] {
    let least = if is_little { tasks.len().max(1) } else { 1 };
    let parts: Vec<[f64; K]> = tasks.with_min_len(least).map(visit).collect();
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
    let mut pieces: Vec<(usize, &mut [T])> = Vec::with_capacity(n.div_ceil(CHUNK));
    let mut rest = out;
    for first in (0..n).step_by(CHUNK) {
        let last = (first + CHUNK).min(n);
        let (own, after) = rest.split_at_mut((start[last] - start[first]) as usize);
        pieces.push((first, own));
        rest = after;
    }
    pieces.into_par_iter().for_each(|(first, mut own)| {
        for i in first..(first + CHUNK).min(n) {
            let (row, after) = own.split_at_mut((start[i + 1] - start[i]) as usize);
            f(i, row);
            own = after;
        }
    });
}
