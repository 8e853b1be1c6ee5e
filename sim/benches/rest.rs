//! What rests: beds, stacks, mechanisms and great mass ratios by every method and both laws of friction, with the defaults.
//!
//! `cargo bench -p sim --bench rest [WORD…]` writes `results/rest.csv`; words choose among the names of cases, methods and laws.

use frame::yaml;
use rayon::prelude::*;
use sim::model_file::ModelFile;
use sim::{FrictionLaw, Method, Simulation};
use std::path::Path;
use std::time::Instant;

/// A model, the time from which it rests, and that at which it ends, s.
struct Case {
    name: &'static str,
    yaml: String,
    rests_from: f64,
    ends: f64,
}

fn cases() -> Vec<Case> {
    let walls = |half: f64| {
        let plane = |name: &str, normal: [i32; 3]| {
            let at = normal.map(|x| -half * f64::from(x));
            format!("  - {{name: {name}, material: g, plane: {{normal: {normal:?}}}, position: {at:?}}}\n")
        };
        [("east", [-1, 0, 0]), ("west", [1, 0, 0]), ("north", [0, -1, 0]), ("south", [0, 1, 0])]
            .map(|(name, normal)| plane(name, normal))
            .concat()
    };
    let bed = format!(
        "materials: {{g: {{density: 2500, friction: 0.5}}}}
bodies:
  - {{name: floor, material: g, plane: {{normal: [0, 0, 1]}}}}
{}fills:
  - {{name: grains, material: g, count: 5000, radius: [0.045, 0.055], min: [-0.55, -0.55, 0], max: [0.55, 0.55, 9]}}
",
        walls(0.55)
    );
    vec![Case { name: "bed", yaml: bed, rests_from: 5.0, ends: 8.0 }]
}

fn run(case: &Case, method: Method, law: FrictionLaw) -> String {
    let (file, doc) = yaml::parse::<ModelFile>(Path::new("bench.yaml"), case.yaml.clone()).expect("sound YAML");
    let resolved = file.resolve(&doc).expect("a sound model");
    let mut model = resolved.model;
    (model.solver.method, model.solver.friction) = (method, law);
    let mut sim = Simulation::new(model, resolved.state);
    let start = Instant::now();
    let moving: Vec<usize> = (0..sim.model.n_bodies()).filter(|b| sim.model.inv_mass[*b] > 0.0).collect();
    let weight = moving.iter().map(|b| 1.0 / sim.model.inv_mass[*b]).sum::<f64>() * 9.81;
    let (mut steps, mut iterations, mut fastest, mut reaction, mut residual) = (0, 0, 0.0f64, [0.0f64; 2], 0.0f64);
    let mut next = 1.0;
    while sim.state.time < case.ends - 1e-9 {
        let report = sim.step();
        let speed = moving.iter().map(|b| sim.state.velocity[*b].length()).sum::<f64>() / moving.len() as f64;
        let c = &sim.state.contacts;
        let held = |b: u32| sim.model.inv_mass[b as usize] == 0.0;
        let force: f64 = (0..c.len())
            .map(|i| match c.bodies[i].map(held) {
                [true, false] => c.impulse[i].z,
                [false, true] => -c.impulse[i].z,
                _ => 0.0,
            })
            .sum::<f64>()
            / sim.model.step;
        if sim.state.time >= next - 1e-9 {
            let top = moving.iter().map(|b| sim.state.position[*b].z).fold(0.0, f64::max);
            let deep = sim.state.contacts.worst_penetration();
            eprintln!("  {} {} {law:?} t {next:.1}: {speed:.2e} m/s, force {:+.2e}, residual {:.1e}, it {}, top {top:.3}, overlap {deep:.1e}, n {}", case.name, method.name(), force / weight - 1.0, report.residual, report.iterations, c.len());
            next += 0.5;
        }
        if sim.state.time >= case.rests_from {
            steps += 1;
            iterations += report.iterations;
            fastest = fastest.max(speed);
            residual = residual.max(report.residual);
            let off = force / weight - 1.0;
            reaction = [reaction[0] + off, reaction[1].max(off.abs())];
        }
    }
    let law = if law == FrictionLaw::Exact { "exact" } else { "relaxed" };
    format!(
        "{},{},{law},{fastest:.2e},{:.2e},{:.2e},{residual:.2e},{:.1},{:.1}",
        case.name,
        method.name(),
        reaction[0] / f64::from(steps),
        reaction[1],
        f64::from(iterations) / f64::from(steps),
        start.elapsed().as_secs_f64()
    )
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
                let word = if law == FrictionLaw::Exact { "exact" } else { "relaxed" };
                if asked(&methods, method.name()) && asked(&["exact", "relaxed"], word) {
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
    println!("case,method,law,fastest mean speed [m/s],mean of reaction,worst of reaction,worst residual [m/s],iterations,wall [s]");
    rows.iter().for_each(|r| println!("{r}"));
}
