//! `scree task`: one task of a film, as the jobs of schedulers run it. Every task may be run any number of times.

use crate::batch::{MadeOf, Movie, MovieStanding, Plan, Task, marks};
use crate::device::Drawer;
use crate::displays::written;
use crate::job::{DrawOn, ImageJob, ModelRun, MovieFile, Statistics, TaskJob, combination, images_of, replacements};
use crate::ledger::{Ledger, Standing};
use crate::model_run::{self, Onward};
use crate::report::{Exit, Failure, Outcome};
use crate::{images, ranges, run, simulate, stitch};
use frame::run::RunReader;
use render::film::bucket::Shard;
use sim::model_file;
use sim::run::{Span, n_frames};

/// Run `scree task`.
pub fn run(job: TaskJob) -> Outcome {
    let TaskJob { plan, task } = job;
    marks::run(&plan.home, task, || match task {
        Task::Simulate(i) => simulate_to(&plan, i),
        Task::Sweep(i) => sweep(&plan, i),
        Task::Draw(i) => draw(&plan, i),
        Task::Finish => finish(&plan),
    })
}

/// Simulate to the time of an index, from where the run has got to.
fn simulate_to(plan: &Plan, i: usize) -> Outcome {
    let Some(simulation) = &plan.simulation else { return Ok(()) };
    let (file, doc) = model_file::load(&simulation.model, &replacements(simulation.set.iter().map(|(p, v)| (p, v))))?;
    let resolved = file.resolve(&doc)?;
    let is_last = i + 1 == simulation.until.len();
    let expected = n_frames(simulation.until[i], file.frame_rate);
    let opened = RunReader::open(&plan.home);
    let is_lost = opened.is_err() && RunReader::is_run(&plan.home);
    let there = opened.ok().filter(|run| run.index.model_hash == sim::run::model_hash(&file));
    let is_whole = !is_lost && there.as_ref().is_none_or(RunReader::is_whole);
    let is_done = if is_last {
        sim::run::is_done(&file, &plan.home)
    } else {
        is_whole && there.is_some_and(|run| run.index.frames.len() as u64 >= expected)
    };
    if is_done {
        eprintln!("{} is simulated to {} s already", plan.home.display(), simulation.until[i]);
        return Ok(());
    }
    if !is_whole {
        let home = plan.home.display();
        let what = if is_lost { format!("run.json of {home} is") } else { format!("frames of {home} are") };
        eprintln!("warning: {what} lost or damaged: it is simulated again");
    }
    let span = Span { until: (!is_last).then_some(simulation.until[i]), resume: is_whole };
    let run = ModelRun { file, resolved, folder: plan.home.clone(), span, computer: Default::default() };
    model_run::simulate(run, Onward::Again, None)?;
    if is_last && !plan.frames.is_empty() {
        // Once here, rather than by each task that draws.
        ranges::settle(&mut images_of(plan, &plan.frames)?)?;
    }
    Ok(())
}

/// Simulate a combination of a sweep.
fn sweep(plan: &Plan, i: usize) -> Outcome {
    let Some(simulation) = &plan.simulation else { return Ok(()) };
    simulate::run(combination(simulation, &plan.home, i)?)
}

/// Draw the images of a task, or a shard of each.
fn draw(plan: &Plan, i: usize) -> Outcome {
    let mut job = images_of(plan, plan.frames_of(i))?;
    let shard = plan.shard_of(i).map(|part| Shard { part, parts: plan.buckets });
    let (input, frames) = ((plan.input.as_path(), plan.home.as_path()), (&plan.frames[..], plan.is_all));
    MadeOf::write(&Ledger::of(&job.folder), input, plan.images.clone(), frames)?;
    let failed = images::render(&mut job, shard, Statistics::default(), &mut Drawer::new(DrawOn::Cpu))?;
    failed.outcome(job.frames.len(), "the others of the task were drawn")?;
    images::check_lost(&job)
}

/// Join shards, check that every image is up to date, and make the movie.
fn finish(plan: &Plan) -> Outcome {
    let mut job = images_of(plan, &plan.frames)?;
    if plan.buckets > 1 {
        join(plan, &job)?;
        for pass in &job.passes {
            join(plan, pass)?;
        }
    }
    images::check_lost(&job)?;
    let standings = images::standings(&mut job, 1)?;
    let bad: Vec<_> = standings.iter().filter(|(_, standing)| standing[0] != Standing::Done).collect();
    if let Some((frame, standing)) = bad.first() {
        let message = format!(
            "{} of {} images are not done: frame {frame} is {}; `scree resume {}` goes on",
            bad.len(),
            plan.frames.len(),
            standing[0],
            plan.home.display()
        );
        return Err(Failure::new(Exit::Partial, message));
    }
    println!("images: {} in {}", plan.frames.len(), job.folder.display());
    let of = images::hash(&job);
    if plan.movie && Movie::standing(&plan.home, Some(&of)) != MovieStanding::Done {
        let name = plan.input.file_stem().unwrap_or_default();
        let movie = run::encode(&job, &MovieFile::Stem(plan.home.join(name)))?;
        Movie::record(&plan.home, movie.as_deref(), of)?;
    }
    Ok(())
}

/// Join the shards of the images that have all of them.
fn join(plan: &Plan, job: &ImageJob) -> Outcome {
    for frame in &job.frames {
        let image = job.image(*frame);
        let all = (1..=plan.buckets).all(|part| written(&image, Some(Shard { part, parts: plan.buckets })).is_file());
        if all {
            stitch::join(&image, plan.buckets, false)?;
        }
    }
    Ok(())
}
