//! Images of both back ends: what each sample sees, and each pixel to two steps of 8 bits; and what a device leaves to the processor.
//! Without any adapter the comparisons say so; `REQUIRE_GPU=1` makes that a failure.

#[path = "backends/caps.rs"]
mod caps;
#[path = "backends/flight.rs"]
mod flight;
#[path = "backends/layers.rs"]
mod layers;
#[path = "backends/shaders.rs"]
mod shaders;
#[path = "backends/shown.rs"]
mod shown;
#[path = "backends/sides.rs"]
mod sides;
#[path = "backends/table.rs"]
mod table;
#[path = "backends/uploads.rs"]
mod uploads;

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
    drawn(rib, &root(), device, shard).unwrap_or_else(|e| panic!("{e}\n{rib}")).expect("an image")
}

/// The last image of a scene of a folder, or what is wrong with it.
fn drawn(
    rib: &str,
    folder: &Path,
    device: Option<Arc<DeviceRenderer>>,
    shard: Option<Shard>,
) -> Result<Option<RenderResult>, String> {
    let folders = ["", "shaders/surface", "shaders/displacement", "shaders/light", "shaders/volume", "shaders/imager"];
    let library = folders.iter().map(|folder| root().join(folder)).chain([root().join("shaders/include")]);
    let files = Files { folders: [folder.into()].into_iter().chain(library).collect(), ..Files::default() };
    let mut context = Context::new(files.clone()).map_err(|e| e.to_string())?;
    (context.device, context.keep_ids, context.shard) = (device, true, shard);
    reader::read(Path::new("t.rib"), rib.as_bytes(), &files, &mut context, &mut |_, _| Ok(None))
        .map_err(|e| e.to_string())?;
    Ok(context.results.pop())
}

/// How far the images of both back ends are the same.
#[derive(Clone, Copy)]
struct Compared {
    /// Parts of the samples that see the same triangle, and of the pixels within 2 of 255.
    ids: f64,
    pixels: f64,
    /// Samples that see something on the processor alone.
    holes: usize,
    /// Samples that see something.
    seen: usize,
    /// The part of the pixels whose other variables agree to a thousandth of the larger of 1 and the number.
    variables: f64,
}

impl Compared {
    fn agrees(&self) -> bool {
        self.ids >= 0.9999 && self.pixels >= 0.999 && self.holes == 0 && self.variables >= 0.999
    }
}

fn compare(rib: &str, device: &Arc<DeviceRenderer>) -> Compared {
    let own = render(rib, Some(device.clone()), None);
    assert_eq!(own.drawn_by, DrawnBy::Gpu, "{rib}");
    compared(&own, &render(rib, None, None))
}

/// How far the image of a device is that of the processor.
fn compared(own: &RenderResult, other: &RenderResult) -> Compared {
    assert!(other.identities.len() == own.identities.len() && !own.identities.is_empty());
    let part = |n: usize, of: usize| n as f64 / of as f64;
    let pairs = || own.identities.iter().zip(&other.identities);
    let near = |(a, b): (&[f32; 4], &[f32; 4])| {
        let byte = |x: f32| (x.clamp(0.0, 1.0) * 255.0).round();
        (0..4).all(|c| (byte(a[c]) - byte(b[c])).abs() <= 2.0)
    };
    let pixels = own.image.pixels.iter().zip(&other.image.pixels);
    assert!(own.image.aovs == other.image.aovs && own.image.extra.len() == other.image.extra.len());
    let alike = |(a, b): (&f32, &f32)| a == b || (a - b).abs() <= 1e-3 * b.abs().max(1.0);
    let depth = (own.image.extra.len() / own.image.pixels.len()).max(1);
    let variables = own.image.extra.chunks(depth).zip(other.image.extra.chunks(depth));
    let n_alike = variables.filter(|(a, b)| a.iter().zip(*b).all(alike)).count();
    Compared {
        variables: if own.image.extra.is_empty() { 1.0 } else { part(n_alike, own.image.pixels.len()) },
        ids: part(pairs().filter(|(a, b)| a == b).count(), own.identities.len()),
        pixels: part(pixels.filter(|pair| near(*pair)).count(), own.image.pixels.len()),
        holes: pairs().filter(|(a, b)| **a == 0 && **b != 0).count(),
        seen: other.identities.iter().filter(|id| **id != 0).count(),
    }
}

fn same(name: &str, rib: &str, device: &Arc<DeviceRenderer>) -> String {
    let c @ Compared { ids, pixels, holes, seen, variables } = compare(rib, device);
    eprintln!("{name}: ids {ids}, pixels {pixels}, variables {variables}, {seen} samples see something");
    if c.agrees() && seen > 0 {
        return String::new();
    }
    format!("{name}: ids {ids}, pixels {pixels}, variables {variables}, holes {holes}, {seen} samples see something\n")
}

const CAMERA: &str =
    "Format 96 72 1 PixelSamples 4 4 PixelFilter \"gaussian\" 2 2 Projection \"perspective\" \"fov\" 45
    Translate 0 0 6 Rotate -35 1 0 0 Rotate 20 0 1 0\n";

const LIT: &str = "WorldBegin LightSource \"distantlight\" \"a\" \"to\" [0.4 -0.5 1] LightSource \"ambientlight\" \"b\" \"intensity\" 0.2
    Surface \"matte\"\n";

/// What is seen of surfaces in one plane, which would fight if their depths alone decided.
#[test]
fn surfaces_in_one_plane_are_the_same_on_a_device() {
    let Some(device) = device() else { return };
    let square = |half: f32| format!("Polygon \"P\" [{0} 0 {0} {1} 0 {0} {1} 0 {1} {0} 0 {1}]\n", -half, half);
    let [small, middle, large] = [0.4, 1.0, 30.0].map(square);
    let world = format!("Color 1 1 .3 {small} Color .3 .4 .9 {middle} Color .9 .3 .2 {large} WorldEnd");
    let moving = CAMERA.replace("Rotate 20 0 1 0", "MotionBegin [0 1] Rotate 20 0 1 0 Rotate 26 0 1 0 MotionEnd");
    let low = CAMERA.replace("Rotate -35 1 0 0", "Rotate -3 1 0 0");
    let mut wrong = String::new();
    for (name, camera) in [("still", CAMERA.into()), ("moving", format!("Shutter 0 1 {moving}")), ("low", low)] {
        wrong += &same(name, &format!("{camera}{LIT}{world}"), &device);
    }
    assert!(wrong.is_empty(), "{wrong}");
}

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

/// Rays that meet displaced surfaces as they are seen: shadows of stones on each other and on a bumpy ground, and through what is translucent.
#[test]
fn rays_meet_displaced_surfaces_on_a_device() {
    let Some(device) = device() else { return };
    let world = "WorldBegin LightSource \"shadowspot\" \"a\" \"from\" [2 4 -3] \"to\" [0 0 0] \"intensity\" 20 \"uniform string shadowname\" [\"any.sm\"]
        LightSource \"distantlight\" \"b\" \"to\" [0.4 -0.5 1] \"intensity\" 0.4 Surface \"matte\" Displacement \"stone\" Attribute \"displacementbound\" \"float sphere\" [0.2]
        AttributeBegin Surface \"occlusionsurf\" \"uniform float samples\" 8 Patch \"bilinear\" \"P\" [-2 -0.8 2 2 -0.8 2 -2 -0.8 -2 2 -0.8 -2] AttributeEnd
        Sphere 0.8 -0.8 0.8 360 Translate 1.2 0 0 Scale 1 1.5 1 Sphere 0.4 -0.4 0.4 360 Translate -2 0 0 Torus 0.5 0.2 0 360 360 WorldEnd";
    let through = world.replace("occlusionsurf", "matte").replace("\"uniform float samples\" 8 Patch", "Patch");
    let mut wrong = same("displaced", &format!("{CAMERA}{world}"), &device);
    wrong += &same(
        "displaced glass",
        &format!("{CAMERA}{}", through.replace("Torus 0.5 0.2 0 360", "Opacity [0.5 0.7 0.9] Torus 0.5 0.2 0 360")),
        &device,
    );
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

/// Spheres that overlap.
fn balls(n: usize) -> String {
    let ball = |k: usize| {
        let (x, y, z) = ((k % 7) as f32 * 0.4 - 1.2, (k % 5) as f32 * 0.4 - 0.8, (k % 3) as f32 * 0.5 - 0.5);
        format!("TransformBegin Translate {x} {y} {z} Sphere 0.5 -0.5 0.5 360 TransformEnd ")
    };
    (0..n).map(ball).collect()
}

/// What may be translucent: constant opacities, those of shaders and of primitive variables, many layers one behind the other, holes,
/// what turns out opaque, and haze behind it.
#[test]
fn what_is_translucent_is_the_same_on_a_device() {
    let Some(device) = device() else { return };
    let floor = "AttributeBegin Opacity [1 1 1] Color [0.8 0.7 0.5] Patch \"bilinear\" \"P\" [-3 -1 3 3 -1 3 -3 -1 -3 3 -1 -3] AttributeEnd ";
    let shades = "Attribute \"visibility\" \"string transmission\" \"transparent\" Patch \"bilinear\" \"P\" [-2 -1 0 2 -1 0 -2 1 1 2 1 1] \"varying color Os\" [0 0 0 1 1 1 1 0.5 0 0.3 0.6 0.9] \"varying color Cs\" [1 0 0 0 1 0 0 0 1 1 1 1]";
    let mut wrong = String::new();
    for (name, options, world) in [
        ("constant", "", format!("{floor} Opacity [0.5 0.3 0.8] Color [0.2 0.5 0.9] {}", balls(40))),
        (
            "glass",
            "",
            format!(
                "{floor} Attribute \"visibility\" \"string transmission\" \"Os\" Surface \"glass\" Sphere 1 -1 1 360 Translate 0.5 0.2 -1.5 Sphere 0.4 -0.4 0.4 360"
            ),
        ),
        ("variables", "", format!("{floor} {shades} Translate 0 0 -0.5 {shades}")),
        (
            "flat",
            "",
            format!("{floor} ShadingInterpolation \"constant\" {shades} Opacity [0.4 0.4 0.4] Torus 1 0.3 0 360 360"),
        ),
        (
            "hole",
            "Imager \"background\"",
            format!("{floor} {shades} Matte 1 Opacity [0.5 0.5 0.5] Sphere 0.6 -0.6 0.6 360"),
        ),
        (
            "haze",
            "",
            format!("Atmosphere \"fog\" \"uniform float distance\" 5 {floor} Opacity [0.5 0.3 0.8] {}", balls(8)),
        ),
        (
            "opaque",
            "",
            format!(
                "{floor} Attribute \"visibility\" \"string transmission\" \"opaque\" Opacity [0.5 0.5 0.5] Sphere 0.4 -0.4 0.4 360 Translate 0 0.2 1.2 Surface \"glass\" Opacity [1 1 1] Sphere 1 -1 1 360"
            ),
        ),
        (
            "motion",
            "Shutter 0 1",
            format!(
                "{floor} Opacity [0.5 0.3 0.8] MotionBegin [0 1] Translate 0 0 0 Translate 0.5 0.3 0 MotionEnd {}",
                balls(40)
            ),
        ),
        ("lens", "DepthOfField 2 0.3 5.5", format!("{floor} {shades} Opacity [0.5 0.3 0.8] {}", balls(40))),
        (
            "points",
            "",
            format!(
                "{floor} Attribute \"visibility\" \"string transmission\" \"opaque\" Opacity [0.5 0.3 0.8] Points \"P\" [-1 0 0 0 0.3 -1 0.2 0.4 -0.5 1 0 1] \"constantwidth\" [0.9]"
            ),
        ),
        (
            "beyond",
            "",
            format!(
                "{floor} Attribute \"visibility\" \"string transmission\" \"opaque\" Patch \"bilinear\" \"P\" [-2 -1 0 2 -1 0 -2 1 1 2 1 1] \"varying color Os\" [-2 -1 0 3 2 1 1 0.5 -1 0.3 4 0.9]"
            ),
        ),
        // Panes nearer to each other than two pixels keep their light each.
        (
            "panes",
            "",
            format!(
                "{floor} Opacity [0.4 0.4 0.4] {}",
                (0..4)
                    .map(|k| format!(
                        "Patch \"bilinear\" \"P\" [-1 {y} 1 1 {y} 1 -1 {y} -1 1 {y} -1] ",
                        y = k as f32 * 0.004
                    ))
                    .collect::<String>()
            ),
        ),
    ] {
        wrong += &same(name, &format!("{options} {CAMERA}{LIT}{world} WorldEnd"), &device);
    }
    assert!(wrong.is_empty(), "{wrong}");
}

/// However little of a frame is on the device at a time, the image is the same to the bit: windows, waves, the layers of parts of a window, and
/// lists of some samples after those of others.
#[test]
fn an_image_does_not_depend_on_what_is_on_the_device_at_a_time() {
    let Some(unlimited) = device() else { return };
    let rib = format!(
        "Display \"+z.exr\" \"exr\" \"z\" {CAMERA}{LIT} Torus 2 0.4 0 360 360 Opacity [0.5 0.3 0.8] {} WorldEnd",
        balls(40)
    );
    let whole = render(&rib, Some(unlimited.clone()), None);
    assert_eq!(whole.drawn_by, DrawnBy::Gpu);
    let mut own = DeviceRenderer::open(&gpu::Choice::Any).unwrap();
    let (samples, points, layers) = (1 << 15, 1 << 12, 1 << 10);
    own.limits = render::DeviceLimits {
        samples,
        round: 64,
        wave: [1 << 10, 1 << 11],
        points,
        values: 1 << 12,
        facets: 1 << 20,
        layers,
    };
    let parts = render(&rib, Some(Arc::new(own)), None);
    assert_eq!(parts.drawn_by, DrawnBy::Gpu);
    assert!(whole.identities == parts.identities);
    assert!(whole.image == parts.image);
    // Within the least memory that may be given.
    let mut own = DeviceRenderer::open(&gpu::Choice::Any).unwrap();
    own.limit_memory(render::LEAST_DEVICE_MEMORY);
    let own = Arc::new(own);
    let large = rib.replace("Format 96 72", "Format 320 240");
    let small = render(&large, Some(own.clone()), None);
    assert_eq!(small.drawn_by, DrawnBy::Gpu);
    assert!(small.image == render(&large, Some(unlimited.clone()), None).image);
    eprintln!("{} of {} bytes", own.most_memory(), unlimited.most_memory());
    assert!(own.most_memory() <= render::LEAST_DEVICE_MEMORY && unlimited.most_memory() > render::LEAST_DEVICE_MEMORY);
    // All of it in one part has more layers than fit.
    let mut own = DeviceRenderer::open(&gpu::Choice::Any).unwrap();
    own.limits.layers = 1 << 14;
    let ranges = render(&rib, Some(Arc::new(own)), None);
    assert_eq!(ranges.drawn_by, DrawnBy::Gpu);
    assert!(whole.identities == ranges.identities && whole.image == ranges.image);
}

/// Clipping planes, levels of detail that fade into each other, and colours and opacities that move.
#[test]
fn what_is_there_in_part_is_the_same_on_a_device() {
    let Some(device) = device() else { return };
    let lights = LIT.replace("WorldBegin", "");
    let detail = "Detail [-1 1 -1 1 -1 1] DetailRange [0 0 0 2000] Color [1 0 0] Sphere 1 -1 1 360 DetailRange [0 2000 10000 10000] Color [0 0 1] Sphere 0.9 -0.9 0.9 360";
    let fading = "MotionBegin [0 1] Color [1 0 0] Color [0 0 1] MotionEnd Sphere 1 -1 1 360
        MotionBegin [0 0.5 1] Opacity [1 1 1] Opacity [0.2 0.2 0.2] Opacity [1 0 0] MotionEnd Translate 0 0.5 -1 Sphere 0.7 -0.7 0.7 360";
    let mut wrong = String::new();
    for (name, options, world) in [
        (
            "planes",
            "",
            format!(
                "ClippingPlane 0 0 0.2 0 0 1 ClippingPlane 0.5 0 0 1 0.2 0.1 WorldBegin {lights} Sphere 1 -1 1 360 Torus 2 0.4 0 360 360"
            ),
        ),
        (
            "planes and motion",
            "Shutter 0 1",
            format!(
                "ClippingPlane 0 0 0.2 0 0 1 WorldBegin {lights} MotionBegin [0 1] Translate 0 0 0 Translate 0.5 0 0 MotionEnd Sphere 1 -1 1 360"
            ),
        ),
        ("detail", "", format!("WorldBegin {lights} {detail}")),
        ("fading", "Shutter 0 1", format!("WorldBegin {lights} {fading}")),
    ] {
        wrong += &same(name, &format!("{options} {CAMERA}{world} WorldEnd"), &device);
    }
    assert!(wrong.is_empty(), "{wrong}");
}

/// Whatever displays take: variables of the renderer, of primitives and of shaders, of what is opaque, translucent, a hole, moved or out of
/// focus.
#[test]
fn displays_of_variables_are_the_same_on_a_device() {
    let Some(device) = device() else { return };
    let all = [
        "z",
        "id",
        "P",
        "N",
        "Ng",
        "I",
        "u",
        "s",
        "Cs",
        "Os",
        "Ci",
        "Oi",
        "motion",
        "color own",
        "float shade",
        "normal bump",
    ];
    let displays: String =
        all.iter().map(|mode| format!("Display \"+{}.exr\" \"exr\" \"{mode}\"\n", mode.replace(' ', "_"))).collect();
    let floor = "AttributeBegin Opacity [1 1 1] Color [0.8 0.7 0.5] Patch \"bilinear\" \"P\" [-3 -1 3 3 -1 3 -3 -1 -3 3 -1 -3] \"varying color own\" [1 0 0 0 1 0 0 0 1 1 1 1] \"uniform float shade\" [0.7] AttributeEnd ";
    let shades = "Attribute \"visibility\" \"string transmission\" \"transparent\" Patch \"bilinear\" \"P\" [-2 -1 0 2 -1 0 -2 1 1 2 1 1] \"varying color Os\" [0 0 0 1 1 1 1 0.5 0 0.3 0.6 0.9] \"varying color own\" [1 0 0 0 1 0 0 0 1 1 1 1]";
    let world = format!(
        "{floor} Sphere 0.8 -0.8 0.8 360 TransformBegin Translate 0 0 -1.2 {shades} TransformEnd
        TransformBegin Translate 1 0.5 -2 Matte 1 Sphere 0.3 -0.3 0.3 360 Matte 0 TransformEnd
        Translate 0.4 0.2 -1.4 Color [0.2 0.9 0.4] Opacity [0.5 0.4 0.9] Sphere 0.5 -0.5 0.5 360"
    );
    let mut wrong = String::new();
    for (name, options, world) in [
        ("still", "", world.clone()),
        ("haze", "", format!("Atmosphere \"fog\" \"uniform float distance\" 5 {world}")),
        ("motion", "Shutter 0 1", format!("MotionBegin [0 1] Translate 0 0 0 Translate 0.5 0.3 0 MotionEnd {world}")),
        ("lens", "DepthOfField 2 0.3 5.5", world.clone()),
    ] {
        wrong += &same(name, &format!("{options} {displays} {CAMERA}{LIT}{world} WorldEnd"), &device);
    }
    assert!(wrong.is_empty(), "{wrong}");
}

/// Textures of bytes, encoded and linear, and of floats, with what lies beyond their edges, near and far and askew; environments by longitude
/// and latitude and by the faces of a cube; one that is not there.
#[test]
fn textures_are_the_same_on_a_device() {
    let Some(device) = device() else { return };
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_string_lossy().to_string();
    let value = |x: u32, y: u32, c: u32| ((x * 7 + y * 13 + c * 101 + (x / 5) * (y / 3) * 29) % 256) as u8;
    let bytes =
        |n: [u32; 2]| image::RgbaImage::from_fn(n[0], n[1], |x, y| image::Rgba([0, 1, 2, 3].map(|c| value(x, y, c))));
    bytes([53, 31]).save(path("bytes.png")).unwrap();
    let floats = |x: u32, y: u32| image::Rgb([0, 1, 2].map(|c| value(x, y, c) as f32 / 100.0));
    let floats = image::ImageBuffer::from_fn(40, 24, floats);
    image::DynamicImage::ImageRgb32F(floats).save(path("floats.exr")).unwrap();
    let faces: Vec<String> = (0..6).map(|k| format!("face{k}.png")).collect();
    faces.iter().enumerate().for_each(|(k, name)| bytes([16 + k as u32, 16]).save(path(name)).unwrap());
    let faces: Vec<String> = faces.iter().map(|name| format!("{:?}", path(name))).collect();
    let maps: String = [("black", "clamp"), ("clamp", "periodic"), ("periodic", "black")]
        .iter()
        .enumerate()
        .map(|(k, (s, t))| format!("MakeTexture {:?} \"tex{k}\" \"{s}\" \"{t}\" \"box\" 1 1\n", path("bytes.png")))
        .collect();
    let maps = format!(
        "{maps} MakeTexture {0:?} \"float\" \"periodic\" \"periodic\" \"box\" 1 1 MakeLatLongEnvironment {0:?} \"all\" \"box\" 1 1
        MakeCubeFaceEnvironment {1} \"cube\" 90 \"box\" 1 1\n",
        path("floats.exr"),
        faces.join(" ")
    );
    let painted = |name: &str, scale: f32| {
        format!(
            "AttributeBegin Surface \"paintedplastic\" \"uniform string texturename\" [\"{name}\"] TextureCoordinates -0.3 -0.4 {scale} -0.2 -0.5 {scale} {scale} {scale}
            Patch \"bilinear\" \"P\" [-1 -1 2 1 -1 2 -1 1 -2 1 1 -2] AttributeEnd "
        )
    };
    let mirror = |name: &str| {
        format!(
            "AttributeBegin Surface \"shinymetal\" \"uniform string texturename\" [\"{name}\"] Sphere 0.7 -0.7 0.7 360 Translate 0.9 0.8 0 Torus 0.4 0.2 0 360 360 AttributeEnd "
        )
    };
    let mut wrong = String::new();
    for (name, world) in [
        ("wraps", ["tex0", "tex1", "tex2"].map(|name| painted(name, 1.7) + "Translate 1.1 0 0 ").concat()),
        ("floats", painted("float", 6.0) + "Translate 1.2 0 0 " + &painted("nothing", 1.0)),
        ("far", painted("tex1", 40.0)),
        ("environments", mirror("all") + "Translate -1.3 0 0 " + &mirror("cube")),
    ] {
        let rib = format!("{maps} {CAMERA}{LIT}{world} WorldEnd");
        wrong += &same(name, &rib, &device);
    }
    assert!(wrong.is_empty(), "{wrong}");
    // What is not in memory as a whole is the processor's.
    let rib =
        format!("Option \"limits\" \"int texturememory\" [1] {maps} {CAMERA}{LIT}{} WorldEnd", painted("tex0", 1.7));
    let own = render(&rib, Some(device), None);
    assert!(matches!(&own.drawn_by, DrawnBy::Fallback(why) if why.contains("`tex0` is larger")), "{:?}", own.drawn_by);
    assert!(own.image == render(&rib, None, None).image);
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

/// Colours that are no finite numbers are reported alike, with the shader.
#[test]
fn colours_that_are_no_numbers_are_reported_on_a_device() {
    let Some(device) = device() else { return };
    let bright = "Color [1e30 1e30 1e30] LightSource \"ambientlight\" \"c\" \"intensity\" 1e30 Sphere 1 -1 1 360";
    for world in [bright.into(), format!("Opacity [0.5 0.5 0.5] {bright}")] {
        let rib = format!("{CAMERA}{LIT}{world} WorldEnd");
        let said = |device| {
            let result = render(&rib, device, None);
            let is_gpu = result.drawn_by == DrawnBy::Gpu;
            let warnings: Vec<String> = result.warnings.iter().filter(|w| w.contains("no finite")).cloned().collect();
            (is_gpu, warnings)
        };
        let (own, other) = (said(Some(device.clone())), said(None));
        assert!(own.0 && !other.0);
        // How many points are shaded differs.
        let without_count = |all: &[String]| -> Vec<String> {
            all.iter().map(|w| w.split(|c: char| c.is_ascii_digit()).collect::<Vec<_>>().join("")).collect()
        };
        assert!(own.1.len() == 1 && own.1[0].contains("the shader `matte`"), "{:?}", own.1);
        assert_eq!(without_count(&own.1), without_count(&other.1));
    }
}

/// What is not built for devices is the processor's whole, and why is said.
#[test]
fn what_a_device_does_not_draw_is_drawn_by_the_processor() {
    let Some(device) = device() else { return };
    for (options, world, why) in [
        ("", "Surface \"glass\" Sphere 1 -1 1 360", "the shader `glass` says how much light gets through"),
        (
            "",
            "Opacity [0.5 0.5 0.5] Points \"P\" [0 0 0 0.3 0.2 0.1] \"constantwidth\" [0.9]",
            "rays meet translucent `Points`",
        ),
        (
            "",
            "AttributeBegin Surface \"occlusionsurf\" Patch \"bilinear\" \"P\" [-2 -0.8 2 2 -0.8 2 -2 -0.8 -2 2 -0.8 -2] AttributeEnd Opacity [0.5 0.5 0.5] Sphere 1 -1 1 360",
            "what translucent surfaces hide",
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
