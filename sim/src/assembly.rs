//! Machines that are built from a few dimensions: parametric builders that write the bodies, joints, springs and loads that an
//! engineer would have to write by hand.

mod helical_anchor;
mod tracked_vehicle;

pub use helical_anchor::HelicalAnchor;
pub use tracked_vehicle::TrackedVehicle;

use crate::joint::JointKind;
use crate::model_file::{BodyFile, JointFile, LoadFile, PartFile, RotateFile, ShapeFile, SpringFile};

/// What a builder makes, as it would stand in a model file.
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

/// What is wrong with a dimension: its key and why.
pub type Wrong = (&'static str, String);

/// A body without shapes at a place.
fn body(name: String, class: &str, material: &str, position: [f64; 3], mass: f64) -> BodyFile {
    let mut body = BodyFile::named(&name);
    (body.class, body.material) = (Some(class.into()), Some(material.into()));
    (body.position, body.mass, body.shapes) = (position, Some(mass), Some(vec![]));
    body
}

/// A shape of a body.
fn part(shape: ShapeFile, position: [f64; 3], rotate: Option<([f64; 3], f64)>) -> PartFile {
    let mut part: PartFile = serde_yaml::from_str("{}").expect("all of a part's keys have defaults");
    part.set_shape(shape);
    part.position = position;
    part.rotate = rotate.map(|(axis, angle)| RotateFile { axis, angle });
    part
}

/// A joint of a kind.
fn joint(name: String, kind: JointKind, [a, b]: [&str; 2], position: [f64; 3], axis: [f64; 3]) -> JointFile {
    let mut joint = JointFile::named(&name, kind, a, b);
    (joint.position, joint.axis) = (position, axis);
    joint
}

/// Refuse dimensions that are not above zero.
fn positive(values: &[(&'static str, f64)]) -> Result<(), Wrong> {
    match values.iter().find(|(_, x)| !(*x > 0.0 && x.is_finite())) {
        Some((key, x)) => Err((key, format!("is {x}, expected a number above 0"))),
        None => Ok(()),
    }
}
