//! The scene: sources of primitives, held by reference; an item is one primitive of a source.

use crate::cpu::bvh::Bvh;
use crate::gprim::trim::Trim;
use crate::scene::area::AreaLight;
use crate::scene::camera::Camera;
use crate::scene::options::Attributes;
use crate::texture::Textures;
use glam::{Mat4, Quat, Vec3};
use ri::{Instances, Param, Values};
use sl::ir::Ask;
use sl::machine::Answer;
use std::collections::HashMap;
use std::sync::{Arc, Mutex};

/// A primitive in its object space.
#[derive(Clone, Debug)]
pub enum Shape {
    /// A whole sphere of radius 1; its size is in the transformation.
    Sphere,
    /// Bicubic patches.
    Patches(Arc<Vec<Patch>>),
}

/// A bicubic Bézier patch with its corner values.
#[derive(Clone, Debug)]
pub struct Patch {
    /// Control points, u fastest.
    pub p: [Vec3; 16],
    /// u and v at the corners (0,0), (1,0), (0,1), (1,1).
    pub uv: [[f32; 2]; 4],
    /// s and t at the corners.
    pub st: [[f32; 2]; 4],
    /// Varying variables: name and values at the four corners, `width` each.
    pub varying: Vec<(String, Vec<f32>)>,
    /// Variables that are the same all over.
    pub uniform: Vec<(String, Vec<f32>)>,
    /// Flat, so that it cannot shadow itself.
    pub flat: bool,
    /// What of it is cut away.
    pub trim: Option<Arc<Trim>>,
    /// Control points later on, by the part of the time that the shutter is open then.
    pub moves: Vec<(f32, [Vec3; 16])>,
}

/// What a source repeats.
pub enum SourceShape {
    /// One primitive.
    One(Shape),
    /// Spheres by columns.
    Spheres(Instances),
    /// Objects by columns: each has all these parts with their places in the object.
    Objects(Instances, Arc<Vec<(Shape, Mat4)>>),
}

/// Primitives that share attributes and a transformation.
pub struct Source {
    /// The primitives.
    pub shape: SourceShape,
    /// Object to world.
    pub to_world: Mat4,
    /// The same later on, by the part of the time that the shutter is open then.
    pub moves: Vec<(f32, Mat4)>,
    /// Attributes.
    pub attributes: Arc<Attributes>,
    /// Uniform primitive variables.
    pub uniform: Vec<(String, Vec<f32>)>,
}

/// Source and index within it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Item {
    /// Index into the sources.
    pub source: u32,
    /// Index within the source.
    pub index: u32,
}

/// One primitive, looked up.
pub struct ItemView<'a> {
    /// Its shape.
    pub shape: &'a Shape,
    /// Shape to world.
    pub to_world: Mat4,
    /// Object space to world: as `to_world`, but without the scale that is a sphere's radius.
    pub object_to_world: Mat4,
    /// Attributes.
    pub attributes: &'a Attributes,
    /// Colour.
    pub color: [f32; 3],
    /// The source, for its uniform variables.
    pub source: &'a Source,
    /// The instance.
    pub instance: Option<(&'a Instances, usize)>,
    /// How far an instance moves in its source while the shutter is open.
    pub shift: Vec3,
}

/// All that is drawn.
#[derive(Default)]
pub struct Scene {
    /// Primitives.
    pub sources: Vec<Source>,
    /// Named coordinate systems, to world.
    pub spaces: HashMap<String, Mat4>,
    /// Camera to world.
    pub camera_to_world: Mat4,
    /// Options for shaders that ask, by `group:name` and by their own names.
    pub options: Vec<(String, Answer)>,
    /// Near and far, for shaders that ask.
    pub clipping: [f32; 2],
    /// Pictures that shaders look up.
    pub textures: Textures,
    /// Lights that have an area.
    pub area_lights: Vec<AreaLight>,
    /// For shadows; made at `WorldEnd`.
    pub bvh: Bvh,
    /// What is odd about the scene, once each.
    pub warnings: Mutex<Vec<String>>,
    /// Displacement bounds that are needed, by shader.
    pub bounds: Mutex<HashMap<String, f32>>,
}

static WHOLE_SPHERE: Shape = Shape::Sphere;

impl Source {
    /// Number of items.
    pub fn len(&self) -> usize {
        match &self.shape {
            SourceShape::One(_) => 1,
            SourceShape::Spheres(columns) => columns.len(),
            SourceShape::Objects(columns, parts) => columns.len() * parts.len(),
        }
    }

    /// Whether it has no items.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

impl Scene {
    /// All items, in order.
    pub fn items(&self) -> impl Iterator<Item = Item> + '_ {
        self.sources
            .iter()
            .enumerate()
            .flat_map(|(s, source)| (0..source.len()).map(move |i| Item { source: s as u32, index: i as u32 }))
    }

    /// Whether anything moves while the shutter is open.
    pub fn moves(&self, camera: &Camera) -> bool {
        let deforms = |shape: &Shape| match shape {
            Shape::Patches(patches) => patches.iter().any(|p| !p.moves.is_empty()),
            Shape::Sphere => false,
        };
        !camera.moves.is_empty()
            || self.sources.iter().any(|source| {
                !source.moves.is_empty()
                    || match &source.shape {
                        SourceShape::One(shape) => deforms(shape),
                        SourceShape::Spheres(columns) => columns.moved.is_some(),
                        SourceShape::Objects(columns, parts) => {
                            columns.moved.is_some() || parts.iter().any(|(shape, _)| deforms(shape))
                        }
                    }
            })
    }

    /// The number of the first item of each source among all, from 1.
    pub fn numbers(&self) -> Vec<usize> {
        let next = |next: &mut usize, source: &Source| Some(std::mem::replace(next, *next + source.len()));
        self.sources.iter().scan(1, next).collect()
    }

    /// The attributes of an item.
    pub fn attributes(&self, item: Item) -> &Attributes {
        &self.sources[item.source as usize].attributes
    }

    /// Look an item up.
    pub fn view(&self, item: Item) -> ItemView<'_> {
        let source = &self.sources[item.source as usize];
        let i = item.index as usize;
        let attributes = &*source.attributes;
        let (shape, place, object, instance) = match &source.shape {
            SourceShape::One(shape) => (shape, Mat4::IDENTITY, Mat4::IDENTITY, None),
            SourceShape::Spheres(columns) => {
                (&WHOLE_SPHERE, columns.matrix(i), unscaled(columns, i), Some((columns, i)))
            }
            SourceShape::Objects(columns, parts) => {
                let (k, part) = (i / parts.len(), &parts[i % parts.len()]);
                let place = columns.matrix(k) * part.1;
                (&part.0, place, columns.matrix(k), Some((columns, k)))
            }
        };
        let color = instance.and_then(|(columns, i)| instance_color(columns, i)).unwrap_or(attributes.color);
        let (to_world, object_to_world) = (source.to_world * place, source.to_world * object);
        let shift = instance.and_then(|(columns, i)| {
            let (_, to) = columns.moved.as_ref()?;
            Some(Vec3::from(to[i]) - Vec3::from(columns.position[i]))
        });
        let shift = shift.unwrap_or(Vec3::ZERO);
        ItemView { shape, to_world, object_to_world, attributes, color, source, instance, shift }
    }

    /// The place of an item for shadows and bounds alone: shape and its matrix to world.
    pub fn place(&self, item: Item) -> (&Shape, Mat4) {
        let source = &self.sources[item.source as usize];
        let i = item.index as usize;
        match &source.shape {
            SourceShape::One(shape) => (shape, source.to_world),
            SourceShape::Spheres(columns) => (&WHOLE_SPHERE, source.to_world * columns.matrix(i)),
            SourceShape::Objects(columns, parts) => {
                let part = &parts[i % parts.len()];
                (&part.0, source.to_world * columns.matrix(i / parts.len()) * part.1)
            }
        }
    }

    /// The matrix from one named space to another; `own` knows those of who asks.
    pub fn matrix(&self, from: &str, to: &str, own: &dyn Fn(&str) -> Option<Mat4>) -> Option<[f32; 16]> {
        let to_world = |space: &str| match space {
            "current" | "world" => Some(Mat4::IDENTITY),
            "camera" | "eye" => Some(self.camera_to_world),
            named => {
                let found = own(named).or_else(|| self.spaces.get(named).copied());
                if found.is_none() {
                    self.warn(format!("a shader names the unknown space `{named}`; world space is taken"));
                }
                found
            }
        };
        Some((to_world(to)?.inverse() * to_world(from)?).to_cols_array())
    }

    /// What shaders ask of the whole picture.
    pub fn ask(&self, what: Ask, names: &[&str]) -> Option<Answer> {
        let numbers = |v: &[f32]| Some(Answer::Numbers(v.to_vec()));
        match (what, names) {
            (Ask::Option, ["Clipping"]) => numbers(&self.clipping),
            (Ask::Option, [name]) => self.options.iter().find(|(n, _)| n == name).map(|(_, v)| v.clone()),
            (Ask::TextureInfo, [texture, what]) => match *what {
                "resolution" => numbers(&self.textures.resolution(texture, self)?),
                "exists" => numbers(&[self.textures.resolution(texture, self).is_some() as u8 as f32]),
                "channels" => self.textures.resolution(texture, self).and_then(|_| numbers(&[4.0])),
                "type" => Some(Answer::Text("texture".into())),
                _ => None,
            },
            _ => None,
        }
    }

    /// Note how far a displacement shader moves a point beyond its bound, as the bound that it needs in object units.
    pub fn needs_bound(&self, shader: &str, bound: f32) {
        let mut needed = self.bounds.lock().unwrap_or_else(|e| e.into_inner());
        let known = needed.entry(shader.into()).or_insert(0.0);
        *known = known.max(bound);
    }

    /// What is odd about the scene, taken out of it.
    pub fn take_warnings(&self) -> Vec<String> {
        let mut needed: Vec<(String, f32)> = self.bounds.lock().unwrap_or_else(|e| e.into_inner()).drain().collect();
        needed.sort_by(|a, b| a.0.cmp(&b.0));
        for (shader, bound) in needed {
            self.warn(format!(
                "displacement `{shader}` reaches farther than its bound, so that some of it may be missing: `Attribute \"displacementbound\" \"sphere\" [{}]` is needed",
                (bound * 1.01 * 1e4).ceil() / 1e4
            ));
        }
        std::mem::take(&mut *self.warnings.lock().unwrap_or_else(|e| e.into_inner()))
    }

    /// Remember an oddity, once.
    pub fn warn(&self, message: String) {
        let mut warnings = self.warnings.lock().unwrap_or_else(|e| e.into_inner());
        if !warnings.contains(&message) {
            warnings.push(message);
        }
    }
}

/// The object space of a sphere: a ball's radius is no part of it, the half axes of an ellipsoid are.
fn unscaled(columns: &Instances, i: usize) -> Mat4 {
    if columns.scale.get(i).is_some_and(|s| s[0] != s[1] || s[1] != s[2]) {
        return columns.matrix(i);
    }
    let turn = columns.orientation.get(i).map_or(Quat::IDENTITY, |q| Quat::from_array(*q));
    Mat4::from_rotation_translation(turn, Vec3::from(columns.position[i]))
}

fn instance_color(columns: &Instances, i: usize) -> Option<[f32; 3]> {
    let param = columns.params.iter().find(|p| p.decl.name == "Cs")?;
    param.numbers().get(3 * i..3 * i + 3).map(|c| [c[0], c[1], c[2]])
}

/// The uniform numbers of an instance's primitive variables other than colour.
pub(crate) fn instance_inputs(columns: &Instances, i: usize) -> impl Iterator<Item = (String, Vec<f32>)> + '_ {
    let wanted = |p: &&Param| p.decl.name != "Cs" && matches!(p.values, Values::Floats(_));
    columns.params.iter().filter(wanted).map(move |p| {
        let width = p.decl.width();
        (p.decl.name.clone(), p.numbers()[i * width..(i + 1) * width].to_vec())
    })
}

impl Patch {
    /// The bilinear patch of four corners (0,0), (1,0), (0,1), (1,1), as a bicubic one.
    pub fn bilinear(c: [Vec3; 4]) -> Patch {
        let mut p = [Vec3::ZERO; 16];
        for (k, q) in p.iter_mut().enumerate() {
            let (u, v) = ((k % 4) as f32 / 3.0, (k / 4) as f32 / 3.0);
            *q = lerp4(c, u, v);
        }
        let normal = (c[1] - c[0]).cross(c[2] - c[0]).normalize_or_zero();
        let flat = (c[3] - c[0]).dot(normal).abs() <= 1e-5 * (c[3] - c[0]).length();
        let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]];
        Patch { p, uv: corners, st: corners, varying: vec![], uniform: vec![], flat, trim: None, moves: vec![] }
    }

    /// The point at (u, v).
    pub fn at(&self, u: f32, v: f32) -> Vec3 {
        point_of(&self.p, u, v)
    }

    /// Derivatives along u and v.
    pub fn slopes(&self, u: f32, v: f32) -> (Vec3, Vec3) {
        let (bu, bv, du, dv) = (bernstein(u), bernstein(v), bernstein_slope(u), bernstein_slope(v));
        let sum = |x: [f32; 4], y: [f32; 4]| {
            (0..4).map(|j| (0..4).map(|i| self.p[4 * j + i] * x[i]).sum::<Vec3>() * y[j]).sum()
        };
        (sum(du, bv), sum(bu, dv))
    }

    /// The normal at (u, v): where the derivatives vanish, as at the tip of a triangle, that of a point nearby.
    pub fn normal(&self, u: f32, v: f32) -> Vec3 {
        let (du, dv) = self.slopes(u, v);
        self.normal_of(du, dv, u, v)
    }

    /// The normal at (u, v), whose derivatives are given.
    pub fn normal_of(&self, mut du: Vec3, mut dv: Vec3, mut u: f32, mut v: f32) -> Vec3 {
        for _ in 0..3 {
            let n = du.cross(dv);
            if n.length_squared() > 1e-12 * du.length_squared().max(dv.length_squared()).powi(2) {
                return n.normalize();
            }
            (u, v) = (u + (0.5 - u) * 0.02, v + (0.5 - v) * 0.02);
            (du, dv) = self.slopes(u, v);
        }
        Vec3::ZERO
    }
}

/// u and v of the specification's sphere in a direction of object space: u around, v from the south pole up (RISpec 5.2).
pub(crate) fn sphere_uv(d: Vec3) -> [f32; 2] {
    [(d.y.atan2(d.x) / std::f32::consts::TAU).rem_euclid(1.0), d.z.clamp(-1.0, 1.0).asin() / std::f32::consts::PI + 0.5]
}

/// The point at (u, v) of the bicubic Bézier patch of some control points.
pub(crate) fn point_of(p: &[Vec3; 16], u: f32, v: f32) -> Vec3 {
    let (bu, bv) = (bernstein(u), bernstein(v));
    (0..4).map(|j| (0..4).map(|i| p[4 * j + i] * bu[i]).sum::<Vec3>() * bv[j]).sum()
}

/// A number between those of four corners.
pub(crate) fn bilinear(c: [f32; 4], u: f32, v: f32) -> f32 {
    (c[0] * (1.0 - u) + c[1] * u) * (1.0 - v) + (c[2] * (1.0 - u) + c[3] * u) * v
}

/// Bilinear interpolation between corners.
pub(crate) fn lerp4(c: [Vec3; 4], u: f32, v: f32) -> Vec3 {
    c[0].lerp(c[1], u).lerp(c[2].lerp(c[3], u), v)
}

/// Bernstein's polynomials of the third degree.
pub(crate) fn bernstein(t: f32) -> [f32; 4] {
    let s = 1.0 - t;
    [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t]
}

/// Their derivatives.
pub(crate) fn bernstein_slope(t: f32) -> [f32; 4] {
    let s = 1.0 - t;
    [-3.0 * s * s, 3.0 * s * s - 6.0 * s * t, 6.0 * s * t - 3.0 * t * t, 3.0 * t * t]
}
