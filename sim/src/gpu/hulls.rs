//! The convex hulls of a model as a column of a device.

use crate::geometry::Hull;
use crate::model::Model;
use crate::shape::ShapeKind;
use glam::DVec3;
use gpu::{Buffer, Device, GpuError};

/// Bits of the number of corners in the word of a face.
const BITS: u32 = 5;

/// The column.
pub struct Hulls {
    /// Rows of all hulls, as `hulls_with.wgsl` reads them.
    pub hull: Buffer<[u32; 4]>,
    /// First row of each hull.
    place: Vec<u32>,
}

impl Hulls {
    /// The hulls of a model.
    ///
    /// # Errors
    /// Those of [`Buffer::zeros`].
    pub fn new(device: &Device, model: &Model) -> Result<Hulls, GpuError> {
        let (mut all, mut place) = (vec![], vec![]);
        for hull in &model.hulls {
            place.push(all.len() as u32);
            all.extend(rows(hull));
        }
        Ok(Hulls { hull: Buffer::of(device, "hull", &all)?, place })
    }

    /// The first row of the hull of a shape; 0 for a shape of another kind.
    pub fn of(&self, model: &Model, s: usize) -> u32 {
        match model.shape_kind[s] {
            ShapeKind::Hull => self.place[model.shape_part[s] as usize],
            _ => 0,
        }
    }
}

/// The rows of a hull.
fn rows(hull: &Hull) -> Vec<[u32; 4]> {
    let (n_vertices, n_faces) = (hull.vertices.len(), hull.faces.len());
    let point = |p: &DVec3, last: u32| {
        let [x, y, z] = p.as_vec3().to_array().map(f32::to_bits);
        [x, y, z, last]
    };
    let mut rows = vec![[n_vertices as u32, n_faces as u32, 0, 0]];
    rows.extend(hull.vertices.iter().map(|v| point(v, 0)));
    let mut corners: Vec<u32> = vec![];
    let first = 4 * (1 + n_vertices + n_faces) as u32;
    for (face, normal) in hull.faces.iter().zip(&hull.normals) {
        let of_face = first + corners.len() as u32;
        corners.extend(Hull::corners_of(face));
        let n = first + corners.len() as u32 - of_face;
        rows.push(point(normal, n | of_face << BITS));
    }
    corners.resize(corners.len().next_multiple_of(4), 0);
    rows.extend(corners.as_chunks::<4>().0);
    rows
}
