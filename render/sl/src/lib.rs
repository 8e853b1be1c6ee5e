//! The RenderMan shading language: front end, typed IR, and the grid machine.
//!
//! [`compile`] takes the text of a shader through lexer, parser, and check-and-lower to an [`ir::Program`], whose
//! invariants [`ir::validate`] holds before any back end sees it. [`machine::Machine`] runs a program over a whole grid of
//! points at a time. Nothing here knows what renders: what a shader asks of the scene goes through [`machine::Scene`].

mod ast;
mod builtins;
pub mod color;
pub mod ir;
mod lanes;
mod lex;
mod lower;
pub mod machine;
pub mod noise;
mod optimise;
mod parse;
mod preprocess;
mod show;
mod source;
mod spline;
mod text;

pub use lanes::spread;
pub use preprocess::Include;

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
    /// What would mend it, if that is known.
    pub hint: Option<String>,
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
    pub hint: Option<String>,
}

impl Error {
    pub fn new(at: usize, message: impl Into<String>) -> Error {
        Error { at, message: message.into(), hint: None }
    }
}

pub(crate) fn error<T>(at: usize, message: impl Into<String>) -> Result<T, Error> {
    Err(Error::new(at, message))
}

/// An error, and what would mend it.
pub(crate) fn error_with<T>(at: usize, message: impl Into<String>, hint: impl Into<String>) -> Result<T, Error> {
    Err(Error { hint: Some(hint.into()), ..Error::new(at, message) })
}

/// Compile the shader in `source`, which came from `path` and includes nothing.
pub fn compile(path: &Path, source: &str) -> Result<ir::Program, Diagnostic> {
    compile_with(path, source, &|name, _| Err(format!("`{name}` was not found: nothing is looked up here")))
}

/// Compile the shader in `source`, which came from `path`; `include` finds what `#include` names.
pub fn compile_with(path: &Path, source: &str, include: &Include<'_>) -> Result<ir::Program, Diagnostic> {
    let mut sources = source::Sources::default();
    let program = front(path, source, include, &mut sources).map_err(|e| sources.place(e))?;
    ir::validate(&program).map_err(|m| sources.place(Error::new(0, format!("internal: {m}"))))?;
    Ok(program)
}

fn front(
    path: &Path,
    source: &str,
    include: &Include<'_>,
    sources: &mut source::Sources,
) -> Result<ir::Program, Error> {
    static PRELUDE: std::sync::OnceLock<ast::File> = std::sync::OnceLock::new();
    let prelude = PRELUDE.get_or_init(|| {
        parse::parse(&lex::lex(builtins::PRELUDE).expect("the prelude is sound")).expect("the prelude is sound")
    });
    let tokens = preprocess::preprocess(path, source, sources, include)?;
    if source.trim().is_empty() {
        return error(0, "is empty, expected a shader");
    }
    let file = parse::parse(&tokens)?;
    let mut program = lower::lower(&file, &prelude.functions)?;
    optimise::optimise(&mut program);
    Ok(program)
}
