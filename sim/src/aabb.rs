//! Axis-aligned boxes.

use glam::{DVec3, Vec3A};

/// An axis-aligned box, m, world, rounded outwards to single precision: four numbers are compared at once.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Aabb {
    /// Least corner.
    pub min: Vec3A,
    /// Greatest corner.
    pub max: Vec3A,
}

impl Aabb {
    /// The box about a centre.
    #[inline]
    pub fn about(centre: DVec3, half: DVec3) -> Aabb {
        /// More than the rounding of a number to single precision.
        const ROUNDING: f32 = 1.2e-7;
        let (min, max) = ((centre - half).as_vec3a(), (centre + half).as_vec3a());
        Aabb { min: min - min.abs() * ROUNDING, max: max + max.abs() * ROUNDING }
    }

    /// A box that overlaps none.
    pub const EMPTY: Aabb = Aabb { min: Vec3A::INFINITY, max: Vec3A::NEG_INFINITY };

    /// Whether another box is inside; an empty one always is.
    #[inline]
    pub fn holds(&self, other: &Aabb) -> bool {
        (self.min.cmple(other.min) & other.max.cmple(self.max)).all()
    }

    /// Whether two boxes share a point.
    #[inline]
    pub fn overlaps(&self, other: &Aabb) -> bool {
        (self.min.cmple(other.max) & other.min.cmple(self.max)).all()
    }
}
