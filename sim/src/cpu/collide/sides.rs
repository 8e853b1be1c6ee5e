//! The contact points of two cylinders or capsules that meet side by side: at both ends of where they lie along each other, each with the
//! gap and the normal that it has there, however they are turned against each other.

use super::convex::{self, Axis, Nearest};
use super::manifold::{Feature, clip};
use super::point::{Placed, Point, Points};
use crate::shape::ShapeKind;
use glam::DVec3;

/// The nearest points where a cylinder meets another shape with its side, or `None` of them if the gap is above `reach`, m, with the axis
/// as [`convex::nearest`] has it; `None` where it may meet it otherwise. The cylinder is a capsule there, whose distance, that of its axis, has no curved
/// outline to search.
pub fn side_by_side(a: &Placed, b: &Placed, reach: f64, axis: &mut Axis) -> Option<Option<Nearest>> {
    /// Cosine between the axis of a cylinder and the direction to what it meets with its side; and of one worth a trial.
    const ASIDE: [f64; 2] = [1e-4, 0.1];
    /// What an overlap may be less by elsewhere, over the least size: the search for it has an error.
    const LESS: f64 = 1e-6;
    let is_cylinder = |shape: &Placed| shape.kind == ShapeKind::Cylinder;
    let along = |direction: DVec3, shape: &Placed| if is_cylinder(shape) { shape.local(direction).z } else { 0.0 };
    let is_aside = |direction: DVec3, most: f64| along(direction, a).abs().max(along(direction, b).abs()) <= most;
    if !is_cylinder(a) && !is_cylinder(b) || !is_aside(axis.direction, ASIDE[1]) {
        return None;
    }
    // The capsule of a cylinder's radius and length has its round ends beyond the cylinder's.
    let [of_a, of_b] =
        [a, b].map(|shape| if is_cylinder(shape) { Placed { kind: ShapeKind::Capsule, ..*shape } } else { *shape });
    let mut own = *axis;
    let Some(nearest) = convex::nearest(&of_a, &of_b, reach, &mut own) else {
        // The capsules are around the cylinders.
        *axis = Axis { apart: convex::separation(a, b, own.direction), ..own };
        return Some(None);
    };
    if !is_aside(nearest.normal, ASIDE[0]) {
        return None;
    }
    // Along the normal a cylinder that leans reaches less far than the capsule.
    let gap = nearest.gap.max(convex::separation(a, b, nearest.normal));
    // An overlap may be less along an axis or a direction in between.
    if gap < 0.0 {
        let elsewhere = convex::nearest(a, b, reach, axis);
        let least = gap + LESS * a.size.min_element().min(b.size.min_element());
        if elsewhere.is_some_and(|elsewhere| elsewhere.gap > least) {
            return Some(elsewhere);
        }
    }
    *axis = Axis { apart: gap, ..own };
    Some((gap <= reach).then_some(Nearest { gap, ..nearest }))
}

/// How far along the axis of a shape a point is, m, and its way from there across the axis; for a capsule the way from the nearest point of the axis.
fn from_axis(shape: &Placed, point: DVec3) -> (f64, DVec3) {
    let (along, offset) = (shape.rotation.z_axis, point - shape.position);
    let at = along.dot(offset);
    let foot = if shape.kind == ShapeKind::Capsule { at.clamp(-shape.size.z, shape.size.z) } else { at };
    (at, offset - along * foot)
}

/// The points with a gap of at most `reach`, m, of two shapes with given features and nearest points; `None` where they do not meet side by side.
/// Returns their count.
pub fn side_points(
    [a, b]: [&Placed; 2],
    [of_a, of_b]: [&Feature; 2],
    nearest: &Nearest,
    reach: f64,
    out: &mut Points,
) -> Option<usize> {
    /// Cosine between the normal of a point and that of the nearest ones, at least: axes that cross have no other points.
    const TOWARDS: f64 = 0.5;
    /// How far beyond the end of a cylinder a point may be that is taken for one beside it, over its radius.
    const BEYOND: f64 = 1e-2;
    let is_side = |shape: &Placed, feature: &Feature| {
        matches!(shape.kind, ShapeKind::Cylinder | ShapeKind::Capsule) && feature.corners().len() == 2
    };
    if !is_side(a, of_a) || !is_side(b, of_b) {
        return None;
    }
    let (along, radius) = (b.rotation.z_axis, b.size.x);
    let mut kept = 0;
    for k in 0..clip(of_a, of_b, nearest.normal, f64::INFINITY, out) {
        let Point { on_second, feature, .. } = out[k];
        let on_axis = b.position + along * along.dot(on_second - b.position).clamp(-b.size.z, b.size.z);
        let (_, mut out_of) = from_axis(a, on_axis);
        if b.kind == ShapeKind::Cylinder {
            // Across the axis a cylinder reaches as far, along it no farther than its end.
            out_of -= along * along.dot(out_of);
        }
        let on_second = on_axis - out_of.normalize_or_zero() * radius;
        let (at, offset) = from_axis(a, on_second);
        let (normal, gap) = (offset.normalize_or_zero(), offset.length() - a.size.x);
        let is_beyond = a.kind == ShapeKind::Cylinder && at.abs() > a.size.z + BEYOND * a.size.x;
        if gap <= reach && normal.dot(nearest.normal) > TOWARDS && !is_beyond {
            out[kept] = Point { normal, on_first: on_second - normal * gap, on_second, gap, feature };
            kept += 1;
        }
    }
    Some(kept)
}
