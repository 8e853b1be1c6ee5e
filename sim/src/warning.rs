//! Warnings about steps, and the state of the watch that gives them.

use serde::{Deserialize, Serialize};

/// The kind of a warning; [`watch`](crate::watch) has the bounds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum WarningKind {
    /// The contact solver has not converged.
    Residual,
    /// A locked motion of a joint is violated.
    Joint,
    /// A motor does not reach the rate or the coordinate that it prescribes.
    Motor,
    /// Energy has grown beyond what motors and loads have given, or joints have lost it.
    Energy,
    /// Two bodies overlap deeply.
    Overlap,
    /// The force on a load swings.
    Swing,
}

impl WarningKind {
    /// All kinds.
    pub const ALL: [WarningKind; 6] = [
        WarningKind::Residual,
        WarningKind::Joint,
        WarningKind::Motor,
        WarningKind::Energy,
        WarningKind::Overlap,
        WarningKind::Swing,
    ];

    /// Name, as in `run.json`.
    pub fn name(self) -> &'static str {
        match self {
            WarningKind::Residual => "residual",
            WarningKind::Joint => "joint",
            WarningKind::Motor => "motor",
            WarningKind::Energy => "energy",
            WarningKind::Overlap => "overlap",
            WarningKind::Swing => "swing",
        }
    }
}

/// A warning about one step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Warning {
    /// Kind of the warning.
    pub kind: WarningKind,
    /// Number of the step, from 1.
    pub step: u64,
    /// Time at the step's end, s.
    pub time: f64,
    /// Message, with the body's or joint's name, the value and its bound.
    pub message: String,
}

impl std::fmt::Display for Warning {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "step {} ({:.6} s): {}", self.step, self.time, self.message)
    }
}

/// The number of steps of a run with a warning of one kind.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WarningCount {
    /// Number of steps.
    pub count: u64,
    /// The first warning of the kind.
    pub first: Warning,
}

/// The reason why a run cannot go on: a value that is not finite, or a body that is too fast.
#[derive(Clone, Debug, PartialEq)]
pub struct Broken {
    /// Id of the body whose state is out of bounds; none for a residual or a joint error.
    pub body: Option<usize>,
    /// Message for the user, without the body's name.
    pub why: String,
}

/// What is known of a load, a body by far heavier than those that carry it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Swing {
    /// Id of the body.
    pub(crate) body: u32,
    /// Speed against gravity after the last step, m/s.
    pub(crate) speed: f64,
    /// Whether it was pushed up, or fell, when it was last accelerated by much.
    pub(crate) is_up: bool,
    /// Changes between the two, each soon after that before.
    pub(crate) turns: u32,
    /// Step of the last change.
    pub(crate) turned: u64,
}

/// The state of the watch over a run; part of the simulation's state, so that a resumed run gives the same warnings.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct WatchState {
    /// Diagonal of the initial bounding box of shapes, moving bodies and joints, m; 0 before the first step.
    pub(crate) diagonal: f64,
    /// Minimum gravitational potential of each body so far, at most that of the initial bounding box's bottom, J/kg (n_bodies).
    pub(crate) lowest: Vec<f64>,
    /// Moving mass of the last step, kg.
    pub(crate) mass: f64,
    /// Sum of the moving bodies' weights times their minimum radii of gyration, J: potential energy of the scale of their sizes.
    pub(crate) by_size: f64,
    /// Whether each joint, then each spring, acted in the last step (n_joints + n_springs).
    pub(crate) acting: Vec<bool>,
    /// Minimum energy less the work given, since the last cause that gives no work, J.
    pub(crate) min_energy: f64,
    /// What the error of the work given since the step of that minimum may come to, J.
    pub(crate) doubt: f64,
    /// Maximum energy less the work given and maximum kinetic energy, J, the greatest turn of a body on joints in a step, rad, and what the
    /// error of the work given may come to, J, since anything could take energy away; none in such a step.
    pub(crate) kept: Option<[f64; 4]>,
    /// The least inradius of a shape that moves, m; none where it is not known yet.
    #[serde(skip)]
    pub(crate) inradius: Option<f64>,
    /// What is known of the loads.
    #[serde(default)]
    pub(crate) swings: Vec<Swing>,
    /// Joints whose motors have been said to stand still or to be driven back at their maximum effort.
    pub(crate) noted: Vec<u32>,
    /// Whether it has been said that steps are taken in parts.
    pub(crate) has_parts: bool,
    /// Warnings so far, by kind, in order of their first step.
    pub warnings: Vec<WarningCount>,
}

impl WatchState {
    /// Check that a state, as a file gives it, is one of a model with these counts.
    pub(crate) fn fit(&self, n_bodies: usize, n_acting: usize) -> Result<(), String> {
        let is_started = self.diagonal != 0.0;
        let [bodies, acting] = if is_started { [n_bodies, n_acting] } else { [0, 0] };
        let sizes = [self.diagonal, self.mass, self.by_size, self.doubt];
        if !sizes.iter().all(|size| size.is_finite() && *size >= 0.0) || self.min_energy.is_nan() {
            return Err("has a watch whose sizes are none".into());
        }
        match self.lowest.len() == bodies && self.acting.len() == acting {
            true => Ok(()),
            false => Err("has a watch of other bodies or joints than the model's".into()),
        }
    }
}
