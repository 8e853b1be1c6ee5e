//! Segmented reduction: the sum of each segment of a column in compressed rows (starts, items), in one order on any device.

use crate::buffer::Buffer;
use crate::commands::Commands;
use crate::count::{Count, Groups};
use crate::device::Device;
use crate::error::GpuError;
use crate::kernel::{Kernel, Kernels};
use crate::reduce::{Combine, tree_cpu};

/// Threads of a workgroup, each with a segment, or all with one that is long.
const THREADS: usize = 256;
/// The most values of a segment that one thread sums.
const LONG: usize = 64;

/// The CPU twin of [`SegmentSum::record`], in the same order: segment s is `values[start[s]..start[s + 1]]`. Short segments are summed
/// from first to last, longer ones as 256 sums of every 256th value and these as a binary tree.
pub fn sums_cpu(values: &[f32], start: &[u32]) -> Vec<f32> {
    let of_segment = |ends: &[u32]| {
        let segment = &values[ends[0] as usize..ends[1] as usize];
        if segment.len() <= LONG {
            return segment.iter().fold(0.0, |sum, value| sum + value);
        }
        let of_thread = |t| segment[t..].iter().step_by(THREADS).fold(0.0, |sum, value| sum + value);
        let sums: Vec<f32> = (0..THREADS.min(segment.len())).map(of_thread).collect();
        tree_cpu(Combine::Sum, &sums, THREADS)
    };
    start.windows(2).map(of_segment).collect()
}

/// The kernels of the segmented sum, with memory for up to a number of segments.
pub struct SegmentSum {
    short: Kernel,
    long: Kernel,
    groups: Groups,
    long_groups: Groups,
    long_ids: Buffer<u32>,
    n_long: Count,
}

impl SegmentSum {
    /// For up to `capacity` segments.
    ///
    /// # Errors
    /// Those of [`Kernels::get`] and [`Buffer::zeros`].
    pub fn new(device: &Device, kernels: &Kernels, capacity: usize) -> Result<SegmentSum, GpuError> {
        Ok(SegmentSum {
            short: kernels.get(device, "segment_sum", include_str!("kernels/segment_sum.wgsl"), &[])?,
            long: kernels.get(device, "segment_long", include_str!("kernels/segment_long.wgsl"), &[])?,
            groups: Groups::new(device, kernels, THREADS)?,
            long_groups: Groups::new(device, kernels, 1)?,
            long_ids: Buffer::zeros(device, "long segments", capacity)?,
            n_long: Count::found(device, capacity)?,
        })
    }

    /// Record the sums of `count` segments: `start` has one more entry, `sums` one for each.
    pub fn record(
        &self,
        device: &Device,
        commands: &mut Commands,
        [values, sums]: [&Buffer<f32>; 2],
        start: &Buffer<u32>,
        count: &Count,
    ) {
        self.groups.record(device, commands, count);
        commands.clear(&self.n_long.n);
        let bound = [values.bind(), start.bind(), sums.bind(), self.long_ids.bind(), self.n_long.n.bind()];
        let buffers: Vec<_> = bound.into_iter().chain([count.n.bind()]).collect();
        commands.dispatch(device, &self.short, &buffers, &[], self.groups.of_level(count, 0));
        self.long_groups.record(device, commands, &self.n_long);
        commands.dispatch(device, &self.long, &bound, &[], self.long_groups.of_level(&self.n_long, 0));
    }
}
