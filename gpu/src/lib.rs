//! Headless wgpu device, typed buffers, commands, and the primitives that simulation and rendering share.
//!
//! A [`Device`] is an adapter that is chosen by name or index. [`Kernels`] compiles WGSL once for it; [`Commands`] records many
//! dispatches, copies and clears, which are submitted together any number of times and timed by stage. Counts that kernels find stay on
//! the device ([`Count`]): dispatches over them are indirect.
//!
//! Each primitive ([`scan`], [`radix_sort`], [`reduce`], [`segments`], [`compact`]) has a CPU twin in the same file, which the CPU back
//! end runs or tests compare the kernels with. This crate knows nothing of simulation or rendering.

mod adapter;
mod bandwidth;
mod buffer;
mod commands;
pub mod compact;
mod count;
mod device;
mod error;
mod kernel;
pub mod layout;
mod mapped;
mod pace;
pub mod radix_sort;
pub mod reduce;
pub mod scan;
pub mod segments;
mod times;

pub use adapter::{Adapter, Choice, adapters, may_have_hardware};
pub use bandwidth::copy_bandwidth;
pub use buffer::{Bound, Buffer, ReadBack};
pub use bytemuck::Pod;
pub use commands::{Commands, Prepared, Work};
pub use count::{BLOCK, Count, Groups};
pub use device::{Device, Dispatches, Traffic};
pub use error::GpuError;
pub use kernel::{Kernel, Kernels, Part};
pub use times::Timings;
