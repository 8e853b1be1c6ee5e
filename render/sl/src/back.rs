//! Back ends, which run programs: the grid machine for the CPU.

mod bound;
pub mod machine;
mod points;
mod scene;
mod slots;
