//! Images of both back ends: what each sample sees, and each pixel to two steps of 8 bits; and what a device leaves to the processor.
//! Without any adapter the comparisons say so; `REQUIRE_GPU=1` makes that a failure.

use render::film::bucket::Shard;
use render::ri::files::Files;
use render::ri::reader;
use render::{Context, DeviceRenderer, DrawnBy, RenderResult};
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

/// The device of all tests; none without an adapter.
fn device() -> Option<Arc<DeviceRenderer>> {
    static DEVICE: OnceLock<Option<Arc<DeviceRenderer>>> = OnceLock::new();
    let open = || match DeviceRenderer::open(&gpu::Choice::Any) {
        Ok(device) => Some(Arc::new(device)),
        Err(error) if std::env::var_os("REQUIRE_GPU").is_some() => panic!("REQUIRE_GPU is set, but {error}"),
        Err(error) => {
            eprintln!("skipped: {error}");
            None
        }
    };
    DEVICE.get_or_init(open).clone()
}

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Render a scene on a device, or on the processor.
fn render(rib: &str, device: Option<Arc<DeviceRenderer>>, shard: Option<Shard>) -> RenderResult {
    let folders = ["", "shaders/surface", "shaders/displacement", "shaders/light", "shaders/volume", "shaders/imager"];
    let folders = folders.iter().map(|folder| root().join(folder)).chain([root().join("shaders/include")]).collect();
    let files = Files { folders, ..Files::default() };
    let mut context = Context::new(files.clone()).unwrap();
    (context.device, context.keep_ids, context.shard) = (device, true, shard);
    reader::read(Path::new("t.rib"), rib.as_bytes(), &files, &mut context, &mut |_, _| Ok(()))
        .unwrap_or_else(|e| panic!("{e}\n{rib}"));
    context.results.pop().expect("an image")
}

/// How far the images of both back ends are the same.
struct Compared {
    /// Parts of the samples that see the same triangle, and of the pixels within 2 of 255.
    ids: f64,
    pixels: f64,
    /// Samples that see something on the processor alone.
    holes: usize,
    /// Samples that see something.
    seen: usize,
}

fn compare(rib: &str, device: &Arc<DeviceRenderer>) -> Compared {
    let own = render(rib, Some(device.clone()), None);
    assert_eq!(own.drawn_by, DrawnBy::Gpu, "{rib}");
    let other = render(rib, None, None);
    assert!(other.identities.len() == own.identities.len() && !own.identities.is_empty());
    let part = |n: usize, of: usize| n as f64 / of as f64;
    let pairs = || own.identities.iter().zip(&other.identities);
    let near = |(a, b): (&[f32; 4], &[f32; 4])| {
        let byte = |x: f32| (x.clamp(0.0, 1.0) * 255.0).round();
        (0..4).all(|c| (byte(a[c]) - byte(b[c])).abs() <= 2.0)
    };
    let pixels = own.image.pixels.iter().zip(&other.image.pixels);
    Compared {
        ids: part(pairs().filter(|(a, b)| a == b).count(), own.identities.len()),
        pixels: part(pixels.filter(|pair| near(*pair)).count(), own.image.pixels.len()),
        holes: pairs().filter(|(a, b)| **a == 0 && **b != 0).count(),
        seen: other.identities.iter().filter(|id| **id != 0).count(),
    }
}

fn same(name: &str, rib: &str, device: &Arc<DeviceRenderer>) -> String {
    let Compared { ids, pixels, holes, seen } = compare(rib, device);
    eprintln!("{name}: ids {ids}, pixels {pixels}, {seen} samples see something");
    if ids >= 0.9999 && pixels >= 0.999 && holes == 0 && seen > 0 {
        return String::new();
    }
    format!("{name}: ids {ids}, pixels {pixels}, holes {holes}, {seen} samples see something\n")
}

const CAMERA: &str =
    "Format 96 72 1 PixelSamples 4 4 PixelFilter \"gaussian\" 2 2 Projection \"perspective\" \"fov\" 45
    Translate 0 0 6 Rotate -35 1 0 0 Rotate 20 0 1 0\n";

const LIT: &str = "WorldBegin LightSource \"distantlight\" \"a\" \"to\" [0.4 -0.5 1] LightSource \"ambientlight\" \"b\" \"intensity\" 0.2
    Surface \"matte\"\n";

/// Every primitive of the corpus, lit, with shadows.
#[test]
fn primitives_are_the_same_on_a_device() {
    let Some(device) = device() else { return };
    let mut paths: Vec<PathBuf> =
        std::fs::read_dir(root().join("tests/corpus/rib")).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    let (mut n, mut wrong) = (0, String::new());
    for path in paths {
        let name = path.file_stem().unwrap().to_string_lossy().to_string();
        // These show nothing here.
        let is_empty =
            ["gprim_geometry_unknown", "gprim_patch_power", "gprim_subdivision_without_tags", "gprim_trim_curve"]
                .contains(&name.as_str());
        if !name.starts_with("gprim_") || is_empty {
            continue;
        }
        let text = std::fs::read_to_string(&path).unwrap();
        let rib = format!("{CAMERA}{}", text.replacen("WorldBegin", LIT, 1));
        wrong += &same(&name, &rib, &device);
        n += 1;
    }
    assert!(wrong.is_empty(), "{wrong}");
    assert!(n > 50, "{n} primitives");
}

/// What the library's scenes are made of: displaced stones, light from the sky and the sun, haze, an imager; large and small.
#[test]
fn looks_of_the_library_are_the_same_on_a_device() {
    let Some(device) = device() else { return };
    let sky = "Option \"sky\" \"vector sun\" [0.78 0.12 0.5] \"float turbidity\" [2.6]
        Imager \"sky\" \"uniform float exposure\" [2.12] \"uniform float white\" [2] \"uniform float hills\" [2.4]\n";
    let camera = "Format 96 54 1 PixelSamples 4 4 PixelFilter \"gaussian\" 2 2 Exposure 1.0 2.2 Projection \"perspective\" \"fov\" 40
        ConcatTransform [1 0 0 0 0 0.342 0.94 0 0 0.94 -0.342 0 0 0 0 1] Translate 0 4 -1.6\n";
    let world = "WorldBegin Atmosphere \"haze\" \"uniform float distance\" [40] LightSource \"skylight\" \"sky\" LightSource \"sunlight\" \"sun\"
        Surface \"matte\" AttributeBegin Color [0.43 0.33 0.23] Polygon \"P\" [-300 -20 0 300 -20 0 300 900 0 -300 900 0] AttributeEnd
        AttributeBegin Color [0.7 0.7 0.66] Polygon \"P\" [-2 2 0 -1 2 0 -1 2 1.5 -2 2 1.5]
        Polygon \"P\" [-1 2 0 -1 3 0 -1 3 1.5 -1 2 1.5] Polygon \"P\" [-2 2 1.5 -1 2 1.5 -1 3 1.5 -2 3 1.5] AttributeEnd
        AttributeBegin Surface \"gravel\" \"uniform float size\" 0.02 \"uniform float variation\" 0.45 Displacement \"stone\" Attribute \"displacementbound\" \"float sphere\" [0.1]
        Attribute \"trace\" \"int displacements\" [0] Color [0.5 0.45 0.4]
        TransformBegin Translate 0.2 0.4 0.3 Sphere 0.3 -0.3 0.3 360 TransformEnd
        TransformBegin Translate 0.7 1 0.2 Scale 1 1.5 1 Sphere 0.2 -0.2 0.2 360 TransformEnd
        TransformBegin Translate 0 1.4 0.25 Sphere 0.25 -0.25 0.25 360 TransformEnd AttributeEnd
        AttributeBegin Color [0.2 0.4 0.7] Translate 1.2 0.5 0.25 Sphere 0.25 -0.25 0.25 360 AttributeEnd WorldEnd";
    let wrong = same("quarry", &format!("{sky}{camera}{world}"), &device);
    assert!(wrong.is_empty(), "{wrong}");
}

/// Lights with shadow maps, which are traced, sharp and soft, and a surface that sends rays all around.
#[test]
fn rays_are_the_same_on_a_device() {
    let Some(device) = device() else { return };
    let world = "WorldBegin LightSource \"shadowspot\" \"a\" \"from\" [2 4 -3] \"to\" [0 0 0] \"intensity\" 20 \"uniform string shadowname\" [\"any.sm\"]
        \"uniform float blur\" 0.02 \"uniform float samples\" 8 Surface \"matte\"
        AttributeBegin Surface \"occlusionsurf\" \"uniform float samples\" 8 Patch \"bilinear\" \"P\" [-2 -0.8 2 2 -0.8 2 -2 -0.8 -2 2 -0.8 -2] AttributeEnd
        Sphere 0.8 -0.8 0.8 360 Translate 1.2 0 0 Scale 1 1.5 1 Sphere 0.4 -0.4 0.4 360 Translate -2 0 0 Torus 0.5 0.2 0 360 360 WorldEnd";
    let wrong = same("rays", &format!("{CAMERA}{world}"), &device);
    assert!(wrong.is_empty(), "{wrong}");
}

/// Motion, of bodies, of the camera and of form, and a lens; alone and together.
#[test]
fn what_is_blurred_is_the_same_on_a_device() {
    let Some(device) = device() else { return };
    let moving = "MotionBegin [0 0.4 1] Translate 0 0 0 Translate 0.5 0.3 0 Translate 0.5 0.6 0.4 MotionEnd Sphere 0.7 -0.7 0.7 360";
    let deforming = "MotionBegin [0 1] Patch \"bilinear\" \"P\" [-2 -1 0 2 -1 0 -2 1 1 2 1 1] Patch \"bilinear\" \"P\" [-2 -1 0 2 -1 0 -2 1.4 0 2 1 1] MotionEnd";
    let still = "Translate -1 0.5 -0.5 Sphere 0.6 -0.6 0.6 360 Translate 3 0 2 Torus 0.8 0.3 0 360 360";
    let mut wrong = String::new();
    for (name, options, motion) in [
        ("motion", "Shutter 0 1", true),
        ("lens", "DepthOfField 2 0.3 5.5", false),
        ("motion and lens", "Shutter 0 1 DepthOfField 2 0.3 5.5", true),
    ] {
        let world = if motion { format!("{moving} {deforming} {still}") } else { still.into() };
        wrong += &same(name, &format!("{options} {CAMERA}{LIT}{world} WorldEnd"), &device);
    }
    assert!(wrong.is_empty(), "{wrong}");
}

/// Windows, buckets and shards of any size give the same bits.
#[test]
fn an_image_of_a_device_does_not_depend_on_how_it_is_cut() {
    let Some(device) = device() else { return };
    let scene = |size: usize| {
        format!(
            "{CAMERA}Option \"limits\" \"bucketsize\" [{size} {size}] Imager \"background\" {LIT} Sphere 1 -1 1 360 Torus 2 0.4 0 360 360 WorldEnd"
        )
    };
    let whole = render(&scene(64), Some(device.clone()), None);
    assert_eq!(whole.drawn_by, DrawnBy::Gpu);
    let bits =
        |result: &RenderResult| -> Vec<[u32; 4]> { result.image.pixels.iter().map(|p| p.map(f32::to_bits)).collect() };
    assert!(bits(&whole) == bits(&render(&scene(13), Some(device.clone()), None)), "by other buckets");
    let parts = [1, 2, 3].map(|part| render(&scene(16), Some(device.clone()), Some(Shard { part, parts: 3 })));
    let sums = (0..whole.image.pixels.len()).map(|k| {
        let drawn: Vec<[f32; 4]> = parts.iter().map(|p| p.image.pixels[k]).filter(|p| *p != [0.0; 4]).collect();
        assert!(drawn.len() <= 1, "a pixel of two shards");
        drawn.first().copied().unwrap_or_default().map(f32::to_bits)
    });
    assert!(bits(&whole) == sums.collect::<Vec<_>>(), "by shards");
}

/// What is not built for devices is the processor's whole, and why is said.
#[test]
fn what_a_device_does_not_draw_is_drawn_by_the_processor() {
    let Some(device) = device() else { return };
    let ball = "Sphere 1 -1 1 360";
    for (options, world, why) in [
        ("ClippingPlane 0 0 0 0 0 1", ball, "clipping planes"),
        ("", "Opacity [0.5 0.5 0.5] Sphere 1 -1 1 360", "the surface `matte` may be translucent"),
        ("", "Surface \"glass\" Sphere 1 -1 1 360", "the surface `glass` may be translucent"),
        ("Display \"t.exr\" \"exr\" \"N\"", ball, "a display takes the variable `N`"),
        (
            "",
            "Surface \"shinymetal\" \"uniform string texturename\" [\"sky.env\"] Sphere 1 -1 1 360",
            "the shader `shinymetal` looks up the map",
        ),
        (
            "",
            "SolidBegin \"difference\" SolidBegin \"primitive\" Sphere 1 -1 1 360 SolidEnd SolidBegin \"primitive\" Translate 1 0 0 Sphere 1 -1 1 360 SolidEnd SolidEnd",
            "solids",
        ),
    ] {
        let rib = format!("{CAMERA}{options}\n{LIT}{world} WorldEnd");
        let own = render(&rib, Some(device.clone()), None);
        let DrawnBy::Fallback(said) = &own.drawn_by else { panic!("{rib}: {:?}", own.drawn_by) };
        assert!(said.contains(why) && said.contains("graphics devices"), "{said}");
        let other = render(&rib, None, None);
        assert!(own.image == other.image, "{why}");
    }
}

/// The frame of a device that is lost is drawn by the processor.
#[test]
fn a_lost_device_loses_no_image() {
    if device().is_none() {
        return;
    }
    let own = Arc::new(DeviceRenderer::open(&gpu::Choice::Any).unwrap());
    let rib = format!("{CAMERA}{LIT}Sphere 1 -1 1 360 WorldEnd");
    assert_eq!(render(&rib, Some(own.clone()), None).drawn_by, DrawnBy::Gpu);
    own.lose();
    let drawn = render(&rib, Some(own.clone()), None);
    assert!(matches!(&drawn.drawn_by, DrawnBy::Fallback(why) if why.contains("lost")), "{:?}", drawn.drawn_by);
    assert!(own.has_failed() && drawn.image == render(&rib, None, None).image);
}
