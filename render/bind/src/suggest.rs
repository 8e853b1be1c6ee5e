//! A starting metadata file for data that has none: which columns are what, and a camera that sees it all.

mod names;

use crate::expr;
use crate::metadata::{
    ArchiveSpec, BoxSpec, CameraSpec, Color, Data, Geometry, Metadata, Object, Parameter, PlaneSpec, Quantity,
    RoundSpec, Shader, SphereSpec,
};
use frame::{Column, Frame};
use glam::Vec3;
use names::Radius;

fn column(name: &str) -> Quantity {
    Quantity::Expression(expr::quoted(name))
}

/// Metadata for frames of the data, the first and the last, say; or what is missing.
pub fn metadata(data: Data, frames: &[&Frame]) -> Result<Metadata, String> {
    let frame = *frames.first().ok_or("the data has no frames")?;
    let has = |name: &str| names::is_numeric(frame, name);
    let Some(position) = names::position(frame) else {
        return Err(format!(
            "no columns of positions were found (as pos_x, pos_y, pos_z or x, y, z); the data has {}",
            frame.names().join(", ")
        ));
    };
    let radius = names::radius(frame);
    let mut boxes: Vec<[Vec3; 2]> = vec![];
    // A model of nothing but ground is looked at as a whole.
    for ground in [false, true] {
        for frame in frames {
            let place = |row: usize| {
                Vec3::from_array(position.map(|c| frame.column(c).and_then(|c| c.number(row)).unwrap_or(0.0) as f32))
            };
            let looked_at = |row: &usize| if ground { shape(frame, *row) != "plane" } else { !is_ground(frame, *row) };
            for row in (0..frame.rows()).filter(looked_at) {
                let reach = reach(frame, row, radius);
                boxes.extend(place(row).is_finite().then(|| [place(row) - reach, place(row) + reach]));
            }
        }
        if !boxes.is_empty() {
            break;
        }
    }
    let n = boxes.len();
    let [mut lo, mut hi] = extent(&boxes);
    let mut size = rounded((hi - lo).length() / (2.0 * (n as f32).cbrt()));
    if hi == lo {
        // Nothing tells a size: what is there is seen anyway.
        size = 0.1;
        (lo, hi) = (lo - size as f32, hi + size as f32);
    }
    if frames.iter().all(|frame| frame.rows() == 0) {
        return Err("the data has no rows from which a camera could be placed".into());
    }
    if n == 0 || !lo.is_finite() || !hi.is_finite() {
        return Err("the data has no finite positions".into());
    }
    let objects = if has("size_x") && frame.column("shape").is_some() && frame.column("class").is_some() {
        classes(frames, (hi - lo).length())
    } else {
        let radius = radius.map_or(Quantity::Number(size), |r| r.quantity());
        vec![Object {
            position: position.map(column),
            ..object(
                "particles",
                None,
                Geometry { sphere: Some(SphereSpec { radius }), ..Geometry::default() },
                "plastic",
            )
        }]
    };
    Ok(Metadata {
        data: Some(data),
        scene: "studio.rib".into(),
        camera: Some(camera(lo, hi)),
        objects,
        ..Metadata::default()
    })
}

/// The box around boxes; of many, without the few that lie farthest out, as stray grains do.
fn extent(boxes: &[[Vec3; 2]]) -> [Vec3; 2] {
    /// Boxes from which on three in a hundred are left out on each side.
    const MANY: usize = 60;
    let end = |side: usize, axis: usize| {
        let mut x: Vec<f32> = boxes.iter().map(|b| b[side][axis]).collect();
        x.sort_by(f32::total_cmp);
        let skip = if x.len() >= MANY { x.len() * 3 / 100 } else { 0 };
        let k = if side == 0 { skip } else { x.len().saturating_sub(1 + skip) };
        x.get(k).copied().unwrap_or(f32::NAN)
    };
    [0, 1].map(|side| Vec3::new(end(side, 0), end(side, 1), end(side, 2)))
}

/// The shape of a row of a run of ours, or nothing.
fn shape(frame: &Frame, row: usize) -> String {
    match frame.column("shape") {
        Some(c @ Column::Category { .. }) => c.text(row),
        _ => String::new(),
    }
}

fn is_ground(frame: &Frame, row: usize) -> bool {
    let shape = shape(frame, row);
    shape == "plane" || shape.starts_with("height_field")
}

/// Whether a plane's normal is level.
fn upright(frame: &Frame, row: usize) -> bool {
    let number = |name: &str| frame.column(name).and_then(|c| c.number(row)).unwrap_or(0.0) as f32;
    let (x, y) = (number("quat_x"), number("quat_y"));
    // z of the turned z axis.
    1.0 - 2.0 * (x * x + y * y) < 0.5
}

/// Half lengths of the box around a row's shape, as it is turned.
fn reach(frame: &Frame, row: usize, radius: Option<Radius<'_>>) -> Vec3 {
    let number = |name: &str| frame.column(name).and_then(|c| c.number(row)).unwrap_or(0.0) as f32;
    let shape = shape(frame, row);
    if shape.is_empty() || shape == "sphere" {
        let of = |radius: Radius<'_>| number(radius.column) * radius.factor;
        return Vec3::splat(radius.map_or(0.0, of).max(0.0));
    }
    let mut half = Vec3::new(number("size_x"), number("size_y"), number("size_z"));
    if shape == "capsule" {
        half.z += half.x;
    }
    let q = glam::Quat::from_xyzw(number("quat_x"), number("quat_y"), number("quat_z"), number("quat_w"));
    let turn = glam::Mat3::from_quat(if q.length() > 0.0 { q.normalize() } else { glam::Quat::IDENTITY });
    turn.x_axis.abs() * half.x + turn.y_axis.abs() * half.y + turn.z_axis.abs() * half.z
}

/// Colours of what people make, one after the other.
const PAINTS: [[f32; 3]; 6] = [
    [0.26, 0.4, 0.56],
    [0.66, 0.34, 0.2],
    [0.36, 0.46, 0.28],
    [0.6, 0.52, 0.28],
    [0.42, 0.34, 0.48],
    [0.3, 0.46, 0.46],
];

fn object(name: &str, select: Option<String>, geometry: Geometry, surface: &str) -> Object {
    let position = ["pos_x", "pos_y", "pos_z"].map(column);
    let shiny = [("Kd", 0.85), ("Ks", 0.25)].map(|(name, x)| (name.to_string(), Parameter::Number(x)));
    let parameters = if surface == "plastic" { shiny.into_iter().collect() } else { Default::default() };
    let surface = Some(Shader { name: surface.into(), bound: None, parameters });
    Object {
        name: name.into(),
        select,
        geometry,
        position,
        orientation: None,
        velocity: None,
        surface,
        displacement: None,
        color: Color::default(),
        opacity: None,
    }
}

/// One object for each class and shape of a run of ours.
fn classes(frames: &[&Frame], extent: f32) -> Vec<Object> {
    let mut seen: Vec<(String, String)> = Vec::new();
    for frame in frames {
        let (Some(class), Some(shape)) = (frame.column("class"), frame.column("shape")) else { continue };
        for row in 0..frame.rows() {
            let pair = (class.text(row), shape.text(row));
            // Planes that stand upright are walls, which would hide what is behind them.
            if pair.1 == "plane" && upright(frame, row) {
                continue;
            }
            if !seen.contains(&pair) {
                seen.push(pair);
            }
        }
    }
    let static_of = |class: &str| {
        matches!(class, "ground" | "floor" | "wall" | "left" | "right" | "front" | "back" | "beam" | "table")
    };
    let mut names: Vec<&String> = vec![];
    for (class, _) in seen.iter().filter(|(c, s)| !matches!(s.as_str(), "sphere" | "plane") && !static_of(c)) {
        if !names.contains(&class) {
            names.push(class);
        }
    }
    let paint = |class: &String| names.iter().position(|n| *n == class).map(|k| PAINTS[k % PAINTS.len()]);
    seen.iter()
        .map(|(class, shape)| {
            let half = ["size_x", "size_y", "size_z"].map(column);
            let round = || RoundSpec { radius: column("size_x"), half: column("size_z") };
            let (geometry, surface, color) = match shape.as_str() {
                "sphere" => (
                    Geometry { sphere: Some(SphereSpec { radius: column("size_x") }), ..Geometry::default() },
                    "gravel",
                    [0.56, 0.48, 0.4],
                ),
                "box" => {
                    (Geometry { block: Some(BoxSpec { half }), ..Geometry::default() }, "concrete", [0.6, 0.6, 0.58])
                }
                "plane" => {
                    let half = Quantity::Number(rounded(40.0 * extent));
                    (Geometry { plane: Some(PlaneSpec { half }), ..Geometry::default() }, "ground", [0.52, 0.44, 0.33])
                }
                "ellipsoid" => {
                    (Geometry { ellipsoid: Some(BoxSpec { half }), ..Geometry::default() }, "gravel", [0.56, 0.48, 0.4])
                }
                "cylinder" => {
                    (Geometry { cylinder: Some(round()), ..Geometry::default() }, "plastic", [0.5, 0.5, 0.53])
                }
                "capsule" => (Geometry { capsule: Some(round()), ..Geometry::default() }, "plastic", [0.5, 0.5, 0.53]),
                "cone" => (Geometry { cone: Some(round()), ..Geometry::default() }, "plastic", [0.5, 0.5, 0.53]),
                other => {
                    // Hulls, meshes and height fields lie beside the frames as archives.
                    let archive = ArchiveSpec { file: format!("geometry/{other}.rib"), scale: Quantity::Number(1.0) };
                    let ground = other.starts_with("height_field");
                    let (surface, color) =
                        if ground { ("ground", [0.52, 0.44, 0.33]) } else { ("matte", [0.62, 0.62, 0.64]) };
                    (Geometry { archive: Some(archive), ..Geometry::default() }, surface, color)
                }
            };
            let alone = seen.iter().filter(|(c, _)| c == class).count() == 1;
            let name = if alone { class.clone() } else { format!("{class}_{shape}") };
            let select = if alone {
                format!("class == '{class}'")
            } else {
                format!("class == '{class}' and shape == '{shape}'")
            };
            let (surface, color) = match paint(class) {
                Some(paint) if matches!(shape.as_str(), "box" | "cylinder" | "capsule" | "cone") => ("plastic", paint),
                _ => (surface, color),
            };
            Object { color: Color::Rgb(color), ..object(&name, Some(select), geometry, surface) }
        })
        .collect()
}

/// A camera from the front, a little to the side and above, near enough that the box fills the image.
fn camera(lo: Vec3, hi: Vec3) -> CameraSpec {
    /// How much of the image the box may take.
    const FILL: f32 = 0.8;
    let center = 0.5 * (lo + hi);
    let fov = 35.0f32;
    let back = Vec3::new(-0.45, -1.0, 0.5).normalize();
    let right = back.cross(Vec3::Z).normalize() * -1.0;
    let up = back.cross(right);
    let half_height = (fov.to_radians() * 0.5).tan() * FILL;
    let half_width = half_height * 16.0 / 9.0;
    let corner = |k: usize| Vec3::new([lo.x, hi.x][k & 1], [lo.y, hi.y][k >> 1 & 1], [lo.z, hi.z][k >> 2]) - center;
    // A corner at depth d + p·back shows if its offset is at most so many of that depth.
    let needed = |p: Vec3| p.dot(back) + (p.dot(up).abs() / half_height).max(p.dot(right).abs() / half_width);
    let distance = (0..8).map(|k| needed(corner(k))).fold(1e-3, f32::max);
    let eye = center + back * distance;
    CameraSpec {
        eye: Some(eye.to_array().map(|x| rounded(x) as f32)),
        look_at: Some(center.to_array().map(|x| rounded(x) as f32)),
        up: [0.0, 0.0, 1.0],
        fov,
        ..CameraSpec::default()
    }
}

/// Three figures are enough for a start.
fn rounded(x: f32) -> f64 {
    format!("{x:.3e}").parse().unwrap_or(x as f64)
}

/// Metadata as YAML, with a commented line that colours the first object by a column of the frame.
pub fn to_yaml(metadata: &Metadata, frame: &Frame) -> String {
    let yaml = serde_yaml::to_string(metadata).expect("metadata is plain data");
    let head = "# What to draw, found out from the data; change what you like.\n";
    let taken = |name: &str| names::is_position_or_size(frame, name);
    let numeric = |name: &&str| names::is_numeric(frame, name);
    let names = frame.names();
    let by = names.iter().find(|n| **n == "speed").or(names.iter().find(|n| !taken(n) && **n != "id" && numeric(n)));
    let first = metadata.objects.first().map(|o| format!("- name: {}\n", o.name));
    match (by, first) {
        (Some(column), Some(first)) => {
            let quoted = expr::quoted(column);
            // A backtick begins no plain text in YAML.
            let value = if quoted == **column { quoted } else { format!("'{}'", quoted.replace('\'', "''")) };
            let line = format!("{first}  # color: {{column: {value}, map: viridis}}\n");
            format!("{head}{}", yaml.replacen(&first, &line, 1))
        }
        _ => format!("{head}{yaml}"),
    }
}
