//! The job of `scree doctor`.

use crate::args::DoctorArgs;
use crate::report::{Exit, Failure, Outcome};
use std::path::PathBuf;

/// What to find out of the machine.
pub struct DoctorJob {
    /// The folder that results would go to.
    pub folder: PathBuf,
    /// Whether JSON is printed.
    pub json: bool,
}

impl DoctorJob {
    /// Check the arguments.
    pub fn check(args: DoctorArgs) -> Outcome<DoctorJob> {
        if !args.folder.is_dir() {
            let message = format!("{}: there is no such folder", args.folder.display());
            return Err(Failure::new(Exit::Usage, message));
        }
        Ok(DoctorJob { folder: args.folder, json: args.json })
    }
}
