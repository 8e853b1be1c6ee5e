//! Joints, motors, springs and loads on a device against the CPU back end's.

use super::whole::{apart, on_device, steps, written};
use crate::fill::SplitMix64;
use crate::model_file::ModelFile;
use crate::simulation::Simulation;
use crate::{FrictionLaw, Method, Model, SolverSettings, State};
use frame::yaml;
use std::path::Path;

/// The head of a model.
const HEAD: &str =
    "name: test\nstep: 0.001\nduration: 1\nframe_rate: 10\nmaterials: {m: {density: 800, friction: 0.4}}\n";

pub fn resolved(text: String) -> (Model, State) {
    let (file, doc) = yaml::parse::<ModelFile>(Path::new("test.yaml"), text).expect("sound YAML");
    let resolved = file.resolve(&doc).unwrap_or_else(|e| panic!("{e}"));
    (resolved.model, resolved.state)
}

/// Step a model on both back ends; both in this order, none without a device.
pub fn both(model: &Model, state: &State, n: usize) -> Option<[Simulation; 2]> {
    let mut own = on_device(model, state)?;
    let mut cpu = Simulation::new(model.clone(), state.clone());
    for _ in 0..n {
        for simulation in [&mut own, &mut cpu] {
            let report = simulation.step();
            assert!(report.broken.is_none(), "{report:?}");
        }
    }
    own.fetch().unwrap();
    Some([own, cpu])
}

/// Greatest difference of the reactions of joints, over the greatest.
pub fn reactions([own, cpu]: &[Simulation; 2]) -> f64 {
    let pairs = || own.state.joints.iter().zip(&cpu.state.joints);
    let most = pairs().map(|(_, b)| b.force_world.length()).fold(1e-9, f64::max);
    pairs().map(|(a, b)| (a.force_world - b.force_world).length()).fold(0.0, f64::max) / most
}

/// Bodies on a jittered lattice with joints of all kinds between neighbours, of which closed loops and redundant rows follow; stiff and soft
/// springs; motors. Nothing touches.
fn mechanism(n: usize) -> String {
    const KINDS: [&str; 8] =
        ["spherical", "revolute", "universal", "fixed", "cylindrical", "prismatic", "point_on_plane", "distance"];
    let mut random = SplitMix64(8);
    let (mut bodies, mut joints, mut springs) =
        ("bodies:\n".to_string(), "joints:\n".to_string(), "springs:\n".to_string());
    for k in 0..n * n {
        let (i, j) = (k / n, k % n);
        let at = [i as f64, j as f64, random.between(-0.2, 0.2)];
        let size = random.between(0.2, 0.9);
        bodies += &format!(
            "  - {{name: b{i}_{j}, material: m, group: g, position: {at:?}, box: {{size: [0.3, 0.5, {size}]}}}}\n"
        );
        for (a, b) in [(i.wrapping_sub(1), j), (i, j.wrapping_sub(1))] {
            let other = if a < n && b < n { format!("b{a}_{b}") } else { "world".into() };
            let kind = KINDS[random.below(8)];
            let more = match kind {
                "spherical" => String::new(),
                "distance" => format!(", position_b: [{}, {}, {}]", at[0], at[1] + 0.1, at[2]),
                "revolute" if k % 3 == 0 => ", axis: [0, 0, 1], motor: {speed: 0.5}".into(),
                "prismatic" => ", axis: [0, 0, 1], motor: {force: {sine: {amplitude: 20, frequency: 9}}}".into(),
                _ => ", axis: [0, 0, 1]".into(),
            };
            let (x, y) = (at[0] - 0.5, at[1] - 0.4);
            joints += &format!(
                "  - {{name: j{i}_{j}_{a}_{b}, kind: {kind}, a: {other}, b: b{i}_{j}, position: [{x}, {y}, 0.1]{more}}}\n"
            );
        }
        if i > 1 {
            let (other, stiffness) = (i - 2, [1.0e7, 300.0][k % 2]);
            springs += &format!(
                "  - {{name: s{i}_{j}, a: b{other}_{j}, b: b{i}_{j}, position: [{other}, {j}, 0], position_b: [{i}, {j}, 0.1], stiffness: {stiffness}, damping: 20}}\n"
            );
        }
    }
    let springs = if n > 2 { springs } else { String::new() };
    HEAD.to_string() + "pass_through: [[g, g]]\n" + &bodies + &joints + &springs
}

/// Without contacts all of it is in double precision. Joints hold at the end of a step to a millionth of its way, which either comes to in its own way.
#[test]
fn mechanisms_without_contacts_are_those_of_the_cpu() {
    for n in [1, 2, 4] {
        let (model, state) = resolved(mechanism(n));
        let Some(pair) = both(&model, &state, 100) else { return };
        let off = apart(&pair[0].state, &pair[1].state);
        assert!(off < 5e-8 && reactions(&pair) < 1e-6, "{n}: {off} m, reactions to {}", reactions(&pair));
        let [own, cpu] = pair.each_ref().map(|s| &s.state);
        // A stiff spring has the force of where its ends are.
        for ((spring, a), b) in model.springs.iter().zip(&own.springs).zip(&cpu.springs) {
            let most = 1e-6 * b.force.abs().max(1.0) + 4.0 * off * spring.stiffness;
            assert!((a.force - b.force).abs() < most, "{n}: {} N, {} N", a.force, b.force);
        }
        assert_eq!(own.watch.warnings.len(), cpu.watch.warnings.len());
    }
}

/// Joints that equal limits lock, as a row more.
#[test]
fn joints_locked_by_equal_limits_are_those_of_the_cpu() {
    let text = HEAD.to_string()
        + "bodies:\n  - {name: a, material: m, position: [0, 0, 0], box: {size: [0.3, 0.2, 0.2]}}\n"
        + "  - {name: b, material: m, position: [0.5, 0, 0], box: {size: [0.3, 0.2, 0.2]}}\n"
        + "joints:\n  - {name: free, kind: revolute, a: world, b: a, position: [-0.3, 0, 0], axis: [0, 1, 0]}\n"
        + "  - {name: locked, kind: revolute, a: a, b: b, position: [0.25, 0, 0], axis: [0, 1, 0], limits: [0, 0]}\n";
    let (model, state) = resolved(text);
    let Some(pair) = both(&model, &state, 100) else { return };
    let off = apart(&pair[0].state, &pair[1].state);
    let bent = pair[0].state.joints[1].coordinate;
    assert!(off < 1e-9 && reactions(&pair) < 1e-6 && bent.abs() < 1e-5, "{off} m, {bent} rad");
    assert!((pair[0].state.position[0] - state.position[0]).length() > 0.02);
}

/// Pendulums that swing into their limits and out of them, a rope that snaps taut, and a slide that comes to its end.
#[test]
fn limits_without_contacts_are_those_of_the_cpu() {
    let mut text = HEAD.to_string() + "pass_through: [[g, g]]\nbodies:\n";
    for (name, x) in [("a", 0.0), ("b", 0.4), ("c", 0.8), ("ball", 3.0), ("sled", 6.0)] {
        text += &format!(
            "  - {{name: {name}, material: m, group: g, position: [{x}, 0, 0], box: {{size: [0.3, 0.2, 0.2]}}}}\n"
        );
    }
    text += "joints:\n  - {name: j0, kind: revolute, a: world, b: a, position: [-0.2, 0, 0], axis: [0, 1, 0], limits: [-5, 20]}\n";
    text += "  - {name: j1, kind: revolute, a: a, b: b, position: [0.2, 0, 0], axis: [0, 1, 0], limits: [-15, 10]}\n";
    text += "  - {name: j2, kind: revolute, a: b, b: c, position: [0.6, 0, 0], axis: [0, 1, 0], limits: [-30, 6]}\n";
    text += "  - {name: rope, kind: distance, a: world, b: ball, position: [3, 0, 0.5], position_b: [3, 0, 0], limits: [0, 0.6]}\n";
    text += "  - {name: way, kind: prismatic, a: world, b: sled, position: [6, 0, 0], axis: [0.3, 0, -1], limits: [-1, 0.1]}\n";
    let (mut model, mut state) = resolved(text);
    state.angular_velocity[1] = glam::DVec3::Y * -2.0;
    state.angular_velocity[2] = glam::DVec3::Y * 3.0;
    model.solver = SolverSettings { iterations: Some(1000), tolerance: 1e-10, ..model.solver };
    let Some(pair) = both(&model, &state, 400) else { return };
    let off = apart(&pair[0].state, &pair[1].state);
    let [own, cpu] = pair.each_ref().map(|s| &s.state.joints);
    let turned: Vec<[f64; 2]> = own.iter().zip(cpu).map(|(a, b)| [a.coordinate, b.coordinate]).collect();
    eprintln!("{off} m, reactions to {}, coordinates {turned:?}", reactions(&pair));
    assert!(off < 1e-4 && reactions(&pair) < 1e-2, "{off} m");
    // All but the hinges between the links hang in their limits.
    assert!((own[0].coordinate - 20f64.to_radians()).abs() < 2e-3 && (own[3].coordinate - 0.6).abs() < 2e-3);
    assert!((own[4].coordinate - 0.1).abs() < 2e-3 && own[4].force_world.length() > 50.0);
}

/// A chain of plates whose hinges hardly turn, that falls over a block, and is pulled along.
#[test]
fn limits_among_contacts_are_those_of_the_cpu() {
    let mut text = HEAD.to_string() + "bodies:\n  - {name: ground, material: m, plane: {normal: [0, 0, 1]}}\n";
    text += "  - {name: block, material: m, fixed: true, position: [0.9, 0, 0.1], box: {size: [0.2, 0.6, 0.2]}}\n";
    for k in 0..8 {
        let x = 0.2 * k as f64;
        text +=
            &format!("  - {{name: p{k}, material: m, position: [{x}, 0, 0.25], box: {{size: [0.18, 0.4, 0.06]}}}}\n");
    }
    text += "joints:\n";
    for k in 1..8 {
        let (a, x) = (k - 1, 0.2 * k as f64 - 0.1);
        text += &format!(
            "  - {{name: j{k}, kind: revolute, a: p{a}, b: p{k}, position: [{x}, 0, 0.25], axis: [0, 1, 0], limits: [-4, 9]}}\n"
        );
    }
    let (mut model, state) = resolved(text);
    for method in [Method::Apgd, Method::GaussSeidel] {
        model.solver =
            SolverSettings { iterations: Some(200), tolerance: 1e-7, method: Some(method), ..model.solver.clone() };
        hold_limits(&model, &state);
    }
}

fn hold_limits(model: &Model, state: &State) {
    let Some(pair) = both(model, state, 100) else { return };
    let off = apart(&pair[0].state, &pair[1].state);
    let n = pair[1].state.contacts.len();
    let at_limit =
        pair[0].state.joints.iter().filter(|j| j.coordinate.to_degrees() > 8.9 || j.coordinate.to_degrees() < -3.9);
    let n_limits = at_limit.count();
    eprintln!("{n} contacts, {n_limits} hinges at their limits, {off} m, reactions to {}", reactions(&pair));
    assert!(n >= 2 && n_limits > 1 && off < 1e-4, "{n} contacts, {n_limits} at their limits, {off} m");
}

/// Loads of every kind, on spheres and on a box that slides.
#[test]
fn loads_act_as_on_the_cpu() {
    let ground = "bodies:\n  - {name: ground, material: m, plane: {normal: [0, 0, 1]}}\n";
    let balls: String = (0..5)
        .map(|k| {
            format!(
                "  - {{name: s{k}, material: m, position: [{}, 0, 0.1], sphere: {{radius: 0.1}}}}\n",
                0.4 * k as f64
            )
        })
        .collect();
    let block = "  - {name: block, material: m, position: [0, 1, 0.1], box: {size: [0.3, 0.2, 0.2]}}\n";
    let loads = "loads:\n  - {body: s0, force: [1, 0, 0], value: 20}\n\
        \x20 - {body: s1, torque: [0, 1, 0], value: {sine: {amplitude: 3, frequency: 20}}}\n\
        \x20 - {body: s2, force: [0, 0, 1], value: {step: {at: 0.03, before: 200, after: 0}}}\n\
        \x20 - {body: s3, force: [0, 1, 0], value: 15, frame: body, point: [0, 0, 0.1], from: 0.01, until: 0.08}\n";
    let on_block = "  - {body: block, force: [1, 0.2, 0], value: 60, frame: body, point: [0.1, 0, 0]}\n";
    let spheres = HEAD.to_string() + ground + &balls + loads;
    let solids = HEAD.to_string() + ground + &balls + block + loads + on_block;
    let sweeps = [(&spheres, Method::GaussSeidel), (&solids, Method::GaussSeidel)];
    for (text, method) in sweeps.into_iter().chain([(&spheres, Method::Apgd), (&solids, Method::Apgd)]) {
        let (mut model, state) = resolved(text.clone());
        model.solver = SolverSettings { iterations: Some(200), tolerance: 1e-8, method: Some(method), ..model.solver };
        let Some([own, cpu]) = both(&model, &state, 100) else { return };
        let off = apart(&own.state, &cpu.state);
        let moved = (cpu.state.position[1] - state.position[1]).length();
        eprintln!("{method:?}: {off} m of {moved} m");
        assert!(moved > 0.02 && off < 2e-5, "{method:?}: {off} m of {moved} m");
    }
}

/// A chain of plates with two pins each, as a track has them, that falls on the ground with a heavy block on a spring, and is pulled along
/// by a motor.
fn track(n: usize) -> String {
    let mut text = HEAD.to_string() + "bodies:\n  - {name: ground, material: m, plane: {normal: [0, 0, 1]}}\n";
    for k in 0..n {
        text += &format!(
            "  - {{name: p{k}, material: m, position: [{}, 0, 0.0305], box: {{size: [0.18, 0.4, 0.06]}}}}\n",
            0.2 * k as f64
        );
    }
    text += "  - {name: load, material: m, position: [1, 0, 0.4], box: {size: [0.5, 0.5, 0.3]}}\n";
    text += "  - {name: roller, material: m, position: [1, 0, 0.17], sphere: {radius: 0.1}}\n";
    text += "joints:\n";
    for k in 1..n {
        for (side, y) in [("left", -0.15), ("right", 0.15)] {
            let (a, x) = (k - 1, 0.2 * k as f64 - 0.1);
            text += &format!(
                "  - {{name: {side}{k}, kind: revolute, a: p{a}, b: p{k}, position: [{x}, {y}, 0.0305], axis: [0, 1, 0]}}\n"
            );
        }
    }
    text += "  - {name: axle, kind: revolute, a: load, b: roller, position: [1, 0, 0.17], axis: [0, 1, 0], motor: {torque: 8}}\n";
    text += "  - {name: pull, kind: prismatic, a: world, b: p0, position: [0, 0, 0.0305], axis: [1, 0, 0], motor: {speed: {ramp: {times: [0.02, 0.08], values: [0, -0.5]}}}, from: 0.02}\n";
    text += "springs:\n  - {name: stay, a: load, b: p7, position: [1.2, 0, 0.3], position_b: [1.4, 0, 0.06], stiffness: 2.0e5, damping: 100}\n";
    text
}

#[test]
fn joints_among_contacts_are_those_of_the_cpu() {
    let (mut model, state) = resolved(track(12));
    let laws = [
        (Method::Apgd, FrictionLaw::Relaxed),
        (Method::Jacobi, FrictionLaw::Relaxed),
        (Method::Apgd, FrictionLaw::Exact),
        (Method::GaussSeidel, FrictionLaw::Relaxed),
        (Method::GaussSeidel, FrictionLaw::Exact),
        (Method::BarzilaiBorwein, FrictionLaw::Relaxed),
    ];
    for (method, friction) in laws {
        let (iterations, n_steps) = if method == Method::Jacobi { (Some(1000), 40) } else { (Some(400), 80) };
        model.solver =
            SolverSettings { iterations, tolerance: 1e-7, method: Some(method), friction, ..model.solver.clone() };
        let Some(pair) = both(&model, &state, n_steps) else { return };
        let (off, forces) = (apart(&pair[0].state, &pair[1].state), reactions(&pair));
        let n = pair[1].state.contacts.len();
        eprintln!("{method:?} {friction:?}: {n} contacts, {off} m, reactions to {forces}");
        // An NVIDIA H100 comes to 1.07e-4 m by APGD with exact friction.
        assert!(n > 40 && off < 2e-4, "{method:?} {friction:?}: {off} m");
    }
}

/// A platform with so many pendulums that it is a hub, whose velocities stay unknowns.
#[test]
fn a_hub_among_contacts_is_that_of_the_cpu() {
    let mut text = HEAD.to_string() + "bodies:\n  - {name: ground, material: m, plane: {normal: [0, 0, 1]}}\n";
    text += "  - {name: hub, material: m, position: [0, 0, 0.151], box: {size: [6, 0.5, 0.3]}}\n";
    let mut joints = "joints:\n".to_string();
    for k in 0..30 {
        let x = 0.2 * k as f64 - 2.9;
        text += &format!("  - {{name: s{k}, material: m, position: [{x}, 0.5, 0.1], sphere: {{radius: 0.06}}}}\n");
        joints += &format!(
            "  - {{name: j{k}, kind: revolute, a: hub, b: s{k}, position: [{x}, 0.3, 0.15], axis: [1, 0, 0]}}\n"
        );
    }
    let (mut model, state) = resolved(text + &joints);
    model.solver = SolverSettings { iterations: Some(300), tolerance: 1e-7, ..model.solver };
    let Some(pair) = both(&model, &state, 100) else { return };
    let off = apart(&pair[0].state, &pair[1].state);
    eprintln!("{} contacts, {off} m, reactions to {}", pair[1].state.contacts.len(), reactions(&pair));
    assert!(pair[1].state.contacts.len() >= 4 && off < 1e-4, "{off} m");
}

/// A run with joints repeats bit for bit, also from its middle, which the processor takes up, too.
#[test]
fn a_run_with_joints_repeats_bit_for_bit_also_from_its_middle() {
    for method in [Method::Apgd, Method::GaussSeidel, Method::BarzilaiBorwein] {
        repeats(method);
    }
}

fn repeats(method: Method) {
    let (mut model, state) = resolved(track(8));
    model.solver = SolverSettings { iterations: Some(60), method: Some(method), ..model.solver };
    let Some(mut first) = on_device(&model, &state) else { return };
    let mut second = on_device(&model, &state).unwrap();
    steps(&mut first, 60);
    steps(&mut second, 30);
    let middle = written(&second.state);
    let mut on_cpu = Simulation::new(model.clone(), middle.clone());
    let mut second = second.restart(middle).unwrap();
    steps(&mut second, 30);
    let bits = |s: &State| -> Vec<u64> {
        let vectors = [&s.position, &s.velocity, &s.angular_velocity, &s.contacts.impulse];
        let vectors = vectors.into_iter().flatten().flat_map(|v| v.to_array());
        let joints = s.joints.iter().flat_map(|j| j.force.to_array());
        vectors.chain(joints).chain(s.orientation.iter().flat_map(|q| q.to_array())).map(f64::to_bits).collect()
    };
    assert!(bits(&first.state) == bits(&second.state));
    steps(&mut on_cpu, 30);
    let off = apart(&first.state, &on_cpu.state);
    assert!(first.state.contacts.len() > 20 && off < 1e-3, "{off} m");
}

/// A joint that begins and one that ends: their bodies touch while they do not act.
#[test]
fn bodies_touch_while_their_joint_does_not_act_as_on_the_cpu() {
    let mut text = HEAD.to_string()
        + "solver: {method: gauss_seidel, iterations: 40}\nbodies:\n  - {name: ground, material: m, plane: {normal: [0, 0, 1]}}\n";
    for (name, x, z) in [("a", 0.0, 0.1), ("b", 0.0, 0.3), ("c", 1.0, 0.1), ("d", 1.0, 0.3)] {
        text +=
            &format!("  - {{name: {name}, material: m, box: {{size: [0.2, 0.2, 0.2]}}, position: [{x}, 0, {z}]}}\n");
    }
    text += "joints:
  - {name: later, kind: fixed, a: a, b: b, position: [0, 0, 0.2], from: 0.05}
  - {name: first, kind: fixed, a: c, b: d, position: [1, 0, 0.2], until: 0.05}
";
    let (model, state) = resolved(text);
    let Some(pair) = both(&model, &state, 100) else { return };
    let off = apart(&pair[0].state, &pair[1].state);
    let heights: Vec<f64> = pair[0].state.position[1..].iter().map(|p| p.z).collect();
    assert!(off < 1e-5, "{off} m: {heights:?}");
    assert!(heights.iter().zip([0.1, 0.3, 0.1, 0.3]).all(|(z, at)| (z - at).abs() < 1e-3), "{heights:?}");
}
