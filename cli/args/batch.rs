//! Arguments of the commands that cut films into tasks: `submit`, `plan`, `status`, `verify`, `resume`.

use super::image::ImageArgs;
use super::value::{Assignment, assignment, one_line, whole, word};
use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// What runs the tasks of a film.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
#[value(rename_all = "lowercase")]
pub enum SchedulerArg {
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

/// How a film is cut into tasks.
#[derive(Args, Debug)]
pub struct CutArgs {
    /// Frames of a task.
    #[arg(long, default_value_t = 1, value_name = "K", value_parser = whole::<usize>(1..=1_000_000))]
    pub frames_per_task: usize,
    /// Tasks that each image is cut to, which are joined at the end.
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = whole::<usize>(1..=10_000))]
    pub buckets: usize,
    /// Parts of the simulation: the images of a part are drawn while the next
    /// is simulated (of a metadata file whose colours have ranges).
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = whole::<usize>(1..=1000))]
    pub segments: usize,
    /// Jobs for each part of the simulation, one after the other, so that one
    /// that ends at its time limit is gone on with from its checkpoint.
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = whole::<usize>(1..=1000))]
    pub chain: usize,
    /// Replace a value of the model, as `scree simulate` does; may be repeated.
    #[arg(long = "set", value_name = "PATH=VALUE", value_parser = assignment)]
    pub set: Vec<Assignment>,
}

const PLAN_EXAMPLES: &str = "\
Examples:
  scree plan metadata.yaml
  scree plan runs/pour --frames-per-task 10 -f 0-999";

/// Arguments of `scree plan`.
#[derive(Args, Debug)]
#[command(after_help = PLAN_EXAMPLES)]
pub struct PlanArgs {
    /// Run directory, metadata file or model (YAML).
    #[arg(value_name = "INPUT")]
    pub input: PathBuf,
    /// Folder of the results [default: as `scree submit` has it].
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub image: ImageArgs,
    #[command(flatten)]
    pub cut: CutArgs,
    /// Draw no frames for an estimate of the time.
    #[arg(long)]
    pub no_samples: bool,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
}

const SUBMIT_EXAMPLES: &str = "\
Examples:
  scree submit metadata.yaml --scheduler local --processes 2
  scree submit runs/pour --scheduler slurm --frames-per-task 5 --time 1:00:00
  scree submit runs/pour --scheduler slurm --dry-run";

/// Arguments of `scree submit`.
#[derive(Args, Debug)]
#[command(after_help = SUBMIT_EXAMPLES)]
pub struct SubmitArgs {
    /// Run directory, metadata file or model (YAML).
    #[arg(value_name = "INPUT")]
    pub input: PathBuf,
    /// Folder of the results: run, images/, plan/, the movie [default: the run
    /// directory; runs/NAME for NAME.yaml].
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// What runs the tasks.
    #[arg(long, value_name = "NAME", value_enum)]
    pub scheduler: SchedulerArg,
    #[command(flatten)]
    pub image: ImageArgs,
    #[command(flatten)]
    pub cut: CutArgs,
    /// Make no movie.
    #[arg(long)]
    pub no_movie: bool,
    /// Processes at once, with --scheduler local.
    #[arg(short = 'j', long, default_value_t = 1, value_name = "N", value_parser = whole::<usize>(1..=1024))]
    pub processes: usize,
    /// Tasks of an array that run at once [default: all].
    #[arg(long, value_name = "K", value_parser = whole::<usize>(1..=1_000_000))]
    pub max_running: Option<usize>,
    /// Time limit of a task, as the scheduler writes it: 1:00:00.
    #[arg(long, value_name = "TIME", value_parser = word)]
    pub time: Option<String>,
    /// Memory of a task, as the scheduler writes it: 8G.
    #[arg(long, value_name = "SIZE", value_parser = word)]
    pub mem: Option<String>,
    /// Processors of a task [default: the scheduler's].
    #[arg(long, value_name = "N", value_parser = whole::<usize>(1..=1024))]
    pub cpus: Option<usize>,
    /// Graphics processors of a task [default: none].
    #[arg(long, value_name = "N", value_parser = whole::<usize>(1..=64))]
    pub gpus: Option<usize>,
    /// Partition or queue.
    #[arg(long, value_name = "NAME", value_parser = word)]
    pub partition: Option<String>,
    /// Account or project that pays.
    #[arg(long, value_name = "NAME", value_parser = word)]
    pub account: Option<String>,
    /// A further directive, as --directive='--constraint=avx2'; may be given
    /// several times.
    #[arg(long, value_name = "TEXT", value_parser = one_line)]
    pub directive: Vec<String>,
    /// Queue tasks again that are interrupted, at their time limit too.
    #[arg(long)]
    pub requeue: bool,
    /// Template of the job scripts (minijinja), in place of the scheduler's.
    #[arg(long, value_name = "FILE")]
    pub template: Option<PathBuf>,
    /// Print the scripts, write and submit nothing.
    #[arg(long)]
    pub dry_run: bool,
}

/// Arguments of `scree status`.
#[derive(Args, Debug)]
pub struct StatusArgs {
    /// Folder that a film was submitted to, or a folder of images.
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// Print it again every two seconds until all is done, or nobody works on
    /// what is left.
    #[arg(long, conflicts_with = "json")]
    pub watch: bool,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `scree verify`.
#[derive(Args, Debug)]
pub struct VerifyArgs {
    /// Folder that a film was submitted to, or a folder of images.
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `scree resume`.
#[derive(Args, Debug)]
pub struct ResumeArgs {
    /// Folder that a film was submitted to.
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// Use the plan's own permission to run programs, or its template of
    /// scripts: it is a plan of yours.
    #[arg(long)]
    pub trust: bool,
    /// Print the scripts, write and submit nothing.
    #[arg(long)]
    pub dry_run: bool,
}

/// Arguments of `scree task`.
#[derive(Args, Debug)]
pub struct TaskArgs {
    /// Folder that the film was submitted to.
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// The task: simulate-I, sweep-I, draw-I or finish.
    #[arg(value_name = "TASK")]
    pub task: String,
}
