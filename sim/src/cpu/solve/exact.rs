//! Coulomb's law itself: the slip feedback μ|v_t| is added to the gap's rate (Cadoux 2009; Acary et al. 2011), and the convex problem
//! is solved again until the feedback is a fixed point. Not for Jacobi, whose problems are never solved so far that the slip of their
//! solutions would be known: it takes the slip of each iterate.

use super::iterates::Iterates;
use super::operator::Operator;
use super::residual::residual;
use super::response::Response;
use super::{method, scale, slip};
use crate::outcome::Outcome;
use crate::settings::SolverSettings;
use glam::DVec3;

pub fn run(
    op: &mut impl Operator,
    settings: &SolverSettings,
    gamma: &mut Vec<DVec3>,
    response: &mut Response,
    work: &mut Iterates,
) -> Outcome {
    const ROUNDS: u32 = 40;
    /// Least number of iterations of a round: with fewer, the slip that is fed would be that of the method's errors.
    const LEAST: u32 = 50;
    let (mut total, mut errors) = (Outcome::default(), f64::INFINITY);
    let max = settings.max_iterations(gamma.len());
    let budget = (max / 4).max(LEAST);
    let mut feedback = vec![0.0; gamma.len()];
    for round in 0..=ROUNDS {
        // The first feedback is the slip of the last step, or that of the starting point.
        let last = if round == 0 { op.last_slip() } else { None };
        let mut slip = last.unwrap_or_else(|| slip::measure(op, response, gamma.len()));
        // Where the first problem is solved with ease, as that of few bodies, slip is known to some tolerances.
        if round == 1 && total.residual <= settings.tolerance && total.iterations <= max / 4 {
            errors = slip::known(settings, gamma.len());
        }
        slip::leave_out_creep(op, gamma, errors, &mut slip);
        let change: f64 = slip.iter().zip(&feedback).map(|(a, b)| (a - b).abs()).sum();
        let sum: f64 = slip.iter().sum();
        let is_fixed_point = change <= 1e-9 * sum + 1e-2 * settings.tolerance * gamma.len() as f64;
        // Where the slip stands still, the problem of it may yet be far from solved, as that of piles which stick.
        if round > 0 && is_fixed_point && total.residual <= settings.tolerance {
            break;
        }
        op.set_slip_feedback(&slip);
        feedback = slip;
        if round == ROUNDS || round > 0 && total.iterations >= max {
            // Of the slip that has come out, not of that which was fed.
            total.residual = total.residual.max(residual(op, gamma, response));
            break;
        }
        op.response(gamma, response);
        if round == 0 {
            scale::scale(op, settings.max_iterations(gamma.len()), gamma, response, work);
        }
        let left = max - total.iterations.min(max - 1);
        let own = if round > 0 && is_fixed_point { left } else { budget.min(left) };
        let settings = SolverSettings { iterations: Some(own), ..settings.clone() };
        let outcome = method::run(op, &settings, gamma, response, work);
        total = Outcome { iterations: total.iterations + outcome.iterations, residual: outcome.residual };
    }
    total
}

/// The residual of γ in Coulomb's law: that of the problem with its own slip, which is the feedback then.
pub fn residual_of_law(op: &mut impl Operator, gamma: &[DVec3], response: &Response) -> f64 {
    let mut slip = slip::measure(op, response, gamma.len());
    slip::leave_out_creep(op, gamma, f64::INFINITY, &mut slip);
    op.set_slip_feedback(&slip);
    residual(op, gamma, response)
}
