//! The slip of contacts that is fed back to their gaps' rates, for Coulomb's law itself.

use super::operator::Operator;
use super::response::Response;
use crate::rows::{CHUNK, fill_rows};
use crate::settings::SolverSettings;
use glam::DVec3;
use rayon::prelude::*;

/// Slip that a solved problem may be wrong by, over the root mean square of its contacts' errors.
pub const KNOWN: f64 = 50.0;

/// Slip that a solved problem is known to, m/s: the tolerance is of the norm over the number of blocks.
pub fn known(settings: &SolverSettings, n_blocks: usize) -> f64 {
    KNOWN * settings.tolerance * (n_blocks as f64).sqrt()
}

/// Set the slip feedback to the slip of an iterate of Jacobi, from its response.
pub fn set_feedback(op: &mut impl Operator, settings: &SolverSettings, gamma: &[DVec3], response: &Response) {
    let mut slip = measure(op, response, gamma.len());
    leave_out_creep(op, gamma, known(settings, gamma.len()), &mut slip);
    op.set_slip_feedback(&slip);
}

/// Slip μ |v_t| of every block, m/s, from the response of γ, without the slip feedback.
pub fn measure(op: &impl Operator, response: &Response, n_blocks: usize) -> Vec<f64> {
    let mut slip = vec![0.0; n_blocks];
    fill_rows(&mut slip, |i| of_block(op, i, op.gradient(response, i)));
    slip
}

/// Slip μ |v_t| of a block with the gradient `v`, m/s.
#[inline]
pub fn of_block(op: &impl Operator, i: usize, v: DVec3) -> f64 {
    let (mu, normal) = op.friction(i);
    mu * (v - normal * v.dot(normal)).length()
}

/// Leave out the slip of blocks that hardly slip, and of those that stick, whose multipliers are within their cones: it is that of the
/// solver's errors, which are at most `errors`, m/s, and what is fed back for it would shake what rests. All is fed from twice the least
/// slip on.
pub fn leave_out_creep(op: &impl Operator, gamma: &[DVec3], errors: f64, slip: &mut [f64]) {
    /// Share of the cone's width from which on a block slides.
    const SLIDES: f64 = 0.99;
    slip.par_iter_mut().with_min_len(CHUNK).enumerate().for_each(|(i, slip)| {
        let (mu, normal) = op.friction(i);
        let least = op.least_slip(i).min(mu * errors);
        let along = gamma[i].dot(normal);
        let sticks = least > 0.0 && (gamma[i] - normal * along).length() < SLIDES * mu * along;
        if sticks {
            *slip = 0.0;
        } else if *slip < 2.0 * least {
            *slip *= ((*slip - least) / least).max(0.0);
        }
    });
}
