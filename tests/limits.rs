//! Limits of joints that are met: ropes, and chains of hinges.

use crate::analytic::simulation;
use sim::Simulation;
use std::fmt::Write;

const MATERIALS: &str = "materials: {m: {density: 1000, friction: 0.3}}\n";

fn energy(sim: &Simulation) -> f64 {
    sim.state.kinetic_energy(&sim.model) + sim.state.potential_energy(&sim.model)
}

/// Run without a warning. Returns the most that the energy has grown by after its least, J, and the greatest violation of a joint, m or rad.
fn run(yaml: &str, until: f64) -> [f64; 2] {
    let mut sim = simulation(yaml);
    let (mut least, mut gained, mut violation) = (energy(&sim), 0.0f64, 0.0f64);
    while sim.state.time < until {
        let report = sim.step();
        assert!(report.warnings.is_empty(), "{:?}", report.warnings);
        let now = energy(&sim);
        least = now.min(least);
        gained = (now - least).max(gained);
        violation = sim.state.joints.iter().fold(violation, |most, joint| joint.violation.max(most));
    }
    [gained, violation]
}

#[test]
fn a_bridge_of_ropes_gains_nothing_by_what_falls_on_it() {
    const N: usize = 10;
    // Nodes of 0.3 kg on a parabola over 1 m, 50 mm deep, and a box of 10 kg on a rail 0.2 m over the middle one: 20 J.
    let at = |i: usize| {
        let x = i as f64 / N as f64;
        [x - 0.5, 0.0, -0.2 * x * (1.0 - x)]
    };
    let bridge = |settings: &str| {
        let mut bodies = format!(
            "{settings}solver: {{friction: exact}}\n{MATERIALS}bodies:\n  - {{name: load, material: m, mass: 10, box: {{size: [0.2, 0.2, 0.1]}}, position: [0, 0, 0.23]}}\n"
        );
        let mut joints =
            "joints:\n  - {name: rail, kind: prismatic, a: world, b: load, position: [0, 0, 0.23], axis: [0, 0, 1]}\n"
                .to_owned();
        for i in 1..N {
            writeln!(
                bodies,
                "  - {{name: n{i}, material: m, mass: 0.3, sphere: {{radius: 0.03}}, position: {:?}}}",
                at(i)
            )
            .unwrap();
        }
        let node = |i: usize| if i == 0 || i == N { "world".to_owned() } else { format!("n{i}") };
        for i in 0..N {
            let (start, end) = (at(i), at(i + 1));
            let length = (end[0] - start[0]).hypot(end[2] - start[2]);
            // The world is A.
            let [(a, from), (b, to)] = match i + 1 == N {
                true => [(node(N), end), (node(i), start)],
                false => [(node(i), start), (node(i + 1), end)],
            };
            writeln!(joints, "  - {{name: r{i}, kind: distance, a: {a}, b: {b}, position: {from:?}, position_b: {to:?}, limits: [0, {length}]}}").unwrap();
        }
        bodies + &joints
    };
    for settings in ["", "quality: draft\n", "quality: normal\n", "quality: tight\n"] {
        let [gained, violation] = run(&bridge(settings), 1.0);
        assert!(gained < 1.0 && violation < 5e-4, "{settings}{gained} J, {violation} m");
    }
}

#[test]
fn a_ball_that_is_whirled_on_a_rope_keeps_its_energy_and_the_rope_its_length() {
    // 0.05 and 0.3 rad in a step of 1 ms.
    for speed in [50.0, 300.0] {
        let mut sim = simulation(&format!(
            "gravity: [0, 0, 0]\n{MATERIALS}bodies: [{{name: b, material: m, mass: 1, sphere: {{radius: 0.03}}, position: [1, 0, 0], velocity: [0, {speed}, 0]}}]
joints: [{{name: r, kind: distance, a: world, b: b, position: [0, 0, 0], position_b: [1, 0, 0], limits: [0, 1]}}]
"
        ));
        let first = energy(&sim);
        while sim.state.time < 0.5 {
            let report = sim.step();
            assert!(report.warnings.is_empty(), "{speed}: {:?}", report.warnings);
            let length = sim.state.position[0].length();
            assert!((length - 1.0).abs() < 1e-6, "{speed}, {} s: {length} m", sim.state.time);
        }
        let kept = energy(&sim) / first;
        assert!((kept - 1.0).abs() < 0.005, "{speed}: {kept} of the energy");
    }
}

/// Links of 0.1 m side by side along x, from the world on, whose hinges turn by `range` degrees to either side, with a load at the end.
fn beam(n: usize, range: f64, settings: &str, load: f64) -> String {
    let mut bodies = format!("{settings}{MATERIALS}bodies:\n");
    let mut joints = "joints:\n".to_owned();
    for i in 0..n {
        let (x, before) = (0.1 * i as f64, if i == 0 { "world".into() } else { format!("l{}", i - 1) });
        writeln!(bodies, "  - {{name: l{i}, material: m, mass: 0.2, capsule: {{radius: 0.01, length: 0.06}}, rotate: {{axis: [0, 1, 0], angle: 90}}, position: [{}, 0, 0]}}", x + 0.05).unwrap();
        writeln!(joints, "  - {{name: h{i}, kind: revolute, a: {before}, b: l{i}, position: [{x}, 0, 0], axis: [0, 1, 0], limits: [-{range}, {range}]}}").unwrap();
    }
    if load > 0.0 {
        let x = 0.1 * n as f64;
        writeln!(
            bodies,
            "  - {{name: load, material: m, mass: {load}, sphere: {{radius: 0.04}}, position: [{}, 0, 0]}}",
            x + 0.04
        )
        .unwrap();
        writeln!(joints, "  - {{name: end, kind: fixed, a: l{}, b: load, position: [{x}, 0, 0]}}", n - 1).unwrap();
    }
    bodies + &joints
}

#[test]
fn chains_of_hinges_at_their_limits_are_beams() {
    // With 100 links' weight, by methods that went through the limits as they go through contacts; the narrow ones all hold within a step.
    for range in [0.1, 5.0] {
        for (n, settings, load) in [
            (6, "solver: {method: gauss_seidel}\n", 0.0),
            (20, "", 20.0),
            (20, "quality: normal\n", 20.0),
            (20, "quality: draft\n", 20.0),
        ] {
            let [gained, violation] = run(&beam(n, range, settings, load), 1.0);
            // Of 200 J that fall.
            assert!(gained < 0.5 && violation < 1e-3, "{n}, {range}, {settings}{gained} J, {violation} rad");
        }
        // Sixty hinges, of which one after another comes to its limit: rounds alone do not find which of them hold.
        let [gained, violation] = run(&beam(60, range, "", 0.0), 0.5);
        assert!(gained < 0.1 && violation < 1e-3, "{range}, {gained} J, {violation} rad");
    }
    // At rest the wall holds the weight: 20 links of 0.2 kg, in an arc of a circle.
    let mut sim = simulation(&beam(20, 0.1, "", 0.0));
    (0..3000).for_each(|_| drop(sim.step()));
    let arm: f64 = sim.state.position.iter().map(|p| p.x).sum::<f64>() / 20.0;
    let (torque, speed) = (sim.state.joints[0].torque.length(), sim.state.velocity[19].length());
    assert!((torque / (20.0 * 0.2 * 9.81 * arm) - 1.0).abs() < 1e-6 && speed < 1e-6, "{torque} N m, {speed} m/s");
}

#[test]
fn a_rope_holds_against_a_motor_without_a_maximum() {
    let mut sim = simulation(&format!(
        "{MATERIALS}bodies: [{{name: b, material: m, sphere: {{radius: 0.02}}, position: [0.3, 0, 0]}}]
joints:
  - {{name: rope, kind: distance, a: world, b: b, position_b: [0.3, 0, 0], limits: [0, 0.31]}}
  - {{name: rail, kind: prismatic, a: world, b: b, position: [0.3, 0, 0], axis: [1, 0, 0], motor: {{speed: 0.5}}}}
"
    ));
    (0..1000).for_each(|_| drop(sim.step()));
    let length = sim.state.position[0].length();
    assert!((length - 0.31).abs() < 1e-5, "{length} m");
}

#[test]
fn a_servo_that_is_sent_beyond_its_limit_presses_against_it() {
    let mut sim = simulation(&format!(
        "gravity: [0, 0, 0]\n{MATERIALS}bodies: [{{name: arm, material: m, mass: 10, box: {{size: [0.5, 0.05, 0.05]}}, position: [0.25, 0, 0]}}]
joints: [{{name: s, kind: revolute, a: world, b: arm, axis: [0, 0, 1], limits: [-20, 20], motor: {{motion: {{sine: {{amplitude: 0.9, frequency: 0.5}}}}, max_torque: 200}}}}]
"
    ));
    while sim.state.time < 0.8 {
        let _ = sim.step();
        // It is to be at 20° and more from 0.13 to 0.87 s, and turns back at 0.5 s.
        let joint = &sim.state.joints[0];
        if sim.state.time > 0.3 {
            assert!((joint.effort - 200.0).abs() < 1e-9 && joint.rate.abs() < 1e-9, "{} s: {joint:?}", sim.state.time);
        }
        assert!(joint.coordinate < 20f64.to_radians() + 1e-6, "{} s: {joint:?}", sim.state.time);
    }
}

#[test]
fn narrow_ranges_hold_against_what_comes_at_once() {
    // 3 kN on 1 kg, which could go by 3 mm in the first step: a slide with a millimetre to either side, or one to one side alone, and a link.
    for (joint, limits) in [
        ("kind: prismatic, axis: [1, 0, 0]", "[-0.001, 0.001]"),
        ("kind: prismatic, axis: [1, 0, 0]", "[-0.01, 0.001]"),
        ("kind: distance, position: [-1, 0, 0], position_b: [0, 0, 0]", "[0.999, 1.001]"),
    ] {
        let yaml = format!(
            "gravity: [0, 0, 0]\n{MATERIALS}bodies: [{{name: b, material: m, mass: 1, sphere: {{radius: 0.03}}}}]
joints: [{{name: s, {joint}, a: world, b: b, limits: {limits}}}]
loads: [{{body: b, force: [1, 0, 0], value: 3000, from: 0.01}}]
"
        );
        let [_, violation] = run(&yaml, 0.1);
        assert!(violation < 1e-6, "{joint}, {limits}: {violation} m");
    }
}
