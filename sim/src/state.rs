//! The state of a run: all that a step changes, as columns.

use crate::aabb::Aabb;
use crate::contacts::Contacts;
use crate::joint::{Frames, Joint, JointState, Spring, SpringState};
use crate::model::{Model, Scheduled};
use crate::pose::Pose;
use crate::twist::Twist;
use crate::warning::Memory;
use glam::{DQuat, DVec3};

/// What a body does at the moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Activity {
    /// It moves.
    Moving,
    /// It is held in place: for ever, or until it is scheduled to move.
    Held,
    /// It is not there yet: it neither moves nor touches, and is in no table.
    Inactive,
}

/// All that a step changes.
#[derive(Clone, Debug, Default, serde::Serialize, serde::Deserialize)]
pub struct State {
    /// Time, s.
    pub time: f64,
    /// Steps taken.
    pub steps: u64,
    /// Centre of mass, m, world (n_bodies).
    pub position: Vec<DVec3>,
    /// Orientation of the principal frame, body to world, unit (n_bodies).
    pub orientation: Vec<DQuat>,
    /// Velocity, m/s, world (n_bodies).
    pub velocity: Vec<DVec3>,
    /// Angular velocity ω̄, rad/s, principal frame (n_bodies).
    pub angular_velocity: Vec<DVec3>,
    /// The contacts of the last step, with their impulses.
    pub contacts: Contacts,
    /// What each body does (n_bodies).
    pub activity: Vec<Activity>,
    /// Fat AABBs: boxes with room to move, for which pairs of shapes were looked for last (n_shapes); none if they must be looked
    /// for again.
    pub fat_aabb: Option<Vec<Aabb>>,
    /// What each joint did in the last step (n_joints).
    pub joints: Vec<JointState>,
    /// What each spring did in the last step (n_springs).
    pub springs: Vec<SpringState>,
    /// The step length that was right for the last step's solver; 0 if none was.
    pub step_length: f64,
    /// What the watch over the run remembers.
    pub watch: Memory,
}

impl State {
    /// Let bodies appear and move whose time has come; whether any has.
    pub fn wake(&mut self, model: &Model) -> bool {
        let now = self.time + 0.5 * model.step;
        let mut has_changed = false;
        if self.activity.len() != model.n_bodies() {
            let of = |inv_mass: &f64| if *inv_mass > 0.0 { Activity::Moving } else { Activity::Held };
            self.activity = model.inv_mass.iter().map(of).collect();
            has_changed = true;
        }
        for &Scheduled { body, appears, moves } in &model.scheduled {
            let b = body as usize;
            let activity = if now < appears {
                Activity::Inactive
            } else if now >= moves && model.inv_mass[b] > 0.0 {
                Activity::Moving
            } else {
                Activity::Held
            };
            has_changed |= self.activity[b] != activity;
            self.activity[b] = activity;
        }
        if has_changed {
            // Pairs of what was held in place were not looked for.
            self.fat_aabb = None;
        }
        has_changed
    }

    /// Whether a body moves.
    #[inline]
    pub fn moves(&self, body: usize) -> bool {
        self.activity[body] == Activity::Moving
    }

    /// Whether a body is not there yet.
    #[inline]
    pub fn is_inactive(&self, body: usize) -> bool {
        self.activity[body] == Activity::Inactive
    }

    /// Where a body's principal frame is.
    #[inline]
    pub fn pose(&self, body: usize) -> Pose {
        Pose { position: self.position[body], orientation: self.orientation[body] }
    }

    /// The velocities of a body, world.
    #[inline]
    pub fn twist(&self, body: usize) -> Twist {
        Twist { v: self.velocity[body], w: self.orientation[body] * self.angular_velocity[body] }
    }

    /// Where a shape is.
    #[inline]
    pub fn shape_pose(&self, model: &Model, shape: usize) -> Pose {
        let own = self.pose(model.shape_body[shape] as usize);
        if model.is_centred_sphere(shape) { own } else { own.place(&model.shape_pose[shape]) }
    }

    /// Where the frames of a joint are.
    pub fn joint_frames(&self, joint: &Joint) -> Frames {
        Frames::of(joint.bodies.map(|b| self.pose(b as usize)), &joint.frame_a, &joint.frame_b)
    }

    /// Where the frames of a spring are.
    pub fn spring_frames(&self, spring: &Spring) -> Frames {
        Frames::of(spring.bodies.map(|b| self.pose(b as usize)), &spring.frame_a, &spring.frame_b)
    }

    /// Where a contact is, m, world.
    pub fn contact_point(&self, contact: usize) -> DVec3 {
        let bodies = self.contacts.bodies[contact];
        // Arms of bodies that are held in place are not kept.
        let side = if self.moves(bodies[0] as usize) { 0 } else { 1 };
        self.position[bodies[side] as usize] + self.contacts.arms(contact)[side]
    }

    /// Kinetic energy, J.
    pub fn kinetic_energy(&self, model: &Model) -> f64 {
        let of = |b: usize| {
            let w = self.angular_velocity[b];
            0.5 * self.velocity[b].length_squared() / model.inv_mass[b]
                + 0.5 * (w * w / model.inv_inertia[b]).element_sum()
        };
        (0..model.n_bodies()).filter(|b| self.moves(*b)).map(of).sum()
    }

    /// Potential energy in gravity, J, against the world's origin.
    pub fn potential_energy(&self, model: &Model) -> f64 {
        let moving = (0..model.n_bodies()).filter(|b| self.moves(*b));
        moving.map(|b| -model.gravity.dot(self.position[b]) / model.inv_mass[b]).sum()
    }
}
