//! `scree simulate`: a model → a run directory, or one for each combination of a model with a `sweep`.

use crate::job::{ModelRun, Plan, SimulateJob, Sweep, SweepJob};
use crate::model_run::{self, Onward};
use crate::preview;
use crate::report::{Exit, Failure, Outcome};
use frame::run::RunReader;
use sim::run;

/// Run `scree simulate`.
pub fn run(job: SimulateJob) -> Outcome {
    match job {
        SimulateJob::Run { run, preview } => {
            let folder = run.folder.clone();
            if preview && let Err(failure) = preview::start(&folder) {
                eprintln!("warning: there is no preview: {failure}");
            }
            model_run::simulate(*run, Onward::Resume, None)?;
            println!("{}", folder.display());
            model_run::check_warnings(&folder)
        }
        SimulateJob::Sweep(SweepJob::Runs(job)) => sweep(job),
        SimulateJob::Sweep(SweepJob::Plan(job)) => plan(&job),
    }
}

/// Simulate the combinations of a sweep.
fn sweep(job: Sweep) -> Outcome {
    let mut warnings = vec![];
    for case in job.runs {
        let folder = case.folder;
        if job.span.until.is_none() && run::is_done(&case.file, &folder) {
            eprintln!("sweep {}: {} is finished already", case.index, folder.display());
        } else {
            eprintln!("sweep {} of {}: {}", case.index, job.n_combinations, case.name);
            let resolved = case.file.resolve(&case.doc)?;
            let mut span = job.span;
            if span.resume && RunReader::open(&folder).is_ok_and(|run| !run.is_whole()) {
                eprintln!("warning: frames of {} are lost or damaged: it is simulated again", folder.display());
                span.resume = false;
            }
            let (goal, computer) = (folder.clone(), job.computer.clone());
            let run = ModelRun { file: case.file, resolved, folder: goal, span, computer };
            model_run::simulate(run, Onward::Resume, None)?;
            println!("{}", folder.display());
        }
        warnings.extend(model_run::check_warnings(&folder).err());
    }
    match warnings.first() {
        None => Ok(()),
        Some(first) => {
            Err(Failure::new(Exit::Partial, format!("{} runs have warnings; the first: {first}", warnings.len())))
        }
    }
}

/// Print the combinations.
fn plan(Plan { combinations, folder }: &Plan) -> Outcome {
    println!("index,run,{}", combinations[0].values.iter().map(|r| r.path.as_str()).collect::<Vec<_>>().join(","));
    for (i, combination) in combinations.iter().enumerate() {
        let values: Vec<&str> = combination.values.iter().map(|r| r.value.as_str()).collect();
        println!("{i},{},{}", folder.join(&combination.name).display(), values.join(","));
    }
    eprintln!("`scree submit` makes job arrays of them");
    Ok(())
}
