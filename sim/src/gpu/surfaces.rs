//! Meshes and height fields as columns of a device: each triangle is a fixture, and trees of boxes tell which of them a shape may touch. Heights
//! over a triangle are exact before they are rounded; what is beside it is right to 5e-7 of its size.

use super::fault::Fault;
use super::fixed::Scale;
use super::kinds::TRIANGLE;
use super::rows::{Fixed, Fixture, Node};
use crate::geometry::Surface;
use crate::model::Model;
use crate::pose::Pose;
use glam::DVec3;

/// The end of a walk.
const END: u32 = u32::MAX;

/// The surface of a shape as rows.
#[derive(Default)]
pub struct Surfaces {
    /// The triangles of all surfaces, as fixtures.
    pub triangles: Vec<Fixture>,
    /// The boxes about them, each before those below it.
    pub nodes: Vec<Node>,
}

impl Surfaces {
    /// Take a surface at a place, whose own fixture is `own`; triangles follow after `n_before` fixtures. Returns the first of its nodes.
    ///
    /// # Errors
    /// [`Fault::Position`].
    pub fn push(
        &mut self,
        (model, scale, n_before): (&Model, Scale, usize),
        own: &Fixture,
        place: &Pose,
    ) -> Result<u32, Fault> {
        let surface = &model.surfaces[model.shape_part[own.shape as usize] as usize];
        let first = self.nodes.len();
        let walk = surface.walk();
        for branch in &walk {
            let start = self.triangles.len();
            for t in &branch.triangles {
                self.triangles.extend(triangle(surface, *t, scale, own, place)?);
            }
            let n = self.triangles.len() - start;
            let next = if branch.next == walk.len() { END } else { (first + branch.next) as u32 };
            let [low, high] = [branch.min.as_vec3(), branch.max.as_vec3()].map(|p| p.clamp(LEAST, -LEAST).to_array());
            let is_leaf = !branch.triangles.is_empty();
            let leaf = if is_leaf { ((n_before + start) as u32) << 3 | n as u32 } else { 0 };
            self.nodes.push(Node { low, leaf, high, next });
        }
        Ok(first as u32)
    }
}

/// The least finite corner.
const LEAST: glam::Vec3 = glam::Vec3::MIN;

/// The row of a triangle; none where it has no area.
fn triangle(surface: &Surface, t: u32, scale: Scale, own: &Fixture, place: &Pose) -> Result<Option<Fixture>, Fault> {
    let corners = surface.corners(t).map(|v| place.position + place.orientation * v);
    let Some(normal) = (corners[1] - corners[0]).cross(corners[2] - corners[0]).try_normalize() else {
        return Ok(None);
    };
    let fix = |p: DVec3| scale.fix(p).ok_or(Fault::Position(own.body));
    let [position, x_axis, y_axis] = [fix(corners[0])?, fix(corners[1])?, fix(corners[2])?];
    let half = Fixed { x: [surface.sharp[t as usize] as u32, t], y: [surface.is_ground() as u32, 0], z: [0; 2] };
    Ok(Some(Fixture { position, x_axis, y_axis, z_axis: Scale::axis(normal), half, kind: TRIANGLE, part: 0, ..*own }))
}
