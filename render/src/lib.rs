//! The REYES renderer: bound, split, dice, displace, shade, sample, filter, display.
//!
//! [`Context`] takes the calls of the RenderMan Interface and keeps a [`scene::Scene`]; at `WorldEnd` the picture is made,
//! [`bucket`] by bucket: what overlaps the bucket is taken front to back, culled if hidden, split and diced to grids of
//! micropolygons about a pixel across (`sphere`, `patch`), displaced and shaded a grid at a time (`shade`), and sampled
//! (`sample`); then the samples are filtered ([`filter`]). A bucket depends on no other, so that any number of threads and
//! any order give the same bits. Spaces: shading happens in world space, which is what shaders call "current".

mod area;
mod blobby;
mod blur;
pub mod bucket;
mod bvh;
mod camera;
mod context;
pub mod filter;
mod gprim;
pub mod image;
mod imager;
mod jitter;
mod lanes;
mod motion;
mod options;
pub mod output;
mod patch;
mod sample;
pub mod scene;
mod seen;
mod shade;
mod sphere;
mod still;
mod subdivision;
mod surfaces;
mod texture;
mod trim;
mod view;

pub use {ri, sl};

pub use context::{Context, Finished};
pub use lanes::has_wide_lanes;
pub use options::Options;
pub use output::Display;
