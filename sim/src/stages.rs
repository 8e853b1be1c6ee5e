//! The ordered list of stages, and the step that runs them.
//!
//! Each stage is a function over columns in `cpu/<stage>.rs`; the file's head names its inputs and outputs.

use crate::cpu::bin_emit::BinGrid;
use crate::cpu::collide::Point;
use crate::cpu::contact_solve::{Outcome, Workspace};
use crate::cpu::{Aabb, bin_emit, bin_start, bounds, contact_solve, contact_write, integrate, pair_write, warm_start};
use crate::{Contacts, Model, State};
use glam::DVec3;
use std::time::Instant;

/// The stages of a step in their order; reports and timers go by these names.
pub const STAGES: [&str; 9] = [
    "bounds",
    "bin_emit",
    "bin_sort",
    "bin_start",
    "pair_write",
    "contact_write",
    "warm_start",
    "contact_solve",
    "integrate",
];

/// What a step did.
#[derive(Clone, Debug, Default)]
pub struct StepReport {
    /// The step's number, from 1.
    pub step: u64,
    /// Time after it, s.
    pub time: f64,
    /// Contacts.
    pub contacts: usize,
    /// Solver iterations.
    pub iterations: u32,
    /// Residual, m/s.
    pub residual: f64,
    /// Worst penetration at the step's start, m.
    pub worst_penetration: f64,
    /// Milliseconds by stage, in the order of [`STAGES`].
    pub stage_ms: [f64; STAGES.len()],
}

/// A model on its way.
pub struct Simulation {
    /// The model.
    pub model: Model,
    /// Its state.
    pub state: State,
    work: Scratch,
}

/// Columns that stages hand to each other within a step, and scratch that is kept from step to step.
#[derive(Default)]
struct Scratch {
    margin: Vec<f64>,
    aabb: Vec<Aabb>,
    pair_start: Vec<u32>,
    bin: Vec<u32>,
    shape: Vec<u32>,
    sort: gpu::radix_sort::Scratch,
    bin_start: Vec<[u32; 2]>,
    candidate: Vec<[u32; 2]>,
    count: Vec<u32>,
    points: Vec<(u32, Point)>,
    old: Contacts,
    solver: Workspace,
    linear: Vec<DVec3>,
    angular: Vec<DVec3>,
}

impl Simulation {
    /// Start from a model and a state.
    pub fn new(model: Model, state: State) -> Simulation {
        Simulation { model, state, work: Scratch::default() }
    }

    /// Take one step of length `model.step`.
    pub fn step(&mut self) -> StepReport {
        let (model, state, w) = (&self.model, &mut self.state, &mut self.work);
        let mut clock = Clock::start();

        bounds::run(model, state, &mut w.margin, &mut w.aabb);
        clock.lap();
        let grid = BinGrid::choose(model, &w.aabb);
        bin_emit::run(model, &w.aabb, &grid, &mut w.pair_start, &mut w.bin, &mut w.shape);
        clock.lap();
        gpu::radix_sort::sort_cpu(&mut w.bin, &mut w.shape, grid.len(), &mut w.sort);
        clock.lap();
        bin_start::run(&w.bin, &mut w.bin_start);
        clock.lap();
        pair_write::run(model, &w.aabb, &grid, &w.bin, &w.shape, &w.bin_start, &mut w.count, &mut w.candidate);
        clock.lap();
        std::mem::swap(&mut state.contacts, &mut w.old);
        let mut contacts = std::mem::take(&mut state.contacts);
        contact_write::run(model, state, &w.candidate, &w.margin, &mut w.count, &mut w.points, &mut contacts);
        clock.lap();
        if model.solver.warm_start {
            warm_start::run(&w.old, &mut contacts);
        } else {
            contacts.gamma = vec![DVec3::ZERO; contacts.len()];
        }
        clock.lap();
        free_velocities(model, state, &mut w.linear, &mut w.angular);
        let outcome = contact_solve::run(model, state, &mut contacts, &mut w.solver, &mut w.linear, &mut w.angular);
        clock.lap();
        state.contacts = contacts;
        integrate::run(model, &w.linear, &w.angular, state);
        clock.lap();

        report(state, outcome, clock)
    }

    /// The first body whose state is no longer a number, if any: a run that has blown up stops there.
    pub fn broken_body(&self) -> Option<usize> {
        let s = &self.state;
        (0..self.model.n_bodies())
            .find(|&b| !(s.position[b].is_finite() && s.velocity[b].is_finite() && s.angular_velocity[b].is_finite()))
    }
}

/// Velocities of the step without contacts: v + h M⁻¹ f, in the world frame. Gyroscopic terms are in `integrate`.
fn free_velocities(model: &Model, state: &State, linear: &mut Vec<DVec3>, angular: &mut Vec<DVec3>) {
    linear.clear();
    angular.clear();
    let gain = |b: usize| if model.inv_mass[b] > 0.0 { model.gravity * model.step } else { DVec3::ZERO };
    linear.extend((0..model.n_bodies()).map(|b| state.velocity[b] + gain(b)));
    angular.extend((0..model.n_bodies()).map(|b| state.orientation[b] * state.angular_velocity[b]));
}

fn report(state: &State, outcome: Outcome, clock: Clock) -> StepReport {
    StepReport {
        step: state.steps,
        time: state.time,
        contacts: state.contacts.len(),
        iterations: outcome.iterations,
        residual: outcome.residual,
        worst_penetration: state.contacts.worst_penetration(),
        stage_ms: clock.ms,
    }
}

/// Milliseconds by stage.
struct Clock {
    last: Instant,
    stage: usize,
    ms: [f64; STAGES.len()],
}

impl Clock {
    fn start() -> Clock {
        Clock { last: Instant::now(), stage: 0, ms: [0.0; STAGES.len()] }
    }

    fn lap(&mut self) {
        let now = Instant::now();
        self.ms[self.stage] = (now - self.last).as_secs_f64() * 1e3;
        self.last = now;
        self.stage += 1;
    }
}
