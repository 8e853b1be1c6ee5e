//! `scree check`: what is wrong with files, and where, without running them.

use crate::args::CheckArgs;
use crate::job::{self, Yaml};
use crate::library;
use crate::report::{Exit, Failure, Outcome};
use frame::{Fault, FaultKind};
use render::Context;
use render::ri::reader;
use sim::model_file;
use std::path::Path;

/// The command: every file is checked; the worst exit code counts.
pub fn command(args: &CheckArgs) -> Outcome {
    let mut bad = Vec::new();
    for path in &args.files {
        match check(path) {
            Ok(what) => println!("{}: a sound {what}", path.display()),
            Err(failure) => {
                eprintln!("error: {failure}");
                bad.push(failure.exit);
            }
        }
    }
    let n = args.files.len();
    match bad.iter().max_by_key(|e| **e as u8) {
        None => Ok(()),
        Some(exit) => Err(Failure::new(
            *exit,
            format!("{} of {n} files {} faults", bad.len(), if bad.len() == 1 { "has" } else { "have" }),
        )),
    }
}

fn check(path: &Path) -> Outcome<&'static str> {
    let folder = path.parent().unwrap_or(Path::new("."));
    let ending = if crate::render::is_scene(path) { Some("rib") } else { path.extension().and_then(|e| e.to_str()) };
    match ending {
        Some("yaml" | "yml") => match job::kind_of(path)? {
            Yaml::Model => {
                let (_, resolved) = model_file::read(path)?;
                resolved.warnings.iter().for_each(|w| eprintln!("warning: {}: {w}", path.display()));
                Ok("model")
            }
            Yaml::Metadata => {
                let checked = bind::read(path)?;
                job::check_library(&checked, &checked.files(library::files(folder)))?;
                if checked.data.is_some() {
                    let source = checked.open_data()?;
                    if let Some(first) = source.numbers().first() {
                        checked.check_columns(&source.read(*first)?)?;
                    }
                }
                if let Some(model) = &checked.model {
                    model_file::read(&checked.folder().join(model))?;
                }
                Ok("metadata file")
            }
        },
        Some("rib") => {
            let rib = frame::read_bytes(FaultKind::Input, path)?;
            let files = library::files(folder);
            let mut context = Context::new(files.clone()).map_err(|f| Failure::new(Exit::Fault, f.message))?;
            context.dry = true;
            reader::read(path, &rib, &files, &mut context, &mut |_, _| Ok(()))?;
            context.warnings().iter().for_each(|w| eprintln!("warning: {w}"));
            Ok("scene")
        }
        Some("sl") => crate::shader::compile_file(path).map(|_| "shader"),
        _ => {
            Err(Fault::whole(FaultKind::Input, path, "is of no kind that is known: expected .yaml, .rib or .sl").into())
        }
    }
}
