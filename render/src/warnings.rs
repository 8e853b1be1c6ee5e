//! Warnings about a scene, each kept once.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard};

/// Warnings in the order in which they came, from any thread.
#[derive(Default)]
pub struct Warnings {
    all: Mutex<Vec<Warning>>,
    place: Mutex<Place>,
}

/// A warning: as it was said, and with its place.
struct Warning {
    message: String,
    placed: String,
}

/// A place in a file of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Spot {
    file: u32,
    line: u32,
    column: u32,
}

/// Where a scene's files are read, if they are.
#[derive(Default)]
struct Place {
    files: Vec<PathBuf>,
    known: HashMap<PathBuf, u32>,
    spot: Option<Spot>,
    /// The file that was read last.
    file: u32,
}

impl Place {
    /// A message after a place.
    fn placed(&self, spot: Option<Spot>, message: &str) -> String {
        match spot {
            Some(Spot { file, line, column }) => {
                format!("{}:{line}:{column}: {message}", self.files[file as usize].display())
            }
            None => message.into(),
        }
    }
}

impl Warnings {
    /// Add a warning that is not there yet, with the place that is read.
    pub fn add(&self, message: String) {
        let place = lock(&self.place);
        let placed = place.placed(place.spot, &message);
        self.push(message, placed);
    }

    /// Add a warning that is not there yet, about what stands at a place.
    pub fn add_at(&self, spot: Option<Spot>, message: String) {
        let placed = lock(&self.place).placed(spot, &message);
        self.push(message, placed);
    }

    /// Add a warning that is not there yet and says its own place.
    pub fn add_placed(&self, message: String) {
        self.push(message.clone(), message);
    }

    fn push(&self, message: String, placed: String) {
        let mut all = lock(&self.all);
        if !all.iter().any(|known| known.message == message) {
            all.push(Warning { message, placed });
        }
    }

    /// Note the request that is read; none any more.
    pub fn set_place(&self, at: Option<(&Path, (usize, usize))>) {
        let place = &mut *lock(&self.place);
        place.spot = at.map(|(path, (line, column))| {
            if place.files.get(place.file as usize).is_none_or(|file| file != path) {
                place.file = place.known.get(path).copied().unwrap_or_else(|| {
                    place.files.push(path.into());
                    place.known.insert(path.into(), place.files.len() as u32 - 1);
                    place.files.len() as u32 - 1
                });
            }
            Spot { file: place.file, line: line as u32, column: column as u32 }
        });
    }

    /// The place of the request that is read.
    pub fn spot(&self) -> Option<Spot> {
        lock(&self.place).spot
    }

    /// The file of a place, and its line and column.
    pub fn place_of(&self, Spot { file, line, column }: Spot) -> (PathBuf, (usize, usize)) {
        (lock(&self.place).files[file as usize].clone(), (line as usize, column as usize))
    }

    /// The warnings so far.
    pub fn list(&self) -> Vec<String> {
        lock(&self.all).iter().map(|warning| warning.placed.clone()).collect()
    }

    /// The warnings so far, which are removed.
    pub fn take(&self) -> Vec<String> {
        std::mem::take(&mut *lock(&self.all)).into_iter().map(|warning| warning.placed).collect()
    }
}

fn lock<T>(what: &Mutex<T>) -> MutexGuard<'_, T> {
    what.lock().unwrap_or_else(|e| e.into_inner())
}
