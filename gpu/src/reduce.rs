//! Reduction of a column to a scalar that stays on the device, in one order on any device: a binary tree, neighbours first.

use crate::buffer::Buffer;
use crate::commands::{Commands, Work};
use crate::count::{BLOCK, Count, Groups, blocks_of_level};
use crate::device::Device;
use crate::error::GpuError;
use crate::kernel::{Kernel, Kernels, Part};

/// What values are combined by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Combine {
    /// The sum.
    Sum,
    /// The maximum.
    Max,
}

impl Combine {
    fn part(self) -> Part<'static> {
        match self {
            Combine::Sum => ("combine", include_str!("kernels/combine.wgsl")),
            Combine::Max => ("combine", include_str!("kernels/combine_max.wgsl")),
        }
    }

    /// The result for no values.
    pub fn identity(self) -> f32 {
        match self {
            Combine::Sum => 0.0,
            Combine::Max => f32::MIN,
        }
    }

    fn of(self, a: f32, b: f32) -> f32 {
        match self {
            Combine::Sum => a + b,
            Combine::Max => a.max(b),
        }
    }
}

/// The CPU twin of [`Reduce::record`], in the same order: the same bits, as long as no number is subnormal (devices may take these for
/// zero).
pub fn reduce_cpu(combine: Combine, values: &[f32]) -> f32 {
    let mut level: Vec<f32> = values.to_vec();
    loop {
        level = level.chunks(BLOCK).map(|block| tree_cpu(combine, block, BLOCK)).collect();
        match level[..] {
            [] => return combine.identity(),
            [result] => return result,
            _ => {}
        }
    }
}

/// Combine values, padded to a power of two, as a binary tree, neighbours first.
pub(crate) fn tree_cpu(combine: Combine, values: &[f32], padded: usize) -> f32 {
    let mut row = values.to_vec();
    row.resize(padded, combine.identity());
    while row.len() > 1 {
        row = row.chunks(2).map(|pair| combine.of(pair[0], pair[1])).collect();
    }
    row[0]
}

/// The reduction kernel, with memory for up to a number of values.
pub struct Reduce {
    block: Kernel,
    groups: Groups,
    /// The results of the blocks of each level but the last.
    results: Vec<Buffer<f32>>,
}

impl Reduce {
    /// For up to `capacity` values.
    ///
    /// # Errors
    /// Those of [`Kernels::get`] and [`Buffer::zeros`].
    pub fn new(device: &Device, kernels: &Kernels, combine: Combine, capacity: usize) -> Result<Reduce, GpuError> {
        let mut results = vec![];
        for level in 0.. {
            let n = blocks_of_level(capacity, BLOCK, level);
            if n <= 1 {
                break;
            }
            results.push(Buffer::zeros(device, "reduction", n)?);
        }
        let text = include_str!("kernels/reduce_block.wgsl");
        let block = kernels.get(device, "reduce_block", text, &[combine.part()])?;
        Ok(Reduce { block, groups: Groups::new(device, kernels, BLOCK)?, results })
    }

    /// Record the reduction of the first `count` values of a buffer to `result` (1).
    pub fn record(
        &self,
        device: &Device,
        commands: &mut Commands,
        values: &Buffer<f32>,
        count: &Count,
        result: &Buffer<f32>,
    ) {
        self.groups.record(device, commands, count);
        let last = self.groups.n_levels(count) - 1;
        for level in 0..=last {
            let from = if level == 0 { values } else { &self.results[level - 1] };
            let to = if level == last { result } else { &self.results[level] };
            let buffers = [from.bind(), to.bind(), count.n.bind()];
            // The last level runs for no values too: its result is the identity.
            let work = if level == last { Work::Groups(1) } else { self.groups.of_level(count, level) };
            commands.dispatch(device, &self.block, &buffers, &[level as u32], work);
        }
    }
}
