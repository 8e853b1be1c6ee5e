//! Arguments of the commands that make images and movies: `render`, `movie`, `rib` and `stitch`.

use super::value::{Backend, Resolution, ShardArg, frame_rate, index, resolution, shard, size, whole};
use clap::{Args, ValueEnum};
use frame::list::FrameList;
use std::path::PathBuf;

/// Arguments of every command that renders frames.
#[derive(Args, Debug)]
pub struct ImageArgs {
    /// Frames to render, joined by commas: 3, 0-99, 0-99x5 (every fifth),
    /// 120x5 (every fifth from 120 on) [default: as the metadata says, or all].
    #[arg(short, long, value_name = "LIST")]
    pub frames: Option<FrameList>,
    /// Width and height, pixels, as 1280x720 [default: as the metadata says].
    #[arg(long, value_name = "WxH", value_parser = resolution)]
    pub res: Option<Resolution>,
    /// Image quality: samples, shading rate and light
    /// [default: as the metadata says, or normal].
    #[arg(long, value_name = "QUALITY", value_enum)]
    pub image_quality: Option<QualityChoice>,
    /// Samples along each side of a pixel, 1 to 64; 4 makes 16 per pixel
    /// [default: as the metadata says].
    #[arg(long, value_name = "N", value_parser = whole::<u32>(1..=64))]
    pub samples: Option<u32>,
    /// Run this program where a scene asks for it (RunProgram); may be given
    /// several times [default: none runs].
    #[arg(long, value_name = "FILE")]
    pub allow_program: Vec<String>,
    /// Write displays of a scene outside of the output folder where they are
    /// named so, by an absolute name or `..`.
    #[arg(long)]
    pub allow_outside: bool,
    /// Run every program that a scene asks for.
    #[arg(long, conflicts_with = "allow_program")]
    pub allow_programs: bool,
    /// Seconds that such a program has for an answer [default: 60].
    #[arg(long, value_name = "SECONDS", value_parser = whole::<u32>(1..=86_400))]
    pub program_seconds: Option<u32>,
}

/// Image quality, as it is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum QualityChoice {
    /// Quick, to see where everything is.
    Draft,
    /// For films.
    Normal,
    /// For print.
    Final,
}

/// Which images are drawn again.
#[derive(Args, Debug)]
pub struct RedrawArgs {
    /// Render images that are up to date again, too.
    #[arg(long)]
    pub redraw: bool,
    /// The default, which once was not: images that are up to date are kept.
    #[arg(long, hide = true, conflicts_with = "redraw")]
    pub missing: bool,
}

const RENDER_EXAMPLES: &str = "\
Examples:
  scree render runs/pour -f 0-99x5
  scree render p.yaml --res 640x360 --samples 2 -o images
  scree render scene.rib -o images
  scree render scene.rib -o images --bucket 2/8";

/// Arguments of `scree render`.
#[derive(Args, Debug)]
#[command(after_help = RENDER_EXAMPLES)]
pub struct RenderArgs {
    /// Run directory, metadata file (.yaml) or RIB scene (.rib, .rib.gz, .ribz;
    /// - reads a scene from standard input).
    #[arg(value_name = "INPUT")]
    pub input: PathBuf,
    /// Folder of the images [default: images/ in the run directory;
    /// runs/NAME/images for NAME.yaml; the working folder for a RIB scene].
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub image: ImageArgs,
    #[command(flatten)]
    pub redraw: RedrawArgs,
    /// Render only the buckets of shard I of N into a shard file, as 2/8 for
    /// the second of eight; `scree stitch` joins the shards.
    #[arg(long, value_name = "I/N", value_parser = shard)]
    pub bucket: Option<ShardArg>,
    /// Back end to draw with; auto takes the first adapter that is no software
    /// adapter, if there is one. What an adapter cannot draw, the processor does.
    #[arg(long, default_value = "auto")]
    pub backend: Backend,
    /// Graphics adapter of --backend gpu, by its index in `scree doctor` or by a
    /// part of its name [default: the first that is no software adapter].
    #[arg(long, value_name = "TEXT")]
    pub adapter: Option<String>,
    /// The most memory that images take of the graphics adapter, as 2GiB, at least
    /// 64MiB; an image that does not fit is drawn by the processor [default: what
    /// they need].
    #[arg(long, value_name = "SIZE", value_parser = size)]
    pub gpu_memory: Option<u64>,
    /// Print render statistics of every image: primitives, micropolygons,
    /// samples, seconds, memory.
    #[arg(short, long)]
    pub verbose: bool,
    /// Write the render statistics of every image beside it, as
    /// 000012.png.stats.json.
    #[arg(long)]
    pub stats: bool,
}

const MOVIE_EXAMPLES: &str = "\
The file's ending chooses the kind of movie: .mp4, .mov and .mkv (H.264), .webm
(VP9), .gif, .apng and .png (animated PNG). All but animated PNGs need ffmpeg.

Examples:
  scree movie runs/pour/images
  scree movie runs/pour/images -o pour.webm --frame-rate 30";

/// Arguments of `scree movie`.
#[derive(Args, Debug)]
#[command(after_help = MOVIE_EXAMPLES)]
pub struct MovieArgs {
    /// Folder of images (PNG); the last number in a file's name is its frame.
    #[arg(value_name = "DIR")]
    pub images: PathBuf,
    /// Movie file; without an ending it becomes .mp4, or .apng without ffmpeg
    /// [default: runs/a/a.mp4 for runs/a/images, else DIR.mp4].
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Frames per second, above 0 and at most 1000; of a GIF, at most 50.
    #[arg(long, default_value = "24", value_name = "FPS", value_parser = frame_rate, allow_negative_numbers = true)]
    pub frame_rate: f64,
    /// Encode the images that are there, each as one frame of the movie, even
    /// if some between them are missing.
    #[arg(long)]
    pub keep_gaps: bool,
}

const RIB_EXAMPLES: &str = "\
Example:
  scree rib runs/pour -f 24 -o pour_24.rib";

/// Arguments of `scree rib`.
#[derive(Args, Debug)]
#[command(after_help = RIB_EXAMPLES)]
pub struct RibArgs {
    /// Run directory or metadata file (YAML).
    #[arg(value_name = "INPUT")]
    pub input: PathBuf,
    /// Frame to print.
    #[arg(short, long, value_name = "FRAME", value_parser = index::<u64>())]
    pub frame: u64,
    /// File to write [default: standard output].
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
}

const STITCH_EXAMPLES: &str = "\
Example, for two tasks:
  scree render scene.rib -o parts --bucket 1/2
  scree render scene.rib -o parts --bucket 2/2
  scree stitch parts";

/// Arguments of `scree stitch`.
#[derive(Args, Debug)]
#[command(after_help = STITCH_EXAMPLES)]
pub struct StitchArgs {
    /// Folder of the shard files; the images are written there too.
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// Keep the shard files.
    #[arg(long)]
    pub keep: bool,
}
