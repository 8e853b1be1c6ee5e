//! Meshes and height fields on a device against the CPU back end's.

use super::solids::{cone, hold as hold_solids, lump};
use super::whole::{on_device, written};
use super::{device, vector};
use crate::fill::SplitMix64;
use crate::geometry::Surface;
use crate::gpu::collision::Collision;
use crate::model_file::ShapeFile;
use crate::shape::ShapeKind;
use crate::simulation::Simulation;
use crate::{Arms, Method, Model, ModelBuilder, SolverSettings, State};
use glam::{DQuat, DVec3};
use std::collections::BTreeMap;

/// A block of twelve triangles about the origin.
fn block(half: DVec3) -> Surface {
    let vertices =
        (0..8).map(|k| half * DVec3::from([k & 1, k >> 1 & 1, k >> 2].map(|b| 2.0 * b as f64 - 1.0))).collect();
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    Surface::mesh(vertices, faces.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect())
}

/// Waves and a flat part, of cells of 0.1 m.
fn waves() -> Surface {
    let n = 17;
    let heights: Vec<f64> = (0..n * n)
        .map(|k| {
            let (x, y) = (0.1 * (k % n) as f64, 0.1 * (k / n) as f64);
            if x > 1.0 { 0.0 } else { 0.06 * (7.0 * x).sin() * (5.0 * y).cos() }
        })
        .collect();
    Surface::height_field(&heights, [n, n], [-0.8, -0.8], [0.1, 0.1])
}

/// Bodies over a height field, in which a block of triangles stands, somewhere in the world.
pub fn over_ground(shapes: impl Fn(usize) -> ShapeFile, n: usize, at: DVec3) -> (Model, State) {
    let mut builder = ModelBuilder::new("ground");
    builder.material("stone", 2600.0, 0.5);
    // The field comes before the bodies that move, the block after them.
    builder.body("field", "stone", ShapeFile::cuboid([1.0; 3])).fixed = true;
    for k in 0..n {
        builder.body(&format!("s{k}"), "stone", shapes(k)).position = [k as f64, 0.0, 1000.0];
    }
    builder.body("block", "stone", ShapeFile::cuboid([1.0; 3])).fixed = true;
    let mut sim = builder.simulation().unwrap();
    let turned = DQuat::from_euler(glam::EulerRot::XYZ, 0.3, -0.2, 0.5);
    let places = [
        ("field", ShapeKind::HeightField, waves(), DVec3::ZERO, DQuat::from_rotation_x(0.1)),
        ("block", ShapeKind::Mesh, block(DVec3::new(0.25, 0.2, 0.3)), DVec3::new(0.1, -0.1, 0.1), turned),
    ];
    for (name, kind, surface, position, orientation) in places {
        let b = sim.model.body_names[name] as usize;
        let s = sim.model.shape_body.iter().position(|body| *body as usize == b).unwrap();
        let (low, high) = surface.bounds();
        sim.model.shape_kind[s] = kind;
        sim.model.shape_size[s] = low.abs().max(high.abs());
        sim.model.shape_part[s] = sim.model.surfaces.len() as u32;
        sim.model.surfaces.push(surface);
        (sim.state.position[b], sim.state.orientation[b]) = (at + position, orientation);
    }
    (sim.model, sim.state)
}

/// A place near a face, an edge or a corner of one of the surfaces, at a height over it.
fn near_by(model: &Model, state: &State, random: &mut SplitMix64, height: f64) -> DVec3 {
    let name = ["field", "block"][random.below(2)];
    let b = model.body_names[name] as usize;
    let s = model.shape_body.iter().position(|body| *body as usize == b).unwrap();
    let surface = &model.surfaces[model.shape_part[s] as usize];
    let corners = surface.corners(random.below(surface.triangles.len()) as u32);
    let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
    let (u, v) = match random.below(4) {
        0 => (0.0, 0.0),
        1 => (random.uniform(), 0.0),
        _ => (random.uniform(), random.uniform()),
    };
    let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
    let on = corners[0] * (1.0 - u - v) + corners[1] * u + corners[2] * v;
    let aside = vector(random, 0.3 * height.abs());
    state.position[b] + state.orientation[b] * (on + normal * height + aside)
}

/// Spheres that touch faces, edges and corners, also a kilometre from the origin: the triangles of each, their gaps to 1e-6 of the radius.
#[test]
fn spheres_on_surfaces_have_the_contacts_of_the_cpu() {
    for at in [DVec3::ZERO, DVec3::new(1000.0, -1000.0, 500.0)] {
        let mut random = SplitMix64(7);
        let radius = 0.02;
        let n_spheres = 1500;
        let (model, mut state) = over_ground(|_| ShapeFile::sphere(radius), n_spheres, at);
        for k in 0..n_spheres {
            let b = model.body_names[&format!("s{k}")] as usize;
            let height = radius * random.between(-0.4, 1.02);
            state.position[b] = near_by(&model, &state, &mut random, height);
            state.velocity[b] = vector(&mut random, 0.2);
        }
        let Some((device, kernels)) = device() else { return };
        let mut collision = Collision::new(device, kernels, &model, &state).unwrap();
        let found = collision.run(device, kernels, &model).unwrap();
        let contacts = collision.contacts(device).unwrap();
        collision.find_all(device);
        assert_eq!(collision.run(device, kernels, &model).unwrap(), found);
        assert!(collision.contacts(device).unwrap() == contacts, "a run repeats bit for bit");
        let mut cpu = Simulation::new(model.clone(), state.clone());
        cpu.step();
        let c = &cpu.state.contacts;
        let Arms::Along(reach) = &c.arms else { panic!("spheres have arms along the normal") };
        let is_ground = |key: &[u32; 3]| key[..2].iter().any(|s| model.shape_kind[*s as usize].is_surface());
        let expected: BTreeMap<[u32; 3], (DVec3, f64, [f64; 2])> = (0..c.len())
            .map(|i| (c.key[i], (c.normal[i], c.gap[i], reach[i])))
            .filter(|(key, _)| is_ground(key))
            .collect();
        let own: BTreeMap<[u32; 3], _> = contacts.iter().map(|c| ([c.shapes[0], c.shapes[1], c.feature], c)).collect();
        assert_eq!(own.len(), contacts.len(), "a contact has a key of its own");
        let is_face = |key: &[u32; 3], normal: DVec3| {
            let s = key[if model.shape_kind[key[0] as usize].is_surface() { 0 } else { 1 }] as usize;
            let corners = model.surfaces[model.shape_part[s] as usize].corners(key[2] >> 17);
            let face = state.orientation[model.shape_body[s] as usize]
                * (corners[1] - corners[0]).cross(corners[2] - corners[0]);
            face.normalize().cross(normal).length() < 1e-9
        };
        let (mut n, mut n_seams) = (0, 0);
        for (key, (normal, gap, reach)) in &expected {
            let Some(own) = own.get(key) else {
                n_seams += 1;
                continue;
            };
            n += 1;
            let off = (DVec3::from_array(own.normal.map(f64::from)) - *normal).length();
            // At an edge that lies in its face, which the device does not tell from the face.
            if off > 2e-5 && off < 1e-4 {
                n_seams += 1;
                continue;
            }
            // Of edges and corners single precision of the triangle.
            let size = if is_face(key, *normal) { 0.0 } else { 1.0 };
            let slack = 1e-6 * radius + 5e-7 * gap.abs() + 1e-7 * size;
            // The direction from a centre that is nearly on an edge.
            let turn = 1e-7 * size / (gap + radius).abs().max(1e-12);
            assert!((own.gap as f64 - gap).abs() < slack && off < 2e-5 + turn, "{own:?}: {gap}, {normal}, {off}");
            assert!([0, 1].iter().all(|k| (own.reach[*k] as f64 - reach[*k]).abs() < slack), "{own:?} {reach:?}");
        }
        n_seams += own.keys().filter(|key| is_ground(key) && !expected.contains_key(*key)).count();
        eprintln!("{n} contacts, {n_seams} at seams of one alone");
        // At a seam of two faces in one plane either may have the contact: it counts twice.
        assert!(n > 1000 && n_seams * 100 <= n, "{n} contacts, {n_seams} at seams of one alone");
    }
}

/// Bodies that have met the ground for some steps, on both back ends for `steps` more.
fn fall(model: &mut Model, state: &State, (method, tolerance): (Method, f64), steps: u32) {
    let iterations = Some(100);
    // Contact points are found anew in each step, as on the device.
    model.recycle = 0.0;
    model.solver = SolverSettings { method: Some(method), iterations, tolerance: 1e-6, ..model.solver.clone() };
    let mut cpu = Simulation::new(model.clone(), state.clone());
    (0..150).for_each(|_| drop(cpu.step()));
    let state = written(&cpu.state);
    let Some(mut own) = on_device(model, &state) else { return };
    let mut n_contacts = 0;
    for _ in 0..steps {
        let (a, b) = (own.step(), cpu.step());
        n_contacts = n_contacts.max(b.contacts);
        assert!(a.broken.is_none(), "{a:?}");
    }
    own.fetch().unwrap();
    let mut off: Vec<f64> =
        own.state.position.iter().zip(&cpu.state.position).map(|(a, b)| (*a - *b).length()).collect();
    off.sort_by(f64::total_cmp);
    let [usual, most, all] = [off.len() * 9 / 10, off.len() - 2, off.len() - 1].map(|k| off[k]);
    eprintln!(
        "{method:?}: {n_contacts} contacts, nine of ten bodies within {usual} m, all but one within {most} m, that within {all} m"
    );
    // What touches a seam may be given to either of its triangles, and then turns another way.
    assert!(
        n_contacts > 40 && usual < tolerance && most < 20.0 * tolerance && all < 1e-3,
        "{method:?}: {n_contacts} contacts, {usual}, {most}, {all} m"
    );
}

/// Place the bodies that move in layers over the ground, falling.
pub fn layers(model: &Model, state: &mut State, n: usize) {
    let mut random = SplitMix64(3);
    for k in 0..n {
        let b = model.body_names[&format!("s{k}")] as usize;
        let at = DVec3::new((k % 6) as f64, (k / 6 % 6) as f64, (k / 36) as f64) * 0.2;
        state.position[b] = at + DVec3::new(-0.5, -0.5, 0.25) + vector(&mut random, 0.02);
        state.velocity[b] = DVec3::Z * -3.0;
        state.orientation[b] = random.rotation();
    }
}

#[test]
fn steps_of_spheres_on_surfaces_are_those_of_the_cpu() {
    let (mut model, mut state) = over_ground(|k| ShapeFile::sphere(0.05 + 0.01 * (k % 4) as f64), 100, DVec3::ZERO);
    layers(&model, &mut state, 100);
    for method in [Method::Apgd, Method::GaussSeidel] {
        fall(&mut model, &state, (method, 2e-6), 20);
    }
}

pub fn solids(k: usize) -> ShapeFile {
    match k % 7 {
        0 => ShapeFile::cuboid([0.1, 0.12, 0.08]),
        1 => ShapeFile::capsule(0.04, 0.1),
        2 => lump(12, 0.08, k as u64),
        3 => ShapeFile::cylinder(0.05, 0.1),
        4 => ShapeFile::sphere(0.05),
        5 => cone(0.06, 0.12),
        _ => ShapeFile::ellipsoid([0.06, 0.05, 0.08]),
    }
}

#[test]
fn solids_on_surfaces_have_the_contacts_of_the_cpu() {
    let n_bodies = 1000;
    let (mut model, mut state) = over_ground(solids, n_bodies, DVec3::ZERO);
    let mut random = SplitMix64(8);
    for k in 0..n_bodies {
        let b = model.body_names[&format!("s{k}")] as usize;
        let height = random.between(0.02, 0.07);
        state.position[b] = near_by(&model, &state, &mut random, height);
        state.orientation[b] = random.rotation();
        state.velocity[b] = vector(&mut random, 0.2);
    }
    // They are in each other, but only the ground counts.
    let n_groups = 2;
    model.group_names = vec!["all".into(), "ground".into()];
    model.groups_pass = (0..n_groups * n_groups).map(|k| k == 0).collect();
    for s in 0..model.n_shapes() {
        model.shape_group[s] = model.shape_kind[s].is_surface() as u32;
    }
    let n = hold_solids(&model, &state, [5e-5, 1e-2, 0.8, 2e-3]);
    assert!(n > 50, "{n}");
}

#[test]
fn steps_of_solids_on_surfaces_are_those_of_the_cpu() {
    let (mut model, mut state) = over_ground(solids, 36, DVec3::ZERO);
    layers(&model, &mut state, 36);
    // What turns another way at a seam soon meets others.
    for method in [Method::Apgd, Method::GaussSeidel] {
        fall(&mut model, &state, (method, 2e-5), 3);
    }
}

/// Boxes that slide against the sides of a block of triangles on the ground, and along them past its edges, at any angle and with some sides in
/// the planes of its faces: none is under another face, on either back end.
#[test]
fn what_slides_against_a_mesh_is_beside_it() {
    let mut random = SplitMix64(15);
    let n = 60;
    let sizes: Vec<DVec3> = (0..n)
        .map(|k| {
            let size = DVec3::from_array(std::array::from_fn(|_| (random.between(0.1, 1.2) * 100.0).round() / 100.0));
            if k % 5 == 0 { size.with_z(1.0) } else { size }
        })
        .collect();
    let mut builder = ModelBuilder::new("sides");
    builder.material("stone", 1000.0, 0.3);
    builder.body("ground", "stone", ShapeFile::plane([0.0, 0.0, 1.0]));
    builder.body("block", "stone", ShapeFile::cuboid([1.0, 2.0, 1.0])).fixed = true;
    for (k, size) in sizes.iter().enumerate() {
        let body = builder.body(&format!("s{k}"), "stone", ShapeFile::cuboid(size.to_array()));
        body.position = [3.0 * k as f64 + 10.0, 0.0, 0.5 * size.z];
    }
    let mut sim = builder.simulation().unwrap();
    let of_block = sim.model.body_names["block"] as usize;
    let s = sim.model.shape_body.iter().position(|body| *body as usize == of_block).unwrap();
    let surface = block(DVec3::new(0.5, 1.0, 0.5));
    (sim.model.shape_kind[s], sim.model.shape_part[s]) = (ShapeKind::Mesh, 0);
    sim.model.surfaces.push(surface);
    sim.state.position[of_block] = DVec3::Z * 0.5;
    // They pass through each other.
    sim.model.group_names = vec!["all".into(), "ground".into()];
    sim.model.groups_pass = vec![true, false, false, false];
    for s in 0..sim.model.n_shapes() {
        sim.model.shape_group[s] = (sim.model.inv_mass[sim.model.shape_body[s] as usize] == 0.0) as u32;
    }
    for (k, size) in sizes.iter().enumerate() {
        let b = sim.model.body_names[&format!("s{k}")] as usize;
        let (speed, aside) = (random.between(0.5, 6.0), random.between(-2.0, 2.0));
        let reach = 0.55 * size.truncate().length();
        let (position, velocity) = match k % 2 {
            0 => (DVec3::new(-0.55 - reach, random.between(-1.0, 1.0), 0.0), DVec3::new(speed, aside, 0.0)),
            _ => (DVec3::new(random.between(-0.5, 0.5), -1.05 - reach, 0.0), DVec3::new(aside, speed, 0.0)),
        };
        sim.state.position[b] = position.with_z(0.5 * size.z);
        sim.state.velocity[b] = velocity;
        sim.state.orientation[b] = DQuat::from_rotation_z(if k % 3 == 0 { random.between(0.0, 1.6) } else { 0.0 });
    }
    for (step, n_steps) in [(1e-3, 300), (5e-3, 100)] {
        sim.model.step = step;
        let solver = sim.model.solver.clone();
        sim.model.solver = SolverSettings { method: Some(Method::Apgd), iterations: Some(60), ..solver };
        let Some(own) = on_device(&sim.model, &sim.state) else { return };
        for mut simulation in [Simulation::new(sim.model.clone(), sim.state.clone()), own] {
            let mut worst = (0.0, 0);
            for _ in 0..n_steps {
                let report = simulation.step();
                worst =
                    if report.worst_penetration > worst.0 { (report.worst_penetration, report.step) } else { worst };
            }
            let what = format!("{} s, {}: {} m in step {}", step, simulation.backend(), worst.0, worst.1);
            eprintln!("{what}");
            assert!(worst.0 < 0.02, "{what}");
        }
    }
}
