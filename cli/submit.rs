//! `scree submit` and `scree resume`: the tasks of a film that are not done, to a scheduler or run on this machine.

mod local;

use crate::batch::{self, Plan, Scheduler};
use crate::images;
use crate::job::{FilmJob, images_of};
use crate::ledger::Standing;
use crate::report::{Exit, Failure, Outcome};

/// Run `scree submit` or `scree resume`.
pub fn run(job: FilmJob) -> Outcome {
    let FilmJob { plan, dry_run } = job;
    let draw = needed(&plan, dry_run)?;
    let jobs = batch::jobs(&plan, &draw, batch::most_indices(plan.scheduler))?;
    let n_tasks: usize = jobs.iter().map(|job| job.tasks.len()).sum();
    eprintln!("{n_tasks} tasks in {} jobs; {} of {} that draw are needed", jobs.len(), draw.len(), plan.n_tasks());
    if dry_run {
        // All scripts in one text, which a check of scripts takes.
        println!("#!/bin/bash\n# shellcheck disable=SC1128,SC2093,SC2317");
        for job in &jobs {
            println!("# {}", Plan::folder(&plan.home).join(format!("{}.sh", job.name)).display());
            print!("{}", job.script);
        }
        return Ok(());
    }
    plan.write()?;
    if plan.scheduler == Scheduler::Local {
        return local::run(&plan, jobs);
    }
    if let Some(states) = batch::state_of(plan.scheduler, &batch::submitted(&plan.home))
        && !states.is_empty()
    {
        let states: Vec<String> = states.iter().map(|(state, n)| format!("{n} {state}")).collect();
        let message = format!(
            "tasks of {} are queued already ({}): `scree status` shows them, and scancel takes them back",
            plan.home.display(),
            states.join(", ")
        );
        return Err(Failure::new(Exit::Usage, message));
    }
    for job in batch::submit(&plan, &jobs)? {
        println!("{} {} ({} tasks)", job.id, job.job, job.tasks);
    }
    eprintln!("`scree status {}` says how far it is", plan.home.display());
    Ok(())
}

/// The tasks that draw what is not there, or not up to date; all of them before a simulation.
fn needed(plan: &Plan, dry_run: bool) -> Outcome<Vec<usize>> {
    let all = || (0..plan.n_tasks()).collect();
    let is_ready = plan.simulation.is_none() || frame::run::RunReader::is_run(&plan.home);
    // A run that is not finished lacks frames, so that its images cannot all be looked at.
    if !is_ready || dry_run {
        return Ok(all());
    }
    let Ok(mut job) = images_of(plan, &plan.frames) else { return Ok(all()) };
    if job.frames.len() < plan.frames.len() {
        return Ok(all());
    }
    let standings = images::standings(&mut job, plan.buckets)?;
    let is_needed = |task: &usize| {
        let shard = task % plan.buckets;
        let frames = plan.frames_of(*task);
        let of_task = standings.iter().filter(|(frame, _)| frames.contains(frame));
        of_task.clone().count() < frames.len() || of_task.into_iter().any(|(_, all)| all[shard] != Standing::Done)
    };
    Ok((0..plan.n_tasks()).filter(is_needed).collect())
}
