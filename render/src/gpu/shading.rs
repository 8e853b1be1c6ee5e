//! Shading of visible points by kernels of their surface and atmosphere shaders, those alike together.

use crate::cpu::deferred::gather;
use crate::cpu::frame::Frame;
use crate::cpu::shade::{Surface, prepare};
use crate::cpu::view::View;
use crate::gpu::front::Diced;
use crate::gpu::kernels::{FrameKernels, groups};
use crate::gpu::refusal::Refusal;
use crate::gpu::world::{DECLARATIONS, FUNCTIONS, OF_RAYS};
use crate::scene::attributes::Attributes;
use crate::scene::source::{Item, ItemView};
use crate::stats::Stats;
use gpu::{Buffer, Commands, Device, GpuError, Kernels, Work};
use sl::Global;
use sl::ir::Ask;
use sl::machine::{BoundShader, Points, VariableSlots};
use sl::wgsl::{Batch, Host, Kernel, Query, Target};
use std::sync::Arc;

/// Points of a grid that looks at neighbours, at least as many as any has.
const GROUP: u32 = 320;

/// Numbers that shaders are given at a time.
const MOST_VALUES: usize = 1 << 23;

/// A kernel of shaders, and what it is for.
struct Look {
    surface: Arc<BoundShader>,
    lights: Arc<Vec<Arc<BoundShader>>>,
    atmosphere: Option<Arc<BoundShader>>,
    kernel: Kernel,
    /// That of the atmosphere.
    through: Option<Kernel>,
}

/// The shaders of a frame.
pub struct Shaders<'a> {
    device: &'a Device,
    kernels: &'a Kernels,
    own: &'a FrameKernels,
    looks: Vec<Look>,
    /// What kernels read of the scene.
    world: Buffer<[u32; 4]>,
}

impl<'a> Shaders<'a> {
    /// None yet.
    ///
    /// # Errors
    /// Those of [`Buffer::zeros`].
    pub fn new(device: &'a Device, kernels: &'a Kernels, own: &'a FrameKernels) -> Result<Shaders<'a>, GpuError> {
        Ok(Shaders { device, kernels, own, looks: vec![], world: Buffer::zeros(device, "scene", 1)? })
    }

    /// Find kernels for all that the camera may see; whether any asks what stops light, and what closes the sky.
    ///
    /// # Errors
    /// A shader that has no kernel.
    pub fn find(&mut self, frame: &Frame<'_>) -> Result<[bool; 2], Refusal> {
        for (k, source) in frame.scene.sources.iter().enumerate() {
            if source.attributes.visible && !source.attributes.matte && source.len() > 0 {
                let item = Item { source: k as u32, index: 0 };
                self.look(frame, item, &frame.scene.view(item))?;
            }
        }
        let kernels = || self.looks.iter().flat_map(|look| [Some(&look.kernel), look.through.as_ref()]).flatten();
        let asks = |queries: &[Query]| kernels().any(|kernel| queries.iter().any(|query| kernel.asks(*query)));
        Ok([asks(&OF_RAYS), asks(&[Query::Openness])])
    }

    /// Let kernels read the scene.
    ///
    /// # Errors
    /// Those of [`Buffer::of`].
    pub fn set_world(&mut self, rows: &[[u32; 4]]) -> Result<(), GpuError> {
        self.world = Buffer::of(self.device, "scene", rows)?;
        Ok(())
    }

    /// The index of what an item looks by.
    fn look(&mut self, frame: &Frame<'_>, item: Item, view: &ItemView<'_>) -> Result<usize, Refusal> {
        let a = view.attributes;
        if let Some(k) = self.looks.iter().position(|look| look.is_of(a)) {
            return Ok(k);
        }
        let scene = View::new(frame.scene, &frame.rays, item, view, [0.0; 2]);
        let group = GROUP.min(self.device.adapter.max_invocations);
        let host = Host { group, functions: &FUNCTIONS, declarations: DECLARATIONS, scene: &scene };
        let kernel = Kernel::new(&a.surface, &a.light_list, host)?;
        let through = a.atmosphere.as_ref().map(|shader| {
            let scene = View {
                shader_to_world: a.atmosphere_space,
                ..View::new(frame.scene, &frame.rays, item, view, [0.0; 2])
            };
            Kernel::new(shader, &a.light_list, Host { scene: &scene, ..host })
        });
        let through = through.transpose()?;
        for kernel in [Some(&kernel), through.as_ref()].into_iter().flatten() {
            if let Some((shader, map)) = kernel.other_map() {
                return Err(Refusal::of_shader(shader, &format!("looks up the map `{map}`")));
            }
            if let Some(light) = kernel.light_of_primitive() {
                return Err(Refusal::of_shader(
                    light,
                    "is a light's that reads what differs from primitive to primitive",
                ));
            }
        }
        if let (Some(shader), Some(through)) = (&a.atmosphere, &through) {
            if through.asks_by_name(Ask::Surface) {
                return Err(Refusal::of_shader(&shader.program.name, "asks a surface shader what it has left"));
            }
            let changes = |target| !matches!(target, Target::Global(Global::Ci | Global::Oi) | Target::Parameter(_));
            if kernel.outputs().iter().any(|output| changes(output.target)) {
                let name = &a.surface.program.name;
                return Err(Refusal::of_shader(name, "changes more than colours before an atmosphere"));
            }
        }
        let (surface, lights, atmosphere) = (a.surface.clone(), a.light_list.clone(), a.atmosphere.clone());
        self.looks.push(Look { surface, lights, atmosphere, kernel, through });
        Ok(self.looks.len() - 1)
    }

    /// Shade the points of grids that are wanted, a bit each, and put their colours among those of all points.
    ///
    /// # Errors
    /// What has no kernel, and faults of the device.
    pub fn shade(
        &mut self,
        frame: &Frame<'_>,
        grids: &mut [Diced],
        wanted: &[u32],
        colors: &Buffer<[f32; 4]>,
        stats: &mut Stats,
    ) -> Result<(), Refusal> {
        let mut by_look: Vec<Vec<(usize, usize)>> = vec![];
        let mut first = 0;
        for (k, grid) in grids.iter().enumerate() {
            let n = grid.points.n();
            if (first..first + n).any(|point| is_set(wanted, point)) {
                let look = self.look(frame, grid.item, &frame.scene.view(grid.item))?;
                by_look.resize_with(by_look.len().max(look + 1), Vec::new);
                by_look[look].push((k, first));
            }
            first += n;
        }
        for (look, own) in by_look.iter().enumerate() {
            let mut rest = own.as_slice();
            while !rest.is_empty() {
                let taken = self.run(frame, look, grids, (rest, wanted), colors, stats)?;
                rest = &rest[taken..];
            }
        }
        Ok(())
    }

    /// Shade the first of some grids of a look, given by their index and their first point among all; how many of them.
    fn run(
        &self,
        frame: &Frame<'_>,
        look: usize,
        grids: &mut [Diced],
        (own, wanted): (&[(usize, usize)], &[u32]),
        colors: &Buffer<[f32; 4]>,
        stats: &mut Stats,
    ) -> Result<usize, Refusal> {
        let look = &self.looks[look];
        let item = grids[own[0].0].item;
        let view = frame.scene.view(item);
        let scene = View::new(frame.scene, &frame.rays, item, &view, [0.0; 2]);
        let mut batch = Batch::new(&look.kernel, &look.lights, &scene)?;
        let mut later = look.through.as_ref().map(|kernel| Batch::new(kernel, &look.lights, &scene)).transpose()?;
        let mut few = Few::default();
        let mut taken = 0;
        while taken < own.len() && batch.values.len() < MOST_VALUES {
            let (k, first) = own[taken];
            taken += 1;
            few.add(frame, &mut grids[k], (first, wanted), &mut batch, later.as_mut())?;
        }
        stats.shaded_points += few.points.len() as u64;
        let results = self.dispatch(&look.kernel, &batch, None)?;
        match (&look.through, &later) {
            (Some(kernel), Some(later)) => {
                let passed =
                    self.dispatch(kernel, later, Some((&results, &few.relays(&batch, &look.kernel, later))))?;
                // What the atmosphere leaves is as the surface has it.
                self.take(&look.kernel, &batch, &few, &results, colors)?;
                self.take(kernel, later, &few, &passed, colors)?;
            }
            _ => self.take(&look.kernel, &batch, &few, &results, colors)?,
        }
        Ok(taken)
    }

    /// Run a kernel, whose values take some of the results of another's first.
    fn dispatch(
        &self,
        kernel: &Kernel,
        batch: &Batch<'_>,
        before: Option<(&Buffer<f32>, &[[u32; 4]])>,
    ) -> Result<Buffer<f32>, Refusal> {
        let device = self.device;
        let compiled = self.kernels.get(device, "shader", &kernel.text, &[])?;
        let groups_of = Buffer::of(device, "groups", &batch.groups)?;
        let grids = Buffer::of(device, "grids", &batch.grids)?;
        let slots = Buffer::of(device, "slots", &batch.slots)?;
        let lights = Buffer::of(device, "lights", &batch.lights)?;
        let values = Buffer::of(device, "values", &batch.values)?;
        let results = Buffer::<f32>::zeros(device, "results", batch.n_results())?;
        let status = Buffer::<u32>::zeros(device, "status", batch.n_status())?;
        let mut commands = Commands::new();
        if let Some((found, runs)) = before {
            let n = runs.len();
            let runs = Buffer::of(device, "runs", runs)?;
            let bound = [runs.bind(), found.bind(), values.bind()];
            commands.dispatch(device, &self.own.relay, &bound, &[n as u32], Work::Groups(n as u32));
        }
        let inputs = [groups_of.bind(), grids.bind(), slots.bind(), lights.bind(), values.bind()];
        let mut bound: Vec<_> = inputs.into_iter().chain([results.bind(), status.bind()]).collect();
        if FUNCTIONS.iter().any(|(query, _)| kernel.asks(*query)) {
            bound.push(self.world.bind());
        }
        commands.dispatch(device, &compiled, &bound, &[], Work::Groups(batch.groups.len() as u32));
        commands.submit(device)?;
        if let Some(fault) = batch.faults(&status.read(device, batch.n_status())?).first() {
            return Err(Refusal::of_fault(fault));
        }
        Ok(results)
    }

    /// Take the colours that a kernel has found, if it gives any.
    fn take(
        &self,
        kernel: &Kernel,
        batch: &Batch<'_>,
        few: &Few,
        results: &Buffer<f32>,
        colors: &Buffer<[f32; 4]>,
    ) -> Result<(), GpuError> {
        let Some(offset) = offset_of(kernel, Global::Ci) else { return Ok(()) };
        let mut rows = Vec::with_capacity(few.points.len());
        for (k, grid) in few.grids.iter().enumerate() {
            let first = batch.results_of(k) + offset * grid.n;
            let own = few.points[grid.points.clone()].iter();
            rows.extend(own.map(|(point, at)| [*point, first as u32 + at, grid.n as u32, 0]));
        }
        let n = rows.len();
        let rows = Buffer::of(self.device, "shaded points", &rows)?;
        let mut commands = Commands::new();
        let bound = [rows.bind(), results.bind(), colors.bind()];
        commands.dispatch(self.device, &self.own.point_colors, &bound, &[n as u32], groups(n, 256));
        commands.submit(self.device)?;
        Ok(())
    }
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

/// Where the numbers of a global begin among those that a kernel gives of a point.
fn offset_of(kernel: &Kernel, global: Global) -> Option<usize> {
    kernel.outputs().iter().find(|output| output.target == Target::Global(global)).map(|output| output.offset)
}

fn is_set(bits: &[u32], k: usize) -> bool {
    bits[k / 32] >> (k % 32) & 1 == 1
}

/// The points that are shaded together.
#[derive(Default)]
struct Few {
    grids: Vec<FewOfGrid>,
    /// Of each that is wanted, its index among all points, and among those of its grid that are shaded.
    points: Vec<(u32, u32)>,
    gathered: Points,
    wanted: Vec<u32>,
}

/// Those of a grid.
struct FewOfGrid {
    /// Count of its points that are shaded.
    n: usize,
    /// Those that are wanted.
    points: std::ops::Range<usize>,
}

impl Few {
    /// Add the points of a grid that are wanted, or all if its shaders look at neighbours.
    fn add(
        &mut self,
        frame: &Frame<'_>,
        grid: &mut Diced,
        (first, wanted): (usize, &[u32]),
        batch: &mut Batch<'_>,
        later: Option<&mut Batch<'_>>,
    ) -> Result<(), Refusal> {
        let view = frame.scene.view(grid.item);
        self.wanted.clear();
        self.wanted.extend((0..grid.points.n()).filter(|k| is_set(wanted, first + k)).map(|k| k as u32));
        let whole = view.attributes.reads_neighbours();
        if !whole {
            gather(&grid.points, view.attached.n_uniform, &self.wanted, &mut self.gathered);
        }
        let points = if whole { &mut grid.points } else { &mut self.gathered };
        let surface = Surface { item: grid.item, view: &view, reach: grid.reach, z: grid.z, time: 0.0 };
        let scene = prepare(frame, &surface, points);
        let id = frame.scene.id_of(grid.item);
        let [x, y, z] = scene.flat.unwrap_or_default().to_array();
        let own = [(id & 0xffff) as f32, (id >> 16) as f32, scene.bias[0], scene.bias[1], x, y, z];
        add(batch, (&view.attributes.surface, &view.attached.surface), points, &scene, &own)?;
        if let (Some(later), Some(shader)) = (later, &view.attributes.atmosphere) {
            // The surface's results come here.
            let n = points.n();
            [Global::Ci, Global::Oi].into_iter().for_each(|g| points.refill(g).resize(3 * n, 1.0));
            let scene = View { shader_to_world: view.attributes.atmosphere_space, ..scene };
            add(later, (shader, &view.attached.atmosphere), points, &scene, &own)?;
        }
        let (begin, n) = (self.points.len(), points.n());
        let all = self.wanted.iter().enumerate();
        self.points.extend(all.map(|(i, k)| (first as u32 + k, if whole { *k } else { i as u32 })));
        self.grids.push(FewOfGrid { n, points: begin..self.points.len() });
        Ok(())
    }

    /// The runs of a surface's results that its atmosphere is given.
    fn relays(&self, batch: &Batch<'_>, kernel: &Kernel, later: &Batch<'_>) -> Vec<[u32; 4]> {
        let mut runs = vec![];
        for global in [Global::Ci, Global::Oi] {
            let Some(offset) = offset_of(kernel, global) else { continue };
            for (k, grid) in self.grids.iter().enumerate() {
                if let Some(goal) = later.start_of(k, global) {
                    let source = batch.results_of(k) + offset * grid.n;
                    runs.push([source as u32, goal as u32, 3 * grid.n as u32, 0]);
                }
            }
        }
        runs
    }
}

/// Add the points of a grid to those of a kernel, with the host's own numbers.
fn add(
    batch: &mut Batch<'_>,
    (shader, slots): (&BoundShader, &VariableSlots),
    points: &Points,
    scene: &View<'_>,
    own: &[f32],
) -> Result<(), Refusal> {
    let k = batch.add(shader, slots, points, scene)?;
    batch.give(k, own);
    Ok(())
}
