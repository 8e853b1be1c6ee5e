//! The constant model and the mutable state, as columns. `n_bodies`, `n_shapes` and `n_contacts` are the columns' lengths.

use crate::SolverSettings;
use glam::{DMat3, DQuat, DVec3};

/// What a shape is; its `size` reads accordingly.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum ShapeKind {
    /// Ball; size is (radius, radius, radius).
    Sphere,
    /// Box; size is the three half lengths.
    Box,
    /// Half space below local z = 0; size is unused.
    Plane,
}

impl ShapeKind {
    /// The name, as models and frame tables write it.
    pub fn name(self) -> &'static str {
        match self {
            ShapeKind::Sphere => "sphere",
            ShapeKind::Box => "box",
            ShapeKind::Plane => "plane",
        }
    }
}

/// Which form of Coulomb's law a step satisfies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FrictionLaw {
    /// The convex form of the paper: a sliding contact separates at `μ |v_t|`.
    #[default]
    Relaxed,
    /// Coulomb's law itself, by an outer fixed point on `μ |v_t|`.
    Exact,
}

/// All that a run does not change.
#[derive(Clone, Debug)]
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
    /// Names of the classes.
    pub class_names: Vec<String>,
    /// The body that carries the shape (n_shapes).
    pub shape_body: Vec<u32>,
    /// What it is (n_shapes).
    pub shape_kind: Vec<ShapeKind>,
    /// Its size, m (n_shapes).
    pub shape_size: Vec<DVec3>,
    /// Its coefficient of friction; a contact takes the smaller of its two (n_shapes).
    pub shape_friction: Vec<f64>,
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

    /// Number of frames of the whole run: one at time 0, then one every 1/`frame_rate`, before `duration`.
    pub fn n_frames(&self, until: f64) -> u64 {
        ((until.min(self.duration) * self.frame_rate - 1e-9).ceil() as u64).max(1)
    }
}

/// All that a step changes.
#[derive(Clone, Debug, Default)]
pub struct State {
    /// Time, s.
    pub time: f64,
    /// Steps taken.
    pub steps: u64,
    /// Centre of mass, m, world (n_bodies).
    pub position: Vec<DVec3>,
    /// Orientation, body to world, unit (n_bodies).
    pub orientation: Vec<DQuat>,
    /// Velocity, m/s, world (n_bodies).
    pub velocity: Vec<DVec3>,
    /// Angular velocity ω̄, rad/s, body frame (n_bodies).
    pub angular_velocity: Vec<DVec3>,
    /// The contacts of the last step, with their impulses.
    pub contacts: Contacts,
}

/// Contacts as columns (n_contacts each). Body A is the one with the lower index.
#[derive(Clone, Debug, Default)]
pub struct Contacts {
    /// Bodies A and B.
    pub bodies: Vec<[u32; 2]>,
    /// Shapes of A and B and the feature where they touch: what a contact is known by from step to step.
    pub key: Vec<[u32; 3]>,
    /// Unit normal, out of A, world.
    pub normal: Vec<DVec3>,
    /// From A's centre to its contact point, m, world.
    pub arm_a: Vec<DVec3>,
    /// From B's centre to its contact point, m, world.
    pub arm_b: Vec<DVec3>,
    /// Gap Φ, m; negative where the bodies overlap.
    pub gap: Vec<f64>,
    /// Coefficient of friction.
    pub friction: Vec<f64>,
    /// Impulse on B, N s, in the contact's frame (normal, tangent u, tangent w).
    pub gamma: Vec<DVec3>,
    /// Contacts of each body: `incident[incident_start[b]..incident_start[b+1]]` (n_bodies + 1).
    pub incident_start: Vec<u32>,
    /// Twice the contact's index, plus one where the body is B.
    pub incident: Vec<u32>,
}

impl Contacts {
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

    /// Indices into the contacts of a body.
    pub(crate) fn of_body(&self, body: usize) -> &[u32] {
        match self.incident_start.get(body..body + 2) {
            Some(ends) => &self.incident[ends[0] as usize..ends[1] as usize],
            None => &[],
        }
    }
}

/// The contact frame A_p = [n u w]: two tangents to a unit normal (Duff et al. 2017), smooth but for n_z = 0.
#[inline]
pub(crate) fn tangents(n: DVec3) -> (DVec3, DVec3) {
    let sign = 1f64.copysign(n.z);
    let a = -1.0 / (sign + n.z);
    let b = n.x * n.y * a;
    (DVec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x), DVec3::new(b, sign + n.y * n.y * a, -n.y))
}

/// Reciprocal inertia in the world frame, R J̄⁻¹ Rᵀ.
#[inline]
pub(crate) fn world_inv_inertia(orientation: DQuat, inv_inertia: DVec3) -> DMat3 {
    if inv_inertia.x == inv_inertia.y && inv_inertia.y == inv_inertia.z {
        return DMat3::from_diagonal(inv_inertia);
    }
    let r = DMat3::from_quat(orientation);
    r * DMat3::from_diagonal(inv_inertia) * r.transpose()
}
