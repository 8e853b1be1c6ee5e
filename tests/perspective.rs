//! The transformation `Perspective` within a world (RISpec 3.2, 5.2): areas computed by hand, and no seams.

use crate::interface::area;
use crate::rendering::{ORTHO, render_with};

#[test]
fn points_and_instances_go_where_a_perspective_leads() {
    // RISpec 5.2: Perspective of 90 degrees maps a point of depth z to x/z, y/z. A square of 1 at a depth of 2 is 0.5 wide; a small sphere
    // there is seen with half its radius, and at (0.8, 0, 2) it stands at 0.4.
    let square = "Polygon \"P\" [-0.5 -0.5 2 0.5 -0.5 2 0.5 0.5 2 -0.5 0.5 2]";
    let away = "Surface \"constant\" Perspective 90";
    let pi = std::f32::consts::PI;
    for (world, expected) in [
        (format!("{away} {square}"), 0.25),
        (format!("ObjectBegin 1 {square} ObjectEnd {away} ObjectInstance 1"), 0.25),
        (format!("{away} Points \"P\" [0.8 0 2 -0.8 0 2] \"constantwidth\" [0.2]"), 2.0 * 0.0025 * pi),
        (format!("{away} Translate 0 0 2 Sphere 0.1 -0.1 0.1 360"), 0.0025 * pi),
    ] {
        let found = area(&render_with(&[], ORTHO, &world));
        assert!((found - expected).abs() < 0.02 * expected.sqrt(), "{world}: {found}, expected {expected}");
    }
}

#[test]
fn perspective_is_a_transformation() {
    // RISpec 5.2: x and y are divided by z tan(45°): at z = 2 a square of half edge 0.8 has 0.4, a sphere of radius r at a distance d
    // the radius r / √(d² − r²); and of a camera it is its projection.
    let pi = std::f32::consts::PI;
    let square = "Polygon \"P\" [-0.8 -0.8 2 0.8 -0.8 2 0.8 0.8 2 -0.8 0.8 2]";
    let camera = ORTHO.replace("Translate 0 0 5", "Perspective 90");
    for (options, world, expected) in [
        (ORTHO, format!("Perspective 90 {square}"), 0.64),
        (ORTHO, "Perspective 90 Translate 0 0 2 Sphere 1 -1 1 360".to_string(), pi / 3.0),
        (&camera, square.to_string(), 0.64),
    ] {
        let found = area(&render_with(&[], options, &format!("Surface \"constant\" {world}")));
        assert!((found - expected).abs() < 0.012, "{world}: {found}, expected {expected}");
    }
}

#[test]
fn meshes_in_objects_have_no_seams_under_a_perspective() {
    // RISpec 5.2: a square of half edge 1, turned by 40° about y and two units away, spans x / z tan(30°) at its corners: a trapezoid.
    let (s, c) = 40f32.to_radians().sin_cos();
    let f = 1.0 / 30f32.to_radians().tan();
    let corner = |x: f32| (f * x * c / (2.0 - x * s), f / (2.0 - x * s));
    let ((left, high), (right, low)) = (corner(-1.0), corner(1.0));
    // Half of its size, so that all of it is seen.
    let expected = 0.25 * (right - left) * (high + low);
    let n = 7;
    let points: Vec<String> = (0..(n + 1) * (n + 1))
        .map(|k| {
            format!(
                "{} {} 0",
                -1.0 + 2.0 * (k % (n + 1)) as f32 / n as f32,
                -1.0 + 2.0 * (k / (n + 1)) as f32 / n as f32
            )
        })
        .collect();
    let face = |k: usize| {
        let a = k % n + (k / n) * (n + 1);
        format!("{} {} {} {}", a, a + 1, a + n + 2, a + n + 1)
    };
    let faces: Vec<String> = (0..n * n).map(face).collect();
    let mesh = format!("PointsPolygons [{}] [{}] \"P\" [{}]", "4 ".repeat(n * n), faces.join(" "), points.join(" "));
    let away = "Perspective 60 Translate 0 0 2 Rotate 40 0 1 0";
    for world in [
        format!("ObjectBegin 1 {away} {mesh} ObjectEnd Scale 0.5 0.5 1 ObjectInstance 1"),
        format!("ObjectBegin 1 {mesh} ObjectEnd Scale 0.5 0.5 1 {away} ObjectInstance 1"),
        format!(
            "ObjectBegin 1 Translate 0 0 2 Rotate 40 0 1 0 {mesh} ObjectEnd Scale 0.5 0.5 1 Perspective 60 ObjectInstance 1"
        ),
        format!("Scale 0.5 0.5 1 {away} {mesh}"),
    ] {
        let whole = render_with(&[], ORTHO, &format!("Surface \"constant\" {world}"));
        let found = area(&whole);
        assert!((found - expected).abs() < 0.005, "{world}: {found}, expected {expected}");
        // Inside there is no pixel that is less than whole, and none of half an opacity that is more.
        let half = render_with(&[], ORTHO, &format!("Surface \"constant\" Opacity 0.5 0.5 0.5 {world}"));
        let inside = |x: usize, y: usize| (0..25).all(|k| whole.at(x + k % 5 - 2, y + k / 5 - 2)[3] > 0.9);
        let pixels = (2..78).flat_map(|x| (2..78).map(move |y| (x, y))).filter(|(x, y)| inside(*x, *y));
        let seen: Vec<_> = pixels.map(|(x, y)| (whole.at(x, y)[3], half.at(x, y)[3])).collect();
        assert!(seen.len() > 500);
        assert!(seen.iter().all(|(whole, half)| *whole == 1.0 && (half - 0.5).abs() < 1e-5), "{world}");
    }
}

/// Two meshes of an object in one place are two layers, at the edges of their faces, too; each mesh is one there.
#[test]
fn meshes_of_an_object_under_a_perspective_keep_their_edges_apart() {
    // Half of the light goes through each, to a floor behind them: of two, a quarter.
    let told = b"surface told() { Ci = transmission(P, P + vector(0, 0, -9)); Oi = 1; }";
    let mesh = |z: f32| {
        format!("PointsPolygons [4 4] [0 1 4 3 1 2 5 4] \"P\" [-1 -1 {z} 0 -1 {z} 1 -1 {z} -1 1 {z} 0 1 {z} 1 1 {z}]\n")
    };
    let floor = "Polygon \"P\" [-.4 -.4 3 .4 -.4 3 .4 .4 3 -.4 .4 3]";
    for (meshes, expected) in [(mesh(2.0), 0.5), (mesh(2.0) + &mesh(2.0), 0.25)] {
        let world = format!(
            "AttributeBegin Opacity .5 .5 .5 Surface \"constant\" Attribute \"visibility\" \"camera\" [0]
            ObjectBegin 1 {meshes} ObjectEnd Perspective 90 ObjectInstance 1 AttributeEnd
            Surface \"told\" {floor}"
        );
        let options = ORTHO.replace("PixelSamples 8 8", "PixelSamples 1 1");
        let p = render_with(&[("told.sl", &told[..])], &options, &world);
        let inside: Vec<f32> =
            (26..54).flat_map(|x| (26..54).map(move |y| (x, y))).map(|(x, y)| p.at(x, y)[0]).collect();
        let off = inside.iter().filter(|found| (**found - expected).abs() > 1e-3).count();
        assert_eq!(off, 0, "{meshes}: {off} of {} are not {expected}", inside.len());
    }
}
