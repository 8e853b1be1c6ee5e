//! The objects of a job: which rows, of what shapes, with which shaders.

use super::data::Table;
use super::job::{Job, Map, list_of, text};
use super::places::Places;
use super::shaders::{settings, shader};
use crate::binding::{Archive, Color, Object, Shape};
use frame::Fault;
use serde_yaml::Value;
use std::path::Path;

/// An object with its formulas as texts.
pub(super) type Drawn = Object<String, String>;

/// What an object is made from.
pub(super) struct Source<'a> {
    pub(super) job: &'a Job<'a>,
    pub(super) table: &'a Table,
    pub(super) places: &'a Places,
    /// Archives that the job brings itself: names and texts.
    pub(super) made: &'a mut Vec<(String, String)>,
}

/// A size: a number, or a column of the data.
enum Size {
    Number(f64),
    Column(String),
}

impl Size {
    /// As the text of an expression.
    fn text(self) -> String {
        match self {
            Size::Number(x) => format!("({x})"),
            Size::Column(name) => name,
        }
    }

    fn number(&self) -> f64 {
        match self {
            Size::Number(x) => *x,
            Size::Column(_) => 0.0,
        }
    }
}

impl Source<'_> {
    /// The objects of an element, the `index`th of its list: one for each of its shapes.
    pub(super) fn objects(&mut self, key: &str, index: usize, value: &Value) -> Result<Vec<Drawn>, Fault> {
        let (job, table) = (self.job, self.table);
        let known = [
            "name",
            "condition",
            "color",
            "geometry",
            "shader",
            "instanced",
            "attribute",
            "script",
            "range",
            "changingparams",
        ];
        let map = job.map(key, value, &known)?;
        if map.contains_key("script") {
            job.no_python(&format!("{key}.script"), "describe the shape as `geometry`, or make a RIB archive");
        }
        job.no_effect(key, &map, &[("range", "`condition` says which rows are drawn")]);
        let takes_sizes = is_true(map.get("changingparams"));
        let name = map.get("name").map(text).unwrap_or(format!("object{index}"));
        let select = map.get("condition").map(text).filter(|c| !c.trim().is_empty());
        let color = match map.get("color") {
            Some(v) => {
                let v = job.numbers(&format!("{key}.color"), v, 3)?;
                [v[0] as f32, v[1] as f32, v[2] as f32]
            }
            None => [0.7, 0.7, 0.7],
        };
        let (mut surface, mut displacement) = (None, None);
        for (k, value) in list_of(&format!("{key}.shader"), map.get("shader")) {
            let shader = shader(job, &k, &value)?;
            let kind = value.get("type").map(text).unwrap_or_default();
            if kind == "displacement" { displacement = Some(shader) } else { surface = Some(shader) }
        }
        let attributes = settings(job, &format!("{key}.attribute"), map.get("attribute"))?;
        let mut shapes = Vec::new();
        for (at, shape) in list_of(&format!("{key}.geometry"), map.get("geometry")) {
            if shape.get("script").is_some() && shape.get("type").is_none() {
                job.no_python(&format!("{at}.script"), "make a RIB archive and use `type: archive`");
                continue;
            }
            shapes.push((None, self.geometry(&at, &shape, takes_sizes)?));
        }
        if shapes.is_empty() && table.is_exported() {
            // Every row says itself what it is.
            shapes = self.exported_shapes(key)?;
        }
        if shapes.is_empty() && (map.contains_key("script") || map.contains_key("geometry")) {
            job.warn(key, "has nothing but scripts to draw it by, and is left out");
            return Ok(vec![]);
        }
        if shapes.is_empty() {
            return Err(job.doc.fault(key, "has no `geometry`"));
        }
        let n = shapes.len();
        let mut out = Vec::new();
        for (k, (own, shape)) in shapes.into_iter().enumerate() {
            let select = match (&select, own) {
                (Some(a), Some(b)) => Some(format!("({a}) and {b}")),
                (a, b) => b.or(a.clone()),
            };
            out.push(Object {
                name: if n == 1 { name.clone() } else { format!("{name}{k}") },
                of_contacts: false,
                select,
                shape,
                position: ["pos_x", "pos_y", "pos_z"].map(String::from),
                orientation: orientation(table.columns.as_deref().unwrap_or_default()),
                velocity: None,
                surface: surface.clone(),
                displacement: displacement.clone(),
                color: Color::Rgb(color),
                opacity: None,
                attributes: attributes.clone(),
                is_ground: false,
            });
        }
        Ok(out)
    }

    /// Conditions and shapes of the types that the rows of an exported table have.
    fn exported_shapes(&self, key: &str) -> Result<Vec<(Option<String>, Shape<String>)>, Fault> {
        let (job, table) = (self.job, self.table);
        let ep = |k: usize| format!("ep{k}");
        let mut shapes: Vec<(Option<String>, Shape<String>)> = [
            ("sphere", Shape::Sphere(ep(1))),
            ("cube", Shape::Box([ep(1), ep(1), ep(1)])),
            ("box", Shape::Box([ep(1), ep(2), ep(3)])),
            ("ellipsoid", Shape::Ellipsoid([ep(1), ep(2), ep(3)])),
            ("cylinder", Shape::Cylinder([ep(1), ep(2)])),
            ("cone", Shape::Cone([ep(1), ep(2)])),
        ]
        .into_iter()
        .map(|(kind, shape)| (Some(format!("type == '{kind}'")), shape))
        .collect();
        // Files of meshes are named in the rows: those of the first frame are taken for all.
        let Some(path) = table.first_file() else { return Ok(shapes) };
        let rows = frame::csv::read(&path, 0, &table.layout(table.delimiter.map(|c| c as u8)))?;
        let mut files: Vec<String> = Vec::new();
        if let (Some(kinds), Some(sizes)) = (rows.column("type"), rows.column("ep1")) {
            for file in (0..rows.rows()).filter(|row| kinds.text(*row) == "obj").map(|row| sizes.text(row)) {
                if !files.contains(&file) {
                    files.push(file);
                }
            }
        }
        for file in files {
            let found = self.places.locate(Path::new(&file));
            let found =
                found.ok_or_else(|| job.doc.fault(key, format!("there is no file `{file}` in the search paths")))?;
            let archive = Shape::Archive(Archive::File(found.to_string_lossy().into_owned()), "(1)".into());
            shapes.push((Some(format!("type == 'obj' and ep1 == '{file}'")), archive));
        }
        Ok(shapes)
    }

    /// The shape of a `geometry`; `takes_sizes` if its object says that the data has its sizes.
    fn geometry(&mut self, key: &str, value: &Value, takes_sizes: bool) -> Result<Shape<String>, Fault> {
        let job = self.job;
        let known = [
            "type",
            "name",
            "radius",
            "side",
            "xlength",
            "ylength",
            "zlength",
            "height",
            "a",
            "b",
            "c",
            "rmajor",
            "rminor",
            "filename",
            "changingparams",
            "dims",
            "script",
            "scale",
        ];
        let map = job.map(key, value, &known)?;
        if map.contains_key("script") {
            job.no_python(&format!("{key}.script"), "make a RIB archive and use `type: archive`");
        }
        let kind = map.get("type").map(text).unwrap_or_default();
        // With `changingparams` the columns ep1, ep2 … have the sizes, in the order of the names here.
        let from_data = takes_sizes || is_true(map.get("changingparams"));
        let idle =
            [("dims", "the sizes are keys of their own, as `radius` of a sphere"), ("scale", "a RIB archive says it")];
        job.no_effect(key, &map, &idle);
        let size = |k: usize, name: &str| -> Result<Size, Fault> {
            if from_data {
                return Ok(Size::Column(format!("ep{k}")));
            }
            match map.get(name) {
                Some(v) => Ok(Size::Number(job.numbers(&format!("{key}.{name}"), v, 1)?[0])),
                None => {
                    // As the original has it.
                    let (line, _) = job.doc.place(key);
                    eprintln!("warning: {}:{line}: the {kind} has no `{name}`: 1 is taken", job.doc.path.display());
                    Ok(Size::Number(1.0))
                }
            }
        };
        let text_of = |k: usize, name: &str| size(k, name).map(Size::text);
        let round = || -> Result<[String; 2], Fault> { Ok([text_of(1, "radius")?, text_of(2, "height")?]) };
        Ok(match kind.as_str() {
            "sphere" => Shape::Sphere(text_of(1, "radius")?),
            "cube" => {
                let half = text_of(1, "side")?;
                Shape::Box([half.clone(), half.clone(), half])
            }
            "box" => Shape::Box([text_of(1, "xlength")?, text_of(2, "ylength")?, text_of(3, "zlength")?]),
            "ellipsoid" => Shape::Ellipsoid([text_of(1, "a")?, text_of(2, "b")?, text_of(3, "c")?]),
            "cone" => Shape::Cone(round()?),
            "cylinder" => Shape::Cylinder(round()?),
            "plane" => Shape::Plane(text_of(1, "side")?),
            "disk" | "torus" if from_data => {
                return Err(job.doc.fault(key, format!("a {kind} cannot take its sizes from the data")));
            }
            "disk" => inline(self.made, format!("Disk 0 {} 360\n", size(1, "radius")?.number())),
            "torus" => {
                let (major, minor) = (size(1, "rmajor")?.number(), size(2, "rminor")?.number());
                inline(self.made, format!("Torus {major} {minor} 0 360 360\n"))
            }
            "archive" | "file" | "delayedarchive" => Shape::Archive(Archive::File(self.file(key, &map)?), "(1)".into()),
            other => {
                let known =
                    ["sphere", "cube", "box", "ellipsoid", "cone", "cylinder", "disk", "torus", "archive", "plane"];
                return Err(job.doc.unknown(&format!("{key}.type"), "geometry", other, &known));
            }
        })
    }

    /// The file of a geometry.
    fn file(&self, key: &str, map: &Map) -> Result<String, Fault> {
        let file = map.get("filename").map(text).unwrap_or_default();
        match self.places.locate(Path::new(&file)) {
            Some(found) => Ok(found.to_string_lossy().into_owned()),
            None => {
                let message = format!("there is no file `{file}` in the search paths");
                Err(self.job.doc.fault(&format!("{key}.filename"), message))
            }
        }
    }
}

/// Whether a key is there and true.
fn is_true(value: Option<&Value>) -> bool {
    value.is_some_and(|v| text(v) == "true")
}

/// An archive of the job's own.
fn inline(made: &mut Vec<(String, String)>, rib: String) -> Shape<String> {
    let name = format!("chronorender_{}.rib", made.len());
    made.push((format!("scenes/{name}"), rib));
    Shape::Archive(Archive::File(name), "(1)".into())
}

/// The quaternion of a row: its own columns, or the angles that the original turns by about x, then y, then z, degrees.
fn orientation(columns: &[String]) -> Option<[String; 4]> {
    let has = |names: &[&str]| names.iter().all(|n| columns.iter().any(|c| c == n));
    if has(&["quat_w", "quat_x", "quat_y", "quat_z"]) || !has(&["euler_x", "euler_y", "euler_z"]) {
        return None;
    }
    let half = |f: &str, axis: &str| format!("{f}(euler_{axis} * {})", std::f64::consts::PI / 360.0);
    let product =
        |fs: [&str; 3]| ["x", "y", "z"].iter().zip(fs).map(|(a, f)| half(f, a)).collect::<Vec<_>>().join(" * ");
    let (c, s) = ("cos", "sin");
    let part = |a: [&str; 3], sign: &str, b: [&str; 3]| format!("{} {sign} {}", product(a), product(b));
    Some([
        part([c, c, c], "-", [s, s, s]),
        part([s, c, c], "+", [c, s, s]),
        part([c, s, c], "-", [s, c, s]),
        part([c, c, s], "+", [s, s, c]),
    ])
}
