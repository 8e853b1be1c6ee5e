//! The back end of graphics devices: one file per stage, beside its kernels, as in `cpu`. The state stays on the device from step to step;
//! what comes back of a step is a [`rows::Summary`], and the columns when they are asked for.
//!
//! Positions are in fixed point ([`fixed`]), so that gaps are right far from the origin. The stages are those of the CPU back end
//! ([`crate::stages`]), with other columns in between: a sphere is in one bin, and pairs lie in the order of bins.
//!
//! A step is recorded once and submitted for every step: the stages up to the first iteration, an iteration as often as need be, and the
//! rest. If there are more pairs than room, the bodies stay where they are, and the step is done again with more room.

mod apgd;
mod barzilai_borwein;
mod before;
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
mod given;
mod holding;
mod hulls;
mod impacts;
mod integrate;
mod iterates;
mod jacobi;
mod joints;
pub mod kinds;
mod landing;
mod manifolds;
mod mechanism;
mod overlaps;
mod pair_write;
mod parts;
mod plan;
mod probing;
mod problem;
mod read_back;
mod record;
mod recorded;
mod rest;
pub mod rows;
mod scale;
mod sides;
pub mod solids;
mod spheres;
mod surfaces;
mod survey;
mod tiles;
mod usage;
mod warm_start;

#[cfg(test)]
mod tests;

pub use fault::Fault;
pub use usage::Usage;

use crate::model::Model;
use crate::outcome::{Outcome, StepOutcome};
use crate::plan::{ContactMethod, StepPlan, has_joints};
use crate::settings::{Method, SolverSettings};
use crate::stages::Stage;
use crate::state::State;
use crate::twist::Twist;
use crate::{sleep, watch};
use before::Before;
use collision::Collision;
use contact_solve::{ContactSolve, Submissions};
use exact::Rounds;
use gpu::{Device, Kernels};
use holding::Holding;
use impacts::Impacts;
use joints::Joints;
use mechanism::Mechanism;
use overlaps::Overlaps;
use plan::{method_of, needs_tiles, takeover};
use probing::Probing;
use recorded::{Recorded, Solving};
use rest::Rest;
use rows::Summary;
use std::sync::Arc;
use std::time::Instant;
use survey::Survey;
use warm_start::WarmStart;

/// The back end of a device, with the state on it.
pub struct Gpu {
    device: Arc<Device>,
    kernels: Arc<Kernels>,
    collision: Collision,
    warm_start: WarmStart,
    solve: ContactSolve,
    overlaps: Overlaps,
    survey: Survey,
    /// The bodies that joints, springs and loads act on.
    mechanism: Option<Mechanism>,
    /// Impacts one after another, where the plan has them.
    impacts: Option<Impacts>,
    rest: Rest,
    recorded: Recorded,
    /// Mass of the moving bodies, kg.
    mass: f64,
    /// Number of contacts of the last step.
    n_contacts: usize,
    /// Whether the state differs from that on the device, and whether that of its bodies does.
    is_stale: bool,
    has_old_bodies: bool,
    /// Kinetic and potential energy, J, and maximum penetration, m, of the last step.
    measured: [f64; 3],
    /// Sweeps over contacts so far, by the number of these.
    contact_sweeps: u64,
    /// What the probes ask of the device, if they have asked.
    probing: Option<Probing>,
    /// Whether the contacts of the step are found, with their starting point.
    has_found: bool,
    /// Whether Gauss–Seidel has taken over the last step from the method, so that this one is begun for it.
    is_landing: bool,
    /// What the processor has found of a step, where it runs the first stages.
    before: Before,
    /// What is expected of the pairs.
    holding: Holding,
}

/// What has become of the commands of a step.
enum Submitted {
    /// They are done, with these rounds of the solve, where it has rounds.
    Done(Option<Rounds>),
    /// A limit or a motor of a joint holds or is let go with what the contacts do, or the step is another method's: it is to be done again.
    Again,
    /// A sleeping body has woken: the step is to begin again.
    Woken,
}

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
    /// A back end on a device for a model, from a state whose watch has begun, that has the stages from `from` on.
    ///
    /// # Errors
    /// [`Fault::Unsupported`] for a model that needs what no kernel is built for, [`Fault::Position`], [`Fault::Gpu`].
    pub fn new(device: Device, model: &Model, state: &State, (plan, from): (&StepPlan, Stage)) -> Result<Gpu, Fault> {
        Gpu::with((Arc::new(device), Arc::new(Kernels::default())), model, state, (plan, from))
    }

    fn with(
        (device, kernels): (Arc<Device>, Arc<Kernels>),
        model: &Model,
        state: &State,
        (plan, from): (&StepPlan, Stage),
    ) -> Result<Gpu, Fault> {
        let method = method_of(plan);
        let mut collision = Collision::new(&device, &kernels, model, state)?;
        if needs_tiles(plan) {
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
        let by = (method, &model.solver, takeover(plan));
        let solve = ContactSolve::with(&device, &kernels, model, by, (&collision, joints))?;
        solve.place_step_length(&device, state.step_length);
        let overlaps = Overlaps::new(&device, &solve.problem)?;
        let survey = Survey::new(&device, model, state, &collision.bodies)?;
        let impacts = Impacts::new(&device, &kernels, model, plan)?;
        let rest = Rest::new(&device, &kernels)?;
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
            impacts,
            rest,
            recorded,
            mass,
            n_contacts,
            is_stale,
            has_old_bodies: false,
            measured: [0.0; 3],
            contact_sweeps: 0,
            probing: None,
            has_found: false,
            is_landing: false,
            before: Before::new(from),
            holding: Holding::default(),
        };
        gpu.record(model, plan)?;
        Ok(gpu)
    }

    /// Name of the adapter, with that of its driver.
    pub fn adapter(&self) -> String {
        let adapter = &self.device.adapter;
        format!("{} ({})", adapter.name, adapter.driver)
    }

    /// What the device has been used for so far.
    pub fn usage(&self) -> Usage {
        Usage {
            longest_submission: self.device.longest_submission(),
            most_bytes: self.device.most_memory(),
            largest_buffer: self.device.largest_buffer(),
            bytes_per_contact_sweep: self.solve.bytes,
            contact_sweeps: self.contact_sweeps,
            begun_again: self.holding.n_failed,
            traffic: self.device.traffic(),
            dispatches: self.device.dispatches(),
        }
    }

    /// Give the device back, for a back end of another state.
    pub fn into_device(self) -> Device {
        Arc::into_inner(self.device).expect("a back end has its device to itself")
    }

    /// Begin anew from a state, all of whose columns are up to date: bodies have fallen asleep or woken, or the layout of the rows is another.
    ///
    /// # Errors
    /// Those of [`Gpu::new`].
    pub fn renew(&mut self, model: &Model, state: &State, plan: &StepPlan) -> Result<(), Fault> {
        *self = Gpu::with((self.device.clone(), self.kernels.clone()), model, state, (plan, self.before.from))?;
        Ok(())
    }

    /// Adopt a plan: the activity of a body or the settings of the solver have changed.
    ///
    /// # Errors
    /// Those of [`Gpu::new`].
    pub fn prepare(&mut self, model: &Model, state: &mut State, plan: &StepPlan) -> Result<(), Fault> {
        if solids::narrow_of(model) != self.collision.bodies.layout.narrow {
            self.fetch(model, state)?;
            return self.renew(model, state, plan);
        }
        self.impacts = Impacts::new(&self.device, &self.kernels, model, plan)?;
        if self.collision.bodies.place_activity(&self.device, model, state) {
            self.collision.find_all(&self.device);
        }
        self.mass = moving_mass(model, state);
        if needs_tiles(plan) {
            self.collision.make_tiles(&self.device, &self.kernels)?;
        }
        if let Some(mechanism) = &mut self.mechanism {
            mechanism.prepare(&self.device, model, state)?;
        }
        self.renew_solve(model, plan)
    }

    /// Make the solver again, for columns that have grown or settings that have changed, and record the step.
    fn renew_solve(&mut self, model: &Model, plan: &StepPlan) -> Result<(), Fault> {
        self.rest.impulses = None;
        self.solve_by(model, (method_of(plan), &model.solver, takeover(plan)))?;
        self.record(model, plan)
    }

    /// Make the solver again, with a method and settings.
    fn solve_by(&mut self, model: &Model, by: (Method, &SolverSettings, Option<f64>)) -> Result<(), Fault> {
        let step_length = self.solve.step_length(&self.device)?;
        let columns = (&self.collision, joints_of(model, self.mechanism.as_ref()));
        self.solve = ContactSolve::with(&self.device, &self.kernels, model, by, columns)?;
        self.has_found = false;
        self.solve.place_step_length(&self.device, step_length);
        self.overlaps = Overlaps::new(&self.device, &self.solve.problem)?;
        Ok(())
    }

    /// Take a step. The state's time goes on; its columns stay as they are until [`Gpu::fetch`].
    ///
    /// # Errors
    /// [`Fault::Gpu`].
    pub fn step(&mut self, model: &Model, plan: &StepPlan, state: &mut State) -> Result<Stepped, Fault> {
        loop {
            if let Some(stepped) = self.try_step(model, plan, state)? {
                return Ok(stepped);
            }
        }
    }

    /// Take a step; none where a sleeping body has woken that the step would touch: it begins again then.
    ///
    /// # Errors
    /// [`Fault::Gpu`].
    pub fn try_step(&mut self, model: &Model, plan: &StepPlan, state: &mut State) -> Result<Option<Stepped>, Fault> {
        if self.before.from == Stage::Integrate {
            return self.integrate(model, plan, state).map(Some);
        }
        if self.impacts.is_some() {
            self.fetch(model, state)?;
        }
        if self.rest.impulses.is_some() {
            self.renew_solve(model, plan)?;
        }
        let joint_ms = self.begin_joints(model, plan, state, &[])?;
        let mut times = Submissions::default();
        if self.looks(plan, state) {
            let has_woken = self.look(model, plan, state, &mut times)?;
            if has_woken {
                return Ok(None);
            }
        }
        let (summary, rounds) = loop {
            let rounds = match self.submit(model, plan, state, &mut times)? {
                Submitted::Done(rounds) => rounds,
                Submitted::Again => continue,
                Submitted::Woken => return Ok(None),
            };
            let summary = self.survey.summary.read(&self.device, 1)?[0];
            if summary.has_room == 1 {
                break (summary, rounds);
            }
            if self.holding.is_held && summary.lasts <= 0.0 {
                self.holding.fail();
                continue;
            }
            if self.solve.has_undone(&self.device)? {
                self.is_landing = !self.is_landing;
                continue;
            }
            self.make_room(model, plan, [summary.pairs, summary.needed].map(|n| n as usize))?;
        };
        let mut stage_ms = [0.0; Stage::ALL.len()];
        let repetitions = rounds.map_or(summary.iterations, |rounds| rounds.iterations);
        self.take_times(times, &mut stage_ms, repetitions)?;
        self.n_contacts = summary.contacts as usize;
        self.holding.pass(summary.lasts as f64, self.knows_next().then_some(summary.next as f64), summary.rounds);
        self.solve.n_last = Some(summary.iterations);
        let (n, room) = (self.solve.problem.n_bodies, self.collision.columns().0.capacity());
        self.device.expect_growth((n + room) as f64 / (n + self.n_contacts).max(1) as f64);
        (self.is_stale, self.has_old_bodies) = (true, true);
        let survey = self.survey.of_watch(&summary, self.mass);
        self.measured = [survey.kinetic, survey.potential, summary.worst as f64];
        let mut outcome = outcome(&summary);
        if let Some(mechanism) = &mut self.mechanism {
            let started = Instant::now();
            mechanism.finish(&self.device, model, state, &mut outcome)?;
            stage_ms[Stage::JointWrite as usize] += joint_ms + 1e3 * started.elapsed().as_secs_f64();
        }
        state.steps += 1;
        state.time = state.steps as f64 * model.step;
        let (iterations, sweeps) = self.solve.made(repetitions, self.is_landing);
        outcome.solver.iterations = iterations;
        self.contact_sweeps += self.n_contacts as u64 * u64::from(sweeps);
        Ok(Some(Stepped { outcome, survey, stage_ms }))
    }

    /// Take the times of a step and of its iterations.
    fn take_times(
        &self,
        times: Submissions,
        stage_ms: &mut [f64; Stage::ALL.len()],
        iterations: u32,
    ) -> Result<(), Fault> {
        for timings in times.stages {
            self.add_times(timings, stage_ms)?;
        }
        let mut seconds = 0.0;
        for timings in times.iterations {
            seconds += self.add_times(timings, stage_ms)?;
        }
        if iterations > 0 {
            self.solving().solve.observe(&self.device, seconds / f64::from(iterations));
        }
        Ok(())
    }

    /// Add the times of submitted commands to those of their stages. Returns the time of all of them, s.
    fn add_times(&self, timings: gpu::Timings, stage_ms: &mut [f64; Stage::ALL.len()]) -> Result<f64, Fault> {
        let stages = timings.wait(&self.device)?.unwrap_or_default();
        for (name, seconds) in &stages {
            let stage = Stage::ALL.iter().position(|stage| stage.name() == *name);
            stage_ms[stage.expect("stages are named as they are")] += 1e3 * seconds;
        }
        Ok(stages.iter().map(|(_, seconds)| seconds).sum())
    }

    /// Submit the stages up to the contacts with their starting point, with what the processor has found before.
    fn find(&mut self, model: &Model, plan: &StepPlan, state: &State, times: &mut Submissions) -> Result<(), Fault> {
        self.place_given(model, plan, state)?;
        let hold = self.holding.is_likely();
        let (is_held, find) = match self.recorded.ahead.take().filter(|(is_held, _)| *is_held == hold) {
            Some(ahead) => ahead,
            None => self.recorded.prepare(&self.device, hold),
        };
        self.holding.is_held = is_held;
        times.stages.push(find.submit(&self.device)?);
        Ok(())
    }

    /// Whether the end of a step knows the boxes of the next: of all bodies but those that the processor moves.
    fn knows_next(&self) -> bool {
        self.before.from == Stage::Bounds && self.mechanism.is_none()
    }

    /// The commands of the step from its contacts on.
    fn solving(&self) -> &Solving {
        self.recorded.landing.as_ref().filter(|_| self.is_landing).unwrap_or(&self.recorded.own)
    }

    /// Hand the bodies that joints, springs and loads act on to the device, with what impacts change of their velocities. Returns the wall
    /// time, ms.
    fn begin_joints(&mut self, model: &Model, plan: &StepPlan, state: &State, impacts: &[Twist]) -> Result<f64, Fault> {
        let Some(mechanism) = &mut self.mechanism else { return Ok(0.0) };
        let started = Instant::now();
        if mechanism.begin(&self.device, (model, state), &self.collision.bodies, impacts)? {
            self.renew_solve(model, plan)?;
        }
        Ok(1e3 * started.elapsed().as_secs_f64())
    }

    /// Whether the processor has to know the contacts of a step before they are solved.
    fn looks(&self, plan: &StepPlan, state: &State) -> bool {
        plan.start().is_some() || self.impacts.is_some() || !state.sleepers.are_none()
    }

    /// Find the contacts of a step, and let the processor do what it has to: wake bodies, find impacts one after another, or begin from rest.
    /// Returns whether a body has woken.
    fn look(
        &mut self,
        model: &Model,
        plan: &StepPlan,
        state: &mut State,
        times: &mut Submissions,
    ) -> Result<bool, Fault> {
        let n = loop {
            self.find(model, plan, state, times)?;
            let room = self.collision.room().read_back(&self.device, 3)?;
            let n = self.solve.problem.n_contacts.n.read_back(&self.device, 1)?;
            let (room, n) = (room.wait(&self.device)?, n.wait(&self.device)?);
            if room[1] == 1 {
                break n[0] as usize;
            }
            if self.holding.is_held {
                self.holding.fail();
                continue;
            }
            self.make_room(model, plan, [room[0], room[2]].map(|n| n as usize))?;
        };
        self.has_found = true;
        if self.wakes(model, plan, state, (n, false))? {
            return Ok(true);
        }
        if self.impacts.is_some() {
            let contacts = std::mem::replace(&mut state.contacts, self.contacts(n)?);
            let impacts = impacts::found(model, state);
            state.contacts = contacts;
            if let Some(column) = &self.impacts {
                column.place(&self.device, &impacts);
            }
            self.begin_joints(model, plan, state, &impacts)?;
        }
        if let Some((ContactMethod::Blocks(method), settings)) = plan.start()
            && n > 0
            && !self.rest.has_impulses(&self.device)?
        {
            let impulses = rest::impulses(model, state, self.contacts(n)?);
            self.solve_by(model, (method, settings, takeover(plan)))?;
            self.rest.impulses = Some(impulses);
            self.record_by(model, plan, 1)?;
        }
        Ok(false)
    }

    /// Wake what the step touches of the bodies that sleep, if it `is_solved` what it has touched. Returns whether any has woken.
    fn wakes(
        &mut self,
        model: &Model,
        plan: &StepPlan,
        state: &mut State,
        (n, is_solved): (usize, bool),
    ) -> Result<bool, Fault> {
        if state.sleepers.are_none() {
            return Ok(false);
        }
        let contacts = std::mem::replace(&mut state.contacts, self.contacts(n)?);
        let touched = sleep::touched(model, state, is_solved);
        state.contacts = contacts;
        if touched.is_empty() {
            return Ok(false);
        }
        sleep::rouse(state, touched);
        self.renew(model, state, plan)?;
        Ok(true)
    }

    /// Submit the commands of a step.
    fn submit(
        &mut self,
        model: &Model,
        plan: &StepPlan,
        state: &mut State,
        times: &mut Submissions,
    ) -> Result<Submitted, Fault> {
        if !std::mem::take(&mut self.has_found) {
            self.find(model, plan, state, times)?;
        }
        if let Some(impulses) = &self.rest.impulses {
            self.solve.problem.gamma.write(&self.device, impulses);
        }
        let is_landing = self.is_landing && self.solve.may_land();
        let Solving { start, solve, measure, .. } = self.solving();
        times.stages.push(start.submit(&self.device)?);
        if self.solve.asks(is_landing) && self.solve.has_undone(&self.device)? {
            self.is_landing = !is_landing;
            return Ok(Submitted::Again);
        }
        let rounds = self.solve.submit(&self.device, (solve, is_landing, self.holding.rounds()), times)?;
        if self.mechanism.as_ref().is_some_and(Mechanism::has_bounds) {
            times.stages.push(measure.submit(&self.device)?);
        }
        if let Some(mechanism) = self.mechanism.as_mut().filter(|mechanism| mechanism.has_bounds())
            && let Some(has_grown) = mechanism.settle(&self.device, model, state)?
        {
            if has_grown {
                self.renew_solve(model, plan)?;
            }
            return Ok(Submitted::Again);
        }
        if !state.sleepers.are_none() {
            let n = self.solve.problem.n_contacts.read(&self.device)?;
            if self.wakes(model, plan, state, (n, true))? {
                return Ok(Submitted::Woken);
            }
        }
        let Solving { end, recovery, .. } = self.solving();
        let end = if state.steps.is_multiple_of(self.recorded.period) { recovery } else { end };
        times.stages.push(end.submit(&self.device)?);
        if let Some(probing) = &mut self.probing {
            probing.follow(&self.device, &self.solve.problem, &self.collision.bodies)?;
        }
        // While the device is at this step, the next one is encoded.
        self.recorded.ahead = Some(self.recorded.prepare(&self.device, self.holding.is_likely_after()));
        Ok(Submitted::Done(rounds))
    }

    /// Make room for a number of pairs and of contacts.
    fn make_room(&mut self, model: &Model, plan: &StepPlan, needed: [usize; 2]) -> Result<(), Fault> {
        self.collision.make_room(&self.device, &self.kernels, needed)?;
        self.warm_start.make_room(&self.device, self.collision.columns().0.capacity())?;
        self.renew_solve(model, plan)
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

/// Mass of the moving bodies, kg.
fn moving_mass(model: &Model, state: &State) -> f64 {
    (0..model.n_bodies()).filter(|b| state.moves(*b)).map(|b| 1.0 / model.inv_mass[b]).sum()
}
