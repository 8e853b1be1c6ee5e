//! The grid machine: runs a program over a whole grid of points, one operation at a time.
//!
//! A register holds one value (uniform) or one value per point (varying); a varying triple is stored as three runs: all x, all y,
//! all z. Temporaries are computed at every point; only assignments to variables depend on which points are active, and costly
//! calls skip inactive points. One machine serves one thread and is used for grid after grid, so that its memory is allocated once.

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
pub use super::points::{Message, Points};
pub use super::scene::{Emitter, Lights, MapQuery, Open, OpenPlace, Ray, Scene, Segment, open_to};
pub use super::slots::VariableSlots;
pub use state::Machine;
