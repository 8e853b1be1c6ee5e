//! Convex shapes against planes and against the triangles of meshes and height fields. All of these are solid behind their faces: a
//! shape that has passed through is pushed out in front again.

use super::convex::{self, Axis, Convex, Nearest, box_corner, nearest_in_triangle, support_local};
use super::manifold::{self, Feature, feature};
use super::point::{MAX_POINTS, Placed, Point, Points, swap_shapes};
use super::rolling::is_curved;
use crate::ShapeKind;
use crate::geometry::Surface;
use glam::DVec3;

/// The contact points of a convex shape with a plane: its corners, or the deepest points of its round parts. Returns their count.
pub fn convex_plane(a: &Placed, b: &Placed, reach: f64, out: &mut Points) -> usize {
    /// Sine of the tilt up to which an end stands on its corners alone: which point of its rim is the deepest is then round-off.
    const FLAT: f64 = 1e-4;
    let up = b.rotation.z_axis;
    let mut found: [(f64, DVec3, u32); 3 * MAX_POINTS] = [(0.0, DVec3::ZERO, 0); 3 * MAX_POINTS];
    let mut n = 0;
    let mut take = |p: DVec3, id: u32| {
        let gap = (p - b.position).dot(up);
        if gap <= reach && n < found.len() {
            found[n] = (gap, p, id);
            n += 1;
        }
    };
    let world = |p: DVec3| a.position + a.rotation * p;
    let down = a.local(-up);
    match a.kind {
        ShapeKind::Box => {
            for corner in 0..8u32 {
                take(world(box_corner(a.size, 7 - corner as usize)), corner);
            }
        }
        ShapeKind::Hull => {
            let vertices = a.hull.map_or(&[][..], |h| &h.vertices);
            let height = (a.position - b.position).dot(up);
            let gap = |k: usize| height - vertices[k].dot(down);
            let near = || (0..vertices.len()).filter(|k| gap(*k) <= reach);
            if near().count() > MAX_POINTS {
                spread(vertices, near, gap).into_iter().for_each(|k| take(world(vertices[k]), k as u32));
            } else {
                near().for_each(|k| take(world(vertices[k]), k as u32));
            }
        }
        ShapeKind::Cylinder | ShapeKind::Cone => {
            // The deepest point of each rim, and the corners of the end on which the shape may stand.
            let ends: &[f64] = if a.kind == ShapeKind::Cone { &[-a.size.z] } else { &[a.size.z, -a.size.z] };
            let across = down.truncate();
            let lowest = (across.length() > FLAT).then(|| across.normalize() * a.size.x);
            for (k, z) in ends.iter().enumerate() {
                lowest.iter().for_each(|p| take(world(p.extend(*z)), 60 + k as u32));
            }
            if a.kind == ShapeKind::Cone {
                take(world(DVec3::new(0.0, 0.0, a.size.z)), 62);
            }
            let end = feature(a, -up);
            if end.corners().len() > 2 {
                let is_off_lowest = |p: DVec3| {
                    let local = a.local(p - a.position);
                    lowest.is_none_or(|q| (local.truncate() - q).length() > 0.2 * a.size.x)
                };
                end.corners().iter().filter(|(p, _)| is_off_lowest(*p)).for_each(|(p, id)| take(*p, *id));
            }
        }
        ShapeKind::Capsule => {
            for (k, z) in [a.size.z, -a.size.z].into_iter().enumerate() {
                take(world(DVec3::new(0.0, 0.0, z)) - up * a.size.x, k as u32);
            }
        }
        _ => take(world(support_local(a, down).0) - up * Convex::radius(a), 0),
    }
    // The deepest points where there are more than a manifold has.
    let found = &mut found[..n];
    if n > MAX_POINTS {
        found.sort_by(|p, q| p.0.total_cmp(&q.0));
    }
    let kept = n.min(MAX_POINTS);
    for (slot, (gap, p, feature)) in out.iter_mut().zip(&found[..kept]) {
        *slot = Point { normal: -up, on_first: *p, on_second: *p - up * *gap, gap: *gap, feature: *feature };
    }
    kept
}

/// As many of the vertices that are `near` as a manifold has points, all around: the first, and then always the one that is farthest from those
/// before it; instead of the last the deepest, where that is deeper than all of them. Which ones does not depend on round-off of the pose.
fn spread<I: Iterator<Item = usize>>(
    vertices: &[DVec3],
    near: impl Fn() -> I,
    gap: impl Fn(usize) -> f64,
) -> [usize; MAX_POINTS] {
    /// What the deepest vertex is deeper by, over the distance of the first two.
    const DEEPER: f64 = 1e-5;
    let mut chosen = [near().next().unwrap_or(0); MAX_POINTS];
    for n in 1..MAX_POINTS {
        let away =
            |k: usize| chosen[..n].iter().map(|c| vertices[*c].distance_squared(vertices[k])).fold(f64::MAX, f64::min);
        let farther = |best: (f64, usize), k: usize| if away(k) > best.0 { (away(k), k) } else { best };
        chosen[n] = near().fold((0.0, chosen[0]), farther).1;
    }
    let deepest = near().fold(chosen[0], |best, k| if gap(k) < gap(best) { k } else { best });
    let least = chosen.iter().map(|k| gap(*k)).fold(f64::INFINITY, f64::min);
    if gap(deepest) < least - DEEPER * vertices[chosen[0]].distance(vertices[chosen[1]]) {
        chosen[MAX_POINTS - 1] = deepest;
    }
    chosen
}

/// Sine of the angle between a normal and that of a face from which on they differ, of round shapes.
const TILTED: f64 = 2e-3;

/// A triangle of a surface.
#[derive(Clone, Copy, Debug)]
pub struct Triangle {
    /// Corners, m, world.
    pub corners: [DVec3; 3],
    /// The bits of its convex edges and corners, as of [`Surface::sharp`].
    pub sharp: u8,
    /// Whether all that is below it is solid, as of a height field; else as far as a shape may come through it in a step.
    pub is_ground: bool,
}

impl Triangle {
    /// A triangle of a surface at a place.
    pub fn of(surface: &Surface, triangle: u32, place: &Placed) -> Triangle {
        Triangle {
            corners: surface.corners(triangle).map(|v| place.position + place.rotation * v),
            sharp: surface.sharp[triangle as usize],
            is_ground: surface.is_ground(),
        }
    }
}

/// The contact points of a convex shape with a triangle. Returns their count.
pub fn triangle(a: &Placed, triangle: &Triangle, reach: f64, out: &mut Points) -> usize {
    let Triangle { corners, sharp, .. } = *triangle;
    let Some(face) = (corners[1] - corners[0]).cross(corners[2] - corners[0]).try_normalize() else { return 0 };
    let Some(nearest) = nearest_to_face(a, triangle, face, reach) else { return 0 };
    let is_positive = |weights: (f64, f64, f64)| [weights.0, weights.1, weights.2].map(|w| w > 1e-9);
    let on = is_positive(nearest_in_triangle(nearest.on_second, corners));
    let is_convex = match on {
        [true, true, true] => true,
        [true, true, false] => sharp & 1 != 0,
        [false, true, true] => sharp & 2 != 0,
        [true, false, true] => sharp & 4 != 0,
        [true, false, false] => sharp & 8 != 0,
        [false, true, false] => sharp & 16 != 0,
        _ => sharp & 32 != 0,
    };
    let tilt = -nearest.normal.dot(face);
    if a.kind == ShapeKind::Sphere || a.kind == ShapeKind::Ellipsoid {
        if !is_convex && tilt < 1.0 - 1e-9 {
            return 0;
        }
        let Nearest { normal, on_first, on_second, gap } = nearest;
        out[0] = Point { normal, on_first, on_second, gap, feature: 0 };
        return 1;
    }
    // Inner edges that are not convex are no features: a contact on one is a contact on the face. What is round would feel the edge ahead of it
    // by any tilt.
    let is_along = if is_curved(a.kind) { nearest.normal.cross(face).length() <= TILTED } else { tilt > 0.99 };
    let normal = if is_convex || (is_along && tilt > 0.0) { nearest.normal } else { -face };
    let nearest = if normal == nearest.normal {
        nearest
    } else {
        let deepest = a.support(normal).0 + normal * Convex::radius(a);
        let gap = (deepest - corners[0]).dot(face);
        if gap > reach || is_beside(a, nearest.gap, gap) {
            return 0;
        }
        let (u, v, w) = nearest_in_triangle(deepest, corners);
        let on_second = corners[0] * u + corners[1] * v + corners[2] * w;
        if (on_second - (deepest + normal * gap)).length() > 1e-9 + 1e-6 * a.size.max_element() {
            // The deepest point is over another triangle.
            let n = manifold::clip(&Feature::triangle(corners), &feature(a, normal), -normal, reach, out);
            return swap_shapes(out, n);
        }
        Nearest { normal, on_first: deepest, on_second, gap }
    };
    let (fa, fb) = (feature(a, nearest.normal), Feature::triangle(corners));
    manifold::points(&fa, &fb, &nearest, reach, a.size.min_element(), out)
}

/// The nearest points of a shape and a triangle; for a shape that has passed through, those of the way back out of the face. What is beside a
/// face and behind it meets its neighbours alone.
fn nearest_to_face(a: &Placed, triangle: &Triangle, face: DVec3, reach: f64) -> Option<Nearest> {
    let corners = triangle.corners;
    if a.kind == ShapeKind::Sphere {
        return sphere_to_face(a, triangle, face, reach);
    }
    /// Gap over the shape's greatest half length up to which the direction of the nearest points may be round-off.
    const TRACE: f64 = 1e-6;
    let nearest = convex::nearest(a, &corners, reach, &mut Axis::default())?;
    if nearest.gap > 0.0 && nearest.normal.dot(face) < 0.0 {
        return Some(nearest);
    }
    let deepest = a.support(-face).0 - face * Convex::radius(a);
    let gap = (deepest - corners[0]).dot(face);
    let is_apart = match nearest.gap > TRACE * a.size.max_element() {
        true => !is_under(a, corners, face),
        false => is_beside(a, nearest.gap, gap),
    };
    (gap <= reach && !is_apart).then_some(Nearest {
        normal: -face,
        on_first: deepest,
        on_second: deepest - face * gap,
        gap,
    })
}

/// Whether the centre of a shape that is behind a face is right under it.
fn is_under(a: &Placed, corners: [DVec3; 3], face: DVec3) -> bool {
    let (u, v, w) = nearest_in_triangle(a.position, corners);
    let away = a.position - (corners[0] * u + corners[1] * v + corners[2] * w);
    away.dot(face) < 0.0 && (away - face * away.dot(face)).length() <= 1e-9 * a.size.max_element()
}

/// Whether a shape with its nearest points at a gap, whose deepest point has another over the plane of a face, is beside the face.
fn is_beside(a: &Placed, nearest: f64, gap: f64) -> bool {
    /// What the shortest way out may be of that through the face, and this of the shape's width.
    const SHORTER: f64 = 0.1;
    const DEEPER: f64 = 0.5;
    nearest > SHORTER * gap && -gap > DEEPER * a.size.min_element()
}

fn sphere_to_face(a: &Placed, triangle: &Triangle, face: DVec3, reach: f64) -> Option<Nearest> {
    let corners = triangle.corners;
    let (u, v, w) = nearest_in_triangle(a.position, corners);
    let on_second = corners[0] * u + corners[1] * v + corners[2] * w;
    let away = a.position - on_second;
    let distance = away.length();
    let height = (a.position - corners[0]).dot(face);
    let (normal, distance) = if height > 0.0 && distance > 1e-12 * a.size.x {
        (-away / distance, distance)
    } else if (away - face * height).length() <= 1e-9 * a.size.x && (triangle.is_ground || -height <= a.size.x + reach)
    {
        // The centre is behind the face, right under it.
        (-face, height)
    } else {
        return None;
    };
    let gap = distance - a.size.x;
    (gap <= reach).then(|| Nearest { normal, on_first: a.position + normal * a.size.x, on_second, gap })
}
