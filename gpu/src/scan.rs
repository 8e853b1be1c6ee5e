//! Exclusive prefix sum of counts: `out[i] = in[0] + … + in[i-1]`, and the total.

use crate::{Device, Kernel};

/// Values that one workgroup handles.
pub(crate) const BLOCK: usize = 1024;

/// The CPU twin of [`Scan::exclusive`]: scans `values` in place and returns the total.
pub fn exclusive_cpu(values: &mut [u32]) -> u32 {
    let mut sum = 0;
    for value in values {
        sum += std::mem::replace(value, sum);
    }
    sum
}

/// The scan kernels, compiled for a device.
pub struct Scan {
    block: Kernel,
    add: Kernel,
}

impl Scan {
    /// Compile the kernels.
    pub fn new(device: &Device) -> Scan {
        Scan {
            block: Kernel::new(device, "scan_block", include_str!("kernels/scan_block.wgsl")),
            add: Kernel::new(device, "scan_add", include_str!("kernels/scan_add.wgsl")),
        }
    }

    /// Scan the first `n` values of a buffer of `u32` in place.
    pub fn exclusive(&self, device: &Device, values: &wgpu::Buffer, n: usize) {
        if n == 0 {
            return;
        }
        let n_blocks = n.div_ceil(BLOCK);
        let sums = device.zeros::<u32>(n_blocks);
        let size = device.upload(&[n as u32]);
        self.block.dispatch(device, &[values, &sums, &size], n_blocks as u32);
        if n_blocks > 1 {
            self.exclusive(device, &sums, n_blocks);
            self.add.dispatch(device, &[values, &sums, &size], n_blocks as u32);
        }
    }
}
