//! The spheres of a model as columns of a device, and the parts that their kernels import.

use super::fixed::{MAX_RATIO, Scale};
use super::rows::{Aabb, Fixed, Sphere};
use crate::model::Model;
use crate::shape::ShapeKind;
use crate::state::State;
use gpu::{Buffer, Device, GpuError, Kernel, Kernels, Part, Work};

/// The parts that the kernels import.
const PARTS: [Part<'static>; 9] = [
    ("fixed", include_str!("fixed.wgsl")),
    ("sphere", include_str!("sphere.wgsl")),
    ("tight", include_str!("tight.wgsl")),
    ("bins", include_str!("bins.wgsl")),
    ("contact", include_str!("contact.wgsl")),
    ("solve_row", include_str!("solve_row.wgsl")),
    ("project", include_str!("project.wgsl")),
    ("body_response", include_str!("body_response.wgsl")),
    ("apgd_scalars", include_str!("apgd_scalars.wgsl")),
];

/// Rows of a workgroup.
pub const ROWS: usize = 256;

/// Why spheres cannot be put on a device.
#[derive(Clone, Debug, PartialEq)]
pub enum Fault {
    /// The model has something that is not built for devices.
    Unsupported(String),
    /// A body is not where a position can be: not finite, or too far from the origin.
    Position(u32),
    /// A fault of the device.
    Gpu(GpuError),
}

impl std::fmt::Display for Fault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Fault::Unsupported(what) => f.write_str(what),
            Fault::Position(body) => write!(f, "body {body} is too far from the origin for the graphics device"),
            Fault::Gpu(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for Fault {}

impl From<GpuError> for Fault {
    fn from(error: GpuError) -> Fault {
        Fault::Gpu(error)
    }
}

/// A kernel of a stage.
pub fn kernel(device: &Device, kernels: &Kernels, name: &'static str, text: &str) -> Result<Kernel, GpuError> {
    kernels.get(device, name, text, &PARTS)
}

/// A kernel of a stage, with one more part.
pub fn kernel_with(
    device: &Device,
    kernels: &Kernels,
    (name, text): (&'static str, &str),
    part: Part<'static>,
) -> Result<Kernel, GpuError> {
    let parts: Vec<Part> = PARTS.into_iter().chain([part]).collect();
    kernels.get(device, name, text, &parts)
}

/// Workgroups for `n` rows.
pub fn groups(n: usize) -> Work<'static> {
    Work::Groups(n.div_ceil(ROWS) as u32)
}

/// The columns that do not depend on the stages.
pub struct Spheres {
    /// Number of spheres.
    pub n: usize,
    /// The unit of positions and radii.
    pub scale: Scale,
    /// The spheres, by ascending shape (n_spheres).
    pub sphere: Buffer<Sphere>,
    /// Positions (n_bodies).
    pub position: Buffer<Fixed>,
    /// Velocities, m/s (n_bodies).
    pub velocity: Buffer<[f32; 4]>,
    /// Moving, held or inactive (n_bodies).
    pub activity: Buffer<u32>,
    /// What `activity` holds.
    known: Vec<u32>,
    /// Distance from the surface within which contacts are generated, m (n_spheres).
    pub margin: Buffer<f32>,
    /// Fat AABBs, m (n_spheres).
    pub fat_aabb: Buffer<Aabb>,
}

impl Spheres {
    /// The spheres of a model. Shapes of other kinds are left out if their bodies are held in place.
    ///
    /// # Errors
    /// [`Fault::Unsupported`] for a model with other moving shapes, spheres off their bodies' centres of mass, no spheres, or too great a
    /// ratio of radii; [`Fault::Gpu`].
    pub fn new(device: &Device, model: &Model, state: &State) -> Result<Spheres, Fault> {
        let shapes = shapes(model, state)?;
        let radii = || shapes.iter().map(|s| model.shape_size[*s].x);
        let (least, most) = (radii().fold(f64::INFINITY, f64::min), radii().fold(0.0, f64::max));
        if most > MAX_RATIO * least {
            let ratio = most / least;
            let message =
                format!("the radii of the spheres differ by {ratio:.0} times; a device takes {MAX_RATIO} times");
            return Err(Fault::Unsupported(message));
        }
        let scale = Scale::of(least);
        let sphere = |s: &usize| Sphere {
            radius: scale.radius(model.shape_size[*s].x),
            shape: *s as u32,
            body: model.shape_body[*s],
            material: model.shape_material[*s],
            group: model.shape_group[*s],
        };
        let rows: Vec<Sphere> = shapes.iter().map(sphere).collect();
        let n_bodies = model.n_bodies();
        let mut spheres = Spheres {
            n: rows.len(),
            scale,
            sphere: Buffer::of(device, "sphere", &rows)?,
            position: Buffer::zeros(device, "position", n_bodies)?,
            velocity: Buffer::zeros(device, "velocity", n_bodies)?,
            activity: Buffer::zeros(device, "activity", n_bodies)?,
            known: vec![],
            margin: Buffer::zeros(device, "margin", rows.len())?,
            fat_aabb: Buffer::zeros(device, "fat_aabb", rows.len())?,
        };
        spheres.place(device, state)?;
        Ok(spheres)
    }

    /// Write the positions, velocities and activities of a state. Returns whether an activity has changed.
    ///
    /// # Errors
    /// [`Fault::Position`].
    pub fn place(&mut self, device: &Device, state: &State) -> Result<bool, Fault> {
        let fixed = |(body, p): (usize, &glam::DVec3)| self.scale.fix(*p).ok_or(Fault::Position(body as u32));
        let position: Vec<Fixed> = state.position.iter().enumerate().map(fixed).collect::<Result<_, _>>()?;
        let velocity: Vec<[f32; 4]> = state.velocity.iter().map(|v| v.as_vec3().extend(0.0).to_array()).collect();
        let activity = |b: usize| match (state.is_inactive(b), state.moves(b)) {
            (true, _) => 2,
            (false, false) => 1,
            (false, true) => 0,
        };
        let activity: Vec<u32> = (0..position.len()).map(activity).collect();
        self.position.write(device, &position);
        self.velocity.write(device, &velocity);
        let has_changed = activity != self.known;
        if has_changed {
            self.activity.write(device, &activity);
            self.known = activity;
        }
        Ok(has_changed)
    }
}

/// The shapes that are spheres about their bodies' centres of mass.
fn shapes(model: &Model, state: &State) -> Result<Vec<usize>, Fault> {
    let mut found = vec![];
    for s in 0..model.n_shapes() {
        let (kind, body) = (model.shape_kind[s], model.shape_body[s] as usize);
        if model.is_centred_sphere(s) {
            found.push(s);
        } else if kind == ShapeKind::Sphere || state.moves(body) {
            let what = if kind == ShapeKind::Sphere { "a sphere off its centre of mass" } else { kind.name() };
            let label = model.body_label(body);
            let message = format!("body {label} has a shape that no kernel is built for yet: {what}");
            return Err(Fault::Unsupported(message));
        }
    }
    if found.is_empty() {
        return Err(Fault::Unsupported("the model has no spheres".into()));
    }
    Ok(found)
}
