//! The metadata file as types, checked.

use crate::chronorender;
use crate::data::{Source, Store};
use crate::expr::{Expr, ExprError};
use frame::csv::Layout;
use frame::yaml::Document;
use frame::{Fault, Frame, nearest, run, sequence};
use ri::files::Files;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A metadata file.
#[derive(Clone, Debug, Default, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
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
    /// Pictures.
    #[serde(default)]
    pub output: Output,
    /// The movie.
    #[serde(default)]
    pub movie: Movie,
}

/// Where the data is: exactly one of `run` and `csv`.
#[derive(Clone, Debug, Default, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Data {
    /// A run directory.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub run: Option<PathBuf>,
    /// CSV files, `*` standing for any characters; the last number in a file's name is its frame.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub csv: Option<PathBuf>,
    /// The character between cells, if it should not be found out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub delimiter: Option<char>,
    /// Whether the first line names the columns, if it should not be found out.
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
    /// Columns worked out of others, one after the other.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub derive: Vec<Derive>,
    /// Which rows there are at all: a condition on columns.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub select: Option<String>,
}

impl Data {
    /// How CSV files are laid out, as far as it says.
    pub(crate) fn layout(&self) -> Layout {
        Layout {
            delimiter: self.delimiter.map(|c| c as u8),
            header: self.header,
            names: self.columns.clone(),
            least: self.least_cells,
        }
    }
}

/// A column worked out of others.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Derive {
    /// Its name.
    pub column: String,
    /// An expression over the columns before it.
    pub formula: String,
}

/// The camera: a RIB file, or a place and a point to look at.
#[derive(Clone, Debug, Default, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
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
    /// The direction that is up in the picture.
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
#[serde(deny_unknown_fields)]
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
    /// Towards −z, y up in the picture.
    Top,
}

impl CameraSpec {
    /// Eye, what it looks at, and what is up, before it goes anywhere.
    pub fn place(&self) -> ([f32; 3], [f32; 3], [f32; 3]) {
        let at = self.look_at.unwrap_or_default();
        let (way, up) = match self.view {
            Some(View::Front) => ([100.0, 0.0, 0.0], [0.0, 0.0, 1.0]),
            Some(View::Side) => ([0.0, -100.0, 0.0], [0.0, 0.0, 1.0]),
            Some(View::Top) => ([0.0, 0.0, 100.0], [0.0, 1.0, 0.0]),
            None => return (self.eye.unwrap_or_default(), at, self.up),
        };
        ([0, 1, 2].map(|k| at[k] + way[k]), at, up)
    }
}

/// Rows of the data, and what they look like.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
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
#[serde(deny_unknown_fields)]
pub struct Geometry {
    /// A ball.
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
    /// A cylinder about local z with half balls on its ends.
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

/// A ball's size.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SphereSpec {
    /// Radius, m.
    pub radius: Quantity,
}

/// Half lengths.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct BoxSpec {
    /// Along the local axes, m.
    pub half: [Quantity; 3],
}

/// The size of a cylinder, a capsule or a cone.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RoundSpec {
    /// Radius, m.
    pub radius: Quantity,
    /// Half its length along z, m; of a capsule without its round ends.
    pub half: Quantity,
}

/// A square.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlaneSpec {
    /// Half its edge, m.
    pub half: Quantity,
}

/// An archive.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
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
pub struct Shader {
    /// Its name: `gravel` is the library's or a file `gravel.sl` beside the metadata.
    pub name: String,
    /// Greatest displacement, m (displacement shaders).
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
#[serde(deny_unknown_fields)]
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

/// Pictures.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
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

/// Picture files.
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
#[serde(deny_unknown_fields, default)]
pub struct PixelFilter {
    /// box, triangle, gaussian, catmull-rom, sinc or mitchell.
    pub name: String,
    /// Width, pixels.
    pub width: f32,
}

/// The movie.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Movie {
    /// Pictures a second.
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

impl Quantity {
    /// As an expression.
    pub fn expr(&self) -> Result<Expr, crate::expr::ExprError> {
        match self {
            Quantity::Number(x) => Expr::parse(&format!("({x})")),
            Quantity::Expression(text) => Expr::parse(text),
        }
    }
}

/// A metadata file and its text, so that faults found later still have their place.
#[derive(Clone, Debug)]
pub struct Checked {
    /// What it says.
    pub metadata: Metadata,
    /// Where it says it.
    pub doc: Document,
    /// Files that it brings itself: names and texts.
    pub made: Vec<(String, String)>,
    /// Folders to look in besides its own.
    pub folders: Vec<PathBuf>,
    /// Other pictures of the same data, by the names of the folders that they go to.
    pub passes: Vec<(String, Checked)>,
}

/// Read and check a metadata file.
pub fn read(path: &Path) -> Result<Checked, Fault> {
    let (any, doc): (serde_yaml::Value, Document) = frame::yaml::read(path)?;
    if let Some(job) = any.get(chronorender::ROOT) {
        let checked = chronorender::translate(job, doc)?;
        checked.check()?;
        return Ok(checked);
    }
    let (metadata, doc) = frame::yaml::read(path)?;
    check(metadata, doc)
}

/// Check a metadata file that was read.
pub fn check(metadata: Metadata, doc: Document) -> Result<Checked, Fault> {
    let checked = Checked { metadata, doc, made: vec![], folders: vec![], passes: vec![] };
    checked.check()?;
    Ok(checked)
}

impl Checked {
    fn check(&self) -> Result<(), Fault> {
        self.check_output()?;
        self.processes()?;
        self.metadata.objects.iter().enumerate().try_for_each(|(i, object)| self.check_object(i, object))?;
        self.passes.iter().try_for_each(|(_, pass)| pass.check())
    }

    /// A search path that also has what the file brings itself.
    pub fn files(&self, mut files: Files) -> Files {
        for (name, text) in &self.made {
            // A handful of texts for the program's whole life.
            files.built_in.push((Box::leak(name.clone().into_boxed_str()), Box::leak(text.clone().into_boxed_str())));
        }
        files.folders.extend(self.folders.iter().cloned());
        files
    }

    /// The folder that relative paths start from.
    pub fn folder(&self) -> PathBuf {
        self.doc.path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new(".")).into()
    }

    /// Open the data that it names.
    pub fn open_data(&self) -> Result<Source, Fault> {
        let Some(data) = &self.metadata.data else {
            return Err(self.doc.fault("data", "names no data: expected `data: {run: …}` or `data: {csv: …}`"));
        };
        let store = match (&data.run, &data.csv) {
            (Some(folder), None) => Store::Run(run::RunReader::open(&self.folder().join(folder))?),
            (None, Some(pattern)) => {
                let files = sequence::find(&self.folder().join(pattern))?;
                Store::Csv { files, layout: data.layout(), rename: data.rename.clone() }
            }
            _ => return Err(self.doc.fault("data", "needs exactly one of `run` and `csv`")),
        };
        let (derive, select) = self.processes()?;
        Ok(Source { store, derive, select })
    }

    /// Derived columns and the condition of the data, parsed.
    fn processes(&self) -> Result<(Vec<(String, Expr)>, Option<Expr>), Fault> {
        let Some(data) = &self.metadata.data else { return Ok((vec![], None)) };
        let parse = |key: String, text: &str| Expr::parse(text).map_err(|e| self.in_expression(&key, &e));
        let derived = data.derive.iter().enumerate();
        let derive = derived
            .map(|(k, d)| Ok((d.column.clone(), parse(format!("data.derive.{k}.formula"), &d.formula)?)))
            .collect::<Result<_, Fault>>()?;
        let select = data.select.as_ref().map(|text| parse("data.select".into(), text)).transpose()?;
        Ok((derive, select))
    }

    fn check_output(&self) -> Result<(), Fault> {
        let (m, doc) = (&self.metadata, &self.doc);
        let o = &m.output;
        if o.resolution.iter().any(|n| !(1..=65_536).contains(n)) {
            return Err(doc.fault("output.resolution", "expected two numbers from 1 to 65536"));
        }
        if o.resolution[0] as u64 * o.resolution[1] as u64 > 1 << 28 {
            return Err(doc.fault("output.resolution", "expected at most 268 million pixels"));
        }
        if o.samples.iter().any(|n| !(1..=64).contains(n)) {
            return Err(doc.fault("output.samples", "expected two numbers from 1 to 64"));
        }
        if !(o.shading_rate > 0.0 && o.shading_rate.is_finite()) {
            return Err(doc.fault("output.shading_rate", "expected a number above 0"));
        }
        if !(o.shutter >= 0.0 && o.shutter.is_finite()) {
            return Err(doc.fault("output.shutter", "expected seconds, 0 or more"));
        }
        let bits = if o.format == ImageFormat::Exr { [16, 32] } else { [8, 16] };
        if let Some(given) = o.bits.filter(|given| !bits.contains(given)) {
            let [few, many] = bits;
            return Err(doc.fault("output.bits", format!("is {given}, expected {few} or {many}")));
        }
        if !o.channels.is_empty() && o.format != ImageFormat::Exr {
            return Err(doc.fault("output.channels", "needs `format: exr`: no other file has layers"));
        }
        let filters = ["box", "triangle", "gaussian", "catmull-rom", "sinc", "mitchell"];
        if !filters.contains(&o.filter.name.as_str()) {
            return Err(doc.unknown("output.filter.name", "filter", &o.filter.name, &filters));
        }
        if !(1.0..=16.0).contains(&o.filter.width) {
            return Err(doc.fault("output.filter.width", "expected 1 to 16 pixels"));
        }
        if !(m.movie.frame_rate > 0.0 && m.movie.frame_rate <= 1000.0) {
            return Err(doc.fault("movie.frame_rate", "expected a number above 0 and at most 1000"));
        }
        if let Some(data) = &m.data
            && data.delimiter.is_some_and(|c| !c.is_ascii())
        {
            return Err(doc.fault("data.delimiter", "expected one ASCII character"));
        }
        if let Some(c) = &m.camera {
            if c.file.is_none() && c.view.is_none() && (c.eye.is_none() || c.look_at.is_none()) {
                return Err(doc.fault("camera", "needs `eye` and `look_at`, a `view`, or a `file`"));
            }
            if c.view.is_some() && c.orthographic.is_none() {
                return Err(doc.fault("camera.view", "needs `orthographic`: how many metres the picture shows"));
            }
            if c.view.is_some() && c.eye.is_some() {
                return Err(doc.fault("camera.view", "stands instead of `eye`, not beside it"));
            }
            if c.file.is_some() && (c.orbit.is_some() || c.follow.is_some() || c.view.is_some()) {
                return Err(doc.fault("camera", "a camera from a file stays as the file has it"));
            }
            if let Some(lens) = &c.lens {
                if c.file.is_some() || c.orthographic.is_some() {
                    return Err(doc.fault("camera.lens", "belongs to a camera with `eye` and `look_at` in perspective"));
                }
                let numbers = [
                    ("f_stop", lens.f_stop),
                    ("focal_length", lens.focal_length),
                    ("focus", lens.focus.unwrap_or(1.0)),
                ];
                if let Some((name, _)) = numbers.iter().find(|(_, x)| !(*x > 0.0 && x.is_finite())) {
                    return Err(doc.fault(&format!("camera.lens.{name}"), "expected a number above 0"));
                }
            }
            if c.orbit.is_some_and(|o| !o.is_finite()) {
                return Err(doc.fault("camera.orbit", "expected degrees a frame"));
            }
            if !(c.fov > 0.0 && c.fov < 179.0) {
                return Err(
                    doc.fault("camera.fov", format!("is {}, expected an angle between 0 and 179 degrees", c.fov))
                );
            }
            if c.file.is_none() {
                let (eye, at, up) = c.place();
                let way = glam::Vec3::from(at) - glam::Vec3::from(eye);
                if !(way.cross(up.into()).length() > 0.0) {
                    return Err(doc.fault("camera", "cannot look along `up`, nor at the place where it stands"));
                }
            }
        }
        if m.objects.is_empty() {
            return Err(doc.fault("objects", "draws nothing: expected at least one object"));
        }
        Ok(())
    }

    fn check_object(&self, i: usize, object: &Object) -> Result<(), Fault> {
        let key = format!("objects.{i}");
        let g = &object.geometry;
        let count = [
            g.sphere.is_some(),
            g.block.is_some(),
            g.ellipsoid.is_some(),
            g.cylinder.is_some(),
            g.capsule.is_some(),
            g.cone.is_some(),
            g.plane.is_some(),
            g.archive.is_some(),
        ];
        if count.iter().filter(|x| **x).count() != 1 {
            return Err(self.doc.fault(
                &format!("{key}.geometry"),
                "needs exactly one of `sphere`, `box`, `ellipsoid`, `cylinder`, `capsule`, `cone`, `plane` and `archive`",
            ));
        }
        if let Color::Column(by) = &object.color {
            let maps = crate::colormap::names();
            if !maps.contains(&by.map.as_str()) {
                return Err(self.doc.unknown(&format!("{key}.color.map"), "colour map", &by.map, &maps));
            }
            if by.range.is_some_and(|[lo, hi]| !(hi > lo)) {
                return Err(self.doc.fault(&format!("{key}.color.range"), "expected a smaller and a larger number"));
            }
        }
        if object.opacity.is_some_and(|o| !(0.0..=1.0).contains(&o)) {
            return Err(self.doc.fault(&format!("{key}.opacity"), "expected a number from 0 to 1"));
        }
        self.expressions(i).map(|_| ())
    }

    /// All expressions of an object with the keys where they stand, parsed.
    fn expressions(&self, i: usize) -> Result<Vec<(String, Expr)>, Fault> {
        let object = &self.metadata.objects[i];
        let key = format!("objects.{i}");
        let mut list: Vec<(String, Quantity)> = Vec::new();
        if let Some(select) = &object.select {
            list.push((format!("{key}.select"), Quantity::Expression(select.clone())));
        }
        let g = &object.geometry;
        list.extend(g.sphere.iter().map(|s| (format!("{key}.geometry.sphere.radius"), s.radius.clone())));
        list.extend(g.plane.iter().map(|s| (format!("{key}.geometry.plane.half"), s.half.clone())));
        list.extend(g.archive.iter().map(|s| (format!("{key}.geometry.archive.scale"), s.scale.clone())));
        for (name, spec) in [("cylinder", &g.cylinder), ("capsule", &g.capsule), ("cone", &g.cone)] {
            let parts = spec.iter().flat_map(|s| [("radius", &s.radius), ("half", &s.half)]);
            list.extend(parts.map(|(part, q)| (format!("{key}.geometry.{name}.{part}"), q.clone())));
        }
        for (name, spec) in [("box", &g.block), ("ellipsoid", &g.ellipsoid)] {
            let halves = spec.iter().flat_map(|s| s.half.iter().enumerate());
            list.extend(halves.map(|(k, q)| (format!("{key}.geometry.{name}.half.{k}"), q.clone())));
        }
        list.extend(object.position.iter().enumerate().map(|(k, q)| (format!("{key}.position.{k}"), q.clone())));
        if let Some(velocity) = &object.velocity {
            list.extend(velocity.iter().enumerate().map(|(k, q)| (format!("{key}.velocity.{k}"), q.clone())));
        }
        if let Some(orientation) = &object.orientation {
            list.extend(orientation.iter().enumerate().map(|(k, q)| (format!("{key}.orientation.{k}"), q.clone())));
        }
        if let Color::Column(by) = &object.color {
            list.push((format!("{key}.color.column"), by.column.clone()));
        }
        list.into_iter()
            .map(|(key, q)| match q.expr() {
                Ok(e) => Ok((key, e)),
                Err(e) => Err(self.in_expression(&key, &e)),
            })
            .collect()
    }

    /// What is wrong with the expression of a key.
    fn in_expression(&self, key: &str, e: &ExprError) -> Fault {
        self.doc.fault(key, format!("in the expression, at character {}: {}", e.at + 1, e.message))
    }

    /// The condition of the rows that the camera goes with.
    pub fn followed(&self) -> Result<Option<Expr>, Fault> {
        let Some(text) = self.metadata.camera.as_ref().and_then(|c| c.follow.as_ref()) else { return Ok(None) };
        Expr::parse(text).map(Some).map_err(|e| self.in_expression("camera.follow", &e))
    }

    /// Check that every column that is named exists in the data.
    pub fn check_columns(&self, frame: &Frame) -> Result<(), Fault> {
        let names = frame.names();
        let follow = self.followed()?.map(|e| vec![("camera.follow".to_string(), e)]);
        let lists = (0..self.metadata.objects.len()).map(|i| self.expressions(i)).collect::<Result<Vec<_>, _>>()?;
        for list in follow.into_iter().chain(lists) {
            for (key, expr) in list {
                for (column, _) in expr.columns() {
                    if !names.contains(&column) {
                        let fault = self
                            .doc
                            .fault(&key, format!("unknown column `{column}`, the data has {}", names.join(", ")));
                        return Err(match nearest(column, names.iter().copied()) {
                            Some(near) => fault.hint(format!("did you mean `{near}`?")),
                            None => fault,
                        });
                    }
                }
            }
        }
        Ok(())
    }
}
