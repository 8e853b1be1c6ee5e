//! Parallel loops over rows that give the same bits for any number of threads: rows are split into chunks of fixed length, and the
//! sums of the chunks are reduced in order.

use rayon::prelude::*;

/// Rows of a chunk, the work of one task.
pub const CHUNK: usize = 256;

/// Rows up to which a loop is serial: tasks would cost more than they save.
pub const SERIAL_LIMIT: usize = 16 * CHUNK;

/// Fill `out[i] = f(i)` in parallel.
pub fn fill_rows<T: Send>(out: &mut [T], f: impl Fn(usize) -> T + Sync) {
    let body = |(chunk, rows): (usize, &mut [T])| {
        for (i, row) in rows.iter_mut().enumerate() {
            *row = f(chunk * CHUNK + i);
        }
    };
    if out.len() <= SERIAL_LIMIT {
        out.chunks_mut(CHUNK).enumerate().for_each(body);
    } else {
        out.par_chunks_mut(CHUNK).enumerate().for_each(body);
    }
}

/// Sum `f(i)` over the rows, chunk by chunk in order.
pub fn sum_rows<const K: usize>(n: usize, f: impl Fn(usize) -> [f64; K] + Sync) -> [f64; K] {
    let chunk = |c: usize| (c * CHUNK..((c + 1) * CHUNK).min(n)).fold([0.0; K], |sum, i| add(sum, f(i)));
    let n_chunks = n.div_ceil(CHUNK);
    if n <= SERIAL_LIMIT {
        return (0..n_chunks).map(chunk).fold([0.0; K], add);
    }
    let parts: Vec<[f64; K]> = (0..n_chunks).into_par_iter().map(chunk).collect();
    parts.into_iter().fold([0.0; K], add)
}

/// Fold the rows of each chunk of a column, `row(sum, i, column[i])`, and merge the chunks in order.
pub fn fold_rows<T: Send, U: Send>(
    column: &mut [U],
    start: impl Fn() -> T + Sync,
    row: impl Fn(T, usize, &mut U) -> T + Sync,
    merge: impl Fn(T, T) -> T,
) -> T {
    let is_serial = column.len() <= SERIAL_LIMIT;
    let body = |(chunk, rows): (usize, &mut [U])| {
        rows.iter_mut().enumerate().fold(start(), |sum, (k, value)| row(sum, chunk * CHUNK + k, value))
    };
    if is_serial {
        return column.chunks_mut(CHUNK).enumerate().map(body).fold(start(), merge);
    }
    let parts: Vec<T> = column.par_chunks_mut(CHUNK).enumerate().map(body).collect();
    parts.into_iter().fold(start(), merge)
}

/// Run `f(first row, rows)` on the chunks of a column and sum what they return, in order.
pub fn reduce_chunks<T: Send, const K: usize>(
    out: &mut [T],
    f: impl Fn(usize, &mut [T]) -> [f64; K] + Sync,
) -> [f64; K] {
    let is_serial = out.len() <= SERIAL_LIMIT;
    let body = |(chunk, rows): (usize, &mut [T])| f(chunk * CHUNK, rows);
    if is_serial {
        return out.chunks_mut(CHUNK).enumerate().map(body).fold([0.0; K], add);
    }
    let parts: Vec<[f64; K]> = out.par_chunks_mut(CHUNK).enumerate().map(body).collect();
    parts.into_iter().fold([0.0; K], add)
}

/// Run `f(first row, rows, rows)` on the chunks of two columns of one length, as [`reduce_chunks`].
pub fn reduce_chunks_of_two<T: Send, U: Send, const K: usize>(
    a: &mut [T],
    b: &mut [U],
    f: impl Fn(usize, &mut [T], &mut [U]) -> [f64; K] + Sync,
) -> [f64; K] {
    let is_serial = a.len() <= SERIAL_LIMIT;
    let body = |(chunk, (a, b)): (usize, (&mut [T], &mut [U]))| f(chunk * CHUNK, a, b);
    if is_serial {
        return a.chunks_mut(CHUNK).zip(b.chunks_mut(CHUNK)).enumerate().map(body).fold([0.0; K], add);
    }
    let parts: Vec<[f64; K]> = a.par_chunks_mut(CHUNK).zip(b.par_chunks_mut(CHUNK)).enumerate().map(body).collect();
    parts.into_iter().fold([0.0; K], add)
}

/// Run independent tasks, in parallel unless `is_serial`, and sum what they return, in order.
pub fn reduce_tasks<T: Send, const K: usize>(
    tasks: impl IndexedParallelIterator<Item = T>,
    is_serial: bool,
    visit: impl Fn(T) -> [f64; K] + Send + Sync,
) -> [f64; K] {
    let min_len = if is_serial { tasks.len().max(1) } else { 1 };
    let parts: Vec<[f64; K]> = tasks.with_min_len(min_len).map(visit).collect();
    parts.into_iter().fold([0.0; K], add)
}

/// Componentwise sum.
#[inline]
pub fn add<const K: usize>(mut a: [f64; K], b: [f64; K]) -> [f64; K] {
    for k in 0..K {
        a[k] += b[k];
    }
    a
}

/// Split a column into consecutive slices of given lengths.
pub fn cut<T>(mut column: &mut [T], lengths: impl IntoIterator<Item = usize>) -> Vec<&mut [T]> {
    let part = |n| {
        let (own, rest) = std::mem::take(&mut column).split_at_mut(n);
        column = rest;
        own
    };
    lengths.into_iter().map(part).collect()
}

/// Write the values of each row `i` to `out[start[i]..start[i+1]]` in parallel; `start` ascends and ends at `out.len()`.
pub fn scatter_rows<T: Send>(out: &mut [T], start: &[u32], f: impl Fn(usize, &mut [T]) + Sync) {
    let n = start.len() - 1;
    let mut chunks: Vec<(usize, &mut [T])> = Vec::with_capacity(n.div_ceil(CHUNK));
    let mut rest = out;
    for first in (0..n).step_by(CHUNK) {
        let last = (first + CHUNK).min(n);
        let (own, after) = rest.split_at_mut((start[last] - start[first]) as usize);
        chunks.push((first, own));
        rest = after;
    }
    chunks.into_par_iter().for_each(|(first, mut own)| {
        for i in first..(first + CHUNK).min(n) {
            let (row, after) = own.split_at_mut((start[i + 1] - start[i]) as usize);
            f(i, row);
            own = after;
        }
    });
}
