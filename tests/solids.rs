//! Solids of primitives against silhouettes known on paper (RISpec 5.9).

use crate::rendering::{ORTHO, Rendered, render_with};
use std::f32::consts::PI;

fn primitive(gprims: &str) -> String {
    format!("SolidBegin \"primitive\" {gprims} SolidEnd\n")
}

/// A solid of parts, each a primitive or a solid.
fn solid(operation: &str, parts: &[&str]) -> String {
    let part = |part: &&str| if part.starts_with("SolidBegin") { part.to_string() } else { primitive(part) };
    format!("SolidBegin \"{operation}\" {} SolidEnd\n", parts.iter().map(part).collect::<String>())
}

/// A closed cylinder about z.
fn cylinder(radius: f32, half: f32) -> String {
    format!("Cylinder {radius} -{half} {half} 360 Disk -{half} {radius} 360 Disk {half} {radius} 360")
}

fn moved(x: f32, z: f32, gprims: &str) -> String {
    format!("AttributeBegin Translate {x} 0 {z} {gprims} AttributeEnd")
}

/// A cube about the origin by half its edge.
fn cube(half: f32) -> String {
    let at = |k: usize, bit: usize| if k >> bit & 1 == 1 { half } else { -half };
    let points: String = (0..8).map(|k| format!("{} {} {} ", at(k, 0), at(k, 1), at(k, 2))).collect();
    let faces = "0 1 3 2 4 6 7 5 0 4 5 1 2 3 7 6 0 2 6 4 1 5 7 3";
    format!("PointsPolygons [4 4 4 4 4 4] [{faces}] \"P\" [{points}]")
}

fn render(options: &str, world: &str) -> Rendered {
    let out = b"displacement out(float h = 0.1;) { P += h * normalize(N); N = calculatenormal(P); }";
    render_with(&[("out.sl", out)], options, world)
}

/// The area that a world covers in a parallel view along z, square units.
fn covered(options: &str, world: &str) -> f32 {
    let image = render(options, &format!("Surface \"constant\"\n{world}"));
    image.pixels.iter().map(|p| p[0]).sum::<f32>() / 1600.0
}

#[test]
fn solids_cover_what_their_operations_leave() {
    let (left, right) = (moved(-0.2, 0.0, "Sphere 0.6 -0.6 0.6 360"), moved(0.2, 0.0, "Sphere 0.6 -0.6 0.6 360"));
    // Two circles of radius r at a distance d share 2r² acos(d/2r) − d/2 √(4r² − d²).
    let lens = 0.72 * (0.4f32 / 1.2).acos() - 0.2 * (1.44f32 - 0.16).sqrt();
    let (sphere, cubes) = ("Sphere 0.8 -0.8 0.8 360", cube(0.5));
    let (hole, bore) = (cylinder(0.3, 1.0), cylinder(0.4, 1.0));
    let (thin, longer) = (cylinder(0.1, 1.0), cylinder(0.1, 2.0));
    let half = moved(1.0, 0.0, &cube(1.0));
    let ring = solid("difference", &[&hole, &longer]);
    let displaced = "Displacement \"out\" Attribute \"displacementbound\" \"sphere\" [0.2]";
    let cases = [
        ("two spheres", solid("intersection", &[&left, &right]), lens),
        ("either sphere", solid("union", &[&left, &right]), 0.72 * PI - lens),
        ("a bored sphere", solid("difference", &[sphere, &bore]), 0.48 * PI),
        ("the core of it", solid("intersection", &[sphere, &bore]), 0.16 * PI),
        ("a bored cube", solid("difference", &[&cubes, &hole]), 1.0 - 0.09 * PI),
        ("with a pin", solid("union", &[&solid("difference", &[&cubes, &hole]), &thin]), 1.0 - 0.08 * PI),
        ("less a ring", solid("difference", &[&cubes, &ring]), 1.0 - 0.08 * PI),
        ("half a torus", solid("difference", &["Torus 0.5 0.2 0 360 360", &half]), 0.2 * PI),
        (
            "a swollen sphere",
            format!("{displaced} {}", solid("difference", &["Sphere 0.7 -0.7 0.7 360", &cylinder(0.3, 2.0)])),
            0.55 * PI,
        ),
        ("parts without blocks of their own", format!("SolidBegin \"intersection\" {sphere} {cubes} SolidEnd"), 1.0),
    ];
    for (what, world, expected) in cases {
        let found = covered(ORTHO, &world);
        assert!((found - expected).abs() < 0.012, "{what}: {found}, expected {expected}");
    }
}

#[test]
fn solids_move_and_are_instanced() {
    let moving = format!(
        "AttributeBegin MotionBegin [0 1] Translate -0.2 0 0 Translate 0.2 0 0 MotionEnd {} AttributeEnd",
        cylinder(0.2, 1.0)
    );
    let open = ORTHO.replace("Translate", "Shutter 0 1 Translate");
    // A hole that wanders takes away its area, wherever it is.
    let found = covered(&open, &solid("difference", &[&cube(0.5), &moving]));
    assert!((found - (1.0 - 0.04 * PI)).abs() < 0.012, "{found}");
    let object = format!(
        "ObjectBegin 1 {} ObjectEnd Translate -0.1 0 0 ObjectInstance 1 Translate 0.2 0 0.1 ObjectInstance 1",
        solid("difference", &[&cube(0.3), &cylinder(0.2, 1.0)])
    );
    // Two bored cubes that overlap: each fills the other's hole, but where the holes overlap (two circles of radius 0.2 at 0.2) and
    // where the other cube does not reach (a segment at 0.1 from the middle of each).
    let lens = 0.08 * (0.5f32).acos() - 0.1 * (0.16f32 - 0.04).sqrt();
    let holes = lens + 2.0 * (0.04 * (0.5f32).acos() - 0.1 * (0.04f32 - 0.01).sqrt());
    let found = covered(ORTHO, &object);
    assert!((found - (0.6 * 0.8 - holes)).abs() < 0.012, "{found}");
    let within = format!(
        "ObjectBegin 1 {} ObjectEnd SolidBegin \"difference\" {} SolidBegin \"primitive\" ObjectInstance 1 SolidEnd SolidEnd",
        cylinder(0.3, 1.0),
        primitive(&cube(0.5))
    );
    let found = covered(ORTHO, &within);
    assert!((found - (1.0 - 0.09 * PI)).abs() < 0.012, "{found}");
}

#[test]
fn solids_are_lit_and_shade_as_they_are() {
    let lit = "LightSource \"distantlight\" 1 \"from\" [0 0 0] \"to\" [0 0 1] Surface \"matte\" \"Ka\" 0 \"Kd\" 1";
    // A bowl cut into a cube: at 0.3 from the middle of a sphere of 0.4 the cosine is √(1 − 0.3²/0.4²); the rim is flat.
    let bowl = solid("difference", &[&cube(0.5), &moved(0.0, -0.5, "Sphere 0.4 -0.4 0.4 360")]);
    let image = render(ORTHO, &format!("{lit} {bowl}"));
    let cosine = (1.0 - (0.3125f32 / 0.4).powi(2)).sqrt();
    for (x, y, expected) in [(40, 40, 1.0), (52, 40, cosine), (58, 40, 1.0), (22, 22, 1.0)] {
        let found = image.at(x, y)[0];
        assert!((found - expected).abs() < 0.01, "({x}, {y}): {found}, expected {expected}");
    }
    // Light falls through a bore onto a floor behind it.
    let floor = "Polygon \"P\" [-0.95 -0.95 2 0.95 -0.95 2 0.95 0.95 2 -0.95 0.95 2]";
    let bored = solid("difference", &[&cube(0.5), &cylinder(0.3, 1.0)]);
    let image = render(ORTHO, &format!("{lit} {floor} Attribute \"visibility\" \"int camera\" [0] {bored}"));
    let found = image.pixels.iter().map(|p| p[0]).sum::<f32>() / 1600.0;
    assert!((found - (1.9 * 1.9 - 1.0 + 0.09 * PI)).abs() < 0.02, "{found}");
}

#[test]
fn light_falls_through_bores_of_any_length() {
    // The sun shines along a cylinder of radius 0.9 onto a floor of 1.9 by 1.9 behind it, and through its bore. Some lengths make facets
    // of caps that rounding alone gives an area.
    let lit = "LightSource \"distantlight\" 1 \"to\" [0 0 1] Surface \"matte\" \"Ka\" 0 \"Kd\" 1";
    for (length, radius) in [(1.0, 0.3), (10.0, 0.05), (50.0, 0.3), (100.0, 0.05), (300.0, 0.2), (1000.0, 0.05)] {
        let (half, floor) = (length / 2.0, length / 2.0 + 1.0);
        let bored = solid("difference", &[&cylinder(0.9, half), &cylinder(radius, half + 0.5)]);
        let floor = format!("-0.95 -0.95 {floor} 0.95 -0.95 {floor} 0.95 0.95 {floor} -0.95 0.95 {floor}");
        let world = format!("{lit} Polygon \"P\" [{floor}] Attribute \"visibility\" \"int camera\" [0] {bored}");
        let image = render(&ORTHO.replace("0 0 5", &format!("0 0 {}", half + 5.0)), &world);
        let found = image.pixels.iter().map(|p| p[0]).sum::<f32>() / 1600.0;
        let expected = 1.9 * 1.9 - (0.81 - radius * radius) * PI;
        assert!((found - expected).abs() < 0.006, "{length} long, {radius} wide: {found}, expected {expected}");
    }
}

#[test]
fn a_long_bore_that_is_cut_open_is_lit_all_over() {
    // A tube along z, of which the half towards the eye is cut off: the sun shines from the eye into the half of its bore.
    let lit = "LightSource \"distantlight\" 1 \"to\" [0 1 0] Surface \"matte\" \"Ka\" 0 \"Kd\" 1";
    let half = format!("AttributeBegin Translate 0 -1 0 Scale 1 1 30 {} AttributeEnd", cube(1.0));
    let tube = |r: f32| format!("Cylinder {r} -20 20 360 Disk -20 {r} 360 Disk 20 {r} 360");
    let whole = solid("difference", &[&tube(0.8), &tube(0.5), &half]);
    let view = ORTHO.replace("Translate 0 0 5", "Rotate 90 1 0 0 Translate 0 5 0");
    let image = render(&view, &format!("{lit} {whole}"));
    // At x from the axis the bore's normal has the cosine √(1 − x²/0.5²); the cut is flat.
    for (x, expected) in [(0.0f32, 1.0), (0.3, 0.8), (-0.4, 0.6), (0.65, 1.0)] {
        let found = image.at((40.0 * (x + 1.0)) as usize, 40)[0];
        assert!((found - expected).abs() < 0.04, "{x}: {found}, expected {expected}");
    }
}

#[test]
fn very_many_parts_in_one_place_are_shaded_where_they_are_seen() {
    // Of 1,200 parts in one place, the points that are seen of the first are shaded.
    let shaded = |n: usize| {
        let parts = vec![cylinder(0.8, 0.5); n];
        let parts: Vec<&str> = parts.iter().map(String::as_str).collect();
        let world = format!("Surface \"constant\"\nRotate 60 1 0 0\n{}", solid("union", &parts));
        crate::layers::stats(ORTHO, &world)["stats"]["shaded_points"].as_u64().unwrap()
    };
    let [few, many] = [shaded(3), shaded(1200)];
    assert!(many < 2 * few, "{many} points are shaded, {few} of three parts");
}
