//! The narrow phase of a pair of shapes: up to eight contact points, with normals from the first shape to the second.
//!
//! Spheres against simple shapes have closed forms (`round`), boxes use the separating axis theorem (`boxes`), all other convex
//! shapes the Gilbert–Johnson–Keerthi distance with the expanding polytope algorithm for overlaps (`convex`). The manifold of a flat
//! contact has several points, from clipping the two shapes' facing features (`manifold`). Planes and triangles are in `surface`.

mod boxes;
pub mod convex;
pub mod manifold;
mod passing;
pub mod point;
pub mod rolling;
mod round;
mod sides;
mod solids;
mod surface;

use crate::geometry::Surface;
use crate::model::Model;
use crate::shape::ShapeKind;
use convex::Axis;
use point::{Placed, Points, swap_shapes};

pub use passing::{Way, pass};
pub use round::spheres as collide_spheres;
pub use surface::{Triangle, triangle as collide_triangle};

/// The mesh or height field of a shape; none for other kinds.
pub fn surface_of(model: &Model, shape: usize) -> Option<&Surface> {
    matches!(model.shape_kind[shape], ShapeKind::Mesh | ShapeKind::HeightField)
        .then(|| &model.surfaces[model.shape_part[shape] as usize])
}

/// Find the contact points of two shapes, neither a mesh nor a height field, with a gap of at most `reach`, m. Returns their count.
#[inline]
pub fn collide(a: &Placed, b: &Placed, reach: f64, out: &mut Points) -> usize {
    collide_along(a, b, reach, &mut Axis::default(), out)
}

/// Find contact points as [`collide`] does. The search of two convex shapes of which neither is a sphere nor a plane may begin along `axis`,
/// if it is known; they leave there the axis along which they are farthest apart, or one along which their gap is above `reach`.
pub fn collide_along(a: &Placed, b: &Placed, reach: f64, axis: &mut Axis, out: &mut Points) -> usize {
    use ShapeKind::*;
    match (a.kind, b.kind) {
        (Sphere, Sphere) => round::sphere_sphere(a, b, reach, out),
        (Sphere, Box) => round::sphere_box(a, b, reach, out),
        (Sphere, Plane) => round::sphere_plane(a, b, reach, out),
        (Sphere, Cylinder | Capsule | Cone) => round::sphere_turned(a, b, reach, out),
        (Box, Box) => boxes::box_box(a, b, reach, axis, out),
        (Plane, Plane) => 0,
        (Plane, _) | (_, Sphere) => {
            let n = collide(b, a, reach, out);
            swap_shapes(out, n)
        }
        (_, Plane) => surface::convex_plane(a, b, reach, out),
        _ => solids::convex_convex(a, b, reach, axis, out),
    }
}

#[cfg(test)]
mod tests;
