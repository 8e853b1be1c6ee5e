//! Geometric primitives: made from the calls of the interface, split and diced to grids of micropolygons.

pub mod blobby;
pub mod patch;
pub mod sphere;
pub mod subdivision;
pub mod surfaces;
pub mod trim;
pub mod variables;
