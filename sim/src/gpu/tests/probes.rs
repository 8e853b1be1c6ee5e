//! Lines of the probes, which a device sums, against those of the state that it gives back.

use super::device;
use crate::model_file::ModelFile;
use crate::probe::{Sums, probe_line};
use crate::simulation::Simulation;
use frame::yaml;
use gpu::{Choice, Device};
use std::path::Path;

/// Grains that fall on a floor, among which a body is found by its name.
const GRAINS: &str = "name: probes
step: 0.001
duration: 1
frame_rate: 10
materials: {grain: {density: 2500, friction: 0.45}}
solver: {method: gauss_seidel, iterations: 20}
bodies:
  - {name: floor, material: grain, plane: {normal: [0, 0, 1]}}
  - {name: ball, material: grain, position: [0.3, 0, 0.03], velocity: [-1, 0, 0], sphere: {radius: 0.03}}
fills: [{name: grains, material: grain, count: 300, radius: [0.02, 0.025], min: [-0.2, -0.2, 0], max: [0.2, 0.2, 0.8], packing: hexagonal}]
probes: {contacts: [{name: on_floor, between: [grains, floor]}, {name: of_ball, between: [ball, grains]}]}
";

/// The same before a plough that a motor drives, which the processor keeps.
const PLOUGH: &str = "
  - {name: plough, material: grain, box: {size: [0.02, 0.3, 0.2]}, position: [-0.23, 0, 0.11]}
joints:
  - {name: drive, kind: prismatic, a: world, b: plough, position: [-0.23, 0, 0.11], axis: [1, 0, 0], motor: {speed: 0.5}}
fills";

#[test]
fn lines_of_probes_are_those_of_the_state() {
    for text in [GRAINS.to_string(), GRAINS.replace("gauss_seidel", "apgd").replace("\nfills", PLOUGH)] {
        let (file, doc) = yaml::parse::<ModelFile>(Path::new("test.yaml"), text).expect("sound YAML");
        let resolved = file.resolve(&doc).unwrap_or_else(|e| panic!("{e}"));
        let (model, probes) = (resolved.model, resolved.probes);
        assert_eq!((probes.bodies.len(), probes.contacts.len()), (1 + model.joints.len(), 2));
        if device().is_none() {
            return;
        }
        let device = Device::open(&Choice::Any).unwrap();
        let mut own = Simulation::on_device(model, resolved.state, device).unwrap();
        let mut forces = 0.0f64;
        for steps in [0, 1, 1, 60, 1, 1, 60] {
            (0..steps).for_each(|_| drop(own.step()));
            let before = own.device_usage().unwrap().traffic;
            let line = own.probe_line(&probes).unwrap();
            let read = (own.device_usage().unwrap().traffic - before).bytes_read;
            assert!(read < 400, "{read} bytes for a line");
            own.fetch().unwrap();
            let sums = Sums::of(&own.model, &own.state, &probes);
            let of_state = probe_line(&own.model, &own.state, &probes, &sums);
            let numbers = |line: &str| -> Vec<f64> { line.trim().split(',').map(|x| x.parse().unwrap()).collect() };
            let (a, b) = (numbers(&line), numbers(&of_state));
            let n_sums = 4 + own.model.joints.len() + 4 * probes.contacts.len();
            let n_own = a.len() - n_sums;
            // What is known of bodies and joints is the same; sums are those of single precision.
            assert_eq!(a[..n_own], b[..n_own]);
            let scale = b[n_own..].iter().fold(0.0, |m: f64, x| m.max(x.abs()));
            for (x, y) in a[n_own..].iter().zip(&b[n_own..]) {
                assert!((x - y).abs() < 1e-5 * scale.min(y.abs().max(1e-3)), "{x} for {y}: {line}\n{of_state}");
            }
            forces = forces.max(sums.between[0].1.z.abs());
        }
        // The weight of grains that lie on the floor.
        assert!(forces > 1.0, "{forces} N");
    }
}
