//! The job of `scree init`.

use crate::args::{InitArgs, StarterArg};
use crate::report::Outcome;
use std::path::PathBuf;

/// A project to lay.
pub struct InitJob {
    /// Its folder.
    pub folder: PathBuf,
    /// What it begins as.
    pub starter: Starter,
}

/// A project to start from.
#[derive(Clone, Copy, Debug)]
pub enum Starter {
    /// Stones that fall into a box.
    Drop,
    /// A blade that is drawn through grains.
    Plough,
}

impl InitJob {
    /// Check the arguments.
    pub fn check(args: InitArgs) -> Outcome<InitJob> {
        let starter = match args.starter {
            StarterArg::Drop => Starter::Drop,
            StarterArg::Plough => Starter::Plough,
        };
        Ok(InitJob { folder: args.folder, starter })
    }
}
