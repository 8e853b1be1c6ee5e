//! Many rigid bodies with exact Coulomb friction cones.
//!
//! A YAML file ([`model_file`]) is checked and resolved into a constant [`Model`] and a mutable [`State`]; [`Simulation`]
//! advances the state by running the [`stages`] in order. Equations: `D` collects the contact Jacobians, `γ` the contact
//! impulses, `N = Dᵀ M⁻¹ D`; a step minimises `½ γᵀNγ + rᵀγ` over the product of friction cones (Negrut et al. 2012, §2).

mod cpu;
mod fill;
pub mod model_file;
pub mod stages;
mod state;
mod table;
pub mod workload;

pub use cpu::contact_solve::{Method, SolverSettings};
pub use fill::SplitMix64;
pub use stages::{Simulation, StepReport};
pub use state::{Contacts, FrictionLaw, Model, ShapeKind, State};
pub use table::{frame_of, report_header, report_line};
