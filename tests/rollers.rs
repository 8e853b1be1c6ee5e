//! Round bodies that roll, that lie along each other and that lie across each other take no energy from nowhere.

use crate::analytic::simulation;
use sim::Simulation;

const HEAD: &str = "quality: normal\nmaterials: {m: {density: 1000, friction: 0.5}}\nbodies:\n";

/// Bodies that roll along x on the plane z = 0, with the turn about their own axis that goes with it, and their moment of inertia over m r².
const ROLLERS: [(&str, &str, f64); 3] = [
    ("cylinder: {radius: 0.1, length: 0.4}, rotate: {axis: [1, 0, 0], angle: 90}", "[0, 0, -1]", 0.5),
    // Of 4/3 of the radius for its ends and four radii for the rest.
    ("capsule: {radius: 0.1, length: 0.4}, rotate: {axis: [1, 0, 0], angle: 90}", "[0, 0, -1]", 0.475),
    ("ellipsoid: {radii: [0.1, 0.1, 0.1]}", "[0, 1, 0]", 0.4),
];

fn run(sim: &mut Simulation, until: f64) {
    while sim.state.time < until - 1e-9 {
        let report = sim.step();
        assert!(report.warnings.is_empty(), "{:?}", report.warnings);
    }
}

/// What bodies roll on: a box, and the upper edges of two boxes, along which they roll.
fn floors() -> [(&'static str, String); 2] {
    let rail = |y: f64| {
        let z = -0.1 * 2f64.sqrt();
        format!(
            "  - {{name: rail{y}, material: m, box: {{size: [10, 0.2, 0.2]}}, position: [0, {y}, {z}], rotate: {{axis: [1, 0, 0], angle: 45}}, fixed: true}}\n"
        )
    };
    let floor = "  - {name: floor, material: m, box: {size: [10, 4, 1]}, position: [0, 0, -0.5], fixed: true}\n";
    [("a box", floor.into()), ("two edges", rail(-0.05) + &rail(0.05))]
}

#[test]
fn what_rolls_slowly_neither_gains_nor_loses_speed() {
    for (on, floor) in floors() {
        for (shape, axis, _) in ROLLERS {
            // A ball touches edges below its middle.
            let height = if on == "two edges" && shape.starts_with("ell") { (0.01f64 - 0.0025).sqrt() } else { 0.1 };
            for speed in [1e-3, 1e-2, 0.05, 0.5] {
                let spin = axis.replace('1', &(speed / height).to_string());
                let mut sim = simulation(&format!(
                    "{HEAD}{floor}  - {{name: b, material: m, {shape}, position: [0, 0, {height}], velocity: [{speed}, 0, 0], angular_velocity: {spin}}}\n"
                ));
                let b = sim.model.body_names["b"] as usize;
                run(&mut sim, 5.0);
                let (v, x) = (sim.state.velocity[b].x, sim.state.position[b].x);
                // Where an ellipsoid meets an edge is sought by steps, which end a millionth of its size from there.
                let off = if height < 0.1 { 1e-4 + 0.15 * speed } else { 5e-4 * speed };
                assert!(
                    (v - speed).abs() < off && (x - 5.0 * speed).abs() < 5.0 * off,
                    "{shape} on {on}: {v} of {speed} m/s, {x} m"
                );
            }
        }
    }
}

#[test]
fn what_rolls_down_a_slope_is_as_fast_as_it_should() {
    let [(_, floor), _] = floors();
    for (shape, _, inertia) in ROLLERS {
        for (degrees, within) in [(0.05f64, 0.02), (0.5, 2e-3)] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let gravity = format!("gravity: [{}, 0, {}]\n", 9.81 * sin, -9.81 * cos);
            let mut sim = simulation(&format!(
                "{gravity}{HEAD}{floor}  - {{name: b, material: m, {shape}, position: [0, 0, 0.1]}}\n"
            ));
            run(&mut sim, 5.0);
            let expected = 9.81 * sin * 5.0 / (1.0 + inertia);
            let v = sim.state.velocity[sim.model.body_names["b"] as usize].x;
            assert!((v / expected - 1.0).abs() < within, "{shape} on {degrees}°: {v} m/s, should be {expected}");
        }
    }
}

#[test]
fn a_plank_on_two_rollers_goes_on_at_its_speed() {
    let (speed, [(_, floor), _]) = (1e-3, floors());
    let (cylinder, ..) = ROLLERS[0];
    let roller = |x: f64| {
        let spin = -speed / 0.1;
        format!(
            "  - {{name: r{x}, material: m, {cylinder}, position: [{x}, 0, 0.1], velocity: [{speed}, 0, 0], angular_velocity: [0, 0, {spin}]}}\n"
        )
    };
    let plank = format!(
        "  - {{name: plank, material: m, box: {{size: [2, 0.4, 0.05]}}, position: [0, 0, 0.225], velocity: [{}, 0, 0]}}\n",
        2.0 * speed
    );
    let mut sim = simulation(&format!("{HEAD}{floor}{}{}{plank}", roller(-0.4), roller(0.4)));
    run(&mut sim, 5.0);
    let v = sim.state.velocity[sim.model.body_names["plank"] as usize].x;
    assert!((v / (2.0 * speed) - 1.0).abs() < 0.01, "{v} m/s");
}

/// Sixty-four logs in layers between walls that lean outwards: they roll and slip into each other's gaps, and rest.
#[test]
fn logs_between_walls_come_to_rest() {
    for (shape, length) in [("cylinder", 1.0), ("capsule", 0.9)] {
        for friction in [0.1, 0.3, 0.5] {
            let mut yaml = format!(
                "quality: normal
materials: {{m: {{density: 1000, friction: {friction}}}}}
bodies:
  - {{name: ground, material: m, plane: {{normal: [0, 0, 1]}}}}
  - {{name: west, material: m, plane: {{normal: [1, 0, 0.3]}}, position: [-0.5, 0, 0]}}
  - {{name: east, material: m, plane: {{normal: [-1, 0, 0.3]}}, position: [0.5, 0, 0]}}
"
            );
            for (i, j) in (0..64).map(|k| (k % 8, k / 8)) {
                let (x, z) = ((i as f64 - 3.5) * 0.105 + 0.02 * (j % 2) as f64, 0.06 + 0.11 * j as f64);
                yaml += &format!(
                    "  - {{name: l{i}_{j}, material: m, {shape}: {{radius: 0.05, length: {length}}}, position: [{x}, 0, {z}], rotate: {{axis: [1, 0, 0], angle: 90}}}}\n"
                );
            }
            let mut sim = simulation(&yaml);
            let energy = |sim: &Simulation| {
                let height = |b: usize| 9.81 * sim.state.position[b].z / sim.model.inv_mass[b];
                let moving = (0..sim.model.n_bodies()).filter(|b| sim.model.inv_mass[*b] > 0.0);
                sim.state.kinetic_energy(&sim.model) + moving.map(height).sum::<f64>()
            };
            let (mut before, mut deepest) = (energy(&sim), 0.0f64);
            for second in 1..=5 {
                while sim.state.time < second as f64 {
                    deepest = deepest.max(sim.step().worst_penetration);
                }
                let now = energy(&sim);
                // Overlaps that are pushed apart lift what lies above a little.
                assert!(now < before + 0.2, "{shape}, {friction}: from {before} to {now} J in second {second}");
                before = now;
            }
            let n = sim.model.n_bodies();
            let speed = sim.state.velocity.iter().map(|v| v.length()).sum::<f64>() / n as f64;
            assert!(speed < 1e-4 && deepest < 1e-2, "{shape}, {friction}: {speed} m/s, {deepest} m");
        }
    }
}

/// Round logs crossed in pairs, which may roll on each other without any force: they stand as they were put.
#[test]
fn crossed_logs_stay_as_they_are() {
    for shape in ["cylinder: {radius: 0.05, length: 1}", "capsule: {radius: 0.05, length: 0.9}"] {
        let mut yaml = format!("{HEAD}  - {{name: ground, material: m, plane: {{normal: [0, 0, 1]}}}}\n");
        for (j, side) in (0..16).map(|k| (k / 2, 0.8 * (k % 2) as f64 - 0.4)) {
            let z = 0.05 + 0.1 * j as f64 + 1e-3 * (j + 1) as f64;
            let (position, axis) = if j % 2 == 0 { ([0.0, side, z], [0, 1, 0]) } else { ([side, 0.0, z], [1, 0, 0]) };
            yaml += &format!(
                "  - {{name: l{j}_{side}, material: m, {shape}, position: {position:?}, rotate: {{axis: {axis:?}, angle: 90}}}}\n"
            );
        }
        let mut sim = simulation(&yaml);
        run(&mut sim, 5.0);
        let before = sim.state.position.clone();
        run(&mut sim, 15.0);
        let moved = before.iter().zip(&sim.state.position).map(|(p, q)| p.distance(*q)).fold(0.0, f64::max);
        assert!(moved < 5e-5, "{shape}: {moved} m in ten seconds");
    }
}

/// The seams of a flat mesh are no edges to what lies on its side and slides over them.
#[test]
fn what_is_round_does_not_feel_the_seams_of_a_flat_mesh() {
    let work = tempfile::tempdir().unwrap();
    let obj = work.path().join("flat.obj");
    let mut text = String::new();
    const N: usize = 40;
    for k in 0..(N + 1) * (N + 1) {
        let [x, y] = [k % (N + 1), k / (N + 1)].map(|i| 0.2 * i as f64 - 4.0);
        text += &format!("v {x} {y} 0\n");
    }
    for k in 0..N * N {
        let a = k / N * (N + 1) + k % N + 1;
        let [b, c, d] = [a + 1, a + N + 2, a + N + 1];
        text += &format!("f {a} {b} {c}\nf {a} {c} {d}\n");
    }
    std::fs::write(&obj, text).unwrap();
    for shape in ["cylinder", "capsule", "cone"] {
        for quality in ["normal", "tight"] {
            let mut sim = simulation(&format!(
                "quality: {quality}
materials: {{m: {{density: 1000, friction: 0}}}}
bodies:
  - {{name: ground, material: m, fixed: true, mesh: {{file: {}}}}}
  - {{name: b, material: m, position: [-3, 0.3, 0.04], rotate: {{axis: [1, 0, 0], angle: 90}}, velocity: [2, 0.1, 0], {shape}: {{radius: 0.04, length: 0.06}}}}
",
                obj.display()
            ));
            let mut most = 0.0f64;
            while sim.state.time < 1.5 {
                sim.step();
                most = most.max(sim.state.position[1].z);
            }
            let speed = sim.state.velocity[1].x;
            assert!((speed - 2.0).abs() < 2e-3 && most < 0.0401, "{shape} {quality}: {speed} m/s, up to {most} m");
        }
    }
}
