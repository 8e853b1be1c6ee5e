//! The ordered list of stages, and the step that runs them.
//!
//! Each stage is a function over columns in `cpu/<stage>.rs`; the file's head names its inputs and outputs.

use crate::cpu::bin_emit::BinGrid;
use crate::cpu::bounds::Ball;
use crate::cpu::contact_solve::Workspace;
use crate::cpu::contact_write::Touching;
use crate::cpu::pair_write::Pairs;
use crate::cpu::{
    Aabb, bin_emit, bin_start, bounds, contact_solve, contact_write, force, integrate, joint_write, pair_write,
    warm_start,
};
use crate::joint::{JointState, SpringState};
use crate::solve::Outcome;
use crate::state::Arms;
use crate::watch::{Broken, Seen, Warning};
use crate::{Contacts, Model, State};
use glam::DVec3;
use std::time::Instant;

/// The stages of a step in their order; reports and timers go by these names.
pub const STAGES: [&str; 11] = [
    "bounds",
    "bin_emit",
    "bin_sort",
    "bin_start",
    "pair_write",
    "contact_write",
    "warm_start",
    "force",
    "joint_write",
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
    /// What has gone wrong.
    pub warnings: Vec<Warning>,
    /// Why the run cannot go on, if so.
    pub broken: Option<Broken>,
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
    margin: Vec<f32>,
    candidate: Pairs,
    touching: Touching,
    /// Whether `candidate` has the pairs of the state's roomy boxes.
    has_pairs: bool,
    /// Whether nothing but balls moves.
    balls_only: bool,
    last: warm_start::Last,
    solver: Workspace,
}

impl Scratch {
    /// Find the contacts: the stages from `bounds` to `contact_write`; those between the two are passed over while the pairs
    /// of the last time hold. `roomy` has the boxes that the pairs were found for; `contacts` has the last step's, of which `last`
    /// takes what the next start from.
    fn detect(
        &mut self,
        model: &Model,
        state: &State,
        roomy: &mut Vec<Aabb>,
        contacts: &mut Contacts,
        clock: &mut Clock,
    ) {
        // Pairs and tiles hang on what moves.
        if self.solver.masses.look(model) && self.has_pairs {
            roomy.clear();
        }
        if roomy.is_empty() || !self.has_pairs {
            self.balls_only = model.has_balls_only();
        }
        let mut balls = vec![];
        if self.balls_only {
            balls = Ball::rows_in(std::mem::take(&mut self.solver.image.twist), model.n_shapes());
        }
        let left = bounds::run(model, state, &mut self.margin, &mut balls, roomy);
        clock.lap();
        let kept = self.has_pairs && !left;
        if !kept {
            self.find_pairs(model, state, roomy, clock);
            self.has_pairs = true;
        } else {
            clock.pass_to("contact_write");
        }
        self.last.take(contacts, &mut self.touching, kept);
        let Scratch { margin, candidate, touching, .. } = self;
        let at = contact_write::Input { model, state, margin, balls: &balls };
        contact_write::run(&at, candidate, touching, contacts);
        if self.balls_only {
            self.solver.image.twist = bytemuck::cast_vec(balls);
        }
        clock.lap();
    }

    /// The stages from `bin_emit` to `pair_write`. Their bins are not kept: pairs are looked for now and then, and meanwhile the
    /// solver has their memory, whose contacts in turn are let go for them.
    fn find_pairs(&mut self, model: &Model, state: &State, roomy: &[Aabb], clock: &mut Clock) {
        self.solver.methods.forget();
        let mut grid = BinGrid::default();
        grid.choose(model, roomy);
        let (mut pair_start, mut bin, mut shape) = (vec![], vec![], vec![]);
        bin_emit::run(model, roomy, &grid, &mut pair_start, &mut bin, &mut shape);
        clock.lap();
        gpu::radix_sort::sort_cpu(&mut bin, &mut shape, grid.len());
        clock.lap();
        let mut bin_start = vec![];
        bin_start::run(&bin, &mut bin_start);
        clock.lap();
        let input = pair_write::Input {
            model,
            state,
            aabb: roomy,
            grid: &grid,
            bin: &bin,
            shape: &shape,
            bin_start: &bin_start,
        };
        pair_write::run(&input, &mut self.candidate);
        clock.lap();
    }
}

impl Simulation {
    /// Start from a model and a state.
    pub fn new(model: Model, mut state: State) -> Simulation {
        state.joints.resize(model.joints.len(), JointState::default());
        state.springs.resize(model.springs.len(), SpringState::default());
        let mut sim = Simulation { model, state, work: Scratch::default() };
        sim.wake();
        let mut watch = std::mem::take(&mut sim.state.watch);
        watch.start(&sim.model, &sim.state);
        sim.state.watch = watch;
        sim
    }

    /// Take one step of length `model.step`.
    pub fn step(&mut self) -> StepReport {
        // Inside the pool, so that its threads need not be woken by one outside it for every stage.
        let mut report = StepReport::default();
        rayon::scope(|_| report = self.advance());
        report
    }

    fn advance(&mut self) -> StepReport {
        self.wake();
        let (model, state, w) = (&self.model, &mut self.state, &mut self.work);
        let mut clock = Clock::start();

        let (mut contacts, mut roomy) = (std::mem::take(&mut state.contacts), std::mem::take(&mut state.roomy));
        w.detect(model, state, &mut roomy, &mut contacts, &mut clock);
        state.roomy = roomy;
        warm_start::run(model, &mut w.last, &w.touching, &mut contacts);
        clock.lap();
        let balls = matches!(contacts.arms, Arms::Along(_));
        force::run(model, state, balls, &mut w.solver);
        clock.lap();
        joint_write::run(model, state, &mut w.solver);
        clock.lap();
        w.solver.methods.step_length = state.step_length;
        let outcome = contact_solve::run(model, state, &mut contacts, &mut w.solver);
        state.step_length = w.solver.methods.step_length;
        clock.lap();
        state.contacts = contacts;
        joint_write::record(model, state, &mut w.solver);
        integrate::run(model, &w.solver.image.twist, state);
        let mut watch = std::mem::take(&mut state.watch);
        let seen = Seen {
            outcome: &outcome,
            worst: w.solver.worst,
            joints: &w.solver.joint_errors,
            spring_swing: w.solver.spring_swing,
        };
        let (warnings, broken) = watch.look(model, state, &seen);
        state.watch = watch;
        clock.lap();

        report(state, outcome, clock, warnings, broken)
    }

    /// Let bodies appear and move whose time has come.
    fn wake(&mut self) {
        let now = self.state.time + 0.5 * self.model.step;
        for late in &self.model.late {
            let passed = |t: f64| t <= now && now - self.model.step < t;
            if passed(late.appears) || passed(late.moves) {
                // Pairs of what was held in place were not looked for.
                self.state.roomy.clear();
            }
            let b = late.body as usize;
            self.model.absent[b] = now < late.appears;
            let moves = now >= late.moves.max(late.appears);
            self.model.inv_mass[b] = if moves { late.inv_mass } else { 0.0 };
            self.model.inv_inertia[b] = if moves { late.inv_inertia } else { DVec3::ZERO };
        }
    }
}

/// Two bodies that overlap.
pub struct Overlap {
    /// The bodies.
    pub bodies: [u32; 2],
    /// Their shapes.
    pub shapes: [u32; 2],
    /// How deep, m.
    pub depth: f64,
}

/// The overlaps of a state, the deepest of each pair of shapes.
pub fn overlaps(model: &Model, state: &State) -> Vec<Overlap> {
    let mut w = Scratch::default();
    let mut contacts = Contacts::default();
    // What appears later must not overlap then; where that is nobody knows yet.
    w.detect(model, state, &mut vec![], &mut contacts, &mut Clock::start());
    let mut found: Vec<Overlap> = vec![];
    for i in 0..contacts.len() {
        let (depth, [s, t, _]) = (-contacts.gap[i], contacts.key[i]);
        match found.last_mut() {
            _ if depth <= 0.0 => {}
            Some(last) if last.shapes == [s, t] => last.depth = last.depth.max(depth),
            _ => found.push(Overlap { bodies: contacts.bodies[i], shapes: [s, t], depth }),
        }
    }
    found
}

fn report(state: &State, outcome: Outcome, clock: Clock, warnings: Vec<Warning>, broken: Option<Broken>) -> StepReport {
    StepReport {
        step: state.steps,
        time: state.time,
        contacts: state.contacts.len(),
        iterations: outcome.iterations,
        residual: outcome.residual,
        worst_penetration: state.contacts.worst_penetration(),
        stage_ms: clock.ms,
        warnings,
        broken,
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

    /// Leave out the stages before this one.
    fn pass_to(&mut self, stage: &str) {
        self.stage = STAGES.iter().position(|s| *s == stage).expect("a stage's name");
    }

    fn lap(&mut self) {
        let now = Instant::now();
        self.ms[self.stage] = (now - self.last).as_secs_f64() * 1e3;
        self.last = now;
        self.stage += 1;
    }
}
