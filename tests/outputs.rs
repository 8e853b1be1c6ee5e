//! Channels besides colour, metadata of image files, and render statistics.

use crate::cli::{images, scratch, scree};
use exr::prelude::{FlatSamples, ReadChannels, ReadLayers, Text, read};
use std::collections::BTreeMap;
use std::path::Path;

/// The channels of an EXR file, as floats by name, and its attributes.
pub struct Layers {
    width: usize,
    channels: BTreeMap<String, Vec<f32>>,
    /// Channels that have 16 bits.
    half: Vec<String>,
    about: BTreeMap<String, String>,
}

impl Layers {
    pub fn read(path: &Path) -> Layers {
        let image =
            read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer().all_attributes();
        let image = image.from_file(path).unwrap();
        let mut layers = Layers {
            width: image.layer_data.size.width(),
            channels: BTreeMap::new(),
            half: vec![],
            about: BTreeMap::new(),
        };
        for channel in &image.layer_data.channel_data.list {
            let name = channel.name.to_string();
            let values = channel.sample_data.values_as_f32().collect();
            if matches!(channel.sample_data, FlatSamples::F16(_)) {
                layers.half.push(name.clone());
            }
            layers.channels.insert(name, values);
        }
        let program = image.layer_data.attributes.software_name.as_ref().map(Text::to_string);
        layers.about.insert("software".into(), program.unwrap_or_default());
        let comments = image.layer_data.attributes.comments.as_ref().map(Text::to_string).unwrap_or_default();
        for (key, value) in comments.split(' ').filter_map(|pair| pair.split_once('=')) {
            layers.about.insert(key.into(), value.into());
        }
        layers
    }

    pub fn at(&self, name: &str, x: usize, y: usize) -> f32 {
        let channel = self.channels.get(name).unwrap_or_else(|| panic!("{name} is none of {:?}", self.channels.keys()));
        channel[y * self.width + x]
    }
}

/// Render a RIB that writes `a.exr` and read that.
fn render(scene: &str) -> Layers {
    let work = scratch();
    let shader = "surface parts(output varying color base = 0; output varying float depth = 0;) {
        normal Nf = faceforward(normalize(N), I);
        base = Cs * diffuse(Nf); depth = zcomp(P);
        Oi = Os; Ci = Os * (base + 0.25); }";
    std::fs::write(work.path().join("parts.sl"), shader).unwrap();
    std::fs::write(work.path().join("t.rib"), scene).unwrap();
    scree(&["render", work.path().join("t.rib").to_str().unwrap(), "-o", work.path().to_str().unwrap()]).ok();
    Layers::read(&work.path().join("a.exr"))
}

/// Looking along z from −5, ±1 across the image.
const VIEW: &str =
    "Format 80 80 1 PixelSamples 4 4 PixelFilter \"box\" 1 1 Projection \"orthographic\" Translate 0 0 5";

const DISPLAYS: &str = "Display \"a.exr\" \"exr\" \"rgbaz\" Display \"+a.exr\" \"exr\" \"N\" Display \"+a.exr\" \"exr\" \"varying point P\"
    Display \"+a.exr\" \"exr\" \"id\" Display \"+a.exr\" \"exr\" \"color base\" Display \"+a.exr\" \"exr\" \"float depth\"
    Display \"+a.exr\" \"exr\" \"motion\"";

#[test]
fn variables_of_a_sphere_are_those_of_its_equation() {
    let scene = |smooth: &str| {
        format!(
            "{DISPLAYS} {VIEW} WorldBegin ShadingInterpolation \"{smooth}\"
            LightSource \"distantlight\" 1 \"to\" [0 0 1] Surface \"parts\" Color .8 .6 .4 Sphere .9 -.9 .9 360
            Translate 0.8 0.8 0 Sphere .1 -.1 .1 360 WorldEnd"
        )
    };
    for smooth in ["smooth", "constant"] {
        let a = render(&scene(smooth));
        // A flat micropolygon's values are those of its first corner, up to a pixel away.
        let tolerance = if smooth == "smooth" { 0.01 } else { 0.06 };
        for (px, py) in [(40, 40), (20, 40), (30, 55), (55, 22)] {
            let (x, y) = ((px as f32 + 0.5) / 40.0 - 1.0, 1.0 - (py as f32 + 0.5) / 40.0);
            let z = -(0.81 - x * x - y * y).sqrt();
            let expected = [
                ("Z", 5.0 + z),
                ("P.X", x),
                ("P.Y", y),
                ("P.Z", z),
                ("depth", z),
                ("N.X", x / 0.9),
                ("N.Z", z / 0.9),
                ("base.R", -0.8 * z / 0.9),
                ("base.B", -0.4 * z / 0.9),
                ("R", -0.8 * z / 0.9 + 0.25),
                ("id", 1.0),
                ("motion.X", 0.0),
            ];
            // N is not of unit length where the shader leaves it so: the sphere's is as long as its radius.
            let length = a.at("N.X", px, py).hypot(a.at("N.Y", px, py)).hypot(a.at("N.Z", px, py));
            for (name, value) in expected {
                let scale = if name.starts_with("N.") { 1.0 / length } else { 1.0 };
                // Depth is the least in the pixel.
                let off = if name == "Z" { 0.03 } else { tolerance };
                let found = a.at(name, px, py) * scale;
                assert!((found - value).abs() < off, "{smooth} {name} at {px}, {py}: {found}, expected {value}");
            }
        }
        assert_eq!((a.at("id", 72, 8), a.at("id", 3, 3), a.at("Z", 3, 3)), (2.0, 0.0, f32::INFINITY));
        assert!(a.half.is_empty() && a.about["software"].starts_with("scree "), "{:?}", a.about);
    }
}

#[test]
fn layers_are_composited_each_in_its_way() {
    // A red sheet before a green one: a quarter opaque, it leaves the depth behind it; three quarters, it has its own. Colours count by the opacity.
    for (opacity, depth, id) in [(0.25, 6.0, 2.0), (0.75, 4.0, 1.0)] {
        let a = render(&format!(
            "{DISPLAYS} {VIEW} WorldBegin LightSource \"distantlight\" 1 \"to\" [0 0 1] Surface \"parts\"
            AttributeBegin Attribute \"visibility\" \"int transmission\" 0 Color 1 0 0 Opacity {opacity} {opacity} {opacity} Translate 0 0 -1 Polygon \"P\" [-1 -1 0 1 -1 0 1 1 0 -1 1 0] AttributeEnd
            Color 0 1 0 Translate 0 0 1 Polygon \"P\" [-1 -1 0 1 -1 0 1 1 0 -1 1 0] WorldEnd"
        ));
        let near = |name: &str, value: f32| {
            let found = a.at(name, 33, 50);
            assert!((found - value).abs() < 1e-3, "{name}: {found}, expected {value}");
        };
        near("Z", depth);
        near("P.Z", depth - 5.0);
        near("id", id);
        near("base.R", opacity);
        near("base.G", 1.0 - opacity);
        near("A", 1.0);
    }
}

#[test]
fn motion_is_in_pixels() {
    let a = render(&format!(
        "{DISPLAYS} {VIEW} Shutter 0 0.5 WorldBegin Surface \"parts\"
        MotionBegin [0 1] Translate 0 0 0 Translate 0.2 -0.1 0 MotionEnd Polygon \"P\" [-1 -1 0 1 -1 0 1 1 0 -1 1 0] WorldEnd"
    ));
    // Half of the way of 8 pixels to the right and 4 down.
    assert!((a.at("motion.X", 40, 40) - 4.0).abs() < 1e-2 && (a.at("motion.Y", 40, 40) - 2.0).abs() < 1e-2);
}

#[test]
fn files_have_the_floats_and_the_names_that_are_asked_for() {
    let half = "Display \"a.exr\" \"exr\" \"rgba\" \"string type\" [\"half\"] Display \"+a.exr\" \"exr\" \"z\" \"string type\" [\"half\"]";
    let scene = format!("{half} {VIEW} WorldBegin Sphere .9 -.9 .9 360 WorldEnd");
    let a = render(&scene);
    assert_eq!(a.channels.keys().collect::<Vec<_>>(), ["A", "B", "G", "R", "Z"]);
    assert_eq!(a.half, ["A", "B", "G", "R"]);
    // A variable alone in a file is seen as a colour.
    let a = render(&format!("Display \"a.exr\" \"exr\" \"N\" {VIEW} WorldBegin Sphere .9 -.9 .9 360 WorldEnd"));
    assert_eq!(a.channels.keys().collect::<Vec<_>>(), ["B", "G", "R"]);
    // Modes that make no sense are errors.
    let work = scratch();
    for (displays, said) in [
        ("Display \"a.exr\" \"exr\" \"diffuse\"", "without its type"),
        ("Display \"a.exr\" \"exr\" \"colour diffuse\"", "begins with `colour`"),
        ("Display \"a.png\" \"png\" \"rgb\" Display \"+a.png\" \"png\" \"N\"", "only EXR files have layers"),
        ("Display \"a.exr\" \"exr\" \"rgb\" \"string type\" [\"short\"]", "half"),
    ] {
        std::fs::write(work.path().join("t.rib"), format!("{displays} {VIEW} WorldBegin WorldEnd")).unwrap();
        let found = scree(&["render", work.path().join("t.rib").to_str().unwrap()]).fails(3);
        assert!(found.contains(said) && found.contains("t.rib:1:"), "{found}");
    }
}

#[test]
fn shards_with_layers_are_stitched_and_statistics_add_up() {
    let work = scratch();
    let at = |name: &str| work.path().join(name);
    let text = |name: &str| at(name).to_str().unwrap().to_string();
    let scene = format!(
        "Option \"limits\" \"integer bucketsize\" [16] {DISPLAYS} {VIEW} WorldBegin
        LightSource \"distantlight\" 1 \"to\" [0 0 1] Surface \"parts\" Sphere .9 -.9 .9 360 WorldEnd"
    )
    .replace("surface", "");
    std::fs::write(at("parts.sl"), "surface parts(output varying color base = 0;) { base = Cs; Ci = Cs; Oi = Os; }")
        .unwrap();
    std::fs::write(at("t.rib"), scene.replace("Display \"+a.exr\" \"exr\" \"float depth\"", "")).unwrap();
    scree(&["render", &text("t.rib"), "--stats", "-o", &text("whole")]).ok();
    for part in ["1/3", "2/3", "3/3"] {
        scree(&["render", &text("t.rib"), "--bucket", part, "--stats", "-o", &text("in3")]).ok();
    }
    scree(&["stitch", &text("in3")]).ok();
    assert!(std::fs::read(at("whole/a.exr")).unwrap() == std::fs::read(at("in3/a.exr")).unwrap());
    let stats =
        |name: &str| -> serde_json::Value { serde_json::from_slice(&std::fs::read(at(name)).unwrap()).unwrap() };
    let whole = stats("whole/a.exr.stats.json");
    let parts: Vec<_> = (1..=3).map(|k| stats(&format!("in3/a.exr.part-{k}-of-3.stats.json"))).collect();
    for key in ["micropolygons", "shaded_points", "samples", "grids", "splits"] {
        let sum: u64 = parts.iter().map(|p| p["stats"][key].as_u64().unwrap()).sum();
        assert_eq!(whole["stats"][key].as_u64().unwrap(), sum, "{key}");
    }
    assert!(whole["stats"]["shaded_points"].as_u64().unwrap() > 3000 && whole["peak_bytes"].as_u64().unwrap() > 0);
    let seconds = whole["stats"]["seconds"].as_object().unwrap();
    assert!(seconds.len() == 6 && seconds.values().all(|s| s.as_f64().unwrap() >= 0.0));
}

#[test]
fn images_of_data_have_their_frame_and_time() {
    let work = scratch();
    let at = |name: &str| work.path().join(name);
    std::fs::write(at("p_0007.csv"), "x;y;z;radius;vx\n0;0;0.5;0.5;2\n1.5;0;0.5;0.5;0\n").unwrap();
    let metadata = "data: {csv: 'p_*.csv'}
objects:
  - {name: spheres, position: [x, y, z], geometry: {sphere: {radius: radius}}}
camera: {eye: [0, -6, 3], look_at: [0.5, 0, 0.5]}
output: {resolution: [64, 48], samples: [2, 2], format: exr, bits: 16, channels: [z, id, N]}
";
    std::fs::write(at("m.yaml"), metadata).unwrap();
    let said = scree(&["render", at("m.yaml").to_str().unwrap(), "-o", at("out").to_str().unwrap()]);
    said.ok();
    let image = images(&at("out")).remove(0);
    let layers = Layers::read(&image);
    assert_eq!(layers.channels.keys().collect::<Vec<_>>(), ["A", "B", "G", "N.X", "N.Y", "N.Z", "R", "Z", "id"]);
    assert_eq!(layers.half, ["A", "B", "G", "R"]);
    assert_eq!((layers.about["frame"].as_str(), layers.about["time"].as_str()), ("7", "0"));
    // Numbers stay whole: the two spheres and what else the scene has.
    assert!(layers.channels["id"].iter().all(|id| id.fract() == 0.0));
    let ids: std::collections::BTreeSet<u32> = layers.channels["id"].iter().map(|id| *id as u32).collect();
    assert!(ids.len() >= 3, "{ids:?}");
}

/// Numbers of a TIFF file of one strip, little-endian: the values of a tag, or of the pixels.
struct Tiff(Vec<u8>);

impl Tiff {
    fn whole(&self, at: usize, bytes: usize) -> usize {
        self.0[at..at + bytes].iter().rev().fold(0, |n, byte| n << 8 | *byte as usize)
    }

    fn tag(&self, tag: usize) -> Option<usize> {
        let first = self.whole(4, 4);
        let entries = (0..self.whole(first, 2)).map(|k| first + 2 + 12 * k);
        let found = entries.into_iter().find(|at| self.whole(*at, 2) == tag)?;
        Some(self.whole(found + 8, if self.whole(found + 2, 2) == 3 { 2 } else { 4 }))
    }
}

/// RISpec 4.1.2: depths are floats unless `Quantize "z"` says otherwise, whatever it says of colours; PNG has bytes.
#[test]
fn depths_alone_in_a_tiff_file_are_floats() {
    let depth_at_middle = |quantize: &str, end: &str| {
        let work = scratch();
        let path = work.path().join("t.rib");
        let text = format!(
            "Display \"t.{end}\" \"file\" \"z\" {quantize}\nFormat 8 8 1 PixelSamples 2 2 PixelFilter \"box\" 1 1\nProjection \"orthographic\" Translate 0 0 5
            WorldBegin Surface \"constant\" Polygon \"P\" [-1 -1 -4.5 1 -1 -4.5 1 1 -4.5 -1 1 -4.5] WorldEnd\n"
        );
        std::fs::write(&path, text).unwrap();
        scree(&["render", path.to_str().unwrap(), "-o", work.path().to_str().unwrap()]).ok();
        std::fs::read(work.path().join(format!("t.{end}"))).unwrap()
    };
    for (quantize, bits, format, expected) in [
        ("", 32, Some(3), 0.5f32),
        ("Quantize \"rgba\" 65535 0 65535 0", 32, Some(3), 0.5),
        ("Quantize \"z\" 0 0 0 0", 32, Some(3), 0.5),
        ("Quantize \"z\" 255 0 255 0", 8, Some(1), 128.0),
        ("Quantize \"z\" 65535 0 65535 0", 16, Some(1), 32768.0),
        ("Quantize \"rgba\" 0 0 0 0 Quantize \"z\" 200 0 90 0", 8, Some(1), 90.0),
    ] {
        let file = Tiff(depth_at_middle(quantize, "tif"));
        let found = [file.tag(258), file.tag(277)];
        assert_eq!(found, [Some(bits), Some(1)], "{quantize}");
        assert_eq!(file.tag(339).or(Some(1)), format, "{quantize}");
        let at = file.tag(273).unwrap() + 4 * 8 * bits / 8 + 4 * bits / 8;
        let value = match bits {
            32 => f32::from_bits(file.whole(at, 4) as u32),
            bits => file.whole(at, bits / 8) as f32,
        };
        assert!((value - expected).abs() <= expected * 1e-5, "{quantize}: {value}, expected {expected}");
    }
    let levels = image::load_from_memory(&depth_at_middle("", "png")).unwrap();
    assert_eq!((levels.color(), levels.to_luma8().get_pixel(4, 4).0), (image::ColorType::L8, [128]));
}
