//! The plan of a film, as it stands in `plan/plan.json` of its folder: what is simulated and drawn, and how it is cut into tasks.

use bind::binding::Quality;
use frame::{Fault, FaultKind};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Version of the format.
const VERSION: u32 = 1;

/// What runs the tasks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Scheduler {
    /// Slurm, by job arrays.
    Slurm,
    /// PBS Professional and OpenPBS, by array jobs.
    Pbs,
    /// Torque, by array jobs.
    Torque,
    /// Grid Engine (Sun, Univa, Altair), by array jobs.
    GridEngine,
    /// This machine, in processes of their own.
    Local,
}

/// What a job asks of its scheduler.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Requests {
    /// Tasks of an array that run at once; all if not given.
    pub max_running: Option<usize>,
    /// Time limit of a task, as the scheduler writes it.
    pub time: Option<String>,
    /// Memory of a task, as the scheduler writes it.
    pub mem: Option<String>,
    /// Processors of a task.
    pub cpus: Option<usize>,
    /// Graphics processors of a task.
    pub gpus: Option<usize>,
    /// Partition or queue.
    pub partition: Option<String>,
    /// Account or project.
    pub account: Option<String>,
    /// Further directives, a line each, without what they begin with.
    pub directives: Vec<String>,
    /// Whether tasks that are interrupted are queued again.
    pub requeue: bool,
    /// The user's own template of scripts.
    pub template: Option<PathBuf>,
}

/// Choices of the command line for the images.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ImageChoices {
    /// Width and height, pixels.
    pub res: Option<[u32; 2]>,
    /// Image quality.
    pub quality: Option<Quality>,
    /// Samples along each side of a pixel.
    pub samples: Option<u32>,
    /// Programs that scenes may run.
    pub allow_program: Vec<String>,
    /// Whether they may run any.
    pub allow_programs: bool,
    /// Seconds that they have for an answer.
    pub program_seconds: Option<u32>,
    /// Whether displays may be written outside of the folder.
    pub allow_outside: bool,
}

/// A simulation before the images.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Simulation {
    /// The model.
    pub model: PathBuf,
    /// Times up to which its jobs simulate, one after the other, s.
    pub until: Vec<f64>,
    /// Jobs for each of them, so that one that ends at its time limit is gone on with.
    pub chain: usize,
    /// Combinations of the model's sweep; 0 of a model without one.
    pub sweep: usize,
    /// Values in place of the model's: paths and YAML.
    #[serde(default)]
    pub set: Vec<(String, String)>,
}

/// The plan of a film.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// Version of the format.
    plan: u32,
    /// The folder that names of files start from.
    pub from: PathBuf,
    /// The model, metadata file or run directory.
    pub input: PathBuf,
    /// The folder of everything that is made.
    pub home: PathBuf,
    /// The simulation before the images, if there is one.
    pub simulation: Option<Simulation>,
    /// The frames to draw, in order.
    pub frames: Vec<u64>,
    /// Whether these were all frames that the data had.
    #[serde(default)]
    pub is_all: bool,
    /// Frames of a task.
    pub frames_per_task: usize,
    /// Tasks that each image is cut to.
    pub buckets: usize,
    /// Choices for the images.
    pub images: ImageChoices,
    /// Flags of every command: memory, threads, root.
    pub flags: Vec<String>,
    /// Whether a movie is made of the images.
    pub movie: bool,
    /// What runs the tasks.
    pub scheduler: Scheduler,
    /// Processes at once on this machine.
    pub processes: usize,
    /// What jobs ask for.
    pub requests: Requests,
}

/// A task of a plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Task {
    /// Simulate up to the time of this index.
    Simulate(usize),
    /// Simulate the combination of this index.
    Sweep(usize),
    /// Draw the images, or shards of images, of this index.
    Draw(usize),
    /// Join shards, check all images, and make the movie.
    Finish,
}

impl Task {
    /// The name of a task, as the command line has it.
    pub fn name(self) -> String {
        match self {
            Task::Simulate(i) => format!("simulate-{i}"),
            Task::Sweep(i) => format!("sweep-{i}"),
            Task::Draw(i) => format!("draw-{i}"),
            Task::Finish => "finish".into(),
        }
    }

    /// The task of a name.
    pub fn parse(name: &str) -> Option<Task> {
        if name == "finish" {
            return Some(Task::Finish);
        }
        let (kind, i) = name.rsplit_once('-')?;
        let i = i.parse().ok()?;
        match kind {
            "simulate" => Some(Task::Simulate(i)),
            "sweep" => Some(Task::Sweep(i)),
            "draw" => Some(Task::Draw(i)),
            _ => None,
        }
    }
}

impl Plan {
    /// A plan of the frames of an input, with its results in `home`, from the present working folder, to be run on this machine.
    pub fn new(input: &Path, home: &Path, frames: Vec<u64>) -> std::io::Result<Plan> {
        Ok(Plan {
            plan: VERSION,
            from: std::env::current_dir()?,
            input: std::path::absolute(input)?,
            home: std::path::absolute(home)?,
            simulation: None,
            frames,
            is_all: false,
            frames_per_task: 1,
            buckets: 1,
            images: ImageChoices::default(),
            flags: vec![],
            movie: true,
            scheduler: Scheduler::Local,
            processes: 1,
            requests: Requests::default(),
        })
    }

    /// The folder of the plan in that of the results: plan, scripts, logs.
    pub fn folder(home: &Path) -> PathBuf {
        home.join("plan")
    }

    /// Whether a folder has a plan.
    pub fn exists(home: &Path) -> bool {
        Plan::folder(home).join("plan.json").is_file()
    }

    /// Read the plan of a folder.
    pub fn read(home: &Path) -> Result<Plan, Fault> {
        let path = Plan::folder(home).join("plan.json");
        let text = frame::read_text(FaultKind::Data, &path)?;
        let bad = |why: String| Fault::whole(FaultKind::Data, &path, why).hint("submit the film again");
        let plan: Plan = serde_json::from_str(&text).map_err(|e| bad(format!("is not a plan: {e}")))?;
        let r = &plan.requests;
        let texts = [&r.time, &r.mem, &r.partition, &r.account].into_iter().flatten().chain(&r.directives);
        let is_plain = texts.chain(&plan.flags).all(|text| !text.contains(char::is_control));
        let is_sound = plan.plan == VERSION && plan.frames_per_task > 0 && plan.buckets > 0 && is_plain;
        // Work goes where the plan lies, not where a changed file says.
        let is_here = guard::is_one_of(home, [&plan.home]);
        match (is_sound, is_here) {
            (true, true) => Ok(plan),
            (false, _) => Err(bad("is of another version, or has tasks of nothing or texts of several lines".into())),
            (true, false) => Err(bad(format!(
                "is of another folder, {}: it was moved or copied; `scree verify` of its `images` still looks at these",
                plan.home.display()
            ))),
        }
    }

    /// Write the plan to its folder.
    pub fn write(&self) -> Result<(), Fault> {
        let text = serde_json::to_vec_pretty(self).unwrap_or_default();
        let path = Plan::folder(&self.home).join("plan.json");
        if std::fs::read(&path).is_ok_and(|there| there == text) { Ok(()) } else { frame::atomic::write(&path, &text) }
    }

    /// The folder of the images.
    pub fn images_folder(&self) -> PathBuf {
        self.home.join("images")
    }

    /// The flags of a task, which takes as many threads as it is given processors, if none are named.
    pub fn flags(&self, cpus: Option<usize>) -> Vec<String> {
        let is_set = self.flags.iter().any(|flag| flag.starts_with("--threads"));
        let threads = cpus.filter(|_| !is_set).map(|cpus| ["--threads".to_string(), cpus.to_string()]);
        self.flags.iter().cloned().chain(threads.into_iter().flatten()).collect()
    }

    /// Number of tasks that draw.
    pub fn n_tasks(&self) -> usize {
        self.frames.len().div_ceil(self.frames_per_task) * self.buckets
    }

    /// The frames of a task that draws.
    pub fn frames_of(&self, task: usize) -> &[u64] {
        let chunk = task / self.buckets;
        let first = (chunk * self.frames_per_task).min(self.frames.len());
        &self.frames[first..(first + self.frames_per_task).min(self.frames.len())]
    }

    /// The shard of a task that draws, from 1, if images are cut.
    pub fn shard_of(&self, task: usize) -> Option<usize> {
        (self.buckets > 1).then_some(task % self.buckets + 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tasks_are_chunks_of_frames_by_shards() {
        let mut plan = Plan::new(Path::new("a.yaml"), Path::new("runs/a"), (0..10).collect()).unwrap();
        (plan.frames_per_task, plan.buckets) = (4, 2);
        assert_eq!(plan.n_tasks(), 6);
        assert_eq!((plan.frames_of(0), plan.shard_of(0)), (&[0, 1, 2, 3][..], Some(1)));
        assert_eq!((plan.frames_of(5), plan.shard_of(5)), (&[8, 9][..], Some(2)));
        for task in [Task::Simulate(3), Task::Sweep(0), Task::Draw(12), Task::Finish] {
            assert_eq!(Task::parse(&task.name()), Some(task));
        }
        assert_eq!(Task::parse("draw"), None);
    }
}
