//! Runs of models: simulated, with their progress shown and their metadata written beside them.

use crate::arrivals::Arrivals;
use crate::geometry;
use crate::interrupt::{self, Listener};
use crate::job::{FramesJob, ModelRun, Origin};
use crate::ledger::Claims;
use crate::machine;
use crate::progress::Progress;
use crate::report::{Exit, Failure, Outcome};
use crate::source;
use bind::data::{Source, Store};
use bind::metadata::Data;
use bind::{Binding, Up};
use frame::run::{COMMANDS, RunReader, RunWriter, WarningEntry};
use frame::{Fault, Frame, list};
use sim::model_file::ModelFile;
use sim::run::{self, Observer, RunError};
use sim::watch::{Warning, WarningKind};
use sim::{FrictionLaw, Simulation, checkpoint};
use std::path::Path;

/// Simulate a model, and show the progress; whoever waits for its frames is told as they arrive.
pub fn simulate(job: ModelRun, onward: Onward, arrivals: Option<&Arrivals>) -> Outcome {
    let ModelRun { file, resolved, folder, span, computer } = job;
    let place = |e| failure(e, &folder, onward);
    computer.check(&file).map_err(place)?;
    for warning in &resolved.warnings {
        eprintln!("warning: {warning}");
    }
    if let Some(quality) = file.quality {
        eprintln!("quality {}: {}", quality.name(), chosen(&file));
    }
    let (duration, until) = (resolved.model.duration, span.until);
    if let Some(until) = until.filter(|until| *until > duration) {
        eprintln!("warning: --until {until} is after the end of the model: its `duration` is {duration} s");
    }
    let claims = Claims::open(&folder.join(".lock"));
    let Some(_claim) = claims.claim("simulation") else {
        let message = format!("{}: another process is simulating into it", folder.display());
        return Err(Failure::new(Exit::Usage, message));
    };
    for place in [folder.clone(), folder.join("frames"), folder.join("checkpoints")] {
        frame::atomic::sweep(&place);
    }
    say_what_is_there(&file, &folder, span.resume, onward)?;
    note_command(&folder, span.resume)?;
    let up = Up::against(resolved.model.gravity.to_array());
    // Until the first step there is nothing to keep but what is there: a signal ends the program at once.
    let has_checkpoint = span.resume && checkpoint::latest(&folder)?.is_some();
    interrupt::remark(match has_checkpoint {
        true => format!("no step is taken yet; {} has a checkpoint: {}", folder.display(), onward.way()),
        false => "no step is taken yet; the same command begins again".into(),
    });
    let mut console = Console { progress: None, interruption: None, up, arrivals };
    guard::memory::doing("simulating into", &folder);
    let done = machine::with_all_memory(|| run::simulate(&file, resolved, &folder, (&span, &computer), &mut console));
    done.map_err(place)
}

/// How a simulation goes on that was interrupted.
#[derive(Clone, Copy)]
pub enum Onward {
    /// By the command with `--resume`.
    Resume,
    /// By the same command.
    Again,
}

impl Onward {
    /// How, for a message.
    fn way(self) -> &'static str {
        match self {
            Onward::Resume => "continue with --resume",
            Onward::Again => "the same command goes on",
        }
    }
}

/// The error that ends a run into a folder, for the user.
fn failure(error: RunError, folder: &Path, onward: Onward) -> Failure {
    match error {
        RunError::Fault(fault) => fault.into(),
        RunError::Diverged(why) => Failure::new(Exit::Data, why),
        RunError::Unsupported(why) => {
            Failure::new(Exit::Usage, format!("--backend gpu: {why}\n  = --backend cpu simulates this model"))
        }
        RunError::Adapter(why) => Failure::new(Exit::Usage, format!("--adapter: {why}")),
        RunError::Device(why) => Failure::new(Exit::Fault, format!("--backend gpu: {why}")),
        RunError::NoDevice(why) => Failure::new(
            Exit::Usage,
            format!("{why}\n  = --backend gpu or auto takes an adapter; without it leave `gpu_from` out"),
        ),
        RunError::Interrupted(time) => {
            let way = onward.way();
            let message = format!("interrupted at {time:.6} s; {} has a checkpoint: {way}", folder.display());
            Failure::new(Exit::Interrupted, message)
        }
    }
}

/// The step and the solver of a model, for a message.
fn chosen(file: &ModelFile) -> String {
    let solver = &file.solver;
    let method = solver.method.map_or("the default method", |method| method.name());
    let iterations = solver.iterations.map_or("the default number of".into(), |n| format!("{n}"));
    let friction = if solver.friction == FrictionLaw::Exact { "exact" } else { "relaxed" };
    let (step, tolerance) = (file.step * 1e3, solver.tolerance);
    format!(
        "steps of {step:.4} ms, {method}, {friction} friction, {iterations} iterations, tolerance {tolerance:e} m/s"
    )
}

/// Note this command in a folder, behind those that it goes on from.
fn note_command(folder: &Path, resume: bool) -> Outcome {
    let path = folder.join(COMMANDS);
    let before = if resume { std::fs::read_to_string(&path).unwrap_or_default() } else { String::new() };
    let word = |word: std::ffi::OsString| guard::text::shell_word(&guard::text::line(&word.to_string_lossy()));
    let words = std::env::args_os().skip(1).map(word);
    let command: Vec<String> = std::iter::once("scree".to_string()).chain(words).collect();
    Ok(frame::atomic::write(&path, format!("{before}{}\n", command.join(" ")).as_bytes())?)
}

/// Say that a run of the same model is simulated again, or that there is none to resume.
fn say_what_is_there(file: &ModelFile, folder: &Path, resume: bool, onward: Onward) -> Outcome {
    let can_resume = checkpoint::latest(folder)?.is_some();
    if resume && !can_resume {
        eprintln!("note: {} has no checkpoint to resume from: the simulation begins at 0 s", folder.display());
    }
    let there = RunReader::open(folder).ok().filter(|run| run.index.model_hash == run::model_hash(file));
    if let Some(run) = there.filter(|run| !resume && !run.index.frames.is_empty()) {
        let (n, all) = (run.index.frames.len(), run.index.expected_frames);
        let way = match onward {
            Onward::Resume if can_resume => "; --resume goes on from its last checkpoint",
            Onward::Resume | Onward::Again => "",
        };
        eprintln!("note: {} held {n} of {all} frames of this model, which is simulated again{way}", folder.display());
    }
    Ok(())
}

/// Provide the frames of a job with their metadata: a model is simulated first.
pub fn provide(job: FramesJob) -> Outcome<(Binding, Source)> {
    let FramesJob { input, binding, origin, home } = job;
    let source = match origin {
        Origin::Data(source) => *source,
        Origin::Finished(run) => {
            eprintln!("simulation: {} holds the finished run of this model", home.display());
            warn_of_damaged(&run, &input);
            Store::Run(*run).into()
        }
        Origin::Model(model) => {
            simulate(*model, Onward::Again, None)?;
            Store::Run(RunReader::open(&home)?).into()
        }
    };
    match binding {
        Some(binding) => Ok((binding, source)),
        None => source::metadata_of_run(&home),
    }
}

/// Warn of frames of a finished run that cannot be drawn any more: it is not simulated again unasked.
fn warn_of_damaged(run: &RunReader, input: &Path) {
    let damaged = run.damaged();
    if damaged.is_empty() {
        return;
    }
    let [input, home] = [input, &run.folder].map(|path| guard::text::shell_word(&path.display().to_string()));
    eprintln!(
        "warning: {} of {home} {} lost or damaged: `scree run {input} -o {home} --fresh` simulates it again",
        list::describe(&damaged),
        if damaged.len() == 1 { "is" } else { "are" }
    );
}

/// Fail if a run has warnings: its data exists, but is not to be trusted.
pub fn check_warnings(folder: &Path) -> Outcome {
    let warnings = RunReader::open(folder)?.index.warnings;
    if warnings.is_empty() {
        return Ok(());
    }
    let count = |w: &WarningEntry| format!("{} in {} steps, first at {:.6} s", w.kind, w.steps, w.first_time);
    let counts: Vec<String> = warnings.iter().map(count).collect();
    let is_motor = |w: &WarningEntry| w.kind == WarningKind::Motor.name();
    let advice = match warnings.iter().all(is_motor) {
        true => "give the motor room, bound it by `max_torque` or `max_force`, or drive it by a torque or a force",
        false => "try a shorter step or more iterations",
    };
    let message = format!(
        "the run ended with warnings: {} (see {}); {advice}",
        counts.join("; "),
        folder.join("run.json").display()
    );
    Err(Failure::new(Exit::Partial, message))
}

/// Shows the progress of a run, and writes what rendering it needs: shapes as RIB archives and a metadata file.
struct Console<'a> {
    progress: Option<Progress>,
    /// From the first frame on.
    interruption: Option<Listener>,
    /// The axis that points up.
    up: Up,
    /// Who waits for frames.
    arrivals: Option<&'a Arrivals>,
}

impl Console<'_> {
    /// Listen to signals, which stop the run at a checkpoint from now on.
    fn listen(&mut self) {
        self.interruption.get_or_insert_with(|| {
            interrupt::remark(String::new());
            Listener::new()
        });
    }
}

impl Observer for Console<'_> {
    fn begin(&mut self, sim: &Simulation, first: &Frame, writer: &mut RunWriter) -> Result<(), Fault> {
        geometry::write_archives(&sim.model, writer.folder())?;
        write_metadata(std::slice::from_ref(first), self.up, writer).map(|_| ())
    }

    fn resume(&mut self, checkpoint: &Path, time: f64, there: u64, expected: u64) {
        eprintln!("resume: from {} at {time:.4} s, {there} of {expected} frames exist", checkpoint.display());
        if there > 0 {
            self.listen();
        }
        self.arrivals.iter().for_each(|arrivals| arrivals.written(there));
    }

    fn fall_back(&mut self, why: &str) {
        eprintln!("note: --backend auto: the processor simulates this model: {why}");
    }

    fn start(&mut self, expected: u64) {
        self.progress = Some(Progress::start("simulating", expected, "frames"));
    }

    fn frame(&mut self, done: u64) {
        self.listen();
        self.progress.iter().for_each(|p| p.at(done));
        self.arrivals.iter().for_each(|arrivals| arrivals.written(done));
    }

    fn warn(&mut self, warning: &Warning) {
        eprintln!("warning: {warning}; further warnings of this kind ({}) are counted", warning.kind.name());
    }

    fn note(&mut self, note: &Warning) {
        eprintln!("note: {note}");
    }

    /// Write the metadata again from frames of the whole run: bodies may have appeared, and moved out of the image.
    fn end(&mut self, writer: &mut RunWriter) -> Result<(), Fault> {
        self.progress.iter().for_each(Progress::finish);
        let run = RunReader::open(writer.folder())?;
        let n_rows = run.index.frames.last().map_or(0, |f| f.rows);
        let sample = bind::suggest::sample(&run.numbers(), n_rows);
        let frames = sample.into_iter().map(|f| run.read_frame(f)).collect::<Result<Vec<_>, Fault>>()?;
        if !write_metadata(&frames, self.up, writer)? {
            let path = writer.folder().join(METADATA);
            eprintln!("{} was edited and stays as it is; remove it to have one made of this run", path.display());
        }
        Ok(())
    }

    fn is_interrupted(&self) -> bool {
        self.interruption.as_ref().is_some_and(Listener::is_requested)
    }
}

const METADATA: &str = "metadata.yaml";

/// Write the metadata file of a run, with an object for every class, so that `scree render RUN` needs no other file. Returns false if
/// the user has edited the file there.
fn write_metadata(frames: &[Frame], up: Up, writer: &mut RunWriter) -> Result<bool, Fault> {
    let data = Data { run: Some(".".into()), ..Data::default() };
    match bind::suggest::metadata(data, frames, up) {
        Ok(suggestion) => writer.write_generated(METADATA, &suggestion.yaml),
        // Nothing to look at: a model of planes alone.
        Err(_) => Ok(true),
    }
}
