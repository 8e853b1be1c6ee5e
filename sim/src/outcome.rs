//! Outcomes of a step: iterations, residual and joint errors.

use crate::joint::Row;
use glam::DVec3;

/// The outcome of a contact solve.
#[derive(Clone, Copy, Debug, Default)]
pub struct Outcome {
    /// Number of iterations.
    pub iterations: u32,
    /// Residual of the cone complementarity problem, m/s: `‖(γ − Π(γ − g (Nγ + r))) / g‖₂ / n_blocks` with g = 10⁻³ η; terms of rolling
    /// blocks, rad/s, are multiplied by their radius of gyration.
    pub residual: f64,
}

/// The maximum joint errors at a step's start.
#[derive(Clone, Copy, Debug, Default)]
pub struct JointErrors {
    /// Id of the joint with the maximum error of a length, and the error, m.
    pub length: (usize, f64),
    /// Id of the joint with the maximum error of an angle, and the error, rad.
    pub angle: (usize, f64),
}

impl JointErrors {
    pub(crate) fn add(&mut self, joint: usize, row: &Row, error: f64) {
        let worst = if row.linear == DVec3::ZERO { &mut self.angle } else { &mut self.length };
        // An error that is not finite is the maximum.
        if !(error <= worst.1) {
            *worst = (joint, error);
        }
    }
}

/// The outcome of a step.
#[derive(Clone, Copy, Debug, Default)]
pub struct StepOutcome {
    /// Outcome of the contact solver.
    pub solver: Outcome,
    /// Bodies of the block with the maximum residual, where the step's is above [`crate::watch::residual_bound`].
    pub worst: Option<[u32; 2]>,
    /// Maximum joint errors.
    pub joints: JointErrors,
    /// Bound of the energy oscillation of springs that are integrated explicitly: h |F·v|, summed, J.
    pub spring_oscillation: f64,
}
