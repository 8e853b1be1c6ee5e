//! LU factorisation of dense matrices with row interchanges, by panels of columns.

use crate::lanes::{LaneLoop, Lanes4, four, four_mut, widest};
use rayon::prelude::*;
use std::ops::Range;

/// Columns of a panel: the rows of one fit in the second cache.
const PANEL: usize = 32;
/// Columns that are updated at once.
const TILE: usize = 256;

/// A factorised matrix of n rows.
pub struct Lu {
    n: usize,
    /// L below the diagonal, whose own diagonal is 1, and U, by rows (n × n).
    factors: Vec<f64>,
    /// The row of the matrix that became each row (n).
    order: Vec<usize>,
}

impl Lu {
    /// Factorise a matrix, given by rows (n × n); none for one that is singular or not finite.
    pub fn new(n: usize, mut a: Vec<f64>) -> Option<Lu> {
        let mut order: Vec<usize> = (0..n).collect();
        for first in (0..n).step_by(PANEL) {
            let panel = first..(first + PANEL).min(n);
            factorise_panel(&mut a, n, panel.clone(), &mut order)?;
            let (above, below) = a.split_at_mut(panel.end * n);
            let pivots = &mut above[first * n..];
            for i in 1..panel.len() {
                let (done, own) = pivots.split_at_mut(i * n);
                eliminate(&mut own[..n], done, n, first..first + i, panel.end);
            }
            let pivots = &*pivots;
            let rows = below.par_chunks_mut(n).with_min_len(16);
            rows.for_each(|row| eliminate(row, pivots, n, panel.clone(), panel.end));
        }
        Some(Lu { n, factors: a, order })
    }

    /// The sign of the determinant: 1 or −1.
    pub fn sign(&self) -> f64 {
        let negative = (0..self.n).filter(|i| self.factors[i * self.n + i] < 0.0).count();
        // A permutation is odd if its number of rows less that of its cycles is.
        let (mut seen, mut cycles) = (vec![false; self.n], 0);
        for first in 0..self.n {
            let mut at = first;
            cycles += usize::from(!seen[at]);
            while !std::mem::replace(&mut seen[at], true) {
                at = self.order[at];
            }
        }
        if (negative + self.n - cycles).is_multiple_of(2) { 1.0 } else { -1.0 }
    }

    /// Solve: the right-hand side becomes the solution (n).
    pub fn solve(&self, x: &mut [f64]) {
        let mut y: Vec<f64> = self.order.iter().map(|i| x[*i]).collect();
        let dot = |row: &[f64], y: &[f64]| row.iter().zip(y).map(|(a, b)| a * b).sum::<f64>();
        for (i, row) in self.factors.chunks(self.n.max(1)).enumerate() {
            y[i] -= dot(&row[..i], &y);
        }
        for (i, row) in self.factors.chunks(self.n.max(1)).enumerate().rev() {
            y[i] = (y[i] - dot(&row[i + 1..], &y[i + 1..])) / row[i];
        }
        x.copy_from_slice(&y);
    }
}

/// Factorise the columns of a panel, from its first row down.
fn factorise_panel(a: &mut [f64], n: usize, panel: Range<usize>, order: &mut [usize]) -> Option<()> {
    for k in panel.clone() {
        let size = |i: usize| a[i * n + k].abs();
        let pivot = (k..n).fold(k, |best, i| if size(i) > size(best) { i } else { best });
        if !(size(pivot) > 0.0) || !size(pivot).is_finite() {
            return None;
        }
        if pivot != k {
            let (above, below) = a.split_at_mut(pivot * n);
            above[k * n..(k + 1) * n].swap_with_slice(&mut below[..n]);
            order.swap(k, pivot);
        }
        let (above, below) = a.split_at_mut((k + 1) * n);
        let row = &above[k * n..];
        for other in below.chunks_mut(n) {
            let factor = other[k] / row[k];
            other[k] = factor;
            let columns = k + 1..panel.end;
            other[columns.clone()].iter_mut().zip(&row[columns]).for_each(|(x, y)| *x -= factor * y);
        }
    }
    Some(())
}

/// Subtract from the columns `from..` of a row the pivot rows of some columns, times the row's factors there.
fn eliminate(row: &mut [f64], pivots: &[f64], n: usize, columns: Range<usize>, from: usize) {
    let (factors, rest) = row.split_at_mut(from);
    widest(Elimination { factors: &factors[columns], rest, pivots, n, from });
}

/// The arguments of [`eliminate`].
struct Elimination<'a> {
    factors: &'a [f64],
    rest: &'a mut [f64],
    pivots: &'a [f64],
    n: usize,
    from: usize,
}

impl LaneLoop for Elimination<'_> {
    type Out = ();

    #[inline(always)]
    fn run<V: Lanes4>(self) {
        for (t, tile) in self.rest.chunks_mut(TILE).enumerate() {
            let mut p = 0;
            while p < self.factors.len() {
                let rows = [0, 1, 2, 3].map(|i| {
                    let place = (p + i).min(self.factors.len() - 1) * self.n + self.from + t * TILE;
                    &self.pivots[place..place + tile.len()]
                });
                if p + 4 <= self.factors.len() {
                    subtract4::<V>(tile, rows, four(self.factors, p));
                    p += 4;
                } else {
                    subtract::<V>(tile, rows[0], self.factors[p]);
                    p += 1;
                }
            }
        }
    }
}

/// x −= (f₀ a + f₁ b) + (f₂ c + f₃ d).
#[inline(always)]
fn subtract4<V: Lanes4>(x: &mut [f64], [a, b, c, d]: [&[f64]; 4], f: &[f64; 4]) {
    let [fa, fb, fc, fd] = [V::splat(f[0]), V::splat(f[1]), V::splat(f[2]), V::splat(f[3])];
    let whole = x.len() / 4 * 4;
    let mut k = 0;
    while k < whole {
        let sum = (fa * V::load(four(a, k)) + fb * V::load(four(b, k)))
            + (fc * V::load(four(c, k)) + fd * V::load(four(d, k)));
        *four_mut(x, k) = (V::load(four(x, k)) - sum).to_array();
        k += 4;
    }
    for k in whole..x.len() {
        x[k] -= (f[0] * a[k] + f[1] * b[k]) + (f[2] * c[k] + f[3] * d[k]);
    }
}

/// x −= f a.
#[inline(always)]
fn subtract<V: Lanes4>(x: &mut [f64], a: &[f64], f: f64) {
    let whole = x.len() / 4 * 4;
    let mut k = 0;
    while k < whole {
        *four_mut(x, k) = (V::load(four(x, k)) - V::splat(f) * V::load(four(a, k))).to_array();
        k += 4;
    }
    for k in whole..x.len() {
        x[k] -= f * a[k];
    }
}

#[cfg(test)]
mod tests {
    use super::Lu;
    use crate::fill::SplitMix64;

    #[test]
    fn random_systems_have_their_solutions() {
        for n in [1, 2, 31, 32, 33, 100, 300] {
            let mut random = SplitMix64(n as u64);
            let a: Vec<f64> = (0..n * n).map(|_| random.between(-1.0, 1.0)).collect();
            let x: Vec<f64> = (0..n).map(|_| random.between(-1.0, 1.0)).collect();
            let mut b: Vec<f64> = a.chunks(n).map(|row| row.iter().zip(&x).map(|(a, x)| a * x).sum()).collect();
            Lu::new(n, a).unwrap().solve(&mut b);
            b.iter().zip(&x).for_each(|(b, x)| assert!((b - x).abs() < 1e-9, "{n}: {b}, expected {x}"));
        }
    }

    #[test]
    fn the_sign_is_that_of_the_determinant() {
        let sign = |a: &[f64]| Lu::new(a.len().isqrt(), a.to_vec()).unwrap().sign();
        assert_eq!(sign(&[2.0]), 1.0);
        assert_eq!(sign(&[-2.0]), -1.0);
        assert_eq!(sign(&[0.0, 1.0, 1.0, 0.0]), -1.0);
        // Even and odd permutations, with one negative number.
        assert_eq!(sign(&[0.0, 1.0, 0.0, 0.0, 0.0, -3.0, 1.0, 0.0, 0.0]), -1.0);
        assert_eq!(sign(&[1.0, 0.0, 0.0, 0.0, 0.0, -3.0, 0.0, 1.0, 0.0]), 1.0);
        // Rows that trade places change it.
        let mut random = SplitMix64(5);
        let mut a: Vec<f64> = (0..50 * 50).map(|_| random.between(-1.0, 1.0)).collect();
        let before = sign(&a);
        let (above, below) = a.split_at_mut(50 * 20);
        above[..50].swap_with_slice(&mut below[..50]);
        assert_eq!(sign(&a), -before);
    }

    #[test]
    fn what_is_singular_has_no_factors() {
        assert!(Lu::new(2, vec![1.0, 2.0, 0.0, 0.0]).is_none());
        assert!(Lu::new(2, vec![1.0, f64::NAN, f64::NAN, 1.0]).is_none());
        // No pivot on the diagonal.
        let mut b = [3.0, 5.0];
        Lu::new(2, vec![0.0, 1.0, 1.0, 0.0]).unwrap().solve(&mut b);
        assert_eq!(b, [5.0, 3.0]);
    }
}
