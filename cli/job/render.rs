//! The job of `scree render`.

use super::frames::FramesJob;
use super::images::ImageOptions;
use super::run_folder::spare_link;
use super::simulate::adapter_alone;
use crate::args::{Backend, RenderArgs, ShardArg};
use crate::library;
use crate::report::{Exit, Failure, Outcome};
use crate::source;
use frame::FaultKind;
use render::film::bucket::Shard;
use render::ri::files::Files;
use std::path::{Path, PathBuf};

/// What to render.
pub enum RenderJob {
    /// A RIB scene.
    Scene(Box<RenderScene>),
    /// Frames of data.
    Frames(Box<RenderFrames>),
}

/// A RIB scene to render.
pub struct RenderScene {
    /// The scene's file.
    pub path: PathBuf,
    /// Its text.
    pub rib: Vec<u8>,
    /// The search path of scenes and shaders.
    pub files: Files,
    /// The folder that the names of its displays start from.
    pub folder: PathBuf,
    /// Whether displays may be written outside of it.
    pub allow_outside: bool,
    /// The shard to render; whole images if not given.
    pub shard: Option<Shard>,
    /// The statistics wanted.
    pub statistics: Statistics,
    /// What draws.
    pub on: DrawOn,
    /// The most memory that is taken of a graphics adapter, bytes, if there is a limit.
    pub gpu_memory: Option<u64>,
}

/// Frames to render.
pub struct RenderFrames {
    /// The frames.
    pub frames: FramesJob,
    /// The folder of the images.
    pub folder: PathBuf,
    /// Choices of the command line.
    pub options: ImageOptions,
    /// The shard to render; whole images if not given.
    pub shard: Option<Shard>,
    /// The statistics wanted.
    pub statistics: Statistics,
    /// What draws.
    pub on: DrawOn,
    /// The most memory that is taken of a graphics adapter, bytes, if there is a limit.
    pub gpu_memory: Option<u64>,
}

/// What draws images.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum DrawOn {
    /// The processor.
    #[default]
    Cpu,
    /// The first hardware adapter, if there is one and it can; else the processor.
    Auto,
    /// A graphics adapter, and the processor what it cannot.
    Gpu(gpu::Choice),
}

impl DrawOn {
    /// Check a back end, and the adapter that is chosen, if one is.
    pub fn check(backend: Backend, adapter: Option<String>) -> Outcome<DrawOn> {
        match (backend, adapter) {
            (Backend::Gpu, adapter) => Ok(DrawOn::Gpu(adapter.map_or(gpu::Choice::Hardware, gpu::Choice::Named))),
            (Backend::Auto, None) => Ok(DrawOn::Auto),
            (Backend::Cpu, None) => Ok(DrawOn::Cpu),
            (Backend::Auto | Backend::Cpu, Some(_)) => Err(adapter_alone()),
        }
    }

    /// Check a limit on the memory of an adapter, if one is given.
    pub fn memory(&self, bytes: Option<u64>) -> Outcome<Option<u64>> {
        if bytes.is_some() && *self == DrawOn::Cpu {
            let message = "--gpu-memory limits the memory of a graphics adapter: give --backend gpu or auto with it";
            return Err(Failure::new(Exit::Usage, message));
        }
        Ok(bytes)
    }
}

/// Where the render statistics of every image go.
#[derive(Clone, Copy, Default)]
pub struct Statistics {
    /// Whether they are printed.
    pub print: bool,
    /// Whether they are written beside the image.
    pub write: bool,
}

impl RenderJob {
    /// Check the arguments.
    pub fn check(args: RenderArgs) -> Outcome<RenderJob> {
        if source::is_scene(&args.input) {
            return Ok(RenderJob::Scene(Box::new(scene(args)?)));
        }
        let frames = FramesJob::open(&args.input)?;
        let statistics = Statistics { print: args.verbose, write: args.stats };
        let folder = match args.output {
            Some(folder) => folder,
            None => {
                let folder = frames.home.join("images");
                if !args.image.allow_outside {
                    spare_link(&folder, &frames.home)?;
                }
                folder
            }
        };
        let shard = args.bucket.map(Shard::from);
        let on = DrawOn::check(args.backend, args.adapter)?;
        let gpu_memory = on.memory(args.gpu_memory)?;
        let options = ImageOptions::check(args.image, args.redraw.redraw)?;
        Ok(RenderJob::Frames(Box::new(RenderFrames { frames, folder, options, shard, statistics, on, gpu_memory })))
    }
}

fn scene(args: RenderArgs) -> Outcome<RenderScene> {
    if args.image.frames.is_some() || args.redraw.missing || args.redraw.redraw {
        let message = "--frames, --missing and --redraw are for data: a RIB scene has no frames to choose from, and is always drawn";
        return Err(Failure::new(Exit::Usage, message));
    }
    if args.image.res.is_some() || args.image.samples.is_some() || args.image.image_quality.is_some() {
        let message = "--res, --image-quality and --samples are for data: a RIB scene has its own Format, ShadingRate and PixelSamples";
        return Err(Failure::new(Exit::Usage, message));
    }
    let on = DrawOn::check(args.backend, args.adapter)?;
    let gpu_memory = on.memory(args.gpu_memory)?;
    let rib = frame::read_bytes(FaultKind::Input, &args.input)?;
    let ImageOptions { programs, program_time, allow_outside, .. } = ImageOptions::check(args.image, true)?;
    let files = Files { programs, program_time, ..library::files(args.input.parent().unwrap_or(Path::new("."))) };
    let statistics = Statistics { print: args.verbose, write: args.stats };
    let folder = args.output.unwrap_or_else(|| PathBuf::from("."));
    Ok(RenderScene {
        path: args.input,
        rib,
        files,
        folder,
        allow_outside,
        shard: args.bucket.map(Shard::from),
        statistics,
        on,
        gpu_memory,
    })
}

impl From<ShardArg> for Shard {
    fn from(shard: ShardArg) -> Shard {
        Shard { part: shard.index, parts: shard.n_shards }
    }
}
