//! Syntax tree → IR: names are resolved, types checked, user functions inlined.

mod call;
mod expression;
mod form;
mod inline;
mod scene;
mod shader;
mod state;
mod statement;
mod variable;

pub use shader::lower;
