//! Spheres in world coordinates.

use crate::aabb::Aabb;
use crate::model::Model;
use crate::state::State;
use glam::DVec3;

/// A sphere in world coordinates: the data that the narrow phase reads of it, in one record. It has the layout of a
/// [`Twist`](crate::twist::Twist), so that lanes load both in the same way.
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Sphere {
    /// Centre, m, world.
    pub centre: DVec3,
    /// Radius plus margin, m.
    pub reach: f64,
    /// Radius, m.
    pub radius: f64,
    /// Id of the body.
    pub body: u32,
    /// Index of the material.
    pub material: u32,
}

impl Sphere {
    /// The sphere of shape `s`; `margin` is the distance from its surface within which contacts are generated, m.
    #[inline]
    pub fn of(model: &Model, state: &State, s: usize, margin: f32) -> Sphere {
        Sphere { centre: state.shape_pose(model, s).position, ..Sphere::centred(model, state, s, margin) }
    }

    /// The sphere of shape `s`, which is about its body's centre of mass.
    #[inline(always)]
    pub fn centred(model: &Model, state: &State, s: usize, margin: f32) -> Sphere {
        let (body, radius) = (model.shape_body[s], model.shape_size[s].x);
        let centre = state.position[body as usize];
        Sphere { centre, reach: radius + margin as f64, radius, body, material: model.shape_material[s] }
    }

    /// Whether the spheres with their margins overlap or touch.
    #[inline(always)]
    pub fn is_near(&self, other: &Sphere) -> bool {
        let reach = self.reach + other.reach;
        (self.centre - other.centre).length_squared() <= reach * reach
    }

    /// The tight AABB of the sphere with its margin.
    #[inline(always)]
    pub fn tight(&self) -> Aabb {
        Aabb::about(self.centre, DVec3::splat(self.reach))
    }
}
