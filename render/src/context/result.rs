//! Render results.

use crate::film::image::Image;
use crate::scene::options::Options;
use crate::stats::Stats;

/// A render result: an image, its options, statistics and warnings.
pub struct RenderResult {
    /// Frame number, from `FrameBegin`, or 0.
    pub frame: i32,
    /// Options of the image, its displays among them.
    pub options: Options,
    /// The image, after exposure and before quantization.
    pub image: Image,
    /// Render statistics.
    pub stats: Stats,
    /// Warnings about the scene.
    pub warnings: Vec<String>,
    /// The back end.
    pub drawn_by: DrawnBy,
    /// The identities of what samples see, if these are kept ([`Context::keep_ids`](crate::Context::keep_ids)): row by row, one pixel's
    /// samples after another's; 0 where nothing opaque is. Back ends give them alike.
    pub identities: Vec<u64>,
}

/// What has drawn an image.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DrawnBy {
    /// The processor.
    Cpu,
    /// A graphics device.
    Gpu,
    /// The processor in a device's stead, and why.
    Fallback(String),
}
