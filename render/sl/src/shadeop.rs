//! What shading functions compute: plain functions of numbers and of runs of numbers, which know neither the IR nor the scene.

pub mod call;
pub mod color;
pub mod direction;
pub mod format;
pub mod grid;
pub mod matrix;
pub mod noise;
pub mod number;
pub mod numbers;
pub mod pattern;
pub mod runs;
pub mod spline;
pub mod triple;
pub mod wide;
