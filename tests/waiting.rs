//! Contacts without impulses for many steps: bodies that fall, drift or bounce respond to the next load as if there had been no wait, by
//! every method and law.

use crate::analytic::simulation;
use crate::cli::scratch;
use sim::{Simulation, State, checkpoint};

const METHODS: [&str; 4] = ["apgd", "barzilai_borwein", "gauss_seidel", "jacobi"];
const LAWS: [&str; 2] = ["relaxed", "exact"];

/// Run a check for every method and law.
fn for_all(check: impl Fn(&str, &str)) {
    for method in METHODS {
        LAWS.iter().for_each(|law| check(method, law));
    }
}

/// Take steps; none may warn, and none may have a residual that is not finite.
fn advance(sim: &mut Simulation, steps: usize, what: &str) {
    for _ in 0..steps {
        let report = sim.step();
        assert!(report.residual.is_finite() && report.broken.is_none(), "{what}, step {}: {report:?}", report.step);
        assert!(report.warnings.is_empty(), "{what}: {:?}", report.warnings);
    }
}

/// Two bodies on each other, in touch, high above the ground.
fn falling_stack(method: &str, law: &str, shape: &str, step: f64, height: f64) -> Simulation {
    simulation(&format!(
        "step: {step}
solver: {{method: {method}, friction: {law}}}
materials: {{m: {{density: 1000, friction: 0.5}}}}
bodies:
  - {{name: ground, material: m, plane: {{normal: [0, 0, 1]}}}}
  - {{name: lower, material: m, {shape}, position: [0, 0, {}]}}
  - {{name: upper, material: m, {shape}, position: [0, 0, {}]}}
",
        height + 0.1,
        height + 0.3
    ))
}

/// A state without the solver's data of earlier steps.
fn forgetful(state: &State) -> State {
    State { contacts: Default::default(), fat_aabb: None, step_length: 0.0, ..state.clone() }
}

#[test]
fn a_stack_lands_as_if_it_had_not_fallen_for_long() {
    let work = scratch();
    let threads = |n: usize| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
    let (one, seven) = (threads(1), threads(7));
    for_all(|method, law| {
        for shape in ["sphere: {radius: 0.1}", "box: {size: [0.2, 0.2, 0.2]}"] {
            for (fall, step) in [(1_000, 1e-3), (10_000, 1e-4)] {
                let what = format!("{method}, {law}, {shape}, {fall} steps");
                let height = 0.5 * 9.81 * (fall as f64 * step).powi(2);
                let landing = (0.4 / step) as usize;
                let mut whole = falling_stack(method, law, shape, step, height);
                let (model, start) = (whole.model.clone(), whole.state.clone());
                let mut resumed = None;
                one.install(|| {
                    advance(&mut whole, fall - 10, &what);
                    resumed = Some(Simulation::new(model.clone(), forgetful(&whole.state)));
                    advance(&mut whole, landing, &what);
                });
                let mut resumed = resumed.unwrap();
                one.install(|| advance(&mut resumed, landing, &what));
                for b in 1..3 {
                    let place = whole.state.position[b];
                    let expected = if b == 1 { 0.1 } else { 0.3 };
                    assert!((place.z - expected).abs() < 2e-3, "{what}: body {b} lies at {place}");
                    assert!(place.truncate().length() < 1e-3, "{what}: body {b} lies at {place}");
                    assert!(whole.state.velocity[b].length() < 1e-3, "{what}: {}", whole.state.velocity[b]);
                    assert!(
                        place.distance(resumed.state.position[b]) < 1e-5,
                        "{what}: {place}, else {}",
                        resumed.state.position[b]
                    );
                }
                // By other threads, and over a checkpoint in the fall: the same bits.
                let mut again = Simulation::new(model.clone(), start);
                seven.install(|| advance(&mut again, fall / 2, &what));
                let path = work.path().join("fall");
                checkpoint::write(&path, &again.state, "").unwrap();
                let mut again = Simulation::new(model, checkpoint::read(&path).unwrap().0);
                seven.install(|| advance(&mut again, fall - fall / 2 - 10 + landing, &what));
                checkpoint::write(&path, &again.state, "").unwrap();
                let other = work.path().join("whole");
                checkpoint::write(&other, &whole.state, "").unwrap();
                assert!(std::fs::read(&path).unwrap() == std::fs::read(&other).unwrap(), "{what}: the states differ");
            }
        }
    });
}

#[test]
fn bodies_that_met_drift_on_together() {
    for_all(|method, law| {
        for shape in ["sphere: {radius: 0.1}", "box: {size: [0.2, 0.2, 0.2]}"] {
            let what = format!("{method}, {law}, {shape}");
            let mut sim = simulation(&format!(
                "gravity: [0, 0, 0]
solver: {{method: {method}, friction: {law}}}
materials: {{m: {{density: 1000, friction: 0.5}}}}
bodies:
  - {{name: a, material: m, {shape}, velocity: [1, 0, 0]}}
  - {{name: b, material: m, {shape}, position: [0.5, 0, 0]}}
"
            ));
            let mut iterations = 0;
            for _ in 0..3_000 {
                let report = sim.step();
                assert!(report.warnings.is_empty() && report.broken.is_none(), "{what}: {report:?}");
                iterations += report.iterations;
            }
            for b in 0..2 {
                let off = sim.state.velocity[b] - glam::DVec3::X * 0.5;
                assert!(off.length() < 1e-6, "{what}: {}", sim.state.velocity[b]);
            }
            let distance = sim.state.position[1] - sim.state.position[0];
            assert!((distance.x - 0.2).abs() < 1e-4, "{what}: {distance}");
            assert!(iterations < 100_000, "{what}: {iterations} iterations");
        }
    });
}

/// Spheres in a row that touch: all at once they share the motion, one after another they hand it on.
#[test]
fn a_cradle_that_touches_hands_the_impact_on_where_it_is_sequential() {
    for_all(|method, law| {
        for (impacts, speeds) in [("simultaneous", [-0.5, 0.5, 0.5, 0.5]), ("sequential", [0.0, 0.0, 0.0, 1.0])] {
            let spheres: String = [-0.12, 0.0, 0.1, 0.2]
                .iter()
                .enumerate()
                .map(|(i, x)| {
                    let speed = if i == 0 { 1 } else { 0 };
                    format!("  - {{name: s{i}, material: m, sphere: {{radius: 0.05}}, position: [{x}, 0, 0], velocity: [{speed}, 0, 0]}}\n")
                })
                .collect();
            let mut sim = simulation(&format!(
                "gravity: [0, 0, 0]
solver: {{method: {method}, friction: {law}, impacts: {impacts}, tolerance: 1e-10}}
materials: {{m: {{density: 7800, friction: 0.3, restitution: 1}}}}
bodies:
{spheres}"
            ));
            (0..100).for_each(|_| drop(sim.step()));
            for (b, speed) in speeds.into_iter().enumerate() {
                let v = sim.state.velocity[b].x;
                assert!((v - speed).abs() < 1e-6, "{method}, {law}, {impacts}: sphere {b} has {v} m/s");
            }
        }
    });
}

/// Spheres in a row with gaps, without friction: the momentum of the first one goes through all of them, and energy does not grow.
#[test]
fn a_cradle_keeps_its_energy() {
    for_all(|method, law| {
        for (restitution, gravity) in [(0.0, 0.0), (0.9, -9.81), (1.0, 0.0), (1.0, -9.81)] {
            let what = format!("{method}, {law}, {restitution}, {gravity}");
            let spheres: String = (0..6)
                .map(|i| {
                    let speed = if i == 0 { 1 } else { 0 };
                    let x = i as f64 * 0.101;
                    format!("  - {{name: s{i}, material: m, sphere: {{radius: 0.05}}, position: [{x}, 0, 0.05], velocity: [{speed}, 0, 0]}}\n")
                })
                .collect();
            let mut sim = simulation(&format!(
                "gravity: [0, 0, {gravity}]
step: 1e-4
solver: {{method: {method}, friction: {law}, tolerance: 1e-6}}
materials: {{m: {{density: 7800, friction: 0, restitution: {restitution}}}}}
bodies:
  - {{name: ground, material: m, plane: {{normal: [0, 0, 1]}}}}
{spheres}"
            ));
            let momentum = |sim: &Simulation| sim.state.velocity.iter().map(|v| v.x).sum::<f64>();
            advance(&mut sim, 1_000, &what);
            let energy = sim.state.kinetic_energy(&sim.model);
            let mass = 1.0 / sim.model.inv_mass[1];
            assert!((momentum(&sim) - 1.0).abs() < 1e-5, "{what}: momentum {}", momentum(&sim));
            assert!(energy <= 0.5 * mass * 1.0001, "{what}: {energy} J");
            if restitution == 1.0 {
                assert!(energy >= 0.5 * mass * 0.999, "{what}: {energy} J");
                assert!((sim.state.velocity[6].x - 1.0).abs() < 1e-3, "{what}: {}", sim.state.velocity[6]);
            }
        }
    });
}

/// A sphere between two walls, thrown from one to the other: contacts open and close, and its speed stays.
#[test]
fn a_sphere_bounces_between_two_walls() {
    for_all(|method, law| {
        let what = format!("{method}, {law}");
        let mut sim = simulation(&format!(
            "gravity: [0, 0, 0]
solver: {{method: {method}, friction: {law}}}
materials: {{m: {{density: 1000, friction: 0.3, restitution: 1}}}}
bodies:
  - {{name: left, material: m, plane: {{normal: [1, 0, 0]}}, position: [-0.2, 0, 0]}}
  - {{name: right, material: m, plane: {{normal: [-1, 0, 0]}}, position: [0.2, 0, 0]}}
  - {{name: sphere, material: m, sphere: {{radius: 0.1}}, velocity: [3, 0, 0]}}
"
        ));
        let (mut turns, mut before) = (0, 3.0);
        for _ in 0..4_000 {
            advance(&mut sim, 1, &what);
            let now = sim.state.velocity[2].x;
            turns += (now * before < 0.0) as usize;
            before = now;
        }
        assert!((before.abs() - 3.0).abs() < 1e-5, "{what}: {before}");
        assert!((59..=61).contains(&turns), "{what}: {turns} turns in 4 s at 3 m/s over 0.2 m");
    });
}
