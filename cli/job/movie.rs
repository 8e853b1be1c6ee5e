//! The job of `scree movie`.

use crate::args::MovieArgs;
use crate::report::Outcome;
use frame::{Fault, FaultKind};
use std::path::{Path, PathBuf};

/// A movie to encode.
pub struct MovieJob {
    /// The images, in order.
    pub images: Vec<PathBuf>,
    /// The movie's path without its ending, which is the encoder's.
    pub output: PathBuf,
    /// Frames per second.
    pub frame_rate: f64,
}

impl MovieJob {
    /// Check the arguments: find the images.
    pub fn check(args: MovieArgs) -> Outcome<MovieJob> {
        let found = frame::sequence::find(&args.images.join("*.png"))?;
        check_gaps(&args.images, &found.keys().copied().collect::<Vec<_>>())?;
        let beside = || args.images.parent().unwrap_or(Path::new(".")).join("movie.mp4");
        let output = args.output.clone().unwrap_or_else(beside).with_extension("");
        Ok(MovieJob { images: found.into_values().collect(), output, frame_rate: args.frame_rate })
    }
}

/// Check that the images' frames are evenly spaced: a gap means that some are not rendered yet.
fn check_gaps(folder: &Path, frames: &[u64]) -> Outcome {
    let step = frames.windows(2).map(|w| w[1] - w[0]).min().unwrap_or(1) as usize;
    let (first, last) = (frames[0], frames[frames.len() - 1]);
    let missing: Vec<String> =
        (first..=last).step_by(step).filter(|f| frames.binary_search(f).is_err()).map(|f| f.to_string()).collect();
    if missing.is_empty() {
        return Ok(());
    }
    let some = missing.iter().take(20).cloned().collect::<Vec<_>>().join(", ");
    let (noun, verb) = if missing.len() == 1 { ("image", "is") } else { ("images", "are") };
    let message = format!("{} {noun} {verb} missing between {first} and {last}: {some}", missing.len());
    Err(Fault::whole(FaultKind::Data, folder, message).hint("render them with `scree render … --missing`").into())
}
