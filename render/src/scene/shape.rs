//! Shapes: what a primitive is in its object space.

use crate::scene::patch::Patch;
use crate::scene::variables::VariableNames;
use glam::Vec3;
use std::sync::Arc;

/// A primitive in its object space.
#[derive(Clone, Debug)]
pub enum Shape {
    /// A whole sphere of radius 1; its size is in the transformation.
    Sphere,
    /// Bicubic patches, and the names of their variables.
    Patches(Arc<Vec<Patch>>, Arc<VariableNames>),
}

/// u and v of the specification's sphere in a direction of object space: u around, v from the south pole up (RISpec 5.2).
pub(crate) fn sphere_uv(d: Vec3) -> [f32; 2] {
    [(d.y.atan2(d.x) / std::f32::consts::TAU).rem_euclid(1.0), d.z.clamp(-1.0, 1.0).asin() / std::f32::consts::PI + 0.5]
}
