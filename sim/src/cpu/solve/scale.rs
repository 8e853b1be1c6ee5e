//! The scale of a starting point.

use super::iterates::Iterates;
use super::operator::Operator;
use super::response::Response;
use crate::rows::{fill_rows, sum_rows};
use glam::DVec3;

/// Scale the starting point so that the objective is least along it, which can only lessen it: cones are kept. Impulses of the
/// last step that stopped a fall would otherwise push back, and those of a load that has just come would be too small for as
/// many iterations as a stack's slowest mode takes, which is the common factor of its impulses.
pub fn scale(op: &mut impl Operator, gamma: &mut Vec<DVec3>, response: &mut Response, work: &mut Iterates) {
    /// Beyond this factor the response is evaluated again: what small impulses add to velocities is rounded.
    const FAR: f64 = 1e3;
    if gamma.iter().all(|g| *g == DVec3::ZERO) {
        return;
    }
    let Iterates { next, response_next, response_y, .. } = work;
    next.clear();
    next.resize(gamma.len(), DVec3::ZERO);
    op.response(next, response_next);
    // γᵀNγ, and γᵀ(Nγ + r).
    let curvature = op.curvature(response, response_next);
    let [slope] = sum_rows(gamma.len(), |i| [gamma[i].dot(op.gradient(response, i))]);
    let factor = 1.0 - slope / curvature;
    let most = if op.has_open_cones() { f64::INFINITY } else { 1.0 };
    if curvature > 0.0 && factor.is_finite() {
        let factor = factor.clamp(0.0, most);
        fill_rows(next, |i| gamma[i] * factor);
        std::mem::swap(gamma, next);
        if factor > FAR {
            op.response(gamma, response);
        } else {
            response_y.extrapolate(response, response_next, factor - 1.0);
            std::mem::swap(response, response_y);
        }
    }
}
