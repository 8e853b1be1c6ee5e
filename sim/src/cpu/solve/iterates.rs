//! The iterates of a method, and the best of them.

use super::operator::Operator;
use super::residual::residual;
use super::response::Response;
use super::schedule::Colored;
use crate::outcome::Outcome;
use crate::settings::SolverSettings;
use glam::DVec3;

/// Relative rounding error of impulses and of velocities: a few units in the last place.
pub const ROUNDING: f64 = 1e-15;

/// The iterates of the methods, which keep their memory from step to step.
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
    /// Step length of the last APGD solve, from which the next one starts.
    pub step_length: f64,
}

/// The best iterate of a method that is not monotone in the residual, which is evaluated at intervals and at the end. The starting
/// point is no candidate: after an impact its mean residual may be below that of iterates that have begun to distribute the impulse.
pub struct Best {
    outcome: Outcome,
    /// Whether the last iterate that was checked is the best.
    is_current: bool,
}

impl Best {
    /// Iterations between checks of the residual, with a tolerance and without one.
    const CHECK_INTERVAL: [u32; 2] = [10, 25];

    /// A best iterate that is not found yet.
    pub fn new() -> Best {
        Best { outcome: Outcome { iterations: 0, residual: f64::INFINITY }, is_current: true }
    }

    /// Check the iterate after `done` iterations, if the interval is over. Returns whether its residual is within the tolerance.
    pub fn check(
        &mut self,
        op: &impl Operator,
        settings: &SolverSettings,
        done: u32,
        (gamma, response): (&[DVec3], &Response),
        (kept, kept_response): (&mut Vec<DVec3>, &mut Response),
    ) -> bool {
        let last = done >= settings.max_iterations(gamma.len());
        if !done.is_multiple_of(Self::CHECK_INTERVAL[(settings.tolerance <= 0.0) as usize]) && !last {
            return false;
        }
        self.compare(Outcome { iterations: done, residual: residual(op, gamma, response) });
        let has_converged = self.is_current && self.outcome.residual <= settings.tolerance;
        if self.is_current && !has_converged && !last {
            kept.clear();
            kept.extend_from_slice(gamma);
            kept_response.copy_from(response);
        }
        has_converged
    }

    /// Compare an iterate with the best one so far.
    pub fn compare(&mut self, outcome: Outcome) {
        self.is_current = outcome.residual <= self.outcome.residual || !self.outcome.residual.is_finite();
        if self.is_current {
            self.outcome = outcome;
        }
    }

    /// Restore the best iterate if it is not the last one.
    pub fn finish(self, done: u32, gamma: &mut [DVec3], response: &mut Response, work: &Iterates) -> Outcome {
        if !self.is_current {
            gamma.copy_from_slice(&work.best);
            response.copy_from(&work.response_best);
        }
        Outcome { iterations: done, residual: self.outcome.residual }
    }
}
