//! Where contact points of curved shapes go as these turn: over the shape, while those of faces, edges and corners stay where they are.

use super::convex::support_local;
use super::manifold::{is_end, is_nearest};
use super::point::{Placed, longest_axis};
use crate::shape::ShapeKind;
use glam::DVec3;

/// Whether points of a shape may go over it.
pub fn is_curved(kind: ShapeKind) -> bool {
    use ShapeKind::*;
    matches!(kind, Sphere | Ellipsoid | Cylinder | Capsule | Cone)
}

/// The unit normal of the flat face of a shape that looks along a direction most, both of its frame; none of curved sides.
pub fn face_near(shape: &Placed, d: DVec3) -> Option<DVec3> {
    match shape.kind {
        ShapeKind::Box => {
            let axis = longest_axis(d);
            Some(DVec3::AXES[axis] * 1.0f64.copysign(d[axis]))
        }
        ShapeKind::Hull => Some(shape.hull?.normal_facing(d)),
        ShapeKind::Cylinder if is_end(shape.kind, d) => Some(DVec3::Z * 1.0f64.copysign(d.z)),
        ShapeKind::Cone if is_end(shape.kind, d) => Some(-DVec3::Z),
        _ => None,
    }
}

/// Whether a shape has a flat face across a direction of its frame.
pub fn has_face(shape: &Placed, d: DVec3) -> bool {
    /// Cosine of the angle between them.
    const ALONG: f64 = 1.0 - 1e-8;
    face_near(shape, d).is_some_and(|face| face.dot(d) >= ALONG)
}

/// What is kept of a point on a shape, in its frame, m, whose outward normal is `d`: of a capsule the point on its axis.
pub fn held(shape: &Placed, point: DVec3, d: DVec3) -> DVec3 {
    if shape.kind == ShapeKind::Capsule { point - d * shape.size.x } else { point }
}

/// Where a point that was [`held`] is on its shape, in its frame, m, now that `d` is the outward normal there; `None` where it is fixed to the shape.
pub fn rolled(shape: &Placed, held: DVec3, d: DVec3, feature: u32) -> Option<DVec3> {
    match shape.kind {
        ShapeKind::Ellipsoid => Some(support_local(shape, d).0),
        ShapeKind::Capsule => Some(held + d * shape.size.x),
        ShapeKind::Cylinder | ShapeKind::Cone if is_nearest(feature) || !is_end(shape.kind, d) => {
            let (out, radius) = (d.truncate(), held.truncate().length());
            (out.length() > f64::EPSILON).then(|| (out * (radius / out.length())).extend(held.z))
        }
        _ => None,
    }
}
