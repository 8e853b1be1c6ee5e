//! Accelerated projected gradient descent on a device, whose scalars stay there: a trial is taken or not, and the next has the step length
//! that follows, without anything read back.
//! in     row      [n_contacts]
//! in     free     [n_bodies]    m/s, rad/s
//! inout  gamma    [n_contacts]  N s, world
//! inout  motion   [n_bodies]    m/s, rad/s
//! Kernels: apgd_contact.wgsl, apgd_body.wgsl, apgd_decide.wgsl, apgd_extrapolate.wgsl. Twin: cpu/solve/apgd.rs
//!
//! Bytes of a contact and trial: its row (48), z, which is x by now, and the iterate before it read, x and z written (64), what z turns bodies by
//! (16), and again by its two bodies (id 4, z 16, turn 16 each): 200 from memory. The halves of the columns of x take turns in having it, so that
//! neither iterate is copied.

use super::iterates::Iterates;
use super::parts::kernel_of;
use super::problem::Problem;
use super::rows::Body;
use gpu::{Bound, Buffer, Commands, Device, GpuError, Kernel, Kernels, Work};

/// Bytes of a contact and trial from memory.
pub const BYTES: f64 = 200.0;

/// The columns of the method, and its kernels.
pub struct Apgd {
    contact: Kernel,
    body: Kernel,
    decide: Kernel,
    extrapolate: Kernel,
    iterates: Iterates,
    motion_y: Buffer<Body>,
    motion_next: Buffer<Body>,
}

impl Apgd {
    /// For a problem.
    pub fn new(device: &Device, kernels: &Kernels, problem: &Problem, tolerance: f64) -> Result<Apgd, GpuError> {
        let motions = |name| Buffer::zeros(device, name, problem.n_bodies);
        let get = |name, text| kernel_of(problem.layout, device, kernels, (name, text));
        Ok(Apgd {
            contact: get("apgd_contact", include_str!("apgd_contact.wgsl"))?,
            body: get("apgd_body", include_str!("apgd_body.wgsl"))?,
            decide: get("apgd_decide", include_str!("apgd_decide.wgsl"))?,
            extrapolate: get("apgd_extrapolate", include_str!("apgd_extrapolate.wgsl"))?,
            iterates: Iterates::new(device, kernels, problem, (tolerance, 2))?,
            motion_y: motions("motion_y")?,
            motion_next: motions("motion_next")?,
        })
    }

    /// Record the start, from the impulses and velocities of the problem.
    pub fn record_start(&self, commands: &mut Commands, problem: &Problem) {
        self.iterates.record_start(commands, problem);
        commands.copy(&problem.motion, &self.motion_y, problem.n_bodies);
    }

    /// Record a trial. Returns the iterates, which are checked at intervals.
    pub fn record(&self, device: &Device, commands: &mut Commands, problem: &Problem) -> &Iterates {
        let (scalars, n) = (problem.scalars.bind(), problem.n_contacts.n.bind());
        let ([z, free, side, start], y) = (problem.sums_of_bodies(), self.motion_y.bind());
        let (row, spin) = (problem.row(), problem.spin.bind());
        let (sums, body_sums, work) = (problem.of_contacts.bind(), problem.of_bodies.bind(), problem.work.bind());
        let next = self.motion_next.bind();
        let [roll, roll_row] = problem.rolling();
        let [x, roll_x] = self.iterates.x();
        let rolling = [roll_x, roll, roll_row];
        let of_contacts = [row, y, x, z, sums, scalars, n];
        let of_contacts: Vec<Bound> = of_contacts.into_iter().chain(rolling).chain([spin]).collect();
        let [mass, orientation] = problem.inertia();
        let of_bodies = [spin, z, free, side, start, y, next, body_sums, mass, orientation, roll];
        let of_decision = [sums, body_sums, scalars, work, n];
        let of_motion = [next, problem.motion.bind(), y, scalars];
        commands.dispatch(device, &self.contact, &of_contacts, &[], problem.any_contacts());
        commands.dispatch(device, &self.body, &of_bodies, &[], problem.bodies());
        if let Some(joints) = &problem.joints {
            joints.record_trial(device, commands, &problem.of_joints(), ([next, y], false));
        }
        let params = [problem.n_sums()];
        commands.dispatch(device, &self.decide, &of_decision, &params, Work::Groups(1));
        commands.dispatch(device, &self.extrapolate, &of_motion, &[], problem.bodies());
        &self.iterates
    }

    /// Record the end: the best iterate is the solution.
    pub fn record_end(&self, device: &Device, commands: &mut Commands, problem: &Problem) {
        self.iterates.record_end(device, commands, problem);
    }
}
