//! Rules of the interface, each with a value computed by hand and the section of the RISpec 3.2 that has it.

use crate::cli::{scratch, scree};
use crate::rendering::{ORTHO, Rendered, render_with};

/// A surface of the value of a variable.
const SHOW: &[u8] = b"surface show(varying float value = 0;) { Oi = 1; Ci = value; }";

/// Render with the surface shader `show`.
fn show(world: &str) -> Rendered {
    render_with(&[("show.sl", SHOW)], ORTHO, &format!("Surface \"show\"\n{world}"))
}

/// The red of an image at a place of the plane that [`ORTHO`] looks at, which is the mean of the pixels around.
fn red(image: &Rendered, x: f32, y: f32) -> f32 {
    let (i, j) = ((40.0 * (x + 1.0)).round() as usize, (40.0 * (1.0 - y)).round() as usize);
    let four = [(i - 1, j - 1), (i, j - 1), (i - 1, j), (i, j)];
    four.into_iter().map(|(i, j)| image.at(i, j)[0]).sum::<f32>() / 4.0
}

/// The control points of a flat square with corners ±0.9, evenly spread, `n` along each side.
fn square(n: usize) -> String {
    let at = |k: usize| -0.9 + 1.8 * k as f32 / (n as f32 - 1.0);
    (0..n * n).map(|k| format!("{} {} 0 ", at(k % n), at(k / n))).collect()
}

#[test]
fn vertex_variables_follow_the_control_points_of_cubic_patches() {
    // RISpec 5: a vertex variable is interpolated by the same basis as the surface. Bézier: the middle of the patch has
    // (3/8 + 3/8)² of the four inner values, the point u = ¼ of the middle row (27 + 9)/64 · ¾.
    let net = "0 0 0 0 0 1 1 0 0 1 1 0 0 0 0 0";
    let image = show(&format!("Patch \"bicubic\" \"P\" [{}] \"vertex float value\" [{net}]", square(4)));
    assert!((red(&image, 0.0, 0.0) - 0.5625).abs() < 2e-3, "{}", red(&image, 0.0, 0.0));
    assert!((red(&image, -0.45, 0.0) - 0.421875).abs() < 2e-3, "{}", red(&image, -0.45, 0.0));
    // B-spline: a lone 1 at an inner point weighs (23/48)² in the middle of the patch.
    let bspline = "Basis \"b-spline\" 1 \"b-spline\" 1";
    let image = show(&format!(
        "{bspline} Patch \"bicubic\" \"P\" [{}] \"vertex float value\" [0 0 0 0 0 1 0 0 0 0 0 0 0 0 0 0]",
        square(4)
    ));
    assert!((red(&image, 0.0, 0.0) - (23.0f32 / 48.0).powi(2)).abs() < 3e-3, "{}", red(&image, 0.0, 0.0));
    // A subdivision mesh of nine points, of which the middle one has 1: as on a uniform B-spline it keeps (4/6)² there.
    let mesh = "SubdivisionMesh \"catmull-clark\" [4 4 4 4] [0 1 4 3 1 2 5 4 3 4 7 6 4 5 8 7] [\"interpolateboundary\"] [0 0] [] []";
    let image = show(&format!("{mesh} \"P\" [{}] \"vertex float value\" [0 0 0 0 1 0 0 0 0]", square(3)));
    assert!((red(&image, 0.0, 0.0) - 4.0 / 9.0).abs() < 5e-3, "{}", red(&image, 0.0, 0.0));
    // A mesh of two Bézier patches along u: the same middle in each, and vertex s.
    let points: String =
        (0..28).map(|k| format!("{} {} 0 ", -0.9 + 0.3 * (k % 7) as f32, -0.9 + 0.6 * (k / 7) as f32)).collect();
    let row = |x: &str| x.to_string();
    let values =
        format!("{}{}{}{}", row("0 0 0 0 0 0 0 "), row("0 1 1 0 2 2 0 "), row("0 1 1 0 2 2 0 "), row("0 0 0 0 0 0 0 "));
    let basis = "Basis \"bezier\" 3 \"bezier\" 3";
    for (declared, surface) in [("vertex float value", "show"), ("vertex float s", "coordinate")] {
        let image = render_with(
            &[("show.sl", SHOW), ("coordinate.sl", b"surface coordinate() { Oi = 1; Ci = s; }")],
            ORTHO,
            &format!(
                "Surface \"{surface}\" {basis} PatchMesh \"bicubic\" 7 \"nonperiodic\" 4 \"nonperiodic\" \"P\" [{points}] \"{declared}\" [{values}]"
            ),
        );
        let (left, right) = (red(&image, -0.45, 0.0), red(&image, 0.45, 0.0));
        assert!((left - 0.5625).abs() < 2e-3 && (right - 1.125).abs() < 4e-3, "{declared}: {left} {right}");
    }
}

#[test]
fn vertex_variables_follow_nurbs_and_cubic_curves() {
    // RISpec 5.3: of order 4 without inner knots a NURBS is the Bézier patch; with weights 1 and 3 along u the point u = ½ of a
    // linear one has (1·0 + 3·1)/(1 + 3) of the values 0 and 1.
    let knots = "4 4 [0 0 0 0 1 1 1 1] 0 1";
    let net = "0 0 0 0 0 1 1 0 0 1 1 0 0 0 0 0";
    let image = show(&format!("NuPatch {knots} {knots} \"P\" [{}] \"vertex float value\" [{net}]", square(4)));
    assert!((red(&image, 0.0, 0.0) - 0.5625).abs() < 2e-3, "{}", red(&image, 0.0, 0.0));
    let linear = "2 2 [0 0 1 1] 0 1";
    let points = "-0.9 -0.9 0 1  2.7 -2.7 0 3  -0.9 0.9 0 1  2.7 2.7 0 3";
    let image = show(&format!("NuPatch {linear} {linear} \"Pw\" [{points}] \"vertex float value\" [0 1 0 1]"));
    // u = ½ stands at x = (−0.9 + 2.7)/4.
    assert!((red(&image, 0.45, 0.0) - 0.75).abs() < 5e-3, "{}", red(&image, 0.45, 0.0));
    // Curves: Bézier values 0 1 1 0 have 3/4 in the middle; two segments have their own.
    let curve =
        |n: usize| -> String { (0..n).map(|k| format!("0 {} 0 ", -0.9 + 1.8 * k as f32 / (n as f32 - 1.0))).collect() };
    let image = show(&format!(
        "Curves \"cubic\" [4] \"nonperiodic\" \"P\" [{}] \"vertex float value\" [0 1 1 0] \"constantwidth\" [0.4]",
        curve(4)
    ));
    assert!((red(&image, 0.0, 0.0) - 0.75).abs() < 5e-3, "{}", red(&image, 0.0, 0.0));
    let image = show(&format!(
        "Curves \"cubic\" [7] \"nonperiodic\" \"P\" [{}] \"vertex float value\" [0 1 1 0 2 2 0] \"constantwidth\" [0.4]",
        curve(7)
    ));
    let (low, high) = (red(&image, 0.0, -0.45), red(&image, 0.0, 0.45));
    assert!((low - 0.75).abs() < 5e-3 && (high - 1.5).abs() < 1e-2, "{low} {high}");
    // A width at every vertex: 0 0.8 0.8 0 is 0.6 wide in the middle.
    let image = show(&format!(
        "Curves \"cubic\" [4] \"nonperiodic\" \"P\" [{}] \"vertex float width\" [0 0.8 0.8 0] \"constant float value\" [1]",
        curve(4)
    ));
    let wide: f32 = (0..80).map(|x| image.at(x, 40)[0]).sum::<f32>() / 40.0;
    assert!((wide - 0.6).abs() < 0.02, "{wide}");
}

#[test]
fn points_and_directions_come_to_current_space() {
    // RISpec 5: points, vectors and normals are given in object space and handed to shaders in current space, which is world here.
    let shader = b"surface place(varying point at = 0; varying vector way = 0; varying normal up = 0; uniform point lone = 0; string what = \"at\";) {
        Oi = 1;
        if (what == \"at\") Ci = color(xcomp(at), ycomp(at), zcomp(at));
        else if (what == \"way\") Ci = color(xcomp(way), ycomp(way), zcomp(way));
        else if (what == \"up\") Ci = color(xcomp(up), ycomp(up), zcomp(up));
        else Ci = color(xcomp(lone), ycomp(lone), zcomp(lone)); }";
    let four = |v: &str| format!("{v} ").repeat(4);
    let primitives = [
        format!("Polygon \"P\" [-0.3 -0.3 0 0.3 -0.3 0 0.3 0.3 0 -0.3 0.3 0] \"vertex point at\" [{0}] \"varying vector way\" [{0}] \"varying normal up\" [{0}] \"uniform point lone\" [1 2 3]", four("1 2 3")),
        format!("Disk 0 0.3 360 \"varying point at\" [{0}] \"varying vector way\" [{0}] \"varying normal up\" [{0}] \"constant point lone\" [1 2 3]", four("1 2 3")),
        "Sphere 0.3 -0.3 0.3 360 \"uniform point at\" [1 2 3] \"uniform vector way\" [1 2 3] \"uniform normal up\" [1 2 3] \"uniform point lone\" [1 2 3]".into(),
        "Points \"P\" [0 0 0] \"constantwidth\" [0.6] \"vertex point at\" [1 2 3] \"varying vector way\" [1 2 3] \"varying normal up\" [1 2 3] \"uniform point lone\" [1 2 3]".into(),
    ];
    for primitive in &primitives {
        // Moved by (0, 0, 0.5), and stretched along x by 2: a normal shrinks there as much.
        for (what, expected) in
            [("at", [2.0, 2.0, 3.5]), ("way", [2.0, 2.0, 3.0]), ("up", [0.5, 2.0, 3.0]), ("lone", [2.0, 2.0, 3.5])]
        {
            for world in [
                format!("Translate 0 0 0.5 Scale 2 1 1 {primitive}"),
                format!("ObjectBegin 1 Scale 2 1 1 {primitive} ObjectEnd Translate 0 0 0.5 ObjectInstance 1"),
            ] {
                let image = render_with(
                    &[("place.sl", shader)],
                    ORTHO,
                    &format!("Surface \"place\" \"string what\" \"{what}\" {world}"),
                );
                let found = image.at(40, 40);
                let near = (0..3).all(|c| (found[c] - expected[c]).abs() < 1e-3);
                assert!(near, "{what} of {world}: {found:?}, expected {expected:?}");
            }
        }
    }
}

#[test]
fn displacement_shaders_have_the_variables_of_patches() {
    // RISpec 5: what a primitive has, every shader of it may read. Seen from the side, a square rises from 0 to 0.6.
    let side = "Format 80 80 1 PixelSamples 8 8 PixelFilter \"box\" 1 1 Projection \"orthographic\" Translate 0 0 5 Rotate 90 1 0 0";
    let out = b"displacement out(varying float value = 0;) { P += value * normalize(N); N = calculatenormal(P); }";
    let world = "Displacement \"out\" Attribute \"displacementbound\" \"sphere\" [1] Surface \"constant\" Patch \"bilinear\" \"P\" [-0.5 -0.5 0 0.5 -0.5 0 -0.5 0.5 0 0.5 0.5 0] \"varying float value\" [0 0 0.6 0.6]";
    let image = render_with(&[("out.sl", out)], side, world);
    assert!((area(&image) - 0.6).abs() < 0.01, "{}", area(&image));
}

/// The area that an image of [`ORTHO`] shows as white, in square units.
pub fn area(image: &Rendered) -> f32 {
    image.pixels.iter().map(|p| p[0]).sum::<f32>() / 1600.0
}

/// [`ORTHO`] with the shutter open from one time to another.
fn at(open: f32, close: f32) -> String {
    ORTHO.replace("Translate", &format!("Shutter {open} {close} Translate"))
}

#[test]
fn moving_quadrics_are_cut_alike() {
    // RISpec 6.3: a primitive goes straight from its first form to its last, also where it sweeps another angle.
    let pi = std::f32::consts::PI;
    let disk = "Surface \"constant\" MotionBegin [0 1] Disk 0 0.8 180 Disk 0 0.8 360 MotionEnd";
    let sphere = "Surface \"constant\" MotionBegin [0 1] Sphere 0.8 -0.8 0.8 180 Sphere 0.8 -0.8 0.8 360 MotionEnd";
    let shrinks = "Surface \"constant\" MotionBegin [0 1] Sphere 0.8 -0.8 0.8 360 Sphere 0.4 -0.4 0.4 360 MotionEnd";
    for (world, time, expected) in [
        (disk, 0.0, 0.32 * pi),
        (disk, 1.0, 0.64 * pi),
        (sphere, 0.0, 0.32 * pi),
        (sphere, 1.0, 0.64 * pi),
        (shrinks, 1.0, 0.16 * pi),
    ] {
        let found = area(&render_with(&[], &at(time, time), world));
        assert!((found - expected).abs() < 0.01, "{world} at {time}: {found}, expected {expected}");
    }
    // A polygon that is cut to triangles at the first time is cut so at the last.
    let polygon = |p: &str| format!("Polygon \"P\" [-0.5 -0.5 0 0.5 -0.5 0 {p} -0.5 0.5 0]");
    let moves =
        format!("Surface \"constant\" MotionBegin [0 1] {} {} MotionEnd", polygon("-0.2 -0.2 0"), polygon("0.5 0.5 0"));
    for (time, expected) in [(0.0, 0.3), (1.0, 1.0)] {
        let found = area(&render_with(&[], &at(time, time), &moves));
        assert!((found - expected).abs() < 0.01, "at {time}: {found}, expected {expected}");
    }
}

#[test]
fn objects_keep_their_own_attributes_and_motion_and_no_others_get_them() {
    // RISpec 5.7: an object has the attributes of where it is instanced, but for those that are set within it.
    let colour = |options: &str, world: &str, x: f32, y: f32| {
        let image = render_with(&[("show.sl", SHOW)], options, &format!("Surface \"constant\"\n{world}"));
        let pixel = image.at((40.0 * (x + 1.0)) as usize, (40.0 * (1.0 - y)) as usize);
        [pixel[0], pixel[1], pixel[2]]
    };
    let two = "ObjectBegin 1 AttributeBegin Color 1 0 0 Translate -0.5 0 0 Disk 0 0.3 360 AttributeEnd Translate 0.5 0 0 Disk 0 0.3 360 ObjectEnd Color 0 0 1 ObjectInstance 1";
    assert_eq!(colour(ORTHO, two, -0.5, 0.0), [1.0, 0.0, 0.0]);
    assert_eq!(colour(ORTHO, two, 0.5, 0.0), [0.0, 0.0, 1.0]);
    let leaks = "Color 0 1 0 ObjectBegin 1 Color 1 0 0 Disk 0 0.3 360 ObjectEnd Disk 0 0.2 360";
    assert_eq!(colour(ORTHO, leaks, 0.0, 0.0), [0.0, 1.0, 0.0]);
    // Set to what it is anyway is set too.
    let white =
        "ObjectBegin 1 AttributeBegin Color 1 1 1 Disk 0 0.3 360 AttributeEnd ObjectEnd Color 1 0 0 ObjectInstance 1";
    assert_eq!(colour(ORTHO, white, 0.0, 0.0), [1.0, 1.0, 1.0]);
    let points = "ObjectBegin 1 Points \"P\" [-0.5 0 0 0.5 0 0] \"constantwidth\" [0.4] \"varying color Cs\" [1 0 0 0 1 0] ObjectEnd ObjectInstance 1";
    assert_eq!(colour(ORTHO, points, 0.5, 0.0), [0.0, 1.0, 0.0]);
    let moves = "ObjectBegin 1 MotionBegin [0 1] Translate 0 0 0 Translate 0.5 0 0 MotionEnd Disk 0 0.2 360 ObjectEnd Translate 0 0.5 0 ObjectInstance 1 Translate 0 -1 0 Disk 0 0.2 360";
    assert_eq!(colour(&at(1.0, 1.0), moves, 0.5, 0.5)[0], 1.0);
    assert_eq!(colour(&at(1.0, 1.0), moves, 0.0, 0.5)[0], 0.0);
    assert_eq!(colour(&at(1.0, 1.0), moves, 0.0, -0.5)[0], 1.0);
    // An object may be made of others.
    let nested = "ObjectBegin 1 Disk 0 0.2 360 ObjectEnd ObjectBegin 2 Translate 0.5 0 0 ObjectInstance 1 ObjectEnd Translate 0 0.5 0 ObjectInstance 2";
    assert_eq!(colour(ORTHO, nested, 0.5, 0.5)[0], 1.0);
    // What is cut away of NURBS patches is an attribute.
    let trim = "AttributeBegin TrimCurve [1] [2] [0 0 1 2 3 4 4] [0] [4] [5] [0.25 0.75 0.75 0.25 0.25] [0.25 0.25 0.75 0.75 0.25] [1 1 1 1 1] AttributeEnd NuPatch 2 2 [0 0 1 1] 0 1 2 2 [0 0 1 1] 0 1 \"P\" [-0.9 -0.9 0 0.9 -0.9 0 -0.9 0.9 0 0.9 0.9 0]";
    assert_eq!(colour(ORTHO, trim, 0.7, 0.7)[0], 1.0);
}

/// The colour in the middle of a disk with a surface shader of this body; `before` stands before it.
fn shaded(before: &str, body: &str) -> [f32; 3] {
    let shader = format!("surface t() {{ {body} }}");
    let world = format!("{before} Surface \"t\" Disk 0 0.8 360");
    let [r, g, b, _] = render_with(&[("t.sl", shader.as_bytes())], ORTHO, &world).at(40, 40);
    [r, g, b]
}

fn near(found: [f32; 3], expected: [f32; 3]) {
    let off = (0..3).map(|c| (found[c] - expected[c]).abs()).fold(0.0, f32::max);
    assert!(off < 2e-3, "{found:?}, expected {expected:?}");
}

#[test]
fn small_rules_of_the_language() {
    // A number of C, a chain of assignments (RISpec 17), and the light between two points by its older name.
    near(
        shaded("", "float a, b; float c[2]; a = b = 0.5f; c[0] = c[1] = a; Oi = 1; Ci = color(b, c[0], c[1]);"),
        [0.5; 3],
    );
    near(shaded("", "Oi = 1; Ci = visibility(P, P - vector(0, 0, 10));"), [1.0; 3]);
    // What is not reflected is refracted: at normal incidence on glass 0.2² / 2.5² · 6.25 = 0.04 and 0.96 (RISpec 15.3).
    let glass =
        "float kr, kt; fresnel(vector(0, 0, 1), normal(0, 0, -1), 1 / 1.5, kr, kt); Oi = 1; Ci = color(kr, kt, 0);";
    near(shaded("", glass), [0.04, 0.96, 0.0]);
    // Another random number at each call, and in each turn of a loop (RISpec 15.4).
    let differ = "float a = random(); float b = random(); float same = a == b ? 1 : 0; float i;
        for (i = 0; i < 5; i += 1) { b = random(); if (a == b) same = 1; a = b; } Oi = 1; Ci = same;";
    near(shaded("", differ), [0.0; 3]);
    let mean = "float sum = 0; float i; for (i = 0; i < 400; i += 1) { sum += random(); } Oi = 1; Ci = sum / 400;";
    assert!((shaded("", mean)[0] - 0.5).abs() < 0.06);
    // Options of the image (RISpec 15.8).
    let format =
        "uniform float f[3] = {0, 0, 0}; option(\"Format\", f); Oi = 1; Ci = color(f[0] / 100, f[1] / 100, f[2]);";
    near(shaded("", format), [0.8, 0.8, 1.0]);
    near(shaded("", &format.replace("Format", "DeviceResolution")), [0.8, 0.8, 1.0]);
    let crop = "uniform float f[4] = {0, 0, 0, 0}; option(\"CropWindow\", f); Oi = 1; Ci = color(f[1], f[3], f[0]);";
    near(shaded("", crop), [1.0, 1.0, 0.0]);
    let aspect =
        "uniform float f = 0; float known = option(\"FrameAspectRatio\", f); Oi = 1; Ci = color(f / 2, known, 0);";
    near(shaded("", aspect), [0.5, 1.0, 0.0]);
    // Sources of others have comments in Latin-1.
    let shader = b"surface t() { /* caf\xe9 */ Oi = 1; Ci = 0.5; }";
    let image = render_with(&[("t.sl", shader)], ORTHO, "Surface \"t\" Disk 0 0.8 360");
    assert_eq!(image.at(40, 40)[0], 0.5);
    // Others begin with the mark of UTF-8.
    let shader = "\u{feff}surface t() { /* café */ Oi = 1; Ci = 0.5; }".as_bytes();
    let image = render_with(&[("t.sl", shader)], ORTHO, "Surface \"t\" Disk 0 0.8 360");
    assert_eq!(image.at(40, 40)[0], 0.5);
    // Scenes have Latin-1 in their strings.
    let work = scratch();
    let path = work.path().join("t.rib");
    let text =
        format!("Display \"t.png\" \"png\" \"rgb\"\n{ORTHO}\nWorldBegin\nAttribute \"identifier\" \"name\" [\"caf");
    let text = [text.as_bytes(), b"\xe9\"]\nDisk 0 0.8 360\nWorldEnd\n"].concat();
    std::fs::write(&path, text).unwrap();
    scree(&["render", path.to_str().unwrap(), "-o", work.path().to_str().unwrap()]).ok();
}

#[test]
fn shaders_tell_those_after_them() {
    // RISpec 15.8: output parameters are read as the shader left them. At x = 0.5 h is 0.5, and g 0.75.
    let displacement = b"displacement d(float amp = 0.2; output varying float h = 0; output varying float g = 0;) { h = amp * 2; g = 0.5 + 0.5 * xcomp(transform(\"object\", P)); }";
    let surface = b"surface t(output varying float told = 0;) { float x = 0, y = 0, z = 0; displacement(\"h\", x); displacement(\"g\", y); displacement(\"amp\", z); told = y; Oi = 1; Ci = color(x, y, z); }";
    let volume = b"volume v() { float y = 0; surface(\"told\", y); Ci = color(comp(Ci, 0), comp(Ci, 1), y); }";
    let files: [(&str, &[u8]); 3] = [("d.sl", displacement), ("t.sl", surface), ("v.sl", volume)];
    let world = "Displacement \"d\" \"float amp\" [0.25] Surface \"t\" Disk 0 0.8 360";
    let place = |image: &Rendered| [0, 1, 2].map(|c| image.at(60, 40)[c]);
    let off = 0.5 + 0.5 * 0.5125;
    near(place(&render_with(&files, ORTHO, world)), [0.5, off, 0.25]);
    near(place(&render_with(&files, ORTHO, &format!("Atmosphere \"v\" {world}"))), [0.5, off, off]);
}

#[test]
fn lights_and_null_shaders() {
    let disk = "Surface \"matte\" Disk 0 0.8 360";
    let lit = |lights: &str| {
        let light = b"light l() { illuminate(point \"world\" (0, 0, -3)) { Cl = abs(zcomp(normalize(Ns))) * color(0.5, 0, 0); } }";
        let [r, g, b, _] = render_with(&[("l.sl", light)], ORTHO, &format!("{lights} {disk}")).at(40, 40);
        [r, g, b]
    };
    // RISpec 5.2.1: a handle that is used again names another light; both shine.
    let two = "LightSource \"ambientlight\" 1 \"intensity\" [0.25] LightSource \"ambientlight\" 1 \"intensity\" [0.5]";
    near(lit(two), [0.75; 3]);
    near(lit(&format!("{two} Illuminate 1 0")), [0.25; 3]);
    // The normal of what is lit: the disk is met squarely.
    near(lit("LightSource \"l\" 1"), [0.5, 0.0, 0.0]);
    // RISpec A.1: a null shader of every kind.
    near(lit("LightSource \"null\" 1 LightSource \"ambientlight\" 2"), [1.0; 3]);
    let image = render_with(
        &[],
        ORTHO,
        "Surface \"null\" Displacement \"null\" Atmosphere \"null\" Interior \"null\" Color 0.25 0.5 0.75 Disk 0 0.8 360",
    );
    let [r, g, b, _] = image.at(40, 40);
    near([r, g, b], [0.25, 0.5, 0.75]);
}

/// RISpec 5.1.6: interiors are those of solids.
#[test]
fn volumes_that_do_nothing_are_said() {
    let fog = b"volume v() { Ci *= 0.5; }";
    let through = b"surface t() { Oi = 1; Ci = trace(P, vector(0, 0, 1)); }";
    let square = |at: &str| format!("TransformBegin {at} Polygon \"P\" [-1 -1 1 1 -1 1 1 1 1 -1 1 1] TransformEnd\n");
    let turns = ["", "Rotate 90 1 0 0", "Rotate 180 1 0 0", "Rotate 270 1 0 0", "Rotate 90 0 1 0", "Rotate 270 0 1 0"];
    let sides: Vec<String> = turns.map(square).into();
    let (open, idle) = ("what has the interior `v` does not enclose a volume", "no shader here traces any");
    for (world, expected) in [
        (format!("Surface \"t\" {}", sides[0]), [true, false]),
        (format!("Surface \"t\" {}", sides[..5].concat()), [true, false]),
        (format!("Surface \"t\" {}", sides.concat()), [false, false]),
        ("Surface \"t\" Sphere 1 -1 1 360".into(), [false, false]),
        ("Surface \"t\" Sphere 1 0 1 360".into(), [true, false]),
        ("Surface \"t\" Sphere 1 0 1 360 Disk 0 1 360".into(), [false, false]),
        ("Surface \"t\" SolidBegin \"primitive\" Sphere 1 -1 1 360 SolidEnd".into(), [false, false]),
        (format!("Surface \"matte\" {}", sides[0]), [false, true]),
    ] {
        let work = scratch();
        std::fs::write(work.path().join("v.sl"), fog).unwrap();
        std::fs::write(work.path().join("t.sl"), through).unwrap();
        let path = work.path().join("t.rib");
        let text =
            format!("Display \"t.png\" \"png\" \"rgb\"\n{ORTHO}\nWorldBegin\nInterior \"v\"\n{world}\nWorldEnd\n");
        std::fs::write(&path, text).unwrap();
        let answer = scree(&["render", path.to_str().unwrap(), "-o", work.path().to_str().unwrap()]);
        let said = answer.errors();
        assert_eq!([open, idle].map(|part| said.contains(part)), expected, "{world}: {said}");
        assert!(!expected.contains(&true) || said.contains("t.rib:5:"), "{said}");
    }
}

#[test]
fn rays_go_through_volumes() {
    // RISpec 5.1.6: a ray of length 1 through fog of depth 1 keeps e⁻¹ of its red.
    let fog =
        b"volume v(float d = 1; color c = color(0, 1, 0);) { float f = 1 - exp(-length(I) / d); Ci = mix(Ci, c, f); }";
    let through = b"surface t() { Oi = 1; Ci = raylevel() > 0 ? color(1, 0, 0) : trace(P, vector(0, 0, 1)); }";
    let files: [(&str, &[u8]); 2] = [("v.sl", fog), ("t.sl", through)];
    let kept = (-1.0f32).exp();
    let pane = "Surface \"t\" Polygon \"P\" [-0.5 -0.5 0 0.5 -0.5 0 0.5 0.5 0 -0.5 0.5 0]";
    let wall = "Surface \"constant\" Color 1 0 0 Polygon \"P\" [-1 -1 1 -1 1 1 1 1 1 1 -1 1]";
    for (world, expected) in [
        ("Interior \"v\" Surface \"t\" Sphere 0.5 -0.5 0.5 360".to_string(), [kept, 1.0 - kept, 0.0]),
        (format!("AttributeBegin Exterior \"v\" {pane} AttributeEnd {wall}"), [kept, 1.0 - kept, 0.0]),
        (format!("AttributeBegin Interior \"v\" {pane} AttributeEnd {wall}"), [1.0, 0.0, 0.0]),
    ] {
        let [r, g, b, _] = render_with(&files, ORTHO, &world).at(40, 40);
        assert!((r - expected[0]).abs() < 5e-3 && (g - expected[1]).abs() < 5e-3, "{world}: {r} {g} {b}");
    }
}

#[test]
fn levels_of_detail_share_the_samples() {
    // RISpec 5.6: half way between two levels, each is seen by half of the samples, and both together by all.
    let disk = "Disk 0 0.8 360";
    let coarse = format!("Surface \"constant\" Detail [-1 1 -1 1 0 0] DetailRange [0 0 3200 9600] {disk}");
    let mean = |image: &Rendered| {
        (30..50).flat_map(|y| (30..50).map(move |x| (x, y))).map(|(x, y)| image.at(x, y)[0]).sum::<f32>() / 400.0
    };
    let found = mean(&render_with(&[], ORTHO, &coarse));
    assert!((found - 0.5).abs() < 0.02, "{found}");
    let both = render_with(&[], ORTHO, &format!("{coarse} DetailRange [3200 9600 1e30 1e30] {disk}"));
    assert_eq!(mean(&both), 1.0);
}

#[test]
fn displays_have_their_own_levels_and_windows_give_way() {
    let work = scratch();
    let path = work.path().join("t.rib");
    let rib = format!(
        "Display \"win\" \"framebuffer\" \"rgb\" Display \"+t.png\" \"file\" \"rgb\" \"quantize\" [0 65535 0 65535] Display \"+low.png\" \"png\" \"rgb\" \"quantize\" [10 210 10 110] Display \"+noise.png\" \"png\" \"rgb\" \"dither\" [40]
        Quantize \"rgba\" 255 0 255 0 {ORTHO} WorldBegin Format 10 10 1 Surface \"constant\" Color [0.25 0.5 0.75] Disk 0 0.8 360 WorldEnd\n"
    );
    std::fs::write(&path, rib).unwrap();
    let said = scree(&["render", path.to_str().unwrap(), "-o", work.path().to_str().unwrap()]);
    // RISpec 4: an option cannot change within the world.
    assert!(said.errors().contains("`Format` stands between WorldBegin and WorldEnd"), "{}", said.errors());
    said.ok();
    let deep = image::open(work.path().join("t.png")).unwrap().to_rgb16();
    assert_eq!(deep.dimensions(), (80, 80));
    assert_eq!(deep.get_pixel(40, 40).0, [16384, 32768, 49151]);
    // 10 + 200 x, at most 110.
    assert_eq!(image::open(work.path().join("low.png")).unwrap().to_rgb8().get_pixel(40, 40).0, [60, 110, 110]);
    // Dither of one display alone: other levels from pixel to pixel, of the same mean.
    let noise = image::open(work.path().join("noise.png")).unwrap().to_rgb8();
    let levels: Vec<f32> =
        (20..60).flat_map(|x| (30..50).map(move |y| (x, y))).map(|(x, y)| noise.get_pixel(x, y).0[1] as f32).collect();
    let mean = levels.iter().sum::<f32>() / levels.len() as f32;
    assert!((mean - 127.5).abs() < 3.0 && levels.iter().any(|x| (x - mean).abs() > 20.0), "{mean}");
    assert!(!work.path().join("win").exists());
}

#[test]
fn colours_of_other_samples_become_red_green_and_blue() {
    // RISpec 4.2.3: with n samples a colour is a row of n numbers, times the n rows of the first matrix.
    let one = "ColorSamples [0.8 0.5 0.2] [0.3 0.3 0.4]";
    let two = "ColorSamples [1 0 0  0 0.5 0.5] [1 0  0 1  0 1]";
    let disk = "Disk 0 0.8 360";
    for (samples, world, expected) in [
        (one, format!("Surface \"constant\" Color [0.5] {disk}"), [0.4, 0.25, 0.1]),
        (one, format!("Surface \"constant\" Color 0.5 {disk}"), [0.4, 0.25, 0.1]),
        (two, format!("Surface \"constant\" Color [0.5 0.8] {disk}"), [0.5, 0.4, 0.4]),
        (two, format!("Surface \"constant\" {disk} \"constant color Cs\" [0.5 0.8]"), [0.5, 0.4, 0.4]),
    ] {
        let image = render_with(&[], &format!("{ORTHO} {samples}"), &world);
        let [r, g, b, _] = image.at(40, 40);
        near([r, g, b], expected);
    }
}

#[test]
fn what_goes_wrong_is_said() {
    let work = scratch();
    let said = |files: &[(&str, &str)], text: &str| {
        for (name, text) in files {
            std::fs::write(work.path().join(name), text).unwrap();
        }
        let path = work.path().join("t.rib");
        std::fs::write(&path, text).unwrap();
        scree(&["render", path.to_str().unwrap(), "-o", work.path().to_str().unwrap()])
    };
    let head = format!("Display \"t.png\" \"png\" \"rgb\"\n{ORTHO}\nWorldBegin\n");
    let index = "surface t() {\n float a[3] = {1, 2, 3}; float i = 5 + floor(random()); Oi = 1; Ci = a[i]; }";
    let answer = said(&[("t.sl", index)], &format!("{head}Surface \"t\" Disk 0 0.8 360\nWorldEnd\n"));
    assert!(
        answer.errors().contains("t.sl:2:70: the shader `t` uses element 5 of an array, expected 0 to 2"),
        "{}",
        answer.errors()
    );
    let component = "surface t() {\n float i = 5 + 3 * u; vector v = 1; v[i] = 2; Oi = 1; Ci = comp(v, i); }";
    let answer = said(&[("t.sl", component)], &format!("{head}Surface \"t\" Disk 0 0.8 360\nWorldEnd\n"));
    let warnings = answer.errors().matches("uses component 5, expected 0 to 2").count();
    assert!(warnings == 1 && answer.errors().contains("t.sl:2:"), "{}", answer.errors());
    for fixed in ["setcomp(v, -1, 2);", "v[1 + 2] = 1;", "Ci = comp(v, -2);", "matrix m = 1; Ci = comp(m, 0, 2 * 2);"] {
        let index = format!("surface t() {{\n vector v = 1; Oi = 1; {fixed} }}");
        let answer = said(&[("t.sl", &index)], &format!("{head}Surface \"t\" Disk 0 0.8 360\nWorldEnd\n"));
        assert!(answer.fails(3).contains("the index of a component is"), "{fixed}");
    }
    let default =
        "float f() { float x = 0; while (x < 1) x *= 1; return x; } surface t(float k = f();) { Oi = 1; Ci = k; }";
    let answer = said(&[("t.sl", default)], &format!("{head}Surface \"t\" Disk 0 0.8 360\nWorldEnd\n"));
    let errors = answer.fails(3);
    assert!(errors.contains("t.rib:4:1: the loops of the shader `t` do not end, in "), "{errors}");
    assert!(errors.contains("t.sl:1:26"), "{errors}");
    let block = "MotionBegin [0 1]\nAttributeBegin Translate 0 0 0 AttributeEnd Translate 0 0 0\nMotionEnd\n";
    let answer = said(&[], &format!("{head}{block}Disk 0 0.8 360\nWorldEnd\n"));
    assert!(answer.errors().contains("t.rib:5:1: `AttributeBegin` in a motion block"), "{}", answer.errors());
    // Of loops within each other it is that which goes on and on.
    let endless = "surface t() {\n float i, j = 0;\n while (j < 1)\n for (i = 0; i < 9; i += 1) Ci += 1;\n }";
    let answer = said(&[("t.sl", endless)], &format!("{head}Surface \"t\" Disk 0 0.8 360\nWorldEnd\n"));
    assert!(answer.errors().contains("t.sl:3"), "{}", answer.errors());
    // The primitive is named that the shader runs on first, in an archive, too.
    let world = "Sphere 0.1 -0.1 0.1 360\nReadArchive \"a.rib\"\nSphere 0.2 -0.2 0.2 360\nWorldEnd\n";
    let archive = "Surface \"t\"\n Disk 0 0.8 360\nDisk 0.5 0.8 360\n";
    let answer = said(&[("t.sl", endless), ("a.rib", archive)], &format!("{head}{world}"));
    assert!(answer.errors().contains("a.rib:2:2: the loops of the shader `t` do not end"), "{}", answer.errors());
    let answer = said(&[], &format!("{head}Scale 0 0 0 Disk 0 0.8 360\nWorldEnd\n"));
    assert!(answer.errors().contains("`Scale 0 0 0` cannot be inverted"), "{}", answer.errors());
    let far = "displacement d() { P += pow(10, 30) * pow(10, 30) * N; }";
    let answer = said(&[("d.sl", far)], &format!("{head}Displacement \"d\" Disk 0 0.8 360\nWorldEnd\n"));
    assert!(
        answer.errors().contains("d.sl: displacement `d` moves points to places that are not finite"),
        "{}",
        answer.errors()
    );
    let farther = "displacement d() { P += pow(10, 20) * N; }";
    let answer = said(&[("d.sl", farther)], &format!("{head}Displacement \"d\" Disk 0 0.8 360\nWorldEnd\n"));
    assert!(answer.errors().contains("displacement `d` reaches farther than its bound"), "{}", answer.errors());
    let answer = said(&[], &format!("{head}Disk 0 0.8 360\n"));
    assert!(answer.fails(3).contains("has no WorldEnd"));
}

#[test]
fn spheres_in_one_place_are_drawn_once() {
    // Ten thousand spheres in one place: what is as another before it is not diced, sampled or met by rays.
    let points = "0 0 0 ".repeat(10_000);
    let world = format!(
        "LightSource \"distantlight\" 1 \"from\" [0 0 0] \"to\" [0 0 1] Surface \"matte\" \"Ka\" 0 \"Kd\" 1 Points \"P\" [{points} 0.9 0.9 0] \"constantwidth\" [0.4]"
    );
    let begun = std::time::Instant::now();
    let image = render_with(&[], ORTHO, &world);
    assert!(begun.elapsed().as_secs() < 60, "{:?}", begun.elapsed());
    assert!((image.at(40, 40)[0] - 1.0).abs() < 0.01 && image.at(76, 4)[0] > 0.9);
}

#[test]
fn blobbies_remember_where_their_leaves_were() {
    // A leaf of radius 1.2 about x = 0.2 was at x = 5 with twice its size: the point (0.2, 0.3) of it was at 5 + 0, 0.3 · 2.
    let shader = b"surface place(varying point at = 0;) { Oi = 1; Ci = color(xcomp(at), ycomp(at), 0); }";
    let leaf = "1.2 0 0 0 0 1.2 0 0 0 0 1.2 0 0.2 0 0 1";
    let rest = "2.4 0 0 0 0 2.4 0 0 0 0 2.4 0 5 0 0 1";
    let world = format!("Surface \"place\" Blobby 1 [1001 0] [{leaf}] [\"\"] \"vertex mpoint at\" [{rest}]");
    let image = render_with(&[("place.sl", shader)], ORTHO, &world);
    let [x, y, ..] = image.at(48, 28);
    assert!((x - 5.025).abs() < 0.04 && (y - 0.575).abs() < 0.04, "{x} {y}");
}

#[test]
fn bytes_of_textures_are_linear_unless_they_are_tagged() {
    let image = image::RgbImage::from_pixel(4, 4, image::Rgb([128; 3]));
    let mut png = std::io::Cursor::new(Vec::new());
    image.write_to(&mut png, image::ImageFormat::Png).unwrap();
    let plain = png.into_inner();
    // A chunk before the image: its length, kind, one byte, and a check sum (of "sRGB\0").
    let mut tagged = plain.clone();
    tagged.splice(33..33, [0, 0, 0, 1, b's', b'R', b'G', b'B', 0, 0xae, 0xce, 0x1c, 0xe9]);
    let surface = b"surface map() { Oi = 1; Ci = texture(\"p.png\", 0.5, 0.5); }";
    let red = |png: &[u8], options: &str| {
        let options = format!("{options} {ORTHO}");
        render_with(&[("map.sl", surface), ("p.png", png)], &options, "Surface \"map\" Disk 0 0.8 360").at(40, 40)[0]
    };
    // IEC 61966-2-1: 128/255 encoded is 0.21586.
    assert!((red(&plain, "") - 128.0 / 255.0).abs() < 1e-4);
    assert!((red(&tagged, "") - 0.21586).abs() < 1e-4);
    assert!((red(&plain, "Option \"texture\" \"string colorspace\" \"srgb\"") - 0.21586).abs() < 1e-4);
    assert!((red(&tagged, "Option \"texture\" \"string colorspace\" \"linear\"") - 128.0 / 255.0).abs() < 1e-4);
}

#[test]
fn clipping_planes_cut_what_their_normals_point_to() {
    // RISpec 4.1.1. Of a disk the right half, of a sphere half as much again by a slanted plane through its middle.
    let pi = std::f32::consts::PI;
    let disk = "Surface \"constant\" Disk 0 0.8 360";
    let perspective = "Format 80 80 1 PixelSamples 8 8 PixelFilter \"box\" 1 1 Projection \"perspective\" \"fov\" [90] ScreenWindow -0.2 0.2 -0.2 0.2 Translate 0 0 5";
    for (options, planes, expected) in [
        (ORTHO, "ClippingPlane 0 0 0 1 0 0", 0.32 * pi),
        (ORTHO, "ClippingPlane 0 0 0 1 0 0 ClippingPlane 0 0 0 0 1 0", 0.16 * pi),
        (perspective, "ClippingPlane 0 0 0 1 0 0", 0.32 * pi),
        (ORTHO, "ClippingPlane 0 0 -1 0 0 1", 0.0),
    ] {
        let found = area(&render_with(&[], &format!("{options} {planes}"), disk));
        assert!((found - expected).abs() < 0.012, "{planes}: {found}, expected {expected}");
    }
}

#[test]
fn frames_neither_begin_nor_end_within_worlds_or_frames() {
    // RISpec 4: frames have worlds in them, and no frames.
    let work = scratch();
    let path = work.path().join("t.rib");
    let head = "Display \"t.png\" \"png\" \"rgb\" Format 8 8 1\n";
    for (text, expected) in [
        ("WorldBegin\nFrameBegin 1 Disk 0 1 360 FrameEnd WorldEnd", "t.rib:3:1: FrameBegin within a world"),
        ("FrameBegin 1\nWorldBegin\nFrameEnd WorldEnd", "t.rib:4:1: FrameEnd before the WorldEnd"),
        ("FrameBegin 1\n FrameBegin 2 FrameEnd FrameEnd", "t.rib:3:2: FrameBegin within FrameBegin"),
    ] {
        std::fs::write(&path, format!("{head}{text}\n")).unwrap();
        let answer = scree(&["render", path.to_str().unwrap(), "-o", work.path().to_str().unwrap()]);
        assert!(answer.fails(3).contains(expected), "{text}: {}", answer.errors());
    }
}

#[test]
fn images_of_one_channel_of_floats_are_textures() {
    // A sphere of radius ½ whose middle is 5 before the eye is 4.5 away there; a depth beyond the near plane, written as floats.
    let work = scratch();
    let at = |name: &str| work.path().join(name).to_str().unwrap().to_string();
    let depth = ["exr", "tif"]
        .map(|kind| format!("Display \"+z.{kind}\" \"{}\" \"z\"\n", if kind == "tif" { "tiff" } else { kind }));
    let scene = |displays: &str, world: &str| {
        format!("Display \"t.exr\" \"exr\" \"rgb\"\n{displays}{ORTHO}\nWorldBegin\n{world}\nWorldEnd\n")
    };
    let draw = |displays: &str, world: &str| {
        std::fs::write(at("t.rib"), scene(displays, world)).unwrap();
        let answer = scree(&["render", &at("t.rib"), "-o", &at("")]);
        answer.ok();
        assert!(!answer.errors().contains("warning"), "{}", answer.errors());
    };
    draw(&depth.concat(), "Surface \"constant\" Sphere .5 -.5 .5 360");
    let shader = "surface look(string map = \"\";) { float n = 0; textureinfo(map, \"channels\", n);
        Oi = 1; Ci = color(float texture(map[0], 0.5, 0.5), float texture(map[1], 0.5, 0.5, \"fill\", 7), n); }";
    std::fs::write(at("look.sl"), shader).unwrap();
    for name in ["z.exr", "z.tif"] {
        let made = format!("MakeTexture \"{name}\" \"made\" \"clamp\" \"clamp\" \"box\" 1 1\n");
        for (made, map) in [("", name), (made.as_str(), "made")] {
            draw(made, &format!("Surface \"look\" \"string map\" \"{map}\" Disk 0 9 360"));
            let [depth, fill, channels] = image::open(at("t.exr")).unwrap().to_rgb32f().get_pixel(40, 40).0;
            assert!((depth - 4.5).abs() < 1e-2 && fill == 7.0 && channels == 1.0, "{map}: {depth} {fill} {channels}");
        }
    }
}
