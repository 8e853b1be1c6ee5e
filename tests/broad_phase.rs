//! The broad phase against brute force: spheres and boxes at random, sizes from 1 to 100, some held in place. Every pair that
//! overlaps, found by looking at all pairs, is found; and none that does not.

use crate::analytic::simulation;
use glam::{DMat3, DVec3};
use sim::{Model, Pose, ShapeKind, Simulation, SplitMix64, State};
use std::collections::BTreeSet;

/// Sizes from the smallest to the largest, evenly by their logarithms.
fn size(random: &mut SplitMix64, range: [f64; 2]) -> f64 {
    range[0] * (range[1] / range[0]).powf(random.uniform())
}

/// Bodies at random in a cube: of `boxes` in ten a box, every seventh held in place, with velocities.
fn cloud(seed: u64, n: usize, boxes: u32, range: [f64; 2], extent: f64) -> Simulation {
    let mut random = SplitMix64(seed);
    let mut yaml = String::from(
        "gravity: [0, 0, 0]\nstep: 1e-3\nsolver: {iterations: 2, tolerance: 0}\nmaterials: {m: {density: 1000, friction: 0.3}}\nbodies:\n",
    );
    for i in 0..n {
        let r = size(&mut random, range);
        let shape = if random.uniform() * 10.0 < boxes as f64 {
            let size = [0; 3].map(|_| r * random.between(0.7, 2.0));
            format!("box: {{size: {size:?}}}")
        } else {
            format!("sphere: {{radius: {r}}}")
        };
        // Far apart at first: a model whose bodies overlap is refused.
        yaml += &format!(
            "  - {{name: b{i}, material: m, fixed: {}, {shape}, position: [{}, 0, 0]}}\n",
            i % 7 == 0,
            10.0 * i as f64
        );
    }
    let mut sim = simulation(&yaml);
    for b in 0..n {
        let mut vector = |max: f64| DVec3::from([0; 3].map(|_| random.between(-max, max)));
        sim.state.position[b] = vector(0.5 * extent);
        if b % 7 != 0 {
            (sim.state.velocity[b], sim.state.angular_velocity[b]) = (vector(2.0), vector(3.0));
        }
        sim.state.orientation[b] = random.rotation();
    }
    // The pairs of the places that the bodies were at.
    sim.state.fat_aabb = None;
    sim
}

/// A shape for brute force.
#[derive(Clone, Copy)]
struct Solid {
    kind: ShapeKind,
    place: Pose,
    size: DVec3,
}

/// Overlap of two shapes, m; negative where they are separate, and then a lower bound of minus their distance.
fn depth(a: &Solid, b: &Solid) -> f64 {
    match (a.kind, b.kind) {
        (ShapeKind::Sphere, ShapeKind::Sphere) => a.size.x + b.size.x - (a.place.position - b.place.position).length(),
        (ShapeKind::Box, ShapeKind::Box) => boxes_depth(a, b),
        (ShapeKind::Box, ShapeKind::Sphere) => depth(b, a),
        (ShapeKind::Sphere, ShapeKind::Box) => {
            let local = b.place.orientation.inverse() * (a.place.position - b.place.position);
            let inside = (b.size - local.abs()).min_element();
            let away = local - local.clamp(-b.size, b.size);
            a.size.x + if inside > 0.0 { inside } else { -away.length() }
        }
        other => panic!("brute force knows no {other:?}"),
    }
}

/// The minimum overlap of two boxes along the fifteen axes that can separate them.
fn boxes_depth(a: &Solid, b: &Solid) -> f64 {
    let [p, q] = [a, b].map(|s| DMat3::from_quat(s.place.orientation));
    let away = b.place.position - a.place.position;
    let reach = |m: &DMat3, half: DVec3, n: DVec3| (m.transpose() * n).abs().dot(half);
    let faces = (0..3).flat_map(|i| [p.col(i), q.col(i)]);
    let edges = (0..3).flat_map(|i| (0..3).map(move |j| (i, j))).map(|(i, j)| p.col(i).cross(q.col(j)));
    let axes = faces.chain(edges).filter_map(DVec3::try_normalize);
    axes.map(|n| reach(&p, a.size, n) + reach(&q, b.size, n) - away.dot(n).abs()).fold(f64::INFINITY, f64::min)
}

/// All pairs of shapes that may touch with their overlaps, of those that are not far apart.
fn brute(model: &Model, state: &State) -> Vec<([u32; 2], f64, f64)> {
    let solid = |s: usize| {
        let (kind, size) = (model.shape_kind[s], model.shape_size[s]);
        Solid { kind, place: state.shape_pose(model, s), size }
    };
    let solids: Vec<Solid> = (0..model.n_shapes()).map(solid).collect();
    let radius: Vec<f64> =
        solids.iter().map(|s| if s.kind == ShapeKind::Sphere { s.size.x } else { s.size.length() }).collect();
    let moves = |s: usize| model.inv_mass[model.shape_body[s] as usize] > 0.0;
    let mut found = vec![];
    for t in 0..solids.len() {
        for s in (0..t).filter(|s| moves(*s) || moves(t)) {
            let away = (solids[s].place.position - solids[t].place.position).length();
            if away < radius[s] + radius[t] {
                let min = solids[s].size.min_element().min(solids[t].size.min_element());
                found.push(([s as u32, t as u32], depth(&solids[s], &solids[t]), min));
            }
        }
    }
    found
}

/// Shapes in the order of their ids: a contact has its bodies in that order.
fn ordered([s, t]: [u32; 2]) -> [u32; 2] {
    [s.min(t), s.max(t)]
}

/// Hold pairs that were found to those of brute force; returns how many overlap.
fn held(found: &BTreeSet<[u32; 2]>, all: &[([u32; 2], f64, f64)], only: bool, what: &str) -> usize {
    let mut n = 0;
    for (pair, depth, min) in all {
        // What hardly touches is the narrow phase's to judge.
        if *depth > 1e-6 * min {
            n += 1;
            assert!(found.contains(pair), "{what}: shapes {pair:?} overlap by {depth:.3e} m and are not found");
        } else if *depth < -1e-6 * min && only {
            assert!(!found.contains(pair), "{what}: shapes {pair:?} are {:.3e} m apart and are found", -depth);
        }
    }
    if only {
        let near: BTreeSet<[u32; 2]> = all.iter().map(|(pair, ..)| *pair).collect();
        assert!(found.is_subset(&near), "{what}: {:?} are far apart and found", found.difference(&near).next());
    }
    n
}

#[test]
fn overlaps_are_those_of_brute_force() {
    let mut total = 0;
    // Spheres alone and with boxes; sizes alike, and mixed 1:100 in a box as large as some thirty of the largest.
    let mixes = [(0, [0.05, 0.05], 1.0), (0, [0.01, 1.0], 6.0), (3, [0.01, 1.0], 6.0), (10, [0.02, 0.2], 1.2)];
    for (mix, (boxes, range, extent)) in mixes.into_iter().enumerate() {
        for seed in 0..12 {
            let sim = cloud(1000 * mix as u64 + seed, 250, boxes, range, extent);
            let found = sim::overlaps::overlaps(&sim.model, &sim.state);
            let pairs: BTreeSet<[u32; 2]> = found.iter().map(|o| ordered(o.shapes)).collect();
            assert_eq!(pairs.len(), found.len(), "each pair once");
            total += held(&pairs, &brute(&sim.model, &sim.state), true, &format!("mix {mix}, seed {seed}"));
        }
    }
    assert!(total > 5_000, "{total} overlaps");
}

#[test]
fn moving_bodies_meet_as_brute_force_says_step_after_step() {
    // Pairs outlive a step: they are found for boxes with room to move.
    for (boxes, range, extent) in [(0, [0.05, 0.05], 1.2), (0, [0.01, 1.0], 6.0), (4, [0.02, 0.6], 4.0)] {
        for seed in 0..2 {
            let mut sim = cloud(77 + seed, 200, boxes, range, extent);
            let (mut total, mut renewed) = (0, 0);
            for step in 0..60 {
                let all = brute(&sim.model, &sim.state);
                let before = format!("{:?}", sim.state.fat_aabb);
                sim.step();
                renewed += (before != format!("{:?}", sim.state.fat_aabb)) as usize;
                let contacts = &sim.state.contacts;
                let pairs: BTreeSet<[u32; 2]> = contacts.key.iter().map(|[s, t, _]| ordered([*s, *t])).collect();
                total += held(&pairs, &all, false, &format!("{boxes} boxes, seed {seed}, step {step}"));
            }
            assert!(total > 500 && (2..60).contains(&renewed), "{total} overlaps, pairs renewed {renewed} times");
        }
    }
}
