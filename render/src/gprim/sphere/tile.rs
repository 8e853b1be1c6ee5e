//! A tile of the half of a sphere that the eye sees, by what its points follow from: a device makes them of it, to the bit as the processor.

use glam::{Mat3, Vec3};
use std::sync::Arc;

/// The most rings of a tile that a device dices.
pub const MOST_RINGS: usize = 256;

/// What the tiles of a sphere's cap have alike.
#[derive(Debug)]
pub struct CapSphere {
    /// The middle of the sphere, world.
    pub center: Vec3,
    /// Lattice directions to world, the radius in it, and to world normals.
    pub linear: Mat3,
    pub normals: Mat3,
    /// Towards the eye, and two directions across, in the space of the lattice.
    pub axes: [Vec3; 3],
    /// Cosine and sine of the angle from the eye's direction, by rings from the middle.
    pub rings: Vec<[f32; 2]>,
    /// The ring of the outline, and the angle of its normals and of those beyond.
    pub outline: (usize, [f32; 2]),
    /// 1, or −1 where normals point into the sphere.
    pub outward: f32,
}

/// A tile of a sphere's cap.
#[derive(Clone, Debug)]
pub struct CapTile {
    pub sphere: Arc<CapSphere>,
    /// Column and row of the first point, from the middle.
    pub first: [i32; 2],
}

impl CapTile {
    /// The place of a point, by rows of `nu`, in the world.
    pub fn place(&self, nu: usize, point: usize) -> Vec3 {
        let (a, b) = (self.first[0] + (point % nu) as i32, self.first[1] + (point / nu) as i32);
        let CapSphere { center, linear, axes: [to_eye, across, up], rings, .. } = &*self.sphere;
        let [x, y] = direction(a, b, eighth);
        let [cos, sin] = rings[a.abs().max(b.abs()) as usize];
        *center + *linear * (*to_eye * cos + (*across * x + *up * y) * sin)
    }
}

/// Cosine and sine of the point of a ring so far along an eighth of it.
pub fn eighth(ring: usize, along: usize) -> [f32; 2] {
    let (sin, cos) = (std::f32::consts::FRAC_PI_4 * along as f32 / ring.max(1) as f32).sin_cos();
    [cos, sin]
}

/// [`eighth`] of all rings, each after those within it.
pub fn eighths() -> Vec<[f32; 2]> {
    (0..MOST_RINGS).flat_map(|ring| (0..=ring).map(move |along| eighth(ring, along))).collect()
}

/// The direction of the point of a square lattice on a disk, by column and row from the middle, of the points of an eighth of its rings.
pub fn direction(a: i32, b: i32, mut eighth: impl FnMut(usize, usize) -> [f32; 2]) -> [f32; 2] {
    let (x, y) = (a.unsigned_abs() as usize, b.unsigned_abs() as usize);
    let [near, far] = eighth(x.max(y), x.min(y));
    let (cos, sin) = if x >= y { (near, far) } else { (far, near) };
    [if a < 0 { -cos } else { cos }, if b < 0 { -sin } else { sin }]
}
