//! Motion blur and depth of field against answers known on paper.

use crate::cli::{scratch, scree};
use crate::rendering::{ORTHO, Rendered, render_with};

/// A parallel view of 80 × 80 pixels, 40 to a unit, while the shutter is open from 0 to 1.
fn moving(world: &str) -> Rendered {
    render_with(&[], &format!("Shutter 0 1 {ORTHO}"), &format!("Surface \"constant\" {world}"))
}

/// The mean coverage of a pixel column, rows 30 to 50.
fn column(p: &Rendered, x: usize) -> f32 {
    (30..50).map(|y| p.at(x, y)[3]).sum::<f32>() / 20.0
}

/// Everything to the left of x = 0.
const LEFT: &str = "Polygon \"P\" [-9 -9 0  0 -9 0  0 9 0  -9 9 0]";

#[test]
fn a_moving_edge_is_a_ramp() {
    // From x = −0.5 to 0.5: pixels 20 to 60. A pixel is covered for as long as the edge is to its right.
    let p = moving(&format!("MotionBegin [0 1] Translate -0.5 0 0 Translate 0.5 0 0 MotionEnd {LEFT}"));
    for x in 0..80 {
        let expected = (1.0 - (x as f32 + 0.5 - 20.0) / 40.0).clamp(0.0, 1.0);
        assert!((column(&p, x) - expected).abs() < 0.012, "column {x}: {}, expected {expected}", column(&p, x));
    }
}

#[test]
fn a_shutter_sees_its_part_of_many_segments() {
    // The edge rests at −0.5, moves to 0.5 from 1 to 2, and on to 0.6 at 3; the shutter sees 0.5 to 1.5: half rest, half way.
    let world = format!(
        "MotionBegin [0 1 2 3] Translate -0.5 0 0 Translate -0.5 0 0 Translate 0.5 0 0 Translate 0.6 0 0 MotionEnd {LEFT}"
    );
    let p = render_with(&[], &format!("Shutter 0.5 1.5 {ORTHO}"), &format!("Surface \"constant\" {world}"));
    for x in 0..80 {
        let ramp = (1.0 - (x as f32 + 0.5 - 20.0) / 20.0).clamp(0.0, 1.0);
        let expected = if x < 20 { 1.0 } else { 0.5 * ramp };
        assert!((column(&p, x) - expected).abs() < 0.015, "column {x}: {}, expected {expected}", column(&p, x));
    }
}

#[test]
fn everything_that_can_move_covers_its_mean_area() {
    let pixels = |area: f32| area * 1600.0;
    let pi = std::f32::consts::PI;
    // A sphere's radius from 0.3 to 0.6: the mean of r² is (0.09 + 0.18 + 0.36) / 3.
    let cases = [
        (
            "Patch \"bilinear\" \"P\" [-.5 -.5 0 .5 -.5 0 -.5 .5 0 .5 .5 0]
          Patch \"bilinear\" \"P\" [-.5 -.5 0 0 -.5 0 -.5 .5 0 0 .5 0]",
            0.75,
        ),
        ("Sphere .3 -.3 .3 360 Sphere .6 -.6 .6 360", pi * 0.21),
        ("Disk 0 .3 360 Disk 0 .6 360", pi * 0.21),
        (
            "Points \"P\" [-.4 0 0 .4 0 0] \"constantwidth\" .2 Points \"P\" [-.4 .3 0 .4 .1 0] \"constantwidth\" .2",
            pi * 0.02,
        ),
        ("Polygon \"P\" [0 0 0 .5 0 0 .5 .5 0 0 .5 0] Polygon \"P\" [0 0 0 .5 0 0 .5 1 0 0 1 0]", 0.375),
    ];
    for (two, area) in cases {
        let p = moving(&format!("MotionBegin [0 1] {two} MotionEnd"));
        let error = (p.coverage() - pixels(area)).abs() / pixels(area);
        assert!(error < 0.012, "{two}: {} pixels, expected {}", p.coverage(), pixels(area));
    }
    // A ball that grows and shrinks again, and comes to the side meanwhile, has the same mean.
    let thrice = "Points \"P\" [0 0 0] \"constantwidth\" .6 Points \"P\" [.2 0 0] \"constantwidth\" 1.2
        Points \"P\" [0 0 0] \"constantwidth\" .6";
    let p = moving(&format!("MotionBegin [0 0.5 1] {thrice} MotionEnd"));
    let error = (p.coverage() - pixels(pi * 0.21)).abs() / pixels(pi * 0.21);
    assert!(error < 0.012, "{} pixels, expected {}", p.coverage(), pixels(pi * 0.21));
}

#[test]
fn a_moving_camera_sees_what_a_moving_world_shows() {
    let ball = "Surface \"constant\" Translate 0.1 0.2 0 Sphere .4 -.4 .4 360";
    let options = format!("Shutter 0 1 {ORTHO}");
    let still =
        render_with(&[], &options, &format!("MotionBegin [0 1] Translate 0 0 0 Translate .3 .1 0 MotionEnd {ball}"));
    let moved =
        render_with(&[], &format!("{options} MotionBegin [0 1] Translate 0 0 0 Translate .3 .1 0 MotionEnd"), ball);
    assert!(still.coverage() > 500.0);
    for (a, b) in still.pixels.iter().zip(&moved.pixels) {
        assert!((a[3] - b[3]).abs() <= 2.0 / 64.0, "{a:?} {b:?}");
    }
}

#[test]
fn a_point_out_of_focus_is_a_circle_of_confusion() {
    // 100 pixels across 90°: 50 pixels to a unit at depth 1. The lens is 0.5 / 1 across, sharp at 4.
    for z in [1.5f32, 2.0, 4.0, 16.0] {
        let options = "DepthOfField 1 0.5 4 Format 100 100 1 PixelSamples 8 8 PixelFilter \"box\" 1 1 Projection \"perspective\" \"fov\" 90";
        // A disk of two pixels.
        let r = 0.04 * z;
        let p = render_with(&[], options, &format!("Surface \"constant\" Translate 0 0 {z} Disk 0 {r} 360"));
        let radius = 50.0 * 0.25 * (1.0 / z - 0.25f32).abs();
        let (mut weight, mut square, mut reach) = (0.0, 0.0, 0.0f32);
        for y in 0..100 {
            for x in 0..100 {
                let a = p.at(x, y)[3];
                let d = ((x as f32 - 49.5).powi(2) + (y as f32 - 49.5).powi(2)).sqrt();
                weight += a;
                square += a * d * d;
                reach = if a > 0.0 { reach.max(d) } else { reach };
            }
        }
        // What is blurred keeps its area; an even disk's mean square is half its radius', and so is that of the point itself.
        let area = std::f32::consts::PI * 4.0;
        assert!((weight - area).abs() < 0.05 * area, "z {z}: {weight} pixels, expected {area}");
        let expected = 0.5 * (radius * radius + 4.0) + 1.0 / 6.0;
        assert!(
            (square / weight - expected).abs() < 0.06 * expected,
            "z {z}: {}, expected {expected}",
            square / weight
        );
        assert!(reach < radius + 2.0 + 1.0, "z {z}: reaches {reach}, radius {radius}");
    }
}

#[test]
fn blur_opens_no_holes() {
    // Nothing of a bright background comes through a displaced sphere, a mesh and a patch that move before a lens.
    let options =
        "Shutter 0 1 DepthOfField 2 0.4 3 Format 80 60 1 PixelSamples 8 8 Projection \"perspective\" \"fov\" 40
        Option \"limits\" \"uniform integer bucketsize\" [16]";
    let moves = "MotionBegin [0 0.4 1] Rotate 0 1 2 3 Rotate 9 1 2 3 Rotate 14 1 2 3 MotionEnd";
    let things = [
        "Displacement \"rock\" \"uniform float Km\" [0.1] \"uniform float size\" [0.5] Sphere 2.2 -2.2 2.2 360".to_string(),
        "SubdivisionMesh \"catmull-clark\" [4 4 4 4 4 4] [0 1 3 2  4 6 7 5  0 2 6 4  1 5 7 3  0 4 5 1  2 3 7 6] \"P\" [-3 -3 -3 3 -3 -3 -3 3 -3 3 3 -3 -3 -3 3 3 -3 3 -3 3 3 3 3 3]".into(),
        "Patch \"bicubic\" \"P\" [-4 -4 0 -1 -4 1 1 -4 0 4 -4 1  -4 -1 1 -1 -1 0 1 -1 -1 4 -1 0  -4 1 0 -1 1 -1 1 1 1 4 1 0  -4 4 1 -1 4 0 1 4 1 4 4 0]".into(),
    ];
    for thing in things {
        let p = render_with(&[], options, &format!("Surface \"constant\" Color 0 0 0 Translate 0 0 5 {moves} {thing}"));
        for y in 10..50 {
            for x in 10..70 {
                assert!(p.at(x, y)[3] > 0.9999, "({x}, {y}) of {thing}: {}", p.at(x, y)[3]);
            }
        }
    }
}

#[test]
fn data_with_velocities_is_blurred_and_a_lens_focuses() {
    let work = scratch();
    let at = |name: &str| work.path().join(name);
    // A ball of 0.2 m at 2 m/s; in 0.5 s it comes 1 m far.
    std::fs::write(at("a_1.csv"), "pos_x,pos_y,pos_z,vel_x,vel_y,vel_z\n-0.5,0,0,2,0,0\n").unwrap();
    let metadata = |more: &str, lens: &str| {
        format!(
            "data: {{csv: 'a_*.csv'}}
scene: plain.rib
camera: {{eye: [0, -5, 0], look_at: [0, 0, 0], fov: 40{lens}}}
objects: [{{name: ball, geometry: {{sphere: {{radius: 0.2}}}}, surface: {{name: constant}}, color: [1, 1, 1]}}]
output: {{resolution: [80, 80], samples: [8, 8], format: exr{more}}}
"
        )
    };
    std::fs::write(
        at("plain.rib"),
        "#scree inject camera\n#scree override Format\n#scree override Display\n#scree override PixelSamples\nWorldBegin\n#scree inject objects\nWorldEnd\n",
    )
    .unwrap();
    let draw = |name: &str, text: String| {
        std::fs::write(at(name), text).unwrap();
        scree(&["render", at(name).to_str().unwrap(), "-o", at("out").to_str().unwrap()]).ok();
        image::open(at("out/000001.exr")).unwrap().to_rgb32f()
    };
    let widest = |image: &image::Rgb32FImage| (0..80).filter(|x| image.get_pixel(*x, 40).0[0] > 0.02).count();
    let total = |image: &image::Rgb32FImage| image.pixels().map(|p| p.0[0]).sum::<f32>();
    let still = draw("still.yaml", metadata("", ""));
    let moved = draw("moved.yaml", metadata(", shutter: 0.5", ""));
    let blurred = draw("lens.yaml", metadata("", ", lens: {f_stop: 1, focal_length: 0.5, focus: 2}"));
    // 80 pixels show 2 · 5 · tan 20° = 3.64 m: 22 pixels a metre.
    let (a, b) = (widest(&still), widest(&moved));
    assert!((9..=11).contains(&a) && (30..=33).contains(&b), "{a} and {b} pixels wide");
    assert!((total(&moved) - total(&still)).abs() < 0.03 * total(&still));
    assert!(widest(&blurred) > a + 10 && (total(&blurred) - total(&still)).abs() < 0.1 * total(&still));
}

#[test]
fn what_moves_through_the_camera_comes_to_an_end() {
    let view = "Format 64 48 1 PixelSamples 2 2 Projection \"perspective\" \"fov\" 40";
    let through = "MotionBegin [0 1] Translate 0 0 0 Translate 0 0 8 MotionEnd";
    let ground = "Polygon \"P\" [-9 -1 -9 9 -1 -9 9 -1 90 -9 -1 90]";
    let cases = [
        // The camera goes through a ball and along a ground; a ball comes through the camera, displaced far more than it says.
        (format!("Shutter 0 1 DepthOfField 2 1 3 {view} {through}"), format!("{ground} Sphere 1 -1 1 360")),
        (
            format!("Shutter 0 1 {view}"),
            "MotionBegin [0 1] Translate 0 0 -3 Translate 0 0 3 MotionEnd Displacement \"rock\" \"uniform float Km\" 100
            Attribute \"displacementbound\" \"sphere\" 1 Sphere 1 -1 1 360"
                .to_string(),
        ),
        // It shrinks to nothing, and goes where single precision ends.
        (
            format!("Shutter 0 1 {view} Translate 0 0 5"),
            "MotionBegin [0 1] Scale 1 1 1 Scale 0 0 0 MotionEnd Sphere 1 -1 1 360 Identity
            MotionBegin [0 1] Translate 0 0 0 Translate 1e30 0 5 MotionEnd Sphere 1 -1 1 360"
                .to_string(),
        ),
    ];
    for (options, world) in cases {
        let p = render_with(&[], &options, &format!("Surface \"constant\" {world}"));
        assert!(p.pixels.iter().flatten().all(|x| x.is_finite()));
    }
    let work = scratch();
    let path = work.path().join("t.rib");
    std::fs::write(&path, "WorldBegin\nMotionBegin [0 1]\nTranslate 0 0 0\nMotionEnd\nWorldEnd\n").unwrap();
    let said = scree(&["render", path.to_str().unwrap()]).fails(3);
    assert!(said.contains("t.rib:4:1") && said.contains("2 times"), "{said}");
}

/// A lens spreads what it sees, and adds nothing: a ball of 7 pixels far out of focus, diced coarsely, covers its disk.
#[test]
fn a_small_ball_out_of_focus_covers_as_much_as_in_focus() {
    for x in [0.0, 0.11, 0.31] {
        let covered = |lens: &str| {
            let camera = format!(
                "Format 200 200 1 PixelSamples 8 8 PixelFilter \"box\" 1 1 {lens} Projection \"perspective\" \"fov\" [20]"
            );
            let ball = format!("Surface \"constant\" Translate {x} 0.03 4 Sphere 0.05 -0.05 0.05 360");
            render_with(&[], &camera, &ball).coverage()
        };
        let [sharp, blurred] = [covered(""), covered("DepthOfField 0.5 0.2 2")];
        assert!((blurred / sharp - 1.0).abs() < 0.025, "at {x}: {blurred}, {sharp} in focus");
    }
}
