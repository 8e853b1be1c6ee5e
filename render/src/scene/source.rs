//! Sources of primitives, held by reference, and the items that they have: an item is one primitive of a source.

use crate::scene::attached::Attached;
use crate::scene::attributes::Attributes;
use crate::scene::shape::Shape;
use glam::{Mat4, Quat, Vec3};
use ri::{Instances, Param, Values};
use sl::machine::Points;
use std::sync::Arc;

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
    /// The variables of each part, attached to its shaders; of one for all items where there are no parts.
    pub attached: Vec<Arc<Attached>>,
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
    /// The slots of its variables.
    pub attached: &'a Attached,
    /// The instance.
    pub instance: Option<(&'a Instances, usize)>,
    /// How far an instance moves in its source while the shutter is open.
    pub shift: Vec3,
}

impl Source {
    /// Number of items.
    pub fn len(&self) -> usize {
        match &self.shape {
            SourceShape::One(_) => 1,
            SourceShape::Spheres(columns) => columns.len(),
            SourceShape::Objects(columns, parts) => columns.len() * parts.len(),
        }
    }
}

/// The object space of a sphere: the radius of a sphere is no part of it, the half axes of an ellipsoid are.
pub(crate) fn unscaled(columns: &Instances, i: usize) -> Mat4 {
    if columns.scale.get(i).is_some_and(|s| s[0] != s[1] || s[1] != s[2]) {
        return columns.matrix(i);
    }
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
}
