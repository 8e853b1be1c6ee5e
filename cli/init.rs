//! `scree init`: a small project to start from, laid into a folder.

use crate::job::{InitJob, Starter};
use crate::report::{Exit, Failure, Outcome};
use std::path::Path;

const README: &str = include_str!("starters/README.md");
const SHADER: &str = include_str!("starters/pebble.sl");

/// Run `scree init`.
pub fn run(job: InitJob) -> Outcome {
    let InitJob { folder, starter } = job;
    let is_empty = std::fs::read_dir(&folder).map_or(true, |mut entries| entries.next().is_none());
    if folder.exists() && !(folder.is_dir() && is_empty) {
        let message = format!("{} exists and is not an empty folder: give another name", folder.display());
        return Err(Failure::new(Exit::Usage, message));
    }
    let (model, metadata, summary) = files(starter);
    let whole = std::path::absolute(&folder).unwrap_or_else(|_| folder.clone());
    let name = whole.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let readme = README.replace("NAME", &guard::text::line(&name)).replace("SUMMARY", summary);
    for (file, text) in
        [("model.yaml", model), ("metadata.yaml", metadata), ("pebble.sl", SHADER), ("README.md", &readme)]
    {
        frame::atomic::write(&folder.join(file), text.as_bytes())?;
    }
    println!("{}", folder.display());
    eprintln!("next: cd {}; scree run metadata.yaml", guard::text::shell(&shown(&folder)));
    Ok(())
}

fn shown(folder: &Path) -> String {
    folder.display().to_string()
}

/// Model, metadata and summary of a starter.
fn files(starter: Starter) -> (&'static str, &'static str, &'static str) {
    match starter {
        Starter::Drop => (
            include_str!("starters/drop/model.yaml"),
            include_str!("starters/drop/metadata.yaml"),
            "stones that fall into a box.",
        ),
        Starter::Plough => (
            include_str!("starters/plough/model.yaml"),
            include_str!("starters/plough/metadata.yaml"),
            "a blade that is drawn through a bed of grains, with the force that it takes.",
        ),
    }
}
