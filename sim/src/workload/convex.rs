//! Benchmark workloads of convex bodies and joints, after the parameters of the benchmarks of game engines.

use crate::builder::ModelBuilder;
use crate::fill::SplitMix64;
use crate::joint::JointKind;
use crate::model_file::{HullFile, ShapeFile};
use glam::{DQuat, DVec3};

/// A benchmark workload of convex bodies or joints.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Convex {
    /// Boxes that stand on each other; the number is that of boxes in the lowest row.
    Pyramid,
    /// Hulls that fall upon each other; the number is that of layers of 64.
    Pile,
    /// Boxes poured into a box; the number is that of boxes.
    Boxes,
    /// A net of spherical joints; the number is that of joints along an edge.
    Grid,
}

impl Convex {
    /// The number of the peers' benchmarks, and the simulated time, s.
    pub fn size(self) -> (usize, f64) {
        match self {
            Convex::Pyramid => (100, 5.0),
            Convex::Pile => (80, 1.5),
            Convex::Boxes => (5000, 2.0),
            Convex::Grid => (100, 2.0),
        }
    }
}

/// The model of a workload of `n` as [`Convex`] counts it.
pub fn scene(workload: Convex, n: usize) -> ModelBuilder {
    let mut model = ModelBuilder::new(&format!("{workload:?}({n})"));
    model.file.gravity = if workload == Convex::Boxes { [0.0, 0.0, -9.81] } else { [0.0, -10.0, 0.0] };
    match workload {
        Convex::Pyramid => pyramid(&mut model, n),
        Convex::Pile => pile(&mut model, n),
        Convex::Boxes => boxes(&mut model, n),
        Convex::Grid => grid(&mut model, n),
    }
    model
}

/// Boxes of 1 m in rows of `n`, `n` − 1, … on the ground.
fn pyramid(model: &mut ModelBuilder, n: usize) {
    model.material("box", 100.0, 0.6);
    model.body("ground", "box", ShapeFile::plane([0.0, 1.0, 0.0]));
    for row in 0..n {
        for k in 0..n - row {
            let x = 0.5 * (row as f64 + 1.0) + k as f64 - 0.5 * n as f64;
            let body = model.body(&format!("b{row}_{k}"), "box", ShapeFile::cuboid([1.0; 3]));
            body.position = [x, 0.5 + row as f64, 0.0];
        }
    }
}

/// Columns of hulls of 32 points, 8 by 8, `n` layers high, that fall upon each other.
fn pile(model: &mut ModelBuilder, n: usize) {
    const RADIUS: f64 = 2.0;
    model.material("rock", 1000.0, 0.6);
    model.body("ground", "rock", ShapeFile::plane([0.0, 1.0, 0.0]));
    let mut random = SplitMix64(42);
    let mut points: Vec<[f64; 3]> = vec![];
    while points.len() < 32 {
        let p = DVec3::from([0; 3].map(|_| random.uniform() - 0.5));
        if p.length() < 0.5 {
            points.push((p * (RADIUS / p.length())).to_array());
        }
    }
    for layer in 0..n {
        for k in 0..64 {
            let site = [(k % 8) as f64 - 4.0, 0.5 + layer as f64, (k / 8) as f64 - 4.0];
            model.body(&format!("b{layer}_{k}"), "rock", stone(points.clone())).position =
                site.map(|x| 2.0 * RADIUS * x);
        }
    }
}

/// A floor and four walls of a square of this edge length, m.
pub fn walls(model: &mut ModelBuilder, material: &str, length: f64) {
    let walls = [
        ([0.0; 3], [0.0, 0.0, 1.0]),
        ([0.0; 3], [1.0, 0.0, 0.0]),
        ([length, 0.0, 0.0], [-1.0, 0.0, 0.0]),
        ([0.0; 3], [0.0, 1.0, 0.0]),
        ([0.0, length, 0.0], [0.0, -1.0, 0.0]),
    ];
    for (k, (point, normal)) in walls.into_iter().enumerate() {
        model.body(&format!("wall{k}"), material, ShapeFile::plane(normal)).position = point;
    }
}

/// The hull of points.
fn stone(points: Vec<[f64; 3]>) -> ShapeFile {
    ShapeFile { hull: Some(HullFile { points: Some(points), file: None, scale: 1.0 }), ..ShapeFile::default() }
}

/// Boxes of mixed size in all directions, poured into a box of a floor and four walls.
fn boxes(model: &mut ModelBuilder, n: usize) {
    const SPACING: f64 = 0.36;
    model.material("box", 2000.0, 0.5);
    let side = ((n as f64 / 25.5).sqrt().round() as usize).max(3);
    let length = side as f64 * SPACING;
    walls(model, "box", length);
    let mut random = SplitMix64(7);
    for i in 0..n {
        let site = [i % side, i / side % side, i / (side * side)];
        let rotation: DQuat = random.rotation();
        let size = [0; 3].map(|_| 0.1 + 0.1 * random.uniform());
        let body = model.body(&format!("b{i}"), "box", ShapeFile::cuboid(size));
        body.position = site.map(|c| (c as f64 + 0.5) * SPACING);
        body.orientation = Some([rotation.w, rotation.x, rotation.y, rotation.z]);
    }
}

/// A bed of `n` spheres, boxes, capsules, cylinders, cones, ellipsoids and stones of 12 points, in all directions and of mixed size, that falls
/// into a box of a floor and four walls.
pub fn mixed(n: usize) -> ModelBuilder {
    const SPACING: f64 = 0.2;
    let mut model = ModelBuilder::new(&format!("mixed({n})"));
    model.file.gravity = [0.0, 0.0, -9.81];
    model.material("stone", 2600.0, 0.5);
    let side = ((n as f64 / 2.0).cbrt().round() as usize).max(3);
    walls(&mut model, "stone", side as f64 * SPACING);
    let mut random = SplitMix64(11);
    for i in 0..n {
        let site = [i % side, i / side % side, i / (side * side)];
        let r = 0.06 + 0.03 * random.uniform();
        let shape = match i % 7 {
            0 => ShapeFile::sphere(r),
            1 => ShapeFile::cuboid([1.3 * r, 1.1 * r, 0.9 * r]),
            2 => ShapeFile::capsule(0.6 * r, 0.8 * r),
            3 => ShapeFile::cylinder(0.7 * r, 1.3 * r),
            4 => ShapeFile { cone: ShapeFile::cylinder(0.8 * r, 1.3 * r).cylinder, ..ShapeFile::default() },
            5 => ShapeFile::ellipsoid([r, 0.8 * r, 0.7 * r]),
            _ => stone((0..12).map(|_| (random.rotation() * DVec3::X * r).to_array()).collect()),
        };
        let rotation: DQuat = random.rotation();
        let body = model.body(&format!("b{i}"), "stone", shape);
        body.position = site.map(|c| (c as f64 + 0.5) * SPACING);
        body.orientation = Some([rotation.w, rotation.x, rotation.y, rotation.z]);
        body.velocity = [0.0, 0.0, -1.0];
    }
    model
}

/// A net of `n` by `n` spheres that touch nothing, joined to their neighbours by spherical joints and hung at one edge.
fn grid(model: &mut ModelBuilder, n: usize) {
    model.material("knot", 1000.0, 0.6);
    model.file.pass_through = vec![["net".into(), "net".into()]];
    let name = |k: usize, i: usize| format!("b{k}_{i}");
    for k in 0..n {
        for i in 0..n {
            let body = model.body(&name(k, i), "knot", ShapeFile::sphere(0.4));
            body.position = [k as f64, -(i as f64), 0.0];
            body.group = Some("net".into());
            body.fixed = i == 0;
            let mut join = |other: String, point: [f64; 3]| {
                let joint = format!("{other}_{}", name(k, i));
                model.joint(&joint, JointKind::Spherical, &other, &name(k, i)).position = point;
            };
            if i > 0 {
                join(name(k, i - 1), [k as f64, 0.5 - i as f64, 0.0]);
            }
            if i > 0 && k > 0 {
                join(name(k - 1, i), [k as f64 - 0.5, -(i as f64), 0.0]);
            }
        }
    }
}
