//! `scree movie`: pictures → a movie by ffmpeg, or an animated PNG where ffmpeg is not there.

use crate::args::MovieArgs;
use crate::report::{Exit, Failure, Outcome};
use frame::{Fault, FaultKind};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// A picture.
pub struct Png {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    color: png::ColorType,
    depth: png::BitDepth,
    data: Vec<u8>,
}

/// The command.
pub fn command(args: &MovieArgs) -> Outcome {
    if !(args.frame_rate > 0.0 && args.frame_rate <= 1000.0) {
        return Err(Failure::new(
            Exit::Usage,
            format!("--frame-rate {}: expected a number above 0 and at most 1000", args.frame_rate),
        ));
    }
    let found = frame::sequence::find(&args.images.join("*.png"))?;
    check_gaps(&args.images, &found.keys().copied().collect::<Vec<_>>())?;
    let images: Vec<PathBuf> = found.into_values().collect();
    let beside = args.images.parent().unwrap_or(Path::new(".")).join("movie.mp4");
    let goal = args.output.clone().unwrap_or(beside);
    println!("{}", encode(&images, &goal.with_extension(""), args.frame_rate)?.display());
    Ok(())
}

/// Pictures are numbered in even steps: a gap means that some are not drawn yet.
fn check_gaps(folder: &Path, numbers: &[u64]) -> Outcome {
    let step = numbers.windows(2).map(|w| w[1] - w[0]).min().unwrap_or(1) as usize;
    let (first, last) = (numbers[0], numbers[numbers.len() - 1]);
    let absent: Vec<String> =
        (first..=last).step_by(step).filter(|n| numbers.binary_search(n).is_err()).map(|n| n.to_string()).collect();
    if absent.is_empty() {
        return Ok(());
    }
    let some = absent.iter().take(20).cloned().collect::<Vec<_>>().join(", ");
    let message = format!("{} pictures are missing between {first} and {last}: {some}", absent.len());
    Err(Fault::whole(FaultKind::Data, folder, message).hint("draw them with `scree render … --missing`").into())
}

/// Read a PNG whole; a torn one is a fault.
pub fn read_png(path: &Path) -> Result<Png, Fault> {
    let torn = |e: png::DecodingError| Fault::whole(FaultKind::Data, path, format!("is not a whole PNG: {e}"));
    let file = std::fs::File::open(path).map_err(|e| Fault::unreadable(FaultKind::Data, path, &e))?;
    let mut reader = png::Decoder::new(std::io::BufReader::new(file)).read_info().map_err(torn)?;
    let mut data = vec![0; reader.output_buffer_size().unwrap_or(0)];
    let info = reader.next_frame(&mut data).map_err(torn)?;
    Ok(Png { width: info.width, height: info.height, color: info.color_type, depth: info.bit_depth, data })
}

/// Encode pictures to `goal` with the ending that it comes to; all are checked to be there, whole and of one size first.
pub fn encode(images: &[PathBuf], goal: &Path, frame_rate: f64) -> Outcome<PathBuf> {
    let mut size = None;
    for path in images {
        let picture = read_png(path)?;
        let own = (picture.width, picture.height);
        if *size.get_or_insert(own) != own {
            let message = format!(
                "is {}×{} pixels, the first picture is {}×{}",
                own.0,
                own.1,
                size.unwrap_or(own).0,
                size.unwrap_or(own).1
            );
            return Err(Fault::whole(FaultKind::Data, path, message).into());
        }
    }
    if images.is_empty() {
        return Err(Failure::new(Exit::Data, "there are no pictures to encode"));
    }
    let named = |ending: &str| PathBuf::from(format!("{}.{ending}", goal.display()));
    if ffmpeg_version().is_some() {
        let movie = named("mp4");
        by_ffmpeg(images, &movie, frame_rate)?;
        return Ok(movie);
    }
    eprintln!(
        "ffmpeg is not on PATH: an animated PNG is written instead; for an MP4 install ffmpeg (Debian: apt-get install ffmpeg) and run `scree movie`"
    );
    let movie = named("apng");
    frame::atomic::write(&movie, &animated_png(images, frame_rate)?)?;
    Ok(movie)
}

/// The first line of `ffmpeg -version`, if ffmpeg is there.
pub fn ffmpeg_version() -> Option<String> {
    let output =
        Command::new("ffmpeg").arg("-version").stdin(Stdio::null()).output().ok().filter(|o| o.status.success())?;
    String::from_utf8_lossy(&output.stdout).lines().next().map(str::to_string)
}

/// Pictures go in through a pipe, so that their numbers need not be without gaps.
fn by_ffmpeg(images: &[PathBuf], movie: &Path, frame_rate: f64) -> Outcome {
    let part = movie.with_extension("part.mp4");
    let fault = |e: std::io::Error| Failure::new(Exit::Fault, format!("ffmpeg: {e}"));
    // H.264 wants even sizes: an odd one is padded by a row or a column.
    let mut child = Command::new("ffmpeg")
        .args([
            "-y",
            "-loglevel",
            "error",
            "-f",
            "image2pipe",
            "-c:v",
            "png",
            "-framerate",
            &frame_rate.to_string(),
            "-i",
            "-",
        ])
        .args([
            "-vf",
            "pad=ceil(iw/2)*2:ceil(ih/2)*2",
            "-c:v",
            "libx264",
            "-pix_fmt",
            "yuv420p",
            "-crf",
            "18",
            "-movflags",
            "+faststart",
        ])
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
        let said = String::from_utf8_lossy(&output.stderr);
        let tail: Vec<&str> = said.lines().rev().take(5).collect();
        let message =
            format!("ffmpeg failed ({}): {}", output.status, tail.into_iter().rev().collect::<Vec<_>>().join("; "));
        return Err(Failure::new(Exit::Fault, message));
    }
    std::fs::rename(&part, movie).map_err(|e| Fault::unwritable(movie, &e).into())
}

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
        let picture = read_png(path)?;
        if (picture.color, picture.depth) != (first.color, first.depth) {
            return Err(Fault::whole(FaultKind::Data, path, "has other channels than the first picture").into());
        }
        writer.write_image_data(&picture.data).map_err(fault)?;
    }
    writer.finish().map_err(fault)?;
    Ok(bytes)
}
