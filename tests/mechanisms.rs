//! What joints alone move keeps its energy and its joints, at the steps that a model has by default and by its quality.

use crate::analytic::simulation;
use crate::cli::{scratch, scree};
use sim::Simulation;
use std::fmt::Write;

/// Settings of a model that names no step.
const OPEN: [&str; 3] = ["", "quality: normal\n", "quality: tight\n"];

/// Length of a link, m.
const LINK: f64 = 0.2;

const MATERIALS: &str = "materials: {m: {density: 1000, friction: 0.4}}\npass_through: [[g, g]]\n";

/// Links side by side along x, let go level from their first end; `drive` is of that.
fn chain(n: usize, settings: &str, drive: &str) -> String {
    let mut bodies = format!("{settings}{MATERIALS}bodies:\n");
    let mut joints = "joints:\n".to_owned();
    for i in 0..n {
        let (start, middle) = (LINK * i as f64, LINK * (i as f64 + 0.5));
        let before = if i == 0 { "world".to_owned() } else { format!("l{}", i - 1) };
        let drive = if i == 0 { drive } else { "" };
        let size = [LINK, 0.04, 0.04];
        writeln!(
            bodies,
            "  - {{name: l{i}, material: m, group: g, box: {{size: {size:?}}}, position: [{middle}, 0, 0]}}"
        )
        .unwrap();
        writeln!(joints, "  - {{name: j{i}, kind: revolute, a: {before}, b: l{i}, position: [{start}, 0, 0], axis: [0, 1, 0]{drive}}}")
            .unwrap();
    }
    bodies + &joints
}

/// A slider-crank at its dead centre, whose crank turns at `speed`, rad/s, or is driven so.
fn slider_crank(settings: &str, speed: f64, is_driven: bool) -> String {
    let at = if is_driven { 0.0 } else { speed };
    let motor = if is_driven { format!(", motor: {{speed: {speed}}}") } else { String::new() };
    // The rod turns about the piston, which stands.
    let (rod, end) = (-0.4 * at, -0.1 * at);
    format!(
        "{settings}{MATERIALS}bodies:
  - {{name: crank, material: m, group: g, box: {{size: [0.2, 0.04, 0.04]}}, position: [0.1, 0, 0], velocity: [0, 0, {end}], angular_velocity: [0, {at}, 0]}}
  - {{name: rod, material: m, group: g, box: {{size: [0.5, 0.04, 0.04]}}, position: [0.45, 0, 0], velocity: [0, 0, {end}], angular_velocity: [0, {rod}, 0]}}
  - {{name: piston, material: m, group: g, box: {{size: [0.1, 0.1, 0.1]}}, position: [0.7, 0, 0]}}
joints:
  - {{name: shaft, kind: revolute, a: world, b: crank, axis: [0, 1, 0]{motor}}}
  - {{name: pin, kind: revolute, a: crank, b: rod, position: [0.2, 0, 0], axis: [0, 1, 0]}}
  - {{name: wrist, kind: revolute, a: rod, b: piston, position: [0.7, 0, 0], axis: [0, 1, 0]}}
  - {{name: guide, kind: prismatic, a: world, b: piston, position: [0.7, 0, 0], axis: [1, 0, 0]}}
"
    )
}

/// What a run has shown.
struct Seen {
    /// Mean energy of the first and of the last tenth of it, and the maximum kinetic energy, J.
    energy: [f64; 2],
    kinetic: f64,
    /// The greatest violation of a joint, m or rad.
    gap: f64,
}

impl Seen {
    /// Share of the maximum kinetic energy that has come in the mean.
    fn gained(&self) -> f64 {
        (self.energy[1] - self.energy[0]) / self.kinetic
    }
}

/// Run until a time, s, without a warning.
fn watched(yaml: &str, until: f64) -> (Simulation, Seen) {
    let mut sim = simulation(yaml);
    let n = (until / sim.model.step).round() as usize;
    let mut seen = Seen { energy: [0.0; 2], kinetic: 0.0, gap: 0.0 };
    for i in 0..n {
        sim.step();
        let kinetic = sim.state.kinetic_energy(&sim.model);
        let energy = kinetic + sim.state.potential_energy(&sim.model);
        let tenth = n / 10;
        if i < tenth {
            seen.energy[0] += energy / tenth as f64;
        } else if i >= n - tenth {
            seen.energy[1] += energy / tenth as f64;
        }
        seen.kinetic = seen.kinetic.max(kinetic);
        seen.gap = sim.state.joints.iter().map(|j| j.violation).fold(seen.gap, f64::max);
    }
    let warned: Vec<&str> = sim.state.watch.warnings.iter().map(|w| w.first.message.as_str()).collect();
    assert!(warned.is_empty(), "{warned:?}");
    (sim, seen)
}

#[test]
fn chains_let_go_level_keep_their_energy_and_their_joints() {
    for n in [1, 2, 3, 5, 10, 20] {
        for settings in OPEN {
            let (_, seen) = watched(&chain(n, settings, ""), 5.0);
            let gained = seen.gained();
            assert!(gained.abs() < 0.01, "{n} links {settings}: {gained} of the kinetic energy");
            assert!(seen.gap < 1e-4 * LINK, "{n} links {settings}: {} m", seen.gap);
        }
    }
}

/// A closed loop that turns by 0.1 rad in a step gained a third of its energy by joints that were solved for once or twice; one that turns by a
/// radian was torn.
#[test]
fn a_slider_crank_keeps_its_energy() {
    // At 600 rad/s a part finds no solution once in a thousand turns: its gap is made good within a few steps.
    for (step, speed, gap) in
        [(1e-3, 100.0, 1e-6), (1.8e-3, 100.0, 1e-6), (1e-3, 250.0, 1e-6), (1e-3, 600.0, 1e-4), (1e-3, 1000.0, 1e-6)]
    {
        let (_, seen) = watched(&slider_crank(&format!("step: {step}\n"), speed, false), 5.0);
        assert!(seen.gained().abs() < 0.01, "{step} s, {speed} rad/s: {} of the kinetic energy", seen.gained());
        assert!(seen.gap < gap, "{step} s: {} m", seen.gap);
    }
}

/// A rod of 1 m about its end, which lost 6 % in this time by joints that hold at the start of a step.
/// A crank a fiftieth as heavy as its slider, by a torque from 0.1 s on: at the dead centre it whirls for a step.
#[test]
fn a_light_crank_passes_its_dead_centre_at_every_step() {
    for step in [1e-3, 3e-4, 1e-4] {
        let yaml = format!(
            "step: {step}\n{MATERIALS}bodies:
  - {{name: crank, material: m, group: g, mass: 0.5, box: {{size: [0.1, 0.03, 0.02]}}, position: [0.05, 0, 0]}}
  - {{name: rod, material: m, group: g, mass: 1.2, box: {{size: [0.4, 0.02, 0.02]}}, position: [0.3, 0, 0.04]}}
  - {{name: slider, material: m, group: g, mass: 23, box: {{size: [0.1, 0.1, 0.3]}}, position: [0.5, 0, 0.04]}}
joints:
  - {{name: shaft, kind: revolute, a: world, b: crank, axis: [0, 1, 0], motor: {{torque: {{step: {{at: 0.1, after: 20}}}}}}}}
  - {{name: pin, kind: revolute, a: crank, b: rod, position: [0.1, 0, 0], axis: [0, 1, 0]}}
  - {{name: wrist, kind: revolute, a: rod, b: slider, position: [0.5, 0, 0], axis: [0, 1, 0]}}
  - {{name: guide, kind: prismatic, a: world, b: slider, position: [0.5, 0, 0], axis: [1, 0, 0]}}
"
        );
        let (_, seen) = watched(&yaml, 1.0);
        assert!(seen.gap < 1e-5, "{step}: {} m", seen.gap);
    }
}

#[test]
fn a_fast_rotor_on_a_hinge_keeps_its_energy() {
    let (_, seen) = watched(
        "gravity: [0, 0, 0]
step: 1e-3
materials: {m: {density: 1000, friction: 0.5}}
bodies: [{name: rod, material: m, box: {size: [1, 0.05, 0.05]}, position: [0.5, 0, 0], velocity: [0, 30, 0], angular_velocity: [0, 0, 60]}]
joints: [{name: hinge, kind: revolute, a: world, b: rod, axis: [0, 0, 1]}]
",
        10.0,
    );
    assert!(seen.gained().abs() < 1e-5, "{}", seen.gained());
    assert!(seen.gap < 1e-6, "{} m", seen.gap);
}

#[test]
fn motors_that_start_at_once_leave_their_joints_whole() {
    for settings in OPEN {
        for speed in [30.0, 300.0] {
            let (sim, seen) = watched(&chain(1, settings, &format!(", motor: {{speed: {speed}}}")), 0.5);
            let rate = sim.state.joints[0].rate;
            assert!((rate - speed).abs() < 1e-6 * speed && seen.gap < 1e-6, "{settings} {speed} rad/s: {} m", seen.gap);
        }
        let (_, seen) = watched(&slider_crank(settings, 50.0, true), 2.0);
        assert!(seen.gap < 1e-6, "{settings}: {} m", seen.gap);
    }
}

/// A step in which a motor turns too far is made shorter by the quality, and without one it is said which joint it tears, and what step it takes.
/// The ends of chains that are whirled carry forces that are stiff for the step: their joints hold all the same.
#[test]
fn chains_that_are_whirled_stay_whole() {
    for settings in OPEN {
        for (n, speed) in [(5, 30.0), (10, 20.0)] {
            let (_, seen) = watched(&chain(n, settings, &format!(", motor: {{speed: {speed}}}")), 2.0);
            assert!(seen.gap < 1e-6, "{settings} {n}: {} m", seen.gap);
        }
    }
}

/// Links in a zigzag that a load pulls straight are thrown round by it within a few steps, which are taken in parts.
#[test]
fn a_load_that_pulls_a_zigzag_straight_gains_nothing() {
    for settings in OPEN {
        let mut sim = simulation(&zigzag(settings));
        let mut kinetic = 0.0f64;
        let mut parts = 0;
        let start = sim.state.potential_energy(&sim.model);
        while sim.state.time < 3.0 {
            let report = sim.step();
            assert!(report.warnings.is_empty(), "{settings}: {:?}", report.warnings);
            kinetic = kinetic.max(sim.state.kinetic_energy(&sim.model));
            parts = parts.max(report.parts);
        }
        let energy = sim.state.kinetic_energy(&sim.model) + sim.state.potential_energy(&sim.model);
        assert!((energy - start).abs() < 0.03 * kinetic, "{settings}: {start} J, {energy} J");
        assert!(parts > 1, "{settings}: in {parts} parts");
    }
}

/// Ten links of 0.2 m at 60° to the horizontal, up and down, and a ball of 50 kg at their end.
fn zigzag(settings: &str) -> String {
    let mut bodies = format!("{settings}{MATERIALS}bodies:\n");
    let mut joints = "joints:\n".to_owned();
    let [mut x, mut z] = [0.0, 0.0];
    for i in 0..10 {
        let angle = if i % 2 == 0 { 60.0f64 } else { -60.0 };
        let (sin, cos) = angle.to_radians().sin_cos();
        let middle = [x + 0.5 * LINK * cos, 0.0, z - 0.5 * LINK * sin];
        let before = if i == 0 { "world".to_owned() } else { format!("l{}", i - 1) };
        writeln!(bodies, "  - {{name: l{i}, material: m, group: g, box: {{size: [{LINK}, 0.04, 0.04]}}, position: {middle:?}, rotate: {{axis: [0, 1, 0], angle: {angle}}}}}").unwrap();
        writeln!(
            joints,
            "  - {{name: j{i}, kind: revolute, a: {before}, b: l{i}, position: [{x}, 0, {z}], axis: [0, 1, 0]}}"
        )
        .unwrap();
        [x, z] = [x + LINK * cos, z - LINK * sin];
    }
    writeln!(
        bodies,
        "  - {{name: load, material: m, group: g, mass: 50, sphere: {{radius: 0.1}}, position: [{x}, 0, {z}]}}"
    )
    .unwrap();
    writeln!(joints, "  - {{name: end, kind: spherical, a: l9, b: load, position: [{x}, 0, {z}]}}").unwrap();
    bodies + &joints
}

/// Links of constant length turn though the bodies at their ends do not: a ball on a thread, by 0.1 and 0.5 rad a step; and a cart whose wheels carry
/// their axles at their centres goes on in whole steps.
#[test]
fn links_turn_and_wheels_do_not_bend() {
    for (kind, speed) in [("distance", 20.0), ("distance", 100.0), ("revolute_spherical", 100.0)] {
        let (_, seen) = watched(
            &format!(
                "gravity: [0, 0, 0]
step: 1e-3
{MATERIALS}bodies: [{{name: ball, material: m, group: g, sphere: {{radius: 0.05}}, position: [0.2, 0, 0], velocity: [0, {speed}, 0]}}]
joints: [{{name: thread, kind: {kind}, a: world, b: ball, position_b: [0.2, 0, 0], axis: [0, 0, 1]}}]
"
            ),
            1.0,
        );
        assert!(seen.gap < 1e-6 && seen.gained().abs() < 2e-3, "{kind} {speed}: {} m, {}", seen.gap, seen.gained());
    }
    let wheel = |x: f64, y: f64, k: usize| {
        let at = format!("position: [{x}, {y}, 0.05]");
        let body = format!("  - {{name: w{k}, material: m, group: g, sphere: {{radius: 0.05}}, {at}}}\n");
        (
            body,
            format!(
                "  - {{name: j{k}, kind: revolute, a: chassis, b: w{k}, {at}, axis: [0, 1, 0], motor: {{torque: 0.3}}}}\n"
            ),
        )
    };
    let wheels = [(0.15, 0.1, 0), (0.15, -0.1, 1), (-0.15, 0.1, 2), (-0.15, -0.1, 3)].map(|(x, y, k)| wheel(x, y, k));
    let mut sim = simulation(&format!(
        "step: 1e-3\n{MATERIALS}bodies:\n  - {{name: ground, material: m, plane: {{normal: [0, 0, 1]}}}}\n  - {{name: chassis, material: m, group: g, mass: 5, box: {{size: [0.4, 0.15, 0.06]}}, position: [0, 0, 0.08]}}\n{}joints:\n{}",
        wheels.iter().map(|(body, _)| &body[..]).collect::<String>(),
        wheels.iter().map(|(_, joint)| &joint[..]).collect::<String>()
    ));
    for _ in 0..1500 {
        let report = sim.step();
        assert!(report.parts == 1 && report.warnings.is_empty(), "{} s: {} parts", report.time, report.parts);
    }
    assert!(sim.state.velocity[1].x > 2.0, "{}", sim.state.velocity[1]);
}

/// What rests beside a crank that is too fast for the step presses with its weight all the same, and a run goes on from the middle with the same bits.
#[test]
fn steps_in_parts_have_the_forces_of_whole_ones() {
    let model = slider_crank("", 400.0, false).replacen(
        "bodies:",
        "bodies:\n  - {name: ground, material: m, plane: {normal: [0, 0, 1]}, position: [0, 0, -1]}\n  - {name: block, material: m, box: {size: [0.1, 0.1, 0.1]}, position: [0, 1, -0.95]}",
        1,
    );
    let mut sim = simulation(&model);
    let mut half = None;
    for step in 0..200 {
        if step == 100 {
            half = Some(Simulation::new(sim.model.clone(), sim.state.clone()));
        }
        let report = sim.step();
        assert!(report.parts > 1 && report.warnings.is_empty(), "{} parts, {:?}", report.parts, report.warnings);
        let weight: f64 = sim.state.contacts.impulse.iter().map(|impulse| impulse.z).sum::<f64>() / sim.model.step;
        assert!(step < 20 || (weight - 9.81).abs() < 1e-3, "{step}: {weight} N");
    }
    let mut half = half.unwrap();
    (100..200).for_each(|_| drop(half.step()));
    assert!(half.state.position == sim.state.position && half.state.velocity == sim.state.velocity);
    assert_eq!(half.state.contacts.impulse, sim.state.contacts.impulse);
    assert_eq!((sim.state.steps, sim.state.time), (200, 200.0 * sim.model.step));
}

#[test]
fn a_motor_too_fast_for_the_step_has_shorter_ones_or_is_said() {
    let driven = |settings: &str, speed: &str| chain(2, settings, &format!(", motor: {{speed: {speed}}}"));
    let step = |settings: &str, speed: &str| simulation(&driven(settings, speed)).model.step;
    for (settings, turn) in [("quality: draft\n", 0.5), ("quality: normal\n", 0.25), ("quality: tight\n", 0.125)] {
        let fast = step(settings, "500");
        assert!(fast <= turn / 500.0 && fast > 0.9 * turn / 500.0, "{settings}: {fast} s");
        assert_eq!(fast, step(settings, "{sine: {amplitude: 300, mean: -200, frequency: 3}}"), "{settings}");
        let (slow, mistaken) = (step(settings, "5"), step(settings, "1e6"));
        assert!(slow > fast && (0.95..1.05).contains(&(slow / 16.0 / mistaken)), "{settings}: {slow} s, {mistaken} s");
    }
    // Beyond what parts of a step resolve.
    let mut sim = simulation(&driven("", "2e4"));
    (0..200).for_each(|_| drop(sim.step()));
    let said = &sim.state.watch.warnings.iter().find(|w| w.first.kind == sim::watch::WarningKind::Joint).unwrap().first;
    assert!(said.message.contains("joint `j") && said.message.contains("in a step: take steps of"), "{}", said.message);
}

/// What a limit holds on a rail that turns gains nothing, also at steps in which it turns by a tenth of a radian.
#[test]
fn a_slider_at_its_limit_on_a_rail_that_turns_gains_nothing() {
    for step in [1e-3, 3e-3, 1e-2] {
        let (sim, seen) = watched(
            &format!(
                "gravity: [0, 0, 0]
step: {step}
{MATERIALS}bodies:
  - {{name: rail, material: m, group: g, box: {{size: [1, 0.05, 0.05]}}, angular_velocity: [0, 0, 10]}}
  - {{name: cart, material: m, group: g, box: {{size: [0.1, 0.1, 0.1]}}, position: [0.2, 0, 0], angular_velocity: [0, 0, 10], velocity: [0, 2, 0]}}
joints:
  - {{name: hub, kind: revolute, a: world, b: rail, axis: [0, 0, 1]}}
  - {{name: slide, kind: prismatic, a: rail, b: cart, position: [0.2, 0, 0], axis: [1, 0, 0], limits: [-0.1, 0.2]}}
"
            ),
            5.0,
        );
        // The cart slides to its limit and stays, with the angular momentum that both have: of moments about the hub.
        let rail = 2.5 * (1.0 + 0.0025) / 12.0;
        let of_cart = |at: f64| 0.01 / 6.0 + at * at;
        let [before, after] = [0.2, 0.4].map(|at| rail + of_cart(at));
        let energy = 0.5 * (before * 10.0f64).powi(2) / after;
        let at = sim.state.joints[1].coordinate;
        assert!((at - 0.2).abs() < 1e-3, "{step} s: {at} m");
        let now = sim.state.kinetic_energy(&sim.model);
        assert!((now / energy - 1.0).abs() < 2e-3, "{step} s: {now} J of {energy} J");
        assert!(seen.gap < 1e-6, "{step} s: {} m", seen.gap);
    }
}

/// Limbs of capsules on ball joints about a trunk, which fall on the ground.
#[test]
fn a_ragdoll_falls_without_a_warning() {
    let mut bodies = "  - {name: ground, material: m, plane: {normal: [0, 0, 1]}}
  - {name: trunk, material: m, group: g, capsule: {radius: 0.12, length: 0.6}, position: [0, 0, 1.5]}
  - {name: head, material: m, group: g, sphere: {radius: 0.1}, position: [0, 0, 1.92]}\n"
        .to_owned();
    let mut joints =
        "joints:\n  - {name: neck, kind: spherical, a: trunk, b: head, position: [0, 0, 1.81]}\n".to_owned();
    let limbs = [("arm", 0.17, 1.72, [0.3, 0.28], [0.04, 0.035]), ("leg", 0.08, 1.2, [0.42, 0.4], [0.06, 0.045])];
    for (side, sign) in [("left", 1.0), ("right", -1.0)] {
        for (limb, y, mut z, lengths, radii) in limbs {
            let mut before = "trunk".to_owned();
            for (part, (length, radius)) in ["upper", "lower"].into_iter().zip(lengths.into_iter().zip(radii)) {
                let (name, y) = (format!("{part}_{side}_{limb}"), y * sign);
                writeln!(bodies, "  - {{name: {name}, material: m, group: g, capsule: {{radius: {radius}, length: {length}}}, position: [0, {y}, {}]}}", z - 0.5 * length).unwrap();
                writeln!(
                    joints,
                    "  - {{name: of_{name}, kind: spherical, a: {before}, b: {name}, position: [0, {y}, {z}]}}"
                )
                .unwrap();
                (before, z) = (name, z - length);
            }
        }
    }
    for settings in OPEN {
        let (_, seen) = watched(&format!("{settings}{MATERIALS}bodies:\n{bodies}{joints}"), 4.0);
        assert!(seen.gap < 5e-6, "{settings}: {} m", seen.gap);
    }
}

/// Planks between two posts without any slack are stiff by their compliance alone, which no step resolves: their rows stay linear, and a ball that
/// falls on them gains nothing.
#[test]
fn a_bridge_without_slack_gains_nothing() {
    let mut bodies = format!(
        "{MATERIALS}bodies:\n  - {{name: ball, material: m, sphere: {{radius: 0.3}}, position: [3, 0, 2.4]}}\n"
    );
    let mut joints = "joints:\n".to_owned();
    for i in 0..20 {
        let x = 0.3 * f64::from(i);
        writeln!(
            bodies,
            "  - {{name: p{i}, material: m, group: g, box: {{size: [0.3, 1, 0.05]}}, position: [{}, 0, 2]}}",
            x + 0.15
        )
        .unwrap();
        let before = if i == 0 { "world".to_owned() } else { format!("p{}", i - 1) };
        for (side, y) in [("l", -0.4), ("r", 0.4)] {
            writeln!(
                joints,
                "  - {{name: j{i}{side}, kind: spherical, a: {before}, b: p{i}, position: [{x}, {y}, 2]}}"
            )
            .unwrap();
            if i == 19 {
                writeln!(joints, "  - {{name: end{side}, kind: spherical, a: world, b: p19, position: [6, {y}, 2]}}")
                    .unwrap();
            }
        }
    }
    let mut sim = simulation(&(bodies + &joints));
    let start = sim.state.potential_energy(&sim.model);
    for _ in 0..2000 {
        sim.step();
        let energy = sim.state.kinetic_energy(&sim.model) + sim.state.potential_energy(&sim.model);
        assert!(energy < start + 1.0, "{} s: {energy} J of {start} J", sim.state.time);
    }
}

/// Planks with little slack, on whose middle a box falls, turn by the angle that they hang through within a step: it is taken in parts, which make
/// good what a step has left in the time of a whole one. They gained megajoules.
#[test]
fn a_taut_bridge_gains_nothing_by_what_falls_on_it() {
    let mut parts = 0;
    for (settings, sag) in
        [("", 0.005), ("quality: normal\n", 0.005), ("quality: draft\n", 0.005), ("quality: draft\n", 0.02)]
    {
        let mut sim = simulation(&taut_bridge(settings, sag));
        let mut least = f64::INFINITY;
        while sim.state.time < 1.0 {
            let report = sim.step();
            assert!(report.warnings.is_empty(), "{settings}{sag}: {:?}", report.warnings);
            parts = parts.max(report.parts);
            let energy = sim.state.kinetic_energy(&sim.model) + sim.state.potential_energy(&sim.model);
            least = energy.min(least);
            // A quarter of the 117 J of the impact, within which energy is least.
            assert!(energy < least + 30.0, "{settings}{sag}, {} s: {energy} J after {least} J", sim.state.time);
        }
    }
    assert!(parts > 1, "in {parts} parts");
}

/// Ten planks over 2 m on a parabola, and a box of 62 kg 0.19 m over their middle.
fn taut_bridge(settings: &str, sag: f64) -> String {
    const N: usize = 10;
    let mut bodies = format!(
        "{settings}solver: {{friction: exact}}\n{MATERIALS}bodies:\n  - {{name: load, material: m, mass: 62, box: {{size: [0.2, 0.2, 0.2]}}, position: [1, 0, 1.3]}}\n"
    );
    let mut joints = "joints:\n".to_owned();
    let pin = |i: usize| {
        let x = 0.2 * i as f64;
        (x, 1.0 - 4.0 * sag * (x / 2.0) * (1.0 - x / 2.0))
    };
    for i in 0..N {
        let ((x, z), (x_end, z_end)) = (pin(i), pin(i + 1));
        let (length, angle) = ((x_end - x).hypot(z_end - z), -(z_end - z).atan2(x_end - x).to_degrees());
        let middle = [0.5 * (x + x_end), 0.0, 0.5 * (z + z_end)];
        writeln!(
            bodies,
            "  - {{name: p{i}, material: m, group: g, mass: 8.3, box: {{size: [{length}, 0.3, 0.02]}}, position: {middle:?}, rotate: {{axis: [0, 1, 0], angle: {angle}}}}}"
        )
        .unwrap();
        let before = if i == 0 { "world".to_owned() } else { format!("p{}", i - 1) };
        writeln!(
            joints,
            "  - {{name: j{i}, kind: revolute, a: {before}, b: p{i}, position: [{x}, 0, {z}], axis: [0, 1, 0]}}"
        )
        .unwrap();
    }
    let (x, z) = pin(N);
    bodies
        + &joints
        + &format!(
            "  - {{name: end, kind: revolute, a: world, b: p{}, position: [{x}, 0, {z}], axis: [0, 1, 0]}}\n",
            N - 1
        )
}

#[test]
fn what_a_joint_does_not_have_is_told() {
    let work = scratch();
    let path = work.path().join("m.yaml");
    let known = "expected one of l0, l1, world\n";
    for (from, to, says) in [
        ("b: l1", "b: l7", known),
        ("b: l0", "b: l0, motor: {force: 2}", "is for what slides"),
        ("kind: revolute, a: world", "kind: prismatic, motor: {torque: 2}, a: world", "is for what turns"),
    ] {
        let model = format!("duration: 1\nframe_rate: 10\n{}", chain(2, "", "")).replacen(from, to, 1);
        std::fs::write(&path, model).unwrap();
        let said = scree(&["check", path.to_str().unwrap()]).fails(3);
        assert!(said.contains(says), "{said}");
    }
}
