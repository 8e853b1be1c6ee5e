//! Many rigid bodies with exact Coulomb friction cones, joints, motors and loads.
//!
//! A YAML file ([`model_file`]) or code ([`ModelBuilder`]) becomes a [`Model`] and a mutable [`State`]; [`Simulation`] advances
//! the state by running the [`stages`] in order. Equations: `D` collects the contact Jacobians, `γ` the contact impulses,
//! `N = Dᵀ M̃⁻¹ D` with the joints eliminated; a step minimises `½ γᵀNγ + rᵀγ` over the product of friction cones (Negrut et
//! al. 2012, §2).

mod assembly;
mod builder;
pub mod checkpoint;
mod cpu;
mod fill;
pub mod geometry;
pub mod joint;
mod lanes;
pub mod load;
pub mod model_file;
mod probe;
pub mod run;
pub mod solve;
pub mod stages;
mod state;
mod table;
mod terrain;
mod twist;
pub mod watch;
pub mod workload;

pub use builder::ModelBuilder;
pub use fill::SplitMix64;
pub use lanes::has_wide_lanes;
pub use probe::{probe_header, probe_line};
pub use solve::{Method, SolverSettings};
pub use stages::{Simulation, StepReport};
pub use state::{ContactLaw, Contacts, FrictionLaw, Late, Model, Pose, ShapeKind, State};
pub use table::{contacts_of, frame_of, report_header, report_line};
