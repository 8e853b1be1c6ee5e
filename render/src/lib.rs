//! The REYES renderer: bound, split, dice, displace, shade, sample, filter, display.
//!
//! [`Context`] takes the calls of the RenderMan Interface and keeps a scene; at `WorldEnd` the image is rendered, bucket by bucket:
//! what overlaps the bucket is taken front to back, culled if hidden, split and diced to grids of micropolygons about a pixel
//! across, displaced, sampled and shaded where samples see it; then the samples are filtered. A bucket depends on no other, so that
//! any number of threads and any order give the same bits. Shading happens in world space, which is what shaders call "current".
//!
//! | room | what it is | uses |
//! |---|---|---|
//! | `context` | the calls of the interface → the scene; `WorldEnd` → render results | all below |
//! | `cpu` | the back end on the processor: buckets, sampling, visible points, shading, rays | `gprim`, `scene`, `film` |
//! | `gprim` | geometric primitives: made from parameters, bounded, split, diced to grids for a `Sink` | `scene` |
//! | `scene` | shapes, sources, attributes, options, camera, motion, area lights | `texture`, `film` |
//! | `texture` | maps, their levels and tiles | – |
//! | [`film`] | sample places, filters, buckets and shards, displays, image files | – |
//!
//! `stats` and `warnings` are beside them. A room uses only rooms below it, and no file uses one that uses it: paths are written
//! out, `crate::room::file`. Another back end stands beside `cpu` and uses what `cpu` uses.

mod context;
mod cpu;
pub mod film;
mod gprim;
mod scene;
mod stats;
mod texture;
mod warnings;

pub use {ri, sl};

pub use context::result::RenderResult;
pub use context::state::Context;
pub use cpu::lanes::has_wide_lanes;
pub use film::display::Display;
pub use scene::options::Options;
pub use stats::{Seconds, Stats};
