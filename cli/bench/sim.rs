//! `scree bench sim`: spheres that settle in a box, convex bodies, or joints.

use crate::job::SimBench;
use crate::machine::{cpu_seconds, peak_bytes};
use serde_json::json;
use sim::Simulation;
use sim::joint::JointKind;
use sim::stages::Stage;
use sim::workload::Measure;
use std::time::Instant;

/// Simulate the workload and measure it.
pub fn measure(job: SimBench) -> serde_json::Value {
    let SimBench { workload, n, steps, quality, simulation: mut sim, cpu_before } = job;
    let (step, solver) = (sim.model.step, sim.model.solver.clone());
    let mut measure = Measure::new(&sim);
    let wall = Instant::now();
    let (mut contact_iterations, mut contacts) = (0.0, 0);
    let mut stage_ms = [0.0; Stage::ALL.len()];
    let (mut startup, mut cpu) = (0.0, cpu_seconds());
    for k in 0..steps {
        let r = sim.step();
        measure.note(&sim.state, &r);
        if k == 0 {
            // The first step has what is done once, as the solve of bodies that stand on each other.
            startup = cpu_seconds() - cpu_before;
            cpu = cpu_seconds();
            continue;
        }
        contact_iterations += r.contacts as f64 * r.iterations as f64;
        stage_ms.iter_mut().zip(r.stage_ms).for_each(|(sum, ms)| *sum += ms);
        contacts = r.contacts;
    }
    let timed = steps.saturating_sub(1).max(1) as f64;
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
        Stage::ALL.iter().zip(stage_ms).map(|(s, ms)| (s.name().to_string(), json!(ms / timed))).collect();
    let radius = sim.model.shape_size.iter().map(|s| s.x).fold(0.0, f64::max);
    let [drift, drop] = measure.drift_and_drop(&sim);
    json!({
        "workload": workload, "n": n, "backend": sim.backend(), "threads": rayon::current_num_threads(),
        "quality": quality, "step": step, "steps": steps, "iterations": solver.iterations, "method": solver.method,
        "friction": solver.friction, "recovery_speed": solver.recovery_speed,
        "startup_cpu_seconds": startup,
        "cpu_seconds_per_simulated_second": (cpu_seconds() - cpu) / (timed * step),
        "wall_seconds": wall.elapsed().as_secs_f64(),
        "worst_penetration_over_r": sim.state.contacts.worst_penetration() / radius,
        "worst_penetration_over_inradius": measure.penetration(&sim.state),
        "worst_penetration_over_inradius_run": measure.worst,
        "drift_max_m": drift, "drop_max_m": drop, "joint_gap_max_m": joint_gap(&sim),
        "kinetic_energy_j": sim.state.kinetic_energy(&sim.model),
        "contacts": contacts,
        "contact_iterations_per_second_per_core": contact_iterations / (solver_ms * 1e-3 * cores),
        "shapes_per_second_per_core": sim.model.n_shapes() as f64 * timed / (detection_ms * 1e-3 * cores),
        "other_share_of_step": 1.0 - (solver_ms + detection_ms) / all_ms,
        "stage_ms": stages,
        "solver_share_of_step": solver_ms / all_ms,
        "peak_bytes": peak_bytes(),
        "max_position_difference_m": serde_json::Value::Null,
    })
}

/// Greatest distance of the two origins of a joint that holds them together, m; none without such joints.
fn joint_gap(sim: &Simulation) -> Option<f64> {
    let gap = |joint| {
        let frames = sim.state.joint_frames(joint);
        frames.a.position.distance(frames.b.position)
    };
    use JointKind::{Fixed, Revolute, Spherical, Universal};
    let joined = sim.model.joints.iter().filter(|joint| matches!(joint.kind, Spherical | Revolute | Universal | Fixed));
    joined.map(gap).reduce(f64::max)
}
