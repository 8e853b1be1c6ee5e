//! The job of `scree run`.

use super::frames::{FramesJob, Origin};
use super::images::ImageOptions;
use super::movie::MovieFile;
use super::output::{default_folder, stem};
use super::render::DrawOn;
use super::run_folder::spare_link;
use super::simulate::computer;
use crate::args::RunArgs;
use crate::report::Outcome;
use crate::source;
use std::path::PathBuf;

/// A movie to make from a model or a metadata file.
pub struct RunJob {
    /// The frames.
    pub frames: FramesJob,
    /// Choices of the command line for the images.
    pub options: ImageOptions,
    /// The folder of the images.
    pub images: PathBuf,
    /// The movie's file.
    pub movie: MovieFile,
    /// What draws.
    pub on: DrawOn,
}

impl RunJob {
    /// Check the arguments.
    pub fn check(args: RunArgs) -> Outcome<RunJob> {
        let on = DrawOn::check(args.backend, args.adapter.clone())?;
        let computer = computer(args.backend, args.adapter)?;
        let home = args.output.unwrap_or_else(|| default_folder(&args.input));
        let (images, movie) = (home.join("images"), MovieFile::Stem(home.join(stem(&args.input))));
        if !args.image.allow_outside {
            spare_link(&images, &home)?;
        }
        let mut frames = FramesJob::of_yaml(&args.input, home, args.fresh)?;
        if let Origin::Model(run) = &mut frames.origin {
            run.computer = computer;
        }
        if let (None, Some(name)) = (&frames.binding, source::metadata_beside(&args.input)) {
            eprintln!(
                "note: {name} beside this model says how to draw it: `scree run {name}` does that, this draws it plainly"
            );
        }
        Ok(RunJob { frames, options: ImageOptions::check(args.image, args.redraw.redraw)?, images, movie, on })
    }
}
