//! Source texts laid end to end, so that one offset stands for a byte of any of them.

use super::diagnostic::{Diagnostic, Error};
use std::path::{Path, PathBuf};

struct Text {
    path: PathBuf,
    text: String,
    base: usize,
}

/// The texts of a compilation: the shader's own and those that it includes.
#[derive(Default)]
pub struct Sources {
    texts: Vec<Text>,
}

impl Sources {
    /// Add a text; returns the offset of its first byte.
    pub fn add(&mut self, path: &Path, text: &str) -> usize {
        let base = self.texts.last().map_or(0, |t| t.base + t.text.len() + 1);
        self.texts.push(Text { path: path.into(), text: text.into(), base });
        base
    }

    /// The file that a byte is in.
    pub fn path(&self, at: usize) -> &Path {
        &self.find(at).path
    }

    fn find(&self, at: usize) -> &Text {
        let next = self.texts.partition_point(|t| t.base <= at);
        &self.texts[next.saturating_sub(1)]
    }

    /// An error with its place.
    pub fn place(&self, e: Error) -> Diagnostic {
        let source = self.find(e.at);
        let at = (e.at - source.base).min(source.text.len());
        let before = &source.text.as_bytes()[..at];
        let line_start = before.iter().rposition(|b| *b == b'\n').map_or(0, |i| i + 1);
        let line = 1 + before.iter().filter(|b| **b == b'\n').count();
        Diagnostic {
            file: source.path.clone(),
            line,
            column: 1 + at - line_start,
            text: source.text.lines().nth(line - 1).unwrap_or("").to_string(),
            message: e.message,
            hint: e.hint,
        }
    }
}
