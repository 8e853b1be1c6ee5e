//! The iterates of a method, and the best of them.

use super::operator::Operator;
use super::residual::residual;
use super::response::Response;
use super::schedule::Colored;
use crate::outcome::Outcome;
use crate::settings::SolverSettings;
use glam::DVec3;

/// The rounding of impulses and of velocities, of their size: some units in the last place.
pub const ROUNDING: f64 = 1e-15;

/// The iterates of the methods, kept from step to step for their memory.
#[derive(Default)]
pub struct Iterates {
    pub previous: Vec<DVec3>,
    pub next: Vec<DVec3>,
    pub best: Vec<DVec3>,
    pub response_next: Response,
    pub response_y: Response,
    pub response_y_next: Response,
    pub response_best: Response,
    /// The blocks by colours, for Gauss–Seidel.
    pub colored: Colored,
    /// The step length of the last APGD; the next begins with it.
    pub step_length: f64,
}

/// The best iterate of a method whose residual does not fall at every step. The residual is looked at now and then, and at the
/// end. The starting point is no candidate: where a blow has just come its mean residual may be less than that of iterates that
/// have begun to spread it.
pub struct Best {
    outcome: Outcome,
    /// Whether the iterate that was looked at last is the best.
    is_current: bool,
}

impl Best {
    /// Iterations between looks at the residual, and where no residual is good enough to stop at.
    const LOOK: [u32; 2] = [10, 25];

    /// None yet.
    pub fn new() -> Best {
        Best { outcome: Outcome { iterations: 0, residual: f64::INFINITY }, is_current: true }
    }

    /// Look at the iterate after `done` iterations, if it is time; whether it is good enough.
    pub fn look(
        &mut self,
        op: &impl Operator,
        settings: &SolverSettings,
        done: u32,
        (gamma, response): (&[DVec3], &Response),
        (kept, kept_image): (&mut Vec<DVec3>, &mut Response),
    ) -> bool {
        let last = done >= settings.max_iterations(gamma.len());
        if !done.is_multiple_of(Self::LOOK[(settings.tolerance <= 0.0) as usize]) && !last {
            return false;
        }
        self.compare(Outcome { iterations: done, residual: residual(op, gamma, response) });
        let is_enough = self.is_current && self.outcome.residual <= settings.tolerance;
        if self.is_current && !is_enough && !last {
            kept.clear();
            kept.extend_from_slice(gamma);
            kept_image.copy_from(response);
        }
        is_enough
    }

    /// Compare an iterate with the best one, of those whose residual is finite.
    pub fn compare(&mut self, outcome: Outcome) {
        self.is_current = outcome.residual <= self.outcome.residual || !self.outcome.residual.is_finite();
        if self.is_current {
            self.outcome = outcome;
        }
    }

    /// Put the best iterate back where it is not the last one.
    pub fn finish(self, done: u32, gamma: &mut [DVec3], response: &mut Response, work: &Iterates) -> Outcome {
        if !self.is_current {
            gamma.copy_from_slice(&work.best);
            response.copy_from(&work.response_best);
        }
        Outcome { iterations: done, residual: self.outcome.residual }
    }
}
