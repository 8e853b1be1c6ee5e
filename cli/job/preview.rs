//! The job of `scree preview`.

use crate::args::PreviewArgs;
use crate::report::Outcome;
use std::ffi::OsString;

/// A preview, which a program of its own makes.
pub struct PreviewJob {
    /// Its arguments.
    pub args: Vec<OsString>,
}

impl PreviewJob {
    /// Take over the arguments, which that program checks.
    pub fn check(args: PreviewArgs) -> Outcome<PreviewJob> {
        Ok(PreviewJob { args: args.args })
    }
}
