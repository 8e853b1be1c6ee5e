//! Primitives that stand in one place and are alike in all: what they come to, known on paper, shaded once.

use crate::cli::{scratch, scree};
use crate::rendering::{ORTHO, render_with};

/// Looking along z from −5, ±1 across the image, at four samples a pixel.
const PLAIN: &str =
    "Format 64 64 1 PixelSamples 2 2 PixelFilter \"box\" 1 1 Projection \"orthographic\" Translate 0 0 5";

fn assert_near(found: f32, expected: f32, what: &str) {
    assert!((found - expected).abs() < 2e-4, "{what}: {found}, expected {expected}");
}

/// What shaders move and let light through: they do the same to what is alike in all.
#[test]
fn primitives_of_one_look_in_one_place_are_shaded_once() {
    let stats_of = |world: &str| {
        let work = scratch();
        let at = |name: &str| work.path().join(name).to_str().unwrap().to_string();
        std::fs::write(at("grow.sl"), "displacement grow(float k = .1;) { P += k * normalize(N); }").unwrap();
        let text = format!("Display \"t.png\" \"png\" \"rgb\"\n{ORTHO}\nWorldBegin\n{world}\nWorldEnd\n");
        std::fs::write(at("t.rib"), text).unwrap();
        scree(&["render", &at("t.rib"), "--stats", "-o", &at("")]).ok();
        let stats = std::fs::read(at("t.png.stats.json")).unwrap();
        serde_json::from_slice::<serde_json::Value>(&stats).unwrap()["stats"].clone()
    };
    let sphere = "Sphere 0.5 -0.5 0.5 360\n";
    let object = format!("ObjectBegin 1\n{sphere}ObjectEnd\n");
    let lit = "LightSource \"distantlight\" 1\n";
    let grow = "Displacement \"grow\" Attribute \"displacementbound\" \"float sphere\" [.2] Surface \"matte\"\n";
    let glass = "Surface \"glass\"\n";
    for (looks, shape) in [
        (format!("{lit}{grow}"), sphere.to_string()),
        (format!("{lit}{glass}"), sphere.to_string()),
        (format!("{lit}{grow}{glass}Attribute \"displacementbound\" \"float sphere\" [.2]\n"), sphere.to_string()),
        // Each with shaders of its own.
        (lit.into(), format!("AttributeBegin {grow}{sphere}AttributeEnd\n")),
        (lit.into(), format!("AttributeBegin {glass}{sphere}AttributeEnd\n")),
        (format!("{lit}{glass}{object}"), "ObjectInstance 1\n".into()),
        (format!("{lit}{glass}"), "Patch \"bilinear\" \"P\" [-1 -1 0 1 -1 0 -1 1 0 1 1 1]\n".into()),
    ] {
        let [one, many] = [1, 400].map(|n| stats_of(&format!("{looks}{}", shape.repeat(n))));
        for what in ["micropolygons", "shaded_points", "samples", "items"] {
            assert_eq!(one[what], many[what], "{what} of {looks}{shape}");
        }
    }
    // What differs in anything that its shaders may see is drawn.
    let items = |world: &str| stats_of(world)["items"].as_u64().unwrap();
    for other in [
        "Color 1 0 0",
        "Surface \"glass\" \"Kr\" .5",
        "LightSource \"ambientlight\" 2",
        "Attribute \"user\" \"float k\" [1]",
        "Displacement \"grow\" \"k\" .05",
        "Attribute \"displacementbound\" \"float sphere\" [.3]",
        "Interior \"fog\"",
        "TextureCoordinates 0 0 2 0 0 2 2 2",
    ] {
        let shape = "Patch \"bilinear\" \"P\" [-1 -1 0 1 -1 0 -1 1 0 1 1 1]\n";
        assert_eq!(items(&format!("{glass}{shape}{other}\n{shape}")), 2 * items(&format!("{glass}{shape}")), "{other}");
    }
    // What shaders move or let light through hides nothing that they leave as it is, and is not hidden by that.
    let plain = "Surface \"matte\"\n";
    for other in [glass, grow] {
        for [first, second] in [[other, plain], [plain, other]] {
            let world =
                format!("AttributeBegin {first}{sphere}AttributeEnd AttributeBegin {second}{sphere}AttributeEnd\n");
            assert_eq!(items(&world), 2 * items(sphere), "{world}");
        }
    }
    let varied =
        |k: f32| format!("Patch \"bilinear\" \"P\" [-1 -1 0 1 -1 0 -1 1 0 1 1 1] \"varying float Kr\" [0 0 {k} 1]\n");
    assert_eq!(items(&format!("{glass}{}{}", varied(0.0), varied(1.0))), 2 * items(&format!("{glass}{}", varied(0.0))));
}

/// A part o of the light is kept by each of n surfaces in one place, whichever way that is found: (1 − o)ⁿ passes, and what they
/// shine is the sum of what is not hidden by those before.
#[test]
fn surfaces_of_one_look_in_one_place_let_through_what_all_do() {
    const PANE: &[u8] = b"surface pane(float k = .05;) { Oi = k * Os; Ci = k * Cs; }";
    const MIRROR: &[u8] = b"surface mirror() { Ci = trace(P, vector(0, 0, 1)); Oi = 1; }";
    const TOLD: &[u8] = b"surface told() { Ci = transmission(P, P + vector(0, 0, 9)); Oi = 1; }";
    let files: [(&str, &[u8]); 3] = [("pane.sl", PANE), ("mirror.sl", MIRROR), ("told.sl", TOLD)];
    let small = PLAIN.replace("64 64", "16 16");
    for (shape, surfaces) in
        [("Sphere .7 -.7 .7 360\n", 2), ("Polygon \"P\" [-1 -1 0 1 -1 0 1 1 0 -1 1 0]\n", 1), ("ObjectInstance 1\n", 2)]
    {
        let object = "Color [.8 .4 .2] Surface \"pane\" ObjectBegin 1 Sphere .7 -.7 .7 360 ObjectEnd\n";
        for n in [1usize, 2, 20, 150] {
            let passes = 0.95f32.powi((surfaces * n) as i32);
            let all = format!("{object}{}", shape.repeat(n));
            let [r, g, b, a] = render_with(&files, &small, &all).at(8, 8);
            let expected = [0.8, 0.4, 0.2, 1.0].map(|c| c * (1.0 - passes));
            for (found, expected) in [r, g, b, a].into_iter().zip(expected) {
                assert_near(found, expected, &format!("{n} of {shape}"));
            }
            let before = "Polygon \"P\" [-1 -1 -1 1 -1 -1 1 1 -1 -1 1 -1]\n";
            let seen_by = |shader: &str| {
                let world = format!("{all}Surface \"{shader}\" {before}");
                render_with(&files, &small, &world).at(8, 8)
            };
            let found = seen_by("mirror")[0];
            // A ray ends where less than a thousandth is left of it.
            assert!(
                (found - expected[0]).abs() < 1e-3,
                "a ray that meets {n} of {shape}: {found}, expected {}",
                expected[0]
            );
            let found = seen_by("told")[1];
            assert!((found - passes).abs() < 1e-3, "light through {n} of {shape}: {found}, expected {passes}");
        }
    }
}

/// What displays take of them besides.
#[test]
fn values_of_surfaces_of_one_look_are_those_of_all() {
    let shader =
        b"surface pane(output varying color light = 0;) { light = color(0.5, 1, 0.25); Oi = .2 * Os; Ci = Oi * Cs; }";
    let kept = 1.0 - 0.8f32.powi(8);
    for (mode, expected) in [
        ("Ci", [0.8 * kept, 0.4 * kept, 0.2 * kept]),
        ("Oi", [kept; 3]),
        ("color light", [0.5 * kept, kept, 0.25 * kept]),
    ] {
        let work = scratch();
        std::fs::write(work.path().join("pane.sl"), shader).unwrap();
        let path = work.path().join("t.rib");
        let pane = "Polygon \"P\" [-1 -1 0 1 -1 0 1 1 0 -1 1 0]\n".repeat(8);
        let world = format!("Surface \"pane\" Color [.8 .4 .2]\n{pane}");
        let text = format!("Display \"t.exr\" \"exr\" \"{mode}\"\n{PLAIN}\nWorldBegin\n{world}\nWorldEnd\n");
        std::fs::write(&path, text).unwrap();
        scree(&["render", path.to_str().unwrap(), "-o", work.path().to_str().unwrap()]).ok();
        let image = image::open(work.path().join("t.exr")).unwrap().to_rgb32f();
        for (found, expected) in image.get_pixel(32, 32).0.into_iter().zip(expected) {
            assert_near(found, expected, mode);
        }
    }
}
