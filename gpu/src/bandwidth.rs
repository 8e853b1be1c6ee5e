//! The copy bandwidth of an adapter, which the speed of its kernels is held against.

use crate::buffer::Buffer;
use crate::commands::{Commands, Work};
use crate::count::BLOCK;
use crate::device::Device;
use crate::error::GpuError;
use crate::kernel::Kernels;

/// Measure the copy bandwidth: bytes read and written per second by a kernel that copies `n` rows of 16 bytes, the best of `repeats`
/// times after one that does not count.
///
/// # Errors
/// Those of [`Kernels::get`], [`Buffer::zeros`] and [`Device::check`].
pub fn copy_bandwidth(device: &Device, kernels: &Kernels, n: usize, repeats: usize) -> Result<f64, GpuError> {
    let rows = Buffer::<[u32; 4]>::zeros(device, "copied rows", n)?;
    let copy = Buffer::<[u32; 4]>::zeros(device, "copy", n)?;
    let kernel = kernels.get(device, "copy", include_str!("kernels/copy.wgsl"), &[])?;
    let mut commands = Commands::new();
    commands.stage("copy");
    let work = Work::Groups(n.div_ceil(BLOCK) as u32);
    commands.dispatch(device, &kernel, &[rows.bind(), copy.bind()], &[n as u32], work);
    commands.stage_seconds(device, "copy")?;
    let mut best = f64::INFINITY;
    for _ in 0..repeats.max(1) {
        best = best.min(commands.stage_seconds(device, "copy")?);
    }
    Ok(2.0 * 16.0 * n as f64 / best)
}
