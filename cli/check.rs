//! `scree check`: faults of files and their places, without running the files.

use crate::failed::MissingValues;
use crate::job::{CheckJob, FileKind, ImageJob, ImageOptions, ShaderFile, sweep};
use crate::library;
use crate::overlay::{Overlay, Prepared};
use crate::report::{Exit, Failure, Outcome};
use crate::shader;
use crate::source::{self, Yaml};
use bind::binding::Shape;
use bind::{Moment, emit};
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
    let mut checked = vec![];
    for (path, kind) in &job.files {
        let mut said = Said::default();
        let found = check(path, *kind, &mut said);
        if job.json {
            checked.push(as_json(path, &found, &said));
        } else {
            said.warnings.iter().for_each(|w| eprintln!("warning: {w}"));
            said.notes.iter().for_each(|note| eprintln!("note: {note}"));
        }
        match found {
            Ok(noun) if !job.json => println!("{}: valid {noun}", path.display()),
            Ok(_) => {}
            Err(failure) => {
                if !job.json {
                    eprintln!("error: {failure}");
                }
                exits.push(failure.exit);
            }
        }
    }
    if job.json {
        println!("{}", serde_json::Value::from(checked));
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

/// What is said of a file beside its fault.
#[derive(Default)]
struct Said {
    warnings: Vec<String>,
    notes: Vec<String>,
}

/// What was found of a file, for programs.
fn as_json(path: &Path, found: &Outcome<&str>, said: &Said) -> serde_json::Value {
    let place = |n: usize| (n > 0).then_some(n);
    let fault = found.as_ref().err().map(|failure| match &failure.fault {
        Some(f) => serde_json::json!({
            "file": f.file, "line": place(f.line), "column": place(f.column), "message": f.message, "hint": f.hint,
        }),
        None => {
            serde_json::json!({"file": path, "line": null, "column": null, "message": failure.message, "hint": null})
        }
    });
    let kind = found.as_ref().ok();
    serde_json::json!({
        "file": path, "kind": kind, "is_valid": fault.is_none(), "fault": fault, "warnings": said.warnings, "notes": said.notes,
    })
}

/// Check a file; the noun of its kind if it has no faults.
fn check(path: &Path, kind: Option<FileKind>, said: &mut Said) -> Outcome<&'static str> {
    match kind {
        Some(FileKind::Yaml) => match source::kind_of(path)? {
            Yaml::Model => check_model(path, said).map(|()| "model"),
            Yaml::Metadata => check_metadata(path, said).map(|()| "metadata file"),
        },
        Some(FileKind::Scene) => check_scene(path, said).map(|()| "scene"),
        Some(FileKind::Shader) => shader::compile(&ShaderFile::read(path)?).map(|_| "shader"),
        None => Err(Fault::whole(FaultKind::Input, path, "is of unknown kind: expected .yaml, .rib or .sl").into()),
    }
}

fn check_model(path: &Path, said: &mut Said) -> Outcome {
    let (file, doc) = model_file::load(path, &[])?;
    let resolved = file.resolve(&doc)?;
    // Those that have a place name their file.
    let place = |w: &str| {
        if w.starts_with(&path.display().to_string()) { String::new() } else { format!("{}: ", path.display()) }
    };
    said.warnings.extend(resolved.warnings.iter().map(|w| format!("{}{w}", place(w))));
    if !file.sweep.is_empty() {
        let n = sweep::check(&file, &doc, &[])?;
        said.notes.push(format!("{}: {n} combinations of the sweep are valid", path.display()));
    }
    Ok(())
}

fn check_metadata(path: &Path, said: &mut Said) -> Outcome {
    let binding = bind::read(path)?;
    source::check_library(&binding)?;
    if binding.data.is_some() {
        let source = binding.open_data()?;
        source.files().iter().for_each(|file| guard::note(file));
        if !source.numbers().is_empty() {
            let options = ImageOptions { programs: Permission::PassOver, ..ImageOptions::default() };
            let job = ImageJob::resolve(binding, source, PathBuf::new(), &options)?;
            check_image(&job, said)?;
            job.passes.iter().try_for_each(|pass| check_image(pass, said))?;
            return Ok(());
        }
    }
    if let Some(model) = &binding.model {
        check_model(&binding.folder().join(model), said)?;
    }
    Ok(())
}

/// Check the first image of a job up to its rendering.
fn check_image(job: &ImageJob, said: &mut Said) -> Outcome {
    let frame = job.frames[0];
    let mut context = Context::new(job.files.clone()).map_err(|f| Failure::new(Exit::Input, f.message))?;
    context.dry = true;
    let image = job.image(frame);
    context.image = Some(image.to_string_lossy().into());
    let table = job.source.read(frame)?;
    let overlays = Prepared::find(&job.binding, &job.source)?;
    Overlay::of(&job.binding, &overlays, &table)?.check(job.binding.output.resolution)?;
    let moment = Moment::of(&job.binding, &job.source, &table)?;
    check_trails(job)?;
    let missing = emit::frame(&job.binding, &moment, &image.to_string_lossy(), &job.files, &mut context)?;
    let mut values = MissingValues::default();
    values.add(frame, &missing);
    said.notes.extend(values.notes());
    said.warnings.extend(values.warnings());
    said.warnings.extend(context.warnings().iter().map(|w| w.to_string()));
    Ok(())
}

/// Check that the trails of a job can be drawn: of the second frame, since the first has nothing before it.
fn check_trails(job: &ImageJob) -> Outcome {
    let has_trails = job.binding.objects.iter().any(|object| matches!(object.shape, Shape::Trail(_)));
    let Some(second) = job.source.numbers().get(1).copied().filter(|_| has_trails) else { return Ok(()) };
    let table = job.source.read(second)?;
    Moment::of(&job.binding, &job.source, &table)?;
    Ok(())
}

fn check_scene(path: &Path, said: &mut Said) -> Outcome {
    let rib = frame::read_bytes(FaultKind::Input, path)?;
    let folder = path.parent().unwrap_or(Path::new("."));
    let files = Files { programs: Permission::PassOver, ..library::files(folder) };
    let mut context = Context::new(files.clone()).map_err(|f| Failure::new(Exit::Input, f.message))?;
    context.dry = true;
    reader::read(path, &rib, &files, &mut context, &mut |_, directive| emit::take_alone(directive).map(|_| None))?;
    said.warnings.extend(context.warnings().iter().map(|w| w.to_string()));
    Ok(())
}
