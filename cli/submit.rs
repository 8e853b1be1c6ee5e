//! `scree submit` and `scree resume`: the tasks of a film that are not done, to a scheduler or run on this machine.

mod local;

use crate::batch::{self, Movie, MovieStanding, Needed, Plan, Scheduler, Simulation, Task, marks};
use crate::images;
use crate::job::{FilmJob, images_of, open_combinations, replacements};
use crate::ledger::Standing;
use crate::report::{Exit, Failure, Outcome};

/// Run `scree submit` or `scree resume`.
pub fn run(job: FilmJob) -> Outcome {
    let FilmJob { plan, dry_run } = job;
    let needed = needed(&plan, dry_run)?;
    let jobs = batch::jobs(&plan, &needed, batch::most_indices(plan.scheduler))?;
    let n_tasks: usize = jobs.iter().map(|job| job.tasks.len()).sum();
    let draw = &needed.draw;
    eprintln!("tasks: {n_tasks}, in jobs: {}; {} of {} that draw are needed", jobs.len(), draw.len(), plan.n_tasks());
    if dry_run {
        eprintln!("note: a dry run looks at no images: its scripts are those of all tasks, done or not");
        // All scripts in one text, which a check of scripts takes.
        println!("#!/bin/bash\n# shellcheck disable=SC1128,SC2093,SC2317");
        for job in &jobs {
            let script = Plan::folder(&plan.home).join(format!("{}.sh", job.name));
            println!("# {}", guard::text::line(&script.display().to_string()));
            print!("{}", job.script);
        }
        return Ok(());
    }
    plan.write()?;
    marks::forget(&plan.home, |task| match task {
        Task::Simulate(_) => !needed.simulate,
        Task::Sweep(i) => !needed.sweep.contains(&i),
        Task::Draw(i) => !needed.draw.contains(&i),
        Task::Finish => !needed.finish,
    });
    if jobs.is_empty() {
        println!("{}: all is done", plan.home.display());
        return Ok(());
    }
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
    eprintln!("`scree status {}` says how far it is", guard::text::shell_word(&plan.home.display().to_string()));
    Ok(())
}

/// What is left to do of a plan: the simulation, the tasks that draw what is not there or not up to date, and the end. All of it before
/// a simulation is finished.
fn needed(plan: &Plan, dry_run: bool) -> Outcome<Needed> {
    let all = |simulate: bool, sweep: Vec<usize>| {
        let draw = (0..plan.n_tasks()).collect();
        Needed { simulate, sweep, draw, finish: !plan.frames.is_empty() }
    };
    if let Some(simulation) = plan.simulation.as_ref().filter(|simulation| simulation.sweep > 0) {
        let sweep = if dry_run { (0..simulation.sweep).collect() } else { open_combinations(simulation, &plan.home)? };
        return Ok(all(!sweep.is_empty(), sweep));
    }
    // A run that is not finished lacks frames, so that its images cannot all be looked at.
    let is_simulated = match &plan.simulation {
        None => true,
        Some(simulation) => is_simulated(plan, simulation)?,
    };
    if !is_simulated || dry_run {
        return Ok(all(plan.simulation.is_some(), vec![]));
    }
    let mut job = match images_of(plan, &plan.frames) {
        Ok(job) => job,
        // No task could draw anything.
        Err(failure) if matches!(failure.exit, Exit::Input | Exit::Usage) => return Err(failure),
        Err(_) => return Ok(all(false, vec![])),
    };
    let standings = images::standings(&mut job, plan.buckets)?;
    let is_needed = |task: &usize| {
        let shard = task % plan.buckets;
        let frames = plan.frames_of(*task);
        let of_task = standings.iter().filter(|(frame, _)| frames.contains(frame));
        of_task.clone().count() < frames.len() || of_task.into_iter().any(|(_, all)| all[shard] != Standing::Done)
    };
    let draw: Vec<usize> = (0..plan.n_tasks()).filter(is_needed).collect();
    let is_joined = plan.buckets == 1 || job.frames.iter().all(|frame| job.image(*frame).is_file());
    let has_movie = || Movie::standing(&plan.home, Some(&images::hash(&job))) == MovieStanding::Done;
    let finish = !draw.is_empty() || !is_joined || plan.movie && !has_movie();
    Ok(Needed { simulate: false, sweep: vec![], draw, finish })
}

/// Whether the simulation of a plan is finished, with all of its frames.
fn is_simulated(plan: &Plan, simulation: &Simulation) -> Outcome<bool> {
    let set = replacements(simulation.set.iter().map(|(path, value)| (path, value)));
    Ok(sim::run::is_done(&sim::model_file::load(&simulation.model, &set)?.0, &plan.home))
}
