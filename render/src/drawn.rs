//! What a back end gives of a frame.

use crate::film::image::Image;
use crate::stats::Stats;

/// A frame as a back end has drawn it.
pub struct Drawn {
    /// The image, before exposure unless there is an imager shader.
    pub image: Image,
    /// Render statistics.
    pub stats: Stats,
    /// The identities of what samples see, if these are kept: row by row, one pixel's samples after another's; 0 where nothing is.
    pub identities: Vec<u64>,
}
