//! What the stages find out about a step, beside the state that they change.

use crate::joint::Row;
use glam::DVec3;

/// How a solve of the contacts went.
#[derive(Clone, Copy, Debug, Default)]
pub struct Outcome {
    /// Iterations done.
    pub iterations: u32,
    /// `‖(γ − Π(γ − g (Nγ + r))) / g‖₂ / n_blocks` with g = 10⁻³ η: the velocity, m/s, by which contacts still miss their cones;
    /// rolling blocks count with the speed at their radius of gyration.
    pub residual: f64,
}

/// The joints that are off most at a step's start.
#[derive(Clone, Copy, Debug, Default)]
pub struct JointErrors {
    /// A joint and by how much a length is off, m.
    pub length: (usize, f64),
    /// A joint and by how much an angle is off, rad.
    pub angle: (usize, f64),
}

impl JointErrors {
    pub(crate) fn add(&mut self, joint: usize, row: &Row, error: f64) {
        let worst = if row.linear == DVec3::ZERO { &mut self.angle } else { &mut self.length };
        // An error that is not finite is the greatest.
        if !(error <= worst.1) {
            *worst = (joint, error);
        }
    }
}

/// What a step has come to.
#[derive(Clone, Copy, Debug, Default)]
pub struct StepOutcome {
    /// The solver's.
    pub solver: Outcome,
    /// The bodies of the contact whose residual is greatest, where the step's is above [`crate::watch::residual_bound`].
    pub worst: Option<[u32; 2]>,
    /// Errors of the joints.
    pub joints: JointErrors,
    /// h |F·v| of springs that are integrated explicitly, summed, J.
    pub spring_swing: f64,
}
