//! Data whose up is another axis than z stands upright in the images.

use crate::cli::{scratch, scree};
use image::RgbImage;
use std::path::Path;

/// A rotation by right angles: each row has where a turned coordinate comes from, and its sign.
type Turn = [(usize, f64); 3];

/// The axes, and how data with z up is turned for the axis to be up: x, y, z of the turned data.
const AXES: [(&str, Turn, [f64; 4]); 6] = [
    ("x", [(2, 1.0), (1, 1.0), (0, -1.0)], [HALF, 0.0, HALF, 0.0]),
    ("-x", [(2, -1.0), (1, 1.0), (0, 1.0)], [HALF, 0.0, -HALF, 0.0]),
    ("y", [(0, 1.0), (2, 1.0), (1, -1.0)], [HALF, -HALF, 0.0, 0.0]),
    ("-y", [(0, 1.0), (2, -1.0), (1, 1.0)], [HALF, HALF, 0.0, 0.0]),
    ("z", [(0, 1.0), (1, 1.0), (2, 1.0)], [1.0, 0.0, 0.0, 0.0]),
    ("-z", [(0, 1.0), (1, -1.0), (2, -1.0)], [0.0, 1.0, 0.0, 0.0]),
];
const HALF: f64 = std::f64::consts::FRAC_1_SQRT_2;

fn turned(turn: &Turn, v: [f64; 3]) -> [f64; 3] {
    turn.map(|(k, sign)| sign * v[k])
}

/// The product of two quaternions w, x, y, z.
fn product([a, b, c, d]: [f64; 4], [w, x, y, z]: [f64; 4]) -> [f64; 4] {
    [
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x,
        a * z + b * y - c * x + d * w,
    ]
}

/// The image of boxes that move and turn, with arrows and trails, of data turned for this axis to be up.
fn draw((axis, turn, rotation): &(&str, Turn, [f64; 4])) -> RgbImage {
    let work = scratch();
    for frame in 0..3 {
        let mut table = "id,pos_x,pos_y,pos_z,vel_x,vel_y,vel_z,quat_w,quat_x,quat_y,quat_z\n".to_string();
        for k in 0..5 {
            let (t, s) = (frame as f64, k as f64);
            let velocity = [0.5 - 0.2 * s, 0.3, 1.0 - 0.3 * s];
            let place = [0, 1, 2].map(|c| [s * 0.5 - 1.0, 0.2 * s, 0.5][c] + 0.2 * t * velocity[c]);
            let angle = 0.3 * s + 0.2;
            let q = product(*rotation, [angle.cos(), 0.6 * angle.sin(), 0.0, 0.8 * angle.sin()]);
            let row = [turned(turn, place), turned(turn, velocity)].concat();
            let cells = row.iter().chain(&q).map(f64::to_string).collect::<Vec<_>>();
            table += &format!("{k},{}\n", cells.join(","));
        }
        std::fs::write(work.path().join(format!("s_{frame}.csv")), table).unwrap();
    }
    let text = format!(
        "data: {{files: 's_*.csv'}}\nup: '{axis}'\nscene: studio.rib\nground_height: -0.2
camera: {{eye: [1, -4, 1.5], look_at: [0, 0, 0], follow: id < 3}}\nobjects:
  - {{name: boxes, geometry: {{box: {{half: [0.2, 0.1, 0.15]}}}}, color: [0.9, 0.1, 0.1]}}
  - {{name: ways, geometry: {{trail: {{frames: 2}}}}, color: [0.1, 0.6, 0.1]}}
  - {{name: speeds, geometry: {{arrow: {{vector: [vel_x, vel_y, vel_z]}}}}, color: [0.1, 0.1, 0.9]}}
output: {{resolution: [320, 180], samples: [2, 2], shutter: 0.1}}\n"
    );
    let (file, out) = (work.path().join("m.yaml"), work.path().join("o"));
    std::fs::write(&file, text).unwrap();
    scree(&["render", file.to_str().unwrap(), "-f", "2", "-o", out.to_str().unwrap()]).ok();
    image::open(out.join("000002.png")).unwrap().to_rgb8()
}

#[test]
fn turned_data_gives_the_same_image_whatever_axis_is_up() {
    let expected = draw(&AXES[4]);
    for axis in &AXES {
        let image = draw(axis);
        // Orientations are rounded to single precision in other ways.
        let other = image.pixels().zip(expected.pixels()).filter(|(a, b)| (0..3).any(|c| a[c].abs_diff(b[c]) > 3));
        let n = other.count();
        assert!(n < 60, "{}: {n} pixels differ", axis.0);
    }
}

/// The value of a key of a metadata file that stands in a line of its own.
fn value(file: &Path, key: &str) -> Option<String> {
    let text = std::fs::read_to_string(file).unwrap();
    text.lines().find_map(|line| line.strip_prefix(&format!("{key}: "))).map(str::to_string)
}

#[test]
fn runs_stand_against_their_gravity_and_tables_as_they_are_told() {
    let work = scratch();
    let place = |name: &str| work.path().join(name).to_str().unwrap().to_string();
    let model = "step: 0.005\nduration: 0.1\ngravity: [0, -9.81, 0]\nmaterials: {stone: {density: 2600, friction: 0.5}}\nbodies:
  - {name: ground, material: stone, plane: {normal: [0, 1, 0]}}
  - {name: block, material: stone, box: {size: [0.2, 0.4, 0.2]}, position: [0, 0.5, 0]}\n";
    std::fs::write(place("m.yaml"), model).unwrap();
    scree(&["simulate", &place("m.yaml"), "-o", &place("run")]).ok();
    let file = work.path().join("run/metadata.yaml");
    assert_eq!(value(&file, "up").as_deref(), Some("y"));
    let text = std::fs::read_to_string(&file).unwrap();
    assert!(text.contains("ground: true"), "the plane is the ground: {text}");
    scree(&["inspect", &place("run"), "--write", &place("md.yaml")]).ok();
    assert_eq!(value(Path::new(&place("md.yaml")), "up").as_deref(), Some("y"));

    std::fs::write(place("t.csv"), "x,y,z,radius\n0,1,0,0.1\n0,2,0,0.1\n").unwrap();
    scree(&["inspect", &place("t.csv"), "--write", &place("t.yaml"), "--up", "-y"]).ok();
    let file = place("t.yaml");
    assert_eq!(value(Path::new(&file), "up").as_deref(), Some("-y"));
    // What is lowest in the data is 2.1 m below its origin once it is turned.
    let height: f64 = value(Path::new(&file), "ground_height").unwrap().parse().unwrap();
    assert!((-2.2..=-2.1).contains(&height), "{height}");
    let refused = scree(&["inspect", &place("t.csv"), "--write", &place("u.yaml"), "--up", "w"]);
    assert!(refused.fails(2).contains("[possible values: x, y, z, -x, -y, -z]"));
}
