//! Shaders of users, `tests/shaders/*.sl`, which use the language in ways that the library does not: they are drawn on a device, and as on the
//! processor.

use super::{Compared, compared, device, drawn};
use render::{DeviceRenderer, DrawnBy};
use std::path::{Path, PathBuf};
use std::sync::Arc;

const VIEW: &str = "Format 64 48 1 PixelSamples 3 3 PixelFilter \"gaussian\" 2 2 Projection \"perspective\" \"fov\" 45
    Translate 0 0 6 Rotate -35 1 0 0 Rotate 20 0 1 0\n";

/// A ball with a name, a torus and a ground.
const THINGS: &str = "Color [0.8 0.7 0.6]
    AttributeBegin Attribute \"identifier\" \"name\" \"ball\" Attribute \"user\" \"float q\" [0.5] Translate -1 0.1 0 Rotate -90 1 0 0
    Sphere 1 -1 1 360 AttributeEnd
    AttributeBegin Translate 1.2 0.2 0.3 Rotate 60 1 0 0 Torus 0.8 0.35 0 360 360 AttributeEnd
    Polygon \"P\" [-2.5 -1 2.5 2.5 -1 2.5 2.5 -1 -2.5 -2.5 -1 -2.5] \"st\" [0 0 1 0 1 1 0 1]\n";

const SUN: &str =
    "LightSource \"distantlight\" 1 \"to\" [0.4 -0.5 1] LightSource \"ambientlight\" 2 \"intensity\" 0.2\n";
const STUDIO: &str = "LightSource \"key\" 1 LightSource \"clouds\" 2 LightSource \"gobo\" 3\n";

/// The image of a world on both back ends; an error if the processor has drawn both.
fn both(options: &str, world: &str, device: &Arc<DeviceRenderer>) -> Result<Compared, String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/shaders");
    let rib = format!("{options}{VIEW}WorldBegin\n{world}{THINGS}WorldEnd\n");
    let image = |device| drawn(&rib, &folder, device, None)?.ok_or_else(|| "no image".to_string());
    let own = image(Some(device.clone()))?;
    match &own.drawn_by {
        DrawnBy::Fallback(why) => Err(why.clone()),
        _ => Ok(compared(&own, &image(None)?)),
    }
}

/// Two maps of colours.
fn maps(folder: &Path) -> [PathBuf; 2] {
    let picture =
        |x: u32, y: u32| image::Rgb([(x * 4 % 256) as u8, (y * 4 % 256) as u8, (x / 8 + y / 8) as u8 % 2 * 200]);
    [("map.png", 64), ("sky.png", 128)].map(|(name, width)| {
        let path = folder.join(name);
        image::RgbImage::from_fn(width, 64, picture).save(&path).unwrap();
        path
    })
}

#[test]
fn shaders_of_users_are_the_same_on_a_device() {
    let Some(device) = device() else { return };
    let folder = tempfile::tempdir().unwrap();
    let [map, sky] = maps(folder.path());
    let decals = format!("Surface \"decals\" \"string map\" [{map:?}] \"string env\" [{sky:?}]\n");
    let displaced = |shader: &str, reach: f32, surface: &str| {
        format!(
            "Displacement \"{shader}\" Attribute \"displacementbound\" \"float sphere\" [{reach}] Surface \"{surface}\"\n"
        )
    };
    let outputs = "Display \"t\" \"framebuffer\" \"rgba\" Display \"+albedo\" \"framebuffer\" \"varying color albedo\"
        Display \"+depth\" \"framebuffer\" \"varying float depthv\" Display \"+mask\" \"framebuffer\" \"float mask\"\n";
    let of = |surface: &str| format!("Surface \"{surface}\"\n");
    let mut wrong = String::new();
    for (name, options, lights, looks) in [
        ("tints", "", SUN, of("tints")),
        (
            "tints given",
            "",
            SUN,
            "Surface \"tints\" \"float[4] w\" [0.9 0.1 0.5 0.2] \"color[3] tint\" [1 0 0 0 1 0 0 0 1]\n".into(),
        ),
        ("studio", "", STUDIO, of("studio")),
        ("lights", "", STUDIO, of("plastic")),
        ("ripples", "", SUN, of("ripples")),
        ("marble", "", SUN, of("marble")),
        ("cobbles", "", SUN, displaced("cobbles", 0.15, "matte")),
        ("patterns", "", SUN, of("patterns")),
        (
            "patterns of rings",
            "",
            SUN,
            "Surface \"patterns\" \"string mode\" \"rings\" \"string space\" \"world\"\n".into(),
        ),
        (
            "patterns of checks",
            "",
            SUN,
            "Surface \"patterns\" \"string mode\" \"checks\" \"string[2] names\" [\"b\" \"c\"]\n".into(),
        ),
        ("decals", "", SUN, decals),
        ("spaces", "", SUN, of("spaces")),
        ("haze", "", SUN, format!("Atmosphere \"haze\" {}", of("matte"))),
        ("poster", "Imager \"poster\"\n", SUN, of("matte")),
        ("probes", "", SUN, of("probes")),
        ("passes", outputs, SUN, of("passes")),
        ("curves", "", SUN, of("curves")),
        ("glaze", "", SUN, of("glaze")),
        ("lattice", "", SUN, of("lattice")),
        ("lattice of glass", "", SUN, format!("Opacity [0.7 0.8 0.9] {}", of("lattice"))),
        ("labels", "", SUN, displaced("cobbles", 0.15, "labels")),
        ("swirl", "", SUN, displaced("swirl", 0.5, "plastic")),
        ("fractal", "", SUN, of("fractal")),
        ("nested", "", STUDIO, of("nested")),
    ] {
        match both(options, &format!("{lights}{looks}"), &device) {
            Ok(c) if c.agrees() && (c.seen > 1000 || name.starts_with("lattice")) => {}
            Ok(c) => {
                wrong += &format!(
                    "{name}: ids {}, pixels {}, variables {}, holes {}\n",
                    c.ids, c.pixels, c.variables, c.holes
                )
            }
            Err(why) => wrong += &format!("{name}: {why}\n"),
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}

/// Of an array of strings that a scene gives, a shader has each.
#[test]
fn strings_of_arrays_are_given() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/shaders");
    let image = |given: &str| {
        let looks = format!("Surface \"patterns\" \"string mode\" \"rings\" {given}\n");
        let rib = format!("{VIEW}WorldBegin\n{looks}{THINGS}WorldEnd\n");
        drawn(&rib, &folder, None, None).unwrap().expect("an image").image
    };
    let own = image("");
    assert!(own == image("\"string[2] names\" [\"a\" \"b\"]"));
    assert!(own != image("\"string[2] names\" [\"a\" \"x\"]"));
}
