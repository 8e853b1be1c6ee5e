//! The job of `scree rib`.

use super::frames::FramesJob;
use crate::args::RibArgs;
use crate::report::Outcome;
use std::path::PathBuf;

/// A frame to print as RIB.
pub struct RibJob {
    /// The data.
    pub frames: FramesJob,
    /// The frame.
    pub frame: u64,
    /// The file to write; standard output if not given.
    pub output: Option<PathBuf>,
}

impl RibJob {
    /// Check the arguments.
    pub fn check(args: RibArgs) -> Outcome<RibJob> {
        Ok(RibJob { frames: FramesJob::open(&args.input)?, frame: args.frame, output: args.output })
    }
}
