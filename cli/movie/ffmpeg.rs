//! Movies by ffmpeg: which of its encoders makes which kind of movie, how colours are converted, and how a movie is written whole.
//!
//! Images go to ffmpeg as raw 8-bit red, green and blue through a pipe, so that their frames may have gaps. Where colours are
//! subsampled, the matrix is that of BT.709 in its limited range, and the movie is tagged so: a player that is not told guesses by
//! the size of the image, and small movies come out in other colours.

use super::pixels::{self, Format};
use crate::job::MovieKind;
use crate::progress::Progress;
use crate::report::{Exit, Failure, Outcome};
use frame::Fault;
use std::fs::File;
use std::io::{Read, Seek, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// How ffmpeg is installed.
pub const INSTALL: &str = "install ffmpeg (Debian: apt-get install ffmpeg)";

/// An encoder of ffmpeg with its options, and the container that it writes.
pub struct Encoder {
    container: &'static str,
    name: &'static str,
    options: &'static [&'static str],
}

/// Encoders that would do, with their options.
type Choices = &'static [(&'static str, &'static [&'static str])];

/// Encoders by the order in which they are tried. VP8 is none of them, since its colors are never those of BT.709.
const H264: [(&str, &[&str]); 2] =
    [("libx264", &["-crf", "18", "-preset", "medium"]), ("libopenh264", &["-b:v", "12M"])];
const WEBM: [(&str, &[&str]); 3] = [
    ("libvpx-vp9", &["-crf", "22", "-b:v", "0", "-row-mt", "1", "-deadline", "good", "-cpu-used", "3"]),
    ("libaom-av1", &["-crf", "24", "-b:v", "0", "-cpu-used", "6", "-row-mt", "1"]),
    ("libsvtav1", &["-crf", "24", "-preset", "8"]),
];
const GIF: [(&str, &[&str]); 1] = [("gif", &["-loop", "0"])];

/// BT.709 in limited range: converted so, and tagged so.
const COLORS: &str = "scale=out_color_matrix=bt709:out_range=tv:flags=accurate_rnd+full_chroma_int,format=yuv420p,\
                      setparams=range=tv:color_primaries=bt709:color_trc=bt709:colorspace=bt709";
const TAGS: [&str; 8] =
    ["-color_range", "tv", "-color_primaries", "bt709", "-color_trc", "bt709", "-colorspace", "bt709"];

/// The first line of `ffmpeg -version`, if ffmpeg is there.
pub fn version() -> Option<String> {
    ask(&["-version"])?.lines().next().map(str::to_string)
}

/// The answer of ffmpeg to a question.
fn ask(question: &[&str]) -> Option<String> {
    let output = Command::new("ffmpeg").args(question).stdin(Stdio::null()).output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).to_string())
}

/// Of each kind of movie, the encoder that this ffmpeg would make it by, if it has one.
pub fn encoders() -> Vec<(&'static str, Option<&'static str>)> {
    let list = list();
    let kinds: [(_, Choices); 3] = [("mp4, mov, mkv", &H264), ("webm", &WEBM), ("gif", &GIF)];
    kinds.map(|(kind, wanted)| (kind, first_there(wanted, &list).map(|(name, _)| *name))).into()
}

/// The encoders of this ffmpeg, a line each.
fn list() -> String {
    ask(&["-hide_banner", "-encoders"]).unwrap_or_default()
}

/// The first of some encoders that is in the list of those that are there.
fn first_there(wanted: Choices, list: &str) -> Option<&'static (&'static str, &'static [&'static str])> {
    wanted.iter().find(|(name, _)| list.lines().any(|l| l.split_whitespace().nth(1) == Some(name)))
}

/// The encoder for a kind of movie that this ffmpeg has.
pub fn encoder(kind: MovieKind, movie: &Path) -> Outcome<Encoder> {
    let (container, codecs, wanted): (_, _, Choices) = match kind {
        MovieKind::Mp4 => ("mp4", "H.264", &H264),
        MovieKind::Mov => ("mov", "H.264", &H264),
        MovieKind::Mkv => ("matroska", "H.264", &H264),
        MovieKind::Webm => ("webm", "VP9 or AV1", &WEBM),
        MovieKind::Gif => ("gif", "GIF", &GIF),
        MovieKind::Apng => return Err(Failure::new(Exit::Fault, "animated PNGs are not encoded by ffmpeg")),
    };
    if let Some((name, options)) = first_there(wanted, &list()) {
        return Ok(Encoder { container, name, options });
    }
    let names: Vec<&str> = wanted.iter().map(|(name, _)| *name).collect();
    let message = format!(
        "{}: this ffmpeg has no encoder for {codecs} ({}); {INSTALL} with it, or choose another ending",
        movie.display(),
        names.join(", ")
    );
    Err(Failure::new(Exit::Fault, message))
}

/// Encode images as a movie.
pub fn encode(images: &[PathBuf], format: Format, encoder: &Encoder, movie: &Path, frame_rate: f64) -> Outcome {
    let palette = match encoder.container {
        "gif" => Some(palette(images, format, frame_rate)?),
        _ => None,
    };
    // Colours are subsampled by two along both sides: an odd size gets one more row or column like the last.
    let size = [format.width, format.height].map(|n| if palette.is_none() { n.next_multiple_of(2) } else { n });
    let mut command = input(size, frame_rate);
    match &palette {
        Some(file) => {
            command.args(["-f", "rawvideo", "-pix_fmt", "rgba", "-video_size", "16x16", "-i"]).arg(file.path());
            command.args(["-lavfi", "paletteuse=dither=sierra2_4a"]);
        }
        None => {
            command.args(["-vf", COLORS]).args(TAGS);
        }
    }
    command.args(["-c:v", encoder.name]).args(encoder.options);
    if ["mp4", "mov"].contains(&encoder.container) {
        command.args(["-movflags", "+faststart"]);
    }
    command.args(["-f", encoder.container]);
    let mut part = Part::create(movie)?;
    part.goal(&mut command)?;
    let work = Work { task: "encoding", images, size, movie };
    work.run(command)?;
    part.publish(movie)
}

/// The palette of a GIF: the 256 colours that serve all images best, as a file of 16×16 raw pixels.
fn palette(images: &[PathBuf], format: Format, frame_rate: f64) -> Outcome<tempfile::NamedTempFile> {
    let fault = |e: std::io::Error| Failure::new(Exit::Fault, format!("the palette of the GIF: {e}"));
    let file = tempfile::NamedTempFile::new().map_err(fault)?;
    let size = [format.width, format.height];
    let mut command = input(size, frame_rate);
    command.args(["-vf", "palettegen=reserve_transparent=0", "-frames:v", "1", "-pix_fmt", "rgba", "-f", "rawvideo"]);
    command.arg(file.path()).stdout(Stdio::null());
    Work { task: "choosing colors", images, size, movie: file.path() }.run(command)?;
    Ok(file)
}

/// A call of ffmpeg that reads raw images of a size from its standard input.
fn input([width, height]: [u32; 2], frame_rate: f64) -> Command {
    let mut command = Command::new("ffmpeg");
    command.args(["-y", "-nostats", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24"]);
    command.args(["-video_size", &format!("{width}x{height}"), "-framerate", &frame_rate.to_string(), "-i", "-"]);
    command
}

/// One pass of ffmpeg over the images.
struct Work<'a> {
    task: &'a str,
    images: &'a [PathBuf],
    size: [u32; 2],
    movie: &'a Path,
}

impl Work<'_> {
    /// Call ffmpeg and give it the images, with progress shown.
    fn run(&self, mut command: Command) -> Outcome {
        let fault = |e: std::io::Error| Failure::new(Exit::Fault, format!("ffmpeg: {e}"));
        let progress = Progress::start(self.task, self.images.len() as u64, "images");
        let mut child = command.stdin(Stdio::piped()).stderr(Stdio::piped()).spawn().map_err(fault)?;
        // The command may hold the file that ffmpeg writes.
        drop(command);
        let errors = child.stderr.take().map(|mut pipe| {
            std::thread::spawn(move || {
                let mut text = Vec::new();
                let _ = pipe.read_to_end(&mut text);
                String::from_utf8_lossy(&text).to_string()
            })
        });
        let written = child.stdin.take().map_or(Ok(()), |pipe| self.write(pipe, &progress));
        if written.is_err() {
            let _ = child.kill();
        }
        let status = child.wait().map_err(fault)?;
        written?;
        if !status.success() {
            let errors = errors.and_then(|thread| thread.join().ok()).unwrap_or_default();
            return Err(self.failure(status, &errors));
        }
        progress.finish();
        Ok(())
    }

    /// Write the images into ffmpeg's input. That ffmpeg has ended early is no fault here: its exit status tells.
    fn write(&self, mut pipe: impl Write, progress: &Progress) -> Outcome {
        for (i, path) in self.images.iter().enumerate() {
            if pipe.write_all(&pixels::rgb(path, self.size)?).is_err() {
                break;
            }
            progress.at(i as u64 + 1);
        }
        Ok(())
    }

    fn failure(&self, status: std::process::ExitStatus, errors: &str) -> Failure {
        if errors.contains("No space left on device") {
            let message = format!("{}: cannot be written: the disk is full", self.movie.display());
            return Failure::new(Exit::Fault, message);
        }
        let lines: Vec<&str> = errors.lines().collect();
        let tail = lines[lines.len().saturating_sub(5)..].join("; ");
        Failure::new(Exit::Fault, format!("{}: ffmpeg failed ({status}): {tail}", self.movie.display()))
    }
}

/// The file that ffmpeg writes until the movie is whole. On Linux it has no name, so that nothing is left of it whatever ends the
/// program; ffmpeg gets it as its standard output, which it may open again.
struct Part {
    file: File,
    /// Its name, where it has one.
    named: Option<tempfile::TempPath>,
}

impl Part {
    /// Create the file in the movie's folder.
    fn create(movie: &Path) -> Outcome<Part> {
        let folder = movie.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let fault = |e: std::io::Error| Failure::from(Fault::unwritable(movie, &e));
        std::fs::create_dir_all(folder).map_err(fault)?;
        if cfg!(target_os = "linux") {
            return Ok(Part { file: tempfile::tempfile_in(folder).map_err(fault)?, named: None });
        }
        let (file, path) = tempfile::Builder::new().prefix(".part-").tempfile_in(folder).map_err(fault)?.into_parts();
        Ok(Part { file, named: Some(path) })
    }

    /// Make the file the goal of a call of ffmpeg.
    fn goal(&self, command: &mut Command) -> Outcome {
        match &self.named {
            Some(path) => command.arg(path).stdout(Stdio::null()),
            None => {
                let file = self.file.try_clone().map_err(|e| Failure::new(Exit::Fault, format!("ffmpeg: {e}")))?;
                command.arg("file:/dev/stdout").stdout(file)
            }
        };
        Ok(())
    }

    /// Write what the file holds as the movie.
    fn publish(&mut self, movie: &Path) -> Outcome {
        let mut bytes = Vec::new();
        // The file's place on the disk is given back first, so that a movie takes it once.
        let read = self.file.rewind().and_then(|()| self.file.read_to_end(&mut bytes));
        let read = read.and_then(|_| self.file.set_len(0));
        read.map_err(|e| Fault::unwritable(movie, &e))?;
        Ok(frame::atomic::write(movie, &bytes)?)
    }
}
