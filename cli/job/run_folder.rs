//! The run directory of a simulation: whether it is free, or holds a run that must not be lost.

use crate::report::{Exit, Failure, Outcome};
use frame::run::{self, RunReader};
use sim::model_file::ModelFile;
use sim::run::{identity, model_hash, n_frames};
use std::path::Path;

/// Check that a simulation of a model into `folder` loses nothing: no run of another model, no longer run of the same model, and no
/// files of somebody else. `until` is the time to simulate to, s, if it is not the model's duration.
pub fn check(file: &ModelFile, folder: &Path, until: Option<f64>) -> Outcome {
    let refuse = |why: String| {
        let message =
            format!("{} {why}\n  = --fresh replaces it; -o DIR (--output) simulates elsewhere", folder.display());
        Err(Failure::new(Exit::Usage, message))
    };
    if !RunReader::is_run(folder) {
        return match run::tables(folder).unwrap_or_default().first() {
            Some(table) => {
                refuse(format!("is no run directory, but holds {}, which would be removed", table.display()))
            }
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
