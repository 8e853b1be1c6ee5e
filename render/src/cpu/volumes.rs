//! Volume shaders on rays that are traced: of what a ray goes through up to where it meets something (RISpec 5.1.6).
//!
//! A ray that meets a surface from within has gone through the inside of that primitive, whose interior shader is run. Where that has
//! none, or is met from outside, a ray that left the surface that it started from or passed last outwards runs the exterior shader of
//! that; by the normal there the way of the ray decides. What meets nothing goes through no volume that ends.

use crate::scene::attributes::Attributes;
use glam::{Mat4, Vec3};
use sl::Global;
use sl::machine::{BoundShader, Machine, Points, Scene, VariableSlots};
use std::sync::Arc;

/// A ray from where it started or passed a surface last, up to where it meets another.
pub struct Leg<'a> {
    /// Where it begins and ends, world space.
    pub from: Vec3,
    /// Where it ends.
    pub to: Vec3,
    /// Whether it leaves the surface where it begins outwards.
    pub outwards: bool,
    /// Whether it meets the surface where it ends from within.
    pub within: bool,
    /// Attributes of the surface where it begins, and of that where it ends.
    pub attributes: [&'a Attributes; 2],
}

impl<'a> Leg<'a> {
    /// The shader of what it goes through.
    fn volume(&self) -> Option<&'a (Arc<BoundShader>, Mat4)> {
        let [first, last] = self.attributes;
        let inside = last.interior.as_ref().filter(|_| self.within);
        inside.or(first.exterior.as_ref().filter(|_| self.outwards))
    }

    /// Run its volume shader over what comes along it, a colour and an opacity; `scene_of` has the scene as a shader of a space
    /// sees it.
    pub fn pass<S: Scene>(&self, [ci, oi]: [[f32; 3]; 2], scene_of: impl Fn(Mat4) -> S) -> [[f32; 3]; 2] {
        let Some((shader, space)) = self.volume() else { return [ci, oi] };
        let mut points = Points::new(1, 1, 1.0);
        let ends = [(Global::P, self.to), (Global::I, self.to - self.from), (Global::E, self.from)];
        ends.into_iter().for_each(|(global, value)| points.set(global, value.to_array().to_vec()));
        points.set(Global::Ci, ci.to_vec());
        points.set(Global::Oi, oi.to_vec());
        Machine::new().run_with(shader, &VariableSlots::default(), &mut points, &scene_of(*space));
        let triple = |global| match points.get(global) {
            Some(&[r, g, b]) => [r, g, b],
            _ => [0.0; 3],
        };
        [triple(Global::Ci), triple(Global::Oi)]
    }
}
