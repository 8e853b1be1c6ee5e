//! Primitive variables: their names and types, and their values over a patch.

use crate::scene::interpolation::{bernstein, bilinear, cubic_part};
use ri::{Declaration, Type};

/// Names and types of the variables that the patches of a primitive have, in the order of their values.
#[derive(Clone, Debug, Default)]
pub struct VariableNames {
    /// Of those that are the same all over a patch.
    pub uniform: Vec<VariableName>,
    /// Of those that vary.
    pub varying: Vec<VariableName>,
}

/// Name and type of a variable.
#[derive(Clone, Debug, PartialEq)]
pub struct VariableName {
    /// Name.
    pub name: String,
    /// Type of its elements.
    pub ty: Type,
    /// Numbers that shaders get of it, all elements together.
    pub width: usize,
}

impl VariableName {
    /// Those of a declaration.
    pub fn of(declared: &Declaration) -> VariableName {
        VariableName::of_type(declared, declared.ty)
    }

    /// Those of a declaration whose values became another type's.
    pub fn of_type(declared: &Declaration, ty: Type) -> VariableName {
        // Homogeneous points reach shaders as points.
        let each = if ty == Type::HPoint { 3 } else { ty.width() };
        VariableName { name: declared.name.clone(), ty, width: each * declared.array }
    }
}

/// The values of a variable over a patch: at its corners (0,0), (1,0), (0,1), (1,1), bilinear in between, or at its 16 control
/// points, u fastest, from which they come as the surface itself does (RISpec 5, `vertex`).
#[derive(Clone, Debug, PartialEq)]
pub struct Varying {
    width: usize,
    values: Vec<f32>,
}

impl Varying {
    /// Of values at the four corners or at the 16 control points, `width` numbers each.
    pub fn new(width: usize, values: Vec<f32>) -> Varying {
        assert!(values.len() == 4 * width || values.len() == 16 * width, "{} values of {width}", values.len());
        Varying { width, values }
    }

    /// A part `t` of the way to other values of the same kind.
    pub fn blend(&mut self, to: &Varying, t: f32) {
        if self.values.len() == to.values.len() {
            self.values.iter_mut().zip(&to.values).for_each(|(a, b)| *a += (b - *a) * t);
        }
    }

    /// Between two values of v.
    pub fn part(&self, [a, b]: [f32; 2]) -> Varying {
        let mut values = Vec::with_capacity(self.values.len());
        if self.is_curved() {
            values.resize(self.values.len(), 0.0);
            for k in 0..4 * self.width {
                let column = [0, 1, 2, 3].map(|j| self.values[4 * self.width * j + k]);
                let part = cubic_part(column, [a, b]);
                (0..4).for_each(|j| values[4 * self.width * j + k] = part[j]);
            }
        } else {
            let corners = [[0.0, a], [1.0, a], [0.0, b], [1.0, b]];
            values.extend(corners.iter().flat_map(|[u, v]| (0..self.width).map(move |c| self.at(c, *u, *v))));
        }
        Varying { width: self.width, values }
    }

    /// Numbers of a value.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Whether it follows control points, and not the corners alone.
    pub fn is_curved(&self) -> bool {
        self.values.len() > 4 * self.width
    }

    /// Number `c` of it by itself.
    pub fn component(&self, c: usize) -> Varying {
        Varying { width: 1, values: self.values.chunks_exact(self.width).map(|value| value[c]).collect() }
    }

    /// Number `c` of the value at the corners.
    pub fn corners(&self, c: usize) -> [f32; 4] {
        let places = if self.is_curved() { [0, 3, 12, 15] } else { [0, 1, 2, 3] };
        places.map(|k| self.values[k * self.width + c])
    }

    /// Number `c` of the value at (u, v).
    pub fn at(&self, c: usize, u: f32, v: f32) -> f32 {
        if !self.is_curved() {
            return bilinear(self.corners(c), u, v);
        }
        let (bu, bv) = (bernstein(u), bernstein(v));
        let value = |j: usize, i: usize| self.values[(4 * j + i) * self.width + c];
        (0..4).map(|j| (0..4).map(|i| value(j, i) * bu[i]).sum::<f32>() * bv[j]).sum()
    }
}
