//! Compaction: the ids of the rows that have a flag, in order, and their number, which stays on the device.

use crate::buffer::Buffer;
use crate::commands::{Commands, Work};
use crate::count::{BLOCK, Count, Groups};
use crate::device::Device;
use crate::error::GpuError;
use crate::kernel::{Kernel, Kernels};
use crate::scan::Scan;

/// The CPU twin of [`Compact::record`].
pub fn compact_cpu(flags: &[u32]) -> Vec<u32> {
    (0..).zip(flags).filter(|(_, flag)| **flag != 0).map(|(id, _)| id).collect()
}

/// The kernels of the compaction, with memory for up to a number of rows.
pub struct Compact {
    flag: Kernel,
    write: Kernel,
    groups: Groups,
    scan: Scan,
    /// Prefix sums of the flags, and their number.
    place: Buffer<u32>,
    n_places: Count,
}

impl Compact {
    /// For up to `capacity` rows.
    ///
    /// # Errors
    /// Those of [`Kernels::get`] and [`Buffer::zeros`].
    pub fn new(device: &Device, kernels: &Kernels, capacity: usize) -> Result<Compact, GpuError> {
        Ok(Compact {
            flag: kernels.get(device, "compact_flag", include_str!("kernels/compact_flag.wgsl"), &[])?,
            write: kernels.get(device, "compact_write", include_str!("kernels/compact_write.wgsl"), &[])?,
            groups: Groups::new(device, kernels, BLOCK)?,
            scan: Scan::new(device, kernels, capacity + 1)?,
            place: Buffer::zeros(device, "compaction", capacity + 1)?,
            n_places: Count::found(device, capacity + 1)?,
        })
    }

    /// The prefix sums of the flags of the last compaction, and the number of all that are kept (n + 1).
    pub fn places(&self) -> &Buffer<u32> {
        &self.place
    }

    /// Record the compaction of `count` flags to `ids` and their number `n_kept`. Where a count that is found on the device is 0, nothing is done: both
    /// stay as they were.
    pub fn record(
        &self,
        device: &Device,
        commands: &mut Commands,
        flags: &Buffer<u32>,
        count: &Count,
        ids: &Buffer<u32>,
        n_kept: &Count,
    ) {
        self.groups.record(device, commands, count);
        // One workgroup more than blocks never harms: it takes care of no rows at all, whose number is 0.
        let work = if count.capacity == 0 { Work::Groups(1) } else { self.groups.of_level(count, 0) };
        let buffers = [flags.bind(), self.place.bind(), self.n_places.n.bind(), count.n.bind()];
        commands.dispatch(device, &self.flag, &buffers, &[], work);
        self.scan.record(device, commands, &self.place, &self.n_places);
        let buffers = [self.place.bind(), ids.bind(), n_kept.n.bind(), count.n.bind()];
        commands.dispatch(device, &self.write, &buffers, &[], work);
    }
}
