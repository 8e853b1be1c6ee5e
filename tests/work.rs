//! The work of motors, actuators, loads and preloads, and energy that comes beyond it.

use crate::analytic::{close, run, simulation};
use crate::cli::{scratch, scree};
use sim::Simulation;
use sim::watch::WarningKind;

const G: f64 = 9.81;

/// A model of bodies without shapes, and what drives them.
fn driven(rest: &str) -> Simulation {
    simulation(&format!("step: 1e-3\nmaterials: {{m: {{density: 1000, friction: 0.3}}}}\n{rest}"))
}

/// Kinetic, potential and elastic energy, J.
fn energy(sim: &Simulation) -> f64 {
    let (state, model) = (&sim.state, &sim.model);
    state.kinetic_energy(model) + state.potential_energy(model) + state.elastic_energy(model)
}

/// Work of motors, actuators and preloads, J.
fn of_motors(sim: &Simulation) -> f64 {
    let springs: f64 = sim.state.springs.iter().map(|s| s.work).sum();
    sim.state.joints.iter().map(|j| j.work).sum::<f64>() + springs
}

/// Run for `seconds` without a warning. Returns the least and the greatest of what is dissipated, over the greatest kinetic energy.
fn dissipated(sim: &mut Simulation, seconds: f64) -> [f64; 2] {
    let start = energy(sim);
    let (mut range, mut kinetic) = ([0.0f64; 2], 0.0f64);
    for _ in 0..(seconds / sim.model.step).round() as usize {
        let report = sim.step();
        assert!(report.warnings.is_empty(), "{:?}", report.warnings);
        let given = of_motors(sim) + sim.state.load_work + sim.state.arrived;
        let lost = given + start - energy(sim);
        range = [range[0].min(lost), range[1].max(lost)];
        kinetic = kinetic.max(sim.state.kinetic_energy(&sim.model));
    }
    range.map(|lost| lost / kinetic)
}

#[test]
fn motors_and_brakes_do_the_work_that_wheels_gain_and_lose() {
    let wheel = |rate: f64, motor: &str| {
        driven(&format!(
            "bodies: [{{name: wheel, shapes: [], mass: 2, inertia: [0.1, 0.2, 0.3], angular_velocity: [0, 0, {rate}]}}]
joints: [{{name: j, kind: revolute, a: world, b: wheel, motor: {{{motor}}}}}]\n"
        ))
    };
    // To 5 rad/s, by a torque that is bounded, by any, and by a given one; and a brake.
    for (rate, motor, work, effort) in [
        (0.0, "speed: 5, max_torque: 0.6", 3.75, 0.6),
        (0.0, "speed: 5", 3.75, 1500.0),
        (0.0, "torque: 0.75", 3.75, 0.75),
        (10.0, "speed: 0, max_torque: 1.5", -15.0, -1.5),
    ] {
        let mut sim = wheel(rate, motor);
        let start = energy(&sim);
        sim.step();
        close(sim.state.joints[0].effort, effort, 1e-5, motor);
        run(&mut sim, 2.0);
        if motor.starts_with("speed: 5,") {
            run(&mut sim, 3.0);
        }
        close(sim.state.joints[0].work, work, 1e-6, motor);
        close(energy(&sim) - start, work, 1e-6, motor);
    }
}

#[test]
fn what_is_lifted_has_the_work_that_lifts_it() {
    let body = "bodies: [{name: b, shapes: [], mass: 8, inertia: [0.1, 0.2, 0.3], position: [0, 0, -1]}]\n";
    let rod = "joints: [{name: rod, kind: distance, a: world, b: b, position: [0, 0, 0], position_b: [0, 0, -1], length: {ramp: {times: [0.5, 1.5], values: [1, 0.5]}}}]\n";
    let mut sim = driven(&format!("{body}{rod}"));
    run(&mut sim, 1.0);
    // It pulls: B is not pushed away.
    close(sim.state.joints[0].effort, -8.0 * G, 1e-3, "force of the rod");
    run(&mut sim, 2.0);
    close(sim.state.joints[0].work, 8.0 * G * 0.5, 1e-6, "work of the rod");
    let arm = "bodies: [{name: arm, shapes: [], mass: 8, inertia: [0.1, 0.6, 0.6], position: [0.5, 0, 0]}]
joints: [{name: j, kind: revolute, a: world, b: arm, position: [0, 0, 0], axis: [0, -1, 0], motor: {motion: {ramp: {times: [0.2, 2], values: [0, 1.5]}}}}]\n";
    let mut sim = driven(arm);
    run(&mut sim, 3.0);
    close(sim.state.joints[0].work, 8.0 * G * 0.5 * 1.5f64.sin(), 1e-6, "work of the servo");
}

/// A crank whose motor speeds up, and a spring whose preload grows, keep what they are given: no friction takes any.
#[test]
fn mechanisms_keep_the_work_that_they_are_given() {
    let crank = "gravity: [0, 0, 0]
bodies:
  - {name: crank, shapes: [], mass: 1, inertia: [1e-3, 1e-2, 1e-2], position: [0.1, 0, 0]}
  - {name: rod, shapes: [], mass: 1, inertia: [1e-3, 2e-2, 2e-2], position: [0.4, 0, 0]}
  - {name: slider, shapes: [], mass: 3, inertia: [1e-2, 1e-2, 1e-2], position: [0.6, 0, 0]}
joints:
  - {name: shaft, kind: revolute, a: world, b: crank, position: [0, 0, 0], axis: [0, 1, 0], motor: {speed: {ramp: {times: [0, 1], values: [0, 20]}}}}
  - {name: pin, kind: revolute, a: crank, b: rod, position: [0.2, 0, 0], axis: [0, 1, 0]}
  - {name: wrist, kind: revolute, a: rod, b: slider, position: [0.6, 0, 0], axis: [0, 1, 0]}
  - {name: guide, kind: prismatic, a: world, b: slider, position: [0.6, 0, 0], axis: [1, 0, 0]}
";
    let spring = "bodies: [{name: b, shapes: [], mass: 8, inertia: [0.1, 0.1, 0.1], position: [0, 0, -1]}]
springs: [{name: s, a: world, b: b, position: [0, 0, 0], position_b: [0, 0, -1], stiffness: 4000, rest: 1, preload: {ramp: {times: [0.5, 0.7], values: [0, 500]}}}]\n";
    // An explicit spring lets energy swing by h F·v/2.
    let stretched = "gravity: [0, 0, 0]
bodies: [{name: b, shapes: [], mass: 1, inertia: [0.1, 0.1, 0.1], position: [1.1, 0, 0]}]
springs: [{name: s, a: world, b: b, position: [0, 0, 0], position_b: [1.1, 0, 0], stiffness: 1000, rest: 1}]\n";
    for (model, seconds, bound) in [(crank, 5.0, 5e-4), (spring, 2.0, 0.1), (stretched, 2.0, 0.02)] {
        let [least, most] = dissipated(&mut driven(model), seconds);
        assert!(least > -bound && most < bound, "{least:.1e} to {most:.1e} of the kinetic energy");
    }
}

/// A block that a force pushes over the ground, one that comes later, and another that is let go.
#[test]
fn friction_takes_what_a_load_gives() {
    let mut sim = driven(
        "solver: {friction: exact}
bodies:
  - {name: ground, material: m, plane: {normal: [0, 0, 1]}}
  - {name: b, material: m, mass: 8, box: {size: [0.2, 0.2, 0.2]}, position: [0, 0, 0.1]}
  - {name: late, material: m, mass: 2, box: {size: [0.2, 0.2, 0.2]}, position: [0, 3, 0.1], velocity: [1, 0, 0], appears: 0.5}
  - {name: held, material: m, mass: 4, box: {size: [0.2, 0.2, 0.2]}, position: [0, 6, 0.3], held_until: 0.7}
loads: [{body: b, force: [1, 0, 0], value: 40}]\n",
    );
    let start = energy(&sim);
    run(&mut sim, 2.0);
    let way = sim.state.position[1].x;
    close(sim.state.load_work, 40.0 * way, 1e-3, "work of the force");
    close(sim.state.arrived, 2.0 * G * 0.1 + 1.0 + 4.0 * G * 0.3, 1e-9, "energy of what came");
    let lost = sim.state.load_work + sim.state.arrived + start - energy(&sim);
    close(lost, 0.3 * 8.0 * G * way + 1.0 + 4.0 * G * 0.2, 2e-3, "what friction and the fall have taken");
}

/// Springs that are too stiff together for the step, beside a motor that works and a load: neither hides them.
#[test]
fn energy_beyond_the_work_of_a_motor_is_reported() {
    let spring = |k: i32| {
        format!(
            "  - {{name: s{k}, a: world, b: a, position: [-1, 0, 0], position_b: [0, 0, 0], stiffness: 3.7e+6, rest: 0.9}}\n"
        )
    };
    let springs: String = (0..6).map(spring).collect();
    let mut sim = driven(&format!(
        "gravity: [0, 0, 0]
bodies:
  - {{name: a, material: m, sphere: {{radius: 0.1}}}}
  - {{name: wheel, shapes: [], mass: 2, inertia: [0.1, 0.2, 0.3], position: [3, 0, 0]}}
  - {{name: pushed, shapes: [], mass: 2, inertia: [0.1, 0.2, 0.3], position: [6, 0, 0]}}
joints: [{{name: j, kind: revolute, a: world, b: wheel, position: [3, 0, 0], motor: {{torque: 2}}}}]
loads: [{{body: pushed, force: [1, 0, 0], value: 5}}]
springs:
{springs}"
    ));
    let warnings: Vec<_> = (0..20).flat_map(|_| sim.step().warnings).collect();
    assert!(warnings.iter().all(|w| w.kind == WarningKind::Energy), "{warnings:?}");
    let said = &warnings.first().expect("a warning").message;
    assert!(said.contains("beyond what motors and loads have given"), "{said}");
}

/// Work is in the probes of what does work alone, goes on after a restart, and is balanced on the page of a run.
#[test]
fn work_is_written_and_balanced() {
    let work = scratch();
    let at = |name: &str| work.path().join(name).to_str().unwrap().to_string();
    let model = "duration: 0.4\nframe_rate: 10\ncheckpoint_interval: 0.1
materials: {m: {density: 1000, friction: 0.3}}
bodies:
  - {name: ground, material: m, plane: {normal: [0, 0, 1]}}
  - {name: b, material: m, box: {size: [0.2, 0.2, 0.2]}, position: [0, 0, 0.1]}
  - {name: wheel, shapes: [], mass: 2, inertia: [0.1, 0.2, 0.3], position: [3, 0, 0]}
joints:
  - {name: driven, kind: revolute, a: world, b: wheel, position: [3, 0, 0], motor: {speed: 5, max_torque: 0.6}}
loads: [{body: b, force: [1, 0, 0], value: 40}]
";
    std::fs::write(at("m.yaml"), model).unwrap();
    scree(&["simulate", &at("m.yaml"), "-o", &at("run"), "--csv"]).ok();
    let probes = |run: &str| std::fs::read_to_string(at(run) + "/probes.csv").unwrap();
    let whole = probes("run");
    let (head, rows) = whole.split_once('\n').unwrap();
    let names = [
        "driven.violation [m or rad],driven.effort [N m],driven.work [J]",
        "energy.potential [J],work.motors [J],work.loads [J],contacts.",
    ];
    assert!(names.iter().all(|name| head.contains(name)) && !head.contains("elastic"), "{head}");
    let place = head.split(',').position(|name| name == "work.motors [J]").unwrap();
    let last = rows.lines().last().unwrap().split(',').nth(place).unwrap();
    // Half of 0.3 kg m² times the square of 0.8 rad/s.
    close(last.parse().unwrap(), 0.096, 1e-6, "work of the motor");
    scree(&["simulate", &at("m.yaml"), "-o", &at("two"), "--csv", "--until", "0.2"]).ok();
    scree(&["simulate", &at("m.yaml"), "-o", &at("two"), "--csv", "--resume"]).ok();
    assert_eq!(probes("two"), whole);
    let page = scree(&["report", &at("run")]).ok().trim().to_string();
    let page = std::fs::read_to_string(page).unwrap();
    let parts = ["<td>work of motors</td>", "<td>work of loads</td>", "<td>dissipated</td>"];
    assert!(parts.iter().all(|part| page.contains(part)), "{parts:?}");
}
