//! The metadata file as types, just as it is written.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// A metadata file.
#[derive(Clone, Debug, Default, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a map")]
pub struct Metadata {
    /// A model to simulate first; its run directory is then the data. From this file's folder.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub model: Option<PathBuf>,
    /// Where the data is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub data: Option<Data>,
    /// The scene: a RIB file from this file's folder, or one of the library's.
    #[serde(default = "default_scene")]
    pub scene: String,
    /// The camera.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub camera: Option<CameraSpec>,
    /// A RIB file of lights for the scene's `#scree inject lights`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lights: Option<String>,
    /// What is drawn.
    pub objects: Vec<Object>,
    /// Images.
    #[serde(default)]
    pub output: Output,
    /// The movie.
    #[serde(default)]
    pub movie: Movie,
}

/// Where the data is: exactly one of `run` and `csv`.
#[derive(Clone, Debug, Default, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a map")]
pub struct Data {
    /// A run directory.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub run: Option<PathBuf>,
    /// CSV files, `*` standing for any characters; the last number in a file's name is its frame.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub csv: Option<PathBuf>,
    /// The character between cells, if it should not be detected.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub delimiter: Option<char>,
    /// Whether the first line names the columns, if it should not be detected.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub header: Option<bool>,
    /// Column names, which go before those of a header.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub columns: Option<Vec<String>>,
    /// Cells that every row of a CSV file has at least; what is missing after them is 0. Without it, rows have all their cells.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub least_cells: Option<usize>,
    /// New names for columns: `old: new`.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub rename: BTreeMap<String, String>,
    /// Columns computed from others, one after the other.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub derive: Vec<Derive>,
    /// Which rows there are at all: a condition on columns.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub select: Option<String>,
}

/// A column computed from others.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a map")]
pub struct Derive {
    /// Its name.
    pub column: String,
    /// An expression over the columns before it.
    pub formula: String,
}

/// The camera: a RIB file, or a place and a point to look at.
#[derive(Clone, Debug, Default, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a map")]
pub struct CameraSpec {
    /// A RIB file of camera calls; `{frame}` in its name stands for the frame's number, `{frame:04}` for it with four digits.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// Where it stands, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub eye: Option<[f32; 3]>,
    /// What it looks at, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub look_at: Option<[f32; 3]>,
    /// The direction that is up in the image.
    #[serde(default = "default_up")]
    pub up: [f32; 3],
    /// Angle of view across the shorter side, degrees.
    #[serde(default = "default_fov")]
    pub fov: f32,
    /// Instead of `eye`: straight from the `front`, the `side` or the `top`, in parallel projection.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub view: Option<View>,
    /// Degrees a frame by which it goes around what it looks at, about `up`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub orbit: Option<f32>,
    /// Rows that it goes with: `eye` and `look_at` are then from the middle of these.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub follow: Option<String>,
    /// A lens: what is not where it is sharp is blurred. Without it all is sharp.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lens: Option<Lens>,
    /// Parallel projection, this many metres across the shorter side.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub orthographic: Option<f32>,
}

/// A camera's lens.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a map")]
pub struct Lens {
    /// f-stop: the focal length over the width of the opening.
    pub f_stop: f32,
    /// Focal length, m.
    pub focal_length: f32,
    /// How far away it is sharp, m; if not given, as far as what the camera looks at.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub focus: Option<f32>,
}

/// A straight view.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum View {
    /// Towards −x.
    Front,
    /// Towards y: the side elevation.
    Side,
    /// Towards −z, y up in the image.
    Top,
}

/// Rows of the data, and what they look like.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a map")]
pub struct Object {
    /// Name, for `#scree inject objects NAME`.
    pub name: String,
    /// Which rows: a condition on columns; all if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub select: Option<String>,
    /// What stands at each row.
    pub geometry: Geometry,
    /// Three columns or expressions, m.
    #[serde(default = "default_position")]
    pub position: [Quantity; 3],
    /// The quaternion's w, x, y, z: columns or expressions. If not given: quat_w … quat_z where the data has them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub orientation: Option<[Quantity; 4]>,
    /// Three columns or expressions, m/s, for motion blur. If not given: vel_x, vel_y, vel_z where the data has them.
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
}

/// Geometry: exactly one of these.
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
    /// Geometry from a RIB archive, drawn at every row.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub archive: Option<ArchiveSpec>,
}

/// A sphere's size.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a map")]
pub struct SphereSpec {
    /// Radius, m.
    pub radius: Quantity,
}

/// Half lengths.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a map")]
pub struct BoxSpec {
    /// Along the local axes, m.
    pub half: [Quantity; 3],
}

/// The size of a cylinder, a capsule or a cone.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a map")]
pub struct RoundSpec {
    /// Radius, m.
    pub radius: Quantity,
    /// Half its length along z, m; of a capsule without its round ends.
    pub half: Quantity,
}

/// A square.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a map")]
pub struct PlaneSpec {
    /// Half its edge, m.
    pub half: Quantity,
}

/// An archive.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a map")]
pub struct ArchiveSpec {
    /// The RIB file.
    pub file: String,
    /// Scale.
    #[serde(default = "one")]
    pub scale: Quantity,
}

/// A number, or an expression over columns.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(untagged, expecting = "expected a number or an expression over columns")]
pub enum Quantity {
    /// A number.
    Number(f64),
    /// An expression.
    Expression(String),
}

/// A shader and its parameters.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(expecting = "a map")]
pub struct Shader {
    /// Its name: `gravel` is the library's or a file `gravel.sl` beside the metadata.
    pub name: String,
    /// Maximum displacement, m (displacement shaders).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bound: Option<f32>,
    /// Its parameters by name.
    #[serde(flatten)]
    pub parameters: BTreeMap<String, Parameter>,
}

/// A shader parameter: a number, three numbers, or text.
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

/// Colour: red, green, blue, or a column through a map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(untagged, expecting = "expected [red, green, blue] or {column: …, map: …, range: [low, high]}")]
pub enum Color {
    /// Linear red, green and blue.
    Rgb([f32; 3]),
    /// A column through a named map.
    Column(ColorBy),
}

/// A column through a named map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a map")]
pub struct ColorBy {
    /// Column or expression.
    pub column: Quantity,
    /// The map.
    #[serde(default = "default_map")]
    pub map: String,
    /// Values at the map's ends; of the frame's own range if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range: Option<[f64; 2]>,
}

/// Images.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default, expecting = "a map")]
pub struct Output {
    /// Pixels along x and y.
    pub resolution: [u32; 2],
    /// Samples along x and y of a pixel.
    pub samples: [u32; 2],
    /// Pixels a micropolygon.
    pub shading_rate: f32,
    /// `png` or `exr`.
    pub format: ImageFormat,
    /// Bits of a colour: 8 or 16 in a PNG, 16 or 32, both floats, in an EXR; 8 and 32 if not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bits: Option<u32>,
    /// What else goes into an EXR, each a layer of it: `z`, `N`, `P`, `id`, `motion`, or another variable with its type, such as
    /// `color diffuse`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub channels: Vec<String>,
    /// How long the shutter is open, s: what moves is blurred by as far as it comes in that time.
    pub shutter: f64,
    /// Frames to draw, as for `-f`; all if not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frames: Option<String>,
    /// Pixel filter.
    pub filter: PixelFilter,
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

/// Pixel filter.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default, expecting = "a map")]
pub struct PixelFilter {
    /// box, triangle, gaussian, catmull-rom, sinc or mitchell.
    pub name: String,
    /// Width, pixels.
    pub width: f32,
}

/// The movie.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default, expecting = "a map")]
pub struct Movie {
    /// Images a second.
    pub frame_rate: f64,
}

impl Default for Output {
    fn default() -> Output {
        Output {
            resolution: [640, 360],
            samples: [4, 4],
            shading_rate: 1.0,
            shutter: 0.0,
            format: ImageFormat::Png,
            bits: None,
            channels: vec![],
            frames: None,
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

fn one() -> Quantity {
    Quantity::Number(1.0)
}

fn default_position() -> [Quantity; 3] {
    ["pos_x", "pos_y", "pos_z"].map(|c| Quantity::Expression(c.into()))
}
