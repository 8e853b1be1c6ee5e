//! Shaders as WGSL: one function a shader, in a kernel that shades grids of points.
//!
//! A [`Kernel`] is a shader together with those of the lights that shine on it. Where a value depends on neighbouring points, a
//! workgroup shades a whole grid and control flow becomes masks, as in the grid machine; otherwise every point is shaded on its own.
//! Strings are known when a shader is bound, so that none is left in a kernel: what depends on them is decided before it is written.
//! What cannot be done on a device is refused by its name ([`Refused`]).
//!
//! This module emits text and tables of numbers ([`Batch`]); it knows no device. A kernel has entry point `main` and seven storage
//! buffers: groups, grids, slots, lights, values, results, status (`parts/kernel.wgsl` says what is in them).

mod batch;
mod call;
mod control;
mod gather;
mod kernel;
mod light;
mod map;
mod module;
mod op;
mod query;
mod registers;
mod specialise;
mod spline;
mod texts;
mod value;
mod writer;

pub use batch::{Batch, Extent, Fault};
pub use kernel::{Kernel, Output, Shader, Target};
pub use module::{Host, Query, Refused};
