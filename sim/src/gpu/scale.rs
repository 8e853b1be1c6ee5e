//! The start of a descent method: the starting point is scaled to the least objective along it, and the scalars are those of the first
//! iteration.
//! inout  gamma    [n_contacts]  N s, world
//! inout  motion   [n_bodies]    m/s, rad/s: velocities with γ
//! out    scalars  [1]
//! out    work     [5]
//! Kernels: scale_contact.wgsl, scale_body.wgsl, scale_decide.wgsl, scale_compare.wgsl, solve_start.wgsl, scale_apply.wgsl,
//! response.wgsl. Twin: cpu/solve/scale.rs

use super::parts::{bits, kernel_of};
use super::problem::Problem;
use gpu::{Commands, Device, GpuError, Kernels, Work};

/// Record the start; `iterations` is the most of them, if it is given, and `omega` that of Jacobi.
pub fn record(
    device: &Device,
    kernels: &Kernels,
    commands: &mut Commands,
    problem: &Problem,
    (iterations, omega): (Option<u32>, f64),
) -> Result<(), GpuError> {
    let get = |name, text| kernel_of(problem.layout, device, kernels, (name, text));
    let Problem { free, gamma, motion, scalars, work, of_contacts, of_bodies, .. } = problem;
    let (n, row, n_bodies) = (problem.n_contacts.n.bind(), problem.row(), problem.n_bodies as u32);
    let [free, gamma, motion] = [free.bind(), gamma.bind(), motion.bind()];
    let (scalars, work, of_contacts, of_bodies) = (scalars.bind(), work.bind(), of_contacts.bind(), of_bodies.bind());
    let ([roll, roll_row], one) = (problem.rolling(), Work::Groups(1));
    let contact = get("scale_contact", include_str!("scale_contact.wgsl"))?;
    commands.dispatch(device, &contact, &[row, gamma, motion, of_contacts, n, roll, roll_row], &[], problem.contacts());
    let body = get("scale_body", include_str!("scale_body.wgsl"))?;
    let [mass, orientation] = problem.inertia();
    commands.dispatch(device, &body, &[free, motion, of_bodies, mass, orientation], &[], problem.bodies());
    if let Some(joints) = &problem.joints {
        joints.record_scale(device, commands, &problem.of_joints());
    }
    let decide = get("scale_decide", include_str!("scale_decide.wgsl"))?;
    let params = [problem.n_sums(), iterations.unwrap_or(0), problem.coheres as u32];
    commands.dispatch(device, &decide, &[of_contacts, of_bodies, scalars, n], &params, one);
    let compare = get("scale_compare", include_str!("scale_compare.wgsl"))?;
    let bound = [row, gamma, motion, free, scalars, of_contacts, n, roll, roll_row];
    commands.dispatch(device, &compare, &bound, &[], problem.contacts());
    let start = get("solve_start", include_str!("solve_start.wgsl"))?;
    commands.dispatch(device, &start, &[of_contacts, scalars, work, n], &[n_bodies, bits(omega)], one);
    let apply = get("scale_apply", include_str!("scale_apply.wgsl"))?;
    commands.dispatch(device, &apply, &[gamma, scalars, n, roll], &[], problem.contacts());
    problem.record_response(device, commands);
    Ok(())
}
