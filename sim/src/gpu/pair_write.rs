//! Broad phase: count, scan, write every pair of spheres whose fat boxes overlap, once, and those of spheres and fixtures.
//! in   fat_aabb   [n_spheres]  m, world
//! in   bin_shape  [n_spheres]  sorted by bin
//! in   bin_start  [n_bins]
//! in   fixture    [n_fixtures]
//! out  pairs      [n_pairs]    the lower sphere first, or a sphere and n_spheres plus a fixture; in the order of bins
//! Kernels: pair_write.wgsl in two passes, and the scan. Twin: cpu/pair_write.rs

use super::bin_emit::Bins;
use super::bodies::Bodies;
use super::bounds::Due;
use super::fixtures::Fixtures;
use super::parts::{Layout, ROWS, bits, kernel_with};
use super::spheres::Spheres;
use crate::model::Model;
use gpu::scan::Scan;
use gpu::{Buffer, Commands, Count, Device, GpuError, Groups, Kernel, Kernels};

/// The pairs.
pub struct Pairs {
    /// First pair of each sphere in the sorted column, and the end (n_spheres + 1).
    pub start: Buffer<u32>,
    /// Pairs, the lower sphere first (n_pairs).
    pub pairs: Buffer<[u32; 2]>,
    /// Number of pairs; 0 where there is no room for all.
    pub n: Count,
    /// Number of pairs that room is needed for, whether there is room, and the number of contacts that it is needed for, where a pair may
    /// have several (3).
    pub room: Buffer<u32>,
}

impl Pairs {
    /// With room for this many pairs of `n` spheres.
    pub fn new(device: &Device, n: usize, room: usize) -> Result<Pairs, GpuError> {
        Ok(Pairs {
            start: Buffer::zeros(device, "pair_start", n + 1)?,
            pairs: Buffer::zeros(device, "pairs", room)?,
            n: Count::found(device, room)?,
            room: Buffer::of(device, "room", &[0, 1, 0])?,
        })
    }
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
    pub fn new(
        device: &Device,
        kernels: &Kernels,
        (model, layout): (&Model, Layout),
        n: usize,
    ) -> Result<PairWrite, GpuError> {
        let text = include_str!("pair_write.wgsl");
        let pass = |name, part| kernel_with(layout, device, kernels, (name, text), &[("pair_pass", part)]);
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
        (bodies, at, fixtures): (&Bodies, &Spheres, &Fixtures),
        (due, bins, to): (&Due, &Bins, &Pairs),
    ) {
        let boxes =
            [at.fat_aabb.bind(), at.sphere.bind(), bodies.activity.bind(), bins.shape.bind(), bins.start.bind()];
        let held = [fixtures.fixture.bind(), fixtures.aabb.bind()];
        let rest = [self.rules.bind(), due.levels.bind(), due.spheres.n.bind()];
        let out =
            [to.start.bind(), to.pairs.bind(), to.room.bind(), to.n.n.bind(), bins.grid.bind(), fixtures.node.bind()];
        let bound: Vec<gpu::Bound> = boxes.into_iter().chain(held).chain(rest).chain(out).collect();
        let (n_groups, n_exclusions) = (model.group_names.len() as u32, model.exclusions.len() as u32);
        let params = [n_groups, n_exclusions, fixtures.n as u32, bits(1.0 / bodies.scale.unit)];
        self.groups.record(device, commands, &due.spheres);
        commands.dispatch(device, &self.count, &bound, &params, self.groups.of_level(&due.spheres, 0));
        self.scan.record(device, commands, &to.start, &due.rows);
        commands.dispatch(device, &self.write, &bound, &params, self.groups.of_level(&due.spheres, 0));
    }
}
