//! Joints, motors, limits, springs and loads against answers known on paper, and against curves of ADAMS where they lie beside the
//! tree.

use crate::analytic::{close, run, simulation};
use glam::{DQuat, DVec3};
use std::path::Path;

/// A pendulum: 1 kg, inertia (0.04, 0.1, 0.1) kg m², its centre 2 m from a hinge about y, let go level.
fn pendulum(step: f64) -> sim::Simulation {
    simulation(&format!(
        "gravity: [0, 0, -9.80665]
step: {step}
materials: {{m: {{density: 1000, friction: 0.5}}}}
bodies:
  - name: bob
    shapes: []
    mass: 1
    inertia: [0.04, 0.1, 0.1]
    position: [2, 0, 0]
    orientation: [0.7071067811865476, -0.7071067811865476, 0, 0]
joints:
  - {{name: hinge, kind: revolute, a: world, b: bob, position: [0, 0, 0], axis: [0, 1, 0], axis_x: [1, 0, 0]}}
"
    ))
}

/// Compared quantities of the pendulum, and the tolerances of their root mean square errors: place, velocity, orientation (w, x, y, z),
/// force and torque of the joint on the world.
const COMPARED: [(&str, f64); 5] = [("Pos", 1e-3), ("Vel", 1e-2), ("Quat", 1e-3), ("Rforce", 2e-2), ("Rtorque", 1e-2)];

/// The pendulum against rows of what is compared, each with its time.
fn follows(rows: &[(f64, [Vec<f64>; 5])]) {
    let mut sim = pendulum(5e-4);
    let mut sums = [[0.0f64; 4]; 5];
    let mut violation = 0.0f64;
    for (time, expected) in rows {
        run(&mut sim, *time);
        let (s, j) = (&sim.state, &sim.state.joints[0]);
        // The body's frame is the principal one; the joint's x, y, z are the world's x, −z, y.
        let q = s.orientation[0];
        let world = |v: DVec3| vec![v.x, v.z, -v.y];
        // Before the first step a joint has no force.
        let force = if *time == 0.0 { expected[3].clone() } else { world(j.force) };
        let mine = [
            s.position[0].to_array().to_vec(),
            s.velocity[0].to_array().to_vec(),
            vec![q.w, q.x, q.y, q.z],
            force,
            world(j.torque),
        ];
        for (sums, (mine, expected)) in sums.iter_mut().zip(mine.iter().zip(expected)) {
            for (sum, (x, y)) in sums.iter_mut().zip(mine.iter().zip(expected)) {
                *sum += (x - y).powi(2) / rows.len() as f64;
            }
        }
        violation += j.violation.powi(2) / rows.len() as f64;
    }
    for ((name, tolerance), sums) in COMPARED.iter().zip(sums) {
        let off = sums.iter().fold(0.0, |max: f64, sum| max.max(sum.sqrt()));
        assert!(off < *tolerance, "{name}: {off} RMS");
    }
    assert!(violation.sqrt() < 1e-5, "constraint: {} RMS", violation.sqrt());
}

/// The curves of ADAMS, where they lie beside the tree.
fn curves_of_adams() -> Option<Vec<(f64, [Vec<f64>; 5])>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/joints");
    let mut rows: Vec<(f64, [Vec<f64>; 5])> = vec![];
    for (k, (name, _)) in COMPARED.iter().enumerate() {
        let text = std::fs::read_to_string(folder.join(format!("Revolute_Case01_ADAMS_{name}.txt"))).ok()?;
        let row = |l: &str| l.split_whitespace().map(|c| c.parse().ok()).collect::<Option<Vec<f64>>>();
        for (i, row) in text.lines().skip(3).filter_map(row).enumerate() {
            if k == 0 {
                rows.push((row[0], Default::default()));
            }
            rows[i].1[k] = row[1..].to_vec();
        }
    }
    Some(rows)
}

#[test]
fn the_revolute_pendulum_follows_adams() {
    match curves_of_adams() {
        Some(rows) => follows(&rows),
        None => eprintln!("skipped: the curves of ADAMS are not beside the tree"),
    }
}

/// Jacobi's elliptic functions sn, cn, dn of modulus k, by the arithmetic-geometric mean (Abramowitz & Stegun, 16.4).
fn elliptic(u: f64, k: f64) -> [f64; 3] {
    let (mut a, mut b, mut c) = (1.0, (1.0 - k * k).sqrt(), k);
    let mut ratios = vec![];
    let mut phase = u;
    while c > 1e-16 {
        (a, b, c) = (0.5 * (a + b), (a * b).sqrt(), 0.5 * (a - b));
        ratios.push(c / a);
        phase *= 2.0;
    }
    phase *= a;
    for ratio in ratios.iter().rev() {
        phase = 0.5 * (phase + (ratio * phase.sin()).asin());
    }
    let (sn, cn) = phase.sin_cos();
    [sn, cn, (1.0 - k * k * sn * sn).sqrt()]
}

#[test]
fn elliptic_functions_are_those_of_the_table() {
    // At k² = ½ and half of K = 1.8540746773: sn² = 1/(1 + k′), cn² = k′/(1 + k′), dn² = k′; and at k = 0 those of the circle.
    let k = 0.5f64.sqrt();
    let expected = [1.0 / (1.0 + k), k / (1.0 + k), k].map(f64::sqrt);
    for (found, expected) in elliptic(0.927_037_338_650_686, k).into_iter().zip(expected) {
        close(found, expected, 1e-12, "half of a quarter period");
    }
    close(elliptic(0.7, 0.0)[0], 0.7f64.sin(), 1e-14, "sine");
    close(elliptic(3.0 * 1.854_074_677_301_372, k)[0], -1.0, 1e-12, "three quarters of a period");
}

#[test]
fn the_revolute_pendulum_follows_its_equation() {
    // φ from hanging straight down, let go at 90°: sin(φ/2) = k cd(ω₀ t, k) with k = sin 45° and ω₀² = m g L / I about the hinge.
    let (length, inertia, gravity): (f64, f64, f64) = (2.0, 0.1 + 4.0, 9.80665);
    let omega = (gravity * length / inertia).sqrt();
    let k = 0.5f64.sqrt();
    let rows = (0..=500).map(|i| {
        let time = 0.01 * i as f64;
        let [sn, cn, dn] = elliptic(omega * time, k);
        let angle = 2.0 * (k * cn / dn).asin();
        let rate = -2.0 * k * k * omega * sn / dn;
        let (s, c) = angle.sin_cos();
        let position = DVec3::new(s, 0.0, -c) * length;
        let velocity = DVec3::new(c, 0.0, s) * length * rate;
        let acceleration = DVec3::new(c, 0.0, s) * length * -omega * omega * s - position * rate * rate;
        // The body has turned about y since it lay along x.
        let turned = DQuat::from_rotation_y(std::f64::consts::FRAC_PI_2 - angle);
        let q = turned * DQuat::from_xyzw(-(0.5f64.sqrt()), 0.0, 0.0, 0.5f64.sqrt());
        let force = DVec3::new(0.0, 0.0, -gravity) - acceleration;
        let vectors = [position, velocity, force, DVec3::ZERO].map(|v| v.to_array().to_vec());
        let [position, velocity, force, torque] = vectors;
        (time, [position, velocity, vec![q.w, q.x, q.y, q.z], force, torque])
    });
    follows(&rows.collect::<Vec<_>>());
}

#[test]
fn the_pendulum_keeps_its_energy() {
    let mut sim = pendulum(5e-4);
    let energy = |s: &sim::Simulation| s.state.kinetic_energy(&s.model) + s.state.potential_energy(&s.model);
    run(&mut sim, 5.0);
    // Of some 20 J that go to and fro.
    assert!(energy(&sim).abs() < 0.05, "{} J", energy(&sim));
}

/// A body of 2 kg on a joint to the world at the origin; gravity along −z.
fn on_joint(joint: &str, extra: &str) -> sim::Simulation {
    simulation(&format!(
        "step: 1e-3
materials: {{m: {{density: 1000, friction: 0.5}}}}
bodies:
  - {{name: body, shapes: [], mass: 2, inertia: [0.1, 0.2, 0.3], position: [0, 0, 0]}}
joints:
  - {{name: j, a: world, b: body, {joint}}}
{extra}"
    ))
}

#[test]
fn joints_carry_weight_and_let_go_what_they_leave_free() {
    // kind, then whether x, y, z of the body's place stay.
    for (joint, stays) in [
        ("kind: spherical", [true; 3]),
        ("kind: fixed", [true; 3]),
        ("kind: revolute", [true; 3]),
        ("kind: universal", [true; 3]),
        ("kind: prismatic", [true, true, false]),
        ("kind: cylindrical", [true, true, false]),
        ("kind: prismatic, axis: [1, 0, 0]", [true, true, true]),
        ("kind: point_on_plane", [true; 3]),
        ("kind: point_on_plane, axis: [1, 0, 0]", [true, true, false]),
        ("kind: distance, position: [0, 0, 1], position_b: [0, 0, 0]", [true; 3]),
        ("kind: revolute_spherical, position: [0, 0, 1], position_b: [0, 0, 0], axis: [1, 0, 0]", [true; 3]),
    ] {
        let mut sim = on_joint(joint, "");
        run(&mut sim, 0.5);
        let p = sim.state.position[0];
        for k in 0..3 {
            let fallen = 0.5 * 9.81 * 0.25;
            if stays[k] {
                assert!(p[k].abs() < 1e-5, "{joint}: {p}");
            } else {
                assert!((p[k] + fallen).abs() < 5e-3, "{joint}: {p}");
            }
        }
        // The weight is carried by the joint if z stays; the reaction is on the world.
        let j = &sim.model.joints[0];
        let force = sim.state.joints[0].force;
        let world = j.frame_a.orientation * force;
        let expected = if stays[2] { -2.0 * 9.81 } else { 0.0 };
        assert!((world.z - expected).abs() < 1e-3, "{joint}: {world}");
    }
}

#[test]
fn the_rate_before_any_step_is_that_of_the_state() {
    let at_start = |kind: &str, motion: &str| {
        let sim = simulation(&format!(
            "materials: {{m: {{density: 1000, friction: 0.5}}}}
bodies:
  - {{name: body, shapes: [], mass: 2, inertia: [0.1, 0.2, 0.3], position: [0, 0, 0], {motion}}}
joints:
  - {{name: j, a: world, b: body, {kind}}}
"
        ));
        let now = sim.state.joints[0];
        assert!(now.force == glam::DVec3::ZERO && now.violation < 1e-12, "{kind}: {now:?}");
        now.rate
    };
    close(at_start("kind: revolute", "angular_velocity: [0, 0, 3]"), 3.0, 1e-12, "a hinge");
    close(at_start("kind: prismatic", "velocity: [0, 0, -0.5]"), -0.5, 1e-12, "a slide");
    let rod = "kind: distance, position: [0, 0, 1], position_b: [0, 0, 0], limits: [0, 2]";
    close(at_start(rod, "velocity: [0, 0, -0.5]"), 0.5, 1e-12, "a rope");
}

#[test]
fn motors_springs_and_limits_do_what_they_say() {
    // A speed of 3 rad/s about z.
    let mut sim = on_joint("kind: revolute, motor: {speed: {ramp: {times: [0, 0.2], values: [0, 3]}}}", "");
    run(&mut sim, 1.0);
    close(sim.state.joints[0].rate, 3.0, 1e-6, "speed");
    close(sim.state.joints[0].coordinate, 3.0 * 0.9, 2e-3, "angle, more than half a turn");
    // An angle over time, a torque against inertia.
    let mut sim = on_joint("kind: revolute, motor: {motion: {sine: {amplitude: 0.5, frequency: 1}}}", "");
    run(&mut sim, 0.25);
    close(sim.state.joints[0].coordinate, 0.5, 1e-3, "angle");
    let mut sim = on_joint("kind: revolute, motor: {torque: 0.6}", "");
    run(&mut sim, 1.0);
    close(sim.state.joints[0].rate, 2.0, 1e-4, "0.6 N m on 0.3 kg m² for 1 s");
    // Limits: the body falls 0.1 m along its slide and stays there.
    let mut sim = on_joint("kind: prismatic, limits: [-0.1, 0.1]", "");
    run(&mut sim, 1.0);
    close(sim.state.position[0].z, -0.1, 1e-3, "the lower end");
    let mut sim = on_joint("kind: revolute, limits: [-30, 45], motor: {torque: 0.6}", "");
    run(&mut sim, 2.0);
    close(sim.state.joints[0].coordinate.to_degrees(), 45.0, 1e-3, "the upper stop");
    // The joint's reaction has that of its limit.
    for (kind, force, torque) in [
        ("prismatic, limits: [-0.1, 0.1]", -2.0 * 9.81, 0.0),
        ("prismatic, limits: [0, 0]", -2.0 * 9.81, 0.0),
        ("revolute, limits: [-30, 45], motor: {torque: 0.6}", -2.0 * 9.81, 0.0),
        ("revolute, limits: [0, 0], motor: {torque: 0.6}", -2.0 * 9.81, 0.0),
    ] {
        let mut sim = on_joint(&format!("kind: {kind}"), "");
        run(&mut sim, 2.0);
        let now = sim.state.joints[0];
        close(now.force_world.z, force, 1e-3, kind);
        assert!((now.torque_world.z - torque).abs() < 1e-6, "{kind}: {}", now.torque_world);
    }
    // A linear actuator.
    let mut sim = on_joint(
        "kind: distance, position: [0, 0, 1], position_b: [0, 0, 0], length: {ramp: {times: [0, 1], values: [1, 0.6]}}",
        "",
    );
    run(&mut sim, 1.0);
    close(sim.state.position[0].z, 0.4, 1e-3, "lifted by 0.4 m");
}

#[test]
fn springs_swing_with_their_frequency_and_hold_their_load() {
    let spring = |more: &str| {
        simulation(&format!(
            "step: 5e-4
materials: {{m: {{density: 1000, friction: 0.5}}}}
bodies:
  - {{name: body, shapes: [], mass: 2, inertia: [0.1, 0.2, 0.3], position: [0, 0, 0]}}
springs:
  - {{name: s, a: world, b: body, position: [0, 0, 1], position_b: [0, 0, 0], {more}}}
"
        ))
    };
    // Free: swings about its equilibrium m g/k below, with amplitude m g/k.
    let mut sim = spring("stiffness: 200");
    let period = std::f64::consts::TAU * (2.0f64 / 200.0).sqrt();
    run(&mut sim, 4.5 * period);
    close(sim.state.position[0].z, -2.0 * 2.0 * 9.81 / 200.0, 5e-3, "lowest after nine half periods");
    // Damped: comes to rest there; preloaded: is lifted by preload/k.
    let mut sim = spring("stiffness: 200, damping: 30");
    run(&mut sim, 5.0);
    close(sim.state.position[0].z, -2.0 * 9.81 / 200.0, 1e-3, "at rest");
    close(sim.state.springs[0].force, 2.0 * 9.81, 1e-3, "the spring carries the weight");
    let mut sim = spring("stiffness: 200, damping: 30, preload: 19.62");
    run(&mut sim, 5.0);
    assert!(sim.state.position[0].z.abs() < 1e-4);
    // So stiff that the step cannot follow: still at rest, not blown up.
    let mut sim = spring("stiffness: 1.0e9, damping: 10");
    run(&mut sim, 1.0);
    assert!(sim.state.position[0].z.abs() < 1e-5 && sim.state.velocity[0].length() < 1e-3);
}

#[test]
fn loads_push_in_the_world_or_with_the_body() {
    let pushed = |load: &str| {
        let mut sim = simulation(&format!(
            "gravity: [0, 0, 0]
step: 1e-3
materials: {{m: {{density: 1000, friction: 0.5}}}}
bodies:
  - {{name: b, shapes: [], mass: 2, inertia: [0.5, 0.5, 0.5], orientation: [0.7071067811865476, 0, 0, 0.7071067811865476]}}
loads:
  - {{body: b, {load}}}
"
        ));
        run(&mut sim, 1.0);
        (sim.state.velocity[0], sim.state.orientation[0] * sim.state.angular_velocity[0])
    };
    let near = |a: DVec3, b: [f64; 3]| assert!((a - DVec3::from(b)).length() < 2e-3, "{a}");
    near(pushed("force: [1, 0, 0], value: 4").0, [2.0, 0.0, 0.0]);
    near(pushed("force: [1, 0, 0], value: 4, frame: body").0, [0.0, 2.0, 0.0]);
    near(pushed("force: [1, 0, 0], value: 4, from: 0.5").0, [1.0, 0.0, 0.0]);
    near(pushed("force: [1, 0, 0], value: {ramp: {times: [0, 1], values: [0, 4]}}").0, [1.0, 0.0, 0.0]);
    near(pushed("force: [1, 0, 0], value: {table: [[0, 0], [0.5, 4], [1, 0]]}").0, [1.0, 0.0, 0.0]);
    near(pushed("torque: [0, 0, 1], value: 1").1, [0.0, 0.0, 2.0]);
    // At a point of the body's frame, which lies along the world's y: a force along x turns it back about z.
    near(pushed("force: [0, 0, 1], value: 0.1, point: [1, 0, 0]").1, [0.2, 0.0, 0.0]);
}

#[test]
fn a_heavy_load_on_a_light_chain_costs_no_iterations() {
    // 60 links of 0.1 kg carry 500 kg: eliminated, the joints hold it to a hair in one pass.
    let mut yaml = String::from(
        "step: 1e-3
solver: {iterations: 5}
materials: {m: {density: 1000, friction: 0.5}}
bodies:
",
    );
    let mut joints = String::from("joints:\n");
    for k in 0..60 {
        let x = 0.05 + 0.1 * k as f64;
        yaml += &format!(
            "  - {{name: link{k}, shapes: [], mass: 0.1, inertia: [1e-4, 1e-4, 1e-4], position: [0, 0, {}]}}\n",
            -x
        );
        let before = if k == 0 { "world".to_string() } else { format!("link{}", k - 1) };
        joints += &format!(
            "  - {{name: pin{k}, kind: revolute, a: {before}, b: link{k}, position: [0, 0, {}], axis: [0, 1, 0]}}\n",
            -0.1 * k as f64
        );
    }
    yaml += "  - {name: load, shapes: [], mass: 500, inertia: [1, 1, 1], position: [0, 0, -6.2]}\n";
    joints += "  - {name: hook, kind: spherical, a: link59, b: load, position: [0, 0, -6]}\n";
    let mut sim = simulation(&(yaml + &joints));
    run(&mut sim, 1.0);
    let z = sim.state.position[60].z;
    assert!((z + 6.2).abs() < 1e-4, "the load hangs at {z}");
    let force = sim.model.joints[0].frame_a.orientation * sim.state.joints[0].force;
    close(force.z, -506.0 * 9.81, 1e-3, "the first pin carries all");
}

#[test]
fn a_joint_carries_the_same_whatever_the_method() {
    // A sphere pinned in mid-air, and one that rests on the ground: the contact's impulses are found by every method.
    let sphere = 2600.0 * 4.0 / 3.0 * std::f64::consts::PI * 0.1f64.powi(3);
    for method in sim::Method::ALL {
        let mut sim = simulation(&format!(
            "step: 1e-3
solver: {{method: {}}}
materials: {{stone: {{density: 2600, friction: 0.5}}}}
bodies:
  - {{name: ground, material: stone, plane: {{normal: [0, 0, 1]}}}}
  - {{name: low, material: stone, sphere: {{radius: 0.1}}, position: [0, 0, 0.1]}}
  - {{name: pinned, material: stone, sphere: {{radius: 0.1}}, position: [0.5, 0, 0.5]}}
joints:
  - {{name: pin, kind: spherical, a: world, b: pinned, position: [0.5, 0, 0.5]}}
",
            method.name()
        ));
        run(&mut sim, 0.05);
        let force = sim.state.joints[0].force.length();
        close(force, sphere * 9.81, 1e-6, method.name());
    }
}

/// Two bobs of 1 kg with 0.01 kg m² about y, the second hinged at the centre of the first, each 1 m from its hinge; let go level.
fn double_pendulum(step: f64) -> sim::Simulation {
    simulation(&format!(
        "step: {step}
materials: {{m: {{density: 1000, friction: 0.5}}}}
bodies:
  - {{name: upper, shapes: [], mass: 1, inertia: [0.01, 0.01, 0.01], position: [1, 0, 0]}}
  - {{name: lower, shapes: [], mass: 1, inertia: [0.01, 0.01, 0.01], position: [2, 0, 0]}}
joints:
  - {{name: shoulder, kind: revolute, a: world, b: upper, position: [0, 0, 0], axis: [0, 1, 0]}}
  - {{name: elbow, kind: revolute, a: upper, b: lower, position: [1, 0, 0], axis: [0, 1, 0]}}
"
    ))
}

/// Angles from the vertical, rad, and their rates, of that pendulum: one step of the classical Runge–Kutta method.
fn runge_kutta(y: [f64; 4], h: f64) -> [f64; 4] {
    let rates = |[a, b, u, v]: [f64; 4]| {
        let ((s, c), g) = ((a - b).sin_cos(), 9.81);
        // [2.01, c; c, 1.01] (u', v') = r.
        let r = [-s * v * v - 2.0 * g * a.sin(), s * u * u - g * b.sin()];
        let det = 2.01 * 1.01 - c * c;
        [u, v, (1.01 * r[0] - c * r[1]) / det, (2.01 * r[1] - c * r[0]) / det]
    };
    let add = |y: [f64; 4], k: [f64; 4], h: f64| [0, 1, 2, 3].map(|i| y[i] + h * k[i]);
    let k1 = rates(y);
    let k2 = rates(add(y, k1, 0.5 * h));
    let k3 = rates(add(y, k2, 0.5 * h));
    let k4 = rates(add(y, k3, h));
    [0, 1, 2, 3].map(|i| y[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]))
}

#[test]
fn the_double_pendulum_is_half_a_step_ahead_of_its_equation() {
    // A velocity acts over the whole step at whose end it is found, so that it is that of the step's middle: the motion from rest is half a
    // step ahead, and of second order from there.
    let mut off = vec![];
    for h in [2e-3, 1e-3] {
        let mut sim = double_pendulum(h);
        let mut y = [std::f64::consts::FRAC_PI_2, std::f64::consts::FRAC_PI_2, 0.0, 0.0];
        (0..5).for_each(|_| y = runge_kutta(y, 0.1 * h));
        let mut worst = 0f64;
        for _ in 0..(3.0 / h) as usize {
            sim.step();
            (0..10).for_each(|_| y = runge_kutta(y, 0.1 * h));
            let arm = |angle: f64| DVec3::new(angle.sin(), 0.0, -angle.cos());
            let places = [arm(y[0]), arm(y[0]) + arm(y[1])];
            worst = (0..2).map(|b| sim.state.position[b].distance(places[b])).fold(worst, f64::max);
        }
        off.push(worst);
    }
    assert!(off[1] < 2e-4, "{off:?} m at 1 ms");
    assert!(off[0] / off[1] > 3.5, "{off:?} m at 2 and 1 ms");
}

#[test]
fn a_bent_shaft_turns_as_its_cross_does_in_any_phase() {
    let (bend, speed) = (0.6f64, 10.0);
    for phase in [0.0f64, 0.7, 1.3, 2.5] {
        let (b, pin) = ([bend.cos(), 0.0, bend.sin()], [0.0, phase.cos(), phase.sin()]);
        let mut sim = simulation(&format!(
            "gravity: [0, 0, 0]
step: 2e-4
materials: {{m: {{density: 1000, friction: 0.5}}}}
bodies:
  - {{name: driving, shapes: [], mass: 1, inertia: [0.01, 0.02, 0.02], position: [-1, 0, 0], angular_velocity: [{speed}, 0, 0]}}
  - {{name: driven, shapes: [], mass: 1, inertia: [0.01, 0.01, 0.01], position: {b:?}}}
joints:
  - {{name: motor, kind: revolute, a: world, b: driving, position: [-1, 0, 0], axis: [1, 0, 0], motor: {{speed: {speed}}}}}
  - {{name: bearing, kind: revolute, a: world, b: driven, position: {b:?}, axis: {b:?}}}
  - {{name: cross, kind: universal, a: driving, b: driven, axis: [1, 0, 0], axis_x: {pin:?}, axis_b: {b:?}}}
"
        ));
        for _ in 0..3142 {
            // The rate is that of the step, the angle that of its start. θ is the pin's from the normal of the plane of the shafts.
            let theta = phase + sim.state.joints[0].coordinate;
            sim.step();
            let ratio = bend.cos() / (1.0 - (bend.sin() * theta.sin()).powi(2));
            let rate = sim.state.joints[1].rate;
            assert!((rate - ratio * speed).abs() < 0.02 * speed, "phase {phase}: {rate} rad/s at {theta}");
            assert!(sim.state.joints[2].violation < 1e-5, "phase {phase}");
        }
        close(sim.state.joints[1].coordinate, std::f64::consts::TAU, 2e-3, "a whole turn");
    }
}

#[test]
fn a_spring_of_no_length_holds_two_points_together() {
    // 2 kg on 200 N/m hang 98.1 mm below; pulled aside, they swing there with the same frequency in all directions, and damped to rest.
    let bushing = |more: &str| {
        simulation(&format!(
            "step: 1e-3
materials: {{m: {{density: 1000, friction: 0.5}}}}
bodies:
  - {{name: body, shapes: [], mass: 2, inertia: [0.1, 0.2, 0.3], velocity: [0.3, 0, 0]}}
springs:
  - {{name: bushing, a: world, b: body, rest: 0, {more}}}
"
        ))
    };
    let mut sim = bushing("stiffness: 200");
    // A quarter of a period: x has its amplitude v/ω, z is halfway.
    run(&mut sim, 0.25 * std::f64::consts::TAU / 10.0);
    let p = sim.state.position[0];
    assert!((p - DVec3::new(0.03, 0.0, -0.0981)).length() < 2e-3, "{p}");
    for (more, below) in [("stiffness: 200, damping: 40", 0.0981), ("stiffness: 2e8, damping: 1e4", 9.81e-8)] {
        let mut sim = bushing(more);
        run(&mut sim, 3.0);
        let (p, spring) = (sim.state.position[0], sim.state.springs[0]);
        assert!((p - DVec3::new(0.0, 0.0, -below)).length() < 1e-3 * below + 1e-12, "{more}: {p}");
        close(spring.force, 19.62, 1e-3, "force");
        close(spring.coordinate, below, 1e-3, "length");
    }
}

/// Bodies of a joint that begins or ends touch each other while it does not act, on from a checkpoint too.
#[test]
fn bodies_touch_while_their_joint_does_not_act() {
    let model = |joint: &str| {
        simulation(&format!(
            "quality: normal
materials: {{m: {{density: 1000, friction: 0.5}}}}
bodies:
  - {{name: ground, material: m, plane: {{normal: [0, 0, 1]}}}}
  - {{name: a, material: m, box: {{size: [0.2, 0.2, 0.2]}}, position: [0, 0, 0.1]}}
  - {{name: b, material: m, box: {{size: [0.2, 0.2, 0.2]}}, position: [0, 0, 0.3]}}
  - {{name: c, material: m, box: {{size: [0.2, 0.2, 0.2]}}, position: [0, 0, 0.5]}}
joints: [{{name: j, kind: fixed, a: a, b: b, position: [0, 0, 0.2], {joint}}}]
"
        ))
    };
    for joint in ["from: 0.2", "until: 0.2", "from: 0.1, until: 0.3"] {
        let mut sim = model(joint);
        let mut other = None;
        while sim.state.time < 0.6 {
            let report = sim.step();
            assert!(report.warnings.is_empty(), "{joint}: {:?}", report.warnings);
            if sim.state.steps == 20 {
                other = Some(sim::Simulation::new(model(joint).model, sim.state.clone()));
            }
        }
        let heights: Vec<f64> = sim.state.position[1..].iter().map(|p| p.z).collect();
        assert!(heights.iter().zip([0.1, 0.3, 0.5]).all(|(z, at)| (z - at).abs() < 1e-4), "{joint}: {heights:?}");
        let mut other = other.expect("a run that goes on");
        while other.state.steps < sim.state.steps {
            other.step();
        }
        assert_eq!(other.state.position, sim.state.position, "{joint}");
    }
}
