//! Steps in which a bed lands, which Gauss–Seidel takes over from another method on a device. Which of the two a step is recorded for is what
//! the last one was; the device decides which it is to be, and undoes the step if it was begun for the other, so that it is begun again.
//! in     scalars  [1]  the residual of the starting point
//! inout  verdict  [2]  whether Gauss–Seidel takes over; whether the step is undone
//! inout  room     [3]  whether the step is made, second
//! Kernels: landing.wgsl, landing_undo.wgsl. Twin: cpu/contact_solve.rs

use super::parts::{bits, kernel_of};
use super::problem::Problem;
use crate::settings::SolverSettings;
use gpu::{Buffer, Commands, Device, GpuError, Kernel, Kernels, Work};

/// The kernels and columns.
pub struct Landing {
    decide: Kernel,
    undo: Kernel,
    verdict: Buffer<[u32; 2]>,
    room: Buffer<u32>,
    /// The most iterations, 0 for the default; the bound of the residual as bits.
    params: [u32; 2],
}

impl Landing {
    /// For a problem; `room` says whether a step is made, and `bound` (m/s) is that of the root mean square of residual terms.
    pub fn new(
        device: &Device,
        kernels: &Kernels,
        (problem, room): (&Problem, &Buffer<u32>),
        (settings, bound): (&SolverSettings, f64),
    ) -> Result<Landing, GpuError> {
        let get = |name, text| kernel_of(problem.layout, device, kernels, (name, text));
        Ok(Landing {
            decide: get("landing", include_str!("landing.wgsl"))?,
            undo: get("landing_undo", include_str!("landing_undo.wgsl"))?,
            verdict: Buffer::zeros(device, "verdict", 1)?,
            room: room.clone(),
            params: [settings.iterations.unwrap_or(0), bits(bound)],
        })
    }

    /// Record the decision, from the starting point and its velocities.
    pub fn record(&self, device: &Device, commands: &mut Commands, problem: &Problem) {
        problem.record_residual(device, commands);
        let bound = [problem.scalars.bind(), problem.n_contacts.n.bind(), self.verdict.bind()];
        commands.dispatch(device, &self.decide, &bound, &self.params, Work::Groups(1));
    }

    /// Record, after the beginning of a method whose workgroups these are, that the step is undone if it is for the other one.
    pub fn record_undo(
        &self,
        device: &Device,
        commands: &mut Commands,
        (problem, work): (&Problem, &Buffer<[u32; 4]>),
        is_landing: bool,
    ) {
        let bound = [self.verdict.bind(), problem.scalars.bind(), work.bind(), self.room.bind()];
        let params = [is_landing as u32, work.capacity() as u32];
        commands.dispatch(device, &self.undo, &bound, &params, Work::Groups(1));
    }

    /// Whether the step was undone for this; it can be begun again then.
    ///
    /// # Errors
    /// Those of [`Buffer::read`].
    pub fn has_undone(&self, device: &Device) -> Result<bool, GpuError> {
        let [[_, is_undone]] = self.verdict.read(device, 1)?[..] else { return Ok(false) };
        if is_undone == 1 {
            self.room.write_from(device, 1, &[1]);
        }
        Ok(is_undone == 1)
    }
}
