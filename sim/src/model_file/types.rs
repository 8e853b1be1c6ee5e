//! The model file as types. Every type refuses keys that it does not know.

use crate::SolverSettings;
use crate::assembly::{HelicalAnchor, TrackedVehicle};
use crate::joint::JointKind;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// What can be in a model, or come with a stage.
#[derive(Clone, Copy, Debug)]
pub struct Content<'a> {
    /// `bodies`.
    pub bodies: &'a [BodyFile],
    /// `fills`.
    pub fills: &'a [FillFile],
    /// `terrains`.
    pub terrains: &'a [TerrainFile],
    /// `assemblies`.
    pub assemblies: &'a [AssemblyFile],
    /// `joints`.
    pub joints: &'a [JointFile],
    /// `springs`.
    pub springs: &'a [SpringFile],
    /// `loads`.
    pub loads: &'a [LoadFile],
}

/// The geometry of a shape: exactly one of these.
#[derive(Clone, Debug, Default)]
pub struct ShapeFile {
    /// A ball.
    pub sphere: Option<SphereFile>,
    /// An ellipsoid.
    pub ellipsoid: Option<EllipsoidFile>,
    /// A box.
    pub block: Option<BoxFile>,
    /// A cylinder about local z.
    pub cylinder: Option<CylinderFile>,
    /// A cylinder about local z with half balls on its ends.
    pub capsule: Option<CylinderFile>,
    /// A cone about local z, tip up; the local origin is half way up.
    pub cone: Option<CylinderFile>,
    /// The convex hull of points.
    pub hull: Option<HullFile>,
    /// A half space, always fixed.
    pub plane: Option<PlaneFile>,
    /// A triangle mesh, always fixed.
    pub mesh: Option<MeshFile>,
    /// A height field, always fixed.
    pub height_field: Option<HeightFieldFile>,
}

// Fields that several types share are written out in each of them: a reader of flattened types could not say where a wrong
// key stands.

/// A type with the fields of [`Content`] after its own.
macro_rules! with_content {
    ($(#[$meta:meta])* pub struct $name:ident { $($own:tt)* }) => {
        $(#[$meta])*
        pub struct $name {
            $($own)*
            /// Single bodies.
            #[serde(default, skip_serializing_if = "Vec::is_empty")]
            pub bodies: Vec<BodyFile>,
            /// Regions filled with spheres.
            #[serde(default, skip_serializing_if = "Vec::is_empty")]
            pub fills: Vec<FillFile>,
            /// Ready-made grounds.
            #[serde(default, skip_serializing_if = "Vec::is_empty")]
            pub terrains: Vec<TerrainFile>,
            /// Ready-made machines.
            #[serde(default, skip_serializing_if = "Vec::is_empty")]
            pub assemblies: Vec<AssemblyFile>,
            /// Joints.
            #[serde(default, skip_serializing_if = "Vec::is_empty")]
            pub joints: Vec<JointFile>,
            /// Springs and dampers.
            #[serde(default, skip_serializing_if = "Vec::is_empty")]
            pub springs: Vec<SpringFile>,
            /// Forces and torques.
            #[serde(default, skip_serializing_if = "Vec::is_empty")]
            pub loads: Vec<LoadFile>,
        }

        impl $name {
            /// What is in it.
            pub fn content(&self) -> Content<'_> {
                Content {
                    bodies: &self.bodies,
                    fills: &self.fills,
                    terrains: &self.terrains,
                    assemblies: &self.assemblies,
                    joints: &self.joints,
                    springs: &self.springs,
                    loads: &self.loads,
                }
            }
        }
    };
}

/// A type with the fields of [`ShapeFile`] after its own.
macro_rules! with_shape {
    ($(#[$meta:meta])* pub struct $name:ident { $($own:tt)* }) => {
        $(#[$meta])*
        pub struct $name {
            $($own)*
            /// A ball.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            pub sphere: Option<SphereFile>,
            /// An ellipsoid.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            pub ellipsoid: Option<EllipsoidFile>,
            /// A box.
            #[serde(default, rename = "box", skip_serializing_if = "Option::is_none")]
            pub block: Option<BoxFile>,
            /// A cylinder about local z.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            pub cylinder: Option<CylinderFile>,
            /// A cylinder about local z with half balls on its ends.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            pub capsule: Option<CylinderFile>,
            /// A cone about local z, tip up; the local origin is half way up.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            pub cone: Option<CylinderFile>,
            /// The convex hull of points.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            pub hull: Option<HullFile>,
            /// A half space, always fixed.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            pub plane: Option<PlaneFile>,
            /// A triangle mesh, always fixed.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            pub mesh: Option<MeshFile>,
            /// A height field, always fixed.
            #[serde(default, skip_serializing_if = "Option::is_none")]
            pub height_field: Option<HeightFieldFile>,
        }

        impl $name {
            /// Its geometry.
            pub fn shape(&self) -> ShapeFile {
                ShapeFile {
                    sphere: self.sphere.clone(),
                    ellipsoid: self.ellipsoid.clone(),
                    block: self.block.clone(),
                    cylinder: self.cylinder.clone(),
                    capsule: self.capsule.clone(),
                    cone: self.cone.clone(),
                    hull: self.hull.clone(),
                    plane: self.plane.clone(),
                    mesh: self.mesh.clone(),
                    height_field: self.height_field.clone(),
                }
            }

            /// Set its geometry.
            pub fn set_shape(&mut self, shape: ShapeFile) {
                self.sphere = shape.sphere;
                self.ellipsoid = shape.ellipsoid;
                self.block = shape.block;
                self.cylinder = shape.cylinder;
                self.capsule = shape.capsule;
                self.cone = shape.cone;
                self.hull = shape.hull;
                self.plane = shape.plane;
                self.mesh = shape.mesh;
                self.height_field = shape.height_field;
            }
        }
    };
}

with_content! {
    /// A model file.
    #[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
    #[serde(deny_unknown_fields)]
    pub struct ModelFile {
        /// Name, for messages; the file's stem if not given.
        #[serde(default)]
        pub name: String,
        /// Gravity, m/s².
        #[serde(default = "default_gravity")]
        pub gravity: [f64; 3],
        /// Step size, s.
        #[serde(default = "default_step")]
        pub step: f64,
        /// Time to simulate, s; with `stages`, the sum of theirs.
        #[serde(default = "default_duration")]
        pub duration: f64,
        /// Frames a second of simulated time.
        #[serde(default = "default_frame_rate")]
        pub frame_rate: f64,
        /// Seed of the generators.
        #[serde(default)]
        pub seed: u64,
        /// How frames are stored.
        #[serde(default)]
        #[schemars(with = "String")]
        pub format: frame::run::FrameFormat,
        /// Time between checkpoints, s; one at each stage's end and at the end of the run are written in any case.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        pub checkpoint_interval: Option<f64>,
        /// What to do when a step goes wrong (a residual, a joint or an energy out of bounds): `warn`, and end with exit code 5, or
        /// `stop` with exit code 4. What is not finite always stops.
        #[serde(default, skip_serializing_if = "OnDivergence::is_default")]
        pub on_divergence: OnDivergence,
        /// Another run whose bodies are there from the start, as they were at its last checkpoint.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        pub base: Option<BaseFile>,
        /// The contact solver.
        #[serde(default)]
        pub solver: SolverSettings,
        /// Materials by name.
        #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
        pub materials: BTreeMap<String, MaterialFile>,
        /// Laws of pairs of materials, where they are not the rule's.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        pub contacts: Vec<PairFile>,
        /// Pairs of collision groups that pass through each other.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        pub pass_through: Vec<[String; 2]>,
        /// Parts of the run, one after the other; what a part has appears when it begins.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        pub stages: Vec<StageFile>,
        /// What is written to probes.csv.
        #[serde(default)]
        pub probes: ProbesFile,
        /// A grid of values: one run for each combination.
        #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
        #[schemars(schema_with = "lists")]
    pub sweep: BTreeMap<String, Vec<serde_yaml::Value>>,
    }
}

/// What to do when a step goes wrong.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum OnDivergence {
    /// Say it and go on.
    #[default]
    Warn,
    /// Stop the run; its last checkpoint stays.
    Stop,
}

impl OnDivergence {
    fn is_default(&self) -> bool {
        *self == OnDivergence::default()
    }
}

/// Another run to go on from.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BaseFile {
    /// Its run directory, from this file's folder.
    pub run: PathBuf,
    /// Only bodies of these classes; all if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub classes: Option<Vec<String>>,
    /// Stop all motion.
    #[serde(default)]
    pub at_rest: bool,
}

/// A material.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MaterialFile {
    /// Density, kg/m³.
    pub density: f64,
    /// Coefficient of friction; a contact takes the smaller of its two.
    pub friction: f64,
    /// Coefficient of restitution, 0 to 1; a contact takes the greater.
    #[serde(default)]
    pub restitution: f64,
    /// Force by which a contact holds, N; a contact takes the smaller.
    #[serde(default)]
    pub cohesion: f64,
    /// Rolling friction, m: greatest rolling torque over normal force; a contact takes the smaller.
    #[serde(default)]
    pub rolling: f64,
    /// Spinning friction, m: greatest torque about the normal over normal force; a contact takes the smaller.
    #[serde(default)]
    pub spinning: f64,
}

/// The law of a pair of materials; what is not given follows the rule.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PairFile {
    /// The two.
    pub materials: [String; 2],
    /// As for a material.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction: Option<f64>,
    /// As for a material.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub restitution: Option<f64>,
    /// As for a material.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cohesion: Option<f64>,
    /// As for a material.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rolling: Option<f64>,
    /// As for a material.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spinning: Option<f64>,
}

with_shape! {
    /// A body: one shape, or several under `shapes`.
    #[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
    #[serde(deny_unknown_fields)]
    pub struct BodyFile {
        /// Name.
        pub name: String,
        /// Class, by which pictures select; the name if not given.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        pub class: Option<String>,
        /// Material.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        pub material: Option<String>,
        /// Collision group.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        pub group: Option<String>,
        /// Its shapes, if there are several or none.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        pub shapes: Option<Vec<PartFile>>,
        /// Position of the body's frame, m.
        #[serde(default)]
        pub position: [f64; 3],
        /// Orientation, as a turn about an axis.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        pub rotate: Option<RotateFile>,
        /// Orientation, as a quaternion w, x, y, z.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        pub orientation: Option<[f64; 4]>,
        /// Velocity of the centre of mass, m/s.
        #[serde(default)]
        pub velocity: [f64; 3],
        /// Angular velocity, rad/s, body frame.
        #[serde(default)]
        pub angular_velocity: [f64; 3],
        /// Held in place: a static obstacle.
        #[serde(default)]
        pub fixed: bool,
        /// Mass, kg; from the density if not given.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        pub mass: Option<f64>,
        /// Moments of inertia about the centre of mass along the body's axes, kg m²: xx, yy, zz and if need be xy, xz, yz.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        pub inertia: Option<Vec<f64>>,
        /// Centre of mass in the body's frame, m; from the shapes if not given.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        pub center: Option<[f64; 3]>,
        /// When it appears, s.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        pub appears: Option<f64>,
        /// Held in place until this time, s.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        pub held_until: Option<f64>,
    }
}

with_shape! {
    /// One shape of several.
    #[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
    #[serde(deny_unknown_fields)]
    pub struct PartFile {
        /// Material; the body's if not given.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        pub material: Option<String>,
        /// Position in the body's frame, m.
        #[serde(default)]
        pub position: [f64; 3],
        /// Orientation in the body's frame.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        pub rotate: Option<RotateFile>,
        /// Orientation in the body's frame, as a quaternion w, x, y, z.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        pub orientation: Option<[f64; 4]>,
    }
}

/// A ball.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SphereFile {
    /// Radius, m.
    pub radius: f64,
}

/// An ellipsoid.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EllipsoidFile {
    /// Half axes, m.
    pub radii: [f64; 3],
}

/// A box.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoxFile {
    /// Edge lengths, m.
    pub size: [f64; 3],
}

/// A cylinder, capsule or cone.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CylinderFile {
    /// Radius, m.
    pub radius: f64,
    /// Whole length along z, m; of a capsule without its round ends.
    pub length: f64,
}

/// A convex hull: of `points`, or of the corners of a `file`.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HullFile {
    /// Points, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub points: Option<Vec<[f64; 3]>>,
    /// An OBJ or STL file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file: Option<PathBuf>,
    /// Metres per unit of the file.
    #[serde(default = "one")]
    pub scale: f64,
}

/// A half space: all points below the plane through the body's position.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlaneFile {
    /// The direction that is up.
    pub normal: [f64; 3],
}

/// A triangle mesh.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeshFile {
    /// An OBJ or STL file; its triangles look outwards.
    pub file: PathBuf,
    /// Metres per unit of the file.
    #[serde(default = "one")]
    pub scale: f64,
}

/// A height field about the body's position: from an `image` or a `grid` file.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HeightFieldFile {
    /// A PNG image; its brightness is the height.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub image: Option<PathBuf>,
    /// A text file: one line a row (from −y to +y), heights in metres, separated by commas or spaces.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub grid: Option<PathBuf>,
    /// Length along x and y, m.
    pub size: [f64; 2],
    /// Heights of black and white, m (images).
    #[serde(default = "default_height")]
    pub height: [f64; 2],
}

/// A turn.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RotateFile {
    /// Axis, of any length but zero.
    pub axis: [f64; 3],
    /// Angle, degrees.
    pub angle: f64,
}

/// How a region is filled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Packing {
    /// A cubic lattice, each site moved a little at random, from the bottom up.
    #[default]
    Lattice,
    /// Hexagonal layers, the closest of lattices, from the bottom up.
    Hexagonal,
    /// At random, no two closer than they may be.
    PoissonDisk,
}

/// How radii are drawn.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(
    untagged,
    expecting = "expected [least, greatest], {mean, deviation, least, greatest} or {sieve: [[size, passing], …]}"
)]
pub enum RadiusFile {
    /// Uniform between two.
    Uniform([f64; 2]),
    /// Normal, cut off.
    Normal(NormalFile),
    /// From a sieve curve.
    Sieve(SieveFile),
}

/// Normal radii.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NormalFile {
    /// Mean, m.
    pub mean: f64,
    /// Standard deviation, m.
    pub deviation: f64,
    /// Least, m.
    pub least: f64,
    /// Greatest, m.
    pub greatest: f64,
}

/// A sieve curve: the share of mass, 0 to 1, that passes each mesh.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SieveFile {
    /// Pairs of mesh width (a diameter), m, and share passing; both rise, the last share is 1.
    pub sieve: Vec<[f64; 2]>,
}

/// A region filled with spheres.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FillFile {
    /// Name, and the class of the spheres.
    pub name: String,
    /// Material.
    pub material: String,
    /// Collision group.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub group: Option<String>,
    /// How many; as many as fit if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub count: Option<usize>,
    /// Their radii, m.
    pub radius: RadiusFile,
    /// Mass of each, kg; from the density if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mass: Option<f64>,
    /// How they lie.
    #[serde(default)]
    pub packing: Packing,
    /// Least corner of the region, m.
    pub min: [f64; 3],
    /// Greatest corner of the region, m.
    pub max: [f64; 3],
    /// Only within this distance of the region's vertical axis, m: a cylinder.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub within_radius: Option<f64>,
    /// Velocity at the start, m/s.
    #[serde(default)]
    pub velocity: [f64; 3],
    /// When they appear, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub appears: Option<f64>,
}

/// Rolling ground as a height field, with ditches and boulders.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TerrainFile {
    /// Name and class.
    pub name: String,
    /// Material.
    pub material: String,
    /// Middle, m.
    #[serde(default)]
    pub position: [f64; 3],
    /// Length along x and y, m.
    pub size: [f64; 2],
    /// Distance of the grid's points, m.
    pub spacing: f64,
    /// Greatest height of the waves over the mean, m.
    #[serde(default)]
    pub amplitude: f64,
    /// Length of the longest waves, m.
    #[serde(default = "default_wavelength")]
    pub wavelength: f64,
    /// Flat around the middle to this distance, m.
    #[serde(default)]
    pub flat_radius: f64,
    /// Ditches.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub ditches: Vec<DitchFile>,
    /// Boulders that lie half sunk in the ground.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub boulders: Option<BouldersFile>,
}

/// A ditch of rounded section.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DitchFile {
    /// Where it begins, m (x, y).
    pub from: [f64; 2],
    /// Where it ends, m.
    pub to: [f64; 2],
    /// Width, m.
    pub width: f64,
    /// Depth, m.
    pub depth: f64,
}

/// Boulders.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BouldersFile {
    /// How many.
    pub count: usize,
    /// Least and greatest radius, m.
    pub radius: [f64; 2],
    /// Material; the terrain's if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
}

/// A machine: exactly one of these.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AssemblyFile {
    /// Name: its bodies and joints are called NAME_PART.
    pub name: String,
    /// A vehicle on two tracks.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tracked_vehicle: Option<TrackedVehicle>,
    /// A helical anchor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub helical_anchor: Option<HelicalAnchor>,
}

/// A joint. Its frame stands at `position` with z along `axis` when the model starts.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct JointFile {
    /// Name.
    pub name: String,
    /// Kind.
    pub kind: JointKind,
    /// Body A; `world` is the ground.
    pub a: String,
    /// Body B.
    pub b: String,
    /// Where, m, world; for joints with two points, the one on A.
    #[serde(default)]
    pub position: [f64; 3],
    /// The point on B, m, world, where it is another one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub position_b: Option<[f64; 3]>,
    /// The joint's z axis, world.
    #[serde(default = "default_axis")]
    pub axis: [f64; 3],
    /// The joint's x axis, world; a universal joint turns about x on A and about y on B.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axis_x: Option<[f64; 3]>,
    /// Length over time, m (distance, revolute_spherical): a linear actuator. As the model starts if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub length: Option<FunctionFile>,
    /// Least and greatest coordinate: degrees for an angle, m for a distance, counted from the start.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limits: Option<[f64; 2]>,
    /// Motor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motor: Option<MotorFile>,
    /// Whether its two bodies may touch.
    #[serde(default)]
    pub collide: bool,
    /// It holds from this time on, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<f64>,
    /// And until this, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub until: Option<f64>,
}

/// A motor: exactly one of these. SI units: rad/s, rad, N m for turning; m/s, m, N for sliding.
#[derive(Clone, Debug, Default, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MotorFile {
    /// Speed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed: Option<FunctionFile>,
    /// Angle or distance.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motion: Option<FunctionFile>,
    /// Torque, N m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub torque: Option<FunctionFile>,
    /// Force, N.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force: Option<FunctionFile>,
}

/// A spring with a damper.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpringFile {
    /// Name.
    pub name: String,
    /// Body A; `world` is the ground.
    pub a: String,
    /// Body B.
    pub b: String,
    /// The point on A, m, world.
    #[serde(default)]
    pub position: [f64; 3],
    /// The point on B, m, world.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub position_b: Option<[f64; 3]>,
    /// Makes it a spring about this axis, world.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub about: Option<[f64; 3]>,
    /// Stiffness, N/m or N m/rad.
    #[serde(default)]
    pub stiffness: f64,
    /// Damping, N s/m or N m s/rad.
    #[serde(default)]
    pub damping: f64,
    /// Length, m, without force, or angle, degrees; as the model starts if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rest: Option<f64>,
    /// Force or torque in addition, pulling B to A where positive.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub preload: Option<FunctionFile>,
    /// It acts from this time on, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<f64>,
    /// And until this, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub until: Option<f64>,
}

/// A force or a torque on a body.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LoadFile {
    /// The body.
    pub body: String,
    /// Direction of a force; its length does not count.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force: Option<[f64; 3]>,
    /// Direction of a torque; its length does not count.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub torque: Option<[f64; 3]>,
    /// Its size over time, N or N m.
    pub value: FunctionFile,
    /// The frame of the direction: `world`, or `body`, which turns with it.
    #[serde(default)]
    pub frame: LoadFrame,
    /// Where a force acts, in the body's frame, m; at the centre of mass if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub point: Option<[f64; 3]>,
    /// It acts from this time on, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<f64>,
    /// And until this, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub until: Option<f64>,
}

/// The frame of a load's direction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum LoadFrame {
    /// The world's.
    #[default]
    World,
    /// The body's.
    Body,
}

/// A function of time: a number, or exactly one of the forms.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(
    untagged,
    expecting = "expected a number, {step: {…}}, {ramp: {…}}, {sine: {…}}, {table: [[time, value], …]} or {csv: FILE}"
)]
pub enum FunctionFile {
    /// Constant.
    Constant(f64),
    /// A step.
    Step {
        /// The step.
        step: StepFile,
    },
    /// A ramp.
    Ramp {
        /// The ramp.
        ramp: RampFile,
    },
    /// A sine.
    Sine {
        /// The sine.
        sine: SineFile,
    },
    /// Points joined by straight lines.
    Table {
        /// Pairs of time, s, and value; times rise.
        table: Vec<[f64; 2]>,
    },
    /// Points from a CSV file of two columns, with or without a header.
    Csv {
        /// The file.
        csv: PathBuf,
    },
}

/// A step.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StepFile {
    /// When, s.
    pub at: f64,
    /// Value before.
    #[serde(default)]
    pub before: f64,
    /// Value after.
    pub after: f64,
}

/// A ramp.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RampFile {
    /// Begin and end, s.
    pub times: [f64; 2],
    /// Values there; constant outside.
    pub values: [f64; 2],
}

/// A sine.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SineFile {
    /// Amplitude.
    pub amplitude: f64,
    /// Frequency, Hz.
    pub frequency: f64,
    /// Mean.
    #[serde(default)]
    pub mean: f64,
    /// Phase, degrees.
    #[serde(default)]
    pub phase: f64,
}

with_content! {
    /// A part of the run; what it has appears when it begins, and loads and joints act from then on.
    #[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
    #[serde(deny_unknown_fields)]
    pub struct StageFile {
        /// Name; its checkpoint is called so.
        pub name: String,
        /// How long, s.
        pub duration: f64,
        /// Bodies that are held in place before and let go now.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        pub release: Vec<String>,
    }
}

/// What is written to probes.csv.
#[derive(Clone, Debug, Default, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ProbesFile {
    /// Time between two lines, s; every step if not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub interval: Option<f64>,
    /// Bodies by name, `*` standing for any characters; the single moving bodies of `bodies` if not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bodies: Option<Vec<String>>,
    /// Joints and springs by name, `*` standing for any characters; those of `joints` and `springs` if not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub joints: Option<Vec<String>>,
    /// Total contact forces between two classes.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub contacts: Vec<ContactProbeFile>,
    /// Leave the energies out.
    pub no_energies: bool,
    /// Write a table of all contacts beside every frame.
    pub contact_tables: bool,
}

/// The contacts of two classes, added up.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ContactProbeFile {
    /// Name.
    pub name: String,
    /// Classes: the force is the one on the second.
    pub between: [String; 2],
}

/// Words that come from code, as YAML.
fn quoted(text: &str) -> String {
    serde_yaml::to_string(text).expect("text is plain data").trim_end().to_string()
}

impl BodyFile {
    /// A body of a name, all else as if not given.
    pub fn named(name: &str) -> BodyFile {
        serde_yaml::from_str(&format!("name: {}", quoted(name))).expect("all other keys of a body have defaults")
    }
}

impl JointFile {
    /// A joint between two bodies, all else as if not given.
    pub fn named(name: &str, kind: JointKind, a: &str, b: &str) -> JointFile {
        let mut joint: JointFile = serde_yaml::from_str("{name: j, kind: fixed, a: a, b: b}")
            .expect("all other keys of a joint have defaults");
        (joint.name, joint.kind, joint.a, joint.b) = (name.into(), kind, a.into(), b.into());
        joint
    }
}

fn default_gravity() -> [f64; 3] {
    [0.0, 0.0, -9.81]
}

fn default_step() -> f64 {
    1e-3
}

fn default_duration() -> f64 {
    1.0
}

fn default_frame_rate() -> f64 {
    24.0
}

fn default_height() -> [f64; 2] {
    [0.0, 1.0]
}

fn default_wavelength() -> f64 {
    5.0
}

fn default_axis() -> [f64; 3] {
    [0.0, 0.0, 1.0]
}

fn one() -> f64 {
    1.0
}

/// The schema of lists of any values by name.
fn lists(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
    schemars::json_schema!({"type": "object", "additionalProperties": {"type": "array"}})
}
