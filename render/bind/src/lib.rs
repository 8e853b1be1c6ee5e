//! Metadata, which binds columns of data to geometry and shaders, and its injection into RIB scenes.
//!
//! A metadata file ([`metadata::Metadata`]), or a job of [`chronorender`], names the data, the rows that make up each object, and
//! each object's geometry and shaders. [`read`] makes a checked and resolved [`Binding`] of either. [`data::Source`] reads the
//! frames; [`emit`] reads a scene and, at its `#scree inject` directives, makes the RenderMan calls that draw a frame by the
//! binding. [`suggest`] makes a first metadata file for data that has none.

pub mod binding;
pub mod chronorender;
pub mod colormap;
pub mod data;
pub mod emit;
pub mod expr;
pub mod file;
mod formula;
pub mod metadata;
pub mod moment;
pub mod suggest;
mod up;

pub use binding::Binding;
pub use file::read;
pub use metadata::Metadata;
pub use moment::Moment;
pub use up::Up;
