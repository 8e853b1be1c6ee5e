//! `scree bench gpu`: copy bandwidth, primitives, collision stages and solvers of a graphics adapter, held against the copy bandwidth and
//! the processor, and whole steps of spheres, of mixed convex shapes and of the tracked vehicle on a bed.

mod budget;
mod steps;

use crate::job::GpuBench;
use crate::report::{Exit, Failure, Outcome};
use budget::{Budget, Report};
use glam::DVec3;
use gpu::compact::{Compact, compact_cpu};
use gpu::radix_sort::{Key, RadixSort, sort_cpu};
use gpu::reduce::{Combine, Reduce, reduce_cpu};
use gpu::scan::{Scan, exclusive_cpu};
use gpu::segments::{SegmentSum, sums_cpu};
use gpu::{Buffer, Commands, Count, Device, GpuError, Kernels};
use serde_json::{Value, json};
use sim::gpu::collision::{Collision, Fault};
use sim::gpu::contact_solve::ContactSolve;
use sim::workload::{self, Workload};
use sim::{Method, ShapeKind, Simulation, SolverSettings, SplitMix64};
use std::collections::HashMap;
use std::time::Instant;
use steps::Steps;

/// Times that are measured, of which the median counts.
const REPEATS: usize = 5;

/// Iterations of a solve.
const ITERATIONS: u32 = 50;

/// The stage whose time counts.
const STAGE: &str = "measured";

/// A device, its kernels and its copy bandwidth, bytes/s.
struct Bench {
    device: Device,
    kernels: Kernels,
    bandwidth: f64,
}

/// What a primitive does with `n` values.
struct Measured {
    name: &'static str,
    n: usize,
    seconds: f64,
    dispatches: usize,
    /// Bytes that it must move for each value.
    bytes: f64,
    /// Whether the result is that of the CPU twin.
    is_equal: bool,
}

/// Measure an adapter. Returns the result, and whether the benchmark was not interrupted.
pub fn measure(job: &GpuBench) -> Outcome<(Value, bool)> {
    run(job).map_err(|error| {
        let exit = if matches!(error, Fault::Gpu(GpuError::Choice { .. })) { Exit::Usage } else { Exit::Fault };
        Failure::new(exit, error.to_string())
    })
}

fn run(job: &GpuBench) -> Result<(Value, bool), Fault> {
    let time = Budget::new(Instant::now() + job.time);
    let device = Device::open(&job.adapter)?;
    let kernels = Kernels::default();
    let copied = if job.small { 1 << 21 } else { 1 << 26 };
    let bandwidth = gpu::copy_bandwidth(&device, &kernels, copied, REPEATS)?;
    let adapter = &device.adapter;
    let head = json!({
        "adapter": adapter.name, "driver": adapter.driver, "is_software": adapter.software,
        "timer": if adapter.features.contains(&"timestamps") { "timestamps" } else { "wall" },
        "copy_bytes_per_second": bandwidth,
    });
    let most_bytes = adapter.max_buffer.min(adapter.max_binding);
    let bench = Bench { device, kernels, bandwidth };
    let mut result = Report::new(head, job.out.as_deref());
    for n in if job.small { [10_000, 1_000_000] } else { [1_000_000, 16_000_000] } {
        for (name, primitive) in PRIMITIVES {
            let row = match time.left_out(name, n) {
                Some(why) => json!({ "name": name, "n": n, "left_out": why }),
                None => bench.report(&time.measure(name, n, || primitive(&bench, n))?),
            };
            result.add("primitives", row)?;
        }
    }
    for n in if job.small { [1_000, 10_000] } else { [84_000, 1_000_000] } {
        let row = match time.left_out("detection", n) {
            Some(why) => json!({ "workload": "S", "n": n, "left_out": why }),
            None => time.measure("detection", n, || detection(&bench, n))?,
        };
        result.add("collision", row)?;
    }
    let seconds = if job.small { 3.0 } else { 10.0 };
    let measure = Steps { adapter: &job.adapter, most_bytes, bandwidth, time: &time, seconds };
    measure.all(job.small, &mut |row| result.add("steps", row))?;
    Ok((result.value, !time.is_interrupted()))
}

/// The primitives by their names.
type Primitive = fn(&Bench, usize) -> Result<Measured, Fault>;
const PRIMITIVES: [(&str, Primitive); 6] = [
    ("scan", |bench, n| Ok(scan(bench, n)?)),
    ("sort_u32", |bench, n| Ok(sort_u32(bench, n)?)),
    ("sort_u64", |bench, n| Ok(sort_u64(bench, n)?)),
    ("sum", |bench, n| Ok(sum(bench, n)?)),
    ("segment_sum", |bench, n| Ok(segments(bench, n)?)),
    ("compact", |bench, n| Ok(compact(bench, n)?)),
];

impl Bench {
    fn report(&self, m: &Measured) -> Value {
        let rate = m.n as f64 / m.seconds;
        json!({
            "name": m.name, "n": m.n, "seconds": m.seconds, "items_per_second": rate, "bytes_per_item": m.bytes,
            "fraction_of_copy_bandwidth": rate * m.bytes / self.bandwidth, "dispatches": m.dispatches,
            "equal_to_cpu": m.is_equal,
        })
    }

    /// The median time of the stage, s, and its dispatches. `prepare` records what comes before each run.
    fn time(
        &self,
        prepare: impl FnOnce(&mut Commands),
        record: impl FnOnce(&mut Commands),
    ) -> Result<(f64, usize), GpuError> {
        let mut commands = Commands::new();
        commands.stage("preparation");
        prepare(&mut commands);
        commands.stage(STAGE);
        record(&mut commands);
        let mut seconds = vec![];
        for _ in 0..=REPEATS {
            seconds.push(commands.stage_seconds(&self.device, STAGE)?);
        }
        // The first run has the driver's preparations in it.
        seconds.remove(0);
        seconds.sort_by(f64::total_cmp);
        Ok((seconds[REPEATS / 2], commands.n_dispatches()))
    }
}

/// Repeatable numbers of 53 bits.
fn numbers(n: usize) -> Vec<u64> {
    let mut random = SplitMix64(12345);
    (0..n).map(|_| (random.uniform() * 2f64.powi(53)) as u64).collect()
}

fn scan(bench: &Bench, n: usize) -> Result<Measured, GpuError> {
    let Bench { device, kernels, .. } = bench;
    let mut expected: Vec<u32> = numbers(n).iter().map(|x| (x % 8) as u32).collect();
    let (given, values) = (Buffer::of(device, "given", &expected)?, Buffer::zeros(device, "values", n)?);
    let (scan, count) = (Scan::new(device, kernels, n)?, Count::of(device, n)?);
    let (seconds, dispatches) =
        bench.time(|c| c.copy(&given, &values, n), |c| scan.record(device, c, &values, &count))?;
    exclusive_cpu(&mut expected);
    let is_equal = values.read(device, n)? == expected;
    Ok(Measured { name: "scan", n, seconds, dispatches, bytes: 16.0, is_equal })
}

fn sort<K: Key>(
    bench: &Bench,
    n: usize,
    (name, max_key): (&'static str, K),
    keys: Vec<K>,
) -> Result<Measured, GpuError> {
    let Bench { device, kernels, .. } = bench;
    let (mut keys, mut values): (Vec<K>, Vec<u32>) = (keys, (0..n as u32).collect());
    let given = (Buffer::of(device, "given keys", &keys)?, Buffer::of(device, "given values", &values)?);
    let sorted = (Buffer::zeros(device, "keys", n)?, Buffer::zeros(device, "values", n)?);
    let (sort, count) = (RadixSort::new(device, kernels, n)?, Count::of(device, n)?);
    let (seconds, dispatches) = bench.time(
        |c| {
            c.copy(&given.0, &sorted.0, n);
            c.copy(&given.1, &sorted.1, n);
        },
        |c| sort.record(device, c, (&sorted.0, &sorted.1), &count, max_key),
    )?;
    sort_cpu(&mut keys, &mut values, max_key);
    let same_keys = gpu::layout::bytemuck::cast_slice::<K, u8>(&sorted.0.read(device, n)?)
        == gpu::layout::bytemuck::cast_slice::<K, u8>(&keys);
    let is_equal = same_keys && sorted.1.read(device, n)? == values;
    // A pass of 8 bits counts the keys, then reads and writes the pairs.
    let (key, passes) = (size_of::<K>() as f64, max_key.bits().div_ceil(8) as f64);
    Ok(Measured { name, n, seconds, dispatches, bytes: passes * (key + 2.0 * (key + 4.0)), is_equal })
}

fn sort_u32(bench: &Bench, n: usize) -> Result<Measured, GpuError> {
    sort(bench, n, ("sort_u32", u32::MAX), numbers(n).iter().map(|x| *x as u32).collect())
}

fn sort_u64(bench: &Bench, n: usize) -> Result<Measured, GpuError> {
    const MAX_KEY: u64 = (1 << 48) - 1;
    sort(bench, n, ("sort_u64", MAX_KEY), numbers(n).iter().map(|x| x & MAX_KEY).collect())
}

/// Numbers in single precision, of both signs.
fn reals(n: usize) -> Vec<f32> {
    numbers(n).iter().map(|x| (*x % 2_000_001) as f32 * 1e-3 - 1e3).collect()
}

fn sum(bench: &Bench, n: usize) -> Result<Measured, GpuError> {
    let Bench { device, kernels, .. } = bench;
    let values = reals(n);
    let (column, result) = (Buffer::of(device, "values", &values)?, Buffer::zeros(device, "result", 1)?);
    let (reduce, count) = (Reduce::new(device, kernels, Combine::Sum, n)?, Count::of(device, n)?);
    let (seconds, dispatches) = bench.time(|_| {}, |c| reduce.record(device, c, &column, &count, &result))?;
    let is_equal = result.read(device, 1)?[0].to_bits() == reduce_cpu(Combine::Sum, &values).to_bits();
    Ok(Measured { name: "sum", n, seconds, dispatches, bytes: 4.0, is_equal })
}

fn segments(bench: &Bench, n: usize) -> Result<Measured, GpuError> {
    let Bench { device, kernels, .. } = bench;
    // About a dozen values a segment, as contacts of a body.
    let n_segments = n / 12;
    let mut start: Vec<u32> = numbers(n_segments).iter().map(|x| (x % 25) as u32).chain([0]).collect();
    let n_values = exclusive_cpu(&mut start) as usize;
    let values = reals(n_values);
    let (column, starts) = (Buffer::of(device, "values", &values)?, Buffer::of(device, "starts", &start)?);
    let sums = Buffer::zeros(device, "sums", n_segments)?;
    let (segments, count) = (SegmentSum::new(device, kernels, n_segments)?, Count::of(device, n_segments)?);
    let (seconds, dispatches) =
        bench.time(|_| {}, |c| segments.record(device, c, [&column, &sums], &starts, &count))?;
    let bits = |sums: &[f32]| sums.iter().map(|x| x.to_bits()).collect::<Vec<u32>>();
    let is_equal = bits(&sums.read(device, n_segments)?) == bits(&sums_cpu(&values, &start));
    let bytes = 4.0 + 8.0 * n_segments as f64 / n_values as f64;
    Ok(Measured { name: "segment_sum", n: n_values, seconds, dispatches, bytes, is_equal })
}

fn compact(bench: &Bench, n: usize) -> Result<Measured, GpuError> {
    let Bench { device, kernels, .. } = bench;
    let flags: Vec<u32> = numbers(n).iter().map(|x| (x % 2) as u32).collect();
    let expected = compact_cpu(&flags);
    let (column, ids) = (Buffer::of(device, "flags", &flags)?, Buffer::zeros(device, "ids", n)?);
    let (count, n_kept) = (Count::of(device, n)?, Count::found(device, n)?);
    let compact = Compact::new(device, kernels, n)?;
    let (seconds, dispatches) = bench.time(|_| {}, |c| compact.record(device, c, &column, &count, &ids, &n_kept))?;
    let is_equal = n_kept.read(device)? == expected.len() && ids.read(device, expected.len())? == expected;
    // Flags to places, their scan, and places to ids.
    let bytes = 8.0 + 16.0 + 4.0 + 4.0 * expected.len() as f64 / n as f64;
    Ok(Measured { name: "compact", n, seconds, dispatches, bytes, is_equal })
}

/// The collision stages and Jacobi on workload S, its lattice drawn together so that neighbours touch, its walls taken away.
fn detection(bench: &Bench, n: usize) -> Result<Value, Fault> {
    /// Factor of the lattice's spacing of 2.1 radii.
    const CLOSER: f64 = 0.94;
    /// Distance by which the walls are moved, m.
    const AWAY: f64 = 10.0;
    /// Greatest velocity along an axis, m/s.
    const SPEED: f64 = 1.0;
    let mut random = SplitMix64(17);
    let Bench { device, kernels, .. } = bench;
    let solver = SolverSettings { omega: Some(0.2), ..workload::solver(Method::Jacobi, ITERATIONS) };
    let (model, mut state) = workload::build(Workload::S, n, solver, 1.5e-3);
    for (shape, body) in model.shape_body.iter().map(|b| *b as usize).enumerate() {
        let is_wall = model.shape_kind[shape] == ShapeKind::Plane;
        let wall = state.orientation[body] * DVec3::Z * -AWAY;
        state.position[body] = state.position[body] * CLOSER + if is_wall { wall } else { DVec3::ZERO };
        if !is_wall {
            // Without relative velocities there would be nothing to solve.
            state.velocity[body] = DVec3::from_array(std::array::from_fn(|_| random.between(-SPEED, SPEED)));
        }
    }
    let mut simulation = Simulation::new(model, state);
    let mut collision = Collision::new(device, kernels, &simulation.model, &simulation.state)?;
    let found = collision.run(device, kernels, &simulation.model)?;
    let contacts = collision.contacts(device)?;
    let times = |is_new: bool| -> Result<(f64, Value), Fault> {
        let mut runs = vec![];
        for _ in 0..REPEATS {
            if is_new {
                collision.find_all(device);
            }
            let started = Instant::now();
            let stages = collision.stage_seconds(device, &simulation.model)?.unwrap_or_default();
            let timed: f64 = stages.iter().map(|(_, seconds)| seconds).sum();
            let wall = started.elapsed().as_secs_f64();
            runs.push((if stages.is_empty() { wall } else { timed }, stages));
        }
        runs.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (seconds, stages) = runs.swap_remove(REPEATS / 2);
        let stages: serde_json::Map<String, Value> =
            stages.into_iter().map(|(name, seconds)| (name.to_string(), json!(1e3 * seconds))).collect();
        Ok((seconds, stages.into()))
    };
    let (with_pairs, pair_stages) = times(true)?;
    let (seconds, stages) = times(false)?;
    let dispatches = collision.n_dispatches(device, &simulation.model);
    let (jacobi, impulses) = solve(bench, &simulation, &collision, Method::Jacobi)?;
    let (apgd, _) = solve(bench, &simulation, &collision, Method::Apgd)?;
    collision.make_tiles(device, kernels)?;
    collision.run(device, kernels, &simulation.model)?;
    let (gauss_seidel, _) = solve(bench, &simulation, &collision, Method::GaussSeidel)?;
    simulation.step();
    Ok(json!({
        "workload": "S", "n": n, "pairs": found.pairs, "contacts": found.contacts, "dispatches": dispatches,
        "seconds": seconds, "stage_ms": stages, "seconds_with_new_pairs": with_pairs, "stage_ms_with_new_pairs": pair_stages,
        "contacts_per_second": found.contacts as f64 / seconds,
        "contacts_per_second_with_new_pairs": found.contacts as f64 / with_pairs,
        "equal_to_cpu": is_like(&simulation, &contacts),
        "jacobi": jacobi, "apgd": apgd, "gauss_seidel": gauss_seidel,
        "jacobi_impulses_equal_to_cpu": has_impulses(&simulation, &contacts, &impulses),
    }))
}

/// The speed of a method on the contacts of a collision, and its impulses.
fn solve(
    bench: &Bench,
    simulation: &Simulation,
    collision: &Collision,
    method: Method,
) -> Result<(Value, Vec<[f32; 4]>), Fault> {
    let Bench { device, kernels, .. } = bench;
    let model = &simulation.model;
    let solver = ContactSolve::new(device, kernels, (model, method), collision)?;
    let n = collision.found().contacts;
    let (mut seconds, mut dispatches, mut sweeps) = (vec![], 0, 0);
    for _ in 0..=REPEATS {
        let time;
        (time, dispatches, sweeps) = solver.run(device, kernels, (model, collision))?;
        seconds.push(time);
    }
    // The first one warms up.
    seconds.remove(0);
    let impulses = solver.impulses(device, n)?;
    seconds.sort_by(f64::total_cmp);
    let rate = n as f64 * f64::from(sweeps) / seconds[REPEATS / 2];
    let report = json!({
        "iterations": ITERATIONS, "sweeps_per_iteration": f64::from(sweeps) / f64::from(ITERATIONS), "dispatches": dispatches, "contact_iterations_per_second": rate,
        "bytes_per_contact_iteration": solver.bytes, "fraction_of_copy_bandwidth": rate * solver.bytes / bench.bandwidth,
    });
    Ok((report, impulses))
}

/// Whether contacts between spheres are those of the CPU back end's last step: the same pairs, gaps to 1e-6 of the radius.
fn is_like(simulation: &Simulation, found: &[sim::gpu::rows::Contact]) -> bool {
    let (model, contacts) = (&simulation.model, &simulation.state.contacts);
    let is_sphere = |s: u32| model.shape_kind[s as usize] == ShapeKind::Sphere;
    let own = (0..contacts.len()).map(|i| ([contacts.key[i][0], contacts.key[i][1]], contacts.gap[i]));
    let mut expected: Vec<([u32; 2], f64)> = own.filter(|(shapes, _)| shapes.iter().all(|s| is_sphere(*s))).collect();
    let mut found: Vec<([u32; 2], f64)> = found.iter().map(|c| (c.shapes, c.gap as f64)).collect();
    expected.sort_by_key(|(shapes, _)| *shapes);
    found.sort_by_key(|(shapes, _)| *shapes);
    let radius = |s: u32| model.shape_size[s as usize].x;
    let is_near =
        |(a, b): (&([u32; 2], f64), &([u32; 2], f64))| a.0 == b.0 && (a.1 - b.1).abs() < 1e-6 * radius(a.0[0]);
    expected.len() == found.len() && expected.iter().zip(&found).all(is_near)
}

/// Whether impulses are those of the CPU back end's last step, to 1e-4 of the largest.
fn has_impulses(simulation: &Simulation, found: &[sim::gpu::rows::Contact], impulses: &[[f32; 4]]) -> bool {
    let contacts = &simulation.state.contacts;
    let key = |i: usize| [contacts.key[i][0], contacts.key[i][1]];
    let expected: HashMap<[u32; 2], DVec3> = (0..contacts.len()).map(|i| (key(i), contacts.impulse[i])).collect();
    let largest = expected.values().map(|z| z.length()).fold(0.0, f64::max);
    let is_near = |(c, z): (&sim::gpu::rows::Contact, &[f32; 4])| {
        let z = DVec3::new(z[0] as f64, z[1] as f64, z[2] as f64);
        expected.get(&c.shapes).is_some_and(|known| (*known - z).length() <= 1e-4 * largest)
    };
    expected.len() == found.len() && found.iter().zip(impulses).all(is_near)
}
