//! A time series as a CSV file that grows: lines are appended several at a time, so that the cost per line does not grow with the
//! file, and a concurrent reader sees whole lines.

use crate::{Fault, FaultKind, atomic, read_text};
use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// How long lines wait to be written.
const WAIT: Duration = Duration::from_secs(1);

/// A time series that is being written. Lines wait in memory for up to about a second; those that wait are lost unless
/// [`Series::flush`] is called.
pub struct Series {
    path: PathBuf,
    file: File,
    waiting: String,
    written: Instant,
}

impl Series {
    /// Start a series in the file `path` with its header, a line with its line break. A file that exists is replaced.
    pub fn create(path: &Path, header: &str) -> Result<Series, Fault> {
        Series::begin(path, header)
    }

    /// Continue a series: lines whose value in `column` (from 0) is at most `until` stay, others and truncated lines are removed.
    /// An error if the file cannot be read or written, or if no line is left with a value of at least `from`: then some are missing.
    pub fn reopen(path: &Path, column: usize, from: f64, until: f64) -> Result<Series, Fault> {
        const REPAIR: &str = "lines were lost: simulate again with --fresh";
        let text = read_text(FaultKind::Data, path).map_err(|fault| fault.hint(REPAIR))?;
        let mut lines = text.lines();
        let header = lines.next().unwrap_or_default();
        // Names in the header may have commas, within quotes.
        let cells = |line: &str| line.split('"').step_by(2).map(|part| part.matches(',').count()).sum::<usize>();
        let stays = |line: &&str| {
            let value = line.split(',').nth(column).and_then(|c| c.parse::<f64>().ok());
            cells(line) == cells(header) && value.is_some_and(|v| v <= until)
        };
        let kept: Vec<&str> = lines.filter(stays).collect();
        let last = kept.last().and_then(|line| line.split(',').nth(column)?.parse::<f64>().ok());
        if last.unwrap_or(f64::NEG_INFINITY) < from {
            let end = last.map_or("has no lines".into(), |t| format!("ends at {t}"));
            return Err(Fault::whole(
                FaultKind::Data,
                path,
                format!("{end}, before the checkpoint, from which it goes on"),
            )
            .hint(REPAIR));
        }
        let kept: String = std::iter::once(header).chain(kept).flat_map(|l| [l, "\n"]).collect();
        Series::begin(path, &kept)
    }

    fn begin(path: &Path, text: &str) -> Result<Series, Fault> {
        atomic::write(path, text.as_bytes())?;
        let file = File::options().append(true).open(path).map_err(|e| Fault::unwritable(path, &e))?;
        Ok(Series { path: path.into(), file, waiting: String::new(), written: Instant::now() })
    }

    /// Append one or more lines, with their line breaks.
    pub fn push(&mut self, line: &str) -> Result<(), Fault> {
        self.waiting.push_str(line);
        if self.written.elapsed() > WAIT { self.flush() } else { Ok(()) }
    }

    /// Write the lines that wait in memory.
    pub fn flush(&mut self) -> Result<(), Fault> {
        self.written = Instant::now();
        let lines = std::mem::take(&mut self.waiting);
        self.file.write_all(lines.as_bytes()).map_err(|e| Fault::unwritable(&self.path, &e))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_series_goes_on_where_it_was_whole() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("s.csv");
        let text = || std::fs::read_to_string(&path).unwrap();
        let mut series = Series::create(&path, "step,time [s]\n").unwrap();
        series.push("1,0.1\n2,0.2\n").unwrap();
        series.push("3,0.3\n").unwrap();
        series.flush().unwrap();
        assert_eq!(text(), "step,time [s]\n1,0.1\n2,0.2\n3,0.3\n");
        // Cut off in its last line.
        std::fs::write(&path, "step,time [s]\n1,0.1\n2,0.2\n3").unwrap();
        let mut series = Series::reopen(&path, 1, 0.15, 0.25).unwrap();
        series.push("3,0.3\n").unwrap();
        series.flush().unwrap();
        assert_eq!(text(), "step,time [s]\n1,0.1\n2,0.2\n3,0.3\n");
        drop(Series::reopen(&path, 1, 0.0, 0.15).unwrap());
        assert_eq!(text(), "step,time [s]\n1,0.1\n");
        assert!(Series::reopen(&path, 1, 0.15, 0.25).is_err_and(|fault| fault.message.contains("ends at 0.1")));
        std::fs::remove_file(&path).unwrap();
        assert!(Series::reopen(&path, 1, 0.15, 0.25).is_err_and(|fault| fault.hint.unwrap().contains("--fresh")));
    }
}
