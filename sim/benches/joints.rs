//! Joints: what it costs to factorise their system and to solve it, and whole runs, with the gaps that are left.
//!
//! `cargo bench -p sim --bench joints [CASE…]` writes `results/joints.csv`; with names of cases it only prints their rows. Everything
//! runs on one thread: the times of the system are the shortest of many, those of the runs are CPU time.

mod clock;

use clock::cpu_seconds;
use frame::yaml;
use sim::Simulation;
use sim::joint_system::JointSystem;
use sim::model_file::ModelFile;
use std::fmt::Write as _;
use std::path::Path;
use std::time::{Duration, Instant};

/// A model, the step of its run and its end, s.
struct Case {
    name: String,
    yaml: String,
    step: f64,
    ends: f64,
}

const HEAD: &str =
    "name: bench\nstep: 0.001\nduration: 1\nframe_rate: 1\nmaterials: {m: {density: 1000, friction: 0.6}}\n";

/// Bodies of radius 0.4 m at places, those that are held, and joints between them: kind, bodies, place.
struct Mechanism {
    yaml: String,
    joints: String,
    n_joints: usize,
}

impl Mechanism {
    fn new(gravity: [f64; 3]) -> Mechanism {
        Mechanism {
            yaml: format!("{HEAD}gravity: {gravity:?}\npass_through: [[g, g]]\nbodies:\n"),
            joints: "joints:\n".to_string(),
            n_joints: 0,
        }
    }

    fn body(&mut self, name: &str, place: [f64; 3], is_fixed: bool) {
        let fixed = if is_fixed { ", fixed: true" } else { "" };
        let line =
            format!("  - {{name: {name}, material: m, group: g, position: {place:?}, sphere: {{radius: 0.4}}{fixed}}}");
        writeln!(self.yaml, "{line}").expect("text");
    }

    fn joint(&mut self, kind: &str, [a, b]: [&str; 2], place: [f64; 3]) {
        let n = self.n_joints;
        self.n_joints += 1;
        let axis = if kind == "spherical" { "" } else { ", axis: [0, 0, 1]" };
        let line = format!("  - {{name: j{n}, kind: {kind}, a: {a}, b: {b}, position: {place:?}{axis}}}");
        writeln!(self.joints, "{line}").expect("text");
    }

    fn case(self, name: &str, step: f64, ends: f64) -> Case {
        Case { name: name.to_string(), yaml: self.yaml + &self.joints, step, ends }
    }
}

/// A grid of spherical joints whose upper row is held.
fn grid(n: usize, gravity: [f64; 3], name: &str, step: f64, ends: f64) -> Case {
    let mut m = Mechanism::new(gravity);
    let of = |k: usize, i: usize| format!("b{k}_{i}");
    for k in 0..n {
        for i in 0..n {
            let (x, y) = (k as f64, -(i as f64));
            m.body(&of(k, i), [x, y, 0.0], i == 0);
            if i > 0 {
                m.joint("spherical", [&of(k, i - 1), &of(k, i)], [x, y + 0.5, 0.0]);
                if k > 0 {
                    m.joint("spherical", [&of(k - 1, i), &of(k, i)], [x - 0.5, y, 0.0]);
                }
            }
        }
    }
    m.case(name, step, ends)
}

/// Chains of joints of the given kinds in turn; their first bodies hang on the world, their ends too where they are closed.
fn chains(name: &str, n_chains: usize, links: usize, kinds: &[&str], closed: bool, step: f64, ends: f64) -> Case {
    let mut m = Mechanism::new([0.0, -9.81, 0.0]);
    for c in 0..n_chains {
        let z = 2.0 * c as f64;
        let of = |i: usize| if i == 0 { "world".to_string() } else { format!("b{c}_{i}") };
        for i in 1..=links {
            m.body(&of(i), [i as f64, 0.0, z], false);
            m.joint(kinds[i % kinds.len()], [&of(i - 1), &of(i)], [i as f64 - 0.5, 0.0, z]);
        }
        if closed {
            m.joint("spherical", [&of(links), "world"], [links as f64 + 0.5, 0.0, z]);
        }
    }
    m.case(name, step, ends)
}

/// A body that hangs on the world with many bodies on it.
fn star(n: usize, step: f64, ends: f64) -> Case {
    let mut m = Mechanism::new([0.0, -9.81, 0.0]);
    m.body("hub", [0.0; 3], false);
    m.joint("universal", ["world", "hub"], [0.0; 3]);
    for i in 0..n {
        let (name, x, z) = (format!("b{i}"), (i % 64) as f64 - 31.5, (i / 64) as f64 - (n / 128) as f64);
        m.body(&name, [x, -1.0, z], false);
        m.joint("spherical", ["hub", &name], [x, -0.5, z]);
    }
    m.case(&format!("star {n}"), step, ends)
}

fn cases() -> Vec<Case> {
    const MIXED: [&str; 5] = ["spherical", "revolute", "universal", "fixed", "revolute"];
    let still = [0.0, -10.0, 0.0];
    let mut cases = vec![
        chains("pendulum", 1, 1, &["revolute"], false, 1e-3, 10.0),
        chains("three links", 1, 3, &["spherical"], false, 1e-3, 10.0),
        chains("chain 10000", 1, 10_000, &["spherical"], false, 1e-3, 0.2),
        chains("chains 500 of 20 mixed", 500, 20, &MIXED, false, 1e-3, 0.2),
        chains("closed chains 100 of 60", 100, 60, &["revolute", "spherical"], true, 1e-3, 0.2),
        star(3000, 1e-3, 0.2),
        grid(30, still, "grid 30", 1.0 / 240.0, 0.5),
    ];
    for rate in [60.0, 120.0, 240.0] {
        cases.push(grid(100, still, &format!("grid 100 at {rate} Hz"), 1.0 / rate, 60.0 / rate));
        cases.push(grid(100, [0.0, -7.0, 7.0], &format!("swinging grid 100 at {rate} Hz"), 1.0 / rate, 60.0 / rate));
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("models/tracked_vehicle.yaml");
    let yaml = std::fs::read_to_string(path).expect("the model of the vehicle");
    cases.push(Case { name: "tracked vehicle".into(), yaml, step: 1e-3, ends: 3.0 });
    cases
}

/// The shortest time of a few calls, µs.
fn shortest(mut call: impl FnMut()) -> f64 {
    let start = Instant::now();
    let mut best = Duration::MAX;
    let mut n = 0;
    while n < 3 || (start.elapsed() < Duration::from_millis(400) && n < 2000) {
        let now = Instant::now();
        call();
        best = best.min(now.elapsed());
        n += 1;
    }
    best.as_secs_f64() * 1e6
}

fn run(case: &Case) -> String {
    let (file, doc) = yaml::parse::<ModelFile>(Path::new("bench.yaml"), case.yaml.clone()).expect("sound YAML");
    let resolved = file.resolve(&doc).unwrap_or_else(|e| panic!("{}: {e}", case.name));
    let mut model = resolved.model;
    model.step = case.step;
    let mut system = JointSystem::new(&model, &resolved.state);
    system.factorise();
    let factorise = shortest(|| system.factorise());
    let mut left = 0.0;
    let solve = shortest(|| left = system.solve());
    let analyse = shortest(|| {
        system.forget();
        system.factorise();
    }) - factorise;
    let (numbers, work) = system.size();
    let mut sim = Simulation::new(model, resolved.state);
    sim.step();
    let (start, from) = (cpu_seconds(), sim.state.time);
    let (mut gap, mut iterations, mut steps) = (0f64, 0u64, 0u64);
    while sim.state.time < case.ends - 1e-9 {
        let report = sim.step();
        assert!(report.broken.is_none(), "{}: {:?}", case.name, report.broken);
        gap = sim.state.joints.iter().fold(gap, |gap, joint| gap.max(joint.violation));
        iterations += u64::from(report.iterations);
        steps += 1;
    }
    let cpu = (cpu_seconds() - start) / (sim.state.time - from);
    format!(
        "{},{},{numbers},{work},{analyse:.0},{factorise:.2},{solve:.2},{left:.1e},{},{cpu:.3},{:.1},{gap:.1e}",
        case.name,
        system.n_rows(),
        case.step,
        iterations as f64 / steps as f64,
    )
}

fn main() {
    let wanted: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("threads");
    let mut table = "case,rows,numbers of the factor,multiplications,analysis [us],factorisation [us],solve [us],\
                     residual of the solve,step [s],CPU-s per simulated second,iterations,maximum violation\n"
        .to_string();
    for case in cases().iter().filter(|c| wanted.is_empty() || wanted.iter().any(|w| c.name.contains(w.as_str()))) {
        let row = pool.install(|| run(case));
        eprintln!("{row}");
        table += &(row + "\n");
    }
    print!("{table}");
    if wanted.is_empty() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/results/joints.csv");
        std::fs::write(path, table).expect("the folder of results can be written");
    }
}
