//! What shading functions compute: plain functions of numbers and of runs of numbers, which know neither the IR nor the scene.

pub mod color;
pub mod direction;
pub mod format;
pub mod matrix;
pub mod noise;
pub mod number;
pub mod runs;
pub mod spline;
