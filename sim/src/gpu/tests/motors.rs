//! Motors with a maximum torque or force on a device against the CPU back end's.

use super::joints::{both, reactions, resolved};
use super::whole::apart;
use crate::{Method, SolverSettings};

const HEAD: &str =
    "name: test\nstep: 0.001\nduration: 1\nframe_rate: 10\nmaterials: {m: {density: 800, friction: 0.4}}\n";

/// A flywheel that comes to its speed, a lift that is too heavy, a servo that a load pushes off its path, and an arm of three motors.
#[test]
fn motors_without_contacts_are_those_of_the_cpu() {
    let mut text = HEAD.to_string() + "pass_through: [[g, g]]\nbodies:\n";
    for (name, x) in [("wheel", 0.0), ("lift", 2.0), ("servo", 4.0), ("a", 6.0), ("b", 6.4), ("c", 6.8)] {
        text += &format!(
            "  - {{name: {name}, material: m, group: g, position: [{x}, 0, 0], box: {{size: [0.3, 0.2, 0.2]}}}}\n"
        );
    }
    text += "joints:
  - {name: j0, kind: revolute, a: world, b: wheel, motor: {speed: 5, max_torque: 1.5}}
  - {name: j1, kind: prismatic, a: world, b: lift, position: [2, 0, 0], motor: {speed: 0.1, max_force: {step: {at: 0.2, before: 90, after: 200}}}}
  - {name: j2, kind: revolute, a: world, b: servo, position: [4, 0, 0], motor: {motion: {sine: {amplitude: 0.2, frequency: 0.5}}, max_torque: 2}}
  - {name: j3, kind: revolute, a: world, b: a, position: [5.8, 0, 0], axis: [0, 1, 0], motor: {motion: 0.3, max_torque: 40}}
  - {name: j4, kind: revolute, a: a, b: b, position: [6.2, 0, 0], axis: [0, 1, 0], motor: {speed: -2, max_torque: 9}}
  - {name: j5, kind: revolute, a: b, b: c, position: [6.6, 0, 0], axis: [0, 1, 0], limits: [-20, 20], motor: {speed: 1, max_torque: 6}}
loads:
  - {body: servo, torque: [0, 0, 1], value: 3, from: 0.1, until: 0.25}
";
    let (model, state) = resolved(text);
    let Some(pair) = both(&model, &state, 400) else { return };
    let off = apart(&pair[0].state, &pair[1].state);
    let [own, cpu] = pair.each_ref().map(|s| &s.state.joints);
    eprintln!("{off} m, reactions to {}", reactions(&pair));
    assert!(off < 1e-5 && reactions(&pair) < 1e-3, "{off} m, reactions to {}", reactions(&pair));
    assert!(own.iter().zip(cpu).all(|(a, b)| a.motor_side == b.motor_side), "{own:?} {cpu:?}");
    // 1.5 N m on 9.6 kg of 0.3 by 0.2 m, until it has 5 rad/s.
    assert!((own[0].rate - 5.0).abs() < 1e-6 && own[0].motor_side == 0.0, "{}", own[0].rate);
}

/// An arm that presses on a post, a plough that stalls in blocks, and one that pushes them.
#[test]
fn motors_among_contacts_are_those_of_the_cpu() {
    let mut text = HEAD.to_string() + "bodies:\n  - {name: ground, material: m, plane: {normal: [0, 0, 1]}}\n";
    text += "  - {name: arm, material: m, position: [0.4, 3, 1], box: {size: [0.8, 0.1, 0.1]}}
  - {name: post, material: m, fixed: true, position: [0.7, 3.3, 1], sphere: {radius: 0.1}}\n";
    for (name, y) in [("weak", 0.0), ("strong", 1.5)] {
        text += &format!(
            "  - {{name: {name}, material: m, position: [-0.205, {y}, 0.16], box: {{size: [0.1, 0.6, 0.3]}}}}\n"
        );
        for k in 0..4 {
            let x = 0.31 * k as f64;
            text += &format!(
                "  - {{name: {name}{k}, material: m, position: [{x}, {y}, 0.1], box: {{size: [0.3, 0.3, 0.2]}}}}\n"
            );
        }
    }
    text += "joints:
  - {name: turn, kind: revolute, a: world, b: arm, position: [0, 3, 1], motor: {speed: 3, max_torque: 25}}
  - {name: weak, kind: prismatic, a: world, b: weak, position: [-0.205, 0, 0.16], axis: [1, 0, 0], motor: {speed: 0.5, max_force: 40}}
  - {name: strong, kind: prismatic, a: world, b: strong, position: [-0.205, 1.5, 0.16], axis: [1, 0, 0], motor: {motion: {ramp: {times: [0, 1], values: [0, 0.5]}}, max_force: 1000}}
";
    let (mut model, state) = resolved(text);
    for method in [Method::Apgd, Method::GaussSeidel] {
        model.solver =
            SolverSettings { iterations: Some(300), tolerance: 1e-8, method: Some(method), ..model.solver.clone() };
        let Some(pair) = both(&model, &state, 300) else { return };
        let off = apart(&pair[0].state, &pair[1].state);
        let own = &pair[0].state.joints;
        eprintln!(
            "{method:?}: {off} m, reactions to {}, {:?}",
            reactions(&pair),
            own.iter().map(|j| j.rate).collect::<Vec<_>>()
        );
        assert!(off < 2e-4, "{method:?}: {off} m");
        // 25 N m against the post, 40 N against a block of 14.4 kg, which friction holds by up to 56 N.
        assert!((own[0].torque_world.z + 25.0).abs() < 1e-3 && own[0].motor_side == 1.0, "{:?}", own[0]);
        assert!((own[1].force_world.x + 40.0).abs() < 1e-3 && own[1].rate.abs() < 1e-3, "{:?}", own[1]);
        assert!((own[2].rate - 0.5).abs() < 1e-3 && own[2].motor_side == 0.0, "{:?}", own[2]);
    }
}
