//! The job of `scree check`.

use crate::args::CheckArgs;
use crate::report::Outcome;
use crate::source;
use std::path::{Path, PathBuf};

/// Files to check.
pub struct CheckJob {
    /// The files, with their kinds; none where the name tells no kind.
    pub files: Vec<(PathBuf, Option<FileKind>)>,
    /// Whether the files that they read are listed.
    pub list_files: bool,
    /// Whether JSON is printed.
    pub json: bool,
}

/// Kinds of file, as their names tell them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileKind {
    /// A model or a metadata file.
    Yaml,
    /// A RIB scene.
    Scene,
    /// A shader.
    Shader,
}

impl CheckJob {
    /// Check the arguments.
    pub fn check(args: CheckArgs) -> Outcome<CheckJob> {
        let files = args.files.into_iter().map(|path| {
            let kind = kind_of(&path);
            (path, kind)
        });
        Ok(CheckJob { files: files.collect(), list_files: args.list_files, json: args.json })
    }
}

fn kind_of(path: &Path) -> Option<FileKind> {
    if source::is_scene(path) {
        return Some(FileKind::Scene);
    }
    match path.extension()?.to_str()? {
        "yaml" | "yml" => Some(FileKind::Yaml),
        "sl" => Some(FileKind::Shader),
        _ => None,
    }
}
