//! A simulation: the step, on a back end.

use crate::backend::Backend;
use crate::cpu::Cpu;
use crate::gpu::{Fault, Gpu, Usage};
use crate::joint::{JointState, SpringState};
use crate::model::Model;
use crate::model_file::Probes;
use crate::outcome::{Deepest, StepOutcome};
use crate::parts::{self, Kept, Ran, StageTimes, run_stages};
use crate::plan::StepPlan;
use crate::probe::{self, Sums};
use crate::stages::Stage;
use crate::state::State;
use crate::warning::{Broken, Warning};
use crate::{sleep, watch};

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
    /// Number of parts in which the step was taken ([`Bend`](crate::Bend)).
    pub parts: u32,
    /// Wall time of each stage, ms, in the order of [`Stage::ALL`]; 0 for a stage that was skipped.
    pub stage_ms: [f64; Stage::ALL.len()],
    /// Warnings of the step.
    pub warnings: Vec<Warning>,
    /// What is to be known of it and is no fault: the first motor in the run that does not reach what it prescribes with its maximum effort, or the
    /// first step that is taken in parts.
    pub note: Option<Warning>,
    /// Reason why the run cannot go on; none if it can.
    pub broken: Option<Broken>,
}

/// A simulation: a model and its state. The model is constant but for its solver settings, which may be changed between steps.
pub struct Simulation {
    /// The model.
    pub model: Model,
    /// The state. Of a simulation on a graphics device, its time; its columns once they are fetched.
    pub state: State,
    plan: StepPlan,
    engine: Engine,
}

/// The back ends.
enum Engine {
    Cpu(Box<Cpu>),
    Gpu(Box<Gpu>),
    /// The first stages on the processor, the others on a graphics device.
    Split(Box<Cpu>, Box<Gpu>),
}

/// Why a step cannot be taken.
#[derive(Debug)]
pub enum StepFault {
    /// A column is not what the table of columns says: a defect of the back end.
    Columns(String),
    /// The graphics device failed, or the model has come to what it cannot do.
    Device(Fault),
}

impl std::fmt::Display for StepFault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            StepFault::Columns(why) => f.write_str(why),
            StepFault::Device(fault) => fault.fmt(f),
        }
    }
}

impl From<Fault> for StepFault {
    fn from(fault: Fault) -> StepFault {
        StepFault::Device(fault)
    }
}

impl Simulation {
    /// A simulation of a model from a state, on the CPU back end.
    pub fn new(model: Model, state: State) -> Simulation {
        Simulation::on_cpu(model, state, Cpu::default())
    }

    /// A simulation with all contacts that a device makes.
    #[cfg(test)]
    pub(crate) fn with_all_contacts(model: Model, state: State) -> Simulation {
        Simulation::on_cpu(model, state, Cpu::before_device())
    }

    fn on_cpu(mut model: Model, state: State, cpu: Cpu) -> Simulation {
        let (state, plan) = begin(&mut model, state);
        let mut cpu = Box::new(cpu);
        cpu.prepare(&model, &state, &plan);
        Simulation { model, state, plan, engine: Engine::Cpu(cpu) }
    }

    /// A simulation of a model from a state, on a graphics device.
    ///
    /// # Errors
    /// [`Fault`]: what of the model no kernel is built for, or a fault of the device.
    pub fn on_device(model: Model, state: State, device: gpu::Device) -> Result<Simulation, Fault> {
        Simulation::on_device_from(Stage::Bounds, model, state, device)
    }

    /// A simulation of a model from a state, whose stages from `from` on run on a graphics device and those before it on the processor. The
    /// state goes to the device and back in each step.
    ///
    /// # Errors
    /// Those of [`Simulation::on_device`].
    pub fn on_device_from(
        from: Stage,
        mut model: Model,
        state: State,
        device: gpu::Device,
    ) -> Result<Simulation, Fault> {
        let (state, plan) = begin(&mut model, state);
        let gpu = Box::new(Gpu::new(device, &model, &state, (&plan, from))?);
        let engine = if from == Stage::Bounds {
            Engine::Gpu(gpu)
        } else {
            let mut cpu = Box::new(Cpu::before_device());
            cpu.prepare(&model, &state, &plan);
            Engine::Split(cpu, gpu)
        };
        Ok(Simulation { model, state, plan, engine })
    }

    /// A simulation of the same model on the same back end, from another state.
    ///
    /// # Errors
    /// Those of [`Simulation::on_device`].
    pub fn restart(self, state: State) -> Result<Simulation, Fault> {
        match self.engine {
            Engine::Cpu(_) => Ok(Simulation::new(self.model, state)),
            Engine::Gpu(gpu) | Engine::Split(_, gpu) => {
                Simulation::on_device_from(gpu.from(), self.model, state, gpu.into_device())
            }
        }
    }

    /// Name of the back end, as in `run.json`.
    pub fn backend(&self) -> &'static str {
        match &self.engine {
            Engine::Cpu(cpu) => cpu.name(),
            Engine::Gpu(_) | Engine::Split(..) => "gpu",
        }
    }

    /// What the graphics device has been used for so far; none on the CPU.
    pub fn device_usage(&self) -> Option<Usage> {
        match &self.engine {
            Engine::Cpu(_) => None,
            Engine::Gpu(gpu) | Engine::Split(_, gpu) => Some(gpu.usage()),
        }
    }

    /// Name of the graphics adapter with its driver; none on the CPU.
    pub fn adapter(&self) -> Option<String> {
        match &self.engine {
            Engine::Cpu(_) => None,
            Engine::Gpu(gpu) | Engine::Split(_, gpu) => Some(gpu.adapter()),
        }
    }

    /// Bring the columns of the state up to date, which on a graphics device they are not after a step.
    ///
    /// # Errors
    /// [`Fault::Gpu`].
    pub fn fetch(&mut self) -> Result<(), Fault> {
        match &mut self.engine {
            Engine::Cpu(_) => Ok(()),
            Engine::Gpu(gpu) | Engine::Split(_, gpu) => gpu.fetch(&self.model, &mut self.state),
        }
    }

    /// Bring the poses and velocities of the state up to date, as a table of the bodies needs them.
    ///
    /// # Errors
    /// [`Fault::Gpu`].
    pub fn fetch_bodies(&mut self) -> Result<(), Fault> {
        match &mut self.engine {
            Engine::Cpu(_) => Ok(()),
            Engine::Gpu(gpu) | Engine::Split(_, gpu) => gpu.fetch_bodies(&mut self.state),
        }
    }

    /// Line of `probes.csv` at the state's time, with its line break. A graphics device sums where the columns are: they stay there.
    ///
    /// # Errors
    /// [`Fault::Gpu`].
    pub fn probe_line(&mut self, probes: &Probes) -> Result<String, Fault> {
        let sums = match &mut self.engine {
            Engine::Gpu(gpu) => gpu.probe(&self.model, &mut self.state, probes)?,
            Engine::Cpu(_) | Engine::Split(..) => None,
        };
        let sums = match sums {
            Some(sums) => sums,
            None => {
                self.fetch()?;
                Sums::of(&self.model, &self.state, probes)
            }
        };
        Ok(probe::probe_line(&self.model, &self.state, probes, &sums))
    }

    /// Take one step of length `model.step`.
    ///
    /// # Panics
    /// Debug builds check the columns as [`Simulation::checked_step`] does, and panic at a fault, which is a defect of the back end. So does
    /// a fault of a graphics device: [`Simulation::try_step`] returns it.
    pub fn step(&mut self) -> StepReport {
        self.try_step().unwrap_or_else(|fault| panic!("{fault}"))
    }

    /// Take one step of length `model.step`.
    ///
    /// # Errors
    /// A fault of the graphics device; in debug builds, a defect of the back end.
    pub fn try_step(&mut self) -> Result<StepReport, StepFault> {
        self.in_pool(cfg!(debug_assertions))
    }

    /// Take one step of length `model.step`, and check the columns after every stage that has run.
    ///
    /// # Errors
    /// The first fault that [`stages::check`](crate::stages::check) finds.
    pub fn checked_step(&mut self) -> Result<StepReport, String> {
        self.in_pool(true).map_err(|fault| fault.to_string())
    }

    fn in_pool(&mut self, is_checked: bool) -> Result<StepReport, StepFault> {
        // Inside the thread pool: a thread outside it would wake the pool's threads in every stage.
        let mut result = Ok(StepReport::default());
        rayon::scope(|_| result = self.advance(is_checked));
        result
    }

    fn advance(&mut self, is_checked: bool) -> Result<StepReport, StepFault> {
        let Simulation { model, state, plan, engine } = self;
        let times = [start_of_last(model, state), state.time];
        let excludes_others = model.excludes_others(times) && model.exclude(state.time);
        if excludes_others {
            // Pairs of other bodies are looked for.
            if let Engine::Gpu(gpu) | Engine::Split(_, gpu) = engine {
                gpu.fetch(model, state)?;
            }
            state.fat_aabb = None;
        }
        let has_changed = state.wake(model) || excludes_others;
        let has_woken = sleep::rouse_driven(model, state, has_changed) || excludes_others;
        if has_woken || has_changed || !plan.is_current(model) {
            *plan = StepPlan::resolve(model, state);
            match engine {
                Engine::Cpu(cpu) => cpu.prepare(model, state, plan),
                Engine::Gpu(gpu) if has_woken => gpu.renew(model, state, plan)?,
                Engine::Gpu(gpu) => gpu.prepare(model, state, plan)?,
                Engine::Split(cpu, gpu) => {
                    cpu.prepare(model, state, plan);
                    if has_woken { gpu.renew(model, state, plan)? } else { gpu.prepare(model, state, plan)? }
                }
            }
        }
        let (stage_ms, outcome, watched) = match engine {
            Engine::Cpu(cpu) => {
                let stepped = parts::step(cpu, (model, plan), state, is_checked);
                let (stage_ms, outcome) = stepped.map_err(StepFault::Columns)?;
                (stage_ms, outcome_of(outcome, model, state), None)
            }
            Engine::Gpu(gpu) => {
                // Sleep is found in the columns of the state.
                let sleeps = model.solver.sleep.is_some() || !state.sleepers.are_none();
                let mut stepped = gpu.step(model, plan, state)?;
                if sleeps {
                    gpu.fetch(model, state)?;
                    stepped.outcome.contacts += state.sleepers.contacts.len();
                    stepped.outcome.worst_penetration = state.worst_penetration();
                }
                (stepped.stage_ms, stepped.outcome, Some(stepped.survey))
            }
            Engine::Split(cpu, gpu) => split_step((cpu, gpu), (model, plan), state, is_checked)?,
        };
        let mut watch = std::mem::take(&mut state.watch);
        let survey = watched.unwrap_or_else(|| watch.survey(model, state));
        let (warnings, broken) = watch.check(model, state, (&outcome, &survey));
        let note = watch.note(model, state, &outcome);
        state.watch = watch;
        if let Some(speed) = model.solver.sleep
            && sleep::fall_asleep(model, state, speed)
        {
            match engine {
                Engine::Cpu(cpu) => cpu.prepare(model, state, plan),
                Engine::Gpu(gpu) => gpu.renew(model, state, plan)?,
                Engine::Split(cpu, gpu) => {
                    cpu.prepare(model, state, plan);
                    gpu.renew(model, state, plan)?;
                }
            }
        }
        Ok(StepReport {
            step: state.steps,
            time: state.time,
            contacts: outcome.contacts,
            iterations: outcome.solver.iterations,
            residual: outcome.solver.residual,
            worst_penetration: outcome.worst_penetration,
            parts: outcome.parts.max(1),
            stage_ms,
            warnings,
            note,
            broken,
        })
    }
}

/// Time at which the last step began, s; of the start that of one before it.
fn start_of_last(model: &Model, state: &State) -> f64 {
    (state.steps as f64 - 1.0) * model.step
}

/// The state with which a simulation begins, and its plan.
fn begin(model: &mut Model, mut state: State) -> (State, StepPlan) {
    if state.steps > 0 {
        // Those of the last step, whose contacts the state has.
        model.exclude(start_of_last(model, &state));
    }
    state.joints.resize(model.joints.len(), JointState::default());
    state.springs.resize(model.springs.len(), SpringState::default());
    // What a later state wakes is woken by its step, as in a run that goes on.
    if state.activity.len() != model.n_bodies() {
        state.wake(model);
    }
    let mut watch = std::mem::take(&mut state.watch);
    watch.start(model, &state);
    state.watch = watch;
    let plan = StepPlan::resolve(model, &state);
    (state, plan)
}

/// The outcome of a step of the CPU back end, all of whose stages have run, with what the state's contacts tell.
fn outcome_of(outcome: StepOutcome, model: &Model, state: &mut State) -> StepOutcome {
    let contacts = state.contacts.len() + state.sleepers.contacts.len();
    let worst_penetration = state.worst_penetration();
    let may_be_deep = state.watch.may_be_deep(model, worst_penetration);
    let deepest = if may_be_deep { Deepest::of(state, |s| model.inradius(s)) } else { None };
    StepOutcome { contacts, worst_penetration, deepest, ..outcome }
}

/// Times of the stages, ms, the outcome of a step, and the survey of its bodies where a device has one.
type Watched = (StageTimes, StepOutcome, Option<watch::Survey>);

/// Take a step whose first stages are the processor's and whose others are the device's.
fn split_step(
    (cpu, gpu): (&mut Cpu, &mut Gpu),
    (model, plan): (&Model, &StepPlan),
    state: &mut State,
    is_checked: bool,
) -> Result<Watched, StepFault> {
    let from = gpu.from();
    let before = &Stage::ALL[..from as usize];
    loop {
        let kept = Kept::of(state, false);
        let ran = run_stages(cpu, before, (model, plan), state, (is_checked, None)).map_err(StepFault::Columns)?;
        if let Ran::Whole(mut stage_ms) = ran {
            gpu.give(cpu.given(from, model, state));
            if let Some(mut stepped) = gpu.try_step(model, plan, state)? {
                if from == Stage::Integrate {
                    // Joints are the processor's, and the bodies that they act on; the others are fetched.
                    run_stages(cpu, &[from], (model, plan), state, (is_checked, None)).map_err(StepFault::Columns)?;
                    stepped.outcome = outcome_of(cpu.outcome(), model, state);
                }
                gpu.fetch(model, state)?;
                // In single precision their lengths are off by 1e-7, by which velocities would grow or shrink in each step.
                state.orientation.iter_mut().for_each(|q| *q = q.normalize());
                stepped.outcome.contacts = state.contacts.len() + state.sleepers.contacts.len();
                stepped.outcome.worst_penetration = state.worst_penetration();
                stage_ms.iter_mut().zip(stepped.stage_ms).for_each(|(all, ms)| *all += ms);
                return Ok((stage_ms, stepped.outcome, Some(stepped.survey)));
            }
            if let Some(kept) = kept {
                kept.restore(state);
            }
        }
        // A body has woken. The plan is the same whether bodies sleep or move.
        cpu.prepare(model, state, plan);
        gpu.renew(model, state, plan)?;
    }
}
