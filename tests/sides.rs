//! One-sided primitives: what is seen of them is where their outside is before the eye (RISpec 3.2, section 4.2, `Sides` and `Orientation`),
//! by where the surface is, triangle by triangle and at every moment.

use crate::rendering::{ORTHO, Rendered, render_with};
use std::f32::consts::PI;

fn draw(options: &str, world: &str) -> Rendered {
    render_with(&[], &format!("{options} {ORTHO}"), &format!("Surface \"constant\" {world}"))
}

/// Primitives whose outside encloses them, each with silhouettes that run through its micropolygons.
const CLOSED: [&str; 4] = [
    "Sphere .6 -.6 .6 360",
    "Rotate 30 1 0 0 Torus .55 .25 0 360 360",
    "Rotate 50 1 1 0 Cylinder .4 -.5 .5 360 Translate 0 0 .5 Disk 0 .4 360 Translate 0 0 -1 ReverseOrientation Disk 0 .4 360",
    "Scale .7 .7 .7 SubdivisionMesh \"catmull-clark\" [4 4 4 4 4 4] [0 1 3 2 1 5 7 3 5 4 6 7 4 0 2 6 2 3 7 6 4 5 1 0] [] [] [] []
     \"P\" [-1 -1 -1 1 -1 -1 -1 1 -1 1 1 -1 -1 -1 1 1 -1 1 -1 1 1 1 1 1]",
];

#[test]
fn what_is_closed_has_the_same_silhouette_whether_its_inside_is_there() {
    let moves = "MotionBegin [0 1] Translate -.1 0 0 Translate .2 .1 0 MotionEnd";
    for shape in CLOSED {
        for (options, moves) in [("", ""), ("Shutter 0 1", moves), ("DepthOfField 8 .5 5", "")] {
            let of = |attributes: &str| draw(options, &format!("{attributes} {moves} {shape}"));
            let (both, outside, turned) = (of("Sides 2"), of("Sides 1"), of("Sides 1 ReverseOrientation"));
            // A sample of 64 at the rounding of an edge, in few pixels.
            let off = |a: &Rendered, b: &Rendered| {
                let differences = a.pixels.iter().zip(&b.pixels).map(|(a, b)| (a[3] - b[3]).abs());
                differences.fold((0.0f32, 0.0f32), |(most, sum), d| (most.max(d), sum + d))
            };
            for one in [&outside, &turned] {
                let (most, sum) = off(one, &both);
                // A sphere that shows its inside is diced all over, not to its outline, and a little smaller.
                let is_diced_alike = !(shape.contains("Sphere") && std::ptr::eq(one, &turned));
                let (allowed, in_all) =
                    if is_diced_alike { (1.01 / 64.0, 0.2) } else { (0.15, 6e-3 * both.coverage()) };
                assert!(most <= allowed && sum < in_all, "{shape} {options}: {most} in a pixel, {sum} in all");
            }
        }
    }
}

#[test]
fn one_layer_is_there_of_a_sphere_whose_inside_is_not_seen() {
    // The outside has one layer before every place of the disk, the whole sphere two.
    for (options, place) in
        [("", ""), ("Shutter 0 1", "MotionBegin [0 1] Translate -.1 0 0 Translate .1 0 0 MotionEnd")]
    {
        let of = |attributes: &str| draw(options, &format!("{attributes} {place} Sphere .6 -.6 .6 360"));
        let one = of("Sides 1 Opacity .5 .5 .5");
        assert!(one.pixels.iter().all(|p| p[3] < 0.5 + 1e-4), "{options}: two layers in a pixel");
        let (whole, half) = (of("").coverage(), one.coverage());
        assert!((whole / (1600.0 * 0.36 * PI) - 1.0).abs() < 3e-3, "{whole}");
        assert!((half / whole - 0.5).abs() < 2e-3, "{half} of {whole}");
        let both = of("Opacity .5 .5 .5").coverage();
        assert!((both / whole - 0.75).abs() < 3e-3, "{both} of {whole}");
    }
    // From within an open half its inside alone is seen, and its outside from without.
    let part = |attributes: &str, heights: &str| {
        draw("", &format!("{attributes} Sphere .6 {heights} 360")).coverage() / 1600.0
    };
    let disk = 0.36 * PI;
    for (attributes, heights, expected) in [
        ("Sides 1", "-.6 0", disk),
        ("Sides 1", "0 .6", 0.0),
        ("Sides 1 ReverseOrientation", "0 .6", disk),
        ("Sides 1 Scale 1 -1 1", "-.6 0", disk),
        ("Sides 1 Orientation \"rh\"", "-.6 0", 0.0),
        ("Sides 1 Orientation \"lh\"", "-.6 0", disk),
        // A mirrored space is right-handed.
        ("Sides 1 Scale 1 -1 1 Orientation \"rh\"", "-.6 0", disk),
        ("Sides 1 Scale 1 -1 1 Orientation \"lh\"", "-.6 0", 0.0),
    ] {
        let found = part(attributes, heights);
        assert!((found - expected).abs() < 4e-3, "{attributes} {heights}: {found}, expected {expected}");
    }
}

#[test]
fn a_one_sided_disk_that_turns_over_is_seen_while_it_faces_the_eye() {
    // Half a turn at a constant rate: its outside is before the eye for the first half of the time.
    let turns = |attributes: &str, from: f32| {
        let world = format!(
            "{attributes} MotionBegin [0 1] Rotate {from} 1 0 0 Rotate {} 1 0 0 MotionEnd Disk 0 .5 360",
            from + 180.0
        );
        let image = draw("Shutter 0 1", &world);
        let middle = [(39, 39), (40, 39), (39, 40), (40, 40)];
        middle.into_iter().map(|(x, y)| image.at(x, y)[3]).sum::<f32>() / 4.0
    };
    assert!((turns("Sides 2", 0.0) - 1.0).abs() < 0.02);
    // At any time one of its sides is seen.
    let (outside, inside) = (turns("Sides 1", 0.0), turns("Sides 1 ReverseOrientation", 0.0));
    assert!((outside - 0.5).abs() < 0.02 && (inside - 0.5).abs() < 0.02, "{outside} {inside}");
    // From a quarter turn on, it is one side all the time.
    let (outside, inside) = (turns("Sides 1", 90.0), turns("Sides 1 ReverseOrientation", 90.0));
    assert!((outside.max(inside) - 1.0).abs() < 0.02 && outside.min(inside) < 0.02, "{outside} {inside}");
}

#[test]
fn given_normals_do_not_tell_sides_apart() {
    let square = "\"P\" [-.5 -.5 0 -.5 .5 0 .5 .5 0 .5 -.5 0]";
    for polygon in
        [format!("Polygon {square}"), "Patch \"bilinear\" \"P\" [-.5 -.5 0 -.5 .5 0 .5 -.5 0 .5 .5 0]".to_string()]
    {
        let seen = |attributes: &str, normals: &str| {
            draw("", &format!("{attributes} {polygon} {normals}")).coverage() / 1600.0
        };
        let plain = seen("Sides 1", "");
        for z in [-1, 1] {
            let normals = format!("\"N\" [0 0 {z} 0 0 {z} 0 0 {z} 0 0 {z}]");
            assert_eq!(seen("Sides 1", &normals), plain);
            assert!((seen("Sides 1", &normals) + seen("Sides 1 ReverseOrientation", &normals) - 1.0).abs() < 0.01);
        }
    }
}

#[test]
fn curves_show_the_eye_their_outside_and_have_the_normals_that_they_are_given() {
    let curves = "Curves \"linear\" [2] \"nonperiodic\" \"P\" [-.5 0 0 .5 0 0] \"constantwidth\" .5";
    let seen =
        |attributes: &str, normals: &str| draw("", &format!("{attributes} {curves} {normals}")).coverage() / 1600.0;
    for attributes in ["Sides 1", "Sides 1 Scale -1 1 1"] {
        assert!((seen(attributes, "") - 0.5).abs() < 0.01, "{attributes}");
        assert!((seen(attributes, "\"N\" [0 0 -1 0 0 -1]") - 0.5).abs() < 0.01, "{attributes}");
        assert_eq!(seen(attributes, "\"N\" [0 0 1 0 0 1]"), 0.0, "{attributes}");
    }
    // RISpec 5.5: a ribbon without "N" faces the eye; one with "N" lies across it.
    let shader = b"surface z() { Oi = 1; normal c = normalize(ntransform(\"camera\", N)); Ci = color(-zcomp(c), zcomp(c), ycomp(c)); }";
    for (normals, expected) in [
        ("", [1.0, -1.0, 0.0]),
        ("\"N\" [0 0 -1 0 0 -1]", [1.0, -1.0, 0.0]),
        ("\"N\" [0 .6 .8 0 .6 .8]", [-0.8, 0.8, 0.6]),
    ] {
        let image = render_with(&[("z.sl", shader)], ORTHO, &format!("Surface \"z\" {curves} {normals}"));
        let found = image.at(40, 40);
        assert!((0..3).all(|c| (found[c] - expected[c]).abs() < 1e-4), "{normals}: {found:?}, expected {expected:?}");
    }
}
