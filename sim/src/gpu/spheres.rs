//! The spheres of a model as columns of a device, or its moving shapes of any kind.

use super::fault::Fault;
use super::fixed::{MAX_RATIO, Scale};
use super::hulls::Hulls;
use super::rows::{Aabb, Solid, Sphere};
use super::solids;
use crate::model::Model;
use crate::plan::Narrow;
use crate::shape::ShapeKind;
use gpu::{Buffer, Device};

/// The columns, a row for each sphere, or for each moving shape where these are of any kind.
pub struct Spheres {
    /// Number of spheres.
    pub n: usize,
    /// The spheres, by ascending shape.
    pub sphere: Buffer<Sphere>,
    /// The shapes, where they are of any kind; else one row that is not used.
    pub solid: Buffer<Solid>,
    /// The same.
    pub rows: Vec<Solid>,
    /// The convex hulls of shapes and fixtures.
    pub hulls: Hulls,
    /// Distance from the surface within which contacts are generated, m.
    pub margin: Buffer<f32>,
    /// Fat AABBs, m.
    pub fat_aabb: Buffer<Aabb>,
    /// Ids of the shapes.
    pub shapes: Vec<usize>,
    /// Ids of the bodies.
    pub bodies: Vec<u32>,
    /// Harmonic mean of the diameters, of other shapes of the widths of their boxes, m.
    pub width: f64,
    /// Harmonic mean of the volumes of boxes about the shapes, as thick and as deep as the shape is at its least, m³.
    pub volume: f64,
    /// Diameter of the sphere about a shape that all but a few are within, m.
    pub longest: f64,
}

/// Share of the shapes that may be longer than [`Spheres::longest`].
const LONGER: f64 = 0.002;

impl Spheres {
    /// The spheres of a model, with the units of its lengths.
    ///
    /// # Errors
    /// [`Fault::Unsupported`] for a model without moving shapes, or with too great a ratio of sizes; [`Fault::Gpu`].
    pub fn new(device: &Device, model: &Model, narrow: Narrow) -> Result<(Spheres, Scale), Fault> {
        let shapes: Vec<usize> = (0..model.n_shapes()).filter(|s| solids::is_mover(model, *s)).collect();
        if shapes.is_empty() {
            return Err(Fault::Unsupported("no body of the model that moves has a shape".into()));
        }
        let hulls = Hulls::new(device, model)?;
        let solids = match narrow {
            Narrow::Spheres => vec![],
            Narrow::Any => shapes.iter().map(|s| solids::row(model, &hulls, *s)).collect(),
        };
        let radii = || shapes.iter().map(|s| model.shape_size[*s].max_element());
        let least = shapes.iter().map(|s| solids::least_of(model, *s)).fold(f64::INFINITY, f64::min);
        let most = radii().fold(0.0, f64::max);
        if most > MAX_RATIO * least {
            let ratio = most / least;
            let message =
                format!("the sizes of the moving shapes differ by {ratio:.0} times; a device takes {MAX_RATIO} times");
            return Err(Fault::Unsupported(message));
        }
        let scale = Scale::of(least);
        let sphere = |s: &usize| Sphere {
            radius: if model.is_centred_sphere(*s) { scale.radius(model.shape_size[*s].x) } else { 0 },
            shape: *s as u32,
            body: model.shape_body[*s],
            material: model.shape_material[*s],
            group: model.shape_group[*s],
        };
        let rows: Vec<Sphere> = shapes.iter().map(sphere).collect();
        let n = rows.len();
        let size = |s: &usize| (model.shape_size[*s].max_element(), solids::least_of(model, *s));
        let volumes = shapes.iter().map(size).map(|(most, least)| 8.0 * most * least * least);
        let volume = n as f64 / volumes.map(|volume| 1.0 / volume).sum::<f64>();
        let width = n as f64 / radii().map(|radius| 0.5 / radius).sum::<f64>();
        let around = |s: &usize| match model.shape_kind[*s] {
            ShapeKind::Sphere => model.shape_size[*s].x,
            _ => model.shape_size[*s].length(),
        };
        let mut lengths: Vec<f64> = shapes.iter().map(|s| 2.0 * around(s)).collect();
        lengths.sort_unstable_by(f64::total_cmp);
        let longest = lengths[n - 1 - (LONGER * n as f64) as usize];
        let spheres = Spheres {
            n,
            sphere: Buffer::of(device, "sphere", &rows)?,
            solid: match solids.is_empty() {
                true => Buffer::zeros(device, "solid", 1)?,
                false => Buffer::of(device, "solid", &solids)?,
            },
            rows: solids,
            hulls,
            margin: Buffer::zeros(device, "margin", n)?,
            fat_aabb: Buffer::zeros(device, "fat_aabb", n)?,
            bodies: rows.iter().map(|s| s.body).collect(),
            shapes,
            width,
            volume,
            longest,
        };
        Ok((spheres, scale))
    }
}
