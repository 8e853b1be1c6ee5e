//! The constant model and the mutable state, as columns. `n_bodies`, `n_shapes` and `n_contacts` are the columns' lengths.

use crate::SolverSettings;
use crate::geometry::{Hull, Surface};
use crate::joint::{Joint, Spring};
use crate::load::Load;
use glam::{DMat3, DQuat, DVec3};
use std::collections::{BTreeMap, HashMap};

/// What a shape is; its `size` reads accordingly.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum ShapeKind {
    /// Ball; size is (radius, radius, radius).
    Sphere,
    /// Ellipsoid; size is the three half axes.
    Ellipsoid,
    /// Box; size is the three half lengths.
    Box,
    /// Cylinder about local z; size is (radius, radius, half length).
    Cylinder,
    /// Cylinder about local z with half balls on its ends; size is (radius, radius, half length of the cylinder).
    Capsule,
    /// Cone about local z, its base at −z and its tip at +z; size is (radius, radius, half height).
    Cone,
    /// Convex hull of points; size is the half lengths of the box around it.
    Hull,
    /// Half space below local z = 0; size is unused.
    Plane,
    /// Static triangle mesh; size is the half lengths of the box around it.
    Mesh,
    /// Static height field; size is the half lengths of the box around it.
    HeightField,
}

impl ShapeKind {
    /// All kinds, in the order of their numbers.
    pub const ALL: [ShapeKind; 10] = [
        ShapeKind::Sphere,
        ShapeKind::Ellipsoid,
        ShapeKind::Box,
        ShapeKind::Cylinder,
        ShapeKind::Capsule,
        ShapeKind::Cone,
        ShapeKind::Hull,
        ShapeKind::Plane,
        ShapeKind::Mesh,
        ShapeKind::HeightField,
    ];

    /// The name, as models and frame tables write it.
    pub fn name(self) -> &'static str {
        match self {
            ShapeKind::Sphere => "sphere",
            ShapeKind::Ellipsoid => "ellipsoid",
            ShapeKind::Box => "box",
            ShapeKind::Cylinder => "cylinder",
            ShapeKind::Capsule => "capsule",
            ShapeKind::Cone => "cone",
            ShapeKind::Hull => "hull",
            ShapeKind::Plane => "plane",
            ShapeKind::Mesh => "mesh",
            ShapeKind::HeightField => "height_field",
        }
    }

    /// Whether the shape is a surface that only static bodies carry: it is met shape by shape, not through bins.
    pub fn is_surface(self) -> bool {
        matches!(self, ShapeKind::Plane | ShapeKind::Mesh | ShapeKind::HeightField)
    }
}

/// Which form of Coulomb's law a step satisfies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum FrictionLaw {
    /// The convex form of the paper: a sliding contact separates at `μ |v_t|`.
    #[default]
    Relaxed,
    /// Coulomb's law itself, by an outer fixed point on `μ |v_t|`.
    Exact,
}

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

/// A place and an orientation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// Position, m.
    pub position: DVec3,
    /// Orientation, unit.
    pub orientation: DQuat,
}

impl Pose {
    /// A pose given in this one's frame, in the frame that this one is given in.
    #[inline]
    pub fn place(&self, local: &Pose) -> Pose {
        Pose {
            position: self.position + self.orientation * local.position,
            orientation: self.orientation * local.orientation,
        }
    }

    /// The inverse: this pose's outer frame, in its own.
    pub fn inverse(&self) -> Pose {
        let orientation = self.orientation.inverse();
        Pose { position: orientation * -self.position, orientation }
    }
}

/// A column of poses of which most are alike, as those of the grains of a bed are: a row names one of the distinct ones.
#[derive(Clone, Debug, Default)]
pub struct PoseColumn {
    distinct: Vec<Pose>,
    /// So many rows, from the first, have the first pose.
    alike: usize,
    /// Which pose each of the others has.
    row: Vec<u32>,
    known: HashMap<[u64; 7], u32>,
}

impl PoseColumn {
    /// Add a row.
    pub fn push(&mut self, pose: Pose) {
        let (p, q) = (pose.position, pose.orientation);
        let name = [p.x, p.y, p.z, q.x, q.y, q.z, q.w].map(f64::to_bits);
        let next = self.distinct.len() as u32;
        let row = *self.known.entry(name).or_insert(next);
        if row == next {
            self.distinct.push(pose);
        }
        if row == 0 && self.row.is_empty() {
            self.alike += 1;
        } else {
            self.row.push(row);
        }
    }
}

impl std::ops::Index<usize> for PoseColumn {
    type Output = Pose;

    #[inline]
    fn index(&self, row: usize) -> &Pose {
        let which = if row < self.alike { 0 } else { self.row[row - self.alike] };
        &self.distinct[which as usize]
    }
}

/// A body that is absent or held in place at first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Late {
    /// The body.
    pub body: u32,
    /// When it appears, s.
    pub appears: f64,
    /// When it begins to move, s.
    pub moves: f64,
    /// Its reciprocal mass then, 1/kg.
    pub inv_mass: f64,
    /// Its reciprocal principal moments of inertia then, 1/(kg m²).
    pub inv_inertia: DVec3,
}

/// What a run computes with. Only [`Late`] bodies ever change it: their masses are zero until they move.
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

    /// Reciprocal mass, 1/kg; zero holds the body where it is (n_bodies).
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
    /// Whether the body is not there yet: it neither moves nor touches, and is in no table (n_bodies).
    pub absent: Vec<bool>,
    /// Bodies that appear, or begin to move, at a later time.
    pub late: Vec<Late>,

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
    /// Pairs of bodies that never touch, as those that a joint connects; the lower body first, sorted.
    pub apart: Vec<[u32; 2]>,

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

    /// Where a shape is.
    #[inline]
    pub fn shape_place(&self, state: &State, shape: usize) -> Pose {
        let body = self.shape_body[shape] as usize;
        let own = Pose { position: state.position[body], orientation: state.orientation[body] };
        if self.is_centred_ball(shape) { own } else { own.place(&self.shape_pose[shape]) }
    }

    /// Whether a shape is a ball about its body's centre.
    #[inline]
    pub fn is_centred_ball(&self, shape: usize) -> bool {
        self.shape_kind[shape] == ShapeKind::Sphere && self.shape_pose[shape].position == DVec3::ZERO
    }

    /// Whether all that moves are balls that turn alike about all axes, and all balls are about their bodies' centres.
    pub fn has_balls_only(&self) -> bool {
        let moves = |s: usize| self.inv_mass[self.shape_body[s] as usize] > 0.0;
        let fits = |s: usize| self.is_centred_ball(s) || (self.shape_kind[s] != ShapeKind::Sphere && !moves(s));
        self.inv_inertia.iter().all(|i| is_isotropic(*i)) && (0..self.n_shapes()).all(fits)
    }

    /// Kinetic energy of a state, J.
    pub fn kinetic_energy(&self, state: &State) -> f64 {
        (0..self.n_bodies())
            .filter(|&b| self.inv_mass[b] > 0.0)
            .map(|b| {
                let w = state.angular_velocity[b];
                0.5 * state.velocity[b].length_squared() / self.inv_mass[b]
                    + 0.5 * (w * w / self.inv_inertia[b]).element_sum()
            })
            .sum()
    }

    /// Potential energy in gravity, J, against the world's origin.
    pub fn potential_energy(&self, state: &State) -> f64 {
        let moving = (0..self.n_bodies()).filter(|&b| self.inv_mass[b] > 0.0);
        moving.map(|b| -self.gravity.dot(state.position[b]) / self.inv_mass[b]).sum()
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
    /// Boxes with room to move, for which the pairs that may touch were found last (n_shapes).
    pub roomy: Vec<crate::cpu::Aabb>,
    /// What each joint did in the last step (n_joints).
    pub joints: Vec<crate::joint::JointState>,
    /// What each spring did in the last step (n_springs).
    pub springs: Vec<crate::joint::SpringState>,
    /// The step length that was right for the last step's solver; 0 if none was.
    pub step_length: f64,
    /// What the watch over the run remembers.
    pub watch: crate::watch::Watch,
}

/// Contacts as columns (n_contacts each). Body A is the one with the lower index.
#[derive(Clone, Debug, Default, serde::Serialize, serde::Deserialize)]
pub struct Contacts {
    /// Bodies A and B.
    pub bodies: Vec<[u32; 2]>,
    /// Shapes of A and B and the feature where they touch: what a contact is known by from step to step.
    pub key: Vec<[u32; 3]>,
    /// Unit normal, out of A, world.
    pub normal: Vec<DVec3>,
    /// From the bodies' centres to the contact point.
    pub arms: Arms,
    /// Gap Φ, m; negative where the bodies overlap.
    pub gap: Vec<f64>,
    /// Which of the model's laws holds.
    pub law: Vec<u32>,
    /// Impulse on B, N s, world: A_p γ.
    pub impulse: Vec<DVec3>,
    /// Angular impulse on B of rolling and spinning friction, N m s, world; empty where no material has any.
    pub twist: Vec<DVec3>,
    /// How they lie by tiles.
    #[serde(skip)]
    pub tiles: Tiles,
}

/// Contacts lie tile by tile: the tiles of a round share no moving body. The second round has what the first cuts, and the
/// contacts after its last tile are in none.
#[derive(Clone, Debug, Default)]
pub struct Tiles {
    /// First contact of each tile, and of the contacts in none (n_tiles + 1).
    pub start: Vec<u32>,
    /// Tiles of the first round.
    pub n_first: usize,
}

impl Tiles {
    /// Where the tiles of each round begin, and after the last where it ends. There must be contacts.
    pub fn rounds(&self) -> [&[u32]; 2] {
        [&self.start[..=self.n_first], &self.start[self.n_first..]]
    }
}

/// From the centres of A and B to the contact point, m, world (n_contacts). Of a body that is held in place nobody asks it.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub enum Arms {
    /// Of any bodies.
    Any(Vec<[DVec3; 2]>),
    /// Of balls about their own centres: along the normal, the lengths alone; zero for a body that is held in place.
    Along(Vec<[f64; 2]>),
}

impl Default for Arms {
    fn default() -> Arms {
        Arms::Any(vec![])
    }
}

impl Contacts {
    /// The arms of a contact, m, world.
    #[inline]
    pub fn arms(&self, i: usize) -> [DVec3; 2] {
        match &self.arms {
            Arms::Any(arms) => arms[i],
            Arms::Along(reach) => [self.normal[i] * reach[i][0], self.normal[i] * -reach[i][1]],
        }
    }

    /// Where a contact is, m, world.
    pub fn point(&self, model: &Model, state: &State, i: usize) -> DVec3 {
        let side = if model.inv_mass[self.bodies[i][0] as usize] > 0.0 { 0 } else { 1 };
        state.position[self.bodies[i][side] as usize] + self.arms(i)[side]
    }

    /// Number of contacts.
    pub fn len(&self) -> usize {
        self.bodies.len()
    }

    /// Whether nothing touches.
    pub fn is_empty(&self) -> bool {
        self.bodies.is_empty()
    }

    /// Greatest overlap, m; zero where nothing overlaps.
    pub fn worst_penetration(&self) -> f64 {
        self.gap.iter().fold(0.0, |worst: f64, gap| worst.max(-gap))
    }

    /// The multipliers γ = (γ_n, γ_u, γ_w) of a contact, N s, in its frame A_p = [n u w].
    pub fn gamma(&self, i: usize) -> DVec3 {
        let (u, w) = tangents(self.normal[i]);
        DVec3::new(self.impulse[i].dot(self.normal[i]), self.impulse[i].dot(u), self.impulse[i].dot(w))
    }

    /// The velocity of B against A at a contact, m/s, world.
    pub fn velocity(&self, state: &State, i: usize) -> DVec3 {
        let [a, b] = self.bodies[i].map(|b| b as usize);
        let [arm_a, arm_b] = self.arms(i);
        let spin = |b: usize| state.orientation[b] * state.angular_velocity[b];
        state.velocity[b] + spin(b).cross(arm_b) - state.velocity[a] - spin(a).cross(arm_a)
    }
}

/// The contact frame A_p = [n u w]: two tangents to a unit normal (Duff et al. 2017), smooth but for n_z = 0.
#[inline]
pub fn tangents(n: DVec3) -> (DVec3, DVec3) {
    let sign = 1f64.copysign(n.z);
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    (DVec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x), DVec3::new(b, sign + n.y * n.y * a, -n.y))
}

/// Reciprocal inertia in the world frame, R J̄⁻¹ Rᵀ.
#[inline]
pub(crate) fn world_inv_inertia(orientation: DQuat, inv_inertia: DVec3) -> DMat3 {
    if is_isotropic(inv_inertia) {
        return DMat3::from_diagonal(inv_inertia);
    }
    let r = DMat3::from_quat(orientation);
    r * DMat3::from_diagonal(inv_inertia) * r.transpose()
}

/// Whether a body turns alike about all axes.
#[inline]
pub(crate) fn is_isotropic(inv_inertia: DVec3) -> bool {
    inv_inertia.x == inv_inertia.y && inv_inertia.y == inv_inertia.z
}
