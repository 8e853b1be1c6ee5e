//! Projected Jacobi, the paper's Algorithm 1: γ⁺ = λ Π(γ − ω η (Nγ + r)) + (1 − λ) γ, with the joints eliminated rather than iterated.
//!
//! Steps do not grow, in the metric of η, where ω is short enough for N: an ω that was not given by hand is halved where they do, as among
//! bodies that touch at many points.

use super::iterates::Iterates;
use super::operator::Operator;
use super::residual::residual;
use super::response::Response;
use super::slip;
use crate::outcome::Outcome;
use crate::rows::{fill_rows, sum_rows};
use crate::settings::{FrictionLaw, SolverSettings};
use glam::DVec3;

/// Share of the tolerance at which it ends by Coulomb's law itself: what Jacobi leaves is an error of whole layers, which would slip.
pub const SHARE: f64 = 0.1;

/// Growth of a step's square that is more than rounding.
const GROWS: f64 = 1.0 + 1e-6;

pub fn run(
    op: &mut impl Operator,
    settings: &SolverSettings,
    gamma: &mut Vec<DVec3>,
    response: &mut Response,
    work: &mut Iterates,
) -> Outcome {
    let (mut omega, lambda) = (settings.omega.unwrap_or(0.3), settings.lambda);
    let has_feedback = settings.friction == FrictionLaw::Exact;
    let tolerance = if has_feedback { SHARE * settings.tolerance } else { settings.tolerance };
    let mut last_step2 = f64::INFINITY;
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
        if has_feedback {
            slip::set_feedback(op, settings, gamma, response);
        }
        if settings.omega.is_none() {
            let [step2] = sum_rows(gamma.len(), |i| [(gamma[i] - work.next[i]).length_squared() / op.eta(i)]);
            if step2 > GROWS * last_step2 {
                omega *= 0.5;
            }
            last_step2 = step2;
        }
        outcome.iterations = iteration;
        if tolerance > 0.0 || iteration == max {
            outcome.residual = residual(op, gamma, response);
            if outcome.residual <= tolerance {
                break;
            }
        }
    }
    outcome
}
