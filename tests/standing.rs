//! What stands stays, whatever moves beside it, under it or came before it.

use crate::analytic::{run, simulation};
use crate::cli::{scratch, scree};
use sim::Simulation;
use sim::watch::WarningKind;

/// Ten bricks on each other, each 4 cm beside the one below, that are pushed by up to 2 cm/s and move at `speed` along y, over `more` bodies.
fn column(quality: &str, base: f64, speed: f64, more: &str) -> Simulation {
    let brick = |i: usize| {
        let x = if i.is_multiple_of(2) { -0.01 } else { 0.01 };
        let (z, push) = (base + 0.05 + 0.1 * i as f64, 0.02 * (i as f64 + 0.5) / 10.0);
        format!(
            "  - {{name: b{i}, material: m, box: {{size: [0.199, 0.1, 0.1]}}, position: [{x}, 0, {z}], velocity: [0, {}, 0], angular_velocity: [-0.02, 0, 0]}}\n",
            speed + push
        )
    };
    let bricks: String = (0..10).map(brick).collect();
    simulation(&format!(
        "quality: {quality}
materials: {{m: {{density: 1000, friction: 0.5}}, ice: {{density: 1000, friction: 0}}}}
bodies:
  - {{name: ground, material: ice, plane: {{normal: [0, 0, 1]}}}}
{more}{bricks}"
    ))
}

/// How far the last body has moved sideways beside the second, the first that moves, m, after some seconds.
fn leaned(mut sim: Simulation, seconds: f64) -> f64 {
    let last = sim.state.position.len() - 1;
    let beside = |sim: &Simulation| sim.state.position[last].y - sim.state.position[1].y;
    let before = beside(&sim);
    run(&mut sim, seconds);
    (beside(&sim) - before).abs()
}

#[test]
fn a_column_stands_on_a_sled_and_beside_a_ball() {
    for speed in [0.0, 0.5, 5.0] {
        let sled = format!(
            "  - {{name: sled, material: m, mass: 50, box: {{size: [2, 1, 0.1]}}, position: [0, 0, 0.05], velocity: [0, {speed}, 0]}}\n"
        );
        let leaned = leaned(column("normal", 0.1, speed, &sled), 5.0);
        assert!(leaned < 1e-3, "on a sled at {speed} m/s: {leaned} m");
    }
    let floor = "  - {name: slab, material: m, fixed: true, box: {size: [9, 9, 0.1]}, position: [0, 0, 0.05]}\n";
    for speed in [0.0, 0.5, 3.0] {
        let ball = format!(
            "{floor}  - {{name: ball, material: m, sphere: {{radius: 0.05}}, position: [-1, -1.5, 0.15], velocity: [{speed}, 0, 0], angular_velocity: [0, {}, 0]}}\n",
            speed / 0.05
        );
        let leaned = leaned(column("normal", 0.1, 0.0, &ball), 5.0);
        assert!(leaned < 1e-3, "beside a ball at {speed} m/s: {leaned} m");
    }
    let leaned = leaned(column("draft", 0.1, 0.0, floor), 8.0);
    assert!(leaned < 1e-3, "at draft quality: {leaned} m");
}

/// A pyramid of some rows of which nothing is there before a time, and a box on the ground that is.
fn later(rows: usize, at: f64) -> String {
    let mut text = "quality: normal
duration: 1
materials: {m: {density: 1000, friction: 0.5}}
bodies:
  - {name: ground, material: m, plane: {normal: [0, 0, 1]}}
  - {name: one, material: m, box: {size: [0.2, 0.2, 0.2]}, position: [-3, 0, 0.1]}
"
    .to_string();
    for row in 0..rows {
        for k in 0..rows - row {
            let (x, z) = (0.22 * k as f64 + 0.11 * row as f64, 0.1 + 0.2 * row as f64);
            text += &format!(
                "  - {{name: p{row}_{k}, material: m, box: {{size: [0.2, 0.2, 0.2]}}, position: [{x}, 0, {z}], appears: {at}}}\n"
            );
        }
    }
    text
}

#[test]
fn what_appears_as_it_stands_stands_from_then_on() {
    let mut sim = simulation(&later(30, 0.1));
    run(&mut sim, 0.2);
    let kinetic = sim.state.kinetic_energy(&sim.model);
    // 465 boxes of 8 kg: 1e-5 m/s.
    assert!(kinetic < 2e-7, "{kinetic} J");
}

#[test]
fn quality_is_chosen_for_all_that_will_move() {
    let settings = |when: &str| {
        let sim = simulation(&format!(
            "quality: normal
materials: {{m: {{density: 1000, friction: 0.5}}}}
bodies:
  - {{name: ground, material: m, plane: {{normal: [0, 0, 1]}}}}
  - {{name: box, material: m, box: {{size: [0.2, 0.2, 0.2]}}, position: [0, 0, 0.1]{when}}}
"
        ));
        (sim.model.step, format!("{:?}", sim.model.solver))
    };
    assert_eq!(settings(", appears: 0.5"), settings(""));
    assert_eq!(settings(", held_until: 0.5"), settings(""));
}

/// A mass on a spring, as a model that has a level of quality or a step.
fn swinging(settings: &str, stiffness: f64) -> String {
    format!(
        "{settings}
duration: 1
gravity: [0, 0, 0]
materials: {{m: {{density: 1000, friction: 0.5}}}}
bodies: [{{name: b, material: m, mass: 1, box: {{size: [0.2, 0.2, 0.2]}}, position: [1.1, 0, 0]}}]
springs: [{{name: s, a: world, b: b, position: [0, 0, 0], position_b: [1.1, 0, 0], stiffness: {stiffness}, rest: 1.0}}]
"
    )
}

#[test]
fn steps_resolve_springs() {
    // The same swing at the end as at the start, and no alarm, also where a step is given that resolves it badly.
    for (settings, bound) in
        [("quality: draft", 0.2), ("quality: normal", 0.1), ("quality: tight", 0.04), ("step: 4e-3", 0.3)]
    {
        let mut sim = simulation(&swinging(settings, 1e4));
        let (mut most, mut kinds) = ([0.0f64; 2], vec![]);
        while sim.state.time < 2.0 {
            kinds.extend(sim.step().warnings);
            let late = (sim.state.time > 1.8) as usize;
            if sim.state.time < 0.2 || late == 1 {
                most[late] = most[late].max((sim.state.position[0].x - 1.0).abs());
            }
        }
        assert!(kinds.is_empty(), "{settings}: {kinds:?}");
        assert!((most[1] / most[0] - 1.0).abs() < 0.03, "{settings}: {most:?}");
        assert!((most[0] / 0.1 - 1.0).abs() < bound, "{settings}: {most:?}");
    }
    // One that no step of that length resolves is said.
    let work = scratch();
    let at = |name: &str| work.path().join(name).to_str().unwrap().to_string();
    std::fs::write(at("m.yaml"), swinging("step: 4e-3", 1e6)).unwrap();
    let said = scree(&["simulate", &at("m.yaml"), "-o", &at("run"), "--until", "0.01"]).errors();
    assert!(said.contains("stiffer than steps of 4.00e-3 s resolve") && said.contains("m.yaml:6:"), "{said}");
}

/// Balls and boxes that meet without gravity: there is no g h to measure a residual by.
#[test]
fn impacts_without_gravity_are_no_fault() {
    for quality in ["draft", "normal", "tight"] {
        let mut sim = simulation(&format!(
            "quality: {quality}
gravity: [0, 0, 0]
materials: {{m: {{density: 1000, friction: 0.3}}}}
bodies:
  - {{name: b0, material: m, sphere: {{radius: 0.1}}, velocity: [2, 0, 0]}}
  - {{name: b1, material: m, sphere: {{radius: 0.1}}, position: [0.21, 0.01, 0]}}
  - {{name: b2, material: m, sphere: {{radius: 0.1}}, position: [0.42, 0, 0]}}
"
        ));
        let mut kinds = vec![];
        while sim.state.time < 1.0 {
            kinds.extend(sim.step().warnings.iter().map(|w| w.kind));
        }
        assert!(!kinds.contains(&WarningKind::Residual), "{quality}: {kinds:?}");
    }
}
