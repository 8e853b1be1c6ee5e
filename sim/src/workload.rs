//! Benchmark workloads for comparisons between engines: beds of spheres that settle in an open box, convex bodies, joints, and a vehicle.

mod convex;
mod measure;
mod vehicle;

pub use convex::{Convex, mixed, scene};
pub use measure::Measure;
pub use vehicle::vehicle;

use crate::fill::SplitMix64;
use crate::model_file::quality::{NORMAL_OMEGA, NORMAL_OVERLAP, NORMAL_SWEEPS};
use crate::{ContactLaw, Method, Model, Pose, ShapeKind, SolverSettings, State};
use glam::{DQuat, DVec3};

/// A benchmark workload: the spheres of a bed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Workload {
    /// Workload S: spheres of radius 0.075 m and density 1900 kg/m³; μ = 0.4.
    S,
    /// Workload A: spheres of radius 0.025 to 0.036 m and mass 0.005 kg, as in the bed of the anchor model; μ = 0.4.
    A,
}

/// The model and initial state of a workload: `n` spheres on a jittered lattice 12 layers high, in a box of a floor and four walls,
/// with steps of `step`, s.
pub fn build(workload: Workload, n: usize, solver: SolverSettings, step: f64) -> (Model, State) {
    let r_max = radius(workload);
    let spacing = 2.1 * r_max;
    let side = (n as f64 / 12.0).sqrt().ceil() as usize;
    let length = side as f64 * spacing;
    let mut random = SplitMix64(12345);
    let mut model = Model {
        name: format!("{workload:?}({n})"),
        gravity: DVec3::new(0.0, 0.0, -9.81),
        step,
        part: 1.0,
        duration: 1.0,
        frame_rate: 24.0,
        seed: 12345,
        envelope: solver.envelope.unwrap_or(1e-3),
        solver,
        class_names: vec!["wall".into(), "grain".into()],
        material_names: vec!["stone".into()],
        laws: vec![ContactLaw { friction: 0.4, ..ContactLaw::default() }],
        group_names: vec!["all".into()],
        groups_pass: vec![false],
        ..Model::default()
    };
    let mut state = State::default();
    let walls = [
        (DVec3::ZERO, DVec3::Z),
        (DVec3::ZERO, DVec3::X),
        (DVec3::new(length, 0.0, 0.0), -DVec3::X),
        (DVec3::ZERO, DVec3::Y),
        (DVec3::new(0.0, length, 0.0), -DVec3::Y),
    ];
    for (point, normal) in walls {
        add(
            &mut model,
            &mut state,
            0,
            ShapeKind::Plane,
            DVec3::ZERO,
            point,
            DQuat::from_rotation_arc(DVec3::Z, normal),
            0.0,
        );
    }
    for i in 0..n {
        let site = [i % side, i / side % side, i / (side * side)];
        let p = site.map(|c| (c as f64 + 0.5) * spacing + (2.0 * random.uniform() - 1.0) * 0.04 * r_max);
        let (r, mass) = match workload {
            Workload::S => (r_max, 1900.0 * 4.0 / 3.0 * std::f64::consts::PI * (r_max * r_max * r_max)),
            Workload::A => (0.025 + 0.011 * random.uniform(), 0.005),
        };
        add(&mut model, &mut state, 1, ShapeKind::Sphere, DVec3::splat(r), DVec3::from_array(p), DQuat::IDENTITY, mass);
    }
    (model, state)
}

/// The greatest radius of a workload's spheres, m.
pub fn radius(workload: Workload) -> f64 {
    if workload == Workload::S { 0.075 } else { 0.036 }
}

/// The same settings with the sweeps of normal quality, and more where spheres would overlap.
pub fn sweeping_more(workload: Workload, solver: SolverSettings) -> SolverSettings {
    let overlap = NORMAL_OVERLAP * radius(workload);
    SolverSettings {
        iterations: Some(NORMAL_SWEEPS),
        omega: Some(NORMAL_OMEGA),
        overlap_tolerance: Some(overlap),
        ..solver
    }
}

/// Solver settings of the workloads: a method alone, and a fixed number of iterations, whatever the residual.
pub fn solver(method: Method, iterations: u32) -> SolverSettings {
    SolverSettings {
        method: Some(method),
        iterations: Some(iterations),
        tolerance: 0.0,
        envelope: Some(2e-4),
        sweep_landings: false,
        ..SolverSettings::default()
    }
}

#[allow(clippy::too_many_arguments)]
fn add(
    model: &mut Model,
    state: &mut State,
    class: u32,
    kind: ShapeKind,
    size: DVec3,
    position: DVec3,
    orientation: DQuat,
    mass: f64,
) {
    let inv = if mass > 0.0 { 1.0 / mass } else { 0.0 };
    model.shape_body.push(model.inv_mass.len() as u32);
    model.shape_kind.push(kind);
    model.shape_size.push(size);
    let middle = Pose::default();
    model.shape_pose.push(middle);
    model.shape_material.push(0);
    model.shape_group.push(0);
    model.shape_part.push(0);
    model.body_frame.push(middle);
    model.inv_mass.push(inv);
    model.inv_inertia.push(if mass > 0.0 { DVec3::splat(inv / (0.4 * size.x * size.x)) } else { DVec3::ZERO });
    model.class.push(class);
    state.position.push(position);
    state.orientation.push(orientation);
    state.velocity.push(DVec3::ZERO);
    state.angular_velocity.push(DVec3::ZERO);
}
