//! `scree run`: from a model or a metadata file to a movie.

use crate::device::Drawer;
use crate::drawing::{self, Drawing};
use crate::job::{ImageJob, MovieFile, Origin, RunJob, Statistics};
use crate::report::Outcome;
use crate::{images, model_run, movie};
use std::collections::HashSet;
use std::path::PathBuf;

/// Run `scree run`.
pub fn run(job: RunJob) -> Outcome {
    let home = job.frames.home.clone();
    let is_simulated = !matches!(job.frames.origin, Origin::Data(_));
    let how = Drawing { folder: job.images, options: &job.options, shard: None, statistics: Statistics::default() };
    let (images, failed) = drawing::draw(job.frames, how, &mut Drawer::new(job.on))?;
    let n = images.frames.len();
    if failed.len() < n {
        println!("images: {} in {}", n - failed.len(), images.folder.display());
    }
    // A movie that jumps over frames would be taken for a whole one.
    failed.outcome(n, "the others were rendered, and no movie is written")?;
    if job.options.frames.is_some()
        && has_others(&images)
        && let Some(movie) = movie::there(&job.movie)
    {
        eprintln!(
            "note: {} stays as it is: there are images of other frames than those of --frames; the same command without --frames makes it of all",
            movie.display()
        );
    } else {
        encode(&images, &job.movie)?;
    }
    images::check_missing(&images)?;
    if is_simulated { model_run::check_warnings(&home) } else { Ok(()) }
}

/// Whether there are images of other frames of the data than those of the job.
fn has_others(images: &ImageJob) -> bool {
    let drawn: HashSet<u64> = images.frames.iter().copied().collect();
    let is_other = |frame: &u64| !drawn.contains(frame) && images.image(*frame).is_file();
    images.source.numbers().iter().any(is_other)
}

/// Make the movie of a job's images, in the order of the frames, and return its file; of EXR images there is none.
pub fn encode(images: &ImageJob, output: &MovieFile) -> Outcome<Option<PathBuf>> {
    let files = images.images();
    if files.first().is_some_and(|i| i.extension().is_some_and(|e| e != "png")) {
        eprintln!("warning: movies are made of PNG images, and these are EXR (`output.format`): no movie is written");
        return Ok(None);
    }
    let movie = movie::encode(&files, output, images.binding.frame_rate)?;
    println!("movie: {}", movie.display());
    Ok(Some(movie))
}
