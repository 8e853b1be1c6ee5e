//! The run directory of a simulation: whether it is free, or holds a run that must not be lost.

use crate::report::{Exit, Failure, Outcome};
use frame::run::RunReader;
use sim::model_file::ModelFile;
use sim::run::{identity, model_hash, n_frames};
use std::path::{Path, PathBuf};

/// Files of a run directory that a new run replaces, and folders of which it removes the tables and checkpoints.
const FILES: [&str; 3] = ["model.yaml", "report.csv", "probes.csv"];
const FOLDERS: [(&str, &[&str]); 3] =
    [("frames", &["arrow", "csv"]), ("checkpoints", &["state"]), ("contacts", &["csv"])];

/// Check that a simulation of the model `file`, which was read from the path `model`, does not replace that file by its resolved form.
pub fn spare_model(model: &Path, file: &ModelFile, folder: &Path) -> Outcome {
    let copy = folder.join("model.yaml");
    if guard::is_one_of(&copy, [model]) && std::fs::read_to_string(model).ok().as_ref() != Some(&file.to_yaml()) {
        let message = format!(
            "the run in {} would replace the model file itself, {}\n  = simulate elsewhere: -o DIR (--output)",
            folder.display(),
            model.display()
        );
        return Err(Failure::new(Exit::Usage, message));
    }
    Ok(())
}

/// Check that no link in the run directory `folder` leads what is written or removed there out of the folder `home`, which is the run
/// directory itself or that of its sweep.
pub fn spare_linked(folder: &Path, home: &Path) -> Outcome {
    FOLDERS.iter().map(|(name, _)| *name).chain(["geometry"]).try_for_each(|name| spare_link(&folder.join(name), home))
}

/// Check that no link leads what is written to a folder out of the folder `home`.
pub fn spare_link(folder: &Path, home: &Path) -> Outcome {
    if !guard::leads_out(folder, home) {
        return Ok(());
    }
    let message = format!(
        "{}: a link leads out of {}\n  = remove the link, or write elsewhere: -o DIR (--output)",
        folder.display(),
        home.display()
    );
    Err(Failure::new(Exit::Usage, message))
}

/// Check that a simulation of a model into `folder` loses nothing: no run of another model, no longer run of the same model, and no
/// files of somebody else. `until` is the time to simulate to, s, if it is not the model's duration, and `by` the command that would replace
/// what is there.
pub fn check(file: &ModelFile, folder: &Path, until: Option<f64>, by: &str) -> Outcome {
    if folder.is_file() {
        return Err(Failure::new(Exit::Usage, format!("{}: is a file, and no folder", folder.display())));
    }
    let refuse = |why: String| {
        let message = format!(
            "{} {why}\n  = `{by} --fresh` replaces it; `{by} -o DIR` (--output) simulates elsewhere",
            folder.display()
        );
        Err(Failure::new(Exit::Usage, message))
    };
    if !RunReader::is_run(folder) {
        return match foreign_file(folder) {
            Some(path) => refuse(format!("is no run directory, but holds {}, which would be replaced", path.display())),
            None => Ok(()),
        };
    }
    let there = RunReader::open(folder)?.index;
    if there.model_hash != model_hash(file) {
        let n_frames = there.frames.len();
        let keys = changed_keys(file, folder);
        let changed = if keys.is_empty() { String::new() } else { format!("; changed since: {}", keys.join(", ")) };
        return refuse(format!("holds the run of another model ({n_frames} frames){changed}"));
    }
    let duration = file.whole_duration();
    let expected = n_frames(until.unwrap_or(duration).min(duration), file.frame_rate);
    if there.frames.len() as u64 > expected {
        return refuse(format!(
            "holds {} frames of this model, and this run would have {expected}",
            there.frames.len()
        ));
    }
    Ok(())
}

/// A file of a folder that is no run directory, which a new run would replace or remove.
fn foreign_file(folder: &Path) -> Option<PathBuf> {
    let of_run = |(sub, endings): (&str, &[&str])| {
        let is_ours = |path: &PathBuf| path.extension().and_then(|e| e.to_str()).is_some_and(|e| endings.contains(&e));
        std::fs::read_dir(folder.join(sub)).ok()?.flatten().map(|entry| entry.path()).find(is_ours)
    };
    let own = FILES.iter().map(|name| folder.join(name)).find(|path| path.exists());
    own.or_else(|| FOLDERS.into_iter().find_map(of_run))
}

/// Keys in which a model differs from that of a run directory, the first few.
fn changed_keys(file: &ModelFile, folder: &Path) -> Vec<String> {
    const MAX: usize = 4;
    let there = std::fs::read_to_string(folder.join("model.yaml")).unwrap_or_default();
    let as_value = |file: &ModelFile| serde_yaml::from_str(&identity(file).to_yaml());
    let Ok((before, now)) = serde_yaml::from_str(&there).and_then(|there| Ok((as_value(&there)?, as_value(file)?)))
    else {
        return vec![];
    };
    let mut keys = vec![];
    differences(&before, &now, "", &mut keys);
    let n = keys.len();
    keys.truncate(MAX);
    if n > MAX {
        keys.push(format!("and {} more", n - MAX));
    }
    keys
}

/// Add the dotted paths of the values that differ.
fn differences(a: &serde_yaml::Value, b: &serde_yaml::Value, path: &str, keys: &mut Vec<String>) {
    use serde_yaml::Value;
    let join = |part: &str| if path.is_empty() { part.to_string() } else { format!("{path}.{part}") };
    match (a, b) {
        (Value::Mapping(x), Value::Mapping(y)) => {
            let others = y.keys().filter(|k| !x.contains_key(*k));
            for key in x.keys().chain(others) {
                let of = |map: &serde_yaml::Mapping| map.get(key).cloned().unwrap_or(Value::Null);
                differences(&of(x), &of(y), &join(key.as_str().unwrap_or("?")), keys);
            }
        }
        (Value::Sequence(x), Value::Sequence(y)) if x.len() == y.len() => {
            for (k, (x, y)) in x.iter().zip(y).enumerate() {
                let name = y.get("name").and_then(Value::as_str).map_or(k.to_string(), str::to_string);
                differences(x, y, &join(&name), keys);
            }
        }
        _ if a != b => keys.push(path.into()),
        _ => {}
    }
}
