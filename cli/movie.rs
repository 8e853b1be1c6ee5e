//! `scree movie`: images → a movie by ffmpeg, or an animated PNG, which needs no other program.

mod apng;
mod ffmpeg;
mod pixels;

use crate::job::{MovieFile, MovieJob, MovieKind};
use crate::report::{Exit, Failure, Outcome};
use ffmpeg::INSTALL;
use frame::{Fault, FaultKind};
use pixels::Format;
use rayon::prelude::*;
use std::path::{Path, PathBuf};

pub use ffmpeg::{encoders, version as ffmpeg_version};

/// Run `scree movie`.
pub fn run(job: MovieJob) -> Outcome {
    if job.n_missing > 0 {
        let images = if job.n_missing == 1 { "1 image is" } else { &format!("{} images are", job.n_missing) };
        eprintln!("warning: {images} missing and skipped (--keep-gaps)");
    }
    println!("{}", encode(&job.images, &job.output, job.frame_rate)?.display());
    Ok(())
}

/// Encode images as a movie, and give its path. What the movie needs is looked for first; then all images are checked to be complete
/// and of one size.
pub fn encode(images: &[PathBuf], output: &MovieFile, frame_rate: f64) -> Outcome<PathBuf> {
    let (kind, movie) = choose(output)?;
    let encoder = match kind {
        MovieKind::Apng => None,
        _ => Some(ffmpeg::encoder(kind, &movie)?),
    };
    let format = check_images(images)?;
    match encoder {
        Some(encoder) => ffmpeg::encode(images, format, &encoder, &movie, frame_rate)?,
        None => frame::atomic::write(&movie, &apng::encode(images, format, frame_rate)?)?,
    }
    Ok(movie)
}

/// The file of a movie that would be replaced.
pub fn there(output: &MovieFile) -> Option<PathBuf> {
    let (_, path) = named(output, ffmpeg_version().is_some());
    Some(path).filter(|path| path.is_file())
}

/// The kind of movie and its path: of a stem what this machine can encode.
fn named(output: &MovieFile, has_ffmpeg: bool) -> (MovieKind, PathBuf) {
    match output {
        MovieFile::OfKind(kind, path) => (*kind, path.clone()),
        MovieFile::Stem(stem) if has_ffmpeg => (MovieKind::Mp4, with_ending(stem, "mp4")),
        MovieFile::Stem(stem) => (MovieKind::Apng, with_ending(stem, "apng")),
    }
}

/// The same, as far as this machine can encode it.
fn choose(output: &MovieFile) -> Outcome<(MovieKind, PathBuf)> {
    let has_ffmpeg = ffmpeg_version().is_some();
    let (kind, path) = named(output, has_ffmpeg);
    if !has_ffmpeg && kind != MovieKind::Apng {
        let message = format!(
            "{}: ffmpeg is not on PATH; {INSTALL}, or write an animated PNG: `-o {}`",
            path.display(),
            path.with_extension("apng").display()
        );
        return Err(Failure::new(Exit::Fault, message));
    }
    if !has_ffmpeg && matches!(output, MovieFile::Stem(_)) {
        eprintln!(
            "ffmpeg is not on PATH: an animated PNG is written instead; for an MP4 {INSTALL} and run `scree movie`"
        );
    }
    Ok((kind, path))
}

fn with_ending(stem: &Path, ending: &str) -> PathBuf {
    let mut path = stem.as_os_str().to_os_string();
    path.push(format!(".{ending}"));
    path.into()
}

/// Check that there are images, that they are complete, and that they have the size of the first. Gives their common format.
fn check_images(images: &[PathBuf]) -> Outcome<Format> {
    let Some(first_path) = images.first() else {
        return Err(Failure::new(Exit::Data, "there are no images to encode"));
    };
    let all: Vec<Result<Format, Fault>> = images.par_iter().map(|path| pixels::format(path)).collect();
    let mut common: Option<Format> = None;
    for (path, format) in images.iter().zip(all) {
        let format = format?;
        let first = common.get_or_insert(format);
        if (format.width, format.height) != (first.width, first.height) {
            let message = format!(
                "is {}×{} pixels, the first image, {}, is {}×{}",
                format.width,
                format.height,
                first_path.file_name().unwrap_or_default().to_string_lossy(),
                first.width,
                first.height
            );
            let hint = "render all images at one resolution: `scree render … --res WxH` renders those of others again";
            return Err(Fault::whole(FaultKind::Data, path, message).hint(hint).into());
        }
        first.kind = first.kind.filter(|kind| format.kind == Some(*kind));
    }
    common.ok_or_else(|| Failure::new(Exit::Data, "there are no images to encode"))
}
