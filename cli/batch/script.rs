//! The scripts of jobs: which jobs a plan needs, in which order, and what stands in the script of each.

use super::plan::{Plan, Scheduler, Simulation, Task};
use crate::report::{Exit, Failure, Outcome};
use guard::text::{sbatch, shell};
use minijinja::{Environment, context};
use std::path::Path;

/// A job of a scheduler: one task, or an array of them.
pub struct Job {
    /// Its name, and that of its script.
    pub name: String,
    /// Its tasks.
    pub tasks: Vec<Task>,
    /// Indices of the jobs that it comes after.
    pub after: Vec<usize>,
    /// Whether these may have failed.
    pub is_after_any: bool,
    /// The script.
    pub script: String,
}

/// What is left to do of a plan.
pub struct Needed {
    /// Whether its model is simulated.
    pub simulate: bool,
    /// The combinations of its sweep that are.
    pub sweep: Vec<usize>,
    /// The tasks that draw.
    pub draw: Vec<usize>,
    /// Whether shards are joined, images checked, and the movie made.
    pub finish: bool,
}

/// The jobs that do what is left of a plan. An array has no index at or above `most`.
pub fn jobs(plan: &Plan, needed: &Needed, most: usize) -> Outcome<Vec<Job>> {
    let mut jobs: Vec<Job> = vec![];
    let mut simulated: Vec<usize> = vec![];
    if let Some(simulation) = plan.simulation.as_ref().filter(|_| needed.simulate) {
        simulated = simulate(plan, (simulation, &needed.sweep), most, &mut jobs)?;
    }
    let mut parts = vec![];
    for (segment, tasks) in by_segment(plan, &needed.draw, simulated.len()) {
        let after: Vec<usize> = segment.map(|s| simulated[s]).into_iter().collect();
        parts.extend(arrays(plan.scheduler, &tasks, most).into_iter().map(|part| (after.clone(), part)));
    }
    let (sharing, n_at_once) = sharing(plan, parts.len());
    let mut drawn = vec![];
    for (after, part) in parts {
        let name = format!("draw-{}", drawn.len());
        // Of arrays that may not all run at once, each waits for an earlier one, which waits for the simulation.
        let before = drawn.len().checked_sub(n_at_once).map(|k| drawn[k]);
        drawn.push(jobs.len());
        let tasks = part.into_iter().map(Task::Draw).collect();
        let after = before.map_or(after, |before| vec![before]);
        jobs.push(job(&sharing, name, tasks, after, before.is_some(), most)?);
    }
    if needed.finish {
        // What is drawn already needs no job; the end comes after the simulation then.
        let after = if drawn.is_empty() { simulated } else { drawn };
        jobs.push(job(plan, "finish".into(), vec![Task::Finish], after, false, most)?);
    }
    Ok(jobs)
}

/// A plan whose tasks that run at once are shared by arrays, and how many of these run at once.
fn sharing(plan: &Plan, n_arrays: usize) -> (Plan, usize) {
    let mut plan = plan.clone();
    let n_at_once = plan.requests.max_running.map_or(n_arrays, |most| n_arrays.min(most)).max(1);
    plan.requests.max_running = plan.requests.max_running.map(|most| most / n_at_once);
    (plan, n_at_once)
}

/// The jobs of a simulation, or of combinations of a sweep; the indices of those after which its frames are there, one for each time.
fn simulate(
    plan: &Plan,
    (simulation, sweep): (&Simulation, &[usize]),
    most: usize,
    jobs: &mut Vec<Job>,
) -> Outcome<Vec<usize>> {
    if simulation.sweep > 0 {
        let parts = arrays(plan.scheduler, sweep, most);
        let (sharing, n_at_once) = sharing(plan, parts.len());
        for (k, part) in parts.into_iter().enumerate() {
            let tasks = part.into_iter().map(Task::Sweep).collect();
            let before: Vec<usize> = k.checked_sub(n_at_once).into_iter().collect();
            let is_after_any = !before.is_empty();
            jobs.push(job(&sharing, format!("sweep-{k}"), tasks, before, is_after_any, most)?);
        }
        return Ok(vec![]);
    }
    let mut ends = vec![];
    for i in 0..simulation.until.len() {
        for link in 0..simulation.chain {
            let after = jobs.len().checked_sub(1).into_iter().collect();
            let name = if simulation.chain > 1 { format!("simulate-{i}-{link}") } else { format!("simulate-{i}") };
            jobs.push(job(plan, name, vec![Task::Simulate(i)], after, link > 0, most)?);
        }
        ends.push(jobs.len() - 1);
    }
    Ok(ends)
}

/// Tasks that draw, by the part of the simulation that makes their last frame.
fn by_segment(plan: &Plan, draw: &[usize], n_segments: usize) -> Vec<(Option<usize>, Vec<usize>)> {
    if n_segments == 0 {
        return vec![(None, draw.to_vec())];
    }
    let per_segment = plan.n_tasks().div_ceil(n_segments * plan.buckets) * plan.buckets;
    let mut found: Vec<(Option<usize>, Vec<usize>)> = (0..n_segments).map(|s| (Some(s), vec![])).collect();
    draw.iter().for_each(|task| found[(task / per_segment.max(1)).min(n_segments - 1)].1.push(*task));
    found.retain(|(_, tasks)| !tasks.is_empty());
    found
}

/// Tasks as arrays: none reaches `most` indices, and where a scheduler knows ranges alone, none has a gap.
fn arrays(scheduler: Scheduler, tasks: &[usize], most: usize) -> Vec<Vec<usize>> {
    let lists = matches!(scheduler, Scheduler::Slurm | Scheduler::Torque);
    let goes_on = |a: &usize, b: &usize| a / most == b / most && (lists || a + 1 == *b);
    tasks.chunk_by(goes_on).map(<[usize]>::to_vec).collect()
}

/// Indices as ranges, `0-3,7`.
fn ranges(indices: &[usize]) -> String {
    let part = |run: &[usize]| match run {
        [one] => one.to_string(),
        _ => format!("{}-{}", run[0], run[run.len() - 1]),
    };
    indices.chunk_by(|a, b| a + 1 == *b).map(part).collect::<Vec<_>>().join(",")
}

/// A job with its script.
fn job(
    plan: &Plan,
    name: String,
    tasks: Vec<Task>,
    after: Vec<usize>,
    is_after_any: bool,
    most: usize,
) -> Outcome<Job> {
    let script = script(plan, &name, &tasks, most)?;
    Ok(Job { name, tasks, after, is_after_any, script })
}

fn script(plan: &Plan, name: &str, tasks: &[Task], most: usize) -> Outcome<String> {
    let indices: Vec<usize> = tasks
        .iter()
        .map(|task| match task {
            Task::Simulate(i) | Task::Sweep(i) | Task::Draw(i) => *i,
            Task::Finish => 0,
        })
        .collect();
    let offset = indices.first().map_or(0, |i| i / most * most);
    let is_array = tasks.len() > 1;
    let own: Vec<usize> = indices.iter().map(|i| i - offset).collect();
    let requests = &plan.requests;
    let program = std::env::current_exe().map(|path| path.display().to_string()).unwrap_or("scree".into());
    let kind = tasks[0].name();
    let (task, setup) = if is_array {
        (format!("\"{}-$index\"", kind.rsplit_once('-').map_or("", |(kind, _)| kind)), index(plan.scheduler, offset))
    } else {
        (kind, String::new())
    };
    let flags: String = plan.flags(requests.cpus).iter().map(|flag| format!(" {}", shell(flag))).collect();
    let home = shell(&plan.home.display().to_string());
    let command = format!("{} task {home} {task}{flags}", shell(&program));
    let logs = Plan::folder(&plan.home).join("logs");
    let (log, redirect) = log(plan.scheduler, &logs, name, is_array);
    let label = format!("scree-{}-{name}", guard::text::file_name(&label(&plan.home), ".-"));
    let (source, path) = template(plan)?;
    let shell_folder = shell(&plan.from.display().to_string());
    let values = context! {
        name => label, scheduler => plan.scheduler, array => is_array.then(|| ranges(&own)),
        first => own.first(), last => own.last(), max_running => requests.max_running, log, time => requests.time,
        mem => requests.mem, cpus => requests.cpus, gpus => requests.gpus, partition => requests.partition,
        account => requests.account, directives => requests.directives, requeue => requests.requeue,
        folder => shell_folder, redirect, setup, command,
    };
    let mut environment = Environment::new();
    environment.set_trim_blocks(true);
    environment.set_lstrip_blocks(true);
    environment.set_undefined_behavior(minijinja::UndefinedBehavior::Strict);
    let text = environment.render_named_str(&path, &source, values);
    text.map(|text| text.trim_end().to_string() + "\n").map_err(|e| Failure::new(Exit::Input, format!("{path}: {e:#}")))
}

fn label(home: &Path) -> String {
    home.file_name().map_or("film".into(), |name| name.to_string_lossy().into_owned())
}

/// The template, and its name: the user's, or that of the scheduler.
fn template(plan: &Plan) -> Outcome<(String, String)> {
    if let Some(path) = &plan.requests.template {
        let text = frame::read_text(frame::FaultKind::Input, path)?;
        if !text.contains("command") {
            let message = format!("{}: has no `{{{{ command }}}}`, which runs a task", path.display());
            return Err(Failure::new(Exit::Input, message));
        }
        return Ok((text, path.display().to_string()));
    }
    let (text, name) = match plan.scheduler {
        Scheduler::Slurm => (include_str!("templates/slurm.sh"), "slurm.sh"),
        Scheduler::Pbs => (include_str!("templates/pbs.sh"), "pbs.sh"),
        Scheduler::Torque => (include_str!("templates/torque.sh"), "torque.sh"),
        Scheduler::GridEngine => (include_str!("templates/gridengine.sh"), "gridengine.sh"),
        Scheduler::Local => ("{{ command }}", "local"),
    };
    Ok((text.trim_end().into(), name.into()))
}

/// The line that sets `index` to a task's index.
fn index(scheduler: Scheduler, offset: usize) -> String {
    let (variable, first) = match scheduler {
        Scheduler::Slurm => ("SLURM_ARRAY_TASK_ID", 0),
        Scheduler::Pbs => ("PBS_ARRAY_INDEX", 0),
        Scheduler::Torque => ("PBS_ARRAYID", 0),
        Scheduler::GridEngine => ("SGE_TASK_ID", 1),
        Scheduler::Local => return String::new(),
    };
    match (offset, first) {
        (0, 0) => format!("index=${variable}"),
        (offset, 0) => format!("index=$(({variable} + {offset}))"),
        (offset, first) if offset < first => format!("index=$(({variable} - {}))", first - offset),
        (offset, first) => format!("index=$(({variable} + {}))", offset - first),
    }
}

/// Where the output of a job's tasks goes: as the scheduler writes it, and the line of the script that sends it there where its directives
/// cannot name the place.
fn log(scheduler: Scheduler, logs: &Path, name: &str, is_array: bool) -> (String, String) {
    let start = logs.join(name).display().to_string();
    let (log, id) = match scheduler {
        Scheduler::Local => return (start, String::new()),
        Scheduler::Slurm => {
            // A backslash takes the meaning from its patterns.
            let pattern = if is_array { "-%A_%a.log" } else { "-%j.log" };
            (sbatch(&start, pattern).filter(|_| !start.contains('\\')), "$SLURM_JOB_ID")
        }
        // The others have no quotes in directives.
        _ if start.contains(|c: char| c.is_whitespace() || c.is_control() || "\"'$`\\:".contains(c)) => {
            (None, if scheduler == Scheduler::GridEngine { "$JOB_ID" } else { "$PBS_JOBID" })
        }
        Scheduler::Pbs | Scheduler::Torque => (Some(format!("{}/", logs.display())), ""),
        Scheduler::GridEngine => (Some(format!("{start}-$JOB_ID{}.log", if is_array { ".$TASK_ID" } else { "" })), ""),
    };
    let task = if scheduler == Scheduler::GridEngine && is_array { ".$SGE_TASK_ID" } else { "" };
    match log {
        Some(log) => (log, String::new()),
        None => ("/dev/null".into(), format!("exec >>{}\"-{id}{task}.log\" 2>&1", shell(&start))),
    }
}
