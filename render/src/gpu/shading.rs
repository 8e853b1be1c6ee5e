//! Shading of visible points by kernels of their surface and atmosphere shaders, those of a material together.

use crate::cpu::frame::Frame;
use crate::cpu::view::View;
use crate::gpu::caps::Caps;
use crate::gpu::few::{Chosen, Few, count_of, offset_of};
use crate::gpu::front::Diced;
use crate::gpu::kept::{Kept, Recorded};
use crate::gpu::kernels::{FrameKernels, groups, staged};
use crate::gpu::materials::{Material, Materials};
use crate::gpu::outputs::Outputs;
use crate::gpu::refusal::Refusal;
use crate::gpu::world::FUNCTIONS;
use crate::stats::Stats;
use gpu::{Buffer, Device, GpuError, Kernels, Work};
use rayon::prelude::*;
use sl::Global;
use sl::wgsl::{Batch, Extent, Kernel};

/// Where shading puts what it finds of points.
#[derive(Clone, Copy)]
pub struct Goal<'a> {
    pub colors: &'a Buffer<[f32; 4]>,
    /// Opacities, if they are wanted.
    pub opacities: Option<&'a Buffer<[f32; 4]>>,
    /// What displays take besides, if they do.
    pub outputs: Option<&'a Outputs>,
    /// The tiles that the device dices.
    pub caps: &'a Caps,
    /// The points that are wanted, a bit each.
    pub wanted: &'a Buffer<u32>,
}

/// The shaders of a frame.
pub struct Shaders<'a> {
    device: &'a Device,
    kernels: &'a Kernels,
    own: &'a FrameKernels,
    kept: &'a Kept,
    pub materials: Materials<'a>,
    /// What kernels read of the scene.
    world: Buffer<[u32; 4]>,
    /// What stands for opacities where these are not wanted.
    nothing: Buffer<[f32; 4]>,
    /// Numbers that shaders are given at a time.
    most_values: usize,
}

impl<'a> Shaders<'a> {
    /// None yet, whose kernels are given so many numbers at a time.
    ///
    /// # Errors
    /// Those of [`Buffer::zeros`].
    pub fn new(
        device: &'a Device,
        (kernels, own, kept): (&'a Kernels, &'a FrameKernels, &'a Kept),
        most_values: usize,
    ) -> Result<Shaders<'a>, GpuError> {
        let world = Buffer::zeros(device, "scene", 1)?;
        let nothing = Buffer::zeros(device, "no opacities", 1)?;
        Ok(Shaders { device, kernels, own, kept, materials: Materials::new(device), world, nothing, most_values })
    }

    /// Let kernels read the scene.
    ///
    /// # Errors
    /// Those of [`Buffer::of`].
    pub fn set_world(&mut self, rows: &[[u32; 4]]) -> Result<(), GpuError> {
        self.world = self.kept.filled(self.device, "scene", rows)?;
        Ok(())
    }

    /// Keep what kernels read of the scene for another frame: they read it no more.
    pub fn keep(&self) {
        self.kept.give("scene", self.world.clone());
    }

    /// Shade the points of grids that are wanted, a bit each, and put what is found of them among that of all points.
    ///
    /// # Errors
    /// What has no kernel, and faults of the device.
    pub fn shade(
        &mut self,
        frame: &Frame<'_>,
        grids: &[Diced],
        wanted: &[u32],
        goal: Goal<'_>,
        stats: &mut Stats,
    ) -> Result<(), Refusal> {
        let mut by_material: Vec<Vec<Wanted>> = vec![];
        let (mut first, mut cap) = (0, 0);
        for (index, grid) in grids.iter().enumerate() {
            let count = count_of(wanted, first, grid.n());
            if count > 0 {
                let material = self.materials.of(frame, grid.item)?;
                by_material.resize_with(by_material.len().max(material + 1), Vec::new);
                by_material[material].push(Wanted { chosen: Chosen { index, first, cap }, count });
            }
            first += grid.n_shaded();
            cap += u32::from(grid.cap.is_some());
        }
        for (material, own) in by_material.iter().enumerate() {
            let mut rest = own.as_slice();
            while !rest.is_empty() {
                let taken = self.fitting(grids, rest);
                self.run(frame, &self.materials.all[material], grids, (&rest[..taken], wanted), goal, stats)?;
                rest = &rest[taken..];
            }
        }
        Ok(())
    }

    /// How many of some grids are given to shaders at a time, by about how many numbers they have.
    fn fitting(&self, grids: &[Diced], own: &[Wanted]) -> usize {
        /// Numbers of a grid, and of a point besides those that it has.
        const GRID: usize = 64;
        const POINT: usize = 12;
        let numbers = |one: &Wanted| {
            let grid = &grids[one.chosen.index];
            let of_points = grid.points.iter().flat_map(|points| points.variables());
            let all: usize = of_points.map(Vec::len).sum();
            (1 + grid.fades.len()) * (GRID + one.count * (POINT + all.div_ceil(grid.n())))
        };
        let sums = own.iter().scan(0, |sum, one| {
            *sum += numbers(one);
            Some(*sum)
        });
        sums.take_while(|sum| *sum < self.most_values).count().clamp(1, own.len())
    }

    /// Shade grids of a material: parts of them are prepared by several threads, and run together.
    fn run(
        &self,
        frame: &Frame<'_>,
        material: &Material,
        grids: &[Diced],
        (own, wanted): (&[Wanted], &[u32]),
        goal: Goal<'_>,
        stats: &mut Stats,
    ) -> Result<(), Refusal> {
        /// Grids that are worth a part.
        const LEAST: usize = 512;
        let n_parts = own.len().div_ceil(LEAST).min(rayon::current_num_threads());
        let prepare = |part: &[Wanted]| Prepared::new(frame, material, grids, (part, wanted), goal.outputs.is_some());
        let parts: Vec<_> = own.par_chunks(own.len().div_ceil(n_parts)).map(prepare).collect();
        // One behind the other, so that one dispatch shades them all.
        let mut parts: Vec<Prepared<'_>> = parts.into_iter().collect::<Result<_, _>>()?;
        let [mut before, mut before_later] = [Extent::default(); 2];
        for part in &mut parts {
            stats.shaded_points += part.few.n_points as u64;
            part.place([&mut before, &mut before_later]);
        }
        parts.par_iter_mut().for_each(Prepared::move_on);
        let status = |kernel: &Kernel| Buffer::<u32>::zeros(self.device, "status", kernel.n_status());
        let status = [status(&material.kernel)?, status(material.through.as_ref().unwrap_or(&material.kernel))?];
        self.run_parts(frame, material, &parts, goal, &status)?;
        // They are large.
        parts.into_par_iter().for_each(drop);
        for (kernel, status) in [Some(&material.kernel), material.through.as_ref()].into_iter().zip(&status) {
            let Some(kernel) = kernel else { continue };
            if let Some(fault) = kernel.faults(&status.read(self.device, kernel.n_status())?).first() {
                return Err(Refusal::of_fault(fault));
            }
        }
        Ok(())
    }

    /// Run the kernels of a material over some points, and take what they find; `status` takes their faults.
    fn run_parts(
        &self,
        frame: &Frame<'_>,
        material: &Material,
        parts: &[Prepared<'_>],
        goal: Goal<'_>,
        status: &[Buffer<u32>; 2],
    ) -> Result<(), Refusal> {
        let batches: Vec<&Batch<'_>> = parts.iter().map(|part| &part.batch).collect();
        let mut recorded = Recorded::new(staged("shade"));
        let first = Before::Caps(parts, goal);
        let (results, values) = self.dispatch(frame, (&material.kernel, &batches), first, &status[0], &mut recorded)?;
        let own = parts.iter().map(|part| (&part.few, &part.batch));
        self.take(&material.kernel, own, &results, (material, 0), goal, &mut recorded)?;
        recorded.send(self.device, self.kept)?;
        for part in parts {
            self.take_given(&part.few, material, goal)?;
            if let Some(outputs) = goal.outputs {
                self.take_outputs(outputs, &part.few.rows, &results)?;
                let given = Buffer::of(self.device, "given outputs", &part.few.given_outputs)?;
                self.take_outputs(outputs, &part.few.given_rows, &given)?;
            }
        }
        if let Some(kernel) = &material.through {
            // What the atmosphere leaves is as the surface has it.
            let own = || parts.iter().filter_map(|part| Some((&part.few, &part.batch, part.later.as_ref()?)));
            let [mut of_results, mut of_values] = [vec![], vec![]];
            for (few, batch, later) in own() {
                let [results, values] = few.relays(batch, &material.kernel, later);
                of_results.extend(results);
                of_values.extend(values);
            }
            let batches: Vec<&Batch<'_>> = own().map(|(_, _, later)| later).collect();
            let mut recorded = Recorded::new(staged("shade"));
            let before = Before::Surface([(&results, &of_results), (&values, &of_values)]);
            let (passed, given) = self.dispatch(frame, (kernel, &batches), before, &status[1], &mut recorded)?;
            let own = own().map(|(few, _, later)| (few, later));
            self.take(kernel, own, &passed, (material, 1), goal, &mut recorded)?;
            recorded.hold("passed results", passed);
            recorded.hold("passed values", given);
            recorded.send(self.device, self.kept)?;
        }
        self.kept.give("results", results);
        self.kept.give("values", values);
        Ok(())
    }

    /// Record that a kernel runs over batches that stand one behind the other, whose values take what there is before it; its results and its
    /// values.
    fn dispatch(
        &self,
        frame: &Frame<'_>,
        (kernel, batches): (&Kernel, &[&Batch<'_>]),
        before: Before<'_>,
        status: &Buffer<u32>,
        recorded: &mut Recorded,
    ) -> Result<(Buffer<f32>, Buffer<f32>), Refusal> {
        let device = self.device;
        let compiled = self.kernels.get(device, "shader", &kernel.text, &[])?;
        let mut all = Extent::default();
        batches.iter().for_each(|batch| all += batch.extent());
        // Kernels ask for its length.
        let groups: Vec<[u32; 2]> = batches.iter().flat_map(|batch| &batch.groups).copied().collect();
        let groups_of = Buffer::of(device, "groups", &groups)?;
        let kept = self.kept;
        let grids = kept.take(device, "grids", all.grids)?;
        let slots = kept.take(device, "slots", all.slots)?;
        let lights = kept.take(device, "lights", all.lights)?;
        let [of_values, of_results] = match before {
            Before::Caps(..) => ["values", "results"],
            Before::Surface(_) => ["passed values", "passed results"],
        };
        let values = kept.take(device, of_values, all.values)?;
        let results = kept.take(device, of_results, all.results)?;
        for batch in batches {
            let first = batch.before();
            grids.write_from(device, first.grids, &batch.grids);
            slots.write_from(device, first.slots, &batch.slots);
            lights.write_from(device, first.lights, &batch.lights);
            values.write_from(device, first.values, &batch.values);
        }
        match before {
            Before::Caps(parts, goal) => {
                let n: usize = parts.iter().map(|part| part.few.of_caps.len() / 2).sum();
                if n > 0 {
                    let given = kept.take(device, "shaded caps", 2 * n)?;
                    let mut first = 0;
                    for part in parts {
                        given.write_from(device, first, &part.few.of_caps);
                        first += part.few.of_caps.len();
                    }
                    let buffers = (&given, goal.wanted, &values);
                    goal.caps.give(device, self.own, frame, &mut recorded.commands, buffers, n);
                    recorded.hold("shaded caps", given);
                }
            }
            Before::Surface(relays) => {
                for (found, runs) in relays.into_iter().filter(|(_, runs)| !runs.is_empty()) {
                    let n = runs.len() as u32;
                    let runs = Buffer::of(device, "runs", runs)?;
                    let bound = [runs.bind(), found.bind(), values.bind()];
                    recorded.commands.dispatch(device, &self.own.relay, &bound, &[n], Work::Groups(n));
                }
            }
        }
        let inputs = [groups_of.bind(), grids.bind(), slots.bind(), lights.bind(), values.bind()];
        let mut bound: Vec<_> = inputs.into_iter().chain([results.bind(), status.bind()]).collect();
        if FUNCTIONS[0].iter().any(|(query, _)| kernel.asks(*query)) {
            bound.push(self.world.bind());
        }
        recorded.commands.dispatch(device, &compiled, &bound, &[], Work::Groups(groups.len() as u32));
        recorded.hold("grids", grids);
        recorded.hold("slots", slots);
        recorded.hold("lights", lights);
        Ok((results, values))
    }

    /// Record that the colours and opacities are taken that a kernel has found, if it gives any: that of the surface, 0, or of the atmosphere, 1, of
    /// a material.
    fn take<'b>(
        &self,
        kernel: &Kernel,
        own: impl Iterator<Item = (&'b Few<'b>, &'b Batch<'b>)>,
        results: &Buffer<f32>,
        by: (&Material, u32),
        goal: Goal<'_>,
        recorded: &mut Recorded,
    ) -> Result<(), GpuError> {
        let [color, opacity] = [Global::Ci, Global::Oi].map(|g| offset_of(kernel, g).map_or(u32::MAX, |n| n as u32));
        if [color, opacity] == [u32::MAX; 2] {
            return Ok(());
        }
        let of_grid = |(few, batch): (&'b Few<'b>, &'b Batch<'b>)| {
            few.grids.iter().enumerate().flat_map(|(k, grid)| grid.rows(batch.results_of(k)))
        };
        let rows: Vec<_> = own.flat_map(of_grid).collect();
        self.put(&rows, results, [color, opacity], by, goal, recorded)
    }

    /// Take the opacities of points whose surface shader leaves them as they are given.
    fn take_given(&self, few: &Few<'_>, material: &Material, goal: Goal<'_>) -> Result<(), GpuError> {
        if goal.opacities.is_none() || offset_of(&material.kernel, Global::Oi).is_some() {
            return Ok(());
        }
        let rows: Vec<_> = few.grids.iter().flat_map(|grid| grid.rows_of_opacities()).collect();
        let given = Buffer::of(self.device, "given opacities", &few.opacities)?;
        let mut recorded = Recorded::new(staged("shade"));
        self.put(&rows, &given, [u32::MAX, 0], (material, 0), goal, &mut recorded)?;
        recorded.send(self.device, self.kept)
    }

    /// Record that colours and opacities are put among those of all points, by two rows a grid.
    fn put(
        &self,
        rows: &[[u32; 4]],
        results: &Buffer<f32>,
        [color, opacity]: [u32; 2],
        (material, index): (&Material, u32),
        goal: Goal<'_>,
        recorded: &mut Recorded,
    ) -> Result<(), GpuError> {
        let n = rows.len() / 2;
        let rows = self.kept.filled(self.device, "shaded grids", rows)?;
        let changes = |kernel: &Kernel| offset_of(kernel, Global::Oi).is_some();
        let is_last = index == 1 || !material.through.as_ref().is_some_and(changes);
        let params = [n as u32, color, opacity, goal.opacities.is_some() as u32, index, is_last as u32];
        let opacities = goal.opacities.unwrap_or(&self.nothing);
        let bound = [
            rows.bind(),
            goal.wanted.bind(),
            results.bind(),
            goal.colors.bind(),
            opacities.bind(),
            material.lost.bind(),
        ];
        recorded.commands.dispatch(self.device, &self.own.point_colors, &bound, &params, groups(n, 1));
        recorded.hold("shaded grids", rows);
        Ok(())
    }

    /// Put what displays take besides colours among that of all points.
    fn take_outputs(&self, outputs: &Outputs, rows: &[[u32; 4]], results: &Buffer<f32>) -> Result<(), GpuError> {
        let n = rows.len();
        if n == 0 {
            return Ok(());
        }
        let rows = Buffer::of(self.device, "rows of outputs", rows)?;
        let mut commands = staged("shade");
        let bound = [rows.bind(), results.bind(), outputs.of_points.bind()];
        commands.dispatch(self.device, &outputs.kernels.point_outputs, &bound, &[n as u32], groups(n, 256));
        commands.send(self.device)?;
        Ok(())
    }
}

/// A grid with points that are shaded, and how many these are.
struct Wanted {
    chosen: Chosen,
    count: usize,
}

/// What goes to values before a kernel runs.
enum Before<'a> {
    /// Points of tiles that the device dices.
    Caps(&'a [Prepared<'a>], Goal<'a>),
    /// What a surface's kernel has found, and what it was given, by runs.
    Surface([(&'a Buffer<f32>, &'a [[u32; 4]]); 2]),
}

/// Points that are ready to be shaded: for the surface's kernel, and for the atmosphere's.
struct Prepared<'a> {
    batch: Batch<'a>,
    later: Option<Batch<'a>>,
    few: Few<'a>,
    /// What stands before the batches in the buffers of their kernels.
    before: [Extent; 2],
}

impl<'a> Prepared<'a> {
    /// Of the points of grids of a material that are wanted.
    fn new(
        frame: &Frame<'_>,
        material: &'a Material,
        grids: &[Diced],
        (own, wanted): (&[Wanted], &[u32]),
        takes_outputs: bool,
    ) -> Result<Prepared<'a>, Refusal> {
        let item = grids[own[0].chosen.index].item;
        let view = frame.scene.view(item);
        let scene = View::new(frame.scene, &frame.rays, item, &view, [0.0; 2]);
        let mut batch = Batch::new(&material.kernel, &material.lights, &scene)?;
        let mut later =
            material.through.as_ref().map(|kernel| Batch::new(kernel, &material.lights, &scene)).transpose()?;
        let mut few = Few::of(&material.kernel, takes_outputs);
        for one in own {
            few.add(frame, &grids[one.chosen.index], (one.chosen, wanted), &mut batch, later.as_mut())?;
        }
        let first = batch.place_filled() as u32;
        few.of_caps.iter_mut().step_by(2).for_each(|row| row[3] += first);
        if let Some(later) = &mut later {
            later.place_filled();
        }
        let before = [Extent::default(); 2];
        Ok(Prepared { batch, later, few, before })
    }

    /// Note what stands before it in the buffers of the kernels, that of the surface and that of the atmosphere, and add what it has.
    fn place(&mut self, before: [&mut Extent; 2]) {
        for ((own, before), batch) in self.before.iter_mut().zip(before).zip([Some(&self.batch), self.later.as_ref()]) {
            *own = *before;
            *before += batch.map_or_else(Extent::default, Batch::extent);
        }
    }

    /// Move all of its places on by what stands before it.
    fn move_on(&mut self) {
        let [before, before_later] = self.before;
        let (values, results) = (before.values as u32, before.results as u32);
        for rows in self.few.of_caps.as_chunks_mut::<2>().0 {
            (rows[0][3], rows[1][0]) = (rows[0][3] + values, rows[1][0] + values);
        }
        self.few.rows.iter_mut().for_each(|row| row[1] += results);
        self.batch.stand_behind(before);
        if let Some(later) = &mut self.later {
            later.stand_behind(before_later);
        }
    }
}
