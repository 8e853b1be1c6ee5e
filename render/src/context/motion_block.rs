//! Open motion blocks: what their calls are kept as until `MotionEnd` (RISpec 6.3).

use crate::context::blobby_call::BlobbyCall;
use crate::gprim::quadric::Quadric;
use crate::scene::attributes::{Attribute, Attributes};
use crate::scene::patch::Patch;
use crate::scene::variables::{VariableName, VariableNames};
use glam::{Mat4, Vec3};
use ri::{Instances, Params};

/// A transformation at rising times.
pub type Keys = Vec<(f32, Mat4)>;

/// A transformation as the shutter opens, and its keys if it moves.
pub type Place = (Mat4, Keys);

/// An open `MotionBegin`: its times, and what its calls were.
pub struct MotionBlock {
    pub times: Vec<f32>,
    pub calls: Vec<Moving>,
    /// Attributes as the first request that sets one has left them, if a second one does.
    pub first: Option<Box<Attributes>>,
    /// Requests that set an attribute, or draw nothing.
    pub n_set: usize,
    /// Colours and opacities, each at one of the times.
    pub colors: Vec<(Attribute, [f32; 3])>,
    /// How the first call cut its polygons, which the others do alike.
    pub cuts: Vec<PolygonCut>,
}

/// How a polygon is cut: vertices of its loops, and corners of its patches among them.
pub struct PolygonCut {
    pub loops: Vec<usize>,
    pub quads: Vec<[usize; 4]>,
}

/// A call within a motion block.
pub enum Moving {
    /// A transformation after the current one.
    Concat(Mat4),
    /// A rotation after the current one: its axis, of unit length, and angle, radians.
    Turn(Vec3, f32),
    /// One in its place.
    Set(Mat4),
    Patches(Vec<Patch>, VariableNames),
    Quadric(Quadric, Params),
    Blobby(Box<BlobbyCall>),
    /// Whether they are `Points` stands last.
    Spheres(Instances, Vec<(VariableName, Vec<f32>)>, bool),
}
