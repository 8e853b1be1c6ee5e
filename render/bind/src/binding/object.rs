//! Objects of a binding: rows of the data, with their geometry and shaders.
//!
//! An object is made with its formulas as texts (`Object<String>`), and [`Object::compile`] makes programs of these.

use crate::colormap::{self, Map};
use crate::formula::Formula;
use frame::Fault;
use frame::yaml::Document;
use ri::{Param, Params, Values};

/// An object: rows of the data, with their geometry and shaders. `F` is the type of its formulas: `String` before
/// [`Object::compile`], [`Formula`] after it; `M` is the type of its colour map likewise.
#[derive(Clone, Debug)]
pub struct Object<F = Formula, M = Map> {
    /// Name of the object, for `#scree inject objects NAME`.
    pub name: String,
    /// Whether the rows are the contacts of the frame, instead of those of its table.
    pub of_contacts: bool,
    /// Condition on the object's rows; all rows if not given.
    pub select: Option<F>,
    /// Shape drawn at each row.
    pub shape: Shape<F>,
    /// Position, m.
    pub position: [F; 3],
    /// Orientation as a quaternion w, x, y, z; if not given, the columns `quat_w` … `quat_z` where the data has them.
    pub orientation: Option<[F; 4]>,
    /// Velocity, m/s, for motion blur; if not given, the columns `vel_x`, `vel_y` and `vel_z` where the data has them.
    pub velocity: Option<[F; 3]>,
    /// Surface shader; `matte` if not given.
    pub surface: Option<Shader>,
    /// Displacement shader.
    pub displacement: Option<Shader>,
    /// Colour.
    pub color: Color<F, M>,
    /// Opacity, 0 to 1.
    pub opacity: Option<f32>,
    /// Attributes by their groups, as `visibility`.
    pub attributes: Vec<(String, Params)>,
    /// Whether the object is the ground, which is left out in scenes with a ground of their own (`#scree ground`).
    pub is_ground: bool,
}

/// The shape drawn at a row; lengths in m.
#[derive(Clone, Debug)]
pub enum Shape<F = Formula> {
    /// A sphere by its radius.
    Sphere(F),
    /// A box by its half lengths along the local axes.
    Box([F; 3]),
    /// An ellipsoid by its half axes.
    Ellipsoid([F; 3]),
    /// A cylinder about local z, by its radius and half its length.
    Cylinder([F; 2]),
    /// A cylinder about local z with half spheres on its ends, by its radius and half its length without these.
    Capsule([F; 2]),
    /// A cone about local z, its tip up and its origin half way up, by its radius and half its height.
    Cone([F; 2]),
    /// A square in the local xy plane, by half its edge.
    Plane(F),
    /// Geometry from files, and its scale factor.
    Archive(Archive, F),
    /// An arrow along a vector.
    Arrow(Arrow<F>),
    /// A line through the last places of a body.
    Trail(Trail),
}

/// An arrow from the position of its row.
#[derive(Clone, Debug)]
pub struct Arrow<F = Formula> {
    /// The vector.
    pub vector: [F; 3],
    /// Length of the arrow of a vector of length 1, m; chosen by the longest vector and the view if not given.
    pub scale: Option<f64>,
    /// Diameter of the shaft, m; chosen by the view if not given.
    pub width: Option<f64>,
}

/// A line through the last places of a body.
#[derive(Clone, Copy, Debug)]
pub struct Trail {
    /// How far it goes back.
    pub reach: Reach,
    /// Width of the line, m; chosen by the view if not given.
    pub width: Option<f64>,
    /// Whether it fades towards its end.
    pub fade: bool,
}

/// How far a trail goes back.
#[derive(Clone, Copy, Debug)]
pub enum Reach {
    /// Seconds.
    Time(f64),
    /// Frames.
    Frames(u64),
}

/// RIB files or meshes (OBJ, STL, PLY).
#[derive(Clone, Debug)]
pub enum Archive {
    /// A file for all rows.
    File(String),
    /// A file for each value of a column: a word, or the text of a number.
    ByColumn {
        /// The column.
        column: String,
        /// Values and files.
        files: Vec<(String, String)>,
    },
}

/// A colour: constant, or a value of each row through a colour map.
#[derive(Clone, Debug)]
pub enum Color<F = Formula, M = Map> {
    /// Linear red, green and blue.
    Rgb([f32; 3]),
    /// The value of each row through a colour map.
    By {
        /// The value.
        value: F,
        /// The colour map.
        map: M,
        /// Values at the two ends of the map; the frame's minimum and maximum if not given.
        range: Option<[f64; 2]>,
    },
}

/// A shader and its parameters.
#[derive(Clone, Debug)]
pub struct Shader {
    /// Name of the shader: `gravel` is a file `gravel.sl` beside the file, or a shader of the library.
    pub name: String,
    /// Maximum displacement, m (displacement shaders).
    pub bound: Option<f32>,
    /// Whether rays meet what it displaces (displacement shaders).
    pub traced: bool,
    /// Parameters of the shader, with their values.
    pub params: Params,
}

impl Object<String, String> {
    /// Check the object, which has index `i` in the file, and compile its formulas. An error is at the key of the first bad value.
    pub fn compile(self, doc: &Document, i: usize) -> Result<Object, Fault> {
        let key = format!("objects.{i}");
        let color = match self.color {
            Color::Rgb(rgb) if rgb.iter().all(|x| x.is_finite()) => Color::Rgb(rgb),
            Color::Rgb(_) => {
                return Err(doc.fault(&format!("{key}.color"), "is not finite, expected red, green and blue"));
            }
            Color::By { value, map, range } => {
                let found = colormap::named(&map)
                    .ok_or_else(|| doc.unknown(&format!("{key}.color.map"), "colour map", &map, &colormap::names()))?;
                // The larger value first turns the map round.
                if range.is_some_and(|[a, b]| !(a.is_finite() && b.is_finite() && a != b)) {
                    return Err(doc.fault(&format!("{key}.color.range"), "expected two different numbers"));
                }
                Color::By { value, map: found, range }
            }
        };
        if self.opacity.is_some_and(|o| !(0.0..=1.0).contains(&o)) {
            return Err(doc.fault(&format!("{key}.opacity"), "expected a number from 0 to 1"));
        }
        for (part, shader) in [("surface", &self.surface), ("displacement", &self.displacement)] {
            let is_finite =
                |param: &Param| !matches!(&param.values, Values::Floats(v) if v.iter().any(|x| !x.is_finite()));
            let params = shader.iter().flat_map(|s| &s.params);
            if let Some(param) = params.into_iter().find(|param| !is_finite(param)) {
                let name = &param.decl.name;
                return Err(doc.fault(&format!("{key}.{part}.{name}"), format!("`{name}` is not finite")));
            }
        }
        let compile = |part: &str, text: String| Formula::compile(doc, format!("{key}.{part}"), &text);
        Ok(Object {
            name: self.name,
            of_contacts: self.of_contacts,
            select: self.select.map(|text| compile("select", text)).transpose()?,
            shape: self.shape.compile(&compile)?,
            position: each("position", self.position, &compile)?,
            velocity: self.velocity.map(|texts| each("velocity", texts, &compile)).transpose()?,
            orientation: self.orientation.map(|texts| each("orientation", texts, &compile)).transpose()?,
            color: match color {
                Color::Rgb(rgb) => Color::Rgb(rgb),
                Color::By { value, map, range } => Color::By { value: compile("color.column", value)?, map, range },
            },
            surface: self.surface,
            displacement: self.displacement,
            opacity: self.opacity,
            attributes: self.attributes,
            is_ground: self.is_ground,
        })
    }
}

/// Compile texts that stand in a list.
fn each<const N: usize>(
    part: &str,
    texts: [String; N],
    compile: &dyn Fn(&str, String) -> Result<Formula, Fault>,
) -> Result<[Formula; N], Fault> {
    let mut all = Vec::with_capacity(N);
    for (k, text) in texts.into_iter().enumerate() {
        all.push(compile(&format!("{part}.{k}"), text)?);
    }
    Ok(all.try_into().expect("as many formulas as texts"))
}

impl Shape<String> {
    fn compile(self, compile: &dyn Fn(&str, String) -> Result<Formula, Fault>) -> Result<Shape, Fault> {
        let round = |shape: &str, [radius, half]: [String; 2]| -> Result<[Formula; 2], Fault> {
            let part = |name: &str| format!("geometry.{shape}.{name}");
            Ok([compile(&part("radius"), radius)?, compile(&part("half"), half)?])
        };
        Ok(match self {
            Shape::Sphere(radius) => Shape::Sphere(compile("geometry.sphere.radius", radius)?),
            Shape::Box(half) => Shape::Box(each("geometry.box.half", half, compile)?),
            Shape::Ellipsoid(half) => Shape::Ellipsoid(each("geometry.ellipsoid.half", half, compile)?),
            Shape::Cylinder(size) => Shape::Cylinder(round("cylinder", size)?),
            Shape::Capsule(size) => Shape::Capsule(round("capsule", size)?),
            Shape::Cone(size) => Shape::Cone(round("cone", size)?),
            Shape::Plane(half) => Shape::Plane(compile("geometry.plane.half", half)?),
            Shape::Archive(file, scale) => Shape::Archive(file, compile("geometry.archive.scale", scale)?),
            Shape::Arrow(Arrow { vector, scale, width }) => {
                Shape::Arrow(Arrow { vector: each("geometry.arrow.vector", vector, compile)?, scale, width })
            }
            Shape::Trail(trail) => Shape::Trail(trail),
        })
    }
}

impl Object {
    /// Whether what it looks like depends on values of all frames: on the range of its colours, or on its longest arrow.
    pub fn is_open(&self) -> bool {
        matches!(self.color, Color::By { range: None, .. })
            || matches!(self.shape, Shape::Arrow(Arrow { scale: None, .. }))
    }

    /// All formulas of the object, in the order in which faults in them are reported.
    pub fn formulas(&self) -> Vec<&Formula> {
        let mut all: Vec<&Formula> = self.select.iter().collect();
        match &self.shape {
            Shape::Sphere(x) | Shape::Plane(x) | Shape::Archive(_, x) => all.push(x),
            Shape::Box(half) | Shape::Ellipsoid(half) => all.extend(half),
            Shape::Cylinder(size) | Shape::Capsule(size) | Shape::Cone(size) => all.extend(size),
            Shape::Arrow(arrow) => all.extend(&arrow.vector),
            Shape::Trail(_) => {}
        }
        all.extend(&self.position);
        all.extend(self.velocity.iter().flatten());
        all.extend(self.orientation.iter().flatten());
        if let Color::By { value, .. } = &self.color {
            all.push(value);
        }
        all
    }
}
