//! Projected Jacobi for contacts between spheres, on a device: rows, the contacts of each body, and iterations of two kernels each.
//! in   contact  [n_contacts]  of `contact_write`
//! in   free     [n_bodies]    m/s, rad/s: velocities at the step's end without contacts
//! out  gamma    [n_contacts]  N s, world: impulses on B
//! out  motion   [n_bodies]    m/s, rad/s: velocities at the step's end
//! Kernels: solve_rows.wgsl, bin_clear.wgsl, bin_start.wgsl, jacobi_contact.wgsl, jacobi_body.wgsl. Twin: cpu/solve/jacobi.rs
//!
//! Bytes of a contact and iteration: its row (48), impulse read and written (32), and again by its two bodies (id 4, impulse 16, row 48
//! each): 216 from memory. The velocities of the bodies, 32 bytes each, are read twice by a contact and written once; those of neighbours
//! are near in memory and stay in the cache.

use super::collision::Collision;
use super::rows::Body;
use super::spheres::{Fault, ROWS, groups, kernel};
use crate::inertia::is_isotropic;
use crate::model::Model;
use crate::settings::{FrictionLaw, SolverSettings};
use crate::state::State;
use gpu::radix_sort::RadixSort;
use gpu::{Buffer, Commands, Count, Device, Groups, Kernel, Kernels};

/// Bytes of a contact and iteration from memory.
pub const BYTES: f64 = 216.0;

/// Name of the stage of the iterations, in times.
pub const ITERATIONS: &str = "jacobi";

/// The solver, recorded for the contacts of a collision.
pub struct Jacobi {
    free: Buffer<Body>,
    motion: Buffer<Body>,
    gamma: Buffer<[f32; 4]>,
    commands: Commands,
    n_bodies: usize,
}

/// The kernels, and the columns that no one else reads.
struct Parts {
    rows: Kernel,
    clear: Kernel,
    start: Kernel,
    contact: Kernel,
    body: Kernel,
    sort: RadixSort<u32>,
    of_contacts: Groups,
    of_sides: Groups,
    /// Rows of the contacts (n_contacts).
    row: Buffer<[u32; 12]>,
    /// Bodies of the sides, and the sides, sorted by body (2 n_contacts).
    sides: [Buffer<u32>; 2],
    /// First side of each body, and the end (n_bodies).
    side_start: Buffer<[u32; 2]>,
    n_sides: Count,
    n_bodies: Count,
    friction: Buffer<f32>,
}

impl Jacobi {
    /// For the contacts of a collision, as many as it has room for now: after a run that has made more room, the solver is made again.
    ///
    /// # Errors
    /// [`Fault::Unsupported`] for a model with joints, springs, loads, or laws or settings that no kernel is built for; [`Fault::Gpu`].
    pub fn new(device: &Device, kernels: &Kernels, model: &Model, collision: &Collision) -> Result<Jacobi, Fault> {
        supported(model)?;
        let (contact, n_contacts) = collision.columns();
        let (n_bodies, room) = (model.n_bodies(), contact.capacity());
        let parts = Parts::new(device, kernels, model, room)?;
        let mut jacobi = Jacobi {
            free: Buffer::zeros(device, "free", n_bodies)?,
            motion: Buffer::zeros(device, "motion", n_bodies)?,
            gamma: Buffer::zeros(device, "gamma", room)?,
            commands: Commands::new(),
            n_bodies,
        };
        let c = &mut jacobi.commands;
        c.stage("solve_rows");
        let columns = [contact.bind(), jacobi.free.bind(), parts.friction.bind(), parts.row.bind()];
        let sides = [parts.sides[0].bind(), parts.sides[1].bind(), parts.n_sides.n.bind(), n_contacts.n.bind()];
        let bound: Vec<gpu::Bound> = columns.into_iter().chain(sides).collect();
        parts.of_contacts.record(device, c, n_contacts);
        let work = parts.of_contacts.of_level(n_contacts, 0);
        c.clear(&parts.n_sides.n);
        c.dispatch(device, &parts.rows, &bound, &[(1.0 / model.step as f32).to_bits()], work);
        parts.record_sides(device, c, n_bodies);
        c.stage(ITERATIONS);
        c.clear(&jacobi.gamma);
        let [row, gamma, motion, free] =
            [parts.row.bind(), jacobi.gamma.bind(), jacobi.motion.bind(), jacobi.free.bind()];
        let of_body = [row, gamma, free, parts.sides[1].bind(), parts.side_start.bind(), motion];
        c.dispatch(device, &parts.body, &of_body, &[], groups(n_bodies));
        let SolverSettings { omega, lambda, .. } = model.solver;
        let factors = [omega.unwrap_or(OMEGA), lambda].map(|x| (x as f32).to_bits());
        for _ in 0..iterations(&model.solver)? {
            c.dispatch(device, &parts.contact, &[row, motion, gamma, n_contacts.n.bind()], &factors, work);
            c.dispatch(device, &parts.body, &of_body, &[], groups(n_bodies));
        }
        Ok(jacobi)
    }

    /// Solve the contact problem of the collision's last run, for the velocities of a state, from impulses of zero.
    ///
    /// # Errors
    /// [`Fault::Gpu`].
    pub fn run(&self, device: &Device, model: &Model, state: &State) -> Result<(), Fault> {
        self.free.write(device, &bodies(model, state));
        self.commands.submit(device)?;
        Ok(())
    }

    /// The impulses on B of the first `n` contacts, N s, world; the fourth numbers are not used.
    ///
    /// # Errors
    /// [`Fault::Gpu`].
    pub fn impulses(&self, device: &Device, n: usize) -> Result<Vec<[f32; 4]>, Fault> {
        Ok(self.gamma.read(device, n)?)
    }

    /// The velocities of the bodies at the step's end.
    ///
    /// # Errors
    /// [`Fault::Gpu`].
    pub fn motion(&self, device: &Device) -> Result<Vec<Body>, Fault> {
        Ok(self.motion.read(device, self.n_bodies)?)
    }

    /// The time of the iterations of a solve, s.
    ///
    /// # Errors
    /// [`Fault::Gpu`].
    pub fn seconds(&self, device: &Device) -> Result<f64, Fault> {
        Ok(self.commands.stage_seconds(device, ITERATIONS)?)
    }
}

/// ω where the model gives none.
const OMEGA: f64 = 0.3;

impl Parts {
    fn new(device: &Device, kernels: &Kernels, model: &Model, room: usize) -> Result<Parts, Fault> {
        let friction: Vec<f32> = model.laws.iter().map(|law| law.friction as f32).collect();
        let groups = || Groups::new(device, kernels, ROWS);
        let sides = || Buffer::zeros(device, "sides", 2 * room);
        Ok(Parts {
            rows: kernel(device, kernels, "solve_rows", include_str!("solve_rows.wgsl"))?,
            clear: kernel(device, kernels, "bin_clear", include_str!("bin_clear.wgsl"))?,
            start: kernel(device, kernels, "bin_start", include_str!("bin_start.wgsl"))?,
            contact: kernel(device, kernels, "jacobi_contact", include_str!("jacobi_contact.wgsl"))?,
            body: kernel(device, kernels, "jacobi_body", include_str!("jacobi_body.wgsl"))?,
            sort: RadixSort::new(device, kernels, 2 * room)?,
            of_contacts: groups()?,
            of_sides: groups()?,
            row: Buffer::zeros(device, "rows", room)?,
            sides: [sides()?, sides()?],
            side_start: Buffer::zeros(device, "side_start", model.n_bodies())?,
            n_sides: Count::found(device, 2 * room)?,
            n_bodies: Count::of(device, model.n_bodies())?,
            friction: Buffer::of(device, "friction", &friction)?,
        })
    }

    /// Record the sort of the sides by body.
    fn record_sides(&self, device: &Device, commands: &mut Commands, n_bodies: usize) {
        let [body, side] = &self.sides;
        self.sort.record(device, commands, (body, side), &self.n_sides, n_bodies as u32);
        let bound = [self.side_start.bind(), self.n_bodies.n.bind()];
        commands.dispatch(device, &self.clear, &bound, &[], groups(n_bodies));
        self.of_sides.record(device, commands, &self.n_sides);
        let bound = [body.bind(), self.side_start.bind(), self.n_sides.n.bind()];
        commands.dispatch(device, &self.start, &bound, &[], self.of_sides.of_level(&self.n_sides, 0));
    }
}

/// Refuse what no kernel is built for.
fn supported(model: &Model) -> Result<(), Fault> {
    let law = |has: fn(&crate::model::ContactLaw) -> bool| model.laws.iter().any(has);
    let anisotropic = || model.inv_inertia.iter().any(|i| !is_isotropic(*i));
    let faults = [
        (!model.joints.is_empty() || !model.springs.is_empty(), "joints and springs"),
        (!model.loads.is_empty(), "loads"),
        (law(|l| l.restitution > 0.0), "restitution"),
        (law(|l| l.cohesion != 0.0), "cohesion"),
        (law(|l| l.rolling > 0.0 || l.spinning > 0.0), "rolling and spinning friction"),
        (model.solver.friction == FrictionLaw::Exact, "exact friction by Jacobi"),
        (anisotropic(), "bodies of anisotropic inertia"),
    ];
    match faults.iter().find(|(is_there, _)| *is_there) {
        Some((_, what)) => Err(Fault::Unsupported(format!("no kernel is built yet for {what}"))),
        None => Ok(()),
    }
}

/// Number of iterations, which must be given: the default depends on the number of contacts, which only the device knows.
fn iterations(settings: &SolverSettings) -> Result<u32, Fault> {
    settings.iterations.ok_or_else(|| Fault::Unsupported("the number of iterations must be given".into()))
}

/// The bodies' velocities at the step's end without contacts, and their masses.
fn bodies(model: &Model, state: &State) -> Vec<Body> {
    let body = |b: usize| {
        if !state.moves(b) {
            return Body::default();
        }
        let (v, w) = (state.velocity[b] + model.gravity * model.step, state.twist(b).w);
        let single = |v: glam::DVec3| v.as_vec3().to_array();
        let [inv_mass, inv_inertia] = [model.inv_mass[b], model.inv_inertia[b].x].map(|x| x as f32);
        Body { v: single(v), inv_mass, w: single(w), inv_inertia }
    };
    (0..model.n_bodies()).map(body).collect()
}
