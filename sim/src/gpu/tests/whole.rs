//! Whole steps on a device against the CPU back end's.

use super::{device, hold_to, vector};
use crate::fill::SplitMix64;
use crate::gpu::collision::Collision;
use crate::model_file::ShapeFile;
use crate::simulation::Simulation;
use crate::stages::{PARITY, Stage};
use crate::workload::{self, Workload, build};
use crate::{Method, Model, ModelBuilder, SolverSettings, State, StepReport};
use glam::{DQuat, DVec3};
use gpu::{Choice, Device};

/// A simulation on the device that tests have; none without an adapter.
pub fn on_device(model: &Model, state: &State) -> Option<Simulation> {
    on_device_from(Stage::Bounds, model, state)
}

/// The same, with the stages before one on the processor.
pub fn on_device_from(from: Stage, model: &Model, state: &State) -> Option<Simulation> {
    device()?;
    let device = Device::open(&Choice::Any).unwrap();
    Some(Simulation::on_device_from(from, model.clone(), state.clone(), device).unwrap())
}

/// A bed of spheres that falls together and onto the floor, with a box in the way.
pub fn bed(n: usize, solver: SolverSettings) -> (Model, State) {
    let (mut model, mut state) = build(Workload::S, n, solver, 1e-3);
    let mut random = SplitMix64(4);
    for b in 0..model.n_bodies() {
        if model.inv_mass[b] > 0.0 {
            state.velocity[b] = vector(&mut random, 0.3) - DVec3::Z;
            state.angular_velocity[b] = vector(&mut random, 3.0);
        }
    }
    model.laws[0].restitution = 0.1;
    (model, state)
}

pub fn settings(method: Method, iterations: u32, tolerance: f64) -> SolverSettings {
    SolverSettings { tolerance, ..workload::solver(method, iterations) }
}

/// Greatest distance of a body's positions in two states, m.
pub fn apart(a: &State, b: &State) -> f64 {
    a.position.iter().zip(&b.position).map(|(p, q)| (*p - *q).length()).fold(0.0, f64::max)
}

pub fn steps(simulation: &mut Simulation, n: usize) {
    for _ in 0..n {
        let report = simulation.step();
        assert!(report.warnings.is_empty() && report.broken.is_none(), "{report:?}");
    }
    simulation.fetch().unwrap();
}

#[test]
fn steps_of_a_bed_are_those_of_the_cpu() {
    for method in Method::ALL {
        let (model, state) = bed(300, settings(method, 300, 1e-6));
        let Some(mut own) = on_device(&model, &state) else { return };
        let mut cpu = Simulation::new(model, state);
        let mut n_contacts = 0;
        for _ in 0..20 {
            let (a, b) = (own.step(), cpu.step());
            n_contacts = n_contacts.max(b.contacts);
            assert!(a.contacts.abs_diff(b.contacts) * 50 <= b.contacts + 50, "{method:?}: {a:?}\n{b:?}");
            assert!((a.worst_penetration - b.worst_penetration).abs() < 2e-5, "{method:?}: {a:?}\n{b:?}");
            assert_eq!((a.step, a.time), (b.step, b.time));
        }
        own.fetch().unwrap();
        let off = apart(&own.state, &cpu.state);
        assert!(n_contacts > 200 && off < PARITY, "{method:?}: {n_contacts} contacts, {off} m");
        let energies = [&own, &cpu].map(|s| s.state.kinetic_energy(&s.model));
        assert!((energies[0] / energies[1] - 1.0).abs() < 0.01, "{method:?}: {energies:?}");
    }
}

/// A step leaves the pairs out where they hold, which the end of the last one knows, also where a body is struck in it. Of bodies that the processor
/// moves, on joints, that is an estimate: where one is struck, the step is begun again, and no contact is lost.
#[test]
fn pairs_are_found_again_where_a_body_is_struck() {
    const SPEED: f64 = 8.0;
    let mut text = "name: row\nstep: 0.001\nduration: 1\nframe_rate: 10\ngravity: [0, 0, 0]\n\
        materials: {m: {density: 800, friction: 0}}\nbodies:\n"
        .to_string();
    for k in 0..12 {
        // A row of spheres a tenth of a radius apart, which the first meets after some steps.
        let (x, speed) = if k == 0 { (-1.35, SPEED) } else { (0.21 * (f64::from(k) - 6.0), 0.0) };
        text += &format!(
            "  - {{name: s{k}, material: m, position: [{x}, 0, 0], velocity: [{speed}, 0, 0], sphere: {{radius: 0.1}}}}\n"
        );
    }
    text += "  - {name: far, material: m, position: [0, 3, 0], sphere: {radius: 0.1}}\n";
    let joint = "joints:\n  - {name: pin, kind: spherical, a: world, b: far, position: [0, 3, 0.1]}\n";
    for joint in ["", joint] {
        let (mut model, state) = super::joints::resolved(text.clone() + joint);
        model.solver = settings(Method::GaussSeidel, 400, 1e-5);
        let Some(mut own) = on_device(&model, &state) else { return };
        let mut cpu = Simulation::new(model, state);
        own.step();
        let sorting = |own: &Simulation| own.device_usage().unwrap().dispatches["bin_sort"];
        let of_step = sorting(&own);
        // The watch asks where energy goes when a body is struck.
        let whole = |report: StepReport| assert!(report.broken.is_none(), "{report:?}");
        (0..59).for_each(|_| whole(own.step()));
        (0..60).for_each(|_| whole(cpu.step()));
        own.fetch().unwrap();
        let (begun_again, sorting) = (own.device_usage().unwrap().begun_again, sorting(&own));
        assert!((begun_again > 0) != joint.is_empty(), "{begun_again}");
        assert!(sorting <= 30 * of_step, "{sorting} dispatches, {of_step} of a step");
        assert!(apart(&own.state, &cpu.state) < 1e-5, "{} m", apart(&own.state, &cpu.state));
        // Those that are struck go on with the first.
        assert!(own.state.velocity[6].x > 0.05 * SPEED, "{:?}", own.state.velocity);
    }
}

#[test]
fn a_run_repeats_bit_for_bit_also_from_its_middle() {
    for method in [Method::Apgd, Method::GaussSeidel, Method::BarzilaiBorwein] {
        let (model, state) = bed(300, settings(method, 40, 1e-6));
        let Some(mut first) = on_device(&model, &state) else { return };
        let mut second = on_device(&model, &state).unwrap();
        steps(&mut first, 14);
        steps(&mut second, 7);
        let state = written(&second.state);
        let mut second = second.restart(state).unwrap();
        steps(&mut second, 7);
        assert!(words(&first.state) == words(&second.state), "{method:?}");
        assert_eq!(first.state.contacts.key, second.state.contacts.key);
        assert_eq!(first.state.fat_aabb, second.state.fat_aabb);
        assert!(first.state.contacts.len() > 100);
    }
}

/// All numbers of the bodies and of the impulses.
fn words(s: &State) -> Vec<u64> {
    let vectors = [&s.position, &s.velocity, &s.angular_velocity, &s.contacts.impulse];
    let vectors = vectors.into_iter().flatten().flat_map(|v| v.to_array());
    vectors.chain(s.orientation.iter().flat_map(|q| q.to_array())).map(f64::to_bits).collect()
}

/// Gauss–Seidel takes over the steps in which a bed lands, whatever the law of friction and whether the number of iterations is given; what
/// the method itself makes of them is something else.
#[test]
fn steps_in_which_a_bed_lands_are_swept_as_on_the_cpu() {
    use crate::FrictionLaw::{Exact, Relaxed};
    for (method, friction, iterations) in [(Method::Apgd, Relaxed, Some(200)), (Method::BarzilaiBorwein, Exact, None)] {
        let solver = SolverSettings { friction, iterations, sweep_landings: true, ..settings(method, 50, 1e-6) };
        let (mut model, mut state) = bed(1100, solver);
        for b in (0..model.n_bodies()).filter(|b| model.inv_mass[*b] > 0.0) {
            state.position[b] *= 0.955;
        }
        let Some(mut own) = on_device(&model, &state) else { return };
        let mut again = on_device(&model, &state).unwrap();
        let mut cpu = Simulation::new(model.clone(), state.clone());
        model.solver.sweep_landings = false;
        let mut alone = Simulation::new(model, state);
        for simulation in [&mut own, &mut cpu, &mut alone] {
            (0..3).for_each(|_| drop(simulation.step()));
            simulation.fetch().unwrap();
        }
        let off = [&own, &alone].map(|s| apart(&s.state, &cpu.state));
        assert!(off[0] < 1.5e-4 && off[0] < 0.1 * off[1], "{method:?}: {off:?} m");
        // From the middle of the landing.
        (0..2).for_each(|_| drop(again.step()));
        again.fetch().unwrap();
        let state = written(&again.state);
        let mut again = again.restart(state).unwrap();
        drop(again.step());
        again.fetch().unwrap();
        assert!(words(&own.state) == words(&again.state), "{method:?}");
    }
}

/// Sweeps go on beyond the iterations of the settings, up to four times as many passes, while they leave gaps that close too fast, and no longer.
#[test]
fn sweeps_go_on_where_a_step_would_add_overlap() {
    let run = |overlap_tolerance: Option<f64>, is_own: bool| {
        let solver = SolverSettings { overlap_tolerance, ..settings(Method::GaussSeidel, 4, 1e-9) };
        let (model, mut state) = bed(1100, solver);
        for b in (0..model.n_bodies()).filter(|b| model.inv_mass[*b] > 0.0) {
            state.position[b] *= 0.99;
        }
        let mut simulation =
            if is_own { on_device(&model, &state)? } else { Simulation::new(model.clone(), state.clone()) };
        let reports: Vec<(u32, f64)> = (0..40)
            .map(|_| {
                let report = simulation.step();
                (report.iterations, report.worst_penetration)
            })
            .collect();
        let worst = reports.iter().map(|report| report.1).fold(0.0, f64::max);
        Some((reports.iter().map(|report| report.0).collect::<Vec<u32>>(), worst))
    };
    let tolerance = 2e-5;
    let Some((alone, without)) = run(None, true) else { return };
    let ((own, worst), (on_cpu, of_cpu)) = (run(Some(tolerance), true).unwrap(), run(Some(tolerance), false).unwrap());
    eprintln!("{alone:?} {without} m, {own:?} {worst} m; on the CPU {on_cpu:?} {of_cpu} m");
    assert!(alone.iter().all(|n| *n <= 4) && own.iter().all(|n| *n <= 30), "{alone:?}, {own:?}");
    assert!(own.iter().any(|n| *n > 4) && own.iter().any(|n| *n <= 4), "{own:?}");
    assert!(
        worst < 0.5 * without && worst < 2.0 * of_cpu + tolerance,
        "{worst} m of {without} m, {of_cpu} m on the CPU"
    );
}

/// A state as a checkpoint has it: without what is not written.
pub fn written(state: &State) -> State {
    postcard::from_bytes(&postcard::to_stdvec(state).unwrap()).unwrap()
}

/// Impulses of Gauss–Seidel by tiles come to those of the CPU's sweeps, by either law of friction; also where most pairs are in tiles that
/// are too big for a workgroup, and among spheres as large as tiles.
#[test]
fn tiles_come_to_the_solution_of_the_cpu() {
    use crate::FrictionLaw::{Exact, Relaxed};
    for (friction, is_dense) in [(Relaxed, false), (Exact, false), (Exact, true)] {
        let solver = SolverSettings { friction, ..settings(Method::GaussSeidel, 400, 1e-7) };
        let (mut model, mut state) = bed(1500, solver);
        let middle = DVec3::new(1.0, 1.0, 0.9);
        let closer = if is_dense { 0.85 } else { 0.95 };
        for b in (0..model.n_bodies()).filter(|b| model.inv_mass[*b] > 0.0) {
            state.position[b] = middle + (state.position[b] - middle) * closer;
        }
        // Spheres as large as tiles, which lie on the bed.
        let top = state.position.iter().map(|p| p.z).fold(0.0, f64::max);
        for (k, [x, y]) in [[0.5, 0.5], [1.4, 0.6], [0.9, 1.4]].into_iter().enumerate() {
            let s = model.n_shapes() - 1 - k;
            model.shape_size[s] = DVec3::splat(0.4);
            state.position[model.shape_body[s] as usize] = DVec3::new(x, y, top + 0.47);
        }
        let Some(mut own) = on_device(&model, &state) else { return };
        let mut cpu = Simulation::new(model, state);
        let (a, b) = (own.step(), cpu.step());
        own.fetch().unwrap();
        assert!(a.contacts.abs_diff(b.contacts) < 3 && b.contacts > 3000, "{a:?}\n{b:?}");
        // Spheres deep in each other are not solved in as many sweeps on either.
        assert!(is_dense && a.residual < b.residual || a.iterations < 400 && b.iterations < 400, "{a:?}\n{b:?}");
        let speed = cpu.state.velocity.iter().map(|v| v.length()).fold(0.0, f64::max);
        let off: f64 =
            own.state.velocity.iter().zip(&cpu.state.velocity).map(|(a, b)| (*a - *b).length_squared()).sum();
        let off = (off / own.state.velocity.len() as f64).sqrt() / speed;
        assert!(off < if is_dense { 1e-2 } else { 1e-3 }, "{friction:?} {is_dense}: {off}\n{a:?}\n{b:?}");
    }
}

#[test]
fn a_state_goes_on_on_the_other_back_end() {
    let (model, state) = bed(300, settings(Method::Apgd, 300, 1e-7));
    let Some(mut own) = on_device(&model, &state) else { return };
    let mut cpu = Simulation::new(model.clone(), state);
    steps(&mut own, 8);
    steps(&mut cpu, 8);
    let mut own_on_cpu = Simulation::new(model.clone(), own.state.clone());
    let mut cpu_on_own = on_device(&model, &cpu.state).unwrap();
    steps(&mut own_on_cpu, 8);
    steps(&mut cpu_on_own, 8);
    steps(&mut cpu, 8);
    for other in [&own_on_cpu, &cpu_on_own] {
        assert!(apart(&other.state, &cpu.state) < 1e-4);
        assert_eq!((other.state.steps, other.state.time), (cpu.state.steps, cpu.state.time));
    }
}

/// A bed whose grains resist rolling, a ball that rolls to a stop and one that spins, by all methods; and all of it from a checkpoint.
#[test]
fn rolling_and_spinning_friction_are_those_of_the_cpu() {
    for method in Method::ALL {
        let (mut model, mut state) = bed(300, settings(method, 300, 1e-6));
        (model.laws[0].rolling, model.laws[0].spinning) = (0.01, 0.005);
        let Some(mut own) = on_device(&model, &state) else { return };
        let mut cpu = Simulation::new(model.clone(), state.clone());
        for _ in 0..10 {
            let (a, b) = (own.step(), cpu.step());
            assert!(a.contacts.abs_diff(b.contacts) * 50 <= b.contacts + 50, "{a:?}\n{b:?}");
        }
        own.fetch().unwrap();
        let mut own = own.restart(written(&cpu.state)).unwrap();
        for _ in 0..10 {
            own.step();
            cpu.step();
        }
        own.fetch().unwrap();
        let off = apart(&own.state, &cpu.state);
        let rolling = |s: &Simulation| s.state.contacts.rolling_impulse.iter().map(|z| z.length()).sum::<f64>();
        assert!(off < 1e-4, "{method:?}: {off} m");
        assert!(rolling(&cpu) > 0.0 && (rolling(&own) / rolling(&cpu) - 1.0).abs() < 0.02, "{method:?}");

        // Two balls alone on the floor.
        let balls: Vec<usize> = (0..model.n_bodies()).filter(|b| model.inv_mass[*b] > 0.0).collect();
        for (k, b) in balls.iter().enumerate() {
            let s = model.shape_body.iter().position(|body| *body as usize == *b).unwrap();
            let radius = model.shape_size[s].x;
            state.position[*b] = DVec3::new(0.3 + 3.0 * radius * k as f64, 0.4, radius);
            (state.velocity[*b], state.angular_velocity[*b]) = (DVec3::ZERO, DVec3::ZERO);
            if k > 1 {
                state.position[*b] = DVec3::new(0.4, 0.4, 100.0 + k as f64);
            }
        }
        state.velocity[balls[0]] = DVec3::Y * 0.3;
        state.orientation[balls[1]] = DQuat::IDENTITY;
        state.angular_velocity[balls[1]] = DVec3::Z * 5.0;
        let mut own = on_device(&model, &state).unwrap();
        let mut cpu = Simulation::new(model, state);
        steps(&mut own, 200);
        steps(&mut cpu, 200);
        let near = |k: usize| (own.state.velocity[balls[k]] - cpu.state.velocity[balls[k]]).length();
        let spins = [&own, &cpu].map(|s| s.state.angular_velocity[balls[1]].z);
        assert!(near(0) < 1e-4 && apart(&own.state, &cpu.state) < 1e-4, "{method:?}: {} m/s", near(0));
        assert!(cpu.state.velocity[balls[0]].y < 0.19, "{}", cpu.state.velocity[balls[0]]);
        assert!(spins[1] < 4.9 && (spins[0] - spins[1]).abs() < 1e-3, "{method:?}: {spins:?}");
    }
}

/// A bed of grains that stick together, and a ball that hangs from another one that is held, by its cohesion alone.
#[test]
fn cohesion_is_that_of_the_cpu() {
    for method in Method::ALL {
        let (mut model, mut state) = bed(300, settings(method, 300, 1e-6));
        model.laws[0].cohesion = 200.0;
        let moving: Vec<usize> = (0..model.n_bodies()).filter(|b| model.inv_mass[*b] > 0.0).collect();
        let [above, below] = [moving[0], moving[1]];
        let size = |b: usize| model.shape_size[model.shape_body.iter().position(|s| *s as usize == b).unwrap()].x;
        state.position[above].z = 50.0;
        state.position[below] = state.position[above] - DVec3::Z * (size(above) + size(below));
        for b in [above, below] {
            (state.velocity[b], state.angular_velocity[b]) = (DVec3::ZERO, DVec3::ZERO);
        }
        (model.inv_mass[above], model.inv_inertia[above]) = (0.0, DVec3::ZERO);
        state.activity.clear();
        state.wake(&model);
        assert!(200.0 * model.inv_mass[below] > 9.81, "the ball is light enough");
        let Some(mut own) = on_device(&model, &state) else { return };
        let mut cpu = Simulation::new(model.clone(), state.clone());
        for _ in 0..20 {
            let (a, b) = (own.step(), cpu.step());
            assert!(a.contacts.abs_diff(b.contacts) * 50 <= b.contacts + 50, "{a:?}\n{b:?}");
        }
        own.fetch().unwrap();
        let off = apart(&own.state, &cpu.state);
        assert!(off < 1e-4, "{method:?}: {off} m");
        let fallen = (own.state.position[below] - state.position[below]).length();
        assert!(fallen < 1e-5, "{method:?}: {fallen} m");
    }
}

/// All spheres are in each other: 44,850 pairs, where there is room for 1,264 at first.
#[test]
fn pairs_beyond_the_room_undo_the_step_and_none_is_dropped() {
    let (mut model, mut state) = build(Workload::S, 300, settings(Method::Jacobi, 2, 0.0), 1e-3);
    (model.gravity, model.solver.omega) = (DVec3::ZERO, Some(1e-3));
    let mut random = SplitMix64(8);
    for b in 0..model.n_bodies() {
        if model.inv_mass[b] > 0.0 {
            state.position[b] = DVec3::splat(0.4) + vector(&mut random, 0.005);
        }
    }
    let Some(mut own) = on_device(&model, &state) else { return };
    let mut cpu = Simulation::new(model, state);
    let (a, b) = (own.step(), cpu.step());
    assert_eq!((a.step, a.contacts, b.contacts), (1, 300 * 299 / 2, 300 * 299 / 2));
    own.fetch().unwrap();
    assert!(apart(&own.state, &cpu.state) < 1e-5, "{}", apart(&own.state, &cpu.state));
}

#[test]
fn spheres_about_what_is_held_have_the_contacts_of_the_cpu() {
    let (near, far) = (DVec3::ZERO, DVec3::new(1000.0, -2000.0, 500.0));
    let shapes = [
        (near, ShapeFile::cuboid([0.5, 0.3, 0.8])),
        (far, ShapeFile::cuboid([0.5, 0.3, 0.8])),
        (far, ShapeFile::cylinder(0.25, 0.7)),
        (far, ShapeFile::capsule(0.25, 0.4)),
        (far, ShapeFile { cone: ShapeFile::cylinder(0.3, 0.7).cylinder, ..ShapeFile::default() }),
    ];
    for (far, shape) in shapes {
        let mut builder = ModelBuilder::new("held");
        builder.material("stone", 2600.0, 0.5);
        builder.body("slope", "stone", ShapeFile::plane([0.3, -0.2, 1.0]));
        builder.body("block", "stone", shape).fixed = true;
        let mut random = SplitMix64(5);
        for k in 0..400 {
            let sphere = builder.body(&format!("s{k}"), "stone", ShapeFile::sphere(random.between(0.02, 0.03)));
            sphere.position = [k as f64, 0.0, 1000.0];
        }
        let mut sim = builder.simulation().unwrap();
        // Where no model could begin: deep in each other and in what is held.
        for (name, body) in sim.model.body_names.iter() {
            sim.state.position[body as usize] = far
                + match name {
                    "slope" => DVec3::Z * -0.4,
                    "block" => DVec3::ZERO,
                    _ => vector(&mut random, 0.5),
                };
        }
        let turned = DQuat::from_euler(glam::EulerRot::XYZ, 0.4, 0.7, -0.2);
        let body = sim.model.body_names["block"] as usize;
        sim.state.orientation[body] = turned;
        let Some((device, kernels)) = device() else { return };
        let mut collision = Collision::new(device, kernels, &sim.model, &sim.state).unwrap();
        let n = collision.run(device, kernels, &sim.model).unwrap().contacts;
        assert!(n > 100, "{n}");
        // Solids of revolution are right to single precision of their sizes.
        let slack = if sim.model.shape_kind[1] == crate::ShapeKind::Box { 0.0 } else { 2e-7 };
        hold_to(&sim.model, &sim.state, &collision.contacts(device).unwrap(), slack);
    }
}

#[test]
fn a_sphere_bounces_and_rolls_as_on_the_cpu() {
    let mut builder = ModelBuilder::new("bounce");
    builder.material("rubber", 1000.0, 0.5);
    builder.body("floor", "rubber", ShapeFile::plane([0.0, 0.1, 1.0]));
    let ball = builder.body("ball", "rubber", ShapeFile::sphere(0.1));
    (ball.position, ball.velocity) = ([0.0, 0.0, 0.5], [1.0, 0.0, 0.0]);
    let mut sim = builder.simulation().unwrap();
    sim.model.laws.iter_mut().for_each(|l| l.restitution = 0.6);
    sim.model.solver.iterations = None;
    let Some(mut own) = on_device(&sim.model, &sim.state) else { return };
    let mut cpu = Simulation::new(sim.model, sim.state);
    let mut bounces = 0;
    for _ in 0..700 {
        let before = cpu.state.velocity[1].z;
        own.step();
        cpu.step();
        bounces += (before < -0.2 && cpu.state.velocity[1].z > 0.1) as u32;
    }
    own.fetch().unwrap();
    let turn = (own.state.orientation[1].inverse() * cpu.state.orientation[1]).to_scaled_axis().length();
    assert!(bounces > 1 && apart(&own.state, &cpu.state) < 1e-4 && turn < 1e-3, "{bounces} {turn}");
}

/// A sphere that appears above the bed in the middle of the run, and falls onto it.
#[test]
fn what_appears_falls_as_on_the_cpu() {
    let mut builder = ModelBuilder::new("late");
    builder.material("stone", 2600.0, 0.5);
    builder.body("floor", "stone", ShapeFile::plane([0.0, 0.0, 1.0]));
    for k in 0..16 {
        let grain = builder.body(&format!("g{k}"), "stone", ShapeFile::sphere(0.1));
        grain.position = [0.2 * (k % 4) as f64, 0.2 * (k / 4) as f64, 0.1];
    }
    let ball = builder.body("ball", "stone", ShapeFile::sphere(0.15));
    (ball.position, ball.velocity) = ([0.33, 0.31, 0.5], [0.1, 0.0, -3.0]);
    ball.appears = Some(0.01);
    let sim = builder.simulation().unwrap();
    let Some(mut own) = on_device(&sim.model, &sim.state) else { return };
    let mut cpu = Simulation::new(sim.model, sim.state);
    let n = (0.08 / cpu.model.step) as usize;
    (0..n).for_each(|_| drop((own.step(), cpu.step())));
    own.fetch().unwrap();
    let ball = cpu.model.body_names["ball"] as usize;
    assert!(cpu.state.position[ball].z < 0.4 && cpu.state.contacts.len() > 16);
    assert!(apart(&own.state, &cpu.state) < 1e-4, "{}", apart(&own.state, &cpu.state));
}

/// Nothing touches it: what the fixed point and single precision make of a flight of a thousand steps far from the origin.
#[test]
fn a_flight_is_that_of_the_cpu_far_from_the_origin() {
    let mut builder = ModelBuilder::new("flight");
    builder.material("stone", 2600.0, 0.5);
    let ball = builder.body("ball", "stone", ShapeFile::sphere(0.01));
    (ball.position, ball.velocity) = ([1000.0, -1000.0, 1000.0], [1.0, 2e-7, 0.5]);
    let mut sim = builder.simulation().unwrap();
    sim.state.angular_velocity[0] = DVec3::new(30.0, -20.0, 5.0);
    let Some(mut own) = on_device(&sim.model, &sim.state) else { return };
    let mut cpu = Simulation::new(sim.model, sim.state);
    steps(&mut own, 1000);
    steps(&mut cpu, 1000);
    let (p, q) = (own.state.position[0], cpu.state.position[0]);
    let turn = (own.state.orientation[0].inverse() * cpu.state.orientation[0]).to_scaled_axis().length();
    assert!((p - q).length() < 2e-6 * (q - DVec3::new(1000.0, -1000.0, 1000.0)).length(), "{p} {q}");
    // A motion of 2e-10 m a step is carried on.
    assert!((p.y - q.y).abs() < 1e-9 && turn < 1e-4, "{p} {q} {turn}");
}

/// Impacts go through a row of spheres that touch one after another, and a bed that is hit bounces as on the CPU; on a pendulum, too.
#[test]
fn impacts_one_after_another_are_those_of_the_cpu() {
    let mut builder = ModelBuilder::new("cradle");
    builder.material("steel", 7800.0, 0.3);
    for (k, x) in [-0.12, 0.0, 0.1, 0.2].into_iter().enumerate() {
        let sphere = builder.body(&format!("s{k}"), "steel", ShapeFile::sphere(0.05));
        (sphere.position, sphere.velocity) = ([x, 0.0, 0.0], [if k == 0 { 1.0 } else { 0.0 }, 0.0, 0.0]);
    }
    let mut sim = builder.simulation().unwrap();
    sim.model.gravity = DVec3::ZERO;
    sim.model.laws.iter_mut().for_each(|l| l.restitution = 1.0);
    sim.model.solver.impacts = crate::Impacts::Sequential;
    let Some(mut own) = on_device(&sim.model, &sim.state) else { return };
    (0..100).for_each(|_| drop(own.step()));
    own.fetch().unwrap();
    for (b, speed) in [0.0, 0.0, 0.0, 1.0].into_iter().enumerate() {
        let v = own.state.velocity[b].x;
        assert!((v - speed).abs() < 1e-6, "sphere {b} has {v} m/s");
    }
    for method in [Method::Apgd, Method::GaussSeidel] {
        let solver = SolverSettings { impacts: crate::Impacts::Sequential, ..settings(method, 300, 1e-6) };
        let (mut model, state) = bed(300, solver);
        model.laws[0].restitution = 0.6;
        let Some(mut own) = on_device(&model, &state) else { return };
        let mut cpu = Simulation::new(model, state);
        for _ in 0..20 {
            own.step();
            cpu.step();
        }
        own.fetch().unwrap();
        let off = apart(&own.state, &cpu.state);
        let energies = [&own, &cpu].map(|s| s.state.kinetic_energy(&s.model));
        assert!(off < 1e-4 && (energies[0] / energies[1] - 1.0).abs() < 0.01, "{method:?}: {off} m, {energies:?} J");
    }
}

/// Columns that fall asleep, one of which a ball hits later, and a load that wakes another: the same bodies sleep at the same times as on the
/// CPU, with the same forces; and a run repeats bit for bit from where some sleep.
#[test]
fn bodies_sleep_and_wake_as_on_the_cpu() {
    let mut builder = ModelBuilder::new("sleep");
    builder.material("stone", 1000.0, 0.5);
    builder.body("ground", "stone", ShapeFile::plane([0.0, 0.0, 1.0]));
    for k in 0..6 {
        let position = [1.5 * (k / 3) as f64, 0.0, 0.1 + 0.2 * (k % 3) as f64];
        builder.body(&format!("b{k}"), "stone", ShapeFile::cuboid([0.2, 0.2, 0.2])).position = position;
    }
    let ball = builder.body("ball", "stone", ShapeFile::sphere(0.08));
    (ball.position, ball.velocity) = ([-2.0, 0.0, 0.08], [2.5, 0.0, 0.0]);
    let mut sim = builder.simulation().unwrap();
    sim.model.step = 2e-3;
    for method in [Method::Apgd, Method::GaussSeidel] {
        let solver = SolverSettings { method: Some(method), sleep: Some(2e-3), ..sim.model.solver.clone() };
        // Gaps in single precision differ from step to step, which would rock the columns.
        sim.model.solver = SolverSettings { iterations: Some(200), tolerance: 1e-7, rest_gap: 1e-4, ..solver };
        let Some(mut own) = on_device(&sim.model, &sim.state) else { return };
        let mut cpu = Simulation::new(sim.model.clone(), sim.state.clone());
        let asleep = |s: &Simulation| {
            (0..s.model.n_bodies()).filter(|b| s.state.activity[*b] == crate::Activity::Asleep).count()
        };
        let mut seen = vec![];
        for k in 0..500 {
            let (a, b) = (own.step(), cpu.step());
            assert_eq!(asleep(&own), asleep(&cpu), "{method:?}: step {k}\n{a:?}\n{b:?}");
            assert!(a.broken.is_none() && a.contacts.abs_diff(b.contacts) < 9, "{method:?}: step {k}\n{a:?}\n{b:?}");
            seen.push(asleep(&own));
        }
        seen.dedup();
        let off = apart(&own.state, &cpu.state);
        let force = |s: &Simulation| s.state.all_contacts().map(|(c, i)| c.impulse[i].z).sum::<f64>();
        eprintln!("{method:?}: asleep {seen:?}, {off} m apart, {} of {} N s", force(&own), force(&cpu));
        assert!(seen.contains(&6) && seen.windows(2).any(|n| n[1] < n[0]), "{method:?}: asleep {seen:?}");
        assert!(off < 1e-3 && (force(&own) / force(&cpu) - 1.0).abs() < 0.02, "{method:?}: {off} m");
    }
}

/// Whether a run takes up what another has left in its middle, to the bit, while bodies sleep.
#[test]
fn a_run_with_sleepers_repeats_bit_for_bit_also_from_its_middle() {
    let mut builder = ModelBuilder::new("sleep");
    builder.material("stone", 1000.0, 0.5);
    builder.body("ground", "stone", ShapeFile::plane([0.0, 0.0, 1.0]));
    for k in 0..4 {
        let position = [0.5 * k as f64, 0.0, 0.1];
        builder.body(&format!("b{k}"), "stone", ShapeFile::cuboid([0.2, 0.2, 0.2])).position = position;
    }
    let ball = builder.body("ball", "stone", ShapeFile::sphere(0.08));
    (ball.position, ball.velocity) = ([0.5, -2.3, 0.08], [0.0, 3.0, 0.0]);
    let mut sim = builder.simulation().unwrap();
    sim.model.step = 2e-3;
    sim.model.solver.sleep = Some(2e-3);
    let Some(mut first) = on_device(&sim.model, &sim.state) else { return };
    let mut second = on_device(&sim.model, &sim.state).unwrap();
    let asleep = |s: &State| s.activity.iter().filter(|a| **a == crate::Activity::Asleep).count();
    let run = |s: &mut Simulation, n: usize| {
        (0..n).for_each(|_| drop(s.step()));
        s.fetch().unwrap();
    };
    run(&mut first, 400);
    run(&mut second, 310);
    let middle = written(&second.state);
    assert!(asleep(&middle) > 2, "{}", asleep(&middle));
    let mut second = second.restart(middle).unwrap();
    run(&mut second, 90);
    let bits = |s: &State| -> Vec<u64> {
        let vectors = [&s.position, &s.velocity, &s.angular_velocity, &s.contacts.impulse];
        vectors.into_iter().flatten().flat_map(|v| v.to_array()).map(f64::to_bits).collect()
    };
    assert!(bits(&first.state) == bits(&second.state));
    assert_eq!(first.state.sleepers.island, second.state.sleepers.island);
}
