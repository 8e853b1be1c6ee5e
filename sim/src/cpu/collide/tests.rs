//! Manifolds whose points are known on paper.

use super::point::{MAX_POINTS, Point};
use super::*;
use crate::fill::SplitMix64;
use crate::geometry::{Hull, Surface};
use crate::manifolds::Corners;
use crate::pose::Pose;
use glam::{DQuat, DVec2, DVec3};
use std::f64::consts::TAU;

fn cube(position: DVec3, orientation: DQuat) -> Placed<'static> {
    placed(ShapeKind::Box, [0.5; 3], position, orientation)
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
fn a_sphere_meets_the_face_the_edge_and_the_inside_of_a_box() {
    let sphere = |p| placed(ShapeKind::Sphere, [0.1; 3], p, DQuat::IDENTITY);
    let block = cube(DVec3::ZERO, DQuat::IDENTITY);
    let mut out = [Point::default(); MAX_POINTS];
    assert_eq!(collide(&sphere(DVec3::new(0.0, 0.0, 0.59)), &block, 0.0, &mut out), 1);
    assert!((out[0].gap + 0.01).abs() < 1e-12 && (out[0].normal + DVec3::Z).length() < 1e-12);
    assert_eq!(collide(&block, &sphere(DVec3::new(0.55, 0.0, 0.55)), 0.0, &mut out), 1);
    assert!((out[0].normal - DVec3::new(1.0, 0.0, 1.0).normalize()).length() < 1e-12);
    assert_eq!(collide(&sphere(DVec3::new(0.0, 0.4, 0.0)), &block, 0.0, &mut out), 1);
    assert!((out[0].gap + 0.2).abs() < 1e-12 && (out[0].normal + DVec3::Y).length() < 1e-12);
    assert_eq!(collide(&sphere(DVec3::new(0.0, 0.0, 0.7)), &block, 0.05, &mut out), 0);
}

fn placed(kind: ShapeKind, size: [f64; 3], position: DVec3, orientation: DQuat) -> Placed<'static> {
    Placed::new(kind, size.into(), Pose { position, orientation }, None)
}

fn points(a: &Placed, b: &Placed, reach: f64) -> Vec<Point> {
    let mut out = [Point::default(); MAX_POINTS];
    let n = collide(a, b, reach, &mut out);
    out[..n].to_vec()
}

const UP: DQuat = DQuat::IDENTITY;

#[test]
fn the_general_distance_agrees_with_closed_forms() {
    // A sphere as an ellipsoid of equal axes meets every shape as the sphere does.
    let mut random = crate::SplitMix64(9);
    let mut met = 0;
    for k in 0..4000 {
        let (kind, size) = [
            (ShapeKind::Box, [0.3, 0.2, 0.4]),
            (ShapeKind::Cylinder, [0.3, 0.3, 0.4]),
            (ShapeKind::Capsule, [0.2, 0.2, 0.3]),
            (ShapeKind::Cone, [0.3, 0.3, 0.4]),
        ][k % 4];
        let orientation = random.rotation();
        let b = placed(kind, size, DVec3::ZERO, orientation);
        let way = random.rotation() * DVec3::Z;
        let at = way * random.between(0.25, 0.8);
        let sphere = placed(ShapeKind::Sphere, [0.1; 3], at, UP);
        let round = placed(ShapeKind::Ellipsoid, [0.1; 3], at, orientation);
        let (exact, general) = (points(&sphere, &b, 0.1), points(&round, &b, 0.1));
        assert_eq!(exact.is_empty(), general.is_empty(), "{kind:?} {at}");
        if let (Some(e), Some(g)) = (exact.first(), general.first()) {
            // Deep inside, the nearest way out may be found through another face.
            if e.gap > -0.1 {
                // Smooth shapes are approached by planes: the deeper, the coarser.
                let allowed = 5e-6 + 2e-3 * -e.gap.min(0.0);
                assert!((e.gap - g.gap).abs() < allowed, "{kind:?}: {} {}", e.gap, g.gap);
                assert!((e.normal - g.normal).length() < 0.05, "{kind:?}: {} {}", e.normal, g.normal);
                met += 1;
            }
        }
    }
    assert!(met > 1000, "{met}");
}

/// A triangle of a mesh.
fn part(corners: [DVec3; 3], sharp: u8) -> Triangle {
    Triangle { corners, sharp, is_ground: false }
}

/// A ball on a plate of triangles is not held by the plate's lower face, which it is behind; the ground is solid however deep.
#[test]
fn a_ball_on_a_plate_is_not_met_by_its_lower_face() {
    let lower = [DVec3::new(-1.0, -1.0, 0.0), DVec3::new(0.0, 2.0, 0.0), DVec3::new(1.0, -1.0, 0.0)];
    let mut out = [Point::default(); MAX_POINTS];
    for (z, n) in [(0.3, 0), (0.11, 0), (0.099, 1), (-0.05, 1), (-0.099, 1), (-0.11, 0)] {
        let ball = placed(ShapeKind::Sphere, [0.1; 3], DVec3::new(0.0, 0.0, z), UP);
        assert_eq!(collide_triangle(&ball, &part(lower, 63), 1e-3, &mut out), n, "{z}");
    }
    let ball = placed(ShapeKind::Sphere, [0.1; 3], DVec3::new(0.0, 0.0, 3.0), UP);
    let ground = Triangle { is_ground: true, ..part(lower, 63) };
    assert_eq!(collide_triangle(&ball, &ground, 1e-3, &mut out), 1);
    assert!((out[0].gap + 3.1).abs() < 1e-12);
}

/// A face on whose edge a shape leans, behind it, does not push it out upwards: it is solid below, but not beside.
#[test]
fn what_is_beside_a_face_is_not_under_it() {
    let top = part([DVec3::new(0.0, -1.0, 1.0), DVec3::new(0.0, 1.0, 1.0), DVec3::new(-2.0, 0.0, 1.0)], 63);
    let mut out = [Point::default(); MAX_POINTS];
    // Lower and higher than the face, apart and by a trace in it.
    for (half, gap) in [(0.3, 1e-3), (0.8, 1e-3), (0.8, -1e-4)] {
        for kind in [ShapeKind::Box, ShapeKind::Cylinder, ShapeKind::Capsule] {
            let high = if kind == ShapeKind::Capsule { half - 0.2 } else { half };
            let shape = placed(kind, [0.2, 0.2, high], DVec3::new(0.2 + gap, 0.0, half), UP);
            let n = collide_triangle(&shape, &top, 0.01, &mut out);
            assert!(out[..n].iter().all(|p| p.gap > -1e-3), "{kind:?} {half} {gap}: {:?}", &out[..n]);
        }
    }
    // Edge at edge in a corner, by a trace, any direction between the two faces is as good.
    let mut random = SplitMix64(12);
    for _ in 0..3000 {
        let size = [random.between(0.1, 0.5), random.between(0.1, 0.5), 0.5];
        let at = DVec3::new(
            size[0] + random.between(-3e-12, 3e-12),
            random.between(-0.5, 0.5),
            size[2] + random.between(-3e-11, 3e-11),
        );
        let trace = DQuat::from_scaled_axis(DVec3::new(random.between(-1e-12, 1e-12), 1e-12, 3e-13));
        let n = collide_triangle(&placed(ShapeKind::Box, size, at, trace), &top, 0.01, &mut out);
        assert!(out[..n].iter().all(|p| p.gap > -1e-3), "{size:?} {at} {trace}: {:?}", &out[..n]);
    }
    // Under it, and in it.
    for z in [0.79, 0.9, 1.1] {
        let shape = placed(ShapeKind::Box, [0.2; 3], DVec3::new(-0.5, 0.0, z), UP);
        let n = collide_triangle(&shape, &top, 0.1, &mut out);
        let least = out[..n].iter().map(|p| p.gap).fold(0.0, f64::min);
        assert!((least - (z - 1.2)).abs() < 1e-9, "{z}: {least}");
    }
}

#[test]
fn flat_contacts_have_several_points_that_stay() {
    let plate = placed(ShapeKind::Box, [1.0, 1.0, 0.1], DVec3::ZERO, UP);
    let lying = DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2);
    let hull = Hull::of_points(&[
        DVec3::new(-0.2, -0.2, -0.2),
        DVec3::new(0.2, -0.2, -0.2),
        DVec3::new(0.0, 0.3, -0.2),
        DVec3::new(0.0, 0.0, 0.4),
    ])
    .unwrap()
    .0;
    let bottom = -hull.vertices.iter().map(|v| v.z).fold(0.0, f64::min);
    let cases = [
        (placed(ShapeKind::Cylinder, [0.2, 0.2, 0.3], DVec3::new(0.1, 0.0, 0.399), UP), 8),
        (placed(ShapeKind::Cylinder, [0.2, 0.2, 0.3], DVec3::new(0.1, 0.0, 0.299), lying), 2),
        (placed(ShapeKind::Capsule, [0.2, 0.2, 0.3], DVec3::new(0.1, 0.0, 0.299), lying), 2),
        (placed(ShapeKind::Cone, [0.2, 0.2, 0.3], DVec3::new(0.1, 0.0, 0.399), UP), 8),
        (placed(ShapeKind::Ellipsoid, [0.3, 0.2, 0.1], DVec3::new(0.1, 0.0, 0.199), UP), 1),
        (
            Placed {
                hull: Some(&hull),
                ..placed(ShapeKind::Hull, [0.3; 3], DVec3::new(0.1, 0.0, 0.1 + bottom - 0.001), UP)
            },
            3,
        ),
    ];
    let ground = placed(ShapeKind::Plane, [0.0; 3], DVec3::new(0.0, 0.0, 0.1), UP);
    let square = [DVec3::new(-9.0, -9.0, 0.1), DVec3::new(9.0, -9.0, 0.1), DVec3::new(0.0, 18.0, 0.1)];
    for (shape, n) in cases {
        for (what, found) in [
            ("plate", points(&plate, &shape, 0.005)),
            ("plane", points(&ground, &shape, 0.005)),
            ("triangle", {
                let mut out = [Point::default(); MAX_POINTS];
                let n = collide_triangle(&shape, &part(square, 63), 0.005, &mut out);
                swap_shapes(&mut out, n);
                out[..n].to_vec()
            }),
        ] {
            assert_eq!(found.len(), n, "{:?} on a {what}", shape.kind);
            for p in &found {
                assert!((p.normal - DVec3::Z).length() < 1e-5, "{:?} on a {what}: {}", shape.kind, p.normal);
                assert!((p.gap + 0.001).abs() < 1e-5, "{:?} on a {what}: {}", shape.kind, p.gap);
            }
            let features: std::collections::HashSet<u32> = found.iter().map(|p| p.feature).collect();
            assert_eq!(features.len(), n, "{:?} on a {what}: feature ids differ", shape.kind);
        }
        // After a small motion the same points have the same ids.
        let moved = Placed { position: shape.position + DVec3::new(1e-4, -1e-4, 1e-5), ..shape };
        let ids = |s: &Placed| points(&plate, s, 0.005).iter().map(|p| p.feature).collect::<Vec<_>>();
        assert_eq!(ids(&shape), ids(&moved), "{:?}", shape.kind);
    }
}

#[test]
fn overlaps_are_left_by_the_nearest_way() {
    let mut random = crate::SplitMix64(4);
    let kinds = [ShapeKind::Box, ShapeKind::Cylinder, ShapeKind::Capsule, ShapeKind::Cone, ShapeKind::Ellipsoid];
    let mut met = 0;
    for k in 0..3000 {
        let (p, q) = (kinds[k % 5], kinds[k / 5 % 5]);
        let a = placed(p, [0.2, 0.2, 0.3], DVec3::ZERO, random.rotation());
        let away = random.rotation() * DVec3::Z * random.between(0.3, 0.6);
        let b = placed(q, [0.15, 0.15, 0.25], away, random.rotation());
        for point in points(&a, &b, 0.02) {
            assert!((point.normal.length() - 1.0).abs() < 1e-9, "{p:?} {q:?}");
            let along = (point.on_second - point.on_first).dot(point.normal);
            assert!((along - point.gap).abs() < 1e-6, "{p:?} {q:?}: {along} {}", point.gap);
            met += 1;
        }
        // Separated by the depth, they hardly overlap.
        let overlapping = points(&a, &b, 0.0);
        if let Some(deepest) = overlapping.iter().min_by(|p, q| p.gap.total_cmp(&q.gap)) {
            let separated = Placed { position: b.position - deepest.normal * deepest.gap.min(0.0), ..b };
            let left = points(&a, &separated, 0.0).iter().map(|p| p.gap).fold(0.0, f64::min);
            assert!(left > -2e-3, "{p:?} {q:?}: {left} of {deepest:?}");
        }
    }
    assert!(met > 1000, "{met}");
}

#[test]
fn seams_of_a_flat_surface_are_not_felt() {
    let n = 9;
    let surface = Surface::height_field(&vec![0.0; n * n], [n, n], [-1.0, -1.0], [0.25, 0.25]);
    for x in [-0.3, -0.26, -0.25, -0.125, 0.0, 0.1] {
        let sphere = placed(ShapeKind::Sphere, [0.2; 3], DVec3::new(x, 0.05, 0.195), UP);
        let block = placed(ShapeKind::Box, [0.2, 0.3, 0.1], DVec3::new(x, 0.05, 0.099), UP);
        for shape in [sphere, block] {
            let mut found = vec![];
            surface.visit(shape.position - 0.5, shape.position + 0.5, &mut |t| {
                let mut out = [Point::default(); MAX_POINTS];
                let n = collide_triangle(&shape, &part(surface.corners(t), surface.sharp[t as usize]), 0.02, &mut out);
                found.extend_from_slice(&out[..n]);
            });
            assert!(!found.is_empty(), "{:?} at {x}", shape.kind);
            assert!(found.iter().all(|p| (p.normal + DVec3::Z).length() < 1e-6), "{:?} at {x}", shape.kind);
            let min_gap = found.iter().map(|p| p.gap).fold(f64::INFINITY, f64::min);
            assert!((min_gap - (shape.position.z - shape.size.z)).abs() < 1e-9, "{min_gap}");
        }
    }
}

#[test]
fn boxes_apart_without_facing_faces_have_their_nearest_points() {
    let size = [0.5; 3];
    let a = placed(ShapeKind::Box, size, DVec3::ZERO, UP);
    for (offset, apart) in [
        (DVec3::new(1.02, 1.03, 0.1), 0.02f64.hypot(0.03)),
        (DVec3::new(-1.02, 1.02, -1.01), (2.0 * 0.02f64.powi(2) + 0.01f64.powi(2)).sqrt()),
    ] {
        let found = points(&a, &placed(ShapeKind::Box, size, offset, UP), 0.1);
        let nearest = found.iter().map(|p| p.gap).fold(f64::INFINITY, f64::min);
        assert!((nearest - apart).abs() < 1e-9, "{offset}: {nearest}, expected {apart}");
    }
}

#[test]
fn a_search_that_begins_along_an_axis_finds_the_same_gap() {
    let mut random = crate::SplitMix64(9);
    let corners: Vec<DVec3> = (0..32).map(|_| random.rotation() * DVec3::X * 0.2).collect();
    let (hull, _) = crate::geometry::Hull::of_points(&corners).unwrap();
    let kinds = [ShapeKind::Hull, ShapeKind::Box, ShapeKind::Cylinder, ShapeKind::Capsule, ShapeKind::Cone];
    let mut apart = 0;
    for k in 0..5000 {
        let mut shape = |kind: ShapeKind, at: DVec3| Placed {
            hull: (kind == ShapeKind::Hull).then_some(&hull),
            ..placed(kind, [0.2, 0.2, 0.25], at, random.rotation())
        };
        let a = shape(kinds[k % 5], DVec3::ZERO);
        let b = shape(kinds[k / 5 % 5], DVec3::new(0.0, 0.0, 0.45));
        let (reach, mut first) = (0.05, Axis::default());
        let mut out = Points::default();
        let least = |n: usize, out: &Points| out[..n].iter().map(|p| p.gap).fold(f64::INFINITY, f64::min);
        let n = collide_along(&a, &b, reach, &mut first, &mut out);
        let gap = least(n, &out);
        // From the axis that was found, from one beside it, and from the opposite one; from corners that were found, and from any.
        let beside = (first.direction + DVec3::new(0.1, -0.2, 0.05)).normalize();
        let none = Corners::default();
        let any = [0; 3].map(|_| [0; 2].map(|_| random.between(1.0, 8.9) as u16));
        let starts = [
            (first.direction, none),
            (beside, none),
            (-first.direction, none),
            (first.direction, first.corners),
            (beside, [first.corners[0], [0; 2], [0; 2]]),
            (-first.direction, any),
        ];
        for (direction, corners) in starts {
            let mut axis = Axis { direction, apart: 0.0, corners };
            let n = collide_along(&a, &b, reach, &mut axis, &mut out);
            let found = least(n, &out);
            assert!(
                found == gap || (found - gap).abs() < 3e-6 - 1e-3 * gap.min(0.0),
                "{:?} {:?} {k}: {gap} {found}",
                a.kind,
                b.kind
            );
            let along = convex::separation(&a, &b, axis.direction);
            assert!(n > 0 || (axis.apart > reach && (along - axis.apart).abs() < 1e-9), "{along} {axis:?}");
        }
        apart += (n == 0) as u32;
    }
    assert!((500..4500).contains(&apart), "{apart}");
}

#[test]
fn cylinders_side_by_side_have_the_gap_of_their_sides() {
    let mut random = crate::SplitMix64(4);
    let (r, half) = (0.1, 0.25);
    for i in 0..20_000 {
        let turn = random.rotation();
        let gap = 10f64.powf(random.between(-13.0, -3.0)) * if i % 2 == 0 { 1.0 } else { -1.0 };
        let gap = if i % 10 == 0 { 0.0 } else { gap };
        let (kind, other) = [(ShapeKind::Cylinder, 0.1), (ShapeKind::Cylinder, 0.07), (ShapeKind::Cone, 0.1)][i % 3];
        // A cone's side leans by its own slope; it is turned back so that it lies along the cylinder's.
        let lean = if kind == ShapeKind::Cone { f64::atan2(other, 2.0 * half) } else { 0.0 };
        let out = if kind == ShapeKind::Cone { half * lean.sin() } else { other };
        let own = DQuat::from_rotation_z(random.between(-3.0, 3.0));
        let spin = DQuat::from_rotation_z(random.between(-3.0, 3.0));
        let at = DVec3::new(r + out + gap, 0.0, random.between(-0.9, 0.9) * half);
        let first = placed(ShapeKind::Cylinder, [r, r, half], DVec3::ZERO, turn * own);
        let lying = DQuat::from_rotation_y(if kind == ShapeKind::Cone { -lean } else { 0.0 });
        let second = placed(kind, [other, other, half], turn * at, turn * lying * spin);
        let found = points(&first, &second, 1e-2);
        let least = found.iter().map(|p| p.gap).fold(f64::INFINITY, f64::min);
        assert!((least - gap).abs() < 1e-7, "{i} {kind:?}: {least} for {gap}");
        for p in &found {
            let tilt = (p.normal - turn * DVec3::X).length();
            assert!(tilt < 5e-3, "{i} {kind:?}: {tilt} for {gap}");
        }
    }
}

/// The gap of two shapes is their greatest separation along any direction: none that is tried beside the normal that was found is greater,
/// and along that normal it is the gap.
#[test]
fn no_direction_separates_two_shapes_by_more_than_their_gap() {
    let mut random = SplitMix64(21);
    let corners: Vec<DVec3> = (0..24).map(|_| random.rotation() * DVec3::X * 0.2).collect();
    let (hull, _) = Hull::of_points(&corners).unwrap();
    let kinds = [
        ShapeKind::Sphere,
        ShapeKind::Capsule,
        ShapeKind::Cylinder,
        ShapeKind::Cone,
        ShapeKind::Ellipsoid,
        ShapeKind::Box,
        ShapeKind::Hull,
    ];
    let (mut worst, mut which) = (0.0, None);
    for k in 0..140_000 {
        let mut shape = |kind: ShapeKind, at: DVec3| Placed {
            hull: (kind == ShapeKind::Hull).then_some(&hull),
            ..placed(kind, [0.2, if kind == ShapeKind::Ellipsoid { 0.15 } else { 0.2 }, 0.25], at, random.rotation())
        };
        let a = shape(kinds[k % 7], DVec3::ZERO);
        let b = shape(kinds[k / 7 % 7], DVec3::ZERO);
        let way = random.rotation() * DVec3::X;
        let b = Placed { position: way * random.between(0.2, 0.8), ..b };
        let Some(found) = convex::nearest(&a, &b, 0.05, &mut Axis::default()) else { continue };
        let along = convex::separation(&a, &b, found.normal);
        let mut greatest = along;
        let mut best = found.normal;
        for round in 0..90 {
            // First around the line between the centres, then ever nearer to the best.
            let spread = if round < 30 { 2.0 } else { 0.7f64.powi((round - 30) / 3) };
            let near = if round < 30 { way } else { best };
            let d = (near + random.rotation() * DVec3::X * spread * random.between(0.0, 1.0)).normalize();
            let apart = convex::separation(&a, &b, d);
            if apart > greatest {
                (greatest, best) = (apart, d);
            }
        }
        // Smooth shapes are approached by planes: the deeper, the coarser.
        let coarse = 1e-2 * -found.gap.min(0.0);
        let error = (found.gap - along).abs().max(greatest - found.gap) - coarse;
        if error > worst {
            (worst, which) = (error, Some((k, a.kind, b.kind, found.gap, along, greatest)));
        }
    }
    assert!(worst < 1e-5, "{worst}: {which:?}");
}

#[test]
fn boxes_that_are_apart_have_the_gap_of_their_nearest_points() {
    let mut random = SplitMix64(4);
    let mut apart = 0;
    for k in 0..50_000 {
        let mut size = || [0.2, 0.4, 0.6].map(|s| s * random.between(0.5, 1.5));
        let (of_a, of_b) = (size(), size());
        let at = random.rotation() * DVec3::X * random.between(0.3, 1.4);
        let a = placed(ShapeKind::Box, of_a, DVec3::ZERO, random.rotation());
        let b = placed(ShapeKind::Box, of_b, at, random.rotation());
        let least = a.size.min_element().min(b.size.min_element());
        // Of slow boxes, and of fast ones.
        let reach = least * if k % 2 == 0 { 0.05 } else { 0.3 };
        let nearest = convex::nearest(&a, &b, reach, &mut Axis::default());
        let Some(nearest) = nearest.filter(|nearest| nearest.gap > 0.0) else { continue };
        let gap = points(&a, &b, reach).iter().map(|p| p.gap).fold(f64::INFINITY, f64::min);
        assert!((gap - nearest.gap).abs() < 1.1e-3 * least, "{k}: {gap}, expected {}", nearest.gap);
        apart += 1;
    }
    assert!(apart > 1000, "{apart}");
}

/// A prism of many sides that lies on its end has points all around, on a plane, on a box and on another prism, which lies turned by a little.
#[test]
fn faces_of_many_corners_have_points_all_around() {
    for n in [9, 13, 16, 24, 31, 48, 96, 200] {
        let rim = (0..n).map(|k| DVec2::from_angle(TAU * k as f64 / n as f64) * 0.1);
        let corners: Vec<DVec3> = rim.flat_map(|p| [p.extend(-0.05), p.extend(0.05)]).collect();
        let (hull, _) = Hull::of_points(&corners).unwrap();
        let prism = |z: f64, turn: f64| Placed {
            hull: Some(&hull),
            ..placed(ShapeKind::Hull, [0.1, 0.1, 0.05], DVec3::Z * z, DQuat::from_rotation_z(turn))
        };
        let below = [
            placed(ShapeKind::Plane, [0.0; 3], DVec3::ZERO, DQuat::IDENTITY),
            placed(ShapeKind::Box, [0.5, 0.5, 0.1], DVec3::Z * -0.1, DQuat::from_rotation_z(0.3)),
            prism(-0.05, 0.1),
        ];
        for below in below {
            for tilt in [0.0, 1e-7, -1e-7] {
                let above = prism(0.0501, 0.7);
                let orientation = DQuat::from_rotation_x(tilt) * above.orientation;
                let above =
                    Placed::new(above.kind, above.size, Pose { position: above.position, orientation }, above.hull);
                let found = points(&above, &below, 0.01);
                let middle = found.iter().map(|p| p.on_first).sum::<DVec3>() / found.len() as f64;
                let around = found.iter().map(|p| p.on_first.truncate().length()).fold(f64::INFINITY, f64::min);
                assert!(
                    found.len() == MAX_POINTS && middle.truncate().length() < 0.03,
                    "{n} {:?}: {middle}",
                    below.kind
                );
                assert!(around > 0.09, "{n} {:?}: {around}", below.kind);
            }
        }
    }
}

/// A cylinder that stands on its end, tilted by round-off whichever way, has the same points of its rim.
#[test]
fn what_stands_on_an_end_keeps_its_points() {
    let plane = placed(ShapeKind::Plane, [0.0; 3], DVec3::ZERO, DQuat::IDENTITY);
    for kind in [ShapeKind::Cylinder, ShapeKind::Cone] {
        let features = |turn: f64| {
            let tilt = DQuat::from_axis_angle(DVec3::from_array([turn.cos(), turn.sin(), 0.0]), 1e-9);
            let own = placed(kind, [0.1, 0.1, 0.1], DVec3::Z * 0.1, tilt);
            points(&own, &plane, 1e-3).iter().map(|p| p.feature).collect::<Vec<u32>>()
        };
        let first = features(0.0);
        assert_eq!(first.len(), MAX_POINTS);
        (1..50).for_each(|k| assert_eq!(features(0.13 * k as f64), first, "{kind:?} {k}"));
    }
}

/// A cylinder that lies along a face or an edge of a box, or of a hull of the same corners, has a point at both ends of the line, and the
/// normal of the face or across the edge.
#[test]
fn a_cylinder_along_a_face_or_an_edge_has_both_ends() {
    let mut random = SplitMix64(11);
    let size = DVec3::new(0.2, 0.3, 0.1);
    let corners: Vec<DVec3> = (0..8).map(|k| convex::box_corner(size, k)).collect();
    let (hull, _) = Hull::of_points(&corners).unwrap();
    for i in 0..20_000 {
        let turn = random.rotation();
        let shift = random.rotation() * DVec3::X * random.between(0.0, 10.0);
        let gap = 10f64.powf(random.between(-9.0, -3.0)) * if i % 2 == 0 { 1.0 } else { -1.0 };
        let (r, half) = (0.06, random.between(0.05, 0.4));
        // Along z, on the face across x, or about the edge between it and that across y.
        let angle = if i % 3 == 0 { 0.0 } else { random.between(0.05, 1.5) };
        let normal = DVec3::new(angle.cos(), angle.sin(), 0.0);
        let foot = DVec3::new(size.x, if i % 3 == 0 { random.between(-0.9, 0.9) * size.y } else { size.y }, 0.0);
        let at = foot + normal * (r + gap) + DVec3::Z * random.between(-0.5, 0.5) * size.z;
        let is_hull = i % 4 < 2;
        let kind = if is_hull { ShapeKind::Hull } else { ShapeKind::Box };
        let a = Placed { hull: is_hull.then_some(&hull), ..placed(kind, size.to_array(), shift, turn) };
        // A millionth of a radian beside it.
        let lean = DQuat::from_rotation_x(1e-6) * DQuat::from_rotation_z(random.between(-3.0, 3.0));
        let b = placed(ShapeKind::Cylinder, [r, r, half], shift + turn * at, turn * lean);
        for (first, second, sign) in [(&a, &b, 1.0), (&b, &a, -1.0)] {
            let found = points(first, second, 1e-2);
            assert!(found.len() == 2, "{i} {kind:?}: {} points, gap {gap:e}, angle {angle}", found.len());
            for p in &found {
                let tilt = (p.normal * sign - turn * normal).length();
                assert!(tilt < 3e-6 && (p.gap - gap).abs() < 5e-7, "{i} {kind:?}: {tilt:e}, {:e} for {gap:e}", p.gap);
            }
        }
    }
}

/// Logs that lie along each other, askew by little or much, have points at both ends of where they do, with the gaps that they have there.
#[test]
fn logs_askew_have_points_where_they_lie_along_each_other() {
    let (radii, half, reach) = ([0.05, 0.07], [0.5, 0.4], 8e-3);
    let mut random = SplitMix64(12);
    for i in 0..4_000 {
        let kinds =
            [[ShapeKind::Cylinder; 2], [ShapeKind::Capsule; 2], [ShapeKind::Cylinder, ShapeKind::Capsule]][i % 3];
        let askew = [0.0, 10f64.powf(random.between(-5.0, -1.0)), random.between(0.2, 1.5)][i / 3 % 3];
        let gap = random.between(-2e-3, 2e-3);
        let (frame, shift) = (random.rotation(), random.between(-0.05, 0.05));
        let at = frame * DVec3::new(radii[0] + radii[1] + gap, 0.0, shift);
        let spin = |random: &mut SplitMix64| DQuat::from_rotation_z(random.between(-3.0, 3.0));
        let log = |k: usize, position: DVec3, orientation: DQuat| {
            placed(kinds[k], [radii[k], radii[k], half[k]], position, orientation)
        };
        let a = log(0, DVec3::ZERO, frame * spin(&mut random));
        let turned = frame * DQuat::from_rotation_x(askew) * spin(&mut random);
        let b = log(1, at, turned);
        let found = points(&a, &b, reach);
        // The ends of the second, which is the shorter one, beside the axis of the first.
        let ends = [half[1], -half[1]].map(|z| {
            let end = frame.inverse() * (at + turned * DVec3::Z * z);
            (end.truncate().length() - radii[0] - radii[1], end.z)
        });
        let near = ends.iter().filter(|(gap, z)| *gap < 0.9 * reach && z.abs() < half[0]);
        for (gap, z) in near.clone() {
            let is_there = |p: &Point| {
                let place = frame.inverse() * p.on_first;
                (place.z - z).abs() < 2e-2 && (p.gap - gap).abs() < 0.02 * askew * askew + 1e-6
            };
            assert!(found.iter().any(is_there), "{i} {kinds:?} {askew}: {ends:?} {found:?}");
        }
        let most = if ends.iter().all(|(gap, _)| *gap > 1.1 * reach) { 1 } else { 3 };
        assert!((1..=most).contains(&found.len()), "{i} {kinds:?} {askew}: {ends:?} {found:?}");
        let least = found.iter().map(|p| p.gap).fold(f64::INFINITY, f64::min);
        assert!((least - gap).abs() < 2e-6, "{i} {kinds:?} {askew}: {least} for {gap}");
        // Points of both shapes, across from each other.
        for p in &found {
            assert!((p.on_second - p.on_first - p.normal * p.gap).length() < 1e-12, "{i}: {p:?}");
            let out = (frame.inverse() * p.on_first).truncate().length();
            assert!((out - radii[0]).abs() < 1e-6, "{i} {kinds:?} {askew}: {out} {p:?}");
        }
    }
}
