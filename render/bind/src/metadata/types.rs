//! The metadata file as types, just as it is written.

use crate::Up;
use crate::binding::Overlays;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// A metadata file.
#[derive(Clone, Debug, Default, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a map")]
pub struct Metadata {
    /// A model file to simulate first, relative to this file's folder; its run directory is then the data.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub model: Option<PathBuf>,
    /// The data.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub data: Option<Data>,
    /// The axis of the data that points up. What is drawn is turned so that it is z, which is up in scenes; camera and `ground_height` belong to
    /// what is turned.
    #[serde(default, skip_serializing_if = "Up::is_z")]
    pub up: Up,
    /// The scene: a RIB file, relative to this file's folder, or the name of a scene of the library.
    #[serde(default = "default_scene")]
    pub scene: String,
    /// The camera, if the scene does not have its own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub camera: Option<CameraSpec>,
    /// A RIB file of lights for the scene's `#scree inject lights`; default lights if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lights: Option<String>,
    /// The height of the scene's own ground, m, where it has one (`#scree ground`); where it is given, scenes without one lay a floor under
    /// data that brings none (`#scree inject floor`).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ground_height: Option<f32>,
    /// The objects to draw.
    pub objects: Vec<Object>,
    /// What is written over the images: title, time, scale bar, legend, axes, plot.
    #[serde(default, skip_serializing_if = "Overlays::is_empty")]
    pub overlays: Overlays,
    /// The images.
    #[serde(default)]
    pub output: Output,
    /// The movie.
    #[serde(default)]
    pub movie: Movie,
}

/// The place of the data, exactly one of `run`, `files` and `csv`, and the operations on each frame.
#[derive(Clone, Debug, Default, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a map")]
pub struct Data {
    /// A run directory.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub run: Option<PathBuf>,
    /// Tables of other programs, told by their content: CSV files, dumps of LAMMPS and LIGGGHTS, files of VTK and ParaView, Parquet
    /// and Arrow files. In the name `*` stands for any characters; the last number in a file's name is its frame number, or the time
    /// step where a dump has several.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub files: Option<PathBuf>,
    /// The same, as metadata files of CSV files have it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub csv: Option<PathBuf>,
    /// Delimiter of cells; detected if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub delimiter: Option<char>,
    /// Whether the first line is a header; detected if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub header: Option<bool>,
    /// Names of the columns, which replace those of a header.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub columns: Option<Vec<String>>,
    /// Minimum count of cells in a row of a CSV file; numbers missing after these are 0. If not given, every row must have all its
    /// cells.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub least_cells: Option<usize>,
    /// The column of CSV files that has the times of rows, where these are of different times: of one body a file, or of all in
    /// one. The rows of a time make a frame, whose number is the place of its time among all; of several files, the column `body`
    /// has the number in the file's name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time: Option<String>,
    /// New names for columns: `old: new`.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub rename: BTreeMap<String, String>,
    /// Derived columns, computed in order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub derive: Vec<Derive>,
    /// Condition on the rows to keep; all rows if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub select: Option<String>,
}

/// A derived column, computed from other columns.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a map")]
pub struct Derive {
    /// Name of the derived column.
    pub column: String,
    /// Expression over the columns of the data and those derived before.
    pub formula: String,
}

/// The camera: a RIB file, or a position and a point to look at.
#[derive(Clone, Debug, Default, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a map")]
pub struct CameraSpec {
    /// A RIB file of camera calls; `{frame}` in its name stands for the frame's number, `{frame:04}` for it with four digits.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// Position of the camera, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub eye: Option<[f32; 3]>,
    /// Point that the camera looks at, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub look_at: Option<[f32; 3]>,
    /// The direction that is up in the image.
    #[serde(default = "default_up")]
    pub up: [f32; 3],
    /// Angle of view across the image's shorter side, degrees.
    #[serde(default = "default_fov")]
    pub fov: f32,
    /// A standard view in parallel projection, `front`, `side` or `top`, instead of `eye`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub view: Option<View>,
    /// Angle per frame, degrees, by which the camera orbits `look_at` about `up`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub orbit: Option<f32>,
    /// Turns about `look_at` in the length of the data, instead of `orbit`: 1 for a turntable whose film is a loop.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub turns: Option<f32>,
    /// Condition on the rows that the camera follows: `eye` and `look_at` are then relative to the mean position of these rows.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub follow: Option<String>,
    /// Number of frames over which the way of what is followed is smoothed, before and after each.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub damping: Option<f64>,
    /// The lens, for depth of field; a pinhole if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lens: Option<Lens>,
    /// Parallel projection: the extent across the image's shorter side, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub orthographic: Option<f32>,
    /// Keyframes, between which the camera goes smoothly.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub keys: Vec<KeySpec>,
    /// Distance of the eyes of a stereo pair, m: the images are those of the left eye, and those of the right eye are in the folder
    /// `right` beside them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stereo: Option<f32>,
}

/// A keyframe of the camera. What it does not give is as in the key before, and in the first as the camera has it.
#[derive(Clone, Debug, Default, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a map")]
pub struct KeySpec {
    /// The frame.
    pub frame: f64,
    /// Position of the camera, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub eye: Option<[f32; 3]>,
    /// Point that the camera looks at, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub look_at: Option<[f32; 3]>,
    /// Angle of view across the image's shorter side, degrees.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fov: Option<f32>,
    /// Whether the camera jumps here instead of going here.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub cut: bool,
}

/// A camera's lens.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a map")]
pub struct Lens {
    /// f-stop: the focal length over the diameter of the aperture.
    pub f_stop: f32,
    /// Focal length, m.
    pub focal_length: f32,
    /// Focal distance, m: the distance at which the image is sharp; if not given, the distance of `look_at`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub focus: Option<f32>,
}

/// A standard view along an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum View {
    /// View towards −x.
    Front,
    /// View towards +y, the side elevation.
    Side,
    /// View towards −z, with y up in the image.
    Top,
}

/// An object: rows of the data, with their geometry and shaders.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a map")]
pub struct Object {
    /// Name of the object, for `#scree inject objects NAME`.
    pub name: String,
    /// What the rows are of: the bodies, or the contacts of a run with contact tables.
    #[serde(default, skip_serializing_if = "RowsOf::is_default")]
    pub rows: RowsOf,
    /// Condition on the object's rows; all rows if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub select: Option<String>,
    /// Geometry drawn at each row.
    pub geometry: Geometry,
    /// Position, m: three columns or expressions.
    #[serde(default = "default_position")]
    pub position: [Quantity; 3],
    /// Orientation as a quaternion w, x, y, z: columns or expressions; if not given, `quat_w` … `quat_z` where the data has them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub orientation: Option<[Quantity; 4]>,
    /// Velocity, m/s, for motion blur: three columns or expressions; if not given, `vel_x`, `vel_y` and `vel_z` where the data has
    /// them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub velocity: Option<[Quantity; 3]>,
    /// Surface shader and its parameters; `matte` if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surface: Option<Shader>,
    /// Displacement shader and its parameters.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub displacement: Option<Shader>,
    /// Colour.
    #[serde(default, skip_serializing_if = "Color::is_default")]
    pub color: Color,
    /// Opacity, 0 to 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub opacity: Option<f32>,
    /// Whether the object is a ground, which is left out in scenes with a ground of their own.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub ground: bool,
}

/// What the rows of an object are of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum RowsOf {
    /// The bodies: the rows of the data.
    #[default]
    Bodies,
    /// The contacts: the rows of the contact table of the frame.
    Contacts,
}

impl RowsOf {
    fn is_default(&self) -> bool {
        *self == RowsOf::default()
    }
}

/// The geometry of an object: exactly one of these.
#[derive(Clone, Debug, Default, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a map")]
pub struct Geometry {
    /// A sphere.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sphere: Option<SphereSpec>,
    /// A box by its half lengths.
    #[serde(default, rename = "box", skip_serializing_if = "Option::is_none")]
    pub block: Option<BoxSpec>,
    /// An ellipsoid by its half axes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ellipsoid: Option<BoxSpec>,
    /// A cylinder about local z.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cylinder: Option<RoundSpec>,
    /// A cylinder about local z with half spheres on its ends.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub capsule: Option<RoundSpec>,
    /// A cone about local z, its tip up and its origin half way up.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cone: Option<RoundSpec>,
    /// A square in the local xy plane.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub plane: Option<PlaneSpec>,
    /// Geometry from a RIB, OBJ, STL or PLY file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub archive: Option<ArchiveSpec>,
    /// An arrow along a vector.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub arrow: Option<ArrowSpec>,
    /// A line through the places where a body has been.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub trail: Option<TrailSpec>,
}

/// An arrow from the position of its row.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a map")]
pub struct ArrowSpec {
    /// The vector, in any unit: three columns or expressions.
    #[serde(default = "default_vector")]
    pub vector: [Quantity; 3],
    /// Length of the arrow of a vector of length 1, m; if not given, the longest of all frames is a fifth of the view.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scale: Option<f64>,
    /// Diameter of the shaft, m; if not given, chosen by the view.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub width: Option<f64>,
}

/// A line through the last places of a body, which are those of the rows of its `id` and `part` in the frames before.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a map")]
pub struct TrailSpec {
    /// Time of the trail, s, for data with times.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub length: Option<f64>,
    /// Number of frames of the trail, instead of `length`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frames: Option<u64>,
    /// Width of the line, m; if not given, chosen by the view.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub width: Option<f64>,
    /// Whether the trail fades towards its end.
    #[serde(default = "yes", skip_serializing_if = "Clone::clone")]
    pub fade: bool,
}

/// The size of a sphere.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a map")]
pub struct SphereSpec {
    /// Radius, m.
    pub radius: Quantity,
}

/// The size of a box or an ellipsoid.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a map")]
pub struct BoxSpec {
    /// Half lengths along the local axes, m.
    pub half: [Quantity; 3],
}

/// The size of a cylinder, a capsule or a cone.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a map")]
pub struct RoundSpec {
    /// Radius, m.
    pub radius: Quantity,
    /// Half the length along local z, m; of a capsule without its half spheres.
    pub half: Quantity,
}

/// The size of a square.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a map")]
pub struct PlaneSpec {
    /// Half the edge, m.
    pub half: Quantity,
}

/// A geometry file, or one for each value of a column, and its scale.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a map")]
pub struct ArchiveSpec {
    /// The RIB, OBJ, STL or PLY file.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// Column whose values tell which of `files`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub column: Option<String>,
    /// Files by values of `column`: words or numbers.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub files: BTreeMap<String, String>,
    /// Scale factor.
    #[serde(default = "one")]
    pub scale: Quantity,
}

/// A quantity: a number, or an expression over columns.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(untagged, expecting = "expected a number or an expression over columns")]
pub enum Quantity {
    /// A number.
    Number(f64),
    /// A column or an expression over columns.
    Expression(String),
}

/// A shader and its parameters.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(expecting = "a map")]
pub struct Shader {
    /// Name of the shader: `gravel` is a file `gravel.sl` beside the metadata, or a shader of the library.
    pub name: String,
    /// Maximum displacement, m (displacement shaders).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bound: Option<f32>,
    /// Whether shadows and rays meet the displaced surface (displacement shaders); if not, they meet it as it was, which is faster.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub traced: Option<bool>,
    /// Values of the shader's parameters, by name.
    #[serde(flatten)]
    pub parameters: BTreeMap<String, Parameter>,
}

/// The value of a shader parameter: a number, three numbers, or text.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(untagged, expecting = "expected a number, three numbers or text")]
pub enum Parameter {
    /// A number.
    Number(f32),
    /// A colour, point or direction.
    Triple([f32; 3]),
    /// Text.
    Text(String),
}

/// A colour: red, green and blue, or a column through a colour map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(untagged, expecting = "expected [red, green, blue] or {column: …, map: …, range: [low, high]}")]
pub enum Color {
    /// Linear red, green and blue.
    Rgb([f32; 3]),
    /// A column through a named colour map.
    Column(ColorBy),
}

/// A column through a named colour map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a map")]
pub struct ColorBy {
    /// Column or expression.
    pub column: Quantity,
    /// Name of the colour map.
    #[serde(default = "default_map")]
    pub map: String,
    /// Values at the two ends of the map; the frame's minimum and maximum if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range: Option<[f64; 2]>,
}

/// The images: resolution, sampling and file format.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default, expecting = "a map")]
pub struct Output {
    /// Width and height of the image, pixels.
    pub resolution: [u32; 2],
    /// Image quality: chooses samples, shading rate and light where these are not given.
    #[serde(skip_serializing_if = "Quality::is_default")]
    pub quality: Quality,
    /// Count of samples along x and y of a pixel; if not given, as the quality says.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub samples: Option<[u32; 2]>,
    /// Shading rate: maximum area of a micropolygon on the raster, pixels; if not given, as the quality says.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shading_rate: Option<f32>,
    /// File format, `png` or `exr`.
    pub format: ImageFormat,
    /// Bits of a colour component: 8 (default) or 16 in a PNG, 16 or 32 (default), both floats, in an EXR.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bits: Option<u32>,
    /// Additional layers of an EXR file: `z`, `N`, `P`, `id`, `motion`, or another variable with its type, such as `color diffuse`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub channels: Vec<String>,
    /// Duration for which the shutter is open, s: moving objects are blurred over the distance that they move in it.
    pub shutter: f64,
    /// Frame list of the frames to draw, as for `-f`; all if not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frames: Option<String>,
    /// Levels of the film: the brightness on the screen, 0 to 1, that becomes nearly black (0.04), and that which becomes nearly white (0.95);
    /// if not given, measured from the first, the middle and the last frame.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub levels: Option<[f64; 2]>,
    /// The pixel filter.
    pub filter: PixelFilter,
}

/// Image quality.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Quality {
    /// Quick, to see where everything is.
    Draft,
    /// For films.
    #[default]
    Normal,
    /// For print.
    Final,
}

impl Quality {
    fn is_default(&self) -> bool {
        *self == Quality::default()
    }
}

/// File format of images.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum ImageFormat {
    /// PNG.
    #[default]
    Png,
    /// OpenEXR, floats.
    Exr,
}

/// The pixel filter: its kind and width.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default, expecting = "a map")]
pub struct PixelFilter {
    /// Kind of the filter: `box`, `triangle`, `gaussian`, `catmull-rom`, `sinc` or `mitchell`.
    pub name: String,
    /// Full width, pixels.
    pub width: f32,
}

/// The movie.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default, expecting = "a map")]
pub struct Movie {
    /// Frame rate, 1/s.
    pub frame_rate: f64,
}

impl Default for Output {
    fn default() -> Output {
        Output {
            resolution: [640, 360],
            quality: Quality::Normal,
            samples: None,
            shading_rate: None,
            shutter: 0.0,
            format: ImageFormat::Png,
            bits: None,
            channels: vec![],
            frames: None,
            levels: None,
            filter: PixelFilter::default(),
        }
    }
}

impl Default for PixelFilter {
    fn default() -> PixelFilter {
        PixelFilter { name: "gaussian".into(), width: 2.0 }
    }
}

impl Default for Movie {
    fn default() -> Movie {
        Movie { frame_rate: 24.0 }
    }
}

impl Color {
    fn is_default(&self) -> bool {
        *self == Color::default()
    }
}

impl Default for Color {
    fn default() -> Color {
        Color::Rgb([0.7, 0.7, 0.7])
    }
}

fn default_scene() -> String {
    "studio.rib".into()
}

fn default_up() -> [f32; 3] {
    [0.0, 0.0, 1.0]
}

fn default_fov() -> f32 {
    35.0
}

fn default_map() -> String {
    "viridis".into()
}

fn yes() -> bool {
    true
}

fn default_vector() -> [Quantity; 3] {
    ["vel_x", "vel_y", "vel_z"].map(|c| Quantity::Expression(c.into()))
}

fn one() -> Quantity {
    Quantity::Number(1.0)
}

fn default_position() -> [Quantity; 3] {
    ["pos_x", "pos_y", "pos_z"].map(|c| Quantity::Expression(c.into()))
}
