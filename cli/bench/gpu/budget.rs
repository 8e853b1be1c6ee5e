//! The time of a benchmark, of which a part that is expected to take longer than what is left is left out; and its result so far.

use crate::interrupt::Listener;
use serde_json::{Value, json};
use sim::gpu::Fault;
use std::cell::RefCell;
use std::collections::HashMap;
use std::path::Path;
use std::time::Instant;

/// The time that there is, and how long what was measured has taken.
pub struct Budget {
    until: Instant,
    listener: Listener,
    /// The last of each kind: its size, and the time that it took, s.
    taken: RefCell<HashMap<String, (usize, f64)>>,
}

impl Budget {
    /// Until a time, or an interruption.
    pub fn new(until: Instant) -> Budget {
        Budget { until, listener: Listener::new(), taken: RefCell::default() }
    }

    /// Whether the benchmark was interrupted.
    pub fn is_interrupted(&self) -> bool {
        self.listener.is_requested()
    }

    /// Whether what is under way is to end.
    pub fn is_over(&self) -> bool {
        self.is_interrupted() || Instant::now() >= self.until
    }

    /// Why something of a kind and size is left out, if it is: the last of its kind tells how long it may take.
    pub fn left_out(&self, kind: &str, n: usize) -> Option<String> {
        if self.is_interrupted() {
            return Some("the benchmark was interrupted".into());
        }
        let left = self.until.saturating_duration_since(Instant::now()).as_secs_f64();
        let expected = self.taken.borrow().get(kind).map_or(0.0, |taken| expected(*taken, n));
        let is_left_out = left == 0.0 || expected > left;
        is_left_out.then(|| format!("it may take {expected:.0} s, and {left:.0} s of the benchmark's time are left"))
    }

    /// Measure something of a kind and size, and note how long it takes.
    ///
    /// # Errors
    /// Those of what is measured.
    pub fn measure<T>(&self, kind: &str, n: usize, run: impl FnOnce() -> Result<T, Fault>) -> Result<T, Fault> {
        let started = Instant::now();
        let measured = run()?;
        self.taken.borrow_mut().insert(kind.to_string(), (n, started.elapsed().as_secs_f64()));
        Ok(measured)
    }
}

/// The time that something of a size may take, s, by that of another.
fn expected((size, seconds): (usize, f64), n: usize) -> f64 {
    /// Time that does not grow with the size, at most, s: a device is opened, and kernels are compiled.
    const FIXED: f64 = 3.0;
    let fixed = FIXED.min(seconds);
    fixed + (seconds - fixed) * n as f64 / size as f64
}

/// The result so far.
pub struct Report<'a> {
    /// All of it.
    pub value: Value,
    out: Option<&'a Path>,
}

impl Report<'_> {
    /// Begin with the head, for a file where it is written after each row.
    pub fn new(head: Value, out: Option<&Path>) -> Report<'_> {
        Report { value: head, out }
    }

    /// Add a row to a part, and write all to the file, whole.
    ///
    /// # Errors
    /// [`Fault::Unsupported`] where the file cannot be written.
    pub fn add(&mut self, part: &str, row: Value) -> Result<(), Fault> {
        if let Some(Value::Array(rows)) = self.value.as_object_mut().map(|all| all.entry(part).or_insert(json!([]))) {
            rows.push(row);
        }
        let Some(out) = self.out else { return Ok(()) };
        let written = frame::atomic::write(out, format!("{}\n", self.value).as_bytes());
        written.map_err(|fault| Fault::Unsupported(fault.to_string()))
    }
}

#[cfg(test)]
mod tests {
    use super::{Budget, Report, expected};
    use serde_json::json;
    use std::time::{Duration, Instant};

    #[test]
    fn what_would_take_too_long_is_left_out() {
        assert_eq!(expected((1000, 2.0), 50_000), 2.0);
        assert_eq!(expected((1000, 5.0), 10_000), 23.0);
        let budget = Budget::new(Instant::now() + Duration::from_secs(20));
        assert!(budget.left_out("sort", 1000).is_none() && !budget.is_over());
        budget.taken.borrow_mut().insert("sort".into(), (1000, 5.0));
        assert!(budget.left_out("sort", 2000).is_none());
        let why = budget.left_out("sort", 10_000).unwrap();
        assert!(why.starts_with("it may take 23 s, and "), "{why}");
        assert!(budget.left_out("scan", 10_000).is_none());
        let over = Budget::new(Instant::now());
        assert!(over.is_over() && over.left_out("scan", 1).is_some());
    }

    #[test]
    fn the_file_has_all_rows_so_far() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("gpu.json");
        let mut report = Report::new(json!({ "adapter": "none" }), Some(&out));
        for n in 1..=2 {
            report.add("steps", json!({ "n": n })).unwrap();
            let read: serde_json::Value = serde_json::from_slice(&std::fs::read(&out).unwrap()).unwrap();
            assert_eq!(read, report.value);
            assert_eq!(read["steps"].as_array().unwrap().len(), n);
        }
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
