//! Axis-aligned bounding boxes (AABBs).

use glam::{DVec3, Vec3A};

/// An axis-aligned bounding box, m, world frame, rounded outwards to single precision so that all coordinates are compared in one
/// vector operation.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Aabb {
    /// Minimum corner, m.
    pub min: Vec3A,
    /// Maximum corner, m.
    pub max: Vec3A,
}

impl Aabb {
    /// The box about a centre with given half lengths, m, rounded outwards.
    #[inline]
    pub fn about(centre: DVec3, half: DVec3) -> Aabb {
        /// A bound of the relative rounding error of single precision.
        const ROUNDING: f32 = 1.2e-7;
        let (min, max) = ((centre - half).as_vec3a(), (centre + half).as_vec3a());
        Aabb { min: min - min.abs() * ROUNDING, max: max + max.abs() * ROUNDING }
    }

    /// The empty box, which overlaps no other.
    pub const EMPTY: Aabb = Aabb { min: Vec3A::INFINITY, max: Vec3A::NEG_INFINITY };

    /// Whether another box lies inside this one; the empty box always does.
    #[inline]
    pub fn contains(&self, other: &Aabb) -> bool {
        (self.min.cmple(other.min) & other.max.cmple(self.max)).all()
    }

    /// A gap that the contents of two boxes have at least, m; negative or zero where the boxes overlap or touch.
    #[inline]
    pub fn gap(&self, other: &Aabb) -> f32 {
        (self.min - other.max).max(other.min - self.max).max_element()
    }

    /// Whether two boxes overlap or touch.
    #[inline]
    pub fn overlaps(&self, other: &Aabb) -> bool {
        (self.min.cmple(other.max) & other.min.cmple(self.max)).all()
    }
}
