//! The constant model, as columns. `n_bodies` and `n_shapes` are the columns' lengths.

use crate::body_names::BodyNames;
use crate::geometry::{Hull, Surface};
use crate::joint::{Joint, Spring};
use crate::load::Load;
use crate::pose::PoseColumn;
use crate::settings::SolverSettings;
use crate::shape::ShapeKind;
use glam::DVec3;

/// The contact law of a pair of materials.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactLaw {
    /// Coefficient of friction μ.
    pub friction: f64,
    /// Coefficient of restitution, 0 to 1.
    pub restitution: f64,
    /// Cohesion: maximum tensile force of a contact, N.
    pub cohesion: f64,
    /// Rolling friction: maximum rolling torque over normal force, m.
    pub rolling: f64,
    /// Spinning friction: maximum torque about the normal over normal force, m.
    pub spinning: f64,
}

/// The schedule of a body that is first inactive, then held in place, then moving.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scheduled {
    /// Id of the body.
    pub body: u32,
    /// Time at which it appears, s.
    pub appears: f64,
    /// Time at which it begins to move, s.
    pub moves: f64,
}

/// The constant model of a run, as columns with a row per body (n_bodies) or shape (n_shapes); a step changes the
/// [`State`](crate::State) alone.
#[derive(Clone, Debug, Default)]
pub struct Model {
    /// Name, for messages.
    pub name: String,
    /// Gravity, m/s², world.
    pub gravity: DVec3,
    /// Step size h, s.
    pub step: f64,
    /// What part of a step this is: 1, but while one is taken in parts.
    pub part: f64,
    /// Time to simulate, s.
    pub duration: f64,
    /// Frames per second of simulated time.
    pub frame_rate: f64,
    /// Seed of the pseudo-random generators.
    pub seed: u64,
    /// Settings of the contact solver.
    pub solver: SolverSettings,
    /// Envelope δ: maximum gap at which contacts are generated, m; the margin of a moving shape is δ + |v| h.
    pub envelope: f64,
    /// Relative motion up to which the contact points of two convex shapes are carried along, m.
    pub recycle: f64,

    /// Reciprocal mass, 1/kg; zero for a fixed body (n_bodies).
    pub inv_mass: Vec<f64>,
    /// Reciprocal principal moments of inertia, 1/(kg m²); zero for a fixed body (n_bodies).
    pub inv_inertia: Vec<DVec3>,
    /// Class of the body, an index into `class_names` (n_bodies).
    pub class: Vec<u32>,
    /// Pose of the model file's body frame in the body's principal frame (n_bodies).
    pub body_frame: PoseColumn,
    /// Names of the classes.
    pub class_names: Vec<String>,
    /// Names of bodies, with their ids.
    pub body_names: BodyNames,
    /// Bodies that appear, or begin to move, at a later time; by ascending id.
    pub scheduled: Vec<Scheduled>,

    /// Id of the shape's body (n_shapes).
    pub shape_body: Vec<u32>,
    /// Kind of the shape (n_shapes).
    pub shape_kind: Vec<ShapeKind>,
    /// Size of the shape, m; its meaning depends on the [`ShapeKind`] (n_shapes).
    pub shape_size: Vec<DVec3>,
    /// Pose of the shape in the body's principal frame (n_shapes).
    pub shape_pose: PoseColumn,
    /// Material of the shape, an index into `material_names` (n_shapes).
    pub shape_material: Vec<u32>,
    /// Collision group of the shape, an index into `group_names` (n_shapes).
    pub shape_group: Vec<u32>,
    /// Index into `hulls` for a hull, into `surfaces` for a mesh or a height field (n_shapes).
    pub shape_part: Vec<u32>,

    /// Convex hulls.
    pub hulls: Vec<Hull>,
    /// Triangle meshes and height fields.
    pub surfaces: Vec<Surface>,
    /// Names of the materials.
    pub material_names: Vec<String>,
    /// Contact law of each pair of materials, row by row (n_materials²).
    pub laws: Vec<ContactLaw>,
    /// Names of the collision groups.
    pub group_names: Vec<String>,
    /// Whether two groups pass through each other, row by row (n_groups²).
    pub groups_pass: Vec<bool>,
    /// Collision exclusions of the next step: pairs of bodies without contacts, as those that a joint connects; the lower id first, sorted.
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

    /// Whether a joint whose bodies do not touch each other begins or ends to act between steps that begin at `before` and `now`, s.
    pub fn excludes_others(&self, [before, now]: [f64; 2]) -> bool {
        self.joints.iter().any(|joint| !joint.collides && joint.acts(now) != joint.acts(before))
    }

    /// Set the collision exclusions to those of the joints that act at time `t`, s. Returns whether they are others.
    pub fn exclude(&mut self, t: f64) -> bool {
        let acting = self.joints.iter().filter(|joint| joint.acts(t));
        let mut exclusions: Vec<[u32; 2]> = acting.filter_map(|joint| joint.exclusion()).collect();
        exclusions.sort_unstable();
        exclusions.dedup();
        let is_other = exclusions != self.exclusions;
        self.exclusions = exclusions;
        is_other
    }

    /// Index into `laws` of the contact law of shapes `s` and `t`.
    #[inline]
    pub fn law(&self, s: usize, t: usize) -> u32 {
        self.shape_material[s] * self.material_names.len() as u32 + self.shape_material[t]
    }

    /// Whether a shape is a sphere about its body's centre of mass.
    #[inline]
    pub fn is_centred_sphere(&self, shape: usize) -> bool {
        self.shape_kind[shape] == ShapeKind::Sphere && self.shape_pose[shape].position == DVec3::ZERO
    }

    /// Radius of the sphere about a shape's position that fits into it, m; infinite for a surface.
    pub fn inradius(&self, shape: usize) -> f64 {
        let size = self.shape_size[shape];
        match self.shape_kind[shape] {
            ShapeKind::Plane | ShapeKind::Mesh | ShapeKind::HeightField => f64::INFINITY,
            ShapeKind::Capsule => size.x,
            ShapeKind::Cone => size.x * size.z / size.x.hypot(2.0 * size.z),
            ShapeKind::Hull => {
                let hull = &self.hulls[self.shape_part[shape] as usize];
                let faces = hull.faces.iter().zip(&hull.normals);
                faces.map(|(face, n)| hull.vertices[face[0] as usize].dot(*n)).fold(f64::INFINITY, f64::min)
            }
            _ => size.min_element(),
        }
    }

    /// Label of a body for messages: its name, or its id and class.
    pub fn body_label(&self, body: usize) -> String {
        match self.body_names.of(body as u32) {
            Some(name) => format!("`{name}`"),
            None => format!("{body} of class `{}`", self.class_names[self.class[body] as usize]),
        }
    }
}
