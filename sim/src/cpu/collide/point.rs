//! Shapes in their places, and the points where two of them touch.

use crate::geometry::Hull;
use crate::model::Model;
use crate::pose::Pose;
use crate::shape::ShapeKind;
use glam::{DQuat, DVec3};

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
pub fn turn(out: &mut Points, n: usize) -> usize {
    for p in &mut out[..n] {
        *p = Point { normal: -p.normal, on_first: p.on_second, on_second: p.on_first, ..*p };
    }
    n
}
