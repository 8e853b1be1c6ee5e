//! Friction problems as data: `u = Wr + q`, `K* ∋ u + g(u) ⊥ r ∈ K` with g = (μ|u_t|, 0, 0) for exact friction, or 0.
//!
//! They are solved on the CPU, by its methods or by sweeps of their own.

mod matrix;
mod read;

pub use matrix::MatrixOperator;
pub use read::read;

use crate::cpu::solve::cone::project_cone;
use crate::cpu::solve::iterates::Iterates;
use crate::cpu::solve::operator::Operator;
use crate::cpu::solve::response::Response;
use crate::cpu::solve::{exact, solve as solve_with};
use crate::settings::{FrictionLaw, Method, SolverSettings};
use glam::{DMat3, DVec3};

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
            let part = Law { iterations: length.min(law.iterations - done), ..*law };
            let next = match method {
                Method::GaussSeidel => sweeps(op, &part, best.gamma.clone()),
                _ => descend(op, &part, method, best.gamma.clone()),
            };
            let ends = next.error <= law.tolerance;
            // What did not help has been done all the same.
            done += if ends { next.iterations } else { part.iterations };
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

/// A method of the solver, with an outer loop for exact friction.
fn descend(op: &mut MatrixOperator, law: &Law, method: Method, mut gamma: Vec<DVec3>) -> Solution {
    let is_exact = law.friction == FrictionLaw::Exact;
    let mut best =
        Solution { error: op.error(&gamma, is_exact), gamma: gamma.clone(), iterations: 0, method: method.name() };
    let mut work = Iterates::default();
    let mut response = Response::default();
    let mut done = 0;
    // The slip that is fed changes between rounds; each round is solved a little better than the error so far.
    while done < law.iterations && best.error > law.tolerance {
        if is_exact {
            op.response(&gamma, &mut response);
            let slip = exact::measure(op, &response, gamma.len());
            op.feed_slip(&slip);
        }
        let settings = SolverSettings {
            method,
            friction: FrictionLaw::Relaxed,
            iterations: Some((law.iterations - done).min(200)),
            tolerance: 0.0,
            ..SolverSettings::default()
        };
        done += solve_with(op, &settings, &mut gamma, &mut response, &mut work).iterations;
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
