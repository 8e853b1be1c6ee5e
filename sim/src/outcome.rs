//! Outcomes of a step: iterations, residual and joint errors.

use crate::contacts::Contacts;
use crate::joint::Row;
use crate::pace::Bend;
use crate::state::State;
use glam::DVec3;

/// The outcome of a contact solve.
#[derive(Clone, Copy, Debug, Default)]
pub struct Outcome {
    /// Number of iterations.
    pub iterations: u32,
    /// Residual of the cone complementarity problem, m/s: `‖(γ − Π(γ − g (Nγ + r))) / g‖₂ / n_blocks`. Π is the projection onto the
    /// friction cones, and g = 10⁻³ η, with η_i = 3 / trace(N_ii) for block i. The terms of blocks of rolling and spinning impulses,
    /// rad/s, are multiplied by a radius of gyration.
    pub residual: f64,
}

/// The maximum errors of the joints' locked motions at a step's start.
#[derive(Clone, Copy, Debug, Default)]
pub struct JointErrors {
    /// Id of the joint with the maximum error of a length, and that error, m.
    pub length: (usize, f64),
    /// Id of the joint with the maximum error of an angle, and that error, rad.
    pub angle: (usize, f64),
}

impl JointErrors {
    /// The greater ones of two.
    fn and(self, other: JointErrors) -> JointErrors {
        // An error that is not finite is the maximum.
        let worse = |a: (usize, f64), b: (usize, f64)| if b.1 <= a.1 { a } else { b };
        JointErrors { length: worse(self.length, other.length), angle: worse(self.angle, other.angle) }
    }

    pub(crate) fn add(&mut self, joint: usize, row: &Row, error: f64) {
        let worst = if row.linear == DVec3::ZERO { &mut self.angle } else { &mut self.length };
        // An error that is not finite is the maximum.
        if !(error <= worst.1) {
            *worst = (joint, error);
        }
    }
}

/// The overlap of a step that is the deepest for the sizes of its shapes.
#[derive(Clone, Copy, Debug)]
pub struct Deepest {
    /// Ids of the bodies.
    pub bodies: [u32; 2],
    /// Penetration, m.
    pub depth: f64,
    /// The smaller inradius of the two shapes, m.
    pub inradius: f64,
}

impl Deepest {
    /// The deepest overlap of a state's contacts for the inradii of their shapes, m; none where nothing overlaps.
    pub fn of(state: &State, inradius: impl Fn(usize) -> f64) -> Option<Deepest> {
        let of = |(contacts, i): (&Contacts, usize)| {
            let [s, t, _] = contacts.key[i].map(|k| k as usize);
            Deepest { bodies: contacts.bodies[i], depth: -contacts.gap[i], inradius: inradius(s).min(inradius(t)) }
        };
        let overlaps = state.all_contacts().map(of).filter(|d| d.depth > 0.0);
        overlaps.max_by(|a, b| a.share().total_cmp(&b.share()))
    }

    /// Penetration over the inradius.
    pub fn share(&self) -> f64 {
        self.depth / self.inradius
    }
}

/// The outcome of a step: of its contact solve, its joints and its springs.
#[derive(Clone, Copy, Debug, Default)]
pub struct StepOutcome {
    /// Outcome of the contact solver.
    pub solver: Outcome,
    /// Ids of the bodies of the block with the maximum residual; none if the step's residual is within
    /// [`residual_bound`](crate::watch::residual_bound).
    pub worst: Option<[u32; 2]>,
    /// Number of contacts.
    pub contacts: usize,
    /// Maximum penetration at the step's start, m.
    pub worst_penetration: f64,
    /// The deepest overlap where one may be too deep, as far as the contacts are at hand.
    pub deepest: Option<Deepest>,
    /// Maximum joint errors.
    pub joints: JointErrors,
    /// Bound of the energy oscillation of springs that are integrated explicitly, J: the sum of h |F·v| with the step h, the force F
    /// and its velocity v.
    pub spring_oscillation: f64,
    /// Elastic energy of what springs stretch in the step, from rest, J: what their forces change by in it adds to that oscillation.
    pub spring_stretch: f64,
    /// Work of motors, actuators, loads and changing preloads, J: the sum of the sizes.
    pub work: f64,
    /// What the joints bend.
    pub bend: Bend,
    /// Number of parts in which the step was taken; 0 on a back end that takes none in parts.
    pub parts: u32,
}

impl StepOutcome {
    /// The outcome of this part of a step and the next one.
    pub fn and(self, next: StepOutcome) -> StepOutcome {
        // A residual that is not finite is the greater one.
        let is_worse = self.solver.residual.is_nan() || self.solver.residual > next.solver.residual;
        let (solver, worst) = match is_worse {
            true => (self.solver, self.worst),
            false => (next.solver, next.worst),
        };
        let iterations = self.solver.iterations + next.solver.iterations;
        StepOutcome {
            solver: Outcome { iterations, ..solver },
            worst,
            joints: self.joints.and(next.joints),
            spring_oscillation: self.spring_oscillation.max(next.spring_oscillation),
            spring_stretch: self.spring_stretch.max(next.spring_stretch),
            work: self.work + next.work,
            bend: self.bend.and(next.bend),
            ..next
        }
    }
}
