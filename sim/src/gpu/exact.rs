//! Coulomb's law itself by a descent method on a device: the slip μ |v_t| is fed back to the rates of the gaps, and the convex problem solved
//! again, until the slip that comes out is the slip that was fed. What a round has come to is read back, and decides whether there is another.
//! Jacobi feeds the slip of each iterate itself.
//! inout  row     [n_contacts]
//! inout  slip    [n_contacts]  m/s
//! inout  gamma   [n_contacts]  N s, world
//! in     motion  [n_bodies]    m/s, rad/s
//! Kernels: slip_measure.wgsl, slip_sum.wgsl, slip_feed.wgsl, solve_limit.wgsl, solve_again.wgsl. Twin: cpu/solve/exact.rs

use super::parts::{bits, kernel, kernel_of};
use super::problem::Problem;
use crate::settings::SolverSettings;
use gpu::{Buffer, Commands, Device, GpuError, Kernel, Kernels, Work};

/// The most rounds.
pub const ROUNDS: u32 = 40;
/// Least number of iterations of a round: with fewer, the slip that is fed would be that of the method's errors.
const LEAST: u32 = 50;

/// The kernels and columns.
pub struct Exact {
    measure: Kernel,
    sum: Kernel,
    feed: Kernel,
    limit: Kernel,
    again: Kernel,
    /// Change of all slips, and their sum, m/s (1).
    sums: Buffer<[f32; 4]>,
    /// The most iterations of the round (1).
    most: Buffer<u32>,
}

/// What the rounds of a step have come to.
#[derive(Clone, Copy, Debug, Default)]
pub struct Rounds {
    /// Iterations of all rounds.
    pub iterations: u32,
    is_fixed_point: bool,
}

impl Rounds {
    /// The most iterations of the next round, of `most` in all.
    pub fn next(&self, most: u32) -> u32 {
        let left = most - self.iterations.min(most - 1);
        if self.is_fixed_point { left } else { (most / 4).max(LEAST).min(left) }
    }
}

impl Exact {
    /// For a problem.
    pub fn new(device: &Device, kernels: &Kernels, problem: &Problem) -> Result<Exact, GpuError> {
        let of = |name, text| kernel_of(problem.layout, device, kernels, (name, text));
        let get = |name, text| kernel(device, kernels, name, text);
        Ok(Exact {
            measure: of("slip_measure", include_str!("slip_measure.wgsl"))?,
            sum: get("slip_sum", include_str!("slip_sum.wgsl"))?,
            feed: of("slip_feed", include_str!("slip_feed.wgsl"))?,
            limit: get("solve_limit", include_str!("solve_limit.wgsl"))?,
            again: of("solve_again", include_str!("solve_again.wgsl"))?,
            sums: Buffer::zeros(device, "slips", 1)?,
            most: Buffer::zeros(device, "most iterations", 1)?,
        })
    }

    /// Set the most iterations of the next round.
    pub fn place_limit(&self, device: &Device, most: u32) {
        self.most.write(device, &[most]);
    }

    /// Record that the slips are fed.
    pub fn record_feed(&self, device: &Device, commands: &mut Commands, problem: &Problem) {
        let n = problem.n_contacts.n.bind();
        commands.dispatch(device, &self.feed, &[problem.row(), problem.slip.bind(), n], &[], problem.contacts());
    }

    /// Record the limit of the first round.
    pub fn record_limit(&self, device: &Device, commands: &mut Commands, problem: &Problem) {
        commands.dispatch(device, &self.limit, &[problem.scalars.bind(), self.most.bind()], &[], Work::Groups(1));
    }

    /// Record the slips of a round's solution.
    pub fn record_measure(&self, device: &Device, commands: &mut Commands, problem: &Problem, least_speed: f64) {
        let (slip, sums, n) = (problem.slip.bind(), problem.of_contacts.bind(), problem.n_contacts.n.bind());
        let bound = [problem.row(), problem.motion.bind(), problem.gamma.bind(), slip, sums, n];
        commands.dispatch(device, &self.measure, &bound, &[bits(least_speed)], problem.contacts());
        commands.dispatch(device, &self.sum, &[sums, self.sums.bind(), n], &[], Work::Groups(1));
    }

    /// Record the beginning of another round, with the first step length of Barzilai–Borwein.
    pub fn record_again(&self, device: &Device, commands: &mut Commands, (problem, omega): (&Problem, f64)) {
        self.record_feed(device, commands, problem);
        let bound = [problem.scalars.bind(), problem.work.bind(), self.most.bind(), problem.n_contacts.n.bind()];
        let params = [problem.n_bodies as u32, bits(omega)];
        commands.dispatch(device, &self.again, &bound, &params, Work::Groups(1));
    }

    /// Add a round of so many iterations that has left this residual. Returns whether there is none to follow.
    ///
    /// # Errors
    /// Those of [`Buffer::read`].
    pub fn add(
        &self,
        device: &Device,
        settings: &SolverSettings,
        (rounds, most): (&mut Rounds, u32),
        (n_blocks, iterations, residual): (usize, u32, f64),
    ) -> Result<bool, GpuError> {
        /// Change of the slips over their sum that is none, in single precision.
        const NONE: f64 = 1e-6;
        let [change, sum, ..] = self.sums.read(device, 1)?[0].map(f64::from);
        rounds.iterations += iterations;
        rounds.is_fixed_point = change <= NONE * sum + 1e-2 * settings.tolerance * n_blocks as f64;
        Ok(rounds.is_fixed_point && residual <= settings.tolerance || rounds.iterations >= most)
    }
}
