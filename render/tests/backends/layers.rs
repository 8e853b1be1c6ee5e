//! Layers on a device: faces that meet, and opacities that are none.

use super::{CAMERA, LIT, compare, device, render};
use render::DrawnBy;

/// A mesh of five by five faces across the image and beyond it, which lean to each other as `height` says.
fn mesh(height: impl Fn(f32, f32) -> f32) -> String {
    let at = |k: usize| 0.6 * k as f32 - 1.5;
    let point = |k: usize| {
        let (i, j) = (k % 6, k / 6);
        // Off the lines of strata.
        let off =
            if (1..5).contains(&i) && (1..5).contains(&j) { 0.03 * ((7 * i + 3 * j) % 5) as f32 - 0.06 } else { 0.0 };
        let (x, y) = (at(i) + off, at(j) - off);
        format!("{x} {y} {} ", height(x, y))
    };
    let corners = (0..25).map(|k| k / 5 * 6 + k % 5).map(|k| format!("{k} {} {} {} ", k + 1, k + 7, k + 6));
    let (corners, points): (String, String) = (corners.collect(), (0..36).map(point).collect());
    format!("PointsPolygons [{}] [{corners}] \"P\" [{points}] ", "4 ".repeat(25))
}

/// A mesh lets through what its opacity says, on the edges of its faces as in their middle.
#[test]
fn an_edge_of_two_faces_is_one_layer_on_a_device() {
    let Some(device) = device() else { return };
    let camera =
        "Format 96 96 1 PixelSamples 4 4 PixelFilter \"box\" 1 1 Projection \"orthographic\" Translate 0 0 5 WorldBegin
        Surface \"constant\" Opacity [0.5 0.5 0.5]\n";
    let moves = "MotionBegin [0 1] Translate 0 0 0 Translate 0.1 0.05 0.3 MotionEnd";
    for height in [|_: f32, _: f32| 0.0f32, |x: f32, y: f32| 0.4 * x.abs() + 0.3 * y] {
        let mesh = mesh(height);
        for (what, options, world, expected) in [
            ("one", "", mesh.clone(), 0.5),
            ("moving", "Shutter 0 1", format!("{moves} {mesh}"), 0.5),
            ("through a lens", "DepthOfField 4 0.2 5", mesh.clone(), 0.5),
            ("two in one place", "", format!("{mesh} {mesh}"), 0.75),
            ("two that nearly touch", "", format!("{mesh} Translate 0 0 0.0001 {mesh}"), 0.75),
        ] {
            let drawn = render(&format!("{options} {camera} {world} WorldEnd"), Some(device.clone()), None);
            assert_eq!(drawn.drawn_by, DrawnBy::Gpu);
            let off = drawn.image.pixels.iter().filter(|p| (p[3] - expected).abs() > 1e-5).count();
            assert_eq!(off, 0, "pixels of {what}");
        }
    }
}

/// The same of steep surfaces, on which depths differ much within the width of an edge; and samples see the same triangles as on the processor.
#[test]
fn an_edge_on_a_steep_surface_is_one_layer_on_a_device() {
    let Some(device) = device() else { return };
    let camera =
        "Format 64 64 1 PixelSamples 4 4 PixelFilter \"box\" 1 1 Projection \"perspective\" \"fov\" 60 WorldBegin
        Surface \"constant\" Opacity [0.5 0.5 0.5] Translate 0 0 4\n";
    let moves = "MotionBegin [0 1] Translate 0 0 0 Translate 0.1 0.05 0.3 MotionEnd";
    let mesh = mesh(|_, _| 0.0);
    for surface in ["Disk 0 2 360", &mesh] {
        for turn in
            ["Rotate 2.362 0.253 1.73 0.246 Scale 9.28 9.28 9.28", "Rotate 67.124 1.38 0.206 0.266 Scale 11 11 11"]
        {
            for (options, moves) in [("", ""), ("Shutter 0 1", moves), ("DepthOfField 4 0.2 4", "")] {
                let rib = format!("{options} {camera} {moves} {turn} {surface} WorldEnd");
                let drawn = render(&rib, Some(device.clone()), None);
                assert_eq!(drawn.drawn_by, DrawnBy::Gpu);
                let off = drawn.image.pixels.iter().filter(|p| p[3] > 0.5 + 1e-5).count();
                // As on the processor, sides that are blurred may be cut unlike those beside them.
                assert!(
                    off <= if options.is_empty() { 0 } else { 2 },
                    "{off} pixels of {options} {turn} {surface:.10}"
                );
                let opaque = rib.replace("[0.5 0.5 0.5]", "[1 1 1]").replace("constant", "matte");
                // What its shader could make translucent is sampled as layers are.
                let fog = opaque.replace("WorldBegin", "WorldBegin Atmosphere \"fog\" \"uniform float distance\" 5");
                assert!(compare(&fog, &device).agrees(), "{options} {turn} {surface:.10}");
            }
        }
    }
}

/// Opacities that are none are reported alike, with the shader, and infinite colours are finite in an image.
#[test]
fn opacities_that_are_none_are_reported_on_a_device() {
    let Some(device) = device() else { return };
    let patch = "Attribute \"visibility\" \"string transmission\" \"opaque\" Patch \"bilinear\" \"P\" [-2 -1 0 2 -1 0 -2 1 1 2 1 1]";
    let world = format!("{patch} \"varying color Os\" [-2 -1 0 3 2 1 1 0.5 -1 0.3 4 0.9]");
    let said = |device| {
        let result = render(&format!("{CAMERA}{LIT}{world} WorldEnd"), device, None);
        let is_gpu = result.drawn_by == DrawnBy::Gpu;
        let warnings: Vec<String> = result.warnings.iter().filter(|w| w.contains("below 0")).cloned().collect();
        let without_count =
            |w: &String| w.split(" points").next().unwrap().trim_end_matches(char::is_numeric).to_string();
        (is_gpu, warnings.iter().map(without_count).collect::<Vec<String>>())
    };
    let (own, other) = (said(Some(device.clone())), said(None));
    assert!(own.0 && !other.0);
    assert!(own.1.len() == 1 && own.1[0].contains("the shader `matte`"), "{:?}", own.1);
    assert_eq!(own.1, other.1);
    let bright = "Color [1e30 1e30 1e30] LightSource \"ambientlight\" \"c\" \"intensity\" 1e30 Sphere 1 -1 1 360";
    let drawn = render(&format!("{CAMERA}{LIT}{bright} WorldEnd"), Some(device), None);
    assert_eq!(drawn.drawn_by, DrawnBy::Gpu);
    assert!(drawn.image.pixels.iter().flatten().all(|x| x.is_finite()));
    assert!(drawn.image.pixels.iter().any(|pixel| pixel[0] >= 1e29));
}
