//! Multibody dynamics: many rigid bodies with Coulomb friction cones, joints, motors and loads.
//!
//! A YAML file ([`model_file`]) or code ([`ModelBuilder`]) becomes a [`Model`] and a mutable [`State`]; [`Simulation`] advances
//! the state by running the [`stages`] in order. Equations: `D` collects the contact Jacobians, `γ` the contact impulses,
//! `N = Dᵀ M̃⁻¹ D` with the joints eliminated; a step minimises `½ γᵀNγ + rᵀγ` over the product of friction cones (Negrut et
//! al. 2012, §2).

mod aabb;
mod assembly;
mod backend;
mod builder;
pub mod checkpoint;
mod contacts;
mod cpu;
mod fill;
pub mod geometry;
mod inertia;
pub mod joint;
mod lanes;
pub mod load;
mod model;
pub mod model_file;
mod outcome;
pub mod overlaps;
mod plan;
mod pose;
mod probe;
pub mod problem;
mod rows;
pub mod run;
mod settings;
mod shape;
mod simulation;
mod sphere;
pub mod stages;
mod state;
mod table;
mod terrain;
mod twist;
mod warning;
pub mod watch;
pub mod workload;

pub use aabb::Aabb;
pub use backend::Backend;
pub use builder::ModelBuilder;
pub use contacts::{Arms, Contacts, Tiles};
pub use fill::SplitMix64;
pub use lanes::has_wide_lanes;
pub use model::{ContactLaw, Model, Scheduled};
pub use outcome::{JointErrors, Outcome, StepOutcome};
pub use plan::{ContactMethod, Narrow, StepPlan};
pub use pose::{Pose, PoseColumn};
pub use probe::{probe_header, probe_line};
pub use settings::{FrictionLaw, Method, SolverSettings};
pub use shape::ShapeKind;
pub use simulation::{Simulation, StepReport};
pub use state::{Activity, State};
pub use table::{contacts_of, frame_of, report_header, report_line};
pub use twist::Twist;
