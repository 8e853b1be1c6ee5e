//! The state of a run: the data that a step changes, as columns.

use crate::aabb::Aabb;
use crate::contacts::Contacts;
use crate::joint::{Frames, Joint, JointState, Spring, SpringState};
use crate::joint_factor::JointFactor;
use crate::manifolds::Manifolds;
use crate::model::{Model, Scheduled};
use crate::pace::Pace;
use crate::pose::Pose;
use crate::shape::FARTHEST;
use crate::sleepers::{AWAKE, Sleepers};
use crate::twist::Twist;
use crate::warning::WatchState;
use glam::{DQuat, DVec3};

/// The activity of a body: whether it moves, and whether it takes part in contacts and frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Activity {
    /// Moving: its velocity and its pose are integrated.
    Moving,
    /// Held in place: a fixed body, or one that is scheduled to move later; it has contacts with moving bodies.
    Held,
    /// Inactive: it has not appeared yet, has no contacts and is in no frame.
    Inactive,
    /// Asleep: it would move, but rests, and is held in place until something concerns it (`sleep`).
    Asleep,
}

/// The mutable state of a simulation, as columns.
#[derive(Clone, Debug, Default, serde::Serialize, serde::Deserialize)]
pub struct State {
    /// Simulated time, s.
    pub time: f64,
    /// Number of steps taken.
    pub steps: u64,
    /// Position of the centre of mass, m, world (n_bodies).
    pub position: Vec<DVec3>,
    /// Orientation of the principal frame, body to world, unit (n_bodies).
    pub orientation: Vec<DQuat>,
    /// Velocity of the centre of mass, m/s, world (n_bodies).
    pub velocity: Vec<DVec3>,
    /// Angular velocity ω̄, rad/s, principal frame (n_bodies).
    pub angular_velocity: Vec<DVec3>,
    /// The contacts of the last step, with their impulses.
    pub contacts: Contacts,
    /// Manifolds of convex shapes that are kept from step to step.
    pub manifolds: Manifolds,
    /// Activity of the bodies (n_bodies).
    pub activity: Vec<Activity>,
    /// Fat AABBs of the last run of the broad phase (n_shapes); none if the next step must run it.
    pub fat_aabb: Option<Vec<Aabb>>,
    /// Joint states of the last step (n_joints).
    pub joints: Vec<JointState>,
    /// Spring states of the last step (n_springs).
    pub springs: Vec<SpringState>,
    /// Work of the loads so far, J.
    pub load_work: f64,
    /// Whether bodies have appeared or begun to move in the step that begins, or began last.
    #[serde(skip)]
    pub has_arrivals: bool,
    /// Kinetic and potential energy of the bodies that have appeared or begun to move, as they did, J.
    pub arrived: f64,
    /// Step length of the last APGD solve, from which the next one starts; 0 before the first.
    pub step_length: f64,
    /// The factorisation of the joints for the steps to come.
    pub joint_factor: JointFactor,
    /// The parts that steps are taken in.
    pub pace: Pace,
    /// The bodies that sleep.
    pub sleepers: Sleepers,
    /// State of the [`watch`](crate::watch) over the run.
    pub watch: WatchState,
}

impl State {
    /// Check that a state, as a file gives it, is one of a model: its columns have the model's lengths, what they name is there, and
    /// bodies, contacts and boxes are where they can be.
    ///
    /// # Errors
    /// What does not fit, for a message.
    pub fn fit(&self, model: &Model) -> Result<(), String> {
        let (n, n_joints, n_springs) = (model.n_bodies(), model.joints.len(), model.springs.len());
        let is = |found: usize, expected: usize, what: &str| match found == expected {
            true => Ok(()),
            false => Err(format!("has {found} {what}, expected the model's {expected}")),
        };
        is(self.position.len(), n, "bodies")?;
        let bodies = [&self.velocity, &self.angular_velocity].map(Vec::len);
        bodies.into_iter().chain([self.orientation.len(), self.activity.len()]).try_for_each(|l| is(l, n, "bodies"))?;
        is(self.joints.len(), n_joints, "joints")?;
        is(self.springs.len(), n_springs, "springs")?;
        self.watch.fit(n, n_joints + n_springs)?;
        let is_sound = |b: usize| {
            let vectors = [self.position[b], self.velocity[b], self.angular_velocity[b]];
            vectors.iter().all(|v| v.abs().max_element() <= FARTHEST && !v.is_nan())
                && (self.orientation[b].length() - 1.0).abs() < 1e-3
        };
        if let Some(b) = (0..n).find(|b| !is_sound(*b)) {
            return Err(format!(
                "has a body {b} that is nowhere: its position, orientation or velocity is no such thing"
            ));
        }
        if !self.pace.is_sound() {
            return Err("has parts of steps that there are not".into());
        }
        if ![self.time, self.step_length, self.arrived, self.work()].iter().all(|value| value.is_finite()) {
            return Err("has a time, a step length, a work or an energy that is not finite".into());
        }
        self.joint_factor.fit(n)?;
        self.contacts.fit(n, model.n_shapes(), model.laws.len())?;
        self.sleepers.fit(n, model.n_shapes(), model.laws.len())?;
        let sleeps = |b: usize| self.sleepers.island.get(b).is_some_and(|island| *island != AWAKE);
        if let Some(b) = (0..n).find(|b| (self.activity[*b] == Activity::Asleep) != sleeps(*b)) {
            return Err(format!("has a body {b} that sleeps in one column and not in another"));
        }
        self.manifolds.fit(model.n_shapes())?;
        let Some(boxes) = &self.fat_aabb else { return Ok(()) };
        is(boxes.len(), model.n_shapes(), "shapes")?;
        let is_around = |s: usize| {
            let (own, centre) = (boxes[s], self.shape_pose(model, s).position.as_vec3a());
            let is_inactive = self.is_inactive(model.shape_body[s] as usize);
            let (around, width) = (own.min.cmple(centre) & own.max.cmpge(centre), (own.max - own.min).max_element());
            is_inactive || model.shape_kind[s].is_surface() || (around.all() && width > 0.0 && width < FARTHEST as f32)
        };
        match (0..boxes.len()).find(|s| !is_around(*s)) {
            Some(s) => Err(format!("has a box of shape {s} that is not around it")),
            None => Ok(()),
        }
    }

    /// Wake the scheduled bodies for the step that begins now: a body appears, or begins to move, in the first step whose middle is not
    /// before the scheduled time. Returns whether any activity has changed.
    pub fn wake(&mut self, model: &Model) -> bool {
        let now = self.time + 0.5 * model.step;
        let mut has_changed = false;
        self.has_arrivals = false;
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
            if activity == Activity::Moving && self.activity[b] == Activity::Asleep {
                continue;
            }
            has_changed |= self.activity[b] != activity;
            let comes = activity == Activity::Moving && !self.is_free(b);
            self.activity[b] = activity;
            if comes {
                self.has_arrivals = true;
                self.arrived += self.kinetic_energy_of(model, b) + self.potential_energy_of(model, b);
            }
        }
        if has_changed {
            // The broad phase has left out pairs of bodies held in place.
            self.fat_aabb = None;
        }
        has_changed
    }

    /// Whether a body moves.
    #[inline]
    pub fn moves(&self, body: usize) -> bool {
        self.activity[body] == Activity::Moving
    }

    /// Whether a body moves, or would if it did not sleep.
    #[inline]
    pub fn is_free(&self, body: usize) -> bool {
        matches!(self.activity[body], Activity::Moving | Activity::Asleep)
    }

    /// Whether a body has not appeared yet.
    #[inline]
    pub fn is_inactive(&self, body: usize) -> bool {
        self.activity[body] == Activity::Inactive
    }

    /// Pose of a body's principal frame, world.
    #[inline]
    pub fn pose(&self, body: usize) -> Pose {
        Pose { position: self.position[body], orientation: self.orientation[body] }
    }

    /// Linear and angular velocity of a body, world.
    #[inline]
    pub fn twist(&self, body: usize) -> Twist {
        Twist { v: self.velocity[body], w: self.orientation[body] * self.angular_velocity[body] }
    }

    /// Pose of a shape, world.
    #[inline]
    pub fn shape_pose(&self, model: &Model, shape: usize) -> Pose {
        let own = self.pose(model.shape_body[shape] as usize);
        if model.is_centred_sphere(shape) { own } else { own.place(&model.shape_pose[shape]) }
    }

    /// Frames of a joint, world.
    pub fn joint_frames(&self, joint: &Joint) -> Frames {
        Frames::of(joint.bodies.map(|b| self.pose(b as usize)), &joint.frame_a, &joint.frame_b)
    }

    /// Frames of a spring, world.
    pub fn spring_frames(&self, spring: &Spring) -> Frames {
        Frames::of(spring.bodies.map(|b| self.pose(b as usize)), &spring.frame_a, &spring.frame_b)
    }

    /// The contacts of the last step, each as a row of columns: those of the bodies that sleep come last.
    pub fn all_contacts(&self) -> impl Iterator<Item = (&Contacts, usize)> {
        [&self.contacts, &self.sleepers.contacts].into_iter().flat_map(|c| (0..c.len()).map(move |i| (c, i)))
    }

    /// Maximum penetration of all contacts, m; zero where nothing overlaps.
    pub fn worst_penetration(&self) -> f64 {
        self.contacts.worst_penetration().max(self.sleepers.contacts.worst_penetration())
    }

    /// Point of a contact of [`State::all_contacts`], m, world.
    pub fn contact_point(&self, (contacts, i): (&Contacts, usize)) -> DVec3 {
        let [a, b] = contacts.bodies[i].map(|b| b as usize);
        // Arms of bodies that were held in place are not stored; a body that sleeps was not when its contacts were made.
        let is_of_a = self.moves(a) || (self.is_free(a) && !self.moves(b));
        let (body, side) = if is_of_a { (a, 0) } else { (b, 1) };
        self.position[body] + contacts.arms(i)[side]
    }

    /// Kinetic energy of the moving bodies, J.
    pub fn kinetic_energy(&self, model: &Model) -> f64 {
        (0..model.n_bodies()).filter(|b| self.moves(*b)).map(|b| self.kinetic_energy_of(model, b)).sum()
    }

    fn kinetic_energy_of(&self, model: &Model, b: usize) -> f64 {
        let w = self.angular_velocity[b];
        0.5 * self.velocity[b].length_squared() / model.inv_mass[b] + 0.5 * (w * w / model.inv_inertia[b]).element_sum()
    }

    fn potential_energy_of(&self, model: &Model, b: usize) -> f64 {
        -model.gravity.dot(self.position[b]) / model.inv_mass[b]
    }

    /// Potential energy of the moving and the sleeping bodies in gravity, relative to the world's origin, J.
    pub fn potential_energy(&self, model: &Model) -> f64 {
        let moving = (0..model.n_bodies()).filter(|b| self.is_free(*b));
        moving.map(|b| self.potential_energy_of(model, b)).sum()
    }

    /// Elastic energy of the springs, J: of their stiffness, and of their preload as it is now.
    pub fn elastic_energy(&self, model: &Model) -> f64 {
        // Those of the last step, and at the start of the first.
        let at = if self.steps > 0 { self.time - model.step } else { self.time };
        let of = |(spring, now): (&Spring, &SpringState)| {
            if !spring.acts(at) || spring.bodies.iter().any(|b| self.is_inactive(*b as usize)) {
                return 0.0;
            }
            let stretch = now.coordinate - spring.rest;
            0.5 * spring.stiffness * stretch * stretch + spring.preload.at(self.time) * stretch
        };
        model.springs.iter().zip(&self.springs).map(of).sum()
    }

    /// Work of motors, actuators and changing preloads so far, J.
    pub fn work_of_motors(&self) -> f64 {
        let of_joints: f64 = self.joints.iter().map(|joint| joint.work).sum();
        let of_springs: f64 = self.springs.iter().map(|spring| spring.work).sum();
        of_joints + of_springs
    }

    /// Work that motors, actuators, changing preloads and loads have done so far, J.
    pub fn work(&self) -> f64 {
        self.work_of_motors() + self.load_work
    }
}
