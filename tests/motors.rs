//! Motors with a maximum torque or force.

use crate::analytic::simulation;
use crate::cli::{scratch, scree};
use sim::Simulation;
use sim::watch::WarningKind;

const G: f64 = 9.81;

/// A flywheel of 0.3 kg m² on a shaft along z, with a motor.
fn flywheel(settings: &str, motor: &str) -> Simulation {
    simulation(&format!(
        "step: 1e-3
{settings}materials: {{m: {{density: 1000, friction: 0.5}}}}
bodies:
  - {{name: wheel, shapes: [], mass: 2, inertia: [0.1, 0.2, 0.3]}}
joints:
  - {{name: j, kind: revolute, a: world, b: wheel, motor: {{{motor}}}}}
"
    ))
}

/// A body of 2 kg on a slide along z, with a motor.
fn lift(motor: &str) -> Simulation {
    simulation(&format!(
        "step: 1e-3
materials: {{m: {{density: 1000, friction: 0.5}}}}
bodies:
  - {{name: body, shapes: [], mass: 2, inertia: [0.1, 0.2, 0.3]}}
joints:
  - {{name: j, kind: prismatic, a: world, b: body, motor: {{{motor}}}}}
"
    ))
}

#[test]
fn a_flywheel_comes_to_its_speed_at_a_constant_rate() {
    for settings in ["", "quality: normal\n", "solver: {method: gauss_seidel}\n", "solver: {method: jacobi}\n"] {
        let mut sim = flywheel(settings, "speed: 5, max_torque: 0.6");
        let (mut notes, mut warnings) = (vec![], vec![]);
        for k in 1..=4000 {
            let report = sim.step();
            notes.extend(report.note);
            warnings.extend(report.warnings);
            let (t, now) = (1e-3 * k as f64, sim.state.joints[0]);
            // 0.6 N m on 0.3 kg m²: it comes to 5 rad/s after 2.5 s.
            let expected = (2.0 * t).min(5.0);
            assert!((now.rate - expected).abs() < 1e-8, "{settings}{t} s: {} rad/s", now.rate);
            let torque = if k <= 2500 { -0.6 } else { 0.0 };
            // The row's compliance leaves a trace in the step after.
            assert!((now.torque_world.z - torque).abs() < 1e-5, "{settings}{t} s: {} N m", now.torque_world.z);
        }
        assert!(warnings.is_empty() && notes.is_empty(), "{warnings:?} {notes:?}");
    }
}

#[test]
fn a_lift_that_is_too_heavy_sinks_and_one_that_is_not_is_held() {
    // 2 kg by 15 N, which is less than their weight.
    let mut sim = lift("speed: 0, max_force: 15");
    for k in 1..=500 {
        assert!(sim.step().warnings.is_empty());
        let speed = sim.state.velocity[0].z;
        assert!((speed + (G - 15.0 / 2.0) * 1e-3 * k as f64).abs() < 1e-9, "{speed} m/s");
        assert!((sim.state.joints[0].force_world.z + 15.0).abs() < 1e-8);
    }
    let mut sim = lift("speed: 0, max_force: 20");
    (0..500).for_each(|_| assert!(sim.step().note.is_none()));
    assert!(sim.state.position[0].z.abs() < 1e-4, "{}", sim.state.position[0]);
    // The maximum may change: the brake is let go for a tenth of a second.
    let mut sim = lift("speed: 0, max_force: {table: [[0, 50], [0.1, 50], [0.1001, 0], [0.2, 0], [0.2001, 50]]}");
    (0..200).for_each(|_| drop(sim.step()));
    assert!((sim.state.velocity[0].z + 0.1 * G).abs() < 2e-2, "{}", sim.state.velocity[0]);
    (0..100).for_each(|_| drop(sim.step()));
    assert!(sim.state.velocity[0].z.abs() < 1e-5, "{}", sim.state.velocity[0]);
}

/// An arm that turns against a post.
fn against_a_post(settings: &str, motor: &str) -> Simulation {
    simulation(&format!(
        "step: 1e-3
gravity: [0, 0, 0]
{settings}
materials: {{m: {{density: 1000, friction: 0.3}}}}
bodies:
  - {{name: arm, material: m, box: {{size: [0.8, 0.1, 0.1]}}, position: [0.4, 0, 0]}}
  - {{name: post, material: m, fixed: true, sphere: {{radius: 0.1}}, position: [0.7, 0.4, 0]}}
joints:
  - {{name: j, kind: revolute, a: world, b: arm, motor: {{{motor}}}}}
"
    ))
}

#[test]
fn a_stalled_motor_presses_with_its_maximum() {
    for method in ["apgd", "gauss_seidel", "barzilai_borwein", "jacobi"] {
        for friction in ["relaxed", "exact"] {
            for motor in ["speed: 2, max_torque: 3", "motion: 1.2, max_torque: 3"] {
                let settings = format!("solver: {{method: {method}, friction: {friction}, tolerance: 1e-10}}");
                let mut sim = against_a_post(&settings, motor);
                for _ in 0..2000 {
                    let report = sim.step();
                    assert!(report.broken.is_none() && report.warnings.is_empty(), "{:?}", report.warnings);
                }
                let contacts = &sim.state.contacts;
                let at = |k: usize| sim.state.contact_point((contacts, k)).cross(contacts.impulse[k]).z / 1e-3;
                let moment: f64 = (0..contacts.len()).map(at).sum::<f64>().abs();
                let case = format!("{method} {friction} {motor}");
                assert!((moment - 3.0).abs() < 1e-4, "{case}: the post is pressed with {moment} N m");
                assert!((sim.state.joints[0].torque_world.z + 3.0).abs() < 1e-9, "{case}");
                assert!(sim.state.joints[0].violation < 1.3 && sim.state.joints[0].rate.abs() < 1e-5, "{case}");
            }
        }
    }
}

/// A servo that is held up for a while comes back to its path.
#[test]
fn a_servo_returns_to_its_path_without_a_jump() {
    let path = |t: f64| 0.5 - 0.5 * (std::f64::consts::TAU * 0.25 * t).cos();
    for (load, inertia) in [(0.0, 0.3), (1.2, 0.3), (-1.2, 0.3)] {
        let mut sim = simulation(&format!(
            "step: 1e-3
materials: {{m: {{density: 1000, friction: 0.5}}}}
bodies:
  - {{name: wheel, shapes: [], mass: 2, inertia: [0.1, 0.2, {inertia}]}}
joints:
  - {{name: j, kind: revolute, a: world, b: wheel, motor: {{motion: {{sine: {{amplitude: 0.5, frequency: 0.25, mean: 0.5, phase: -90}}}}, max_torque: 3}}}}
loads:
  - {{body: wheel, torque: [0, 0, 1], value: {load}}}
  - {{body: wheel, torque: [0, 0, 1], value: -6, from: 1, until: 1.4}}
"
        ));
        let (mut farthest, mut beyond, mut last) = (0.0f64, 0.0f64, 0.0f64);
        let mut back = f64::INFINITY;
        for k in 1..=4000 {
            assert!(sim.step().warnings.is_empty());
            let (t, now) = (1e-3 * k as f64, sim.state.joints[0]);
            // The torques that there are cannot change the rate by more in a step.
            assert!(
                (now.rate - last).abs() < 1e-3 * (3.0 + 7.2 + 0.1) / inertia,
                "{load} {t}: {} to {}",
                last,
                now.rate
            );
            last = now.rate;
            let off = now.coordinate - path(t);
            if t < 1.0 {
                assert!(off.abs() < 1e-4, "{load} {t}: off by {off} rad");
            }
            farthest = farthest.max(-off);
            if t > 1.6 {
                beyond = beyond.max(off);
            }
            if off.abs() > 1e-3 {
                back = t;
            }
        }
        assert!(farthest > 0.1, "{load}: it is pushed off by {farthest} rad");
        assert!(beyond < 0.05 * farthest && back < 3.8, "{load}: of {farthest} rad {beyond} beyond, back at {back} s");
        assert!(sim.state.joints[0].violation < 1e-5);
    }
}

/// A motor that begins far from where it shall be, on a light rotor that carries a heavy load by way of other joints.
#[test]
fn a_servo_swings_a_heavy_load_to_its_place() {
    let mut sim = simulation(
        "step: 1e-3
gravity: [0, 0, 0]
materials: {m: {density: 1000, friction: 0.5}}
bodies:
  - {name: rotor, shapes: [], mass: 1, inertia: [1e-3, 1e-3, 1e-3]}
  - {name: arm, shapes: [], mass: 1, inertia: [1e-3, 1e-3, 1e-3], position: [0.5, 0, 0]}
  - {name: load, shapes: [], mass: 20, inertia: [0.1, 0.1, 0.1], position: [1, 0, 0]}
joints:
  - {name: drive, kind: revolute, a: world, b: rotor, motor: {motion: 1, max_torque: 10}}
  - {name: root, kind: fixed, a: rotor, b: arm}
  - {name: end, kind: fixed, a: arm, b: load, position: [1, 0, 0]}
",
    );
    let (mut most, mut fastest) = (0.0f64, 0.0f64);
    for _ in 0..8000 {
        assert!(sim.step().broken.is_none());
        most = most.max(sim.state.joints[0].coordinate);
        fastest = fastest.max(sim.state.joints[0].rate);
        assert!(sim.state.joints[0].torque_world.z.abs() < 10.0 + 1e-6);
    }
    let now = sim.state.joints[0];
    assert!((now.coordinate - 1.0).abs() < 1e-6 && most < 1.001, "{} rad, at most {most}", now.coordinate);
    // It is sped up by all of the torque and stopped by half of it: v² = 2 a x with a of 10 N m over 20.352 kg m² until a third of the way.
    let expected = (2.0 * 10.0 / 20.352 / 3.0f64).sqrt();
    assert!((fastest - expected).abs() < 0.01, "{fastest} rad/s, expected {expected}");
}

/// A drill that stalls in its limits, and a bounded motor beside an unbounded one.
#[test]
fn a_motor_at_the_limit_of_its_joint_pulls_nothing_apart() {
    let mut sim = simulation(
        "step: 1e-3
materials: {m: {density: 1000, friction: 0.5}}
bodies:
  - {name: wheel, shapes: [], mass: 2, inertia: [0.1, 0.2, 0.3], position: [0.1, 0, 0]}
joints:
  - {name: j, kind: revolute, a: world, b: wheel, limits: [-20, 20], motor: {motion: {ramp: {times: [0, 1], values: [0, 1]}}, max_torque: 4}}
",
    );
    for _ in 0..1500 {
        assert!(sim.step().warnings.is_empty());
    }
    let now = sim.state.joints[0];
    assert!((now.coordinate.to_degrees() - 20.0).abs() < 1e-3, "{}", now.coordinate.to_degrees());
    // The limit takes what the motor gives.
    assert!(now.torque_world.z.abs() < 1e-4, "{}", now.torque_world);
    assert!((sim.state.position[0].length() - 0.1).abs() < 1e-6);
}

/// A motor without a maximum stops at the limits of its joint, which it would else pull apart, and is said to.
#[test]
fn a_motor_without_a_maximum_stops_at_the_limits_of_its_joint() {
    for (motor, says) in [
        (
            "motion: {ramp: {times: [0, 1], values: [0, 1]}}",
            "goes from 0.0000 to 1.0000 rad, beyond the joint's `limits`",
        ),
        ("speed: 1", ""),
        ("speed: -30", ""),
    ] {
        let model = format!(
            "step: 1e-3
duration: 1
frame_rate: 10
materials: {{m: {{density: 1000, friction: 0.5}}}}
bodies:
  - {{name: arm, material: m, box: {{size: [0.8, 0.1, 0.1]}}, position: [0.4, 0, 0]}}
joints:
  - {{name: j, kind: revolute, a: world, b: arm, limits: [-20, 20], motor: {{{motor}}}}}
"
        );
        let mut sim = simulation(&model);
        let mut gap = 0.0f64;
        for _ in 0..1000 {
            let report = sim.step();
            gap = gap.max((sim.state.position[0].length() - 0.4).abs());
            assert!(report.warnings.iter().all(|w| w.kind == WarningKind::Motor), "{:?}", report.warnings);
        }
        let now = sim.state.joints[0];
        assert!((now.coordinate.to_degrees().abs() - 20.0).abs() < 1e-3, "{motor}: {}", now.coordinate.to_degrees());
        // Its weight alone.
        assert!(gap < 1e-6 && now.torque_world.z.abs() < 1e-3, "{motor}: {gap} m, {}", now.torque_world);
        let first = &sim.state.watch.warnings[0].first;
        assert!(first.message.contains("limit of") && first.message.contains("`max_torque` would bound"), "{first:?}");
        let work = scratch();
        let path = work.path().join("m.yaml");
        std::fs::write(&path, model).unwrap();
        let said = scree(&["check", path.to_str().unwrap()]).errors();
        assert!(said.contains(says) && (says.is_empty() || said.contains(":8:")), "{said}");
    }
}

#[test]
fn a_resumed_run_has_the_same_bits() {
    let mut first = against_a_post("", "motion: {sine: {amplitude: 0.8, frequency: 2}}, max_torque: 3");
    (0..700).for_each(|_| drop(first.step()));
    let mut second = Simulation::new(first.model.clone(), first.state.clone());
    for _ in 0..300 {
        first.step();
        second.step();
    }
    assert_eq!(first.state.position, second.state.position);
    assert_eq!(first.state.joints, second.state.joints);
}

/// Motors that are as strong as they are asked to be are no fault: the run ends well, and says once of each that stands still or is driven back.
#[test]
fn motors_that_stall_are_noted_once_and_are_no_warnings() {
    let work = scratch();
    let (path, run) = (work.path().join("m.yaml"), work.path().join("run"));
    let model = "step: 1e-3
duration: 0.2
frame_rate: 10
on_divergence: stop
materials: {m: {density: 1000, friction: 0.5}}
bodies:
  - {name: wall, material: m, fixed: true, box: {size: [1, 1, 1]}, position: [1, 0, 0]}
  - {name: wheel, material: m, box: {size: [1, 1, 1]}, position: [5, 0, 0]}
  - {name: pusher, material: m, box: {size: [1, 1, 1]}}
  - {name: lift, material: m, box: {size: [1, 1, 1]}, position: [9, 0, 0]}
joints:
  - {name: spin, kind: revolute, a: world, b: wheel, position: [5, 0, 0], motor: {speed: 1, max_torque: 3}}
  - {name: push, kind: prismatic, a: world, b: pusher, axis: [1, 0, 0], motor: {speed: 1, max_force: 3}}
  - {name: raise, kind: prismatic, a: world, b: lift, position: [9, 0, 0], motor: {motion: 1, max_force: 3}}
";
    std::fs::write(&path, model).unwrap();
    let answer = scree(&["simulate", path.to_str().unwrap(), "-o", run.to_str().unwrap()]);
    answer.ok();
    let said = answer.errors();
    assert!(said.matches("note: step").count() == 2 && !said.contains("warning"), "{said}");
    let of = |joint: &str| said.lines().filter(|line| line.contains(joint)).count();
    assert!([of("`spin`"), of("`push`"), of("`raise`")] == [0, 1, 1], "{said}");
    assert!(said.contains("with its `max_force` of 3.000e0 N"), "{said}");
}

/// Servos of bodies on each other's joints that have fallen behind: each gives its maximum at most, whatever the others do.
#[test]
fn servos_of_an_arm_keep_to_their_maxima() {
    let arm = |n: usize, share: f64, goal: [f64; 3]| {
        let mut bodies = String::new();
        let mut joints = String::new();
        let mut most = vec![];
        for (i, goal) in goal.iter().enumerate().take(n) {
            let (x, beyond) = (0.5 * i as f64, (n - i) as f64);
            // What the arm asks for when it is stretched out level.
            most.push(share * 4.905 * beyond * beyond);
            let before = if i == 0 { "world".into() } else { format!("l{}", i - 1) };
            bodies += &format!(
                "  - {{name: l{i}, material: m, mass: 2, group: g, box: {{size: [0.5, 0.05, 0.05]}}, position: [{}, 0, 0]}}\n",
                x + 0.25
            );
            joints += &format!(
                "  - {{name: j{i}, kind: revolute, a: {before}, b: l{i}, position: [{x}, 0, 0], axis: [0, -1, 0], motor: {{motion: {{ramp: {{times: [0, 0.7], values: [0, {goal}]}}}}, max_torque: {}}}}}\n",
                most[i]
            );
        }
        let text = format!(
            "step: 1e-3\nduration: 2\nframe_rate: 10\nmaterials: {{m: {{density: 1000, friction: 0.5}}}}\npass_through: [[g, g]]\nbodies:\n{bodies}joints:\n{joints}"
        );
        (text, most)
    };
    for (n, share, goal) in [(2, 1.5, [0.8, -0.77, 0.0]), (3, 1.5, [0.5, -0.9, 0.7]), (3, 1.1, [-0.6, 0.9, -0.8])] {
        let (text, most) = arm(n, share, goal);
        let mut sim = simulation(&text);
        for step in 1..=2000 {
            let report = sim.step();
            assert!(report.warnings.is_empty(), "{n} links, step {step}: {:?}", report.warnings);
            for (joint, most) in sim.state.joints.iter().zip(&most) {
                let torque = joint.torque_world.y.abs();
                assert!(torque < most * (1.0 + 1e-6), "{n} links, step {step}: {torque} of {most} N m");
            }
        }
        let off = sim.state.joints.iter().zip(goal).map(|(now, goal)| (now.coordinate - goal).abs());
        let off = off.fold(0.0, f64::max);
        assert!(off < 1e-6, "{n} links: {off} rad off at the end");
    }
}

#[test]
fn what_bounds_no_motor_is_told() {
    let work = scratch();
    let path = work.path().join("m.yaml");
    for (joint, motor, says) in [
        ("revolute", "speed: 2, max_force: 3", "is for what slides"),
        ("prismatic", "speed: 2, max_torque: 3", "is for what turns"),
        ("revolute", "torque: 2, max_torque: 3", "is for motors by `speed` or `motion`"),
        ("prismatic", "force: 2, max_force: 3", "is for motors by `speed` or `motion`"),
        ("revolute", "speed: 2, max_torque: -3", "goes down to -3"),
        ("revolute", "speed: 2, max_torque: {sine: {amplitude: 3, frequency: 1, mean: 1}}", "goes down to -2"),
        ("revolute", "max_torque: 3", "needs exactly one of `speed`, `motion` and `torque`"),
    ] {
        let model = format!(
            "duration: 1
frame_rate: 10
materials: {{m: {{density: 1000, friction: 0.5}}}}
bodies:
  - {{name: body, material: m, box: {{size: [1, 1, 1]}}}}
joints:
  - {{name: j, kind: {joint}, a: world, b: body, motor: {{{motor}}}}}
"
        );
        std::fs::write(&path, model).unwrap();
        let said = scree(&["check", path.to_str().unwrap()]).fails(3);
        assert!(said.contains(says) && said.contains(":7:"), "{motor}: {said}");
    }
}

#[test]
fn a_motor_that_begins_at_the_end_of_a_step_lags_nowhere() {
    // Times that are whole steps but for rounding, to either side.
    for at in [0.1, 0.3, 0.7, 1.1, 1.3, 1.5] {
        let mut sim = flywheel("", &format!("speed: {{step: {{at: {at}, after: 1}}}}"));
        let warnings: Vec<_> = (0..1600).flat_map(|_| sim.step().warnings).collect();
        assert!(warnings.is_empty(), "at {at} s: {warnings:?}");
        assert!((sim.state.joints[0].rate - 1.0).abs() < 1e-8);
    }
}

#[test]
fn a_length_never_goes_below_zero() {
    let model = |length: &str| {
        format!(
            "materials: {{m: {{density: 1000, friction: 0.5}}}}
bodies:
  - {{name: ball, material: m, sphere: {{radius: 0.1}}, position: [0, 0, 1]}}
joints:
  - {{name: rod, kind: distance, a: world, b: ball, position: [0, 0, 2], position_b: [0, 0, 1], until: 0.5, length: {length}}}
"
        )
    };
    let work = scratch();
    let path = work.path().join("m.yaml");
    let said = |length: &str| {
        std::fs::write(&path, model(length)).unwrap();
        scree(&["check", path.to_str().unwrap()]).errors()
    };
    let below = said("{ramp: {times: [0, 1], values: [1, -1.2]}}");
    assert!(below.contains("m.yaml:5:") && below.contains("comes down to -0.1000 m"), "{below}");
    // Below zero once the joint no longer acts.
    let later = said("{ramp: {times: [0, 1], values: [1, -0.5]}}");
    assert!(later.is_empty(), "{later}");
}
