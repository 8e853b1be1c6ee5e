//! The RenderMan Interface: one trait, the RIB reader and the RIB writer.
//!
//! [`Ri`] is the only door to a renderer: the [`reader`] makes its calls from RIB, a binder makes them from tables, Rust callers
//! make them by hand, and the [`writer`] is one more `Ri`, which turns them back into RIB. All three, and the trait itself, come
//! from one table of requests (`table.rs`). Conventions are those of the RenderMan Interface Specification 3.2 (RISpec): row
//! vectors, left-handed camera space, angles in degrees.

mod arguments;
mod binary;
mod conditions;
mod dispatch;
pub mod files;
mod groups;
mod instances;
mod lexer;
mod line;
mod params;
mod programs;
pub mod reader;
pub mod requests;
mod ri;
mod standing;
mod table;
pub mod writer;

pub use instances::{InstanceShape, Instances};
pub use params::{Class, Declaration, Declarations, Param, Params, Type, Values};
pub use reader::{Place, RibError};
pub use ri::{Fail, Knots, Ri, RiResult, Tags, TrimCurves};
