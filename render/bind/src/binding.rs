//! A binding: what to draw of which data, checked and resolved; the one form that the emitter reads.
//!
//! Metadata files ([`crate::metadata`]) and jobs of Chrono::Render ([`crate::chronorender`]) both end as bindings, and neither
//! knows the other. Whatever stands in a file as text, names or nested keys is here a value: shapes are one of a kind, colour
//! maps and shader parameters are found, and expressions are programs ([`Formula`]), compiled once for all frames.
//!
//! Keys (`objects.2.select`) are those of metadata files. The file's [`frame::yaml::Document`] finds the place of a key, or of the longest part
//! of it that the file has.

mod check;
mod object;
mod resolved;

pub use check::{delimiter, some_objects};
pub use object::{Color, Formula, Object, Shader, Shape};
pub use resolved::{Binding, Camera, Data, ImageFormat, Lens, Output, Place, Placed, Projection};
