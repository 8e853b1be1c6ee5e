//! What the shaders of a kernel share: what the host offers and what they use of it, helper functions, categories of lights.

use super::super::bound::Answer;
use super::super::scene::Scene;
use crate::ir::{Ask, Lookup};
use std::collections::BTreeSet;
use std::fmt::{Display, Formatter};

/// A query of the scene that a host may answer by a WGSL function.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Query {
    /// `fn scene_transmission(start: vec3<f32>, end: vec3<f32>) -> vec3<f32>`: the fraction of light that passes, by colour channel.
    Transmission,
    /// `fn scene_openness(place: vec3<f32>, normal: vec3<f32>, up: vec3<f32>) -> vec3<f32>`: the sky's part of what [`Scene::openness`]
    /// answers; and `fn scene_surroundings(place: vec3<f32>, normal: vec3<f32>, up: vec3<f32>, sun: vec3<f32>) -> mat4x4<f32>`: the rest, as
    /// `surroundings` has it.
    Openness,
    /// `fn scene_hit(start: vec3<f32>, direction: vec3<f32>) -> f32`: the distance along a ray to the nearest surface, negative if
    /// there is none.
    Hit,
    /// `fn scene_map(map: u32, lookup: Lookup) -> vec4<f32>`: four channels of the map that [`Scene::map_number`] gives the number of.
    /// The kernel declares the struct `Lookup` (`parts/kernel.wgsl`).
    Map,
}

/// The host of kernels: the limits of its device, and how it answers queries.
#[derive(Clone, Copy)]
pub struct Host<'a> {
    /// Most invocations of a workgroup. A grid whose points look at their neighbours has at most as many points.
    pub group: u32,
    /// The queries that can be answered, with the text of their functions.
    pub functions: &'a [(Query, &'a str)],
    /// What any of these functions needs: written once, before the first. They read a grid's own numbers ([`super::Batch::give`]) from
    /// `values[work.own]` on; bindings from 7 on are the host's.
    pub declarations: &'a str,
    /// The scene, which is asked for strings when a kernel is written.
    pub scene: &'a dyn Scene,
}

/// Why a shader has no kernel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refused {
    /// Name of the shader.
    pub shader: String,
    /// What it does that no kernel can do: the end of the sentence "the shader `x` …".
    pub reason: String,
}

impl Display for Refused {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        write!(f, "the shader `{}` {}, which is not built for graphics devices", self.shader, self.reason)
    }
}

impl std::error::Error for Refused {}

/// A value that a shader reads of its host, besides globals and parameters.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Slot {
    /// The matrix from one coordinate system to another.
    Matrix { from: String, to: String },
    /// The inverse transpose of its upper left part.
    NormalMatrix { from: String, to: String },
    /// The number of a map.
    Map { how: Lookup, name: String },
    /// The answer to a query by name: `len` values of `width` numbers.
    Answer { what: Ask, names: Vec<String>, width: usize, len: usize },
}

/// A query by name whose answer is a string, and the answer.
pub(super) type Asked = (Ask, Vec<String>, Option<Answer>);

/// A shader of a light, as others call it.
pub(super) struct LightShader {
    /// Whether its points look at their neighbours.
    pub grid: bool,
    /// Whether it is ambient: it is summed, and not met by loops over lights.
    pub is_ambient: bool,
    /// Output parameters and other parameters: name, slot, width; and whether the light computes it.
    pub parameters: Vec<(String, usize, usize, bool)>,
}

/// The parts that stand between the shaders of a kernel.
pub(super) struct Module<'a> {
    pub host: Host<'a>,
    /// Whether workgroups shade whole grids.
    pub grid: bool,
    /// Shaders of lights, by their index less 1.
    pub lights: Vec<LightShader>,
    /// Categories that `illuminance` asks for.
    pub categories: Vec<String>,
    pub asked: Vec<Asked>,
    pub queries: BTreeSet<Query>,
    /// Functions that shaders call.
    pub functions: String,
}

impl Module<'_> {
    /// Whether a light's points look at their neighbours.
    pub fn has_grid_light(&self) -> bool {
        self.lights.iter().any(|light| light.grid)
    }

    /// Note that a query is used; false if the host does not answer it.
    pub fn uses(&mut self, query: Query) -> bool {
        self.queries.insert(query);
        self.host.functions.iter().any(|(q, _)| *q == query)
    }

    /// The bit of a category; none if there are too many.
    pub fn category(&mut self, name: &str) -> Option<u32> {
        let k = self.categories.iter().position(|c| c == name).unwrap_or_else(|| {
            self.categories.push(name.into());
            self.categories.len() - 1
        });
        (k < 32).then_some(k as u32)
    }
}
