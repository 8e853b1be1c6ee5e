//! Friction problems as data: `u = Wr + q`, `K* ∋ u + g(u) ⊥ r ∈ K` with g = (μ|u_t|, 0, 0) for exact friction, or 0.
//!
//! The unknowns are the multipliers r (`gamma` in code) and the contact velocities u, with the components normal, tangent, tangent per
//! contact; W is positive semidefinite, but not always symmetric, K is the product of the friction cones, and K* its dual. Values have the
//! units of the problem's file.
//!
//! Solvers: the methods of the CPU back end, Gauss–Seidel sweeps on the matrix, and for small problems of exact friction on which these
//! stall, `direct`: solves of their independent parts (`components`) with factorised matrices, by Newton's method (`newton`), the central
//! path (`path`) and numerical continuation (`continuation`).

mod alart_curnier;
mod components;
mod continuation;
mod dense;
mod direct;
mod matrix;
mod newton;
mod path;
mod read;

pub use matrix::MatrixOperator;
pub use read::read;

use crate::cpu::solve::cone::project_cone;
use crate::cpu::solve::iterates::Iterates;
use crate::cpu::solve::operator::Operator;
use crate::cpu::solve::response::Response;
use crate::cpu::solve::{slip, solve as solve_with};
use crate::fill::SplitMix64;
use crate::settings::{FrictionLaw, Method, SolverSettings};
use glam::{DMat3, DVec3};

/// The settings of a solve: friction law, method and termination criteria.
#[derive(Clone, Copy, Debug)]
pub struct Law {
    /// Law of friction.
    pub friction: FrictionLaw,
    /// Error, as in [`Solution::error`], at which the solve ends.
    pub tolerance: f64,
    /// Maximum number of iterations, or of sweeps for Gauss–Seidel.
    pub iterations: u32,
    /// Method; Gauss–Seidel and APGD in alternation if not given.
    pub method: Option<Method>,
}

/// The solution of a problem.
#[derive(Clone, Debug)]
pub struct Solution {
    /// Multipliers γ with the lowest error: normal, tangent, tangent (n_contacts).
    pub gamma: Vec<DVec3>,
    /// Error `‖F_nat‖/‖q‖` of the multipliers ([`MatrixOperator::error`]).
    pub error: f64,
    /// Number of iterations, or of sweeps for Gauss–Seidel.
    pub iterations: u32,
    /// Name of the method that found the multipliers.
    pub method: &'static str,
}

/// Solve a problem from zero multipliers; a solve that does not converge returns the multipliers with the lowest error.
pub fn solve(op: &mut MatrixOperator, law: &Law) -> Solution {
    match law.method {
        Some(Method::GaussSeidel) => sweeps(op, law, vec![DVec3::ZERO; op.q.len()], 0).0,
        Some(method) => descend(op, law, method, vec![DVec3::ZERO; op.q.len()]),
        None => alternate(op, law),
    }
}

/// Alternate Gauss–Seidel and APGD, each from the best multipliers so far: Gauss–Seidel converges faster on most problems of rigid bodies,
/// APGD by far on some. The rounds become twice as long, those of APGD half as long when they find nothing better. Exact friction on which
/// they stall is tried once by direct solves, for as long as the iterations that are left take; if these do not converge, the rounds go on
/// as if they had not been.
fn alternate(op: &mut MatrixOperator, law: &Law) -> Solution {
    /// Iterations of the first round of each: those of APGD cost a sixteenth of a sweep.
    const FIRST: [(Method, u32); 2] = [(Method::GaussSeidel, 32), (Method::Apgd, 512)];
    let exact = law.friction == FrictionLaw::Exact;
    let start = vec![DVec3::ZERO; op.q.len()];
    let mut best =
        Solution { error: op.error(&start, exact), gamma: start, iterations: 0, method: Method::GaussSeidel.name() };
    let (mut done, mut rounds) = (0, FIRST);
    let mut next_direct = if exact { direct::first(op) } else { u32::MAX };
    while best.error > law.tolerance && done < law.iterations {
        for ((method, length), (_, least)) in rounds.iter_mut().zip(FIRST) {
            let part = Law { iterations: (*length).min(law.iterations - done), ..*law };
            let (next, made) = match method {
                Method::GaussSeidel => sweeps(op, &part, best.gamma.clone(), done),
                _ => (descend(op, &part, *method, best.gamma.clone()), part.iterations),
            };
            let ends = next.error <= law.tolerance;
            // Iterations without progress count too.
            done += if ends { next.iterations } else { made };
            let is_better = next.error < best.error;
            let doubles = is_better || *method == Method::GaussSeidel;
            *length = if doubles { length.saturating_mul(2) } else { (*length / 2).max(least) };
            if is_better {
                best = Solution { iterations: done, ..next };
            }
            if ends || done >= law.iterations {
                return best;
            }
        }
        if done >= next_direct {
            next_direct = u32::MAX;
            let limits = direct::Limits { early: done.saturating_mul(2), late: law.iterations - done };
            let found = direct::solve(op, &best.gamma, law.tolerance, limits);
            if found.error <= law.tolerance {
                let (iterations, method) = (done + found.iterations, found.method);
                return Solution { gamma: found.gamma, error: found.error, iterations, method };
            }
        }
    }
    best
}

/// Gauss–Seidel on the law itself: each contact's own problem is solved with the other multipliers fixed (Jourdan et al. 1998). Each
/// sweep has a random order of its own, the same in every run, so that no mode of a stiff problem is by far slower than the others. Returns
/// the solution, and the number of sweeps made.
fn sweeps(op: &MatrixOperator, law: &Law, mut gamma: Vec<DVec3>, seed: u32) -> (Solution, u32) {
    let exact = law.friction == FrictionLaw::Exact;
    let n = gamma.len();
    let mut best =
        Solution { error: op.error(&gamma, exact), gamma: gamma.clone(), iterations: 0, method: "gauss_seidel" };
    let mut next_check = 1;
    let mut order: Vec<usize> = (0..n).collect();
    let mut random = SplitMix64(seed.into());
    let mut made = 0;
    for sweep in 1..=law.iterations {
        made = sweep;
        for k in (1..n).rev() {
            order.swap(k, random.below(k + 1));
        }
        for &i in &order {
            let own = op.diagonal(i);
            let others = op.velocity(&gamma, i) - own * gamma[i];
            gamma[i] = local(&own, others, op.friction[i], gamma[i], exact);
        }
        if sweep == next_check || sweep == law.iterations {
            next_check = sweep + (sweep / 8).clamp(1, 50);
            let error = op.error(&gamma, exact);
            if error < best.error {
                (best.error, best.iterations) = (error, sweep);
                best.gamma.clone_from(&gamma);
            }
            if error <= law.tolerance || !error.is_finite() {
                break;
            }
            // Stop without progress.
            if sweep > 20_000 && sweep > 4 * best.iterations {
                break;
            }
        }
    }
    (best, made)
}

/// One contact's problem: r with `K* ∋ Wr + q + g ⊥ r ∈ K`, by extragradient steps of adaptive length.
fn local(w: &DMat3, q: DVec3, mu: f64, start: DVec3, exact: bool) -> DVec3 {
    const STEPS: usize = 200;
    // The closed forms first: it opens (for the relaxed law, faster than it slips), or it sticks.
    if q.x >= 0.0 && (exact || project_cone(-q, DVec3::X, mu) == DVec3::ZERO) {
        return DVec3::ZERO;
    }
    let stick = -(w.inverse() * q);
    if stick.is_finite() && stick.x >= 0.0 && (stick.y * stick.y + stick.z * stick.z).sqrt() <= mu * stick.x {
        return stick;
    }
    let trace = w.x_axis.x + w.y_axis.y + w.z_axis.z;
    let longest = 3.0 / trace;
    // A contact that no impulse of its own moves.
    if !(longest > 0.0 && longest.is_finite()) {
        return DVec3::ZERO;
    }
    let slip = |u: DVec3| DVec3::new(if exact { mu * (u.y * u.y + u.z * u.z).sqrt() } else { 0.0 }, 0.0, 0.0);
    let velocity = |r: DVec3| {
        let u = *w * r + q;
        u + slip(u)
    };
    let (mut r, mut step) = (start, longest);
    for _ in 0..STEPS {
        let f = velocity(r);
        let (mut next, mut f_next);
        // Extragradient: shorten the step until it is a contraction.
        loop {
            next = project_cone(r - f * step, DVec3::X, mu);
            f_next = velocity(next);
            let (df, dr) = ((f_next - f).length() * step, (next - r).length());
            let is_too_long = df > 0.9 * dr && step >= 1e-12 / trace;
            if !is_too_long {
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

/// A descent method, or Jacobi, with an outer fixed point on the slip feedback for exact friction.
fn descend(op: &mut MatrixOperator, law: &Law, method: Method, mut gamma: Vec<DVec3>) -> Solution {
    let is_exact = law.friction == FrictionLaw::Exact;
    let mut best =
        Solution { error: op.error(&gamma, is_exact), gamma: gamma.clone(), iterations: 0, method: method.name() };
    let mut work = Iterates::default();
    let mut response = Response::default();
    let mut done = 0;
    // Each round updates the slip feedback and goes on from the last multipliers.
    while done < law.iterations && best.error > law.tolerance {
        if is_exact {
            op.response(&gamma, &mut response);
            let slip = slip::measure(op, &response, gamma.len());
            op.set_slip_feedback(&slip);
        }
        let settings = SolverSettings {
            method: Some(method),
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
