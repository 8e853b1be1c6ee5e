//! Shading of visible points by kernels of their surface and atmosphere shaders, those alike together.

use crate::cpu::frame::Frame;
use crate::cpu::view::View;
use crate::gpu::caps::Caps;
use crate::gpu::few::{Chosen, Few, count_of, offset_of};
use crate::gpu::front::Diced;
use crate::gpu::kept::{Kept, Recorded};
use crate::gpu::kernels::{FrameKernels, groups, staged};
use crate::gpu::outputs::Outputs;
use crate::gpu::refusal::Refusal;
use crate::gpu::world::{DECLARATIONS, FUNCTIONS, OF_RAYS};
use crate::scene::attributes::Attributes;
use crate::scene::source::{Item, ItemView, Source};
use crate::scene::world::Scene;
use crate::stats::Stats;
use gpu::{Buffer, Device, GpuError, Kernels, Work};
use rayon::prelude::*;
use sl::Global;
use sl::ir::{Ask, Lookup, Program};
use sl::machine::BoundShader;
use sl::wgsl::{Batch, Extent, Host, Kernel, Query, Target};
use std::collections::HashSet;
use std::sync::Arc;

/// Points of a grid that looks at neighbours, at least as many as any has.
const GROUP: u32 = 320;

/// A kernel of shaders, and what it is for.
struct Look {
    surface: Arc<BoundShader>,
    lights: Arc<Vec<Arc<BoundShader>>>,
    atmosphere: Option<Arc<BoundShader>>,
    kernel: Kernel,
    /// That of the atmosphere.
    through: Option<Kernel>,
    /// Of the surface's shader and of the atmosphere's: points with what is no finite number, and the first source of these; points of the first
    /// with what is no number; points with opacities below 0 or above 1, and the first source of these.
    lost: Buffer<u32>,
}

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
    looks: Vec<Look>,
    /// The looks of sources, as far as they are known.
    of_source: Vec<Option<usize>>,
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
        Ok(Shaders { device, kernels, own, kept, looks: vec![], of_source: vec![], world, nothing, most_values })
    }

    /// Find kernels for all that the camera may see, of whose sources some become layers; whether any asks what stops light, and what closes
    /// the sky.
    ///
    /// # Errors
    /// A shader that has no kernel.
    pub fn find(&mut self, frame: &Frame<'_>, layered: &[bool]) -> Result<[bool; 2], Refusal> {
        let is_wanted = |source: &Source, is_layered: bool| {
            let is_shaded = !source.attributes.matte || is_layered;
            source.attributes.visible && is_shaded && source.len() > 0
        };
        let sources = (0..).zip(&frame.scene.sources).zip(layered);
        let wanted = sources.filter(|((_, source), is_layered)| is_wanted(source, **is_layered));
        let items: Vec<Item> = wanted.map(|((source, _), _)| Item { source, index: 0 }).collect();
        // Those of programs are written at once; the others differ from these in numbers alone, as far as strings do not.
        let mut known = HashSet::new();
        let first: Vec<Item> =
            items.iter().copied().filter(|item| known.insert(programs_of(frame.scene.attributes(*item)))).collect();
        let written: Vec<_> = first.par_iter().map(|item| self.write(frame, *item, &frame.scene.view(*item))).collect();
        for (item, kernels) in first.into_iter().zip(written) {
            if self.known(frame.scene.attributes(item)).is_none() {
                self.push(frame.scene.attributes(item), kernels?)?;
            }
        }
        for item in items {
            self.look(frame, item, &frame.scene.view(item))?;
        }
        let kernels = || self.looks.iter().flat_map(|look| [Some(&look.kernel), look.through.as_ref()]).flatten();
        let asks = |queries: &[Query]| kernels().any(|kernel| queries.iter().any(|query| kernel.asks(*query)));
        let has_shadows = kernels().any(|kernel| kernel.maps().any(|(how, ..)| how == Lookup::Shadow));
        for (_, name, _) in kernels().flat_map(Kernel::maps).filter(|(how, ..)| *how != Lookup::Shadow) {
            frame.scene.textures.number(name);
        }
        if asks(&[Query::Hit]) && frame.rays.any_translucent() {
            let why = "a shader asks what translucent surfaces hide, which is not built for graphics devices";
            return Err(Refusal::Unsupported(why.into()));
        }
        Ok([has_shadows || asks(&OF_RAYS), asks(&[Query::Openness])])
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

    /// The index of what an item looks by, which is that of its source.
    fn look_of(&mut self, frame: &Frame<'_>, item: Item) -> Result<usize, Refusal> {
        let source = item.source as usize;
        if let Some(look) = self.of_source.get(source).copied().flatten() {
            return Ok(look);
        }
        let look = self.look(frame, item, &frame.scene.view(item))?;
        self.of_source.resize(self.of_source.len().max(source + 1), None);
        self.of_source[source] = Some(look);
        Ok(look)
    }

    /// The index of what an item of a view looks by.
    fn look(&mut self, frame: &Frame<'_>, item: Item, view: &ItemView<'_>) -> Result<usize, Refusal> {
        match self.known(view.attributes) {
            Some(k) => Ok(k),
            None => self.push(view.attributes, self.write(frame, item, view)?),
        }
    }

    /// The index of what primitives of some attributes look by, if it is there.
    fn known(&self, a: &Attributes) -> Option<usize> {
        self.looks.iter().position(|look| look.is_of(a))
    }

    /// Write the kernels of an item of a view: that of its surface, and that of its atmosphere.
    fn write(&self, frame: &Frame<'_>, item: Item, view: &ItemView<'_>) -> Result<(Kernel, Option<Kernel>), Refusal> {
        let a = view.attributes;
        let scene = View::new(frame.scene, &frame.rays, item, view, [0.0; 2]);
        let kernel = self.kernel(frame, &a.surface, &a.light_list, &scene)?;
        let Some(shader) = &a.atmosphere else { return Ok((kernel, None)) };
        let scene = View { shader_to_world: a.atmosphere_space, ..scene };
        let through = self.kernel(frame, shader, &a.light_list, &scene)?;
        if through.asks_by_name(Ask::Surface) {
            return Err(Refusal::of_shader(&shader.program.name, "asks a surface shader what it has left"));
        }
        let changes = |target| !matches!(target, Target::Global(Global::Ci | Global::Oi) | Target::Parameter(_));
        if kernel.outputs().iter().any(|output| changes(output.target)) {
            return Err(Refusal::of_shader(&a.surface.program.name, "changes more than colours before an atmosphere"));
        }
        Ok((kernel, Some(through)))
    }

    /// Add what primitives of some attributes look by; its index.
    fn push(&mut self, a: &Attributes, (kernel, through): (Kernel, Option<Kernel>)) -> Result<usize, Refusal> {
        let (surface, lights, atmosphere) = (a.surface.clone(), a.light_list.clone(), a.atmosphere.clone());
        let lost =
            Buffer::of(self.device, "points without finite colours", &[0, u32::MAX, 0, u32::MAX, 0, 0, u32::MAX])?;
        self.looks.push(Look { surface, lights, atmosphere, kernel, through, lost });
        Ok(self.looks.len() - 1)
    }

    /// Write the kernel of a shader for lights.
    fn kernel(
        &self,
        frame: &Frame<'_>,
        shader: &Arc<BoundShader>,
        lights: &[Arc<BoundShader>],
        scene: &View<'_>,
    ) -> Result<Kernel, Refusal> {
        let group = GROUP.min(self.device.adapter.max_invocations);
        let declarations = DECLARATIONS[frame.rays.any_translucent() as usize];
        let host = |functions| Host { group, functions, declarations, scene };
        let mut kernel = Kernel::new(shader, lights, host(&FUNCTIONS[0]))?;
        if kernel.maps().any(|(how, ..)| how != Lookup::Shadow) {
            kernel = Kernel::new(shader, lights, host(&FUNCTIONS[1]))?;
        }
        if let Some((_, map, _)) = kernel.maps().find(|(how, _, by_light)| *how == Lookup::Shadow && !by_light) {
            return Err(Refusal::of_shader(&shader.program.name, &format!("looks up the shadow map `{map}`")));
        }
        if let Some(light) = kernel.light_of_primitive() {
            return Err(Refusal::of_shader(light, "is a light's that reads what differs from primitive to primitive"));
        }
        Ok(kernel)
    }

    /// Tell the scene of colours and opacities that are no finite numbers, and of what are no opacities.
    ///
    /// # Errors
    /// Those of [`Buffer::read`].
    pub fn report(&self, scene: &Scene) -> Result<(), GpuError> {
        for look in &self.looks {
            let lost = look.lost.read(self.device, 7)?;
            if lost[0] > 0 {
                scene.not_finite(&look.surface.program, lost[0] as usize, lost[1]);
            }
            let more = lost[2].saturating_sub(lost[4]);
            if let Some(atmosphere) = look.atmosphere.as_ref().filter(|_| more > 0) {
                scene.not_finite(&atmosphere.program, more as usize, lost[3]);
            }
            if lost[5] > 0 {
                scene.not_opacities(&look.surface.program, lost[5] as usize, lost[6]);
            }
        }
        Ok(())
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
        let mut by_look: Vec<Vec<Wanted>> = vec![];
        let (mut first, mut cap) = (0, 0);
        for (index, grid) in grids.iter().enumerate() {
            let count = count_of(wanted, first, grid.n());
            if count > 0 {
                let look = self.look_of(frame, grid.item)?;
                by_look.resize_with(by_look.len().max(look + 1), Vec::new);
                by_look[look].push(Wanted { chosen: Chosen { index, first, cap }, count });
            }
            first += grid.n_shaded();
            cap += u32::from(grid.cap.is_some());
        }
        for (look, own) in by_look.iter().enumerate() {
            let mut rest = own.as_slice();
            while !rest.is_empty() {
                let taken = self.fitting(grids, rest);
                self.run(frame, &self.looks[look], grids, (&rest[..taken], wanted), goal, stats)?;
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

    /// Shade grids of a look: parts of them are prepared by several threads, and run together.
    fn run(
        &self,
        frame: &Frame<'_>,
        look: &Look,
        grids: &[Diced],
        (own, wanted): (&[Wanted], &[u32]),
        goal: Goal<'_>,
        stats: &mut Stats,
    ) -> Result<(), Refusal> {
        /// Grids that are worth a part.
        const LEAST: usize = 512;
        let n_parts = own.len().div_ceil(LEAST).min(rayon::current_num_threads());
        let prepare = |part: &[Wanted]| Prepared::new(frame, look, grids, (part, wanted), goal.outputs.is_some());
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
        let status = [status(&look.kernel)?, status(look.through.as_ref().unwrap_or(&look.kernel))?];
        self.run_parts(frame, look, &parts, goal, &status)?;
        // They are large.
        parts.into_par_iter().for_each(drop);
        for (kernel, status) in [Some(&look.kernel), look.through.as_ref()].into_iter().zip(&status) {
            let Some(kernel) = kernel else { continue };
            if let Some(fault) = kernel.faults(&status.read(self.device, kernel.n_status())?).first() {
                return Err(Refusal::of_fault(fault));
            }
        }
        Ok(())
    }

    /// Run the kernels of a look over some points, and take what they find; `status` takes their faults.
    fn run_parts(
        &self,
        frame: &Frame<'_>,
        look: &Look,
        parts: &[Prepared<'_>],
        goal: Goal<'_>,
        status: &[Buffer<u32>; 2],
    ) -> Result<(), Refusal> {
        let batches: Vec<&Batch<'_>> = parts.iter().map(|part| &part.batch).collect();
        let mut recorded = Recorded::new(staged("shade"));
        let first = Before::Caps(parts, goal);
        let results = self.dispatch(frame, (&look.kernel, &batches), first, &status[0], &mut recorded)?;
        let own = parts.iter().map(|part| (&part.few, &part.batch));
        self.take(&look.kernel, own, &results, (look, 0), goal, &mut recorded)?;
        recorded.send(self.device, self.kept)?;
        for part in parts {
            self.take_given(&part.few, look, goal)?;
            if let Some(outputs) = goal.outputs {
                self.take_outputs(outputs, &part.few.rows, &results)?;
                let given = Buffer::of(self.device, "given outputs", &part.few.given_outputs)?;
                self.take_outputs(outputs, &part.few.given_rows, &given)?;
            }
        }
        if let Some(kernel) = &look.through {
            // What the atmosphere leaves is as the surface has it.
            let own = || parts.iter().filter_map(|part| Some((&part.few, &part.batch, part.later.as_ref()?)));
            let runs: Vec<_> = own().flat_map(|(few, batch, later)| few.relays(batch, &look.kernel, later)).collect();
            let batches: Vec<&Batch<'_>> = own().map(|(_, _, later)| later).collect();
            let mut recorded = Recorded::new(staged("shade"));
            let before = Before::Surface(&results, &runs);
            let passed = self.dispatch(frame, (kernel, &batches), before, &status[1], &mut recorded)?;
            let own = own().map(|(few, _, later)| (few, later));
            self.take(kernel, own, &passed, (look, 1), goal, &mut recorded)?;
            recorded.send(self.device, self.kept)?;
        }
        self.kept.give("results", results);
        Ok(())
    }

    /// Record that a kernel runs over batches that stand one behind the other, whose values take what there is before it.
    fn dispatch(
        &self,
        frame: &Frame<'_>,
        (kernel, batches): (&Kernel, &[&Batch<'_>]),
        before: Before<'_>,
        status: &Buffer<u32>,
        recorded: &mut Recorded,
    ) -> Result<Buffer<f32>, Refusal> {
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
        let values = kept.take(device, "values", all.values)?;
        let results = kept.take(device, "results", all.results)?;
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
            Before::Surface(found, runs) => {
                let n = runs.len();
                let runs = Buffer::of(device, "runs", runs)?;
                let bound = [runs.bind(), found.bind(), values.bind()];
                recorded.commands.dispatch(device, &self.own.relay, &bound, &[n as u32], Work::Groups(n as u32));
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
        recorded.hold("values", values);
        Ok(results)
    }

    /// Record that the colours and opacities are taken that a kernel has found, if it gives any: that of the surface, 0, or of the atmosphere, 1, of
    /// a look.
    fn take<'b>(
        &self,
        kernel: &Kernel,
        own: impl Iterator<Item = (&'b Few<'b>, &'b Batch<'b>)>,
        results: &Buffer<f32>,
        by: (&Look, u32),
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
    fn take_given(&self, few: &Few<'_>, look: &Look, goal: Goal<'_>) -> Result<(), GpuError> {
        if goal.opacities.is_none() || offset_of(&look.kernel, Global::Oi).is_some() {
            return Ok(());
        }
        let rows: Vec<_> = few.grids.iter().flat_map(|grid| grid.rows_of_opacities()).collect();
        let given = Buffer::of(self.device, "given opacities", &few.opacities)?;
        let mut recorded = Recorded::new(staged("shade"));
        self.put(&rows, &given, [u32::MAX, 0], (look, 0), goal, &mut recorded)?;
        recorded.send(self.device, self.kept)
    }

    /// Record that colours and opacities are put among those of all points, by two rows a grid.
    fn put(
        &self,
        rows: &[[u32; 4]],
        results: &Buffer<f32>,
        [color, opacity]: [u32; 2],
        (look, index): (&Look, u32),
        goal: Goal<'_>,
        recorded: &mut Recorded,
    ) -> Result<(), GpuError> {
        let n = rows.len() / 2;
        let rows = self.kept.filled(self.device, "shaded grids", rows)?;
        let changes = |kernel: &Kernel| offset_of(kernel, Global::Oi).is_some();
        let is_last = index == 1 || !look.through.as_ref().is_some_and(changes);
        let params = [n as u32, color, opacity, goal.opacities.is_some() as u32, index, is_last as u32];
        let opacities = goal.opacities.unwrap_or(&self.nothing);
        let bound =
            [rows.bind(), goal.wanted.bind(), results.bind(), goal.colors.bind(), opacities.bind(), look.lost.bind()];
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
    /// What a surface's kernel has found, by runs.
    Surface(&'a Buffer<f32>, &'a [[u32; 4]]),
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
    /// Of the points of grids of a look that are wanted.
    fn new(
        frame: &Frame<'_>,
        look: &'a Look,
        grids: &[Diced],
        (own, wanted): (&[Wanted], &[u32]),
        takes_outputs: bool,
    ) -> Result<Prepared<'a>, Refusal> {
        let item = grids[own[0].chosen.index].item;
        let view = frame.scene.view(item);
        let scene = View::new(frame.scene, &frame.rays, item, &view, [0.0; 2]);
        let mut batch = Batch::new(&look.kernel, &look.lights, &scene)?;
        let mut later = look.through.as_ref().map(|kernel| Batch::new(kernel, &look.lights, &scene)).transpose()?;
        let mut few = Few::of(&look.kernel, takes_outputs);
        for one in own {
            few.add(frame, &grids[one.chosen.index], (one.chosen, wanted), &mut batch, later.as_mut())?;
        }
        let first = batch.place_filled() as u32;
        few.of_caps.iter_mut().step_by(2).for_each(|row| row[3] += first);
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

/// The programs of the shaders that primitives of some attributes look by, and the lights that shine on them, by where they are.
fn programs_of(a: &Attributes) -> (*const Program, Option<*const BoundShader>, Vec<*const BoundShader>) {
    let lights = a.light_list.iter().map(Arc::as_ptr).collect();
    (Arc::as_ptr(&a.surface.program), a.atmosphere.as_ref().map(Arc::as_ptr), lights)
}

impl Look {
    /// Whether primitives of these attributes look by it.
    fn is_of(&self, a: &Attributes) -> bool {
        let same = |a: &[Arc<BoundShader>], b: &[Arc<BoundShader>]| {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| Arc::ptr_eq(a, b))
        };
        let through = match (&self.atmosphere, &a.atmosphere) {
            (Some(own), Some(other)) => Arc::ptr_eq(own, other),
            (None, None) => true,
            _ => false,
        };
        let is_same = Arc::ptr_eq(&self.surface, &a.surface) || self.kernel.is_of(&a.surface);
        through && is_same && same(&self.lights, &a.light_list)
    }
}
