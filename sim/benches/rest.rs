//! What rests: beds, stacks, mechanisms and great mass ratios by every method and both laws of friction, with the defaults.
//!
//! `cargo bench -p sim --bench rest [WORD…]` writes `results/rest.csv`; words choose among the names of cases, methods and laws.

use frame::yaml;
use rayon::prelude::*;
use sim::model_file::ModelFile;
use sim::{FrictionLaw, Method, Simulation};
use std::path::Path;
use std::time::Instant;

/// A model, the time from which it shall rest, and that at which it ends, s.
struct Case {
    name: &'static str,
    yaml: String,
    rests_from: f64,
    ends: f64,
}

/// Planes that hold a square region of half length `half`.
fn walls(half: f64) -> String {
    let plane = |name: &str, normal: [i32; 3]| {
        let at = normal.map(|x| -half * f64::from(x));
        format!("  - {{name: {name}, material: m, plane: {{normal: {normal:?}}}, position: {at:?}}}\n")
    };
    [("east", [-1, 0, 0]), ("west", [1, 0, 0]), ("north", [0, -1, 0]), ("south", [0, 1, 0])]
        .map(|(name, normal)| plane(name, normal))
        .concat()
}

/// Bodies on each other: the mass of each, kg, and its shape.
fn stack(of: impl Iterator<Item = (f64, &'static str)>) -> String {
    of.enumerate()
        .map(|(i, (mass, shape))| {
            let z = 0.1 + 0.2 * i as f64;
            format!("  - {{name: b{i}, material: m, mass: {mass}, {shape}, position: [0, 0, {z}]}}\n")
        })
        .collect()
}

fn cases() -> Vec<Case> {
    const BOX: &str = "box: {size: [0.2, 0.2, 0.2]}";
    const SPHERE: &str = "sphere: {radius: 0.1}";
    let ground = "materials: {m: {density: 2500, friction: 0.5}, steel: {density: 7800, friction: 0.5}}
bodies:
  - {name: ground, material: m, plane: {normal: [0, 0, 1]}}
";
    let grains = "fills:
  - {name: grains, material: m, count: 5000, radius: [0.045, 0.055], min: [-0.55, -0.55, 0], max: [0.55, 0.55, 9]}
";
    let stones: String = (0..400)
        .map(|i| {
            let shape = ["box: {size: [0.2, 0.15, 0.1]}", "capsule: {radius: 0.05, length: 0.1}", "sphere: {radius: 0.08}", "cylinder: {radius: 0.08, length: 0.12}"][i % 4];
            let [x, y, z] = [i % 4, (i / 4) % 4, i / 16].map(|k| k as f64);
            format!("  - {{name: s{i}, material: m, {shape}, position: [{}, {}, {}], rotate: {{axis: [1, 2, {}], angle: {}}}}}\n", 0.22 * (x - 1.5), 0.22 * (y - 1.5), 0.2 + 0.25 * z, i % 7, 20 * i)
        })
        .collect();
    let (mut boxes, mut hinges) = (String::new(), "joints:\n".to_string());
    for i in 0..8 {
        let (z, x, mass) = (0.05 + 0.1 * f64::from(i), if i % 2 == 0 { 0.5 } else { -0.5 }, 3f64.powi(i));
        boxes += &format!(
            "  - {{name: l{i}, material: m, mass: {mass}, box: {{size: [1, 0.2, 0.1]}}, position: [0, 0, {z}]}}\n"
        );
        hinges += &format!(
            "  - {{name: h{i}, kind: revolute, a: world, b: l{i}, position: [{x}, 0, {z}], axis: [0, 1, 0]}}\n"
        );
    }
    let case = |name, yaml: String, rests_from, ends| Case { name, yaml: format!("{ground}{yaml}"), rests_from, ends };
    vec![
        case("bed", walls(0.55) + grains, 5.0, 8.0),
        case("second bed", walls(0.55) + grains + "seed: 11\n", 5.0, 8.0),
        case("stones", walls(0.5) + &stones, 5.0, 6.0),
        case("ten boxes", stack((0..10).map(|_| (1.0, BOX))), 0.5, 2.0),
        case("1000 times", stack((0..21).map(|i| (if i == 20 { 1e3 } else { 1.0 }, SPHERE))), 0.5, 2.0),
        case("a million times", stack((0..6).map(|i| (if i == 5 { 1e6 } else { 1.0 }, BOX))), 0.5, 2.0),
        case("levers", boxes + &hinges, 0.5, 2.0),
    ]
}

fn run(case: &Case, method: Method, law: FrictionLaw) -> String {
    let (file, doc) = yaml::parse::<ModelFile>(Path::new("bench.yaml"), case.yaml.clone()).expect("sound YAML");
    let resolved = file.resolve(&doc).unwrap_or_else(|e| panic!("{}: {e}", case.name));
    let mut model = resolved.model;
    (model.solver.method, model.solver.friction) = (Some(method), law);
    let mut sim = Simulation::new(model, resolved.state);
    let start = Instant::now();
    let moving: Vec<usize> = (0..sim.model.n_bodies()).filter(|b| sim.model.inv_mass[*b] > 0.0).collect();
    let weight = moving.iter().map(|b| 1.0 / sim.model.inv_mass[*b]).sum::<f64>() * 9.81;
    let is_held = |model: &sim::Model, b: u32| model.inv_mass[b as usize] == 0.0;
    let mean_speed =
        |sim: &Simulation| moving.iter().map(|b| sim.state.velocity[*b].length()).sum::<f64>() / moving.len() as f64;
    let (mut steps, mut all_iterations, mut iterations, mut fastest, mut reaction) = (0u32, 0u64, 0u64, 0.0f64, 0.0f64);
    let mut rested = f64::NAN;
    while sim.state.time < case.ends - 1e-9 {
        let report = sim.step();
        if let Some(broken) = report.broken {
            eprintln!("{}, {}, {}: {broken:?}", case.name, method.name(), word(law));
            (steps, fastest, reaction, rested) = (steps.max(1), f64::INFINITY, f64::INFINITY, f64::NAN);
            break;
        }
        let speed = mean_speed(&sim);
        let c = &sim.state.contacts;
        let on_held = (0..c.len()).map(|i| match c.bodies[i].map(|b| is_held(&sim.model, b)) {
            [true, false] => c.impulse[i].z,
            [false, true] => -c.impulse[i].z,
            _ => 0.0,
        });
        let hinges =
            sim.model.joints.iter().zip(&sim.state.joints).filter(|(joint, _)| is_held(&sim.model, joint.bodies[0]));
        let force = on_held.sum::<f64>() / sim.model.step - hinges.map(|(_, now)| now.force_world.z).sum::<f64>();
        let off = (force / weight - 1.0).abs();
        // The time from which on it has rested.
        let rests = speed <= 1e-4 && off <= 1e-3;
        if !rests {
            rested = f64::NAN;
        } else if rested.is_nan() {
            rested = sim.state.time;
        }
        all_iterations += u64::from(report.iterations);
        if sim.state.time >= case.rests_from {
            steps += 1;
            iterations += u64::from(report.iterations);
            fastest = fastest.max(speed);
            reaction = reaction.max(off);
        }
    }
    format!(
        "{},{},{},{fastest:.1e},{reaction:.1e},{rested:.2},{:.1},{all_iterations},{:.1}",
        case.name,
        method.name(),
        word(law),
        iterations as f64 / f64::from(steps),
        start.elapsed().as_secs_f64()
    )
}

fn word(law: FrictionLaw) -> &'static str {
    match law {
        FrictionLaw::Relaxed => "relaxed",
        FrictionLaw::Exact => "exact",
    }
}

fn main() {
    let wanted: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    let cases = cases();
    let asked = |words: &[&str], word: &str| {
        let own: Vec<_> = wanted.iter().filter(|w| words.contains(&w.as_str())).collect();
        own.is_empty() || own.iter().any(|w| *w == word)
    };
    let names: Vec<&str> = cases.iter().map(|c| c.name).collect();
    let methods = Method::ALL.map(Method::name);
    let mut all = vec![];
    for case in cases.iter().filter(|c| asked(&names, c.name)) {
        for law in [FrictionLaw::Relaxed, FrictionLaw::Exact] {
            for method in Method::ALL {
                if asked(&methods, method.name()) && asked(&["exact", "relaxed"], word(law)) {
                    all.push((case, method, law));
                }
            }
        }
    }
    let rows: Vec<String> = all
        .par_iter()
        .with_max_len(1)
        .map(|(case, method, law)| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("threads");
            let row = pool.install(|| run(case, *method, *law));
            eprintln!("{row}");
            row
        })
        .collect();
    let header = "case,method,law,maximum mean speed [m/s],maximum error of the reaction,rests from [s],iterations at rest,iterations in all,wall time [s]";
    let table = rows.iter().fold(format!("{header}\n"), |table, row| table + row + "\n");
    print!("{table}");
    if wanted.is_empty() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/results/rest.csv");
        std::fs::write(path, table).expect("the folder of results can be written");
    }
}
