//! The RenderMan Interface: one trait, the RIB reader and the RIB writer.
//!
//! [`Ri`] is the only interface to a renderer: the [`reader`] makes its calls from RIB, the crate `bind` makes them from tables of
//! data, Rust callers make them directly, and the [`writer`] implements `Ri` by writing the calls as RIB. The trait, the reader and
//! the writer are generated from one table of requests (`table.rs`). Conventions are those of the RenderMan Interface Specification
//! 3.2 (RISpec): row vectors, left-handed camera space, angles in degrees.

mod arguments;
mod binary;
mod conditions;
mod dispatch;
pub mod files;
mod groups;
pub mod imprint;
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
mod unread;
pub mod writer;

pub use instances::{Fit, InstanceShape, Instances};
pub use params::{Class, Declaration, Declarations, Param, Params, Type, Values};
pub use reader::{Place, RibError};
pub use ri::{Fail, Knots, Ri, RiResult, Tags, TrimCurves};
