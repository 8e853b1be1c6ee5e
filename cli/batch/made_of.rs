//! What a folder of images was last made of, so that it can be verified by itself.

use super::plan::ImageChoices;
use crate::ledger::Ledger;
use frame::Fault;
use serde::{Deserialize, Serialize};
use std::path::{Component, Path, PathBuf};

/// The input and the choices of the command that made a folder of images. Paths are seen from the images where these lie within the
/// input's folder: a project that is moved or copied as a whole is verified by itself.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MadeOf {
    /// The run directory or metadata file.
    input: PathBuf,
    /// The folder of the results.
    home: PathBuf,
    /// Choices for the images.
    pub images: ImageChoices,
}

impl MadeOf {
    /// Remember that the images of a ledger are made of an input.
    pub fn write(ledger: &Ledger, input: &Path, home: &Path, images: ImageChoices) -> Result<(), Fault> {
        let made = MadeOf { input: seen_from(&ledger.images, input), home: seen_from(&ledger.images, home), images };
        let bytes = serde_json::to_vec(&made).unwrap_or_default();
        let path = ledger.made_of();
        match std::fs::read(&path) {
            Ok(there) if there == bytes => Ok(()),
            _ => frame::atomic::write(&path, &bytes),
        }
    }

    /// What the images of a ledger are made of, if that is known.
    pub fn read(ledger: &Ledger) -> Option<MadeOf> {
        let made: MadeOf = serde_json::from_slice(&std::fs::read(ledger.made_of()).ok()?).ok()?;
        let place = |path: &Path| plain(&ledger.images.join(path));
        Some(MadeOf { input: place(&made.input), home: place(&made.home), ..made })
    }

    /// The run directory or metadata file.
    pub fn input(&self) -> &Path {
        &self.input
    }

    /// The folder of the results.
    pub fn home(&self) -> &Path {
        &self.home
    }
}

/// A path as it is seen from a folder that lies within its own folder, or within itself; any other as it is.
fn seen_from(folder: &Path, path: &Path) -> PathBuf {
    let whole = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.into());
    let (folder, path) = (whole(folder), whole(path));
    let up = |inner: &Path| inner.components().map(|_| "..").collect::<PathBuf>();
    match (folder.strip_prefix(&path), path.parent().and_then(|parent| folder.strip_prefix(parent).ok())) {
        (Ok(inner), _) => up(inner),
        (_, Some(inner)) => up(inner).join(path.file_name().unwrap_or_default()),
        _ => path,
    }
}

/// A path without `..` after a name.
fn plain(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in std::path::absolute(path).unwrap_or_else(|_| path.into()).components() {
        match part {
            Component::ParentDir => drop(plain.pop()),
            part => plain.push(part),
        }
    }
    plain
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_seen_from_the_images() {
        for (folder, path, seen) in [
            ("/p/runs/md/images", "/p/md.yaml", "../../../md.yaml"),
            ("/p/runs/md/images", "/p/runs/md", ".."),
            ("/p/images", "/p/runs/a", "/p/runs/a"),
            ("/p/runs/a", "/p/runs/a", ""),
            ("/elsewhere/images", "/p/md.yaml", "/p/md.yaml"),
        ] {
            assert_eq!(seen_from(Path::new(folder), Path::new(path)), PathBuf::from(seen), "{folder} {path}");
            assert_eq!(plain(&Path::new(folder).join(seen)), PathBuf::from(path));
        }
    }
}
