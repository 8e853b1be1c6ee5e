//! The REYES renderer: bound, split, dice, displace, shade, sample, filter, display.
//!
//! [`Context`] takes the calls of the RenderMan Interface and keeps a `scene::world::Scene`; at `WorldEnd` the picture is made,
//! bucket by bucket: what overlaps the bucket is taken front to back, culled if hidden, split and diced to grids of
//! micropolygons about a pixel across (`sphere`, `patch`), displaced and shaded a grid at a time (`shade`), and sampled
//! (`sample`); then the samples are filtered (`film::filter`). A bucket depends on no other, so that any number of threads and
//! any order give the same bits. Spaces: shading happens in world space, which is what shaders call "current".

mod context;
mod cpu;
pub mod film;
mod gprim;
mod scene;
mod stats;
mod texture;
mod warnings;

pub use {ri, sl};

pub use context::result::Finished;
pub use context::state::Context;
pub use film::display::Display;
pub use scene::options::Options;
pub use stats::{Seconds, Stats};
