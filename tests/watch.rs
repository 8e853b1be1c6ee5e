//! Nothing goes wrong silently: residuals, joints and energies out of bounds are reported, counted, and in the exit code.

use crate::analytic::simulation;
use crate::cli::{scratch, scree};
use frame::run::RunReader;
use sim::watch::{Warning, WarningCount, WarningKind};
use std::path::Path;

/// The kinds of warnings of a model's first steps.
fn kinds(yaml: &str, steps: usize) -> Vec<WarningKind> {
    let mut sim = simulation(yaml);
    (0..steps).for_each(|_| drop(sim.step()));
    sim.state.watch.warnings.iter().map(|w| w.first.kind).collect()
}

/// A heavy box on light ones, which two iterations cannot carry.
const OVERLOADED: &str = "name: overloaded
duration: 0.2
checkpoint_interval: 0.05
solver: {method: jacobi, iterations: 2}
materials: {light: {density: 10, friction: 0.5}, heavy: {density: 100000, friction: 0.5}}
bodies:
  - {name: ground, material: light, plane: {normal: [0, 0, 1]}}
  - {name: a, material: light, box: {size: [0.2, 0.2, 0.2]}, position: [0, 0, 0.1]}
  - {name: b, material: light, box: {size: [0.2, 0.2, 0.2]}, position: [0, 0, 0.3]}
  - {name: load, material: heavy, box: {size: [0.2, 0.2, 0.2]}, position: [0, 0, 0.5]}
";

/// Springs that are too stiff together for the step: each alone is stable.
fn unstable(when: &str) -> String {
    let spring = |k: i32| {
        format!(
            "  - {{name: s{k}, a: world, b: a, position: [-1, 0, 0], position_b: [0, 0, 0], stiffness: 3.7e+6, rest: 0.9, {when}}}\n"
        )
    };
    let springs: String = (0..6).map(spring).collect();
    format!(
        "gravity: [0, 0, 0]
materials: {{m: {{density: 1000, friction: 0.5}}}}
bodies:
  - {{name: a, material: m, sphere: {{radius: 0.1}}}}
springs:
{springs}"
    )
}

#[test]
fn a_solver_that_has_not_converged_is_reported_and_counted() {
    let work = scratch();
    let at = |name: &str| work.path().join(name).to_str().unwrap().to_string();
    let model = at("overloaded.yaml");
    std::fs::write(&model, format!("# A load.\n{OVERLOADED}")).unwrap();
    let said = scree(&["simulate", &model, "-o", &at("run")]).fails(5);
    assert!(
        said.contains("warning: step ") && said.contains("residual") && said.contains("greatest between body"),
        "{said}"
    );
    assert_eq!(said.matches("warning: step").count(), said.matches("are counted").count(), "{said}");
    let index = RunReader::open(Path::new(&at("run"))).unwrap().index;
    assert!(index.complete);
    let residual = index.warnings.iter().find(|w| w.kind == "residual").unwrap();
    assert!(residual.steps > 10 && residual.first_step < 10, "{residual:?}");
    assert!(said.contains(&format!("residual in {} steps", residual.steps)), "{said}");

    // What a run says does not depend on where it was interrupted.
    scree(&["simulate", &model, "--until", "0.1", "-o", &at("two")]).fails(5);
    scree(&["simulate", &model, "--resume", "-o", &at("two")]).fails(5);
    assert_eq!(index.warnings, RunReader::open(Path::new(&at("two"))).unwrap().index.warnings);
}

#[test]
fn a_run_that_shall_stop_keeps_its_last_checkpoint() {
    let work = scratch();
    let at = |name: &str| work.path().join(name).to_str().unwrap().to_string();
    let model = at("later.yaml");
    // The springs act after the first checkpoints.
    let delayed = format!("duration: 0.2\ncheckpoint_interval: 0.05\n{}", unstable("from: 0.12"));
    std::fs::write(&model, format!("# Springs.\non_divergence: stop\n{delayed}")).unwrap();
    let said = scree(&["simulate", &model, "-o", &at("run")]).fails(4);
    assert!(said.contains(".state are kept") && said.contains("error: step 1"), "{said}");
    let last = sim::checkpoint::latest(Path::new(&at("run"))).unwrap().unwrap();
    let steps = sim::checkpoint::read(&last).unwrap().0.steps;
    assert!(steps == 100 || steps == 150, "{}", last.display());
    let index = RunReader::open(Path::new(&at("run"))).unwrap().index;
    assert!(!index.complete && index.warnings.len() == 1, "{:?}", index.warnings);
    let said = scree(&["simulate", &model, "-o", &at("x"), "--set", "on_divergence=go_on"]).fails(3);
    assert!(said.contains("on_divergence"), "{said}");
}

#[test]
fn a_violated_joint_is_reported() {
    let violated = "materials: {m: {density: 1000, friction: 0.5}}
bodies:
  - {name: a, material: m, box: {size: [0.2, 0.2, 0.2]}}
  - {name: b, material: m, box: {size: [0.2, 0.2, 0.2]}, position: [1, 0, 0], angular_velocity: [0, 20000, 0]}
joints:
  - {name: pin, kind: spherical, a: a, b: b, position: [0.5, 0, 0]}
";
    assert!(kinds(violated, 3).contains(&WarningKind::Joint));
    // A prescribed change of length is no violation.
    let actuator = "gravity: [0, 0, 0]
materials: {m: {density: 1000, friction: 0.5}}
bodies:
  - {name: a, material: m, box: {size: [0.2, 0.2, 0.2]}}
  - {name: b, material: m, box: {size: [0.2, 0.2, 0.2]}, position: [1, 0, 0]}
joints:
  - {name: rod, kind: distance, a: a, b: b, position: [0.1, 0, 0], position_b: [0.9, 0, 0], length: {ramp: {times: [0, 0.1], values: [0.8, 1.6]}}}
";
    assert_eq!(kinds(actuator, 150), []);
}

#[test]
fn what_is_well_is_not_reported() {
    // A rate that goes through zero, where round-off is all of it.
    let through_zero = "gravity: [0, 0, 0]
materials: {m: {density: 1000, friction: 0.5}}
bodies: [{name: a, material: m, box: {size: [0.2, 0.2, 0.2]}}]
joints: [{name: j, kind: prismatic, a: world, b: a, axis: [1, 0, 0], motor: {speed: {sine: {amplitude: 1, frequency: 5}}}}]
";
    assert_eq!(kinds(through_zero, 500), []);
    // A body without shapes that is held at first: the model has no extent.
    let held = "bodies: [{name: a, shapes: [], mass: 10, inertia: [0.1, 0.1, 0.1], held_until: 0.1}]
joints: [{name: j, kind: revolute, a: world, b: a, axis: [0, 1, 0]}]
";
    assert_eq!(kinds(held, 300), []);
}

#[test]
fn a_motor_that_is_held_up_is_reported() {
    let driven = |kind: &str, limits: &str, motor: &str| {
        format!(
            "step: 0.01
gravity: [0, 0, 0]
materials: {{m: {{density: 1000, friction: 0.5}}}}
bodies: [{{name: arm, material: m, box: {{size: [0.2, 0.2, 0.2]}}}}]
joints: [{{name: drive, kind: {kind}, a: world, b: arm, axis: [0, 0, 1], {limits} motor: {{{motor}}}}}]
"
        )
    };
    let ramp = "{ramp: {times: [0, 1], values: [0, 1]}}";
    for (kind, limits) in [("revolute", "limits: [-30, 30],"), ("prismatic", "limits: [-0.3, 0.3],")] {
        for motor in
            ["speed: 1".to_owned(), "speed: -0.5".to_owned(), format!("speed: {ramp}"), format!("motion: {ramp}")]
        {
            let free = kinds(&driven(kind, "", &motor), 150);
            assert_eq!(free, [], "{kind} {motor}");
            let mut sim = simulation(&driven(kind, limits, &motor));
            (0..150).for_each(|_| drop(sim.step()));
            let warned = &sim.state.watch.warnings;
            let is_motor = |w: &WarningCount| w.first.kind == WarningKind::Motor;
            let first = warned.iter().find(|w| is_motor(w)).unwrap_or_else(|| panic!("{kind} {motor}: {warned:?}"));
            assert!(first.first.message.contains("limit of") && first.first.step > 10, "{first:?}");
        }
    }
}

#[test]
fn energy_growth_without_a_cause_is_reported() {
    assert_eq!(kinds(&unstable("from: 0"), 20), [WarningKind::Energy]);
    // Two spheres that overlap by half are moved apart, and get no energy; they are named as long as they overlap deeply.
    let overlap = "gravity: [0, 0, 0]
solver: {recovery_speed: 5}
materials: {m: {density: 1000, friction: 0.5}}
bodies:
  - {name: a, material: m, sphere: {radius: 0.1}}
  - {name: b, material: m, sphere: {radius: 0.1}, position: [0.1, 0, 0]}
";
    let mut sim = simulation(overlap);
    let warnings: Vec<Warning> = (0..100).flat_map(|_| sim.step().warnings).collect();
    assert!(warnings.iter().all(|w| w.kind == WarningKind::Overlap), "{warnings:?}");
    let message = "bodies `a` and `b` overlap by 1.000e-1 m, 1.00 of the smaller one's inradius of 1.000e-1 m";
    assert!(warnings[0].step == 1 && warnings[0].message == message, "{warnings:?}");
    assert!((15..=25).contains(&warnings.len()), "apart by 5 m/s: {}", warnings.len());
    assert!((sim.state.position[1].x - sim.state.position[0].x - 0.2).abs() < 1e-6, "{}", sim.state.position[1]);
    assert_eq!(sim.state.velocity[1].length(), 0.0);
    // What a load, a motor, a spring or a body that comes adds has a cause.
    let body = "{name: a, material: m, sphere: {radius: 0.1}}";
    for cause in [
        "loads:\n  - {body: a, force: [1, 0, 0], value: 100}",
        "springs:\n  - {name: s, a: world, b: a, position: [-1, 0, 0], position_b: [0, 0, 0], stiffness: 4000, rest: 0.5}",
        "joints:\n  - {name: j, kind: prismatic, a: world, b: a, axis: [1, 0, 0], motor: {speed: 2}}",
    ] {
        let model = format!(
            "gravity: [0, 0, 0]\nmaterials: {{m: {{density: 1000, friction: 0.5}}}}\nbodies:\n  - {body}\n{cause}\n"
        );
        assert_eq!(kinds(&model, 1_000), [], "{cause}");
    }
    let comes = "materials: {m: {density: 1000, friction: 0.5}}
bodies:
  - {name: a, material: m, sphere: {radius: 0.1}, position: [0, 0, 1]}
  - {name: b, material: m, sphere: {radius: 0.1}, position: [0, 0, 40], velocity: [0, 0, -9], appears: 0.1}
";
    assert_eq!(kinds(comes, 300), []);
}

#[test]
fn swings_and_bounces_give_no_warning() {
    let pendulum = |length: f64, radius: f64, step: f64| {
        format!(
            "step: {step}
materials: {{m: {{density: 2000, friction: 0.5}}}}
bodies:
  - {{name: bob, material: m, sphere: {{radius: {radius}}}, position: [{length}, 0, 0]}}
joints:
  - {{name: pin, kind: revolute, a: world, b: bob, position: [0, 0, 0], axis: [0, 1, 0]}}
"
        )
    };
    for (length, radius, step) in [(1.0, 0.01, 1e-3), (1.0, 0.05, 1e-2), (0.01, 0.002, 1e-3)] {
        assert_eq!(kinds(&pendulum(length, radius, step), 3_000), [], "{length} m, {radius} m, {step} s");
    }
    for (restitution, step) in [(1.0, 1e-3), (0.9, 1e-2)] {
        let sphere = format!(
            "step: {step}
materials: {{m: {{density: 2000, friction: 0.5, restitution: {restitution}}}}}
bodies:
  - {{name: ground, material: m, plane: {{normal: [0, 0, 1]}}}}
  - {{name: sphere, material: m, sphere: {{radius: 0.01}}, position: [0, 0, 1.01]}}
"
        );
        assert_eq!(kinds(&sphere, 3_000), [], "restitution {restitution}, {step} s");
    }
}

#[test]
fn a_stiff_spring_hides_no_energy() {
    let model = "gravity: [0, 0, 0]
solver: {recovery_speed: 5}
materials: {m: {density: 1000, friction: 0.5}}
bodies:
  - {name: a, material: m, sphere: {radius: 0.1}}
  - {name: b, material: m, sphere: {radius: 0.1}, position: [0.5, 0, 0]}
  - {name: c, material: m, sphere: {radius: 0.1}, position: [9, 0, 0]}
springs:
  - {name: s, a: world, b: c, position: [8, 0, 0], position_b: [9, 0, 0], stiffness: 3.0e6, rest: 1.0}
";
    let mut sim = simulation(model);
    (0..5).for_each(|_| assert!(sim.step().warnings.is_empty()));
    // A sphere is thrown.
    sim.state.velocity[1].x = 5.0;
    let warnings = sim.step().warnings;
    assert_eq!(warnings.iter().map(|w| w.kind).collect::<Vec<_>>(), [WarningKind::Energy]);
}

#[test]
fn what_is_not_finite_stops_a_run() {
    let sphere =
        "materials: {m: {density: 1000, friction: 0.5}}\nbodies:\n  - {name: a, material: m, sphere: {radius: 0.1}}\n";
    for (speed, said) in [(f64::NAN, "not finite"), (f64::INFINITY, "not finite"), (2e5, "m/s")] {
        let mut sim = simulation(sphere);
        assert!(sim.step().broken.is_none());
        sim.state.velocity[0].y = speed;
        let broken = sim.step().broken.unwrap();
        assert!(broken.body == Some(0) && broken.why.contains(said), "{broken:?}");
    }
}

/// A load is what outweighs all others by far. It is thrown up again and again here, as by a bed whose solve is cut off.
#[test]
fn a_load_that_swings_is_reported() {
    let swings = |mass: f64, every: usize| {
        let mut sim = simulation(&format!(
            "materials: {{m: {{density: 1000, friction: 0.5}}}}
bodies:
  - {{name: load, material: m, mass: {mass}, sphere: {{radius: 0.1}}}}
  - {{name: grain, material: m, mass: 0.1, sphere: {{radius: 0.1}}, position: [5, 0, 0]}}
"
        ));
        let mut steps = vec![];
        for k in 1..=2000 {
            if k % every == 0 {
                sim.state.velocity[0].z = 0.5 * 9.81 * 1e-3 * every as f64;
            }
            steps.extend(sim.step().warnings.into_iter().filter(|w| w.kind == WarningKind::Swing).map(|w| w.step));
        }
        steps
    };
    // Two turns a throw, from the time on when loads are looked for.
    let steps = swings(200.0, 20);
    assert!(steps.first().is_some_and(|first| (400..=500).contains(first)), "{:?}", steps.first());
    assert_eq!(swings(200.0, 500), [0; 0], "a ball that bounces now and then");
    assert_eq!(swings(50.0, 20), [0; 0], "no load");
}

/// A knee of two light links that carries a load on a vertical guide and passes its straight line, faster than a step resolves: the energy of
/// its swing goes, and that is said. With heavier links it is kept, and nothing is said.
#[test]
fn energy_that_joints_lose_is_reported() {
    let knee = |link: f64| {
        format!(
            "step: 1e-3
materials: {{m: {{density: 1000, friction: 0}}}}
bodies:
  - {{name: upper, shapes: [], mass: {link}, inertia: [1e-3, 1e-3, 1e-4], position: [0.05, 0, -0.0866025403784], rotate: {{axis: [0, 1, 0], angle: -30}}}}
  - {{name: lower, shapes: [], mass: {link}, inertia: [1e-3, 1e-3, 1e-4], position: [0.05, 0, -0.2598076211353], rotate: {{axis: [0, 1, 0], angle: 30}}}}
  - {{name: load, shapes: [], mass: 20, inertia: [0.01, 0.01, 0.01], position: [0, 0, -0.3464101615138]}}
joints:
  - {{name: top, kind: revolute, a: world, b: upper, position: [0, 0, 0], axis: [0, 1, 0]}}
  - {{name: knee, kind: revolute, a: upper, b: lower, position: [0.1, 0, -0.1732050807569], axis: [0, 1, 0]}}
  - {{name: foot, kind: revolute, a: lower, b: load, position: [0, 0, -0.3464101615138], axis: [0, 1, 0]}}
  - {{name: guide, kind: prismatic, a: world, b: load, position: [0, 0, 0], axis: [0, 0, 1]}}
"
        )
    };
    assert_eq!(kinds(&knee(0.02), 1_000), [WarningKind::Energy]);
    assert_eq!(kinds(&knee(20.0), 1_000), []);
}

#[test]
fn joints_beyond_their_limits_are_reported() {
    // A rope that is tied to a bob when it has come too far, or not so far.
    let rope = |length: f64| {
        format!(
            "step: 1e-3
materials: {{m: {{density: 7800, friction: 0}}}}
gravity: [0, 0, 0]
bodies:
  - {{name: bob, material: m, sphere: {{radius: 0.02}}, position: [0.3, 0, 0], velocity: [0.5, 0, 0]}}
joints:
  - {{name: rope, kind: distance, a: world, b: bob, position_b: [0.3, 0, 0], limits: [0, {length}], from: 0.05}}
"
        )
    };
    assert_eq!(kinds(&rope(0.31), 200), [WarningKind::Joint]);
    assert_eq!(kinds(&rope(0.33), 200), []);
    let mut sim = simulation(&rope(0.31));
    (0..51).for_each(|_| drop(sim.step()));
    let [now, length] = [sim.state.joints[0].violation, sim.state.position[0].length()];
    // That of the step's start.
    assert!(now > 1e-2 && (now - (length - 0.31)).abs() < 2e-3, "{now} m of {length} m");
}
