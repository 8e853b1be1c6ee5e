//! Warnings about a scene, each kept once.

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

/// Where a scene's file is read, if it is: the line and column of a request.
#[derive(Default)]
struct Place {
    file: PathBuf,
    spot: Option<(usize, usize)>,
}

impl Warnings {
    /// Add a warning that is not there yet, with the place that is read.
    pub fn add(&self, message: String) {
        let place = lock(&self.place);
        let placed = match place.spot {
            Some((line, column)) => format!("{}:{line}:{column}: {message}", place.file.display()),
            None => message.clone(),
        };
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
        let mut place = lock(&self.place);
        place.spot = at.map(|(_, spot)| spot);
        if let Some((file, _)) = at.filter(|(file, _)| *file != place.file) {
            place.file = file.into();
        }
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
