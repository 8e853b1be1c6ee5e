//! The types of the model file. Every type refuses unknown keys.

mod bodies;
mod fills;
mod joints;

pub use bodies::*;
pub use fills::*;
pub use joints::*;

use crate::stages::Stage;
use crate::{Quality, SolverSettings};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// The content of a model file or of one of its stages: the lists of bodies, joints and loads that both have.
#[derive(Clone, Copy, Debug)]
pub struct Content<'a> {
    /// Bodies.
    pub bodies: &'a [BodyFile],
    /// Regions filled with spheres.
    pub fills: &'a [FillFile],
    /// Terrains: parametric grounds.
    pub terrains: &'a [TerrainFile],
    /// Assemblies: parametric machines.
    pub assemblies: &'a [AssemblyFile],
    /// Joints.
    pub joints: &'a [JointFile],
    /// Springs and dampers.
    pub springs: &'a [SpringFile],
    /// Loads: forces and torques.
    pub loads: &'a [LoadFile],
}

// Common fields are repeated in each type: with flattened types an unknown key would be reported without its line.

/// A type with the fields of [`Content`] after its own.
macro_rules! with_content {
    ($(#[$meta:meta])* pub struct $name:ident { $($own:tt)* }) => {
        $(#[$meta])*
        pub struct $name {
            $($own)*
            /// Bodies.
            #[serde(default, skip_serializing_if = "Vec::is_empty")]
            pub bodies: Vec<BodyFile>,
            /// Regions filled with spheres.
            #[serde(default, skip_serializing_if = "Vec::is_empty")]
            pub fills: Vec<FillFile>,
            /// Terrains: parametric grounds.
            #[serde(default, skip_serializing_if = "Vec::is_empty")]
            pub terrains: Vec<TerrainFile>,
            /// Assemblies: parametric machines.
            #[serde(default, skip_serializing_if = "Vec::is_empty")]
            pub assemblies: Vec<AssemblyFile>,
            /// Joints.
            #[serde(default, skip_serializing_if = "Vec::is_empty")]
            pub joints: Vec<JointFile>,
            /// Springs and dampers.
            #[serde(default, skip_serializing_if = "Vec::is_empty")]
            pub springs: Vec<SpringFile>,
            /// Loads: forces and torques.
            #[serde(default, skip_serializing_if = "Vec::is_empty")]
            pub loads: Vec<LoadFile>,
        }

        impl $name {
            /// The content: the lists from `bodies` to `loads`.
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

with_content! {
    /// A model file: the keys of its YAML document.
    #[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
    #[serde(deny_unknown_fields)]
    pub struct ModelFile {
        /// Name, for messages; the file's stem if not given.
        #[serde(default)]
        pub name: String,
        /// Gravity, m/s², world.
        #[serde(default = "default_gravity")]
        pub gravity: [f64; 3],
        /// Level of quality: `draft`, `normal` or `tight`, which chooses the step and the solver's settings where these are not given.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        pub quality: Option<Quality>,
        /// Step size, s.
        #[serde(default = "default_step")]
        pub step: f64,
        /// Time to simulate, s; with `stages`, the sum of their durations.
        #[serde(default = "default_duration")]
        pub duration: f64,
        /// Frames per second of simulated time.
        #[serde(default = "default_frame_rate")]
        pub frame_rate: f64,
        /// Seed of the pseudo-random generator.
        #[serde(default)]
        pub seed: u64,
        /// File format of frames: `arrow` or `csv`.
        #[serde(default)]
        #[schemars(with = "String")]
        pub format: frame::run::FrameFormat,
        /// Time between checkpoints, s; there is also one at the end of each stage and of the run.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        pub checkpoint_interval: Option<f64>,
        /// Reaction to a residual, joint error or energy out of bounds: `warn`, and end with exit code 5, or `stop` with exit code 4.
        /// Values that are not finite always stop the run.
        #[serde(default, skip_serializing_if = "OnDivergence::is_default")]
        pub on_divergence: OnDivergence,
        /// First stage of the step that a graphics adapter runs: those before it are the processor's, to tell in which of them a fault is.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        pub gpu_from: Option<Stage>,
        /// Another run, whose bodies at its last checkpoint are in this model from the start.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        pub base: Option<BaseFile>,
        /// Settings of the contact solver.
        #[serde(default)]
        pub solver: SolverSettings,
        /// Materials by name.
        #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
        pub materials: BTreeMap<String, MaterialFile>,
        /// Contact laws of pairs of materials that differ from the combination of the two materials' values.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        pub contacts: Vec<PairFile>,
        /// Pairs of collision groups that pass through each other.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        pub pass_through: Vec<[String; 2]>,
        /// Stages of the run, one after the other; the content of a stage appears when it begins.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        pub stages: Vec<StageFile>,
        /// Quantities of `probes.csv`.
        #[serde(default)]
        pub probes: ProbesFile,
        /// Parameter sweep: lists of values by the path of a key, with one run for each combination.
        #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
        #[schemars(schema_with = "lists")]
    pub sweep: BTreeMap<String, Vec<serde_yaml::Value>>,
    }
}

/// Reaction to a step whose residual, joint error or energy is out of bounds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum OnDivergence {
    /// Warn the user and continue.
    #[default]
    Warn,
    /// Stop the run; its last checkpoint is kept.
    Stop,
}

impl OnDivergence {
    fn is_default(&self) -> bool {
        *self == OnDivergence::default()
    }
}

/// Another run as the base of a model: its bodies, with the joints and springs between them; loads are not carried over.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BaseFile {
    /// Run directory, relative to this file's folder.
    pub run: PathBuf,
    /// Classes whose bodies are included; all if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub classes: Option<Vec<String>>,
    /// Whether the velocities of the bodies are set to zero.
    #[serde(default)]
    pub at_rest: bool,
}

/// A material: density and contact law. The contact law of two materials is combined from the values of both.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MaterialFile {
    /// Density, kg/m³.
    pub density: f64,
    /// Coefficient of friction; two materials have the smaller value.
    pub friction: f64,
    /// Coefficient of restitution, 0 to 1; two materials have the greater value.
    #[serde(default)]
    pub restitution: f64,
    /// Cohesion: maximum tensile force of a contact, N; two materials have the smaller value.
    #[serde(default)]
    pub cohesion: f64,
    /// Rolling friction, m: maximum rolling torque over normal force; two materials have the smaller value.
    #[serde(default)]
    pub rolling: f64,
    /// Spinning friction, m: maximum torque about the normal over normal force; two materials have the smaller value.
    #[serde(default)]
    pub spinning: f64,
}

/// The contact law of a pair of materials; values that are not given are combined from the values of the two materials.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PairFile {
    /// Names of the two materials.
    pub materials: [String; 2],
    /// Coefficient of friction.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction: Option<f64>,
    /// Coefficient of restitution, 0 to 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub restitution: Option<f64>,
    /// Cohesion: maximum tensile force of a contact, N.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cohesion: Option<f64>,
    /// Rolling friction, m: maximum rolling torque over normal force.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rolling: Option<f64>,
    /// Spinning friction, m: maximum torque about the normal over normal force.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spinning: Option<f64>,
}

with_content! {
    /// A stage of the run: its bodies appear when the stage begins, and its joints, springs and loads act from then on.
    #[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
    #[serde(deny_unknown_fields)]
    pub struct StageFile {
        /// Name of the stage, also of the checkpoint at its end.
        pub name: String,
        /// Duration, s.
        pub duration: f64,
        /// Names of bodies that are held in place until this stage begins.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        pub release: Vec<String>,
    }
}

/// Quantities of `probes.csv`.
#[derive(Clone, Debug, Default, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ProbesFile {
    /// Time between lines, s; every step if not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub interval: Option<f64>,
    /// Bodies by name, with `*` for any characters; the moving bodies of `bodies` if not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bodies: Option<Vec<String>>,
    /// Joints and springs by name, with `*` for any characters; those of `joints` and `springs` if not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub joints: Option<Vec<String>>,
    /// Total contact forces between pairs of classes.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub contacts: Vec<ContactProbeFile>,
    /// Whether the energies are left out.
    pub no_energies: bool,
    /// Whether a table of all contacts is written with every frame.
    pub contact_tables: bool,
}

/// Total contact force between two classes, a quantity of `probes.csv`.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ContactProbeFile {
    /// Name of the quantity.
    pub name: String,
    /// The two classes; the force is that on the second.
    pub between: [String; 2],
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

/// The schema of lists of any values by name.
fn lists(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
    schemars::json_schema!({"type": "object", "additionalProperties": {"type": "array"}})
}
