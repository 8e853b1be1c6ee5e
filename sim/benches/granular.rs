//! Known laws of granular matter: craters (Uehara et al. 2003), hoppers (Beverloo 1961), angles of repose.
//!
//! `cargo bench -p sim --bench granular [crater|hopper|repose]` writes `results/NAME.csv`, with the fitted figures.

use rayon::prelude::*;
use sim::model_file::ModelFile;
use sim::{Model, Simulation, State};
use std::path::Path;

fn simulation(yaml: &str) -> Simulation {
    let (file, doc) = frame::yaml::parse::<ModelFile>(Path::new("bench.yaml"), yaml.into()).expect("sound YAML");
    let resolved = file.resolve(&doc).expect("a sound model");
    Simulation::new(resolved.model, resolved.state)
}

fn run(sim: &mut Simulation, until: f64) {
    while sim.state.time < until - 1e-9 {
        sim.step();
    }
}

fn write(name: &str, text: &str) {
    print!("{name}:\n{text}\n");
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("benches/results/{name}.csv"));
    std::fs::write(path, text).expect("the folder of results can be written");
}

fn main() {
    let wanted: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    let asked = |name: &str| wanted.is_empty() || wanted.iter().any(|w| w == name);
    for (name, bench) in [("crater", crater as fn()), ("hopper", hopper), ("repose", repose)] {
        if asked(name) {
            bench();
        }
    }
}

/// Slope and offset of the straight line through points, by least squares.
fn line(points: &[[f64; 2]]) -> [f64; 2] {
    let n = points.len() as f64;
    let sum = |f: &dyn Fn(&[f64; 2]) -> f64| points.iter().map(f).sum::<f64>();
    let (x, y) = (sum(&|p| p[0]), sum(&|p| p[1]));
    let slope = (n * sum(&|p| p[0] * p[1]) - x * y) / (n * sum(&|p| p[0] * p[0]) - x * x);
    [slope, (y - slope * x) / n]
}

/// Recovery speed of the bed, m/s: low, since the recoveries of all its layers add up.
const CALM: f64 = 0.005;

/// A bed of grains 2.4 mm wide and some 11 cm deep in a box, settled once.
fn bed() -> (Model, State) {
    let mut sim = simulation(
        "step: 5e-4
duration: 9
seed: 3
solver: {method: gauss_seidel, friction: exact, iterations: 24, recovery_speed: 0.05}
materials: {g: {density: 1510, friction: 0.45}}
bodies:
  - {name: floor, material: g, plane: {normal: [0, 0, 1]}}
  - {name: a, material: g, plane: {normal: [1, 0, 0]}, position: [-0.05, 0, 0]}
  - {name: b, material: g, plane: {normal: [-1, 0, 0]}, position: [0.05, 0, 0]}
  - {name: c, material: g, plane: {normal: [0, 1, 0]}, position: [0, -0.05, 0]}
  - {name: d, material: g, plane: {normal: [0, -1, 0]}, position: [0, 0.05, 0]}
fills:
  - {name: grains, material: g, count: 90000, radius: [0.0011, 0.0013], min: [-0.05, -0.05, 0], max: [0.05, 0.05, 0.6]}
",
    );
    run(&mut sim, 0.6);
    sim.model.solver.recovery_speed = CALM;
    run(&mut sim, 0.8);
    (sim.model, sim.state)
}

/// The bed scaled by a factor and come to rest, with the step size of the impact.
fn scaled((model, state): &(Model, State), by: f64) -> (Model, State) {
    let (mut model, mut state) = (model.clone(), state.clone());
    state.contacts = Default::default();
    state.fat_aabb = None;
    model.envelope *= by;
    model.shape_size.iter_mut().for_each(|size| *size *= by);
    model.inv_mass.iter_mut().for_each(|m| *m /= by.powi(3));
    model.inv_inertia.iter_mut().for_each(|i| *i /= by.powi(5));
    state.position.iter_mut().for_each(|p| *p *= by);
    state.velocity.iter_mut().chain(&mut state.angular_velocity).for_each(|v| *v = glam::DVec3::ZERO);
    model.step = 1e-4;
    (state.steps, state.time) = (0, 0.0);
    let mut sim = Simulation::new(model, state);
    run(&mut sim, 0.03);
    (sim.model, sim.state)
}

/// Depth of the crater of a sphere of density ρ_b, diameter D, dropped so that it stops H below its start:
/// d = 0.14/μ (ρ_b/ρ_g)^½ D^⅔ H^⅓. Uehara's grains are small against the sphere; these are not, so that the bed is
/// scaled with the sphere, which is always 10.6 grains wide.
fn crater() {
    const USUAL: f64 = 0.0254;
    let all = [[1000.0, 2000.0, 4000.0], [0.019, USUAL, 0.033], [0.05, 0.15, 0.4]];
    let bed = bed();
    let mut text = String::from("density [kg/m3],diameter [m],fall H [m],depth [m]\n");
    let mut rows = vec![];
    for diameter in all[1] {
        let (model, state) = scaled(&bed, diameter / USUAL);
        let top = surface(&model, &state);
        for density in all[0] {
            for height in all[2] {
                // Only along the three axes through the middle, and the corners.
                let off = [(density, 0), (diameter, 1), (height, 2)].map(|(x, k)| x != all[k][1]);
                if off.iter().filter(|x| **x).count() == 2 {
                    continue;
                }
                let depth = drop_sphere(&model, &state, top, density, diameter, height);
                rows.push([density.ln(), f64::ln(diameter), (height + depth).ln(), depth.ln()]);
                text += &format!("{density},{diameter},{:.4},{depth:.5}\n", height + depth);
                eprintln!("{density} {diameter} {:.4} {depth:.5}", height + depth);
            }
        }
    }
    let fit = least_squares(&rows);
    text += &format!("# depth ~ density^{:.3} D^{:.3} H^{:.3} (Uehara 2003: 1/2, 2/3, 1/3)\n", fit[0], fit[1], fit[2]);
    write("crater", &text);
}

/// Height of a bed's surface: the mean top of the highest grains on a grid of columns.
fn surface(model: &Model, state: &State) -> f64 {
    const N: usize = 9;
    let mut top = [[0.0f64; N]; N];
    let side = state.position.iter().fold(0.0f64, |max, p| max.max(p.x));
    for s in (0..model.n_shapes()).filter(|s| !model.shape_kind[*s].is_surface()) {
        let p = state.position[model.shape_body[s] as usize];
        let cell = |x: f64| ((0.5 * (x / side + 1.0) * N as f64) as usize).min(N - 1);
        let t = &mut top[cell(p.x)][cell(p.y)];
        *t = t.max(p.z + model.shape_size[s].x);
    }
    top.iter().flatten().sum::<f64>() / (N * N) as f64
}

fn drop_sphere(model: &Model, state: &State, top: f64, density: f64, diameter: f64, height: f64) -> f64 {
    let (mut model, mut state) = (model.clone(), state.clone());
    let r = 0.5 * diameter;
    let mass = density * 4.0 / 3.0 * std::f64::consts::PI * r * r * r;
    let pose = sim::Pose::default();
    model.shape_body.push(model.n_bodies() as u32);
    model.shape_kind.push(sim::ShapeKind::Sphere);
    model.shape_size.push(glam::DVec3::splat(r));
    model.shape_pose.push(pose);
    model.shape_material.push(0);
    model.shape_group.push(0);
    model.shape_part.push(0);
    model.inv_mass.push(1.0 / mass);
    model.inv_inertia.push(glam::DVec3::splat(2.5 / (mass * r * r)));
    model.class.push(0);
    model.body_frame.push(pose);
    state.position.push(glam::DVec3::new(0.0, 0.0, top + r + 1e-4));
    state.orientation.push(glam::DQuat::IDENTITY);
    state.velocity.push(glam::DVec3::new(0.0, 0.0, -(2.0 * 9.81 * height).sqrt()));
    state.angular_velocity.push(glam::DVec3::ZERO);
    (state.steps, state.time) = (0, 0.0);
    state.fat_aabb = None;
    let mut sim = Simulation::new(model, state);
    let sphere = sim.model.n_bodies() - 1;
    let mut lowest = f64::INFINITY;
    // Until it has come to rest.
    while sim.state.time < 0.2 && sim.state.velocity[sphere].z < -2e-3 {
        sim.step();
        lowest = lowest.min(sim.state.position[sphere].z - r);
    }
    top - lowest
}

/// Exponents a, b, c and offset of `y = a x₀ + b x₁ + c x₂ + d`, by the normal equations.
fn least_squares(rows: &[[f64; 4]]) -> [f64; 4] {
    let mut m = [[0.0; 5]; 4];
    for row in rows {
        let x = [row[0], row[1], row[2], 1.0];
        for i in 0..4 {
            (0..4).for_each(|j| m[i][j] += x[i] * x[j]);
            m[i][4] += x[i] * row[3];
        }
    }
    for i in 0..4 {
        let pivot = m[i];
        for k in (0..4).filter(|k| *k != i) {
            let f = m[k][i] / pivot[i];
            (0..5).for_each(|j| m[k][j] -= f * pivot[j]);
        }
    }
    [0, 1, 2, 3].map(|i| m[i][4] / m[i][i])
}

/// Mass flow through a round opening of diameter D in a flat bottom: W ∝ (D − 1.4 d)^2.5 with grains of diameter d.
fn hopper() {
    const GRAIN: f64 = 0.012;
    let mut text = String::from("opening D [m],flow [kg/s],first half [kg/s],second half [kg/s]\n");
    let mut points = vec![];
    for opening in [0.06, 0.08, 0.1] {
        let mut yaml = format!(
            "step: 5e-4
duration: 9
seed: 3
solver: {{method: gauss_seidel, iterations: 12, recovery_speed: 0.05}}
materials: {{g: {{density: 2500, friction: 0.4}}}}
bodies:
  - {{name: a, material: g, plane: {{normal: [1, 0, 0]}}, position: [-0.12, 0, 0]}}
  - {{name: b, material: g, plane: {{normal: [-1, 0, 0]}}, position: [0.12, 0, 0]}}
  - {{name: c, material: g, plane: {{normal: [0, 1, 0]}}, position: [0, -0.12, 0]}}
  - {{name: d, material: g, plane: {{normal: [0, -1, 0]}}, position: [0, 0.12, 0]}}
  - {{name: plug, material: g, shapes: [{{cylinder: {{radius: {}, length: 0.01}}}}], position: [0, 0, -0.005], fixed: true}}
",
            0.5 * opening
        );
        // The bottom around the opening: sixteen plates whose inner edges touch its circle.
        for k in 0..16 {
            let angle = k as f64 * 22.5;
            let (s, c) = angle.to_radians().sin_cos();
            let (length, r) = (0.2, 0.5 * opening + 0.1);
            yaml += &format!(
                "  - {{name: plate{k}, class: bottom, material: g, fixed: true, box: {{size: [{length}, 0.2, 0.01]}}, position: [{}, {}, -0.005], rotate: {{axis: [0, 0, 1], angle: {angle}}}}}\n",
                r * c,
                r * s
            );
        }
        yaml += &format!(
            "fills:\n  - {{name: grains, material: g, count: 8000, radius: [{}, {}], min: [-0.12, -0.12, 0.002], max: [0.12, 0.12, 1.2]}}\n",
            0.45 * GRAIN,
            0.55 * GRAIN
        );
        let mut sim = simulation(&yaml);
        run(&mut sim, 0.6);
        let plug = sim.model.body_names["plug"] as usize;
        sim.state.position[plug].x = 10.0;
        let below = |sim: &Simulation| -> f64 {
            (0..sim.model.n_bodies())
                .filter(|b| sim.model.inv_mass[*b] > 0.0 && sim.state.position[*b].z < -0.01)
                .map(|b| 1.0 / sim.model.inv_mass[b])
                .sum()
        };
        let start = sim.state.time + 0.4;
        let mut masses = vec![];
        for t in [0.0, 0.3, 0.6] {
            run(&mut sim, start + t);
            masses.push(below(&sim));
        }
        let halves = [(masses[1] - masses[0]) / 0.3, (masses[2] - masses[1]) / 0.3];
        let flow = 0.5 * (halves[0] + halves[1]);
        points.push([(opening - 1.4 * GRAIN).ln(), flow.ln()]);
        text += &format!("{opening},{flow:.4},{:.4},{:.4}\n", halves[0], halves[1]);
    }
    let [exponent, offset] = line(&points);
    let bulk = offset.exp() / 9.81f64.sqrt();
    text += &format!(
        "# flow ~ (D - 1.4 d)^{exponent:.3} (Beverloo: 2.5); flow/(sqrt(g) (D - 1.4 d)^2.5) about {bulk:.0} kg/m3\n"
    );
    write("hopper", &text);
}

/// Angles of heaps, the mean of four.
fn repose() {
    let mut text = String::from("friction,angle [degrees],min [degrees],max [degrees],height [m],radius [m]\n");
    for friction in [0.1, 0.2, 0.35, 0.5] {
        let heaps: Vec<[f64; 3]> = [5, 6, 7, 8].into_par_iter().map(|seed| heap(friction, seed)).collect();
        let mean = |k: usize| heaps.iter().map(|heap| heap[k]).sum::<f64>() / heaps.len() as f64;
        let min = heaps.iter().fold(f64::INFINITY, |min, heap| min.min(heap[0]));
        let max = heaps.iter().fold(0.0, |max: f64, heap| max.max(heap[0]));
        text += &format!("{friction},{:.2},{min:.2},{max:.2},{:.3},{:.3}\n", mean(0), mean(1), mean(2));
    }
    write("repose", &text);
}

/// The angle (degrees), height and radius (m) of the heap that is left when a column of grains is let go on rough ground.
fn heap(friction: f64, seed: u64) -> [f64; 3] {
    let mut sim = simulation(&format!(
        "step: 1e-3
duration: 9
seed: {seed}
solver: {{method: apgd, iterations: 40, recovery_speed: 0.05}}
materials: {{g: {{density: 2500, friction: {friction}, rolling: 8e-4}}, rough: {{density: 2500, friction: 1, rolling: 2e-3}}}}
contacts: [{{materials: [g, rough], friction: 1.0, rolling: 2e-3}}]
bodies:
  - {{name: floor, material: rough, plane: {{normal: [0, 0, 1]}}}}
fills:
  - {{name: grains, material: g, count: 2500, radius: [0.009, 0.011], packing: hexagonal, min: [-0.2, -0.2, 0], max: [0.2, 0.2, 2], within_radius: 0.2}}
"
    ));
    run(&mut sim, 2.0);
    // Mean top by rings around the axis: the slope between a fifth and four fifths of the heap.
    let grains: Vec<(f64, f64)> = (0..sim.model.n_bodies())
        .filter(|b| sim.model.inv_mass[*b] > 0.0)
        .map(|b| (sim.state.position[b].truncate().length(), sim.state.position[b].z + 0.01))
        .filter(|(r, _)| *r < 1.5)
        .collect();
    let ring = 0.02;
    let mut tops = vec![];
    for k in 0..60 {
        let (lo, hi) = (k as f64 * ring, (k + 1) as f64 * ring);
        let mut z: Vec<f64> = grains.iter().filter(|(r, _)| (lo..hi).contains(r)).map(|g| g.1).collect();
        z.sort_by(|a, b| b.total_cmp(a));
        let n = (z.len() / 6).max(1);
        if z.len() >= 6 {
            tops.push([0.5 * (lo + hi), z[..n].iter().sum::<f64>() / n as f64]);
        }
    }
    let height = tops.iter().map(|p| p[1]).fold(0.0, f64::max);
    let slope: Vec<[f64; 2]> = tops.iter().copied().filter(|p| p[1] > 0.2 * height && p[1] < 0.85 * height).collect();
    let [tangent, _] = line(&slope);
    let radius = tops.iter().filter(|p| p[1] > 0.03).map(|p| p[0]).fold(0.0, f64::max);
    [(-tangent).atan().to_degrees(), height, radius]
}
