//! The constant model, as columns. `n_bodies` and `n_shapes` are the columns' lengths.

use crate::geometry::{Hull, Surface};
use crate::joint::{Joint, Spring};
use crate::load::Load;
use crate::pose::PoseColumn;
use crate::settings::SolverSettings;
use crate::shape::ShapeKind;
use glam::DVec3;
use std::collections::BTreeMap;

/// How two materials touch.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactLaw {
    /// Coefficient of friction μ.
    pub friction: f64,
    /// Coefficient of restitution, 0 to 1.
    pub restitution: f64,
    /// Greatest force by which a contact holds, N.
    pub cohesion: f64,
    /// Rolling friction: greatest rolling torque over normal force, m.
    pub rolling: f64,
    /// Spinning friction: greatest torque about the normal over normal force, m.
    pub spinning: f64,
}

/// A body that is inactive or held in place at first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scheduled {
    /// The body.
    pub body: u32,
    /// When it appears, s.
    pub appears: f64,
    /// When it begins to move, s.
    pub moves: f64,
}

/// The constants of a run. What varies is in the [`State`](crate::State).
#[derive(Clone, Debug, Default)]
pub struct Model {
    /// Name, for messages.
    pub name: String,
    /// Gravity, m/s², world.
    pub gravity: DVec3,
    /// Step size h, s.
    pub step: f64,
    /// Time to simulate, s.
    pub duration: f64,
    /// Frames a second of simulated time.
    pub frame_rate: f64,
    /// Seed of the generators.
    pub seed: u64,
    /// Solver and its settings.
    pub solver: SolverSettings,
    /// Contacts are made at gaps up to this, and farther for fast bodies, m.
    pub envelope: f64,

    /// Reciprocal mass, 1/kg; zero for a body that is fixed for ever (n_bodies).
    pub inv_mass: Vec<f64>,
    /// Reciprocal principal moments of inertia, 1/(kg m²), body frame (n_bodies).
    pub inv_inertia: Vec<DVec3>,
    /// Index into `class_names` (n_bodies).
    pub class: Vec<u32>,
    /// The frame that the model file places the body by, in the body's principal frame (n_bodies).
    pub body_frame: PoseColumn,
    /// Names of the classes.
    pub class_names: Vec<String>,
    /// Bodies that have names.
    pub body_names: BTreeMap<String, u32>,
    /// Bodies that appear, or begin to move, at a later time.
    pub scheduled: Vec<Scheduled>,

    /// The body that carries the shape (n_shapes).
    pub shape_body: Vec<u32>,
    /// What it is (n_shapes).
    pub shape_kind: Vec<ShapeKind>,
    /// Its size, m (n_shapes).
    pub shape_size: Vec<DVec3>,
    /// Its place in the body's principal frame (n_shapes).
    pub shape_pose: PoseColumn,
    /// Its material (n_shapes).
    pub shape_material: Vec<u32>,
    /// Its collision group (n_shapes).
    pub shape_group: Vec<u32>,
    /// Which hull or surface it is, for those kinds (n_shapes).
    pub shape_part: Vec<u32>,

    /// Convex hulls.
    pub hulls: Vec<Hull>,
    /// Triangle meshes and height fields.
    pub surfaces: Vec<Surface>,
    /// Names of the materials.
    pub material_names: Vec<String>,
    /// The law of each pair of materials, row by row (n_materials²).
    pub laws: Vec<ContactLaw>,
    /// Names of the collision groups.
    pub group_names: Vec<String>,
    /// Whether two groups pass through each other, row by row (n_groups²).
    pub groups_pass: Vec<bool>,
    /// Collision exclusions: pairs of bodies that never touch, as those that a joint connects; the lower body first, sorted.
    pub exclusions: Vec<[u32; 2]>,

    /// Joints.
    pub joints: Vec<Joint>,
    /// Springs.
    pub springs: Vec<Spring>,
    /// Loads.
    pub loads: Vec<Load>,
}

impl Model {
    /// Number of bodies.
    pub fn n_bodies(&self) -> usize {
        self.inv_mass.len()
    }

    /// Number of shapes.
    pub fn n_shapes(&self) -> usize {
        self.shape_body.len()
    }

    /// How the materials of two shapes touch.
    #[inline]
    pub fn law(&self, s: usize, t: usize) -> u32 {
        self.shape_material[s] * self.material_names.len() as u32 + self.shape_material[t]
    }

    /// Whether a shape is a sphere about its body's centre.
    #[inline]
    pub fn is_centred_sphere(&self, shape: usize) -> bool {
        self.shape_kind[shape] == ShapeKind::Sphere && self.shape_pose[shape].position == DVec3::ZERO
    }

    /// Number of frames of the whole run: one at time 0, then one every 1/`frame_rate`, before `duration`.
    pub fn n_frames(&self, until: f64) -> u64 {
        ((until.min(self.duration) * self.frame_rate - 1e-9).ceil() as u64).max(1)
    }

    /// A body's name, or its class and number.
    pub fn body_label(&self, body: usize) -> String {
        match self.body_names.iter().find(|(_, b)| **b as usize == body) {
            Some((name, _)) => format!("`{name}`"),
            None => format!("{body} of class `{}`", self.class_names[self.class[body] as usize]),
        }
    }
}
