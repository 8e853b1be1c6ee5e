//! A model on its way: the step, which runs the stages of a back end.

use crate::backend::Backend;
use crate::cpu::Cpu;
use crate::joint::{JointState, SpringState};
use crate::model::Model;
use crate::plan::StepPlan;
use crate::stages::{Stage, check};
use crate::state::State;
use crate::warning::{Broken, Warning};
use std::time::Instant;

/// What a step did.
#[derive(Clone, Debug, Default)]
pub struct StepReport {
    /// The step, from 1.
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
    /// Milliseconds by stage, in the order of [`Stage::ALL`]; 0 for a stage that did not have to run.
    pub stage_ms: [f64; Stage::ALL.len()],
    /// What has gone wrong.
    pub warnings: Vec<Warning>,
    /// Why the run cannot go on, if so.
    pub broken: Option<Broken>,
}

/// A model on its way. The model is constant, but for its solver's settings, which may be changed between steps.
pub struct Simulation {
    /// The model.
    pub model: Model,
    /// Its state.
    pub state: State,
    plan: StepPlan,
    backend: Box<dyn Backend>,
}

impl Simulation {
    /// Start from a model and a state, on the CPU.
    pub fn new(model: Model, mut state: State) -> Simulation {
        state.joints.resize(model.joints.len(), JointState::default());
        state.springs.resize(model.springs.len(), SpringState::default());
        state.wake(&model);
        let mut watch = std::mem::take(&mut state.watch);
        watch.start(&model, &state);
        state.watch = watch;
        let plan = StepPlan::resolve(&model, &state);
        let mut backend = Box::new(Cpu::default());
        backend.prepare(&model, &state, &plan);
        Simulation { model, state, plan, backend }
    }

    /// The name of the back end.
    pub fn backend(&self) -> &'static str {
        self.backend.name()
    }

    /// Take one step of length `model.step`.
    pub fn step(&mut self) -> StepReport {
        // Inside the pool, so that its threads need not be woken by one outside it for every stage.
        let mut report = StepReport::default();
        rayon::scope(|_| report = self.advance());
        report
    }

    fn advance(&mut self) -> StepReport {
        let Simulation { model, state, plan, backend } = self;
        if state.wake(model) || !plan.holds(model) {
            *plan = StepPlan::resolve(model, state);
            backend.prepare(model, state, plan);
        }
        let mut stage_ms = [0.0; Stage::ALL.len()];
        let mut last = Instant::now();
        for (stage, ms) in Stage::ALL.into_iter().zip(&mut stage_ms) {
            let has_run = backend.run(stage, model, plan, state);
            let now = Instant::now();
            if has_run {
                *ms = (now - last).as_secs_f64() * 1e3;
                if cfg!(debug_assertions) {
                    check(stage, model, plan, state, |column| backend.column(state, column)).expect("sound columns");
                }
            }
            last = now;
        }
        let outcome = backend.outcome();
        let mut watch = std::mem::take(&mut state.watch);
        let (warnings, broken) = watch.look(model, state, &outcome);
        state.watch = watch;
        StepReport {
            step: state.steps,
            time: state.time,
            contacts: state.contacts.len(),
            iterations: outcome.solver.iterations,
            residual: outcome.solver.residual,
            worst_penetration: state.contacts.worst_penetration(),
            stage_ms,
            warnings,
            broken,
        }
    }
}
