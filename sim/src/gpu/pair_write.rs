//! Broad phase: count, scan, write every pair of spheres whose fat boxes overlap, once.
//! in   fat_aabb   [n_spheres]  m, world
//! in   bin_shape  [n_spheres]  sorted by bin
//! in   bin_start  [n_bins]
//! out  pairs      [n_pairs]    the lower sphere first, in the order of bins
//! Kernels: pair_write.wgsl in two passes, and the scan. Twin: cpu/pair_write.rs

use super::bin_emit::Bins;
use super::bounds::Due;
use super::spheres::{ROWS, Spheres, kernel_with};
use crate::model::Model;
use gpu::scan::Scan;
use gpu::{Buffer, Commands, Count, Device, GpuError, Groups, Kernel, Kernels};

/// The pairs.
pub struct Pairs {
    /// First pair of each sphere in the sorted column, and the end (n_spheres + 1).
    pub start: Buffer<u32>,
    /// Pairs, the lower sphere first (n_pairs).
    pub pairs: Buffer<[u32; 2]>,
    /// Number of pairs, which may exceed the room.
    pub n: Count,
}

/// The stage's kernels, and the rules of what may collide.
pub struct PairWrite {
    count: Kernel,
    write: Kernel,
    scan: Scan,
    groups: Groups,
    /// Whether two groups pass through each other (n_groups²), then the excluded pairs of bodies.
    rules: Buffer<u32>,
}

impl PairWrite {
    /// Compile the kernels.
    pub fn new(device: &Device, kernels: &Kernels, model: &Model, n: usize) -> Result<PairWrite, GpuError> {
        let text = include_str!("pair_write.wgsl");
        let pass = |name, part| kernel_with(device, kernels, (name, text), ("pair_pass", part));
        let passes = model.groups_pass.iter().map(|passes| *passes as u32);
        let rules: Vec<u32> = passes.chain(model.exclusions.iter().flatten().copied()).collect();
        Ok(PairWrite {
            count: pass("pair_count", include_str!("pair_count.wgsl"))?,
            write: pass("pair_write", include_str!("pair_pass.wgsl"))?,
            scan: Scan::new(device, kernels, n + 1)?,
            groups: Groups::new(device, kernels, ROWS)?,
            rules: Buffer::of(device, "rules", &rules)?,
        })
    }

    /// Record the stage.
    pub fn record(
        &self,
        device: &Device,
        commands: &mut Commands,
        model: &Model,
        at: &Spheres,
        (due, bins): (&Due, &Bins),
        to: &Pairs,
    ) {
        let boxes = [at.fat_aabb.bind(), at.sphere.bind(), at.activity.bind(), bins.shape.bind(), bins.start.bind()];
        let rest = [self.rules.bind(), due.levels.bind(), due.spheres.n.bind()];
        let out = [to.start.bind(), to.pairs.bind(), to.n.n.bind()];
        let bound: Vec<gpu::Bound> = boxes.into_iter().chain(rest).chain(out).collect();
        let ([x, y, z], scale) = (bins.bits, (1.0 / at.scale.unit as f32).to_bits());
        let params = [model.group_names.len() as u32, model.exclusions.len() as u32, x, y, z, scale];
        self.groups.record(device, commands, &due.spheres);
        commands.dispatch(device, &self.count, &bound, &params, self.groups.of_level(&due.spheres, 0));
        self.scan.record(device, commands, &to.start, &due.rows);
        commands.dispatch(device, &self.write, &bound, &params, self.groups.of_level(&due.spheres, 0));
    }
}
