//! The RenderMan shading language: front end, typed IR, and the grid machine.
//!
//! [`compile`] takes the text of a shader through lexer, parser, and check-and-lower to an [`ir::Program`], whose
//! invariants [`ir::validate`] holds before any back end sees it. [`machine::Machine`] runs a program over a whole grid of
//! points at a time. Nothing here knows what renders: what a shader asks of the scene goes through [`machine::Scene`].

mod back;
mod front;
pub mod ir;
mod shadeop;

pub use back::machine;
pub use front::{Diagnostic, Include, compile, compile_with};
pub use ir::Global;
pub use shadeop::direction::spread;
pub use shadeop::noise;
