//! Metadata of Chrono::Render (Python, 2011–2014): its jobs as bindings.
//!
//! What the original does differently from what it means is done as it means: matrices come from whole quaternions, angles may be
//! negative, sizes hold for every shape, and a frame's number is the last one in its file's name. Every element may be one map or a
//! list of them. Python hooks cannot be run: the message says what to use instead.

mod data;
mod job;
mod objects;
mod pass;
mod places;
mod scene;
mod shaders;

pub use job::ROOT;
pub use pass::check;
