//! The interface between a cone complementarity problem and the methods. It is private to the CPU back end: the methods of another back
//! end have their own.

use super::cells::Cells;
use super::response::{Extrapolated, Response};
use super::schedule::Colored;
use crate::rows::reduce_chunks;
use crate::twist::Twist;
use glam::{DMat3, DVec3};

/// A symmetric operator N, an offset r and cones; the gradient Nγ + r is evaluated from the response of γ.
pub trait Operator: Sync {
    /// Number of blocks of three multipliers.
    fn n_blocks(&self) -> usize;
    /// The response of γ; it is affine in γ.
    fn response(&mut self, gamma: &[DVec3], out: &mut Response);
    /// Block i of Nγ + r, from γ's response.
    fn gradient(&self, response: &Response, block: usize) -> DVec3;
    /// dᵀNd for the difference of two multipliers, given by their responses.
    fn curvature(&self, a: &Response, b: &Response) -> f64;
    /// Squared norm of a response in the units of the curvature.
    fn energy(&self, response: &Response) -> f64;
    /// A projected step from y = x + β (x − previous): `next = Π(y − t η (N y + r))`. Returns
    /// `[|next − y|²/η, (N y + r)·(next − x)]`, summed. An operator may begin the response of `next` in `to`.
    fn descend(&self, next: &mut [DVec3], from: &Extrapolated, step: f64, _to: &mut Response) -> [f64; 2] {
        reduce_chunks(next, |first, rows| any(self, first, rows, from, step))
    }
    /// After `descend`: the response of `next`, the response of the point extrapolated from `x` and it, and the curvature along
    /// `next` − y.
    fn advance(&mut self, next: &[DVec3], beta: f64, [x, y]: [&Response; 2], [to, to_y]: [&mut Response; 2]) -> f64 {
        advance(self, next, beta, [x, y], [to, to_y])
    }
    /// Project block i onto its cone; `gamma` has the multipliers that the cone's width may depend on.
    fn project(&self, block: usize, value: DVec3, gamma: &[DVec3]) -> DVec3;
    /// Project block i onto its cone, with the multipliers in cells.
    ///
    /// # Safety
    /// No other thread writes the multipliers of the block, or those that its cone's width depends on.
    unsafe fn project_in(&self, block: usize, value: DVec3, gamma: &Cells<DVec3>) -> DVec3;
    /// η of a block: 3/trace(N_ii).
    fn eta(&self, block: usize) -> f64;
    /// Length that converts the velocities of a block to m/s: 1, or m where they are rad/s.
    fn lever(&self, _block: usize) -> f64 {
        1.0
    }
    /// N_ii.
    fn diagonal(&self, block: usize) -> DMat3;
    /// Apply the impulse `d` of a block to the response, without solving the joints.
    ///
    /// # Safety
    /// No other thread touches the entries of the block's moving bodies.
    unsafe fn apply(&self, response: &Cells<Twist>, block: usize, d: DVec3);
    /// Block i of Nγ + r from a response that others may be changing elsewhere.
    ///
    /// # Safety
    /// No other thread writes the entries of the block's bodies.
    unsafe fn gradient_in(&self, response: &Cells<Twist>, block: usize) -> DVec3;
    /// Solve the joints after impulses have been applied.
    fn solve_joints(&mut self, response: &mut Response);
    /// Colour the blocks: blocks of a colour have no response entry in common.
    fn colors(&self, colored: &mut Colored);
    /// Whether the cones are homogeneous, with their tips at zero.
    fn has_homogeneous_cones(&self) -> bool {
        true
    }
    /// Whether no block's cone depends on another's multipliers.
    fn has_independent_cones(&self) -> bool {
        true
    }
    /// The coefficient of friction of a block, and its normal; (0, 0) where it has none.
    fn friction(&self, block: usize) -> (f64, DVec3);
    /// The slip `μ |v_t|` of every block in the last step, if there was one, m/s.
    fn last_slip(&self) -> Option<Vec<f64>> {
        None
    }
    /// Slip of a block below which none is fed back, m/s.
    fn least_slip(&self, _block: usize) -> f64 {
        0.0
    }
    /// Set the slip feedback `μ |v_t|` in the gap's rate of every block (exact friction), m/s.
    fn set_slip_feedback(&mut self, slip: &[f64]);
}

/// A projected step of some blocks: [`Operator::descend`] for any operator.
pub fn any(
    op: &(impl Operator + ?Sized),
    first: usize,
    next: &mut [DVec3],
    from: &Extrapolated,
    step: f64,
) -> [f64; 2] {
    let mut sums = [0.0; 2];
    for (k, z) in next.iter_mut().enumerate() {
        let i = first + k;
        let eta = op.eta(i);
        let y = from.x[i] + (from.x[i] - from.previous[i]) * from.beta;
        let gradient = op.gradient(from.response, i);
        *z = op.project(i, y - gradient * (step * eta), from.x);
        sums[0] += (*z - y).length_squared() / eta;
        sums[1] += gradient.dot(*z - from.x[i]);
    }
    sums
}

/// [`Operator::advance`] for any operator: the response of `next`, that of the extrapolated point, and the curvature, one after the
/// other.
pub fn advance(
    op: &mut (impl Operator + ?Sized),
    next: &[DVec3],
    beta: f64,
    [x, y]: [&Response; 2],
    [to, to_y]: [&mut Response; 2],
) -> f64 {
    op.response(next, to);
    to_y.extrapolate(to, x, beta);
    op.curvature(to, y)
}
