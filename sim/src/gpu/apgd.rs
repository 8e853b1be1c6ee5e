//! Accelerated projected gradient descent on a device, whose scalars stay there: a trial is taken or not, and the next has the step length
//! that follows, without anything read back.
//! in     row      [n_contacts]
//! in     free     [n_bodies]    m/s, rad/s
//! inout  gamma    [n_contacts]  N s, world
//! inout  motion   [n_bodies]    m/s, rad/s
//! Kernels: apgd_contact.wgsl, apgd_body.wgsl, apgd_decide.wgsl, apgd_extrapolate.wgsl; apgd_check.wgsl, apgd_best.wgsl,
//! apgd_keep_contacts.wgsl, apgd_keep_bodies.wgsl for the best iterate. Twin: cpu/solve/apgd.rs, cpu/solve/iterates.rs
//!
//! Bytes of a contact and trial: its row (48), x, previous and z read and x, previous and z written (96), and again by its two bodies (id
//! 4, z 16, row 48 each): 280 from memory.

use super::parts::{bits, kernel_of};
use super::problem::Problem;
use super::rows::Body;
use gpu::{Bound, Buffer, Commands, Device, GpuError, Kernel, Kernels, Work};

/// Bytes of a contact and trial from memory.
pub const BYTES: f64 = 280.0;

/// Trials between checks of the residual, with a tolerance and without one.
const CHECK_INTERVAL: [u32; 2] = [10, 25];

/// Trials between checks of the residual.
pub fn interval(tolerance: f64) -> u32 {
    CHECK_INTERVAL[(tolerance <= 0.0) as usize]
}

/// The columns of the method, and its kernels.
pub struct Apgd {
    contact: Kernel,
    body: Kernel,
    decide: Kernel,
    extrapolate: Kernel,
    check: Kernel,
    best: Kernel,
    keep_contacts: Kernel,
    keep_bodies: Kernel,
    x: Buffer<[f32; 4]>,
    previous: Buffer<[f32; 4]>,
    motion_y: Buffer<Body>,
    motion_next: Buffer<Body>,
    best_gamma: Buffer<[f32; 4]>,
    best_motion: Buffer<Body>,
    /// The same of rolling impulses.
    roll_x: Buffer<[f32; 4]>,
    roll_previous: Buffer<[f32; 4]>,
    roll_best: Buffer<[f32; 4]>,
    tolerance: f64,
}

impl Apgd {
    /// For a problem.
    pub fn new(device: &Device, kernels: &Kernels, problem: &Problem, tolerance: f64) -> Result<Apgd, GpuError> {
        let (room, n_bodies) = (problem.gamma.capacity(), problem.n_bodies);
        let impulses = |name| Buffer::zeros(device, name, room);
        let rolling = |name| Buffer::zeros(device, name, problem.roll.capacity());
        let motions = |name| Buffer::zeros(device, name, n_bodies);
        let get = |name, text| kernel_of(problem.layout, device, kernels, (name, text));
        Ok(Apgd {
            contact: get("apgd_contact", include_str!("apgd_contact.wgsl"))?,
            body: get("apgd_body", include_str!("apgd_body.wgsl"))?,
            decide: get("apgd_decide", include_str!("apgd_decide.wgsl"))?,
            extrapolate: get("apgd_extrapolate", include_str!("apgd_extrapolate.wgsl"))?,
            check: get("apgd_check", include_str!("apgd_check.wgsl"))?,
            best: get("apgd_best", include_str!("apgd_best.wgsl"))?,
            keep_contacts: get("apgd_keep_contacts", include_str!("apgd_keep_contacts.wgsl"))?,
            keep_bodies: get("apgd_keep_bodies", include_str!("apgd_keep_bodies.wgsl"))?,
            x: impulses("x")?,
            previous: impulses("previous")?,
            motion_y: motions("motion_y")?,
            motion_next: motions("motion_next")?,
            best_gamma: impulses("best impulses")?,
            best_motion: motions("best motion")?,
            roll_x: rolling("rolling x")?,
            roll_previous: rolling("previous rolling")?,
            roll_best: rolling("best rolling impulses")?,
            tolerance,
        })
    }

    /// Record the start, from the impulses and velocities of the problem.
    pub fn record_start(&self, commands: &mut Commands, problem: &Problem) {
        for column in [&self.x, &self.previous] {
            commands.copy(&problem.gamma, column, problem.gamma.capacity());
        }
        for column in [&self.roll_x, &self.roll_previous] {
            commands.copy(&problem.roll, column, problem.roll.capacity());
        }
        commands.copy(&problem.motion, &self.motion_y, problem.n_bodies);
    }

    /// Record trials, with checks of the residual at intervals; the trials of a solve are recorded in parts of a multiple of them.
    pub fn record(&self, device: &Device, commands: &mut Commands, problem: &Problem, trials: u32) {
        let (scalars, n) = (problem.scalars.bind(), problem.n_contacts.n.bind());
        let ([row, z, free, side, start], y) = (problem.sums_of_bodies(&problem.gamma), self.motion_y.bind());
        let (sums, body_sums, work) = (problem.of_contacts.bind(), problem.of_bodies.bind(), problem.work.bind());
        let next = self.motion_next.bind();
        let [roll, roll_row] = problem.rolling();
        let rolling = [self.roll_x.bind(), self.roll_previous.bind(), roll, roll_row];
        let of_contacts = [row, y, self.x.bind(), self.previous.bind(), z, sums, scalars, n];
        let of_contacts: Vec<Bound> = of_contacts.into_iter().chain(rolling).collect();
        let [mass, orientation] = problem.inertia();
        let of_bodies = [row, z, free, side, start, y, next, body_sums, mass, orientation, roll];
        let of_decision = [sums, body_sums, scalars, work, n];
        let of_motion = [next, problem.motion.bind(), y, scalars];
        let [over_contacts, over_bodies] = [0, 1].map(|row| Work::Indirect(&problem.work, row));
        let interval = interval(self.tolerance);
        for trial in 1..=trials {
            commands.dispatch(device, &self.contact, &of_contacts, &[], over_contacts);
            commands.dispatch(device, &self.body, &of_bodies, &[], over_bodies);
            if let Some(joints) = &problem.joints {
                joints.record_trial(device, commands, &problem.of_joints(), [next, y]);
            }
            let params = [problem.n_sums()];
            commands.dispatch(device, &self.decide, &of_decision, &params, Work::Groups(1));
            commands.dispatch(device, &self.extrapolate, &of_motion, &[], over_bodies);
            if trial % interval == 0 {
                self.record_check(device, commands, problem, (Work::Indirect(&problem.work, 2), false));
            }
        }
    }

    /// Record a check of the iterate, which is kept if it is the best so far; the last one is made in any case.
    fn record_check(&self, device: &Device, commands: &mut Commands, problem: &Problem, (over, is_last): (Work, bool)) {
        let (scalars, n) = (problem.scalars.bind(), problem.n_contacts.n.bind());
        let (x, next, motion) = (self.x.bind(), problem.gamma.bind(), problem.motion.bind());
        let sums = problem.of_contacts.bind();
        let ([roll, roll_row], roll_x) = (problem.rolling(), self.roll_x.bind());
        commands.dispatch(
            device,
            &self.check,
            &[problem.row(), motion, x, next, scalars, sums, n, roll_x, roll, roll_row],
            &[],
            over,
        );
        let params = [problem.n_bodies as u32, bits(self.tolerance), is_last as u32];
        commands.dispatch(device, &self.best, &[sums, scalars, problem.work.bind(), n], &params, Work::Groups(1));
        let [contacts, bodies] = [3, 4].map(|row| Work::Indirect(&problem.work, row));
        let best = self.best_gamma.bind();
        commands.dispatch(
            device,
            &self.keep_contacts,
            &[x, next, best, scalars, n, roll_x, roll, self.roll_best.bind()],
            &[],
            contacts,
        );
        commands.dispatch(device, &self.keep_bodies, &[motion, self.best_motion.bind()], &[], bodies);
    }

    /// Record the end: the best iterate is the solution.
    pub fn record_end(&self, device: &Device, commands: &mut Commands, problem: &Problem) {
        self.record_check(device, commands, problem, (problem.contacts(), true));
        commands.copy(&self.best_gamma, &problem.gamma, problem.gamma.capacity());
        commands.copy(&self.roll_best, &problem.roll, problem.roll.capacity());
        commands.copy(&self.best_motion, &problem.motion, problem.n_bodies);
    }
}
