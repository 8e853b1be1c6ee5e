//! What ends a preview early, with the exit code of `scree`.

use frame::{Fault, FaultKind};
use std::fmt;

/// A message and an exit code.
#[derive(Debug)]
pub struct Failure {
    /// The exit code: 1 of the program or machine, 2 of the command line, 3 of an input file, 4 of data, 5 of a part.
    pub exit: u8,
    message: String,
}

impl Failure {
    /// A failure of the program or the machine.
    pub fn machine(message: impl Into<String>) -> Failure {
        Failure { exit: 1, message: message.into() }
    }

    /// A failure of the command line.
    pub fn usage(message: impl Into<String>) -> Failure {
        Failure { exit: 2, message: message.into() }
    }

    /// A failure of the data.
    pub fn data(message: impl Into<String>) -> Failure {
        Failure { exit: 4, message: message.into() }
    }

    /// Work that is partly done.
    pub fn partial(message: impl Into<String>) -> Failure {
        Failure { exit: 5, message: message.into() }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&guard::text::terminal(&self.message))
    }
}

impl From<Fault> for Failure {
    fn from(fault: Fault) -> Failure {
        let exit = match fault.kind {
            FaultKind::Input => 3,
            FaultKind::Data => 4,
            FaultKind::Machine => 1,
        };
        Failure { exit, message: fault.to_string() }
    }
}

impl From<rerun::RecordingStreamError> for Failure {
    fn from(error: rerun::RecordingStreamError) -> Failure {
        Failure::machine(format!("the recording: {error}"))
    }
}
