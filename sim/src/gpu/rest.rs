//! A solve without any impulse to start from: it begins with impulses of rest, which the processor finds from the contacts of the step, and
//! by the settings that the plan has for it.
//! in     gamma  [n_contacts]  N s, world
//! out    flag   [1]           whether any of them is not zero
//! Kernel: impulse_flag.wgsl. Twin: cpu/solve/support.rs

use super::parts::{ROWS, kernel};
use super::problem::Problem;
use crate::contacts::Contacts;
use crate::cpu::solve::support;
use crate::model::Model;
use crate::state::State;
use gpu::{Buffer, Commands, Device, GpuError, Groups, Kernel, Kernels};

/// The start from rest.
pub struct Rest {
    look: Kernel,
    groups: Groups,
    flag: Buffer<u32>,
    /// The impulses of rest, where the solver is that of a step without any others.
    pub impulses: Option<Vec<[f32; 4]>>,
}

impl Rest {
    /// Of no step yet.
    pub fn new(device: &Device, kernels: &Kernels) -> Result<Rest, GpuError> {
        Ok(Rest {
            look: kernel(device, kernels, "impulse_flag", include_str!("impulse_flag.wgsl"))?,
            groups: Groups::new(device, kernels, ROWS)?,
            flag: Buffer::zeros(device, "impulse flag", 1)?,
            impulses: None,
        })
    }

    /// Record the look at the impulses.
    pub fn record(&self, device: &Device, commands: &mut Commands, problem: &Problem) {
        let n = &problem.n_contacts;
        commands.clear(&self.flag);
        self.groups.record(device, commands, n);
        let bound = [problem.gamma.bind(), self.flag.bind(), n.n.bind()];
        commands.dispatch(device, &self.look, &bound, &[], self.groups.of_level(n, 0));
    }

    /// Whether any contact had an impulse when its commands ran.
    ///
    /// # Errors
    /// Those of [`Buffer::read`].
    pub fn has_impulses(&self, device: &Device) -> Result<bool, GpuError> {
        Ok(self.flag.read(device, 1)?[0] == 1)
    }
}

/// Impulses that carry the weight of the bodies of a state for a step.
pub fn impulses(model: &Model, state: &State, mut contacts: Contacts) -> Vec<[f32; 4]> {
    support::fill(model, state, &mut contacts);
    contacts.impulse.iter().map(|z| z.as_vec3().extend(0.0).to_array()).collect()
}
