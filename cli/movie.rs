//! `scree movie`: images → a movie by ffmpeg, or an animated PNG where ffmpeg is not installed.

use crate::image_file::read_png;
use crate::job::MovieJob;
use crate::report::{Exit, Failure, Outcome};
use frame::{Fault, FaultKind};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Run `scree movie`.
pub fn run(job: MovieJob) -> Outcome {
    println!("{}", encode(&job.images, &job.output, job.frame_rate)?.display());
    Ok(())
}

/// Encode images as the movie `output`, to which the encoder's ending is added; all images are checked first to be complete and of
/// one size.
pub fn encode(images: &[PathBuf], output: &Path, frame_rate: f64) -> Outcome<PathBuf> {
    check_sizes(images)?;
    let with_ending = |ending: &str| PathBuf::from(format!("{}.{ending}", output.display()));
    if ffmpeg_version().is_some() {
        let movie = with_ending("mp4");
        encode_by_ffmpeg(images, &movie, frame_rate)?;
        return Ok(movie);
    }
    eprintln!(
        "ffmpeg is not on PATH: an animated PNG is written instead; for an MP4 install ffmpeg (Debian: apt-get install ffmpeg) and run `scree movie`"
    );
    let movie = with_ending("apng");
    frame::atomic::write(&movie, &animated_png(images, frame_rate)?)?;
    Ok(movie)
}

/// Check that there are images, that they are complete, and that they have the size of the first.
fn check_sizes(images: &[PathBuf]) -> Outcome {
    let mut first = None;
    for path in images {
        let png = read_png(path)?;
        let (width, height) = (png.width, png.height);
        let (first_width, first_height) = *first.get_or_insert((width, height));
        if (first_width, first_height) != (width, height) {
            let message = format!("is {width}×{height} pixels, the first image is {first_width}×{first_height}");
            return Err(Fault::whole(FaultKind::Data, path, message).into());
        }
    }
    match first {
        Some(_) => Ok(()),
        None => Err(Failure::new(Exit::Data, "there are no images to encode")),
    }
}

/// The first line of `ffmpeg -version`, if ffmpeg is there.
pub fn ffmpeg_version() -> Option<String> {
    let output =
        Command::new("ffmpeg").arg("-version").stdin(Stdio::null()).output().ok().filter(|o| o.status.success())?;
    String::from_utf8_lossy(&output.stdout).lines().next().map(str::to_string)
}

/// Encode images as H.264 by ffmpeg. They go through a pipe, so that their frames may have gaps.
fn encode_by_ffmpeg(images: &[PathBuf], movie: &Path, frame_rate: f64) -> Outcome {
    let part = movie.with_extension("part.mp4");
    let fault = |e: std::io::Error| Failure::new(Exit::Fault, format!("ffmpeg: {e}"));
    // H.264 wants even sizes: an odd one is padded by a row or a column.
    let mut child = Command::new("ffmpeg")
        .args(["-y", "-loglevel", "error", "-f", "image2pipe", "-c:v", "png", "-framerate", &frame_rate.to_string()])
        .args(["-i", "-", "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-c:v", "libx264", "-pix_fmt", "yuv420p"])
        .args(["-crf", "18", "-movflags", "+faststart"])
        .arg(&part)
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(fault)?;
    let mut pipe = child.stdin.take().ok_or_else(|| Failure::new(Exit::Fault, "ffmpeg has no input"))?;
    for path in images {
        let bytes = std::fs::read(path).map_err(|e| Fault::unreadable(FaultKind::Data, path, &e))?;
        if pipe.write_all(&bytes).is_err() {
            break;
        }
    }
    drop(pipe);
    let output = child.wait_with_output().map_err(fault)?;
    if !output.status.success() {
        let _ = std::fs::remove_file(&part);
        let errors = String::from_utf8_lossy(&output.stderr);
        let tail: Vec<&str> = errors.lines().rev().take(5).collect();
        let message =
            format!("ffmpeg failed ({}): {}", output.status, tail.into_iter().rev().collect::<Vec<_>>().join("; "));
        return Err(Failure::new(Exit::Fault, message));
    }
    std::fs::rename(&part, movie).map_err(|e| Fault::unwritable(movie, &e).into())
}

/// The bytes of an animated PNG of images.
fn animated_png(images: &[PathBuf], frame_rate: f64) -> Outcome<Vec<u8>> {
    let first = read_png(&images[0])?;
    let fault = |e: png::EncodingError| Failure::new(Exit::Fault, format!("animated PNG: {e}"));
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, first.width, first.height);
    encoder.set_color(first.color);
    encoder.set_depth(first.depth);
    encoder.set_animated(images.len() as u32, 0).map_err(fault)?;
    let delay = (1000.0 / frame_rate).round().clamp(1.0, 65_535.0) as u16;
    encoder.set_frame_delay(delay, 1000).map_err(fault)?;
    let mut writer = encoder.write_header().map_err(fault)?;
    for path in images {
        let png = read_png(path)?;
        if (png.color, png.depth) != (first.color, first.depth) {
            return Err(Fault::whole(FaultKind::Data, path, "has other channels than the first image").into());
        }
        writer.write_image_data(&png.data).map_err(fault)?;
    }
    writer.finish().map_err(fault)?;
    Ok(bytes)
}
