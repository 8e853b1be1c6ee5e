//! The scene around a grid, as shaders ask it.

use super::bound::{Answer, BoundShader};
use crate::ir::{Ask, Lookup};
use std::sync::Arc;

/// What a shader asks of the scene around the grid. Where a question is asked at many points it comes once for all of them, so
/// that it may be answered in bulk; answers go to a slice of the same length.
pub trait Scene {
    /// The lights that shine on the grid.
    fn lights(&self) -> &[Arc<BoundShader>];
    /// The matrix from one named space to another, 16 numbers column after column for column vectors.
    fn matrix(&self, from: &str, to: &str) -> Option<[f32; 16]>;
    /// How much light gets along segments: 1 all, 0 none.
    fn transmission(&self, _segments: &[Segment], light: &mut [[f32; 3]]) {
        light.fill([1.0; 3]);
    }
    /// Where on an area light its light of an index in [`Scene::lights`] is, for `n` places that it lights.
    fn emitter(&self, _light: usize, _n: usize, _place: &dyn Fn(usize) -> [f32; 3]) -> Option<Emitter> {
        None
    }
    /// What the scene knows under some names.
    fn ask(&self, _what: Ask, _names: &[&str]) -> Option<Answer> {
        None
    }
    /// Four channels of a map, for queries that differ in their places alone.
    fn map(&self, _queries: &[MapQuery<'_>], values: &mut [[f32; 4]]) {
        values.fill([0.0; 4]);
    }
    /// How far along rays the nearest surface is.
    fn hit(&self, _rays: &[Ray], distances: &mut [Option<f32>]) {
        distances.fill(None);
    }
    /// Whether rays from here are followed at all: not where they have come too deep.
    fn traces(&self, _many: bool) -> bool {
        false
    }
    /// The colours that rays bring back; `many` says that each is one of many from its point, as for light from all around.
    fn trace(&self, _rays: &[Ray], _many: bool, colors: &mut [[f32; 3]]) {
        colors.fill([0.0; 3]);
    }
    /// Take what `printf` prints.
    fn print(&self, text: &str) {
        eprint!("{text}");
    }
}

/// A ray.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Where it starts.
    pub from: [f32; 3],
    /// Its direction, of unit length.
    pub direction: [f32; 3],
}

/// From one point to another.
#[derive(Clone, Copy, Debug)]
pub struct Segment {
    /// Where it starts.
    pub from: [f32; 3],
    /// Where it ends.
    pub to: [f32; 3],
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
    fn print(&self, _: &str) {}
}

/// A question for a map.
#[derive(Clone, Copy, Debug)]
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
