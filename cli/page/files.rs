//! Where a run is from: program, machine and model, its files with their hashes.

use super::number;
use super::view::{Figure, File};
use crate::job::RunData;
use frame::run::COMMANDS;
use std::collections::BTreeMap;
use std::path::Path;

/// The files of a run whose hashes stand on its page.
const FILES: [&str; 6] = ["run.json", "model.yaml", "metadata.yaml", "probes.csv", "report.csv", "plan/plan.json"];

/// Characters of a model that a page has at most.
const MAX_MODEL: usize = 100_000;

/// Different values of the runs of a sweep that are listed.
const LISTED: usize = 4;

/// What is recorded of a run.
pub fn provenance(run: &RunData) -> Vec<Figure> {
    let index = &run.run.index;
    vec![
        Figure::new("simulated by", &index.program),
        Figure::new("page made by", concat!("scree ", env!("CARGO_PKG_VERSION"))),
        Figure::new("model hash", &index.model_hash).noted("BLAKE3 of the resolved model without its duration"),
        Figure::new("back end", &index.backend),
        Figure::new("machine", &index.adapter).noted("as the run recorded it"),
        Figure::new("seed", index.seed.to_string()),
        Figure::new("units", &index.units),
        commands(run),
    ]
}

/// What is recorded of the runs of a sweep: what they have in common, and where they differ.
pub fn provenance_of(runs: &[RunData]) -> Vec<Figure> {
    let shared = |name: &str, of: fn(&RunData) -> String| {
        let mut counts: BTreeMap<String, usize> = BTreeMap::new();
        runs.iter().for_each(|run| *counts.entry(of(run)).or_default() += 1);
        let some = |(value, n): (&String, &usize)| format!("{value} ({})", number::counted(*n as u64, "run"));
        match counts.len() {
            1 => Figure::new(name, counts.keys().next().cloned().unwrap_or_default()).noted("of all runs"),
            n if n <= LISTED => {
                Figure::new(name, counts.iter().map(some).collect::<Vec<_>>().join(", ")).noted("they differ")
            }
            n => Figure::new(name, format!("{n} different ones")),
        }
    };
    let mut facts = vec![
        shared("simulated by", |run| run.run.index.program.clone()),
        Figure::new("page made by", concat!("scree ", env!("CARGO_PKG_VERSION"))),
        shared("model hash", |run| run.run.index.model_hash.clone()),
        shared("back end", |run| run.run.index.backend.clone()),
        shared("machine", |run| run.run.index.adapter.clone()),
        shared("seed", |run| run.run.index.seed.to_string()),
        shared("step", |run| number::quantity(run.run.index.step_size, "s")),
        shared("units", |run| run.run.index.units.clone()),
        shared("commands", |run| text_of_commands(run).unwrap_or_else(|| "not recorded".into())),
    ];
    facts.retain(|fact| !fact.value.is_empty());
    facts
}

/// The commands that made a run.
fn commands(run: &RunData) -> Figure {
    let note = "`scree simulate model.yaml`, of the file below, makes the run again";
    Figure::new("commands", text_of_commands(run).unwrap_or_else(|| "not recorded".into())).noted(note)
}

/// The commands in a run's folder, one behind the other.
fn text_of_commands(run: &RunData) -> Option<String> {
    let path = run.run.folder.join(COMMANDS);
    let bytes = if guard::leads_out(&path, &run.run.folder) { None } else { guard::read(&path).ok() }?;
    let text = String::from_utf8_lossy(&bytes).lines().collect::<Vec<_>>().join("; then ");
    (!text.trim().is_empty()).then_some(text)
}

/// The files of a run with their hashes; what cannot be read is added to `faults`.
pub fn files(run: &RunData, faults: &mut Vec<String>) -> Vec<File> {
    let folder = &run.run.folder;
    let mut files = vec![];
    let names =
        FILES.iter().map(|name| folder.join(name)).filter(|path| path.is_file() && !guard::leads_out(path, folder));
    for path in names.chain(run.films.iter().cloned()) {
        let name = path.strip_prefix(folder).unwrap_or(&path).to_string_lossy().into_owned();
        match hash(&path) {
            Ok((size, hash)) => {
                let note = note(run, &name, &hash);
                files.push(File { name, size: number::size(size), hash, note });
            }
            Err(e) => faults.push(format!("{}: {e}", path.display())),
        }
    }
    let frames = &run.run.index.frames;
    if let Some(last) = frames.last() {
        let size: u64 = frames.iter().filter_map(|f| folder.join(&f.file).metadata().ok()).map(|m| m.len()).sum();
        files.push(File {
            name: format!("frames: {} to {}", frames[0].file, last.file),
            size: number::size(size),
            hash: String::new(),
            note: "run.json has the hash of each".into(),
        });
    }
    files
}

/// What is to be known of a file.
fn note(run: &RunData, name: &str, hash: &str) -> String {
    match run.run.index.generated.get(name) {
        Some(written) if written == hash => "as it was written".into(),
        Some(_) => "edited since it was written".into(),
        None => String::new(),
    }
}

fn hash(path: &Path) -> std::io::Result<(u64, String)> {
    let mut hasher = blake3::Hasher::new();
    hasher.update_reader(guard::open(path)?)?;
    Ok((hasher.count(), hasher.finalize().to_hex().to_string()))
}

/// The text of a run's model, or its beginning.
pub fn model(run: &RunData) -> Option<String> {
    let path = run.run.folder.join("model.yaml");
    // A page is handed on: what a link leads to is no part of the run.
    let text = guard::read_to_string(&path).ok().filter(|_| !guard::leads_out(&path, &run.run.folder))?;
    if text.len() <= MAX_MODEL {
        return Some(text);
    }
    let end = text.floor_char_boundary(MAX_MODEL);
    Some(format!("{}\n… {} more", &text[..end], number::size((text.len() - end) as u64)))
}
