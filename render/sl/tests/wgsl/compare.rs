//! A shader run by the grid machine and by its kernel over the same grid, and how far they differ.

use crate::world::{FUNCTIONS, World};
use gpu::{Buffer, Choice, Commands, Device, Kernels, Work};
use sl::Global;
use sl::machine::{BoundShader, Machine, Points, VariableSlots};
use sl::wgsl::{Batch, Extent, Fault, Host, Kernel, Refused};
use std::sync::{Arc, OnceLock};

/// A device and its kernels.
pub struct Bench {
    device: Device,
    kernels: Kernels,
}

/// The device; none without an adapter.
pub fn bench() -> Option<&'static Bench> {
    static BENCH: OnceLock<Option<Bench>> = OnceLock::new();
    let open = || match Device::open(&Choice::Any) {
        Ok(device) => Some(Bench { device, kernels: Kernels::default() }),
        Err(error) if std::env::var_os("REQUIRE_GPU").is_some() => panic!("REQUIRE_GPU is set, but {error}"),
        Err(error) => {
            eprintln!("skipped: {error}");
            None
        }
    };
    BENCH.get_or_init(open).as_ref()
}

/// Points of a row, and rows.
pub const SIZE: [usize; 2] = [17, 13];

/// A curved grid, whose places and directions are no round numbers.
pub fn points() -> Points {
    let [nu, nv] = SIZE;
    let n = nu * nv;
    let mut points = Points::new(nu, nv, -1.0);
    let u = |k: usize| (k % nu) as f32 / (nu - 1) as f32;
    let v = |k: usize| (k / nu) as f32 / (nv - 1) as f32;
    let triples =
        |f: &dyn Fn(f32, f32) -> [f32; 3]| -> Vec<f32> { (0..3 * n).map(|i| f(u(i % n), v(i % n))[i / n]).collect() };
    let place = |u: f32, v: f32| [2.3 * u - 1.07, 1.7 * v - 0.83, 0.6 * (2.0 * u).sin() * (1.5 * v + 0.3).cos() + 0.21];
    let normal = |u: f32, v: f32| {
        let n = glam::Vec3::new(0.4 * (3.0 * u).cos(), 0.5 * v - 0.2, -1.0 + 0.1 * u).normalize();
        (n * (1.0 + 0.2 * u)).to_array()
    };
    points.set(Global::P, triples(&place));
    points.set(Global::N, triples(&normal));
    points.set(Global::Ng, triples(&normal));
    points.set(
        Global::I,
        triples(&|u, v| {
            let [x, y, z] = place(u, v);
            [x - 0.1, y - 0.3, z + 4.0]
        }),
    );
    points.set(Global::E, vec![0.1, 0.3, -4.0]);
    points.set(Global::Cs, triples(&|u, v| [0.2 + 0.6 * u, 0.7 - 0.3 * v, 0.4]));
    points.set(Global::Os, vec![1.0, 0.8, 0.9]);
    points.set(Global::Ci, vec![0.0; 3]);
    points.set(Global::Oi, vec![1.0; 3]);
    points.set(Global::S, (0..n).map(|k| 1.37 * u(k) + 0.113).collect());
    points.set(Global::T, (0..n).map(|k| 0.91 * v(k) - 0.271).collect());
    points.set(Global::U, (0..n).map(u).collect());
    points.set(Global::V, (0..n).map(v).collect());
    points.set(Global::Alpha, vec![0.75]);
    points
}

/// What both have found: by the name of a value, the largest difference and where it is.
pub struct Found {
    /// The largest difference of any number, by the size of numbers above 1.
    pub difference: f32,
    /// Where.
    pub place: String,
    /// Numbers that were compared, and how many of them are the same to the bit.
    pub numbers: [usize; 2],
    pub faults: Vec<Fault>,
}

/// A device that answers all queries.
pub fn host(world: &World) -> Host<'_> {
    Host { group: 256, functions: &FUNCTIONS, declarations: "", scene: world }
}

/// Run a shader's kernel on a device over the grids of batches that stand one behind the other.
pub fn run(bench: &Bench, kernel: &Kernel, batches: &[Batch<'_>]) -> (Vec<f32>, Vec<u32>) {
    let Bench { device, kernels } = bench;
    let compiled = kernels.get(device, "shader", &kernel.text, &[]).unwrap_or_else(|e| panic!("{e}\n{}", kernel.text));
    let mut all = Extent::default();
    for batch in batches {
        assert_eq!(batch.before(), all, "a batch stands behind those before it");
        all += batch.extent();
    }
    fn rows<'b, T: gpu::Pod>(
        device: &gpu::Device,
        batches: &'b [Batch<'b>],
        of: impl Fn(&'b Batch<'b>) -> &'b Vec<T>,
    ) -> Buffer<T> {
        let rows: Vec<T> = batches.iter().flat_map(of).copied().collect();
        Buffer::of(device, "rows of batches", &rows).unwrap()
    }
    let groups = rows(device, batches, |batch| &batch.groups);
    let grids = rows(device, batches, |batch| &batch.grids);
    let slots = rows(device, batches, |batch| &batch.slots);
    let lights = rows(device, batches, |batch| &batch.lights);
    let values = rows(device, batches, |batch| &batch.values);
    let results = Buffer::<f32>::zeros(device, "results", all.results).unwrap();
    let status = Buffer::<u32>::zeros(device, "status", kernel.n_status()).unwrap();
    let mut commands = Commands::new();
    let inputs = [groups.bind(), grids.bind(), slots.bind(), lights.bind(), values.bind()];
    let buffers: Vec<_> = inputs.into_iter().chain([results.bind(), status.bind()]).collect();
    commands.dispatch(device, &compiled, &buffers, &[], Work::Groups(all.groups as u32));
    commands.submit(device).unwrap();
    (results.read(device, all.results).unwrap(), status.read(device, kernel.n_status()).unwrap())
}

/// Compare a shader's kernel with the grid machine; an error if it has none, none without an adapter.
pub fn compare(shader: &Arc<BoundShader>, world: &World) -> Result<Option<Found>, Refused> {
    // Two grids, the second without some of its globals.
    let mut all = points();
    // Slivers in one of them stand for more than themselves.
    all.footprints = (0..all.n()).map(|k| [1.0 + 0.01 * k as f32, 0.2, 1.3]).collect();
    let mut few = Points::new(5, 3, 1.0);
    for (global, width) in [(Global::P, 3), (Global::N, 3), (Global::I, 3), (Global::U, 1), (Global::V, 1)] {
        let from = all.get(global).unwrap();
        let n = all.n();
        few.set(global, (0..15 * width).map(|i| from[i / 15 * n + 3 * (i % 15)]).collect());
    }
    few.set(Global::Ci, vec![0.25; 3]);
    few.set(Global::Oi, vec![0.5; 3]);
    compare_grids(shader, &VariableSlots::default(), vec![all, few], world)
}

/// Compare over grids whose primitive variables go before parameters.
pub fn compare_grids(
    shader: &Arc<BoundShader>,
    slots: &VariableSlots,
    grids: Vec<Points>,
    world: &World,
) -> Result<Option<Found>, Refused> {
    let kernel = Kernel::new(shader, &world.lights, host(world))?;
    // Each in a batch of its own: several batches are shaded in one dispatch.
    let (mut batches, mut before) = (vec![], Extent::default());
    for grid in &grids {
        let mut batch = Batch::new(&kernel, &world.lights, world)?;
        batch.add(shader, slots, grid, world)?;
        batch.stand_behind(before);
        before += batch.extent();
        batches.push(batch);
    }
    let Some(bench) = bench() else { return Ok(None) };
    let (results, status) = run(bench, &kernel, &batches);
    let mut found = Found { difference: 0.0, place: String::new(), numbers: [0; 2], faults: kernel.faults(&status) };
    for (k, grid) in grids.into_iter().enumerate() {
        let (mut cpu, mut device) = (grid.clone(), grid);
        let mut machine = Machine::new();
        machine.run_with(shader, slots, &mut cpu, world);
        let batch = &batches[k];
        batch.take(0, &results, &mut device);
        let n = cpu.n();
        for global in Global::all() {
            // L and Cl are left as the last light sets them.
            if let (Some(a), Some(b)) = (cpu.get(global), device.get(global))
                && ![Global::L, Global::Cl].contains(&global)
            {
                found.differ(&format!("grid {k}, {}", global.name()), a, b, n);
            }
        }
        for param in shader.program.params.iter().filter(|p| p.output && p.array.is_none()) {
            if let (Some(a), Some(b)) = (machine.output(shader, &param.name), batch.output(0, &param.name, &results)) {
                found.differ(&format!("grid {k}, {}", param.name), a, b, n);
            }
        }
    }
    Ok(Some(found))
}

impl Found {
    /// Compare values, one or one a point.
    fn differ(&mut self, name: &str, a: &[f32], b: &[f32], n: usize) {
        let width = if a.len().max(b.len()).is_multiple_of(3) && a.len() != n { 3 } else { 1 };
        let at = |v: &[f32], c: usize, k: usize| {
            if v.len() <= 3 && v.len() != n { v[c.min(v.len() - 1)] } else { v[c * n + k] }
        };
        for c in 0..width {
            for k in 0..n {
                let (a, b) = (at(a, c, k), at(b, c, k));
                let difference = if a.to_bits() == b.to_bits() { 0.0 } else { (a - b).abs() / a.abs().max(1.0) };
                self.numbers[0] += 1;
                self.numbers[1] += (a == b) as usize;
                if difference > self.difference || difference.is_nan() {
                    self.difference = if difference.is_nan() { f32::INFINITY } else { difference };
                    self.place = format!("{name}[{c}] at {k}: {a} on the CPU, {b} on the device");
                }
            }
        }
    }
}
