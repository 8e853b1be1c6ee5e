//! The REYES renderer: bound, split, dice, displace, shade, sample, filter, display.
//!
//! [`Context`] takes the calls of the RenderMan Interface and keeps a scene; at `WorldEnd` the image is rendered, bucket by bucket:
//! the primitives that overlap the bucket are taken front to back, culled if hidden, split, diced to grids of micropolygons about a
//! pixel across, displaced and sampled, and shaded where samples see them; then the samples are filtered. A bucket depends on no
//! other, so that any number of threads and any order give the same bits. Shading happens in world space, which shaders call
//! "current".
//!
//! | module | contents | uses |
//! |---|---|---|
//! | `context` | calls of the interface → the scene; `WorldEnd` → render results | all below |
//! | `gpu` | the back end on a graphics device: what it has no kernels for, `cpu` does | `cpu`, all below |
//! | `cpu` | the back end on the processor: buckets, sampling, visible points, shading, rays | `gprim`, `scene`, `film` |
//! | `gprim` | geometric primitives: made from parameters, bounded, split, diced to grids for a `Sink` | `scene` |
//! | `scene` | shapes, sources, attributes, options, camera, motion, area lights | `texture`, `film` |
//! | `texture` | texture, environment and shadow maps, their MIP levels and tiles | – |
//! | [`film`] | sample positions, filters, buckets and shards, displays, image files | – |
//!
//! `stats`, `drawn` and `warnings` stand beside these. A module uses only modules below it in the table, and no two files depend on each
//! other: paths are written out, `crate::module::file`.

mod context;
mod cpu;
mod drawn;
pub mod film;
mod gprim;
mod gpu;
mod scene;
mod stats;
mod texture;
mod warnings;

pub use {ri, sl};

pub use context::result::{DrawnBy, RenderResult};
pub use context::state::Context;
pub use film::display::Display;
pub use gpu::limits::{LEAST_MEMORY as LEAST_DEVICE_MEMORY, Limits as DeviceLimits};
pub use gpu::render::Renderer as DeviceRenderer;
pub use scene::options::{Hider, Options};
pub use sl::has_wide_lanes;
pub use stats::{DeviceSeconds, DeviceStats, Seconds, Stats};
