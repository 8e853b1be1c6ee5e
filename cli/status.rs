//! `scree status`: how far a film is, or a folder of images, by what its ledger says; `scree verify`: whether every image is what was
//! written, of what is there now.

use crate::batch::marks::{self, TaskState};
use crate::batch::{self, MadeOf, Movie, MovieStanding, Plan, Scheduler};
use crate::displays::written;
use crate::images;
use crate::job::{StatusJob, images_made_of, images_of, replacements};
use crate::ledger::{Hashes, Ledger, Standing};
use crate::report::{Exit, Failure, Outcome, in_one_line};
use frame::run::RunReader;
use frame::{Fault, FaultKind, list};
use rayon::prelude::*;
use render::film::bucket::Shard;
use std::collections::{BTreeMap, BTreeSet, HashSet};
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
    /// Why the run cannot be read, if it is there.
    run_fault: Option<String>,
    /// Runs of a sweep that are finished, and how many there will be.
    runs: Option<(usize, usize)>,
    /// The movie, where one is made.
    movie: Option<MovieStanding>,
    /// Tasks that have begun and have not done their work.
    tasks: BTreeMap<String, TaskState>,
    /// Tasks in each of the scheduler's states; none if it cannot be asked, or there is none.
    queue: Option<BTreeMap<String, usize>>,
    /// Whether the film has a plan.
    is_planned: bool,
    /// Whether a scheduler runs its tasks.
    has_queue: bool,
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
        if !job.watch || status.is_done() {
            return Ok(());
        }
        if status.is_idle() {
            let message = "nobody works on what is left: `scree resume` goes on";
            return Err(Failure::new(Exit::Partial, message));
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
        let run = RunReader::open(&plan.home).map_err(|fault| fault.to_string());
        status.run_fault = run.as_ref().err().filter(|_| RunReader::is_run(&plan.home)).cloned();
        let run = run.ok();
        let there = run.as_ref().map_or(0, |run| run.n_there() as u64);
        status.simulated = Some((there, run.map_or(0, |run| run.index.expected_frames)));
    }
    if let Some(n) = plan.simulation.as_ref().map(|simulation| simulation.sweep).filter(|n| *n > 0) {
        let folders = std::fs::read_dir(&plan.home).into_iter().flatten().flatten().map(|entry| entry.path());
        let runs = folders.filter_map(|folder| RunReader::open(&folder).ok());
        let is_done = |run: &RunReader| run.n_there() as u64 == run.index.expected_frames;
        status.runs = Some((runs.filter(is_done).count(), n));
    }
    status.is_planned = true;
    status.movie = (plan.movie && !plan.frames.is_empty()).then(|| Movie::standing(&plan.home, None));
    status.tasks = marks::states(&plan.home);
    status.queue = batch::state_of(plan.scheduler, &batch::submitted(&plan.home));
    status.has_queue = plan.scheduler != Scheduler::Local;
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
    let ending = if entries.iter().any(|name| name.contains(".exr")) { "exr" } else { "png" };
    let wanted: Vec<String> = match plan {
        Some(plan) => plan.frames.iter().map(|frame| format!("{frame:06}.{ending}")).collect(),
        None => {
            let mut all: BTreeSet<String> = entries.iter().filter_map(known).filter(|name| is_image(name)).collect();
            let made: Vec<u64> = MadeOf::read(&ledger).map_or(vec![], |made| made.frames().collect());
            all.extend(made.iter().map(|frame| format!("{frame:06}.{ending}")));
            all.into_iter().collect()
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

/// Whether a name in a ledger is that of an image, whose name is its frame's number.
fn is_image(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_digit()) && !name.contains(".part-")
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
    if entries.contains(&format!("{file}.failed"))
        && let Some(why) = ledger.failure(file)
    {
        return State::Failed(why);
    }
    if entries.contains(&format!("{file}.json")) && files.contains(file) {
        let size = ledger.images.join(file).metadata().map(|m| m.len()).ok();
        return match ledger.entry(file) {
            Some(entry) if Some(entry.bytes) == size => State::Done(entry.seconds),
            _ => State::Damaged,
        };
    }
    let shard = |part: usize| written(Path::new(file), Some(Shard { part, parts: n_shards }));
    let there = (1..=n_shards).filter(|part| n_shards > 1 && files.contains(&shard(*part).display().to_string()));
    match there.count() {
        0 => State::Missing,
        n => State::Shards(n),
    }
}

impl Status {
    /// Whether all is done.
    fn is_done(&self) -> bool {
        let is_swept = self.runs.is_none_or(|(done, all)| done == all);
        let is_drawn = self.done == self.images && (self.images > 0 || self.runs.is_some());
        let is_failed = self.tasks.values().any(|state| matches!(state, TaskState::Failed(_)));
        is_swept
            && is_drawn
            && !is_failed
            && self.run_fault.is_none()
            && self.movie.is_none_or(|movie| movie == MovieStanding::Done)
    }

    /// Whether nobody works on a film that is not done, as far as that can be known.
    fn is_idle(&self) -> bool {
        let is_queued = self.has_queue && self.queue.as_ref().is_none_or(|queue| !queue.is_empty());
        let runs = |state: &TaskState| *state == TaskState::Running;
        self.is_planned && !is_queued && self.working == 0 && !self.tasks.values().any(runs) && !self.is_done()
    }

    /// Time that is left, s, if one process drew the rest.
    fn seconds_left(&self) -> Option<f64> {
        (self.done > 0).then(|| self.seconds / self.done as f64 * (self.images - self.done) as f64)
    }

    fn text(&self) -> String {
        /// Names that are printed.
        const PRINTED: usize = 10;
        let mut text = String::new();
        if let Some(why) = &self.run_fault {
            text += &format!("simulation: {}\n", in_one_line(why));
        } else if let Some((there, expected)) = self.simulated {
            text += &format!("simulation: {there} of {expected} frames\n");
        }
        if let Some((done, all)) = self.runs {
            text += &format!("runs of the sweep: {done} of {all} finished\n");
            if self.images == 0 {
                return text + &self.of_tasks() + &self.of_queue();
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
            text += &format!("  {file}: {}\n", in_one_line(why));
        }
        for file in self.damaged.iter().take(PRINTED) {
            text += &format!("  {file}: not as it was written\n");
        }
        if let Some(movie) = self.movie {
            text += &format!("movie: {movie}\n");
        }
        text + &self.of_tasks() + &self.of_queue()
    }

    /// What is known of tasks that have not done their work.
    fn of_tasks(&self) -> String {
        /// Tasks that are named.
        const PRINTED: usize = 10;
        let said = |(task, state): (&String, &TaskState)| match state {
            TaskState::Running => None,
            TaskState::Failed(why) => Some(format!("task {task} failed: {}\n", in_one_line(why))),
            TaskState::Lost => Some(format!(
                "task {task} was stopped before its end: it was cancelled or killed, or its machine was lost\n"
            )),
        };
        let all: Vec<String> = self.tasks.iter().filter_map(said).collect();
        let more = all.len().saturating_sub(PRINTED);
        let more = if more > 0 { format!("and {more} tasks more\n") } else { String::new() };
        all.into_iter().take(PRINTED).collect::<String>() + &more
    }

    /// What the scheduler has of the film.
    fn of_queue(&self) -> String {
        match &self.queue {
            None if self.has_queue => "the queue is not known here: of Slurm squeue does not answer, that of another scheduler is shown by qstat\n".into(),
            Some(queue) if !queue.is_empty() => {
                let states: Vec<String> = queue.iter().map(|(state, n)| format!("{n} {state}")).collect();
                format!("tasks in the queue: {}\n", states.join(", "))
            }
            _ if self.is_idle() => "nobody works on what is left: `scree resume` goes on\n".into(),
            _ => String::new(),
        }
    }

    fn json(&self) -> serde_json::Value {
        let failed: Vec<_> =
            self.failed.iter().map(|(file, why)| serde_json::json!({"file": file, "why": why})).collect();
        let task = |(name, state): (&String, &TaskState)| {
            let (state, why) = match state {
                TaskState::Running => ("running", None),
                TaskState::Failed(why) => ("failed", Some(why)),
                TaskState::Lost => ("lost", None),
            };
            serde_json::json!({"task": name, "state": state, "why": why})
        };
        serde_json::json!({
            "images": self.images, "done": self.done, "working": self.working, "failed": failed,
            "damaged": self.damaged, "shards": self.shards, "seconds": self.seconds, "seconds_left": self.seconds_left(),
            "simulated_frames": self.simulated.map(|(there, _)| there),
            "expected_frames": self.simulated.map(|(_, expected)| expected), "run_fault": self.run_fault, "queue": self.queue,
            "movie": self.movie.map(|movie| movie.to_string()), "tasks": self.tasks.iter().map(task).collect::<Vec<_>>(),
            "is_done": self.is_done(),
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
    let (n, bad) = if Plan::exists(&job.folder) { of_film(&job.folder)? } else { of_images(&job.folder)? };
    if job.json {
        let bad: Vec<_> = bad.iter().map(|(name, why)| serde_json::json!({"what": name, "why": why})).collect();
        println!("{}", serde_json::json!({"images": n, "is_done": bad.is_empty(), "not_done": bad}));
    } else {
        bad.iter().for_each(|(name, standing)| println!("{name}: {standing}"));
    }
    if bad.is_empty() {
        if !job.json {
            println!("{n} images are as they were written, of what is there now");
        }
        return Ok(());
    }
    let n_others = bad.iter().filter(|(name, _)| ["movie", "run", "sweep", "frames"].contains(&name.as_str())).count();
    let are = |n: usize| if n == 1 { "is" } else { "are" };
    let parts = |n: usize| if n == 1 { "1 other part".to_string() } else { format!("{n} other parts") };
    let has_none = bad.iter().any(|(name, _)| name == "images");
    let message = match (if has_none { n } else { bad.len() - n_others }, n_others) {
        (images, 0) => format!("{images} of {n} images {} not done", are(images)),
        (0, others) => format!("all {n} images are done, but {} of the film {} not", parts(others), are(others)),
        (images, others) => format!("{images} of {n} images and {} of the film are not done", parts(others)),
    };
    Err(Failure::new(Exit::Partial, message))
}

/// The number of images of a film, and what of it is not done.
fn of_film(folder: &Path) -> Outcome<(usize, Vec<(String, String)>)> {
    let plan = Plan::read(folder)?;
    std::env::set_current_dir(&plan.from)
        .map_err(|e| Failure::new(Exit::Fault, format!("{}: {e}", plan.from.display())))?;
    let mut bad: Vec<(String, String)> = vec![];
    if plan.simulation.is_some() {
        let folders = std::fs::read_dir(&plan.home).into_iter().flatten().flatten().map(|entry| entry.path());
        let runs = folders.chain([plan.home.clone()]).filter_map(|folder| RunReader::open(&folder).ok());
        if let Some(why) = model_of_run(&plan) {
            bad.push(("run".into(), why));
        }
        for run in runs.filter(|run| !run.is_whole()) {
            let why = format!("{} has frames that are not as they were written", run.folder.display());
            bad.push(("run".into(), why));
        }
    }
    if let Some(n) = plan.simulation.as_ref().map(|simulation| simulation.sweep).filter(|n| *n > 0) {
        let (done, _) = status(folder)?.runs.unwrap_or_default();
        if done < n {
            bad.push(("sweep".into(), format!("{done} of {n} runs are finished")));
        }
    }
    if !plan.frames.is_empty() {
        match images_of(&plan, &plan.frames) {
            Ok(mut job) => {
                let known: HashSet<u64> = plan.frames.iter().copied().collect();
                let new =
                    job.source.numbers().into_iter().filter(|frame| plan.is_all && !known.contains(frame)).count();
                if new > 0 {
                    let why = format!("the data has {new} frames that the film does not have: submit it again");
                    bad.push(("frames".into(), why));
                }
                let lost = job.lacking.iter().map(|frame| (format!("frame {frame}"), Standing::Gone.to_string()));
                bad.extend(lost);
                bad.extend(not_done(images::standings(&mut job, 1)?));
                let movie = plan.movie.then(|| Movie::standing(&plan.home, Some(&images::hash(&job))));
                bad.extend(movie.filter(|m| *m != MovieStanding::Done).map(|m| ("movie".into(), m.to_string())));
            }
            // Of a run that has not begun, no image is there.
            Err(_) if !RunReader::is_run(&plan.home) && plan.simulation.is_some() => {
                bad.push(("images".into(), Standing::Missing.to_string()));
            }
            // The run was there when the film was submitted, and is not the model's any more.
            Err(failure) if failure.exit == Exit::Usage && RunReader::is_run(&plan.home) => {
                bad.push(("run".into(), in_one_line(&failure.message)));
                bad.push(("images".into(), "stale: of another run than the model's".into()));
            }
            Err(failure) => return Err(failure),
        }
    }
    Ok((plan.frames.len(), bad))
}

/// Why the run of a film is not that of its model as it is now, if that is so.
fn model_of_run(plan: &Plan) -> Option<String> {
    let simulation = plan.simulation.as_ref().filter(|simulation| simulation.sweep == 0)?;
    let run = RunReader::open(&plan.home).ok()?;
    let set = replacements(simulation.set.iter().map(|(path, value)| (path, value)));
    match sim::model_file::load(&simulation.model, &set) {
        Ok((file, _)) if sim::run::model_hash(&file) == run.index.model_hash => None,
        Ok(_) => Some(format!("stale: {} has changed since it was simulated", simulation.model.display())),
        Err(fault) => Some(format!("cannot be simulated again: {}", in_one_line(&fault.to_string()))),
    }
}

/// Frames whose images are not done.
fn not_done(standings: Vec<(u64, Vec<Standing>)>) -> impl Iterator<Item = (String, String)> {
    let bad = standings.into_iter().filter(|(_, standing)| standing[0] != Standing::Done);
    bad.map(|(frame, standing)| (format!("frame {frame}"), standing[0].to_string()))
}

/// The number of images in a folder without a plan, and those that are not done.
fn of_images(folder: &Path) -> Outcome<(usize, Vec<(String, String)>)> {
    let (mut n, mut bad) = (0, vec![]);
    let all = folders(folder)?;
    let main = Ledger::of(&all[0]);
    let numbers = |ledger: &Ledger| -> Vec<u64> {
        let entries = std::fs::read_dir(ledger.folder()).into_iter().flatten().flatten();
        let images = std::fs::read_dir(&ledger.images).into_iter().flatten().flatten();
        let names = entries.chain(images).map(|entry| entry.file_name().to_string_lossy().into_owned());
        let number = |name: String| {
            let stem = name.split_once('.')?.0;
            stem.parse::<u64>().ok().filter(|_| stem.len() >= 6)
        };
        names.filter_map(number).collect::<BTreeSet<_>>().into_iter().collect()
    };
    let made = MadeOf::read(&main);
    let there = numbers(&main);
    let job = made.map(|made| images_made_of(&made, &all[0], &there)).transpose()?.flatten();
    if let Some(mut job) = job {
        let n_frames = job.frames.len() + job.lacking.len();
        let lost = job.lacking.iter().map(|frame| (format!("frame {frame}"), Standing::Gone.to_string()));
        bad.extend(lost);
        bad.extend(not_done(images::standings(&mut job, 1)?));
        return Ok((n_frames, bad));
    }
    eprintln!(
        "note: data and metadata of these images are not there to be looked at; their shaders, scenes and textures are"
    );
    let mut hashes = Hashes::default();
    for images in all {
        let ledger = Ledger::of(&images);
        for file in ledger.files() {
            n += 1;
            let standing = ledger.standing(&file, None, &mut hashes);
            if standing != Standing::Done {
                bad.push((images.join(&file).display().to_string(), standing.to_string()));
            }
        }
    }
    Ok((n, bad))
}

/// What is said of frames in short.
pub fn describe(frames: &[u64]) -> String {
    let mut sorted = frames.to_vec();
    sorted.sort_unstable();
    list::describe(&sorted)
}
