//! Very many layers that are seen through each other: what they come to, known on paper, in memory and time that are bounded.

use crate::cli::{scratch, scree};
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
fn stats(options: &str, world: &str) -> serde_json::Value {
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
