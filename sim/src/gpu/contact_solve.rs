//! Solve the contact problem on a device.
//!
//! ```text
//! in     contact  [n_contacts]  of `contact_write`
//! in     free     [n_bodies]    m/s, rad/s: velocities at the step's end without contacts
//! inout  gamma    [n_contacts]  N s, world: impulses on B
//! out    motion   [n_bodies]    m/s, rad/s: velocities at the step's end
//! ```
//!
//! Twin: cpu/contact_solve.rs. The methods are in `jacobi`, `apgd`, `barzilai_borwein` and `gauss_seidel`, what they share in `problem`. A solve is recorded in three parts, of
//! which that of the iterations is submitted as often as the most iterations ask: once it has converged, its dispatches are empty.

use super::apgd::{self, Apgd};
use super::barzilai_borwein::{self, BarzilaiBorwein};
use super::collision::Collision;
use super::exact::{self, Exact, Rounds};
use super::fault::Fault;
use super::gauss_seidel::{self, GaussSeidel};
use super::iterates::interval;
use super::joints::Joints;
use super::problem::Problem;
use super::rows::Body;
use super::{force, jacobi, scale};
use crate::model::Model;
use crate::plan::has_joints;
use crate::settings::{FrictionLaw, Method, SolverSettings};
use gpu::{Commands, Device, GpuError, Kernels, Timings};

/// Name of the stage.
const STAGE: &str = "contact_solve";

/// The most iterations that are recorded.
const PART: u32 = 50;

/// Bodies times iterations of a part on a software adapter.
const SLOW_ROWS: usize = 250_000;

/// Parts of the iterations that are submitted before the device is asked whether more are needed.
const UNASKED: u32 = 2;

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
    /// Coulomb's law itself, where it is by rounds.
    exact: Option<Exact>,
    settings: SolverSettings,
    /// Speed of one step of free fall, m/s.
    fall: f64,
    is_software: bool,
    /// Bytes of a contact and sweep from memory.
    pub bytes: f64,
    /// Sweeps of an iteration.
    pub sweeps: u32,
}

/// The recorded commands of a solve.
#[derive(Default)]
pub struct Recorded {
    part: Commands,
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
        ContactSolve::with(device, kernels, model, (method, &model.solver), (collision, None))
    }

    /// The same for a model whose joints have columns, with these settings.
    ///
    /// # Errors
    /// Those of [`ContactSolve::new`].
    pub(super) fn with(
        device: &Device,
        kernels: &Kernels,
        model: &Model,
        (method, settings): (Method, &SolverSettings),
        (collision, joints): (&Collision, Option<&Joints>),
    ) -> Result<ContactSolve, Fault> {
        let feeds = settings.friction == FrictionLaw::Exact && method != Method::GaussSeidel;
        let problem = Problem::new(device, kernels, (model, feeds), (collision, joints))?;
        // Jacobi feeds the slip of each iterate.
        let by_rounds = feeds && method != Method::Jacobi;
        let exact = if by_rounds { Some(Exact::new(device, kernels, &problem)?) } else { None };
        let (method, bytes) = match method {
            Method::Jacobi => (Columns::Jacobi, jacobi::BYTES),
            Method::GaussSeidel => {
                let method = GaussSeidel::new(device, kernels, settings, (&problem, collision))?;
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
        let sweeps = if let Columns::GaussSeidel(_) = method { gauss_seidel::SWEEPS } else { 1 };
        let bytes = bytes / f64::from(sweeps);
        let is_software = device.adapter.software;
        let (settings, fall) = (settings.clone(), model.gravity.length() * model.step);
        Ok(ContactSolve { problem, method, exact, settings, fall, is_software, bytes, sweeps })
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

    /// Number of iterations of a part: all, if they are not many; on a software adapter as many as it does in some tenths of a second.
    pub fn part(&self) -> u32 {
        let all = self.settings.iterations.filter(|n| *n <= 2 * PART).unwrap_or(PART);
        if !self.is_software {
            return all;
        }
        let n = self.problem.n_bodies.max(1);
        let (most, step) = match &self.method {
            Columns::GaussSeidel(_) => (SLOW_ROWS / 10 / n, 1),
            Columns::Jacobi => (SLOW_ROWS / n, 1),
            // Whole intervals between its checks.
            Columns::Apgd(_) | Columns::BarzilaiBorwein(_) => (SLOW_ROWS / n, interval(self.settings.tolerance)),
        };
        let most = (most as u32 / step * step).max(step);
        if most < all { most } else { all }
    }

    /// Submit the iterations of a step, once its start has been. Returns the iterations of all rounds, where there are rounds.
    ///
    /// # Errors
    /// Those of [`Commands::submit`] and [`gpu::Buffer::read`].
    pub fn submit(
        &self,
        device: &Device,
        solve: &Recorded,
        times: &mut Vec<Timings>,
    ) -> Result<Option<Rounds>, GpuError> {
        let n = match (&self.exact, self.settings.iterations) {
            // The most iterations follow from the number of contacts.
            (Some(_), _) | (_, None) => self.problem.n_contacts.read(device)?,
            (None, Some(_)) => 1,
        };
        let blocks = if self.problem.layout.rolls { 2 * n } else { n };
        let most = if n == 0 { 0 } else { self.settings.max_iterations(blocks) };
        let Some(exact) = &self.exact else {
            self.submit_parts(device, solve, most, times)?;
            return Ok(None);
        };
        let mut rounds = Rounds::default();
        for round in 0..if n == 0 { 0 } else { exact::ROUNDS } {
            let own = rounds.next(most);
            exact.place_limit(device, own);
            let begin = if round == 0 { &solve.first } else { &solve.again };
            times.push(begin.submit(device)?);
            self.submit_parts(device, solve, own, times)?;
            times.push(solve.measure.submit(device)?);
            let scalars = self.problem.scalars.read(device, 1)?[0];
            let residual = f32::from_bits(scalars[RESIDUAL]) as f64;
            if exact.add(device, &self.settings, (&mut rounds, most), (blocks, scalars[TRIALS], residual))? {
                break;
            }
        }
        Ok(Some(rounds))
    }

    fn submit_parts(
        &self,
        device: &Device,
        solve: &Recorded,
        most: u32,
        times: &mut Vec<Timings>,
    ) -> Result<(), GpuError> {
        for k in 0..most.div_ceil(self.part()) {
            if k > 0 && k % UNASKED == 0 && !self.goes_on(device)? {
                break;
            }
            times.push(solve.part.submit(device)?);
        }
        Ok(())
    }

    /// Record the iterations of a step, and what goes between rounds.
    ///
    /// # Errors
    /// Those of [`Kernels::get`].
    pub fn record(&self, device: &Device, kernels: &Kernels) -> Result<Recorded, GpuError> {
        let mut own = Recorded::default();
        self.record_part(device, kernels, &mut own.part)?;
        let Some(exact) = &self.exact else { return Ok(own) };
        let Recorded { first, measure, again, .. } = &mut own;
        [&mut *first, &mut *again, &mut *measure].into_iter().for_each(|commands| commands.stage(STAGE));
        exact.record_limit(device, first, &self.problem);
        self.record_solution(device, measure);
        exact.record_measure(device, measure, &self.problem, self.fall);
        exact.record_again(device, again, (&self.problem, self.first_length()));
        if self.problem.joints.is_some() {
            // The multipliers of the joints are those of the round's solution.
            self.problem.record_response(device, again, self.problem.bodies());
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

    /// Record the beginning, from the impulses `gamma` of the problem.
    ///
    /// # Errors
    /// Those of [`Kernels::get`].
    pub fn record_start(
        &self,
        device: &Device,
        kernels: &Kernels,
        commands: &mut Commands,
        (model, collision): (&Model, &Collision),
    ) -> Result<(), GpuError> {
        commands.stage(STAGE);
        self.problem.record(device, commands, model, &collision.bodies);
        if let Columns::GaussSeidel(sweeps) = &self.method {
            sweeps.record_start(device, commands, &self.problem, &self.settings);
            return Ok(());
        }
        let first = (self.settings.iterations, self.first_length());
        scale::record(device, kernels, commands, &self.problem, first)?;
        self.record_iterates(commands);
        Ok(())
    }

    /// Record a part of the iterations.
    ///
    /// # Errors
    /// Those of [`Kernels::get`].
    pub fn record_part(&self, device: &Device, kernels: &Kernels, commands: &mut Commands) -> Result<(), GpuError> {
        commands.stage(STAGE);
        match &self.method {
            Columns::Jacobi => {
                jacobi::record(device, kernels, commands, (&self.settings, self.part()), (&self.problem, self.fall))?;
            }
            Columns::Apgd(apgd) => apgd.record(device, commands, &self.problem, self.part()),
            Columns::BarzilaiBorwein(own) => own.record(device, commands, &self.problem, self.part()),
            Columns::GaussSeidel(sweeps) => sweeps.record(device, commands, &self.problem, self.part()),
        }
        Ok(())
    }

    /// Record the end: the solution with its residual, unless the last round has left it.
    pub fn record_end(&self, device: &Device, commands: &mut Commands) {
        commands.stage(STAGE);
        if self.exact.is_none() {
            self.record_solution(device, commands);
        }
    }

    fn record_solution(&self, device: &Device, commands: &mut Commands) {
        match &self.method {
            // Its residual is that of the visits. The velocities are summed again from the impulses, whose momentum is exact.
            Columns::GaussSeidel(_) => {
                let problem = &self.problem;
                problem.record_response(device, commands, problem.bodies());
                return;
            }
            Columns::Apgd(apgd) => apgd.record_end(device, commands, &self.problem),
            Columns::BarzilaiBorwein(own) => own.record_end(device, commands, &self.problem),
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
    /// iterations, s, and the number of their dispatches.
    ///
    /// # Errors
    /// [`Fault::Gpu`].
    pub fn run(
        &self,
        device: &Device,
        kernels: &Kernels,
        (model, collision): (&Model, &Collision),
    ) -> Result<(f64, usize), Fault> {
        let mut commands = Commands::new();
        self.problem.record_inertia(&mut commands, &collision.bodies);
        force::record(device, kernels, &mut commands, model, (&collision.bodies, &self.problem.free))?;
        commands.clear(&self.problem.gamma);
        commands.clear(&self.problem.roll);
        self.record_start(device, kernels, &mut commands, (model, collision))?;
        commands.submit(device)?;
        let mut part = Commands::new();
        self.record_part(device, kernels, &mut part)?;
        let n = self.settings.iterations.unwrap_or(PART).div_ceil(self.part());
        let mut seconds = 0.0;
        for _ in 0..n {
            seconds += part.stage_seconds(device, STAGE)?;
        }
        let mut commands = Commands::new();
        self.record_end(device, &mut commands);
        commands.submit(device)?;
        Ok((seconds, n as usize * part.n_dispatches()))
    }
}
