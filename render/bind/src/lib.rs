//! Metadata that binds data columns to geometry and shaders, and the injection into scenes.
//!
//! A [`metadata::Metadata`] file says where the data is, which rows are which object and what each object looks like;
//! [`data::Source`] reads the frames; [`emit`] reads a predefined scene and, at its `#scree inject` directives, makes the
//! RenderMan calls that draw a frame. [`suggest`] writes a starting metadata file for data that has none.

pub mod chronorender;
pub mod colormap;
pub mod data;
pub mod emit;
pub mod expr;
pub mod frames;
pub mod metadata;
pub mod suggest;

pub use metadata::Metadata;
