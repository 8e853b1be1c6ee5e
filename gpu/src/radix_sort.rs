//! Stable radix sort of (key, value) pairs by a 32-bit key, least significant digit first.

use crate::scan::{BLOCK, Scan};
use crate::{Device, Kernel};
use rayon::prelude::*;

/// Bits that a key can have if the greatest is `max_key`.
fn bits(max_key: u32) -> u32 {
    32 - max_key.leading_zeros()
}

/// The CPU twin of [`RadixSort::sort`]: sorts `keys` and `values` (of equal length) in place. `max_key` is at least every key; it
/// determines the count of passes.
pub fn sort_cpu(keys: &mut [u32], values: &mut [u32], max_key: u32) {
    /// Bits of a key that a pass may sort by: their counters stay in the cache.
    const DIGIT: u32 = 16;
    let bits = bits(max_key);
    let n_passes = bits.div_ceil(DIGIT);
    let digit = bits.div_ceil(n_passes.max(1));
    let (mut from, mut to, mut start) = (vec![], vec![], vec![]);
    for pass in 0..n_passes {
        let bucket = |key: u32| key >> (pass * digit) & ((1 << digit) - 1);
        if pass == 0 {
            let pairs = || keys.iter().zip(values.iter()).map(|(key, value)| (bucket(*key), [*key, *value]));
            distribute_cpu(1 << digit, pairs, &mut start, &mut to);
        } else {
            let pairs = || from.iter().map(|pair: &[u32; 2]| (bucket(pair[0]), *pair));
            distribute_cpu(1 << digit, pairs, &mut start, &mut to);
        }
        std::mem::swap(&mut from, &mut to);
    }
    for ((key, value), pair) in keys.iter_mut().zip(values).zip(from) {
        [*key, *value] = pair;
    }
}

/// Stable counting sort of items, given as (bucket, item), into `n_buckets` buckets: those of bucket b become
/// `out[start[b]..start[b + 1]]`; `start` gets `[n_buckets + 1]` entries. Each thread goes through all items for a range of
/// buckets, so that the result does not depend on the count of threads.
pub fn distribute_cpu<T: Copy + Default + Send, I: ExactSizeIterator<Item = (u32, T)>>(
    n_buckets: usize,
    items: impl Fn() -> I + Sync,
    start: &mut Vec<u32>,
    out: &mut Vec<T>,
) {
    /// Items that are not worth a second thread.
    const FEW: usize = 8192;
    let n = items().len();
    let n_ranges = if n < FEW { 1 } else { rayon::current_num_threads().min(8) };
    let length = n_buckets.div_ceil(n_ranges).max(1);
    start.clear();
    start.resize(n_buckets + 1, 0);
    start[..n_buckets].par_chunks_mut(length).enumerate().for_each(|(range, count)| {
        for (bucket, _) in items() {
            if let Some(count) = count.get_mut((bucket as usize).wrapping_sub(range * length)) {
                *count += 1;
            }
        }
    });
    crate::scan::exclusive_cpu(start);
    out.resize(n, T::default());
    let mut rest = &mut out[..];
    let mut ranges = vec![];
    for (range, slots) in start[..n_buckets].chunks(length).enumerate() {
        let end = start[((range + 1) * length).min(n_buckets)];
        let (own, after) = std::mem::take(&mut rest).split_at_mut((end - slots[0]) as usize);
        rest = after;
        ranges.push((slots[0], own));
    }
    start[..n_buckets].par_chunks_mut(length).zip(ranges).enumerate().for_each(|(range, (slot, (base, own)))| {
        for (bucket, item) in items() {
            if let Some(slot) = slot.get_mut((bucket as usize).wrapping_sub(range * length)) {
                own[(*slot - base) as usize] = item;
                *slot += 1;
            }
        }
    });
    // Each start has moved to the next bucket's: move them back by one.
    start.rotate_right(1);
    start[0] = 0;
}

/// The sort kernels, compiled for a device.
pub struct RadixSort {
    count: Kernel,
    scatter: Kernel,
    scan: Scan,
}

impl RadixSort {
    /// Compile the kernels.
    pub fn new(device: &Device) -> RadixSort {
        RadixSort {
            count: Kernel::new(device, "radix_count", include_str!("kernels/radix_count.wgsl")),
            scatter: Kernel::new(device, "radix_scatter", include_str!("kernels/radix_scatter.wgsl")),
            scan: Scan::new(device),
        }
    }

    /// Sort the first `n` pairs of two buffers of `u32`; returns the buffers that hold the sorted keys and values. `max_key` is at
    /// least every key; it determines the count of passes.
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
