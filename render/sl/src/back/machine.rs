//! The grid machine: runs a program over a whole grid of points, an operation at a time.
//!
//! A register holds one value (uniform) or one a point (varying), a triple as three runs: all x, all y, all z. Temporaries are
//! computed at every point; only assignments to variables look at which points are active, and costly calls skip the others.
//! One machine serves one thread and is used again for grid after grid, so that its memory is taken once.

mod bind;
mod call;
mod control;
mod light;
mod map;
mod number;
mod rays;
mod run;
mod state;
mod text;

pub use super::bound::{Answer, BoundShader};
pub use super::points::Points;
pub use super::scene::{Emitter, Lights, MapQuery, Ray, Scene, Segment};
pub use super::slots::VariableSlots;
pub use state::Machine;
