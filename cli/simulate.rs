//! `scree simulate`: a model → a run directory, from the start or from its last checkpoint.

use crate::args::{Backend, SimulateArgs};
use crate::progress::Progress;
use crate::report::{Exit, Failure, Outcome};
use crate::{geometry, job, sweep};
use bind::metadata::Data;
use frame::run::{FORMAT_VERSION, FrameFormat, Index, RunReader, RunWriter, WarningEntry};
use frame::{Fault, FaultKind, atomic, csv, read_text};
use sim::model_file::{self, ModelFile, OnDivergence, Resolved};
use sim::watch::{Broken, Warning, WarningCount};
use sim::{Simulation, checkpoint, contacts_of, frame_of, probe_header, probe_line, report_header, report_line};
use std::path::Path;
use std::time::Instant;

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

/// Which part of a run is to be done.
#[derive(Clone, Copy, Debug, Default)]
pub struct Span {
    /// Stop at this time, s; at the model's own end if not given.
    pub until: Option<f64>,
    /// Go on from the last checkpoint.
    pub resume: bool,
}

/// The identity of a resolved model.
pub fn model_hash(file: &ModelFile) -> String {
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

/// A run on its way.
struct Run<'a> {
    file: &'a ModelFile,
    resolved: &'a Resolved,
    folder: &'a Path,
    writer: RunWriter,
    sim: Simulation,
    hash: String,
    report: String,
    probes: String,
    next_probe: f64,
    next_checkpoint: f64,
    /// When the series were written last.
    series_written: Instant,
    /// Checkpoints that were written only for a restart: all but the last are removed.
    passing: Vec<u64>,
}

/// Run the model into `folder`.
pub fn simulate(file: &ModelFile, mut resolved: Resolved, folder: &Path, span: &Span) -> Outcome {
    for warning in &resolved.warnings {
        eprintln!("warning: {warning}");
    }
    let duration = resolved.model.duration;
    let until = span.until.unwrap_or(duration).min(duration);
    let expected_frames = resolved.model.n_frames(until);
    let hash = model_hash(file);
    let index = Index {
        format_version: FORMAT_VERSION,
        program: format!("scree {}", env!("CARGO_PKG_VERSION")),
        model_hash: hash.clone(),
        seed: resolved.model.seed,
        step_size: resolved.model.step,
        backend: "cpu".into(),
        adapter: "cpu".into(),
        units: "SI: m, kg, s, rad".into(),
        expected_frames,
        complete: false,
        columns: vec![],
        warnings: vec![],
        frames: vec![],
    };
    let sim = Simulation::new(std::mem::take(&mut resolved.model), std::mem::take(&mut resolved.state));
    let mut run = match span.resume.then(|| checkpoint::latest(folder)).transpose()?.flatten() {
        Some(path) => Run::resume(file, &resolved, folder, index, sim, hash, &path)?,
        None => Run::start(file, &resolved, folder, index, sim, hash)?,
    };
    let period = 1.0 / run.sim.model.frame_rate;
    let progress = Progress::start("simulating", expected_frames);
    let first = run.writer.frames() as u64;
    for number in first..expected_frames {
        // The frame's instant is the first step's end that is not before its time.
        run.advance(number as f64 * period, number)?;
        run.write_frame(number)?;
        progress.at(number + 1);
    }
    run.advance(until, expected_frames)?;
    run.save()?;
    run.list_warnings();
    run.finish_metadata()?;
    run.writer.finish()?;
    progress.finish();
    Ok(())
}

impl<'a> Run<'a> {
    /// A run with empty series.
    fn new(
        file: &'a ModelFile,
        resolved: &'a Resolved,
        folder: &'a Path,
        writer: RunWriter,
        sim: Simulation,
        hash: String,
    ) -> Run<'a> {
        let (report, probes) = (String::new(), String::new());
        let (next_probe, next_checkpoint) = (0.0, 0.0);
        let (series_written, passing) = (Instant::now(), vec![]);
        Run {
            file,
            resolved,
            folder,
            writer,
            sim,
            hash,
            report,
            probes,
            next_probe,
            next_checkpoint,
            series_written,
            passing,
        }
    }

    fn start(
        file: &'a ModelFile,
        resolved: &'a Resolved,
        folder: &'a Path,
        index: Index,
        sim: Simulation,
        hash: String,
    ) -> Outcome<Run<'a>> {
        let writer = RunWriter::create(folder, file.format, index)?;
        writer.write_file("model.yaml", &file.to_yaml())?;
        clear(&checkpoint::folder(folder), "state")?;
        clear(&folder.join("contacts"), "csv")?;
        geometry::write_archives(&sim.model, folder)?;
        let metadata = metadata_for(&[&frame_of(&sim.model, &sim.state, 0)]);
        metadata.iter().try_for_each(|text| writer.write_file("metadata.yaml", text))?;
        let mut run = Run::new(file, resolved, folder, writer, sim, hash);
        (run.report, run.probes) = (report_header(), probe_header(&run.sim.model, &resolved.probes));
        run.probe();
        run.next_checkpoint = run.checkpoint_interval();
        Ok(run)
    }

    fn resume(
        file: &'a ModelFile,
        resolved: &'a Resolved,
        folder: &'a Path,
        index: Index,
        sim: Simulation,
        hash: String,
        path: &Path,
    ) -> Outcome<Run<'a>> {
        let (state, of) = checkpoint::read(path)?;
        if of != hash {
            let fault = Fault::whole(FaultKind::Input, path, "is a checkpoint of another model than this one")
                .hint("simulate without --resume to begin anew, or give the model as it was");
            return Err(fault.into());
        }
        if state.position.len() != sim.model.n_bodies() {
            return Err(Fault::whole(FaultKind::Data, path, "does not have the model's bodies").into());
        }
        let h = sim.model.step;
        let keep = (0..index.expected_frames)
            .take_while(|n| *n as f64 / sim.model.frame_rate - 0.5 * h <= state.time)
            .count() as u64;
        let expected = index.expected_frames;
        let writer = RunWriter::reopen(folder, file.format, index, keep)?;
        let there = writer.frames();
        eprintln!("resume: from {} at {:.4} s, {there} of {expected} frames are there", path.display(), state.time);
        let time = state.time;
        let sim = Simulation::new(sim.model, state);
        let mut run = Run::new(file, resolved, folder, writer, sim, hash);
        run.report = series_until(folder, "report.csv", 1, time + 0.5 * h)?;
        run.probes = series_until(folder, "probes.csv", 0, time + 0.5 * h)?;
        let after = |interval: f64| ((time + 0.5 * h) / interval).floor() * interval + interval;
        run.next_probe = after(resolved.probes.interval);
        run.next_checkpoint = after(run.checkpoint_interval());
        Ok(run)
    }

    fn checkpoint_interval(&self) -> f64 {
        self.file.checkpoint_interval.unwrap_or(self.sim.model.duration / 10.0)
    }

    /// Step until a time; frame `number` is the next to be written.
    fn advance(&mut self, time: f64, number: u64) -> Outcome {
        let h = self.sim.model.step;
        while self.sim.state.time < time - 0.5 * h {
            let step = self.sim.step();
            self.report.push_str(&report_line(&step));
            if let Some(broken) = &step.broken {
                return Err(self.end_early(blown_up(&self.sim, broken, number)));
            }
            for warning in &step.warnings {
                self.warn(warning, number)?;
            }
            self.probe();
            let now = self.sim.state.time;
            let stage = self.resolved.stages.iter().find(|(_, end)| (end - now).abs() <= 0.5 * h);
            if let Some((name, _)) = stage {
                let path = checkpoint::folder(self.folder).join(format!("{name}.state"));
                checkpoint::write(&path, &self.sim.state, &self.hash)?;
            }
            let due = now >= self.next_checkpoint - 0.5 * h;
            if due || stage.is_some() {
                self.save()?;
                if due {
                    self.next_checkpoint += self.checkpoint_interval();
                }
                if self.file.checkpoint_interval.is_none() {
                    self.passing.push(self.sim.state.steps);
                }
            }
        }
        Ok(())
    }

    /// Say a warning, the first time of its kind, or end the run if the model asks for it.
    fn warn(&mut self, warning: &Warning, number: u64) -> Outcome {
        let Warning { kind, step, time, message } = warning;
        if self.file.on_divergence == OnDivergence::Stop {
            let message = format!(
                "step {step} ({time:.6} s): {message}; frames before {number} and the last checkpoint are kept"
            );
            return Err(self.end_early(Failure::new(Exit::Data, message)));
        }
        let is_first = self.sim.state.watch.warnings.iter().any(|w| w.first == *warning);
        if is_first {
            eprintln!("warning: step {step} ({time:.6} s): {message}; more of this kind ({}) are counted", kind.name());
        }
        Ok(())
    }

    /// Write the series as far as they go, and what went wrong.
    fn end_early(&mut self, failure: Failure) -> Failure {
        self.list_warnings();
        match self.write_series().and_then(|()| Ok(self.writer.write()?)) {
            Ok(()) => failure,
            Err(more) => Failure::new(failure.exit, format!("{failure}\n{more}")),
        }
    }

    fn list_warnings(&mut self) {
        let entry = |w: &WarningCount| WarningEntry {
            kind: w.first.kind.name().into(),
            steps: w.count,
            first_step: w.first.step,
            first_time: w.first.time,
            message: w.first.message.clone(),
        };
        self.writer.set_warnings(self.sim.state.watch.warnings.iter().map(entry).collect());
    }

    fn probe(&mut self) {
        let h = self.sim.model.step;
        if self.sim.state.time >= self.next_probe - 0.5 * h {
            self.probes.push_str(&probe_line(&self.sim.model, &self.sim.state, &self.resolved.probes));
            self.next_probe += self.resolved.probes.interval.max(h);
        }
    }

    fn write_frame(&mut self, number: u64) -> Outcome {
        self.list_warnings();
        self.writer.write_frame(&frame_of(&self.sim.model, &self.sim.state, number))?;
        if self.resolved.probes.contact_tables {
            let table = csv::encode(&contacts_of(&self.sim.model, &self.sim.state, number));
            atomic::write(&self.folder.join(format!("contacts/{number:06}.csv")), table.as_bytes())?;
        }
        // Whole, and so not at every frame of many, but as often as one who looks on would like.
        if self.series_written.elapsed().as_secs_f64() > 1.0 {
            self.write_series()?;
        }
        Ok(())
    }

    /// Write a checkpoint with the series that lead to it, and remove the one before it that nobody asked for.
    fn save(&mut self) -> Outcome {
        self.write_series()?;
        let folder = checkpoint::folder(self.folder);
        let path = folder.join(checkpoint::file_name(self.sim.state.steps));
        checkpoint::write(&path, &self.sim.state, &self.hash)?;
        for steps in self.passing.drain(..).filter(|s| *s != self.sim.state.steps) {
            let _ = std::fs::remove_file(folder.join(checkpoint::file_name(steps)));
        }
        Ok(())
    }

    /// Look again at what there is to draw: bodies may have appeared, and moved out of the picture. A file that somebody has
    /// changed meanwhile stays.
    fn finish_metadata(&self) -> Outcome {
        let run = RunReader::open(self.folder)?;
        let first = run.read_frame(0)?;
        let last = frame_of(&self.sim.model, &self.sim.state, 0);
        let ours = std::fs::read_to_string(self.folder.join("metadata.yaml")).ok() == metadata_for(&[&first]);
        match metadata_for(&[&first, &last]) {
            Some(text) if ours => Ok(self.writer.write_file("metadata.yaml", &text)?),
            _ => Ok(()),
        }
    }

    fn write_series(&mut self) -> Outcome {
        self.series_written = Instant::now();
        self.writer.write_file("report.csv", &self.report)?;
        self.writer.write_file("probes.csv", &self.probes)?;
        Ok(())
    }
}

/// Remove files of an earlier run.
fn clear(folder: &Path, ending: &str) -> Outcome {
    let Ok(entries) = std::fs::read_dir(folder) else { return Ok(()) };
    for path in entries.flatten().map(|e| e.path()).filter(|p| p.extension().is_some_and(|e| e == ending)) {
        std::fs::remove_file(&path).map_err(|e| Fault::unwritable(&path, &e))?;
    }
    Ok(())
}

/// The lines of a series whose time, in the given column, is not after `time`.
fn series_until(folder: &Path, name: &str, column: usize, time: f64) -> Outcome<String> {
    let path = folder.join(name);
    let text = read_text(FaultKind::Data, &path)?;
    let early = |line: &str| line.split(',').nth(column).and_then(|c| c.parse::<f64>().ok()).is_some_and(|t| t <= time);
    let kept = text.lines().enumerate().filter(|(i, line)| *i == 0 || early(line));
    Ok(kept.map(|(_, line)| format!("{line}\n")).collect())
}

fn blown_up(sim: &Simulation, broken: &Broken, frame: u64) -> Failure {
    let body = broken.body.map_or(String::new(), |b| format!("body {}: ", sim.model.body_label(b)));
    let message = format!(
        "the simulation blew up at step {} ({:.4} s): {body}{}; frames before {frame} are kept; try a shorter step",
        sim.state.steps, sim.state.time, broken.why
    );
    Failure::new(Exit::Data, message)
}

/// What to draw for every class, beside the run, so that `scree render RUN` just works.
fn metadata_for(frames: &[&frame::Frame]) -> Option<String> {
    let data = Data { run: Some(".".into()), ..Data::default() };
    let metadata = bind::suggest::metadata(data, frames).ok()?;
    Some(bind::suggest::to_yaml(&metadata, frames[0]))
}
