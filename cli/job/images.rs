//! Images to render of frames that exist: which frames, at which resolution, to which files.

use super::run_folder::spare_link;
use crate::args::{ImageArgs, QualityChoice};
use crate::arrivals::Arrivals;
use crate::batch::ImageChoices;
use crate::ledger::Ledger;
use crate::library;
use crate::report::{Exit, Failure, Outcome};
use crate::source;
use bind::binding::{Binding, ImageFormat, Quality};
use bind::data::Source;
use frame::Frame;
use frame::list::FrameList;
use frame::run::RunReader;
use render::ri::files::{Files, Permission, resolve};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

/// Choices of the command line for the images of a job.
#[derive(Clone, Debug, Default)]
pub struct ImageOptions {
    /// Frames; those of the metadata if not given.
    pub frames: Option<FrameList>,
    /// Width and height, pixels; those of the metadata if not given.
    pub resolution: Option<[u32; 2]>,
    /// Image quality; that of the metadata if not given.
    pub quality: Option<Quality>,
    /// Samples along each side of a pixel; those of the metadata if not given.
    pub samples: Option<u32>,
    /// Whether images that are up to date are rendered, too.
    pub redraw: bool,
    /// Programs that scenes may run.
    pub programs: Permission,
    /// How long they have for an answer.
    pub program_time: Option<Duration>,
    /// Whether displays of scenes may be written outside of the output folder.
    pub allow_outside: bool,
    /// The choices, as plans and ledgers keep them.
    pub choices: ImageChoices,
}

impl ImageOptions {
    /// Check the arguments: find the programs that are allowed. Images that are up to date are kept unless `redraw` is set.
    pub fn check(args: ImageArgs, redraw: bool) -> Outcome<ImageOptions> {
        let ImageArgs {
            frames,
            res,
            image_quality: quality,
            samples,
            allow_program,
            allow_programs,
            program_seconds,
            allow_outside,
        } = args;
        let quality = quality.map(Quality::from);
        let choices = ImageChoices {
            res,
            quality,
            samples,
            allow_program: allow_program.clone(),
            allow_programs,
            program_seconds,
            allow_outside,
        };
        let program_time = program_seconds.map(|s| Duration::from_secs(s.into()));
        let find = |name: &String| {
            let missing = || Failure::new(Exit::Usage, format!("--allow-program {name}: there is no such program"));
            resolve(name).ok_or_else(missing)
        };
        let programs = match (allow_programs, allow_program.is_empty()) {
            (true, _) => Permission::All,
            (false, true) => Permission::None,
            (false, false) => Permission::Named(allow_program.iter().map(find).collect::<Outcome<_>>()?),
        };
        Ok(ImageOptions {
            frames,
            resolution: res,
            quality,
            samples,
            redraw,
            programs,
            program_time,
            allow_outside,
            choices,
        })
    }
}

/// Images to render.
pub struct ImageJob {
    /// The metadata, with the choices of the command line.
    pub binding: Binding,
    /// The data.
    pub source: Source,
    /// The frames of the data that are still to come, while they are simulated.
    pub arrivals: Option<Arc<Arrivals>>,
    /// The search path of scenes and shaders.
    pub files: Files,
    /// The frames, in order.
    pub frames: Vec<u64>,
    /// Whether these are all frames that the data has.
    pub is_all: bool,
    /// Frames that an interrupted simulation did not reach, or that the data of a film has lost, of those that are asked for.
    pub lacking: Vec<u64>,
    /// The folder of the images.
    pub folder: PathBuf,
    /// Hash of the files that are built into the program.
    pub library: String,
    /// Whether images that are up to date are rendered, too.
    pub redraw: bool,
    /// Whether displays of scenes may be written outside of the folder.
    pub allow_outside: bool,
    /// Other images of the same frames, in folders of their own.
    pub passes: Vec<ImageJob>,
}

impl ImageJob {
    /// Resolve metadata, its data and the choices of the command line.
    pub fn resolve(binding: Binding, source: Source, folder: PathBuf, options: &ImageOptions) -> Outcome<ImageJob> {
        ImageJob::of_run(binding, (source, None), folder, options)
    }

    /// Resolve metadata, the data of a run whose later frames may still arrive, and the choices of the command line.
    pub fn of_run(
        mut binding: Binding,
        (source, arrivals): (Source, Option<Arc<Arrivals>>),
        folder: PathBuf,
        options: &ImageOptions,
    ) -> Outcome<ImageJob> {
        let output = &mut binding.output;
        if let Some(resolution) = options.resolution {
            output.resolution = resolution;
        }
        if let Some(quality) = options.quality {
            output.set_quality(quality);
        }
        if let Some(n) = options.samples {
            output.samples = [n; 2];
        }
        guard::allow(&folder);
        if !options.allow_outside {
            spare_link(&Ledger::of(&folder).folder(), &folder)?;
        }
        let existing = source.numbers();
        let frames = frames(&binding, &if arrivals.is_some() { source.expected() } else { existing.clone() }, options)?;
        let (programs, program_time) = (options.programs.clone(), options.program_time);
        let files = Files { programs, program_time, ..library::files(&binding.folder()) };
        let files = binding.files(files);
        binding.check_columns(&first_readable(&source, if arrivals.is_some() { &existing } else { &frames })?)?;
        source::check_library(&binding)?;
        let passes = std::mem::take(&mut binding.passes).into_iter().map(|(name, pass)| {
            let own = folder.join(name);
            if !options.allow_outside {
                spare_link(&own, &folder)?;
            }
            ImageJob::of_run(pass, (source.clone(), arrivals.clone()), own, options)
        });
        let passes = passes.collect::<Outcome<_>>()?;
        let lacking = if arrivals.is_some() { vec![] } else { lacking(&binding, &source, options) };
        let is_all = options.frames.is_none() && binding.output.frames.is_none();
        let (library, redraw, allow_outside) = (library::hash(&files), options.redraw, options.allow_outside);
        Ok(ImageJob {
            binding,
            source,
            arrivals,
            files,
            frames,
            is_all,
            lacking,
            folder,
            library,
            redraw,
            allow_outside,
            passes,
        })
    }

    /// Take the frames of a run that has come to its end: none are still to arrive.
    pub fn complete(&mut self, run: &RunReader) {
        (self.source, self.arrivals) = (self.source.grown(run.clone()), None);
        self.passes.iter_mut().for_each(|pass| pass.complete(run));
    }

    /// The files of all images, in the order of the frames, whatever the order in which they are drawn.
    pub fn images(&self) -> Vec<PathBuf> {
        let mut frames = self.frames.clone();
        frames.sort_unstable();
        frames.into_iter().map(|frame| self.image(frame)).collect()
    }

    /// The file of a frame's image.
    pub fn image(&self, frame: u64) -> PathBuf {
        let ending = match self.binding.output.format {
            ImageFormat::Png => "png",
            ImageFormat::Exr => "exr",
        };
        self.folder.join(format!("{frame:06}.{ending}"))
    }
}

/// The table of the first frame that can be read and has rows, of the first some; one without rows if there is no other, and if none
/// can be read, why the first cannot.
fn first_readable(source: &Source, frames: &[u64]) -> Outcome<Frame> {
    /// Frames that are looked at.
    const SOME: usize = 100;
    let (mut empty, mut fault) = (None, None);
    for frame in frames.iter().take(SOME) {
        match source.read(*frame) {
            Ok(table) if table.rows() > 0 => return Ok(table),
            Ok(table) => drop(empty.get_or_insert(table)),
            Err(first) => drop(fault.get_or_insert((*frame, first))),
        }
    }
    match (empty, fault) {
        (Some(table), _) => Ok(table),
        (None, Some((_, fault))) if frames.len() == 1 => Err(fault.into()),
        (None, Some((frame, fault))) => {
            let n = frames.len();
            let none = if n > SOME { format!("none of the first {SOME} of {n}") } else { format!("none of the {n}") };
            Err(Failure { message: format!("{none} frames can be read; frame {frame}: {fault}"), ..fault.into() })
        }
        (None, None) => Err(Failure::new(Exit::Data, "the data has no frames yet")),
    }
}

/// The frames of a run that are not there yet, of those that the command line selects, or the metadata.
fn lacking(binding: &Binding, source: &Source, options: &ImageOptions) -> Vec<u64> {
    let missing = source.missing();
    let of_file = || binding.output.frames.as_ref().and_then(|list| list.parse::<FrameList>().ok());
    match options.frames.clone().or_else(of_file) {
        Some(list) => list.select(&missing).unwrap_or_default(),
        None => missing,
    }
}

/// The frames that the command line selects of those that exist, or the metadata, or all.
pub fn frames(binding: &Binding, existing: &[u64], options: &ImageOptions) -> Outcome<Vec<u64>> {
    if existing.is_empty() {
        return Err(Failure::new(Exit::Data, "the data has no frames yet"));
    }
    match (&options.frames, &binding.output.frames) {
        (Some(list), _) => list.select(existing).map_err(|m| Failure::new(Exit::Usage, format!("--frames: {m}"))),
        (None, Some(list)) => {
            let selected = list.parse::<FrameList>().and_then(|list| list.select(existing));
            Ok(selected.map_err(|m| binding.doc.fault("output.frames", m))?)
        }
        (None, None) => Ok(existing.to_vec()),
    }
}

impl From<QualityChoice> for Quality {
    fn from(choice: QualityChoice) -> Quality {
        match choice {
            QualityChoice::Draft => Quality::Draft,
            QualityChoice::Normal => Quality::Normal,
            QualityChoice::Final => Quality::Final,
        }
    }
}

impl From<Quality> for QualityChoice {
    fn from(quality: Quality) -> QualityChoice {
        match quality {
            Quality::Draft => QualityChoice::Draft,
            Quality::Normal => QualityChoice::Normal,
            Quality::Final => QualityChoice::Final,
        }
    }
}
