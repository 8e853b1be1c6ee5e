//! A first metadata file for data that has none: columns are recognised by their names, and the camera is placed to see all rows.

mod framing;
mod names;

use crate::expr;
use crate::metadata::{
    ArchiveSpec, BoxSpec, Color, Data, Geometry, Metadata, Object, Parameter, PlaneSpec, Quantity, RoundSpec, Shader,
    SphereSpec,
};
use frame::{Column, Frame};
use framing::rounded;

fn column(name: &str) -> Quantity {
    Quantity::Expression(expr::quoted(name))
}

/// Frames of the data from which metadata is suggested, evenly spread from the first to the last; fewer if a frame has many rows.
pub fn sample(frames: &[u64], n_rows: usize) -> Vec<u64> {
    /// Rows to read in all.
    const ROWS: usize = 1 << 21;
    let n = (ROWS / n_rows.max(1)).clamp(4, 24).min(frames.len());
    (0..n).map(|k| frames[k * (frames.len() - 1) / (n - 1).max(1)]).collect()
}

/// Suggest metadata for data, from some of its frames (such as the first and the last). An error if there is no frame, or if no
/// columns of positions are recognised.
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
    if frames.iter().all(|frame| frame.rows() == 0) {
        return Err("the data has no rows from which a camera could be placed".into());
    }
    let framing::Extent { mut lo, mut hi, n_rows } =
        framing::extent(frames, position, radius).ok_or("the data has no finite positions")?;
    let is_ours = has("half_x") && frame.column("shape").is_some() && frame.column("class").is_some();
    // Where no column tells a radius, that of spheres which would fill the box; where they are all in one place, any.
    let size = if hi == lo { 0.1 } else { rounded((hi - lo).length() / (2.0 * (n_rows as f32).cbrt())) };
    if hi == lo || (radius.is_none() && !is_ours) {
        (lo, hi) = (lo - size as f32, hi + size as f32);
    }
    let objects = if is_ours {
        let containers = framing::containers(frames, position, radius);
        classes(frames, &containers, (hi - lo).length())
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
        camera: Some(framing::camera(lo, hi)),
        objects,
        ..Metadata::default()
    })
}

/// Whether a plane is a wall: its normal is level.
fn is_wall(frame: &Frame, row: usize) -> bool {
    normal_z(frame, row) < 0.5
}

/// Vertical part of a plane's normal.
fn normal_z(frame: &Frame, row: usize) -> f32 {
    let number = |name: &str| frame.column(name).and_then(|c| c.number(row)).unwrap_or(0.0) as f32;
    let (x, y) = (number("quat_x"), number("quat_y"));
    1.0 - 2.0 * (x * x + y * y)
}

/// Whether all planes of a class are the ground z = 0, which many scenes have themselves.
fn is_ground(frames: &[&Frame], class: &str) -> bool {
    let mut rows = frames.iter().flat_map(|frame| (0..frame.rows()).map(move |row| (frame, row)));
    let is_of = |frame: &Frame, row: usize, column: &str, name: &str| matches!(frame.column(column), Some(Column::Category { codes, names }) if names[codes[row] as usize] == name);
    rows.all(|(frame, row)| {
        let height = frame.column("pos_z").and_then(|c| c.number(row)).unwrap_or(0.0);
        let is_plane = is_of(frame, row, "shape", "plane") && is_of(frame, row, "class", class);
        !is_plane || is_wall(frame, row) || (height.abs() < 1e-3 && normal_z(frame, row) > 0.999_999)
    })
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
        ground: false,
    }
}

/// One object for each class and shape of a run of ours.
fn classes(frames: &[&Frame], containers: &[String], extent: f32) -> Vec<Object> {
    let mut seen: Vec<(String, String)> = Vec::new();
    for frame in frames {
        let (Some(class), Some(shape)) = (frame.column("class"), frame.column("shape")) else { continue };
        for row in 0..frame.rows() {
            let pair = (class.text(row), shape.text(row));
            // Planes that stand upright are walls, which would hide what is behind them.
            if pair.1 == "plane" && is_wall(frame, row) {
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
            let half = ["half_x", "half_y", "half_z"].map(column);
            let round = || RoundSpec { radius: column("half_x"), half: column("half_z") };
            let (geometry, surface, color) = match shape.as_str() {
                "sphere" => (
                    Geometry { sphere: Some(SphereSpec { radius: column("half_x") }), ..Geometry::default() },
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
            let ground = shape == "plane" && is_ground(frames, class);
            // Seen through once from the front and once behind, the content is still clear.
            let opacity = containers.contains(class).then_some(0.25);
            Object { color: Color::Rgb(color), ground, opacity, ..object(&name, Some(select), geometry, surface) }
        })
        .collect()
}

/// Write metadata as YAML, with a line, commented out, that colours the first object by a column of the frame.
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
