//! The collision of spheres on a device against the CPU back end's, on random and on adverse beds.

mod given;
mod joints;
mod long;
mod motors;
mod probes;
mod solids;
mod surfaces;
mod whole;

use super::collision::{Collision, Fault};
use super::contact_solve::ContactSolve;
use super::fixed::{Scale, gap_cpu};
use super::parts::kernel;
use super::rows::{
    Aabb, Arms, Body, BodyState, Contact, Fixed, Fixture, JointRow, JointSide, Member, MemberFree, Node, Solid, Sphere,
    Summary,
};
use crate::fill::SplitMix64;
use crate::shape::ShapeKind;
use crate::simulation::Simulation;
use crate::state::Activity;
use crate::workload::{self, Workload, build};
use crate::{Method, Model, State};
use glam::DVec3;
use gpu::layout::check;
use gpu::{Buffer, Choice, Commands, Device, Kernels, Work};
use std::collections::BTreeMap;
use std::sync::OnceLock;

/// A device for all tests; none without an adapter, unless `REQUIRE_GPU` is set.
fn device() -> Option<&'static (Device, Kernels)> {
    static DEVICE: OnceLock<Option<(Device, Kernels)>> = OnceLock::new();
    let open = || match Device::open(&Choice::Any) {
        Ok(device) => Some((device, Kernels::default())),
        Err(error) if std::env::var_os("REQUIRE_GPU").is_some() => panic!("REQUIRE_GPU is set, but {error}"),
        Err(error) => {
            eprintln!("skipped: {error}");
            None
        }
    };
    DEVICE.get_or_init(open).as_ref()
}

/// A model of spheres in a box of planes, of which every sphere is where `place` says, with its radius and velocity.
fn spheres(n: usize, mut place: impl FnMut(usize) -> (DVec3, f64, DVec3)) -> (Model, State) {
    let solver = workload::solver(Method::Jacobi, 1);
    let (mut model, mut state) = build(Workload::S, n, solver, 1e-3);
    let grains: Vec<usize> = (0..model.n_shapes()).filter(|s| model.shape_kind[*s] == ShapeKind::Sphere).collect();
    for (k, s) in grains.into_iter().enumerate() {
        let (position, radius, velocity) = place(k);
        let body = model.shape_body[s] as usize;
        model.shape_size[s] = DVec3::splat(radius);
        (state.position[body], state.velocity[body]) = (position, velocity);
    }
    state.wake(&model);
    (model, state)
}

/// A contact of the CPU back end: bodies, normal, gap, lengths of the arms, law.
type Expected = ([u32; 2], DVec3, f64, [f64; 2], u32);

/// The contacts that the CPU back end finds, by shapes.
fn expected(model: &Model, state: &State) -> BTreeMap<[u32; 2], Expected> {
    let mut simulation = Simulation::new(model.clone(), state.clone());
    simulation.step();
    let contacts = &simulation.state.contacts;
    let crate::Arms::Along(reach) = &contacts.arms else { panic!("spheres have arms along the normal") };
    let contact = |i: usize| {
        let [s, t, _] = contacts.key[i];
        ([s, t], (contacts.bodies[i], contacts.normal[i], contacts.gap[i], reach[i], contacts.law[i]))
    };
    (0..contacts.len()).map(contact).collect()
}

/// Hold the contacts of a device against those of the CPU: the same pairs, but for those at the end of their margins, to 1e-6 of the
/// least radius and the single precision of normals.
fn hold(model: &Model, state: &State, found: &[Contact]) {
    hold_to(model, state, found, 0.0);
}

/// The same with a slack of gaps and arms, m.
fn hold_to(model: &Model, state: &State, found: &[Contact], slack: f64) {
    let least = model.shape_size.iter().map(|s| s.x).filter(|r| *r > 0.0).fold(f64::INFINITY, f64::min);
    let mut expected = expected(model, state);
    let margin = |s: u32| {
        let speed = state.velocity[model.shape_body[s as usize] as usize].length();
        (model.envelope + speed * model.step) as f32 as f64
    };
    let is_at_the_end = |[s, t]: [u32; 2], gap: f64| {
        (gap - margin(s) - margin(t)).abs() < slack + 2e-6 * least + 2e-7 * (margin(s) + margin(t))
    };
    for c in found {
        assert!(c.shapes[0] < c.shapes[1]);
        let Some((bodies, normal, gap, reach, law)) = expected.remove(&c.shapes) else {
            assert!(is_at_the_end(c.shapes, c.gap as f64), "{c:?} is no contact");
            continue;
        };
        assert_eq!((c.bodies, c.law), (bodies, law));
        // Deep in each other or far apart, single precision of the radii and of the gap.
        let deep = 5e-7 * (reach[0] + reach[1] - gap) + 6e-7 * gap.abs();
        let tolerance = slack + if gap.abs() < least { 1e-6 * least } else { 1e-6 * least + deep };
        assert!((c.gap as f64 - gap).abs() < tolerance, "{c:?}: gap {gap}");
        let off = (DVec3::from_array(c.normal.map(f64::from)) - normal).length();
        // Near concentric spheres the direction is as uncertain as the units are coarse.
        let distance = reach[0] + reach[1];
        assert!(off < 1e-6 + (1e-6 * least + 20.0 * slack) / distance.max(1e-300), "{c:?}: normal {normal}, {off}");
        let arms = [0, 1].map(|k| (c.reach[k] as f64 - reach[k]).abs());
        assert!(arms.iter().all(|a| *a < tolerance + 2e-7 * distance.abs().max(least) + deep), "{c:?}: {reach:?}");
    }
    let missed = expected.iter().find(|(shapes, c)| !is_at_the_end(**shapes, c.2));
    assert!(missed.is_none(), "{missed:?} is missing");
}

/// The contacts that a device finds.
fn found(model: &Model, state: &State) -> Option<Vec<Contact>> {
    let (device, kernels) = device()?;
    let mut collision = Collision::new(device, kernels, model, state).unwrap();
    let first = collision.run(device, kernels, model).unwrap();
    let contacts = collision.contacts(device).unwrap();
    assert_eq!(first.contacts, contacts.len());
    // The same bits again, with the pairs of before and with pairs that are found again.
    for again in [false, true] {
        if again {
            collision.find_all(device);
        }
        assert_eq!(collision.run(device, kernels, model).unwrap(), first);
        assert!(collision.contacts(device).unwrap() == contacts);
    }
    Some(contacts)
}

fn compare(n: usize, place: impl FnMut(usize) -> (DVec3, f64, DVec3)) -> usize {
    let (model, state) = spheres(n, place);
    let Some(found) = found(&model, &state) else { return usize::MAX };
    hold(&model, &state, &found);
    let are_spheres = |c: &&Contact| c.shapes.iter().all(|s| model.shape_kind[*s as usize] == ShapeKind::Sphere);
    found.iter().filter(are_spheres).count()
}

fn vector(random: &mut SplitMix64, size: f64) -> DVec3 {
    DVec3::from_array(std::array::from_fn(|_| random.between(-size, size)))
}

#[test]
fn rows_are_laid_out_as_in_the_kernels() {
    let text = |files: &[&str]| {
        let lines = files.iter().flat_map(|f| f.lines()).filter(|line| !line.starts_with("#import"));
        lines.fold(String::new(), |text, line| text + line + "\n")
    };
    let (fixed, sphere) = (include_str!("fixed.wgsl"), include_str!("sphere.wgsl"));
    check::<Fixture>(&text(&[fixed, include_str!("fixture.wgsl")])).unwrap();
    let (rolls, scalars) = (include_str!("rolls.wgsl"), include_str!("scalars.wgsl"));
    check::<Summary>(&text(&[rolls, scalars, include_str!("partial.wgsl"), include_str!("summary.wgsl")])).unwrap();
    check::<Fixed>(fixed).unwrap();
    check::<Sphere>(&text(&[fixed, sphere])).unwrap();
    check::<Aabb>(&text(&[fixed, sphere])).unwrap();
    check::<Contact>(&text(&[fixed, sphere, include_str!("contact.wgsl")])).unwrap();
    check::<Body>(&text(&[include_str!("row.wgsl"), include_str!("solve_row.wgsl")])).unwrap();
    let joints = "fn change_of(body: u32) -> Twist { return Twist(vec3(0.0), vec3(0.0)); }
fn change_body(body: u32, change: Twist) {}
";
    let joints = text(&[include_str!("joint_solve.wgsl"), joints]);
    check::<Member>(&joints).unwrap();
    check::<JointSide>(&joints).unwrap();
    check::<JointRow>(&joints).unwrap();
    check::<BodyState>(&text(&[fixed, sphere, include_str!("body_state.wgsl")])).unwrap();
    let solve_row = [include_str!("row.wgsl"), include_str!("solve_row.wgsl")];
    check::<MemberFree>(&text(&[fixed, sphere, solve_row[0], solve_row[1], include_str!("member_free.wgsl")])).unwrap();
    check::<Arms>(&text(&[fixed, sphere, include_str!("contact.wgsl")])).unwrap();
    check::<Node>(include_str!("node.wgsl")).unwrap();
    check::<Solid>(&text(&[fixed, include_str!("fixture.wgsl"), include_str!("solid.wgsl")])).unwrap();
}

/// Gaps of the kernels' fixed point, in units of the scale.
const GAPS: &str = "
#import fixed
@group(0) @binding(0) var<storage, read> centres: array<Fixed>;
@group(0) @binding(1) var<storage, read> radii: array<u32>;
@group(0) @binding(2) var<storage, read_write> gaps: array<f32>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let k = id.x;
    if k < arrayLength(&gaps) {
        let offset = subtract_fixed(centres[2u * k + 1u], centres[2u * k]);
        gaps[k] = normal_and_gap(offset, add64(vec2(radii[2u * k], 0u), vec2(radii[2u * k + 1u], 0u))).w;
    }
}
";

#[test]
fn gaps_in_fixed_point_are_their_twin_a_kilometre_and_more_from_the_origin() {
    let Some((device, kernels)) = device() else { return };
    let (least, mut random) = (0.01, SplitMix64(8));
    let scale = Scale::of(least);
    let (mut centres, mut radii) = (vec![], vec![]);
    for k in 0..6000 {
        let far = [0.0, 1e3, 1e6][k % 3];
        let size = if k % 2 == 0 { least } else { random.between(least, 300.0 * least) };
        let pair = [size, random.between(least, 300.0 * least)];
        // Near touching, deep in each other, and concentric.
        let reach = match k % 50 {
            0 => 0.0,
            1..10 => (pair[0] + pair[1]) * random.uniform(),
            _ => pair[0] + pair[1] + random.between(-0.5, 0.5) * least,
        };
        let a = DVec3::splat(-far) + vector(&mut random, 1.0);
        centres.extend([a, a + random.rotation() * DVec3::X * reach].map(|p| scale.fix(p).unwrap()));
        radii.extend(pair.map(|r| scale.radius(r)));
    }
    let n = radii.len() / 2;
    let columns = (Buffer::of(device, "centres", &centres).unwrap(), Buffer::of(device, "radii", &radii).unwrap());
    let gaps = Buffer::<f32>::zeros(device, "gaps", n).unwrap();
    let mut commands = Commands::new();
    let kernel = kernel(device, kernels, "gaps", GAPS).unwrap();
    let bound = [columns.0.bind(), columns.1.bind(), gaps.bind()];
    commands.dispatch(device, &kernel, &bound, &[], Work::Groups(n.div_ceil(64) as u32));
    commands.submit(device).unwrap();
    for (k, gap) in gaps.read(device, n).unwrap().into_iter().enumerate() {
        let pair = [radii[2 * k], radii[2 * k + 1]];
        let exact = gap_cpu(scale, [centres[2 * k], centres[2 * k + 1]], pair);
        let off = (gap as f64 * scale.unit - exact).abs();
        let reach = (pair[0] as f64 + pair[1] as f64) * scale.unit;
        let is_deep = exact * exact + 2.0 * exact.abs() * reach > 3.9e18 * scale.unit * scale.unit;
        let bound = if is_deep { 5e-7 * reach } else { 6e-7 * exact.abs() + 1e-9 * least };
        assert!(off <= bound, "{k}: {gap} {exact} {off} {bound}");
    }
}

#[test]
fn a_bed_of_spheres_has_the_contacts_of_the_cpu() {
    let mut random = SplitMix64(1);
    let n = compare(3000, |_| {
        let p = DVec3::splat(1.0) + vector(&mut random, 0.8);
        (p, 0.075, vector(&mut random, 3.0))
    });
    assert!(n > 3000, "{n}");
}

#[test]
fn a_bed_a_kilometre_from_the_origin_has_the_contacts_of_the_cpu() {
    let mut random = SplitMix64(2);
    let n = compare(1000, |_| {
        let p = DVec3::new(1000.0, -1000.0, 1000.0) + vector(&mut random, 0.08);
        (p, random.between(0.01, 0.012), vector(&mut random, 0.1))
    });
    assert!(n > 1000, "{n}");
}

#[test]
fn radii_of_one_to_three_hundred_have_the_contacts_of_the_cpu() {
    let mut random = SplitMix64(3);
    let n = compare(2000, |k| {
        // A few great ones, and small ones on their surfaces.
        let radius = if k % 100 == 0 { 3.0 } else { random.between(0.01, 0.05) };
        let centre = DVec3::new((k / 100 * 5) as f64, 0.0, 0.0);
        let near = centre + random.rotation() * DVec3::X * (3.0 + radius + random.between(-0.01, 0.01));
        (if k % 100 == 0 { centre } else { near }, radius, DVec3::ZERO)
    });
    assert!(n > 900, "{n}");
}

#[test]
fn adverse_beds_have_the_contacts_of_the_cpu() {
    // Concentric, so that all are in one bin and there are far more pairs than room.
    assert!([300 * 299 / 2, usize::MAX].contains(&compare(300, |_| (DVec3::ONE, 0.05, DVec3::ZERO))));
    // On top of each other in a line of bins, exact touch, one alone, and a step's motion that is longer than the bed.
    let line = compare(500, |k| (DVec3::new(1e-6 * k as f64, 1.0, 1.0), 0.05, DVec3::ZERO));
    assert!([500 * 499 / 2, usize::MAX].contains(&line), "{line}");
    compare(1000, |k| (DVec3::new((k % 10) as f64, (k / 10 % 10) as f64, (k / 100) as f64), 0.5, DVec3::ZERO));
    assert!([0, usize::MAX].contains(&compare(1, |_| (DVec3::ONE, 0.1, DVec3::ZERO))));
    let mut random = SplitMix64(5);
    compare(300, |k| (vector(&mut random, 1.0), 0.05, DVec3::X * if k == 7 { 3000.0 } else { 0.0 }));
}

#[test]
fn held_inactive_and_excluded_bodies_have_the_contacts_of_the_cpu() {
    let mut random = SplitMix64(6);
    let (mut model, mut state) = spheres(1500, |_| (DVec3::ONE + vector(&mut random, 0.6), 0.075, DVec3::ZERO));
    model.group_names = vec!["all".into(), "ghosts".into()];
    model.groups_pass = vec![false, true, true, false];
    let first = model.n_bodies() as u32 - 1500;
    for s in 0..model.n_shapes() {
        model.shape_group[s] = (s % 5 == 0) as u32;
    }
    model.exclusions = (first..first + 1400).map(|a| [a, a + 1 + a % 7]).collect();
    for body in first as usize..model.n_bodies() {
        if body % 3 == 0 {
            (model.inv_mass[body], model.inv_inertia[body]) = (0.0, DVec3::ZERO);
        }
    }
    state.activity.clear();
    state.wake(&model);
    let Some(contacts) = found(&model, &state) else { return };
    hold(&model, &state, &contacts);
    assert!(contacts.len() > 500, "{}", contacts.len());

    // The same bodies, some of which are not there now.
    let (device, kernels) = device().unwrap();
    let mut collision = Collision::new(device, kernels, &model, &state).unwrap();
    collision.run(device, kernels, &model).unwrap();
    for body in (first as usize..model.n_bodies()).step_by(4) {
        state.activity[body] = Activity::Inactive;
    }
    collision.place(device, &model, &state).unwrap();
    collision.run(device, kernels, &model).unwrap();
    let left = collision.contacts(device).unwrap();
    let is_there = |c: &&Contact| c.bodies.iter().all(|b| !state.is_inactive(*b as usize));
    let mut kept: Vec<[u32; 2]> = contacts.iter().filter(is_there).map(|c| c.shapes).collect();
    let mut shapes: Vec<[u32; 2]> = left.iter().map(|c| c.shapes).collect();
    kept.sort();
    shapes.sort();
    assert!(kept == shapes && kept.len() < contacts.len());
}

#[test]
fn pairs_are_kept_while_they_hold_and_found_again_when_they_do_not() {
    let Some((device, kernels)) = device() else { return };
    let mut random = SplitMix64(7);
    let (model, mut state) = spheres(2000, |_| (DVec3::ONE + vector(&mut random, 0.7), 0.075, DVec3::ZERO));
    let mut collision = Collision::new(device, kernels, &model, &state).unwrap();
    let mut pairs = vec![];
    for _ in 0..8 {
        pairs.push(collision.run(device, kernels, &model).unwrap().pairs);
        hold(&model, &state, &collision.contacts(device).unwrap());
        state.position.iter_mut().for_each(|p| *p += vector(&mut random, 0.0007));
        collision.place(device, &model, &state).unwrap();
    }
    pairs.dedup();
    assert!((2..8).contains(&pairs.len()), "pairs are found in some of the steps: {pairs:?}");
}

#[test]
fn what_is_not_built_for_devices_is_refused() {
    let Some((device, kernels)) = device() else { return };
    let refused = |model: &Model, state: &State| match Collision::new(device, kernels, model, state).err().unwrap() {
        Fault::Unsupported(message) => message,
        other => panic!("{other}"),
    };
    let (mut model, mut state) = spheres(3, |k| (DVec3::X * k as f64, 0.1, DVec3::ZERO));
    let last = model.n_shapes() - 1;
    let (body, centre) = (model.shape_body[last] as usize, state.position[model.shape_body[last] as usize]);
    state.position[body] = DVec3::X * 1e30;
    let error = Collision::new(device, kernels, &model, &state).err().unwrap();
    assert_eq!(error, Fault::Position(body as u32));
    state.position[body] = centre;
    model.shape_size[last] = DVec3::splat(100.0);
    assert!(refused(&model, &state).contains("1000 times"));
    model.shape_size[last] = DVec3::splat(0.1);
    let (model, state) = spheres(0, |_| unreachable!());
    assert!(refused(&model, &state).contains("no body of the model that moves"));
}

/// Spheres that overlap far from all planes, and settings of Jacobi that both back ends have.
fn jacobi_bed(n: usize) -> (Model, State) {
    let mut random = SplitMix64(9);
    let (mut model, mut state) = spheres(n, |_| {
        (DVec3::splat(1e3) + vector(&mut random, 0.6), random.between(0.05, 0.08), vector(&mut random, 1.0))
    });
    // The planes are far away, and open to this side.
    for s in 0..model.n_shapes() {
        if model.shape_kind[s] == ShapeKind::Plane {
            state.position[model.shape_body[s] as usize] = DVec3::ZERO;
            state.orientation[model.shape_body[s] as usize] = glam::DQuat::IDENTITY;
        }
    }
    state.angular_velocity.iter_mut().for_each(|w| *w = vector(&mut random, 5.0));
    model.solver = crate::SolverSettings { omega: Some(0.2), lambda: 0.9, ..workload::solver(Method::Jacobi, 40) };
    (model, state)
}

#[test]
fn jacobi_has_the_impulses_and_velocities_of_the_cpu() {
    let Some((device, kernels)) = device() else { return };
    let (mut model, mut state) = jacobi_bed(1200);
    for body in (5..model.n_bodies()).step_by(9) {
        (model.inv_mass[body], model.inv_inertia[body]) = (0.0, DVec3::ZERO);
        (state.velocity[body], state.angular_velocity[body]) = (DVec3::ZERO, DVec3::ZERO);
    }
    state.activity.clear();
    state.wake(&model);
    let mut collision = Collision::new(device, kernels, &model, &state).unwrap();
    let found = collision.run(device, kernels, &model).unwrap();
    let jacobi = ContactSolve::new(device, kernels, (&model, Method::Jacobi), &collision).unwrap();
    jacobi.run(device, kernels, (&model, &collision)).unwrap();
    let impulses = jacobi.impulses(device, found.contacts).unwrap();
    let motion = jacobi.motion(device).unwrap();
    jacobi.run(device, kernels, (&model, &collision)).unwrap();
    assert!(jacobi.impulses(device, found.contacts).unwrap() == impulses, "a run repeats bit for bit");

    let shapes: Vec<[u32; 2]> = collision.contacts(device).unwrap().iter().map(|c| c.shapes).collect();
    let mut simulation = Simulation::new(model, state);
    simulation.step();
    let contacts = &simulation.state.contacts;
    let expected: BTreeMap<[u32; 2], DVec3> =
        (0..contacts.len()).map(|i| ([contacts.key[i][0], contacts.key[i][1]], contacts.impulse[i])).collect();
    assert_eq!(expected.len(), shapes.len());
    let largest = expected.values().map(|z| z.length()).fold(0.0, f64::max);
    let matters = |z: &DVec3| z.length() > 1e-3 * largest;
    assert!(expected.values().filter(|z| matters(z)).count() > 500);
    for (shapes, z) in shapes.iter().zip(&impulses) {
        let z = DVec3::new(z[0] as f64, z[1] as f64, z[2] as f64);
        let off = (z - expected[shapes]).length();
        assert!(off < 1e-4 * largest, "{shapes:?}: {z} {}", expected[shapes]);
    }
    let speeds = simulation.state.velocity.iter().map(|v| v.length()).fold(0.0, f64::max);
    for (b, own) in motion.iter().enumerate().filter(|(b, _)| simulation.state.moves(*b)) {
        let v = DVec3::from_array(own.v.map(f64::from));
        let w = DVec3::from_array(own.w.map(f64::from));
        let twist = simulation.state.twist(b);
        assert!((v - twist.v).length() < 1e-4 * speeds, "{b}: {v} {}", twist.v);
        assert!((w - twist.w).length() < 1e-4 * speeds / 0.05, "{b}: {w} {}", twist.w);
    }
}

/// Velocities of the solution are unique: APGD on the device comes to those of the CPU's, each by its own steps, and in far fewer
/// iterations than Jacobi.
#[test]
fn apgd_comes_to_the_velocities_of_the_cpu() {
    let Some((device, kernels)) = device() else { return };
    let (mut model, state) = jacobi_bed(1200);
    let solve = |model: &Model| -> Vec<DVec3> {
        let mut collision = Collision::new(device, kernels, model, &state).unwrap();
        collision.run(device, kernels, model).unwrap();
        let solver = ContactSolve::new(device, kernels, (model, model.solver.method.unwrap()), &collision).unwrap();
        solver.run(device, kernels, (model, &collision)).unwrap();
        let motion = solver.motion(device).unwrap();
        // The next solve begins with the step length of the last.
        solver.run(device, kernels, (model, &collision)).unwrap();
        assert!(solver.motion(device).unwrap().iter().all(|b| b.v.iter().all(|x| x.is_finite())));
        motion.iter().map(|b| DVec3::from_array(b.v.map(f64::from))).collect()
    };
    let solved_cpu = |model: &Model| -> Vec<DVec3> {
        let mut simulation = Simulation::new(model.clone(), state.clone());
        simulation.step();
        simulation.state.velocity.clone()
    };
    model.solver = workload::solver(Method::Apgd, 3000);
    let exact = solved_cpu(&model);
    let speed = exact.iter().map(|v| v.length()).fold(0.0, f64::max);
    // Root mean square of what velocities are off by, over the greatest speed.
    let off = |found: Vec<DVec3>| {
        let sum: f64 =
            (0..found.len()).filter(|b| state.moves(*b)).map(|b| (found[b] - exact[b]).length_squared()).sum();
        (sum / found.len() as f64).sqrt() / speed
    };
    model.solver = workload::solver(Method::Apgd, 150);
    let (apgd, apgd_cpu) = (off(solve(&model)), off(solved_cpu(&model)));
    model.solver.method = Some(Method::Jacobi);
    model.solver.omega = Some(0.3);
    let jacobi = off(solve(&model));
    assert!(apgd < 0.5 * jacobi && apgd < 3.0 * apgd_cpu + 1e-4, "APGD {apgd}, on the CPU {apgd_cpu}, Jacobi {jacobi}");
    model.solver = workload::solver(Method::Apgd, 1000);
    let long = off(solve(&model));
    assert!(long < 1e-3 && long <= apgd.max(1e-5), "{long} after {apgd}");
}
