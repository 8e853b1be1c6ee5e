//! Geometric primitives: made from the calls of the interface, bounded, split and diced to grids of micropolygons.

pub mod basis;
pub mod blobby;
pub mod bound;
pub mod curves;
pub mod dice;
pub mod grid;
pub mod nurbs;
pub mod patch;
pub mod patch_mesh;
pub mod perspective;
pub mod polygon;
pub mod quadric;
pub mod sphere;
pub mod split;
pub mod subdivision;
pub mod teapot;
pub mod trim;
pub mod variables;
