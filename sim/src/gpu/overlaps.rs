//! Recovery of overlaps on a device: a displacement of the bodies that makes overlaps smaller, apart from their velocities.
//! in   contact    [n_contacts]
//! in   motion     [n_bodies]    m/s, rad/s: velocities at the step's end
//! out  displaced  [2 n_bodies]  m/s: displacement over h; J s: what keeps the angular momentum; a third, rad/s, where arms are of any
//!                               direction
//! out  share      [1]           share of it that is made
//! Kernels: overlap_push.wgsl, overlap_displace.wgsl, overlap_share.wgsl. Twin: cpu/solve/overlaps.rs

use super::parts::{bits, kernel_of};
use super::problem::Problem;
use crate::model::Model;
use crate::plan::Narrow;
use gpu::{Buffer, Commands, Device, GpuError, Kernels, Work};

/// The displacement.
pub struct Overlaps {
    /// Displacements over the step size, what keeps the angular momentum, and rotations where arms are of any direction (2 or 3 n_bodies).
    pub displaced: Buffer<[f32; 4]>,
    /// Share of them that is made (1).
    pub share: Buffer<f32>,
    /// Impulses along the normals, N s (n_contacts).
    pub push: Buffer<f32>,
}

impl Overlaps {
    /// For a problem.
    pub fn new(device: &Device, problem: &Problem) -> Result<Overlaps, GpuError> {
        let vectors = if problem.layout.narrow == Narrow::Any { 3 } else { 2 };
        Ok(Overlaps {
            displaced: Buffer::zeros(device, "displacement", vectors * problem.n_bodies)?,
            share: Buffer::zeros(device, "share", 1)?,
            push: Buffer::zeros(device, "push", problem.gamma.capacity())?,
        })
    }

    /// Record that nothing is displaced.
    pub fn record_none(&self, commands: &mut Commands) {
        commands.clear(&self.share);
    }

    /// Record the recovery, in one of `period` steps for all of them.
    pub fn record(
        &self,
        device: &Device,
        kernels: &Kernels,
        commands: &mut Commands,
        model: &Model,
        (problem, period): (&Problem, u64),
    ) -> Result<(), GpuError> {
        let get = |name, text| kernel_of(problem.layout, device, kernels, (name, text));
        let (h, n) = (model.step, problem.n_contacts.n.bind());
        let least = 0.1 * model.gravity.length() * h * h;
        let (contact, push, motion) = (problem.contact.bind(), self.push.bind(), problem.motion.bind());
        let (of_contacts, of_bodies) = (problem.of_contacts.bind(), problem.of_bodies.bind());
        let params = [1.0 / h, least, model.solver.recovery_speed * period as f64].map(bits);
        let kernel = get("overlap_push", include_str!("overlap_push.wgsl"))?;
        let bound = [contact, motion, push, of_contacts, n, problem.row()];
        commands.dispatch(device, &kernel, &bound, &params, problem.contacts());
        let kernel = get("overlap_displace", include_str!("overlap_displace.wgsl"))?;
        let [side, start] = problem.sides();
        let ([mass, orientation], row) = (problem.inertia(), problem.row());
        let bound = [contact, push, motion, side, start, self.displaced.bind(), of_bodies, row, mass, orientation];
        commands.dispatch(device, &kernel, &bound, &[(least == 0.0) as u32], problem.bodies());
        if let Some(joints) = &problem.joints {
            joints.record_displace(device, commands, (&problem.of_joints(), self.displaced.bind()));
        }
        let kernel = get("overlap_share", include_str!("overlap_share.wgsl"))?;
        let bound = [of_contacts, of_bodies, self.share.bind(), n];
        commands.dispatch(device, &kernel, &bound, &[problem.n_sums()], Work::Groups(1));
        Ok(())
    }
}
