//! The film: sample positions, pixel filters, buckets and shards, displays, and image files.

pub mod bucket;
pub mod display;
pub mod filter;
pub mod image;
pub mod jitter;
