//! Accelerated projected gradient descent on a device, whose scalars stay there: a trial is taken or not, and the next has the step length
//! that follows, without anything read back.
//! in   row       [n_contacts]
//! in   free      [n_bodies]    m/s, rad/s
//! out  gamma     [n_contacts]  N s, world
//! out  motion    [n_bodies]    m/s, rad/s
//! Kernels: apgd_start.wgsl, apgd_contact.wgsl, apgd_body.wgsl, apgd_decide.wgsl, apgd_extrapolate.wgsl, and the ordered sums.
//! Twin: cpu/solve/apgd.rs, which keeps the best of its iterates; here the last counts.
//!
//! Bytes of a contact and trial: its row (48), x, previous and z read and x, previous and z written (96), its terms written and read (16),
//! and again by its two bodies (id 4, z 16, row 48 each): 296 from memory.

use super::problem::{Columns, Problem};
use super::rows::Body;
use super::spheres::kernel;
use gpu::reduce::{Combine, Reduce};
use gpu::{Buffer, Commands, Device, GpuError, Kernel, Kernels, Work};

/// Bytes of a contact and trial from memory.
pub const BYTES: f64 = 296.0;

/// The columns of the method, and its kernels.
struct Apgd {
    start: Kernel,
    contact: Kernel,
    body: Kernel,
    decide: Kernel,
    extrapolate: Kernel,
    of_contacts: Reduce,
    of_bodies: Reduce,
    /// θ, β, t, whether the last trial was taken, trials since one was too long, trials (1).
    scalars: Buffer<[u32; 6]>,
    x: Buffer<[f32; 4]>,
    previous: Buffer<[f32; 4]>,
    motion_y: Buffer<Body>,
    motion_next: Buffer<Body>,
    /// |z − y|²/η and (N y + r)·(z − x) of each contact (n_contacts), and the energy of each body (n_bodies).
    terms: [Buffer<f32>; 3],
    /// Their sums.
    sums: [Buffer<f32>; 3],
}

impl Apgd {
    fn new(device: &Device, kernels: &Kernels, problem: &Problem) -> Result<Apgd, GpuError> {
        let (room, n_bodies) = (problem.n_contacts.capacity, problem.n_bodies);
        let terms = |n| Buffer::zeros(device, "terms", n);
        let sum = || Buffer::zeros(device, "sum", 1);
        Ok(Apgd {
            start: kernel(device, kernels, "apgd_start", include_str!("apgd_start.wgsl"))?,
            contact: kernel(device, kernels, "apgd_contact", include_str!("apgd_contact.wgsl"))?,
            body: kernel(device, kernels, "apgd_body", include_str!("apgd_body.wgsl"))?,
            decide: kernel(device, kernels, "apgd_decide", include_str!("apgd_decide.wgsl"))?,
            extrapolate: kernel(device, kernels, "apgd_extrapolate", include_str!("apgd_extrapolate.wgsl"))?,
            of_contacts: Reduce::new(device, kernels, Combine::Sum, room)?,
            of_bodies: Reduce::new(device, kernels, Combine::Sum, n_bodies)?,
            scalars: Buffer::zeros(device, "scalars", 1)?,
            x: Buffer::zeros(device, "x", room)?,
            previous: Buffer::zeros(device, "previous", room)?,
            motion_y: Buffer::zeros(device, "motion_y", n_bodies)?,
            motion_next: Buffer::zeros(device, "motion_next", n_bodies)?,
            terms: [terms(room)?, terms(room)?, terms(n_bodies)?],
            sums: [sum()?, sum()?, sum()?],
        })
    }
}

/// Record the trials, from impulses of zero and the step length of the last solve.
pub fn record(
    device: &Device,
    kernels: &Kernels,
    commands: &mut Commands,
    trials: u32,
    problem: &Problem,
    Columns { gamma, motion }: &Columns,
) -> Result<(), GpuError> {
    let a = Apgd::new(device, kernels, problem)?;
    let (scalars, count) = (a.scalars.bind(), problem.n_contacts.n.bind());
    let ([row, z, free, side, start], y) = (problem.of_bodies(gamma), a.motion_y.bind());
    let [moved, slope, energy] = a.terms.each_ref().map(Buffer::bind);
    let sums = a.sums.each_ref().map(Buffer::bind);
    let of_contacts = [row, y, a.x.bind(), a.previous.bind(), z, moved, slope, scalars, count];
    let of_bodies = [row, z, free, side, start, y, a.motion_next.bind(), energy];
    let of_decision = [sums[0], sums[1], sums[2], scalars, count];
    let of_motion = [a.motion_next.bind(), motion.bind(), y, scalars];
    let all_bodies = &problem.all_bodies;
    for column in [gamma, &a.x, &a.previous] {
        commands.clear(column);
    }
    commands.copy(&problem.free, motion, problem.n_bodies);
    commands.copy(&problem.free, &a.motion_y, problem.n_bodies);
    commands.dispatch(device, &a.start, &[scalars, count], &[], Work::Groups(1));
    for _ in 0..trials {
        commands.dispatch(device, &a.contact, &of_contacts, &[], problem.contacts());
        for k in 0..2 {
            a.of_contacts.record(device, commands, &a.terms[k], &problem.n_contacts, &a.sums[k]);
        }
        commands.dispatch(device, &a.body, &of_bodies, &[], problem.bodies());
        a.of_bodies.record(device, commands, &a.terms[2], all_bodies, &a.sums[2]);
        commands.dispatch(device, &a.decide, &of_decision, &[trials], Work::Groups(1));
        commands.dispatch(device, &a.extrapolate, &of_motion, &[], problem.bodies());
    }
    Ok(())
}
