//! Bindings: data, objects, camera and output of images, checked and resolved. A binding is the one form that [`crate::emit`]
//! reads.
//!
//! Metadata files ([`crate::metadata`]) and jobs of Chrono::Render ([`crate::chronorender`]) both become bindings, and neither
//! module depends on the other. What a file has as text, names or nested keys is a value here: a shape is one variant of [`Shape`],
//! colour maps and shader parameters are looked up, and expressions are programs ([`Formula`]), compiled once for all frames.
//!
//! Keys (`objects.2.select`) are those of metadata files. The file's [`frame::yaml::Document`] finds the place of a key, or of the
//! longest part of it that the file has. "The file" below is the metadata file or job; relative paths start from its folder.

mod check;
mod object;
mod overlays;
mod resolved;

pub use crate::formula::Formula;
pub use check::{delimiter, some_objects};
pub use object::{Archive, Arrow, Color, Object, Reach, Shader, Shape, Trail};
pub use overlays::{Axes, Corner, GrowingPlot, Legend, Overlays, Panel, ScaleBar, TIME_UNITS, TimeStamp, Title};
pub use resolved::{
    BLACK, Binding, Camera, Data, ImageFormat, Key, Lens, Output, Place, Placed, Projection, Quality, WHITE,
};
