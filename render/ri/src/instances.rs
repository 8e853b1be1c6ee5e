//! The instance array: one gprim or object in many places, as columns. It is an extension of the RenderMan Interface.

use crate::params::{Param, Values};
use glam::{Mat4, Quat, Vec3};

/// The shape that an instance array repeats.
#[derive(Clone, Debug, PartialEq)]
pub enum InstanceShape {
    /// The unit sphere.
    Sphere,
    /// The retained object (`ObjectBegin`) with this handle.
    Object(String),
}

/// An instance array: many instances of one shape. A column has one row per instance, or is empty where it has a default.
#[derive(Clone, Debug, PartialEq)]
pub struct Instances {
    /// The shape that is repeated.
    pub shape: InstanceShape,
    /// Position of each instance, object space; `[n]`.
    pub position: Vec<[f32; 3]>,
    /// Orientation of each instance as a unit quaternion (x, y, z, w); `[n]`, empty for no rotation.
    pub orientation: Vec<[f32; 4]>,
    /// Scale of each instance along the shape's own axes; `[n]`, empty for 1.
    pub scale: Vec<[f32; 3]>,
    /// Primitive variables, with one value per instance.
    pub params: Vec<Param>,
    /// Motion: two times, and the positions `[n]` at the second; `position` then holds those at the first. `None` if the instances
    /// do not move.
    pub moved: Option<([f32; 2], Vec<[f32; 3]>)>,
}

impl Instances {
    /// Count of instances, n.
    pub fn len(&self) -> usize {
        self.position.len()
    }

    /// Whether there are no instances.
    pub fn is_empty(&self) -> bool {
        self.position.is_empty()
    }

    /// Instance `i` by itself, as it is at first if it moves.
    pub fn alone(&self, i: usize) -> Instances {
        let own = |param: &Param| {
            let width = param.decl.width();
            let values = param.numbers().get(i * width..(i + 1) * width).unwrap_or_default().to_vec();
            Param { decl: param.decl.clone(), values: Values::Floats(values) }
        };
        Instances {
            shape: self.shape.clone(),
            position: vec![self.position[i]],
            orientation: self.orientation.get(i).copied().into_iter().collect(),
            scale: self.scale.get(i).copied().into_iter().collect(),
            params: self.params.iter().map(own).collect(),
            moved: None,
        }
    }

    /// The matrix of instance `i` from the shape's space to object space, for column vectors; stored by columns it is the row-major
    /// matrix of the RenderMan Interface.
    pub fn matrix(&self, i: usize) -> Mat4 {
        Mat4::from_scale_rotation_translation(
            self.scale.get(i).map_or(Vec3::ONE, |s| Vec3::from(*s)),
            self.orientation.get(i).map_or(Quat::IDENTITY, |q| Quat::from_array(*q)),
            Vec3::from(self.position[i]),
        )
    }

    /// The primitive variable `param` with only the value of instance `i`.
    pub fn param_of(&self, param: &Param, i: usize) -> Param {
        let width = param.decl.width();
        let values = match &param.values {
            Values::Floats(v) => Values::Floats(v[i * width..(i + 1) * width].to_vec()),
            Values::Strings(v) => Values::Strings(v[i * width..(i + 1) * width].to_vec()),
        };
        Param { decl: param.decl.clone(), values }
    }
}
