//! Back ends, which run programs: the grid machine for the CPU, and WGSL for graphics devices.

mod bound;
pub mod machine;
mod points;
mod scene;
mod slots;
pub mod wgsl;
