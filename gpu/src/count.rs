//! Counts: the number of values that a primitive works on, known to the host or found on the device.

use crate::buffer::Buffer;
use crate::commands::{Commands, Work};
use crate::device::Device;
use crate::error::GpuError;
use crate::kernel::{Kernel, Kernels};

/// Values that one workgroup of most primitives handles.
pub const BLOCK: usize = 1024;

/// The most levels of blocks: 1024⁴ values and more.
const LEVELS: usize = 4;

/// A number of values, on the device. Clones are the same number.
#[derive(Clone, Debug)]
pub struct Count {
    /// The number (1).
    pub n: Buffer<u32>,
    /// The most that it can be.
    pub capacity: usize,
    /// Whether kernels write it, so that dispatches over it are indirect.
    pub is_found: bool,
}

impl Count {
    /// The number `n`, which stays.
    ///
    /// # Errors
    /// Those of [`Buffer::zeros`].
    pub fn of(device: &Device, n: usize) -> Result<Count, GpuError> {
        Ok(Count { n: Buffer::of(device, "count", &[n as u32])?, capacity: n, is_found: false })
    }

    /// A number up to `capacity` that kernels write; 0 so far.
    ///
    /// # Errors
    /// Those of [`Buffer::zeros`].
    pub fn found(device: &Device, capacity: usize) -> Result<Count, GpuError> {
        Ok(Count { n: Buffer::zeros(device, "count", 1)?, capacity, is_found: true })
    }

    /// The number, read back from the device.
    ///
    /// # Errors
    /// Those of [`Buffer::read`].
    pub fn read(&self, device: &Device) -> Result<usize, GpuError> {
        Ok(self.n.read(device, 1)?[0] as usize)
    }
}

/// The workgroups of dispatches over a count, level by level: those of level 0 take the values, those of each further level the results
/// of the blocks of the level before.
pub struct Groups {
    kernel: Kernel,
    args: Buffer<[u32; 4]>,
    block: usize,
}

impl Groups {
    /// For blocks of `block` values.
    ///
    /// # Errors
    /// Those of [`Kernels::get`] and [`Buffer::zeros`].
    pub fn new(device: &Device, kernels: &Kernels, block: usize) -> Result<Groups, GpuError> {
        let kernel = kernels.get(device, "groups", include_str!("kernels/groups.wgsl"), &[])?;
        Ok(Groups { kernel, args: Buffer::zeros(device, "groups", LEVELS)?, block })
    }

    /// Record the count of workgroups of each level, if it is found on the device.
    pub fn record(&self, device: &Device, commands: &mut Commands, count: &Count) {
        if count.is_found {
            let buffers = [count.n.bind(), self.args.bind()];
            let params = [self.block as u32, LEVELS as u32];
            commands.dispatch(device, &self.kernel, &buffers, &params, Work::Groups(1));
        }
    }

    /// The workgroups of a level, after [`Groups::record`].
    pub fn of_level(&self, count: &Count, level: usize) -> Work<'_> {
        if count.is_found {
            return Work::Indirect(&self.args, level);
        }
        Work::Groups(blocks_of_level(count.capacity, self.block, level) as u32)
    }

    /// Number of levels until one block takes all values of the count's capacity, at least one.
    pub fn n_levels(&self, count: &Count) -> usize {
        (0..).find(|level| blocks_of_level(count.capacity, self.block, *level) <= 1).expect("a level of one block") + 1
    }
}

/// Number of blocks of a level over `n` values.
pub(crate) fn blocks_of_level(n: usize, block: usize, level: usize) -> usize {
    (0..=level).fold(n, |n, _| n.div_ceil(block))
}
