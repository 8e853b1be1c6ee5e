//! Schedulers: handing jobs to one, what its limits are, and what it says of jobs.

use super::plan::{Plan, Scheduler};
use super::script::Job;
use crate::report::{Exit, Failure, Outcome};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A job that a scheduler has taken.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Submitted {
    /// Its name.
    pub job: String,
    /// The scheduler's name for it.
    pub id: String,
    /// How many tasks it has.
    pub tasks: usize,
}

/// The most indices of an array, from 0.
pub fn most_indices(scheduler: Scheduler) -> usize {
    match scheduler {
        // Slurm's own default is 1001; the index must be below.
        Scheduler::Slurm => max_array_size().unwrap_or(1001),
        Scheduler::Pbs => 10_000,
        Scheduler::Torque => 100_000,
        Scheduler::GridEngine => 75_000,
        Scheduler::Local => usize::MAX,
    }
}

/// The `MaxArraySize` of a Slurm that answers.
fn max_array_size() -> Option<usize> {
    let said = said("scontrol", &["show", "config"]).ok()?;
    let line = said.lines().find(|line| line.trim_start().starts_with("MaxArraySize"))?;
    line.split_once('=')?.1.trim().parse().ok().filter(|n| *n > 0)
}

/// The Slurm of this machine.
#[derive(Debug, Serialize)]
pub struct Slurm {
    /// What `sbatch --version` says; empty if it does not answer.
    pub version: String,
    /// Which of its programs do not answer, and why.
    pub faults: Vec<String>,
    /// The most tasks of an array; none if the controller does not answer.
    pub most_tasks: Option<usize>,
    /// Its partitions.
    pub partitions: Vec<Partition>,
}

/// A partition of a Slurm cluster, as `sinfo` lists it: a line for each kind of its nodes.
#[derive(Debug, Serialize)]
pub struct Partition {
    /// Its name; that of the usual one ends with `*`.
    pub name: String,
    /// The longest time of a job, as Slurm writes it.
    pub time: String,
    /// Number of nodes.
    pub nodes: usize,
    /// Processors of a node.
    pub cpus: String,
    /// Memory of a node, MB.
    pub memory_mb: String,
}

/// The Slurm of this machine, if it has one: if one of its programs is on PATH.
pub fn slurm() -> Option<Slurm> {
    let asked = [
        ("sbatch", said("sbatch", &["--version"])),
        ("sinfo", said("sinfo", &["--noheader", "--format=%P|%l|%D|%c|%m"])),
    ];
    if asked.iter().all(|(program, answer)| answer.is_err() && !is_on_path(program)) {
        return None;
    }
    let fault = |(program, answer): &(&str, Result<String, String>)| {
        answer.as_ref().err().map(|why| format!("{program} does not answer: {}", guard::text::line(why)))
    };
    let faults = asked.iter().filter_map(fault).collect();
    let [version, list] = asked.map(|(_, answer)| answer.unwrap_or_default());
    let partition = |line: &str| {
        let parts: Vec<String> = line.split('|').map(|part| part.trim().to_string()).collect();
        let [name, time, nodes, cpus, memory_mb] = parts.try_into().ok()?;
        Some(Partition { name, time, nodes: nodes.parse().ok()?, cpus, memory_mb })
    };
    let partitions = list.lines().filter_map(partition).collect();
    Some(Slurm { version: version.trim().into(), faults, most_tasks: max_array_size(), partitions })
}

/// Whether a program is in one of the folders of PATH.
fn is_on_path(program: &str) -> bool {
    let path = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&path).any(|folder| folder.join(program).is_file())
}

/// Where the names of the jobs are kept.
fn list(home: &Path) -> PathBuf {
    Plan::folder(home).join("jobs.json")
}

/// The jobs that a scheduler has taken for the plan of a folder.
pub fn submitted(home: &Path) -> Vec<Submitted> {
    std::fs::read(list(home)).ok().and_then(|bytes| serde_json::from_slice(&bytes).ok()).unwrap_or_default()
}

/// Write the scripts of jobs beside the plan, and hand them to its scheduler, in their order.
pub fn submit(plan: &Plan, jobs: &[Job]) -> Outcome<Vec<Submitted>> {
    let folder = Plan::folder(&plan.home);
    let logs = folder.join("logs");
    std::fs::create_dir_all(&logs).map_err(|e| frame::Fault::unwritable(&logs, &e))?;
    let mut all = submitted(&plan.home);
    let mut taken: Vec<Submitted> = vec![];
    for job in jobs {
        let script = folder.join(format!("{}.sh", job.name));
        frame::atomic::write(&script, job.script.as_bytes())?;
        let (program, mut arguments) = match plan.scheduler {
            Scheduler::Slurm => ("sbatch", vec!["--parsable".to_string()]),
            Scheduler::GridEngine => ("qsub", vec!["-terse".into()]),
            _ => ("qsub", vec![]),
        };
        arguments.extend(dependency(plan.scheduler, jobs, job, &taken));
        arguments.push(script.display().to_string());
        let id = said(program, &arguments.iter().map(String::as_str).collect::<Vec<_>>()).map_err(|why| {
            let before = match taken.len() {
                0 => String::new(),
                n => format!("; {n} jobs before it were taken, and `scree resume` submits the others"),
            };
            Failure::new(Exit::Fault, format!("{program} {}: {why}{before}", script.display()))
        })?;
        let id = id.trim().split([';', ' ']).next().unwrap_or("").to_string();
        let id = if plan.scheduler == Scheduler::GridEngine { id.split('.').next().unwrap_or("").into() } else { id };
        taken.push(Submitted { job: job.name.clone(), id, tasks: job.tasks.len() });
        all.push(taken[taken.len() - 1].clone());
        frame::atomic::write(&list(&plan.home), &serde_json::to_vec_pretty(&all).unwrap_or_default())?;
    }
    Ok(taken)
}

/// The arguments by which a job comes after others.
fn dependency(scheduler: Scheduler, jobs: &[Job], job: &Job, taken: &[Submitted]) -> Vec<String> {
    if job.after.is_empty() {
        return vec![];
    }
    let when = if job.is_after_any { "afterany" } else { "afterok" };
    let ids = || job.after.iter().map(|i| taken[*i].id.as_str()).collect::<Vec<_>>();
    match scheduler {
        Scheduler::Slurm => {
            vec![format!("--dependency={when}:{}", ids().join(":")), "--kill-on-invalid-dep=yes".into()]
        }
        Scheduler::Pbs => vec!["-W".into(), format!("depend={when}:{}", ids().join(":"))],
        Scheduler::Torque => {
            let array = |i: &usize| if jobs[*i].tasks.len() > 1 { "array" } else { "" };
            let one = |i: &usize| format!("{when}{}:{}", array(i), taken[*i].id);
            vec!["-W".into(), format!("depend={}", job.after.iter().map(one).collect::<Vec<_>>().join(","))]
        }
        // It knows no failure: what comes after checks for itself.
        Scheduler::GridEngine => vec!["-hold_jid".into(), ids().join(",")],
        Scheduler::Local => vec![],
    }
}

/// How many tasks of jobs are in each of a scheduler's states; none where it cannot be asked. Tasks that have ended are in none.
pub fn state_of(scheduler: Scheduler, jobs: &[Submitted]) -> Option<BTreeMap<String, usize>> {
    let ids: Vec<&str> = jobs.iter().map(|job| job.id.as_str()).collect();
    if scheduler != Scheduler::Slurm {
        return None;
    }
    if ids.is_empty() {
        return Some(BTreeMap::new());
    }
    // Jobs that it has forgotten are an error to it when they are named, so that all of the user's are asked for.
    let text = said("squeue", &["--noheader", "--me", "--format=%i %T"]).ok()?;
    let mut found = BTreeMap::new();
    for (id, state) in text.lines().filter_map(|line| line.trim().split_once(' ')) {
        let (job, tasks) = id.split_once('_').unwrap_or((id, ""));
        if ids.contains(&job) {
            *found.entry(state.to_lowercase()).or_default() += count(tasks);
        }
    }
    Some(found)
}

/// The number of tasks in `[0-3,7%2]`; 1 of a single task.
fn count(tasks: &str) -> usize {
    let Some(inner) = tasks.strip_prefix('[') else { return 1 };
    let inner = inner.trim_end_matches(']').split('%').next().unwrap_or("");
    let part = |part: &str| match part.split_once('-') {
        Some((a, b)) => Some(b.parse::<usize>().ok()?.saturating_sub(a.parse().ok()?) + 1),
        None => Some(1),
    };
    inner.split(',').filter_map(part).sum()
}

/// What a program says; an error is what it says of a failure.
fn said(program: &str, arguments: &[&str]) -> Result<String, String> {
    match Command::new(program).args(arguments).stdin(std::process::Stdio::null()).output() {
        Ok(output) if output.status.success() => Ok(String::from_utf8_lossy(&output.stdout).into_owned()),
        Ok(output) => {
            let text = String::from_utf8_lossy(&output.stderr).trim().to_string();
            Err(if text.is_empty() { format!("ended with {}", output.status) } else { text })
        }
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => {
            Err(format!("`{program}` is not on PATH; --dry-run prints the scripts"))
        }
        Err(e) => Err(e.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::count;

    #[test]
    fn tasks_of_an_array_are_counted() {
        for (text, n) in [("", 1), ("12", 1), ("[0-3,7%2]", 5), ("[5]", 1), ("[1-99%4]", 99)] {
            assert_eq!(count(text), n, "{text}");
        }
    }
}
