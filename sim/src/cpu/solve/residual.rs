//! The residual of multipliers.

use super::operator::Operator;
use super::response::Response;
use crate::rows::sum_rows;
use glam::DVec3;

/// Residual term of a block: `(γ − Π(γ − g (Nγ + r))) / g` with g = 10⁻³ η, m/s (rad/s for rolling blocks).
#[inline]
pub fn term(op: &impl Operator, i: usize, eta: f64, gamma: &[DVec3], response: &Response) -> DVec3 {
    term_of(op, i, eta, gamma, op.gradient(response, i))
}

/// [`term`] of a gradient Nγ + r, m/s.
#[inline]
pub fn term_of(op: &impl Operator, i: usize, eta: f64, gamma: &[DVec3], gradient: DVec3) -> DVec3 {
    let g = 1e-3 * eta;
    (gamma[i] - op.project(i, gamma[i] - gradient * g, gamma)) / g
}

/// The residual of γ: see [`Outcome::residual`].
pub fn residual(op: &impl Operator, gamma: &[DVec3], response: &Response) -> f64 {
    let [sum] = sum_rows(gamma.len(), |i| {
        let lever = op.lever(i);
        [term(op, i, op.eta(i), gamma, response).length_squared() * (lever * lever)]
    });
    sum.sqrt() / gamma.len() as f64
}

/// Sum of the lengths of all blocks' residual terms: what a few blocks are off by counts for little beside what all are.
pub fn sum_of_lengths(op: &impl Operator, gamma: &[DVec3], response: &Response) -> f64 {
    sum_rows(gamma.len(), |i| [term(op, i, op.eta(i), gamma, response).length() * op.lever(i)])[0]
}

/// Index of the block with the maximum residual term. There must be blocks; η is evaluated here, since some methods do not store it.
pub fn worst_block(op: &impl Operator, gamma: &[DVec3], response: &Response) -> usize {
    let squared = |i: usize| {
        let n = op.diagonal(i);
        let trace = n.x_axis.x + n.y_axis.y + n.z_axis.z;
        term(op, i, 3.0 / trace, gamma, response).length_squared() * op.lever(i).powi(2)
    };
    (0..gamma.len()).map(|i| (squared(i), i)).fold((-1.0, 0), |worst, now| if now.0 > worst.0 { now } else { worst }).1
}

/// Whether zero multipliers are the solution.
pub fn is_idle(op: &impl Operator, gamma: &[DVec3], response: &Response) -> bool {
    gamma.iter().all(|g| *g == DVec3::ZERO) && residual(op, gamma, response) == 0.0
}
