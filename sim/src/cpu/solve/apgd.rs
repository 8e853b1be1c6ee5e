//! Accelerated projected gradient descent (Mazhar, Heyn, Negrut, Tasora 2015): Nesterov's sequence with adaptive restart and
//! back-tracking on the step length. One product with N per iteration: the response of the extrapolated point is the same
//! combination of responses as the point is of points.
//!
//! The step length t carries over from solve to solve, within bounds. In the metric of η the trace of N is 3 n_blocks, so that
//! t = 1/(3 n_blocks) is short enough for any direction. Where a step is so small that its curvature is lost in the rounding of the
//! responses, as without impulses or at the solution, t does not change. Along directions where N nearly vanishes it grows to at most
//! [`MAX_STEP`].

use super::iterates::{Best, Iterates, ROUNDING};
use super::operator::Operator;
use super::response::{Extrapolated, Response};
use crate::outcome::Outcome;
use crate::rows::sum_rows;
use crate::settings::SolverSettings;
use glam::DVec3;

/// Maximum step length. N is so small only along contacts between bodies that joints constrain.
const MAX_STEP: f64 = 1e6;
/// Iterations that a step length is kept after one that was too long: each attempt to exceed the length that fits costs an iteration,
/// which short solves cannot afford.
const KEEP: u32 = 10;
const KEEP_IN_SHORT: u32 = 40;
/// The most iterations of a short solve.
const SHORT: u32 = 100;

pub fn run(
    op: &mut impl Operator,
    settings: &SolverSettings,
    gamma: &mut Vec<DVec3>,
    response: &mut Response,
    work: &mut Iterates,
) -> Outcome {
    let mut best = Best::new();
    work.previous.clone_from(gamma);
    work.next.resize(gamma.len(), DVec3::ZERO);
    work.response_y.copy_from(response);
    let (mut theta, mut beta) = (1.0f64, 0.0);
    // Velocities are sums of impulses that cancel where bodies rest: the rounding of both counts.
    let [impulses] = sum_rows(gamma.len(), |i| [gamma[i].length_squared() / op.eta(i)]);
    let rounding = (op.energy(response) + impulses) * (ROUNDING * ROUNDING);
    let min_step = 1.0 / (3.0 * gamma.len() as f64);
    let is_valid = (min_step..=MAX_STEP).contains(&work.step_length);
    let mut step = if is_valid { work.step_length } else { 1.0 };
    let max = settings.max_iterations(gamma.len());
    let keep = if max <= SHORT { KEEP_IN_SHORT } else { KEEP };
    let (mut done, mut kept) = (0, keep);
    while done < max {
        loop {
            done += 1;
            let from = Extrapolated { x: gamma, previous: &work.previous, beta, response: &work.response_y };
            let [moved, slope] = op.descend(&mut work.next, &from, step, &mut work.response_next);
            // Restart where the step is uphill.
            let uphill = slope > 0.0;
            let next_theta = 0.5 * (theta * (theta * theta + 4.0).sqrt() - theta * theta);
            let next_beta = if uphill { 0.0 } else { theta * (1.0 - theta) / (theta * theta + next_theta) };
            let responses = [&mut work.response_next, &mut work.response_y_next];
            let curvature = op.advance(&work.next, next_beta, [response, &work.response_y], responses);
            let is_known = curvature > rounding;
            // The step is short enough if ½ dᵀNd ≤ |d|²/(2 t) in the metric of η; d is from y.
            if !is_known || curvature * step <= moved * (1.0 + 1e-9) || step <= min_step || done >= max {
                beta = next_beta;
                theta = if uphill { 1.0 } else { next_theta };
                work.step_length = step;
                kept += 1;
                if is_known && kept > keep {
                    step = (1.1 * step).min(MAX_STEP);
                }
                break;
            }
            kept = 0;
            step = (0.95 * moved / curvature).min(0.95 * step).max(min_step);
        }
        // previous ← γ ← next, and their responses.
        std::mem::swap(&mut work.previous, gamma);
        std::mem::swap(gamma, &mut work.next);
        std::mem::swap(response, &mut work.response_next);
        std::mem::swap(&mut work.response_y, &mut work.response_y_next);
        if best.check(op, settings, done, (gamma, response), (&mut work.best, &mut work.response_best)) {
            break;
        }
    }
    best.finish(done, gamma, response, work)
}
