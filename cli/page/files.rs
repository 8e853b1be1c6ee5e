//! Where a run is from: program, machine and model, its files with their hashes.

use super::number;
use super::view::{Figure, File};
use crate::job::RunData;
use frame::run::COMMANDS;
use std::path::Path;

/// The files of a run whose hashes stand on its page.
const FILES: [&str; 6] = ["run.json", "model.yaml", "metadata.yaml", "probes.csv", "report.csv", "plan/plan.json"];

/// Characters of a model that a page has at most.
const MAX_MODEL: usize = 100_000;

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

/// The commands that made a run.
fn commands(run: &RunData) -> Figure {
    let path = run.run.folder.join(COMMANDS);
    let note = "`scree simulate model.yaml`, of the file below, makes the run again";
    let text = if guard::leads_out(&path, &run.run.folder) { None } else { guard::read(&path).ok() };
    match text.map(|bytes| String::from_utf8_lossy(&bytes).into_owned()).filter(|text| !text.trim().is_empty()) {
        Some(text) => Figure::new("commands", text.lines().collect::<Vec<_>>().join("; then ")).noted(note),
        None => Figure::new("commands", "not recorded").noted(note),
    }
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
