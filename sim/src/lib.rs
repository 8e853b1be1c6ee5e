//! Multibody dynamics: many rigid bodies with Coulomb friction cones, joints, motors, springs and loads.
//!
//! A YAML file ([`model_file`]) or code ([`ModelBuilder`]) becomes a [`Model`] and a mutable [`State`]; [`Simulation`] advances
//! the state by running the [`stages`] in order. [`run`] writes a whole simulation to a run directory.
//!
//! Units are SI: m, kg, s, N, rad. Bodies, shapes, joints and contacts are rows of columns, and their ids are indices of rows;
//! `(n_bodies)` behind a column's meaning is its length. A body's *principal frame* has its origin at the centre of mass and its
//! axes along the principal axes of inertia.
//!
//! Equations of a step of length h: `D` collects the contact Jacobians, `γ` (N s) the contact impulses, `M̃⁻¹` is the inverse mass
//! matrix with the joints eliminated, and `r` (m/s) the velocities at the contacts without contact impulses plus the gaps over h.
//! With `N = Dᵀ M̃⁻¹ D`, a step minimises `½ γᵀNγ + rᵀγ` over the product of friction cones.
//!
//! Source: D. Negrut et al., *Investigating the mobility of light autonomous tracked vehicles using a high performance computing
//! simulation capability* (2012), §2; cited below as Negrut et al. 2012.

mod aabb;
mod assembly;
mod backend;
mod body_names;
mod builder;
pub mod checkpoint;
mod contacts;
mod cpu;
mod disjoint_sets;
mod farthest;
mod fill;
pub mod geometry;
pub mod gpu;
mod heap;
mod inertia;
pub mod joint;
mod joint_factor;
pub mod joint_system;
mod lanes;
pub mod load;
pub mod manifolds;
mod model;
pub mod model_file;
mod outcome;
pub mod overlaps;
mod pace;
mod parts;
mod plan;
mod pose;
mod probe;
pub mod problem;
mod rows;
pub mod run;
mod settings;
mod shape;
mod simulation;
pub mod sleep;
mod sleepers;
mod sphere;
mod spring_rates;
pub mod stages;
mod state;
mod swing;
mod table;
mod team;
mod terrain;
mod twist;
mod warning;
pub mod watch;
mod work;
pub mod workload;

pub use aabb::Aabb;
pub use backend::Backend;
pub use body_names::BodyNames;
pub use builder::ModelBuilder;
pub use contacts::{Arms, Contacts, Tiles};
pub use fill::SplitMix64;
pub use joint_factor::JointFactor;
pub use lanes::{Registers, registers};
pub use model::{ContactLaw, Model, Scheduled};
pub use outcome::{JointErrors, Outcome, StepOutcome};
pub use pace::{Bend, Pace};
pub use plan::{ContactMethod, Narrow, StepPlan};
pub use pose::{Pose, PoseColumn};
pub use probe::probe_header;
pub use settings::{FrictionLaw, Impacts, Method, Quality, SolverSettings};
pub use shape::ShapeKind;
pub use simulation::{Simulation, StepFault, StepReport};
pub use sleepers::Sleepers;
pub use state::{Activity, State};
pub use table::{contacts_of, frame_of, report_header, report_line};
pub use twist::Twist;
