//! Bodies that sleep: islands that rest are left where they are, keep their forces, and wake whole, without losing an impulse.

use crate::analytic::simulation;
use crate::cli::{scratch, scree};
use glam::DVec3;
use sim::{Activity, Simulation};
use std::fmt::Write;

/// Run until a time, s. Returns the number of warnings.
fn run_until(sim: &mut Simulation, time: f64) -> usize {
    let mut warnings = 0;
    while sim.state.time < time - 1e-9 {
        warnings += sim.step().warnings.len();
    }
    warnings
}

fn sleeps(sim: &Simulation, name: &str) -> bool {
    sim.state.activity[body(sim, name)] == Activity::Asleep
}

fn body(sim: &Simulation, name: &str) -> usize {
    sim.model.body_names[name] as usize
}

fn momentum(sim: &Simulation) -> DVec3 {
    let moving = (0..sim.model.n_bodies()).filter(|b| sim.model.inv_mass[*b] > 0.0);
    moving.map(|b| sim.state.velocity[b] / sim.model.inv_mass[b]).sum()
}

/// A column of five boxes of 8 kg.
fn column(rest: &str) -> Simulation {
    let mut yaml = "step: 2e-3
solver: {sleep: 1e-3}
materials: {m: {density: 1000, friction: 0.5}}
bodies:
  - {name: ground, material: m, plane: {normal: [0, 0, 1]}}
"
    .to_string();
    for i in 0..5 {
        let z = 0.1 + 0.2 * f64::from(i);
        writeln!(yaml, "  - {{name: b{i}, material: m, box: {{size: [0.2, 0.2, 0.2]}}, position: [0, 0, {z}]}}")
            .unwrap();
    }
    simulation(&(yaml + rest))
}

#[test]
fn what_sleeps_keeps_its_forces_and_its_energy() {
    let mut sim = column("");
    let potential = sim.state.potential_energy(&sim.model);
    assert_eq!(run_until(&mut sim, 0.4), 0);
    assert!((0..5).all(|i| !sleeps(&sim, &format!("b{i}"))));
    assert_eq!(run_until(&mut sim, 2.0), 0);
    assert!((0..5).all(|i| sleeps(&sim, &format!("b{i}"))));
    assert!(sim.state.contacts.is_empty() && sim.state.kinetic_energy(&sim.model) == 0.0);
    assert!((sim.state.potential_energy(&sim.model) - potential).abs() < 1e-3 * potential);
    let on_ground = |(c, i): (&sim::Contacts, usize)| (c.bodies[i][0] == 0).then(|| c.impulse[i].z / sim.model.step);
    let force: f64 = sim.state.all_contacts().filter_map(on_ground).sum();
    assert!((force / (40.0 * 9.81) - 1.0).abs() < 1e-3, "{force} N");
}

#[test]
fn loads_and_what_appears_wake_an_island() {
    let push = "loads: [{body: b4, force: [1, 0, 0], value: 10, from: 1.5, until: 1.6}]\n";
    let mut sim = column(push);
    run_until(&mut sim, 1.49);
    assert!(sleeps(&sim, "b0") && sleeps(&sim, "b4"));
    run_until(&mut sim, 1.55);
    assert!(!sleeps(&sim, "b0") && !sleeps(&sim, "b4"));
    run_until(&mut sim, 2.5);
    assert!(sleeps(&sim, "b0") && sleeps(&sim, "b4"));

    let ball = "  - {name: ball, material: m, sphere: {radius: 0.1}, position: [3, 0, 0.1], appears: 1.5}\n";
    let mut sim = column(ball);
    run_until(&mut sim, 1.49);
    assert!(sleeps(&sim, "b0"));
    run_until(&mut sim, 1.51);
    assert!(!sleeps(&sim, "b0"));
}

/// Spheres of one mass in a row on smooth ground, one of which is driven: all but the first have fallen asleep when it comes.
#[test]
fn an_impact_on_what_sleeps_loses_no_momentum() {
    // The second and the third stand farther apart than the first moves in a step, so near that they meet in the step of its impact, or touch.
    for gap in [0.05, 0.003, 1e-5] {
        let x = [-3.0, 0.0, 0.2 + gap];
        let mut yaml = "step: 2e-3
solver: {sleep: 1e-3, tolerance: 1e-12, iterations: 2000}
materials: {m: {density: 1000, friction: 0}}
bodies:
  - {name: ground, material: m, plane: {normal: [0, 0, 1]}}
"
        .to_string();
        for (i, x) in x.into_iter().enumerate() {
            let speed = if i == 0 { 2 } else { 0 };
            writeln!(yaml, "  - {{name: s{i}, material: m, sphere: {{radius: 0.1}}, position: [{x}, 0, 0.1], velocity: [{speed}, 0, 0]}}")
                .unwrap();
        }
        let mut sim = simulation(&yaml);
        run_until(&mut sim, 1.2);
        let before = momentum(&sim);
        assert!(sleeps(&sim, "s1") && sleeps(&sim, "s2") && before.x > 0.0, "{gap}");
        run_until(&mut sim, 2.2);
        assert!(!sleeps(&sim, "s1") && !sleeps(&sim, "s2"), "{gap}");
        assert!((momentum(&sim).x / before.x - 1.0).abs() < 1e-9, "{gap}: {} of {before}", momentum(&sim));
        let together = sim.state.velocity[body(&sim, "s2")].x;
        assert!((together - 2.0 / 3.0).abs() < 1e-6, "{gap}: {together}");
    }
}

#[test]
fn motors_keep_awake_what_they_drive_and_joints_keep_their_forces() {
    let yaml = "step: 2e-3
solver: {sleep: 1e-3}
materials: {m: {density: 1000, friction: 0.5}}
bodies:
  - {name: lamp, material: m, box: {size: [0.2, 0.2, 0.2]}, position: [0, 0, -0.5]}
  - {name: hand, material: m, box: {size: [0.4, 0.1, 0.1]}, position: [2, 0, 0]}
joints:
  - {name: hook, kind: spherical, a: world, b: lamp, position: [0, 0, 0]}
  - {name: pin, kind: revolute, a: world, b: hand, position: [2, 0, 0], axis: [0, 0, 1], motor: {speed: 1e-4}}
";
    let mut sim = simulation(yaml);
    assert_eq!(run_until(&mut sim, 1.0), 0);
    assert!(sleeps(&sim, "lamp") && !sleeps(&sim, "hand"));
    assert_eq!(run_until(&mut sim, 2.0), 0);
    let hook = sim.state.joints[0].force_world;
    assert!((hook.z.abs() / (8.0 * 9.81) - 1.0).abs() < 1e-6, "{hook}");
    assert!((sim.state.joints[1].coordinate - 2e-4).abs() < 1e-6);
}

/// Stones fall upon stones that sleep: the same bits for any number of threads, and from a checkpoint of the time when most sleep.
#[test]
fn sleep_does_not_depend_on_threads_or_checkpoints() {
    let work = scratch();
    let mut yaml = "duration: 2.4
quality: normal
checkpoint_interval: 0.4
solver: {sleep: 3e-3}
materials: {m: {density: 2500, friction: 0.6}}
bodies:
  - {name: ground, class: ground, material: m, plane: {normal: [0, 0, 1]}}
"
    .to_string();
    for i in 0..60 {
        let (x, y, z) = (0.5 * f64::from(i % 6), 0.5 * f64::from(i / 6 % 5), 0.06 + 0.25 * f64::from(i / 30));
        let late = if i % 30 == 7 { format!(", appears: {}", 1.2 + f64::from(i) / 100.0) } else { String::new() };
        let z = if late.is_empty() { z } else { 1.5 };
        writeln!(
            yaml,
            "  - {{name: s{i}, class: stone, material: m, box: {{size: [0.2, 0.15, 0.1]}}, position: [{x}, {y}, {z}]{late}}}"
        )
        .unwrap();
    }
    let path = work.path().join("stones.yaml");
    std::fs::write(&path, yaml).unwrap();
    let place = |name: &str| work.path().join(name).to_str().unwrap().to_string();
    let run = |name: &str, rest: &[&str]| {
        scree(&[&["simulate", path.to_str().unwrap(), "-o", &place(name)][..], rest].concat()).ok();
    };
    run("one", &["--threads", "1"]);
    run("two", &["--threads", "2", "--until", "1.2"]);
    run("two", &["--threads", "7", "--resume"]);
    let end = |name: &str| {
        sim::checkpoint::read(&sim::checkpoint::latest(work.path().join(name).as_path()).unwrap().unwrap())
    };
    let [one, two] = ["one", "two"].map(|name| end(name).unwrap().0);
    assert!(one.sleepers.n() > 40 && one.steps == two.steps, "{} sleep", one.sleepers.n());
    assert!(one.position == two.position && one.velocity == two.velocity && one.sleepers.island == two.sleepers.island);
    let read = |name: &str| std::fs::read(work.path().join(name).join("probes.csv")).unwrap_or_default();
    assert!(read("one") == read("two"));
}

#[test]
fn what_sleep_cannot_be_is_said() {
    let work = scratch();
    let path = work.path().join("m.yaml");
    std::fs::write(
        &path,
        "solver: {sleep: -1}\nmaterials: {m: {density: 1, friction: 0}}\nbodies: [{name: b, material: m, sphere: {radius: 1}}]\n",
    )
    .unwrap();
    let said = scree(&["check", path.to_str().unwrap()]).errors();
    assert!(said.contains("m.yaml:1:10") && said.contains("is -1, expected a number of at least 0"), "{said}");
}
