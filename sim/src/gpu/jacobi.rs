//! Projected Jacobi on a device: a kernel over contacts steps and projects the impulses, a kernel over bodies sums them.
//! in   row       [n_contacts]
//! in   free      [n_bodies]    m/s, rad/s
//! out  gamma     [n_contacts]  N s, world
//! out  motion    [n_bodies]    m/s, rad/s
//! Kernels: jacobi_contact.wgsl, jacobi_body.wgsl. Twin: cpu/solve/jacobi.rs, which halves an ω that the model does not give where the
//! steps grow.
//!
//! Bytes of a contact and iteration: its row (48), its impulse read and written (32), and again by its two bodies (id 4, impulse 16, row
//! 48 each): 216 from memory. The velocities of the bodies, 32 bytes each, are read twice by a contact and written once; those of
//! neighbours are near in memory and stay in the cache.

use super::problem::{Columns, Problem};
use super::spheres::kernel;
use crate::settings::SolverSettings;
use gpu::{Commands, Device, GpuError, Kernels};

/// Bytes of a contact and iteration from memory.
pub const BYTES: f64 = 216.0;

/// ω where the model gives none.
const OMEGA: f64 = 0.3;

/// Record the iterations, from impulses of zero.
pub fn record(
    device: &Device,
    kernels: &Kernels,
    commands: &mut Commands,
    (settings, iterations): (&SolverSettings, u32),
    problem: &Problem,
    Columns { gamma, motion }: &Columns,
) -> Result<(), GpuError> {
    let contact = kernel(device, kernels, "jacobi_contact", include_str!("jacobi_contact.wgsl"))?;
    let body = kernel(device, kernels, "jacobi_body", include_str!("jacobi_body.wgsl"))?;
    let [row, impulses, free, side, start] = problem.of_bodies(gamma);
    let of_bodies = [row, impulses, free, side, start, motion.bind()];
    let of_contacts = [row, motion.bind(), impulses, problem.n_contacts.n.bind()];
    let factors = [settings.omega.unwrap_or(OMEGA), settings.lambda].map(|x| (x as f32).to_bits());
    commands.clear(gamma);
    commands.copy(&problem.free, motion, problem.n_bodies);
    for _ in 0..iterations {
        commands.dispatch(device, &contact, &of_contacts, &factors, problem.contacts());
        commands.dispatch(device, &body, &of_bodies, &[], problem.bodies());
    }
    Ok(())
}
