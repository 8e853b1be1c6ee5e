//! A simulation: the step, which runs the stages of a back end.

use crate::backend::Backend;
use crate::cpu::Cpu;
use crate::joint::{JointState, SpringState};
use crate::model::Model;
use crate::plan::StepPlan;
use crate::stages::{Stage, check};
use crate::state::State;
use crate::warning::{Broken, Warning};
use std::time::Instant;

/// The report of a step.
#[derive(Clone, Debug, Default)]
pub struct StepReport {
    /// Number of the step, from 1.
    pub step: u64,
    /// Time at the step's end, s.
    pub time: f64,
    /// Number of contacts.
    pub contacts: usize,
    /// Number of solver iterations.
    pub iterations: u32,
    /// Residual of the contact solver, m/s, as in [`Outcome::residual`](crate::Outcome::residual).
    pub residual: f64,
    /// Maximum penetration at the step's start, m.
    pub worst_penetration: f64,
    /// Wall time of each stage, ms, in the order of [`Stage::ALL`]; 0 for a stage that was skipped.
    pub stage_ms: [f64; Stage::ALL.len()],
    /// Warnings of the step.
    pub warnings: Vec<Warning>,
    /// Reason why the run cannot go on; none if it can.
    pub broken: Option<Broken>,
}

/// A simulation: a model and its state. The model is constant but for its solver settings, which may be changed between steps.
pub struct Simulation {
    /// The model.
    pub model: Model,
    /// The state.
    pub state: State,
    plan: StepPlan,
    backend: Box<dyn Backend>,
}

impl Simulation {
    /// A simulation of a model from a state, on the CPU back end.
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

    /// Name of the back end, as in `run.json`.
    pub fn backend(&self) -> &'static str {
        self.backend.name()
    }

    /// Take one step of length `model.step`.
    ///
    /// # Panics
    /// Debug builds check the columns as [`Simulation::checked_step`] does, and panic at a fault, which is a defect of the back end.
    pub fn step(&mut self) -> StepReport {
        self.in_pool(cfg!(debug_assertions)).expect("valid columns")
    }

    /// Take one step of length `model.step`, and check the columns after every stage that has run.
    ///
    /// # Errors
    /// The first fault that [`stages::check`](crate::stages::check) finds.
    pub fn checked_step(&mut self) -> Result<StepReport, String> {
        self.in_pool(true)
    }

    fn in_pool(&mut self, is_checked: bool) -> Result<StepReport, String> {
        // Inside the thread pool: a thread outside it would wake the pool's threads in every stage.
        let mut result = Ok(StepReport::default());
        rayon::scope(|_| result = self.advance(is_checked));
        result
    }

    fn advance(&mut self, is_checked: bool) -> Result<StepReport, String> {
        let Simulation { model, state, plan, backend } = self;
        if state.wake(model) || !plan.is_current(model) {
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
                if is_checked {
                    check(stage, model, plan, state, |column| backend.column(state, column))?;
                }
            }
            last = Instant::now();
        }
        let outcome = backend.outcome();
        let mut watch = std::mem::take(&mut state.watch);
        let (warnings, broken) = watch.check(model, state, &outcome);
        state.watch = watch;
        Ok(StepReport {
            step: state.steps,
            time: state.time,
            contacts: state.contacts.len(),
            iterations: outcome.solver.iterations,
            residual: outcome.solver.residual,
            worst_penetration: state.contacts.worst_penetration(),
            stage_ms,
            warnings,
            broken,
        })
    }
}
