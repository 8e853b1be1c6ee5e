//! Impacts one after another, which the processor finds: it takes the contacts of the step, and hands to the device what the impacts change of
//! the velocities.
//! in     contacts of the step, velocities
//! inout  free  [n_bodies]  m/s, rad/s
//! Kernel: impact_add.wgsl. Twin: cpu/impacts.rs

use super::parts::{groups, kernel};
use super::problem::Problem;
use super::rows::Body;
use crate::cpu::impacts;
use crate::cpu::masses::Masses;
use crate::model::Model;
use crate::plan::StepPlan;
use crate::state::State;
use crate::twist::Twist;
use gpu::{Buffer, Commands, Device, GpuError, Kernel, Kernels};

/// The column of the impacts, and its kernel.
pub struct Impacts {
    add: Kernel,
    /// Changes of the velocities, m/s, rad/s (n_bodies).
    change: Buffer<Body>,
}

impl Impacts {
    /// For a plan that has impacts one after another; else none.
    pub fn new(
        device: &Device,
        kernels: &Kernels,
        model: &Model,
        plan: &StepPlan,
    ) -> Result<Option<Impacts>, GpuError> {
        if !plan.has_sequential_impacts {
            return Ok(None);
        }
        let add = kernel(device, kernels, "impact_add", include_str!("impact_add.wgsl"))?;
        Ok(Some(Impacts { add, change: Buffer::zeros(device, "impacts", model.n_bodies())? }))
    }

    /// Write the impacts of a step.
    pub fn place(&self, device: &Device, impacts: &[Twist]) {
        let row = |t: &Twist| Body { v: t.v.as_vec3().to_array(), w: t.w.as_vec3().to_array(), ..Body::default() };
        self.change.write(device, &impacts.iter().map(row).collect::<Vec<Body>>());
    }

    /// Record what they do to the velocities without contacts.
    pub fn record(&self, device: &Device, commands: &mut Commands, problem: &Problem) {
        let bound = [self.change.bind(), problem.free.bind()];
        commands.dispatch(device, &self.add, &bound, &[], groups(problem.n_bodies));
    }
}

/// What impacts change of the velocities in the step of a state with its contacts (n_bodies).
pub fn found(model: &Model, state: &State) -> Vec<Twist> {
    let mut masses = Masses::default();
    masses.prepare(model, state);
    masses.rotate(model, state);
    let mut change = vec![Twist::default(); model.n_bodies()];
    impacts::run(model, state, &masses, &mut change);
    change
}
