//! Dynamics against answers known on paper.

use glam::DVec3;
use sim::{Simulation, model_file::ModelFile};
use std::path::Path;

/// A simulation of a model given as YAML text.
pub fn simulation(yaml: &str) -> Simulation {
    let (mut file, doc) = frame::yaml::parse::<ModelFile>(Path::new("test.yaml"), yaml.into()).unwrap();
    file.choose(&doc).unwrap();
    let resolved = file.resolve(&doc).unwrap();
    Simulation::new(resolved.model, resolved.state)
}

pub fn run(sim: &mut Simulation, until: f64) {
    while sim.state.time < until - 1e-9 {
        sim.step();
    }
}

pub fn close(value: f64, expected: f64, relative: f64, what: &str) {
    assert!((value - expected).abs() <= relative * expected.abs(), "{what}: {value}, expected {expected}");
}

/// A solid sphere (m 1, r 1) that slides over the ground at 2 m/s.
fn sliding_sphere(friction: &str, method: &str, speed: f64, step: f64) -> Simulation {
    simulation(&format!(
        "gravity: [0, 0, -9.81]
step: {step}
solver: {{friction: {friction}, method: {method}, iterations: 2000, tolerance: 1e-12}}
materials: {{m: {{density: 1, friction: 0.1}}}}
bodies:
  - {{name: ground, material: m, plane: {{normal: [0, 0, 1]}}}}
  - {{name: sphere, material: m, mass: 1, sphere: {{radius: 1}}, position: [0, 0, 1], velocity: [{speed}, 0, 0]}}
"
    ))
}

#[test]
fn one_step_relaxed() {
    for method in ["apgd", "jacobi", "gauss_seidel", "barzilai_borwein"] {
        let mut sim = sliding_sphere("relaxed", method, 2.0, 0.005);
        sim.step();
        let gamma = sim.state.contacts.gamma(0);
        close(gamma.x, 0.240628, 1e-5, "normal impulse");
        close((gamma.y * gamma.y + gamma.z * gamma.z).sqrt(), 0.0240628, 1e-5, "tangential impulse");
        close(sim.state.velocity[1].z, 0.191578, 1e-5, "lift");
        close(sim.state.velocity[1].x, 1.975937, 1e-6, "speed");
    }
}

#[test]
fn one_step_exact() {
    for method in ["apgd", "jacobi", "gauss_seidel", "barzilai_borwein"] {
        let mut sim = sliding_sphere("exact", method, 2.0, 0.005);
        sim.step();
        close(sim.state.contacts.gamma(0).x, 9.81 * 0.005, 1e-5, "normal impulse");
        close(sim.state.velocity[1].x, 1.995095, 1e-6, "speed");
    }
}

#[test]
fn sliding_turns_to_rolling() {
    for friction in ["relaxed", "exact"] {
        let mut sim = sliding_sphere(friction, "apgd", 2.0, 1e-3);
        let mut rolls_at = None;
        while sim.state.time < 1.0 {
            sim.step();
            // The body frame turns with the sphere: compare the spin in the world's.
            let spin = (sim.state.orientation[1] * sim.state.angular_velocity[1]).y;
            if rolls_at.is_none() && (sim.state.velocity[1].x - spin).abs() < 1e-3 {
                rolls_at = Some((sim.state.time, sim.state.position[1].x));
            }
        }
        let (time, place) = rolls_at.expect("the sphere comes to roll");
        // The relaxed law holds the sphere up at first, so that its friction starts a few steps late.
        close(sim.state.velocity[1].x, 1.428571, 1e-3, "rolling speed");
        close(time, 0.58250, 1e-2, "time");
        close(place, 0.99856, 1e-2, "place");
    }
}

#[test]
fn a_block_slides_to_a_stop() {
    let mut sim = simulation(
        "step: 5e-4
solver: {friction: exact, iterations: 400, tolerance: 1e-10}
materials: {m: {density: 1000, friction: 0.5}}
bodies:
  - {name: ground, material: m, plane: {normal: [0, 0, 1]}}
  - {name: block, material: m, box: {size: [0.4, 0.4, 0.1]}, position: [0, 0, 0.05], velocity: [5, 0, 0]}
",
    );
    run(&mut sim, 1.2);
    close(sim.state.position[1].x, 2.548, 5e-3, "stopping distance");
    assert!(sim.state.velocity[1].length() < 1e-6);
}

/// A box on a slope of 20° with friction `mu`, after `time`: how far it has slid down, m, and its speed, m/s.
fn incline(mu: f64, time: f64) -> (f64, f64) {
    let angle = 20f64.to_radians();
    let up = DVec3::new(angle.sin(), 0.0, angle.cos());
    let at = up * 0.05;
    let mut sim = simulation(&format!(
        "step: 1e-3
solver: {{friction: exact, iterations: 300, tolerance: 1e-10}}
materials: {{m: {{density: 1000, friction: {mu}}}}}
bodies:
  - {{name: slope, material: m, plane: {{normal: [{}, 0, {}]}}}}
  - {{name: block, material: m, box: {{size: [0.2, 0.2, 0.1]}}, position: [{}, 0, {}], rotate: {{axis: [0, 1, 0], angle: 20}}}}
",
        up.x, up.z, at.x, at.z
    ));
    let start = sim.state.position[1];
    run(&mut sim, time);
    ((sim.state.position[1] - start).length(), sim.state.velocity[1].length())
}

#[test]
fn a_block_on_a_slope_stays_or_slides() {
    let (drift, _) = incline(0.5, 5.0);
    assert!(drift < 1e-4, "drift {drift} m");
    let angle = 20f64.to_radians();
    let (_, speed) = incline(0.2, 1.0);
    close(speed, 9.81 * (angle.sin() - 0.2 * angle.cos()), 1e-3, "speed after a second");
}

#[test]
fn what_begins_to_slide_presses_with_its_weight() {
    for method in ["apgd", "gauss_seidel", "jacobi", "barzilai_borwein"] {
        // Gravity of a slope of 45 degrees: the slip grows by 5.6 mm/s in a step, from below g h on.
        let mut sim = simulation(&format!(
            "gravity: [6.9367, 0, -6.9367]
solver: {{friction: exact, method: {method}}}
materials: {{m: {{density: 1000, friction: 0.2}}}}
bodies:
  - {{name: ground, material: m, plane: {{normal: [0, 0, 1]}}}}
  - {{name: block, material: m, mass: 1, box: {{size: [0.2, 0.2, 0.2]}}, position: [0, 0, 0.1]}}
"
        ));
        for step in 0..30 {
            let before = sim.state.velocity[1].z;
            sim.step();
            let force = (sim.state.velocity[1].z - before) / sim.model.step + 6.9367;
            assert!((force / 6.9367 - 1.0).abs() < 2e-3, "{method}, step {step}: {force} N");
        }
    }
}

#[test]
fn stacks_stand() {
    for (n, shape, height) in [(5, "sphere: {radius: 0.1}", 0.2), (10, "box: {size: [0.2, 0.2, 0.2]}", 0.2)] {
        let mut yaml = String::from(
            "step: 1e-3
solver: {iterations: 300, tolerance: 1e-9}
materials: {m: {density: 2000, friction: 0.5}}
bodies:
  - {name: ground, material: m, plane: {normal: [0, 0, 1]}}
",
        );
        for i in 0..n {
            let z = (i as f64 + 0.5) * height;
            yaml += &format!("  - {{name: b{i}, material: m, {shape}, position: [0, 0, {z}]}}\n");
        }
        let mut sim = simulation(&yaml);
        run(&mut sim, 2.0);
        for b in 1..=n {
            let p = sim.state.position[b];
            assert!(p.truncate().length() < 1e-5, "{shape}: body {b} has drifted to {p}");
            assert!((p.z - (b as f64 - 0.5) * height).abs() < 2e-3, "{shape}: body {b} has sunk to {p}");
            let turn = 2.0 * sim.state.orientation[b].w.abs().min(1.0).acos();
            assert!(turn < 1e-4, "{shape}: body {b} has turned by {turn}");
        }
    }
}

#[test]
fn a_heavy_sphere_on_a_light_stack_converges() {
    let first_step = |method: &str, iterations: u32| {
        let mut yaml = format!(
            "step: 1e-3
solver: {{method: {method}, iterations: {iterations}, tolerance: 1e-7, warm_start: false}}
materials: {{m: {{density: 2000, friction: 0.3}}}}
bodies:
  - {{name: ground, material: m, plane: {{normal: [0, 0, 1]}}}}
"
        );
        for i in 0..20 {
            yaml += &format!(
                "  - {{name: b{i}, material: m, mass: 1, sphere: {{radius: 0.1}}, position: [0, 0, {}]}}\n",
                0.1 + 0.2 * i as f64
            );
        }
        yaml += "  - {name: heavy, material: m, mass: 1000, sphere: {radius: 0.1}, position: [0, 0, 4.1]}\n";
        let mut sim = simulation(&yaml);
        let report = sim.step();
        let contacts = &sim.state.contacts;
        (report, (0..contacts.len()).map(|i| contacts.gamma(i).x).fold(0.0, f64::max))
    };
    let (apgd, impulse) = first_step("apgd", 100_000);
    assert!(apgd.residual <= 1e-7 && apgd.iterations < 100_000, "APGD did not converge: {apgd:?}");
    close(impulse, 1020.0 * 9.81e-3, 1e-3, "impulse on the ground, which carries the whole column");
    let (jacobi, _) = first_step("jacobi", 10 * apgd.iterations);
    assert!(jacobi.residual > 1e-7, "Jacobi needs more than ten times APGD's {} iterations", apgd.iterations);
}

/// A rod that slides on its lower end: one way friction presses the end into the floor, without bound (Painlevé), until it sticks; the other way
/// friction lifts it.
#[test]
fn a_rod_that_slides_on_its_end_is_held_by_every_method() {
    let methods = ["gauss_seidel", "apgd", "barzilai_borwein"];
    let methods = methods.map(|method| format!("step: 1e-3\nsolver: {{friction: exact, method: {method}}}\n"));
    let levels = ["draft", "normal", "tight"];
    let levels = levels.map(|level| format!("quality: {level}\nsolver: {{friction: exact}}\n"));
    let settings: Vec<String> = methods.into_iter().chain(levels).collect();
    for (settings, speed) in settings.iter().flat_map(|settings| [(settings, -4.0), (settings, 4.0)]) {
        let mut sim = simulation(&format!(
            "{settings}materials: {{m: {{density: 1000, friction: 1.5}}}}
bodies:
  - {{name: ground, material: m, plane: {{normal: [0, 0, 1]}}}}
  - {{name: rod, material: m, capsule: {{radius: 0.02, length: 1}}, position: [0, 0, 0.4540127018922194], rotate: {{axis: [0, 1, 0], angle: -30}}, velocity: [{speed}, 0, 0]}}
"
        ));
        for _ in 0..300 {
            let report = sim.step();
            assert!(report.warnings.is_empty(), "{settings}{speed}: {:?}", report.warnings);
            let is_of_method = settings.starts_with("step");
            let most = if is_of_method { 1e-6 } else { 1e-3 };
            assert!(report.worst_penetration < most, "{settings}{speed}: {:.1e} m", report.worst_penetration);
        }
    }
}

#[test]
fn a_free_box_tumbles_and_keeps_its_momentum() {
    let mut sim = simulation(
        "gravity: [0, 0, 0]
step: 1e-3
materials: {m: {density: 1000, friction: 0.3}}
bodies:
  - {name: box, material: m, box: {size: [0.1, 0.2, 0.4]}, velocity: [1, 2, 3], angular_velocity: [0.01, 5, 0.01]}
",
    );
    let momentum =
        |sim: &Simulation| sim.state.orientation[0] * (sim.state.angular_velocity[0] / sim.model.inv_inertia[0]);
    let (l0, e0) = (momentum(&sim), sim.state.kinetic_energy(&sim.model));
    let mut flipped = false;
    while sim.state.time < 10.0 {
        sim.step();
        flipped |= sim.state.angular_velocity[0].y < -4.0;
    }
    assert!((momentum(&sim) - l0).length() < 1e-10 * l0.length());
    assert!(flipped, "the middle axis is unstable: the box turns over");
    close(sim.state.kinetic_energy(&sim.model), e0, 1e-5, "energy");
}

#[test]
fn a_sphere_rolls_down_a_slope() {
    let angle = 10f64.to_radians();
    let mut sim = simulation(&format!(
        "step: 1e-3
materials: {{m: {{density: 1000, friction: 0.6}}}}
bodies:
  - {{name: slope, material: m, plane: {{normal: [{}, 0, {}]}}}}
  - {{name: sphere, material: m, sphere: {{radius: 0.1}}, position: [{}, 0, {}]}}
",
        angle.sin(),
        angle.cos(),
        0.1 * angle.sin(),
        0.1 * angle.cos()
    ));
    run(&mut sim, 1.0);
    close(sim.state.velocity[1].length(), 5.0 / 7.0 * 9.81 * angle.sin(), 2e-3, "speed after a second");
}

#[test]
fn a_stack_under_a_million_times_its_weight_stands_by_the_exact_law() {
    let boxes: String = (0..6)
        .map(|k| {
            let material = if k == 5 { "heavy" } else { "stone" };
            let z = 0.1 + 0.2 * f64::from(k);
            format!("  - {{name: b{k}, material: {material}, box: {{size: [0.2, 0.2, 0.2]}}, position: [0, 0, {z}]}}\n")
        })
        .collect();
    let mut sim = simulation(&format!(
        "step: 1e-3
solver: {{friction: exact, method: apgd, iterations: 2000}}
materials: {{stone: {{density: 1000, friction: 0.5}}, heavy: {{density: 1e9, friction: 0.5}}}}
bodies:
  - {{name: ground, material: stone, plane: {{normal: [0, 0, 1]}}}}
{boxes}"
    ));
    run(&mut sim, 1.0);
    assert!((sim.state.position[6].z - 1.1).abs() < 1e-3, "{}", sim.state.position[6]);
    // Of 78 MJ that the top weighs over its height; a quarter of the iterations in each round made 8.5 MJ of nothing.
    let kinetic = sim.state.kinetic_energy(&sim.model);
    assert!(kinetic < 1e4, "{kinetic} J");
}

#[test]
fn a_card_house_and_a_stack_under_a_thousand_times_its_weight_stand() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("sim/models/card_house.yaml");
    let (_, resolved) = sim::model_file::read(&path).unwrap();
    let mut sim = Simulation::new(resolved.model, resolved.state);
    let start = sim.state.position.clone();
    run(&mut sim, 2.0);
    for (b, p) in start.iter().enumerate() {
        let moved = (sim.state.position[b] - *p).length();
        assert!(moved < 2e-3, "card {b} has moved by {moved} m");
    }
    let mut yaml = String::from(
        "step: 1e-3
materials: {m: {density: 2000, friction: 0.3}}
bodies:
  - {name: ground, material: m, plane: {normal: [0, 0, 1]}}
",
    );
    for i in 0..21 {
        let mass = if i == 20 { 1000 } else { 1 };
        let z = 0.1 + 0.2 * i as f64;
        yaml +=
            &format!("  - {{name: b{i}, material: m, mass: {mass}, sphere: {{radius: 0.1}}, position: [0, 0, {z}]}}\n");
    }
    let mut sim = simulation(&yaml);
    run(&mut sim, 2.0);
    for b in 1..=21 {
        let p = sim.state.position[b];
        assert!(p.truncate().length() < 1e-5, "sphere {b} has drifted to {p}");
        assert!((p.z - (0.1 + 0.2 * (b - 1) as f64)).abs() < 1e-6, "sphere {b} has sunk to {p}");
    }
}

#[test]
fn impulses_keep_momentum_to_round_off() {
    // A cloud of stones of every shape that meets in the void.
    let mut yaml = String::from(
        "gravity: [0, 0, 0]
step: 1e-3
solver: {iterations: 30}
materials: {m: {density: 1000, friction: 0.5, restitution: 0.3, rolling: 1e-3, spinning: 1e-3}}
bodies:
",
    );
    let shapes = [
        "sphere: {radius: 0.1}",
        "box: {size: [0.2, 0.15, 0.1]}",
        "cylinder: {radius: 0.08, length: 0.2}",
        "capsule: {radius: 0.06, length: 0.15}",
        "cone: {radius: 0.1, length: 0.2}",
        "ellipsoid: {radii: [0.12, 0.08, 0.06]}",
        "hull: {points: [[0.1, 0, 0], [-0.1, 0.05, 0], [0, -0.1, 0], [0, 0, 0.15]]}",
    ];
    for i in 0..42 {
        let at = [i % 4, i / 4 % 4, i / 16].map(|k| 0.3 * k as f64 - 0.45);
        let v = at.map(|x| -2.0 * x);
        yaml += &format!(
            "  - {{name: b{i}, material: m, {}, position: {at:?}, velocity: {v:?}, angular_velocity: [1, {i}, 2]}}\n",
            shapes[i % 7]
        );
    }
    let mut sim = simulation(&yaml);
    let momentum = |s: &Simulation| {
        let (mut p, mut l, mut scale) = (DVec3::ZERO, DVec3::ZERO, 0.0);
        for b in 0..s.model.n_bodies() {
            let own = s.state.velocity[b] / s.model.inv_mass[b];
            let spin = s.state.orientation[b] * (s.state.angular_velocity[b] / s.model.inv_inertia[b]);
            p += own;
            l += s.state.position[b].cross(own) + spin;
            scale += own.length() + spin.length();
        }
        (p, l, scale)
    };
    let (p0, l0, scale) = momentum(&sim);
    let mut contacts = 0;
    for _ in 0..500 {
        contacts += sim.step().contacts;
    }
    let (p1, l1, _) = momentum(&sim);
    assert!(contacts > 1000, "{contacts}");
    assert!((p1 - p0).length() < 1e-11 * scale, "linear: {}", (p1 - p0).length() / scale);
    assert!((l1 - l0).length() < 1e-11 * scale, "angular: {}", (l1 - l0).length() / scale);
}

#[test]
fn restitution_rolling_friction_and_cohesion_have_their_effect() {
    let sphere = |material: &str, more: &str| {
        simulation(&format!(
            "step: 1e-4
solver: {{friction: exact, iterations: 100, tolerance: 1e-10}}
materials: {{m: {{density: 1000, friction: 0.5, {material}}}}}
bodies:
  - {{name: ground, material: m, plane: {{normal: [0, 0, 1]}}}}
  - {{name: sphere, material: m, mass: 1, sphere: {{radius: 0.1}}, {more}}}
"
        ))
    };
    // Let fall from 0.2 m, half the speed comes back: a quarter of the height.
    let mut sim = sphere("restitution: 0.5", "position: [0, 0, 0.3]");
    let mut highest = 0.0f64;
    let (mut bounced, mut falling) = (false, false);
    while sim.state.time < 0.6 {
        sim.step();
        falling |= sim.state.velocity[1].z < -1.0;
        bounced |= falling && sim.state.velocity[1].z > 0.5;
        if bounced && sim.state.time < 0.45 {
            highest = highest.max(sim.state.position[1].z - 0.1);
        }
    }
    close(highest, 0.05, 0.02, "height of the bounce");
    // A rolling sphere is braked by the torque ρ m g: a = ρ g/r · 1/(1 + 2/5).
    let mut sim = sphere("rolling: 2e-3", "position: [0, 0, 0.1], velocity: [1, 0, 0], angular_velocity: [0, 10, 0]");
    run(&mut sim, 1.0);
    close(1.0 - sim.state.velocity[1].x, 2e-3 * 9.81 / 0.1 / 1.4, 0.02, "braking");
    // A force of 15 N holds 1 kg under a ceiling; 5 N does not.
    for (cohesion, holds) in [(15.0, true), (5.0, false)] {
        let mut sim = simulation(&format!(
            "step: 1e-3
materials: {{m: {{density: 1000, friction: 0.5, cohesion: {cohesion}}}}}
bodies:
  - {{name: ceiling, material: m, plane: {{normal: [0, 0, -1]}}}}
  - {{name: sphere, material: m, mass: 1, sphere: {{radius: 0.1}}, position: [0, 0, -0.1]}}
"
        ));
        run(&mut sim, 0.3);
        assert_eq!(sim.state.position[1].z > -0.101, holds, "{cohesion} N: {}", sim.state.position[1].z);
    }
}

#[test]
fn a_mesh_and_a_height_field_carry_every_shape() {
    let folder = tempfile::tempdir().unwrap();
    let obj = folder.path().join("slab.obj");
    std::fs::write(&obj, "v -3 -3 0\nv 3 -3 0\nv 3 3 0\nv -3 3 0\nf 1 2 3\nf 1 3 4\n").unwrap();
    let grid = folder.path().join("flat.txt");
    std::fs::write(&grid, "0 0 0 0 0 0 0\n".repeat(7)).unwrap();
    for ground in [
        format!("mesh: {{file: {}}}", obj.display()),
        format!("height_field: {{grid: {}, size: [6, 6]}}", grid.display()),
    ] {
        let mut yaml = format!(
            "step: 1e-3
solver: {{iterations: 200, tolerance: 1e-8}}
materials: {{m: {{density: 1000, friction: 0.5}}}}
bodies:
  - {{name: ground, material: m, {ground}}}
"
        );
        let shapes = [
            ("sphere: {radius: 0.2}", 0.2),
            ("box: {size: [0.4, 0.4, 0.3]}", 0.15),
            ("cylinder: {radius: 0.2, length: 0.4}", 0.2),
            ("capsule: {radius: 0.2, length: 0.2}", 0.3),
            ("cone: {radius: 0.2, length: 0.4}", 0.2),
            ("ellipsoid: {radii: [0.2, 0.2, 0.1]}", 0.1),
        ];
        for (i, (shape, height)) in shapes.iter().enumerate() {
            let x = i as f64 * 0.8 - 2.03;
            yaml += &format!("  - {{name: s{i}, material: m, {shape}, position: [{x}, 0.013, {}]}}\n", height + 0.02);
        }
        let mut sim = simulation(&yaml);
        run(&mut sim, 1.0);
        for (i, (shape, height)) in shapes.iter().enumerate() {
            let p = sim.state.position[i + 1];
            // A cone's centre of mass is a quarter up.
            let expected = if shape.starts_with("cone") { 0.1 } else { *height };
            assert!((p.z - expected).abs() < 2e-3, "{shape} on {ground}: {p}");
            assert!((p.x - (i as f64 * 0.8 - 2.03)).abs() < 5e-3, "{shape} on {ground}: {p}");
        }
    }
}

#[test]
fn crossed_logs_touch_at_one_point() {
    // A log across another, its centre beside the lower one's axis, has nothing to stand on there: it tips at once. Centred, it stays.
    for shape in ["cylinder: {radius: 0.1, length: 1}", "capsule: {radius: 0.1, length: 0.8}"] {
        for (beside, falls) in [(0.2, true), (0.0, false)] {
            let mut sim = simulation(&format!(
                "materials: {{m: {{density: 700, friction: 0.5}}}}
bodies:
  - {{name: lower, material: m, fixed: true, {shape}, position: [0, 0, 0.1], rotate: {{axis: [0, 1, 0], angle: 90}}}}
  - {{name: upper, material: m, {shape}, position: [0, {beside}, 0.3], rotate: {{axis: [1, 0, 0], angle: 90}}}}
"
            ));
            run(&mut sim, 0.3);
            let (height, spin) = (sim.state.position[1].z, sim.state.angular_velocity[1].length());
            assert_eq!(height < 0.28 && spin > 1.0, falls, "{shape}, {beside} m beside: {height} m, {spin} rad/s");
        }
    }
}

#[test]
fn a_body_slides_and_stops_at_any_scale() {
    // Squares of the impulses of the greatest are beyond single precision.
    for size in [1e-4, 1.0, 1e5, 4e5_f64] {
        let (speed, half) = ((9.81 * size).sqrt(), 0.125 * size);
        let mut sim = simulation(&format!(
            "quality: normal
materials: {{m: {{density: 1000, friction: 0.5}}}}
bodies:
  - {{name: ground, material: m, plane: {{normal: [0, 0, 1]}}}}
  - {{name: box, material: m, box: {{size: [{size}, {size}, {}]}}, position: [0, 0, {half}], velocity: [{speed}, 0, 0]}}
",
            2.0 * half
        ));
        // It stops after v/(μ g), v²/(2 μ g) from where it began: by its own size.
        run(&mut sim, 1.2 * speed / (0.5 * 9.81));
        let way = sim.state.position[1].x / size;
        assert!((way - 1.0).abs() < 0.02, "of {size} m: {way}");
        assert!(sim.state.velocity[1].length() < 1e-3 * speed);
    }
}
