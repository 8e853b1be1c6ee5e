//! Dense elimination of a supernode's rows, in lanes of four rows. A front has its columns by tiles of four rows: tile t has the columns
//! 0, 1, … with four numbers each, so that every loop reads contiguous numbers. Own columns and those of the border are apart: the
//! panel, (own + border) × own, becomes the supernode's part of the factor, the update, border × border, goes to the parent. Of both,
//! the lower triangle counts.
//!
//! S = L Lᵀ. In place of the 4 × 4 triangles on its diagonal L has their inverses: solving is multiplying.

use super::supernodes::TILE;
use crate::lanes::{LaneLoop, Lanes4, four, four_mut};

/// Numbers of a tile.
const SQUARE: usize = TILE * TILE;

/// The elimination of a front.
pub struct Eliminate<'a> {
    /// The panel.
    pub panel: &'a mut [f64],
    /// The update.
    pub update: &'a mut [f64],
    /// Own rows and those of the border.
    pub own: usize,
    pub border: usize,
    /// Pivots below it are raised to it.
    pub min_pivot: f64,
}

impl LaneLoop for Eliminate<'_> {
    type Out = ();
    #[inline(always)]
    fn run<V: Lanes4>(self) {
        let Eliminate { panel, update, own, border, min_pivot } = self;
        let (n_own, n) = (own / TILE, (own + border) / TILE);
        let width = own * TILE;
        let mut t = 0;
        while t < n {
            let is_own = t < n_own;
            let rows = if is_own { n_own - t } else { n - t }.min(3);
            let (above, block) = panel.split_at_mut(t * width);
            let done = if is_own { t } else { n_own };
            match rows {
                3 => columns::<V, 3>(above, block, width, done),
                2 => columns::<V, 2>(above, block, width, done),
                _ => columns::<V, 1>(above, block, width, done),
            }
            if is_own {
                corner::<V>(block, width, t, rows, min_pivot);
            }
            t += rows;
        }
        let panel = &panel[n_own * width..];
        let mut t = 0;
        while t < n - n_own {
            let rows = (n - n_own - t).min(3);
            let block = &mut update[t * border * TILE..];
            match rows {
                3 => products::<V, 3>(panel, block, (width, border), t),
                2 => products::<V, 2>(panel, block, (width, border), t),
                _ => products::<V, 1>(panel, block, (width, border), t),
            }
            t += rows;
        }
    }
}

/// R tiles of rows by four columns, in registers.
type Block<V, const R: usize> = [[V; TILE]; R];

/// Subtract from a block the products of R tiles of rows with a tile of rows, over their first columns, as many as `column` has.
#[inline(always)]
fn subtract<V: Lanes4, const R: usize>(c: &mut Block<V, R>, rows: [&[f64]; R], column: &[f64]) {
    let column = column.as_chunks::<TILE>().0;
    let n = column.len();
    let mut of_row: [&[[f64; TILE]]; R] = [&[]; R];
    for r in 0..R {
        of_row[r] = &rows[r].as_chunks::<TILE>().0[..n];
    }
    for k in 0..n {
        let mut a = [V::splat(0.0); R];
        for r in 0..R {
            a[r] = V::load(&of_row[r][k]);
        }
        for l in 0..TILE {
            let b = V::splat(column[k][l]);
            for r in 0..R {
                c[r][l] = c[r][l] - a[r] * b;
            }
        }
    }
}

/// Tiles of R rows of tiles, `stride` numbers apart.
#[inline(always)]
fn load<V: Lanes4, const R: usize>(block: &[f64], stride: usize) -> Block<V, R> {
    let mut c = [[V::splat(0.0); TILE]; R];
    for r in 0..R {
        for l in 0..TILE {
            c[r][l] = V::load(four(block, r * stride + l * TILE));
        }
    }
    c
}

#[inline(always)]
fn store<V: Lanes4>(tile: &mut [f64], c: [V; TILE]) {
    for l in 0..TILE {
        *four_mut(tile, l * TILE) = c[l].to_array();
    }
}

/// The first `width` numbers of R rows of tiles, `stride` numbers apart.
#[inline(always)]
fn rows_of<const R: usize>(block: &[f64], stride: usize, width: usize) -> [&[f64]; R] {
    let mut rows: [&[f64]; R] = [&[]; R];
    for r in 0..R {
        rows[r] = &block[r * stride..][..width];
    }
    rows
}

/// Eliminate the first `done` tiles of columns from R tiles of rows, `block`; the rows of these columns are `above`.
#[inline(always)]
fn columns<V: Lanes4, const R: usize>(above: &[f64], block: &mut [f64], width: usize, done: usize) {
    for j in 0..done {
        let at = j * SQUARE;
        let column = &above[j * width..][..at + SQUARE];
        let (column, inverse) = column.split_at(at);
        let mut c: Block<V, R> = load(&block[at..], width);
        subtract(&mut c, rows_of(block, width, at), column);
        for r in 0..R {
            store(&mut block[r * width + at..], divided(c[r], inverse));
        }
    }
}

/// A tile of rows over the triangle whose inverse is given.
#[inline(always)]
fn divided<V: Lanes4>(c: [V; TILE], inverse: &[f64]) -> [V; TILE] {
    let mut x = c;
    for l in 0..TILE {
        x[l] = c[0] * V::splat(inverse[l]);
        for m in 1..=l {
            x[l] = x[l] + c[m] * V::splat(inverse[m * TILE + l]);
        }
    }
    x
}

/// Eliminate the columns of up to three tiles of rows, `block`, from themselves: their own ones, from tile t on.
#[inline(always)]
fn corner<V: Lanes4>(block: &mut [f64], width: usize, t: usize, rows: usize, min_pivot: f64) {
    for r in 0..rows {
        let (above, row) = block.split_at_mut(r * width);
        for q in 0..=r {
            let at = (t + q) * SQUARE;
            let mut c: Block<V, 1> = load(&row[at..], width);
            if q < r {
                let (column, inverse) = above[q * width..][..at + SQUARE].split_at(at);
                subtract(&mut c, [&row[..at]], column);
                store(&mut row[at..], divided(c[0], inverse));
            } else {
                subtract(&mut c, [&row[..at]], &row[..at]);
                store(&mut row[at..], c[0]);
                invert(four_tile(row, at), min_pivot);
            }
        }
    }
}

#[inline(always)]
fn four_tile(row: &mut [f64], at: usize) -> &mut [f64; SQUARE] {
    (&mut row[at..at + SQUARE]).try_into().expect("a tile")
}

/// Replace a tile on the diagonal, A = T Tᵀ, by the inverse of T.
#[inline(always)]
fn invert(a: &mut [f64; SQUARE], min_pivot: f64) {
    let at = |i: usize, j: usize| j * TILE + i;
    let mut t = [0.0; SQUARE];
    let mut reciprocal = [0.0; TILE];
    for j in 0..TILE {
        let mut d = a[at(j, j)];
        for k in 0..j {
            d -= t[at(j, k)] * t[at(j, k)];
        }
        reciprocal[j] = 1.0 / d.max(min_pivot).sqrt();
        for i in j + 1..TILE {
            let mut x = a[at(i, j)];
            for k in 0..j {
                x -= t[at(i, k)] * t[at(j, k)];
            }
            t[at(i, j)] = x * reciprocal[j];
        }
    }
    *a = [0.0; SQUARE];
    for j in 0..TILE {
        a[at(j, j)] = reciprocal[j];
        for i in j + 1..TILE {
            let mut x = 0.0;
            for k in j..i {
                x -= t[at(i, k)] * a[at(k, j)];
            }
            a[at(i, j)] = x * reciprocal[i];
        }
    }
}

/// Subtract from R tiles of the update's rows, `block`, from tile t on, the products of the border's rows.
#[inline(always)]
fn products<V: Lanes4, const R: usize>(panel: &[f64], block: &mut [f64], (width, border): (usize, usize), t: usize) {
    let rows = rows_of::<R>(&panel[t * width..], width, width);
    for j in 0..t + R {
        let column = &panel[j * width..][..width];
        let at = j * SQUARE;
        let mut c: Block<V, R> = load(&block[at..], border * TILE);
        subtract(&mut c, rows, column);
        for r in 0..R {
            store(&mut block[r * border * TILE + at..], c[r]);
        }
    }
}

/// Solve L y = b for a supernode's rows: `own` has b and becomes y, `change` what y changes of the border's rows.
#[inline(always)]
pub fn forward<V: Lanes4>(panel: &[f64], own: &mut [f64], change: &mut [f64]) {
    let width = own.len() * TILE;
    let n_own = own.len() / TILE;
    for t in 0..n_own {
        let (done, rest) = own.split_at_mut(t * TILE);
        let row = &panel[t * width..][..(t + 1) * SQUARE];
        let (row, inverse) = row.split_at(t * SQUARE);
        let b = product::<V>(V::load(four(rest, 0)), row, done).to_array();
        let mut y = V::load(four(inverse, 0)) * V::splat(b[0]);
        for l in 1..TILE {
            y = y + V::load(four(inverse, l * TILE)) * V::splat(b[l]);
        }
        *four_mut(rest, 0) = y.to_array();
    }
    for t in 0..change.len() / TILE {
        let row = &panel[(n_own + t) * width..][..width];
        *four_mut(change, t * TILE) = product::<V>(V::splat(0.0), row, own).to_array();
    }
}

/// b − (a tile of rows) x, in two sums.
#[inline(always)]
fn product<V: Lanes4>(b: V, row: &[f64], x: &[f64]) -> V {
    let (mut even, mut odd) = (b, V::splat(0.0));
    for (a, x) in row.chunks_exact(SQUARE).zip(x.chunks_exact(TILE)) {
        even = even - V::load(four(a, 0)) * V::splat(x[0]);
        odd = odd - V::load(four(a, TILE)) * V::splat(x[1]);
        even = even - V::load(four(a, 2 * TILE)) * V::splat(x[2]);
        odd = odd - V::load(four(a, 3 * TILE)) * V::splat(x[3]);
    }
    even + odd
}

/// Solve Lᵀ x = y for a supernode's rows: `own` has y and becomes x; `at_border` has x of the border's rows. `sums` is scratch.
#[inline(always)]
pub fn backward<V: Lanes4>(panel: &[f64], own: &mut [f64], at_border: &[f64], sums: &mut [[f64; TILE]]) {
    let width = own.len() * TILE;
    let n_own = own.len() / TILE;
    let sums = &mut sums[..own.len()];
    sums.fill([0.0; TILE]);
    let mut tiles = panel[n_own * width..].chunks_exact(2 * width).zip(at_border.chunks_exact(2 * TILE));
    for (rows, x) in &mut tiles {
        let (first, second) = rows.split_at(width);
        let (x, z) = (V::load(four(x, 0)), V::load(four(x, TILE)));
        for ((sum, a), b) in sums.iter_mut().zip(first.chunks_exact(TILE)).zip(second.chunks_exact(TILE)) {
            *sum = (V::load(sum) - V::load(four(a, 0)) * x - V::load(four(b, 0)) * z).to_array();
        }
    }
    if !at_border.len().is_multiple_of(2 * TILE) {
        let x = V::load(four(at_border, at_border.len() - TILE));
        let row = &panel[panel.len() - width..];
        for (sum, a) in sums.iter_mut().zip(row.chunks_exact(TILE)) {
            *sum = (V::load(sum) - V::load(four(a, 0)) * x).to_array();
        }
    }
    for t in (0..n_own).rev() {
        let row = &panel[t * width..][..(t + 1) * SQUARE];
        let (row, inverse) = row.split_at(t * SQUARE);
        let (before, mine) = own.split_at_mut(t * TILE);
        let mut y = [0.0; TILE];
        for l in 0..TILE {
            y[l] = mine[l] + all(&sums[t * TILE + l]);
        }
        let y = V::load(&y);
        for l in 0..TILE {
            mine[l] = all(&(V::load(four(inverse, l * TILE)) * y).to_array());
        }
        let x = V::load(four(mine, 0));
        for (sum, a) in sums[..before.len()].iter_mut().zip(row.chunks_exact(TILE)) {
            *sum = (V::load(sum) - V::load(four(a, 0)) * x).to_array();
        }
    }
}

/// The sum of four numbers.
#[inline(always)]
fn all(s: &[f64; TILE]) -> f64 {
    (s[0] + s[2]) + (s[1] + s[3])
}
