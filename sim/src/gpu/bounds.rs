//! Bound every sphere by an axis-aligned box, grown by its margin; tell whether one has left its fat box.
//! in    position  [n_bodies]   fine units
//! in    velocity  [n_bodies]   m/s
//! in    orientation, spin [n_bodies]  rad/s, where shapes are of any kind
//! in    activity  [n_bodies]
//! out   margin    [n_spheres]  m, distance within which contacts are generated: δ + |v| h
//! inout fat_aabb  [n_spheres]  m, renewed for all when a tight box has left its fat one
//! out   lasts     [1]          number of steps for which none will
//! out   next      [1]          the same from the start of the next step on
//! out   due       counts of what the broad phase works on: all, or nothing while the pairs hold
//! Kernels: bounds.wgsl, pairs_due.wgsl, fatten.wgsl. Twin: cpu/bounds.rs

use super::bodies::Bodies;
use super::parts::{Layout, ROWS, bits, groups, kernel, kernel_of};
use super::spheres::Spheres;
use crate::cpu::bounds::{FAT_MARGIN, STEPS};
use crate::model::Model;
use gpu::{Bound, Buffer, Commands, Count, Device, GpuError, Groups, Kernel, Kernels, Work};

/// What the broad phase works on.
pub struct Due {
    /// Not zero if a sphere has left its fat box: all boxes are renewed (1).
    pub left: Buffer<u32>,
    /// Not zero if the pairs are found even though none has (1).
    pub lost: Buffer<u32>,
    /// As bits: the number of steps, from the start of this one on, for which none will (1).
    pub lasts: Buffer<u32>,
    /// The same from the start of the next step on, none if one will have left its box by then (1); and whether one will (1).
    pub next: [Buffer<u32>; 2],
    /// The spheres whose boxes are renewed.
    renewed: Count,
    /// The spheres.
    pub spheres: Count,
    /// The spheres and one row more.
    pub rows: Count,
    /// The bins.
    pub bins: Count,
    /// Mask of the levels of bins that are used (2).
    pub levels: Buffer<u32>,
}

impl Due {
    /// For this many spheres and bins; all are due.
    pub fn new(device: &Device, n: usize, n_bins: usize) -> Result<Due, GpuError> {
        Ok(Due {
            left: Buffer::of(device, "left", &[1])?,
            lost: Buffer::of(device, "lost", &[1])?,
            lasts: Buffer::of(device, "lasts", &[bits(f32::MAX as f64)])?,
            next: [Buffer::of(device, "next", &[bits(f32::MAX as f64)])?, Buffer::zeros(device, "next left", 1)?],
            renewed: Count::found(device, n)?,
            spheres: Count::found(device, n)?,
            rows: Count::found(device, n + 1)?,
            bins: Count::found(device, n_bins)?,
            levels: Buffer::zeros(device, "levels", 2)?,
        })
    }
}

/// The stage's kernels.
pub struct Bounds {
    bounds: Kernel,
    due: Kernel,
    fatten: Kernel,
    groups: Groups,
}

impl Bounds {
    /// Compile the kernels.
    pub fn new(device: &Device, kernels: &Kernels, layout: Layout) -> Result<Bounds, GpuError> {
        Ok(Bounds {
            bounds: kernel_of(layout, device, kernels, ("bounds", include_str!("bounds.wgsl")))?,
            due: kernel(device, kernels, "pairs_due", include_str!("pairs_due.wgsl"))?,
            fatten: kernel_of(layout, device, kernels, ("fatten", include_str!("fatten.wgsl")))?,
            groups: Groups::new(device, kernels, ROWS)?,
        })
    }

    /// Record the margins of the poses that there are, and for how many steps the boxes hold these: from this step on, or at its end from the next.
    pub fn record_margins(
        &self,
        device: &Device,
        commands: &mut Commands,
        model: &Model,
        (bodies, at): (&Bodies, &Spheres),
        (due, is_next): (&Due, bool),
    ) {
        let [envelope, step, unit] = [model.envelope, model.step, bodies.scale.unit].map(bits);
        let [position, velocity] = [bodies.position.bind(), bodies.velocity.bind()];
        let [activity, sphere] = [bodies.activity.bind(), at.sphere.bind()];
        let (margin, fat) = (at.margin.bind(), at.fat_aabb.bind());
        let turning = [bodies.orientation.bind(), bodies.spin.bind(), at.solid.bind()];
        let [next, next_left] = &due.next;
        let [left, lasts] = if is_next { [next_left, next] } else { [&due.left, &due.lasts] }.map(Buffer::bind);
        let own = [position, velocity, activity, sphere, fat, margin, left, lasts];
        let bound: Vec<Bound> = own.into_iter().chain(turning).collect();
        commands.dispatch(device, &self.bounds, &bound, &[at.n as u32, envelope, step, unit], groups(at.n));
    }

    /// Record the stage, in which boxes are renewed where one has been left.
    pub fn record(
        &self,
        device: &Device,
        commands: &mut Commands,
        model: &Model,
        (bodies, at): (&Bodies, &Spheres),
        due: &Due,
    ) {
        self.record_margins(device, commands, model, (bodies, at), (due, false));
        let [step, unit] = [model.step, bodies.scale.unit].map(bits);
        let [position, velocity] = [bodies.position.bind(), bodies.velocity.bind()];
        let [activity, sphere] = [bodies.activity.bind(), at.sphere.bind()];
        let (margin, fat) = (at.margin.bind(), at.fat_aabb.bind());
        let turning = [bodies.orientation.bind(), bodies.spin.bind(), at.solid.bind()];
        let [renewed, spheres, rows, bins] =
            [&due.renewed, &due.spheres, &due.rows, &due.bins].map(|count| count.n.bind());
        let counts = [renewed, spheres, rows, bins, due.lasts.bind(), due.levels.bind()];
        let bound: Vec<Bound> = [due.left.bind(), due.lost.bind()].into_iter().chain(counts).collect();
        let params = [at.n as u32, due.bins.capacity as u32, bits(STEPS)];
        commands.dispatch(device, &self.due, &bound, &params, Work::Groups(1));

        self.groups.record(device, commands, &due.renewed);
        let own = [position, velocity, activity, sphere, margin, fat, renewed];
        let bound: Vec<Bound> = own.into_iter().chain(turning).collect();
        let work = self.groups.of_level(&due.renewed, 0);
        commands.dispatch(device, &self.fatten, &bound, &[step, unit, bits(STEPS), FAT_MARGIN.to_bits()], work);
    }
}
