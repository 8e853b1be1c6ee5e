//! Default places of results.

use std::path::{Path, PathBuf};

/// The stem of an input's file name, which its results are named by.
pub fn stem(input: &Path) -> String {
    input.file_stem().and_then(|s| s.to_str()).filter(|s| !s.is_empty()).unwrap_or("run").into()
}

/// The folder of an input's results if no other is given.
pub fn default_folder(input: &Path) -> PathBuf {
    Path::new("runs").join(stem(input))
}
