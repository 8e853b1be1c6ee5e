//! Warnings about steps, and what is remembered for them.

use serde::{Deserialize, Serialize};

/// What a warning is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum WarningKind {
    /// The contact solver has not converged.
    Residual,
    /// A joint is violated.
    Joint,
    /// Energy has grown without a cause.
    Energy,
}

impl WarningKind {
    /// All kinds.
    pub const ALL: [WarningKind; 3] = [WarningKind::Residual, WarningKind::Joint, WarningKind::Energy];

    /// The name, as `run.json` writes it.
    pub fn name(self) -> &'static str {
        match self {
            WarningKind::Residual => "residual",
            WarningKind::Joint => "joint",
            WarningKind::Energy => "energy",
        }
    }
}

/// A warning about one step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Warning {
    /// Kind.
    pub kind: WarningKind,
    /// The step, from 1.
    pub step: u64,
    /// Time after it, s.
    pub time: f64,
    /// What it says, with the body's or joint's name and the value and its bound.
    pub message: String,
}

impl std::fmt::Display for Warning {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "step {} ({:.6} s): {}", self.step, self.time, self.message)
    }
}

/// The steps of a run with a warning of one kind.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WarningCount {
    /// Number of such steps.
    pub count: u64,
    /// The first of them.
    pub first: Warning,
}

/// Why a run cannot go on.
#[derive(Clone, Debug, PartialEq)]
pub struct Broken {
    /// The body that shows it, if it is one.
    pub body: Option<usize>,
    /// What is wrong.
    pub why: String,
}

/// What the watch over a run remembers from step to step; part of the state, so that a run that goes on from a checkpoint says the same.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Memory {
    /// Diagonal of the bounding box of what moved or was jointed at the start, m; 0 before the first step.
    pub(crate) diagonal: f64,
    /// The least gravitational potential where each body has been, at most that of the initial box's bottom, J/kg (n_bodies).
    pub(crate) lowest: Vec<f64>,
    /// Moving mass in the last step, kg.
    pub(crate) mass: f64,
    /// Its weight times radii of gyration, summed, J: the potential energy that bodies have by their size.
    pub(crate) by_size: f64,
    /// Whether a spring or joint held in the last step, in their order.
    pub(crate) held: Vec<bool>,
    /// Least energy since the last cause, J.
    pub(crate) least: f64,
    /// Warnings so far, by kind, in order of their first step.
    pub warnings: Vec<WarningCount>,
}
