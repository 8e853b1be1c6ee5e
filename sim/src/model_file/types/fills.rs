//! Fills, terrains and ready-made machines, as a model file writes them.

use crate::assembly::{HelicalAnchor, TrackedVehicle};
use serde::{Deserialize, Serialize};

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

fn default_wavelength() -> f64 {
    5.0
}
