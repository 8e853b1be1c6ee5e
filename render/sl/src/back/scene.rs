//! The scene around a grid, as shaders ask it.

use super::bound::{Answer, BoundShader};
use crate::ir::{Ask, Lookup};
use std::sync::Arc;

/// What a shader asks of the scene around the grid.
pub trait Scene {
    /// The lights that shine on the grid.
    fn lights(&self) -> &[Arc<BoundShader>];
    /// The matrix from one named space to another, 16 numbers column after column for column vectors.
    fn matrix(&self, from: &str, to: &str) -> Option<[f32; 16]>;
    /// How much light gets from one point to another: 1 all, 0 none.
    fn transmission(&self, from: [f32; 3], to: [f32; 3]) -> [f32; 3];
    /// Where on an area light its light of a number in [`Scene::lights`] is, for `n` places that it lights.
    fn emitter(&self, _light: usize, _n: usize, _place: &dyn Fn(usize) -> [f32; 3]) -> Option<Emitter> {
        None
    }
    /// What the scene knows under some names.
    fn ask(&self, _what: Ask, _names: &[&str]) -> Option<Answer> {
        None
    }
    /// Four channels of a map.
    fn map(&self, _query: &MapQuery) -> [f32; 4] {
        [0.0; 4]
    }
    /// How far along a direction (of unit length) the nearest surface is.
    fn hit(&self, _from: [f32; 3], _direction: [f32; 3]) -> Option<f32> {
        None
    }
    /// Whether rays from here are followed at all: not where they have come too deep.
    fn traces(&self, _many: bool) -> bool {
        false
    }
    /// The colour that a ray brings back; `many` says that it is one of many from its point, as for light from all around.
    fn trace(&self, _from: [f32; 3], _direction: [f32; 3], _many: bool) -> [f32; 3] {
        [0.0; 3]
    }
    /// Take what `printf` prints.
    fn print(&self, text: &str) {
        eprint!("{text}");
    }
}

/// Points of an area light, one for each place that it lights.
pub struct Emitter {
    /// The points, as three runs.
    pub points: Vec<f32>,
    /// The normals there, likewise.
    pub normals: Vec<f32>,
    /// The part of the light that they stand for.
    pub part: f32,
}

/// A scene of lights alone: every space is the world, nothing is in the way, and what is printed is dropped.
pub struct Lights(pub Vec<Arc<BoundShader>>);

impl Scene for Lights {
    fn lights(&self) -> &[Arc<BoundShader>] {
        &self.0
    }
    fn matrix(&self, _: &str, _: &str) -> Option<[f32; 16]> {
        None
    }
    fn transmission(&self, _: [f32; 3], _: [f32; 3]) -> [f32; 3] {
        [1.0; 3]
    }
    fn print(&self, _: &str) {}
}

/// A question for a map.
#[derive(Clone, Debug)]
pub struct MapQuery<'a> {
    /// How it is looked up.
    pub how: Lookup,
    /// Its name.
    pub name: &'a str,
    /// The first channel.
    pub channel: usize,
    /// s and t, a direction, or a place.
    pub at: [f32; 3],
    /// How that changes to the next point of the grid, along its rows and its columns.
    pub change: [[f32; 3]; 2],
    /// Factor of the filter's width.
    pub width: f32,
    /// Blur, a part of the whole map.
    pub blur: f32,
    /// Samples, where the map is sampled.
    pub samples: f32,
    /// Bias of a shadow map.
    pub bias: f32,
    /// In a light shader: where the light comes from.
    pub light: Option<[f32; 3]>,
}
