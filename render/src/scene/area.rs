//! Area lights: a light shader is run for points on the primitives of its light, spread evenly by area, and each is a light of its
//! own to the surface shader (RISpec 5.2.2).
//!
//! The points are other ones at every place that is lit, so that a penumbra is smooth up to noise and not a stack of hard shadows.

use crate::scene::facets::{Cut, facets_of};
use crate::scene::shape::Shape;
use glam::{Mat3, Mat4, Vec3};
use sl::machine::BoundShader;
use std::sync::Arc;

/// Points of a light that are lit from if no attribute says.
pub const SAMPLES: usize = 16;

/// A part of a light's surface, world space.
enum Piece {
    /// Made of the unit sphere; 1, or −1 if its inside is out.
    Sphere(Mat4, f32),
    /// A corner and the edges from it.
    Triangle(Vec3, Vec3, Vec3),
}

/// The surface of an area light.
#[derive(Default)]
pub struct Area {
    pieces: Vec<Piece>,
    /// Area of each piece and all before it.
    sums: Vec<f32>,
}

impl Area {
    /// Add a primitive; `reversed` if its inside is out.
    pub fn add(&mut self, shape: &Shape, to_world: Mat4, reversed: bool) {
        match shape {
            Shape::Sphere => {
                // Of an ellipsoid, Thomsen's formula, right to a hundredth.
                let [x, y, z] = [to_world.x_axis, to_world.y_axis, to_world.z_axis].map(|a| a.truncate().length());
                let p = 1.6075f32;
                let mean = ((x * y).powf(p) + (x * z).powf(p) + (y * z).powf(p)) / 3.0;
                self.push(
                    Piece::Sphere(to_world, if reversed { -1.0 } else { 1.0 }),
                    4.0 * std::f32::consts::PI * mean.powf(1.0 / p),
                );
            }
            Shape::Patches(patches, _) => {
                let turned = reversed != (to_world.determinant() < 0.0);
                for [a, b, c] in patches.iter().flat_map(|p| facets_of(p, Cut::even(p), to_world)) {
                    let (ab, ac) = if turned { (c - a, b - a) } else { (b - a, c - a) };
                    self.push(Piece::Triangle(a, ab, ac), 0.5 * ab.cross(ac).length());
                }
            }
        }
    }

    fn push(&mut self, piece: Piece, area: f32) {
        if area > 0.0 && area.is_finite() {
            self.pieces.push(piece);
            self.sums.push(self.area() + area);
        }
    }

    /// All of it.
    pub fn area(&self) -> f32 {
        self.sums.last().copied().unwrap_or(0.0)
    }

    /// The point of it for two numbers from 0 to 1, and the normal there; none if it has no area.
    pub fn point(&self, [u, v]: [f32; 2]) -> Option<(Vec3, Vec3)> {
        let at = u * self.area();
        let i = self.sums.partition_point(|s| *s <= at).min(self.pieces.len().checked_sub(1)?);
        let before = if i > 0 { self.sums[i - 1] } else { 0.0 };
        // What is left of the first number spreads the points in the piece.
        let u = ((at - before) / (self.sums[i] - before)).clamp(0.0, 1.0);
        Some(match &self.pieces[i] {
            Piece::Sphere(m, sign) => {
                let z = 1.0 - 2.0 * u;
                let r = (1.0 - z * z).max(0.0).sqrt();
                let (s, c) = (v * std::f32::consts::TAU).sin_cos();
                let d = Vec3::new(r * c, r * s, z);
                let normals = Mat3::from_mat4(*m).inverse().transpose();
                (m.transform_point3(d), (normals * d).normalize_or_zero() * *sign)
            }
            Piece::Triangle(a, ab, ac) => {
                let r = u.sqrt();
                (*a + *ab * (r * (1.0 - v)) + *ac * (r * v), ab.cross(*ac).normalize_or_zero())
            }
        })
    }
}

/// Which point of which area light a light of a list is; none if it is no area light.
pub type Emitter = Option<(u32, u32)>;

/// A light of the stream that has an area.
pub struct AreaLight {
    /// The shader.
    pub shader: Arc<BoundShader>,
    /// Points of it that are lit from.
    pub samples: usize,
    /// Its surface.
    pub area: Area,
}
