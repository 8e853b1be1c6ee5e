//! Warnings about a scene, each kept once.

use std::sync::{Mutex, MutexGuard};

/// Warnings in the order in which they came, from any thread.
#[derive(Default)]
pub struct Warnings(Mutex<Vec<String>>);

impl Warnings {
    /// Add a warning that is not there yet.
    pub fn add(&self, message: String) {
        let mut all = self.lock();
        if !all.contains(&message) {
            all.push(message);
        }
    }

    /// The warnings so far.
    pub fn list(&self) -> Vec<String> {
        self.lock().clone()
    }

    /// The warnings so far, which are removed.
    pub fn take(&self) -> Vec<String> {
        std::mem::take(&mut *self.lock())
    }

    fn lock(&self) -> MutexGuard<'_, Vec<String>> {
        self.0.lock().unwrap_or_else(|e| e.into_inner())
    }
}
