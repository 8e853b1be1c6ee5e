//! Marks of what moves and is pressed: arrows, trails, forces of contacts; how long they are, where they go, and what is refused.

use crate::cli::{scratch, scree};
use image::RgbImage;
use std::path::Path;

/// Metres across the image's shorter side; pixels of it.
const VIEW: f64 = 2.0;
const HEIGHT: u32 = 200;

/// Frames of two bodies: the first comes along x by 0.2 m a frame from −0.4 m, the second rests at z = −0.6 m.
fn table(folder: &Path, frames: u32) {
    for frame in 0..frames {
        let (x, v) = (-0.4 + 0.2 * frame as f64, frame + 1);
        let rows = format!("id,pos_x,pos_y,pos_z,vel_x,vel_y,vel_z\n7,{x},0,0,{v},0,0\n9,0.1,0,-0.6,0,0,0\n");
        std::fs::write(folder.join(format!("b_{frame}.csv")), rows).unwrap();
    }
}

/// A metadata file that draws bodies and an object.
fn metadata(folder: &Path, data: &str, object: &str) -> String {
    let bodies = "{name: bodies, geometry: {sphere: {radius: 0.02}}}";
    let text = format!(
        "data: {data}\nscene: white_page.rib\ncamera: {{view: side, orthographic: {VIEW}, look_at: [0, 0, 0]}}\nobjects:\n  - {bodies}\n{object}output: {{quality: draft}}\n"
    );
    let path = folder.join("m.yaml");
    std::fs::write(&path, text).unwrap();
    path.to_str().unwrap().into()
}

/// The image of a frame.
fn draw(folder: &Path, data: &str, object: &str, frame: u32) -> RgbImage {
    let (file, out) = (metadata(folder, data, object), folder.join("o"));
    let res = format!("{HEIGHT}x{HEIGHT}");
    scree(&["render", &file, "-o", out.to_str().unwrap(), "--res", &res, "-f", &frame.to_string()]).ok();
    image::open(out.join(format!("{frame:06}.png"))).unwrap().to_rgb8()
}

/// Where a mark is in a frame, m: the least and largest x and z of the pixels that it changes; none if it changes none.
fn extent(folder: &Path, data: &str, object: &str, frame: u32) -> Option<[f64; 4]> {
    let (with, without) = (draw(folder, data, object, frame), draw(folder, data, "", frame));
    let mut found: Option<[f64; 4]> = None;
    for (x, y, pixel) in with.enumerate_pixels() {
        let change = pixel.0.iter().zip(without.get_pixel(x, y).0).map(|(a, b)| a.abs_diff(b)).max().unwrap();
        if change > 12 {
            let place = |k: f64| (k - 0.5 * HEIGHT as f64) * VIEW / HEIGHT as f64;
            let [a, b] = [place(x as f64 + 0.5), -place(y as f64 + 0.5)];
            let [x0, x1, z0, z1] = found.unwrap_or([a, a, b, b]);
            found = Some([x0.min(a), x1.max(a), z0.min(b), z1.max(b)]);
        }
    }
    found
}

const BODIES: &str = "{files: 'b_*.csv'}";

fn assert_near(found: Option<[f64; 4]>, expected: [f64; 4], what: &str) {
    let found = found.unwrap_or_else(|| panic!("{what} is not in the image"));
    let is_near = found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 0.035);
    assert!(is_near, "{what} is at {found:.3?}, expected {expected:.3?}");
}

#[test]
fn arrows_are_as_long_as_their_vectors() {
    let work = scratch();
    table(work.path(), 2);
    let object = |arrow: &str| format!("  - {{name: v, geometry: {{arrow: {arrow}}}, color: [0.8, 0.1, 0.1]}}\n");
    let at = |arrow: &str, frame| extent(work.path(), BODIES, &object(arrow), frame);
    assert_near(at("{scale: 0.3}", 0), [-0.4, -0.1, -0.02, 0.02], "the arrow of 1 m/s");
    assert_near(at("{scale: 0.3}", 1), [-0.2, 0.4, -0.02, 0.02], "the arrow of 2 m/s");
    // The longest of both frames is a fifth of the view.
    assert_near(at("{}", 0), [-0.4, -0.2, -0.02, 0.02], "the shorter arrow");
    assert_near(at("{}", 1), [-0.2, 0.2, -0.02, 0.02], "the longest arrow");
    let up = "{vector: [0, 0, pos_z + 0.6], scale: 1, width: 0.04}";
    assert_near(at(up, 0), [-0.46, -0.34, 0.0, 0.6], "the arrow of an expression");
    assert!(at("{vector: [0, 0, 0]}", 0).is_none(), "there is no arrow where nothing moves");
}

#[test]
fn trails_go_through_the_places_before_and_fade() {
    let work = scratch();
    table(work.path(), 5);
    let object = |trail: &str| format!("  - {{name: w, geometry: {{trail: {trail}}}, color: [0.8, 0.1, 0.1]}}\n");
    let at = |trail: &str, frame| extent(work.path(), BODIES, &object(trail), frame);
    assert_near(at("{frames: 2, fade: false}", 4), [0.0, 0.4, 0.0, 0.0], "the trail of two frames");
    assert_near(at("{frames: 20, fade: false}", 3), [-0.4, 0.2, 0.0, 0.0], "the trail of all frames before");
    assert!(at("{frames: 2}", 0).is_none(), "there is no trail in the first frame");
    let image = draw(work.path(), BODIES, &object("{frames: 4, width: 0.06}"), 4);
    // Along the trail towards its beginning the page shows more and more through the red.
    let green =
        [0.3, 0.1, -0.1, -0.3].map(|x: f64| image.get_pixel(((x / VIEW + 0.5) * HEIGHT as f64) as u32, 99).0[1]);
    assert!(green.is_sorted() && green[3] > green[0] + 60, "the trail fades: {green:?}");
    let mut history = "t,pos_x,pos_y,pos_z\n".to_string();
    (0..5).for_each(|k| history += &format!("{},{},0,0\n", 0.1 * k as f64, -0.4 + 0.2 * k as f64));
    std::fs::write(work.path().join("h.csv"), history).unwrap();
    // A part of a step: 0.25 s are two steps and a half.
    let found = extent(work.path(), "{files: h.csv, time: t}", &object("{length: 0.25, fade: false}"), 4);
    assert_near(found, [-0.1, 0.4, 0.0, 0.0], "the trail of a time");
}

#[test]
fn forces_of_contacts_are_those_of_the_run() {
    let work = scratch();
    let model = "duration: 0.5
frame_rate: 10
materials: {stone: {density: 2500, friction: 0.5}}
bodies:
  - {name: ground, material: stone, plane: {normal: [0, 0, 1]}, position: [0, 0, -0.5]}
  - {name: ball, material: stone, sphere: {radius: 0.1}, position: [0.3, 0, -0.4]}
";
    let run = |name: &str, probes: &str| {
        let (file, out) = (work.path().join("model.yaml"), work.path().join(name));
        std::fs::write(&file, format!("{model}{probes}")).unwrap();
        scree(&["simulate", file.to_str().unwrap(), "-o", out.to_str().unwrap()]).ok();
    };
    run("plain", "");
    run("run", "probes: {contact_tables: true}\n");
    // 0.5 m for the weight of 2500 kg/m³ · 4/3 π (0.1 m)³ · 9.81 m/s² = 102.7 N.
    let arrow = "{arrow: {vector: ['abs(force_x)', 'abs(force_y)', 'abs(force_z)'], scale: 0.004868}}";
    let object = format!("  - {{name: f, rows: contacts, geometry: {arrow}, color: [0.8, 0.1, 0.1]}}\n");
    assert_near(extent(work.path(), "{run: run}", &object, 4), [0.28, 0.32, -0.5, 0.0], "the weight");
    let file = metadata(work.path(), "{run: plain}", &object);
    let out = work.path().join("o");
    let said = scree(&["render", &file, "-o", out.to_str().unwrap(), "--res", "20x20"]).fails(3);
    assert!(said.contains("contact_tables") && said.contains("m.yaml:6"), "{said}");
}

#[test]
fn what_is_wrong_is_refused_at_its_place() {
    let work = scratch();
    table(work.path(), 3);
    let cases: [(&str, &[&str]); 8] = [
        ("geometry: {arrow: {scale: 0}}", &["above 0"]),
        ("geometry: {arrow: {vector: [vel_x, vel_y, vle_z]}}", &["vle_z", "did you mean `vel_z`"]),
        ("geometry: {trail: {}}", &["`length`", "`frames`"]),
        ("geometry: {trail: {length: 1, frames: 2}}", &["`length`", "`frames`"]),
        ("geometry: {trail: {frames: 0}}", &["above 0"]),
        ("geometry: {trail: {length: 1}}", &["no times that ascend", "`frames`"]),
        ("rows: contacts, geometry: {trail: {frames: 2}}", &["contacts have no trails"]),
        ("rows: contacts, geometry: {arrow: {}}", &["no run of scree"]),
    ];
    for (object, expected) in cases {
        let file = metadata(work.path(), BODIES, &format!("  - {{name: o, {object}}}\n"));
        let out = work.path().join("o");
        let said = scree(&["render", &file, "-o", out.to_str().unwrap(), "--res", "20x20", "-f", "2"]).fails(3);
        for part in expected.iter().chain(&["m.yaml:6"]) {
            assert!(said.contains(part), "{object}: `{part}` is missing in {said}");
        }
    }
}

#[test]
fn a_film_with_trails_reads_each_table_once() {
    let work = scratch();
    table(work.path(), 6);
    let file = metadata(work.path(), BODIES, "  - {name: w, geometry: {trail: {frames: 2}}}\n");
    let binding = bind::read(Path::new(&file)).unwrap();
    let source = binding.open_data().unwrap();
    for frame in 0..4 {
        let table = source.shared(frame).unwrap();
        assert_eq!(bind::Moment::of(&binding, &source, &table).unwrap().before.len(), frame.min(2) as usize);
        // What has been read is not there any more.
        std::fs::remove_file(work.path().join(format!("b_{frame}.csv"))).unwrap();
    }
    // What no trail goes back to is let go of.
    assert!(source.shared(3).is_ok() && source.shared(1).is_ok() && source.shared(0).is_err());
}

#[test]
fn images_with_trails_that_are_drawn_at_a_time_read_each_table_once() {
    let work = scratch();
    table(work.path(), 6);
    let file = metadata(work.path(), BODIES, "  - {name: w, geometry: {trail: {frames: 2}}}\n");
    let binding = bind::read(Path::new(&file)).unwrap();
    let source = binding.open_data().unwrap();
    // Threads that want a table at a time have the same.
    let all: Vec<_> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..8).map(|_| scope.spawn(|| source.shared(0).unwrap())).collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).collect()
    });
    assert!(all.iter().all(|table| std::sync::Arc::ptr_eq(table, &all[0])));
    drop(all);
    let tables: Vec<_> = (0..4).map(|frame| source.shared(frame).unwrap()).collect();
    (0..4).for_each(|frame| std::fs::remove_file(work.path().join(format!("b_{frame}.csv"))).unwrap());
    // Whichever comes first, no other image's tables are let go of.
    for frame in [3, 1, 2, 0] {
        let before = bind::Moment::of(&binding, &source, &tables[frame]).unwrap().before;
        assert_eq!(before.len(), frame.min(2));
    }
    drop(tables);
    let table = source.shared(4).unwrap();
    assert_eq!(bind::Moment::of(&binding, &source, &table).unwrap().before.len(), 2);
    assert!(source.shared(1).is_err());
}

#[test]
fn colours_of_marks_are_theirs_in_every_scene() {
    let work = scratch();
    table(work.path(), 1);
    let color = [0.8, 0.1, 0.3f64];
    let object = format!(
        "  - {{name: v, geometry: {{arrow: {{vector: [0.8, 0, 0], scale: 1, width: 0.1}}}}, color: {color:?}}}\n"
    );
    let shown = color.map(|c| 255.0 * c.powf(1.0 / 2.2));
    for scene in ["white_page", "dark_page", "laboratory", "studio", "lunar", "quarry", "desert_noon", "desert_dusk"] {
        let file = metadata(work.path(), BODIES, &object);
        let text = std::fs::read_to_string(&file).unwrap().replace("white_page", scene);
        std::fs::write(&file, text).unwrap();
        let out = work.path().join(scene);
        scree(&["render", &file, "-o", out.to_str().unwrap(), "--res", "200x200"]).ok();
        let image = image::open(out.join("000000.png")).unwrap().to_rgb8();
        // The middle of the shaft faces the eye.
        let found = image.get_pixel(100, 100).0;
        let is_near = found.iter().zip(shown).all(|(c, expected)| (*c as f64 - expected).abs() < 8.0);
        assert!(is_near, "{scene}: {found:?}, expected {shown:.0?}");
    }
}
