//! The front end: the text of a shader through preprocessor, lexer and parser to a syntax tree, and through checking and lowering to
//! the IR.

mod ast;
mod compile;
mod diagnostic;
mod lex;
mod lower;
mod parse;
mod prelude;
mod preprocess;
mod source;

pub use compile::{compile, compile_with};
pub use diagnostic::Diagnostic;
pub use preprocess::Include;
