//! `scree status`: how far a film is, or a folder of images, by what its ledger says; `scree verify`: whether every image is what was
//! written, of what is there now.

use crate::batch::{self, Plan};
use crate::displays::written;
use crate::images;
use crate::job::{StatusJob, images_of};
use crate::ledger::{Hashes, Ledger, Standing};
use crate::report::{Exit, Failure, Outcome};
use frame::run::RunReader;
use frame::{Fault, FaultKind, list};
use rayon::prelude::*;
use render::film::bucket::Shard;
use std::collections::{BTreeMap, HashSet};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// How far a film is.
#[derive(Default)]
struct Status {
    /// Images, or those of which anything is known where there is no plan.
    images: usize,
    done: usize,
    /// Shards that wait to be joined, of images that are not done.
    shards: usize,
    /// Images that a process is drawing.
    working: usize,
    /// Images whose file is not what was written, by its size.
    damaged: Vec<String>,
    /// Images that could not be drawn, and why.
    failed: Vec<(String, String)>,
    /// Time that the images which are done took, s.
    seconds: f64,
    /// Frames of the simulation that are there, and how many there will be.
    simulated: Option<(u64, u64)>,
    /// Runs of a sweep that are finished, and how many there will be.
    runs: Option<(usize, usize)>,
    /// Tasks in each of the scheduler's states.
    queue: BTreeMap<String, usize>,
}

/// Run `scree status`.
pub fn run(job: StatusJob) -> Outcome {
    loop {
        let status = status(&job.folder)?;
        if job.json {
            println!("{}", status.json());
        } else {
            print!("{}", status.text());
        }
        let is_swept = status.runs.is_some_and(|(done, all)| done == all);
        if !job.watch || is_swept || status.done == status.images && status.images > 0 {
            return Ok(());
        }
        std::thread::sleep(Duration::from_secs(2));
    }
}

/// The folders of images in a folder: those of its plan, or it, or its `images`.
fn folders(folder: &Path) -> Outcome<Vec<PathBuf>> {
    let has_ledger = |folder: &Path| Ledger::of(folder).folder().join("lock").is_file();
    let main = [folder.join("images"), folder.to_path_buf()].into_iter().find(|folder| has_ledger(folder));
    let Some(main) = main.or_else(|| Plan::exists(folder).then(|| folder.join("images"))) else {
        let fault = Fault::whole(FaultKind::Data, folder, "has neither a plan nor images of `scree render`");
        return Err(fault.into());
    };
    let inner = std::fs::read_dir(&main).into_iter().flatten().flatten().map(|entry| entry.path());
    let mut all: Vec<PathBuf> = inner.filter(|path| path.is_dir() && has_ledger(path)).collect();
    all.sort();
    all.insert(0, main);
    Ok(all)
}

fn status(folder: &Path) -> Outcome<Status> {
    let plan = if Plan::exists(folder) { Some(Plan::read(folder)?) } else { None };
    let mut status = Status::default();
    for images in folders(folder)? {
        look(&images, plan.as_ref(), &mut status);
    }
    let Some(plan) = plan else { return Ok(status) };
    if plan.simulation.as_ref().is_some_and(|simulation| simulation.sweep == 0) {
        let run = RunReader::open(&plan.home).ok();
        let there = run.as_ref().map_or(0, |run| run.index.frames.len() as u64);
        status.simulated = Some((there, run.map_or(0, |run| run.index.expected_frames)));
    }
    if let Some(n) = plan.simulation.as_ref().map(|simulation| simulation.sweep).filter(|n| *n > 0) {
        let folders = std::fs::read_dir(&plan.home).into_iter().flatten().flatten().map(|entry| entry.path());
        let runs = folders.filter_map(|folder| RunReader::open(&folder).ok());
        let is_done = |run: &RunReader| run.index.frames.len() as u64 == run.index.expected_frames;
        status.runs = Some((runs.filter(is_done).count(), n));
    }
    status.queue = batch::state_of(plan.scheduler, &batch::submitted(&plan.home)).unwrap_or_default();
    Ok(status)
}

/// Look at a folder of images: those that a plan names, or those that its ledger knows.
fn look(images: &Path, plan: Option<&Plan>, status: &mut Status) {
    let ledger = Ledger::of(images);
    let names = |folder: &Path| -> HashSet<String> {
        let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
        entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect()
    };
    let (files, entries) = (names(images), names(&ledger.folder()));
    let known = |name: &String| name.strip_suffix(".json").or(name.strip_suffix(".failed")).map(str::to_string);
    let wanted: Vec<String> = match plan {
        Some(plan) => {
            let ending = if entries.iter().any(|name| name.contains(".exr")) { "exr" } else { "png" };
            plan.frames.iter().map(|frame| format!("{frame:06}.{ending}")).collect()
        }
        None => {
            let whole = entries.iter().filter_map(known).filter(|name| !name.contains(".part-") && name != "ranges");
            whole.collect::<std::collections::BTreeSet<_>>().into_iter().collect()
        }
    };
    let claims = ledger.claims();
    let n_shards = plan.map_or(1, |plan| plan.buckets);
    let states: Vec<_> = wanted.par_iter().map(|file| of_image(file, &ledger, (&files, &entries), n_shards)).collect();
    for (file, state) in wanted.into_iter().zip(states) {
        status.images += 1;
        match state {
            State::Done(seconds) => {
                status.done += 1;
                status.seconds += seconds;
            }
            State::Damaged => status.damaged.push(file),
            State::Failed(why) => status.failed.push((file, why)),
            State::Shards(n) => status.shards += n,
            State::Missing if claims.claim(&file).is_none() => status.working += 1,
            State::Missing => {}
        }
    }
}

/// How an image is, as far as sizes of files tell.
enum State {
    Done(f64),
    Damaged,
    Failed(String),
    Shards(usize),
    Missing,
}

fn of_image(
    file: &str,
    ledger: &Ledger,
    (files, entries): (&HashSet<String>, &HashSet<String>),
    n_shards: usize,
) -> State {
    let has_entry = entries.contains(&format!("{file}.json"));
    if has_entry && files.contains(file) {
        let size = ledger.images.join(file).metadata().map(|m| m.len()).ok();
        return match ledger.entry(file) {
            Some(entry) if Some(entry.bytes) == size => State::Done(entry.seconds),
            _ => State::Damaged,
        };
    }
    if entries.contains(&format!("{file}.failed"))
        && let Some(why) = ledger.failure(file)
    {
        return State::Failed(why);
    }
    let shard = |part: usize| written(Path::new(file), Some(Shard { part, parts: n_shards }));
    let there = (1..=n_shards).filter(|part| n_shards > 1 && files.contains(&shard(*part).display().to_string()));
    match there.count() {
        0 => State::Missing,
        n => State::Shards(n),
    }
}

impl Status {
    /// Time that is left, s, if one process drew the rest.
    fn seconds_left(&self) -> Option<f64> {
        (self.done > 0).then(|| self.seconds / self.done as f64 * (self.images - self.done) as f64)
    }

    fn text(&self) -> String {
        /// Names that are printed.
        const PRINTED: usize = 10;
        let mut text = String::new();
        if let Some((there, expected)) = self.simulated {
            text += &format!("simulation: {there} of {expected} frames\n");
        }
        if let Some((done, all)) = self.runs {
            text += &format!("runs of the sweep: {done} of {all} finished\n");
            if self.images == 0 {
                return text + &self.of_queue();
            }
        }
        text += &format!("images: {} of {} done", self.done, self.images);
        let rest = self.images - self.done - self.working - self.damaged.len() - self.failed.len();
        for (n, what) in [
            (self.working, "being drawn"),
            (self.failed.len(), "failed"),
            (self.damaged.len(), "not as they were written"),
            (rest, "not there"),
        ] {
            if n > 0 {
                text += &format!(", {n} {what}");
            }
        }
        if self.shards > 0 {
            text += &format!("; {} shards wait to be joined", self.shards);
        }
        if let Some(left) = self.seconds_left().filter(|left| *left > 0.0) {
            text += &format!("; {} of work left for one process", duration(left));
        }
        text += "\n";
        for (file, why) in self.failed.iter().take(PRINTED) {
            text += &format!("  {file}: {}\n", guard::text::line(why));
        }
        for file in self.damaged.iter().take(PRINTED) {
            text += &format!("  {file}: not as it was written\n");
        }
        text + &self.of_queue()
    }

    /// What the scheduler has of the film.
    fn of_queue(&self) -> String {
        if self.queue.is_empty() {
            return String::new();
        }
        let states: Vec<String> = self.queue.iter().map(|(state, n)| format!("{n} {state}")).collect();
        format!("tasks in the queue: {}\n", states.join(", "))
    }

    fn json(&self) -> serde_json::Value {
        let failed: Vec<_> =
            self.failed.iter().map(|(file, why)| serde_json::json!({"file": file, "why": why})).collect();
        serde_json::json!({
            "images": self.images, "done": self.done, "working": self.working, "failed": failed,
            "damaged": self.damaged, "shards": self.shards, "seconds": self.seconds, "seconds_left": self.seconds_left(),
            "simulated_frames": self.simulated.map(|(there, _)| there),
            "expected_frames": self.simulated.map(|(_, expected)| expected), "queue": self.queue,
            "finished_runs": self.runs.map(|(done, _)| done), "runs": self.runs.map(|(_, all)| all),
        })
    }
}

/// A length of time in words.
pub fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 1.0 => format!("{:.0} ms", 1000.0 * s),
        s if s < 100.0 => format!("{s:.1} s"),
        s if s < 6000.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}

/// Run `scree verify`: name what is not done, and fail if there is any.
pub fn verify(job: StatusJob) -> Outcome {
    let mut bad: Vec<(String, Standing)> = vec![];
    let n;
    if Plan::exists(&job.folder) {
        let plan = Plan::read(&job.folder)?;
        std::env::set_current_dir(&plan.from)
            .map_err(|e| Failure::new(Exit::Fault, format!("{}: {e}", plan.from.display())))?;
        let there: Vec<u64> = match RunReader::open(&plan.home) {
            Ok(run) if plan.simulation.is_some() => run.numbers(),
            _ => plan.frames.clone(),
        };
        let frames: Vec<u64> = plan.frames.iter().copied().filter(|frame| there.contains(frame)).collect();
        n = plan.frames.len();
        let lacking = plan.frames.iter().filter(|frame| !frames.contains(frame));
        bad.extend(lacking.map(|frame| (format!("frame {frame}"), Standing::Missing)));
        if !frames.is_empty() {
            let all = images::standings(&mut images_of(&plan, &frames)?, 1)?;
            let not_done = all.into_iter().filter(|(_, standing)| standing[0] != Standing::Done);
            bad.extend(not_done.map(|(frame, mut standing)| (format!("frame {frame}"), standing.remove(0))));
        }
    } else {
        let mut hashes = Hashes::default();
        let mut count = 0;
        for images in folders(&job.folder)? {
            let ledger = Ledger::of(&images);
            for file in ledger.files() {
                count += 1;
                let standing = ledger.standing(&file, None, &mut hashes);
                if standing != Standing::Done {
                    bad.push((images.join(&file).display().to_string(), standing));
                }
            }
        }
        n = count;
    }
    bad.iter().for_each(|(name, standing)| println!("{name}: {standing}"));
    if bad.is_empty() {
        println!("{n} images are as they were written, of what is there now");
        return Ok(());
    }
    Err(Failure::new(Exit::Partial, format!("{} of {n} images are not done", bad.len())))
}

/// What is said of frames in short.
pub fn describe(frames: &[u64]) -> String {
    let mut sorted = frames.to_vec();
    sorted.sort_unstable();
    list::describe(&sorted)
}
