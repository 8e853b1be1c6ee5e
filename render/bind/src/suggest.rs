//! A first metadata file for data that has none: columns are recognised by their names, and the camera is placed to see all rows.

mod columns;
mod framing;
mod inside;
mod lengths;
mod motion;
mod names;
mod survey;

use crate::Up;
use crate::expr;
use crate::metadata::{
    ArchiveSpec, BoxSpec, CameraSpec, Color, ColorBy, Data, Geometry, Metadata, Movie, Object, Parameter, PlaneSpec,
    Quantity, RoundSpec, RowsOf, Shader, SphereSpec,
};
use frame::{Column, Frame};
use framing::{Classes, MANY, Subject, rounded};
use lengths::Length;
use names::Names;
use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};
use survey::{Kind, Survey};

fn column(name: &str) -> Quantity {
    Quantity::Expression(expr::quoted(name))
}

/// The columns of orientations that need not be named.
const STANDARD_TURN: [&str; 4] = ["quat_w", "quat_x", "quat_y", "quat_z"];
/// The columns of velocities that need not be named, with their unit, m/s.
const STANDARD_MOTION: [(&str, f64); 3] = [("vel_x", 1.0), ("vel_y", 1.0), ("vel_z", 1.0)];
/// The colour of ground.
const GROUND: [f32; 3] = [0.33, 0.272, 0.206];

/// Frames of the data from which metadata is suggested, evenly spread from the first to the last; fewer if a frame has many rows.
pub fn sample(frames: &[u64], n_rows: usize) -> Vec<u64> {
    /// Rows to read in all.
    const ROWS: usize = 1 << 21;
    let n = (ROWS / n_rows.max(1)).clamp(4, 24).min(frames.len());
    (0..n).map(|k| frames[k * (frames.len() - 1) / (n - 1).max(1)]).collect()
}

/// Metadata suggested for data.
pub struct Suggestion {
    /// The metadata file's text.
    pub yaml: String,
    /// What had to be guessed or converted, in a sentence each.
    pub remarks: Vec<String>,
}

/// Suggest metadata for data, from some of its frames (such as the first and the last) and the axis that points up in it. An error if there
/// is no frame, or if no columns of positions are recognised.
pub fn metadata(data: Data, frames: &[Frame], up: Up) -> Result<Suggestion, String> {
    let some = frames.iter().find(|frame| frame.rows() > 0);
    let frame = some.ok_or("the data has no rows from which a camera could be placed")?;
    let has = |name: &str| columns::is_numeric(frame, name);
    let is_ours = has("half_x") && frame.column("shape").is_some() && frame.column("class").is_some();
    let (mut names, mut remarks) = Names::of(frame)?;
    if is_ours {
        // Our own tables are drawn as they are, in metres.
        names.position.iter_mut().for_each(|length| length.origin = 0.0);
        remarks.clear();
    }
    let surveys: Vec<Survey> = frames.iter().map(|frame| Survey::of(frame, &names, up)).collect();
    let classes = Classes::of(&surveys);
    let containers = classes.containers();
    let [mut lo, mut hi] =
        framing::extent(&surveys, &classes, &containers).ok_or("the data has no finite positions")?;
    let is_guessed = names.radius.is_none() && !is_ours;
    let spacing = if is_guessed { framing::radius_by_spacing(&surveys, [lo, hi]) } else { None };
    let size = spacing.map_or(0.1, rounded);
    if hi == lo || is_guessed {
        (lo, hi) = (lo - size as f32, hi + size as f32);
    }
    let kinds = kinds(&surveys);
    let ground_height =
        if is_ours { ground_height(&surveys, &kinds, lo.z, hi.z) } else { floor_height(lo.z, (hi - lo).max_element()) };
    let camera = match classes.subject(&containers, [lo, hi]).filter(|_| is_ours) {
        Some(Subject { class, lo, hi }) => {
            CameraSpec { follow: Some(format!("class == '{class}'")), ..framing::camera(lo, hi) }
        }
        None => framing::camera(lo, hi),
    };
    let objects = if is_ours {
        kinds_as_objects(&kinds, up, &classes.moving(), &containers, [ground_height, (hi - lo).length()])
    } else {
        let radius = names.radius.map_or(Quantity::Number(size), |r| r.quantity());
        vec![Object {
            position: names.position.map(|p| p.quantity()),
            orientation: names.orientation.filter(|q| *q != STANDARD_TURN).map(|q| q.map(column)),
            velocity: names
                .velocity
                .filter(|v| v.map(|v| (v.column, v.factor)) != STANDARD_MOTION)
                .map(|v| v.map(Length::quantity)),
            color: Color::Rgb([0.38, 0.29, 0.21]),
            ..object(
                "particles",
                None,
                Geometry { sphere: Some(SphereSpec { radius }), ..Geometry::default() },
                "plastic",
            )
        }]
    };
    let has_ground = objects
        .iter()
        .any(|object| object.ground || object.surface.as_ref().is_some_and(|surface| surface.name == "ground"));
    let metadata = Metadata {
        data: Some(data),
        up,
        // What brings no ground stands, or floats, over a floor under the lowest of it.
        scene: if has_ground { "studio.rib" } else { "seamless.rib" }.into(),
        camera: Some(camera),
        // A floor lies under what brings no ground, whatever scene it is put in.
        ground_height: Some(ground_height).filter(|z| !has_ground || *z != 0.0),
        objects,
        movie: if is_ours { Movie { frame_rate: real_time(frames) } } else { Movie::default() },
        ..Metadata::default()
    };
    if let Some((radius, apart)) = framing::too_large(&surveys).filter(|_| !is_ours && names.radius.is_some()) {
        remarks.push(format!(
            "the usual radius, {radius} m, is more than the rows lie apart at most, {apart} m: is it in the unit of the positions?"
        ));
    }
    if is_guessed {
        let from = if spacing.is_some() { " from the distances between the rows" } else { "" };
        remarks.push(format!("no column tells a radius: {size} m is guessed{from}"));
    }
    if !is_ours {
        remarks.extend(names.unused(frame));
    }
    Ok(Suggestion { yaml: to_yaml(&metadata, frame, &remarks), remarks })
}

/// The rate at which a movie of all frames of a run goes on as time does, where that is one of movies; else the usual one.
fn real_time(frames: &[Frame]) -> f64 {
    let usual = Movie::default().frame_rate;
    let (Some(first), Some(last)) = (frames.first(), frames.last()) else { return usual };
    let rate = (last.number - first.number) as f64 / (last.time - first.time);
    // Frames are taken at the ends of steps.
    let rate = if (rate - rate.round()).abs() < 0.02 * rate { rate.round() } else { (rate * 100.0).round() / 100.0 };
    if (4.0..=120.0).contains(&rate) { rate } else { usual }
}

/// Colours of what people make, one after the other: those of Okabe and Ito (2008), which the colour-blind tell apart, linear and a little
/// paler.
const PAINTS: [[f32; 3]; 6] = [
    [0.03, 0.18, 0.42],
    [0.62, 0.13, 0.03],
    [0.03, 0.33, 0.18],
    [0.75, 0.6, 0.08],
    [0.12, 0.42, 0.72],
    [0.55, 0.2, 0.36],
];

/// Parameters of a shader that are numbers.
fn number_of<const N: usize>(values: [(&str, f32); N]) -> BTreeMap<String, Parameter> {
    values.map(|(name, x)| (name.to_string(), Parameter::Number(x))).into_iter().collect()
}

/// Draw spheres, the largest of which has this radius, as stones within them, each of a shade of its own.
fn become_stones(object: &mut Object, radius: f32) {
    /// Deepest that a stone of the library is cut, over its radius.
    const CUT: f32 = 0.37;
    let bound = Some(rounded(CUT * radius) as f32);
    object.displacement =
        Some(Shader { name: "stone".into(), bound, traced: Some(false), parameters: BTreeMap::new() });
    let size = rounded(0.5 * radius) as f32;
    object.surface = object.surface.take().map(|shader| Shader { parameters: number_of([("size", size)]), ..shader });
    let by = ColorBy {
        column: Quantity::Expression("id * 0.618 % 1".into()),
        map: "stone".into(),
        range: Some([-0.2, 0.9]),
    };
    object.color = Color::Column(by);
}

fn object(name: &str, select: Option<String>, geometry: Geometry, surface: &str) -> Object {
    let position = ["pos_x", "pos_y", "pos_z"].map(column);
    let shiny = || number_of([("Kd", 0.85), ("Ks", 0.25)]);
    let parameters = if surface == "plastic" { shiny() } else { BTreeMap::new() };
    let surface = Some(Shader { name: surface.into(), bound: None, traced: None, parameters });
    Object {
        name: name.into(),
        rows: RowsOf::default(),
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

/// The classes and shapes of all frames; the shapes alone, with no name of a class, where there are very many classes, as of bodies that
/// have names each.
fn kinds<'a>(surveys: &[Survey<'a>]) -> Vec<Kind<'a>> {
    /// Classes and shapes that are objects of their own at most.
    const MOST: usize = 500;
    let by_class = merged(surveys.iter().flat_map(|survey| &survey.kinds).cloned(), Kind::merge);
    let shapes_of = |survey: &Survey<'a>| {
        let nameless = survey.kinds.iter().map(|kind| Kind { class: "", ..kind.clone() });
        merged(nameless, Kind::add_all)
    };
    if by_class.len() <= MOST { by_class } else { merged(surveys.iter().flat_map(shapes_of), Kind::merge) }
}

/// Kinds without doubles, in the order of the first of each; `merge` puts another of the same class and shape into it.
fn merged<'a>(kinds: impl Iterator<Item = Kind<'a>>, merge: fn(&mut Kind<'a>, &Kind<'a>)) -> Vec<Kind<'a>> {
    let (mut all, mut place): (Vec<Kind<'_>>, BTreeMap<(&str, &str), usize>) = Default::default();
    for kind in kinds {
        match place.entry((kind.class, kind.shape)) {
            Entry::Occupied(before) => merge(&mut all[*before.get()], &kind),
            Entry::Vacant(new) => {
                new.insert(all.len());
                all.push(kind);
            }
        }
    }
    all
}

/// The height at which a scene may have a ground of its own, m: that of the lowest level plane, or below terrain, or else below what
/// would stand under z = 0. `lo` and `hi` are the heights of the things.
fn ground_height(surveys: &[Survey<'_>], kinds: &[Kind<'_>], lo: f32, hi: f32) -> f32 {
    /// A gap below terrain, over the height of what is seen.
    const GAP: f32 = 0.02;
    let planes = kinds.iter().filter_map(|kind| kind.levels.map(|[level, _]| level)).reduce(f32::min);
    let terrain = surveys.iter().flat_map(|survey| &survey.terrain).map(|t| t.lo.z).reduce(f32::min);
    let below = terrain.map(|z| z - GAP * (hi - z).max(hi - lo));
    let height = match (planes, below.map(|z| rounded(z) as f32)) {
        (Some(plane), Some(below)) => plane.min(below),
        (plane, below) => plane.or(below).unwrap_or(rounded(lo.min(0.0)) as f32),
    };
    if height.abs() < 1e-3 { 0.0 } else { height }
}

/// The height of a floor right under the lowest thing, m, with few digits; 0 where that is nearly it.
fn floor_height(lo: f32, extent: f32) -> f32 {
    let step = 10f32.powi((1e-2 * extent).max(f32::MIN_POSITIVE).log10().floor() as i32);
    let height = rounded((lo / step).floor() * step) as f32;
    if !height.is_finite() || height.abs() < 0.5 * step { 0.0 } else { height.min(lo) }
}

/// The geometry of a shape of ours, and what it is made of if it is not painted: its surface and colour.
fn look(shape: &str, extent: f32) -> (Geometry, &'static str, [f32; 3]) {
    let half = ["half_x", "half_y", "half_z"].map(column);
    let round = || RoundSpec { radius: column("half_x"), half: column("half_z") };
    match shape {
        "sphere" => (
            Geometry { sphere: Some(SphereSpec { radius: column("half_x") }), ..Geometry::default() },
            "gravel",
            [0.56, 0.48, 0.4],
        ),
        "box" => (Geometry { block: Some(BoxSpec { half }), ..Geometry::default() }, "concrete", [0.52, 0.52, 0.5]),
        "plane" => {
            let half = Quantity::Number(rounded(40.0 * extent));
            (Geometry { plane: Some(PlaneSpec { half }), ..Geometry::default() }, "ground", GROUND)
        }
        "ellipsoid" => {
            (Geometry { ellipsoid: Some(BoxSpec { half }), ..Geometry::default() }, "gravel", [0.56, 0.48, 0.4])
        }
        "cylinder" => (Geometry { cylinder: Some(round()), ..Geometry::default() }, "plastic", [0.5, 0.5, 0.53]),
        "spring" => (Geometry { cylinder: Some(round()), ..Geometry::default() }, "plastic", [0.85, 0.62, 0.16]),
        "capsule" => (Geometry { capsule: Some(round()), ..Geometry::default() }, "plastic", [0.5, 0.5, 0.53]),
        "cone" => (Geometry { cone: Some(round()), ..Geometry::default() }, "plastic", [0.5, 0.5, 0.53]),
        other => {
            // Hulls, meshes and height fields lie beside the frames as archives.
            let archive = ArchiveSpec {
                file: Some(format!("geometry/{other}.rib")),
                column: None,
                files: Default::default(),
                scale: Quantity::Number(1.0),
            };
            let ground = other.starts_with("height_field");
            let (surface, color) = if ground { ("ground", GROUND) } else { ("matte", [0.62, 0.62, 0.64]) };
            (Geometry { archive: Some(archive), ..Geometry::default() }, surface, color)
        }
    }
}

/// One object for each class and shape of a run of ours; the height of its ground and its extent are in metres.
fn kinds_as_objects(
    kinds: &[Kind<'_>],
    up: Up,
    moving: &BTreeSet<&str>,
    containers: &BTreeSet<&str>,
    [ground_height, extent]: [f32; 2],
) -> Vec<Object> {
    // Walls would hide what is behind them.
    let drawn = || kinds.iter().filter(|kind| kind.has_others);
    // What stands is not painted: the eye goes to what moves.
    let static_of = |class: &str| {
        matches!(class, "ground" | "floor" | "wall" | "left" | "right" | "front" | "back" | "beam" | "table")
            || !moving.is_empty() && !moving.contains(class)
    };
    let mut paints: BTreeMap<&str, usize> = BTreeMap::new();
    for kind in drawn().filter(|k| !matches!(k.shape, "sphere" | "plane" | "spring") && !static_of(k.class)) {
        let next = paints.len();
        paints.entry(kind.class).or_insert(next);
    }
    let paint = |class: &str| paints.get(class).map(|k| PAINTS[k % PAINTS.len()]);
    let mut shapes: BTreeMap<&str, usize> = BTreeMap::new();
    kinds.iter().for_each(|kind| *shapes.entry(kind.class).or_default() += 1);
    drawn()
        .map(|kind| {
            let Kind { class, shape, .. } = *kind;
            let (geometry, surface, color) = look(shape, extent);
            let alone = shapes[class] == 1;
            let (name, mut select) = match (class, alone) {
                ("", _) => (shape.to_string(), format!("shape == '{shape}'")),
                (_, true) => (class.to_string(), format!("class == '{class}'")),
                (_, false) => (format!("{class}_{shape}"), format!("class == '{class}' and shape == '{shape}'")),
            };
            if kind.has_walls {
                select += &format!(" and {}", up.is_upright());
            }
            let (surface, color) = match paint(class) {
                Some(paint) if matches!(shape, "box" | "cylinder" | "capsule" | "cone") => ("paintedmetal", paint),
                _ => (surface, color),
            };
            let ground = kind.is_level_at(ground_height);
            // Seen through once from the front and once behind, the content is still clear; what is not painted is as glass.
            let is_container = containers.contains(class);
            let is_glass = is_container && surface == "concrete";
            let (surface, opacity) = match (is_glass, is_container) {
                (true, _) => ("pane", Some(0.12)),
                (_, true) => (surface, Some(0.25)),
                _ => (surface, None),
            };
            let mut object =
                Object { color: Color::Rgb(color), ground, opacity, ..object(&name, Some(select), geometry, surface) };
            if shape == "sphere" && kind.count >= MANY {
                become_stones(&mut object, kind.largest);
            }
            if let Some(shader) = object.surface.as_mut().filter(|shader| shader.name == "paintedmetal") {
                let size = rounded(0.1 * extent) as f32;
                shader.parameters = number_of([("wear", 0.1), ("size", size)]);
            }
            object
        })
        .collect()
}

/// Write metadata as YAML, with remarks, and a comment that colours the first object by a column of the frame: behind its colour, or a line
/// of its own.
fn to_yaml(metadata: &Metadata, frame: &Frame, remarks: &[String]) -> String {
    let yaml = serde_yaml::to_string(metadata).expect("metadata is plain data");
    let mut head = "# What to draw, found out from the data; change what you like.\n".to_string();
    remarks.iter().for_each(|remark| head += &format!("# {}.\n", guard::text::line(remark)));
    let taken = |name: &str| names::is_position_or_size(frame, name);
    let numeric = |name: &&str| columns::is_numeric(frame, name);
    let names = frame.names();
    // What is measured rather than counted, and varies: ids and types tell little as colours.
    let varies = |column: &Column| column.range().is_some_and(|(lo, hi)| lo < hi);
    let is_measured =
        |name: &&&str| frame.column(name).is_some_and(|c| matches!(c, Column::F32(_) | Column::F64(_)) && varies(c));
    let others = || names.iter().filter(|n| !taken(n) && **n != "id" && numeric(n));
    let by = names
        .iter()
        .find(|n| ["speed", "absv"].contains(*n))
        .or_else(|| others().find(is_measured))
        .or_else(|| others().next());
    let first = metadata.objects.first().map(|o| format!("- name: {}\n", o.name));
    match (by, first) {
        (Some(column), Some(first)) => {
            let quoted = expr::quoted(column);
            // A backtick begins no plain text in YAML.
            let value = if quoted == **column { quoted } else { format!("'{}'", quoted.replace('\'', "''")) };
            let by_column = guard::text::line(&format!("{{column: {value}, map: viridis}}"));
            let block = |[r, g, b]: [f32; 3]| format!("  color:\n  - {r:?}\n  - {g:?}\n  - {b:?}\n");
            let yaml = match metadata.objects[0].color {
                Color::Rgb(rgb) if yaml.contains(&block(rgb)) => {
                    yaml.replacen(&block(rgb), &format!("  color: {rgb:?} # or {by_column}\n"), 1)
                }
                // The colour by default is not written.
                _ => yaml.replacen(&first, &format!("{first}  # color: {by_column}\n"), 1),
            };
            format!("{head}{yaml}")
        }
        _ => format!("{head}{yaml}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use frame::yaml;
    use std::path::Path;

    /// A frame of a run: bodies with class, shape, place and half lengths.
    fn run(number: u64, bodies: &[(&str, &str, [f32; 3], f32)]) -> Frame {
        let mut frame = Frame::new(number, number as f64 / 24.0);
        let words = |of: &dyn Fn(&(&str, &str, [f32; 3], f32)) -> String| {
            let mut names: Vec<String> = vec![];
            let codes = bodies.iter().map(|body| {
                let name = of(body);
                let at = names.iter().position(|n| *n == name).unwrap_or_else(|| {
                    names.push(name);
                    names.len() - 1
                });
                at as u32
            });
            let codes = codes.collect();
            Column::Category { codes, names }
        };
        frame.push("class", "", words(&|body| body.0.to_string()));
        frame.push("shape", "", words(&|body| body.1.to_string()));
        frame.push("id", "", Column::I64((0..bodies.len() as i64).collect()));
        for (axis, name) in ["pos_x", "pos_y", "pos_z"].into_iter().enumerate() {
            frame.push(name, "m", Column::F64(bodies.iter().map(|body| body.2[axis] as f64).collect()));
        }
        for name in ["half_x", "half_y", "half_z"] {
            frame.push(name, "m", Column::F64(bodies.iter().map(|body| body.3 as f64).collect()));
        }
        frame
    }

    /// The objects that are suggested for a run in which `grains` spheres of each of two classes, the second of one sphere less, fall upon a
    /// fixed block beside a box that moves.
    fn objects(grains: usize) -> BTreeMap<String, Object> {
        let frames: Vec<Frame> = (0..3)
            .map(|k| {
                let fallen = -0.3 * k as f32;
                let grain =
                    |class, n: usize| (0..n).map(move |i| (class, "sphere", [0.2 * i as f32, 0.0, 2.0 + fallen], 0.05));
                let mut all = vec![
                    ("ground", "plane", [0.0; 3], 0.0),
                    ("block", "box", [1.0, 0.0, 0.25], 0.25),
                    ("cart", "box", [0.5 * k as f32, 1.0, 0.2], 0.2),
                ];
                all.extend(grain("stones", grains).chain(grain("balls", grains - 1)));
                run(k, &all)
            })
            .collect();
        let suggestion = metadata(Data::default(), &frames, Up::Z).unwrap();
        let (read, _) = yaml::parse::<Metadata>(Path::new("m.yaml"), suggestion.yaml).unwrap();
        read.objects.into_iter().map(|object| (object.name.clone(), object)).collect()
    }

    #[test]
    fn many_spheres_are_stones_and_what_moves_is_painted() {
        let objects = objects(MANY);
        let surface = |name: &str| objects[name].surface.as_ref().unwrap().name.as_str();
        let stones = &objects["stones"];
        let stone = stones.displacement.as_ref().expect("as many spheres as grains are stones");
        assert_eq!((stone.name.as_str(), stone.traced), ("stone", Some(false)));
        let bound = stone.bound.unwrap();
        assert!(bound > 0.0 && bound < 0.05, "cut by {bound} m within a radius of 0.05 m");
        assert!(matches!(&stones.color, Color::Column(by) if by.map == "stone"), "each of a shade of its own");
        assert!(
            objects["balls"].displacement.is_none() && matches!(objects["balls"].color, Color::Rgb(_)),
            "few are balls"
        );
        assert_eq!([surface("stones"), surface("balls")], ["gravel"; 2]);
        assert_eq!([surface("cart"), surface("block")], ["paintedmetal", "concrete"], "what moves is painted");
        let rgb = |name: &str| match objects[name].color {
            Color::Rgb(rgb) => rgb,
            _ => panic!("{name} has one colour"),
        };
        assert!(rgb("cart") == PAINTS[0] && !PAINTS.contains(&rgb("block")));
    }

    /// Bodies that have names each are classes of their own: where there are very many of these, shapes are objects.
    #[test]
    fn very_many_classes_are_drawn_by_their_shapes() {
        let names: Vec<String> = (0..600).map(|k| format!("b{k}")).collect();
        let bodies = |n: usize| {
            let body = |(k, name)| (name, if k % 2 == 0 { "sphere" } else { "box" }, [0.2 * k as f32, 0.0, 1.0], 0.05);
            names.iter().map(String::as_str).take(n).enumerate().map(body).collect::<Vec<_>>()
        };
        let suggested = |n: usize| metadata(Data::default(), &[run(0, &bodies(n))], Up::Z).unwrap().yaml;
        let yaml = suggested(600);
        assert!(yaml.contains("select: shape == 'sphere'") && yaml.contains("select: shape == 'box'"), "{yaml}");
        assert!(yaml.matches("- name: ").count() == 2 && yaml.contains("name: stone"), "{yaml}");
        assert_eq!(suggested(500).matches("- name: ").count(), 500);
    }

    #[test]
    fn tables_have_a_floor_right_under_them() {
        let mut frame = Frame::new(0, 0.0);
        for (name, column) in [("x", [0.0, 1.0]), ("y", [0.0, 0.5]), ("z", [0.75, 1.0]), ("radius", [0.25, 0.25])] {
            frame.push(name, "m", Column::F64(column.to_vec()));
        }
        let suggestion = metadata(Data::default(), &[frame], Up::Z).unwrap();
        let (read, _) = yaml::parse::<Metadata>(Path::new("m.yaml"), suggestion.yaml).unwrap();
        let height = read.ground_height.expect("a floor");
        assert!(height <= 0.5 && height > 0.4, "{height} m under spheres that reach down to 0.5 m");
    }
}
