//! What a folder of images was last made of, so that it can be verified by itself.

use super::plan::ImageChoices;
use crate::ledger::Ledger;
use frame::Fault;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
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
    /// The frames: from, to, in steps of.
    frames: Vec<[u64; 3]>,
    /// Whether these were all frames of the data.
    pub is_all: bool,
}

impl MadeOf {
    /// Remember that the images of a ledger are made of an input: of some frames, or of all that its data has. Those that were to be
    /// made of it before are not forgotten.
    pub fn write(
        ledger: &Ledger,
        (input, home): (&Path, &Path),
        images: ImageChoices,
        (frames, is_all): (&[u64], bool),
    ) -> Result<(), Fault> {
        let mut made = MadeOf {
            input: seen_from(&ledger.images, input),
            home: seen_from(&ledger.images, home),
            images,
            frames: runs(frames.iter().copied()),
            is_all,
        };
        let bytes = std::fs::read(ledger.made_of()).unwrap_or_default();
        if let Ok(before) = serde_json::from_slice::<MadeOf>(&bytes)
            && (&before.input, &before.images) == (&made.input, &made.images)
        {
            let all: BTreeSet<u64> = before.frames().chain(frames.iter().copied()).collect();
            (made.frames, made.is_all) = (runs(all.into_iter()), is_all || before.is_all);
        }
        let now = serde_json::to_vec(&made).unwrap_or_default();
        if bytes == now { Ok(()) } else { frame::atomic::write(&ledger.made_of(), &now) }
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

    /// The frames of the images, ascending.
    pub fn frames(&self) -> impl Iterator<Item = u64> + '_ {
        self.frames.iter().flat_map(|[from, to, step]| (*from..=*to).step_by((*step).max(1) as usize))
    }
}

/// Ascending numbers as runs of even steps: from, to, in steps of.
fn runs(numbers: impl Iterator<Item = u64>) -> Vec<[u64; 3]> {
    let mut runs: Vec<[u64; 3]> = vec![];
    for number in numbers {
        match runs.last_mut() {
            Some([from, to, step]) if from == to => (*to, *step) = (number, number - *from),
            Some([_, to, step]) if number == *to + *step => *to = number,
            _ => runs.push([number, number, 1]),
        }
    }
    runs
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
    fn runs_are_the_numbers() {
        for numbers in [vec![], vec![7], vec![0, 1, 2, 3], vec![0, 500, 1000, 1001, 1002, 1010], vec![3, 5, 6, 8]] {
            let made = MadeOf {
                input: PathBuf::new(),
                home: PathBuf::new(),
                images: ImageChoices::default(),
                frames: runs(numbers.iter().copied()),
                is_all: true,
            };
            assert_eq!(made.frames().collect::<Vec<_>>(), numbers);
        }
        assert_eq!(runs((0..100_000).map(|k| k * 50)), [[0, 4_999_950, 50]]);
    }

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
