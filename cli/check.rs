//! `scree check`: faults of files and their places, without running the files.

use crate::failed::MissingValues;
use crate::job::{CheckJob, FileKind, ImageJob, ImageOptions, ShaderFile, sweep};
use crate::library;
use crate::report::{Exit, Failure, Outcome};
use crate::shader;
use crate::source::{self, Yaml};
use bind::emit;
use frame::{Fault, FaultKind};
use render::Context;
use render::ri::files::{Files, Permission};
use render::ri::reader;
use sim::model_file;
use std::path::{Path, PathBuf};

/// Run `scree check`: all files are checked; the exit code is the highest of theirs.
pub fn run(job: CheckJob) -> Outcome {
    let n = job.files.len();
    let mut exits = Vec::new();
    for (path, kind) in &job.files {
        match check(path, *kind) {
            Ok(noun) => println!("{}: valid {noun}", path.display()),
            Err(failure) => {
                eprintln!("error: {failure}");
                exits.push(failure.exit);
            }
        }
    }
    if job.list_files {
        guard::seen().iter().for_each(|path| println!("{}", path.display()));
    }
    match exits.iter().max_by_key(|e| **e as u8) {
        None => Ok(()),
        Some(exit) => {
            let verb = if exits.len() == 1 { "has" } else { "have" };
            Err(Failure::new(*exit, format!("{} of {n} files {verb} faults", exits.len())))
        }
    }
}

/// Check a file; the noun of its kind if it has no faults.
fn check(path: &Path, kind: Option<FileKind>) -> Outcome<&'static str> {
    match kind {
        Some(FileKind::Yaml) => match source::kind_of(path)? {
            Yaml::Model => check_model(path).map(|()| "model"),
            Yaml::Metadata => check_metadata(path).map(|()| "metadata file"),
        },
        Some(FileKind::Scene) => check_scene(path).map(|()| "scene"),
        Some(FileKind::Shader) => shader::compile(&ShaderFile::read(path)?).map(|_| "shader"),
        None => Err(Fault::whole(FaultKind::Input, path, "is of unknown kind: expected .yaml, .rib or .sl").into()),
    }
}

fn check_model(path: &Path) -> Outcome {
    let (file, doc) = model_file::load(path, &[])?;
    let resolved = file.resolve(&doc)?;
    // Those that have a place name their file.
    let place = |w: &str| {
        if w.starts_with(&path.display().to_string()) { String::new() } else { format!("{}: ", path.display()) }
    };
    resolved.warnings.iter().for_each(|w| eprintln!("warning: {}{w}", place(w)));
    if !file.sweep.is_empty() {
        let n = sweep::check(&file, &doc, &[])?;
        println!("{}: {n} combinations of the sweep are valid", path.display());
    }
    Ok(())
}

fn check_metadata(path: &Path) -> Outcome {
    let binding = bind::read(path)?;
    source::check_library(&binding)?;
    if binding.data.is_some() {
        let source = binding.open_data()?;
        source.files().iter().for_each(|file| guard::note(file));
        if !source.numbers().is_empty() {
            let options = ImageOptions { programs: Permission::PassOver, ..ImageOptions::default() };
            let job = ImageJob::resolve(binding, source, PathBuf::new(), &options)?;
            check_image(&job)?;
            job.passes.iter().try_for_each(check_image)?;
            return Ok(());
        }
    }
    if let Some(model) = &binding.model {
        check_model(&binding.folder().join(model))?;
    }
    Ok(())
}

/// Check the first image of a job up to its rendering.
fn check_image(job: &ImageJob) -> Outcome {
    let frame = job.frames[0];
    let mut context = Context::new(job.files.clone()).map_err(|f| Failure::new(Exit::Fault, f.message))?;
    context.dry = true;
    let image = job.image(frame);
    context.image = Some(image.to_string_lossy().into());
    let missing =
        emit::frame(&job.binding, &job.source.read(frame)?, &image.to_string_lossy(), &job.files, &mut context)?;
    let mut values = MissingValues::default();
    values.add(frame, &missing);
    values.warn();
    context.warnings().iter().for_each(|w| eprintln!("warning: {w}"));
    Ok(())
}

fn check_scene(path: &Path) -> Outcome {
    let rib = frame::read_bytes(FaultKind::Input, path)?;
    let folder = path.parent().unwrap_or(Path::new("."));
    let files = Files { programs: Permission::PassOver, ..library::files(folder) };
    let mut context = Context::new(files.clone()).map_err(|f| Failure::new(Exit::Fault, f.message))?;
    context.dry = true;
    reader::read(path, &rib, &files, &mut context, &mut |_, _| Ok(()))?;
    context.warnings().iter().for_each(|w| eprintln!("warning: {w}"));
    Ok(())
}
