//! The joints on a device: rows and factor of a step, which come from the processor, and their part of every product with N. One workgroup
//! solves, in phases of rows that do not depend on each other.
//! in     member, joint_side, joint_row, joint_phase, phase_row, joint_term, joint_number  of the step
//! inout  motion  [n_bodies]  m/s, rad/s: with the joints, in place of without
//! out    lambda  [n_rows]    N s, N m s
//! Kernels: joint_response.wgsl, joint_scale.wgsl, joint_trial.wgsl, joint_displace.wgsl. Twin: cpu/solve/joints.rs
//!
//! Bytes that come from the processor in a step: 64 for a row and body, 16 for a row, 4 for a number of the factor. A product with N reads
//! these once: twice the numbers, with 8 bytes of indices for each. The model `tracked_vehicle` has 139 bodies, 814 rows on 1,628 of them and
//! 21,638 numbers in 29,906 terms of 9 phases: 224 kB to the device in a step, 11 kB back.

use super::parts::{Layout, ROWS, kernel_of};
use super::rows::{JointRow, JointSide, Member};
use crate::cpu::mechanism::Mechanism;
use crate::cpu::solve::joints::Phases;
use crate::plan::Narrow;
use gpu::{Bound, Buffer, Commands, Device, GpuError, Kernel, Kernels, Work};

/// Rounds of a solve where the velocities are to be right to rounding. In a trial they are as many as the least pivot asks for.
const EXACT_ROUNDS: u32 = 2;

/// Least pivot over its diagonal below which one round leaves more than rounding.
const WEAK: f64 = 1e-2;

/// In place of a side on a body that does not move.
const NO_SIDE: u32 = u32::MAX;

/// The columns, and their kernels. Clones are the same memory.
#[derive(Clone)]
pub struct Joints {
    /// Number of members, of rows, of phases, and of rows of the factor; rounds of a solve in a trial (5).
    pub sizes: Buffer<u32>,
    /// Bodies that joints, springs and loads act on, with their sides (n_members).
    pub member: Buffer<Member>,
    side: Buffer<JointSide>,
    row: Buffer<JointRow>,
    phase: Buffer<u32>,
    phase_row: Buffer<[u32; 4]>,
    term: Buffer<[u32; 2]>,
    number: Buffer<f32>,
    work: Buffer<f32>,
    lambda: Buffer<[f32; 4]>,
    response: Kernel,
    scale: Kernel,
    trial: Kernel,
    displace: Kernel,
}

/// The columns of the solver that the joints have a part in.
pub struct Solve<'a> {
    /// Velocities with and without impulses.
    pub motion: Bound<'a>,
    /// Those without.
    pub free: Bound<'a>,
    /// The scalars.
    pub scalars: Bound<'a>,
    /// Workgroups of an iteration.
    pub groups: Bound<'a>,
    /// Sums over bodies.
    pub of_bodies: Bound<'a>,
    /// Masses, and principal frames.
    pub inertia: [Bound<'a>; 2],
    /// The number of bodies.
    pub n_bodies: usize,
}

impl Solve<'_> {
    /// The row of the sums over bodies that those with joints have to themselves.
    fn last(&self) -> u32 {
        self.n_bodies.div_ceil(ROWS) as u32
    }
}

/// The rows of a step, as they are written.
#[derive(Default)]
pub struct Rows {
    members: Vec<Member>,
    sides: Vec<JointSide>,
    rows: Vec<JointRow>,
    numbers: Vec<f32>,
    phases: Phases,
    /// Rounds of a solve in a trial.
    rounds: u32,
}

impl Rows {
    /// Take the rows of a mechanism, after its beginning of a step; the structure of its factor too, if it is another.
    pub fn take(&mut self, mechanism: &Mechanism, is_new: bool) {
        let joints = &mechanism.joints;
        if is_new {
            self.phases = mechanism.reduced.factor.phases();
        }
        self.take_rows(mechanism);
        match joints.rows.is_empty() {
            true => self.numbers.clear(),
            false => mechanism.reduced.factor.numbers(&mut self.numbers),
        }
        self.rounds = if mechanism.reduced.weakest < WEAK { 2 } else { 1 };
    }

    fn take_rows(&mut self, mechanism: &Mechanism) {
        let Rows { members, sides, rows, .. } = self;
        members.clear();
        sides.clear();
        rows.clear();
        let mut found = vec![];
        let placed = mechanism.joints.placed().zip(&mechanism.reduced.softness);
        for (r, ((row, place), softness)) in (0u32..).zip(placed) {
            rows.push(JointRow { sides: [NO_SIDE; 2], place, softness: *softness as f32 });
            let of_body = |(k, body): (usize, u32)| mechanism.side(row, body).map(|twists| (body, r, k, twists));
            found.extend(row.bodies.into_iter().enumerate().filter_map(of_body));
        }
        found.sort_unstable_by_key(|(body, r, k, _)| (*body, *r, *k));
        for (at, (body, r, k, [own, to])) in (0u32..).zip(&found) {
            let [linear, angular, to_linear, to_angular] = [own.v, own.w, to.v, to.w].map(|v| v.as_vec3().to_array());
            sides.push(JointSide {
                linear,
                row: *r,
                angular,
                body: *body,
                to_linear,
                to_angular,
                ..JointSide::default()
            });
            rows[*r as usize].sides[*k] = at;
        }
        let place = |body: u32| found.partition_point(|(other, ..)| *other < body) as u32;
        let member = |body: &u32| Member { body: *body, first: place(*body), end: place(*body + 1), pad: 0 };
        members.extend(mechanism.bodies.iter().map(member));
    }
}

impl Joints {
    /// Columns without rows.
    pub fn new(device: &Device, kernels: &Kernels, layout: Layout) -> Result<Joints, GpuError> {
        // Bodies with joints have inertia of any kind.
        let layout = Layout { narrow: Narrow::Any, ..layout };
        let get = |name, text| kernel_of(layout, device, kernels, (name, text));
        Ok(Joints {
            sizes: Buffer::zeros(device, "joint sizes", 5)?,
            member: Buffer::zeros(device, "members", 1)?,
            side: Buffer::zeros(device, "joint sides", 1)?,
            row: Buffer::zeros(device, "joint rows", 1)?,
            phase: Buffer::zeros(device, "joint phases", 2)?,
            phase_row: Buffer::zeros(device, "phase rows", 1)?,
            term: Buffer::zeros(device, "joint terms", 1)?,
            number: Buffer::zeros(device, "joint numbers", 1)?,
            work: Buffer::zeros(device, "joint work", 2)?,
            lambda: Buffer::zeros(device, "joint multipliers", 1)?,
            response: get("joint_response", include_str!("joint_response.wgsl"))?,
            scale: get("joint_scale", include_str!("joint_scale.wgsl"))?,
            trial: get("joint_trial", include_str!("joint_trial.wgsl"))?,
            displace: get("joint_displace", include_str!("joint_displace.wgsl"))?,
        })
    }

    /// Write the rows of a step, and the structure of their factor, if it is another. Returns whether a buffer has grown.
    ///
    /// # Errors
    /// Those of [`Buffer::reserve`].
    pub fn place(&mut self, device: &Device, own: &Rows, is_new: bool) -> Result<bool, GpuError> {
        let Rows { members, sides, rows, numbers, phases, .. } = own;
        let n_factor = if rows.is_empty() { 0 } else { phases.n_rows };
        let mut has_grown = put(device, &mut self.member, members)?;
        has_grown |= put(device, &mut self.side, sides)?;
        has_grown |= put(device, &mut self.row, rows)?;
        has_grown |= put(device, &mut self.number, numbers)?;
        has_grown |= self.work.reserve(device, 2 * n_factor)?;
        has_grown |= self.lambda.reserve(device, rows.len())?;
        if is_new {
            let phase_rows: Vec<[u32; 4]> =
                phases.row.iter().map(|[row, first, end]| [*row, *first, *end, 0]).collect();
            has_grown |= put(device, &mut self.phase, &phases.start)?;
            has_grown |= put(device, &mut self.phase_row, &phase_rows)?;
            has_grown |= put(device, &mut self.term, &phases.term)?;
        }
        let n_phases = if rows.is_empty() { 0 } else { phases.start.len() - 1 };
        let [n_members, n_rows, n_phases, n_factor] = [members.len(), rows.len(), n_phases, n_factor].map(|n| n as u32);
        self.sizes.write(device, &[n_members, n_rows, n_phases, n_factor, own.rounds]);
        Ok(has_grown)
    }

    /// Record the velocities of a problem with the joints, from those without; with `is_checked`, where an iteration has bodies to do.
    pub fn record_response(&self, device: &Device, commands: &mut Commands, of: &Solve, is_checked: bool) {
        // An iterate need not be exact: the next corrects it.
        let params = [is_checked as u32, if is_checked { 0 } else { EXACT_ROUNDS }, 0];
        let bound = self.bound(&[of.motion, of.free, of.groups]);
        commands.dispatch(device, &self.response, &bound, &params, Work::Groups(1));
    }

    /// Record what the joints make of velocities that have changed since the last solve, with its multipliers.
    pub fn record_more(&self, device: &Device, commands: &mut Commands, of: &Solve, work: Work) {
        let bound = self.bound(&[of.motion, of.free, of.groups]);
        commands.dispatch(device, &self.response, &bound, &[0, 0, 1], work);
    }

    /// Record the energies of the starting point.
    pub fn record_scale(&self, device: &Device, commands: &mut Commands, of: &Solve) {
        let [mass, orientation] = of.inertia;
        let bound = self.bound(&[of.motion, of.free, of.of_bodies, mass, orientation]);
        commands.dispatch(device, &self.scale, &bound, &[of.last()], Work::Groups(1));
    }

    /// Record a trial of a descent method, with the velocities of the trial and of y; `is_spectral` tells that it is one of spectral projected
    /// gradients.
    pub fn record_trial(
        &self,
        device: &Device,
        commands: &mut Commands,
        of: &Solve,
        ([next, y], is_spectral): ([Bound; 2], bool),
    ) {
        let [mass, orientation] = of.inertia;
        let bound = [next, of.free, y, of.scalars, of.groups, of.of_bodies, mass, orientation];
        let params = [of.last(), is_spectral as u32];
        commands.dispatch(device, &self.trial, &self.bound(&bound), &params, Work::Groups(1));
    }

    /// Record what the joints make of the displacement by pushes.
    pub fn record_displace(&self, device: &Device, commands: &mut Commands, (of, displaced): (&Solve, Bound)) {
        let [mass, orientation] = of.inertia;
        let bound = self.bound(&[displaced, of.of_bodies, mass, orientation]);
        commands.dispatch(device, &self.displace, &bound, &[of.last(), EXACT_ROUNDS], Work::Groups(1));
    }

    /// The columns of `joint_solve`, and those of a kernel.
    fn bound<'a>(&'a self, rest: &[Bound<'a>]) -> Vec<Bound<'a>> {
        let rows = [self.sizes.bind(), self.member.bind(), self.side.bind(), self.row.bind()];
        let factor = [self.phase.bind(), self.phase_row.bind(), self.term.bind(), self.number.bind()];
        let found = [self.work.bind(), self.lambda.bind()];
        rows.into_iter().chain(factor).chain(found).chain(rest.iter().copied()).collect()
    }
}

/// Write rows, with more room if there are more. Returns whether the buffer has grown.
pub fn put<T: gpu::layout::bytemuck::Pod>(
    device: &Device,
    buffer: &mut Buffer<T>,
    rows: &[T],
) -> Result<bool, GpuError> {
    let has_grown = buffer.reserve(device, rows.len())?;
    buffer.write(device, rows);
    Ok(has_grown)
}
