//! Emit the bin of each sphere, that of its box's minimum corner, on the level of its size. The bins cover the box about all fat boxes.
//! in   fat_aabb   [n_spheres]  m, world
//! out  bin        [n_spheres]
//! out  bin_shape  [n_spheres]  the sphere
//! Kernels: bin_grid.wgsl, bin_bits.wgsl, bin_emit.wgsl. Twin: cpu/bin_emit.rs, which puts a shape in every bin that its box overlaps.

use super::bounds::Due;
use super::parts::{ROWS, bits, kernel};
use super::spheres::Spheres;
use gpu::{Buffer, Commands, Device, GpuError, Groups, Kernel, Kernels, Work};

/// The bins, and which spheres are in them.
pub struct Bins {
    /// The most bits of the index of a bin.
    pub most_bits: u32,
    /// Bits of a bin's coordinate along each axis that its index has, at least 3 (3).
    pub grid: Buffer<u32>,
    /// Bin of each sphere (n_spheres).
    pub bin: Buffer<u32>,
    /// Sphere (n_spheres).
    pub shape: Buffer<u32>,
    /// First sphere of each bin in the sorted column, and the end (n_bins).
    pub start: Buffer<[u32; 2]>,
}

impl Bins {
    /// Bins for this many spheres.
    pub fn new(device: &Device, n: usize) -> Result<Bins, GpuError> {
        let most_bits = most_bits(n);
        Ok(Bins {
            most_bits,
            grid: Buffer::of(device, "grid", &[3; 3])?,
            bin: Buffer::zeros(device, "bin", n)?,
            shape: Buffer::zeros(device, "bin_shape", n)?,
            start: Buffer::zeros(device, "bin_start", 1 << most_bits)?,
        })
    }

    /// Number of bins.
    pub fn n(&self) -> usize {
        1 << self.most_bits
    }
}

/// The most bits of the index of a bin: at most eight bins a sphere, rounded up, and at least one brick of 8³.
fn most_bits(n: usize) -> u32 {
    ((8 * n).next_power_of_two().trailing_zeros()).clamp(9, 24)
}

/// The stage's kernels.
pub struct BinEmit {
    grid: Kernel,
    bits: Kernel,
    emit: Kernel,
    groups: Groups,
    /// Corners of the box about all fat boxes, empty between runs.
    extent: Buffer<u32>,
}

impl BinEmit {
    /// Compile the kernels.
    pub fn new(device: &Device, kernels: &Kernels) -> Result<BinEmit, GpuError> {
        const NONE: u32 = u32::MAX;
        Ok(BinEmit {
            grid: kernel(device, kernels, "bin_grid", include_str!("bin_grid.wgsl"))?,
            bits: kernel(device, kernels, "bin_bits", include_str!("bin_bits.wgsl"))?,
            emit: kernel(device, kernels, "bin_emit", include_str!("bin_emit.wgsl"))?,
            groups: Groups::new(device, kernels, ROWS)?,
            extent: Buffer::of(device, "extent", &[NONE, NONE, NONE, 0, 0, 0])?,
        })
    }

    /// Record the stage; `unit` is that of the fixed-point scale, m.
    pub fn record(
        &self,
        device: &Device,
        commands: &mut Commands,
        at: &Spheres,
        unit: f64,
        (due, bins): (&Due, &Bins),
    ) {
        self.groups.record(device, commands, &due.spheres);
        let work = self.groups.of_level(&due.spheres, 0);
        let (fat, extent, n, grid) = (at.fat_aabb.bind(), self.extent.bind(), due.spheres.n.bind(), bins.grid.bind());
        commands.dispatch(device, &self.grid, &[fat, extent, n], &[], work);
        let params = [bins.most_bits, bits(at.width)];
        commands.dispatch(device, &self.bits, &[extent, grid, n], &params, Work::Groups(1));
        let bound = [fat, bins.bin.bind(), bins.shape.bind(), due.levels.bind(), n, grid];
        commands.dispatch(device, &self.emit, &bound, &[bins.n() as u32, bits(1.0 / unit)], work);
    }
}

#[cfg(test)]
mod tests {
    use super::most_bits;

    #[test]
    fn there_are_at_most_eight_bins_a_sphere_rounded_up() {
        assert_eq!([1, 64, 100, 1_000_000, 100_000_000].map(most_bits), [9, 9, 10, 23, 24]);
    }
}
