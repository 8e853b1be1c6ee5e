//! The bodies that joints, springs and loads act on. Their state, the rows of their joints and the factor are the processor's, in double
//! precision: it hands them to the device at the beginning of each step, and takes from it what the contacts have done to these bodies at
//! the end. All other bodies stay on the device.
//! out    position, orientation, velocity, spin  of these bodies
//! out    free       [n_members]    m/s, rad/s: velocities with joints, without contacts
//! in     gamma, push, displaced    what the contacts do
//! out    effect     [5 n_members]  N s, N m s
//! Kernels: member_pose.wgsl, member_free.wgsl, member_effect.wgsl. Twin: cpu/mechanism.rs
//!
//! Bytes of a body and step: 144 to the device, 80 back.

use super::bodies::Bodies;
use super::fault::Fault;
use super::joints::{Joints, Rows, put};
use super::overlaps::Overlaps;
use super::parts::{groups, kernel, kernel_of};
use super::problem::Problem;
use super::rows::{BodyState, MemberFree};
use crate::cpu::mechanism::{self, Effect};
use crate::model::Model;
use crate::outcome::StepOutcome;
use crate::plan::has_joints;
use crate::state::State;
use crate::twist::Twist;
use glam::DVec3;
use gpu::{Buffer, Commands, Device, GpuError, Kernel, Kernels};

/// The bodies on both sides.
pub struct Mechanism {
    own: mechanism::Mechanism,
    rows: Rows,
    /// The columns of the joints on the device.
    pub joints: Joints,
    has_joints: bool,
    pose: Buffer<BodyState>,
    free: Buffer<MemberFree>,
    effect: Buffer<[f32; 4]>,
    write_pose: Kernel,
    write_free: Kernel,
    read_effect: Kernel,
}

impl Mechanism {
    /// For the bodies of a model that move in a state; none where no joints, springs or loads act.
    pub fn new(
        device: &Device,
        kernels: &Kernels,
        (model, state): (&Model, &State),
        bodies: &Bodies,
    ) -> Result<Option<Mechanism>, Fault> {
        let has_joints = has_joints(model);
        if !has_joints && model.loads.is_empty() {
            return Ok(None);
        }
        let effect = include_str!("member_effect.wgsl");
        let mut mechanism = Mechanism {
            own: mechanism::Mechanism::default(),
            rows: Rows::default(),
            joints: Joints::new(device, kernels, bodies.layout)?,
            has_joints,
            pose: Buffer::zeros(device, "member poses", 1)?,
            free: Buffer::zeros(device, "member velocities", 1)?,
            effect: Buffer::zeros(device, "effects of contacts", 1)?,
            write_pose: kernel(device, kernels, "member_pose", include_str!("member_pose.wgsl"))?,
            write_free: kernel(device, kernels, "member_free", include_str!("member_free.wgsl"))?,
            read_effect: kernel_of(bodies.layout, device, kernels, ("member_effect", effect))?,
        };
        mechanism.prepare(device, model, state)?;
        Ok(Some(mechanism))
    }

    /// Adopt the bodies that move now.
    ///
    /// # Errors
    /// Those of [`Buffer::reserve`].
    pub fn prepare(&mut self, device: &Device, model: &Model, state: &State) -> Result<(), GpuError> {
        self.own.prepare(model, state);
        let n = self.own.bodies.len();
        self.pose.reserve(device, n)?;
        self.free.reserve(device, n)?;
        self.effect.reserve(device, 5 * n)?;
        self.joints.member.reserve(device, n)?;
        Ok(())
    }

    /// Begin a step, with what impacts before the contacts change of the velocities (n_bodies, or none). Returns whether a buffer has grown.
    ///
    /// # Errors
    /// [`Fault::Position`], [`Fault::Gpu`].
    pub fn begin(
        &mut self,
        device: &Device,
        (model, state): (&Model, &State),
        bodies: &Bodies,
        impacts: &[Twist],
    ) -> Result<bool, Fault> {
        let is_new = self.own.begin(model, state, impacts);
        self.rows.take(&self.own, is_new);
        let has_grown = self.joints.place(device, &self.rows, is_new)?;
        self.place_free(device, model, state)?;
        let four = |v: DVec3| v.as_vec3().extend(0.0).to_array();
        let members = &self.own.bodies;
        let pose = |body: &u32| {
            let b = *body as usize;
            Ok(BodyState {
                position: bodies.scale.fix(state.position[b]).ok_or(Fault::Position(*body))?,
                body: *body,
                is_held: self.own.joints.hold(*body) as u32,
                orientation: state.orientation[b].as_quat().to_array(),
                velocity: four(state.velocity[b]),
                spin: four(state.angular_velocity[b]),
            })
        };
        put(device, &mut self.pose, &members.iter().map(pose).collect::<Result<Vec<_>, Fault>>()?)?;
        Ok(has_grown)
    }

    /// Write the velocities without contacts.
    fn place_free(&mut self, device: &Device, model: &Model, state: &State) -> Result<(), GpuError> {
        let four = |v: DVec3| v.as_vec3().extend(0.0).to_array();
        let free = |body: &u32| {
            let Twist { v, w } = self.own.twist(*body);
            let (moments, axes) = self.own.inertia(model, state, *body);
            MemberFree {
                v: v.as_vec3().to_array(),
                inv_mass: model.inv_mass[*body as usize] as f32,
                w: w.as_vec3().to_array(),
                body: *body,
                moments: four(moments),
                axes: axes.as_quat().to_array(),
            }
        };
        let rows: Vec<MemberFree> = self.own.bodies.iter().map(free).collect();
        put(device, &mut self.free, &rows)?;
        Ok(())
    }

    /// Whether limits may be met in the step, or motors have a maximum effort, so that what the contacts do is to be measured before its end.
    pub fn has_bounds(&self) -> bool {
        self.own.has_bounds()
    }

    /// Hold the limits that would be passed with what the contacts do, and let go of those that would pull, and the same of motors with a maximum
    /// effort. Returns whether there are such, so that the step is to be done again, and whether a buffer has grown.
    ///
    /// # Errors
    /// Those of [`Buffer::read`].
    pub fn settle(&mut self, device: &Device, model: &Model, state: &State) -> Result<Option<bool>, GpuError> {
        let (effects, _) = self.effects(device)?;
        let Some(is_new) = self.own.settle((model, state), &effects) else { return Ok(None) };
        self.rows.take(&self.own, is_new);
        let has_grown = self.joints.place(device, &self.rows, is_new)?;
        self.place_free(device, model, state)?;
        Ok(Some(has_grown))
    }

    /// Record the state of the bodies, before the stages.
    pub fn record_pose(&self, device: &Device, commands: &mut Commands, bodies: &Bodies) {
        let state = [bodies.position.bind(), bodies.orientation.bind(), bodies.velocity.bind(), bodies.spin.bind()];
        let bound: Vec<gpu::Bound> =
            [self.pose.bind()].into_iter().chain(state).chain([self.joints.sizes.bind()]).collect();
        commands.dispatch(device, &self.write_pose, &bound, &[], groups(self.own.bodies.len()));
    }

    /// Record the velocities without contacts, over those of `force`.
    pub fn record_free(&self, device: &Device, commands: &mut Commands, problem: &Problem) {
        let [mass, orientation] = problem.inertia();
        let bound = [self.free.bind(), problem.free.bind(), mass, orientation, self.joints.sizes.bind()];
        let params = [self.has_joints as u32];
        commands.dispatch(device, &self.write_free, &bound, &params, groups(self.own.bodies.len()));
    }

    /// Record what the contacts have done, after the recovery of overlaps.
    pub fn record_effect(&self, device: &Device, commands: &mut Commands, (problem, overlaps): (&Problem, &Overlaps)) {
        let [side, start] = problem.sides();
        let of_contacts = [problem.row(), problem.gamma.bind(), side, start, problem.roll.bind()];
        let pushes = [problem.contact.bind(), overlaps.push.bind(), overlaps.displaced.bind(), overlaps.share.bind()];
        let own = [self.effect.bind(), self.joints.sizes.bind()];
        let bound: Vec<gpu::Bound> =
            [self.joints.member.bind()].into_iter().chain(of_contacts).chain(pushes).chain(own).collect();
        commands.dispatch(device, &self.read_effect, &bound, &[], groups(self.own.bodies.len()));
    }

    /// End a step: the joints and springs are recorded, and the bodies moved, in the state.
    ///
    /// # Errors
    /// Those of [`Buffer::read`].
    pub fn finish(
        &mut self,
        device: &Device,
        model: &Model,
        state: &mut State,
        outcome: &mut StepOutcome,
    ) -> Result<(), GpuError> {
        let (effects, share) = self.effects(device)?;
        self.own.finish(model, state, (&effects, share), outcome);
        Ok(())
    }

    /// What the contacts do to each of the bodies, and the share of the displacement by pushes that is made.
    fn effects(&self, device: &Device) -> Result<(Vec<Effect>, f64), GpuError> {
        let rows = self.effect.read(device, 5 * self.own.bodies.len())?;
        let share = rows.first().map_or(0.0, |row| f64::from(row[3]));
        let wide = |row: &[f32; 4]| DVec3::new(row[0].into(), row[1].into(), row[2].into());
        let effect = |own: &[[f32; 4]; 5]| {
            let [v, w, push_v, push_w, turn] = own.each_ref().map(wide);
            Effect { impulse: Twist { v, w }, push: Twist { v: push_v, w: push_w }, turn }
        };
        Ok((rows.as_chunks::<5>().0.iter().map(effect).collect(), share))
    }

    /// Let a state be read back but for these bodies, whose state it has.
    pub fn keep<T>(&self, state: &mut State, read: impl FnOnce(&mut State) -> T) -> T {
        let own = |b: &u32, state: &State| {
            let b = *b as usize;
            (state.position[b], state.orientation[b], state.velocity[b], state.angular_velocity[b])
        };
        let kept: Vec<_> = self.own.bodies.iter().map(|b| own(b, state)).collect();
        let result = read(state);
        for (b, (position, orientation, velocity, spin)) in self.own.bodies.iter().map(|b| *b as usize).zip(kept) {
            (state.position[b], state.orientation[b]) = (position, orientation);
            (state.velocity[b], state.angular_velocity[b]) = (velocity, spin);
        }
        result
    }
}
