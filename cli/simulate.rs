//! `scree simulate`: a model → a run directory, or one for each combination of a model with a `sweep`.

use crate::job::{ModelRun, Plan, SimulateJob, Sweep, SweepJob};
use crate::model_run;
use crate::report::{Exit, Failure, Outcome};
use frame::atomic;
use guard::text::{sbatch, shell};
use sim::run;
use std::path::Path;

/// Run `scree simulate`.
pub fn run(job: SimulateJob) -> Outcome {
    match job {
        SimulateJob::Run(job) => {
            let folder = job.folder.clone();
            model_run::simulate(*job)?;
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
            let span = job.span;
            model_run::simulate(ModelRun { file: case.file, resolved, folder: folder.clone(), span })?;
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

/// Print the combinations, and write a job array that simulates them.
fn plan(job: &Plan) -> Outcome {
    let Plan { combinations, set, csv, until, model, folder, fresh } = job;
    println!("index,run,{}", combinations[0].values.iter().map(|r| r.path.as_str()).collect::<Vec<_>>().join(","));
    for (i, combination) in combinations.iter().enumerate() {
        let values: Vec<&str> = combination.values.iter().map(|r| r.value.as_str()).collect();
        println!("{i},{},{}", folder.join(&combination.name).display(), values.join(","));
    }
    let quote = |p: &Path| shell(&p.display().to_string());
    let set: String = set.iter().map(|r| format!(" --set {}", shell(&format!("{}={}", r.path, r.value)))).collect();
    let csv = if *csv { " --csv" } else { "" };
    let until = until.map_or(String::new(), |until| format!(" --until {until}"));
    let model = std::path::absolute(model).unwrap_or_else(|_| model.clone());
    let out = std::path::absolute(folder).unwrap_or_else(|_| folder.clone());
    let log = sbatch(&out.join("sweep").display().to_string(), "_%a.log")
        .ok_or_else(|| Failure::new(Exit::Usage, format!("{}: a job script cannot name it", out.display())))?;
    let script = format!(
        "#!/bin/bash\n#SBATCH --job-name=sweep\n#SBATCH --array=0-{}\n#SBATCH --output={log}\nexec scree simulate {} -o {}{set}{csv}{until} --sweep-index \"$SLURM_ARRAY_TASK_ID\"\n",
        combinations.len() - 1,
        quote(&model),
        quote(&out),
    );
    let path = folder.join("sweep.sbatch");
    if !fresh && std::fs::read_to_string(&path).is_ok_and(|there| there != script) {
        let message = format!("{} exists and may have been edited: remove it, or say --fresh", path.display());
        return Err(Failure::new(Exit::Usage, message));
    }
    atomic::write(&path, script.as_bytes())?;
    eprintln!("job array: sbatch {}", path.display());
    Ok(())
}
