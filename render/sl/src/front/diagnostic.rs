//! Errors and their places.

/// An error in a shader, with its file, line and column.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnostic {
    /// The shader's file.
    pub file: std::path::PathBuf,
    /// Line, from 1.
    pub line: usize,
    /// Column, from 1.
    pub column: usize,
    /// The line as it stands in the file.
    pub text: String,
    /// What is wrong and what was expected.
    pub message: String,
    /// A possible correction, if one is known.
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

/// An error, and how it may be corrected.
pub(crate) fn error_with<T>(at: usize, message: impl Into<String>, hint: impl Into<String>) -> Result<T, Error> {
    Err(Error { hint: Some(hint.into()), ..Error::new(at, message) })
}
