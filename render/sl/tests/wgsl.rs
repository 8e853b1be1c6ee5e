//! Kernels of shaders against the grid machine: the library, the corpus and shaders made to try what is hard; and what is refused.
//! Without any adapter the comparisons say so; `REQUIRE_GPU=1` makes that a failure.

#[path = "wgsl/compare.rs"]
mod compare;
#[path = "wgsl/library.rs"]
mod library;
#[path = "wgsl/text.rs"]
mod text;
#[path = "wgsl/tricky.rs"]
mod tricky;
#[path = "wgsl/world.rs"]
mod world;
