//! The parts that an assembly expands to: bodies, joints, springs and loads.

use crate::joint::JointKind;
use crate::model_file::{BodyFile, JointFile, LoadFile, PartFile, RotateFile, ShapeFile, SpringFile};

/// The parts of an assembly, in the types of a model file.
#[derive(Clone, Debug, Default)]
pub struct Parts {
    /// Bodies.
    pub bodies: Vec<BodyFile>,
    /// Joints.
    pub joints: Vec<JointFile>,
    /// Springs.
    pub springs: Vec<SpringFile>,
    /// Loads.
    pub loads: Vec<LoadFile>,
    /// Pairs of collision groups that pass through each other.
    pub pass_through: Vec<[String; 2]>,
}

/// The error of a dimension: its key and the message.
pub type DimensionError = (&'static str, String);

/// A body without shapes, at a position.
pub(super) fn body(name: String, class: &str, material: &str, position: [f64; 3], mass: f64) -> BodyFile {
    let mut body = BodyFile::named(&name);
    (body.class, body.material) = (Some(class.into()), Some(material.into()));
    (body.position, body.mass, body.shapes) = (position, Some(mass), Some(vec![]));
    body
}

/// One shape of a body, at a position and orientation in the body's frame.
pub(super) fn part(shape: ShapeFile, position: [f64; 3], rotate: Option<([f64; 3], f64)>) -> PartFile {
    let mut part: PartFile = serde_yaml::from_str("{}").expect("all of a part's keys have defaults");
    part.set_shape(shape);
    part.position = position;
    part.rotate = rotate.map(|(axis, angle)| RotateFile { axis, angle });
    part
}

/// A joint between bodies A and B, at a position and with an axis in the world.
pub(super) fn joint(name: String, kind: JointKind, [a, b]: [&str; 2], position: [f64; 3], axis: [f64; 3]) -> JointFile {
    let mut joint = JointFile::named(&name, kind, a, b);
    (joint.position, joint.axis) = (position, axis);
    joint
}

/// Check that dimensions are finite and above zero.
pub(super) fn positive(values: &[(&'static str, f64)]) -> Result<(), DimensionError> {
    match values.iter().find(|(_, x)| !(*x > 0.0 && x.is_finite())) {
        Some((key, x)) => Err((key, format!("is {x}, expected a number above 0"))),
        None => Ok(()),
    }
}
