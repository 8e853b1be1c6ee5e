//! Runs of models: simulated, with their progress shown and their metadata written beside them.

use crate::geometry;
use crate::job::{FramesJob, ModelRun, Origin};
use crate::progress::Progress;
use crate::report::{Exit, Failure, Outcome};
use crate::source;
use bind::Binding;
use bind::data::{Source, Store};
use bind::metadata::Data;
use frame::run::{RunReader, RunWriter, WarningEntry};
use frame::{Fault, Frame};
use sim::Simulation;
use sim::run::{self, Observer, RunError};
use sim::watch::Warning;
use std::path::Path;

/// Simulate a model, and show the progress.
pub fn simulate(job: ModelRun) -> Outcome {
    let ModelRun { file, resolved, folder, span } = job;
    for warning in &resolved.warnings {
        eprintln!("warning: {warning}");
    }
    run::simulate(&file, resolved, &folder, &span, &mut Console::default()).map_err(|e| match e {
        RunError::Fault(fault) => fault.into(),
        RunError::Diverged(why) => Failure::new(Exit::Data, why),
    })
}

/// Provide the frames of a job with their metadata: a model is simulated first.
pub fn provide(job: FramesJob) -> Outcome<(Binding, Source)> {
    let FramesJob { binding, origin, home } = job;
    let of_run = || Outcome::Ok(Store::Run(RunReader::open(&home)?).into());
    let source = match origin {
        Origin::Data(source) => *source,
        Origin::Finished => {
            eprintln!("simulation: {} holds the finished run of this model", home.display());
            of_run()?
        }
        Origin::Model(model) => {
            simulate(*model)?;
            of_run()?
        }
    };
    let binding = match binding {
        Some(binding) => binding,
        None => source::metadata_of_run(&home)?.0,
    };
    Ok((binding, source))
}

/// Fail if a run has warnings: its data exists, but is not to be trusted.
pub fn check_warnings(folder: &Path) -> Outcome {
    let warnings = RunReader::open(folder)?.index.warnings;
    if warnings.is_empty() {
        return Ok(());
    }
    let count = |w: &WarningEntry| format!("{} in {} steps, first at {:.6} s", w.kind, w.steps, w.first_time);
    let counts: Vec<String> = warnings.iter().map(count).collect();
    let message = format!(
        "the run ended with warnings: {} (see {}); try a shorter step or more iterations",
        counts.join("; "),
        folder.join("run.json").display()
    );
    Err(Failure::new(Exit::Partial, message))
}

/// Shows the progress of a run, and writes what rendering it needs: shapes as RIB archives and a metadata file.
#[derive(Default)]
struct Console {
    progress: Option<Progress>,
}

impl Observer for Console {
    fn begin(&mut self, sim: &Simulation, first: &Frame, writer: &RunWriter) -> Result<(), Fault> {
        geometry::write_archives(&sim.model, writer.folder())?;
        metadata_for(&[first]).iter().try_for_each(|text| writer.write_file(METADATA, text))
    }

    fn resume(&mut self, checkpoint: &Path, time: f64, there: u64, expected: u64) {
        eprintln!("resume: from {} at {time:.4} s, {there} of {expected} frames exist", checkpoint.display());
    }

    fn start(&mut self, expected: u64) {
        self.progress = Some(Progress::start("simulating", expected, "frames"));
    }

    fn frame(&mut self, done: u64) {
        self.progress.iter().for_each(|p| p.at(done));
    }

    fn warn(&mut self, warning: &Warning) {
        eprintln!("warning: {warning}; further warnings of this kind ({}) are counted", warning.kind.name());
    }

    /// Write the metadata again from the first and the last frame: bodies may have appeared, and moved out of the image. A file that
    /// the user has changed meanwhile stays.
    fn end(&mut self, first: &Frame, last: &Frame, writer: &RunWriter) -> Result<(), Fault> {
        self.progress.iter().for_each(Progress::finish);
        let unchanged = std::fs::read_to_string(writer.folder().join(METADATA)).ok() == metadata_for(&[first]);
        let text = metadata_for(&[first, last]).filter(|_| unchanged);
        text.iter().try_for_each(|text| writer.write_file(METADATA, text))
    }
}

const METADATA: &str = "metadata.yaml";

/// The metadata file of a run, with an object for every class, so that `scree render RUN` needs no other file.
fn metadata_for(frames: &[&Frame]) -> Option<String> {
    let data = Data { run: Some(".".into()), ..Data::default() };
    let metadata = bind::suggest::metadata(data, frames).ok()?;
    Some(bind::suggest::to_yaml(&metadata, frames[0]))
}
