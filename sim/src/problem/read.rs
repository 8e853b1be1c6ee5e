//! The text format of friction problems of the collection of Acary et al. (2011): numbers separated by white space.
//!
//! Dimension (3), number of contacts n, kind of matrix (0 dense, 1 blocks); dense: rows and columns (twice), values by columns;
//! blocks: rows, columns, number of blocks, block rows, block columns, the cumulative sizes of both, the index's two lengths, the
//! row starts, the columns, and for each block its index and nine values by columns. Then q (3 n) and μ (n).

use super::matrix::MatrixOperator;
use frame::{Fault, FaultKind, read_text};
use glam::{DMat3, DVec3};
use std::path::Path;

/// The words of a text, with their lines and columns.
struct Words<'a> {
    path: &'a Path,
    text: &'a str,
    words: std::vec::IntoIter<(usize, usize, &'a str)>,
}

impl<'a> Words<'a> {
    fn new(path: &'a Path, text: &'a str) -> Words<'a> {
        let mut words = vec![];
        for (i, line) in text.lines().enumerate() {
            for word in line.split_ascii_whitespace() {
                let column = word.as_ptr() as usize - line.as_ptr() as usize + 1;
                words.push((i + 1, column, word));
            }
        }
        Words { path, text, words: words.into_iter() }
    }

    fn next<T: std::str::FromStr>(&mut self, what: &str) -> Result<T, Fault> {
        let Some((line, column, word)) = self.words.next() else {
            return Err(Fault::whole(FaultKind::Input, self.path, format!("ends where {what} is expected")));
        };
        word.parse().map_err(|_| {
            let message = format!("`{word}` is not {what}");
            Fault::at(FaultKind::Input, self.path, self.text, line, column, message)
        })
    }

    fn number(&mut self, what: &str) -> Result<f64, Fault> {
        let x: f64 = self.next(what)?;
        if x.is_finite() {
            return Ok(x);
        }
        Err(Fault::whole(FaultKind::Input, self.path, format!("{what} is {x}, expected a finite number")))
    }

    /// Read a number that must have a given value.
    fn expect(&mut self, value: usize, what: &str) -> Result<(), Fault> {
        let x: usize = self.next(what)?;
        if x == value {
            return Ok(());
        }
        Err(Fault::whole(FaultKind::Input, self.path, format!("{what} is {x}, expected {value}")))
    }
}

/// Read a friction problem from a text file in the format of the collection of Acary et al. (2011), with W dense or in blocks.
///
/// # Errors
/// A file that cannot be read or is not in the format, with the line and column of the fault.
pub fn read(path: &Path) -> Result<MatrixOperator, Fault> {
    let text = read_text(FaultKind::Input, path)?;
    let mut w = Words::new(path, &text);
    let wrong = |message: String| Fault::whole(FaultKind::Input, path, message);
    let dimension: usize = w.next("the number of dimensions")?;
    if dimension != 3 {
        return Err(wrong(format!("has {dimension} dimensions, expected 3")));
    }
    let n: usize = w.next("the number of contacts")?;
    if n == 0 || n > text.len() {
        return Err(wrong(format!("has {n} contacts, expected at least 1 and no more than the file has numbers")));
    }
    let kind: usize = w.next("the kind of matrix, 0 or 1")?;
    w.expect(3 * n, "the number of rows")?;
    w.expect(3 * n, "the number of columns")?;
    let (start, column, block) = match kind {
        0 => dense(&mut w, n)?,
        1 => blocks(&mut w, n)?,
        other => return Err(wrong(format!("has a matrix of kind {other}, expected 0 (dense) or 1 (blocks)"))),
    };
    let mut q = vec![DVec3::ZERO; n];
    for v in &mut q {
        for k in 0..3 {
            v[k] = w.number("a component of q")?;
        }
    }
    let mut friction = vec![0.0; n];
    for mu in &mut friction {
        *mu = w.number("a coefficient of friction")?;
        if *mu < 0.0 {
            return Err(wrong(format!("has a coefficient of friction of {mu}, expected at least 0")));
        }
    }
    Ok(MatrixOperator::new(start, column, block, q, friction))
}

type Blocks = (Vec<u32>, Vec<u32>, Vec<DMat3>);

fn dense(w: &mut Words, n: usize) -> Result<Blocks, Fault> {
    w.expect(3 * n, "the number of rows")?;
    w.expect(3 * n, "the number of columns")?;
    if n.saturating_mul(n) > w.words.len() {
        let message = format!("has {} more numbers, and a dense matrix of {n} contacts has {n}² × 9", w.words.len());
        return Err(Fault::whole(FaultKind::Input, w.path, message));
    }
    let mut all = vec![DMat3::ZERO; n * n];
    for c in 0..3 * n {
        for r in 0..3 * n {
            all[r / 3 * n + c / 3].col_mut(c % 3)[r % 3] = w.number("an entry of W")?;
        }
    }
    let (mut start, mut column, mut block) = (vec![0], vec![], vec![]);
    for i in 0..n {
        for j in (0..n).filter(|j| *j == i || all[i * n + *j] != DMat3::ZERO) {
            column.push(j as u32);
            block.push(all[i * n + j]);
        }
        start.push(block.len() as u32);
    }
    Ok((start, column, block))
}

fn blocks(w: &mut Words, n: usize) -> Result<Blocks, Fault> {
    let n_blocks: usize = w.next("the number of blocks")?;
    w.expect(n, "the number of block rows")?;
    w.expect(n, "the number of block columns")?;
    for side in ["rows", "columns"] {
        for i in 1..=n {
            w.expect(3 * i, &format!("the end of block {side} {i}"))?;
        }
    }
    w.expect(n + 1, "the length of the row index")?;
    w.expect(n_blocks, "the length of the column index")?;
    let wrong = |path: &Path, message: String| Fault::whole(FaultKind::Input, path, message);
    let mut start = vec![0u32; n + 1];
    for s in &mut start {
        *s = w.next("a row start")?;
    }
    if start[0] != 0 || start[n] as usize != n_blocks || start.windows(2).any(|p| p[1] < p[0]) {
        return Err(wrong(w.path, "its row starts do not ascend from 0 to the number of blocks".into()));
    }
    let mut column = vec![];
    for _ in 0..n_blocks {
        let c: u32 = w.next("a block's column")?;
        if c as usize >= n {
            return Err(wrong(w.path, format!("has a block in column {c} of {n}")));
        }
        column.push(c);
    }
    let mut block = vec![];
    for i in 0..n_blocks {
        w.expect(i, "a block's index")?;
        let mut m = DMat3::ZERO;
        for c in 0..3 {
            for r in 0..3 {
                m.col_mut(c)[r] = w.number("an entry of W")?;
            }
        }
        block.push(m);
    }
    Ok((start, column, block))
}
