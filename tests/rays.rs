//! Shaders that send rays, look up maps or work on pixels, against answers known on paper.

use crate::cli::{scratch, scree};
use crate::rendering::{ORTHO, Rendered, render_with};

/// Every pixel that is covered has a colour, within a tolerance.
fn all_are(p: &Rendered, color: [f32; 3], tolerance: f32) {
    let covered: Vec<_> = p.pixels.iter().filter(|p| p[3] > 0.999).collect();
    assert!(covered.len() > 500);
    for pixel in covered {
        (0..3).for_each(|c| assert!((pixel[c] - color[c]).abs() <= tolerance, "{pixel:?}, expected {color:?}"));
    }
}

#[test]
fn a_white_room_gives_back_its_light() {
    // The furnace: within walls that shine 1 all around, the mean over the hemisphere is 1 and everything is occluded.
    let furnace = b"surface furnace(float which = 0;) {
        normal Nf = faceforward(normalize(N), I);
        if (which == 0) Ci = indirectdiffuse(P, Nf, 16);
        else if (which == 1) Ci = occlusion(P, Nf, 16);
        else if (which == 2) Ci = trace(P, reflect(normalize(I), Nf));
        else { color sum = 0; gather(\"illuminance\", P, Nf, PI / 2, 8, \"surface:Ci\", sum) { Ci += sum / 8; } }
    }";
    for (which, color) in [(0, [0.5, 1.0, 0.25]), (1, [1.0; 3]), (2, [0.5, 1.0, 0.25]), (3, [0.5, 1.0, 0.25])] {
        let p = render_with(
            &[("furnace.sl", furnace)],
            &ORTHO.replace("PixelSamples 8 8", "PixelSamples 2 2"),
            &format!(
                "AttributeBegin Color [0.5 1 0.25] Surface \"constant\" Attribute \"visibility\" \"int camera\" 0 Sphere 20 -20 20 360 AttributeEnd
                Surface \"furnace\" \"uniform float which\" {which} Sphere 0.8 -0.8 0.8 360"
            ),
        );
        all_are(&p, color, 1e-4);
    }
}

#[test]
fn a_mirror_shows_what_stands_before_it() {
    // Seen along z, a mirror turned by 45 degrees looks along x: to the left is a wall, red above y = 0 and green below.
    let mirror = b"surface mirror() { Ci = trace(P, reflect(normalize(I), faceforward(normalize(N), I))); Oi = 1; }";
    let p = render_with(
        &[("mirror.sl", mirror)],
        &ORTHO.replace("PixelSamples 8 8", "PixelSamples 2 2"),
        "AttributeBegin Surface \"constant\"
            Color 1 0 0 Polygon \"P\" [-3 0 -9  -3 0 9  -3 9 9  -3 9 -9]
            Color 0 1 0 Polygon \"P\" [-3 -9 -9  -3 -9 9  -3 0 9  -3 0 -9]
        AttributeEnd
        Surface \"mirror\" Rotate 45 0 1 0 Polygon \"P\" [-1 -1 0  1 -1 0  1 1 0  -1 1 0]",
    );
    for (y, color) in [(10, [1.0, 0.0, 0.0]), (35, [1.0, 0.0, 0.0]), (45, [0.0, 1.0, 0.0]), (70, [0.0, 1.0, 0.0])] {
        (20..60).for_each(|x| assert_eq!(p.at(x, y)[..3], color, "({x}, {y})"));
    }
}

#[test]
fn rays_end_between_two_mirrors() {
    let mirror =
        b"surface mirror() { Ci = 0.1 + 0.5 * trace(P, reflect(normalize(I), faceforward(normalize(N), I))); Oi = 1; }";
    let walls = "Surface \"mirror\" Polygon \"P\" [-9 -9 0  9 -9 0  9 9 0  -9 9 0]
        Attribute \"visibility\" \"int camera\" 0 Polygon \"P\" [-9 -9 -9  9 -9 -9  9 9 -9  -9 9 -9]";
    for depth in [0, 1, 3, 20] {
        let options = format!("{} Option \"trace\" \"int maxdepth\" {depth}", ORTHO.replace("8 8", "1 1"));
        let expected = (0..=depth).map(|k| 0.1 * 0.5f32.powi(k)).sum::<f32>();
        all_are(&render_with(&[("mirror.sl", mirror)], &options, walls), [expected; 3], 1e-5);
    }
}

#[test]
fn lengths_of_rays_are_from_the_place_asked_for() {
    // From a square at z = 0 to a disk at z = 2, in pixels so coarse that where rays start beside the surface would show.
    let shader = b"surface far(float which = 0;) { float d = 0;
        if (which == 0) d = trace(P, vector(0, 0, 1));
        else gather(\"\", P, vector(0, 0, 1), 0, 1, \"ray:length\", d) { d += 0; }
        Ci = d / 4; Oi = 1; }";
    let head = "Format 16 16 1 PixelSamples 1 1 PixelFilter \"box\" 1 1 Quantize \"rgba\" 0 0 0 0 Projection \"orthographic\" Translate 0 0 5";
    for (which, start) in [(0, "Polygon"), (1, "Polygon"), (0, "Patch \"bilinear\""), (1, "Patch \"bilinear\"")] {
        let points = if start == "Polygon" { "-1 -1 0 1 -1 0 1 1 0 -1 1 0" } else { "-1 -1 0 1 -1 0 -1 1 0 1 1 0" };
        let p = render_with(
            &[("far.sl", shader)],
            head,
            &format!(
                "Sides 2 AttributeBegin Surface \"constant\" Translate 0 0 2 Disk 0 9 360 AttributeEnd
                Surface \"far\" \"uniform float which\" {which} {start} \"P\" [{points}]"
            ),
        );
        let found = p.at(8, 8)[0];
        assert!((found - 0.5).abs() < 1e-5, "{start} {which}: {found}");
    }
}

#[test]
fn rays_that_leave_outwards_go_through_the_exterior() {
    // Seen along z, through primitives at z = 0 to a white wall at z = 2 that is turned as they are; a volume keeps a part k of all.
    let keep = b"volume v(float k = 0.5;) { Ci *= k; }";
    let fog = b"volume fog() { Ci *= exp(-length(I)); }";
    let through = b"surface t() { Oi = 1; Ci = trace(P, vector(0, 0, 1)); }";
    let files: [(&str, &[u8]); 3] = [("v.sl", keep), ("fog.sl", fog), ("t.sl", through)];
    let options = ORTHO.replace("PixelSamples 8 8", "PixelSamples 2 2");
    let sphere = "Sphere 0.5 -0.5 0.5 360";
    let flat = [
        "Disk 0 0.8 360",
        "Polygon \"P\" [-0.6 -0.6 0 0.6 -0.6 0 0.6 0.6 0 -0.6 0.6 0]",
        "Patch \"bilinear\" \"P\" [-0.6 -0.6 0 0.6 -0.6 0 -0.6 0.6 0 0.6 0.6 0]",
    ];
    let open = flat.map(|shape| {
        let of = |turned: &str| format!("Exterior \"v\" Surface \"t\" {turned} {shape}");
        [(of(""), 0.5), (of("ReverseOrientation"), 1.0)]
    });
    let closed = [
        (format!("Exterior \"v\" Surface \"t\" {sphere}"), 0.5),
        (format!("Interior \"v\" Exterior \"v\" \"float k\" 0.25 Surface \"t\" {sphere}"), 0.125),
    ];
    for (primitive, kept) in open.into_iter().flatten().chain(closed) {
        let world = format!(
            "AttributeBegin {primitive} AttributeEnd Sides 2 Surface \"constant\" Translate 0 0 2 Attribute \"visibility\" \"int camera\" 0 Disk 0 5 360"
        );
        let image = render_with(&files, &options, &world);
        // Of a sphere not its outline, along which rays that graze it leave where they enter.
        let near = if primitive.contains("Sphere") { 14.0 } else { f32::INFINITY };
        let off = |k: usize| ((k % 80) as f32 - 39.5).hypot((k / 80) as f32 - 39.5);
        let covered: Vec<_> =
            image.pixels.iter().enumerate().filter(|(k, p)| p[3] == 1.0 && off(*k) < near).map(|(_, p)| p).collect();
        assert!(covered.len() > 500, "{primitive}");
        covered.iter().for_each(|p| assert!((p[0] - kept).abs() < 1e-3, "{primitive}: {p:?}"));
    }
    // From the back of a sphere of radius 1/2 it is 3/2 to the wall; from a polygon, 2.
    for (shape, way) in [(sphere, 1.5f32), (flat[1], 2.0)] {
        let world = format!(
            "AttributeBegin Exterior \"fog\" Surface \"t\" {shape} AttributeEnd Sides 2 Surface \"constant\" Translate 0 0 2 Disk 0 5 360"
        );
        let found = render_with(&files, &options, &world).at(40, 40)[0];
        assert!((found - (-way).exp()).abs() < 1e-3, "{shape}: {found}");
    }
}

/// An image of one colour, as a file.
fn plain(color: [u8; 3]) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    image::RgbImage::from_pixel(4, 4, image::Rgb(color)).write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}

#[test]
fn an_environment_of_cube_faces() {
    let names = ["px.png", "nx.png", "py.png", "ny.png", "pz.png", "nz.png"];
    let colors = [[255, 0, 0], [0, 255, 255], [0, 255, 0], [255, 0, 255], [0, 0, 255], [255, 255, 0]];
    let files: Vec<Vec<u8>> = colors.iter().map(|c| plain(*c)).collect();
    let way = b"surface way(vector d = 0;) { Ci = environment(\"cube\", d); Oi = 1; }";
    let mut beside: Vec<(&str, &[u8])> = names.iter().zip(&files).map(|(n, f)| (*n, f.as_slice())).collect();
    beside.push(("way.sl", way));
    let options = format!(
        "{} MakeCubeFaceEnvironment {} \"cube\" 90 \"box\" 1 1",
        ORTHO.replace("8 8", "1 1"),
        names.map(|n| format!("\"{n}\"")).join(" ")
    );
    let ways = ["1 0.3 -0.2", "-1 0.3 0.4", "0.2 1 0.5", "0.2 -3 0.5", "0.1 0.7 1", "-0.2 0.7 -1"];
    for (way, color) in ways.iter().zip(colors) {
        let world = format!("Surface \"way\" \"uniform vector d\" [{way}] Sphere 0.8 -0.8 0.8 360");
        all_are(&render_with(&beside, &options, &world), color.map(|c| c as f32 / 255.0), 1e-5);
    }
}

#[test]
fn an_imager_works_on_pixels() {
    let ramp = b"imager ramp(float gain = 1;) {
        Ci = gain * color(xcomp(P) / 80, ycomp(P) / 80, alpha * comp(Ci, 2));
        alpha = 0.5;
    }";
    let p = render_with(
        &[("ramp.sl", ramp)],
        &format!("{} Imager \"ramp\" \"uniform float gain\" 2", ORTHO.replace("8 8", "1 1")),
        "Surface \"constant\" Color 0 0 0.25 Polygon \"P\" [0 -9 0  9 -9 0  9 9 0  0 9 0]",
    );
    for (x, y) in [(3, 7), (70, 70), (41, 2), (39, 66)] {
        let blue = if x >= 40 { 0.5 } else { 0.0 };
        let expected = [(x as f32 + 0.5) / 40.0, (y as f32 + 0.5) / 40.0, blue, 0.5];
        let found = p.at(x, y);
        (0..4).for_each(|c| assert!((found[c] - expected[c]).abs() < 1e-5, "({x}, {y}): {found:?}, {expected:?}"));
    }
}

#[test]
fn shaders_know_the_spaces_of_the_picture() {
    // NDC and raster coordinates of a point are those of its pixel, whichever way it lies, and the way back ends where it began.
    let place = b"surface place() {
        point n = transform(\"NDC\", P), r = transform(\"raster\", P), s = transform(\"screen\", P);
        Ci = color(xcomp(n), ycomp(r), 0);
        if (length(transform(\"raster\", \"current\", r) - P) > 1e-2) Ci = color(0, 0, 1);
        if (abs(xcomp(s) - 2 * (2 * xcomp(n) - 1)) > 1e-3) Ci = color(0, 0, 1);
        if (length(point \"eye\" (0, 0, 0) - E) > 1e-4) Ci = color(0, 0, 1);
        Oi = 1;
    }";
    for projection in ["\"perspective\" \"fov\" 50", "\"orthographic\""] {
        let options = format!(
            "Format 80 40 1 PixelSamples 1 1 PixelFilter \"box\" 1 1 Projection {projection} Rotate 10 0 1 0 Translate 0.5 0 0"
        );
        let world = "Surface \"place\" Polygon \"P\" [-9 -9 5  9 -9 6  9 9 7  -9 9 4]";
        let p = render_with(&[("place.sl", place)], &options, world);
        for (x, y) in [(0, 0), (79, 39), (40, 20), (13, 31)] {
            let found = p.at(x, y);
            let expected = [(x as f32 + 0.5) / 80.0, y as f32 + 0.5, 0.0];
            (0..3).for_each(|c| {
                assert!((found[c] - expected[c]).abs() < 0.02, "{projection} ({x}, {y}): {found:?}, {expected:?}")
            });
        }
    }
}

#[test]
fn textures_in_files_look_as_those_in_memory() {
    let mut image = image::RgbImage::new(700, 500);
    image
        .enumerate_pixels_mut()
        .for_each(|(x, y, p)| p.0 = [((x * 7) ^ (y * 3)) as u8, (x / 3 + y) as u8, (x * y / 50) as u8]);
    let mut png = std::io::Cursor::new(Vec::new());
    image.write_to(&mut png, image::ImageFormat::Png).unwrap();
    let png = png.into_inner();
    let draw = |kib: &str| {
        let options =
            format!("Option \"limits\" \"uniform integer texturememory\" [{kib}] {}", ORTHO.replace("8 8", "3 3"));
        let world =
            "Surface \"map\" Rotate 50 1 0 0 Polygon \"P\" [-1 -1 0 1 -1 0 1 1 0 -1 1 0] \"st\" [0 0 1 0 1 1 0 1]";
        let map = b"surface map() { Ci = texture(\"p.png\", s, t); Oi = 1; }";
        render_with(&[("map.sl", map), ("p.png", &png)], &options, world)
    };
    let (much, little) = (draw("1000000"), draw("1"));
    assert!(much.pixels == little.pixels && much.pixels.iter().any(|p| p[0] > 0.2));
}

/// Rounding puts a place of a seam between patches beside all of them.
#[test]
fn seams_have_the_normal_of_their_surface() {
    let shown =
        b"surface shown() { normal n = normalize(N); Ci = (color(xcomp(n), ycomp(n), zcomp(n)) + 1) / 2; Oi = 1; }";
    let traces = b"surface traces() { Ci = trace(P, vector(0, 0, 1)); Oi = 1; }";
    let files: [(&str, &[u8]); 2] = [("shown.sl", shown), ("traces.sl", traces)];
    // Turned by 30 degrees about the axis: the normal (0, 0, 1) of what lies in z = 0 becomes (0, -1/2, √3/2).
    let mesh = "Rotate 17 0 0 1 PatchMesh \"bilinear\" 5 \"nonperiodic\" 2 \"nonperiodic\" \"P\" [-2 -2 0 -1 -2 0 0 -2 0 1 -2 0 2 -2 0 -2 2 0 -1 2 0 0 2 0 1 2 0 2 2 0]";
    for shape in ["Disk 0 3 360", "Rotate 12 0 0 1 Disk 0 3 360", mesh] {
        let world = format!(
            "AttributeBegin Surface \"shown\" Translate 0 0 1 Rotate 30 1 0 0 {shape} AttributeEnd
            Surface \"traces\" Polygon \"P\" [-.8 -.8 0 .8 -.8 0 .8 .8 0 -.8 .8 0]"
        );
        let p = render_with(&files, &ORTHO.replace("8 8", "1 1"), &world);
        for (x, y) in (10..70).flat_map(|x| (10..70).map(move |y| (x, y))) {
            let found = [0, 1, 2].map(|c| 2.0 * p.at(x, y)[c] - 1.0);
            let expected = [0.0, -0.5, 0.75f32.sqrt()];
            let is_near = found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-3);
            assert!(is_near, "{shape} ({x}, {y}): {found:?}, expected {expected:?}");
        }
    }
}

/// RISpec 15.7.1: the fill value is that of channels that a map has not.
#[test]
fn channels_that_a_map_has_not_are_filled() {
    let png = |image: image::DynamicImage| {
        let mut bytes = std::io::Cursor::new(Vec::new());
        image.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
        bytes.into_inner()
    };
    let grey = png(image::GrayImage::from_pixel(4, 4, image::Luma([51])).into());
    let covered = png(image::GrayAlphaImage::from_pixel(4, 4, image::LumaA([51, 102])).into());
    let colour = png(image::RgbImage::from_pixel(4, 4, image::Rgb([51, 102, 153])).into());
    let whole = png(image::RgbaImage::from_pixel(4, 4, image::Rgba([51, 102, 153, 204])).into());
    let files = [("g.png", &grey), ("ga.png", &covered), ("rgb.png", &colour), ("rgba.png", &whole)];
    for (name, channels) in [
        ("g.png", [0.2, 0.3, 0.3, 0.3, 0.3]),
        ("ga.png", [0.2, 0.4, 0.3, 0.3, 0.3]),
        ("rgb.png", [0.2, 0.4, 0.6, 0.3, 0.3]),
        ("rgba.png", [0.2, 0.4, 0.6, 0.8, 0.3]),
    ] {
        for (k, expected) in channels.into_iter().enumerate() {
            let shader = format!(
                "surface map() {{ Ci = color(float texture(\"{name}\"[{k}], .5, .5, \"fill\", .3), float texture(\"{name}\"[{k}], .5, .5), 0); Oi = 1; }}"
            );
            let all: Vec<(&str, &[u8])> =
                files.iter().map(|(name, bytes)| (*name, &bytes[..])).chain([("map.sl", shader.as_bytes())]).collect();
            let p = render_with(&all, &ORTHO.replace("8 8", "1 1"), "Surface \"map\" Disk 0 .8 360");
            let [filled, empty, ..] = p.at(40, 40);
            let is_there = expected != 0.3;
            assert!((filled - expected).abs() < 1e-5, "{name}[{k}]: {filled}, expected {expected}");
            assert!((empty - if is_there { expected } else { 0.0 }).abs() < 1e-5, "{name}[{k}]: {empty}");
        }
    }
    // A colour of one channel is grey.
    let shader = b"surface map() { Ci = color texture(\"g.png\", .5, .5); Oi = 1; }";
    let p = render_with(
        &[("map.sl", shader), ("g.png", &grey)],
        &ORTHO.replace("8 8", "1 1"),
        "Surface \"map\" Disk 0 .8 360",
    );
    assert!(p.at(40, 40)[..3].iter().all(|c| (c - 0.2).abs() < 1e-5), "{:?}", p.at(40, 40));
}

/// What lies close behind another primitive is met by a ray that passes this, however small it is in pixels.
#[test]
fn a_ray_meets_what_is_close_behind_another_primitive() {
    let shader = b"surface through() { Oi = 1; Ci = trace(P, normalize(I)); }";
    let square = |z: f32| format!("Polygon \"P\" [-2 -2 {z} 2 -2 {z} 2 2 {z} -2 2 {z}]\n");
    let world = format!(
        "Surface \"through\" {} Surface \"constant\" AttributeBegin Opacity 0.5 0.5 0.5 Color 1 0 0 {} AttributeEnd Color 0 1 0 {}",
        square(1.0),
        square(2.0),
        square(2.05)
    );
    let options = "Format 24 24 1 PixelSamples 2 2 PixelFilter \"box\" 1 1";
    let p = render_with(&[("through.sl", shader.as_slice())], options, &world);
    all_are(&p, [0.5, 0.5, 0.0], 1e-5);
}

/// A `gather` sends as many rays as it is asked for.
/// A tenth of these pixels is 0.0125.
#[test]
fn a_ray_from_a_polygon_meets_what_is_nearer_than_a_part_of_a_pixel() {
    let options = "Format 16 16 1 PixelSamples 2 2 PixelFilter \"box\" 1 1 Projection \"orthographic\" Translate 0 0 5";
    let traces = b"surface traces(vector way = 0;) { Ci = trace(P, way); Oi = 1; }";
    let bump = b"displacement bump() { P += vector(0, 0, 0.0005); }";
    let back = "Translate 0 0 9 Disk 0 99 360";
    for h in [0.0005f32, 0.003, 0.0124, 0.02] {
        for (way, near) in [
            ("0 0 1", format!("Color 1 0 0 Translate 0 0 {h} Disk 0 9 360")),
            ("0.6 0 0.8", format!("Color 1 0 0 Translate 0 0 {h} Disk 0 9 360")),
            ("0 0.995 0.1", format!("Color 1 0 0 Translate 0 0 {h} Disk 0 9 360")),
            ("0 0 1", format!("Color 1 0 0 Translate 0 0 {} Sphere 4 -4 4 360", h + 4.0)),
            ("0 0 1", format!("Displacement \"bump\" Color 1 0 0 Translate 0 0 {h} Disk 0 9 360")),
            // What is seen through a half of it.
            ("0 0 1", format!("Color 2 0 0 Opacity .5 .5 .5 Translate 0 0 {h} Disk 0 9 360")),
        ] {
            let world = format!(
                "AttributeBegin Surface \"constant\" Color 0 0 0 {back} AttributeEnd
                AttributeBegin Surface \"constant\" Attribute \"visibility\" \"camera\" [0] {near} AttributeEnd
                Surface \"traces\" \"vector way\" [{way}] Polygon \"P\" [-.8 -.8 0 .8 -.8 0 .8 .8 0 -.8 .8 0]"
            );
            let files: [(&str, &[u8]); 2] = [("traces.sl", traces), ("bump.sl", bump)];
            let [r, g, ..] = render_with(&files, options, &world).at(8, 8);
            assert!((r - 1.0).abs() < 1e-4 && g == 0.0, "{h}, {way}, {near}: {r} {g}");
        }
    }
}

#[test]
fn many_rays_are_gathered() {
    let shader = b"surface many() { float n = 0; gather(\"\", P, normalize(I), 0.1, 5000) { n += 1; } else { n += 1; } Oi = 1; Ci = n / 5000; }";
    let world = "Surface \"many\" Polygon \"P\" [-2 -2 1 2 -2 1 2 2 1 -2 2 1]";
    let options = "Format 4 4 1 PixelSamples 1 1 PixelFilter \"box\" 1 1";
    let p = render_with(&[("many.sl", shader.as_slice())], options, world);
    assert!(p.pixels.iter().all(|pixel| (pixel[0] - 1.0).abs() < 1e-5), "{:?}", p.pixels[0]);
}

/// A square in the plane of a larger one, as a mirror shows it from below at any slope.
#[test]
fn of_surfaces_in_one_plane_rays_meet_the_first() {
    let files: [(&str, &[u8]); 1] = [("m.sl", b"surface m(vector d = 0;) { Oi = 1; Ci = trace(P, d); }")];
    let square = |color: &str, half: f32| {
        format!("Color {color} Polygon \"P\" [-{half} -{half} 2 {half} -{half} 2 {half} {half} 2 -{half} {half} 2]\n")
    };
    let (small, large) = (square("1 1 0", 0.7), square("0 0 1", 9.0));
    let options = "Format 64 64 1 PixelSamples 1 1 Projection \"orthographic\" Translate 0 0 5";
    for (turn, way) in [("", "0 0 1"), ("Rotate 11 3 1 2", ".3 .2 1"), ("Rotate -7 1 0 0 Rotate 30 0 0 1", "-.3 .4 1")]
    {
        let draw = |above: &str| {
            let mirror = format!("Surface \"m\" \"vector d\" [{way}] Polygon \"P\" [-1 -1 0 1 -1 0 1 1 0 -1 1 0]");
            let above = format!("AttributeBegin Attribute \"visibility\" \"int camera\" [0] {above} AttributeEnd");
            let world = format!("Surface \"constant\" TransformBegin {turn} {above} TransformEnd {mirror}");
            render_with(&files, options, &world)
        };
        let [alone, first, last] =
            [&small, &format!("{small}{large}"), &format!("{large}{small}")].map(|all| draw(all));
        let seen: Vec<usize> = (0..64 * 64).filter(|k| alone.pixels[*k][0] > 0.999).collect();
        assert!(seen.len() > 300, "{turn}: {}", seen.len());
        for k in seen {
            assert!(
                first.pixels[k][0] > 0.999 && first.pixels[k][2] < 0.001,
                "{turn}: pixel {k} {:?}",
                first.pixels[k]
            );
            assert!(last.pixels[k][0] < 0.001, "{turn}: pixel {k} {:?}", last.pixels[k]);
        }
    }
}

/// A ray of `occlusion` asks a surface how opaque it is, not what colour it has: a shader that calls `occlusion` for its colour sends no more rays for
/// that, and one whose opacity depends on it as many as `maxdiffusedepth` allows.
#[test]
fn occlusion_of_shaders_that_call_it_sends_no_more_rays() {
    let work = scratch();
    let at = |name: &str| work.path().join(name).to_str().unwrap().to_string();
    let draw = |body: &str, options: &str| {
        std::fs::write(at("oc.sl"), format!("surface oc() {{ {body} }}")).unwrap();
        let panes =
            "Polygon \"P\" [-3 -3 2 3 -3 2 3 3 2 -3 3 2] Polygon \"P\" [-0.4 -0.4 1 0.4 -0.4 1 0.4 0.4 1 -0.4 0.4 1]";
        let rib = format!(
            "Display \"t.exr\" \"exr\" \"rgba\" Format 4 4 1 PixelSamples 2 2 PixelFilter \"box\" 1 1 {options} WorldBegin
            Surface \"oc\" {panes} WorldEnd"
        );
        std::fs::write(at("t.rib"), rib).unwrap();
        scree(&["render", &at("t.rib"), "--stats", "-o", &at("")]).ok();
        let stats = std::fs::read(at("t.exr.stats.json")).unwrap();
        let stats = serde_json::from_slice::<serde_json::Value>(&stats).unwrap();
        let count = |name: &str| stats["stats"][name].as_u64().unwrap();
        [count("shaded_points"), count("occlusion_rays"), count("opacity_runs")]
    };
    let occlusion = "occlusion(P, faceforward(normalize(N), I), 64)";
    // What is opaque whatever is in its way is asked nothing.
    let body = format!("Oi = 1; Ci = {occlusion};");
    let [points, rays, runs] = draw(&body, "");
    assert_eq!((rays, runs), (64 * points, 0), "{body}");
    for body in [format!("Oi = 0.9; Ci = {occlusion};"), format!("Oi = 1 - 0.25 * {occlusion}; Ci = Oi;")] {
        let [points, rays, runs] = draw(&body, "");
        assert_eq!(rays, 64 * points, "{body}");
        assert!(0 < runs && runs <= 2 * rays, "{runs} of {rays}: {body}");
    }
    let deep = "Option \"trace\" \"int maxdiffusedepth\" [2]";
    let [points, rays, _] = draw(&format!("Oi = 0.9; Ci = {occlusion};"), deep);
    assert_eq!(rays, 64 * points);
    let [points, rays, _] = draw(&format!("Oi = 1 - 0.25 * {occlusion}; Ci = Oi;"), deep);
    assert!(rays > 64 * points);
}
