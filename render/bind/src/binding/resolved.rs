//! A binding's parts: data, camera, images, and what finds files and columns for them.

use super::object::{Formula, Object};
use crate::data::{Source, Store};
use crate::expr::Expr;
use frame::csv::Layout;
use frame::yaml::Document;
use frame::{Fault, Frame, nearest, run, sequence};
use ri::files::Files;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// What to draw, and where the file said it.
#[derive(Clone, Debug)]
pub struct Binding {
    /// The file, so that faults found later still have their place.
    pub doc: Document,
    /// A model to simulate first; its run directory is then the data. From the file's folder.
    pub model: Option<PathBuf>,
    /// Where the data is.
    pub data: Option<Data>,
    /// The scene: a RIB file from the file's folder, or one of the library's.
    pub scene: String,
    /// The camera, if the scene does not have its own.
    pub camera: Option<Camera>,
    /// A RIB file of lights for the scene's `#scree inject lights`.
    pub lights: Option<String>,
    /// What is drawn.
    pub objects: Vec<Object>,
    /// Images.
    pub output: Output,
    /// Images a second of the movie.
    pub frame_rate: f64,
    /// Files that it brings itself: names and texts.
    pub made: Vec<(String, String)>,
    /// Folders to look in besides its own.
    pub folders: Vec<PathBuf>,
    /// Other images of the same data, by the names of the folders that they go to.
    pub passes: Vec<(String, Binding)>,
}

/// Where the data is, and what is done to each frame of it.
#[derive(Clone, Debug)]
pub struct Data {
    /// Where it is; none if the file does not say just one place, which is a fault once the data is opened.
    pub place: Option<Place>,
    /// Columns computed from others, in order.
    pub derive: Vec<(String, Expr)>,
    /// Which rows there are at all.
    pub select: Option<Expr>,
}

/// Where data is; paths are from the file's folder.
#[derive(Clone, Debug)]
pub enum Place {
    /// A run directory.
    Run(PathBuf),
    /// CSV files.
    Csv {
        /// Their names, `*` standing for any characters.
        pattern: PathBuf,
        /// How they are laid out.
        layout: Layout,
        /// New names of columns, by their old ones.
        rename: BTreeMap<String, String>,
    },
}

/// The camera.
#[derive(Clone, Debug)]
pub enum Camera {
    /// A RIB file of camera calls; `{frame}` in its name stands for the frame's number, `{frame:04}` for it with four digits.
    File(String),
    /// A place and a point to look at.
    Placed(Placed),
}

/// A camera by its place.
#[derive(Clone, Debug)]
pub struct Placed {
    /// Where it stands, m.
    pub eye: [f32; 3],
    /// What it looks at, m.
    pub look_at: [f32; 3],
    /// The direction that is up in the image.
    pub up: [f32; 3],
    /// Projection.
    pub projection: Projection,
    /// Degrees a frame by which it goes around what it looks at, about `up`.
    pub orbit: Option<f32>,
    /// The rows that it goes with: `eye` and `look_at` are then from the middle of these.
    pub follow: Option<Formula>,
    /// A lens; without it all is sharp.
    pub lens: Option<Lens>,
}

/// A camera's projection.
#[derive(Clone, Copy, Debug)]
pub enum Projection {
    /// Parallel, this many metres across the shorter side.
    Parallel(f32),
    /// Perspective, this many degrees across the shorter side.
    Perspective(f32),
}

/// A camera's lens.
#[derive(Clone, Copy, Debug)]
pub struct Lens {
    /// f-stop: the focal length over the width of the opening.
    pub f_stop: f32,
    /// Focal length, m.
    pub focal_length: f32,
    /// How far away it is sharp, m; if not given, as far as what the camera looks at.
    pub focus: Option<f32>,
}

/// Images.
#[derive(Clone, Debug)]
pub struct Output {
    /// Pixels along x and y.
    pub resolution: [u32; 2],
    /// Samples along x and y of a pixel.
    pub samples: [u32; 2],
    /// Pixels a micropolygon.
    pub shading_rate: f32,
    /// File format.
    pub format: ImageFormat,
    /// Bits of a colour: 8 or 16 in a PNG, 16 or 32, both floats, in an EXR; 8 and 32 if not given.
    pub bits: Option<u32>,
    /// What else goes into an EXR, each a layer of it.
    pub channels: Vec<String>,
    /// How long the shutter is open, s.
    pub shutter: f64,
    /// Frames to draw, as a list; all if not given.
    pub frames: Option<String>,
    /// Name and width (pixels) of the pixel filter.
    pub filter: (String, f32),
}

/// File format of images.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImageFormat {
    /// PNG.
    Png,
    /// OpenEXR, floats.
    Exr,
}

impl Default for Output {
    fn default() -> Output {
        Output {
            resolution: [640, 360],
            samples: [4, 4],
            shading_rate: 1.0,
            format: ImageFormat::Png,
            bits: None,
            channels: vec![],
            shutter: 0.0,
            frames: None,
            filter: ("gaussian".into(), 2.0),
        }
    }
}

impl Binding {
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
        let Some(data) = &self.data else {
            return Err(self.doc.fault("data", "names no data: expected `data: {run: …}` or `data: {csv: …}`"));
        };
        let store = match &data.place {
            Some(Place::Run(folder)) => Store::Run(run::RunReader::open(&self.folder().join(folder))?),
            Some(Place::Csv { pattern, layout, rename }) => {
                let files = sequence::find(&self.folder().join(pattern))?;
                Store::Csv { files, layout: layout.clone(), rename: rename.clone() }
            }
            None => return Err(self.doc.fault("data", "needs exactly one of `run` and `csv`")),
        };
        Ok(Source { store, derive: data.derive.clone(), select: data.select.clone() })
    }

    /// Check that every column that is named exists in the data.
    pub fn check_columns(&self, frame: &Frame) -> Result<(), Fault> {
        let names = frame.names();
        let follow = match &self.camera {
            Some(Camera::Placed(placed)) => placed.follow.as_ref(),
            _ => None,
        };
        for formula in follow.into_iter().chain(self.objects.iter().flat_map(Object::formulas)) {
            for column in formula.expr.columns() {
                if !names.contains(&column.as_str()) {
                    let message = format!("unknown column `{column}`, the data has {}", names.join(", "));
                    let fault = self.doc.fault(&formula.key, message);
                    return Err(match nearest(column, names.iter().copied()) {
                        Some(near) => fault.hint(format!("did you mean `{near}`?")),
                        None => fault,
                    });
                }
            }
        }
        Ok(())
    }
}
