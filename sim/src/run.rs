//! The driver of a run: from a resolved model to a run directory, from the start or from its last checkpoint.
//!
//! It takes steps and writes frames, probes, the report and checkpoints when they are due. Series are appended to; all else is written
//! whole. What a run says on its way, and what is written beside it, is an [`Observer`]'s.

use crate::model_file::{ModelFile, OnDivergence, Resolved};
use crate::watch::{Broken, Warning, WarningCount};
use crate::{Simulation, checkpoint, contacts_of, frame_of, probe_header, probe_line, report_header, report_line};
use frame::run::{FORMAT_VERSION, Index, RunReader, RunWriter, WarningEntry};
use frame::series::Series;
use frame::{Fault, FaultKind, Frame, atomic, csv};
use std::path::Path;

/// Which part of a run is to be done.
#[derive(Clone, Copy, Debug, Default)]
pub struct Span {
    /// Stop at this time, s; at the model's own end if not given.
    pub until: Option<f64>,
    /// Go on from the last checkpoint.
    pub resume: bool,
}

/// Who looks on while a run goes.
pub trait Observer {
    /// The run begins: its first frame is about to be written. Files beside it may be written now.
    fn begin(&mut self, _sim: &Simulation, _first: &Frame, _writer: &RunWriter) -> Result<(), Fault> {
        Ok(())
    }
    /// The run goes on from a checkpoint at `time`, s; `there` of `expected` frames are written.
    fn resume(&mut self, _checkpoint: &Path, _time: f64, _there: u64, _expected: u64) {}
    /// Steps are about to be taken, for `expected` frames in all.
    fn start(&mut self, _expected: u64) {}
    /// `done` frames are written.
    fn frame(&mut self, _done: u64) {}
    /// A step has the first warning of its kind.
    fn warn(&mut self, _warning: &Warning) {}
    /// The run has come to its end.
    fn end(&mut self, _first: &Frame, _last: &Frame, _writer: &RunWriter) -> Result<(), Fault> {
        Ok(())
    }
}

/// Why a run came to no end.
#[derive(Debug)]
pub enum RunError {
    /// A file could not be read or written.
    Fault(Fault),
    /// The simulation went wrong, with what the user reads.
    Diverged(String),
}

impl From<Fault> for RunError {
    fn from(fault: Fault) -> RunError {
        RunError::Fault(fault)
    }
}

/// The identity of a resolved model. What is done when it diverges does not change its run.
pub fn model_hash(file: &ModelFile) -> String {
    let file = ModelFile { on_divergence: OnDivergence::default(), ..file.clone() };
    frame::run::hash_text(&file.to_yaml())
}

/// Whether a folder holds a finished run of just this model.
pub fn is_done(file: &ModelFile, folder: &Path) -> bool {
    RunReader::open(folder).is_ok_and(|run| {
        run.index.complete
            && run.index.model_hash == model_hash(file)
            && run.index.frames.len() as u64 == run.index.expected_frames
    })
}

/// Simulate a model into `folder`.
pub fn simulate(
    file: &ModelFile,
    mut resolved: Resolved,
    folder: &Path,
    span: &Span,
    observer: &mut dyn Observer,
) -> Result<(), RunError> {
    let duration = resolved.model.duration;
    let until = span.until.unwrap_or(duration).min(duration);
    let expected_frames = resolved.model.n_frames(until);
    let sim = Simulation::new(std::mem::take(&mut resolved.model), std::mem::take(&mut resolved.state));
    let index = Index {
        format_version: FORMAT_VERSION,
        program: format!("scree {}", env!("CARGO_PKG_VERSION")),
        model_hash: model_hash(file),
        seed: sim.model.seed,
        step_size: sim.model.step,
        backend: sim.backend().into(),
        adapter: "cpu".into(),
        units: "SI: m, kg, s, rad".into(),
        expected_frames,
        complete: false,
        columns: vec![],
        warnings: vec![],
        frames: vec![],
    };
    let mut run = match span.resume.then(|| checkpoint::latest(folder)).transpose()?.flatten() {
        Some(path) => Run::resume(file, &resolved, folder, index, sim, &path, observer)?,
        None => Run::start(file, &resolved, folder, index, sim, observer)?,
    };
    let period = 1.0 / run.sim.model.frame_rate;
    observer.start(expected_frames);
    for number in run.writer.frames() as u64..expected_frames {
        // The frame's instant is the first step's end that is not before its time.
        run.advance(number as f64 * period, number, observer)?;
        run.write_frame(number)?;
        observer.frame(number + 1);
    }
    run.advance(until, expected_frames, observer)?;
    run.save()?;
    run.list_warnings();
    let first = RunReader::open(folder)?.read_frame(0)?;
    observer.end(&first, &frame_of(&run.sim.model, &run.sim.state, 0), &run.writer)?;
    run.writer.finish()?;
    Ok(())
}

/// A run on its way.
struct Run<'a> {
    file: &'a ModelFile,
    resolved: &'a Resolved,
    folder: &'a Path,
    writer: RunWriter,
    sim: Simulation,
    hash: String,
    report: Series,
    probes: Series,
    next_probe: f64,
    next_checkpoint: f64,
    /// Checkpoints that were written only for a restart: all but the last are removed.
    passing: Vec<u64>,
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
    ) -> Result<Run<'a>, Fault> {
        let hash = index.model_hash.clone();
        let writer = RunWriter::create(folder, file.format, index)?;
        writer.write_file("model.yaml", &file.to_yaml())?;
        clear(&checkpoint::folder(folder), "state")?;
        clear(&folder.join("contacts"), "csv")?;
        observer.begin(&sim, &frame_of(&sim.model, &sim.state, 0), &writer)?;
        let report = Series::create(&folder.join(REPORT), &report_header())?;
        let probes = Series::create(&folder.join(PROBES), &probe_header(&sim.model, &resolved.probes))?;
        let (next_probe, next_checkpoint, passing) = (0.0, 0.0, vec![]);
        let mut run =
            Run { file, resolved, folder, writer, sim, hash, report, probes, next_probe, next_checkpoint, passing };
        run.probe()?;
        run.next_checkpoint = run.checkpoint_interval();
        Ok(run)
    }

    fn resume(
        file: &'a ModelFile,
        resolved: &'a Resolved,
        folder: &'a Path,
        index: Index,
        sim: Simulation,
        path: &Path,
        observer: &mut dyn Observer,
    ) -> Result<Run<'a>, Fault> {
        let hash = index.model_hash.clone();
        let (state, of) = checkpoint::read(path)?;
        if of != hash {
            let fault = Fault::whole(FaultKind::Input, path, "is a checkpoint of another model than this one");
            return Err(fault.hint("simulate without --resume to begin again, or give the model as it was"));
        }
        if state.position.len() != sim.model.n_bodies() {
            return Err(Fault::whole(FaultKind::Data, path, "does not have the model's bodies"));
        }
        let (h, time, expected) = (sim.model.step, state.time, index.expected_frames);
        let is_before = |n: &u64| *n as f64 / sim.model.frame_rate - 0.5 * h <= time;
        let keep = (0..expected).take_while(is_before).count() as u64;
        let mut writer = RunWriter::reopen(folder, file.format, index, keep)?;
        writer.set_warnings(entries(&state.watch.warnings));
        observer.resume(path, time, writer.frames() as u64, expected);
        let sim = Simulation::new(sim.model, state);
        let report = Series::reopen(&folder.join(REPORT), 1, time + 0.5 * h)?;
        let probes = Series::reopen(&folder.join(PROBES), 0, time + 0.5 * h)?;
        let (next_probe, next_checkpoint, passing) = (0.0, 0.0, vec![]);
        let mut run =
            Run { file, resolved, folder, writer, sim, hash, report, probes, next_probe, next_checkpoint, passing };
        let after = |interval: f64| ((time + 0.5 * h) / interval).floor() * interval + interval;
        run.next_probe = after(resolved.probes.interval);
        run.next_checkpoint = after(run.checkpoint_interval());
        Ok(run)
    }

    fn checkpoint_interval(&self) -> f64 {
        self.file.checkpoint_interval.unwrap_or(self.sim.model.duration / 10.0)
    }

    /// Step until a time; frame `number` is the next to be written.
    fn advance(&mut self, time: f64, number: u64, observer: &mut dyn Observer) -> Result<(), RunError> {
        let h = self.sim.model.step;
        while self.sim.state.time < time - 0.5 * h {
            let step = self.sim.step();
            self.report.push(&report_line(&step))?;
            if let Some(broken) = &step.broken {
                return Err(self.end_early(blown_up(&self.sim, broken, number)));
            }
            for warning in &step.warnings {
                self.warn(warning, number, observer)?;
            }
            self.probe()?;
            self.save_if_due()?;
        }
        Ok(())
    }

    /// Write the checkpoints of a stage's end and of their interval.
    fn save_if_due(&mut self) -> Result<(), Fault> {
        let (now, h) = (self.sim.state.time, self.sim.model.step);
        let stage = self.resolved.stages.iter().find(|(_, end)| (end - now).abs() <= 0.5 * h);
        if let Some((name, _)) = stage {
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
                self.passing.push(self.sim.state.steps);
            }
        }
        Ok(())
    }

    /// Report a warning, the first time of its kind, or end the run if the model asks for it.
    fn warn(&mut self, warning: &Warning, number: u64, observer: &mut dyn Observer) -> Result<(), RunError> {
        if self.file.on_divergence == OnDivergence::Stop {
            let checkpoint = match checkpoint::latest(self.folder)? {
                Some(path) => format!("the checkpoint {} are kept", path.display()),
                None => "no checkpoint yet are kept".into(),
            };
            return Err(self.end_early(format!("{warning}; frames before {number} and {checkpoint}")));
        }
        if self.sim.state.watch.warnings.iter().any(|w| w.first == *warning) {
            observer.warn(warning);
        }
        Ok(())
    }

    /// Write the series as far as they go, and what went wrong.
    fn end_early(&mut self, why: String) -> RunError {
        self.list_warnings();
        match self.flush().and_then(|()| self.writer.write()) {
            Ok(()) => RunError::Diverged(why),
            Err(more) => RunError::Diverged(format!("{why}\n{more}")),
        }
    }

    fn list_warnings(&mut self) {
        self.writer.set_warnings(entries(&self.sim.state.watch.warnings));
    }

    fn probe(&mut self) -> Result<(), Fault> {
        let h = self.sim.model.step;
        if self.sim.state.time >= self.next_probe - 0.5 * h {
            self.next_probe += self.resolved.probes.interval.max(h);
            self.probes.push(&probe_line(&self.sim.model, &self.sim.state, &self.resolved.probes))?;
        }
        Ok(())
    }

    fn write_frame(&mut self, number: u64) -> Result<(), Fault> {
        self.list_warnings();
        self.writer.write_frame(&frame_of(&self.sim.model, &self.sim.state, number))?;
        if self.resolved.probes.contact_tables {
            let table = csv::encode(&contacts_of(&self.sim.model, &self.sim.state, number));
            atomic::write(&self.folder.join(format!("contacts/{number:06}.csv")), table.as_bytes())?;
        }
        Ok(())
    }

    /// Write a checkpoint with the series that lead to it, and remove the one before it that nobody asked for.
    fn save(&mut self) -> Result<(), Fault> {
        self.flush()?;
        let folder = checkpoint::folder(self.folder);
        let path = folder.join(checkpoint::file_name(self.sim.state.steps));
        checkpoint::write(&path, &self.sim.state, &self.hash)?;
        for steps in self.passing.drain(..).filter(|s| *s != self.sim.state.steps) {
            let _ = std::fs::remove_file(folder.join(checkpoint::file_name(steps)));
        }
        Ok(())
    }

    fn flush(&mut self) -> Result<(), Fault> {
        self.report.flush()?;
        self.probes.flush()
    }
}

/// Remove files of an earlier run.
fn clear(folder: &Path, ending: &str) -> Result<(), Fault> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Ok(()) };
    for path in entries.flatten().map(|e| e.path()).filter(|p| p.extension().is_some_and(|e| e == ending)) {
        std::fs::remove_file(&path).map_err(|e| Fault::unwritable(&path, &e))?;
    }
    Ok(())
}

fn blown_up(sim: &Simulation, broken: &Broken, frame: u64) -> String {
    let body = broken.body.map_or(String::new(), |b| format!("body {}: ", sim.model.body_label(b)));
    let (step, time, why) = (sim.state.steps, sim.state.time, &broken.why);
    format!(
        "the simulation blew up at step {step} ({time:.4} s): {body}{why}; frames before {frame} are kept; try a shorter step"
    )
}

/// The warnings of a run as `run.json` lists them.
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
