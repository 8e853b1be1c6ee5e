//! The model file as types. Every type refuses keys that it does not know.

mod bodies;
mod fills;
mod joints;

pub use bodies::*;
pub use fills::*;
pub use joints::*;

use crate::SolverSettings;
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
