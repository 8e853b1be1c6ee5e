//! A sphere against another sphere, a box, a plane, and the solids of revolution: closed forms.

use super::point::{Placed, Point, Points};
use crate::ShapeKind;
use glam::{DVec2, DVec3};

#[inline]
pub fn sphere_sphere(a: &Placed, b: &Placed, reach: f64, out: &mut Points) -> usize {
    let touch = a.size.x + b.size.x + reach;
    if (b.position - a.position).length_squared() > touch * touch {
        return 0;
    }
    out[0] = spheres((a.position, a.size.x), (b.position, b.size.x));
    1
}

/// The contact point of two spheres by their centres and radii, at any distance.
#[inline(always)]
pub fn spheres((a, radius_a): (DVec3, f64), (b, radius_b): (DVec3, f64)) -> Point {
    let offset = b - a;
    let distance = offset.length();
    let normal = if distance > 0.0 { offset / distance } else { DVec3::Z };
    Point {
        normal,
        on_first: a + normal * radius_a,
        on_second: b - normal * radius_b,
        gap: distance - (radius_a + radius_b),
        feature: 0,
    }
}

#[inline]
pub fn sphere_plane(a: &Placed, b: &Placed, reach: f64, out: &mut Points) -> usize {
    let up = b.rotation.z_axis;
    let height = (a.position - b.position).dot(up);
    let gap = height - a.size.x;
    if gap > reach {
        return 0;
    }
    out[0] = Point {
        normal: -up,
        on_first: a.position - up * a.size.x,
        on_second: a.position - up * height,
        gap,
        feature: 0,
    };
    1
}

/// The contact of a sphere with a solid whose nearest surface point, outward normal there and signed distance are known, local.
#[inline]
fn touch(
    a: &Placed,
    b: &Placed,
    (surface, outward, distance): (DVec3, DVec3, f64),
    reach: f64,
    out: &mut Points,
) -> usize {
    if distance > a.size.x + reach {
        return 0;
    }
    let normal = -(b.rotation * outward);
    out[0] = Point {
        normal,
        on_first: a.position + normal * a.size.x,
        on_second: b.position + b.rotation * surface,
        gap: distance - a.size.x,
        feature: 0,
    };
    1
}

pub fn sphere_box(a: &Placed, b: &Placed, reach: f64, out: &mut Points) -> usize {
    let local = b.local(a.position - b.position);
    let nearest = local.clamp(-b.size, b.size);
    let offset = local - nearest;
    let distance2 = offset.length_squared();
    let found = if distance2 > 0.0 {
        let distance = distance2.sqrt();
        (nearest, offset / distance, distance)
    } else {
        // The centre is inside: out through the nearest face.
        let depth = b.size - local.abs();
        let axis = (0..3).min_by(|i, j| depth[*i].total_cmp(&depth[*j])).unwrap_or(0);
        let mut outward = DVec3::ZERO;
        outward[axis] = 1f64.copysign(local[axis]);
        let mut surface = local;
        surface[axis] = b.size[axis].copysign(local[axis]);
        (surface, outward, -depth[axis])
    };
    touch(a, b, found, reach, out)
}

/// A sphere against a cylinder, a capsule or a cone: a problem in the half plane (distance from the axis, height).
pub fn sphere_turned(a: &Placed, b: &Placed, reach: f64, out: &mut Points) -> usize {
    let local = b.local(a.position - b.position);
    let radial = local.truncate().length();
    let around = if radial > 0.0 { local.truncate() / radial } else { DVec2::X };
    let p = DVec2::new(radial, local.z);
    let (r, h) = (b.size.x, b.size.z);
    let (surface, outward, distance) = match b.kind {
        ShapeKind::Capsule => {
            let core = DVec2::new(0.0, p.y.clamp(-h, h));
            let offset = p - core;
            let length = offset.length();
            let outward = if length > 0.0 { offset / length } else { DVec2::X };
            (core + outward * r, outward, length - r)
        }
        ShapeKind::Cone => nearest_outline(p, &[DVec2::new(0.0, -h), DVec2::new(r, -h), DVec2::new(0.0, h)]),
        _ => nearest_outline(p, &[DVec2::new(0.0, -h), DVec2::new(r, -h), DVec2::new(r, h), DVec2::new(0.0, h)]),
    };
    let spatial = |v: DVec2| (around * v.x).extend(v.y);
    touch(a, b, (spatial(surface), spatial(outward), distance), reach, out)
}

/// The nearest point of a convex outline that starts and ends on the axis, the normal there, and the distance, negative inside.
fn nearest_outline(p: DVec2, outline: &[DVec2]) -> (DVec2, DVec2, f64) {
    let mut best = (DVec2::ZERO, DVec2::X, f64::INFINITY);
    let mut inside = true;
    for pair in outline.windows(2) {
        let along = pair[1] - pair[0];
        let normal = DVec2::new(along.y, -along.x).normalize();
        inside &= (p - pair[0]).dot(normal) < 0.0;
        let t = ((p - pair[0]).dot(along) / along.length_squared()).clamp(0.0, 1.0);
        let nearest = pair[0] + along * t;
        let distance = (p - nearest).length();
        if distance < best.2 {
            best = (nearest, normal, distance);
        }
    }
    if inside {
        return (best.0, best.1, -best.2);
    }
    let outward = if best.2 > 0.0 { (p - best.0) / best.2 } else { best.1 };
    (best.0, outward, best.2)
}
