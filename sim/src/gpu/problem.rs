//! The contact problem of spheres on a device: rows of the contacts, and the contacts of each body.
//! in   contact     [n_contacts]    of `contact_write`
//! in   free        [n_bodies]      m/s, rad/s: velocities at the step's end without contacts
//! out  row         [n_contacts]
//! out  side        [2 n_contacts]  sorted by body: twice the contact, and one more for B
//! out  side_start  [n_bodies]      first side of each body, and the end
//! Kernels: solve_rows.wgsl, bin_clear.wgsl, bin_start.wgsl, and the sort. Twin: cpu/contact_solve.rs

use super::collision::Collision;
use super::rows::Body;
use super::spheres::{Fault, ROWS, groups, kernel};
use crate::model::Model;
use crate::state::State;
use gpu::radix_sort::RadixSort;
use gpu::{Bound, Buffer, Commands, Count, Device, Groups, Kernel, Kernels, Work};

/// The problem, with room for as many contacts as a collision has.
pub struct Problem {
    /// Velocities without contacts, and masses (n_bodies).
    pub free: Buffer<Body>,
    /// Number of bodies.
    pub n_bodies: usize,
    /// Number of contacts, and the most that there can be.
    pub n_contacts: Count,
    rows: Kernel,
    clear: Kernel,
    start: Kernel,
    sort: RadixSort<u32>,
    of_contacts: Groups,
    of_sides: Groups,
    /// Rows of the contacts (n_contacts).
    row: Buffer<[u32; 12]>,
    /// Bodies of the sides, and the sides (2 n_contacts).
    sides: [Buffer<u32>; 2],
    side_start: Buffer<[u32; 2]>,
    n_sides: Count,
    /// Number of bodies, for kernels.
    pub all_bodies: Count,
    friction: Buffer<f32>,
}

/// What a method writes.
pub struct Columns {
    /// Impulses on B, N s, world; the fourth numbers are not used (n_contacts).
    pub gamma: Buffer<[f32; 4]>,
    /// Velocities at the step's end, m/s, rad/s (n_bodies).
    pub motion: Buffer<Body>,
}

impl Problem {
    /// For the contacts of a collision.
    pub fn new(device: &Device, kernels: &Kernels, model: &Model, collision: &Collision) -> Result<Problem, Fault> {
        let (contact, n_contacts) = collision.columns();
        let (n_bodies, room) = (model.n_bodies(), contact.capacity());
        let friction: Vec<f32> = model.laws.iter().map(|law| law.friction as f32).collect();
        let sides = || Buffer::zeros(device, "sides", 2 * room);
        Ok(Problem {
            free: Buffer::zeros(device, "free", n_bodies)?,
            n_bodies,
            n_contacts: n_contacts.clone(),
            rows: kernel(device, kernels, "solve_rows", include_str!("solve_rows.wgsl"))?,
            clear: kernel(device, kernels, "bin_clear", include_str!("bin_clear.wgsl"))?,
            start: kernel(device, kernels, "bin_start", include_str!("bin_start.wgsl"))?,
            sort: RadixSort::new(device, kernels, 2 * room)?,
            of_contacts: Groups::new(device, kernels, ROWS)?,
            of_sides: Groups::new(device, kernels, ROWS)?,
            row: Buffer::zeros(device, "rows", room)?,
            sides: [sides()?, sides()?],
            side_start: Buffer::zeros(device, "side_start", n_bodies)?,
            n_sides: Count::found(device, 2 * room)?,
            all_bodies: Count::of(device, n_bodies)?,
            friction: Buffer::of(device, "friction", &friction)?,
        })
    }

    /// Record what does not change during a solve.
    pub fn record(&self, device: &Device, commands: &mut Commands, model: &Model, collision: &Collision) {
        let (contact, n_contacts) = collision.columns();
        let [body, side] = &self.sides;
        commands.clear(&self.n_sides.n);
        self.of_contacts.record(device, commands, n_contacts);
        let columns = [contact.bind(), self.free.bind(), self.friction.bind(), self.row.bind()];
        let sides = [body.bind(), side.bind(), self.n_sides.n.bind(), n_contacts.n.bind()];
        let bound: Vec<Bound> = columns.into_iter().chain(sides).collect();
        let params = [(1.0 / model.step as f32).to_bits()];
        commands.dispatch(device, &self.rows, &bound, &params, self.contacts());
        self.sort.record(device, commands, (body, side), &self.n_sides, self.n_bodies as u32);
        let bound = [self.side_start.bind(), self.all_bodies.n.bind()];
        commands.dispatch(device, &self.clear, &bound, &[], self.bodies());
        self.of_sides.record(device, commands, &self.n_sides);
        let bound = [body.bind(), self.side_start.bind(), self.n_sides.n.bind()];
        commands.dispatch(device, &self.start, &bound, &[], self.of_sides.of_level(&self.n_sides, 0));
    }

    /// The workgroups of a kernel over contacts, after [`Problem::record`].
    pub fn contacts(&self) -> Work<'_> {
        self.of_contacts.of_level(&self.n_contacts, 0)
    }

    /// The workgroups of a kernel over bodies.
    pub fn bodies(&self) -> Work<'static> {
        groups(self.n_bodies)
    }

    /// The rows of the contacts.
    pub fn row(&self) -> Bound<'_> {
        self.row.bind()
    }

    /// What a kernel that sums over the contacts of bodies binds: rows, impulses, free velocities, sides, starts.
    pub fn of_bodies<'a>(&'a self, gamma: &'a Buffer<[f32; 4]>) -> [Bound<'a>; 5] {
        [self.row(), gamma.bind(), self.free.bind(), self.sides[1].bind(), self.side_start.bind()]
    }

    /// Write the velocities at the step's end without contacts.
    pub fn place(&self, device: &Device, model: &Model, state: &State) {
        let body = |b: usize| {
            if !state.moves(b) {
                return Body::default();
            }
            let (v, w) = (state.velocity[b] + model.gravity * model.step, state.twist(b).w);
            let single = |v: glam::DVec3| v.as_vec3().to_array();
            let [inv_mass, inv_inertia] = [model.inv_mass[b], model.inv_inertia[b].x].map(|x| x as f32);
            Body { v: single(v), inv_mass, w: single(w), inv_inertia }
        };
        let bodies: Vec<Body> = (0..self.n_bodies).map(body).collect();
        self.free.write(device, &bodies);
    }
}
