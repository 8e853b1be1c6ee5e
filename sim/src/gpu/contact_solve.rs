//! Solve the contact problem on a device.
//!
//! ```text
//! in     contact  [n_contacts]  of `contact_write`
//! in     free     [n_bodies]    m/s, rad/s: velocities at the step's end without contacts
//! inout  gamma    [n_contacts]  N s, world: impulses on B
//! out    motion   [n_bodies]    m/s, rad/s: velocities at the step's end
//! ```
//!
//! Twin: cpu/contact_solve.rs. The methods are in `jacobi`, `apgd`, `barzilai_borwein` and `gauss_seidel`, what they share in `problem`. One
//! iteration is recorded, and submitted as often as the most iterations ask: once a solve has converged, its dispatches are empty. How many
//! go into one submission follows from the time that they have taken.

use super::apgd::{self, Apgd};
use super::barzilai_borwein::{self, BarzilaiBorwein};
use super::collision::Collision;
use super::exact::{self, Exact, Rounds};
use super::fault::Fault;
use super::gauss_seidel::{self, GaussSeidel};
use super::iterates::interval;
use super::joints::Joints;
use super::landing::Landing;
use super::problem::Problem;
use super::rows::Body;
use super::{force, jacobi, scale};
use crate::model::Model;
use crate::plan::has_joints;
use crate::settings::{FrictionLaw, Method, SolverSettings};
use gpu::{Buffer, Commands, Device, GpuError, Kernels, ReadBack, Timings};
use std::time::Instant;

/// Name of the stage.
const STAGE: &str = "contact_solve";

/// Iterations that are submitted at a time; beyond those of the settings, where each of them may be the last; and the most of these at once.
const PART: u32 = 50;
const PART_BEYOND: u32 = 6;
const MOST_BEYOND: u32 = 200;

/// The most iterations by default, of a few contacts: in single precision more bring nothing. Twin: scalars.wgsl.
const MOST_OF_DEFAULT: u32 = 2000;

/// Places of the step length, the iterations so far, whether the solve goes on, and the residual in the scalars.
const STEP: usize = 2;
const TRIALS: usize = 5;
const GOES_ON: usize = 7;
const RESIDUAL: usize = 15;

/// The solver of a model's contacts.
pub struct ContactSolve {
    /// The problem.
    pub problem: Problem,
    method: Columns,
    /// What takes over the steps in which a bed lands, where that may be.
    landing: Option<(Landing, Columns)>,
    /// Coulomb's law itself, where it is by rounds.
    exact: Option<Exact>,
    settings: SolverSettings,
    /// Speed of one step of free fall, m/s.
    fall: f64,
    /// Bytes of a contact and sweep from memory.
    pub bytes: f64,
    /// Iterations of the last step, or passes, if there has been one.
    pub n_last: Option<u32>,
}

/// The recorded commands of a solve.
#[derive(Default)]
pub struct Recorded {
    /// The parts of an iteration, by the rounds of Gauss–Seidel that they are for, if they are for some.
    iteration: Vec<(Option<u32>, Commands)>,
    /// A check of the iterate, and the iterations from one to the next.
    check: Option<(u32, Commands)>,
    /// What decides whether iterations go on beyond those of the settings.
    closing: Option<Commands>,
    /// By rounds: what begins the first and the others, and what measures the slip that has come out.
    first: Commands,
    again: Commands,
    measure: Commands,
}

/// The columns of a method.
enum Columns {
    Jacobi,
    Apgd(Box<Apgd>),
    BarzilaiBorwein(Box<BarzilaiBorwein>),
    GaussSeidel(Box<GaussSeidel>),
}

/// The times of submitted commands of a step.
#[derive(Default)]
pub struct Submissions {
    /// Those of its stages.
    pub stages: Vec<Timings>,
    /// Those of the iterations.
    pub iterations: Vec<Timings>,
}

impl Recorded {
    /// The lists of the iterations after the first `done` up to `end`, without those of rounds that are not in the mask; from the `last` of the settings
    /// on it is decided whether there are more.
    fn lists(&self, done: u32, end: u32, (last, rounds): (u32, u32)) -> impl Iterator<Item = &Commands> {
        let own = move || {
            let has_any = move |round: &Option<u32>| round.is_none_or(|round| rounds >> round & 1 == 1);
            self.iteration.iter().filter(move |(round, _)| has_any(round)).map(|(_, part)| part)
        };
        let check =
            |k: u32| self.check.as_ref().filter(|(interval, _)| k.is_multiple_of(*interval)).map(|(_, check)| check);
        let closing = move |k: u32| self.closing.as_ref().filter(|_| k >= last);
        (done + 1..=end).flat_map(move |k| own().chain(check(k)).chain(closing(k)))
    }

    /// Tell the time of one iteration, s: their timings have those in them that had nothing to do.
    pub fn observe(&self, device: &Device, seconds: f64) {
        Commands::observe_all(device, self.iteration.iter().map(|(_, part)| part), seconds);
        for other in self.check.iter().map(|(_, check)| check).chain(&self.closing) {
            other.observe(device, seconds);
        }
    }
}

/// The speed at which gaps may close and the residual that may be left, m/s, where sweeps go on while there is more.
fn closing_of(model: &Model, settings: &SolverSettings) -> Option<[f64; 2]> {
    let lost = settings.residual_bound(model.gravity.length() * model.step);
    settings.overlap_tolerance.map(|overlap| [overlap / model.step, lost])
}

/// The residual of slow bodies and their speed, m/s, where tiles of them are swept on while theirs is greater.
fn settling_of(model: &Model, settings: &SolverSettings) -> Option<[f64; 2]> {
    let slow = SolverSettings::SLOW * model.gravity.length() * model.step;
    settings.settling_tolerance.map(|residual| [residual, slow])
}

impl ContactSolve {
    /// For the contacts of a collision, as many as it has room for now: after more room has been made, the solver is made again.
    ///
    /// # Errors
    /// [`Fault::Unsupported`] for a model with joints; [`Fault::Gpu`].
    pub fn new(
        device: &Device,
        kernels: &Kernels,
        (model, method): (&Model, Method),
        collision: &Collision,
    ) -> Result<ContactSolve, Fault> {
        if has_joints(model) {
            return Err(Fault::Unsupported("joints are solved in whole steps alone".into()));
        }
        ContactSolve::with(device, kernels, model, (method, &model.solver, None), (collision, None))
    }

    /// The same for a model whose joints have columns, with these settings, and [`StepPlan::takeover`](crate::plan::StepPlan::takeover).
    ///
    /// # Errors
    /// Those of [`ContactSolve::new`].
    pub(super) fn with(
        device: &Device,
        kernels: &Kernels,
        model: &Model,
        (method, settings, takeover): (Method, &SolverSettings, Option<f64>),
        (collision, joints): (&Collision, Option<&Joints>),
    ) -> Result<ContactSolve, Fault> {
        let feeds = settings.friction == FrictionLaw::Exact && method != Method::GaussSeidel;
        let problem = Problem::new(device, kernels, (model, method, feeds), (collision, joints))?;
        // Jacobi feeds the slip of each iterate.
        let by_rounds = feeds && method != Method::Jacobi;
        let exact = if by_rounds { Some(Exact::new(device, kernels, &problem)?) } else { None };
        let landing = if let Some(bound) = takeover.filter(|_| method != Method::GaussSeidel) {
            let landing = Landing::new(device, kernels, (&problem, collision.room()), (settings, bound))?;
            let settings = settings.of_takeover(model.envelope);
            let by = (&settings, closing_of(model, &settings), settling_of(model, &settings));
            let sweeps = GaussSeidel::new(device, kernels, by, (&problem, collision))?;
            Some((landing, Columns::GaussSeidel(Box::new(sweeps))))
        } else {
            None
        };
        let (method, bytes) = match method {
            Method::Jacobi => (Columns::Jacobi, jacobi::BYTES),
            Method::GaussSeidel => {
                let by = (settings, closing_of(model, settings), settling_of(model, settings));
                let method = GaussSeidel::new(device, kernels, by, (&problem, collision))?;
                (Columns::GaussSeidel(Box::new(method)), gauss_seidel::BYTES[problem.layout.narrow as usize])
            }
            Method::BarzilaiBorwein => {
                let method = BarzilaiBorwein::new(device, kernels, &problem, settings.tolerance)?;
                (Columns::BarzilaiBorwein(Box::new(method)), barzilai_borwein::BYTES)
            }
            Method::Apgd => {
                let method = Apgd::new(device, kernels, &problem, settings.tolerance)?;
                (Columns::Apgd(Box::new(method)), apgd::BYTES)
            }
        };
        let is_swept = matches!(method, Columns::GaussSeidel(_));
        let sweeps = if is_swept { gauss_seidel::SWEEPS[problem.layout.narrow as usize] } else { 1 };
        let bytes = bytes / f64::from(sweeps);
        let (settings, fall) = (settings.clone(), model.gravity.length() * model.step);
        Ok(ContactSolve { problem, method, landing, exact, settings, fall, bytes, n_last: None })
    }

    /// Whether the solve has not come to its end.
    ///
    /// # Errors
    /// Those of [`gpu::Buffer::read`].
    pub fn goes_on(&self, device: &Device) -> Result<bool, GpuError> {
        Ok(self.problem.scalars.read(device, 1)?[0][GOES_ON] == 1)
    }

    /// The step length of APGD, with which the next solve begins.
    ///
    /// # Errors
    /// Those of [`gpu::Buffer::read`].
    pub fn step_length(&self, device: &Device) -> Result<f64, GpuError> {
        Ok(f32::from_bits(self.problem.scalars.read(device, 1)?[0][STEP]) as f64)
    }

    /// Set the step length of APGD.
    pub fn place_step_length(&self, device: &Device, step_length: f64) {
        let mut scalars = [0; 16];
        scalars[STEP] = (step_length as f32).to_bits();
        self.problem.scalars.write(device, &[scalars]);
    }

    /// What solves a step.
    fn columns(&self, is_landing: bool) -> &Columns {
        self.landing.as_ref().filter(|_| is_landing).map_or(&self.method, |(_, sweeps)| sweeps)
    }

    /// Coulomb's law by rounds, if that is how a step is solved.
    fn rounds(&self, is_landing: bool) -> Option<&Exact> {
        self.exact.as_ref().filter(|_| !is_landing)
    }

    /// Repetitions of what is recorded for so many iterations: passes of Gauss–Seidel, else the iterations.
    fn passes(&self, iterations: u32, is_landing: bool) -> u32 {
        match self.columns(is_landing) {
            Columns::GaussSeidel(_) => gauss_seidel::passes(self.problem.layout.narrow, iterations),
            _ => iterations,
        }
    }

    /// The iterations that so many repetitions stand for, and the sweeps over a contact that they make.
    pub fn made(&self, repetitions: u32, is_landing: bool) -> (u32, u32) {
        let narrow = self.problem.layout.narrow;
        match self.columns(is_landing) {
            Columns::GaussSeidel(_) => {
                (gauss_seidel::iterations_of(narrow, repetitions), repetitions * gauss_seidel::SWEEPS[narrow as usize])
            }
            _ => (repetitions, repetitions),
        }
    }

    /// Whether Gauss–Seidel may take over a step.
    pub fn may_land(&self) -> bool {
        self.landing.is_some()
    }

    /// Whether the step was undone, since it was begun for another method than the one that takes it.
    ///
    /// # Errors
    /// Those of [`Buffer::read`].
    pub fn has_undone(&self, device: &Device) -> Result<bool, GpuError> {
        self.landing.as_ref().map_or(Ok(false), |(landing, _)| landing.has_undone(device))
    }

    /// Whether the device is asked for the number of contacts before they are solved.
    pub fn asks(&self, is_landing: bool) -> bool {
        // The most iterations follow from the number of contacts.
        self.rounds(is_landing).is_some() || self.settings.iterations.is_none()
    }

    /// Submit the iterations of a step, once its start has been, without the rounds of Gauss–Seidel that are not in the mask. Returns the iterations of all rounds, where there are rounds.
    ///
    /// # Errors
    /// Those of [`Commands::submit`] and [`Buffer::read`].
    pub fn submit(
        &self,
        device: &Device,
        (solve, is_landing, mask): (&Recorded, bool, u32),
        times: &mut Submissions,
    ) -> Result<Option<Rounds>, GpuError> {
        let n = if self.asks(is_landing) { self.problem.n_contacts.read(device)? } else { 1 };
        let blocks = if self.problem.layout.rolls { 2 * n } else { n };
        let most_of_default = if self.settings.iterations.is_none() { MOST_OF_DEFAULT } else { u32::MAX };
        let iterations = if n == 0 { 0 } else { self.settings.max_iterations(blocks).min(most_of_default) };
        let most = self.passes(iterations, is_landing);
        let Some(exact) = self.rounds(is_landing) else {
            let goes_beyond = matches!(self.columns(is_landing), Columns::GaussSeidel(own) if own.goes_beyond());
            // Beyond those of the settings a pass counts as one: in impacts four sweeps of a tile may do no more than one of all contacts.
            let all = if goes_beyond { SolverSettings::BEYOND * iterations } else { most };
            self.submit_iterations(device, (solve, mask), (all, most), times)?;
            return Ok(None);
        };
        let mut rounds = Rounds::default();
        for round in 0..if n == 0 { 0 } else { exact::ROUNDS } {
            let own = rounds.next(most);
            exact.place_limit(device, own);
            let begin = if round == 0 { &solve.first } else { &solve.again };
            times.stages.push(begin.submit(device)?);
            self.submit_iterations(device, (solve, mask), (own, own), times)?;
            times.stages.push(solve.measure.submit(device)?);
            let scalars = self.problem.scalars.read(device, 1)?[0];
            let residual = f32::from_bits(scalars[RESIDUAL]) as f64;
            if exact.add(device, &self.settings, (&mut rounds, most), (blocks, scalars[TRIALS], residual))? {
                break;
            }
        }
        Ok(Some(rounds))
    }

    /// Submit the most iterations, unless the solve ends before; from the `last` of the settings on it is decided whether there are more.
    fn submit_iterations(
        &self,
        device: &Device,
        (solve, rounds): (&Recorded, u32),
        (most, last): (u32, u32),
        times: &mut Submissions,
    ) -> Result<(), GpuError> {
        let mut submit = |done: u32, end: u32| -> Result<(), GpuError> {
            let lists = solve.lists(done, end, (last, rounds));
            times.iterations.push(Commands::submit_all(device, lists)?.unobserved());
            Ok(())
        };
        // As many as the last step has taken, to begin with: those of a solve that has ended take their time, too.
        let mut done = match self.expected(solve) {
            // Beyond those of the settings only if it has gone beyond them.
            expected if most > last => {
                let beyond = self.n_last.filter(|n| *n > last).map(|n| n + 1);
                beyond.unwrap_or(expected.map_or(last, |n| n.min(last))).min(MOST_BEYOND).min(most)
            }
            expected => expected.map_or(0, |n| n.min(PART).min(most)),
        };
        if done > 0 {
            submit(0, done)?;
            if done < most && !self.goes_on(device)? {
                return Ok(());
            }
        }
        // Iterations after which the device was asked, and its answer: the next part is on its way by then.
        let mut asked: Option<(u32, ReadBack<[u32; 16]>)> = None;
        while done < most {
            if let Some((_, answer)) = asked.take_if(|(after, _)| done > *after)
                && answer.wait(device)?[0][GOES_ON] == 0
            {
                break;
            }
            let end = most.min(done + if most > last { PART_BEYOND } else { PART });
            submit(done, end)?;
            if asked.is_none() && end < most {
                asked = Some((end, self.problem.scalars.read_back(device, 1)?));
            }
            done = end;
        }
        Ok(())
    }

    /// The iterations that a step is likely to take, up to the next check: where solves end by their residual.
    fn expected(&self, solve: &Recorded) -> Option<u32> {
        let n = self.n_last.filter(|_| self.settings.tolerance > 0.0)? + 1;
        Some(solve.check.as_ref().map_or(n, |(interval, _)| n.next_multiple_of(*interval)))
    }

    /// Record the iterations of a step, and what goes between rounds.
    ///
    /// # Errors
    /// Those of [`Kernels::get`].
    pub fn record(&self, device: &Device, kernels: &Kernels, is_landing: bool) -> Result<Recorded, GpuError> {
        let mut own = Recorded::default();
        self.record_iteration(device, kernels, &mut own, is_landing)?;
        let Some(exact) = self.rounds(is_landing) else { return Ok(own) };
        let Recorded { first, measure, again, .. } = &mut own;
        [&mut *first, &mut *again, &mut *measure].into_iter().for_each(|commands| commands.stage(STAGE));
        exact.record_limit(device, first, &self.problem);
        self.record_solution(device, measure, false);
        exact.record_measure(device, measure, &self.problem, self.fall);
        exact.record_again(device, again, (&self.problem, self.first_length()));
        if self.problem.joints.is_some() {
            // The multipliers of the joints are those of the round's solution.
            self.problem.record_response(device, again);
        }
        self.record_iterates(again);
        Ok(own)
    }

    /// The first step length of a method that has one in the scalars.
    fn first_length(&self) -> f64 {
        match &self.method {
            Columns::BarzilaiBorwein(_) => barzilai_borwein::FIRST,
            _ => self.settings.omega.unwrap_or(jacobi::OMEGA),
        }
    }

    /// Record that a descent method begins from the impulses and velocities of the problem.
    fn record_iterates(&self, commands: &mut Commands) {
        match &self.method {
            Columns::Apgd(apgd) => apgd.record_start(commands, &self.problem),
            Columns::BarzilaiBorwein(own) => own.record_start(commands, &self.problem),
            Columns::Jacobi | Columns::GaussSeidel(_) => {}
        }
    }

    /// Record the beginning, from the impulses `gamma` of the problem, for the method or for what takes over from it.
    ///
    /// # Errors
    /// Those of [`Kernels::get`].
    pub fn record_start(
        &self,
        device: &Device,
        kernels: &Kernels,
        commands: &mut Commands,
        (model, collision, is_landing): (&Model, &Collision, bool),
    ) -> Result<(), GpuError> {
        commands.stage(STAGE);
        let problem = &self.problem;
        problem.record(device, commands, model, &collision.bodies);
        if let Some((landing, _)) = &self.landing {
            landing.record(device, commands, problem);
        }
        if let Columns::GaussSeidel(sweeps) = self.columns(is_landing) {
            sweeps.record_start(device, commands, (problem, collision), &self.settings);
        } else {
            if let Some(exact) = &self.exact {
                exact.record_feed(device, commands, problem);
            }
            scale::record(device, kernels, commands, problem, (self.settings.iterations, self.first_length()))?;
            self.record_iterates(commands);
        }
        if let Some((landing, _)) = &self.landing {
            let work = self.work(is_landing);
            landing.record_undo(device, commands, (problem, work), is_landing);
        }
        Ok(())
    }

    /// Workgroups of the iterations.
    fn work(&self, is_landing: bool) -> &Buffer<[u32; 4]> {
        match self.columns(is_landing) {
            Columns::GaussSeidel(sweeps) => &sweeps.work,
            _ => &self.problem.work,
        }
    }

    fn record_iteration(
        &self,
        device: &Device,
        kernels: &Kernels,
        recorded: &mut Recorded,
        is_landing: bool,
    ) -> Result<(), GpuError> {
        let (mut own, problem) = (Commands::new(), &self.problem);
        let commands = &mut own;
        commands.stage(STAGE);
        let iterates = match self.columns(is_landing) {
            Columns::Jacobi => {
                jacobi::record(device, kernels, commands, &self.settings, (problem, self.fall))?;
                None
            }
            Columns::Apgd(apgd) => Some(apgd.record(device, commands, problem)),
            Columns::BarzilaiBorwein(own) => Some(own.record(device, commands, problem)),
            Columns::GaussSeidel(sweeps) => {
                for round in 0..sweeps.rounds() {
                    let mut part = Commands::new();
                    part.stage(STAGE);
                    sweeps.record_round(device, &mut part, problem, round);
                    recorded.iteration.push((Some(round), part));
                }
                sweeps.record_rest(device, commands, problem);
                recorded.closing = sweeps.closing(device, problem, STAGE);
                None
            }
        };
        recorded.iteration.push((None, own));
        if let Some(iterates) = iterates {
            let mut check = Commands::new();
            check.stage(STAGE);
            iterates.record_check(device, &mut check, problem);
            recorded.check = Some((interval(self.settings.tolerance), check));
        }
        Ok(())
    }

    /// Record the end: the solution with its residual, unless the last round has left it.
    pub fn record_end(&self, device: &Device, commands: &mut Commands, is_landing: bool) {
        commands.stage(STAGE);
        if self.rounds(is_landing).is_none() {
            self.record_solution(device, commands, is_landing);
        }
    }

    fn record_solution(&self, device: &Device, commands: &mut Commands, is_landing: bool) {
        match self.columns(is_landing) {
            // Its residual is that of the visits. The velocities are summed again from the impulses, whose momentum is exact.
            Columns::GaussSeidel(sweeps) => {
                let problem = &self.problem;
                sweeps.record_end(device, commands, problem);
                problem.record_response(device, commands);
                return;
            }
            Columns::Apgd(apgd) => apgd.record_end(device, commands, &self.problem),
            Columns::BarzilaiBorwein(own) => own.record_end(device, commands, &self.problem),
            // The joints of an iterate are solved less exactly.
            Columns::Jacobi if self.problem.joints.is_some() => self.problem.record_response(device, commands),
            Columns::Jacobi => {}
        }
        self.problem.record_residual(device, commands);
    }

    /// The impulses on B of the first `n` contacts, N s, world; the fourth numbers are not used.
    ///
    /// # Errors
    /// [`Fault::Gpu`].
    pub fn impulses(&self, device: &Device, n: usize) -> Result<Vec<[f32; 4]>, Fault> {
        Ok(self.problem.gamma.read(device, n)?)
    }

    /// The velocities of the bodies at the step's end.
    ///
    /// # Errors
    /// [`Fault::Gpu`].
    pub fn motion(&self, device: &Device) -> Result<Vec<Body>, Fault> {
        Ok(self.problem.motion.read(device, self.problem.n_bodies)?)
    }

    /// Solve the problem of the collision's last run, for the velocities of a state, from impulses of zero. Returns the time of the
    /// iterations, s, the number of their dispatches, and that of sweeps over a contact.
    ///
    /// # Errors
    /// [`Fault::Gpu`].
    pub fn run(
        &self,
        device: &Device,
        kernels: &Kernels,
        (model, collision): (&Model, &Collision),
    ) -> Result<(f64, usize, u32), Fault> {
        let mut commands = Commands::new();
        self.problem.record_inertia(&mut commands, &collision.bodies);
        force::record(device, kernels, &mut commands, model, (&collision.bodies, &self.problem.free))?;
        commands.clear(&self.problem.gamma);
        commands.clear(&self.problem.roll);
        self.record_start(device, kernels, &mut commands, (model, collision, false))?;
        commands.submit(device)?;
        let recorded = self.record(device, kernels, false)?;
        let n = self.passes(self.settings.iterations.unwrap_or(PART), false);
        device.wait()?;
        let started = Instant::now();
        let times = Commands::submit_all(device, recorded.lists(0, n, (n, u32::MAX)))?.unobserved().wait(device)?;
        let wall = started.elapsed().as_secs_f64();
        let seconds = times.map_or(wall, |times| times.iter().map(|(_, seconds)| seconds).sum());
        recorded.observe(device, seconds / f64::from(n.max(1)));
        let mut commands = Commands::new();
        self.record_end(device, &mut commands, false);
        commands.submit(device)?;
        let dispatches = recorded.lists(0, n, (n, u32::MAX)).map(Commands::n_dispatches).sum();
        Ok((seconds, dispatches, self.made(n, false).1))
    }
}
