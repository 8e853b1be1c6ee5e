//! Very many layers that are seen through each other: what they come to, known on paper, in memory and time that are bounded.

use crate::cli::{scratch, scree};
use crate::outputs::Layers;
use crate::rendering::{ORTHO, Rendered, render_with};
use std::fmt::Write;

/// Looking along z from −5, ±1 across the image, at four samples a pixel.
const PLAIN: &str =
    "Format 64 64 1 PixelSamples 2 2 PixelFilter \"box\" 1 1 Projection \"orthographic\" Translate 0 0 5";

fn render(options: &str, world: &str) -> Rendered {
    render_with(&[], options, &format!("Surface \"constant\"\n{world}"))
}

fn assert_near(found: f32, expected: f32, what: &str) {
    assert!((found - expected).abs() < 2e-4, "{what}: {found}, expected {expected}");
}

/// The statistics of an image.
pub fn stats(options: &str, world: &str) -> serde_json::Value {
    let work = scratch();
    let at = |name: &str| work.path().join(name).to_str().unwrap().to_string();
    std::fs::write(
        at("t.rib"),
        format!("Display \"t.png\" \"png\" \"rgb\"\n{options}\nWorldBegin\n{world}\nWorldEnd\n"),
    )
    .unwrap();
    scree(&["render", &at("t.rib"), "--stats", "-o", &at("")]).ok();
    let stats = std::fs::read(at("t.png.stats.json")).unwrap();
    serde_json::from_slice::<serde_json::Value>(&stats).unwrap()
}

/// Spheres one in the other, each a little farther to a side than the one before, so that none is another's copy.
fn spheres(n: usize, opacity: f32, step: f32) -> String {
    let mut world = format!("Opacity {opacity} {opacity} {opacity}\n");
    for k in 0..n {
        let (hue, x) = (k as f32 / n as f32, k as f32 * step);
        writeln!(
            world,
            "Color [{hue} {} 0.5] TransformBegin Translate {x} 0 {x} Sphere 0.7 -0.7 0.7 360 TransformEnd",
            1.0 - hue
        )
        .unwrap();
    }
    world
}

#[test]
fn coincident_spheres_cover_what_their_opacities_come_to() {
    // A line of sight meets each twice.
    for (n, opacity) in [(1usize, 0.3f32), (10, 0.1), (200, 0.002), (1000, 0.5)] {
        let sphere = "Sphere 0.7 -0.7 0.7 360\n".repeat(n);
        let p = render(PLAIN, &format!("Color [1 0.5 0] Opacity {opacity} {opacity} {opacity}\n{sphere}"));
        let expected = 1.0 - (1.0 - opacity).powi(2 * n as i32);
        let [r, g, b, a] = p.at(32, 32);
        assert_near(a, expected, &format!("{n} of {opacity}"));
        for (found, expected) in [(r, expected), (g, 0.5 * expected), (b, 0.0)] {
            assert_near(found, expected, "colour");
        }
    }
}

/// Panes that each let two colours through are opaque together; alpha is the mean of what is covered by channel.
/// The layers of all samples lie at one depth, and those of each let nothing through together.
#[test]
fn flat_levels_of_detail_fade_in_time() {
    let level = |range: &str, color: &str| {
        format!(
            "AttributeBegin Detail [-.5 .5 -.5 .5 0 0] DetailRange {range} Color [{color}] Disk 0 2 360 AttributeEnd\n"
        )
    };
    let options = PLAIN.replace("PixelSamples 2 2", "PixelSamples 12 12");
    // The box is 1024 pixels, half of the way.
    let begun = std::time::Instant::now();
    let p = render(&options, &(level("0 0 512 1536", "1 0 0") + &level("512 1536 1000000 1000000", "0 1 0")));
    assert!(begun.elapsed().as_secs() < 60, "{:?}", begun.elapsed());
    let mean = |c: usize| p.pixels.iter().map(|pixel| pixel[c]).sum::<f32>() / p.pixels.len() as f32;
    for (c, expected) in [0.5, 0.5, 0.0, 1.0].into_iter().enumerate() {
        assert!((mean(c) - expected).abs() < 0.01, "{c}: {}", mean(c));
    }
}

#[test]
fn alpha_is_that_of_each_channel() {
    let pane = |z: f32, opacity: &str| {
        format!("Color [1 1 1] Opacity [{opacity}] Polygon \"P\" [-1 -1 {z} 1 -1 {z} 1 1 {z} -1 1 {z}]\n")
    };
    let three = pane(0.0, "1 0 0") + &pane(0.1, "0 1 0") + &pane(0.2, "0 0 1");
    for (channel, found) in render(PLAIN, &three).at(32, 32).into_iter().enumerate() {
        assert_near(found, 1.0, &format!("channel {channel}"));
    }
    let two = pane(0.0, "0.5 0.25 0.01") + &pane(0.1, "0.5 0.25 0.01");
    let covered = [0.5f32, 0.25, 0.01].map(|o| 1.0 - (1.0 - o) * (1.0 - o));
    assert_near(render(PLAIN, &two).at(32, 32)[3], covered.iter().sum::<f32>() / 3.0, "alpha of two");
}

#[test]
fn what_lets_nothing_through_together_hides_what_is_behind() {
    // A hundred of one half let 2⁻¹⁰⁰ through: of ten times as many no more points are shaded than of these, nor of a hundred that are
    // nowhere another's copy.
    let one = |n: usize| stats(PLAIN, &format!("Opacity 0.5 0.5 0.5\n{}", "Sphere 0.7 -0.7 0.7 360\n".repeat(n)));
    let shaded = |stats: &serde_json::Value| stats["stats"]["shaded_points"].as_u64().unwrap();
    let [few, many] = [shaded(&one(100)), shaded(&one(1000))];
    assert_eq!(few, many);
    let behind =
        |k: usize| format!("TransformBegin Translate 0 0 {} Sphere 0.7 -0.7 0.7 360 TransformEnd\n", k as f32 * 1e-5);
    let apart = format!("Opacity 0.5 0.5 0.5\n{}", (0..1000).map(behind).collect::<String>());
    let apart = shaded(&stats(PLAIN, &apart));
    assert!(apart < 3 * few, "{apart} points are shaded of spheres apart, {few} of a hundred in one place");
}

#[test]
fn a_row_of_layers_is_composited_from_front_to_back() {
    // 10,000 squares of 0.0005, the farther half blue: 1 − (1 − o)ⁿ of red, and of blue what gets through that.
    let squares = |first: usize, n: usize| {
        (first..first + n).fold(String::new(), |mut all, k| {
            let z = k as f32 * 0.001;
            writeln!(all, "Polygon \"P\" [-2 -2 {z} 2 -2 {z} 2 2 {z} -2 2 {z}]").unwrap();
            all
        })
    };
    let half = 1.0 - 0.9995f64.powi(5000);
    let world = format!(
        "Opacity 0.0005 0.0005 0.0005 Color [1 0 0]\n{}Color [0 0 1]\n{}",
        squares(0, 5000),
        squares(5000, 5000)
    );
    let p = render(&PLAIN.replace("64 64", "16 16"), &world);
    let [r, g, b, a] = p.at(8, 8);
    let expected = [half, 0.0, (1.0 - half) * half, 1.0 - (1.0 - half).powi(2)];
    for (found, expected) in [r, g, b, a].into_iter().zip(expected) {
        assert!((f64::from(found) - expected).abs() < 1e-3, "{found}, expected {expected}");
    }
}

#[test]
fn coincident_polygons_askew_are_composited_in_their_order() {
    // Of two hundred of 0.05 in one place, the first hundred red: pieces of all of them come one after the other.
    let polygon = "Polygon \"P\" [-2 -2 -2 2 -2 2 2 2 2 -2 2 -2]\n".repeat(100);
    let world = format!("Opacity 0.05 0.05 0.05 Color [1 0 0]\n{polygon}Color [0 0 1]\n{polygon}");
    let p = render(&PLAIN.replace("64 64", "32 32"), &world);
    let through = 0.95f32.powi(100);
    for (x, y) in [(5, 5), (16, 16), (27, 9)] {
        let [r, _, b, a] = p.at(x, y);
        assert_near(r, 1.0 - through, "red");
        assert_near(b, (1.0 - through) * through, "blue");
        assert_near(a, 1.0 - through * through, "coverage");
    }
}

#[test]
fn an_image_of_many_layers_depends_on_no_bucket() {
    let moving = "Shutter 0 1\n";
    let lens = "DepthOfField 4 0.2 5\n";
    let perspective = PLAIN.replace("\"orthographic\"", "\"perspective\" \"fov\" [30]");
    let worlds = [
        (PLAIN.to_string(), spheres(40, 0.05, 0.003)),
        (PLAIN.to_string(), spheres(120, 0.5, 0.002)),
        (
            format!("{moving}{PLAIN}"),
            spheres(30, 0.2, 0.004).replace(
                "TransformBegin",
                "TransformBegin MotionBegin [0 1] Translate 0 0 0 Translate 0.2 0 0 MotionEnd",
            ),
        ),
        (format!("{lens}{perspective}"), spheres(30, 0.2, 0.004)),
        // Eleven million layers in a bucket of the usual size are more than it is drawn with at once.
        (PLAIN.replace("2 2", "4 4"), spheres(80, 0.002, 0.003)),
    ];
    for (options, world) in worlds {
        let [small, large] = [8, 64].map(|size| {
            let options = format!("Option \"limits\" \"bucketsize\" [{size}]\n{options}");
            render(&options, &world).pixels
        });
        let differ = small.iter().zip(&large).filter(|(a, b)| a != b).count();
        assert_eq!(differ, 0, "pixels differ of {options}");
    }
}

#[test]
fn shadows_are_those_of_all_layers() {
    // The light comes along z through squares that do not shine back; a floor behind them tells how much gets through.
    let floor =
        "Surface \"matte\" \"Ka\" 0 \"Kd\" 1 Opacity 1 1 1 Color 1 1 1 Polygon \"P\" [-2 -2 2 2 -2 2 2 2 2 -2 2 2]\n";
    let lit = "LightSource \"distantlight\" 1 \"from\" [0 0 0] \"to\" [0 0 1]\n";
    let unseen = "Attribute \"visibility\" \"camera\" [0]\n";
    let square = |z: f32| format!("Polygon \"P\" [-2 -2 {z} 2 -2 {z} 2 2 {z} -2 2 {z}]\n");
    let sphere = |_: f32| "Sphere 0.7 -0.7 0.7 360\n".to_string();
    let through = |n: usize, opacity: f32, step: f32, shape: &dyn Fn(f32) -> String| {
        let layers: String = (0..n).map(|k| shape(k as f32 * step - 1.0)).collect();
        let veil = format!("AttributeBegin {unseen} Opacity {opacity} {opacity} {opacity}\n{layers}AttributeEnd\n");
        render(&PLAIN.replace("64 64", "16 16"), &format!("{lit}{veil}{floor}")).at(8, 8)[0]
    };
    assert_near(through(1000, 0.001, 0.002, &square), 0.999f32.powi(1000), "a thousand apart");
    assert_near(through(10, 0.1, 0.0, &square), 0.9f32.powi(10), "ten in one place");
    assert_near(through(10, 0.1, 0.0, &sphere), 0.9f32.powi(20), "ten spheres in one place");
    assert_near(through(10_000, 0.0001, 0.0002, &square), 0.9999f32.powi(10_000), "ten thousand");
}

#[test]
fn primitives_in_one_place_are_drawn_and_kept_once() {
    let mesh = "SubdivisionMesh \"catmull-clark\" [4] [0 1 2 3] [\"interpolateboundary\"] [0 0] [] [] \"P\" [-1 -1 0 1 -1 0 1 1 0 -1 1 0]\n";
    let blobby = "Blobby 1 [1001 0] [1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1] [\"\"]\n";
    for (shape, n) in [(mesh, 3000), (blobby, 20), ("Sphere 0.7 -0.7 0.7 360\n", 3000)] {
        let [one, many] = [1, n].map(|n| stats(ORTHO, &format!("Surface \"constant\"\n{}", shape.repeat(n))));
        for what in ["micropolygons", "shaded_points", "samples", "items"] {
            assert_eq!(one["stats"][what], many["stats"][what], "{what} of {shape}");
        }
    }
    // What differs in what is seen of it is drawn.
    let items = |text: &str| stats(ORTHO, &format!("Surface \"constant\"\n{text}"))["stats"]["items"].as_u64().unwrap();
    for other in
        ["Sides 1", "ReverseOrientation", "Opacity .5 .5 .5", "Attribute \"visibility\" \"camera\" [0]", "Scale 1 1 2"]
    {
        assert_eq!(items(&format!("Disk 0 1 360\n{other}\nDisk 0 1 360")), 2 * items("Disk 0 1 360"), "{other}");
    }
}

#[test]
fn small_subdivision_meshes_take_little_memory() {
    // Cubes, none where another is: 2,000 take less than 500 MiB more than one.
    let cube =
        "SubdivisionMesh \"catmull-clark\" [4 4 4 4 4 4] [0 1 3 2 2 3 5 4 4 5 7 6 6 7 1 0 1 7 5 3 6 0 2 4] [] [] [] []
        \"P\" [-1 -1 1 1 -1 1 -1 1 1 1 1 1 -1 1 -1 1 1 -1 -1 -1 -1 1 -1 -1]\n";
    let world = |n: usize| {
        (0..n).fold("Surface \"constant\"\n".to_string(), |mut all, k| {
            let (x, y) = ((k % 50) as f32 / 25.0 - 1.0, (k / 50) as f32 / 20.0 - 1.0);
            writeln!(all, "TransformBegin Translate {x} {y} 0 Scale 0.01 0.01 0.01 {cube} TransformEnd").unwrap();
            all
        })
    };
    let peak = |n: usize| stats(ORTHO, &world(n))["peak_bytes"].as_u64().unwrap() >> 20;
    let (one, many) = (peak(1), peak(2000));
    assert!(many < one + 500, "{many} MiB of two thousand, {one} of one");
}

/// The faces of a mesh across the image and beyond it, by their points, which lean to each other as `height` says: n by n.
fn faces(n: usize, height: &dyn Fn(f32, f32) -> f32) -> (String, String, String) {
    let at = |k: usize| 3.0 * k as f32 / n as f32 - 1.5;
    let inner = |k: usize| 0 < k && k < n;
    let mut points = String::new();
    for (j, i) in (0..=n).flat_map(|j| (0..=n).map(move |i| (j, i))) {
        // Off the lines of strata.
        let off = if inner(i) && inner(j) { 0.03 * ((7 * i + 3 * j) % 5) as f32 - 0.06 } else { 0.0 };
        let (x, y) = (at(i) + off, at(j) - off);
        write!(points, "{x} {y} {} ", height(x, y)).unwrap();
    }
    let corners =
        (0..n * n).map(|k| k / n * (n + 1) + k % n).map(|k| format!("{k} {} {} {} ", k + 1, k + n + 2, k + n + 1));
    ("4 ".repeat(n * n), corners.collect(), points)
}

fn polygons(n: usize, height: &dyn Fn(f32, f32) -> f32) -> String {
    let (counts, corners, points) = faces(n, height);
    format!("PointsPolygons [{counts}] [{corners}] \"P\" [{points}]\n")
}

fn meshes(height: &dyn Fn(f32, f32) -> f32) -> [(&'static str, String); 3] {
    let (counts, corners, points) = faces(7, height);
    let tags = "[\"interpolateboundary\"] [0 0] [] []";
    let subdivided = format!("SubdivisionMesh \"catmull-clark\" [{counts}] [{corners}] {tags} \"P\" [{points}]\n");
    let (_, _, points) = faces(12, height);
    let patches = format!(
        "Basis \"bezier\" 3 \"bezier\" 3 PatchMesh \"bicubic\" 13 \"nonperiodic\" 13 \"nonperiodic\" \"P\" [{points}]\n"
    );
    [("polygons", polygons(7, height)), ("subdivided", subdivided), ("patches", patches)]
}

/// A mesh lets through what its opacity says, on the edges of its faces as in their middle.
#[test]
fn an_edge_of_two_faces_is_one_layer() {
    let plain = PLAIN.replace("2 2", "4 4");
    let lens = format!("DepthOfField 4 0.2 5 {plain}");
    let moves = "MotionBegin [0 1] Translate 0 0 0 Translate 0.1 0.05 0.3 MotionEnd";
    let half = "Opacity 0.5 0.5 0.5\n";
    for height in [|_: f32, _: f32| 0.0f32, |x: f32, y: f32| 0.4 * x.abs() + 0.3 * y] {
        for (name, mesh) in meshes(&height) {
            let stack =
                (0..40).map(|k| format!("TransformBegin Translate 0 0 {} {mesh}TransformEnd\n", 0.01 * k as f32));
            let stack = format!("Opacity 0.01 0.01 0.01\n{}", stack.collect::<String>());
            let object = format!("ObjectBegin 1 {mesh}ObjectEnd {half}ObjectInstance 1");
            let apart = format!("{half}{mesh}TransformBegin Translate 0 0 0.0001 {mesh}TransformEnd");
            for (what, options, world, expected) in [
                ("one", &plain, format!("{half}{mesh}"), 0.5),
                ("moving", &format!("Shutter 0 1 {plain}"), format!("{half}{moves} {mesh}"), 0.5),
                ("through a lens", &lens, format!("{half}{mesh}"), 0.5),
                ("of an object", &plain, object.clone(), 0.5),
                // What is apart is, and what is twice in one place.
                ("instances", &plain, format!("{object} ObjectInstance 1"), 0.75),
                ("two in one place", &plain, format!("{half}{mesh}{mesh}"), 0.75),
                ("two that nearly touch", &plain, apart, 0.75),
                ("forty", &plain, stack, 1.0 - 0.99f32.powi(40)),
            ] {
                let image = render(options, &world);
                let off = image.pixels.iter().filter(|p| (p[3] - expected).abs() > 1e-6).count();
                assert_eq!(off, 0, "pixels of {name}, {what}");
            }
        }
    }
    // Two panes of an object are two, and so are two sheets of a mesh, one just behind the other or in its place.
    let pane = "Polygon \"P\" [-1.5 -1.5 0 1.5 -1.5 0 1.5 1.5 0 -1.5 1.5 0]\n";
    let object = format!("ObjectBegin 1 {pane}{pane}ObjectEnd {half}ObjectInstance 1");
    let (counts, corners, points) = faces(4, &|_, _| 0.0);
    let behind: String = corners.split_whitespace().map(|k| format!("{} ", k.parse::<usize>().unwrap() + 25)).collect();
    let sheets = |z: f32| {
        let (_, _, second) = faces(4, &|_, _| z);
        format!("{half}PointsPolygons [{counts}{counts}] [{corners}{behind}] \"P\" [{points}{second}]\n")
    };
    for (what, world) in [("object", object), ("sheets", sheets(1e-4)), ("double", sheets(0.0))] {
        let off = render(&plain, &world).pixels.iter().filter(|p| (p[3] - 0.75).abs() > 1e-6).count();
        // At a corner of four faces a sample may meet one of them alone, and the sheet behind for another. On an edge that faces of two sheets
        // have in one place, nothing tells these apart.
        let most = if what == "double" { 20 } else { 2 };
        assert!(off <= most, "{off} pixels of two: {what}");
    }
}

/// A steep surface lets through what its opacity says: a sample on an edge of two micropolygons belongs to one of them, and where grids or faces
/// meet they are one layer, however far their depths differ within the width of an edge.
#[test]
fn an_edge_on_a_steep_surface_is_one_layer() {
    let plain = "Format 64 64 1 PixelSamples 4 4 PixelFilter \"box\" 1 1 Projection \"perspective\" \"fov\" 60";
    let mut surfaces: Vec<(&str, String)> = meshes(&|_, _| 0.0).into();
    surfaces.push(("disk", "Disk 0 2 360\n".into()));
    // Turns by which each surface has samples on edges, and sizes by which it goes beyond the image.
    let turns = [
        "2.362 0.253 1.73 0.246",
        "67.124 1.38 0.206 0.266",
        "62.777 -1.17 -2.737 -0.285",
        "77.012 0.243 0.337 -0.104",
    ];
    for (name, surface) in surfaces {
        for turn in turns {
            let world = format!("Opacity 0.5 0.5 0.5 Translate 0 0 4 Rotate {turn} Scale 11 11 11 {surface}");
            let moves = format!("MotionBegin [0 1] Translate 0 0 0 Translate 0.1 0.05 0.3 MotionEnd {world}");
            for (what, options, world) in [
                ("still", plain.to_string(), &world),
                ("moving", format!("Shutter 0 1 {plain}"), &moves),
                ("through a lens", format!("DepthOfField 22 0.2 4 {plain}"), &world),
            ] {
                let off = render(&options, world).pixels.iter().filter(|p| p[3] > 0.5 + 1e-6).count();
                // Points of a side that a neighbour does not have are on its line when the shutter opens and closes and through the middle of
                // the lens, and beside it else.
                let most = if what == "still" { 0 } else { 2 };
                assert!(off <= most, "{off} pixels of {name}, {turn}, {what}");
            }
        }
    }
}

/// The same along rays to a light, and of the panes of an object.
#[test]
fn light_passes_an_edge_of_two_faces_as_one_layer() {
    let world = |veil: &str| {
        format!(
            "LightSource \"distantlight\" 1 \"to\" [0 0 1]
            AttributeBegin Attribute \"visibility\" \"camera\" [0] Opacity 0.5 0.5 0.5 {veil} AttributeEnd
            Surface \"matte\" \"Ka\" 0 \"Kd\" 1 Polygon \"P\" [-1.5 -1.5 2 1.5 -1.5 2 1.5 1.5 2 -1.5 1.5 2]"
        )
    };
    let pane = |z: f32| format!("Polygon \"P\" [-1.5 -1.5 {z} 1.5 -1.5 {z} 1.5 1.5 {z} -1.5 1.5 {z}]\n");
    let (near, in_place) = (format!("{}{}", pane(0.0), pane(0.001)), format!("{}{}", pane(0.0), pane(0.0)));
    let object = |panes: &str| format!("ObjectBegin 1 {panes}ObjectEnd ObjectInstance 1");
    let mut cases = vec![("near", object(&near), 0.25), ("in place", object(&in_place), 0.25)];
    let [(_, mesh), (_, subdivided), _] = meshes(&|x, y| 0.4 * x.abs() + 0.3 * y);
    cases.extend([("mesh", mesh, 0.5), ("subdivided", subdivided, 0.5)]);
    cases.push(("points", "Points \"P\" [0 0 -1] \"constantwidth\" [5]".into(), 0.5));
    for (what, veil, expected) in cases {
        let image = render(PLAIN, &world(&veil));
        let off = image.pixels.iter().filter(|p| (p[0] - expected).abs() > 1e-3).count();
        assert_eq!(off, 0, "pixels behind {what}");
    }
}

/// A particle is a disk before the eye (RISpec 5.5): one layer, whichever way it is turned.
/// Faces of one mesh that lie in one place are as many layers as there are, to the eye and to light; of opaque ones the first is seen, without
/// speckles and without shadows on each other, and so is a mesh that has its faces both ways round.
#[test]
fn faces_of_a_mesh_in_one_place_are_layers() {
    let points = "\"P\" [0.1 -0.8 0 0.5 -0.8 0 0.5 0.8 0 0.1 0.8 0]";
    let mesh = |faces: &[&str]| {
        let corners: Vec<String> = faces.iter().map(|face| face.split(' ').count().to_string()).collect();
        format!("PointsPolygons [{}] [{}] {points}", corners.join(" "), faces.join(" "))
    };
    let (face, turned, back) = ("0 1 2 3", "1 2 3 0", "3 2 1 0");
    let (both, other) = (["0 1 2", "0 2 3"], ["0 1 3", "1 2 3"]);
    let object = format!("ObjectBegin 1 {} ObjectEnd ObjectInstance 1", mesh(&[face, face]));
    // The light comes at 45 degrees: the shadow of what is at x lies at x − 0.5, half a unit behind.
    let sun = "LightSource \"distantlight\" 1 \"from\" [1 0 -1] \"to\" [0 0 0] Surface \"matte\" \"Ka\" 0";
    let ground = "Polygon \"P\" [-1 -1 0.5 1 -1 0.5 1 1 0.5 -1 1 0.5]";
    let bare = render(PLAIN, &format!("{sun} {ground}")).at(32, 32)[0];
    for (what, n) in [
        (mesh(&[face]), 1),
        (mesh(&[face, face]), 2),
        (mesh(&[face, turned]), 2),
        (mesh(&[face, back]), 2),
        (mesh(&[face, face, back]), 3),
        (mesh(&both), 1),
        (mesh(&[&both[..], &both[..]].concat()), 2),
        (mesh(&[&both[..], &other[..]].concat()), 2),
        (object, 2),
    ] {
        let alone = render(PLAIN, &format!("Opacity 0.5 0.5 0.5 {what}"));
        assert_near(alone.at(40, 30)[3], 1.0 - 0.5f32.powi(n), &what);
        let lit = render(PLAIN, &format!("{sun} {ground} Opacity 0.5 0.5 0.5 {what}"));
        // Between −0.4 and 0: apart from the edges, and a little off the middle.
        let shadow: Vec<f32> = (22..30).flat_map(|x| [20, 30, 35].map(|y| lit.at(x, y)[0])).collect();
        for found in shadow {
            assert_near(found, bare * 0.5f32.powi(n), &format!("the shadow of {what}"));
        }
        // Opaque ones are shaded as one.
        let askew = format!("{sun} {ground} Rotate 20 1 2 0.5");
        let [one, all] = [mesh(&[face]), what].map(|what| render(PLAIN, &format!("{askew} {what}")).pixels);
        for (found, expected) in all.iter().zip(&one) {
            (0..4).for_each(|c| assert!((found[c] - expected[c]).abs() < 2e-3, "{found:?}, expected {expected:?}"));
        }
    }
    // Many of them take time in proportion to their number.
    let many = vec![face; 4000];
    let alone = render(PLAIN, &format!("Opacity 0.001 0.001 0.001 {}", mesh(&many)));
    assert_near(alone.at(40, 30)[3], 1.0 - 0.999f32.powi(4000), "4000 faces");
}

/// Sheets of one primitive that nearly touch are two layers, however thin what is between them: the sides of a lens, of a folded patch.
#[test]
fn thin_glass_has_two_sides() {
    let net = |z: f32| {
        let rows = [(-0.8, -z), (1.2, -z), (1.2, z), (-0.8, z)];
        rows.map(|(y, z)| [-0.8, -0.3, 0.3, 0.8].map(|x| format!("{x} {y} {z} ")).concat()).concat()
    };
    for thick in [1e-2, 1e-3, 3e-4, 1e-4] {
        let half = 0.5 * thick;
        for shape in [
            format!("Scale 1 1 {half} Sphere .8 -.8 .8 360"),
            format!("Basis \"bezier\" 3 \"bezier\" 3 Patch \"bicubic\" \"P\" [{}]", net(half)),
        ] {
            for (options, moves) in [
                ("", ""),
                ("Shutter 0 1", "MotionBegin [0 1] Translate 0 0 0 Translate .01 0 0 MotionEnd"),
                ("DepthOfField 8 .2 5", ""),
            ] {
                let image = render(&format!("{options} {PLAIN}"), &format!("Opacity .5 .5 .5 {moves} {shape}"));
                let inside = (0..20 * 20).map(|k| image.at(22 + k % 20, 22 + k / 20)[3]);
                let n = inside.filter(|a| (a - 0.75).abs() < 1e-4).count();
                // But for places on sides of grids, where both may be met twice.
                assert!(n > 370, "{n} of 400 pixels have two layers: {thick}, {options}, {shape}");
            }
        }
    }
}

#[test]
fn points_are_one_layer() {
    let point = "Points \"P\" [0 0 0] \"constantwidth\" [1.4]";
    let own = "Points \"P\" [0 0 0] \"constantwidth\" [1.4] \"varying color Os\" [.3 .3 .3]";
    let part = "Opacity .3 .3 .3\n";
    let moves = "MotionBegin [0 1] Translate 0 0 0 Translate .02 0 0 MotionEnd";
    for (what, options, world) in [
        ("still", PLAIN.to_string(), format!("{part}{point}")),
        ("by a variable", PLAIN.into(), own.into()),
        ("turned", PLAIN.into(), format!("{part}ReverseOrientation {point}")),
        ("mirrored", PLAIN.into(), format!("{part}Scale -1 1 1 {point}")),
        ("moving", format!("Shutter 0 1 {PLAIN}"), format!("{part}{moves} {point}")),
        ("moving itself", format!("Shutter 0 1 {PLAIN}"), format!("{part}MotionBegin [0 1] {point} {point} MotionEnd")),
        ("through a lens", format!("DepthOfField 4 0.2 5 {PLAIN}"), format!("{part}{point}")),
        ("in an object", PLAIN.into(), format!("ObjectBegin 1 {point} ObjectEnd {part}ObjectInstance 1")),
        (
            "near",
            PLAIN.replace("\"orthographic\"", "\"perspective\" \"fov\" [90]").replace("0 0 5", "0 0 0.72"),
            format!("{part}{point}"),
        ),
    ] {
        let image = render(&options, &world);
        for (x, y) in [(32, 32), (25, 40), (40, 24)] {
            assert_near(image.at(x, y)[3], 0.3, what);
        }
        if what != "near" {
            // No more at the outline, either.
            let area = image.coverage() / 1024.0;
            assert!((area / (0.3 * 0.49 * std::f32::consts::PI) - 1.0).abs() < 0.02, "{what}: {area}");
        }
    }
    assert_near(render(PLAIN, &format!("{part}{}", "Sphere .7 -.7 .7 360")).at(32, 32)[3], 0.51, "a sphere");
}

/// What is half open hides half of the sky.
#[test]
fn occlusion_counts_what_is_translucent_by_its_opacity() {
    let shader = b"surface sky() { Oi = 1; Ci = occlusion(P, normal(0, 0, -1), 64); }";
    let veil = |opacity: f32, shapes: &str| {
        format!(
            "AttributeBegin Attribute \"visibility\" \"camera\" [0] Surface \"constant\" Opacity {opacity} {opacity} {opacity} {shapes} AttributeEnd
            Surface \"sky\" Polygon \"P\" [-1.5 -1.5 0 1.5 -1.5 0 1.5 1.5 0 -1.5 1.5 0]"
        )
    };
    let (sphere, two) = ("Sphere 9 -9 9 360", "Sphere 9 -9 9 360 Sphere 8 -8 8 360");
    for (opacity, shapes, expected) in [
        (1.0f32, sphere, 1.0f32),
        (0.5, sphere, 0.5),
        (0.5, two, 0.75),
        (0.0, sphere, 0.0),
        (0.3, "Sphere 9 -9 0 360", 0.3),
    ] {
        let image = render_with(&[("sky.sl", shader)], &PLAIN.replace("64 64", "8 8"), &veil(opacity, shapes));
        assert_near(image.at(4, 4)[0], expected, &format!("{shapes} of {opacity}"));
    }
}

/// A layer that is not seen adds nothing to what displays take of colours, and one that is half seen a half.
#[test]
fn colours_of_layers_count_by_their_opacity() {
    let shader =
        b"surface told(output varying color light = 0;) { light = color(0.8, 0.4, 0.2); Oi = Os; Ci = Oi * Cs; }";
    let pane = |z: f32| format!("Polygon \"P\" [-1.5 -1.5 {z} 1.5 -1.5 {z} 1.5 1.5 {z} -1.5 1.5 {z}]\n");
    for (front, back) in [(0.0f32, 1.0f32), (0.0, 0.0), (0.5, 0.0), (0.5, 1.0), (0.25, 0.5)] {
        let world = format!(
            "Surface \"told\" Color [1 1 1] Opacity {front} {front} {front} {}Color [0 1 1] Opacity {back} {back} {back} {}",
            pane(0.0),
            pane(1.0)
        );
        // What is seen of either.
        let (first, second) = (front, (1.0 - front) * back);
        let sum = first + second;
        for (mode, expected) in [
            ("Cs", [first, sum, sum]),
            ("Ci", [first, sum, sum]),
            ("Oi", [sum; 3]),
            ("color light", [0.8, 0.4, 0.2].map(|c| c * sum)),
        ] {
            let work = scratch();
            std::fs::write(work.path().join("told.sl"), shader).unwrap();
            let path = work.path().join("t.rib");
            let text = format!("Display \"t.exr\" \"exr\" \"{mode}\"\n{PLAIN}\nWorldBegin\n{world}\nWorldEnd\n");
            std::fs::write(&path, text).unwrap();
            scree(&["render", path.to_str().unwrap(), "-o", work.path().to_str().unwrap()]).ok();
            let image = image::open(work.path().join("t.exr")).unwrap().to_rgb32f();
            let found = image.get_pixel(32, 32).0;
            let is_near = found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 2e-4);
            assert!(is_near, "{mode} of {front} before {back}: {found:?}, expected {expected:?}");
        }
    }
}

/// What stands behind another like it in its place is not kept, but has its id.
#[test]
fn ids_do_not_depend_on_what_is_hidden() {
    let square = |x: f32| format!("Polygon \"P\" [{x} -1 0 {} -1 0 {} 1 0 {x} 1 0]\n", x + 0.5, x + 0.5);
    let ids = |world: &str| {
        let work = scratch();
        let path = work.path().join("t.rib");
        let text =
            format!("Display \"t.exr\" \"exr\" \"id\"\n{PLAIN}\nWorldBegin\nSurface \"constant\"\n{world}\nWorldEnd\n");
        std::fs::write(&path, text).unwrap();
        scree(&["render", path.to_str().unwrap(), "-o", work.path().to_str().unwrap()]).ok();
        let image = Layers::read(&work.path().join("t.exr"));
        [8, 24, 40].map(|x| image.at("id", x, 32))
    };
    let [first, second] = [square(-1.0), square(-0.5)];
    let sphere = "TransformBegin Translate .25 0 0 Sphere .3 -.3 .3 360 TransformEnd\n";
    assert_eq!(ids(&format!("{first}{second}{sphere}")), [1.0, 2.0, 3.0]);
    assert_eq!(ids(&format!("{first}{first}{first}{second}{second}{sphere}{sphere}")), [1.0, 4.0, 6.0]);
    // As where the copies are apart by so little that they are kept.
    let near = first.replace(" 0 ", " 0.00001 ");
    assert_eq!(ids(&format!("{first}{near}{near}{second}{sphere}")), [1.0, 4.0, 5.0]);
}
