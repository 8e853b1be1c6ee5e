//! Very many vertices, and very many solids in one place: what they take is bounded, and what is not drawn is said.

use crate::cli::{scratch, scree};
use crate::rendering::{ORTHO, render_with};

/// Render a world, with files beside it: what was said, and the statistics of the image.
fn rendered(files: &[(&str, &str)], world: &str) -> (String, serde_json::Value) {
    let work = scratch();
    let at = |name: &str| work.path().join(name).to_str().unwrap().to_string();
    for (name, text) in files {
        std::fs::write(at(name), text).unwrap();
    }
    let head = format!("Display \"t.png\" \"png\" \"rgb\"\n{ORTHO}\nWorldBegin\n");
    std::fs::write(at("t.rib"), format!("{head}{world}\nWorldEnd\n")).unwrap();
    let answer = scree(&["render", &at("t.rib"), "--stats", "-o", &at("")]);
    let said = answer.errors().to_string();
    let stats = std::fs::read(at("t.png.stats.json")).unwrap();
    (said, serde_json::from_slice::<serde_json::Value>(&stats).unwrap()["stats"].clone())
}

/// A polygon of the points of a circle, each as far on from the one before.
fn star(n: usize, step: usize) -> String {
    let at = |k: usize| (k * step % n) as f32 / n as f32 * std::f32::consts::TAU;
    let points: String = (0..n).map(|k| format!("{} {} 0 ", 0.8 * at(k).cos(), 0.8 * at(k).sin())).collect();
    format!("Surface \"constant\"\nPolygon \"P\" [{points}]")
}

#[test]
fn polygons_whose_edges_cross_are_said_and_large_ones_are_not_drawn() {
    let (said, stats) = rendered(&[], &star(100_001, 50_000));
    let expected =
        "t.rib:5:1: a polygon of 100001 vertices whose edges cross is not drawn: such a one has at most 16384";
    assert!(said.contains(expected), "{said}");
    assert_eq!(stats["micropolygons"], 0);
    // A small one is drawn, in parts at least.
    let (said, stats) = rendered(&[], &star(5, 2));
    assert!(said.contains("t.rib:5:1: the edges of a polygon cross: parts of it may be missing"), "{said}");
    assert!(stats["micropolygons"].as_u64() > Some(0));
    // Nothing is said of one that does not cross itself, however many vertices it has, nor of holes that touch it.
    let (said, stats) = rendered(&[], &star(100_001, 1));
    assert!(!said.contains("polygon") && stats["micropolygons"].as_u64() > Some(0), "{said}");
    let holes = "GeneralPolygon [4 3 3] \"P\" [-.9 -.9 0 .9 -.9 0 .9 .9 0 -.9 .9 0 -.9 0 0 0 -.5 0 0 .5 0 0 -.5 0 .5 0 0 0 .5 0]";
    let (said, _) = rendered(&[], &format!("Surface \"constant\"\n{holes}"));
    assert!(!said.contains("polygon"), "{said}");
}

/// A sphere with a bite, moved by hundredths.
fn bitten(place: usize) -> String {
    let [x, y, z] = [place % 5, place % 3, place % 7].map(|k| k as f32 * 0.001);
    format!(
        "TransformBegin Translate {x} {y} {z} SolidBegin \"difference\" SolidBegin \"primitive\" Sphere 0.8 -0.8 0.8 360 SolidEnd
        SolidBegin \"primitive\" Translate 0.3 0.3 -0.6 Sphere 0.5 -0.5 0.5 360 SolidEnd SolidEnd TransformEnd\n"
    )
}

#[test]
fn solids_in_one_place_are_drawn_once() {
    let lit = "LightSource \"distantlight\" 1 \"from\" [0 0 0] \"to\" [0 0.3 1]\nSurface \"matte\"\n";
    let count = |stats: &serde_json::Value, what: &str| stats[what].as_u64().unwrap();
    let (_, one) = rendered(&[], &format!("{lit}{}", bitten(0)));
    let (_, many) = rendered(&[], &format!("{lit}{}", bitten(0).repeat(2000)));
    for what in ["micropolygons", "shaded_points", "samples"] {
        assert_eq!(count(&one, what), count(&many, what), "{what}");
    }
    // Another colour changes nothing: the first is seen. One that is less by another part, is translucent or stands elsewhere is drawn.
    let other = |text: &str| rendered(&[], &format!("{lit}{}{text}", bitten(0))).1;
    let same = other(&format!("Color 1 0 0 {}", bitten(0)));
    assert_eq!(count(&same, "micropolygons"), count(&one, "micropolygons"));
    for different in
        [format!("Opacity 0.5 0.5 0.5 {}", bitten(0)), bitten(1), bitten(0).replace("difference", "intersection")]
    {
        assert!(count(&other(&different), "micropolygons") > count(&one, "micropolygons") * 5 / 4, "{different}");
    }
}

#[test]
fn of_solids_within_each_other_what_is_hidden_is_not_shaded() {
    // A hundred that nearly coincide: each has surfaces in front of others in parts, none is shaded all over.
    let lit = "LightSource \"distantlight\" 1 \"from\" [0 0 0] \"to\" [0 0.3 1]\nSurface \"matte\"\n";
    let world = |n: usize| format!("{lit}{}", (0..n).map(bitten).collect::<String>());
    let shaded = |n: usize| rendered(&[], &world(n)).1["shaded_points"].as_u64().unwrap();
    let (one, many) = (shaded(1), shaded(100));
    assert!(many < 20 * one, "{many} points of a hundred, {one} of one");
    // And it is the same image as of the union, but for what is seen through: nothing.
    let [apart, union] = [world(100), format!("{lit}SolidBegin \"union\" {} SolidEnd", &world(100)[lit.len()..])]
        .map(|world| render_with(&[], ORTHO, &world));
    let differ = apart.pixels.iter().zip(&union.pixels).filter(|(a, b)| (a[0] - b[0]).abs() > 0.02).count();
    assert!(differ < 64, "{differ} pixels differ");
}

#[test]
fn displacement_without_end_is_said_with_the_place_of_what_it_displaces() {
    let far = "displacement d() { P += pow(10, 30) * pow(10, 30) * N; }";
    let files = [("d.sl", far)];
    let (said, _) = rendered(&files, "Surface \"constant\"\nDisplacement \"d\"\n  Disk 0 0.8 360\nDisk 0 0.8 360");
    assert!(said.contains("t.rib:6:3: ") && said.contains("d.sl: displacement `d` moves points"), "{said}");
    // Where the data places it, the object's line in the metadata.
    let work = scratch();
    let at = |name: &str| work.path().join(name).to_str().unwrap().to_string();
    std::fs::write(at("d.sl"), far).unwrap();
    std::fs::write(at("t.csv"), "x,y,z\n0,0,1\n").unwrap();
    let metadata = "data: {files: t.csv}
camera: {eye: [5, 0, 1], look_at: [0, 0, 1], fov: 40}
objects:
  - name: stones
    geometry: {sphere: {radius: 0.5}}
    position: [x, y, z]
    displacement: {name: d, bound: 0.1}
output: {resolution: [64, 48]}
";
    std::fs::write(at("t.yaml"), metadata).unwrap();
    let answer = scree(&["render", &at("t.yaml"), "-o", &at("")]);
    assert!(
        answer.errors().contains("t.yaml:4:5: ") && answer.errors().contains("`d` moves points"),
        "{}",
        answer.errors()
    );
}
