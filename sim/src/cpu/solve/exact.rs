//! Coulomb's law itself: the slip feedback μ|v_t| is added to the gap's rate (Cadoux 2009; Acary et al. 2011), and the convex problem
//! is solved again until the feedback is a fixed point.

use super::iterates::Iterates;
use super::operator::Operator;
use super::response::Response;
use super::{method, scale};
use crate::outcome::Outcome;
use crate::rows::fill_rows;
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
    /// Slip that a solved problem may be wrong by, over the root mean square of its contacts' errors.
    const KNOWN: f64 = 50.0;
    let (mut total, mut errors) = (Outcome::default(), f64::INFINITY);
    let max = settings.max_iterations(gamma.len());
    let budget = (max / 4).max(LEAST);
    let mut feedback = vec![0.0; gamma.len()];
    for round in 0..ROUNDS {
        // The first feedback is the slip of the last step, or that of the starting point.
        let last = if round == 0 { op.last_slip() } else { None };
        let mut slip = last.unwrap_or_else(|| measure(op, response, gamma.len()));
        // Where the first problem is solved with ease, as that of few bodies, slip is known to some tolerances.
        if round == 1 && total.residual <= settings.tolerance && total.iterations <= max / 4 {
            // The tolerance is of the norm over the number of contacts.
            errors = KNOWN * settings.tolerance * (gamma.len() as f64).sqrt();
        }
        leave_out_creep(op, gamma, errors, &mut slip);
        let change: f64 = slip.iter().zip(&feedback).map(|(a, b)| (a - b).abs()).sum();
        let sum: f64 = slip.iter().sum();
        let is_fixed_point = change <= 1e-9 * sum + 1e-2 * settings.tolerance * gamma.len() as f64;
        // Where the slip stands still, the problem of it may yet be far from solved, as that of piles which stick.
        let is_solved = is_fixed_point && total.residual <= settings.tolerance;
        if round > 0 && (is_solved || total.iterations >= max) {
            break;
        }
        op.set_slip_feedback(&slip);
        feedback = slip;
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

/// Slip μ |v_t| of every block, m/s, from the response of γ, without the slip feedback.
pub fn measure(op: &impl Operator, response: &Response, n_blocks: usize) -> Vec<f64> {
    let mut slip = vec![0.0; n_blocks];
    fill_rows(&mut slip, |i| {
        let (mu, normal) = op.friction(i);
        let v = op.gradient(response, i);
        mu * (v - normal * v.dot(normal)).length()
    });
    slip
}

/// Leave out the slip of blocks that hardly slip, and of those that stick, whose multipliers are within their cones: it is that of the
/// solver's errors, which are at most `errors`, m/s, and what is fed back for it would shake what rests. All is fed from twice the least
/// slip on.
fn leave_out_creep(op: &impl Operator, gamma: &[DVec3], errors: f64, slip: &mut [f64]) {
    /// Share of the cone's width from which on a block slides.
    const SLIDES: f64 = 0.99;
    for (i, slip) in slip.iter_mut().enumerate() {
        let (mu, normal) = op.friction(i);
        let least = op.least_slip(i).min(mu * errors);
        let along = gamma[i].dot(normal);
        let sticks = least > 0.0 && (gamma[i] - normal * along).length() < SLIDES * mu * along;
        if sticks {
            *slip = 0.0;
        } else if *slip < 2.0 * least {
            *slip *= ((*slip - least) / least).max(0.0);
        }
    }
}
