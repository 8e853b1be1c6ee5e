//! Failures of commands: the message that the user reads, and the exit code that a script reads. Lines that are printed once.

use bind::emit::EmitError;
use frame::{Fault, FaultKind};
use render::ri::reader::{Place, RibError};
use render::sl::Diagnostic;
use std::collections::HashSet;
use std::fmt;

/// Exit codes of failures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// Fault of the program or of the machine.
    Fault = 1,
    /// Wrong command line.
    Usage = 2,
    /// Bad input file.
    Input = 3,
    /// Bad or missing data.
    Data = 4,
    /// Work partly done.
    Partial = 5,
    /// Interrupted by a signal.
    Interrupted = 130,
}

/// A failure of a command.
#[derive(Debug)]
pub struct Failure {
    /// The exit code.
    pub exit: Exit,
    /// The message.
    pub message: String,
    /// The fault of a file that it comes from.
    pub fault: Option<Box<Fault>>,
}

/// The result of a command, or of a part of it.
pub type Outcome<T = ()> = Result<T, Failure>;

impl Failure {
    /// Make a failure.
    pub fn new(exit: Exit, message: impl Into<String>) -> Failure {
        Failure { exit, message: message.into(), fault: None }
    }
}

/// A message in one line, for lists: without the line of a file that it quotes, and with its advice behind a semicolon.
pub fn in_one_line(message: &str) -> String {
    let mut all = String::new();
    for line in message.lines().filter(|line| !line.starts_with("  | ")) {
        match line.strip_prefix("  = ") {
            Some(advice) => all += &format!("; {advice}"),
            None if all.is_empty() => all += line,
            None => all += &format!(" {line}"),
        }
    }
    guard::text::line(&all)
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
        Failure { fault: Some(fault.clone().into()), ..Failure::new(exit, fault.to_string()) }
    }
}

impl From<RibError> for Failure {
    fn from(e: RibError) -> Failure {
        of_scene(e).into()
    }
}

/// A fault in a scene.
fn of_scene(RibError { place, text, message }: RibError) -> Fault {
    let Place { file, line, column } = place;
    Fault { kind: FaultKind::Input, file, line, column, text, message, hint: None }
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
            EmitError::Rib(error, by) => {
                of_scene(error).hint(format!("the scene is filled in by {}", by.display())).into()
            }
        }
    }
}

/// What has been printed, so that it is printed once: warnings of images are mostly those of the image before.
#[derive(Default)]
pub struct Printed(HashSet<String>);

impl Printed {
    /// Print a line, unless it has been.
    pub fn print(&mut self, line: String) {
        if !self.0.contains(&line) {
            eprintln!("{line}");
            self.0.insert(line);
        }
    }
}
