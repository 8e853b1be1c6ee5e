//! The film: where samples lie, how they are filtered to pixels, and the displays and files that images go to.

pub mod bucket;
pub mod display;
pub mod filter;
pub mod image;
pub mod jitter;
