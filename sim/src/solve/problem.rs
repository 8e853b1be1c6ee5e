//! Friction problems as data: `u = Wr + q`, `K* ∋ u + g(u) ⊥ r ∈ K` with g = (μ|u_t|, 0, 0) for exact friction, or 0.
//!
//! The text format is the one that the collection of problems of Acary et al. (2011) uses: numbers separated by white space.
//! Dimension (3), number of contacts n, kind of matrix (0 dense, 1 blocks); dense: rows and columns (twice), values by columns;
//! blocks: rows, columns, number of blocks, block rows, block columns, the running ends of both, the index's two lengths, the
//! row starts, the columns, and for each block its number and nine values by columns. Then q (3 n) and μ (n).

use super::matrix::MatrixOperator;
use super::{
    FrictionLaw, Image, Method, Operator, SolverSettings, Workspace, exact, project_cone, solve as solve_with,
};
use frame::{Fault, FaultKind, read_text};
use glam::{DMat3, DVec3};
use std::path::Path;

/// What is asked of a solution.
#[derive(Clone, Copy, Debug)]
pub struct Law {
    /// Relaxed or exact.
    pub friction: FrictionLaw,
    /// Greatest error.
    pub tolerance: f64,
    /// Most iterations.
    pub iterations: u32,
    /// The method; the best for the problem if not given.
    pub method: Option<Method>,
}

/// A solution.
#[derive(Clone, Debug)]
pub struct Solution {
    /// Multipliers: normal, tangent, tangent (n_contacts).
    pub gamma: Vec<DVec3>,
    /// `‖F_nat‖/‖q‖`.
    pub error: f64,
    /// Iterations, or sweeps, done.
    pub iterations: u32,
    /// The method's name.
    pub method: &'static str,
}

/// The words of a text, with their places.
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
            return Err(Fault::whole(FaultKind::Input, self.path, format!("ends where {what} should be")));
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

    /// A number that must have a given value.
    fn expect(&mut self, value: usize, what: &str) -> Result<(), Fault> {
        let x: usize = self.next(what)?;
        if x == value {
            return Ok(());
        }
        Err(Fault::whole(FaultKind::Input, self.path, format!("{what} is {x}, expected {value}")))
    }
}

/// Read a problem.
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
        return Err(wrong(format!("has {n} contacts, expected at least 1 and as many as the file holds")));
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
        return Err(wrong(w.path, "its row starts do not rise from 0 to the number of blocks".into()));
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
        w.expect(i, "a block's number")?;
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

/// Solve a problem.
pub fn solve(op: &mut MatrixOperator, law: &Law) -> Solution {
    match law.method {
        Some(Method::GaussSeidel) => sweeps(op, law, vec![DVec3::ZERO; op.q.len()]),
        Some(method) => descend(op, law, method, vec![DVec3::ZERO; op.q.len()]),
        None => in_turns(op, law),
    }
}

/// Gauss–Seidel wins on most problems of rigid bodies, a descent method on some by far: they take turns, ever longer ones, each
/// from the best so far.
fn in_turns(op: &mut MatrixOperator, law: &Law) -> Solution {
    /// Sweeps of the first turn.
    const FIRST: u32 = 32;
    /// A sweep takes as long as so many iterations of the other.
    const RATIO: u32 = 16;
    let exact = law.friction == FrictionLaw::Exact;
    let start = vec![DVec3::ZERO; op.q.len()];
    let mut best =
        Solution { error: op.error(&start, exact), gamma: start, iterations: 0, method: Method::GaussSeidel.name() };
    let (mut done, mut turn) = (0, FIRST);
    while best.error > law.tolerance && done < law.iterations {
        for method in [Method::GaussSeidel, Method::Apgd] {
            let length = if method == Method::GaussSeidel { turn } else { turn.saturating_mul(RATIO) };
            let share = Law { iterations: length.min(law.iterations - done), ..*law };
            let next = match method {
                Method::GaussSeidel => sweeps(op, &share, best.gamma.clone()),
                _ => descend(op, &share, method, best.gamma.clone()),
            };
            let ends = next.error <= law.tolerance;
            // What did not help has been done all the same.
            done += if ends { next.iterations } else { share.iterations };
            if next.error < best.error {
                best = Solution { iterations: done, ..next };
            }
            if ends || done >= law.iterations {
                return best;
            }
        }
        turn = turn.saturating_mul(2);
    }
    best
}

/// Gauss–Seidel on the law itself: each contact's own problem is solved with the others held (Jourdan et al. 1998).
fn sweeps(op: &MatrixOperator, law: &Law, mut gamma: Vec<DVec3>) -> Solution {
    let exact = law.friction == FrictionLaw::Exact;
    let n = gamma.len();
    let mut best =
        Solution { error: op.error(&gamma, exact), gamma: gamma.clone(), iterations: 0, method: "gauss_seidel" };
    let mut look = 1;
    for sweep in 1..=law.iterations {
        // Forward and backward in turn: news travels both ways.
        for k in 0..n {
            let i = if sweep % 2 == 1 { k } else { n - 1 - k };
            let own = op.diagonal(i);
            let others = op.velocity(&gamma, i) - own * gamma[i];
            gamma[i] = local(&own, others, op.friction[i], gamma[i], exact);
        }
        if sweep == look || sweep == law.iterations {
            look = sweep + (sweep / 8).clamp(1, 50);
            let error = op.error(&gamma, exact);
            if error < best.error {
                (best.error, best.iterations) = (error, sweep);
                best.gamma.clone_from(&gamma);
            }
            if error <= law.tolerance || !error.is_finite() {
                break;
            }
            // Give up where nothing has been gained for long.
            if sweep > 2000 && sweep > 4 * best.iterations {
                break;
            }
        }
    }
    best
}

/// One contact's problem: r with `K* ∋ Wr + q + g ⊥ r ∈ K`, by projected steps of adapted length.
fn local(w: &DMat3, q: DVec3, mu: f64, start: DVec3, exact: bool) -> DVec3 {
    const STEPS: usize = 200;
    // The simplest answers first: it opens (for the relaxed law, faster than it slips), or it sticks.
    if q.x >= 0.0 && (exact || project_cone(-q, DVec3::X, mu) == DVec3::ZERO) {
        return DVec3::ZERO;
    }
    let stick = -(w.inverse() * q);
    if stick.is_finite() && stick.x >= 0.0 && (stick.y * stick.y + stick.z * stick.z).sqrt() <= mu * stick.x {
        return stick;
    }
    let trace = w.x_axis.x + w.y_axis.y + w.z_axis.z;
    let feed = |u: DVec3| DVec3::new(if exact { mu * (u.y * u.y + u.z * u.z).sqrt() } else { 0.0 }, 0.0, 0.0);
    let force = |r: DVec3| {
        let u = *w * r + q;
        u + feed(u)
    };
    let (mut r, mut step) = (start, 3.0 / trace.max(f64::MIN_POSITIVE));
    for _ in 0..STEPS {
        let f = force(r);
        let (mut next, mut f_next);
        // Extragradient: shorten the step until it is a contraction.
        loop {
            next = project_cone(r - f * step, DVec3::X, mu);
            f_next = force(next);
            let (df, dr) = ((f_next - f).length() * step, (next - r).length());
            if df <= 0.9 * dr || step < 1e-12 / trace {
                if df < 0.3 * dr {
                    step *= 1.5;
                }
                break;
            }
            step *= 0.66;
        }
        let moved = project_cone(r - f_next * step, DVec3::X, mu);
        let change = (moved - r).length();
        r = moved;
        if change <= 1e-14 * r.length() {
            break;
        }
    }
    r
}

/// A method of [`super`], with an outer loop for exact friction.
fn descend(op: &mut MatrixOperator, law: &Law, method: Method, mut gamma: Vec<DVec3>) -> Solution {
    let is_exact = law.friction == FrictionLaw::Exact;
    let mut best =
        Solution { error: op.error(&gamma, is_exact), gamma: gamma.clone(), iterations: 0, method: method.name() };
    let mut work = Workspace::default();
    let mut image = Image::default();
    let mut done = 0;
    // The slip that is fed changes between rounds; each round is solved a little better than the error so far.
    while done < law.iterations && best.error > law.tolerance {
        if is_exact {
            op.image(&gamma, &mut image);
            let slip = exact::measure(op, &image, gamma.len());
            op.feed(&slip);
        }
        let settings = SolverSettings {
            method,
            friction: FrictionLaw::Relaxed,
            iterations: Some((law.iterations - done).min(200)),
            tolerance: 0.0,
            ..SolverSettings::default()
        };
        done += solve_with(op, &settings, &mut gamma, &mut image, &mut work).iterations;
        let error = op.error(&gamma, is_exact);
        if error < best.error {
            best.error = error;
            best.gamma.clone_from(&gamma);
        }
        best.iterations = done;
        if !error.is_finite() {
            break;
        }
    }
    best
}
