//! The library of scenes and shaders, built into the program, and the search path that ends in it.

use include_dir::{Dir, include_dir};
use render::ri::files::Files;
use std::path::{Path, PathBuf};

static SHADERS: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/shaders");
static SCENES: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/scenes");

/// The search path of scenes and shaders: `folder`, the working folder, the library.
pub fn files(folder: &Path) -> Files {
    let mut built_in = Vec::new();
    for (name, dir) in [("shaders", &SHADERS), ("scenes", &SCENES)] {
        collect(name, dir, &mut built_in);
    }
    Files { folders: vec![folder.into(), PathBuf::from(".")], built_in, ..Files::default() }
}

/// A hash of the built-in files of a search path, hexadecimal.
pub fn hash(files: &Files) -> String {
    let mut hasher = blake3::Hasher::new();
    for (path, text) in &files.built_in {
        hasher.update(path.as_bytes()).update(&[0]).update(text.as_bytes()).update(&[0]);
    }
    hasher.finalize().to_hex().to_string()
}

fn collect(folder: &str, dir: &'static Dir<'static>, out: &mut Vec<(&'static str, &'static str)>) {
    for file in dir.files() {
        if let Some(text) = file.contents_utf8() {
            let path = format!("{folder}/{}", file.path().to_string_lossy());
            // A handful of names for the program's whole life.
            out.push((Box::leak(path.into_boxed_str()), text));
        }
    }
    dir.dirs().for_each(|d| collect(folder, d, out));
}
