//! Emit the bin of each sphere, that of its box's minimum corner, on the level of its size. The bins cover the box about all fat boxes.
//! in   fat_aabb   [n_spheres]  m, world
//! out  bin        [n_spheres]
//! out  bin_shape  [n_spheres]  the sphere
//! Kernels: bin_grid.wgsl, bin_bits.wgsl, bin_emit.wgsl. Twin: [`emit_cpu`]; cpu/bin_emit.rs puts a shape in every bin that its
//! box overlaps.

use super::bounds::Due;
use super::parts::{ROWS, bits, kernel};
use super::rows::Aabb;
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

/// The twin of the kernels: the bins of boxes.
pub struct Emitted {
    /// Bits of a bin's coordinate along each axis.
    pub grid: [u32; 3],
    /// Bin of each box.
    pub bin: Vec<u32>,
    /// Mask of the levels that are used.
    pub levels: [u32; 2],
}

/// The bins of boxes, whose index has `most_bits` bits at most; `width` is the usual one of a bin, m, and `unit` that of the
/// fixed-point scale, m.
pub fn emit_cpu(boxes: &[Aabb], most_bits: u32, (width, unit): (f64, f64)) -> Emitted {
    let are_there = || boxes.iter().filter(|own| own.low[0] <= own.high[0]);
    let length = |axis: usize| {
        let low = are_there().map(|own| own.low[axis]).fold(f32::INFINITY, f32::min);
        are_there().map(|own| own.high[axis]).fold(f32::NEG_INFINITY, f32::max) - low
    };
    let grid = grid_of([0, 1, 2].map(length), most_bits, width as f32);
    let scale = (1.0 / unit) as f32;
    let mut levels = [0; 2];
    let bin = |own: &Aabb| {
        if own.low[0] > own.high[0] {
            return 1 << most_bits;
        }
        let edge = [0, 1, 2].map(|axis| (own.high[axis] - own.low[axis]) * scale);
        let level = level_of(edge.into_iter().fold(0.0, f32::max));
        levels[level as usize / 32] |= 1 << (level % 32);
        let size = f32::from_bits((127 - level) << 23);
        let bin = [0, 1, 2].map(|axis| (own.low[axis] * scale * size).floor() as i32);
        index_of(bin, level, grid)
    };
    Emitted { bin: boxes.iter().map(bin).collect(), grid, levels }
}

/// The bits of the bins' coordinates along each axis, for boxes that are so far apart, m.
fn grid_of(lengths: [f32; 3], most_bits: u32, width: f32) -> [u32; 3] {
    let mut grid = lengths.map(|length| {
        let (mut bits, mut covered) = (3, 8.0 * width);
        while bits < 24 && covered < length {
            (bits, covered) = (bits + 1, 2.0 * covered);
        }
        bits
    });
    while grid.iter().sum::<u32>() > most_bits {
        let most = grid.iter().copied().max().expect("three axes");
        let axis = grid.iter().position(|bits| *bits == most).expect("one of them");
        grid[axis] -= 1;
    }
    grid
}

/// The level whose bins have twice the power of two below a width, in steps.
fn level_of(width: f32) -> u32 {
    (width.to_bits() >> 23).wrapping_sub(126).min(63)
}

/// The index of a bin.
fn index_of(bin: [i32; 3], level: u32, grid: [u32; 3]) -> u32 {
    let at = bin.map(|along| along.wrapping_add(37 * level as i32) as u32);
    let inner = at.map(|along| along & 7);
    let [x, y, z] = [0, 1, 2].map(|axis| (at[axis] >> 3) & ((1 << (grid[axis] - 3)) - 1));
    let outer = x | (y | z << (grid[1] - 3)) << (grid[0] - 3);
    outer << 9 | inner[2] << 6 | inner[1] << 3 | inner[0]
}

#[cfg(test)]
mod tests {
    use super::most_bits;

    #[test]
    fn there_are_at_most_eight_bins_a_sphere_rounded_up() {
        assert_eq!([1, 64, 100, 1_000_000, 100_000_000].map(most_bits), [9, 9, 10, 23, 24]);
    }
}
