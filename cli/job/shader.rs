//! The job of `scree shader`.

use crate::args::ShaderArgs;
use crate::library;
use crate::report::{Exit, Failure, Outcome};
use frame::FaultKind;
use render::ri::files::Files;
use std::path::{Path, PathBuf};

/// Shaders to print.
pub struct ShaderJob {
    /// The shaders, or why one is not found.
    pub shaders: Vec<Outcome<ShaderFile>>,
    /// Whether their intermediate representation is printed.
    pub ir: bool,
    /// Whether JSON is printed.
    pub json: bool,
}

/// The text of a shader.
pub struct ShaderFile {
    /// The file, or its path in the library.
    pub path: PathBuf,
    /// The text.
    pub text: String,
    /// The search path of what it includes.
    pub files: Files,
}

impl ShaderJob {
    /// Check the arguments: find the shaders.
    pub fn check(args: ShaderArgs) -> Outcome<ShaderJob> {
        Ok(ShaderJob { shaders: args.files.iter().map(|path| find(path)).collect(), ir: args.ir, json: args.json })
    }
}

/// Find a file, or a shader of the library by its name.
fn find(path: &Path) -> Outcome<ShaderFile> {
    if path.is_file() {
        return ShaderFile::read(path);
    }
    let files = library::files(path.parent().unwrap_or(Path::new(".")));
    let mut name = path.to_string_lossy().into_owned();
    if !name.ends_with(".sl") {
        name += ".sl";
    }
    let folders = ["surface", "displacement", "light", "volume", "imager"].map(|k| format!("shaders/{k}"));
    let folders: Vec<&str> = folders.iter().map(String::as_str).collect();
    let (path, text) =
        files.read_source(&name, &folders).map_err(|m| Failure::new(Exit::Input, format!("shader {m}")))?;
    Ok(ShaderFile { path, text, files })
}

impl ShaderFile {
    /// Read a file.
    pub fn read(path: &Path) -> Outcome<ShaderFile> {
        let text = frame::read_text(FaultKind::Input, path)?;
        Ok(ShaderFile { path: path.into(), text, files: library::files(path.parent().unwrap_or(Path::new("."))) })
    }
}
