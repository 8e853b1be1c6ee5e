//! The types of fills, terrains and assemblies in a model file.

pub use crate::assembly::{HelicalAnchor, TrackedVehicle};

use serde::{Deserialize, Serialize};

/// The packing of a fill.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Packing {
    /// A cubic lattice with a small random jitter of each site, from the bottom up.
    #[default]
    Lattice,
    /// Hexagonal layers, the densest lattice, from the bottom up.
    Hexagonal,
    /// Random sites at a minimum distance (Poisson-disk sampling).
    PoissonDisk,
}

/// The distribution of the radii of a fill's spheres, m.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(
    untagged,
    expecting = "expected [min, max], {mean, deviation, least, greatest} or {sieve: [[size, passing], …]}"
)]
pub enum RadiusFile {
    /// Uniform distribution between a minimum and a maximum, m.
    Uniform([f64; 2]),
    /// Truncated normal distribution.
    Normal(NormalFile),
    /// Distribution that follows a sieve curve.
    Sieve(SieveFile),
}

/// A truncated normal distribution of radii.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NormalFile {
    /// Mean, m.
    pub mean: f64,
    /// Standard deviation, m.
    pub deviation: f64,
    /// Minimum, m.
    pub least: f64,
    /// Maximum, m.
    pub greatest: f64,
}

/// A sieve curve: the fraction of mass, 0 to 1, that passes each mesh.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SieveFile {
    /// Pairs of mesh width (a diameter), m, and fraction of mass that passes; both ascend, the last fraction is 1.
    pub sieve: Vec<[f64; 2]>,
}

/// A region filled with spheres.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FillFile {
    /// Name, also the class of the spheres.
    pub name: String,
    /// Name of the material.
    pub material: String,
    /// Name of the collision group.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub group: Option<String>,
    /// Number of spheres; the number that fits if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub count: Option<usize>,
    /// Distribution of the radii, m.
    pub radius: RadiusFile,
    /// Mass of each sphere, kg; from the density of the material if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mass: Option<f64>,
    /// Packing of the spheres.
    #[serde(default)]
    pub packing: Packing,
    /// Minimum corner of the region, m.
    pub min: [f64; 3],
    /// Maximum corner of the region, m.
    pub max: [f64; 3],
    /// Radius of a vertical cylinder about the region's middle that bounds the fill, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub within_radius: Option<f64>,
    /// Velocity of the spheres at the start, m/s, world.
    #[serde(default)]
    pub velocity: [f64; 3],
    /// Time at which the spheres appear, s; the start of their stage if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub appears: Option<f64>,
}

/// A terrain: rolling ground as a height field, with ditches and boulders.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TerrainFile {
    /// Name, also the class of the ground.
    pub name: String,
    /// Name of the material.
    pub material: String,
    /// Position of the middle, m, world.
    #[serde(default)]
    pub position: [f64; 3],
    /// Lengths along x and y, m.
    pub size: [f64; 2],
    /// Spacing of the grid, m.
    pub spacing: f64,
    /// Maximum height of the waves over the mean, m.
    #[serde(default)]
    pub amplitude: f64,
    /// Wavelength of the longest waves, m.
    #[serde(default = "default_wavelength")]
    pub wavelength: f64,
    /// Radius of the flat part about the middle, m; the waves have their full height from twice this radius on.
    #[serde(default)]
    pub flat_radius: f64,
    /// Ditches.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub ditches: Vec<DitchFile>,
    /// Boulders, half sunk in the ground.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub boulders: Option<BouldersFile>,
}

/// A ditch of rounded section.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DitchFile {
    /// Start (x, y) of the centre line, m, from the terrain's middle.
    pub from: [f64; 2],
    /// End (x, y) of the centre line, m, from the terrain's middle.
    pub to: [f64; 2],
    /// Width, m.
    pub width: f64,
    /// Depth at the centre line, m.
    pub depth: f64,
}

/// Boulders: fixed ellipsoids at random places of a terrain.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BouldersFile {
    /// Number of boulders; fewer where there is no room for all.
    pub count: usize,
    /// Minimum and maximum radius, m; the half axes of a boulder are 0.75 to 1 times its radius.
    pub radius: [f64; 2],
    /// Name of the material; the terrain's if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
}

/// An assembly: a parametric machine, of exactly one of the kinds below.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AssemblyFile {
    /// Name, the prefix of the names of its bodies and joints: NAME_PART.
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
