//! Joints, springs, loads and functions of time, as a model file writes them.

use crate::joint::JointKind;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// A joint. Its frame stands at `position` with z along `axis` when the model starts.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct JointFile {
    /// Name.
    pub name: String,
    /// Kind.
    pub kind: JointKind,
    /// Body A; `world` is the ground.
    pub a: String,
    /// Body B.
    pub b: String,
    /// Where, m, world; for joints with two points, the one on A.
    #[serde(default)]
    pub position: [f64; 3],
    /// The point on B, m, world, where it is another one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub position_b: Option<[f64; 3]>,
    /// The joint's z axis, world.
    #[serde(default = "default_axis")]
    pub axis: [f64; 3],
    /// The joint's x axis, world; a universal joint turns about x on A and about y on B.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axis_x: Option<[f64; 3]>,
    /// Length over time, m (distance, revolute_spherical): a linear actuator. As the model starts if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub length: Option<FunctionFile>,
    /// Least and greatest coordinate: degrees for an angle, m for a distance, counted from the start.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limits: Option<[f64; 2]>,
    /// Motor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motor: Option<MotorFile>,
    /// Whether its two bodies may touch.
    #[serde(default)]
    pub collide: bool,
    /// It holds from this time on, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<f64>,
    /// And until this, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub until: Option<f64>,
}

/// A motor: exactly one of these. SI units: rad/s, rad, N m for turning; m/s, m, N for sliding.
#[derive(Clone, Debug, Default, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MotorFile {
    /// Speed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed: Option<FunctionFile>,
    /// Angle or distance.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motion: Option<FunctionFile>,
    /// Torque, N m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub torque: Option<FunctionFile>,
    /// Force, N.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force: Option<FunctionFile>,
}

/// A spring with a damper.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpringFile {
    /// Name.
    pub name: String,
    /// Body A; `world` is the ground.
    pub a: String,
    /// Body B.
    pub b: String,
    /// The point on A, m, world.
    #[serde(default)]
    pub position: [f64; 3],
    /// The point on B, m, world.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub position_b: Option<[f64; 3]>,
    /// Makes it a spring about this axis, world.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub about: Option<[f64; 3]>,
    /// Stiffness, N/m or N m/rad.
    #[serde(default)]
    pub stiffness: f64,
    /// Damping, N s/m or N m s/rad.
    #[serde(default)]
    pub damping: f64,
    /// Length, m, without force, or angle, degrees; as the model starts if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rest: Option<f64>,
    /// Force or torque in addition, pulling B to A where positive.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub preload: Option<FunctionFile>,
    /// It acts from this time on, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<f64>,
    /// And until this, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub until: Option<f64>,
}

/// A force or a torque on a body.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LoadFile {
    /// The body.
    pub body: String,
    /// Direction of a force; its length does not count.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force: Option<[f64; 3]>,
    /// Direction of a torque; its length does not count.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub torque: Option<[f64; 3]>,
    /// Its size over time, N or N m.
    pub value: FunctionFile,
    /// The frame of the direction: `world`, or `body`, which turns with it.
    #[serde(default)]
    pub frame: LoadFrame,
    /// Where a force acts, in the body's frame, m; at the centre of mass if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub point: Option<[f64; 3]>,
    /// It acts from this time on, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<f64>,
    /// And until this, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub until: Option<f64>,
}

/// The frame of a load's direction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum LoadFrame {
    /// The world's.
    #[default]
    World,
    /// The body's.
    Body,
}

/// A function of time: a number, or exactly one of the forms.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(
    untagged,
    expecting = "expected a number, {step: {…}}, {ramp: {…}}, {sine: {…}}, {table: [[time, value], …]} or {csv: FILE}"
)]
pub enum FunctionFile {
    /// Constant.
    Constant(f64),
    /// A step.
    Step {
        /// The step.
        step: StepFile,
    },
    /// A ramp.
    Ramp {
        /// The ramp.
        ramp: RampFile,
    },
    /// A sine.
    Sine {
        /// The sine.
        sine: SineFile,
    },
    /// Points joined by straight lines.
    Table {
        /// Pairs of time, s, and value; times rise.
        table: Vec<[f64; 2]>,
    },
    /// Points from a CSV file of two columns, with or without a header.
    Csv {
        /// The file.
        csv: PathBuf,
    },
}

/// A step.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StepFile {
    /// When, s.
    pub at: f64,
    /// Value before.
    #[serde(default)]
    pub before: f64,
    /// Value after.
    pub after: f64,
}

/// A ramp.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RampFile {
    /// Begin and end, s.
    pub times: [f64; 2],
    /// Values there; constant outside.
    pub values: [f64; 2],
}

/// A sine.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SineFile {
    /// Amplitude.
    pub amplitude: f64,
    /// Frequency, Hz.
    pub frequency: f64,
    /// Mean.
    #[serde(default)]
    pub mean: f64,
    /// Phase, degrees.
    #[serde(default)]
    pub phase: f64,
}

impl JointFile {
    /// A joint between two bodies, all else as if not given.
    pub fn named(name: &str, kind: JointKind, a: &str, b: &str) -> JointFile {
        let mut joint: JointFile = serde_yaml::from_str("{name: j, kind: fixed, a: a, b: b}")
            .expect("all other keys of a joint have defaults");
        (joint.name, joint.kind, joint.a, joint.b) = (name.into(), kind, a.into(), b.into());
        joint
    }
}

fn default_axis() -> [f64; 3] {
    [0.0, 0.0, 1.0]
}
