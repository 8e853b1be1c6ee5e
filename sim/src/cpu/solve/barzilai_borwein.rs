//! Spectral projected gradients (Barzilai & Borwein 1988; Birgin, Martínez & Raydan 2000): the step length is the inverse of a
//! Rayleigh quotient of N along the last step, in the metric of η; the search along the projected direction is exact, since
//! the objective is quadratic.

use super::iterates::{Best, Iterates};
use super::operator::Operator;
use super::residual::residual;
use super::response::{Extrapolated, Response};
use crate::outcome::Outcome;
use crate::settings::SolverSettings;
use glam::DVec3;

pub fn run(
    op: &mut impl Operator,
    settings: &SolverSettings,
    gamma: &mut [DVec3],
    response: &mut Response,
    work: &mut Iterates,
) -> Outcome {
    let mut best = Best::new();
    work.next.resize(gamma.len(), DVec3::ZERO);
    let mut alpha = 1.0;
    let mut done = 0;
    while done < settings.max_iterations(gamma.len()) {
        done += 1;
        // next = the projected point; d = next − γ.
        let from = Extrapolated { x: gamma, previous: gamma, beta: 0.0, response };
        let [length2, slope] = op.descend(&mut work.next, &from, alpha, &mut work.response_next);
        if !(length2 > 0.0) {
            // Every block is at its projection: the iterate is the solution.
            best.compare(Outcome { iterations: done, residual: residual(op, gamma, response) });
            break;
        }
        let responses = [&mut work.response_next, &mut work.response_y];
        let curvature = op.advance(&work.next, 0.0, [response, response], responses);
        // Spectral steps are not monotone; a full step is taken unless the objective rises along it.
        let along = if curvature > 0.0 && slope < 0.0 { (-slope / curvature).min(1.0) } else { 1.0 };
        alpha = if curvature > 0.0 { (length2 / curvature).clamp(1e-4, 1e4) } else { 1e4 };
        if along < 1.0 {
            gamma.iter_mut().zip(&work.next).for_each(|(x, z)| *x += (*z - *x) * along);
            work.response_y.extrapolate(response, &work.response_next, -along);
            std::mem::swap(response, &mut work.response_y);
        } else {
            gamma.copy_from_slice(&work.next);
            std::mem::swap(response, &mut work.response_next);
        }
        if best.check(op, settings, done, (gamma, response), (&mut work.best, &mut work.response_best)) {
            break;
        }
    }
    best.finish(done, gamma, response, work)
}
