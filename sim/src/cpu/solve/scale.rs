//! Scaling of the starting point.

use super::iterates::Iterates;
use super::operator::Operator;
use super::response::Response;
use crate::rows::{fill_rows, sum_rows};
use glam::DVec3;

/// Scale the starting point to the minimum of the objective along it; cones are preserved. Without it the impulses of an impact in the
/// last step would push bodies back, and after the onset of a load the impulses would stay too small for as many iterations as a
/// stack's slowest mode takes, which is their common factor.
pub fn scale(op: &mut impl Operator, gamma: &mut Vec<DVec3>, response: &mut Response, work: &mut Iterates) {
    /// Factor above which the response is evaluated again, since the effect of small impulses on velocities is rounded.
    const MAX_FACTOR: f64 = 1e3;
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
    let max = if op.has_homogeneous_cones() { f64::INFINITY } else { 1.0 };
    if curvature > 0.0 && factor.is_finite() {
        let factor = factor.clamp(0.0, max);
        fill_rows(next, |i| gamma[i] * factor);
        std::mem::swap(gamma, next);
        if factor > MAX_FACTOR {
            op.response(gamma, response);
        } else {
            response_y.extrapolate(response, response_next, factor - 1.0);
            std::mem::swap(response, response_y);
        }
    }
}
