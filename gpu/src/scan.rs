//! Exclusive prefix sum of counts: `out[i] = in[0] + … + in[i-1]`.

use crate::buffer::Buffer;
use crate::commands::Commands;
use crate::count::{BLOCK, Count, Groups, blocks_of_level};
use crate::device::Device;
use crate::error::GpuError;
use crate::kernel::{Kernel, Kernels};

/// The CPU twin of [`Scan::record`]: scans `values` in place and returns the total.
pub fn exclusive_cpu(values: &mut [u32]) -> u32 {
    let mut sum = 0;
    for value in values {
        sum += std::mem::replace(value, sum);
    }
    sum
}

/// The scan kernels, with memory for up to a number of values.
pub struct Scan {
    block: Kernel,
    add: Kernel,
    groups: Groups,
    /// The sums of the blocks of each level.
    sums: Vec<Buffer<u32>>,
}

impl Scan {
    /// For up to `capacity` values.
    ///
    /// # Errors
    /// Those of [`Kernels::get`] and [`Buffer::zeros`].
    pub fn new(device: &Device, kernels: &Kernels, capacity: usize) -> Result<Scan, GpuError> {
        let mut sums = vec![];
        for level in 0.. {
            let n = blocks_of_level(capacity, BLOCK, level);
            sums.push(Buffer::zeros(device, "scan sums", n)?);
            if n <= 1 {
                break;
            }
        }
        Ok(Scan {
            block: kernels.get(device, "scan_block", include_str!("kernels/scan_block.wgsl"), &[])?,
            add: kernels.get(device, "scan_add", include_str!("kernels/scan_add.wgsl"), &[])?,
            groups: Groups::new(device, kernels, BLOCK)?,
            sums,
        })
    }

    /// Record the scan in place of the first `count` values of a buffer.
    pub fn record(&self, device: &Device, commands: &mut Commands, values: &Buffer<u32>, count: &Count) {
        self.groups.record(device, commands, count);
        let n_levels = self.groups.n_levels(count);
        let of_level = |level: usize| if level == 0 { values } else { &self.sums[level - 1] };
        for level in 0..n_levels {
            let buffers = [of_level(level).bind(), self.sums[level].bind(), count.n.bind()];
            let work = self.groups.of_level(count, level);
            commands.dispatch(device, &self.block, &buffers, &[level as u32], work);
        }
        for level in (0..n_levels - 1).rev() {
            let buffers = [of_level(level).bind(), self.sums[level].bind(), count.n.bind()];
            let work = self.groups.of_level(count, level);
            commands.dispatch(device, &self.add, &buffers, &[level as u32], work);
        }
    }
}
