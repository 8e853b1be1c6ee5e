//! The spheres of a model as columns of a device.

use super::fault::Fault;
use super::fixed::{MAX_RATIO, Scale};
use super::rows::{Aabb, Sphere};
use crate::model::Model;
use crate::shape::ShapeKind;
use gpu::{Buffer, Device};

/// The columns, a row for each sphere.
pub struct Spheres {
    /// Number of spheres.
    pub n: usize,
    /// The spheres, by ascending shape.
    pub sphere: Buffer<Sphere>,
    /// Distance from the surface within which contacts are generated, m.
    pub margin: Buffer<f32>,
    /// Fat AABBs, m.
    pub fat_aabb: Buffer<Aabb>,
    /// Ids of the shapes.
    pub shapes: Vec<usize>,
    /// Ids of the bodies.
    pub bodies: Vec<u32>,
    /// Harmonic mean of the diameters, m.
    pub width: f64,
}

impl Spheres {
    /// The spheres of a model, with the units of its lengths.
    ///
    /// # Errors
    /// [`Fault::Unsupported`] for spheres off their bodies' centres of mass, no spheres, or too great a ratio of radii; [`Fault::Gpu`].
    pub fn new(device: &Device, model: &Model) -> Result<(Spheres, Scale), Fault> {
        let shapes = shapes(model)?;
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
        let n = rows.len();
        let width = n as f64 / radii().map(|radius| 0.5 / radius).sum::<f64>();
        let spheres = Spheres {
            n,
            sphere: Buffer::of(device, "sphere", &rows)?,
            margin: Buffer::zeros(device, "margin", n)?,
            fat_aabb: Buffer::zeros(device, "fat_aabb", n)?,
            bodies: rows.iter().map(|s| s.body).collect(),
            shapes,
            width,
        };
        Ok((spheres, scale))
    }
}

/// The shapes that are spheres about their bodies' centres of mass.
fn shapes(model: &Model) -> Result<Vec<usize>, Fault> {
    let found: Vec<usize> = (0..model.n_shapes()).filter(|s| model.is_centred_sphere(*s)).collect();
    if let Some(s) =
        (0..model.n_shapes()).find(|s| model.shape_kind[*s] == ShapeKind::Sphere && !model.is_centred_sphere(*s))
    {
        let label = model.body_label(model.shape_body[s] as usize);
        return Err(Fault::Unsupported(format!(
            "body {label} has a shape that no kernel is built for yet: a sphere off its centre of mass"
        )));
    }
    if found.is_empty() {
        return Err(Fault::Unsupported("the model has no spheres".into()));
    }
    Ok(found)
}
