//! Progress on standard error: a bar on a terminal, elsewhere a line every ten seconds. Of work that goes on side by side each has a bar.

use crate::print;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Progress of a task.
pub struct Progress {
    task: String,
    total: u64,
    unit: &'static str,
    bar: Option<ProgressBar>,
    started: Instant,
    last_line: Mutex<Instant>,
}

/// Time between two lines.
const INTERVAL: Duration = Duration::from_secs(10);

impl Progress {
    /// Start the progress of a task of `total` steps, which have a unit such as `frames`.
    pub fn start(task: &str, total: u64, unit: &'static str) -> Progress {
        let bar = std::io::stderr().is_terminal().then(|| {
            let style = ProgressStyle::with_template(&format!(
                "{{msg:>12}} [{{bar:32}}] {{pos}}/{{len}} {unit}  {{elapsed}} elapsed, {{eta}} left"
            ));
            let bar = ProgressBar::new(total)
                .with_style(style.unwrap_or(ProgressStyle::default_bar()).progress_chars("=> "))
                .with_message(task.to_string());
            let bar = print::bars().add(bar);
            bar.tick();
            bar
        });
        if bar.is_none() {
            eprintln!("{task}: 0 of {total} {unit}");
        }
        Progress { task: task.into(), total, unit, bar, started: Instant::now(), last_line: Mutex::new(Instant::now()) }
    }

    /// Show that `done` steps are done.
    pub fn at(&self, done: u64) {
        match &self.bar {
            Some(bar) => bar.set_position(done),
            None => {
                let mut last_line = self.last_line.lock().unwrap_or_else(|e| e.into_inner());
                if last_line.elapsed() >= INTERVAL {
                    *last_line = Instant::now();
                    eprintln!(
                        "{}: {done} of {} {} after {:.0} s",
                        self.task,
                        self.total,
                        self.unit,
                        self.started.elapsed().as_secs_f64()
                    );
                }
            }
        }
    }

    /// Show that all steps are done: what stays is a line.
    pub fn finish(&self) {
        let seconds = self.started.elapsed().as_secs_f64();
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
            print::bars().remove(bar);
        }
        eprintln!("{}: done in {seconds:.1} s", self.task);
    }
}
