//! Metadata files: [`Metadata`] is the content of a file as written, and [`check`] makes a [`crate::binding::Binding`] of it.

mod resolve;
mod types;

pub use resolve::check;
pub use types::*;
