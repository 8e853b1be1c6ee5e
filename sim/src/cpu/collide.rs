//! Where two shapes touch or nearly touch: up to eight points, with a normal from the first shape to the second.
//!
//! Balls against simple shapes have closed forms (`round`), boxes follow the separating axis theorem (`boxes`), all other
//! convex shapes the Gilbert–Johnson–Keerthi distance with the expanding polytope for overlaps (`convex`). Flat contacts get
//! several points by clipping the two shapes' facing features (`manifold`). Planes and triangles are in `surface`.

mod boxes;
mod convex;
mod manifold;
mod round;
mod surface;

use crate::geometry::{Hull, Surface};
use crate::{Model, Pose, ShapeKind};
use glam::{DQuat, DVec3};

pub use round::balls as collide_balls;
pub use surface::triangle as collide_triangle;

/// The most points that two shapes touch in.
pub const MAX_POINTS: usize = 8;

/// A shape in its place.
#[derive(Clone, Copy, Debug)]
pub struct Placed<'a> {
    /// What it is.
    pub kind: ShapeKind,
    /// Its size, m.
    pub size: DVec3,
    /// Its centre, m, world.
    pub position: DVec3,
    /// Its orientation.
    pub orientation: DQuat,
    /// The hull, of a hull.
    pub hull: Option<&'a Hull>,
}

impl<'a> Placed<'a> {
    /// A shape of the model in its place.
    #[inline(always)]
    pub fn of(model: &'a Model, place: &Pose, shape: usize) -> Placed<'a> {
        let kind = model.shape_kind[shape];
        Placed {
            kind,
            size: model.shape_size[shape],
            position: place.position,
            orientation: place.orientation,
            hull: (kind == ShapeKind::Hull).then(|| &model.hulls[model.shape_part[shape] as usize]),
        }
    }
}

/// The triangles of a surface shape.
pub fn surface_of(model: &Model, shape: usize) -> Option<&Surface> {
    matches!(model.shape_kind[shape], ShapeKind::Mesh | ShapeKind::HeightField)
        .then(|| &model.surfaces[model.shape_part[shape] as usize])
}

/// A point where two shapes touch.
#[derive(Clone, Copy, Debug, Default)]
pub struct Point {
    /// Unit normal from the first shape to the second, world.
    pub normal: DVec3,
    /// The point on the first shape, m, world.
    pub on_first: DVec3,
    /// The point on the second shape, m, world.
    pub on_second: DVec3,
    /// Gap, m; negative in overlap.
    pub gap: f64,
    /// Names the point from step to step.
    pub feature: u32,
}

/// The points of a contact.
pub type Points = [Point; MAX_POINTS];

/// See the first `n` points from the second shape; returns `n`.
fn turn(out: &mut Points, n: usize) -> usize {
    for p in &mut out[..n] {
        *p = Point { normal: -p.normal, on_first: p.on_second, on_second: p.on_first, ..*p };
    }
    n
}

/// Find the points of two shapes, not meshes or height fields, with a gap of at most `reach`; returns how many.
#[inline]
pub fn collide(a: &Placed, b: &Placed, reach: f64, out: &mut Points) -> usize {
    use ShapeKind::*;
    match (a.kind, b.kind) {
        (Sphere, Sphere) => round::sphere_sphere(a, b, reach, out),
        (Sphere, Box) => round::sphere_box(a, b, reach, out),
        (Sphere, Plane) => round::sphere_plane(a, b, reach, out),
        (Sphere, Cylinder | Capsule | Cone) => round::sphere_turned(a, b, reach, out),
        (Box, Box) => boxes::box_box(a, b, reach, out),
        (Plane, Plane) => 0,
        (Plane, _) | (_, Sphere) => {
            let n = collide(b, a, reach, out);
            turn(out, n)
        }
        (_, Plane) => surface::convex_plane(a, b, reach, out),
        _ => manifold::convex_convex(a, b, reach, out),
    }
}

#[cfg(test)]
mod tests;
