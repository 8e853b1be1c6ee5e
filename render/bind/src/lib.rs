//! Metadata that binds data columns to geometry and shaders, and the injection into scenes.
//!
//! A file says where the data is, which rows are which object and what each object looks like: a [`metadata::Metadata`] file, or a
//! job of [`chronorender`]. [`read`] makes a [`Binding`] of either, checked and resolved. [`data::Source`] reads the frames;
//! [`emit`] reads a predefined scene and, at its `#scree inject` directives, makes the RenderMan calls that draw a frame as the
//! binding says. [`suggest`] writes a starting metadata file for data that has none.

pub mod binding;
pub mod chronorender;
pub mod colormap;
pub mod data;
pub mod emit;
pub mod expr;
pub mod file;
pub mod metadata;
pub mod suggest;

pub use binding::Binding;
pub use file::read;
pub use metadata::Metadata;
