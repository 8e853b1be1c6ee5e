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

/// Where a shape of unit size stands in its object space: a point p of the shape is offset + size · p there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// The shape's origin, in object space.
    pub offset: Vec3,
    /// Its size along its own axes.
    pub size: Vec3,
}

impl Fit {
    /// A shape whose own space is its object space.
    pub const NONE: Fit = Fit { offset: Vec3::ZERO, size: Vec3::ONE };

    /// The object space of a shape: `shape` brings it to some space.
    pub fn object_of(&self, shape: Mat4) -> Mat4 {
        if *self == Fit::NONE {
            return shape;
        }
        let mut object = shape;
        object.x_axis /= self.size.x;
        object.y_axis /= self.size.y;
        object.z_axis /= self.size.z;
        object.w_axis -= object * self.offset.extend(0.0);
        object
    }

    /// What stands so in the shape of another.
    pub fn of(&self, inner: Fit) -> Fit {
        Fit { offset: self.offset + self.size * inner.offset, size: self.size * inner.size }
    }
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
    /// Scale of each instance along the shape's own axes; `[n]`, empty for 1. It is the size of the shape in object space, and does not
    /// scale that.
    pub scale: Vec<[f32; 3]>,
    /// Place of each shape in its object space, along that space's own axes; `[n]`, empty for its origin.
    pub offset: Vec<[f32; 3]>,
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
            offset: self.offset.get(i).copied().into_iter().collect(),
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

    /// Where the shape of instance `i` stands in its object space.
    pub fn fit(&self, i: usize) -> Fit {
        let row = |column: &[[f32; 3]], otherwise: Vec3| column.get(i).map_or(otherwise, |x| Vec3::from(*x));
        Fit { offset: row(&self.offset, Vec3::ZERO), size: row(&self.scale, Vec3::ONE) }
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
