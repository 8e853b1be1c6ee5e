//! `scree bench sim`: spheres that settle in a box.

use crate::job::SimBench;
use crate::machine::{cpu_seconds, peak_bytes};
use serde_json::json;
use sim::stages::Stage;
use sim::{Simulation, workload};
use std::time::Instant;

/// Simulate the workload and measure it.
pub fn measure(job: &SimBench) -> serde_json::Value {
    let SimBench { workload, n, steps, step, solver } = job;
    let (workload, n, steps, step) = (*workload, *n, *steps, *step);
    let (cpu, wall) = (cpu_seconds(), Instant::now());
    let (model, state) = workload::build(workload, n, solver.clone(), step);
    let mut sim = Simulation::new(model, state);
    let (mut contact_iterations, mut contacts) = (0.0, 0);
    let mut stage_ms = [0.0; Stage::ALL.len()];
    for _ in 0..steps {
        let r = sim.step();
        contact_iterations += r.contacts as f64 * r.iterations as f64;
        stage_ms.iter_mut().zip(r.stage_ms).for_each(|(sum, ms)| *sum += ms);
        contacts = r.contacts;
    }
    let ms_of = |stages: &[Stage]| {
        let counted = Stage::ALL.into_iter().zip(stage_ms).filter(|(stage, _)| stages.contains(stage));
        counted.map(|(_, ms)| ms).sum::<f64>()
    };
    let all_ms: f64 = stage_ms.iter().sum();
    let solver_ms = ms_of(&[Stage::ContactSolve]);
    let detection_ms =
        ms_of(&[Stage::Bounds, Stage::BinEmit, Stage::BinSort, Stage::BinStart, Stage::PairWrite, Stage::ContactWrite]);
    let cores = rayon::current_num_threads() as f64;
    let stages: serde_json::Map<String, serde_json::Value> =
        Stage::ALL.iter().zip(stage_ms).map(|(s, ms)| (s.name().to_string(), json!(ms / steps as f64))).collect();
    let radius = sim.model.shape_size.iter().map(|s| s.x).fold(0.0, f64::max);
    json!({
        "workload": format!("{workload:?}"), "n": n, "backend": sim.backend(), "threads": rayon::current_num_threads(),
        "step": step, "steps": steps, "iterations": solver.iterations, "method": solver.method, "friction": solver.friction,
        "recovery_speed": solver.recovery_speed,
        "cpu_seconds_per_simulated_second": (cpu_seconds() - cpu) / (steps as f64 * step),
        "wall_seconds": wall.elapsed().as_secs_f64(),
        "worst_penetration_over_r": sim.state.contacts.worst_penetration() / radius,
        "kinetic_energy_j": sim.state.kinetic_energy(&sim.model),
        "contacts": contacts,
        "contact_iterations_per_second_per_core": contact_iterations / (solver_ms * 1e-3 * cores),
        "shapes_per_second_per_core": (n as u64 * steps) as f64 / (detection_ms * 1e-3 * cores),
        "other_share_of_step": 1.0 - (solver_ms + detection_ms) / all_ms,
        "stage_ms": stages,
        "solver_share_of_step": solver_ms / all_ms,
        "peak_bytes": peak_bytes(),
        "max_position_difference_m": serde_json::Value::Null,
    })
}
