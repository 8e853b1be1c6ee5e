//! The driver of a run: from a resolved model to a run directory, from the start or from the last checkpoint.
//!
//! It takes steps and writes frames, probes, the report and checkpoints when they are due. Series are appended to; other files are
//! written whole. Messages, and files beside the run's own, are the [`Observer`]'s.

use crate::gpu;
use crate::model_file::{ModelFile, OnDivergence, Resolved};
use crate::stages::Stage;
use crate::watch::{Broken, Warning, WarningCount};
use crate::{
    Model, Simulation, State, StepFault, checkpoint, contacts_of, frame_of, probe_header, report_header, report_line,
};
use ::gpu::{Choice, Device, GpuError};
use frame::run::{EndKind, Ended, FORMAT_VERSION, Index, RunReader, RunWriter, WarningEntry};
use frame::series::Series;
use frame::{Fault, FaultKind, Frame, atomic, csv};
use std::path::Path;

/// The part of a run to simulate.
#[derive(Clone, Copy, Debug, Default)]
pub struct Span {
    /// Time to stop at, s; the model's duration if not given, and at most that.
    pub until: Option<f64>,
    /// Whether to resume from the last checkpoint; a run without a checkpoint starts from time 0.
    pub resume: bool,
}

impl Span {
    /// Time at which a run of a model ends, s.
    pub fn end(&self, model: &Model) -> f64 {
        self.until.unwrap_or(model.duration).min(model.duration)
    }
}

/// The observer of a run: callbacks at the events of the run.
pub trait Observer {
    /// A new run begins: its first frame is about to be written. Other files of the run directory may be written now.
    ///
    /// # Errors
    /// A fault ends the run.
    fn begin(&mut self, _sim: &Simulation, _first: &Frame, _writer: &mut RunWriter) -> Result<(), Fault> {
        Ok(())
    }
    /// The run resumes from a checkpoint at `time`, s; `written` of `expected` frames exist already.
    fn resume(&mut self, _checkpoint: &Path, _time: f64, _written: u64, _expected: u64) {}
    /// The processor simulates a model that is large enough for a graphics adapter, or has `gpu_from`; `why` says what speaks against one.
    fn fall_back(&mut self, _why: &str) {}
    /// The first step is about to be taken; the run has `expected` frames in total.
    fn start(&mut self, _expected: u64) {}
    /// A frame has been written; `written` frames exist.
    fn frame(&mut self, _written: u64) {}
    /// A step has the first warning of a kind in this run.
    fn warn(&mut self, _warning: &Warning) {}
    /// A step has what is to be known of it and is no fault.
    fn note(&mut self, _note: &Warning) {}
    /// The run is complete: all its frames are written.
    ///
    /// # Errors
    /// A fault ends the run.
    fn end(&mut self, _writer: &mut RunWriter) -> Result<(), Fault> {
        Ok(())
    }
    /// Whether the run is to stop after the current step, with a checkpoint.
    fn is_interrupted(&self) -> bool {
        false
    }
}

/// The error that ends a run early.
#[derive(Debug)]
pub enum RunError {
    /// A file cannot be read or written, or a checkpoint belongs to another model.
    Fault(Fault),
    /// The simulation diverged; the message for the user.
    Diverged(String),
    /// The observer stopped the run at a time, s. A checkpoint has been written.
    Interrupted(f64),
    /// The model needs what no kernel of graphics devices is built for; the message for the user.
    Unsupported(String),
    /// The name or index of an adapter stands for none; the message for the user.
    Adapter(String),
    /// The graphics device failed; the message for the user.
    Device(String),
    /// Stages are to run on a graphics adapter, and none is to be used; the message for the user.
    NoDevice(String),
}

impl From<gpu::Fault> for RunError {
    fn from(fault: gpu::Fault) -> RunError {
        match fault {
            gpu::Fault::Gpu(error @ GpuError::Choice { .. }) => RunError::Adapter(error.to_string()),
            gpu::Fault::Gpu(error) => RunError::Device(error.to_string()),
            other => RunError::Unsupported(other.to_string()),
        }
    }
}

impl From<StepFault> for RunError {
    fn from(fault: StepFault) -> RunError {
        match fault {
            StepFault::Device(fault) => fault.into(),
            StepFault::Columns(why) => panic!("{why}"),
        }
    }
}

/// What computes the steps of a run.
#[derive(Clone, Debug, Default)]
pub enum Computer {
    /// The processor.
    #[default]
    Cpu,
    /// A graphics adapter.
    Gpu(Choice),
    /// The first hardware adapter, if the model is large enough to gain from it and can be simulated there; else the processor.
    Auto,
}

/// The least number of bodies that move for which [`Computer::Auto`] takes a graphics adapter. It is an estimate, on the side of the
/// processor: a step of 50 iterations has some 180 dispatches, each of several microseconds whatever the number of bodies, in which time
/// dozens of processor cores step about as many spheres.
pub const LEAST_FOR_GPU: usize = 20_000;

impl Computer {
    /// Check that stages of a model's step that are to run on a graphics adapter can do so.
    ///
    /// # Errors
    /// [`RunError::NoDevice`] for the processor.
    pub fn check(&self, file: &ModelFile) -> Result<(), RunError> {
        match (self, file.gpu_from) {
            (Computer::Cpu, Some(stage)) => Err(RunError::NoDevice(format!(
                "`gpu_from: {}` has a graphics adapter run the stages from there on, and this is a simulation by the processor alone",
                stage.name()
            ))),
            _ => Ok(()),
        }
    }

    /// A simulation of a model from a state, whose stages from `gpu_from` on, or all, run on a graphics adapter, if any does.
    fn begin(
        &self,
        gpu_from: Option<Stage>,
        (model, state): (Model, State),
        observer: &mut dyn Observer,
    ) -> Result<Simulation, RunError> {
        let open = |choice| Device::open(choice).map_err(gpu::Fault::Gpu);
        let is_large = || model.inv_mass.iter().filter(|inv_mass| **inv_mass > 0.0).count() >= LEAST_FOR_GPU;
        let from = gpu_from.unwrap_or(Stage::Bounds);
        match self {
            Computer::Gpu(choice) => Ok(Simulation::on_device_from(from, model, state, open(choice)?)?),
            Computer::Auto if gpu_from.is_some() || is_large() => {
                let begun = open(&Choice::Hardware)
                    .and_then(|device| Simulation::on_device_from(from, model.clone(), state.clone(), device));
                Ok(begun.unwrap_or_else(|fault| {
                    observer.fall_back(&fault.to_string());
                    Simulation::new(model, state)
                }))
            }
            Computer::Cpu | Computer::Auto => Ok(Simulation::new(model, state)),
        }
    }
}

impl From<Fault> for RunError {
    fn from(fault: Fault) -> RunError {
        RunError::Fault(fault)
    }
}

/// A model without what changes none of a run's frames, or their last bits alone: its name, its duration, that of its last stage,
/// `on_divergence` and `gpu_from`.
pub fn identity(file: &ModelFile) -> ModelFile {
    let (name, on_divergence) = (String::new(), OnDivergence::default());
    let mut file = ModelFile { name, on_divergence, gpu_from: None, duration: 1.0, ..file.clone() };
    if let Some(last) = file.stages.last_mut() {
        last.duration = 1.0;
    }
    file
}

/// Hash of the [`identity`] of a model with its defaults.
pub fn model_hash(file: &ModelFile) -> String {
    frame::run::hash_text(&identity(file).to_yaml())
}

/// Whether a folder has a complete run of a model, of its whole duration, with all of its frames as they were written.
pub fn is_done(file: &ModelFile, folder: &Path) -> bool {
    finished(file, folder).is_some_and(|run| run.is_whole())
}

/// The complete run of a model, of its whole duration, that a folder has; files of its frames may have been lost or damaged since.
pub fn finished(file: &ModelFile, folder: &Path) -> Option<RunReader> {
    RunReader::open(folder).ok().filter(|run| {
        run.index.complete
            && run.index.model_hash == model_hash(file)
            && run.index.expected_frames == n_frames(file.whole_duration(), file.frame_rate)
            && run.index.frames.len() as u64 == run.index.expected_frames
    })
}

/// Number of frames of a run until a time, s, before which they are: one at time 0, then one every 1/`frame_rate`.
pub fn n_frames(until: f64, frame_rate: f64) -> u64 {
    ((until * frame_rate - 1e-9).ceil() as u64).max(1)
}

/// Simulate a model, `file` with its resolution `resolved`, into the run directory `folder`.
///
/// # Errors
/// A file that cannot be read or written, a checkpoint of another model, a simulation that diverged, or a graphics device that cannot
/// simulate the model.
pub fn simulate(
    file: &ModelFile,
    mut resolved: Resolved,
    folder: &Path,
    (span, computer): (&Span, &Computer),
    observer: &mut dyn Observer,
) -> Result<(), RunError> {
    let until = span.end(&resolved.model);
    let expected_frames = n_frames(until, resolved.model.frame_rate);
    let (model, state) = (std::mem::take(&mut resolved.model), std::mem::take(&mut resolved.state));
    computer.check(file)?;
    let sim = computer.begin(file.gpu_from, (model, state), observer)?;
    let index = Index {
        format_version: FORMAT_VERSION,
        program: format!("scree {}", env!("CARGO_PKG_VERSION")),
        model_hash: model_hash(file),
        seed: sim.model.seed,
        step_size: sim.model.step,
        frame_rate: Some(sim.model.frame_rate),
        backend: sim.backend().into(),
        adapter: sim.adapter().unwrap_or_else(processor),
        units: "SI: m, kg, s, rad".into(),
        expected_frames,
        complete: false,
        ended: None,
        columns: vec![],
        warnings: vec![],
        generated: Default::default(),
        frames: vec![],
    };
    let mut run = match span.resume.then(|| checkpoint::latest(folder)).transpose()?.flatten() {
        Some(path) => Run::resume(file, &resolved, folder, index, (sim, until), &path, observer)?,
        None => Run::start(file, &resolved, folder, index, sim, observer)?,
    };
    let period = 1.0 / run.sim.model.frame_rate;
    observer.start(expected_frames);
    for frame in run.writer.frames() as u64..expected_frames {
        // The frame's instant is the first step's end that is not before its time.
        run.advance(frame as f64 * period, frame, observer)?;
        run.write_frame(frame)?;
        observer.frame(frame + 1);
    }
    run.advance(until, expected_frames, observer)?;
    run.save()?;
    run.list_warnings();
    observer.end(&mut run.writer)?;
    run.writer.finish()?;
    Ok(())
}

/// A run in progress.
struct Run<'a> {
    file: &'a ModelFile,
    resolved: &'a Resolved,
    folder: &'a Path,
    writer: RunWriter,
    sim: Simulation,
    hash: String,
    report: Series,
    probes: Series,
    /// Number of the next line of the probes; that of time 0 is 0.
    next_probe: u64,
    next_checkpoint: f64,
    /// Steps of checkpoints that serve only a restart: all but the last are removed.
    transient: Vec<u64>,
}

/// The series of a run directory.
const REPORT: &str = "report.csv";
const PROBES: &str = "probes.csv";

impl<'a> Run<'a> {
    fn start(
        file: &'a ModelFile,
        resolved: &'a Resolved,
        folder: &'a Path,
        index: Index,
        sim: Simulation,
        observer: &mut dyn Observer,
    ) -> Result<Run<'a>, RunError> {
        let hash = index.model_hash.clone();
        let mut writer = RunWriter::create(folder, file.format, index)?;
        writer.write_file("model.yaml", &file.to_yaml())?;
        clear(&checkpoint::folder(folder), "state")?;
        clear(&folder.join("contacts"), "csv")?;
        observer.begin(&sim, &frame_of(&sim.model, &sim.state, 0), &mut writer)?;
        let report = Series::create(&folder.join(REPORT), &report_header())?;
        let probes = Series::create(&folder.join(PROBES), &probe_header(&sim.model, &resolved.probes))?;
        let (next_probe, next_checkpoint, transient) = (0, 0.0, vec![]);
        let mut run =
            Run { file, resolved, folder, writer, sim, hash, report, probes, next_probe, next_checkpoint, transient };
        run.probe()?;
        run.next_checkpoint = run.checkpoint_interval();
        Ok(run)
    }

    fn resume(
        file: &'a ModelFile,
        resolved: &'a Resolved,
        folder: &'a Path,
        index: Index,
        (sim, until): (Simulation, f64),
        path: &Path,
        observer: &mut dyn Observer,
    ) -> Result<Run<'a>, RunError> {
        let hash = index.model_hash.clone();
        let (state, of) = checkpoint::read(path)?;
        if of != hash {
            let fault = Fault::whole(FaultKind::Input, path, "is a checkpoint of another model");
            return Err(fault.hint("simulate without --resume to start again, or restore the model").into());
        }
        state.fit(&sim.model).map_err(|why| Fault::whole(FaultKind::Data, path, why))?;
        let (h, time, expected) = (sim.model.step, state.time, index.expected_frames);
        if time > until + 0.5 * h {
            let fault = Fault::whole(FaultKind::Input, path, format!("is at {time:.6} s, after the end at {until} s"));
            return Err(fault.hint("a run is resumed to a later end: give a longer `duration` or --until").into());
        }
        let is_before = |n: &u64| *n as f64 / sim.model.frame_rate - 0.5 * h <= time;
        let keep = (0..expected).take_while(is_before).count() as u64;
        let mut writer = RunWriter::reopen(folder, file.format, index, keep)?;
        writer.set_warnings(entries(&state.watch.warnings));
        observer.resume(path, time, writer.frames() as u64, expected);
        let sim = sim.restart(state)?;
        let (last, interval) = (time + 0.5 * h, resolved.probes.interval.max(h));
        // A checkpoint at time 0 has no step before it.
        let report_from = if sim.state.steps == 0 { f64::NEG_INFINITY } else { time - 0.5 * h };
        let report = Series::reopen(&folder.join(REPORT), 1, report_from, last)?;
        let probes = Series::reopen(&folder.join(PROBES), 0, time - interval - 0.5 * h, last)?;
        let (next_probe, next_checkpoint, transient) = (0, 0.0, vec![]);
        let mut run =
            Run { file, resolved, folder, writer, sim, hash, report, probes, next_probe, next_checkpoint, transient };
        let after = |interval: f64| ((time + 0.5 * h) / interval).floor() * interval + interval;
        // Lines are numbered, so that they are at the same instants as without an interruption.
        run.next_probe = (time / interval) as u64;
        while run.is_probe_due() {
            run.next_probe += 1;
        }
        run.next_checkpoint = after(run.checkpoint_interval());
        Ok(run)
    }

    fn checkpoint_interval(&self) -> f64 {
        self.file.checkpoint_interval.unwrap_or(self.sim.model.duration / 10.0)
    }

    /// Step until a time, s; `frame` is the next to be written.
    fn advance(&mut self, time: f64, frame: u64, observer: &mut dyn Observer) -> Result<(), RunError> {
        let h = self.sim.model.step;
        while self.sim.state.time < time - 0.5 * h {
            let step = self.sim.try_step()?;
            self.report.push(&report_line(&step))?;
            if let Some(broken) = &step.broken {
                let why = matter(&self.sim, broken);
                return Err(self.end_early(EndKind::Diverged, why.clone(), divergence(&self.sim, &why, frame)));
            }
            step.note.iter().for_each(|note| observer.note(note));
            for warning in &step.warnings {
                self.warn(warning, frame, observer)?;
            }
            self.probe()?;
            self.save_if_due()?;
            if observer.is_interrupted() {
                self.save()?;
                self.list_warnings();
                self.set_ended(EndKind::Interrupted, String::new());
                self.writer.write()?;
                return Err(RunError::Interrupted(self.sim.state.time));
            }
        }
        Ok(())
    }

    /// Write the checkpoint of a stage's end, and of the interval where it is due.
    fn save_if_due(&mut self) -> Result<(), RunError> {
        let (now, h) = (self.sim.state.time, self.sim.model.step);
        let stage = self.resolved.stages.iter().find(|(_, end)| (end - now).abs() <= 0.5 * h);
        if let Some((name, _)) = stage {
            self.sim.fetch()?;
            let path = checkpoint::folder(self.folder).join(format!("{name}.state"));
            checkpoint::write(&path, &self.sim.state, &self.hash)?;
        }
        let is_due = now >= self.next_checkpoint - 0.5 * h;
        if is_due {
            self.next_checkpoint += self.checkpoint_interval();
        }
        if is_due || stage.is_some() {
            self.save()?;
            if self.file.checkpoint_interval.is_none() {
                self.transient.push(self.sim.state.steps);
            }
        }
        Ok(())
    }

    /// Report the first warning of a kind, or end the run where `on_divergence` is `stop`.
    fn warn(&mut self, warning: &Warning, frame: u64, observer: &mut dyn Observer) -> Result<(), RunError> {
        if self.file.on_divergence == OnDivergence::Stop {
            let kept = match checkpoint::latest(self.folder)? {
                Some(path) => format!("frames before {frame} and the checkpoint {} are kept", path.display()),
                None => format!("frames before {frame} are kept, there is no checkpoint yet"),
            };
            let why = warning.message.clone();
            return Err(self.end_early(EndKind::Stopped, why, format!("{warning}; {kept}")));
        }
        if self.sim.state.watch.warnings.iter().any(|w| w.first == *warning) {
            observer.warn(warning);
        }
        Ok(())
    }

    /// Write the series, the list of warnings and what ended the run, and return the error with its message for the user.
    fn end_early(&mut self, by: EndKind, why: String, message: String) -> RunError {
        self.list_warnings();
        self.set_ended(by, why);
        match self.flush().and_then(|()| self.writer.write()) {
            Ok(()) => RunError::Diverged(message),
            Err(more) => RunError::Diverged(format!("{message}\n{more}")),
        }
    }

    fn set_ended(&mut self, by: EndKind, why: String) {
        let (step, time) = (self.sim.state.steps, self.sim.state.time);
        self.writer.set_ended(Ended { by, step, time, why });
    }

    fn list_warnings(&mut self) {
        self.writer.set_warnings(entries(&self.sim.state.watch.warnings));
    }

    /// Whether the time of the next line of the probes has come: a multiple of their interval, to half a step.
    fn is_probe_due(&self) -> bool {
        let h = self.sim.model.step;
        self.sim.state.time >= self.next_probe as f64 * self.resolved.probes.interval.max(h) - 0.5 * h
    }

    fn probe(&mut self) -> Result<(), RunError> {
        if self.is_probe_due() {
            self.next_probe += 1;
            self.probes.push(&self.sim.probe_line(&self.resolved.probes)?)?;
        }
        Ok(())
    }

    fn write_frame(&mut self, frame: u64) -> Result<(), RunError> {
        match self.resolved.probes.contact_tables {
            true => self.sim.fetch()?,
            false => self.sim.fetch_bodies()?,
        }
        self.list_warnings();
        // Whoever sees the frame in the index finds its contacts.
        if self.resolved.probes.contact_tables {
            let table = csv::encode(&contacts_of(&self.sim.model, &self.sim.state, frame));
            atomic::write(&self.folder.join(format!("contacts/{frame:06}.csv")), table.as_bytes())?;
        }
        self.writer.write_frame(&frame_of(&self.sim.model, &self.sim.state, frame))?;
        Ok(())
    }

    /// Write the series and a checkpoint, and remove the transient checkpoints before it.
    fn save(&mut self) -> Result<(), RunError> {
        self.sim.fetch()?;
        self.flush()?;
        let folder = checkpoint::folder(self.folder);
        let path = folder.join(checkpoint::file_name(self.sim.state.steps));
        checkpoint::write(&path, &self.sim.state, &self.hash)?;
        for steps in self.transient.drain(..).filter(|s| *s != self.sim.state.steps) {
            let _ = std::fs::remove_file(folder.join(checkpoint::file_name(steps)));
        }
        Ok(())
    }

    fn flush(&mut self) -> Result<(), Fault> {
        self.report.flush()?;
        self.probes.flush()
    }
}

/// Remove the files of an earlier run with an extension.
fn clear(folder: &Path, ending: &str) -> Result<(), Fault> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Ok(()) };
    for path in entries.flatten().map(|e| e.path()).filter(|p| p.extension().is_some_and(|e| e == ending)) {
        std::fs::remove_file(&path).map_err(|e| Fault::unwritable(&path, &e))?;
    }
    Ok(())
}

/// The name of the processor; `cpu` where the system does not say it.
fn processor() -> String {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let of_line = |line: &str| Some(line.strip_prefix("model name")?.split_once(':')?.1.trim().to_string());
    text.lines().find_map(of_line).filter(|name| !name.is_empty()).unwrap_or_else(|| "cpu".into())
}

/// What is wrong with a state that cannot go on.
fn matter(sim: &Simulation, broken: &Broken) -> String {
    let body = broken.body.map_or(String::new(), |b| format!("body {}: ", sim.model.body_label(b)));
    format!("{body}{}", broken.why)
}

/// Message of a run that cannot go on.
fn divergence(sim: &Simulation, why: &str, frame: u64) -> String {
    let (step, time) = (sim.state.steps, sim.state.time);
    format!(
        "the simulation diverged at step {step} ({time:.4} s): {why}; frames before {frame} are kept; try a shorter step"
    )
}

/// The warnings of a run, as entries of `run.json`.
fn entries(warnings: &[WarningCount]) -> Vec<WarningEntry> {
    let entry = |w: &WarningCount| WarningEntry {
        kind: w.first.kind.name().into(),
        steps: w.count,
        first_step: w.first.step,
        first_time: w.first.time,
        message: w.first.message.clone(),
    };
    warnings.iter().map(entry).collect()
}
