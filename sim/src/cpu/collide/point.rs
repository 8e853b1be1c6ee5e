//! Shapes in world coordinates, and contact points.

use crate::geometry::Hull;
use crate::model::Model;
use crate::pose::Pose;
use crate::shape::ShapeKind;
use glam::{DMat3, DQuat, DVec3};

/// Maximum number of points of a manifold.
pub const MAX_POINTS: usize = 8;

/// A shape in world coordinates.
#[derive(Clone, Copy, Debug)]
pub struct Placed<'a> {
    /// Kind.
    pub kind: ShapeKind,
    /// Size, m, as [`ShapeKind`] has it.
    pub size: DVec3,
    /// Position, m, world.
    pub position: DVec3,
    /// Orientation, as a quaternion and as a matrix.
    pub orientation: DQuat,
    pub rotation: DMat3,
    /// The greatest distance of a point of the shape from its position, m; infinite for a surface.
    pub extent: f64,
    /// Hull, where the kind is one.
    pub hull: Option<&'a Hull>,
}

impl<'a> Placed<'a> {
    /// A shape at a pose.
    #[inline(always)]
    pub fn new(kind: ShapeKind, size: DVec3, place: Pose, hull: Option<&'a Hull>) -> Placed<'a> {
        let Pose { position, orientation } = place;
        let rotation = DMat3::from_quat(orientation);
        Placed { kind, size, position, orientation, rotation, extent: extent(kind, size, hull), hull }
    }

    /// A shape of the model at a pose.
    #[inline(always)]
    pub fn of(model: &'a Model, place: Pose, shape: usize) -> Placed<'a> {
        let kind = model.shape_kind[shape];
        let hull = (kind == ShapeKind::Hull).then(|| &model.hulls[model.shape_part[shape] as usize]);
        Placed::new(kind, model.shape_size[shape], place, hull)
    }

    /// A direction or a vector of the world in the frame of the shape.
    #[inline(always)]
    pub fn local(&self, v: DVec3) -> DVec3 {
        DVec3::new(self.rotation.x_axis.dot(v), self.rotation.y_axis.dot(v), self.rotation.z_axis.dot(v))
    }
}

/// The axis along which a vector is longest; the last of several.
#[inline(always)]
pub fn longest_axis(v: DVec3) -> usize {
    let DVec3 { x, y, z } = v.abs();
    if z >= x.max(y) { 2 } else { (y >= x) as usize }
}

/// The greatest distance of a point of a shape from its position, m.
fn extent(kind: ShapeKind, size: DVec3, hull: Option<&Hull>) -> f64 {
    let DVec3 { x, z, .. } = size;
    match kind {
        ShapeKind::Sphere | ShapeKind::Ellipsoid => size.max_element(),
        ShapeKind::Box => size.length(),
        ShapeKind::Cylinder | ShapeKind::Cone => x.hypot(z),
        ShapeKind::Capsule => x + z,
        ShapeKind::Hull => hull.map_or(f64::INFINITY, |hull| hull.radius),
        ShapeKind::Plane | ShapeKind::Mesh | ShapeKind::HeightField => f64::INFINITY,
    }
}

/// A contact point.
#[derive(Clone, Copy, Debug, Default)]
pub struct Point {
    /// Unit normal from the first shape to the second, world.
    pub normal: DVec3,
    /// Point on the first shape, m, world.
    pub on_first: DVec3,
    /// Point on the second shape, m, world.
    pub on_second: DVec3,
    /// Gap, m; negative in overlap.
    pub gap: f64,
    /// Feature id, which identifies the point from step to step.
    pub feature: u32,
}

/// The points of a manifold.
pub type Points = [Point; MAX_POINTS];

/// Swap the two shapes of the first `n` points. Returns `n`.
pub fn swap_shapes(out: &mut Points, n: usize) -> usize {
    for p in &mut out[..n] {
        *p = Point { normal: -p.normal, on_first: p.on_second, on_second: p.on_first, ..*p };
    }
    n
}
