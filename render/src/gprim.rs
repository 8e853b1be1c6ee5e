//! Geometric primitives: made from the calls of the interface, bounded, split and diced to grids of micropolygons.

pub mod blobby;
pub mod bound;
pub mod dice;
pub mod grid;
pub mod patch;
pub mod sphere;
pub mod split;
pub mod subdivision;
pub mod surfaces;
pub mod trim;
pub mod variables;
