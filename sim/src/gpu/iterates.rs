//! The iterates of the descent methods on a device, and the best of them, which is evaluated at intervals and at the end.
//! in     row      [n_contacts]
//! inout  gamma    [n_contacts]  N s, world: the trial, then the solution
//! inout  motion   [n_bodies]    m/s, rad/s: those of the iterate x
//! Kernels: apgd_check.wgsl, apgd_best.wgsl, apgd_keep_contacts.wgsl, apgd_keep_bodies.wgsl. Twin: cpu/solve/iterates.rs

use super::parts::{bits, kernel_of};
use super::problem::Problem;
use super::rows::Body;
use gpu::{Bound, Buffer, Commands, Device, GpuError, Kernel, Kernels, Work};

/// Iterations between checks of the residual, with a tolerance and without one.
const CHECK_INTERVAL: [u32; 2] = [10, 25];

/// Iterations between checks of the residual.
pub fn interval(tolerance: f64) -> u32 {
    CHECK_INTERVAL[(tolerance <= 0.0) as usize]
}

/// The columns, and their kernels.
pub struct Iterates {
    check: Kernel,
    best: Kernel,
    keep_contacts: Kernel,
    keep_bodies: Kernel,
    /// The iterate x, in one half of two, where there are two.
    x: Buffer<[f32; 4]>,
    best_gamma: Buffer<[f32; 4]>,
    best_motion: Buffer<Body>,
    /// The same of rolling impulses.
    roll_x: Buffer<[f32; 4]>,
    roll_best: Buffer<[f32; 4]>,
    /// Residual below which a solve ends, m/s.
    pub tolerance: f64,
}

impl Iterates {
    /// For a problem. With two `halves` the columns of x have the iterate before it, too.
    pub fn new(
        device: &Device,
        kernels: &Kernels,
        problem: &Problem,
        (tolerance, halves): (f64, usize),
    ) -> Result<Iterates, GpuError> {
        let impulses = |name| Buffer::zeros(device, name, problem.gamma.capacity());
        let rolling = |name| Buffer::zeros(device, name, problem.roll.capacity());
        let get = |name, text| kernel_of(problem.layout, device, kernels, (name, text));
        Ok(Iterates {
            check: get("apgd_check", include_str!("apgd_check.wgsl"))?,
            best: get("apgd_best", include_str!("apgd_best.wgsl"))?,
            keep_contacts: get("apgd_keep_contacts", include_str!("apgd_keep_contacts.wgsl"))?,
            keep_bodies: get("apgd_keep_bodies", include_str!("apgd_keep_bodies.wgsl"))?,
            x: Buffer::zeros(device, "x", halves * problem.gamma.capacity())?,
            best_gamma: impulses("best impulses")?,
            best_motion: Buffer::zeros(device, "best motion", problem.n_bodies)?,
            roll_x: Buffer::zeros(device, "rolling x", halves * problem.roll.capacity())?,
            roll_best: rolling("best rolling impulses")?,
            tolerance,
        })
    }

    /// The iterate, and its rolling impulses.
    pub fn x(&self) -> [Bound<'_>; 2] {
        [self.x.bind(), self.roll_x.bind()]
    }

    /// Record that the impulses of the problem are the first iterate.
    pub fn record_start(&self, commands: &mut Commands, problem: &Problem) {
        commands.copy(&problem.gamma, &self.x, problem.gamma.capacity());
        commands.copy(&problem.roll, &self.roll_x, problem.roll.capacity());
    }

    /// Record a check of the iterate, which is kept if it is the best so far.
    pub fn record_check(&self, device: &Device, commands: &mut Commands, problem: &Problem) {
        self.record(device, commands, problem, (Work::Indirect(&problem.work, 2), false));
    }

    /// Record the last check, which is made in any case, and that the best iterate is the solution.
    pub fn record_end(&self, device: &Device, commands: &mut Commands, problem: &Problem) {
        self.record(device, commands, problem, (problem.contacts(), true));
        commands.copy(&self.best_gamma, &problem.gamma, problem.gamma.capacity());
        commands.copy(&self.roll_best, &problem.roll, problem.roll.capacity());
        commands.copy(&self.best_motion, &problem.motion, problem.n_bodies);
    }

    fn record(&self, device: &Device, commands: &mut Commands, problem: &Problem, (over, is_last): (Work, bool)) {
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
}
