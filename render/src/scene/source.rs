//! Sources of primitives, held by reference, and the items that they have: an item is one primitive of a source.

use crate::scene::attached::Attached;
use crate::scene::attributes::Attributes;
use crate::scene::keys::later;
use crate::scene::shape::Shape;
use crate::scene::variables::VariableName;
use crate::warnings::Spot;
use glam::{Mat3, Mat4, Quat, Vec3, Vec4};
use ri::{Fit, Instances, Param, Type, Values};
use sl::Global;
use sl::machine::Points;
use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};
use std::sync::Arc;

/// What a source repeats.
pub enum SourceShape {
    /// One primitive.
    One(Shape),
    /// Spheres by columns.
    Spheres(Instances),
    /// Objects by columns: each has all these parts.
    Objects(Instances, Arc<Vec<Part>>),
}

/// A primitive of an object.
#[derive(Clone)]
pub struct Part {
    /// What it is.
    pub shape: Shape,
    /// Its shape to the object.
    pub place: Mat4,
    /// The space that it was declared in to that of the object: as `place`, but without the scale that is a sphere's radius.
    pub space: Mat4,
    /// Where that space stands in its object space.
    pub fit: Fit,
    /// The primitive that it is a part of, counted from 0 in the object.
    pub whole: u32,
    /// It is one of `Points`, of which the eye and the light see one side.
    pub particle: bool,
}

/// What the items of a source are parts of: the patches of a primitive are parts of one whole.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Wholes {
    /// The name of the first in the scene.
    pub first: u32,
    /// How many an instance of an object has.
    pub per_instance: u32,
    /// Some of them has more than one item.
    pub shared: bool,
}

impl Wholes {
    /// The name of the first of an instance.
    pub fn of_instance(&self, instance: usize) -> u32 {
        self.first.wrapping_add((instance as u32).wrapping_mul(self.per_instance))
    }
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
    pub uniform: Vec<(VariableName, Vec<f32>)>,
    /// Spheres have the source's object space, and none of their own.
    pub shares_space: bool,
    /// Its spheres are `Points`.
    pub particles: bool,
    /// The wholes that its items are parts of.
    pub wholes: Wholes,
    /// The id of its first item, from 1.
    pub first_id: usize,
    /// How many primitives stand as one where each instance does; 0 of those that stand where one before them does, and hide behind it or
    /// are counted there. Empty if all stand alone.
    pub repeats: Vec<u32>,
    /// The variables of each part, attached to its shaders; of one for all items where there are no parts.
    pub attached: Vec<Arc<Attached>>,
    /// Where they stand in a file.
    pub spot: Option<Spot>,
}

/// Source and index within it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
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
    /// The space that it was declared in to world: as `to_world`, but without the scale that is a sphere's radius.
    pub declared_to_world: Mat4,
    /// Object space to world: as `declared_to_world`, but without the scale that is the size of an instance.
    pub object_to_world: Mat4,
    /// Attributes.
    pub attributes: &'a Attributes,
    /// Colour.
    pub color: [f32; 3],
    /// The source, for its uniform variables.
    pub source: &'a Source,
    /// The slots of its variables.
    pub attached: &'a Attached,
    /// The instance.
    pub instance: Option<(&'a Instances, usize)>,
    /// How far an instance moves in its source while the shutter is open.
    pub shift: Vec3,
    /// It is one of `Points`, of which the eye and the light see one side.
    pub particle: bool,
    /// How many that are alike it stands for.
    pub repeats: u32,
}

impl SourceShape {
    /// Number of its instances.
    pub fn n_instances(&self) -> usize {
        match self {
            SourceShape::One(_) => 1,
            SourceShape::Spheres(columns) | SourceShape::Objects(columns, _) => columns.len(),
        }
    }
}

impl Source {
    /// Whether no light gets through its primitives.
    pub fn blocks_light(&self) -> bool {
        let a = &self.attributes;
        let is_opaque = a.surface.program.is_opaque && !a.shadows_of_opacity;
        a.whole_shadows || is_opaque || a.opacity == [1.0; 3] && self.shadow_is_known()
    }

    /// Whether the attributes say how much light gets through it, without its variables and its shader.
    pub fn shadow_is_known(&self) -> bool {
        let a = &self.attributes;
        a.shadows_of_opacity || a.surface_keeps_opacity() && self.attached.iter().all(|a| a.opacity.is_none())
    }

    /// How many primitives an item stands for.
    pub fn repeats_of(&self, item: usize) -> u32 {
        if self.repeats.is_empty() { 1 } else { self.repeats[item / (self.len() / self.repeats.len())] }
    }

    /// Number of items.
    pub fn len(&self) -> usize {
        match &self.shape {
            SourceShape::One(_) => 1,
            SourceShape::Spheres(columns) => columns.len(),
            SourceShape::Objects(columns, parts) => columns.len() * parts.len(),
        }
    }
}

/// How many instances stand where each does, as [`Source::repeats`] has them; of those whose variables count, these are the same.
pub(crate) fn repeats(columns: &Instances, variables_count: bool) -> Vec<u32> {
    let n = columns.len();
    let mut first: HashMap<u64, u32, BuildHasherDefault<Mixed>> =
        HashMap::with_capacity_and_hasher(n, Default::default());
    let mut repeats = Vec::new();
    for i in 0..n {
        let (scale, turn) = (columns.scale.get(i), columns.orientation.get(i));
        let numbers = columns.position[i].iter().chain(scale.into_iter().flatten()).chain(turn.into_iter().flatten());
        let key = numbers.fold(0u64, |key, x| mixed(key ^ x.to_bits() as u64));
        let before = *first.entry(key).or_insert(i as u32) as usize;
        let same = before != i
            && columns.position[i] == columns.position[before]
            && scale == columns.scale.get(before)
            && turn == columns.orientation.get(before)
            && columns.moved.as_ref().is_none_or(|(_, to)| to[i] == to[before])
            && !(variables_count && columns.offset.get(i) != columns.offset.get(before))
            && !(variables_count && columns.params.iter().any(|p| !has_one_value(p, i, before)));
        if same {
            repeats.resize(n, 1);
            repeats[before] += 1;
            repeats[i] = 0;
        }
    }
    repeats
}

/// Whether two instances have one value of a variable.
fn has_one_value(param: &Param, a: usize, b: usize) -> bool {
    let width = param.decl.width();
    match &param.values {
        Values::Floats(v) => v.get(a * width..(a + 1) * width) == v.get(b * width..(b + 1) * width),
        Values::Strings(v) => v.get(a) == v.get(b),
    }
}

/// Mix the bits of a number.
fn mixed(x: u64) -> u64 {
    let x = x.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    x ^ x >> 29
}

/// The hash of a number that is one already.
#[derive(Default)]
struct Mixed(u64);

impl Hasher for Mixed {
    fn write(&mut self, bytes: &[u8]) {
        bytes.iter().for_each(|byte| self.write_u64(*byte as u64));
    }
    fn write_u64(&mut self, x: u64) {
        self.0 = mixed(self.0 ^ x);
    }
    fn finish(&self) -> u64 {
        self.0
    }
}

/// The space of a sphere without its radius, or the half axes of an ellipsoid.
pub(crate) fn unscaled(columns: &Instances, i: usize) -> Mat4 {
    let turn = columns.orientation.get(i).map_or(Quat::IDENTITY, |q| Quat::from_array(*q));
    Mat4::from_rotation_translation(turn, Vec3::from(columns.position[i]))
}

pub(crate) fn instance_color(columns: &Instances, i: usize) -> Option<[f32; 3]> {
    let param = columns.params.iter().find(|p| p.decl.name == "Cs")?;
    param.numbers().get(3 * i..3 * i + 3).map(|c| [c[0], c[1], c[2]])
}

/// The primitive variables that instances have besides their colour: those of numbers.
pub(crate) fn instance_variables(columns: &Instances) -> impl Iterator<Item = &Param> {
    columns.params.iter().filter(|p| p.decl.name != "Cs" && matches!(p.values, Values::Floats(_)))
}

impl ItemView<'_> {
    /// Colour and opacity of all that it stands for, one behind the other, from those of one.
    pub fn repeated(&self, [color, opacity]: [[f32; 3]; 2]) -> [[f32; 3]; 2] {
        if self.repeats <= 1 {
            return [color, opacity];
        }
        let all = opacity.map(|o| {
            let (o, n) = (f64::from(o.clamp(0.0, 1.0)), self.repeats);
            let passes = (1.0 - o).powi(n as i32);
            // The sum of what each before lets through.
            let sum = if o > 1e-9 { (1.0 - passes) / o } else { n as f64 };
            [sum as f32, (1.0 - passes) as f32]
        });
        [std::array::from_fn(|c| color[c] * all[c][0]), all.map(|[_, o]| o)]
    }

    /// Its colour and opacity at a part of the time that the shutter is open.
    pub fn paint(&self, time: f32) -> ([f32; 3], [f32; 3]) {
        let a = self.attributes;
        // The colour of an instance goes before the attribute.
        let own = self.instance.and_then(|(columns, i)| instance_color(columns, i));
        let moves = if own.is_none() { a.color_moves.as_slice() } else { &[] };
        (later(self.color, moves, time), later(a.opacity, &a.opacity_moves, time))
    }

    /// Fill the first slots of the variables of points: those of the source and the instance.
    pub fn fill_variables(&self, points: &mut Points) {
        points.clear_variables();
        for (_, values) in &self.source.uniform {
            points.next_variable().extend_from_slice(values);
        }
        if let Some((columns, i)) = self.instance {
            for param in instance_variables(columns) {
                let width = param.decl.width();
                points.next_variable().extend_from_slice(&param.numbers()[i * width..(i + 1) * width]);
            }
        }
    }

    /// Bring the variables that are places or directions from their object space to world space, which shaders call current
    /// (RISpec 5).
    pub fn to_current(&self, points: &mut Points) {
        let n = points.n();
        for spatial in &self.attached.spatial {
            // What a primitive has is of its own space, what instances have is of the space that they are placed in.
            let m = match spatial.of_source {
                true if spatial.slot < self.source.uniform.len() => self.declared_to_world,
                true => self.source.to_world,
                false => self.to_world,
            };
            if let Some(values) = points.variable_mut(spatial.slot) {
                let n = if spatial.slot < self.attached.n_uniform { 1 } else { n };
                transform(values, n, spatial.ty, &m);
                if spatial.ty == Type::HPoint {
                    *values = weighted(values, n);
                }
            }
        }
    }

    /// Set s and t of points to those that the source or the instance has.
    pub fn set_coordinates(&self, points: &mut Points) {
        let n = points.n();
        for (global, found) in [Global::S, Global::T].into_iter().zip(self.attached.coordinates) {
            let value = found.and_then(|(slot, k)| points.variable(slot)?.get(k).copied());
            if let Some(value) = value {
                points.refill(global).resize(n, value);
            }
        }
    }
}

/// Homogeneous points, whose four numbers are runs of `n`, as points.
fn weighted(values: &[f32], n: usize) -> Vec<f32> {
    let point = |all: &[f32]| (0..3 * n).map(|k| all[k] / all[3 * n + k % n]).collect::<Vec<f32>>();
    values.chunks_exact(4 * n).flat_map(point).collect()
}

/// Transform values at `n` points, each of whose numbers is a run of its own; arrays are of several values.
pub(crate) fn transform(values: &mut [f32], n: usize, ty: Type, m: &Mat4) {
    let normals = Mat3::from_mat4(*m).inverse().transpose();
    let width = ty.width();
    for element in values.chunks_exact_mut(width * n) {
        for k in 0..n {
            let v = Vec3::new(element[k], element[n + k], element[2 * n + k]);
            let out = match ty {
                Type::Point => m.transform_point3(v).extend(0.0),
                Type::Vector => m.transform_vector3(v).extend(0.0),
                Type::Normal => (normals * v).extend(0.0),
                _ => *m * Vec4::new(v.x, v.y, v.z, element[3 * n + k]),
            };
            (0..width).for_each(|c| element[c * n + k] = out[c]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ri::{Class, InstanceShape};

    #[test]
    fn instances_in_one_place_are_counted_where_their_variables_are_the_same() {
        let columns = Instances {
            shape: InstanceShape::Sphere,
            position: vec![[0.0; 3], [1.0; 3], [0.0; 3], [0.0; 3], [1.0; 3]],
            orientation: vec![],
            scale: vec![],
            offset: vec![],
            params: vec![Param::floats("k", Class::Uniform, Type::Float, vec![1.0, 2.0, 1.0, 3.0, 2.0])],
            moved: None,
        };
        assert_eq!(repeats(&columns, false), [3, 2, 0, 0, 0]);
        assert_eq!(repeats(&columns, true), [2, 2, 0, 1, 0]);
    }
}
