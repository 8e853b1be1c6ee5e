//! The combinations of a model with a `sweep`: a grid of values, one run for each.

use super::run_folder;
use crate::args::SimulateArgs;
use crate::report::{Exit, Failure, Outcome};
use frame::run::{FrameFormat, RunReader};
use frame::yaml::Document;
use sim::model_file::{ModelFile, Replacement, Variants};
use sim::run::{self, Computer, Span};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// What to do with the combinations of a model.
pub enum SweepJob {
    /// Simulate them, or one of them.
    Runs(Sweep),
    /// List them.
    Plan(Plan),
}

/// Combinations to simulate, one after the other.
pub struct Sweep {
    /// The runs.
    pub runs: Vec<SweepRun>,
    /// The number of combinations of the sweep, chosen or not.
    pub n_combinations: usize,
    /// The span of time to simulate.
    pub span: Span,
    /// What computes the steps.
    pub computer: Computer,
}

/// A run of a combination.
pub struct SweepRun {
    /// The combination's index, from 0.
    pub index: usize,
    /// The combination's name.
    pub name: String,
    /// The model with the combination's values.
    pub file: ModelFile,
    /// The places of its keys.
    pub doc: Document,
    /// The run directory.
    pub folder: PathBuf,
}

/// Combinations to list.
pub struct Plan {
    /// The combinations.
    pub combinations: Vec<Combination>,
    /// The folder of the runs.
    pub folder: PathBuf,
}

/// A combination of values.
pub struct Combination {
    /// The name, which its run directory has.
    pub name: String,
    /// The values that take the place of the model's.
    pub values: Vec<Replacement>,
}

impl SweepJob {
    /// Check the arguments for a model with a sweep, in which the values of `set` are replaced. Every combination that is chosen is
    /// checked as a model, so that none fails after the others have run for hours.
    pub fn check(
        args: SimulateArgs,
        (file, doc): (&ModelFile, &Document),
        set: Vec<Replacement>,
        (folder, computer): (PathBuf, Computer),
    ) -> Outcome<SweepJob> {
        let combinations = combinations(file, doc)?;
        let n = combinations.len();
        spare_swept(file, &set)?;
        if RunReader::is_run(&folder) {
            let message = format!(
                "{} is the directory of one run, and the model has a `sweep`\n  = -o DIR (--output) takes the folder of its runs",
                folder.display()
            );
            return Err(Failure::new(Exit::Usage, message));
        }
        if let Some(i) = args.sweep_index.filter(|i| *i >= n) {
            let message = format!("--sweep-index {i}: the sweep has combinations 0 to {}", n - 1);
            return Err(Failure::new(Exit::Usage, message));
        }
        let is_chosen = |i: usize| args.sweep_index.is_none_or(|only| only == i);
        let chosen = combinations.into_iter().enumerate().filter(|(i, _)| is_chosen(*i));
        let variants = Variants::without_sweep(doc)?;
        let runs = chosen.map(|(index, combination)| {
            let (mut file, doc) = variants.load(&[&set[..], &combination.values].concat())?;
            if args.csv {
                file.format = FrameFormat::Csv;
            }
            file.resolve(&doc)?;
            let (home, folder) = (&folder, folder.join(&combination.name));
            run_folder::spare_linked(&folder, home)?;
            if !args.fresh && !args.plan {
                run_folder::check(&file, &folder, args.until, "scree simulate")?;
            }
            let run = SweepRun { index, name: combination.name.clone(), file, doc, folder };
            Ok((combination, run))
        });
        let (combinations, runs): (Vec<_>, Vec<_>) = runs.collect::<Outcome<Vec<_>>>()?.into_iter().unzip();
        if args.plan {
            return Ok(SweepJob::Plan(Plan { combinations, folder }));
        }
        let span = Span { until: args.until, resume: args.resume };
        Ok(SweepJob::Runs(Sweep { runs, n_combinations: n, span, computer }))
    }
}

/// Refuse values of the command line for keys that have those of a sweep.
fn spare_swept(file: &ModelFile, set: &[Replacement]) -> Outcome {
    match set.iter().find(|r| file.sweep.contains_key(&r.path)) {
        Some(r) => {
            let message = format!("--set {}={}: the model's `sweep` gives this key its values", r.path, r.value);
            Err(Failure::new(Exit::Usage, message))
        }
        None => Ok(()),
    }
}

/// Check the models of all combinations of a sweep, in which the values of `set` are replaced; their number.
pub fn check(file: &ModelFile, doc: &Document, set: &[Replacement]) -> Outcome<usize> {
    spare_swept(file, set)?;
    let combinations = combinations(file, doc)?;
    let variants = Variants::without_sweep(doc)?;
    for combination in &combinations {
        let (file, doc) = variants.load(&[set, &combination.values].concat())?;
        file.resolve(&doc)?;
    }
    Ok(combinations.len())
}

/// The combinations of a sweep whose runs in `home` are not finished, or have lost frames.
pub fn unfinished(file: &ModelFile, doc: &Document, set: &[Replacement], home: &Path) -> Outcome<Vec<usize>> {
    let variants = Variants::without_sweep(doc)?;
    let mut found = vec![];
    for (i, combination) in combinations(file, doc)?.into_iter().enumerate() {
        let (file, _) = variants.load(&[set, &combination.values].concat())?;
        if !run::is_done(&file, &home.join(&combination.name)) {
            found.push(i);
        }
    }
    Ok(found)
}

/// All combinations of a sweep, the last key changing fastest.
fn combinations(file: &ModelFile, doc: &Document) -> Outcome<Vec<Combination>> {
    /// The most combinations.
    const MOST: usize = 100_000;
    let n = file.sweep.iter().try_fold(1usize, |n, (_, values)| n.checked_mul(values.len())).unwrap_or(usize::MAX);
    if n > MOST {
        let message = format!("has {n} combinations, expected at most {MOST}");
        return Err(doc.fault("sweep", message).hint("the values of all keys are combined").into());
    }
    let mut all = vec![Combination { name: String::new(), values: vec![] }];
    for (path, values) in &file.sweep {
        let key = format!("sweep.{path}");
        if values.is_empty() {
            return Err(doc.fault(&key, "has no values: expected a list of at least one").into());
        }
        let mut next = vec![];
        for combination in &all {
            for (k, value) in values.iter().enumerate() {
                let value = serde_json::to_string(value).map_err(|e| doc.fault(&key, e.to_string()))?;
                let written = Some(format!("{key}.{k}"));
                next.push(
                    combination
                        .with(key_name(path, file.sweep.keys()), Replacement { path: path.clone(), value, written }),
                );
            }
        }
        all = next;
    }
    let mut first = HashMap::new();
    for (i, combination) in all.iter().enumerate() {
        let other = *first.entry(&combination.name).or_insert(i);
        if other < i {
            let message = format!("combinations {other} and {i} would share the run directory `{}`", combination.name);
            let hint = "give each value once, with letters, digits or signs of its own";
            return Err(doc.fault("sweep", message).hint(hint).into());
        }
    }
    Ok(all)
}

/// The end of a path that tells it from all others, and begins with a name.
fn key_name<'a>(path: &'a str, all: impl Iterator<Item = &'a String> + Clone) -> &'a str {
    let starts = path.rmatch_indices('.').map(|(at, _)| at + 1).chain([0]);
    let is_own = |end: &str| all.clone().filter(|p| *p == end || p.ends_with(&format!(".{end}"))).count() == 1;
    let is_named = |end: &str| !end.starts_with(|c: char| c.is_ascii_digit());
    starts.map(|at| &path[at..]).find(|end| is_named(end) && is_own(end)).unwrap_or(path)
}

impl Combination {
    /// This combination with one more value, of a key that is called `key`.
    fn with(&self, key: &str, replacement: Replacement) -> Combination {
        let word: String = replacement
            .value
            .chars()
            .map(|c| if c == ',' { '_' } else { c })
            .filter(|c| c.is_alphanumeric() || matches!(c, '.' | '-' | '+' | '_'))
            .collect();
        let joint = if self.name.is_empty() { "" } else { "_" };
        let name = format!("{}{joint}{}={word}", self.name, guard::text::file_name(key, ".-"));
        let mut values = self.values.clone();
        values.push(replacement);
        Combination { name, values }
    }
}
