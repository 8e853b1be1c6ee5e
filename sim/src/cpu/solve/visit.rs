//! The inner loop of Gauss–Seidel over blocks of one colour: read the gradient, solve the block's own problem, apply the impulse to
//! its bodies.

use super::cells::Cells;
use super::operator::Operator;
use crate::twist::Twist;
use glam::{DMat3, DVec3};

/// Number of projected gradient steps on a block's own 3×3 problem at each visit.
const INNER: usize = 12;

/// Visit blocks of one colour: each minimises the objective over its own cone with the other multipliers fixed. Returns the sum of the
/// squared residual terms `|Δγ/η|²`, m²/s².
///
/// # Safety
/// No other thread touches these blocks, or their moving bodies in the response.
pub unsafe fn visit(
    op: &(impl Operator + ?Sized),
    blocks: &[u32],
    response: &Cells<Twist>,
    gamma: &Cells<DVec3>,
    omega: f64,
) -> f64 {
    let mut residual2 = 0.0;
    for &i in blocks {
        let i = i as usize;
        // SAFETY: the caller's promise, here and below.
        let (gradient, before) = unsafe { (op.gradient_in(response, i), gamma.get(i)) };
        let own = op.diagonal(i);
        let step = 1.0 / largest(&own);
        let mut z = before;
        for _ in 0..INNER {
            let next = unsafe { op.project_in(i, z - (gradient + own * (z - before)) * step, gamma) };
            let moved = (next - z).length_squared();
            z = next;
            if moved <= 1e-24 * z.length_squared() {
                break;
            }
        }
        let d = (z - before) * omega;
        unsafe {
            gamma.set(i, before + d);
            op.apply(response, i, d);
        }
        residual2 += (d / op.eta(i) * op.lever(i)).length_squared();
    }
    residual2
}

/// A bound of the largest eigenvalue: the largest sum of absolute values of a row.
fn largest(m: &DMat3) -> f64 {
    let (x, y, z) = (m.x_axis.abs(), m.y_axis.abs(), m.z_axis.abs());
    (x + y + z).max_element().max(f64::MIN_POSITIVE)
}
