//! Newton's method on exact friction, with a proximal term: small stiff problems to the rounding error, from a point near the solution.
//!
//! Each contact's law is the zero of Alart and Curnier's function. Redundant contacts make W singular; a proximal term
//! ρ (r − r_k) makes each step's system regular, and has no part in the solution (Acary, Brémond, Huber 2018). ρ falls while the steps converge fast and rises where they do not.

use super::alart_curnier::{Derivative, Local, local, moved};
use super::matrix::MatrixOperator;
use crate::cpu::solve::operator::Operator;
use glam::DVec3;

/// First ρ over the mean eigenvalue of the blocks W_ii.
const FIRST: f64 = 0.01;
/// Number of Newton steps after which a proximal step is given up.
const STEPS: u32 = 15;
/// Number of steps without halving the residual after which it is given up.
const STALLED: u32 = 6;

/// Take proximal steps until the error is within a tolerance or `budget` factorisations are made. Returns the best multipliers and
/// their error; `budget` is what is left.
pub fn polish(op: &MatrixOperator, start: &[DVec3], tolerance: f64, budget: &mut u32) -> (Vec<DVec3>, f64) {
    let scale = op.scale();
    let mean = (0..start.len()).map(|i| 1.0 / op.eta(i)).sum::<f64>() / start.len() as f64;
    let (mut rho, mut cautious) = (FIRST * mean, 0);
    let mut gamma = start.to_vec();
    let mut best = (gamma.clone(), op.error(start, true));
    while best.1 > tolerance && *budget > 0 && rho < 100.0 * mean {
        let goal = (0.03 * best.1.min(op.error(&gamma, true))).max(0.1 * tolerance) * scale;
        let (next, steps, converged) = proximal(op, &gamma, rho, goal, budget);
        let error = op.error(&next, true);
        if error < best.1 {
            best = (next.clone(), error);
        }
        if !converged {
            (rho, cautious) = (3.0 * rho, 3);
            continue;
        }
        gamma = next;
        cautious -= 1;
        rho *= if steps >= 9 { 1.5 } else { 1.0 };
        if steps <= 5 && cautious <= 0 {
            rho = (rho / 3.0).max(1e-9 * mean);
        }
    }
    best
}

/// Solve the problem with a proximal term at `anchor`, until the residual is within `goal`. Returns the multipliers, the number of steps,
/// and whether they converged.
fn proximal(op: &MatrixOperator, anchor: &[DVec3], rho: f64, goal: f64, budget: &mut u32) -> (Vec<DVec3>, u32, bool) {
    let mut gamma = anchor.to_vec();
    let eta: Vec<f64> = (0..gamma.len()).map(|i| op.eta(i)).collect();
    let compliance = vec![rho; gamma.len()];
    let (mut least, mut stalled) = (f64::INFINITY, 0);
    for step in 0..=STEPS {
        let of = |i: usize| {
            let u = op.velocity(&gamma, i) + (gamma[i] - anchor[i]) * rho;
            local(u, gamma[i], op.friction[i], eta[i])
        };
        let locals: Vec<Local> = (0..gamma.len()).map(of).collect();
        let residual =
            locals.iter().enumerate().map(|(i, l)| (l.value / op.eta(i)).length_squared()).sum::<f64>().sqrt();
        if residual <= goal {
            return (gamma, step, true);
        }
        stalled = if residual < 0.5 * least { 0 } else { stalled + 1 };
        least = least.min(residual);
        if step == STEPS || stalled > STALLED || *budget == 0 || !residual.is_finite() {
            break;
        }
        *budget -= 1;
        let Some(derivative) = Derivative::new(op, &locals, &eta, &compliance) else { break };
        let values: Vec<DVec3> = locals.iter().map(|l| l.value).collect();
        let change = derivative.solve(&values);
        for (i, (r, d)) in gamma.iter_mut().zip(change).enumerate() {
            *r = moved(*r + d, op.friction[i], locals[i].status);
        }
    }
    (gamma, STEPS, false)
}
