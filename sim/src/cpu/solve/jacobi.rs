//! Projected Jacobi, the paper's Algorithm 1: γ⁺ = λ Π(γ − ω η (Nγ + r)) + (1 − λ) γ, with the joints eliminated rather than iterated.

use super::iterates::Iterates;
use super::operator::Operator;
use super::residual::residual;
use super::response::Response;
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
    let (omega, lambda) = (settings.omega.unwrap_or(0.3), settings.lambda);
    work.next.resize(gamma.len(), DVec3::ZERO);
    let mut outcome = Outcome::default();
    let max = settings.max_iterations(gamma.len());
    for iteration in 1..=max {
        let (now, x, last) = (&*op, &*gamma, &*response);
        fill_rows(&mut work.next, |i| {
            let stepped = x[i] - now.gradient(last, i) * (omega * now.eta(i));
            now.project(i, stepped, x) * lambda + x[i] * (1.0 - lambda)
        });
        std::mem::swap(gamma, &mut work.next);
        op.response(gamma, response);
        outcome.iterations = iteration;
        if settings.tolerance > 0.0 || iteration == max {
            outcome.residual = residual(op, gamma, response);
            if outcome.residual <= settings.tolerance {
                break;
            }
        }
    }
    outcome
}
