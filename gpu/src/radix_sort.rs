//! Stable radix sort of (key, value) pairs by a key of 32 or 64 bits, least significant digit first.

use crate::buffer::Buffer;
use crate::commands::{Commands, Work};
use crate::count::{Count, Groups};
use crate::device::Device;
use crate::error::GpuError;
use crate::kernel::{Kernel, Kernels, Part};
use crate::scan::Scan;
use rayon::prelude::*;

/// A key to sort by.
pub trait Key: bytemuck::Pod + Default + Send + Sync {
    /// The kernel part that defines the key.
    const PART: Part<'static>;

    /// Number of bits that a key can have if this is the greatest.
    fn bits(self) -> u32;

    /// The bits from `shift` on, as many as `mask` has.
    fn digit(self, shift: u32, mask: u32) -> u32;
}

impl Key for u32 {
    const PART: Part<'static> = ("key", include_str!("kernels/key.wgsl"));

    fn bits(self) -> u32 {
        u32::BITS - self.leading_zeros()
    }

    #[inline]
    fn digit(self, shift: u32, mask: u32) -> u32 {
        self >> shift & mask
    }
}

impl Key for u64 {
    const PART: Part<'static> = ("key", include_str!("kernels/key_u64.wgsl"));

    fn bits(self) -> u32 {
        u64::BITS - self.leading_zeros()
    }

    #[inline]
    fn digit(self, shift: u32, mask: u32) -> u32 {
        (self >> shift) as u32 & mask
    }
}

/// The CPU twin of [`RadixSort::record`]: sorts `keys` and `values` (of equal length) in place. `max_key` is at least every key; it
/// determines the count of passes.
pub fn sort_cpu<K: Key>(keys: &mut [K], values: &mut [u32], max_key: K) {
    /// Bits of a key that a pass may sort by: their counters stay in the cache.
    const DIGIT: u32 = 16;
    let bits = max_key.bits();
    let n_passes = bits.div_ceil(DIGIT);
    let digit = bits.div_ceil(n_passes.max(1));
    let (mut from, mut to, mut start) = (vec![], vec![], vec![]);
    for pass in 0..n_passes {
        let bucket = |key: K| key.digit(pass * digit, (1 << digit) - 1);
        if pass == 0 {
            let pairs = || keys.iter().zip(values.iter()).map(|(key, value)| (bucket(*key), (*key, *value)));
            distribute_cpu(1 << digit, pairs, &mut start, &mut to);
        } else {
            let pairs = || from.iter().map(|pair: &(K, u32)| (bucket(pair.0), *pair));
            distribute_cpu(1 << digit, pairs, &mut start, &mut to);
        }
        std::mem::swap(&mut from, &mut to);
    }
    for ((key, value), pair) in keys.iter_mut().zip(values).zip(from) {
        (*key, *value) = pair;
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

/// Keys that one workgroup of the sort handles.
const RADIX_BLOCK: usize = 4096;
/// Bits of a key that a pass sorts by, and the values that they can have.
const DIGIT: u32 = 8;
const DIGITS: usize = 1 << DIGIT;

/// The part that all of its kernels import.
const BLOCK_PART: Part<'static> = ("radix_block", include_str!("kernels/radix_block.wgsl"));

/// The sort kernels, with memory for up to a number of pairs.
pub struct RadixSort<K> {
    size: Kernel,
    count: Kernel,
    scatter: Kernel,
    groups: Groups,
    scan: Scan,
    /// First place of each digit of each block, and how many there are.
    place: Buffer<u32>,
    n_places: Count,
    /// The pairs between two passes.
    keys: Buffer<K>,
    values: Buffer<u32>,
}

impl<K: Key> RadixSort<K> {
    /// For up to `capacity` pairs.
    ///
    /// # Errors
    /// Those of [`Kernels::get`] and [`Buffer::zeros`].
    pub fn new(device: &Device, kernels: &Kernels, capacity: usize) -> Result<RadixSort<K>, GpuError> {
        let n_places = DIGITS * capacity.div_ceil(RADIX_BLOCK);
        Ok(RadixSort {
            size: kernels.get(device, "radix_size", include_str!("kernels/radix_size.wgsl"), &[BLOCK_PART])?,
            count: kernels.get(
                device,
                "radix_count",
                include_str!("kernels/radix_count.wgsl"),
                &[BLOCK_PART, K::PART],
            )?,
            scatter: kernels.get(
                device,
                "radix_scatter",
                include_str!("kernels/radix_scatter.wgsl"),
                &[BLOCK_PART, K::PART],
            )?,
            groups: Groups::new(device, kernels, RADIX_BLOCK)?,
            scan: Scan::new(device, kernels, n_places)?,
            place: Buffer::zeros(device, "radix places", n_places)?,
            n_places: Count::found(device, n_places)?,
            keys: Buffer::zeros(device, "radix keys", capacity)?,
            values: Buffer::zeros(device, "radix values", capacity)?,
        })
    }

    /// Record the sort in place of the first `count` pairs of two buffers. `max_key` is at least every key; it
    /// determines the number of passes.
    pub fn record(
        &self,
        device: &Device,
        commands: &mut Commands,
        (keys, values): (&Buffer<K>, &Buffer<u32>),
        count: &Count,
        max_key: K,
    ) {
        self.groups.record(device, commands, count);
        commands.dispatch(device, &self.size, &[count.n.bind(), self.n_places.n.bind()], &[], Work::Groups(1));
        let (mut from, mut to) = ((keys, values), (&self.keys, &self.values));
        for shift in (0..max_key.bits()).step_by(DIGIT as usize) {
            let buffers = [from.0.bind(), self.place.bind(), count.n.bind()];
            commands.dispatch(device, &self.count, &buffers, &[shift], self.groups.of_level(count, 0));
            self.scan.record(device, commands, &self.place, &self.n_places);
            let (source, goal) = ([from.0.bind(), from.1.bind()], [to.0.bind(), to.1.bind()]);
            let buffers = [source[0], source[1], self.place.bind(), goal[0], goal[1], count.n.bind()];
            commands.dispatch(device, &self.scatter, &buffers, &[shift], self.groups.of_level(count, 0));
            std::mem::swap(&mut from, &mut to);
        }
        if max_key.bits().div_ceil(DIGIT) % 2 == 1 {
            commands.copy(&self.keys, keys, count.capacity);
            commands.copy(&self.values, values, count.capacity);
        }
    }
}
