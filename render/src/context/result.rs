//! Render results.

use crate::film::image::Image;
use crate::scene::options::Options;
use crate::stats::Stats;

/// A finished picture and what it took.
pub struct Finished {
    /// Its number, from `FrameBegin`, or 0.
    pub frame: i32,
    /// The options that it was made with, its displays among them.
    pub options: Options,
    /// The picture, exposed.
    pub image: Image,
    /// What it took.
    pub stats: Stats,
    /// What is odd about the scene.
    pub warnings: Vec<String>,
}
