//! The types of joints, springs, loads and functions of time in a model file.

use crate::joint::JointKind;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// A joint between two bodies. At the start its frame is at `position` with z along `axis`.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct JointFile {
    /// Name.
    pub name: String,
    /// Kind of the joint.
    pub kind: JointKind,
    /// Name of body A; `world` is the fixed world.
    pub a: String,
    /// Name of body B.
    pub b: String,
    /// Position of the joint, m, world; for joints with two points, that of the point on A.
    #[serde(default)]
    pub position: [f64; 3],
    /// Position of the point on B, m, world, for joints with two points (distance, revolute_spherical, point_on_plane).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub position_b: Option<[f64; 3]>,
    /// The joint's z axis, world.
    #[serde(default = "default_axis")]
    pub axis: [f64; 3],
    /// The joint's x axis, world; the axes of a universal joint are x on A and y on B.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axis_x: Option<[f64; 3]>,
    /// Direction of the shaft of B, world, of a universal joint; that of A is `axis`. The same if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axis_b: Option<[f64; 3]>,
    /// Length over time, m (distance, revolute_spherical), of a linear actuator; the length at the start if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub length: Option<FunctionFile>,
    /// Minimum and maximum coordinate: degrees for an angle, m for a distance; relative to the start, but for distance and
    /// revolute_spherical joints, whose coordinate is the length itself.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limits: Option<[f64; 2]>,
    /// Motor of the coordinate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motor: Option<MotorFile>,
    /// Whether the two bodies of the joint may have contacts with each other.
    #[serde(default)]
    pub collide: bool,
    /// Time from which it acts, s; the start of its stage if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<f64>,
    /// Time until which it acts, s; for ever if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub until: Option<f64>,
}

/// A motor of a joint's coordinate: exactly one of `speed`, `motion`, `torque` and `force` is given.
#[derive(Clone, Debug, Default, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MotorFile {
    /// Rate of the coordinate over time, rad/s (revolute, cylindrical) or m/s (prismatic).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed: Option<FunctionFile>,
    /// Coordinate over time, rad (revolute, cylindrical) or m (prismatic).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motion: Option<FunctionFile>,
    /// Torque over time, N m (revolute, cylindrical).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub torque: Option<FunctionFile>,
    /// Force over time, N (prismatic).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force: Option<FunctionFile>,
    /// Maximum torque over time, N m, of a motor by `speed` or `motion` (revolute, cylindrical); any if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_torque: Option<FunctionFile>,
    /// Maximum force over time, N, of a motor by `speed` or `motion` (prismatic); any if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_force: Option<FunctionFile>,
}

/// A spring and damper between two bodies, along the line between two points or about an axis.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpringFile {
    /// Name.
    pub name: String,
    /// Name of body A; `world` is the fixed world.
    pub a: String,
    /// Name of body B.
    pub b: String,
    /// Position of the point on A, m, world.
    #[serde(default)]
    pub position: [f64; 3],
    /// Position of the point on B, m, world; a spring with `rest: 0` pulls two points that are one back together.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub position_b: Option<[f64; 3]>,
    /// Axis of a rotational spring, world; a linear spring if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub about: Option<[f64; 3]>,
    /// Stiffness, N/m or N m/rad.
    #[serde(default)]
    pub stiffness: f64,
    /// Damping, N s/m or N m s/rad.
    #[serde(default)]
    pub damping: f64,
    /// Free length, m, or free angle, degrees; the length or angle at the start if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rest: Option<f64>,
    /// Additional force, N, or torque, N m, over time; positive pulls B towards A, or turns B back about the axis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub preload: Option<FunctionFile>,
    /// Time from which it acts, s; the start of its stage if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<f64>,
    /// Time until which it acts, s; for ever if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub until: Option<f64>,
}

/// A force or a torque on a body: exactly one of `force` and `torque` is given.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LoadFile {
    /// Name of the body.
    pub body: String,
    /// Direction of a force, whose magnitude `value` is in N; the length of the vector has no effect.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force: Option<[f64; 3]>,
    /// Direction of a torque, whose magnitude `value` is in N m; the length of the vector has no effect.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub torque: Option<[f64; 3]>,
    /// Magnitude over time, N (force) or N m (torque).
    pub value: FunctionFile,
    /// Frame of the direction: `world` or `body`.
    #[serde(default)]
    pub frame: LoadFrame,
    /// Point of application of a force, in the body's frame, m; the centre of mass if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub point: Option<[f64; 3]>,
    /// Time from which it acts, s; the start of its stage if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from: Option<f64>,
    /// Time until which it acts, s; for ever if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub until: Option<f64>,
}

/// The frame in which a load's direction is given.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum LoadFrame {
    /// The world frame.
    #[default]
    World,
    /// The body's frame: the direction turns with the body.
    Body,
}

/// A function of time: a number, or exactly one of the forms `step`, `ramp`, `sine`, `table` and `csv`. Values have the unit of the key
/// that the function is given for.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(
    untagged,
    expecting = "expected a number, {step: {…}}, {ramp: {…}}, {sine: {…}}, {table: [[time, value], …]} or {csv: FILE}"
)]
pub enum FunctionFile {
    /// A constant value.
    Constant(f64),
    /// A step between two values.
    Step {
        /// The step.
        step: StepFile,
    },
    /// A linear ramp between two values.
    Ramp {
        /// The ramp.
        ramp: RampFile,
    },
    /// A sine about a mean.
    Sine {
        /// The sine.
        sine: SineFile,
    },
    /// Points with linear interpolation, constant before the first and after the last.
    Table {
        /// Pairs of time, s, and value; times ascend.
        table: Vec<[f64; 2]>,
    },
    /// Points as of `table` from a CSV file of two columns, with or without a header.
    Csv {
        /// Path of the CSV file: time, s, and value.
        csv: PathBuf,
    },
}

/// A step between two values.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StepFile {
    /// Time of the step, s.
    pub at: f64,
    /// Value before the step.
    #[serde(default)]
    pub before: f64,
    /// Value from the step on.
    pub after: f64,
}

/// A linear ramp between two values, constant before and after.
#[derive(Clone, Debug, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RampFile {
    /// Times of start and end, s.
    pub times: [f64; 2],
    /// Values at start and end.
    pub values: [f64; 2],
}

/// A sine: mean + amplitude sin(2π frequency t + phase), t in s.
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
    /// A joint between two bodies by their names, with the defaults of all other keys.
    pub fn named(name: &str, kind: JointKind, a: &str, b: &str) -> JointFile {
        JointFile {
            name: name.into(),
            kind,
            a: a.into(),
            b: b.into(),
            position: [0.0; 3],
            position_b: None,
            axis: default_axis(),
            axis_x: None,
            axis_b: None,
            length: None,
            limits: None,
            motor: None,
            collide: false,
            from: None,
            until: None,
        }
    }
}

fn default_axis() -> [f64; 3] {
    [0.0, 0.0, 1.0]
}
