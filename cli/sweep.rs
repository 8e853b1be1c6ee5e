//! A model with a `sweep`: a grid of values, one run for each combination, here one after the other or as a job array.

use crate::args::SimulateArgs;
use crate::report::{Exit, Failure, Outcome};
use crate::simulate;
use frame::atomic;
use sim::model_file::{self, ModelFile};
use sim::run::{self, Span};
use std::path::Path;

/// A combination: its name, and what is set.
struct Case {
    name: String,
    set: Vec<(String, String)>,
}

/// All combinations, the last key running fastest.
fn cases(file: &ModelFile) -> Outcome<Vec<Case>> {
    let mut all = vec![Case { name: String::new(), set: vec![] }];
    for (path, values) in &file.sweep {
        if values.is_empty() {
            return Err(Failure::new(Exit::Input, format!("sweep.{path} has no values")));
        }
        let mut next = vec![];
        for case in &all {
            for value in values {
                let text = serde_json::to_string(value).map_err(|e| Failure::new(Exit::Input, e.to_string()))?;
                let mut set = case.set.clone();
                set.push((path.clone(), text.clone()));
                let short = path.rsplit('.').next().unwrap_or(path);
                let word: String = text
                    .chars()
                    .map(|c| if c == ',' { '_' } else { c })
                    .filter(|c| c.is_alphanumeric() || matches!(c, '.' | '-' | '+' | '_'))
                    .collect();
                let joint = if case.name.is_empty() { "" } else { "_" };
                next.push(Case { name: format!("{}{joint}{short}={word}", case.name), set });
            }
        }
        all = next;
    }
    Ok(all)
}

/// Simulate all combinations, or one, or write the plan.
pub fn command(args: &SimulateArgs, file: &ModelFile, folder: &Path) -> Outcome {
    let cases = cases(file)?;
    if args.plan {
        return plan(args, &cases, folder);
    }
    let chosen: Vec<usize> = match args.sweep_index {
        Some(i) if i < cases.len() => vec![i],
        Some(i) => {
            let message = format!("--sweep-index {i}: the sweep has combinations 0 to {}", cases.len() - 1);
            return Err(Failure::new(Exit::Usage, message));
        }
        None => (0..cases.len()).collect(),
    };
    let mut warned = vec![];
    for i in chosen {
        let case = &cases[i];
        let mut set = args.set.clone();
        set.extend(case.set.iter().cloned());
        let (mut file, doc) = model_file::load(&args.model, &set)?;
        file.sweep.clear();
        if args.csv {
            file.format = frame::run::FrameFormat::Csv;
        }
        let goal = folder.join(&case.name);
        if args.until.is_none() && run::is_done(&file, &goal) {
            eprintln!("sweep {i}: {} is there already", goal.display());
            warned.extend(simulate::warned(&goal).err());
            continue;
        }
        eprintln!("sweep {i} of {}: {}", cases.len(), case.name);
        let resolved = file.resolve(&doc)?;
        simulate::simulate(&file, resolved, &goal, &Span { until: args.until, resume: args.resume })?;
        println!("{}", goal.display());
        warned.extend(simulate::warned(&goal).err());
    }
    match warned.first() {
        None => Ok(()),
        Some(first) => {
            Err(Failure::new(Exit::Partial, format!("{} runs have warnings; the first: {first}", warned.len())))
        }
    }
}

/// Print the combinations and write a job array that runs them.
fn plan(args: &SimulateArgs, cases: &[Case], folder: &Path) -> Outcome {
    println!("index,run,{}", cases[0].set.iter().map(|(p, _)| p.as_str()).collect::<Vec<_>>().join(","));
    for (i, case) in cases.iter().enumerate() {
        let values: Vec<&str> = case.set.iter().map(|(_, v)| v.as_str()).collect();
        println!("{i},{},{}", folder.join(&case.name).display(), values.join(","));
    }
    let quote = |p: &Path| format!("'{}'", p.display().to_string().replace('\'', "'\\''"));
    let model = std::path::absolute(&args.model).unwrap_or_else(|_| args.model.clone());
    let out = std::path::absolute(folder).unwrap_or_else(|_| folder.into());
    let script = format!(
        "#!/bin/bash\n#SBATCH --job-name=sweep\n#SBATCH --array=0-{}\n#SBATCH --output={}\nexec scree simulate {} -o {} --sweep-index \"$SLURM_ARRAY_TASK_ID\"\n",
        cases.len() - 1,
        out.join("sweep_%a.log").display(),
        quote(&model),
        quote(&out),
    );
    let path = folder.join("sweep.sbatch");
    atomic::write(&path, script.as_bytes())?;
    eprintln!("job array: sbatch {}", path.display());
    Ok(())
}
