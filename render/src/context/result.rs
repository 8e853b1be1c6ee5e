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
}
