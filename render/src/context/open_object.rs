//! Retained objects: one that is open, its parts, and what they are kept as when it ends.

use crate::context::geometry::Geometry;
use crate::context::motion_block::{Keys, Place};
use crate::scene::attributes::Attributes;
use crate::scene::source::Part;
use crate::scene::variables::VariableName;
use glam::Mat4;
use std::sync::Arc;

/// Values of uniform variables.
pub type Uniform = Vec<(VariableName, Vec<f32>)>;

/// An object that is open.
pub struct OpenObject {
    pub handle: String,
    pub parts: Vec<OpenPart>,
    /// Count of those that are copies of parts of other objects.
    pub n_copies: usize,
    /// Count of the primitives that these are parts of.
    pub n_wholes: u32,
    /// The transformation where it began.
    pub base: Mat4,
    /// What holds again after it.
    pub outer: (Attributes, Place, Geometry),
    /// Open attribute and transformation blocks around it.
    pub depths: [usize; 2],
}

impl OpenObject {
    /// Open attribute blocks around it.
    pub fn depth(&self) -> usize {
        self.depths[0]
    }

    /// Open transformation blocks around it.
    pub fn transforms(&self) -> usize {
        self.depths[1]
    }
}

/// A primitive of an object that is open.
pub struct OpenPart {
    pub part: Part,
    /// Its place over time.
    pub moves: Keys,
    pub uniform: Uniform,
    pub attributes: Option<Arc<Attributes>>,
}

/// Parts of an object that are drawn together.
#[derive(Clone)]
pub struct Group {
    pub parts: Arc<Vec<Part>>,
    /// Of a part that moves within the object, its places over time, which hold beside the one in `parts`.
    pub moves: Keys,
    pub uniform: Uniform,
    /// Attributes that were set within the object.
    pub attributes: Option<Arc<Attributes>>,
    pub base: Mat4,
}
