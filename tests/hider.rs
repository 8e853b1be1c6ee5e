//! What is drawn at all and how closely it is looked at: levels of detail, hiders, bounds of displacement.

use crate::cli::{scratch, scree};
use crate::rendering::{ORTHO, Rendered, render_with};

fn render(options: &str, world: &str) -> Rendered {
    render_with(&[], options, world)
}

#[test]
fn levels_of_detail_are_chosen_by_their_size_on_the_raster() {
    // A square of 40 pixels a side has a detail of 1600.
    let draw = |range: &str, factor: f32| {
        let world = format!(
            "Surface \"constant\" AttributeBegin Detail [-.5 .5 -.5 .5 0 0] DetailRange [{range}]
            Polygon \"P\" [-.5 -.5 0 .5 -.5 0 .5 .5 0 -.5 .5 0] AttributeEnd Color 0 1 0 Polygon \"P\" [-1 -1 1 1 -1 1 1 1 1 -1 1 1]"
        );
        render(&format!("RelativeDetail {factor} {ORTHO}"), &world).at(40, 40)[0]
    };
    for (range, factor, seen) in [
        ("0 0 1e6 1e6", 1.0, 1.0),
        ("1500 1500 1700 1700", 1.0, 1.0),
        ("1700 1700 1e6 1e6", 1.0, 0.0),
        ("0 0 1500 1500", 1.0, 0.0),
        ("0 0 1500 1500", 0.5, 1.0),
        ("1200 2000 1e6 1e6", 1.0, 0.5),
        ("0 0 1500 1900", 1.0, 0.75),
    ] {
        let found = draw(range, factor);
        assert!((found - seen).abs() < 2e-3, "[{range}] at {factor}: {found}, expected {seen}");
    }
    let work = scratch();
    std::fs::write(work.path().join("t.rib"), "WorldBegin DetailRange [5 4 6 7] WorldEnd").unwrap();
    let said = scree(&["render", work.path().join("t.rib").to_str().unwrap()]).fails(3);
    assert!(said.contains("t.rib:1:12") && said.contains("do not fall"), "{said}");
}

#[test]
fn the_depth_hider_samples_once_and_blurs_nothing() {
    let moving =
        "MotionBegin [0 1] Translate -.5 0 0 Translate .5 0 0 MotionEnd Surface \"constant\" Sphere .3 -.3 .3 360";
    let still = "Translate -.5 0 0 Surface \"constant\" Sphere .3 -.3 .3 360";
    let options = format!("Shutter 0 1 {ORTHO} DepthOfField 1 1 2");
    let (a, b) = (render(&format!("{options} Hider \"z\""), moving), render(&format!("{ORTHO} Hider \"z\""), still));
    assert!(a.pixels == b.pixels);
    assert!(a.pixels.iter().all(|p| p[3] == 0.0 || p[3] == 1.0));
    let blurred = render(&options, moving);
    assert!(blurred.pixels.iter().filter(|p| p[3] > 0.0 && p[3] < 1.0).count() > 500);
}

#[test]
fn the_null_hider_makes_no_picture() {
    let work = scratch();
    let at = |name: &str| work.path().join(name).to_str().unwrap().to_string();
    std::fs::write(
        at("t.rib"),
        "Display \"t.png\" \"png\" \"rgb\" Hider \"null\" WorldBegin Sphere 1 -1 1 360 WorldEnd",
    )
    .unwrap();
    scree(&["render", &at("t.rib"), "-o", &at("out")]).ok();
    assert!(!work.path().join("out/t.png").exists());
}

#[test]
fn a_bound_that_is_too_small_is_said_with_the_one_that_is_needed() {
    let work = scratch();
    let at = |name: &str| work.path().join(name).to_str().unwrap().to_string();
    std::fs::write(at("out.sl"), "displacement out(float far = 0;) { P += far * normalize(N); }").unwrap();
    for (bound, warned) in [(0.1, true), (0.31, false)] {
        let scene = format!(
            "Display \"t.png\" \"png\" \"rgb\" Projection \"perspective\" Translate 0 0 5 WorldBegin
            Displacement \"out\" \"uniform float far\" 0.6 Attribute \"displacementbound\" \"sphere\" {bound} Scale 2 2 2 Sphere 1 -1 1 360 WorldEnd"
        );
        std::fs::write(at("t.rib"), scene).unwrap();
        let answer = scree(&["render", &at("t.rib"), "-o", &at("o")]);
        answer.ok();
        let said = answer.errors();
        // 0.6 in the world is 0.3 in the sphere's own space, and a hundredth for safety.
        let found = said.contains("displacement `out` reaches farther") && said.contains("[0.303");
        assert_eq!(found, warned, "{said}");
    }
}

/// Squares of half an edge about the origin of the plane z = 0, the first seen wholly, and all others as far as those before them leave them.
#[test]
fn of_surfaces_in_one_plane_the_first_is_seen_and_an_area_light_before_it() {
    let square = |color: &str, half: f32| {
        let p = format!("{0} {0} 0 {1} {0} 0 {1} {1} 0 {0} {1} 0", -half, half);
        format!("Color {color} Polygon \"P\" [{p}]\n")
    };
    let (small, middle, large) = (square("1 0 0", 0.5), square("0 1 0", 0.9), square("0 0 1", 20.0));
    let lamp = format!("AttributeBegin AreaLightSource \"arealight\" 1 {small} AttributeEnd\n");
    let mesh = "Color 0 0 1 PointsPolygons [4 4] [0 1 2 3 3 2 4 5] \"P\" [-20 -20 0 20 -20 0 20 .1 0 -20 .1 0 20 20 0 -20 20 0]\n";
    let turned = "TransformBegin Rotate 31 0 0 1 Rotate 50 1 0 0 Rotate -50 1 0 0 Rotate -31 0 0 1\n";
    let draw = |options: &str, view: &str, world: &str| {
        render(&format!("Format 96 72 1 PixelSamples 2 2 PixelFilter \"box\" 1 1 {options} {view}"), world)
    };
    let perspective = "Projection \"perspective\" \"fov\" [40]";
    let views = [[0.0, 12.0], [33.0, 70.0], [-71.0, 81.0], [140.0, 88.0], [45.0, 89.3]]
        .map(|[around, down]| format!("Translate 0 0 4 Rotate {} 1 0 0 Rotate {around} 0 0 1", -down));
    let open = "Projection \"perspective\" \"fov\" [40] Shutter 0 1 MotionBegin [0 1] Translate 0 0 0 Translate .2 .1 .3 MotionEnd";
    let mut n = 0;
    for (options, world) in [
        (perspective, format!("{small}{middle}{large}")),
        (perspective, format!("{large}{lamp}")),
        (perspective, format!("{lamp}{mesh}")),
        (perspective, format!("{turned}{small}TransformEnd {large}")),
        (perspective, format!("ShadingRate 25 {small} ShadingRate .5 {large}")),
        (perspective, format!("{small} ShadingRate 100 {large}")),
        (perspective, format!("{small} Opacity .5 .5 .5 {large}")),
        (perspective, format!("ObjectBegin 1 {small} ObjectEnd ObjectInstance 1 {large}")),
        ("Projection \"orthographic\" ScreenWindow -2 2 -1.5 1.5", format!("{small}{large}")),
        ("Projection \"perspective\" \"fov\" [40] DepthOfField 4 .5 5", format!("{small}{large}")),
        (open, format!("{small}{large}")),
    ] {
        let world = format!("Surface \"constant\"\n{world}");
        for view in &views {
            let alone = draw(options, view, &format!("Surface \"constant\"\n{small}"));
            let all = draw(options, view, &world);
            for (k, (alone, found)) in
                alone.pixels.iter().zip(&all.pixels).enumerate().filter(|(_, (p, _))| p[3] == 1.0)
            {
                n += 1;
                let is_seen = (0..3).all(|c| (found[c] - alone[c]).abs() < 1e-5);
                assert!(is_seen, "pixel {k} is {found:?} from {view}: {world}");
            }
        }
        // What is no light and comes later lies behind.
        let hidden = draw(options, &views[1], &format!("Surface \"constant\"\n{large}{small}"));
        assert!(hidden.pixels.iter().all(|p| p[0] == 0.0), "{options}");
    }
    assert!(n > 5_000, "{n}");
}

/// A ribbon has its width where it bends, too, by half a circle in one segment: what it covers is its length times that.
#[test]
fn cubic_curves_have_their_width_where_they_bend() {
    let arch = [[-0.6f32, -0.8], [-0.6, 1.2], [0.6, 1.2], [0.6, -0.8]];
    let wave = [[-0.8f32, -0.8], [-0.8, 0.9], [0.8, -0.9], [0.8, 0.8]];
    let bow = [[-0.8f32, 0.0], [-0.3, 0.6], [0.3, 0.6], [0.8, 0.0]];
    for control in [arch, wave, bow] {
        let at = |t: f32| {
            let s = 1.0 - t;
            let weights = [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t];
            [0, 1].map(|c| (0..4).map(|k| weights[k] * control[k][c]).sum::<f32>())
        };
        let step = |k: usize| {
            let [a, b] = [at(k as f32 / 1000.0), at((k + 1) as f32 / 1000.0)];
            (b[0] - a[0]).hypot(b[1] - a[1])
        };
        let length: f32 = (0..1000).map(step).sum();
        let points: Vec<String> = control.iter().map(|[x, y]| format!("{x} {y} 0")).collect();
        let points = points.join(" ");
        for width in [0.05, 0.2] {
            let image = render(
                ORTHO,
                &format!(
                    "Surface \"constant\" Curves \"cubic\" [4] \"nonperiodic\" \"P\" [{points}] \"constantwidth\" [{width}]"
                ),
            );
            let (area, expected) = (image.coverage() / 1600.0, width * length);
            assert!((area / expected - 1.0).abs() < 0.01, "{points}, {width}: {area}, expected {expected}");
        }
    }
}

/// A ribbon that bends covers what its segments measure, as half as much is added outside as is taken inside, and nothing twice.
#[test]
fn linear_curves_are_one_layer_where_they_bend() {
    for (curve, length) in [
        ("[3] \"nonperiodic\" \"P\" [-.5 -.5 0 .5 -.5 0 .5 .5 0]", 2.0),
        ("[6] \"nonperiodic\" \"P\" [-.5 -.5 0 -.5 -.5 0 .5 -.5 0 .5 -.5 0 .5 .5 0 .5 .5 0]", 2.0),
        ("[4] \"periodic\" \"P\" [-.5 -.5 0 .5 -.5 0 .5 .5 0 -.5 .5 0]", 4.0),
        ("[3] \"nonperiodic\" \"P\" [-.5 -.5 0 .5 -.5 0 -.2 .2 0]", 1.0 + 0.98f32.sqrt()),
    ] {
        let image = render(
            ORTHO,
            &format!("Surface \"constant\" Opacity .5 .5 .5 Curves \"linear\" {curve} \"constantwidth\" [.2]"),
        );
        let most = image.pixels.iter().map(|p| p[3]).fold(0.0, f32::max);
        assert!((most - 0.5).abs() < 1e-4, "{curve}: {most}");
        // 40 pixels are a unit.
        let (area, expected) = (image.coverage() / 0.5 / 1600.0, 0.2 * length);
        assert!((area / expected - 1.0).abs() < 0.01, "{curve}: {area}, expected {expected}");
    }
    // One that turns back at once has no mitre, and is drawn all the same.
    let back = render(
        ORTHO,
        "Surface \"constant\" Curves \"linear\" [3] \"nonperiodic\" \"P\" [-.5 0 0 .5 0 0 -.5 0 0] \"constantwidth\" [.2]",
    );
    assert!((back.coverage() / 1600.0 - 0.2).abs() < 0.002, "{}", back.coverage());
}
