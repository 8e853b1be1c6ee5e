//! `scree simulate`: a model → a run directory, from the start or from its last checkpoint.

use crate::args::{Backend, SimulateArgs};
use crate::progress::Progress;
use crate::report::{Exit, Failure, Outcome};
use crate::{geometry, job, sweep};
use bind::metadata::Data;
use frame::run::{FrameFormat, RunReader, RunWriter, WarningEntry};
use frame::{Fault, Frame};
use sim::Simulation;
use sim::model_file::{self, ModelFile, Resolved};
use sim::run::{self, Observer, RunError, Span};
use sim::watch::Warning;
use std::path::Path;

/// The command.
pub fn command(args: &SimulateArgs) -> Outcome {
    if args.backend == Backend::Gpu {
        return Err(Failure::new(
            Exit::Usage,
            "--backend gpu: the simulation has no GPU back end yet; use cpu or auto",
        ));
    }
    if let Some(until) = args.until
        && !(until > 0.0 && until.is_finite())
    {
        return Err(Failure::new(Exit::Usage, format!("--until {until}: expected a time above 0")));
    }
    let (mut file, doc) = model_file::load(&args.model, &args.set)?;
    if args.csv {
        file.format = FrameFormat::Csv;
    }
    let folder = args.output.clone().unwrap_or_else(|| job::default_output(&args.model));
    if !file.sweep.is_empty() {
        return sweep::command(args, &file, &folder);
    }
    if args.plan || args.sweep_index.is_some() {
        return Err(Failure::new(Exit::Usage, "--plan and --sweep-index are for models with a `sweep`"));
    }
    let resolved = file.resolve(&doc)?;
    simulate(&file, resolved, &folder, &Span { until: args.until, resume: args.resume })?;
    println!("{}", folder.display());
    warned(&folder)
}

/// Run the model into `folder`, and show how it goes.
pub fn simulate(file: &ModelFile, resolved: Resolved, folder: &Path, span: &Span) -> Outcome {
    for warning in &resolved.warnings {
        eprintln!("warning: {warning}");
    }
    run::simulate(file, resolved, folder, span, &mut Screen::default()).map_err(|e| match e {
        RunError::Fault(fault) => fault.into(),
        RunError::Diverged(why) => Failure::new(Exit::Data, why),
    })
}

/// Whether the run in a folder went wrong on its way: its numbers are there, and not to be trusted.
pub fn warned(folder: &Path) -> Outcome {
    let warnings = RunReader::open(folder)?.index.warnings;
    if warnings.is_empty() {
        return Ok(());
    }
    let count = |w: &WarningEntry| format!("{} in {} steps, first at {:.6} s", w.kind, w.steps, w.first_time);
    let counts: Vec<String> = warnings.iter().map(count).collect();
    let message = format!(
        "the run came to its end with warnings: {} (see {}); try a shorter step or more iterations",
        counts.join("; "),
        folder.join("run.json").display()
    );
    Err(Failure::new(Exit::Partial, message))
}

/// Shows a run's progress, and writes what pictures of it need: shapes as RIB archives and a metadata file.
#[derive(Default)]
struct Screen {
    progress: Option<Progress>,
}

impl Observer for Screen {
    fn begin(&mut self, sim: &Simulation, first: &Frame, writer: &RunWriter) -> Result<(), Fault> {
        geometry::write_archives(&sim.model, writer.folder())?;
        metadata_for(&[first]).iter().try_for_each(|text| writer.write_file(METADATA, text))
    }

    fn resume(&mut self, checkpoint: &Path, time: f64, there: u64, expected: u64) {
        eprintln!("resume: from {} at {time:.4} s, {there} of {expected} frames are there", checkpoint.display());
    }

    fn start(&mut self, expected: u64) {
        self.progress = Some(Progress::start("simulating", expected));
    }

    fn frame(&mut self, done: u64) {
        self.progress.iter().for_each(|p| p.at(done));
    }

    fn warn(&mut self, warning: &Warning) {
        eprintln!("warning: {warning}; more of this kind ({}) are counted", warning.kind.name());
    }

    /// Look again at what there is to draw: bodies may have appeared, and moved out of the image. A file that somebody has changed
    /// meanwhile stays.
    fn end(&mut self, first: &Frame, last: &Frame, writer: &RunWriter) -> Result<(), Fault> {
        self.progress.iter().for_each(Progress::finish);
        let ours = std::fs::read_to_string(writer.folder().join(METADATA)).ok() == metadata_for(&[first]);
        let text = metadata_for(&[first, last]).filter(|_| ours);
        text.iter().try_for_each(|text| writer.write_file(METADATA, text))
    }
}

const METADATA: &str = "metadata.yaml";

/// What to draw for every class, beside the run, so that `scree render RUN` just works.
fn metadata_for(frames: &[&Frame]) -> Option<String> {
    let data = Data { run: Some(".".into()), ..Data::default() };
    let metadata = bind::suggest::metadata(data, frames).ok()?;
    Some(bind::suggest::to_yaml(&metadata, frames[0]))
}
