//! Emit the bin of each sphere, that of its box's minimum corner, on the level of its size.
//! in   fat_aabb   [n_spheres]  m, world
//! out  bin        [n_spheres]
//! out  bin_shape  [n_spheres]  the sphere
//! Kernels: bin_emit.wgsl. Twin: cpu/bin_emit.rs, which puts a shape in every bin that its box overlaps.

use super::bounds::Due;
use super::spheres::{ROWS, Spheres, kernel};
use gpu::{Buffer, Commands, Device, GpuError, Groups, Kernel, Kernels};

/// The bins, and which spheres are in them.
pub struct Bins {
    /// Bits of a bin's coordinate along each axis that its index has, at least 3.
    pub bits: [u32; 3],
    /// Bin of each sphere (n_spheres).
    pub bin: Buffer<u32>,
    /// Sphere (n_spheres).
    pub shape: Buffer<u32>,
    /// First sphere of each bin in the sorted column, and the end (n_bins).
    pub start: Buffer<[u32; 2]>,
}

/// Number of bins with these bits.
pub fn n_bins(bits: [u32; 3]) -> usize {
    1 << bits.iter().sum::<u32>()
}

/// The bits for spheres of a usual width, m, in a box, m: enough for it, as long as there are at most eight bins a sphere.
pub fn bits(n: usize, width: f64, extent: [f64; 3]) -> [u32; 3] {
    /// Bins of a brick along an edge, and the least number of all bins, in bits.
    const BRICK: u32 = 3;
    let most = ((8 * n).next_power_of_two().trailing_zeros()).clamp(3 * BRICK, 24);
    let mut bits = extent.map(|e| ((e / width).max(1.0).log2().ceil() as u32).clamp(BRICK, 24));
    while bits.iter().sum::<u32>() > most {
        let widest = (0..3).max_by_key(|axis| bits[*axis]).expect("three axes");
        bits[widest] -= 1;
    }
    bits
}

/// The stage's kernel.
pub struct BinEmit {
    emit: Kernel,
    groups: Groups,
}

impl BinEmit {
    /// Compile the kernel.
    pub fn new(device: &Device, kernels: &Kernels) -> Result<BinEmit, GpuError> {
        let emit = kernel(device, kernels, "bin_emit", include_str!("bin_emit.wgsl"))?;
        Ok(BinEmit { emit, groups: Groups::new(device, kernels, ROWS)? })
    }

    /// Record the stage.
    pub fn record(&self, device: &Device, commands: &mut Commands, at: &Spheres, due: &Due, bins: &Bins) {
        self.groups.record(device, commands, &due.spheres);
        let bound = [at.fat_aabb.bind(), bins.bin.bind(), bins.shape.bind(), due.levels.bind(), due.spheres.n.bind()];
        let [x, y, z] = bins.bits;
        let params = [x, y, z, n_bins(bins.bits) as u32, (1.0 / at.scale.unit as f32).to_bits()];
        commands.dispatch(device, &self.emit, &bound, &params, self.groups.of_level(&due.spheres, 0));
    }
}

#[cfg(test)]
mod tests {
    use super::bits;

    #[test]
    fn bins_fit_the_box_and_are_not_too_many() {
        assert_eq!(bits(1_000_000, 0.25, [50.0, 50.0, 2.0]), [8, 8, 3]);
        assert_eq!(bits(1, 1.0, [0.0, 0.0, 0.0]), [3, 3, 3]);
        let few: u32 = bits(1000, 1e-3, [1e6, 1.0, 1e-9]).iter().sum();
        assert!((9..=13).contains(&few), "{few}");
    }
}
