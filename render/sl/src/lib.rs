//! The RenderMan shading language: front end, typed IR, the grid machine, and kernels for graphics devices.
//!
//! [`compile`] takes the text of a shader through lexer, parser, type check and lowering to an [`ir::Program`], whose invariants
//! [`ir::validate`] checks before any back end sees it. [`machine::Machine`] runs a program over a whole grid of points at a time;
//! [`wgsl::Kernel`] writes one as the text of a kernel for a graphics device.
//! The crate knows no renderer and no device: a shader queries the scene through [`machine::Scene`]. Source: RISpec sections 10 to 17.

mod back;
mod front;
pub mod ir;
mod shadeop;

pub use back::{machine, wgsl};
pub use front::{Diagnostic, Include, compile, compile_with};
pub use ir::Global;
pub use shadeop::direction::spread;
pub use shadeop::noise;
pub use shadeop::runs::run_of;
pub use shadeop::wide::has_wide_lanes;
