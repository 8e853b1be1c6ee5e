//! Spheres in their places.

use crate::aabb::Aabb;
use crate::model::Model;
use crate::state::State;
use glam::DVec3;

/// A sphere in its place: all that those who look for its contacts ask for, in one piece. It has the layout of a
/// [`Twist`](crate::twist::Twist), so that lanes load either alike.
#[derive(Clone, Copy, Debug, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Sphere {
    /// Its centre, m, world.
    pub centre: DVec3,
    /// Its radius and its margin, m.
    pub reach: f64,
    /// Its radius, m.
    pub radius: f64,
    /// The body that carries it.
    pub body: u32,
    /// Its material.
    pub material: u32,
}

impl Sphere {
    /// A shape that is a sphere; `margin` is how far from its surface contacts are looked for, m.
    #[inline]
    pub fn of(model: &Model, state: &State, s: usize, margin: f32) -> Sphere {
        Sphere { centre: state.shape_pose(model, s).position, ..Sphere::centred(model, state, s, margin) }
    }

    /// The same of a sphere about its body's centre.
    #[inline(always)]
    pub fn centred(model: &Model, state: &State, s: usize, margin: f32) -> Sphere {
        let (body, radius) = (model.shape_body[s], model.shape_size[s].x);
        let centre = state.position[body as usize];
        Sphere { centre, reach: radius + margin as f64, radius, body, material: model.shape_material[s] }
    }

    /// Whether another is within both margins.
    #[inline(always)]
    pub fn is_near(&self, other: &Sphere) -> bool {
        let reach = self.reach + other.reach;
        (self.centre - other.centre).length_squared() <= reach * reach
    }

    /// The box around it and its margin.
    #[inline(always)]
    pub fn tight(&self) -> Aabb {
        Aabb::about(self.centre, DVec3::splat(self.reach))
    }
}
