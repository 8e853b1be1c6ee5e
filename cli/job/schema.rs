//! The job of `scree schema`.

use crate::args::{SchemaArgs, SchemaKind};
use crate::report::Outcome;
use std::path::PathBuf;

/// A schema to print.
pub struct SchemaJob {
    /// The kind of file that it describes.
    pub kind: SchemaKind,
    /// The file to write; standard output if not given.
    pub output: Option<PathBuf>,
}

impl SchemaJob {
    /// Check the arguments.
    pub fn check(args: SchemaArgs) -> Outcome<SchemaJob> {
        Ok(SchemaJob { kind: args.kind, output: args.output })
    }
}
