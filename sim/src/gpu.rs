//! The back end of graphics devices: one file per stage, beside its kernels, as in `cpu`. The state stays on the device from step to step;
//! what comes back of a step is a [`rows::Summary`], and the columns when they are asked for.
//!
//! Positions are in fixed point ([`fixed`]), so that gaps are right far from the origin. The stages are those of the CPU back end
//! ([`crate::stages`]), with other columns in between: a sphere is in one bin, and pairs lie in the order of bins.
//!
//! A step is recorded once and submitted for every step: the stages up to the first iteration, a part of the iterations as often as need
//! be, and the rest. If there are more pairs than room, the bodies stay where they are, and the step is done again with more room.

mod apgd;
mod bin_emit;
mod bin_start;
mod bodies;
mod bounds;
pub mod collision;
pub mod contact_solve;
mod contact_write;
mod exact;
mod fault;
pub mod fixed;
pub mod fixtures;
mod force;
mod gauss_seidel;
mod hulls;
mod integrate;
mod jacobi;
mod joints;
pub mod kinds;
mod manifolds;
mod mechanism;
mod overlaps;
mod pair_write;
mod parts;
mod problem;
pub mod rows;
mod scale;
pub mod solids;
mod spheres;
mod surfaces;
mod survey;
mod tiles;
mod warm_start;

#[cfg(test)]
mod tests;

pub use fault::Fault;

use crate::contacts::{Arms, Contacts, NO_SPHERE_PAIR};
use crate::manifolds::Manifolds;
use crate::model::Model;
use crate::outcome::{Outcome, StepOutcome};
use crate::plan::{ContactMethod, Narrow, StepPlan, has_joints};
use crate::settings::Method;
use crate::stages::Stage;
use crate::state::State;
use crate::watch;
use collision::Collision;
use contact_solve::ContactSolve;
use exact::Rounds;
use glam::DVec3;
use gpu::{Commands, Device, Kernels, Timings};
use joints::Joints;
use mechanism::Mechanism;
use overlaps::Overlaps;
use rows::Summary;
use std::time::Instant;
use survey::Survey;
use warm_start::WarmStart;

/// The back end of a device, with the state on it.
pub struct Gpu {
    device: Device,
    kernels: Kernels,
    collision: Collision,
    warm_start: WarmStart,
    solve: ContactSolve,
    overlaps: Overlaps,
    survey: Survey,
    /// The bodies that joints, springs and loads act on.
    mechanism: Option<Mechanism>,
    recorded: Recorded,
    /// Mass of the moving bodies, kg.
    mass: f64,
    /// Number of contacts of the last step.
    n_contacts: usize,
    /// Whether the state differs from that on the device.
    is_stale: bool,
}

/// The recorded commands of a step.
struct Recorded {
    start: Commands,
    solve: contact_solve::Recorded,
    /// What the contacts do to the bodies that joints act on.
    measure: Commands,
    end: Commands,
    /// The end of a step that recovers overlaps.
    recovery: Commands,
    /// In one of how many steps overlaps are recovered.
    period: u64,
}

/// The rounds of a solve, where it has rounds, and the times of the commands of a step.
type Submitted = (Option<Rounds>, Vec<Timings>);

/// What a step has done.
pub struct Stepped {
    /// The outcome.
    pub outcome: StepOutcome,
    /// The survey of the bodies.
    pub survey: watch::Survey,
    /// Time of each stage, ms, in the order of [`Stage::ALL`]; zeros where the adapter takes no times.
    pub stage_ms: [f64; Stage::ALL.len()],
}

impl Gpu {
    /// A back end on a device for a model, from a state whose watch has begun.
    ///
    /// # Errors
    /// [`Fault::Unsupported`] for a model that needs what no kernel is built for, [`Fault::Position`], [`Fault::Gpu`].
    pub fn new(device: Device, model: &Model, state: &State, plan: &StepPlan) -> Result<Gpu, Fault> {
        let kernels = Kernels::default();
        let method = method_of(plan);
        contact_solve::supported(model, method)?;
        let mut collision = Collision::new(&device, &kernels, model, state)?;
        if method == Method::GaussSeidel {
            collision.make_tiles(&device, &kernels)?;
        }
        let n_last = state.contacts.len();
        if n_last > collision.columns().0.capacity() {
            collision.make_room(&device, &kernels, [n_last; 2])?;
        }
        let room = collision.columns().0.capacity();
        let warm_start = WarmStart::new(&device, &kernels, collision.bodies.layout, room)?;
        warm_start.place(&device, &state.contacts);
        let mechanism = Mechanism::new(&device, &kernels, (model, state), &collision.bodies)?;
        let joints = joints_of(model, mechanism.as_ref());
        let solve = ContactSolve::with_joints(&device, &kernels, (model, method), (&collision, joints))?;
        solve.place_step_length(&device, state.step_length);
        let overlaps = Overlaps::new(&device, &solve.problem)?;
        let survey = Survey::new(&device, model, state, &collision.bodies)?;
        let recorded = Recorded::empty();
        let (mass, n_contacts, is_stale) = (moving_mass(model, state), n_last, false);
        let mut gpu = Gpu {
            device,
            kernels,
            collision,
            warm_start,
            solve,
            overlaps,
            survey,
            mechanism,
            recorded,
            mass,
            n_contacts,
            is_stale,
        };
        gpu.record(model, plan)?;
        Ok(gpu)
    }

    /// Name of the adapter, with that of its driver.
    pub fn adapter(&self) -> String {
        let adapter = &self.device.adapter;
        format!("{} ({})", adapter.name, adapter.driver)
    }

    /// Give the device back, for a back end of another state.
    pub fn into_device(self) -> Device {
        self.device
    }

    /// Adopt a plan: the activity of a body or the settings of the solver have changed.
    ///
    /// # Errors
    /// Those of [`Gpu::new`].
    pub fn prepare(&mut self, model: &Model, state: &State, plan: &StepPlan) -> Result<(), Fault> {
        if self.collision.bodies.place_activity(&self.device, model, state) {
            self.collision.find_all(&self.device);
        }
        self.mass = moving_mass(model, state);
        if method_of(plan) == Method::GaussSeidel {
            self.collision.make_tiles(&self.device, &self.kernels)?;
        }
        if let Some(mechanism) = &mut self.mechanism {
            mechanism.prepare(&self.device, model, state)?;
        }
        self.renew_solve(model, plan)
    }

    /// Make the solver again, for columns that have grown or settings that have changed, and record the step.
    fn renew_solve(&mut self, model: &Model, plan: &StepPlan) -> Result<(), Fault> {
        let step_length = self.solve.step_length(&self.device)?;
        let columns = (&self.collision, joints_of(model, self.mechanism.as_ref()));
        self.solve = ContactSolve::with_joints(&self.device, &self.kernels, (model, method_of(plan)), columns)?;
        self.solve.place_step_length(&self.device, step_length);
        self.overlaps = Overlaps::new(&self.device, &self.solve.problem)?;
        self.record(model, plan)
    }

    /// Take a step. The state's time goes on; its columns stay as they are until [`Gpu::fetch`].
    ///
    /// # Errors
    /// [`Fault::Gpu`].
    pub fn step(&mut self, model: &Model, plan: &StepPlan, state: &mut State) -> Result<Stepped, Fault> {
        let joint_ms = self.begin_joints(model, plan, state)?;
        let (summary, rounds, times) = loop {
            let Some((rounds, times)) = self.submit(model, plan, state)? else { continue };
            let summary = self.survey.summary.read(&self.device, 1)?[0];
            if summary.has_room == 1 {
                break (summary, rounds, times);
            }
            self.make_room(model, plan, [summary.pairs, summary.needed].map(|n| n as usize))?;
        };
        let mut stage_ms = [0.0; Stage::ALL.len()];
        for timings in times {
            for (name, seconds) in timings.wait(&self.device)?.unwrap_or_default() {
                let stage = Stage::ALL.iter().position(|stage| stage.name() == name);
                stage_ms[stage.expect("stages are named as they are")] += 1e3 * seconds;
            }
        }
        self.n_contacts = summary.contacts as usize;
        self.is_stale = true;
        let survey = self.survey.of_watch(&summary, self.mass);
        let mut outcome = outcome(&summary);
        if let Some(mechanism) = &mut self.mechanism {
            let started = Instant::now();
            mechanism.finish(&self.device, model, state, &mut outcome)?;
            stage_ms[Stage::JointWrite as usize] += joint_ms + 1e3 * started.elapsed().as_secs_f64();
        }
        state.steps += 1;
        state.time = state.steps as f64 * model.step;
        outcome.solver.iterations = rounds.map_or(summary.iterations, |rounds| rounds.iterations);
        Ok(Stepped { outcome, survey, stage_ms })
    }

    /// Hand the bodies that joints, springs and loads act on to the device. Returns the wall time, ms.
    fn begin_joints(&mut self, model: &Model, plan: &StepPlan, state: &State) -> Result<f64, Fault> {
        let Some(mechanism) = &mut self.mechanism else { return Ok(0.0) };
        let started = Instant::now();
        if mechanism.begin(&self.device, model, state, &self.collision.bodies)? {
            self.renew_solve(model, plan)?;
        }
        Ok(1e3 * started.elapsed().as_secs_f64())
    }

    /// Bring a state up to date: its columns are those on the device.
    ///
    /// # Errors
    /// [`Fault::Gpu`].
    pub fn fetch(&mut self, model: &Model, state: &mut State) -> Result<(), Fault> {
        if !self.is_stale {
            return Ok(());
        }
        let fetch = |state: &mut State| self.collision.bodies.fetch(&self.device, state);
        match &self.mechanism {
            Some(mechanism) => mechanism.keep(state, fetch)?,
            None => fetch(state)?,
        }
        state.fat_aabb = Some(self.collision.fetch_boxes(&self.device, model)?);
        self.survey.fetch(&self.device, state)?;
        state.step_length = self.solve.step_length(&self.device)?;
        self.fetch_contacts(state)?;
        // Contact points are found anew in each step here.
        state.manifolds = Manifolds::default();
        self.is_stale = false;
        Ok(())
    }

    fn fetch_contacts(&self, state: &mut State) -> Result<(), Fault> {
        let n = self.n_contacts;
        let rows = self.solve.problem.contact.read(&self.device, n)?;
        let impulses = self.solve.problem.gamma.read(&self.device, n)?;
        let vector = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
        let arms = match self.solve.problem.layout.narrow {
            Narrow::Spheres => Arms::Along(rows.iter().map(|c| c.reach.map(f64::from)).collect()),
            Narrow::Any => {
                let arms = self.solve.problem.arms.read(&self.device, n)?;
                Arms::Any(arms.iter().map(|arm| [arm.a, arm.b].map(vector)).collect())
            }
        };
        let rolling = match self.solve.problem.layout.rolls {
            true => self.solve.problem.roll.read(&self.device, n)?,
            false => vec![],
        };
        state.contacts = Contacts {
            bodies: rows.iter().map(|c| c.bodies).collect(),
            key: rows.iter().map(|c| [c.shapes[0], c.shapes[1], c.feature]).collect(),
            pair: vec![NO_SPHERE_PAIR; n],
            normal: rows.iter().map(|c| vector(c.normal).normalize()).collect(),
            arms,
            gap: rows.iter().map(|c| c.gap as f64).collect(),
            law: rows.iter().map(|c| c.law).collect(),
            impulse: impulses.iter().map(|z| vector([z[0], z[1], z[2]])).collect(),
            rolling_impulse: rolling.iter().map(|z| vector([z[0], z[1], z[2]])).collect(),
            ..Contacts::default()
        };
        Ok(())
    }

    /// Submit the commands of a step; none where a limit of a joint holds or is let go with what the contacts do: the step is then to be done
    /// again.
    fn submit(&mut self, model: &Model, plan: &StepPlan, state: &State) -> Result<Option<Submitted>, Fault> {
        let Recorded { start, solve, measure, end, recovery, period } = &self.recorded;
        let mut times = vec![start.submit(&self.device)?];
        let rounds = self.solve.submit(&self.device, solve, &mut times)?;
        if let Some(mechanism) = self.mechanism.as_mut().filter(|mechanism| mechanism.has_limits()) {
            times.push(measure.submit(&self.device)?);
            if let Some(has_grown) = mechanism.settle(&self.device, model, state)? {
                if has_grown {
                    self.renew_solve(model, plan)?;
                }
                return Ok(None);
            }
        }
        let end = if state.steps.is_multiple_of(*period) { recovery } else { end };
        times.push(end.submit(&self.device)?);
        Ok(Some((rounds, times)))
    }

    /// Make room for a number of pairs and of contacts.
    fn make_room(&mut self, model: &Model, plan: &StepPlan, needed: [usize; 2]) -> Result<(), Fault> {
        self.collision.make_room(&self.device, &self.kernels, needed)?;
        self.warm_start.make_room(&self.device, self.collision.columns().0.capacity())?;
        self.renew_solve(model, plan)
    }

    /// Record a step.
    fn record(&mut self, model: &Model, plan: &StepPlan) -> Result<(), Fault> {
        let Gpu { device, kernels, collision, warm_start, solve, .. } = &*self;
        let mut start = Commands::new();
        if let Some(mechanism) = &self.mechanism {
            start.stage(Stage::JointWrite.name());
            mechanism.record_pose(device, &mut start, &collision.bodies);
        }
        collision.record(device, &mut start, model);
        start.stage(Stage::WarmStart.name());
        match plan.warm_starts {
            true => warm_start.record(device, &mut start, collision.columns(), solve.problem.impulses()),
            false => solve.problem.impulses().into_iter().for_each(|column| start.clear(column)),
        }
        start.stage(Stage::Force.name());
        force::record(device, kernels, &mut start, model, (&collision.bodies, &solve.problem.free))?;
        if let Some(mechanism) = &self.mechanism {
            start.stage(Stage::JointWrite.name());
            solve.problem.record_inertia(&mut start, &collision.bodies);
            mechanism.record_free(device, &mut start, &solve.problem);
        }
        solve.record_start(device, kernels, &mut start, (model, collision))?;
        let part = solve.record(device, kernels)?;
        let period = recovery_period(plan);
        let mut measure = Commands::new();
        if let Some(mechanism) = &self.mechanism {
            solve.record_end(device, &mut measure);
            measure.stage(Stage::JointWrite.name());
            mechanism.record_effect(device, &mut measure, (&solve.problem, &self.overlaps));
        }
        let (end, recovery) = (self.record_end(model, None)?, self.record_end(model, Some(period))?);
        self.recorded = Recorded { start, solve: part, measure, end, recovery, period };
        Ok(())
    }

    /// Record the end of a step, with the recovery of overlaps for so many steps.
    fn record_end(&self, model: &Model, recovery: Option<u64>) -> Result<Commands, Fault> {
        let Gpu { device, kernels, collision, warm_start, solve, overlaps, survey, .. } = self;
        let (problem, room) = (&solve.problem, collision.room());
        let mut commands = Commands::new();
        let c = &mut commands;
        solve.record_end(device, c);
        match recovery {
            Some(period) => overlaps.record(device, kernels, c, model, (problem, period))?,
            None => overlaps.record_none(c),
        }
        c.stage(Stage::Integrate.name());
        if let Some(mechanism) = &self.mechanism {
            mechanism.record_effect(device, c, (problem, overlaps));
        }
        let bodies = &collision.bodies;
        integrate::record(device, kernels, c, (model, bodies), (problem, overlaps, room))?;
        warm_start.record_keep(device, c, collision.columns(), (problem.impulses(), room));
        survey.record(device, kernels, c, (model, bodies), (problem, room))?;
        Ok(commands)
    }
}

impl Recorded {
    fn empty() -> Recorded {
        let none = Commands::new;
        Recorded { start: none(), solve: Default::default(), measure: none(), end: none(), recovery: none(), period: 1 }
    }
}

/// The joints that the contacts are solved with; loads alone need none.
fn joints_of<'a>(model: &Model, mechanism: Option<&'a Mechanism>) -> Option<&'a Joints> {
    mechanism.filter(|_| has_joints(model)).map(|mechanism| &mechanism.joints)
}

fn outcome(summary: &Summary) -> StepOutcome {
    StepOutcome {
        solver: Outcome { iterations: summary.iterations, residual: summary.residual as f64 },
        contacts: summary.contacts as usize,
        worst_penetration: summary.worst as f64,
        ..StepOutcome::default()
    }
}

/// The method of a plan.
fn method_of(plan: &StepPlan) -> Method {
    match plan.method {
        ContactMethod::Sweeps => Method::GaussSeidel,
        ContactMethod::Blocks(method) => method,
    }
}

/// In one of how many steps overlaps are recovered, as on the CPU.
fn recovery_period(plan: &StepPlan) -> u64 {
    if plan.method == ContactMethod::Sweeps { 4 } else { 1 }
}

/// Mass of the moving bodies, kg.
fn moving_mass(model: &Model, state: &State) -> f64 {
    (0..model.n_bodies()).filter(|b| state.moves(*b)).map(|b| 1.0 / model.inv_mass[b]).sum()
}
