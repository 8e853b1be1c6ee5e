//! Open motion blocks: what their calls are kept as until `MotionEnd` (RISpec 6.3).

use crate::scene::patch::Patch;
use crate::scene::variables::VariableNames;
use glam::Mat4;
use ri::Instances;

/// A transformation at rising times.
pub type Keys = Vec<(f32, Mat4)>;

/// A transformation as the shutter opens, and its keys if it moves.
pub type Place = (Mat4, Keys);

/// An open `MotionBegin`: its times, and what its calls were.
pub struct MotionBlock {
    pub times: Vec<f32>,
    pub calls: Vec<Moving>,
}

/// A call within a motion block.
pub enum Moving {
    /// A transformation after the current one.
    Concat(Mat4),
    /// One in its place.
    Set(Mat4),
    Patches(Vec<Patch>, VariableNames),
    Spheres(Instances, Vec<(String, Vec<f32>)>),
}
