//! Velocities at the step's end without contacts: gravity, and what is slower than `rest_speed` loses up to half of its velocity.
//! in   mass         [n_bodies]  1/kg, and principal, 1/(kg m²); zero for a body that does not move
//! in   orientation  [n_bodies]
//! in   velocity     [n_bodies]  m/s
//! in   spin         [n_bodies]  rad/s, in the bodies' frames
//! out  free         [n_bodies]  m/s, rad/s, world
//! Kernel: force.wgsl. Twin: cpu/force.rs

use super::bodies::Bodies;
use super::parts::{bits, groups, kernel_of};
use super::rows::Body;
use crate::model::Model;
use gpu::{Buffer, Commands, Device, GpuError, Kernels};

/// Record the stage.
pub fn record(
    device: &Device,
    kernels: &Kernels,
    commands: &mut Commands,
    model: &Model,
    (bodies, free): (&Bodies, &Buffer<Body>),
) -> Result<(), GpuError> {
    let force = kernel_of(bodies.layout, device, kernels, ("force", include_str!("force.wgsl")))?;
    let [mass, orientation] = [bodies.mass.bind(), bodies.orientation.bind()];
    let bound = [mass, orientation, bodies.velocity.bind(), bodies.spin.bind(), free.bind()];
    let [x, y, z] = (model.gravity * model.step).to_array();
    let params = [x, y, z, model.solver.rest_speed].map(bits);
    commands.dispatch(device, &force, &bound, &params, groups(bodies.n));
    Ok(())
}
