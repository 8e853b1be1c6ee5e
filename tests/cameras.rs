//! Cameras of metadata files: keyframes, cuts and stereo pairs, and a floor that is as large as the data.

use crate::cli::{scratch, scree};
use image::RgbImage;
use std::path::Path;

/// Metadata of three frames with the same small spheres: places and radii, m.
fn metadata(folder: &Path, camera: &str, scene: &str, spheres: &[[f32; 4]]) -> String {
    for frame in 0..3 {
        let rows: String = spheres.iter().map(|[x, y, z, r]| format!("{x},{y},{z},{r}\n")).collect();
        std::fs::write(folder.join(format!("s_{frame}.csv")), format!("pos_x,pos_y,pos_z,r\n{rows}")).unwrap();
    }
    let text = format!(
        "data: {{files: 's_*.csv'}}\nscene: {scene}\ncamera: {camera}\nobjects:
  - {{name: spheres, geometry: {{sphere: {{radius: r}}}}, color: [0.9, 0.1, 0.1]}}\noutput: {{resolution: [320, 180], samples: [4, 4]}}\n"
    );
    let path = folder.join("m.yaml");
    std::fs::write(&path, text).unwrap();
    path.to_str().unwrap().into()
}

/// The images of the three frames, and those of a right eye if there is one.
fn draw(camera: &str, scene: &str, spheres: &[[f32; 4]]) -> [Vec<RgbImage>; 2] {
    let work = scratch();
    let (file, out) = (metadata(work.path(), camera, scene, spheres), work.path().join("o"));
    scree(&["render", &file, "-o", out.to_str().unwrap()]).ok();
    ["", "right"].map(|eye| {
        let file = |k: usize| out.join(eye).join(format!("{k:06}.png"));
        (0..3).map(file).filter(|f| f.exists()).map(|f| image::open(f).unwrap().to_rgb8()).collect()
    })
}

const SPHERE: [[f32; 4]; 1] = [[0.3, 0.0, 0.2, 0.3]];

#[test]
fn keyframes_are_gone_through_and_cuts_jump() {
    let [first, last] =
        ["eye: [0, -4, 1], look_at: [0, 0, 0], fov: 40", "eye: [3, -3, 2], look_at: [0.4, 0, 0], fov: 20"];
    let still = |view: &str| draw(&format!("{{{view}}}"), "white_page.rib", &SPHERE)[0][0].clone();
    let moving = |keys: &str| draw(&format!("{{{first}, keys: [{keys}]}}"), "white_page.rib", &SPHERE)[0].clone();
    let smooth = moving(&format!("{{frame: 0}}, {{frame: 2, {last}}}"));
    assert!(smooth[0] == still(first) && smooth[2] == still(last), "at the keys it is where they say");
    let half = "eye: [1.5, -3.5, 1.5], look_at: [0.2, 0, 0], fov: 30";
    assert!(smooth[1] == still(half), "half way it is in the middle");
    let cut = moving(&format!("{{frame: 0}}, {{frame: 2, cut: true, {last}}}"));
    assert!(cut[0] == cut[1] && cut[1] == smooth[0] && cut[2] == smooth[2]);
}

/// The middle of what is red, pixels.
fn middle(image: &RgbImage, from: u32, to: u32) -> [f64; 2] {
    let red = image.enumerate_pixels().filter(|(x, _, p)| (from..to).contains(x) && p[0] as i32 > p[1] as i32 + 30);
    let (n, x, y) = red.fold((0.0, 0.0, 0.0), |(n, sx, sy), (x, y, _)| (n + 1.0, sx + x as f64, sy + y as f64));
    assert!(n > 20.0, "{n} pixels");
    [x / n + 0.5, y / n + 0.5]
}

#[test]
fn a_stereo_pair_sees_what_it_looks_at_at_one_place_and_the_rest_aside() {
    let spheres = [[0.0, 0.0, 0.0, 0.08], [0.5, -2.0, 0.0, 0.05]];
    let camera = "{eye: [0, -4, 0], look_at: [0, 0, 0], fov: 40, stereo: 0.1}";
    let [left, right] = draw(camera, "white_page.rib", &spheres);
    assert_eq!((left.len(), right.len()), (3, 3));
    let middles = [&left[0], &right[0]].map(|image| middle(image, 120, 200));
    for [x, y] in middles {
        assert!((x - 160.0).abs() < 0.3 && (y - 90.0).abs() < 0.3, "what is looked at stays: {middles:?}");
    }
    // Half as far, with half the eyes' distance d to each side: pixels of d (1/2 − 1/4) / tan 20°, in a half height of 90.
    let aside = middle(&left[0], 205, 320)[0] - middle(&right[0], 205, 320)[0];
    let expected = 0.1 * (1.0 / 2.0 - 1.0 / 4.0) * 90.0 / 20f64.to_radians().tan();
    assert!((aside - expected).abs() < 0.4, "{aside}, expected {expected}");
}

#[test]
fn a_floor_is_as_large_as_the_data() {
    let at = |scale: f32| {
        let spheres = [[0.3f32, 0.0, 0.3, 0.3], [-0.4, 0.2, 0.2, 0.2]].map(|s| s.map(|x| x * scale));
        let [x, y, z] = [1.5, -3.0, 1.4].map(|c: f32| c * scale);
        draw(&format!("{{eye: [{x}, {y}, {z}], look_at: [0, 0, 0]}}"), "seamless.rib", &spheres)[0][0].clone()
    };
    let metres = at(1.0);
    let corner = metres.get_pixel(5, 175);
    assert!(metres.pixels().any(|p| p[0] as i32 + 40 < corner[0] as i32), "there is a shadow");
    for scale in [0.01, 100.0] {
        let other = at(scale);
        let strays = metres.as_raw().iter().zip(other.as_raw()).map(|(a, b)| a.abs_diff(*b) as f64);
        let mean = strays.sum::<f64>() / metres.as_raw().len() as f64;
        assert!(mean < 0.3, "at a scale of {scale}: {mean} of 255");
    }
}

#[test]
fn wrong_keys_are_refused_at_their_place() {
    let cases: [(&str, &[&str]); 6] = [
        (
            "{eye: [0, -4, 1], look_at: [0, 0, 0], keys: [{frame: 3}, {frame: 3}]}",
            &["keys", "after that of the key before", "m.yaml:3"],
        ),
        ("{eye: [0, -4, 1], look_at: [0, 0, 0], keys: [{frame: 3, eyes: [0, 0, 1]}]}", &["eyes", "`eye`", "m.yaml:3"]),
        (
            "{eye: [0, -4, 1], look_at: [0, 0, 0], keys: [{frame: 0, eye: [0, 0, 1]}]}",
            &["cannot look along `up`", "m.yaml:3"],
        ),
        ("{eye: [0, -4, 1], look_at: [0, 0, 0], orthographic: 2, stereo: 0.1}", &["perspective", "m.yaml:3"]),
        ("{eye: [0, -4, 1], look_at: [0, 0, 0], stereo: -1}", &["more than 0", "m.yaml:3"]),
        ("{view: top, orthographic: 2, keys: [{frame: 0}]}", &["`eye` and `look_at`", "m.yaml:3"]),
    ];
    for (camera, expected) in cases {
        let work = scratch();
        let file = metadata(work.path(), camera, "white_page.rib", &SPHERE);
        let said = scree(&["render", &file, "-o", work.path().join("o").to_str().unwrap()]).fails(3);
        for part in expected {
            assert!(said.contains(part), "{camera}: `{part}` is missing in {said}");
        }
    }
}

#[test]
fn a_turntable_is_a_loop_and_turns_by_equal_angles() {
    let turned = |camera: &str| {
        draw(&format!("{{eye: [0, -4, 1], look_at: [0, 0, 0], {camera}}}"), "white_page.rib", &SPHERE)[0].clone()
    };
    let [turns, orbit] = ["turns: 1", "orbit: 120"].map(turned);
    assert!(turns == orbit, "three frames are thirds of a turn");
    assert!(turned("turns: -1")[1] == turns[2], "the other way round");
    let work = scratch();
    let file =
        metadata(work.path(), "{eye: [0, -4, 1], look_at: [0, 0, 0], turns: 1, orbit: 3}", "white_page.rib", &SPHERE);
    assert!(scree(&["check", &file]).fails(3).contains("instead of `orbit`"));
}

#[test]
fn a_damped_camera_follows_without_shaking_or_lagging() {
    let work = scratch();
    // A body that goes along x, up and down by 0.2 m from frame to frame, and one that rests.
    for frame in 0..25 {
        let z = if frame % 2 == 0 { 0.1 } else { -0.1 };
        let rows = format!("pos_x,pos_y,pos_z,r\n{},0,{z},0.1\n", 0.5 * frame as f64);
        std::fs::write(work.path().join(format!("s_{frame}.csv")), rows).unwrap();
    }
    let place = |damping: &str, frame: u32| {
        let text = format!(
            "data: {{files: 's_*.csv'}}\nscene: white_page.rib\ncamera: {{eye: [0, -4, 0], look_at: [0, 0, 0], follow: r > 0{damping}}}\nobjects:
  - {{name: spheres, geometry: {{sphere: {{radius: r}}}}, color: [0.9, 0.1, 0.1]}}\noutput: {{resolution: [320, 180], samples: [4, 4]}}\n"
        );
        let (file, out) = (work.path().join("m.yaml"), work.path().join("o"));
        std::fs::write(&file, text).unwrap();
        scree(&["render", file.to_str().unwrap(), "-o", out.to_str().unwrap(), "-f", &frame.to_string()]).ok();
        middle(&image::open(out.join(format!("{frame:06}.png"))).unwrap().to_rgb8(), 0, 320)
    };
    // The view is 2.52 m high: 0.1 m are 7.1 pixels.
    for frame in [0, 11, 12, 24] {
        let [x, y] = place(", damping: 3", frame);
        let up = if frame % 2 == 0 { -7.1 } else { 7.1 };
        let end = frame == 0 || frame == 24;
        assert!((x - 160.0).abs() < 1.0, "frame {frame}: it does not lag: {x}");
        assert!(end || (y - 90.0 - up).abs() < 1.5, "frame {frame}: it does not shake: {y}");
        assert!((place("", frame)[1] - 90.0).abs() < 1.0, "undamped it shakes along");
    }
    let file = metadata(work.path(), "{eye: [0, -4, 1], look_at: [0, 0, 0], damping: 3}", "white_page.rib", &SPHERE);
    assert!(scree(&["check", &file]).fails(3).contains("needs `follow`"));
}

#[test]
fn scenes_are_as_large_as_the_data() {
    let scenes = std::fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes")).unwrap();
    let mut n = 0;
    for scene in scenes.map(|e| e.unwrap().file_name().into_string().unwrap()) {
        let image = |size: f32| {
            let spheres = [[0.1, 0.0, 0.2, 0.2], [-0.3, 0.2, 0.1, 0.1]].map(|sphere| sphere.map(|x: f32| x * size));
            let camera = format!("{{eye: [{}, {}, {}], look_at: [0, 0, 0]}}", size, -1.7 * size, 0.9 * size);
            draw(&camera, &scene, &spheres)[0][0].clone()
        };
        let of_machines = image(1.0);
        for size in [0.01, 100.0] {
            let other = image(size);
            let pairs = of_machines.as_raw().iter().zip(other.as_raw());
            let change = pairs.map(|(a, b)| a.abs_diff(*b) as f64).sum::<f64>() / other.as_raw().len() as f64;
            assert!(change < 2.0, "{scene}: data of {size} m looks different by {change:.2} of 255");
        }
        n += 1;
    }
    assert!(n >= 12, "{n} scenes");
}

#[test]
fn the_quickstart_shows_all_of_its_stones_from_first_to_last() {
    let work = scratch();
    let run = work.path().join("run");
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let model = root.join("sim/models/quickstart.yaml");
    scree(&["simulate", model.to_str().unwrap(), "-o", run.to_str().unwrap()]).ok();
    let binding = bind::read(&root.join("metadata/quickstart.yaml")).unwrap();
    let run = frame::run::RunReader::open(&run).unwrap();
    let numbers = run.numbers();
    assert_eq!(numbers.len(), 48);
    for number in numbers {
        let table = run.read_frame(number).unwrap();
        let stand = bind::emit::stand(&binding, &table).unwrap().unwrap();
        let bind::binding::Projection::Perspective(fov) = stand.projection else { panic!("a perspective") };
        let (eye, at) = (glam::Vec3::from(stand.eye), glam::Vec3::from(stand.at));
        let ahead = (at - eye).normalize();
        let right = ahead.cross(glam::Vec3::Z).normalize();
        // Inward normals of the four sides of the pyramid that the camera sees, 16 to 9.
        let upright = (0.5 * fov).to_radians().tan();
        let side = |across: glam::Vec3, share: f32| {
            let along = share.atan();
            [1.0, -1.0].map(|sign| ahead * along.sin() + sign * across * along.cos())
        };
        let sides = [side(right, upright * 16.0 / 9.0), side(right.cross(ahead), upright)].concat();
        let column = |name: &str, row: usize| table.column(name).unwrap().number(row).unwrap() as f32;
        let mut n = 0;
        for row in (0..table.rows()).filter(|row| table.column("class").unwrap().text(*row) == "stones") {
            let place = glam::Vec3::from(["pos_x", "pos_y", "pos_z"].map(|name| column(name, row)));
            let room = sides.iter().map(|normal| normal.dot(place - eye)).fold(f32::INFINITY, f32::min);
            assert!(room > column("half_x", row), "frame {number}: the stone at {place} is cut, {room} m from a side");
            n += 1;
        }
        assert_eq!(n, 3000, "frame {number}");
    }
}

#[test]
fn a_floor_lies_under_data_that_has_none_where_the_file_says_how_high() {
    let work = scratch();
    let image = |scene: &str, more: &str| {
        let file = metadata(work.path(), "{eye: [0.3, -3, 1.2], look_at: [0.3, 0, 0.2]}", scene, &SPHERE);
        let text = std::fs::read_to_string(&file).unwrap();
        std::fs::write(&file, format!("{text}{more}")).unwrap();
        let out = work.path().join("o");
        scree(&["render", &file, "-f", "0", "-o", out.to_str().unwrap(), "--image-quality", "draft"]).ok();
        image::open(out.join("000000.png")).unwrap().to_rgb8()
    };
    let own = "  - {name: own, select: pos_x > 9, geometry: {plane: {half: 50}}, position: [0, 0, 0]}\n";
    for scene in ["studio.rib", "quarry.rib"] {
        let below = |image: &RgbImage| image.get_pixel(20, 165).0.map(f64::from);
        let [bare, laid] = ["", "ground_height: 0\n"].map(|more| below(&image(scene, more)));
        let change = (0..3).map(|c| (bare[c] - laid[c]).abs()).sum::<f64>();
        assert!(change > 20.0, "{scene}: a floor of {laid:?} over {bare:?}");
        // Data with a ground of its own has no other, even where no row of it is drawn.
        let text = |more: &str| more.replace("output:", &format!("{own}output:"));
        let file = metadata(work.path(), "{eye: [0.3, -3, 1.2], look_at: [0.3, 0, 0.2]}", scene, &SPHERE);
        let with = text(&std::fs::read_to_string(&file).unwrap());
        let out = work.path().join("g");
        std::fs::write(&file, format!("{with}ground_height: 0\n")).unwrap();
        scree(&["render", &file, "-f", "0", "-o", out.to_str().unwrap(), "--image-quality", "draft"]).ok();
        assert_eq!(below(&image::open(out.join("000000.png")).unwrap().to_rgb8()), bare, "{scene}");
    }
}
