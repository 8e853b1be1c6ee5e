//! Scaling of the starting point.

use super::iterates::Iterates;
use super::operator::Operator;
use super::residual::sum_of_lengths;
use super::response::Response;
use crate::rows::{fill_rows, sum_rows};
use glam::DVec3;

/// Scale the starting point to the minimum of the objective along it; cones are preserved. Without it the impulses of an impact in the
/// last step would push bodies back, and after the onset of a load the impulses would stay too small for as many iterations as a stack's
/// slowest mode takes, which is their common factor.
///
/// In a bed at rest the factor is near 1 and follows the slight errors of the last step; or it follows a single grain that falls, whose
/// energy is more than that of all that rest. Where there are fewer iterations than blocks, they would not undo what the factor disturbs
/// everywhere: the starting point stays as it is, unless the whole changes and the residual of most blocks becomes less.
pub fn scale(
    op: &mut impl Operator,
    max_iterations: u32,
    gamma: &mut Vec<DVec3>,
    response: &mut Response,
    work: &mut Iterates,
) {
    /// Factor above which the response is evaluated again, since the effect of small impulses on velocities is rounded.
    const MAX_FACTOR: f64 = 1e3;
    /// Change of the factor that is near 1.
    const NEAR: f64 = 0.1;
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
        let is_large = gamma.len() > max_iterations as usize;
        if is_large && (factor - 1.0).abs() <= NEAR {
            return;
        }
        fill_rows(next, |i| gamma[i] * factor);
        if factor > MAX_FACTOR {
            op.response(next, response_y);
        } else {
            response_y.extrapolate(response, response_next, factor - 1.0);
        }
        if is_large && sum_of_lengths(op, gamma, response) < sum_of_lengths(op, next, response_y) {
            return;
        }
        std::mem::swap(gamma, next);
        std::mem::swap(response, response_y);
    }
}
