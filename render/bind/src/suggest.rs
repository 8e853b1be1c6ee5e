//! A starting metadata file for data that has none: which columns are what, and a camera that sees it all.

use crate::metadata::{
    ArchiveSpec, BoxSpec, CameraSpec, Color, Data, Geometry, Metadata, Object, Parameter, PlaneSpec, Quantity, Shader,
    SphereSpec,
};
use frame::{Column, Frame};
use glam::Vec3;

/// Names that columns of positions go by, in the usual tools.
const POSITIONS: [[&str; 3]; 5] =
    [["pos_x", "pos_y", "pos_z"], ["x", "y", "z"], ["X", "Y", "Z"], ["px", "py", "pz"], ["c1", "c2", "c3"]];

/// Names that a radius goes by.
const RADII: [&str; 6] = ["radius", "r", "R", "rad", "size_x", "c4"];

fn column(name: &str) -> Quantity {
    Quantity::Expression(name.into())
}

/// Metadata for a frame of the data, or what is missing.
pub fn metadata(data: Data, frame: &Frame) -> Result<Metadata, String> {
    let has = |name: &str| frame.column(name).is_some_and(|c| !matches!(c, Column::Category { .. }));
    let Some(position) = POSITIONS.iter().find(|p| p.iter().all(|c| has(c))) else {
        return Err(format!(
            "no columns of positions were found (as pos_x, pos_y, pos_z or x, y, z); the data has {}",
            frame.names().join(", ")
        ));
    };
    let place = |row: usize| {
        Vec3::from_array(position.map(|c| frame.column(c).and_then(|c| c.number(row)).unwrap_or(0.0) as f32))
    };
    let radius = RADII.iter().find(|c| has(c));
    let size = |row: usize| radius.and_then(|r| frame.column(r)).and_then(|c| c.number(row)).unwrap_or(0.0) as f32;
    let rows: Vec<usize> = (0..frame.rows()).filter(|row| !is_plane(frame, *row)).collect();
    let (mut lo, mut hi) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for row in &rows {
        lo = lo.min(place(*row) - size(*row));
        hi = hi.max(place(*row) + size(*row));
    }
    if rows.is_empty() || !lo.is_finite() || !hi.is_finite() {
        return Err("the data has no finite positions".into());
    }
    let objects = if has("size_x") && frame.column("shape").is_some() && frame.column("class").is_some() {
        classes(frame, (hi - lo).length())
    } else {
        let radius = radius.map_or_else(
            || Quantity::Number(rounded((hi - lo).length() / (2.0 * (rows.len() as f32).cbrt()))),
            |r| column(r),
        );
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

fn is_plane(frame: &Frame, row: usize) -> bool {
    matches!(frame.column("shape"), Some(c @ Column::Category { .. }) if c.text(row) == "plane")
}

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
        surface,
        displacement: None,
        color: Color::default(),
        opacity: None,
    }
}

/// One object for each class and shape of a run of ours.
fn classes(frame: &Frame, extent: f32) -> Vec<Object> {
    let (Some(class), Some(shape)) = (frame.column("class"), frame.column("shape")) else { return vec![] };
    let mut seen: Vec<(String, String)> = Vec::new();
    for row in 0..frame.rows() {
        let pair = (class.text(row), shape.text(row));
        if !seen.contains(&pair) {
            seen.push(pair);
        }
    }
    seen.iter()
        .map(|(class, shape)| {
            let half = ["size_x", "size_y", "size_z"].map(column);
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
                other => (
                    Geometry {
                        archive: Some(ArchiveSpec { file: format!("{other}.rib"), scale: Quantity::Number(1.0) }),
                        ..Geometry::default()
                    },
                    "matte",
                    [0.7; 3],
                ),
            };
            let alone = seen.iter().filter(|(c, _)| c == class).count() == 1;
            let name = if alone { class.clone() } else { format!("{class}_{shape}") };
            let select = if alone {
                format!("class == '{class}'")
            } else {
                format!("class == '{class}' and shape == '{shape}'")
            };
            Object { color: Color::Rgb(color), ..object(&name, Some(select), geometry, surface) }
        })
        .collect()
}

/// A camera from the front, a little to the side and above, near enough that the box fills the picture.
fn camera(lo: Vec3, hi: Vec3) -> CameraSpec {
    /// How much of the picture the box may take.
    const FILL: f32 = 0.85;
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
    let taken = |name: &str| POSITIONS.iter().flatten().chain(&RADII).any(|n| *n == name);
    let numeric = |name: &&str| frame.column(name).is_some_and(|c| !matches!(c, Column::Category { .. }));
    let names = frame.names();
    let by = names.iter().find(|n| **n == "speed").or(names.iter().find(|n| !taken(n) && **n != "id" && numeric(n)));
    let first = metadata.objects.first().map(|o| format!("- name: {}\n", o.name));
    match (by, first) {
        (Some(column), Some(first)) => {
            let line = format!("{first}  # color: {{column: {column}, map: viridis}}\n");
            format!("{head}{}", yaml.replacen(&first, &line, 1))
        }
        _ => format!("{head}{yaml}"),
    }
}
