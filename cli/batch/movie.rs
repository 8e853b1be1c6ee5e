//! The movie of a film, as `plan/movie.json` has it: its file, and the images that it was made of.

use super::plan::Plan;
use crate::ledger::{Ledger, hash_of};
use frame::Fault;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::path::{Path, PathBuf};

/// A movie that has been made; none was where the images are no movie's.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Movie {
    /// Its file, in the film's folder, with its size and blake3 hash.
    file: Option<(PathBuf, u64, String)>,
    /// Hash of the images.
    images: String,
}

/// How the movie of a film stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MovieStanding {
    /// It is what was made, of the images that are there.
    Done,
    /// There is none.
    Missing,
    /// Its file is not what was made.
    Damaged,
    /// The images are others.
    Stale,
}

impl fmt::Display for MovieStanding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            MovieStanding::Done => "up to date",
            MovieStanding::Missing => "not there",
            MovieStanding::Damaged => "not as it was written",
            MovieStanding::Stale => "stale: it was made of other images, or at another rate",
        })
    }
}

fn path(home: &Path) -> PathBuf {
    Plan::folder(home).join("movie.json")
}

/// A hash of the images of these files, by what the ledger has of them.
pub fn images<'a>(ledger: &Ledger, files: impl Iterator<Item = &'a str>) -> String {
    let mut hasher = blake3::Hasher::new();
    for file in files {
        let hash = ledger.entry(file).map(|entry| entry.blake3).unwrap_or_default();
        hasher.update(file.as_bytes()).update(&[0]).update(hash.as_bytes());
    }
    hasher.finalize().to_hex().to_string()
}

impl Movie {
    /// Record the movie of a film, or that its images make none.
    pub fn record(home: &Path, file: Option<&Path>, images: String) -> Result<(), Fault> {
        let of_file = |file: &Path| {
            let bytes = file.metadata().map_or(0, |m| m.len());
            (file.file_name().unwrap_or_default().into(), bytes, hash_of(file).unwrap_or_default())
        };
        let movie = Movie { file: file.map(of_file), images };
        frame::atomic::write(&path(home), &serde_json::to_vec(&movie).unwrap_or_default())
    }

    /// How the movie of a film stands by the size of its file, and where `images` are known, by all.
    pub fn standing(home: &Path, images: Option<&str>) -> MovieStanding {
        let movie = std::fs::read(path(home)).ok().and_then(|bytes| serde_json::from_slice::<Movie>(&bytes).ok());
        let Some(movie) = movie else { return MovieStanding::Missing };
        if images.is_some_and(|images| images != movie.images) {
            return MovieStanding::Stale;
        }
        let Some((file, bytes, hash)) = movie.file else { return MovieStanding::Done };
        let file = home.join(file);
        match file.metadata() {
            Err(_) => MovieStanding::Missing,
            Ok(m) if m.len() != bytes || images.is_some() && hash_of(&file) != Some(hash) => MovieStanding::Damaged,
            Ok(_) => MovieStanding::Done,
        }
    }
}
