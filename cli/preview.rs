//! `scree preview`: hands over to `scree-preview`, a program of its own, as the libraries of its viewer take long to build.

use crate::job::PreviewJob;
use crate::report::{Exit, Failure, Outcome};
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

const NAME: &str = if cfg!(windows) { "scree-preview.exe" } else { "scree-preview" };

/// Run `scree preview`.
pub fn run(job: PreviewJob) -> Outcome {
    let program = program()?;
    let fault = |e: std::io::Error| Failure::new(Exit::Fault, format!("{}: {e}", program.display()));
    let status = Command::new(&program).args(job.args).status().map_err(fault)?;
    // It has said what is wrong.
    if !status.success() {
        std::process::exit(status.code().unwrap_or(Exit::Interrupted as i32));
    }
    Ok(())
}

/// Start a preview that waits for the run in a folder, and follows it.
pub fn start(run: &Path) -> Outcome<Child> {
    let program = program()?;
    let mut command = Command::new(&program);
    command.arg(run).arg("--wait").stdin(Stdio::null()).stdout(Stdio::null());
    command.spawn().map_err(|e| Failure::new(Exit::Fault, format!("{}: {e}", program.display())))
}

/// The program: beside this one, or on the `PATH`.
pub fn program() -> Outcome<PathBuf> {
    let beside = std::env::current_exe().ok().and_then(|own| Some(own.parent()?.join(NAME)));
    let path: OsString = std::env::var_os("PATH").unwrap_or_default();
    let mut places = beside.into_iter().chain(std::env::split_paths(&path).map(|folder| folder.join(NAME)));
    places.find(|place| place.is_file()).ok_or_else(|| {
        let message = "scree-preview is not installed; in the folder of scree's sources, `cargo install --locked --path preview` \
                       builds and installs it (some 35 minutes of one processor)";
        Failure::new(Exit::Fault, message)
    })
}
