//! The jobs of `scree plan`, `submit`, `status`, `verify`, `resume` and `task`: films that are cut into tasks.

use super::frames::{FramesJob, Origin};
use super::images::{ImageJob, ImageOptions};
use super::output::default_folder;
use super::run_folder::{self, spare_link};
use super::simulate::{SimulateJob, replacements};
use super::sweep;
use crate::args::{
    Assignment, Backend, CutArgs, ImageArgs, PlanArgs, QualityChoice, ResumeArgs, SchedulerArg, SimulateArgs,
    StatusArgs, SubmitArgs, TaskArgs, VerifyArgs,
};
use crate::batch::{ImageChoices, MadeOf, Plan, Requests, Scheduler, Simulation, Task};
use crate::library;
use crate::report::{Exit, Failure, Outcome};
use crate::source::{self, Yaml};
use bind::data::{Source, Store};
use bind::{Binding, emit};
use frame::list::{self, FrameList};
use frame::run::RunReader;
use sim::model_file::{self, Replacement};
use sim::run;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// A film to cut into tasks.
pub struct FilmJob {
    /// Its plan.
    pub plan: Plan,
    /// Whether scripts are printed, and nothing is written.
    pub dry_run: bool,
}

/// A film to look over before it is made.
pub struct PlanJob {
    /// Its plan.
    pub plan: Plan,
    /// Whether a few frames are drawn to measure the time.
    pub samples: bool,
    /// Whether JSON is printed.
    pub json: bool,
}

/// A film, or a folder of images, to say of how far it is.
pub struct StatusJob {
    /// The folder.
    pub folder: PathBuf,
    /// Whether it is said again and again.
    pub watch: bool,
    /// Whether JSON is printed.
    pub json: bool,
}

/// A task of a film.
pub struct TaskJob {
    /// The film's plan.
    pub plan: Plan,
    /// The task.
    pub task: Task,
}

impl FilmJob {
    /// Check the arguments of `scree submit`.
    pub fn check(args: SubmitArgs) -> Outcome<FilmJob> {
        let home = home(&args.input, args.output);
        let mut plan = plan(&args.input, &home, args.image, &args.cut)?;
        if let Some(other) = Plan::read(&home).ok().filter(|there| there.input != plan.input) {
            let message = format!(
                "{} holds the film of {}: give another folder, -o DIR (--output)",
                home.display(),
                other.input.display()
            );
            return Err(Failure::new(Exit::Usage, message));
        }
        plan.movie = !args.no_movie;
        (plan.scheduler, plan.processes) = (args.scheduler.into(), args.processes);
        let template = args.template.map(|path| std::path::absolute(&path).unwrap_or(path));
        plan.requests = Requests {
            max_running: args.max_running,
            time: args.time,
            mem: args.mem,
            cpus: args.cpus,
            gpus: args.gpus,
            partition: args.partition,
            account: args.account,
            directives: args.directive,
            requeue: args.requeue,
            template,
        };
        if plan.scheduler == Scheduler::Local && plan.requests != Requests::default() {
            let message = "--scheduler local runs the tasks on this machine: it takes no requests to a scheduler";
            return Err(Failure::new(Exit::Usage, message));
        }
        Ok(FilmJob { plan, dry_run: args.dry_run })
    }

    /// Check the arguments of `scree resume`.
    pub fn resume(args: ResumeArgs) -> Outcome<FilmJob> {
        let plan = read(&args.folder)?;
        let programs = &plan.images.allow_program;
        let trusts = match (&plan.requests.template, plan.images.allow_programs, programs.is_empty()) {
            (Some(path), ..) => Some(format!("has job scripts made by {}", path.display())),
            (None, true, _) => Some("lets scenes run any program".into()),
            (None, false, false) => Some(format!("lets scenes run {}", programs.join(", "))),
            (None, false, true) => None,
        };
        if let Some(what) = trusts.filter(|_| !args.trust) {
            let message = format!("the plan of {} {what}: --trust says that it is yours", args.folder.display());
            return Err(Failure::new(Exit::Usage, message));
        }
        Ok(FilmJob { plan, dry_run: args.dry_run })
    }
}

impl PlanJob {
    /// Check the arguments.
    pub fn check(args: PlanArgs) -> Outcome<PlanJob> {
        let home = home(&args.input, args.output);
        let plan = plan(&args.input, &home, args.image, &args.cut)?;
        Ok(PlanJob { plan, samples: !args.no_samples, json: args.json })
    }
}

impl StatusJob {
    /// Check the arguments of `scree status`.
    pub fn check(args: StatusArgs) -> Outcome<StatusJob> {
        Ok(StatusJob { folder: args.folder, watch: args.watch, json: args.json })
    }

    /// Check the arguments of `scree verify`.
    pub fn verify(args: VerifyArgs) -> Outcome<StatusJob> {
        Ok(StatusJob { folder: args.folder, watch: false, json: args.json })
    }
}

impl TaskJob {
    /// Check the arguments.
    pub fn check(args: TaskArgs) -> Outcome<TaskJob> {
        let plan = read(&args.folder)?;
        let most = |task: &Task| match task {
            Task::Draw(_) => plan.n_tasks(),
            Task::Simulate(_) => plan.simulation.as_ref().map_or(0, |s| s.until.len()),
            Task::Sweep(_) => plan.simulation.as_ref().map_or(0, |s| s.sweep),
            Task::Finish => 1,
        };
        let index = |task: &Task| match task {
            Task::Draw(i) | Task::Simulate(i) | Task::Sweep(i) => *i,
            Task::Finish => 0,
        };
        let task = Task::parse(&args.task).filter(|task| index(task) < most(task));
        let unknown = || Failure::new(Exit::Usage, format!("{} is no task of the plan", args.task));
        Ok(TaskJob { task: task.ok_or_else(unknown)?, plan })
    }
}

impl From<SchedulerArg> for Scheduler {
    fn from(scheduler: SchedulerArg) -> Scheduler {
        match scheduler {
            SchedulerArg::Slurm => Scheduler::Slurm,
            SchedulerArg::Pbs => Scheduler::Pbs,
            SchedulerArg::Torque => Scheduler::Torque,
            SchedulerArg::GridEngine => Scheduler::GridEngine,
            SchedulerArg::Local => Scheduler::Local,
        }
    }
}

/// The simulation of a combination of a sweep, from where it has got to.
pub fn combination(simulation: &Simulation, home: &Path, index: usize) -> Outcome<SimulateJob> {
    let of_plan = |(path, value): &(String, String)| Assignment { path: path.clone(), value: value.clone() };
    SimulateJob::check(SimulateArgs {
        quality: None,
        model: simulation.model.clone(),
        output: Some(home.into()),
        until: None,
        resume: true,
        fresh: false,
        set: simulation.set.iter().map(of_plan).collect(),
        sweep_index: Some(index),
        plan: false,
        backend: Backend::Auto,
        gpu_from: None,
        adapter: None,
        csv: false,
        preview: false,
    })
}

/// The combinations of a sweep whose runs in a folder are not finished.
pub fn open_combinations(simulation: &Simulation, home: &Path) -> Outcome<Vec<usize>> {
    let set = replacements(simulation.set.iter().map(|(path, value)| (path, value)));
    let (file, doc) = model_file::load(&simulation.model, &set)?;
    sweep::unfinished(&file, &doc, &set, home)
}

/// The plan of a folder, whose tasks start where it was made.
fn read(folder: &Path) -> Outcome<Plan> {
    if !Plan::exists(folder) {
        let message = format!("{} has no plan: `scree submit` makes one", folder.display());
        return Err(Failure::new(Exit::Usage, message));
    }
    let plan = Plan::read(folder)?;
    std::env::set_current_dir(&plan.from)
        .map_err(|e| Failure::new(Exit::Fault, format!("{}: {e}", plan.from.display())))?;
    Ok(plan)
}

/// The folder of a film's results.
fn home(input: &Path, output: Option<PathBuf>) -> PathBuf {
    output.unwrap_or_else(|| if input.is_dir() { input.into() } else { default_folder(input) })
}

/// Cut a film into tasks.
fn plan(input: &Path, home: &Path, image: ImageArgs, cut: &CutArgs) -> Outcome<Plan> {
    let frames = image.frames.clone();
    let options = ImageOptions::check(image, false)?;
    if !options.allow_outside {
        spare_link(&home.join("images"), home)?;
    }
    spare_link(&Plan::folder(home), home)?;
    let fault = |e: std::io::Error| Failure::new(Exit::Fault, e.to_string());
    let mut plan = Plan::new(input, home, vec![]).map_err(fault)?;
    (plan.images, plan.buckets, plan.frames_per_task) = (options.choices.clone(), cut.buckets, cut.frames_per_task);
    plan.flags = flags();
    let set = replacements(cut.set.iter().map(|a| (&a.path, &a.value)));
    if let Some((model, binding)) = unfinished(input, home, &set)? {
        simulation(&mut plan, &model, binding.as_ref(), frames, cut)?;
        return Ok(plan);
    }
    if cut.segments > 1 || cut.chain > 1 || !set.is_empty() {
        let message = "--segments, --chain and --set are of a simulation, and there is none to run: its data is there";
        return Err(Failure::new(Exit::Usage, message));
    }
    let (binding, source) = data_of(&plan)?;
    let job = ImageJob::resolve(binding, source, plan.images_folder(), &options)?;
    (plan.frames, plan.is_all) = (job.frames, job.is_all);
    Ok(plan)
}

/// The flags of every command that tasks are given, too.
fn flags() -> Vec<String> {
    let given: Vec<String> = std::env::args().collect();
    let mut flags = vec![];
    for (i, word) in given.iter().enumerate() {
        for name in ["--threads", "--memory", "--root"] {
            if word == name {
                flags.extend(given[i..].iter().take(2).cloned());
            } else if word.starts_with(&format!("{name}=")) {
                flags.push(word.clone());
            }
        }
    }
    flags
}

/// The model that must be simulated first, and the metadata that names it, if there is one.
fn unfinished(input: &Path, home: &Path, set: &[Replacement]) -> Outcome<Option<(PathBuf, Option<Binding>)>> {
    if input.is_dir() || !input.exists() {
        return Ok(None);
    }
    let (model, binding) = match source::kind_of(input)? {
        Yaml::Model => (input.to_path_buf(), None),
        Yaml::Metadata => {
            let binding = bind::read(input)?;
            match &binding.model {
                Some(model) if binding.data.is_none() => (binding.folder().join(model), Some(binding)),
                _ => return Ok(None),
            }
        }
    };
    if !model.is_file() {
        let message = format!("the model {} does not exist", model.display());
        return Err(Failure::new(Exit::Input, message));
    }
    let (file, doc) = model_file::load(&model, set)?;
    file.resolve(&doc)?;
    // Of a model with other values, what is drawn is told by the run alone.
    let is_done = set.is_empty() && file.sweep.is_empty() && run::is_done(&file, home);
    Ok((!is_done).then_some((model, binding)))
}

/// Plan the simulation of a model, and the frames that it will have.
fn simulation(
    plan: &mut Plan,
    model: &Path,
    binding: Option<&Binding>,
    frames: Option<FrameList>,
    cut: &CutArgs,
) -> Outcome {
    let set = replacements(cut.set.iter().map(|a| (&a.path, &a.value)));
    let (file, doc) = model_file::load(model, &set)?;
    let model = std::path::absolute(model).unwrap_or_else(|_| model.into());
    run_folder::spare_linked(&plan.home, &plan.home)?;
    let of_plan = |r: &Replacement| (r.path.clone(), r.value.clone());
    let mut simulation =
        Simulation { model, until: vec![], chain: cut.chain, sweep: 0, set: set.iter().map(of_plan).collect() };
    if !file.sweep.is_empty() {
        simulation.sweep = sweep::check(&file, &doc, &set)?;
        if cut.segments > 1 || cut.chain > 1 {
            let message = "--segments and --chain are of a single run: of a sweep, each combination is a task, which goes on from its checkpoint when it is submitted again";
            return Err(Failure::new(Exit::Usage, message));
        }
        plan.simulation = Some(simulation);
        return Ok(());
    }
    run_folder::spare_model(&simulation.model, &file, &plan.home)?;
    run_folder::check(&file, &plan.home, None, "scree simulate")?;
    if let Some(binding) = binding {
        source::check_library(binding)?;
    }
    let all: Vec<u64> = (0..run::n_frames(file.whole_duration(), file.frame_rate)).collect();
    let of_file = binding.and_then(|b| b.output.frames.as_ref()?.parse::<FrameList>().ok());
    plan.frames = match frames.or(of_file) {
        Some(list) => list.select(&all).map_err(|m| Failure::new(Exit::Usage, format!("--frames: {m}")))?,
        None => all,
    };
    // Each segment knows the frames up to its own end alone.
    let is_settled = binding.is_some_and(|binding| {
        !binding.is_open() && emit::open_keys(binding, &binding.files(library::files(&binding.folder()))).is_empty()
    });
    if cut.segments > 1 && !is_settled {
        let message = "--segments: images can be drawn before the simulation has ended only by a metadata file whose colours \
                       have a `range`, its arrows a `scale`, its output `levels`, whose camera has neither `turns` nor `damping`, and whose overlays have no `plot`: these are found from the whole run otherwise";
        return Err(Failure::new(Exit::Usage, message));
    }
    let n_chunks = plan.frames.len().div_ceil(plan.frames_per_task);
    let per_segment = n_chunks.div_ceil(cut.segments.min(n_chunks));
    let n_segments = n_chunks.div_ceil(per_segment);
    let per_segment = n_chunks.div_ceil(n_segments);
    simulation.until = (1..n_segments)
        .map(|s| plan.frames[..(s * per_segment * plan.frames_per_task)].iter().max())
        // A run has the frames before its end: the last one of a segment, too.
        .map(|last| (*last.expect("a segment has frames") as f64 + 0.5) / file.frame_rate)
        .chain([file.whole_duration()])
        .collect();
    plan.simulation = Some(simulation);
    Ok(())
}

/// The images of a plan, of the frames that are there; the others are those that the job lacks.
pub fn images_of(plan: &Plan, frames: &[u64]) -> Outcome<ImageJob> {
    let data = data_of(plan)?;
    images_of_data(data, plan.images_folder(), &plan.images, frames)
}

/// The images of a folder by what its ledger says that they were made of: of the frames that it says, of some more, and of all that the
/// data has now where it was made of all; none if that is not known, or is a model that must be simulated first. No programs are run
/// for it.
pub fn images_made_of(made: &MadeOf, folder: &Path, more: &[u64]) -> Outcome<Option<ImageJob>> {
    if !made.input().exists() {
        return Ok(None);
    }
    let FramesJob { binding, origin, .. } = match made.input().is_dir() {
        true => FramesJob::open(made.input())?,
        false => FramesJob::of_yaml(made.input(), made.home().into(), false)?,
    };
    let source = match origin {
        Origin::Data(source) => *source,
        Origin::Finished(run) => Store::Run(*run).into(),
        Origin::Model(_) => return Ok(None),
    };
    let (binding, source) = match binding {
        Some(binding) => (binding, source),
        None => source::metadata_of_run(made.home())?,
    };
    let choices = ImageChoices { allow_program: vec![], allow_programs: false, ..made.images.clone() };
    let now = if made.is_all { source.numbers() } else { vec![] };
    let frames: BTreeSet<u64> = made.frames().chain(more.iter().copied()).chain(now).collect();
    let frames: Vec<u64> = frames.into_iter().collect();
    images_of_data((binding, source), folder.into(), &choices, &frames).map(Some)
}

fn images_of_data(
    (binding, source): (Binding, Source),
    folder: PathBuf,
    choices: &ImageChoices,
    frames: &[u64],
) -> Outcome<ImageJob> {
    let existing: BTreeSet<u64> = source.numbers().into_iter().collect();
    let (there, lacking): (Vec<u64>, Vec<u64>) = frames.iter().partition(|frame| existing.contains(frame));
    if there.is_empty() && !lacking.is_empty() {
        let message = format!("the data has none of the frames of the film ({})", list::describe(&lacking));
        return Err(Failure::new(Exit::Data, message));
    }
    let frames = there.iter().map(u64::to_string).collect::<Vec<_>>().join(",");
    let args = ImageArgs {
        frames: frames.parse().ok(),
        res: choices.res,
        image_quality: choices.quality.map(QualityChoice::from),
        samples: choices.samples,
        allow_program: choices.allow_program.clone(),
        allow_programs: choices.allow_programs,
        program_seconds: choices.program_seconds,
        allow_outside: choices.allow_outside,
    };
    let mut job = ImageJob::resolve(binding, source, folder, &ImageOptions::check(args, false)?)?;
    job.lacking = lacking;
    Ok(job)
}

/// The metadata and the data of a plan.
fn data_of(plan: &Plan) -> Outcome<(Binding, Source)> {
    if plan.simulation.is_none() {
        return data_without_simulation(plan);
    }
    match source::kind_of(&plan.input)? {
        Yaml::Model => source::metadata_of_run(&plan.home),
        Yaml::Metadata => Ok((bind::read(&plan.input)?, Store::Run(RunReader::open(&plan.home)?).into())),
    }
}

fn data_without_simulation(plan: &Plan) -> Outcome<(Binding, Source)> {
    let is_folder = plan.input.is_dir() || !plan.input.exists();
    let FramesJob { binding, origin, .. } = if is_folder {
        FramesJob::open(&plan.input)?
    } else {
        FramesJob::of_yaml(&plan.input, plan.home.clone(), false)?
    };
    let source = match origin {
        Origin::Data(source) => *source,
        Origin::Finished(run) => Store::Run(*run).into(),
        Origin::Model(_) => {
            let message = "the model has changed since the film was submitted: submit it again";
            return Err(Failure::new(Exit::Usage, message));
        }
    };
    match binding {
        Some(binding) => Ok((binding, source)),
        None => source::metadata_of_run(&plan.home),
    }
}
