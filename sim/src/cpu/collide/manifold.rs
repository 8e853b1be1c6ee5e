//! Contact manifolds: the faces, edges or corners by which two convex shapes meet are clipped against each other.

use super::convex::{Nearest, support_local};
use super::point::{MAX_POINTS, Placed, Point, Points, longest_axis, swap_shapes};
use crate::ShapeKind;
use crate::geometry::Hull;
use glam::DVec3;

/// Maximum number of corners of a feature: of two that are clipped.
const MAX_CORNERS: usize = 2 * Hull::MOST_CORNERS;

/// Number of corners of the polygon in place of the flat end of a cylinder or a cone.
const RIM: usize = 8;

/// Where these corners are, over the radius.
const CORNERS: [[f64; 2]; RIM] =
    [[1.0, 0.0], [HALF, HALF], [0.0, 1.0], [-HALF, HALF], [-1.0, 0.0], [-HALF, -HALF], [0.0, -1.0], [HALF, -HALF]];
const HALF: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// Bit of the feature ids of points whose reference feature was the second shape's.
pub const OF_SECOND: u32 = 1 << 15;

/// Bit of the feature ids of the nearest points of two shapes, which are of no corner.
const NEAREST: u32 = 1 << 16;

/// Whether a point is the nearest of two shapes, by its feature id, and no corner of a feature.
pub fn is_nearest(feature: u32) -> bool {
    feature & NEAREST != 0
}

/// Whether what faces a direction, unit, of the frame of a cylinder or a cone is its flat end.
pub fn is_end(kind: ShapeKind, d: DVec3) -> bool {
    /// Cosine of the angle between them.
    const ALONG: f64 = 0.7;
    (if kind == ShapeKind::Cylinder { d.z.abs() } else { -d.z }) > ALONG
}

/// A feature of a shape: a face (three corners and more, in order), an edge (two) or a corner (one) in the world, each corner with its
/// id.
#[derive(Clone, Copy, Debug)]
pub struct Feature {
    corner: [(DVec3, u32); MAX_CORNERS],
    n: usize,
}

impl Feature {
    fn new() -> Feature {
        Feature { corner: [(DVec3::ZERO, 0); MAX_CORNERS], n: 0 }
    }

    fn push(&mut self, p: DVec3, id: u32) {
        if self.n < MAX_CORNERS {
            self.corner[self.n] = (p, id);
            self.n += 1;
        }
    }

    /// The corners with their ids.
    pub fn corners(&self) -> &[(DVec3, u32)] {
        &self.corner[..self.n]
    }

    /// The face of a triangle.
    pub fn triangle(corners: [DVec3; 3]) -> Feature {
        let mut f = Feature::new();
        corners.into_iter().enumerate().for_each(|(k, p)| f.push(p, k as u32 + 1));
        f
    }

    /// Unit normal of a face.
    fn normal(&self) -> DVec3 {
        let c = self.corners();
        let around = (1..c.len() - 1).map(|k| (c[k].0 - c[0].0).cross(c[k + 1].0 - c[0].0));
        around.sum::<DVec3>().normalize_or_zero()
    }
}

/// The feature of a shape that faces a direction, world, with the radius around the shape's core.
pub fn feature(shape: &Placed, direction: DVec3) -> Feature {
    let d = shape.local(direction);
    let size = shape.size;
    let mut f = Feature::new();
    let mut local = |p: DVec3, id: u32| f.push(shape.position + shape.rotation * p, id);
    let rim = |k: usize, z: f64| {
        let [x, y] = CORNERS[k];
        DVec3::new(size.x * x, size.x * y, z)
    };
    match shape.kind {
        ShapeKind::Box => {
            let axis = longest_axis(d);
            for (k, (s, t)) in [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)].into_iter().enumerate() {
                let mut p = DVec3::ZERO;
                p[axis] = size[axis].copysign(d[axis]);
                p[(axis + 1) % 3] = s * size[(axis + 1) % 3];
                p[(axis + 2) % 3] = t * size[(axis + 2) % 3];
                let side = if d[axis] < 0.0 { 4 } else { 0 };
                local(p, (8 * axis + side + k + 1) as u32);
            }
        }
        ShapeKind::Hull => {
            if let Some(hull) = shape.hull {
                Hull::corners_of(hull.facing(d)).for_each(|v| local(hull.vertices[v as usize], v + 1));
            }
        }
        ShapeKind::Cylinder if is_end(shape.kind, d.normalize_or_zero()) => {
            let side = if d.z < 0.0 { RIM } else { 0 };
            (0..RIM).for_each(|k| local(rim(k, size.z.copysign(d.z)), (side + k + 1) as u32));
        }
        ShapeKind::Cylinder => {
            let out = d.truncate().normalize_or_zero() * size.x;
            local(out.extend(size.z), 41);
            local(out.extend(-size.z), 42);
        }
        ShapeKind::Cone if is_end(shape.kind, d.normalize_or_zero()) => {
            (0..RIM).for_each(|k| local(rim(k, -size.z), k as u32 + 1))
        }
        ShapeKind::Cone => {
            let across = d.truncate().normalize_or_zero();
            let side = (across * 2.0 * size.z).extend(size.x).normalize();
            if side.dot(d) > 0.95 * d.length() {
                local(DVec3::new(0.0, 0.0, size.z), 41);
                local((across * size.x).extend(-size.z), 42);
            } else {
                local(support_local(shape, d).0, 43);
            }
        }
        ShapeKind::Capsule if d.z.abs() < 0.7 * d.length() => {
            let out = d * (size.x / d.length());
            local(DVec3::new(0.0, 0.0, size.z) + out, 41);
            local(DVec3::new(0.0, 0.0, -size.z) + out, 42);
        }
        _ => {
            let round = if matches!(shape.kind, ShapeKind::Sphere | ShapeKind::Capsule) { size.x } else { 0.0 };
            local(support_local(shape, d).0 + d.normalize_or_zero() * round, 43);
        }
    }
    f
}

/// The manifold of two features with given nearest points: the corners of the clipped features within `reach`, m, and the nearest
/// point where none of them is as near. Returns the number of points.
pub fn points(fa: &Feature, fb: &Feature, nearest: &Nearest, reach: f64, size: f64, out: &mut Points) -> usize {
    /// What the points of parallel edges may lie beside each other by, over the size.
    const BESIDE: f64 = 1e-2;
    let n = nearest.normal;
    // The reference is the face whose own normal is closest to the contact's.
    let facing = |f: &Feature| if f.n >= 3 { f.normal().dot(n).abs() } else { 0.0 };
    let (of_a, of_b) = (facing(fa), facing(fb));
    let mut kept = 0;
    if of_a.max(of_b) > 0.5 {
        if of_a >= of_b - 1e-6 {
            kept = clip(fa, fb, n, reach, out);
        } else {
            kept = clip(fb, fa, -n, reach, out);
            swap_shapes(out, kept);
            out[..kept].iter_mut().for_each(|p| p.feature |= OF_SECOND);
        }
    } else if fa.n == 2 && fb.n == 2 {
        kept = clip(fa, fb, n, reach, out);
        // Edges that cross touch at their nearest points alone.
        let [p, q] = [fa.corner[0].0, fa.corner[1].0];
        let across = (q - p).cross(n).normalize_or_zero();
        if out[..kept].iter().any(|point| (point.on_second - p).dot(across).abs() > BESIDE * size) {
            kept = 0;
        }
    }
    with_nearest(nearest, size, kept, out)
}

/// The nearest points of two shapes are put after `kept` others where none of these is as near. Returns the number of points.
pub fn with_nearest(nearest: &Nearest, size: f64, mut kept: usize, out: &mut Points) -> usize {
    /// What the nearest point may be nearer than all others by, over the size.
    const NEAR: f64 = 1e-5;
    let min_gap = out[..kept].iter().map(|p| p.gap).fold(f64::INFINITY, f64::min);
    if min_gap > nearest.gap + NEAR * size {
        let place = if kept < MAX_POINTS { kept } else { MAX_POINTS - 1 };
        let Nearest { normal, on_first, on_second, gap } = *nearest;
        out[place] = Point { normal, on_first, on_second, gap, feature: NEAREST };
        kept = place + 1;
    }
    kept
}

/// Id of the corner where a side, counted from 1, cuts the edge between two corners: a hash, which may overflow.
pub fn cut_id(from: u32, to: u32, side: u32) -> u32 {
    from.wrapping_mul(53).wrapping_add(to).wrapping_mul(17).wrapping_add(side)
}

/// Feature id of a corner of a clipped feature.
pub fn feature_id(corner: u32) -> u32 {
    corner.wrapping_mul(2_654_435_761) >> 18
}

/// Clip `other` against the sides of `reference` (a face, or an edge by its two ends) and keep the corners within `reach`, m, of it
/// along the normal, which points from the reference to the other. Returns the number of points.
pub fn clip(reference: &Feature, other: &Feature, normal: DVec3, reach: f64, out: &mut Points) -> usize {
    /// What an end of a segment may be beyond a side by, over the side.
    const ALONG: f64 = 1e-6;
    let r = reference.corners();
    // Clipped from one to the other and back.
    let (mut one, mut two) = (*other, Feature::new());
    let (mut f, mut clipped) = (&mut one, &mut two);
    let face = if r.len() >= 3 { reference.normal() } else { normal };
    let face = if face.dot(normal) < 0.0 { -face } else { face };
    let middle = r.iter().map(|c| c.0).sum::<DVec3>() / r.len() as f64;
    for k in 0..r.len() {
        let (p, q) = (r[k].0, r[(k + 1) % r.len()].0);
        let outward = if r.len() == 2 {
            p - q
        } else {
            let side = (q - p).cross(normal);
            if side.dot(middle - p) > 0.0 { -side } else { side }
        };
        // Two points of a segment are an open path, a face's are closed. A segment along a side is not cut by round-off.
        let closed = f.n > 2;
        let beyond = if closed { 0.0 } else { ALONG * outward.length() * (q - p).length() };
        clipped.n = 0;
        for i in 0..f.n {
            let (u, u_id) = f.corner[i];
            let du = (u - p).dot(outward);
            if du <= beyond {
                clipped.push(u, u_id);
            }
            if i + 1 == f.n && !closed {
                break;
            }
            let (v, v_id) = f.corner[(i + 1) % f.n];
            let dv = (v - p).dot(outward);
            if (du <= beyond) != (dv <= beyond) {
                clipped.push(u + (v - u) * (du / (du - dv)), cut_id(u_id, v_id, k as u32 + 1));
            }
        }
        std::mem::swap(&mut f, &mut clipped);
    }
    let tilt = face.dot(normal);
    let gap = |p: DVec3| (p - r[0].0).dot(face) / tilt;
    let mut near = [0usize; MAX_CORNERS];
    let mut n = 0;
    for i in (0..f.n).filter(|i| gap(f.corner[*i].0) <= reach) {
        near[n] = i;
        n += 1;
    }
    let kept = n.min(MAX_POINTS);
    for k in 0..kept {
        let (p, id) = f.corner[near[k * n / kept]];
        let gap = gap(p);
        out[k] = Point { normal, on_first: p - normal * gap, on_second: p, gap, feature: feature_id(id) };
    }
    kept
}
