//! Projected Jacobi on a device: a kernel over contacts steps and projects the impulses, a kernel over bodies sums them, of which one workgroup
//! decides whether another iteration follows.
//! inout  row      [n_contacts]
//! in     slip     [n_contacts]  m/s, by Coulomb's law itself: the slip of each iterate is fed
//! in     free     [n_bodies]    m/s, rad/s
//! inout  gamma    [n_contacts]  N s, world
//! inout  motion   [n_bodies]    m/s, rad/s
//! Kernels: jacobi_contact.wgsl, jacobi_body.wgsl. Twin: cpu/solve/jacobi.rs; the residual here is that of the impulses
//! before an iteration, so that one more is done than there.
//!
//! Bytes of a contact and iteration: its row (48), its impulse read and written (32), what it turns bodies by (16), and again by its two bodies
//! (id 4, impulse 16, turn 16 each): 168 from memory. The velocities of the bodies, 32 bytes each, are read twice by a contact and written once; those of
//! neighbours are near in memory and stay in the cache.

use super::parts::{ROWS, bits, kernel_of};
use super::problem::Problem;
use crate::cpu::solve::jacobi::SHARE;
use crate::cpu::solve::slip::KNOWN;
use crate::settings::SolverSettings;
use gpu::{Bound, Commands, Device, GpuError, Kernels, Work};

/// Bytes of a contact and iteration from memory.
pub const BYTES: f64 = 168.0;

/// ω where the model gives none.
pub const OMEGA: f64 = 0.3;

/// Record an iteration; `fall` is the speed that a body gains in a step of free fall, m/s.
pub fn record(
    device: &Device,
    kernels: &Kernels,
    commands: &mut Commands,
    settings: &SolverSettings,
    (problem, fall): (&Problem, f64),
) -> Result<(), GpuError> {
    let contact = kernel_of(problem.layout, device, kernels, ("jacobi_contact", include_str!("jacobi_contact.wgsl")))?;
    let body = kernel_of(problem.layout, device, kernels, ("jacobi_body", include_str!("jacobi_body.wgsl")))?;
    let (n, scalars, sums) = (problem.n_contacts.n.bind(), problem.scalars.bind(), problem.of_contacts.bind());
    let [roll, roll_row] = problem.rolling();
    let slip = problem.slip.bind();
    let of_contacts = [
        problem.row(),
        problem.motion.bind(),
        problem.gamma.bind(),
        scalars,
        sums,
        n,
        roll,
        roll_row,
        slip,
        problem.spin.bind(),
    ];
    let of_step = [bits(settings.lambda), problem.feeds as u32, bits(fall), bits(KNOWN * settings.tolerance)];
    let of_decision = [sums, scalars, problem.work.bind(), n];
    let share = if problem.feeds { SHARE } else { 1.0 };
    let params = [bits(share * settings.tolerance), settings.omega.is_some() as u32];
    commands.dispatch(device, &contact, &of_contacts, &of_step, problem.any_contacts());
    let [gamma, free, side, start] = problem.sums_of_bodies();
    let [mass, orientation] = problem.inertia();
    let of_bodies = [problem.spin.bind(), gamma, free, side, start, problem.motion.bind(), mass, orientation, roll];
    let bound: Vec<Bound> = of_bodies.into_iter().chain(of_decision).collect();
    let work = Work::Groups(1 + problem.n_bodies.div_ceil(ROWS) as u32);
    commands.dispatch(device, &body, &bound, &params, work);
    if let Some(joints) = &problem.joints {
        joints.record_response(device, commands, &problem.of_joints(), true);
    }
    Ok(())
}
