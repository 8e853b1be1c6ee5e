//! Whole steps of workload S and of mixed convex shapes on a graphics adapter.

use ::gpu::{Choice, Device};
use serde_json::{Map, Value, json};
use sim::gpu::Fault;
use sim::stages::Stage;
use sim::workload::{self, Workload};
use sim::{Method, Model, Simulation, State};
use std::time::Instant;

/// Steps before those that are timed, and the number of these.
const BEFORE: usize = 2;
const STEPS: usize = 5;

/// Size of a bed up to which the same steps are taken by the processor, too.
const COMPARED: usize = 10_000;

/// Methods with their iterations: those of Gauss–Seidel have two sweeps.
const METHODS: [(Method, u32); 3] = [(Method::Jacobi, 50), (Method::Apgd, 50), (Method::GaussSeidel, 12)];

/// Measure all methods on a bed of `n` spheres.
pub fn measure(adapter: &Choice, n: usize) -> Result<Vec<Value>, Fault> {
    let of = |(method, iterations)| of_method(adapter, ("S", n), bed(n, method, iterations), method);
    METHODS.into_iter().map(of).collect()
}

/// Measure the methods on a bed of `n` mixed convex shapes.
pub fn measure_mixed(adapter: &Choice, n: usize) -> Result<Vec<Value>, Fault> {
    let bed = workload::mixed(n).simulation().map_err(|fault| Fault::Unsupported(fault.to_string()))?;
    let of = |(method, iterations)| {
        let mut model = bed.model.clone();
        (model.step, model.solver) = (1.5e-3, workload::solver(method, iterations));
        of_method(adapter, ("mixed", n), (model, bed.state.clone()), method)
    };
    METHODS.into_iter().map(of).collect()
}

fn of_method(
    adapter: &Choice,
    (workload, n): (&str, usize),
    (model, state): (Model, State),
    method: Method,
) -> Result<Value, Fault> {
    let radius = model.shape_size.last().map_or(1.0, |size| size.x);
    let mut cpu = (n <= COMPARED).then(|| Simulation::new(model.clone(), state.clone()));
    let mut own = Simulation::on_device(model, state, Device::open(adapter)?)?;
    let step = |own: &mut Simulation| {
        own.try_step().map_err(|fault| match fault {
            sim::StepFault::Device(fault) => fault,
            sim::StepFault::Columns(why) => panic!("{why}"),
        })
    };
    let mut last = step(&mut own)?;
    for _ in 1..BEFORE {
        last = step(&mut own)?;
    }
    let mut stage_ms = [0.0; Stage::ALL.len()];
    let started = Instant::now();
    for _ in 0..STEPS {
        last = step(&mut own)?;
        stage_ms.iter_mut().zip(last.stage_ms).for_each(|(sum, ms)| *sum += ms / STEPS as f64);
    }
    let seconds = started.elapsed().as_secs_f64() / STEPS as f64;
    own.fetch()?;
    let stages: Map<String, Value> =
        Stage::ALL.iter().zip(stage_ms).map(|(stage, ms)| (stage.name().to_string(), json!(ms))).collect();
    let off = cpu.as_mut().map(|cpu| {
        (0..BEFORE + STEPS).for_each(|_| drop(cpu.step()));
        let pairs = own.state.position.iter().zip(&cpu.state.position);
        pairs.map(|(a, b)| (*a - *b).length()).fold(0.0, f64::max)
    });
    Ok(json!({
        "workload": workload, "n": n, "method": method.name(), "iterations": last.iterations, "contacts": last.contacts,
        "seconds_per_step": seconds, "stage_ms": stages, "worst_penetration_over_r": last.worst_penetration / radius,
        "max_position_difference_m": off, "longest_submission_seconds": own.device_usage().map(|usage| usage.longest_submission),
    }))
}

/// A bed whose lattice is drawn together so that neighbours touch, and falls.
fn bed(n: usize, method: Method, iterations: u32) -> (Model, State) {
    /// Factor of the lattice's spacing of 2.1 radii.
    const CLOSER: f64 = 0.955;
    let (model, mut state) = workload::build(Workload::S, n, workload::solver(method, iterations), 1.5e-3);
    for body in (0..model.n_bodies()).filter(|b| model.inv_mass[*b] > 0.0) {
        state.position[body] *= CLOSER;
    }
    (model, state)
}
