//! Warm start: a step starts from the impulses of the last, contact by contact, and needs fewer iterations.

use crate::analytic::simulation;
use glam::DVec3;
use sim::workload::{self, Workload};
use sim::{Method, Model, Simulation, SolverSettings, State};
use std::collections::BTreeMap;
use std::sync::LazyLock;

/// Impulses by the identity of their contacts.
fn impulses(sim: &Simulation) -> BTreeMap<[u32; 3], DVec3> {
    sim.state.contacts.key.iter().copied().zip(sim.state.contacts.impulse.iter().copied()).collect()
}

/// Piles at rest: a bed of spheres, and boxes and cylinders on the ground.
fn piles() -> [(&'static str, Simulation); 2] {
    static PILES: LazyLock<[(Model, State); 2]> = LazyLock::new(|| {
        let settings = SolverSettings { tolerance: 1e-6, ..workload::solver(Method::Apgd, 5000) };
        let (model, state) = workload::build(Workload::S, 300, settings, 2e-3);
        let mut yaml = String::from(
            "step: 2e-3
solver: {method: apgd, iterations: 5000, tolerance: 1e-6}
materials: {m: {density: 2000, friction: 0.6}}
bodies:
  - {name: ground, material: m, plane: {normal: [0, 0, 1]}}
",
        );
        let shapes =
            ["box: {size: [0.3, 0.2, 0.1]}", "cylinder: {radius: 0.1, length: 0.1}", "box: {size: [0.2, 0.2, 0.1]}"];
        for i in 0..30 {
            let (x, z) = ((i % 6) as f64 * 0.35, 0.051 + (i / 6) as f64 * 0.102);
            yaml += &format!("  - {{name: b{i}, material: m, {}, position: [{x}, 0, {z}]}}\n", shapes[i / 6 % 3]);
        }
        [Simulation::new(model, state), simulation(&yaml)].map(|mut sim| {
            (0..1_500).for_each(|_| _ = sim.step());
            assert!(sim.state.contacts.len() > 60, "{} contacts", sim.state.contacts.len());
            (sim.model, sim.state)
        })
    });
    let [spheres, blocks] = PILES.clone().map(|(model, state)| Simulation::new(model, state));
    [("spheres", spheres), ("blocks", blocks)]
}

/// Take one more step, after which the candidate pairs hold or the broad phase runs again: contacts are matched along the pairs, or by
/// their keys.
fn make_ready(sim: &mut Simulation, again: bool) {
    sim.step();
    if again {
        sim.state.fat_aabb = None;
    }
}

#[test]
fn a_pile_at_rest_needs_fewer_iterations_from_the_last_impulses() {
    for (name, sim) in piles() {
        // Over some steps: a single one of a pile at rest takes few or many as its residual happens to stand.
        let next = |warm: bool| {
            let mut sim = Simulation::new(sim.model.clone(), sim.state.clone());
            sim.model.solver.warm_start = warm;
            let step = |_| {
                let report = sim.step();
                assert!(report.residual <= 1e-6, "{name}, {warm}: {report:?}");
                report.iterations
            };
            (0..20).map(step).sum::<u32>()
        };
        let (warm, cold) = (next(true), next(false));
        assert!(10 * warm < 9 * cold, "{name}: {warm} iterations from the last impulses, {cold} from none");
    }
}

#[test]
fn a_contact_keeps_its_impulse_from_step_to_step() {
    for again in [false, true] {
        for (name, mut sim) in piles() {
            make_ready(&mut sim, again);
            let before = impulses(&sim);
            sim.step();
            let after = impulses(&sim);
            let known: Vec<_> = after.iter().filter_map(|(key, now)| Some((*before.get(key)?, *now))).collect();
            assert!(
                known.len() * 10 > after.len() * 9,
                "{name}: {} of {} contacts are known",
                known.len(),
                after.len()
            );
            let square =
                |f: &dyn Fn(&(DVec3, DVec3)) -> DVec3| known.iter().map(|k| f(k).length_squared()).sum::<f64>();
            let change = (square(&|(then, now)| *now - *then) / square(&|(then, _)| *then)).sqrt();
            assert!(change < 0.3, "{name}, {again}: the impulses have changed by {change} of themselves");
        }
    }
}

#[test]
fn the_starting_point_is_the_last_steps_impulses() {
    // Jacobi's iteration with no step leaves what it begins with: the last impulses times one factor, which differ only by the
    // projection on cones that have turned a little since.
    for again in [false, true] {
        for (name, mut sim) in piles() {
            make_ready(&mut sim, again);
            let before = impulses(&sim);
            sim.model.solver = SolverSettings {
                method: Some(Method::Jacobi),
                iterations: Some(1),
                lambda: 0.0,
                ..sim.model.solver.clone()
            };
            sim.step();
            let after = impulses(&sim);
            // What contacts of two shapes had that are no more goes on with another of the same shapes.
            let (before, after) = (of_shapes(&before), of_shapes(&after));
            let known: Vec<_> = after.iter().filter_map(|(key, now)| Some((*before.get(key)?, *now))).collect();
            let new = after.iter().filter(|(key, _)| !before.contains_key(*key));
            let dot = |f: &dyn Fn(&(DVec3, DVec3)) -> f64| known.iter().map(f).sum::<f64>();
            let factor = dot(&|(a, b)| a.dot(*b)) / dot(&|(a, _)| a.dot(*a));
            assert!((0.5..2.0).contains(&factor), "{name}, {again}: {factor}");
            let off = (dot(&|(a, b)| (*b - *a * factor).length_squared()) / dot(&|(a, _)| a.length_squared())).sqrt();
            assert!(off < 0.05, "{name}, {again}: the starting point is off by {off} of the last impulses");
            assert!(
                new.into_iter().all(|(_, now)| *now == DVec3::ZERO),
                "{name}, {again}: shapes that did not touch have an impulse"
            );
            assert!(known.len() > 20, "{name}: {} pairs that touched", known.len());
        }
    }
}

/// The sums of the impulses of the contacts of two shapes.
fn of_shapes(impulses: &BTreeMap<[u32; 3], DVec3>) -> BTreeMap<[u32; 2], DVec3> {
    let mut sums = BTreeMap::new();
    for ([a, b, _], impulse) in impulses {
        *sums.entry([*a, *b]).or_insert(DVec3::ZERO) += *impulse;
    }
    sums
}
