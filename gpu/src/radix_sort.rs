//! Stable sort of (key, value) pairs by a 32-bit key, least significant digit first.

use crate::scan::{BLOCK, Scan};
use crate::{Device, Kernel};

/// Bits that a key can have if the greatest is `max_key`.
fn bits(max_key: u32) -> u32 {
    32 - max_key.leading_zeros()
}

/// Memory that the CPU twin sorts through, kept from call to call.
#[derive(Default)]
pub struct Scratch {
    keys: Vec<u32>,
    values: Vec<u32>,
}

/// The CPU twin: sorts in place; `max_key` bounds the keys and so the number of passes.
pub fn sort_cpu(keys: &mut Vec<u32>, values: &mut Vec<u32>, max_key: u32, scratch: &mut Scratch) {
    const DIGIT: u32 = 11;
    const BUCKETS: usize = 1 << DIGIT;
    let n = keys.len();
    scratch.keys.resize(n, 0);
    scratch.values.resize(n, 0);
    let mut shift = 0;
    while shift < bits(max_key) {
        let mut place = [0u32; BUCKETS];
        for key in keys.iter() {
            place[(key >> shift) as usize & (BUCKETS - 1)] += 1;
        }
        crate::scan::exclusive_cpu(&mut place);
        for (key, value) in keys.iter().zip(values.iter()) {
            let to = &mut place[(key >> shift) as usize & (BUCKETS - 1)];
            scratch.keys[*to as usize] = *key;
            scratch.values[*to as usize] = *value;
            *to += 1;
        }
        std::mem::swap(keys, &mut scratch.keys);
        std::mem::swap(values, &mut scratch.values);
        shift += DIGIT;
    }
}

/// The sort kernels, compiled for a device.
pub struct RadixSort {
    count: Kernel,
    scatter: Kernel,
    scan: Scan,
}

impl RadixSort {
    /// Compile.
    pub fn new(device: &Device) -> RadixSort {
        RadixSort {
            count: Kernel::new(device, "radix_count", include_str!("kernels/radix_count.wgsl")),
            scatter: Kernel::new(device, "radix_scatter", include_str!("kernels/radix_scatter.wgsl")),
            scan: Scan::new(device),
        }
    }

    /// Sort the first `n` pairs of two buffers; returns the buffers that hold the sorted keys and values.
    pub fn sort(
        &self,
        device: &Device,
        keys: wgpu::Buffer,
        values: wgpu::Buffer,
        n: usize,
        max_key: u32,
    ) -> (wgpu::Buffer, wgpu::Buffer) {
        let n_blocks = n.div_ceil(BLOCK);
        let (mut from, mut to) = ((keys, values), (device.zeros::<u32>(n), device.zeros::<u32>(n)));
        for shift in (0..bits(max_key)).step_by(4) {
            let pass = device.upload(&[n as u32, n_blocks as u32, shift]);
            let place = device.zeros::<u32>(16 * n_blocks);
            self.count.dispatch(device, &[&from.0, &place, &pass], n_blocks as u32);
            self.scan.exclusive(device, &place, 16 * n_blocks);
            let buffers = [&from.0, &from.1, &place, &to.0, &to.1, &pass];
            self.scatter.dispatch(device, &buffers, n_blocks as u32);
            std::mem::swap(&mut from, &mut to);
        }
        from
    }
}
