//! Progress: a bar on a terminal, a plain line now and then elsewhere; both on standard error.

use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Progress of one thing that takes a while.
pub struct Progress {
    what: String,
    total: u64,
    bar: Option<ProgressBar>,
    started: Instant,
    said: Mutex<Instant>,
}

/// How often a plain line is printed.
const EVERY: Duration = Duration::from_secs(10);

impl Progress {
    /// Start: `what` is done `total` times.
    pub fn start(what: &str, total: u64) -> Progress {
        let bar = std::io::stderr().is_terminal().then(|| {
            let style = ProgressStyle::with_template("{msg:>12} [{bar:32}] {pos}/{len}  {elapsed} elapsed, {eta} left");
            ProgressBar::new(total)
                .with_style(style.unwrap_or(ProgressStyle::default_bar()).progress_chars("=> "))
                .with_message(what.to_string())
        });
        if bar.is_none() {
            eprintln!("{what}: {total} to do");
        }
        Progress { what: what.into(), total, bar, started: Instant::now(), said: Mutex::new(Instant::now()) }
    }

    /// So many are done.
    pub fn at(&self, done: u64) {
        match &self.bar {
            Some(bar) => bar.set_position(done),
            None => {
                let mut said = self.said.lock().unwrap_or_else(|e| e.into_inner());
                if said.elapsed() >= EVERY {
                    *said = Instant::now();
                    eprintln!(
                        "{}: {done} of {} after {:.0} s",
                        self.what,
                        self.total,
                        self.started.elapsed().as_secs_f64()
                    );
                }
            }
        }
    }

    /// All done.
    pub fn finish(&self) {
        let seconds = self.started.elapsed().as_secs_f64();
        match &self.bar {
            Some(bar) => bar.finish(),
            None => eprintln!("{}: done in {seconds:.1} s", self.what),
        }
    }
}
