//! Steps of which some stages are the processor's and the others the device's.

use super::joints::resolved;
use super::surfaces::{layers, over_ground, solids};
use super::whole::{apart, bed, on_device_from, settings, written};
use super::{device, vector};
use crate::fill::SplitMix64;
use crate::gpu::bin_emit::emit_cpu;
use crate::gpu::collision::Collision;
use crate::model_file::ShapeFile;
use crate::simulation::Simulation;
use crate::stages::{PARITY, Stage};
use crate::{Method, Model, ModelBuilder, SolverSettings, State};
use glam::DVec3;

/// Shapes of all kinds that fall on plates on pins, one of which is driven and one held by a limit; one is on a spring, one is pulled.
const MIXED: &str = "
name: mixed
step: 0.001
materials: {m: {density: 800, friction: 0.4, rolling: 0.002}, rubber: {density: 900, friction: 0.6, restitution: 0.3}}
bodies:
  - {name: ground, material: m, plane: {normal: [0, 0.05, 1]}}
  - {name: wall, material: m, fixed: true, position: [0.5, 0.3, 0.1], box: {size: [0.8, 0.1, 0.4]}}
  - {name: p0, material: m, position: [0.0, 0, 0.038], velocity: [0, 0, -0.2], box: {size: [0.18, 0.3, 0.06]}}
  - {name: p1, material: m, position: [0.2, 0, 0.038], velocity: [0, 0, -0.2], box: {size: [0.18, 0.3, 0.06]}}
  - {name: p2, material: m, position: [0.4, 0, 0.038], velocity: [0, 0, -0.2], box: {size: [0.18, 0.3, 0.06]}}
  - {name: stone, material: rubber, position: [0.02, 0.03, 0.14], velocity: [0.1, 0, -1], sphere: {radius: 0.06}}
  - {name: pebble, material: rubber, position: [0.2, 0.01, 0.12], velocity: [0, 0.1, -1], sphere: {radius: 0.03}}
  - {name: pill, material: m, position: [0.38, 0.02, 0.15], velocity: [0, 0, -1], capsule: {radius: 0.04, length: 0.1}}
  - {name: can, material: m, position: [0.7, 0.05, 0.12], cylinder: {radius: 0.06, length: 0.15}}
  - {name: crate, material: m, position: [0.72, 0.03, 0.3], velocity: [0, 0, -1], box: {size: [0.1, 0.12, 0.14]}}
joints:
  - {name: a, kind: revolute, a: p0, b: p1, position: [0.1, 0, 0.038], axis: [0, 1, 0], limits: [-1, 1]}
  - {name: b, kind: revolute, a: p1, b: p2, position: [0.3, 0, 0.038], axis: [0, 1, 0], motor: {torque: 2}}
springs:
  - {name: stay, a: p2, b: can, position: [0.45, 0, 0.05], position_b: [0.7, 0, 0.1], stiffness: 2000, damping: 10}
loads:
  - {body: crate, force: [1, 0, 0], value: 3}
";

/// Run a model from a state by both back ends alone and in parts.
fn hold(what: &str, (model, state): (&Model, &State), stages: &[Stage], least: usize) {
    let mut cpu = Simulation::new(model.clone(), state.clone());
    let mut most = 0;
    for _ in 0..20 {
        most = most.max(cpu.step().contacts);
    }
    assert!(most >= least, "{what}: {most} contacts");
    for from in stages.iter().copied() {
        let Some(mut own) = on_device_from(from, model, state) else { return };
        let mut last = None;
        for _ in 0..20 {
            let report = own.step();
            assert!(report.broken.is_none(), "{what}, from {from:?}: {report:?}");
            last = Some(report);
        }
        own.fetch().unwrap();
        let last = last.unwrap();
        let off = apart(&own.state, &cpu.state);
        eprintln!("{what}, from {from:?}: {off:.1e} m, {} of {} contacts", last.contacts, cpu.state.contacts.len());
        assert!(off < PARITY, "{what}, from {from:?}: {off} m");
        assert!(last.step == cpu.state.steps && own.state.time == cpu.state.time, "{what}: {last:?}");
        assert!(last.contacts.abs_diff(cpu.state.contacts.len()) * 20 <= most + 20, "{what}, from {from:?}: {last:?}");
        // The device has a part in it.
        let bits = |s: &Simulation| s.state.position.iter().map(|p| p.to_array().map(f64::to_bits)).collect::<Vec<_>>();
        assert!(bits(&own) != bits(&cpu), "{what}, from {from:?}");
    }
}

#[test]
fn stages_of_both_back_ends_make_the_steps_of_one() {
    let (mut model, state) = resolved(MIXED.into());
    model.solver = SolverSettings { sweep_landings: false, ..settings(Method::Apgd, 400, 1e-7) };
    let mut before = Simulation::new(model.clone(), state);
    (0..30).for_each(|_| drop(before.step()));
    let state = written(&before.state);
    hold("mixed, APGD", (&model, &state), &Stage::ALL, 10);
    model.solver.method = Some(Method::GaussSeidel);
    hold("mixed, Gauss–Seidel", (&model, &state), &Stage::ALL[5..], 10);
}

#[test]
fn stages_of_both_back_ends_make_the_steps_of_a_bed() {
    let (model, state) = bed(300, settings(Method::GaussSeidel, 300, 1e-6));
    hold("bed, Gauss–Seidel", (&model, &state), &Stage::ALL[1..], 200);
    let solver = SolverSettings { friction: crate::FrictionLaw::Exact, ..settings(Method::BarzilaiBorwein, 300, 1e-6) };
    let (model, state) = bed(300, solver);
    hold("bed, spectral", (&model, &state), &Stage::ALL[6..10], 200);
}

#[test]
fn stages_of_both_back_ends_make_the_steps_on_surfaces() {
    for (name, shapes) in [("spheres", false), ("solids", true)] {
        let shape = |k: usize| if shapes { solids(k) } else { ShapeFile::sphere(0.05) };
        let (mut model, mut state) = over_ground(shape, 40, DVec3::ZERO);
        layers(&model, &mut state, 40);
        for method in [Method::Apgd, Method::GaussSeidel] {
            model.solver = SolverSettings { sweep_landings: false, ..settings(method, 300, 1e-7) };
            let mut before = Simulation::new(model.clone(), state.clone());
            (0..120).for_each(|_| drop(before.step()));
            // At a seam either of two triangles may have a contact, after which solids turn another way.
            let stages = &Stage::ALL[if shapes { 6 } else { 5 }..7];
            hold(&format!("{name} on surfaces, {method:?}"), (&model, &written(&before.state)), stages, 20);
        }
    }
}

/// What wakes in a stage of either back end, impacts one after another, and a first step from rest.
#[test]
fn stages_of_both_back_ends_wake_what_sleeps() {
    let mut builder = ModelBuilder::new("sleep");
    builder.material("stone", 1000.0, 0.5);
    builder.body("ground", "stone", ShapeFile::plane([0.0, 0.0, 1.0]));
    for k in 0..3 {
        builder.body(&format!("b{k}"), "stone", ShapeFile::cuboid([0.2; 3])).position =
            [0.0, 0.0, 0.1 + 0.2 * k as f64];
    }
    let ball = builder.body("ball", "stone", ShapeFile::sphere(0.08));
    (ball.position, ball.velocity) = ([-2.0, 0.0, 0.08], [3.5, 0.0, 0.0]);
    let mut sim = builder.simulation().unwrap();
    sim.model.step = 2e-3;
    let solver = SolverSettings { sleep: Some(2e-3), rest_gap: 1e-4, ..settings(Method::Apgd, 200, 1e-7) };
    sim.model.solver = SolverSettings { sweep_landings: false, start_iterations: Some(400), ..solver };
    let asleep = |s: &Simulation| s.state.activity.iter().filter(|a| **a == crate::Activity::Asleep).count();
    for from in [Stage::WarmStart, Stage::Integrate] {
        let Some(mut own) = on_device_from(from, &sim.model, &sim.state) else { return };
        let mut seen = vec![];
        for _ in 0..480 {
            let report = own.step();
            assert!(report.broken.is_none() && report.warnings.is_empty(), "{from:?}: {report:?}");
            seen.push(asleep(&own));
        }
        seen.dedup();
        assert!(seen.starts_with(&[0, 3, 0]) || seen.starts_with(&[0, 3, 2]), "{from:?}: asleep {seen:?}");
    }
}

/// Bins of a bed of many sizes, also far from the origin, and the pairs that follow from them.
#[test]
fn bins_are_those_of_their_twin() {
    let Some((device, kernels)) = device() else { return };
    let mut random = SplitMix64(12);
    for far in [0.0, 900.0] {
        let (model, state) = super::spheres(700, |k| {
            let radius = if k % 70 == 0 { 0.6 } else { random.between(0.01, 0.04) };
            (DVec3::splat(far) + vector(&mut random, 0.7), radius, vector(&mut random, 1.0))
        });
        let mut collision = Collision::new(device, kernels, &model, &state).unwrap();
        collision.run(device, kernels, &model).unwrap();
        let (boxes, most_bits, sizes, found) = collision.bins_found(device).unwrap();
        let mut expected = emit_cpu(&boxes, most_bits, sizes);
        let mut shape: Vec<u32> = (0..boxes.len() as u32).collect();
        gpu::radix_sort::sort_cpu(&mut expected.bin, &mut shape, 1 << most_bits);
        assert!(expected.levels.iter().map(|mask| mask.count_ones()).sum::<u32>() > 2, "{:?}", expected.levels);
        assert_eq!((found.grid, found.levels), (expected.grid, expected.levels));
        assert!(found.bin == expected.bin);
    }
}
