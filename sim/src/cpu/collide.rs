//! Where two shapes touch or nearly touch: up to eight points, with a normal from the first shape to the second.
//!
//! Boxes follow the separating axis theorem: the axis of least overlap is either a face's normal (then the other box's face
//! is clipped to it) or a cross product of edges (then the two edges' nearest points touch).

use crate::ShapeKind;
use glam::{DMat3, DQuat, DVec3};

/// The most points that two shapes touch in.
pub const MAX_POINTS: usize = 8;

/// A shape in its place.
#[derive(Clone, Copy, Debug)]
pub struct Placed {
    /// What it is.
    pub kind: ShapeKind,
    /// Its size, m.
    pub size: DVec3,
    /// Its centre, m, world.
    pub position: DVec3,
    /// Its orientation.
    pub orientation: DQuat,
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

/// Find the points of two shapes with a gap of at most `reach`; returns how many.
#[inline]
pub fn collide(a: &Placed, b: &Placed, reach: f64, out: &mut [Point; MAX_POINTS]) -> usize {
    use ShapeKind::*;
    match (a.kind, b.kind) {
        (Sphere, Sphere) => sphere_sphere(a, b, reach, out),
        (Sphere, Box) => sphere_box(a, b, reach, out),
        (Sphere, Plane) => sphere_plane(a, b, reach, out),
        (Box, Box) => box_box(a, b, reach, out),
        (Box, Plane) => box_plane(a, b, reach, out),
        (Plane, Plane) => 0,
        _ => {
            let n = collide(b, a, reach, out);
            for point in &mut out[..n] {
                point.normal = -point.normal;
                std::mem::swap(&mut point.on_first, &mut point.on_second);
            }
            n
        }
    }
}

#[inline]
fn sphere_sphere(a: &Placed, b: &Placed, reach: f64, out: &mut [Point; MAX_POINTS]) -> usize {
    let apart = b.position - a.position;
    let touch = a.size.x + b.size.x;
    let distance2 = apart.length_squared();
    if distance2 > (touch + reach) * (touch + reach) {
        return 0;
    }
    let distance = distance2.sqrt();
    let normal = if distance > 0.0 { apart / distance } else { DVec3::Z };
    out[0] = Point {
        normal,
        on_first: a.position + normal * a.size.x,
        on_second: b.position - normal * b.size.x,
        gap: distance - touch,
        feature: 0,
    };
    1
}

fn sphere_plane(a: &Placed, b: &Placed, reach: f64, out: &mut [Point; MAX_POINTS]) -> usize {
    let up = b.orientation * DVec3::Z;
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

fn sphere_box(a: &Placed, b: &Placed, reach: f64, out: &mut [Point; MAX_POINTS]) -> usize {
    let local = b.orientation.inverse() * (a.position - b.position);
    let nearest = local.clamp(-b.size, b.size);
    let apart = local - nearest;
    let distance2 = apart.length_squared();
    if distance2 > (a.size.x + reach) * (a.size.x + reach) {
        return 0;
    }
    let (outward, surface, distance) = if distance2 > 0.0 {
        let distance = distance2.sqrt();
        (apart / distance, nearest, distance)
    } else {
        // The centre is inside: out through the nearest face.
        let depth = b.size - local.abs();
        let axis = (0..3).min_by(|i, j| depth[*i].total_cmp(&depth[*j])).unwrap_or(0);
        let mut outward = DVec3::ZERO;
        outward[axis] = 1f64.copysign(local[axis]);
        let mut surface = local;
        surface[axis] = b.size[axis].copysign(local[axis]);
        (outward, surface, -depth[axis])
    };
    let normal = -(b.orientation * outward);
    out[0] = Point {
        normal,
        on_first: a.position + normal * a.size.x,
        on_second: b.position + b.orientation * surface,
        gap: distance - a.size.x,
        feature: 0,
    };
    1
}

fn box_plane(a: &Placed, b: &Placed, reach: f64, out: &mut [Point; MAX_POINTS]) -> usize {
    let up = b.orientation * DVec3::Z;
    let mut n = 0;
    for corner in 0..8u32 {
        let sign = DVec3::new(bit_sign(corner, 0), bit_sign(corner, 1), bit_sign(corner, 2));
        let p = a.position + a.orientation * (a.size * sign);
        let gap = (p - b.position).dot(up);
        if gap <= reach {
            out[n] = Point { normal: -up, on_first: p, on_second: p - up * gap, gap, feature: corner };
            n += 1;
        }
    }
    n
}

fn bit_sign(bits: u32, bit: u32) -> f64 {
    if bits >> bit & 1 == 1 { 1.0 } else { -1.0 }
}

/// How far two boxes are apart along a unit axis; negative in overlap.
fn separation(axis: DVec3, ra: &DMat3, a: &Placed, rb: &DMat3, b: &Placed) -> f64 {
    let reach_a = (ra.transpose() * axis).abs().dot(a.size);
    let reach_b = (rb.transpose() * axis).abs().dot(b.size);
    (b.position - a.position).dot(axis).abs() - reach_a - reach_b
}

fn box_box(a: &Placed, b: &Placed, reach: f64, out: &mut [Point; MAX_POINTS]) -> usize {
    let (ra, rb) = (DMat3::from_quat(a.orientation), DMat3::from_quat(b.orientation));
    let mut best_face = (f64::NEG_INFINITY, 0usize);
    for i in 0..6 {
        let axis = if i < 3 { ra.col(i) } else { rb.col(i - 3) };
        let s = separation(axis, &ra, a, &rb, b);
        if s > reach {
            return 0;
        }
        // A face of the first box is kept unless the second's is clearly better, so that the choice is stable.
        if s > best_face.0 + if i == 3 { 1e-9 } else { 0.0 } {
            best_face = (s, i);
        }
    }
    let mut best_edge = (f64::NEG_INFINITY, 0, 0, DVec3::ZERO);
    for i in 0..3 {
        for j in 0..3 {
            let cross = ra.col(i).cross(rb.col(j));
            if cross.length_squared() < 1e-8 {
                continue;
            }
            let axis = cross.normalize();
            let s = separation(axis, &ra, a, &rb, b);
            if s > reach {
                return 0;
            }
            if s > best_edge.0 {
                best_edge = (s, i, j, axis);
            }
        }
    }
    let size = a.size.min_element().min(b.size.min_element());
    if best_edge.0 > best_face.0 + 1e-3 * size {
        return edge_edge(a, &ra, b, &rb, best_edge, out);
    }
    if best_face.1 < 3 {
        face_clip(a, &ra, best_face.1, b, &rb, reach, out)
    } else {
        let n = face_clip(b, &rb, best_face.1 - 3, a, &ra, reach, out);
        for point in &mut out[..n] {
            point.normal = -point.normal;
            std::mem::swap(&mut point.on_first, &mut point.on_second);
            point.feature |= 1 << 16;
        }
        n
    }
}

fn edge_edge(
    a: &Placed,
    ra: &DMat3,
    b: &Placed,
    rb: &DMat3,
    (gap, i, j, axis): (f64, usize, usize, DVec3),
    out: &mut [Point; MAX_POINTS],
) -> usize {
    let normal = if axis.dot(b.position - a.position) < 0.0 { -axis } else { axis };
    // The middle of the edge of each box that is farthest towards the other.
    let support = |placed: &Placed, r: &DMat3, along: usize, towards: DVec3| {
        let local = r.transpose() * towards;
        let mut p = DVec3::ZERO;
        for k in (0..3).filter(|k| *k != along) {
            p[k] = placed.size[k].copysign(local[k]);
        }
        placed.position + *r * p
    };
    let (pa, pb) = (support(a, ra, i, normal), support(b, rb, j, -normal));
    let (da, db) = (ra.col(i), rb.col(j));
    // Nearest points of the two lines pa + s da and pb + t db.
    let (d, w) = (da.dot(db), pb - pa);
    let det = 1.0 - d * d;
    let s = (w.dot(da) - d * w.dot(db)) / det;
    let t = (d * w.dot(da) - w.dot(db)) / det;
    let on_first = pa + da * s.clamp(-a.size[i], a.size[i]);
    let on_second = pb + db * t.clamp(-b.size[j], b.size[j]);
    out[0] = Point { normal, on_first, on_second, gap, feature: 1 << 17 | (i * 3 + j) as u32 };
    1
}

/// Clip the face of `b` that looks most against face `axis` of `a` to that face's sides; keep what is within reach.
fn face_clip(
    a: &Placed,
    ra: &DMat3,
    axis: usize,
    b: &Placed,
    rb: &DMat3,
    reach: f64,
    out: &mut [Point; MAX_POINTS],
) -> usize {
    let apart = b.position - a.position;
    let normal = ra.col(axis) * 1f64.copysign(ra.col(axis).dot(apart));
    let against = rb.transpose() * normal;
    let face = (0..3).max_by(|i, j| against[*i].abs().total_cmp(&against[*j].abs())).unwrap_or(0);
    let (e1, e2) = ((face + 1) % 3, (face + 2) % 3);
    let mut center = DVec3::ZERO;
    center[face] = -b.size[face].copysign(against[face]);
    let center = b.position + *rb * center;
    let (u, v) = (rb.col(e1) * b.size[e1], rb.col(e2) * b.size[e2]);
    // A polygon of at most eight corners, each with the name of what made it.
    let mut polygon = [(DVec3::ZERO, 0u32); 12];
    let corners = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)];
    for (k, (s, t)) in corners.into_iter().enumerate() {
        polygon[k] = (center + u * s + v * t, k as u32 + 1);
    }
    let mut n = 4;
    for side in 0..4u32 {
        let across = if side < 2 { (axis + 1) % 3 } else { (axis + 2) % 3 };
        let outward = ra.col(across) * if side % 2 == 0 { 1.0 } else { -1.0 };
        let mut clipped = [(DVec3::ZERO, 0u32); 12];
        let mut m = 0;
        for k in 0..n {
            let (p, p_name) = polygon[k];
            let (q, q_name) = polygon[(k + 1) % n];
            let beyond = |x: DVec3| (x - a.position).dot(outward) - a.size[across];
            let (dp, dq) = (beyond(p), beyond(q));
            if dp <= 0.0 {
                clipped[m] = (p, p_name);
                m += 1;
            }
            if (dp <= 0.0) != (dq <= 0.0) {
                clipped[m] = (p + (q - p) * (dp / (dp - dq)), (p_name * 5 + q_name) * 8 + side + 1);
                m += 1;
            }
        }
        polygon = clipped;
        n = m;
    }
    let mut kept = 0;
    for (p, name) in &polygon[..n] {
        let gap = (*p - a.position).dot(normal) - a.size[axis];
        if gap <= reach && kept < MAX_POINTS {
            let feature = (axis as u32) << 12 ^ name.wrapping_mul(2_654_435_761) >> 18;
            out[kept] = Point { normal, on_first: *p - normal * gap, on_second: *p, gap, feature };
            kept += 1;
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube(position: DVec3, orientation: DQuat) -> Placed {
        Placed { kind: ShapeKind::Box, size: DVec3::splat(0.5), position, orientation }
    }

    #[test]
    fn a_cube_on_a_cube_rests_on_four_corners() {
        let mut out = [Point::default(); MAX_POINTS];
        let n = collide(
            &cube(DVec3::ZERO, DQuat::IDENTITY),
            &cube(DVec3::new(0.2, 0.1, 0.99), DQuat::IDENTITY),
            0.01,
            &mut out,
        );
        assert_eq!(n, 4);
        for p in &out[..n] {
            assert!((p.normal - DVec3::Z).length() < 1e-12 && (p.gap + 0.01).abs() < 1e-12);
        }
        let features: std::collections::HashSet<u32> = out[..n].iter().map(|p| p.feature).collect();
        assert_eq!(features.len(), 4);
    }

    #[test]
    fn crossed_edges_touch_in_one_point() {
        let lower = cube(DVec3::ZERO, DQuat::from_rotation_x(std::f64::consts::FRAC_PI_4));
        let upper = cube(DVec3::new(0.0, 0.0, 2f64.sqrt() - 0.01), DQuat::from_rotation_y(std::f64::consts::FRAC_PI_4));
        let mut out = [Point::default(); MAX_POINTS];
        assert_eq!(collide(&lower, &upper, 0.01, &mut out), 1);
        assert!((out[0].normal - DVec3::Z).length() < 1e-12 && (out[0].gap + 0.01).abs() < 1e-12);
        assert!(out[0].on_first.truncate().length() < 1e-9);
    }

    #[test]
    fn a_ball_meets_the_face_the_edge_and_the_inside_of_a_box() {
        let ball =
            |p| Placed { kind: ShapeKind::Sphere, size: DVec3::splat(0.1), position: p, orientation: DQuat::IDENTITY };
        let block = cube(DVec3::ZERO, DQuat::IDENTITY);
        let mut out = [Point::default(); MAX_POINTS];
        assert_eq!(collide(&ball(DVec3::new(0.0, 0.0, 0.59)), &block, 0.0, &mut out), 1);
        assert!((out[0].gap + 0.01).abs() < 1e-12 && (out[0].normal + DVec3::Z).length() < 1e-12);
        assert_eq!(collide(&block, &ball(DVec3::new(0.55, 0.0, 0.55)), 0.0, &mut out), 1);
        assert!((out[0].normal - DVec3::new(1.0, 0.0, 1.0).normalize()).length() < 1e-12);
        assert_eq!(collide(&ball(DVec3::new(0.0, 0.4, 0.0)), &block, 0.0, &mut out), 1);
        assert!((out[0].gap + 0.2).abs() < 1e-12 && (out[0].normal + DVec3::Y).length() < 1e-12);
        assert_eq!(collide(&ball(DVec3::new(0.0, 0.0, 0.7)), &block, 0.05, &mut out), 0);
    }
}
