//! Errors in files, with their place: the error type of all readers of input.

use std::fmt;
use std::path::{Path, PathBuf};

/// The cause of a fault: a file that a person wrote, data that a program wrote, or the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaultKind {
    /// A model, metadata or other hand-written file.
    Input,
    /// Data: a table or a run directory.
    Data,
    /// The machine: a full disk, an unwritable folder.
    Machine,
}

/// An error in a file, with its place. Its text shows the offending line with a caret under the column.
#[derive(Clone, Debug)]
pub struct Fault {
    /// Cause of the fault.
    pub kind: FaultKind,
    /// Path of the file.
    pub file: PathBuf,
    /// Line, from 1; 0 for the file as a whole.
    pub line: usize,
    /// Column, from 1; 0 for the file as a whole.
    pub column: usize,
    /// The offending line as it stands in the file; empty if there is none.
    pub text: String,
    /// What is wrong and what was expected.
    pub message: String,
    /// Advice on how to correct the fault, if any.
    pub hint: Option<String>,
}

impl Fault {
    /// A fault at a line and column (from 1) of a file, whose whole content is `text`.
    pub fn at(
        kind: FaultKind,
        file: &Path,
        text: &str,
        line: usize,
        column: usize,
        message: impl Into<String>,
    ) -> Fault {
        let quoted = text.lines().nth(line.saturating_sub(1)).unwrap_or("").to_string();
        Fault {
            kind,
            file: file.into(),
            line: line.max(1),
            column: column.max(1),
            text: quoted,
            message: message.into(),
            hint: None,
        }
    }

    /// A fault of a file as a whole, without a line.
    pub fn whole(kind: FaultKind, file: &Path, message: impl Into<String>) -> Fault {
        Fault { kind, file: file.into(), line: 0, column: 0, text: String::new(), message: message.into(), hint: None }
    }

    /// The fault in a file of whose text the fault's own was a part, after a number of lines.
    pub fn moved(mut self, lines: usize) -> Fault {
        self.line += if self.line > 0 { lines } else { 0 };
        self
    }

    /// Add advice on how to correct the fault.
    pub fn hint(mut self, hint: impl Into<String>) -> Fault {
        self.hint = Some(hint.into());
        self
    }

    /// The fault of a file that could not be read.
    pub fn unreadable(kind: FaultKind, file: &Path, error: &std::io::Error) -> Fault {
        Fault::whole(kind, file, format!("cannot be read: {error}"))
    }

    /// The fault of a file that could not be written; its cause is [`FaultKind::Machine`].
    pub fn unwritable(file: &Path, error: &std::io::Error) -> Fault {
        Fault::whole(FaultKind::Machine, file, format!("cannot be written: {error}"))
            .hint("check that the folder exists, may be written to, and that the disk is not full")
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:", self.file.display())?;
        if self.line > 0 {
            write!(f, "{}:{}:", self.line, self.column)?;
        }
        write!(f, " {}", self.message)?;
        if !self.text.is_empty() {
            let (text, before) = window(&self.text, self.column);
            write!(f, "\n  | {text}\n  | {}^", " ".repeat(before))?;
        }
        if let Some(hint) = &self.hint {
            write!(f, "\n  = {hint}")?;
        }
        Ok(())
    }
}

impl std::error::Error for Fault {}

/// Read a whole file; `-` is the standard input. A fault of the given kind if it cannot be read.
pub fn read_bytes(kind: FaultKind, path: &Path) -> Result<Vec<u8>, Fault> {
    let bytes = if path == Path::new("-") { guard::read_stdin() } else { guard::read(path) };
    bytes.map_err(|e| Fault::unreadable(kind, path, &e))
}

/// Read a whole text file; `-` is the standard input. A fault of the given kind if it cannot be read, or, with the place of the
/// first bad byte, if it is not UTF-8.
pub fn read_text(kind: FaultKind, path: &Path) -> Result<String, Fault> {
    let bytes = read_bytes(kind, path)?;
    String::from_utf8(bytes).map_err(|e| {
        let good = &e.as_bytes()[..e.utf8_error().valid_up_to()];
        let line = 1 + good.iter().filter(|b| **b == b'\n').count();
        let column = 1 + good.iter().rev().take_while(|b| **b != b'\n').count();
        Fault::at(kind, path, "", line, column, "is not UTF-8 text")
    })
}

/// The part of a line around a column (from 1) that fits a terminal, and how many characters of it are before the column.
fn window(line: &str, column: usize) -> (String, usize) {
    const WIDTH: usize = 110;
    let at = column.saturating_sub(1).min(line.chars().count());
    let first = at.saturating_sub(WIDTH / 2);
    // A control character in the line must not move the mark.
    let shown = line.chars().skip(first).take(WIDTH).map(|c| if c.is_control() { ' ' } else { c });
    (shown.collect(), at - first)
}

/// The candidate nearest in spelling to `name`, if any is near enough for `name` to be a likely misspelling of it: one of the same words in another order
/// (`torque_max`) comes first.
pub fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    /// The words of a name, sorted.
    fn words(name: &str) -> Vec<&str> {
        let mut words: Vec<&str> = name.split(['_', '-', ' ', '.']).collect();
        words.sort_unstable();
        words
    }
    let own = name.to_lowercase();
    let own_words = words(&own);
    candidates
        .into_iter()
        .map(|c| {
            let lower = c.to_lowercase();
            let is_reordered = own_words.len() > 1 && words(&lower) == own_words;
            (if is_reordered { 0 } else { strsim::damerau_levenshtein(&own, &lower) }, c)
        })
        .filter(|(d, c)| *d <= 1 + name.len().max(c.len()) / 3)
        .min_by_key(|(d, _)| *d)
        .map(|(_, c)| c)
}

#[cfg(test)]
mod tests {
    use super::nearest;

    #[test]
    fn words_in_another_order_are_nearest() {
        let keys = ["torque", "max_force", "max_torque"];
        for (name, expected) in [("torque_max", "max_torque"), ("toruqe", "torque"), ("max-force", "max_force")] {
            assert_eq!(nearest(name, keys), Some(expected), "{name}");
        }
        assert_eq!(nearest("colour", keys), None);
    }
}
