//! Integrate the poses of the bodies with their new velocities, unless the step is undone.
//! in     motion       [n_bodies]    m/s, rad/s, world
//! in     displaced    [2 n_bodies]  m/s: recovery of overlaps over h; J s: what keeps the angular momentum; a third, rad/s, where arms
//!                                   are of any direction
//! inout  position     [n_bodies]    fine units
//! inout  orientation  [n_bodies]
//! out    velocity     [n_bodies]    m/s, world
//! out    spin         [n_bodies]    rad/s, in the bodies' frames
//! Kernel: integrate.wgsl. Twin: cpu/integrate.rs

use super::bodies::Bodies;
use super::overlaps::Overlaps;
use super::parts::{bits, groups, kernel_of};
use super::problem::Problem;
use crate::model::Model;
use gpu::{Buffer, Commands, Device, GpuError, Kernels};

/// Record the stage; `room` says whether there was room for all pairs.
pub fn record(
    device: &Device,
    kernels: &Kernels,
    commands: &mut Commands,
    (model, bodies): (&Model, &Bodies),
    (problem, overlaps, room): (&Problem, &Overlaps, &Buffer<u32>),
) -> Result<(), GpuError> {
    let integrate = kernel_of(problem.layout, device, kernels, ("integrate", include_str!("integrate.wgsl")))?;
    let from = [bodies.mass.bind(), problem.motion.bind(), overlaps.displaced.bind(), overlaps.share.bind()];
    let state = [bodies.position.bind(), bodies.orientation.bind(), bodies.velocity.bind(), bodies.spin.bind()];
    let activity = bodies.activity.bind();
    let bound: Vec<gpu::Bound> = from.into_iter().chain([room.bind()]).chain(state).chain([activity]).collect();
    let params = [model.step, 1.0 / bodies.scale.fine()].map(bits);
    commands.dispatch(device, &integrate, &bound, &params, groups(bodies.n));
    Ok(())
}
