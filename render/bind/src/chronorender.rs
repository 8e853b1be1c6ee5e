//! Jobs of Chrono::Render (Python, 2011–2014), its metadata files, as bindings.
//!
//! Known defects of the original are not reproduced: matrices are made from all four components of quaternions, angles may be
//! negative, sizes apply to every shape, and a frame's number is the last number in its file's name. Every element may be one map
//! or a list of maps. Python hooks are unsupported: the error names what to use instead.

mod data;
mod job;
mod objects;
mod pass;
mod places;
mod scene;
mod shaders;

pub use job::ROOT;
pub use pass::check;
