//! Spectral projected gradients on a device, whose scalars stay there: the step length is the inverse of a Rayleigh quotient of N along the
//! last step, and the search along the projected direction is exact.
//! in     row      [n_contacts]
//! in     free     [n_bodies]    m/s, rad/s
//! inout  gamma    [n_contacts]  N s, world
//! inout  motion   [n_bodies]    m/s, rad/s
//! Kernels: spectral_contact.wgsl, apgd_body.wgsl, spectral_decide.wgsl, spectral_take_contacts.wgsl, spectral_take_bodies.wgsl. Twin:
//! cpu/solve/barzilai_borwein.rs
//!
//! Bytes of a contact and iteration: its row (48), x read and z written (32), what z turns bodies by (16), again by its two bodies (id 4, z 16,
//! turn 16 each), and x and z read and x written where the step is taken (48): 216 from memory.

use super::iterates::Iterates;
use super::parts::kernel_of;
use super::problem::Problem;
use super::rows::Body;
use gpu::{Buffer, Commands, Device, GpuError, Kernel, Kernels, Work};

/// Bytes of a contact and iteration from memory.
pub const BYTES: f64 = 216.0;

/// The first step length.
pub const FIRST: f64 = 1.0;

/// The columns of the method, and its kernels.
pub struct BarzilaiBorwein {
    contact: Kernel,
    body: Kernel,
    decide: Kernel,
    take: [Kernel; 2],
    iterates: Iterates,
    motion_next: Buffer<Body>,
}

impl BarzilaiBorwein {
    /// For a problem.
    pub fn new(
        device: &Device,
        kernels: &Kernels,
        problem: &Problem,
        tolerance: f64,
    ) -> Result<BarzilaiBorwein, GpuError> {
        let get = |name, text| kernel_of(problem.layout, device, kernels, (name, text));
        Ok(BarzilaiBorwein {
            contact: get("spectral_contact", include_str!("spectral_contact.wgsl"))?,
            body: get("apgd_body", include_str!("apgd_body.wgsl"))?,
            decide: get("spectral_decide", include_str!("spectral_decide.wgsl"))?,
            take: [
                get("spectral_take_contacts", include_str!("spectral_take_contacts.wgsl"))?,
                get("spectral_take_bodies", include_str!("spectral_take_bodies.wgsl"))?,
            ],
            iterates: Iterates::new(device, kernels, problem, (tolerance, 1))?,
            motion_next: Buffer::zeros(device, "motion_next", problem.n_bodies)?,
        })
    }

    /// Record the start, from the impulses and velocities of the problem.
    pub fn record_start(&self, commands: &mut Commands, problem: &Problem) {
        self.iterates.record_start(commands, problem);
    }

    /// Record an iteration. Returns the iterates, which are checked at intervals.
    pub fn record(&self, device: &Device, commands: &mut Commands, problem: &Problem) -> &Iterates {
        let (scalars, n) = (problem.scalars.bind(), problem.n_contacts.n.bind());
        let ([z, free, side, start], motion) = (problem.sums_of_bodies(), problem.motion.bind());
        let (row, spin) = (problem.row(), problem.spin.bind());
        let (sums, body_sums, work) = (problem.of_contacts.bind(), problem.of_bodies.bind(), problem.work.bind());
        let next = self.motion_next.bind();
        let [roll, roll_row] = problem.rolling();
        let [x, roll_x] = self.iterates.x();
        let of_contacts = [row, motion, x, z, sums, scalars, n, roll_x, roll, roll_row, spin];
        let [mass, orientation] = problem.inertia();
        let of_bodies = [spin, z, free, side, start, motion, next, body_sums, mass, orientation, roll];
        let of_decision = [sums, body_sums, scalars, work, n];
        let [over_contacts, over_bodies, until_end] = [0, 1, 2].map(|row| Work::Indirect(&problem.work, row));
        commands.dispatch(device, &self.contact, &of_contacts, &[], over_contacts);
        commands.dispatch(device, &self.body, &of_bodies, &[], over_bodies);
        if let Some(joints) = &problem.joints {
            joints.record_trial(device, commands, &problem.of_joints(), ([next, motion], true));
        }
        let params = [problem.n_sums()];
        commands.dispatch(device, &self.decide, &of_decision, &params, Work::Groups(1));
        let [contacts, bodies] = &self.take;
        commands.dispatch(device, contacts, &[x, z, scalars, n, roll_x, roll], &[], until_end);
        commands.dispatch(device, bodies, &[next, motion, scalars], &[], over_bodies);
        &self.iterates
    }

    /// Record the end: the best iterate is the solution.
    pub fn record_end(&self, device: &Device, commands: &mut Commands, problem: &Problem) {
        self.iterates.record_end(device, commands, problem);
    }
}
