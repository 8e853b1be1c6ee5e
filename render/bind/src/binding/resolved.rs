//! A binding's parts: data, camera, images, and what finds files and columns for them.

use super::object::Object;
use super::overlays::Overlays;
use crate::Up;
use crate::data::{Source, Store};
use crate::formula::{Formula, unknown_column};
use frame::csv::Layout;
use frame::yaml::Document;
use frame::{Fault, Frame, run, table};
use ri::files::Files;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A binding of data to images: data, scene, camera, lights, objects and output.
#[derive(Clone, Debug)]
pub struct Binding {
    /// The file's text, for the place of faults that are found later.
    pub doc: Document,
    /// Path of a model to simulate first, relative to the file's folder; its run directory is then the data.
    pub model: Option<PathBuf>,
    /// The data, if the file names any.
    pub data: Option<Data>,
    /// The axis of the data that points up.
    pub up: Up,
    /// The scene: a RIB file, relative to the file's folder, or the name of a scene of the library.
    pub scene: String,
    /// The camera; none if the scene has its own.
    pub camera: Option<Camera>,
    /// A RIB file of lights for the scene's `#scree inject lights`; default lights if not given.
    pub lights: Option<String>,
    /// The height of the scene's own ground, or of a floor under data that brings none, m, if it is given.
    pub ground_height: Option<f32>,
    /// The objects to draw, at least one.
    pub objects: Vec<Object>,
    /// What is written over the images.
    pub overlays: Overlays,
    /// Resolution, sampling and file format of the images.
    pub output: Output,
    /// Frame rate of the movie, 1/s.
    pub frame_rate: f64,
    /// Generated files that the scene reads: names and texts.
    pub made: Vec<(String, String)>,
    /// Folders to search besides the file's own.
    pub folders: Vec<PathBuf>,
    /// Bindings of further images of the same data (render passes), each with the name of its output folder.
    pub passes: Vec<(String, Binding)>,
}

/// The place of the data, and the operations on each of its frames.
#[derive(Clone, Debug)]
pub struct Data {
    /// The place of the data; none if the file does not give exactly one, which is a fault when the data is opened.
    pub place: Option<Place>,
    /// Derived columns, in order: name and expression.
    pub derive: Vec<(String, Formula)>,
    /// Condition on the rows to keep; all rows if not given.
    pub select: Option<Formula>,
}

/// The place of data; paths are relative to the file's folder.
#[derive(Clone, Debug)]
pub enum Place {
    /// A run directory.
    Run(PathBuf),
    /// Tables of other programs.
    Files {
        /// Path of the files, in which `*` stands for any characters.
        pattern: PathBuf,
        /// Layout of those that are CSV files.
        layout: Layout,
        /// New names of columns, by their old ones.
        rename: BTreeMap<String, String>,
        /// The column that has the times of rows, if these are of different times.
        time: Option<String>,
    },
}

/// The camera.
#[derive(Clone, Debug)]
pub enum Camera {
    /// A RIB file of camera calls; `{frame}` in its name stands for the frame's number, `{frame:04}` for it with four digits.
    File(String),
    /// A place and a point to look at.
    Placed(Box<Placed>),
}

/// A camera by its position and a point to look at.
#[derive(Clone, Debug)]
pub struct Placed {
    /// Position of the camera, m.
    pub eye: [f32; 3],
    /// Point that the camera looks at, m.
    pub look_at: [f32; 3],
    /// The direction that is up in the image.
    pub up: [f32; 3],
    /// Perspective or parallel projection.
    pub projection: Projection,
    /// Angle per frame, degrees, by which the camera orbits `look_at` about `up`.
    pub orbit: Option<f32>,
    /// Turns about `look_at` in the length of the data; [`Placed::settle`] makes `orbit` of them.
    pub turns: Option<f32>,
    /// Condition on the rows that the camera follows: `eye` and `look_at` are then relative to the mean position of these rows.
    pub follow: Option<Formula>,
    /// Number of frames over which the way of what is followed is smoothed.
    pub damping: Option<f64>,
    /// The smoothed way, by frame; where it has none, it is the mean of the rows.
    pub way: BTreeMap<u64, [f64; 3]>,
    /// The lens, for depth of field; a pinhole if not given.
    pub lens: Option<Lens>,
    /// Keyframes, by frame; none if it stands still but for `orbit` and `follow`.
    pub keys: Vec<Key>,
    /// How far to the right of `eye` the image is taken from, m, for one of a stereo pair. What is looked at is at the same place in both
    /// images of a pair.
    pub aside: f32,
}

impl Placed {
    /// Whether its way depends on all frames.
    pub fn is_open(&self) -> bool {
        self.turns.is_some() || self.is_smoothed()
    }

    /// Whether its way depends on where what it follows is in other frames.
    pub fn is_smoothed(&self) -> bool {
        self.damping.is_some() && self.follow.is_some()
    }

    /// Settle its way by the data: the numbers of its frames, and where what it follows is in them.
    pub fn settle(&mut self, [first, last]: [u64; 2], followed: &BTreeMap<u64, [f64; 3]>) {
        if let Some(turns) = self.turns {
            // The frame after the last would be as the first.
            self.orbit = Some((360.0 * turns as f64 / (last - first + 1) as f64) as f32);
        }
        if let Some(frames) = self.damping {
            self.way = smoothed(followed, frames);
        }
    }
}

/// A way, smoothed by a bell curve over so many frames. At its ends it is mirrored through the end, so that it starts and ends where it does.
fn smoothed(way: &BTreeMap<u64, [f64; 3]>, frames: f64) -> BTreeMap<u64, [f64; 3]> {
    let (numbers, places): (Vec<u64>, Vec<[f64; 3]>) = way.iter().unzip();
    let (n, reach) = (numbers.len(), (3.0 * frames).ceil() as usize);
    let mirrored = |end: usize, inside: usize| {
        let (end, inside) = (places[end], places[inside]);
        [0, 1, 2].map(|c| 2.0 * end[c] - inside[c])
    };
    let at = |k: usize, step: usize, ahead: bool| match ahead {
        true if k + step < n => places[k + step],
        true => mirrored(n - 1, (2 * (n - 1)).saturating_sub(k + step)),
        false if step <= k => places[k - step],
        false => mirrored(0, (step - k).min(n - 1)),
    };
    let smooth = |k: usize| {
        let mut sum = places[k];
        let mut weights = 1.0;
        for step in 1..=reach {
            let weight = (-0.5 * (step as f64 / frames).powi(2)).exp();
            let (a, b) = (at(k, step, false), at(k, step, true));
            sum = [0, 1, 2].map(|c| sum[c] + weight * (a[c] + b[c]));
            weights += 2.0 * weight;
        }
        sum.map(|x| x / weights)
    };
    (0..n).map(|k| (numbers[k], smooth(k))).collect()
}

/// A keyframe of a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Key {
    /// The frame; frames between keys may be whole or not.
    pub frame: f64,
    /// Position of the camera, m.
    pub eye: [f32; 3],
    /// Point that the camera looks at, m.
    pub look_at: [f32; 3],
    /// Angle of view, or in parallel projection the extent, as [`Projection`] has it.
    pub fov: f32,
    /// Whether the camera jumps here.
    pub cut: bool,
}

impl Key {
    /// Eye, point that the camera looks at, angle of view.
    pub fn view(&self) -> [f32; 7] {
        let ([a, b, c], [d, e, f]) = (self.eye, self.look_at);
        [a, b, c, d, e, f, self.fov]
    }
}

/// A camera's projection.
#[derive(Clone, Copy, Debug)]
pub enum Projection {
    /// Parallel projection; extent across the image's shorter side, m.
    Parallel(f32),
    /// Perspective projection; angle of view across the image's shorter side, degrees.
    Perspective(f32),
}

/// A camera's lens.
#[derive(Clone, Copy, Debug)]
pub struct Lens {
    /// f-stop: the focal length over the diameter of the aperture.
    pub f_stop: f32,
    /// Focal length, m.
    pub focal_length: f32,
    /// Focal distance, m: the distance at which the image is sharp; if not given, the distance of `look_at`.
    pub focus: Option<f32>,
}

impl Lens {
    /// Check that it can be focused, where what is looked at is `distance` m away; in a frame, if it is of one. The error is at the key of the focal length.
    pub fn check(&self, doc: &Document, distance: f32, frame: Option<u64>) -> Result<(), Fault> {
        let focus = self.focus.unwrap_or(distance);
        if self.focal_length < focus {
            return Ok(());
        }
        let frame = frame.map_or(String::new(), |number| format!(" in frame {number}"));
        let length = self.focal_length;
        let message = format!("is {length} m, expected less than the distance of what is in focus, {focus} m{frame}");
        let hint = if length >= 1.0 {
            format!("lengths are in metres: of a lens of {length} mm it is {}", length / 1000.0)
        } else {
            "lengths are in metres".into()
        };
        Err(doc.fault("camera.lens.focal_length", message).hint(hint))
    }
}

/// Resolution, sampling and file format of images.
#[derive(Clone, Debug)]
pub struct Output {
    /// Width and height of the image, pixels.
    pub resolution: [u32; 2],
    /// Image quality, which light goes by.
    pub quality: Quality,
    /// Count of samples along x and y of a pixel.
    pub samples: [u32; 2],
    /// Shading rate: maximum area of a micropolygon on the raster, pixels.
    pub shading_rate: f32,
    /// File format.
    pub format: ImageFormat,
    /// Bits of a colour component: 8 (default) or 16 in a PNG, 16 or 32 (default), both floats, in an EXR.
    pub bits: Option<u32>,
    /// Additional layers of an EXR file: names of arbitrary output variables, with types where needed.
    pub channels: Vec<String>,
    /// Duration for which the shutter is open, s; 0 for no motion blur.
    pub shutter: f64,
    /// Frame list ([`frame::list`]) of the frames to draw; all if not given.
    pub frames: Option<String>,
    /// Levels of the film: the brightness on the screen, 0 to 1, that becomes [`BLACK`], and that which becomes [`WHITE`]; the scene's own if
    /// they are neither given nor measured.
    pub levels: Option<[f64; 2]>,
    /// Name of the pixel filter and its full width, pixels.
    pub filter: (String, f32),
}

/// The brightness on the screen, 0 to 1, of what is nearly black.
pub const BLACK: f64 = 0.04;
/// That of what is nearly white.
pub const WHITE: f64 = 0.95;

/// Image quality.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Quality {
    /// Quick, to see where everything is: light from the sky as if nothing were in its way, rays that meet bodies undisplaced.
    Draft,
    /// For films.
    Normal,
    /// For print: shadows of the sun's disc, more samples.
    Final,
}

impl Quality {
    /// Samples along x and y of a pixel.
    pub fn samples(self) -> [u32; 2] {
        [match self {
            Quality::Draft => 1,
            Quality::Normal => 3,
            Quality::Final => 5,
        }; 2]
    }

    /// Area of a micropolygon, pixels.
    pub fn shading_rate(self) -> f32 {
        match self {
            Quality::Draft => 49.0,
            Quality::Normal => 2.0,
            Quality::Final => 1.0,
        }
    }

    /// Pixels along a bucket's edge: larger ones cost memory and less time, of which a draft takes little.
    pub fn bucket_size(self) -> f32 {
        match self {
            Quality::Draft => 256.0,
            Quality::Normal | Quality::Final => 128.0,
        }
    }

    /// How the library's lights go by it: whether the sky's is hidden by what is in the way, and the samples of the sun's disc where it is half hidden.
    pub fn light(self) -> [f32; 2] {
        match self {
            Quality::Draft => [0.0, 1.0],
            Quality::Normal => [1.0, 12.0],
            Quality::Final => [1.0, 32.0],
        }
    }
}

impl Output {
    /// Take a quality, with its samples and shading rate.
    pub fn set_quality(&mut self, quality: Quality) {
        self.quality = quality;
        (self.samples, self.shading_rate) = (quality.samples(), quality.shading_rate());
    }
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
            quality: Quality::Normal,
            samples: Quality::Normal.samples(),
            shading_rate: Quality::Normal.shading_rate(),
            format: ImageFormat::Png,
            bits: None,
            channels: vec![],
            shutter: 0.0,
            frames: None,
            levels: None,
            filter: ("gaussian".into(), 2.0),
        }
    }
}

impl Binding {
    /// Whether it leaves something open that all frames of the data tell: ranges of colours, lengths of arrows, the camera's way.
    pub fn is_open(&self) -> bool {
        let moves = matches!(&self.camera, Some(Camera::Placed(camera)) if camera.is_open());
        moves || self.objects.iter().any(Object::is_open)
    }

    /// Whether the values of all frames tell what it leaves open, and not their numbers alone, as they do of a camera that turns.
    pub fn depends_on_values(&self) -> bool {
        let is_smoothed = matches!(&self.camera, Some(Camera::Placed(camera)) if camera.is_smoothed());
        is_smoothed || self.objects.iter().any(Object::is_open)
    }

    /// The search path `files` with the binding's folders and generated files added.
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

    /// Take the run in the file's folder as the data, with what the file derives and selects of its data.
    pub fn take_run(&mut self, run: run::RunReader) -> Source {
        let (derive, select) = self.data.take().map(|data| (data.derive, data.select)).unwrap_or_default();
        let source = Source::new(Store::Run(run), derive.clone(), select.clone(), self.doc.clone());
        self.data = Some(Data { place: Some(Place::Run(".".into())), derive, select });
        source
    }

    /// Open the data. An error if the binding names no data, or not exactly one place of it, or the data cannot be opened.
    pub fn open_data(&self) -> Result<Source, Fault> {
        let Some(data) = &self.data else {
            return Err(self.doc.fault("data", "there is no data: expected `data: {run: …}` or `data: {files: …}`"));
        };
        let store = match &data.place {
            Some(Place::Run(folder)) => Store::Run(run::RunReader::open(&self.folder().join(folder))?),
            Some(Place::Files { pattern, layout, rename, time }) => {
                let pattern = self.folder().join(pattern);
                let files = match time {
                    Some(time) => table::by_time(&pattern, layout, time)?,
                    None => table::find(&pattern)?,
                };
                Store::Files { files, layout: layout.clone(), rename: rename.clone() }
            }
            None => return Err(self.doc.fault("data", "needs exactly one of `run`, `files` and `csv`")),
        };
        Ok(Source::new(store, data.derive.clone(), data.select.clone(), self.doc.clone()))
    }

    /// Check that `frame` has every column that the objects of its rows and the camera use. The error is at the key that names a missing one.
    pub fn check_columns(&self, frame: &Frame) -> Result<(), Fault> {
        // Writers of empty tables leave columns out.
        if frame.rows() == 0 {
            return Ok(());
        }
        let names = frame.names();
        let follow = match &self.camera {
            Some(Camera::Placed(placed)) => placed.follow.as_ref(),
            _ => None,
        };
        let own = self.objects.iter().filter(|object| !object.of_contacts);
        for formula in follow.into_iter().chain(own.flat_map(Object::formulas)) {
            for column in formula.expr.columns() {
                if !names.contains(&column.as_str()) {
                    return Err(unknown_column(&self.doc, &formula.key, column, frame));
                }
            }
        }
        Ok(())
    }
}
