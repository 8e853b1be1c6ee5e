//! Find the range of each bin among the sorted spheres.
//! in   bin        [n_spheres]  sorted
//! out  bin_start  [n_bins]     first sphere of the bin in the sorted column, and the end
//! Kernels: bin_clear.wgsl, bin_start.wgsl. Twin: cpu/bin_start.rs, which has rows of active bins alone.

use super::bin_emit::Bins;
use super::bounds::Due;
use super::parts::{ROWS, kernel};
use gpu::{Commands, Device, GpuError, Groups, Kernel, Kernels};

/// The stage's kernels.
pub struct BinStart {
    clear: Kernel,
    start: Kernel,
    groups: [Groups; 2],
}

impl BinStart {
    /// Compile the kernels.
    pub fn new(device: &Device, kernels: &Kernels) -> Result<BinStart, GpuError> {
        Ok(BinStart {
            clear: kernel(device, kernels, "bin_clear", include_str!("bin_clear.wgsl"))?,
            start: kernel(device, kernels, "bin_start", include_str!("bin_start.wgsl"))?,
            groups: [Groups::new(device, kernels, ROWS)?, Groups::new(device, kernels, ROWS)?],
        })
    }

    /// Record the stage.
    pub fn record(&self, device: &Device, commands: &mut Commands, due: &Due, bins: &Bins) {
        let [of_bins, of_spheres] = &self.groups;
        of_bins.record(device, commands, &due.bins);
        let bound = [bins.start.bind(), due.bins.n.bind()];
        commands.dispatch(device, &self.clear, &bound, &[], of_bins.of_level(&due.bins, 0));
        of_spheres.record(device, commands, &due.spheres);
        let bound = [bins.bin.bind(), bins.start.bind(), due.spheres.n.bind()];
        commands.dispatch(device, &self.start, &bound, &[], of_spheres.of_level(&due.spheres, 0));
    }
}
