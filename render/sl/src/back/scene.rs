//! The scene around a grid, as shaders ask it.

use super::bound::{Answer, BoundShader};
use crate::ir::{Ask, Global, Lookup};
use std::sync::Arc;

/// The queries that a shader makes of the scene. A query for many points is one call, so that it can be answered in bulk; its
/// answers go to a slice of the same length as the queries. All positions and directions are in the current space.
pub trait Scene {
    /// The lights that illuminate the grid.
    fn lights(&self) -> &[Arc<BoundShader>];
    /// The matrix from one named coordinate system to another, column-major for column vectors; `None` if a name is unknown.
    fn matrix(&self, from: &str, to: &str) -> Option<[f32; 16]>;
    /// The fraction of light that passes along each segment, by colour channel: 1 all, 0 none.
    fn transmission(&self, _segments: &[Segment], light: &mut [[f32; 3]]) {
        light.fill([1.0; 3]);
    }
    /// How much of the sky's light gets to places on a surface: of an even sky above the horizon, of one whose light grows with the
    /// sine of the height, and of what is below the horizon; each as a part of what the upper side of a plane in the open gets of light
    /// from all directions that is as bright as at the zenith, or below. By default nothing is in the way.
    fn openness(&self, places: &[OpenPlace], open: &mut [Open]) {
        let height = |p: &OpenPlace| (0..3).map(|c| p.normal[c] * p.up[c]).sum::<f32>();
        places.iter().zip(open).for_each(|(place, open)| {
            let sky = open_to(height(place));
            *open = Open { sky, low: sky[2], ..Open::default() };
        });
    }
    /// Sample points on an area light, for `n` points that it lights: `_light` is the light's index in [`Scene::lights`], `_place`
    /// gives the position of a lit point by its index. `None` if the light is no area light.
    fn emitter(&self, _light: usize, _n: usize, _place: &dyn Fn(usize) -> [f32; 3]) -> Option<Emitter> {
        None
    }
    /// Times at which the shutter opens and closes.
    fn shutter(&self) -> [f32; 2] {
        [0.0; 2]
    }
    /// Warn of an index that is out of its range at a place of a shader.
    fn outside(&self, _place: &str, _index: f32, message: String) {
        self.warn(message);
    }
    /// Where the eye is.
    fn eye(&self) -> [f32; 3] {
        [0.0; 3]
    }
    /// Answer a query by name; `None` if the scene has no answer.
    fn ask(&self, _what: Ask, _names: &[&str]) -> Option<Answer> {
        None
    }
    /// Look up four channels of a map for each query; the queries of one call differ only in position.
    fn map(&self, _queries: &[MapQuery<'_>], values: &mut [[f32; 4]]) {
        values.fill([0.0; 4]);
    }
    /// Why lookups in a map give 0, if they do whatever is asked; `_along_ray` says that they are a light's, along its ray.
    fn map_fault(&self, _how: Lookup, _name: &str, _along_ray: bool) -> Option<String> {
        None
    }
    /// The number by which the functions of a device know a map ([`crate::wgsl::Query::Map`]), below 2²⁴.
    fn map_number(&self, _how: Lookup, _name: &str) -> u32 {
        0
    }
    /// The distance along each ray to the nearest surface; `None` where it hits no surface.
    fn hit(&self, _rays: &[Ray], distances: &mut [Option<f32>]) {
        distances.fill(None);
    }
    /// How much of what comes along each ray from afar surfaces hold back: 1 where one is opaque.
    fn hidden(&self, rays: &[Ray], hidden: &mut [f32]) {
        let mut distances = vec![None; rays.len()];
        self.hit(rays, &mut distances);
        hidden.iter_mut().zip(distances).for_each(|(hidden, distance)| *hidden = distance.is_some() as u8 as f32);
    }
    /// Whether rays from this grid are traced: not where the maximum ray depth is reached. `_many` as for [`Scene::trace`].
    fn traces(&self, _many: bool) -> bool {
        false
    }
    /// The colour that each ray brings back. `_many` says that each ray is one of many from its point, as for indirect diffuse
    /// light.
    fn trace(&self, _rays: &[Ray], _many: bool, colors: &mut [[f32; 3]]) {
        colors.fill([0.0; 3]);
    }
    /// Take that the loops of a shader do not end, as a message ([`is_stopped`](Scene::is_stopped)).
    fn stop(&self, _message: &str) {}
    /// Whether a shader's loops did not end, so that no loop is to go on.
    fn is_stopped(&self) -> bool {
        false
    }
    /// Take a warning about a shader; by default it is dropped.
    fn warn(&self, _message: String) {}
    /// Take the text that `printf` prints; by default it is dropped.
    fn print(&self, _text: &str) {}
}

/// [`Scene::openness`] of a surface in the open, by the cosine of its normal and up: the second is 2/3 of a plane that faces up, 2/(3π)
/// of one that faces the horizon, and interpolated between these and 0.
pub fn open_to(cosine: f32) -> [f32; 3] {
    let above = (0.5 + 0.5 * cosine).clamp(0.0, 1.0);
    [above, 2.0 / 3.0 * above.powf(1.651_496), 1.0 - above]
}

/// How open a place is, and what is in the way.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Open {
    /// The parts of the sky's light that get there; of the ground's, what spheres let through.
    pub sky: [f32; 3],
    /// The last, as all that is in the way lets it through.
    pub low: f32,
    /// How much of what lights the surface is closed.
    pub closed: f32,
    /// The mean colour of what closes it.
    pub color: [f32; 3],
    /// What it gets from a sun of 1 by way of white bodies that close it.
    pub lit: f32,
}

/// A place on a surface that looks at the sky: position, unit normal, unit direction up and to the sun, in the current space.
#[derive(Clone, Copy, Debug)]
pub struct OpenPlace {
    /// Position.
    pub at: [f32; 3],
    /// Normal.
    pub normal: [f32; 3],
    /// Up.
    pub up: [f32; 3],
    /// The way to the sun, 0 for none.
    pub sun: [f32; 3],
}

/// A ray, in the current space.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Origin of the ray.
    pub from: [f32; 3],
    /// Direction of the ray, of unit length.
    pub direction: [f32; 3],
}

/// The segment from one point to another, in the current space.
#[derive(Clone, Copy, Debug)]
pub struct Segment {
    /// Start point.
    pub from: [f32; 3],
    /// End point.
    pub to: [f32; 3],
}

/// Sample points on an area light, one for each of the n points that it lights.
pub struct Emitter {
    /// The sample points as three runs, all x, all y, all z; `[3 n]`.
    pub points: Vec<f32>,
    /// The area light's normals at the sample points, as three runs; `[3 n]`.
    pub normals: Vec<f32>,
    /// The fraction of the area light's emission that one sample stands for: 1 over the count of samples.
    pub part: f32,
}

/// A scene of lights alone, for shaders that run without a renderer: no coordinate system has a matrix, no surface blocks light,
/// and printed text is dropped.
pub struct Lights(pub Vec<Arc<BoundShader>>);

impl Scene for Lights {
    fn lights(&self) -> &[Arc<BoundShader>] {
        &self.0
    }
    fn matrix(&self, _: &str, _: &str) -> Option<[f32; 16]> {
        None
    }
}

/// Options of lookups (RISpec 15.7); of `filter` there is one alone.
pub(super) const OPTIONS: [&str; 10] =
    ["blur", "sblur", "tblur", "width", "swidth", "twidth", "fill", "samples", "bias", "filter"];

/// The warning of an option that is none of these.
pub(super) fn unknown_option(map: &str, key: &str) -> String {
    let known = OPTIONS.join(", ");
    format!("a lookup in the map `{map}` has the unknown option `{key}`, expected {known}")
}

/// What is said of a question that has no answer: that the texture cannot be read whose properties it asks for. Whether there is one may be
/// asked of any.
pub(super) fn asked_in_vain(what: Ask, names: &[&str], scene: &dyn Scene) -> Option<String> {
    match (what, names) {
        (Ask::TextureInfo, [texture, _]) => scene.map_fault(Lookup::Texture, texture, false),
        _ => None,
    }
}

/// What is said of the first of two spaces that a scene does not know.
pub(super) fn unknown_space(scene: &dyn Scene, spaces: [&str; 2]) -> Option<String> {
    let unknown = spaces.into_iter().find(|space| scene.matrix(space, space).is_none())?;
    Some(format!("names the unknown space `{unknown}`; world space is taken"))
}

/// A lookup in a map at one point.
#[derive(Clone, Copy, Debug)]
pub struct MapQuery<'a> {
    /// The kind of the lookup.
    pub how: Lookup,
    /// Name of the map.
    pub name: &'a str,
    /// The first of the four channels, from 0.
    pub channel: usize,
    /// s and t, a direction, or a position.
    pub at: [f32; 3],
    /// Change of `at` to the next point of the grid, along its rows and along its columns; the filter's area is made from these.
    pub change: [[f32; 3]; 2],
    /// Factor on the filter's width.
    pub width: f32,
    /// Blur along s and t, as fractions of the map's width.
    pub blur: [f32; 2],
    /// Value of channels that the map does not have.
    pub fill: f32,
    /// Count of samples, for maps that are sampled.
    pub samples: f32,
    /// Bias of a shadow lookup.
    pub bias: f32,
    /// In a light shader, the position that the light comes from.
    pub light: Option<[f32; 3]>,
}

/// What a global variable has that nobody has set; nothing if that is 0.
pub(super) fn unset(global: Global, scene: &dyn Scene) -> Vec<f32> {
    let [open, close] = scene.shutter();
    match global {
        Global::Ncomps => vec![3.0],
        Global::Time => vec![open],
        Global::Dtime => vec![close - open],
        Global::E => scene.eye().to_vec(),
        _ => vec![],
    }
}
