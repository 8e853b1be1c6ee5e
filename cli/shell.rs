//! `scree completions` and `scree man`: what shells and `man` need of the command line.

use crate::job::ShellJob;
use crate::report::{Exit, Failure, Outcome};
use std::io::Write;

/// Run `scree completions` or `scree man`.
pub fn run(job: ShellJob) -> Outcome {
    for (path, text) in job.files {
        match path {
            Some(path) => {
                frame::atomic::write(&path, &text)?;
                println!("{}", path.display());
            }
            None => match std::io::stdout().lock().write_all(&text) {
                // A reader may stop early, as `head` does.
                Err(e) if e.kind() == std::io::ErrorKind::BrokenPipe => {}
                written => written.map_err(|e| Failure::new(Exit::Fault, format!("standard output: {e}")))?,
            },
        }
    }
    Ok(())
}
