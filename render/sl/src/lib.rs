//! The RenderMan shading language: front end, typed IR, and the grid machine.
//!
//! [`compile`] takes the text of a shader through lexer, parser, and check-and-lower to an [`ir::Program`], whose
//! invariants [`ir::validate`] holds before any back end sees it. [`machine::Machine`] runs a program over a whole grid of
//! points at a time. Nothing here knows what renders: what a shader asks of the scene goes through [`machine::Scene`].

mod ast;
mod builtins;
pub mod ir;
mod lanes;
mod lex;
mod lower;
pub mod machine;
pub mod noise;
mod parse;

use std::path::Path;

/// What is wrong with a shader, and where; line and column count from 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnostic {
    /// The shader's file.
    pub file: std::path::PathBuf,
    /// Line.
    pub line: usize,
    /// Column.
    pub column: usize,
    /// The line as it stands in the file.
    pub text: String,
    /// What is wrong and what was expected.
    pub message: String,
}

impl std::fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}:{}:{}: {}", self.file.display(), self.line, self.column, self.message)
    }
}

impl std::error::Error for Diagnostic {}

/// A message and the byte of the source that it is about.
#[derive(Clone, Debug)]
pub(crate) struct Error {
    pub at: usize,
    pub message: String,
}

pub(crate) fn error<T>(at: usize, message: impl Into<String>) -> Result<T, Error> {
    Err(Error { at, message: message.into() })
}

/// Compile the shader in `source`, which came from `path`.
pub fn compile(path: &Path, source: &str) -> Result<ir::Program, Diagnostic> {
    let place = |e: Error| {
        let at = e.at.min(source.len());
        let before = &source.as_bytes()[..at];
        let line_start = before.iter().rposition(|b| *b == b'\n').map_or(0, |i| i + 1);
        let line = 1 + before.iter().filter(|b| **b == b'\n').count();
        let text = source.lines().nth(line - 1).unwrap_or("").to_string();
        Diagnostic { file: path.into(), line, column: 1 + at - line_start, text, message: e.message }
    };
    if source.trim().is_empty() {
        return Err(place(Error { at: 0, message: "is empty, expected a shader".into() }));
    }
    let tokens = lex::lex(source).map_err(place)?;
    let prelude =
        parse::parse(&lex::lex(builtins::PRELUDE).expect("the prelude is sound")).expect("the prelude is sound");
    let file = parse::parse(&tokens).map_err(place)?;
    let program = lower::lower(&file, &prelude.functions).map_err(place)?;
    ir::validate(&program).map_err(|m| place(Error { at: 0, message: format!("internal: {m}") }))?;
    Ok(program)
}
