//! Terrain: heights, ditches and boulders are as the model says, the same for the same seed, and carry what is put on them.

use crate::analytic::{run, simulation};
use glam::{DVec2, DVec3};
use sim::{ShapeKind, Simulation};

/// A model with one terrain and what else it has.
fn terrain(seed: u64, keys: &str, more: &str) -> Simulation {
    simulation(&format!(
        "step: 1e-3
seed: {seed}
solver: {{iterations: 200}}
materials: {{m: {{density: 2000, friction: 0.6, rolling: 2e-2}}}}
terrains:
  - {{name: hills, material: m, {keys}}}
{more}"
    ))
}

const HILLS: &str =
    "position: [1, -2, 0.5], size: [16, 12], spacing: 0.25, amplitude: 0.6, wavelength: 5, flat_radius: 2";
const DITCH: &str = "ditches: [{from: [5, -4], to: [5, 4], width: 1.5, depth: 0.4}]";
const BOULDERS: &str = "boulders: {count: 14, radius: [0.2, 0.5]}";

/// The grid's points from the terrain's middle.
fn points(sim: &Simulation) -> Vec<DVec3> {
    let s = sim.model.shape_kind.iter().position(|k| *k == ShapeKind::HeightField).expect("a height field");
    let place = sim.state.shape_pose(&sim.model, s);
    let middle = sim.state.position[sim.model.body_names["hills"] as usize];
    let surface = &sim.model.surfaces[sim.model.shape_part[s] as usize];
    surface.vertices.iter().map(|v| place.position + place.orientation * *v - middle).collect()
}

#[test]
fn heights_are_within_the_amplitude_flat_in_the_middle_and_repeatable() {
    let sim = terrain(3, HILLS, "");
    let all = points(&sim);
    assert_eq!(all.len(), 65 * 49);
    let middle = sim.state.position[sim.model.body_names["hills"] as usize];
    assert!((middle - DVec3::new(1.0, -2.0, 0.5)).length() < 1e-12);
    let corner = all.iter().fold(DVec3::ZERO, |max, p| max.max(p.abs()));
    assert!((corner.truncate() - DVec2::new(8.0, 6.0)).length() < 1e-9 && corner.z <= 0.6 + 1e-12, "{corner}");
    let (flat, rest): (Vec<DVec3>, Vec<DVec3>) = all.iter().partition(|p| p.truncate().length() <= 2.0);
    assert!(flat.len() > 150 && flat.iter().all(|p| p.z.abs() < 1e-12));
    let high = rest.iter().filter(|p| p.z > 0.1).count();
    let low = rest.iter().filter(|p| p.z < -0.1).count();
    assert!(high > 100 && low > 100, "{high} points are high, {low} low");
    // No cliffs: between neighbours the waves rise by no more than their slope.
    let steepest = all.windows(2).filter(|w| w[0].y == w[1].y).map(|w| (w[1].z - w[0].z).abs() / 0.25);
    assert!(steepest.fold(0.0, f64::max) < 4.0);
    assert_eq!(points(&terrain(3, HILLS, "")), all, "the same seed gives the same ground");
    assert_ne!(points(&terrain(4, HILLS, "")), all, "another seed gives another");
}

#[test]
fn ditches_are_as_deep_and_wide_as_they_say() {
    let (plain, dug) = (points(&terrain(3, HILLS, "")), points(&terrain(3, &format!("{HILLS}, {DITCH}"), "")));
    let (mut axis, mut side) = (0, 0);
    for (a, b) in plain.iter().zip(&dug) {
        assert_eq!(a.truncate(), b.truncate());
        let away = (a.truncate() - DVec2::new(5.0, a.y.clamp(-4.0, 4.0))).length();
        let depth = a.z - b.z;
        if away < 1e-9 {
            assert!((depth - 0.4).abs() < 1e-12, "{a}: {depth}");
            axis += 1;
        } else if away >= 0.75 {
            assert_eq!(depth, 0.0, "{a}");
        } else {
            assert!(depth > 0.0 && depth < 0.4, "{a}: {depth}");
            side += 1;
        }
    }
    assert!(axis == 33 && side > 100, "{axis} {side}");
}

#[test]
fn boulders_lie_apart_on_the_ground_and_off_the_flat() {
    let sim = terrain(3, &format!("{HILLS}, {BOULDERS}"), "");
    let ground = points(&sim);
    assert_eq!(ground, points(&terrain(3, HILLS, "")), "boulders do not change the ground");
    let middle = sim.state.position[sim.model.body_names["hills"] as usize];
    let boulders = (0..sim.model.n_shapes()).filter(|s| sim.model.shape_kind[*s] == ShapeKind::Ellipsoid);
    let boulders: Vec<(DVec3, f64)> = boulders
        .map(|s| {
            assert_eq!(sim.model.inv_mass[sim.model.shape_body[s] as usize], 0.0, "boulders are held in place");
            (sim.state.shape_pose(&sim.model, s).position - middle, sim.model.shape_size[s].max_element())
        })
        .collect();
    assert_eq!(boulders.len(), 14);
    for (i, (p, r)) in boulders.iter().enumerate() {
        assert!((0.2 * 0.75..=0.5).contains(r), "{r}");
        assert!(p.truncate().length() > 2.0 + r && p.x.abs() <= 8.0 && p.y.abs() <= 6.0, "{p}");
        boulders[..i].iter().for_each(|(q, s)| assert!((*p - *q).length() > r + s, "{p} {q}"));
        // Sunk: the middle is a little above the ground about it.
        let near = ground
            .iter()
            .min_by(|a, b| a.truncate().distance(p.truncate()).total_cmp(&b.truncate().distance(p.truncate())));
        let above = p.z - near.unwrap().z;
        assert!(above > -0.15 && above < 0.15 * r / 0.75 + 0.15, "{above}");
    }
    let again = terrain(3, &format!("{HILLS}, {BOULDERS}"), "");
    assert_eq!(again.state.position, sim.state.position, "the same seed gives the same boulders");
}

#[test]
fn a_sphere_rests_on_the_flat_and_in_a_ditch() {
    let flat =
        terrain(3, HILLS, "bodies: [{name: sphere, material: m, sphere: {radius: 0.3}, position: [1, -2, 0.81]}]");
    // On the axis of a ditch in flat ground, whose sides rise by the sphere's own curve only farther up.
    let ditch = terrain(
        3,
        "size: [8, 8], spacing: 0.1, ditches: [{from: [-3, 0], to: [3, 0], width: 3, depth: 0.5}]",
        "bodies: [{name: sphere, material: m, sphere: {radius: 0.2}, position: [0.5, 0, -0.29]}]",
    );
    for (mut sim, height) in [(flat, 0.8), (ditch, -0.3)] {
        run(&mut sim, 1.0);
        let sphere = sim.model.body_names["sphere"] as usize;
        let (p, v) = (sim.state.position[sphere], sim.state.velocity[sphere]);
        assert!((p.z - height).abs() < 2e-3 && v.length() < 1e-3, "{p} {v}");
    }
}

#[test]
fn spheres_that_fall_on_hills_stay_above_them() {
    let mut spheres = String::from("bodies:\n");
    for i in 0..40 {
        let (x, y) = ((i % 8) as f64 * 1.6 - 4.6, (i / 8) as f64 * 1.7 - 5.4);
        spheres += &format!("  - {{name: b{i}, material: m, sphere: {{radius: 0.15}}, position: [{x}, {y}, 1.7]}}\n");
    }
    let mut sim = terrain(3, &format!("{HILLS}, {DITCH}, {BOULDERS}"), &spheres);
    let ground = points(&sim);
    let middle = sim.state.position[sim.model.body_names["hills"] as usize];
    run(&mut sim, 1.5);
    let (mut touch, mut on) = (0, 0);
    for i in 0..40 {
        let p = sim.state.position[sim.model.body_names[&format!("b{i}")] as usize] - middle;
        if p.x.abs() > 7.7 || p.y.abs() > 5.7 {
            continue;
        }
        on += 1;
        // Not below the lowest point of the grid's square about it.
        let near = ground.iter().filter(|g| (g.x - p.x).abs() <= 0.25 && (g.y - p.y).abs() <= 0.25);
        let lowest = near.map(|g| g.z).fold(f64::INFINITY, f64::min);
        assert!(p.z > lowest + 0.1, "sphere {i} is at {p}, the ground at {lowest}");
        touch += (p.z < lowest + 0.6) as usize;
    }
    assert!(on >= 35 && touch >= 30, "{on} spheres are on the terrain, {touch} near the ground");
}
