//! What went wrong, as the user reads it, and the exit code that says it to a script.

use bind::emit::EmitError;
use frame::{Fault, FaultKind};
use render::ri::reader::RibError;
use render::sl::Diagnostic;
use std::fmt;

/// Exit codes that mean something.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// A fault of the program or the machine.
    Fault = 1,
    /// The command line.
    Usage = 2,
    /// A bad input file.
    Input = 3,
    /// Bad data.
    Data = 4,
    /// Partly done.
    Partial = 5,
}

/// A failure of a command.
#[derive(Debug)]
pub struct Failure {
    /// The exit code.
    pub exit: Exit,
    /// What the user reads.
    pub message: String,
}

/// What commands answer.
pub type Outcome<T = ()> = Result<T, Failure>;

impl Failure {
    /// A failure.
    pub fn new(exit: Exit, message: impl Into<String>) -> Failure {
        Failure { exit, message: message.into() }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl From<Fault> for Failure {
    fn from(fault: Fault) -> Failure {
        let exit = match fault.kind {
            FaultKind::Input => Exit::Input,
            FaultKind::Data => Exit::Data,
            FaultKind::Machine => Exit::Fault,
        };
        Failure::new(exit, fault.to_string())
    }
}

impl From<RibError> for Failure {
    fn from(e: RibError) -> Failure {
        let p = e.place;
        let fault = Fault {
            kind: FaultKind::Input,
            file: p.file,
            line: p.line,
            column: p.column,
            text: e.text,
            message: e.message,
            hint: None,
        };
        fault.into()
    }
}

impl From<Diagnostic> for Failure {
    fn from(d: Diagnostic) -> Failure {
        let Diagnostic { file, line, column, text, message, hint } = d;
        Fault { kind: FaultKind::Input, file, line, column, text, message, hint }.into()
    }
}

impl From<EmitError> for Failure {
    fn from(e: EmitError) -> Failure {
        match e {
            EmitError::Fault(fault) => fault.into(),
            EmitError::Rib(error) => error.into(),
        }
    }
}

/// The most memory that this process has held (Linux; 0 elsewhere).
pub fn peak_bytes() -> u64 {
    status_kib("/proc/self/status", "VmHWM").unwrap_or(0) * 1024
}

/// A value in KiB of a file in /proc.
pub fn status_kib(file: &str, key: &str) -> Option<u64> {
    let text = std::fs::read_to_string(file).ok()?;
    text.lines().find(|l| l.starts_with(key))?.split_whitespace().nth(1)?.parse().ok()
}
