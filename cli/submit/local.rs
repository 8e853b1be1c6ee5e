//! The tasks of a film on this machine: processes of their own, some at once, each when those before it have ended well.

use crate::batch::{Job, Plan, Task};
use crate::interrupt::Listener;
use crate::progress::Progress;
use crate::report::{Exit, Failure, Outcome};
use std::fs::File;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

/// A task that runs.
struct Running {
    job: usize,
    task: Task,
    log: PathBuf,
    child: Child,
}

/// How far a job is.
struct Left {
    /// Tasks that have not begun, the next one last.
    waiting: Vec<Task>,
    /// Tasks that have not ended.
    open: usize,
    /// Whether a task has failed, or could not begin.
    failed: bool,
}

/// Run the tasks of jobs.
pub fn run(plan: &Plan, jobs: Vec<Job>) -> Outcome {
    let left =
        |job: &Job| Left { waiting: job.tasks.iter().rev().copied().collect(), open: job.tasks.len(), failed: false };
    let mut left: Vec<Left> = jobs.iter().map(left).collect();
    let n: usize = left.iter().map(|job| job.open).sum();
    let logs = Plan::folder(&plan.home).join("logs");
    std::fs::create_dir_all(&logs).map_err(|e| frame::Fault::unwritable(&logs, &e))?;
    let listener = Listener::new();
    let progress = Progress::start("film", n as u64, "tasks");
    let (mut running, mut failures): (Vec<Running>, Vec<String>) = (vec![], vec![]);
    loop {
        if listener.is_requested() {
            return Err(interrupt(running));
        }
        while running.len() < plan.processes
            && let Some((job, task)) = next(&jobs, &mut left)
        {
            let log = logs.join(format!("{}.log", task.name()));
            let child = start(plan, task, &log)?;
            running.push(Running { job, task, log, child });
        }
        if running.is_empty() {
            break;
        }
        std::thread::sleep(Duration::from_millis(5));
        running.retain_mut(|r| {
            let Ok(None) = r.child.try_wait() else {
                left[r.job].open -= 1;
                let status = r.child.try_wait().ok().flatten();
                if !status.is_some_and(|status| status.success()) {
                    left[r.job].failed = true;
                    // One with an exit code has said why it ends.
                    let is_told = status.is_some_and(|status| status.code().is_some());
                    let killed = || status.map_or("it was lost".into(), |status| format!("it was killed: {status}"));
                    let why = if is_told { last_line(&r.log) } else { killed() };
                    failures.push(format!("{}: {why} (see {})", r.task.name(), r.log.display()));
                }
                return false;
            };
            true
        });
        progress.at((n - left.iter().map(|job| job.open).sum::<usize>()) as u64);
    }
    progress.finish();
    let skipped: usize = left.iter().map(|job| job.waiting.len()).sum();
    outcome(plan, &failures, skipped)
}

/// The next task that may begin. What comes after a failure never does.
fn next(jobs: &[Job], left: &mut [Left]) -> Option<(usize, Task)> {
    for i in 0..jobs.len() {
        let before = &jobs[i].after;
        let is_blocked = before.iter().any(|b| left[*b].failed) && !jobs[i].is_after_any;
        left[i].failed |= is_blocked;
        if !is_blocked
            && before.iter().all(|b| left[*b].open == 0)
            && let Some(task) = left[i].waiting.pop()
        {
            return Some((i, task));
        }
    }
    None
}

fn start(plan: &Plan, task: Task, log: &std::path::Path) -> Outcome<Child> {
    let fault = |e: std::io::Error| Failure::new(Exit::Fault, format!("{}: {e}", log.display()));
    let file = File::create(log).map_err(fault)?;
    let program = std::env::current_exe().map_err(fault)?;
    let processors = std::thread::available_parallelism().map_or(1, |n| n.get());
    let share = (processors / plan.processes).max(1);
    let mut command = Command::new(program);
    command.arg("task").arg(&plan.home).arg(task.name()).args(plan.flags(Some(share))).stdin(Stdio::null());
    command.stdout(file.try_clone().map_err(fault)?).stderr(file);
    command.spawn().map_err(fault)
}

/// The last line of a log that says something.
fn last_line(log: &std::path::Path) -> String {
    let text = std::fs::read(log).map(|bytes| String::from_utf8_lossy(&bytes).into_owned()).unwrap_or_default();
    let line = text.lines().rev().find(|line| line.contains("error:")).or(text.lines().last());
    line.unwrap_or("it ended without a word").trim().trim_start_matches("error: ").into()
}

/// End the tasks that run, which leave whole files, and say so.
fn interrupt(running: Vec<Running>) -> Failure {
    for mut r in running {
        #[cfg(unix)]
        let _ = Command::new("kill").args(["-TERM", &r.child.id().to_string()]).status();
        #[cfg(not(unix))]
        let _ = r.child.kill();
        let _ = r.child.wait();
    }
    Failure::new(Exit::Interrupted, "interrupted: what is done stays, and `scree resume` goes on")
}

fn outcome(plan: &Plan, failures: &[String], skipped: usize) -> Outcome {
    /// Failures that are printed.
    const PRINTED: usize = 10;
    if failures.is_empty() {
        println!("{}", plan.home.display());
        return Ok(());
    }
    failures.iter().take(PRINTED).for_each(|failure| eprintln!("error: {failure}"));
    let after = if skipped > 0 { format!(", and {skipped} after them did not begin") } else { String::new() };
    let n = failures.len();
    let tasks = if n == 1 { "task" } else { "tasks" };
    let message = format!("{n} {tasks} failed{after}; `scree resume {}` goes on", plan.home.display());
    Err(Failure::new(Exit::Partial, message))
}
