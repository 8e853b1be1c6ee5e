//! Headless wgpu device, kernels, and the primitives that simulation and rendering share.
//!
//! Each primitive ([`scan`], [`radix_sort`]) has a CPU twin in the same file, which is the one the CPU back end runs
//! and the one that tests compare the kernels with. This crate knows nothing of simulation or rendering.

mod device;
mod kernel;
pub mod radix_sort;
pub mod scan;

pub use device::{Adapter, Device, GpuError, adapters};
pub use kernel::Kernel;
