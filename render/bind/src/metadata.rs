//! Metadata files: [`Metadata`] is what stands in one, and [`check`] makes a [`crate::binding::Binding`] of it.

mod resolve;
mod types;

pub use resolve::check;
pub use types::*;
