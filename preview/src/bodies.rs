//! A frame → the shapes that Rerun draws: an entity for each object of the binding.
//!
//! What does not change from frame to frame, as sizes and colours of one value, is sent once: a sphere costs 12 bytes of position a
//! frame, and 4 for its colour where the data colours it.

use crate::mesh::Triangles;
use bind::binding::{Color, Shape};
use bind::emit::{self, Group, Prepared};
use bind::{Binding, Moment, expr};
use frame::{Fault, Frame};
use rerun::components::FillMode;
use rerun::{
    Arrows3D, AsComponents, Boxes3D, Capsules3D, Cylinders3D, Ellipsoids3D, EntityPath, InstancePoses3D, Points3D,
    RecordingStream, RecordingStreamResult,
};
use ri::files::Files;
use ri::{Instances, Values};
use std::collections::{BTreeMap, BTreeSet};
use std::hash::{DefaultHasher, Hash, Hasher};

/// Below this opacity a shape is drawn by its edges, so that what is inside it is seen.
const SEEN_THROUGH: f32 = 0.7;

/// The bodies of a binding, as far as they have been sent.
pub struct Bodies {
    binding: Binding,
    /// Bodies of an object at most.
    most: usize,
    /// Length of the arrows of velocities, s.
    velocities: Option<f32>,
    files: Files,
    /// What was sent of each entity that need not be sent again.
    sent: BTreeMap<String, u64>,
    /// Entities with bodies in the last frame.
    shown: BTreeSet<String>,
    /// What has been said already.
    said: BTreeSet<String>,
}

impl Bodies {
    /// The bodies of a binding, of which none have been sent.
    pub fn new(binding: &Binding, most: usize, velocities: Option<f32>) -> Bodies {
        let mut binding = binding.clone();
        // Motion over this time gives the arrows.
        binding.output.shutter = velocities.map_or(0.0, f64::from);
        let files = binding.files(Files { folders: vec![binding.folder()], ..Files::default() });
        let (sent, shown, said) = Default::default();
        Bodies { binding, most, velocities, files, sent, shown, said }
    }

    /// Send a frame at the stream's present time.
    pub fn send(&mut self, frame: &Frame, stream: &RecordingStream) -> Result<(), SendError> {
        let binding = self.binding.clone();
        let (objects, _) = emit::prepare(&binding, &Moment::alone(frame))?;
        let before = std::mem::take(&mut self.shown);
        for object in &objects {
            for (k, group) in object.groups.iter().enumerate() {
                let part = (object.groups.len() > 1).then(|| k.to_string());
                self.group(object, group, part, stream)?;
            }
        }
        for gone in before.difference(&self.shown) {
            stream.log(path(gone), &rerun::Clear::recursive())?;
            self.sent.retain(|entity, _| !entity.starts_with(gone.as_str()));
        }
        Ok(())
    }

    /// Send the instances of one shape.
    fn group(
        &mut self,
        object: &Prepared<'_>,
        group: &Group<'_>,
        part: Option<String>,
        stream: &RecordingStream,
    ) -> RecordingStreamResult<()> {
        let Some(all) = group.instances.first().filter(|all| !all.is_empty()) else { return Ok(()) };
        let entity = [Some(object.object.name.clone()), part].into_iter().flatten().collect::<Vec<_>>().join("\u{1f}");
        let stride = all.len().div_ceil(self.most);
        if stride > 1 {
            let message = format!("of the {} rows of `{}`, each {stride}th is shown", all.len(), object.object.name);
            self.say(message);
        }
        let rows = Rows { all, stride, object, group };
        self.shown.insert(entity.clone());
        match &object.object.shape {
            Shape::Sphere(_) => self.parts(&entity, rows.spheres(), stream)?,
            Shape::Ellipsoid(_) => self.parts(&entity, rows.ellipsoids(), stream)?,
            Shape::Box(_) | Shape::Plane(_) => self.parts(&entity, rows.boxes(), stream)?,
            Shape::Cylinder(_) => self.parts(&entity, rows.cylinders(), stream)?,
            Shape::Capsule(_) => self.parts(&entity, rows.capsules(), stream)?,
            Shape::Cone(_) | Shape::Archive(..) => self.meshes(&entity, &rows, stream)?,
            Shape::Arrow(_) if group.is_head => {}
            Shape::Arrow(_) => stream.log(path(&entity), &rows.arrows())?,
            Shape::Trail(_) => {}
        }
        if self.velocities.is_some() && all.moved.is_some() {
            let arrows = Arrows3D::from_vectors(rows.motion()).with_origins(rows.positions());
            stream.log(path(&format!("{entity}\u{1f}velocities")), &arrows)?;
        }
        Ok(())
    }

    /// Send the parts of an archetype that have changed: what moves in every frame, and what seldom changes.
    fn parts(
        &mut self,
        entity: &str,
        [moving, lasting]: [(Box<dyn AsComponents>, u64); 2],
        stream: &RecordingStream,
    ) -> RecordingStreamResult<()> {
        stream.log(path(entity), moving.0.as_ref())?;
        if self.sent.insert(entity.into(), lasting.1) != Some(lasting.1) {
            stream.log(path(entity), lasting.0.as_ref())?;
        }
        Ok(())
    }

    /// Send instances of a mesh, and the mesh itself if it was not sent yet.
    fn meshes(&mut self, entity: &str, rows: &Rows<'_>, stream: &RecordingStream) -> RecordingStreamResult<()> {
        let colors = rows.colors();
        let color = mean(&colors);
        let mark = hash(&(rows.group.archive, color.to_u32()));
        if self.sent.get(entity) != Some(&mark) {
            match Triangles::of(&rows.object.object.shape, rows.group.archive, &self.files) {
                Ok(mesh) => stream.log(path(entity), &mesh.archetype(color))?,
                Err(why) => {
                    self.say(format!("`{}` is shown by boxes: {why}", rows.object.object.name));
                    return self.parts(entity, rows.boxes(), stream);
                }
            }
            if colors.len() > 1 && colors.iter().any(|one| *one != colors[0]) {
                self.say(format!("meshes have one colour: `{}` has the mean of its rows", rows.object.object.name));
            }
            self.sent.insert(entity.into(), mark);
        }
        let poses = InstancePoses3D::new()
            .with_translations(rows.positions())
            .with_quaternions(rows.quaternions())
            .with_scales(rows.scales());
        stream.log(path(entity), &poses)
    }

    /// Say something once.
    fn say(&mut self, message: String) {
        if self.said.insert(message.clone()) {
            eprintln!("note: {}", guard::text::line(&message));
        }
    }
}

/// Why a frame could not be sent.
pub enum SendError {
    /// A fault of the frame.
    Frame(Fault),
    /// The recording failed.
    Stream(rerun::RecordingStreamError),
}

impl From<Fault> for SendError {
    fn from(fault: Fault) -> SendError {
        SendError::Frame(fault)
    }
}

impl From<rerun::RecordingStreamError> for SendError {
    fn from(error: rerun::RecordingStreamError) -> SendError {
        SendError::Stream(error)
    }
}

/// The path of an entity, whose names may have any characters.
fn path(entity: &str) -> EntityPath {
    EntityPath::from_iter(["bodies"].into_iter().chain(entity.split('\u{1f}')).map(rerun::EntityPathPart::new))
}

/// The instances of a group that are shown.
struct Rows<'a> {
    all: &'a Instances,
    stride: usize,
    object: &'a Prepared<'a>,
    group: &'a Group<'a>,
}

impl Rows<'_> {
    fn chosen<T: Copy>(&self, values: &[T]) -> Vec<T> {
        values.iter().step_by(self.stride).copied().collect()
    }

    fn positions(&self) -> Vec<[f32; 3]> {
        self.chosen(&self.all.position)
    }

    fn scales(&self) -> Vec<[f32; 3]> {
        one_if_equal(self.chosen(&self.all.scale))
    }

    fn quaternions(&self) -> Vec<rerun::Quaternion> {
        self.chosen(&self.all.orientation).into_iter().map(rerun::Quaternion::from_xyzw).collect()
    }

    fn motion(&self) -> Vec<[f32; 3]> {
        let to = self.all.moved.as_ref().map_or(&[][..], |(_, to)| to);
        let way = |(from, to): (&[f32; 3], &[f32; 3])| [0, 1, 2].map(|k| to[k] - from[k]);
        self.all.position.iter().zip(to).step_by(self.stride).map(way).collect()
    }

    /// The arrows of which these are the shafts: their heads are as long as eight of the shaft's radii.
    fn arrows(&self) -> Arrows3D {
        let along = |([x, y, z, w], [radius, _, half]): (&[f32; 4], &[f32; 3])| {
            let axis = [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)];
            (axis.map(|c| c * half), axis.map(|c| c * (2.0 * half + 8.0 * radius)))
        };
        let all: Vec<_> = self.all.orientation.iter().zip(&self.all.scale).step_by(self.stride).map(along).collect();
        let tail = |(at, (half, _)): (&[f32; 3], &([f32; 3], [f32; 3]))| [0, 1, 2].map(|k| at[k] - half[k]);
        let tails: Vec<[f32; 3]> = self.positions().iter().zip(&all).map(tail).collect();
        let vectors: Vec<[f32; 3]> = all.iter().map(|(_, vector)| *vector).collect();
        Arrows3D::from_vectors(vectors).with_origins(tails).with_colors(self.colors())
    }

    /// The colour of each row, or the one of all.
    fn colors(&self) -> Vec<rerun::Color> {
        let opacity = self.object.object.opacity.unwrap_or(1.0);
        let rgb: Vec<[f32; 3]> = match &self.object.object.color {
            Color::Rgb(rgb) => vec![*rgb],
            Color::By { .. } => {
                let colors = self.all.params.iter().find(|param| param.decl.name == "Cs");
                let Some(Values::Floats(values)) = colors.map(|param| &param.values) else { return vec![] };
                self.chosen(values.as_chunks().0)
            }
        };
        one_if_equal(rgb.into_iter().map(|rgb| encoded(rgb, opacity)).collect())
    }

    fn fill(&self) -> FillMode {
        match self.object.object.opacity {
            Some(opacity) if opacity < SEEN_THROUGH => FillMode::MajorWireframe,
            _ => FillMode::Solid,
        }
    }

    fn spheres(&self) -> [(Box<dyn AsComponents>, u64); 2] {
        let (colors, radii) = (self.colors(), one_if_equal(self.radii()));
        let marks = hash(&(bits(&radii), colors.iter().map(|c| c.to_u32()).collect::<Vec<_>>()));
        [
            (Box::new(Points3D::update_fields().with_positions(self.positions())), 0),
            (Box::new(Points3D::update_fields().with_radii(radii).with_colors(colors)), marks),
        ]
    }

    fn radii(&self) -> Vec<f32> {
        self.all.scale.iter().step_by(self.stride).map(|s| s[0]).collect()
    }

    fn ellipsoids(&self) -> [(Box<dyn AsComponents>, u64); 2] {
        let (colors, sizes) = (self.colors(), self.scales());
        let marks = self.marks(&sizes, &colors);
        let moving = Ellipsoids3D::update_fields().with_centers(self.positions()).with_quaternions(self.quaternions());
        let lasting = Ellipsoids3D::update_fields().with_half_sizes(sizes).with_colors(colors);
        [(Box::new(moving), 0), (Box::new(lasting.with_fill_mode(self.fill())), marks)]
    }

    /// Boxes, and squares as flat ones.
    fn boxes(&self) -> [(Box<dyn AsComponents>, u64); 2] {
        let is_flat = matches!(self.object.object.shape, Shape::Plane(_));
        let flat = |[x, y, z]: [f32; 3]| [x, y, if is_flat { 0.0 } else { z }];
        let (colors, sizes) = (self.colors(), self.scales().into_iter().map(flat).collect::<Vec<_>>());
        let marks = self.marks(&sizes, &colors);
        let moving = Boxes3D::update_fields().with_centers(self.positions()).with_quaternions(self.quaternions());
        let lasting = Boxes3D::update_fields().with_half_sizes(sizes).with_colors(colors);
        [(Box::new(moving), 0), (Box::new(lasting.with_fill_mode(self.fill())), marks)]
    }

    fn cylinders(&self) -> [(Box<dyn AsComponents>, u64); 2] {
        let (colors, sizes) = (self.colors(), self.scales());
        let marks = self.marks(&sizes, &colors);
        let moving = Cylinders3D::update_fields().with_centers(self.positions()).with_quaternions(self.quaternions());
        let lasting = Cylinders3D::update_fields()
            .with_lengths(sizes.iter().map(|s| 2.0 * s[2]))
            .with_radii(sizes.iter().map(|s| s[0]))
            .with_colors(colors);
        [(Box::new(moving), 0), (Box::new(lasting.with_fill_mode(self.fill())), marks)]
    }

    fn capsules(&self) -> [(Box<dyn AsComponents>, u64); 2] {
        let (colors, sizes) = (self.colors(), self.scales());
        let marks = self.marks(&sizes, &colors);
        // Their origin is the middle of their lower end.
        let lower = |(k, at): (usize, [f32; 3])| {
            let half = self.all.scale[k * self.stride][2];
            let [x, y, z, w] = self.all.orientation.get(k * self.stride).copied().unwrap_or([0.0, 0.0, 0.0, 1.0]);
            let axis = [2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)];
            [0, 1, 2].map(|i| at[i] - half * axis[i])
        };
        let places: Vec<[f32; 3]> = self.positions().into_iter().enumerate().map(lower).collect();
        let moving = Capsules3D::update_fields().with_translations(places).with_quaternions(self.quaternions());
        let lasting = Capsules3D::update_fields()
            .with_lengths(sizes.iter().map(|s| 2.0 * s[2]))
            .with_radii(sizes.iter().map(|s| s[0]))
            .with_colors(colors);
        [(Box::new(moving), 0), (Box::new(lasting.with_fill_mode(self.fill())), marks)]
    }

    fn marks(&self, sizes: &[[f32; 3]], colors: &[rerun::Color]) -> u64 {
        hash(&(bits(sizes.as_flattened()), colors.iter().map(|c| c.to_u32()).collect::<Vec<_>>()))
    }
}

/// The first value alone where all are the same: Rerun repeats it.
fn one_if_equal<T: PartialEq>(mut values: Vec<T>) -> Vec<T> {
    if values.windows(2).all(|pair| pair[0] == pair[1]) {
        values.truncate(1);
    }
    values
}

fn bits(values: &[f32]) -> Vec<u32> {
    values.iter().map(|x| x.to_bits()).collect()
}

fn hash(value: &impl Hash) -> u64 {
    let mut hasher = DefaultHasher::new();
    value.hash(&mut hasher);
    hasher.finish()
}

fn mean(colors: &[rerun::Color]) -> rerun::Color {
    let n = colors.len().max(1) as u32;
    let of = |k: usize| (colors.iter().map(|c| u32::from(c.to_array()[k])).sum::<u32>() / n) as u8;
    rerun::Color::from_unmultiplied_rgba(of(0), of(1), of(2), of(3))
}

/// A linear colour as sRGB bytes (IEC 61966-2-1).
fn encoded(rgb: [f32; 3], opacity: f32) -> rerun::Color {
    let byte = |x: f32| {
        let x = x.clamp(0.0, 1.0);
        let y = if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
        (255.0 * y).round() as u8
    };
    let [r, g, b] = rgb.map(byte);
    rerun::Color::from_unmultiplied_rgba(r, g, b, (255.0 * opacity.clamp(0.0, 1.0)).round() as u8)
}

/// The forces of a table of contacts as arrows, `length` metres for each newton, at the stream's present time.
pub fn contacts(table: &Frame, length: f32, most: usize, stream: &RecordingStream) -> Result<(), SendError> {
    let rows: Vec<usize> = (0..table.rows()).step_by(table.rows().div_ceil(most).max(1)).collect();
    let numbers = |names: [&str; 3]| -> Option<Vec<[f32; 3]>> {
        let column = |name: &str| expr::Expr::column(name).numbers(table, &rows).ok();
        let [x, y, z] = names.map(column);
        let (x, y, z) = (x?, y?, z?);
        Some((0..rows.len()).map(|k| [x[k] as f32, y[k] as f32, z[k] as f32]).collect())
    };
    let (Some(places), Some(forces)) =
        (numbers(["pos_x", "pos_y", "pos_z"]), numbers(["force_x", "force_y", "force_z"]))
    else {
        return Ok(());
    };
    let arrows = forces.into_iter().map(|force| force.map(|x| length * x));
    stream.log("contacts", &Arrows3D::from_vectors(arrows).with_origins(places))?;
    Ok(())
}
