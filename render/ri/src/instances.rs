//! The instance array: one gprim or object in many places, as columns; the one call that is ours.

use crate::params::{Param, Values};
use glam::{Mat4, Quat, Vec3};

/// What is repeated.
#[derive(Clone, Debug, PartialEq)]
pub enum InstanceShape {
    /// The unit sphere.
    Sphere,
    /// An object made by `ObjectBegin` with this handle.
    Object(String),
}

/// Many instances of one shape. A column has a row an instance, or is empty for its default.
#[derive(Clone, Debug, PartialEq)]
pub struct Instances {
    /// What is repeated.
    pub shape: InstanceShape,
    /// Places.
    pub position: Vec<[f32; 3]>,
    /// Unit quaternions (x, y, z, w); empty: unturned.
    pub orientation: Vec<[f32; 4]>,
    /// Scale along the shape's own axes; empty: 1.
    pub scale: Vec<[f32; 3]>,
    /// Primitive variables, one value an instance.
    pub params: Vec<Param>,
    /// Two times, and the places at the second one; `position` is then of the first. None: they stand still.
    pub moved: Option<([f32; 2], Vec<[f32; 3]>)>,
}

impl Instances {
    /// Number of instances.
    pub fn len(&self) -> usize {
        self.position.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.position.is_empty()
    }

    /// Shape to object space for column vectors; its columns read as an RI matrix's rows.
    pub fn matrix(&self, i: usize) -> Mat4 {
        Mat4::from_scale_rotation_translation(
            self.scale.get(i).map_or(Vec3::ONE, |s| Vec3::from(*s)),
            self.orientation.get(i).map_or(Quat::IDENTITY, |q| Quat::from_array(*q)),
            Vec3::from(self.position[i]),
        )
    }

    /// The values of an instance of a primitive variable.
    pub fn param_of(&self, param: &Param, i: usize) -> Param {
        let width = param.decl.width();
        let values = match &param.values {
            Values::Floats(v) => Values::Floats(v[i * width..(i + 1) * width].to_vec()),
            Values::Strings(v) => Values::Strings(v[i * width..(i + 1) * width].to_vec()),
        };
        Param { decl: param.decl.clone(), values }
    }
}
