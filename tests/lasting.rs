//! Factorisations of joints that last for many steps: what moves by them is what moves by one factorisation a step.

use crate::analytic::simulation;
use crate::cli::scratch;
use sim::model_file::ShapeFile;
use sim::workload::{self, Convex};
use sim::{Quality, Simulation, State, checkpoint};

/// A net of 40 by 40 spherical joints under this gravity.
fn net(gravity: [f64; 3], quality: Quality) -> Simulation {
    let mut model = workload::scene(Convex::Grid, 40);
    (model.file.gravity, model.file.quality) = (gravity, Some(quality));
    model.simulation().unwrap()
}

/// Take steps with factors that last, and the same with one in each step. Returns the greatest distance of a body between the two, the greatest gap of a
/// joint of the first, and the number of its steps with the factor of an earlier step.
fn both(sim: Simulation, steps: usize) -> (f64, f64, usize) {
    let mut each = Simulation::new(sim.model.clone(), sim.state.clone());
    let mut sim = sim;
    let (mut gap, mut n_old) = (0.0f64, 0);
    for _ in 0..steps {
        let before = sim.state.joint_factor.clone();
        sim.step();
        each.state.joint_factor = Default::default();
        each.step();
        gap = sim.state.joints.iter().map(|joint| joint.violation).fold(gap, f64::max);
        n_old += usize::from(sim.state.joint_factor.is_same(&before));
    }
    let pairs = sim.state.position.iter().zip(&each.state.position);
    (pairs.map(|(a, b)| a.distance(*b)).fold(0.0, f64::max), gap, n_old)
}

#[test]
fn a_net_at_rest_has_one_factor() {
    for quality in [Quality::Normal, Quality::Tight] {
        let (apart, gap, n_old) = both(net([0.0, -10.0, 0.0], quality), 50);
        assert!(apart < 1e-12 && gap < 1e-6, "{quality:?}: {apart} m apart, gap {gap} m");
        assert_eq!(n_old, 49, "{quality:?}");
    }
}

#[test]
fn a_net_that_sways_has_few_factors() {
    // Let go half a degree off the vertical.
    let (apart, gap, n_old) = both(net([0.0, -10.0, 0.1], Quality::Normal), 250);
    assert!(apart < 1e-6 && gap < 1e-6, "{apart} m apart, gap {gap} m");
    assert!(n_old > 125, "{n_old} of 250 steps");
}

#[test]
fn a_net_that_falls_has_new_factors() {
    let (apart, gap, n_old) = both(net([0.0, -7.0, 7.0], Quality::Normal), 60);
    assert!(apart < 1e-6 && gap < 1e-6, "{apart} m apart, gap {gap} m");
    assert!(n_old < 30, "{n_old} of 60 steps");
}

#[test]
fn a_factor_ends_where_bodies_touch_and_where_they_wake() {
    // A knot is let go after 0.2 s, and after 0.6 s there is ground below the lowest.
    let mut model = workload::scene(Convex::Grid, 40);
    (model.file.gravity, model.file.quality) = ([0.0, -10.0, 0.1], Some(Quality::Normal));
    let ground = model.body("ground", "knot", ShapeFile::plane([0.0, 1.0, 0.0]));
    (ground.position, ground.appears) = ([0.0, -39.401, 0.0], Some(0.6));
    model.file.bodies[39].held_until = Some(0.2);
    let (apart, _, n_old) = both(model.simulation().unwrap(), 120);
    assert!(apart < 1e-6, "{apart} m apart");
    assert!(n_old > 0, "no step goes on with a factor");
}

#[test]
fn small_mechanisms_have_a_factor_in_each_step() {
    let mut sim = simulation(
        "materials: {m: {density: 1000, friction: 0.4}}
bodies:
  - {name: arm, material: m, box: {size: [0.2, 0.04, 0.04]}, position: [0, 0, -0.1]}
joints:
  - {name: hinge, kind: revolute, a: world, b: arm, axis: [0, 1, 0]}
",
    );
    for _ in 0..10 {
        sim.step();
        assert!(!sim.state.joint_factor.is_there());
    }
}

#[test]
fn factors_do_not_depend_on_threads_or_checkpoints() {
    let work = scratch();
    let path = |name: &str| work.path().join(name);
    let first = net([0.0, -10.0, 0.2], Quality::Normal);
    let run = |threads: usize, state: State, steps: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut sim = Simulation::new(first.model.clone(), state);
        pool.install(|| (0..steps).for_each(|_| drop(sim.step())));
        sim.state
    };
    let whole = run(1, first.state.clone(), 90);
    checkpoint::write(&path("whole"), &whole, "").unwrap();
    for steps in [1, 30, 47] {
        let half = run(2, first.state.clone(), steps);
        assert!(half.joint_factor.is_there());
        checkpoint::write(&path("half"), &half, "").unwrap();
        let half = checkpoint::read(&path("half")).unwrap().0;
        half.fit(&first.model).unwrap();
        checkpoint::write(&path("two"), &run(7, half, 90 - steps), "").unwrap();
        assert!(std::fs::read(path("whole")).unwrap() == std::fs::read(path("two")).unwrap(), "after {steps} steps");
    }
}
