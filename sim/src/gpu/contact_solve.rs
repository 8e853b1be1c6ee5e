//! Solve the contact problem of spheres on a device, recorded once for the contacts of a collision.
//!
//! ```text
//! in   contact  [n_contacts]  of `contact_write`
//! in   free     [n_bodies]    m/s, rad/s: velocities at the step's end without contacts
//! out  gamma    [n_contacts]  N s, world: impulses on B
//! out  motion   [n_bodies]    m/s, rad/s: velocities at the step's end
//! ```
//!
//! Twin: cpu/contact_solve.rs. The methods are in `jacobi` and `apgd`, what they share in `problem`.

use super::collision::Collision;
use super::problem::{Columns, Problem};
use super::rows::Body;
use super::spheres::Fault;
use super::{apgd, jacobi};
use crate::inertia::is_isotropic;
use crate::model::{ContactLaw, Model};
use crate::settings::{FrictionLaw, Method};
use crate::state::State;
use gpu::{Buffer, Commands, Device, Kernels};

/// Name of the stage of the iterations, in times.
const ITERATIONS: &str = "iterations";

/// The solver of a model's contacts by the method of its settings.
pub struct ContactSolve {
    problem: Problem,
    columns: Columns,
    commands: Commands,
    /// Bytes of a contact and iteration from memory.
    pub bytes: f64,
}

impl ContactSolve {
    /// For the contacts of a collision, as many as it has room for now: after a run that has made more room, the solver is made again.
    ///
    /// # Errors
    /// [`Fault::Unsupported`] for a model with joints, springs, loads, or laws or settings that no kernel is built for; [`Fault::Gpu`].
    pub fn new(
        device: &Device,
        kernels: &Kernels,
        model: &Model,
        collision: &Collision,
    ) -> Result<ContactSolve, Fault> {
        supported(model)?;
        let settings = &model.solver;
        let unsupported = |message: &str| Fault::Unsupported(message.into());
        // The default depends on the number of contacts, which the device alone knows.
        let iterations = settings.iterations.ok_or_else(|| unsupported("the number of iterations must be given"))?;
        let problem = Problem::new(device, kernels, model, collision)?;
        let columns = Columns {
            gamma: Buffer::zeros(device, "gamma", problem.n_contacts.capacity)?,
            motion: Buffer::zeros(device, "motion", problem.n_bodies)?,
        };
        let mut commands = Commands::new();
        commands.stage("problem");
        problem.record(device, &mut commands, model, collision);
        commands.stage(ITERATIONS);
        let c = &mut commands;
        let bytes = match settings.method {
            Some(Method::Jacobi) => {
                jacobi::record(device, kernels, c, (settings, iterations), &problem, &columns)?;
                jacobi::BYTES
            }
            Some(Method::Apgd) => {
                apgd::record(device, kernels, c, iterations, &problem, &columns)?;
                apgd::BYTES
            }
            _ => return Err(unsupported("no kernel is built yet for this method: give `jacobi` or `apgd`")),
        };
        Ok(ContactSolve { problem, columns, commands, bytes })
    }

    /// Solve the problem of the collision's last run, for the velocities of a state, from impulses of zero.
    ///
    /// # Errors
    /// [`Fault::Gpu`].
    pub fn run(&self, device: &Device, model: &Model, state: &State) -> Result<(), Fault> {
        self.problem.place(device, model, state);
        self.commands.submit(device)?;
        Ok(())
    }

    /// The impulses on B of the first `n` contacts, N s, world; the fourth numbers are not used.
    ///
    /// # Errors
    /// [`Fault::Gpu`].
    pub fn impulses(&self, device: &Device, n: usize) -> Result<Vec<[f32; 4]>, Fault> {
        Ok(self.columns.gamma.read(device, n)?)
    }

    /// The velocities of the bodies at the step's end.
    ///
    /// # Errors
    /// [`Fault::Gpu`].
    pub fn motion(&self, device: &Device) -> Result<Vec<Body>, Fault> {
        Ok(self.columns.motion.read(device, self.problem.n_bodies)?)
    }

    /// The time of the iterations of a solve, s.
    ///
    /// # Errors
    /// [`Fault::Gpu`].
    pub fn seconds(&self, device: &Device) -> Result<f64, Fault> {
        Ok(self.commands.stage_seconds(device, ITERATIONS)?)
    }

    /// Number of dispatches of a solve.
    pub fn n_dispatches(&self) -> usize {
        self.commands.n_dispatches()
    }
}

/// Refuse what no kernel is built for.
fn supported(model: &Model) -> Result<(), Fault> {
    let law = |has: fn(&ContactLaw) -> bool| model.laws.iter().any(has);
    let faults = [
        (!model.joints.is_empty() || !model.springs.is_empty(), "joints and springs"),
        (!model.loads.is_empty(), "loads"),
        (law(|l| l.restitution > 0.0), "restitution"),
        (law(|l| l.cohesion != 0.0), "cohesion"),
        (law(|l| l.rolling > 0.0 || l.spinning > 0.0), "rolling and spinning friction"),
        (model.solver.friction == FrictionLaw::Exact, "exact friction"),
        (model.inv_inertia.iter().any(|i| !is_isotropic(*i)), "bodies of anisotropic inertia"),
    ];
    match faults.iter().find(|(is_there, _)| *is_there) {
        Some((_, what)) => Err(Fault::Unsupported(format!("no kernel is built yet for {what}"))),
        None => Ok(()),
    }
}
