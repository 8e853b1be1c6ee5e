//! Measures of a run of a workload, the same for all engines: penetration, and how far bodies have moved.

use crate::outcome::Deepest;
use crate::simulation::{Simulation, StepReport};
use crate::state::State;
use glam::DVec3;

/// The measures of a run, taken step by step.
pub struct Measure {
    /// Maximum penetration of a step so far over the smaller inradius of the two shapes.
    pub worst: f64,
    /// Positions of the bodies at the start, m.
    start: Vec<DVec3>,
    /// Inradii of the shapes, m, and the least of them.
    inradius: Vec<f64>,
    least: f64,
}

impl Measure {
    /// The measures of a simulation that starts now.
    pub fn new(sim: &Simulation) -> Measure {
        let inradius: Vec<f64> = (0..sim.model.n_shapes()).map(|s| sim.model.inradius(s)).collect();
        let least = inradius.iter().copied().fold(f64::INFINITY, f64::min);
        Measure { worst: 0.0, start: sim.state.position.clone(), inradius, least }
    }

    /// Note the penetration of a step. The contacts are looked at only where it may be the greatest, so that a run is not slowed.
    pub fn note(&mut self, state: &State, report: &StepReport) {
        if report.worst_penetration > self.worst * self.least {
            self.worst = self.worst.max(self.penetration(state));
        }
    }

    /// Maximum penetration of the contacts of the last step over the smaller inradius of the two shapes; 0 where nothing overlaps.
    pub fn penetration(&self, state: &State) -> f64 {
        Deepest::of(state, |s| self.inradius[s]).map_or(0.0, |deepest| deepest.share())
    }

    /// Greatest distances of a body from where it was at the start, m: across gravity, and along it.
    pub fn drift_and_drop(&self, sim: &Simulation) -> [f64; 2] {
        let down = sim.model.gravity.normalize_or_zero();
        let moved = sim.state.position.iter().zip(&self.start).map(|(now, before)| *now - *before);
        moved.fold([0.0f64; 2], |[drift, drop], moved| {
            let fallen = moved.dot(down);
            [drift.max((moved - down * fallen).length()), drop.max(fallen)]
        })
    }
}
