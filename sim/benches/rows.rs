//! The numbers of mechanics at the levels of quality: what slides, rolls, stands, swings and tumbles, against closed forms.
//!
//! `cargo bench -p sim --bench rows [WORD…]` writes `results/rows.csv`; words choose among the names of rows and levels. Rows whose numbers are of
//! a step or a law of friction keep these. Exit code 1 where a number is out of its bound.

use frame::yaml;
use sim::model_file::ModelFile;
use sim::{Quality, Simulation};
use std::path::Path;

/// A number that is measured: its name, what it should be, and how far it may be off.
struct Found {
    what: &'static str,
    found: f64,
    expected: f64,
    within: f64,
}

/// A number and what it should be, to a relative tolerance.
fn near(what: &'static str, found: f64, expected: f64, relative: f64) -> Found {
    Found { what, found, expected, within: relative * expected.abs() }
}

/// A number that should be 0.
fn below(what: &'static str, found: f64, within: f64) -> Found {
    Found { what, found, expected: 0.0, within }
}

/// A model without `quality`, and what is measured on it.
struct Row {
    name: &'static str,
    yaml: String,
    measure: fn(Simulation) -> Vec<Found>,
}

const G: f64 = 9.81;
const GROUND: &str = "  - {name: ground, material: m, plane: {normal: [0, 0, 1]}}\n";

fn rows() -> Vec<Row> {
    let row = |name, yaml: String, measure| Row { name, yaml, measure };
    let sphere = |more: &str, speed: f64| {
        format!(
            "{more}materials: {{m: {{density: 1, friction: 0.1}}}}\nbodies:\n{GROUND}  - {{name: sphere, material: m, mass: 1, sphere: {{radius: 1}}, position: [0, 0, 1], velocity: [{speed}, 0, 0]}}\n"
        )
    };
    let stack = |n: usize, shape: &str, last: f64| {
        let body = |i: usize| {
            let mass = if i + 1 == n { last } else { 1.0 };
            format!(
                "  - {{name: b{i}, material: m, mass: {mass}, {shape}, position: [0, 0, {}]}}\n",
                0.1 + 0.2 * i as f64
            )
        };
        let bodies: String = (0..n).map(body).collect();
        format!("materials: {{m: {{density: 2000, friction: 0.5}}}}\nbodies:\n{GROUND}{bodies}")
    };
    let slope = |degrees: f64, friction: f64, shape: &str, half: f64| {
        let (x, z) = (degrees.to_radians().sin(), degrees.to_radians().cos());
        format!(
            "materials: {{m: {{density: 1000, friction: {friction}}}}}\nbodies:\n  - {{name: slope, material: m, plane: {{normal: [{x}, 0, {z}]}}}}\n  - {{name: body, material: m, {shape}, position: [{}, 0, {}], rotate: {{axis: [0, 1, 0], angle: {degrees}}}}}\n",
            half * x,
            half * z
        )
    };
    const CUBE: &str = "box: {size: [0.2, 0.2, 0.2]}";
    const BALL: &str = "sphere: {radius: 0.1}";
    const BLOCK: &str = "box: {size: [0.2, 0.2, 0.1]}";
    vec![
        row("one step, relaxed", sphere("step: 0.005\nsolver: {friction: relaxed}\n", 2.0), |mut sim| {
            sim.step();
            vec![near("speed", sim.state.velocity[1].x, 1.975937, 1e-5), near("lift", sim.state.velocity[1].z, 0.191578, 1e-4)]
        }),
        row("one step, exact", sphere("step: 0.005\nsolver: {friction: exact}\n", 2.0), |mut sim| {
            sim.step();
            vec![near("speed", sim.state.velocity[1].x, 1.995095, 1e-5)]
        }),
        row("sliding turns to rolling", sphere("", 2.0), |mut sim| {
            let mut rolls = [f64::NAN; 2];
            while sim.state.time < 1.0 - 1e-9 {
                sim.step();
                let spin = (sim.state.orientation[1] * sim.state.angular_velocity[1]).y;
                if rolls[0].is_nan() && (sim.state.velocity[1].x - spin).abs() < 1e-3 {
                    rolls = [sim.state.time, sim.state.position[1].x];
                }
            }
            let speed = near("rolling speed", sim.state.velocity[1].x, 10.0 / 7.0, 1e-3);
            vec![speed, near("time", rolls[0], 0.58250, 0.02), near("place", rolls[1], 0.99856, 0.02)]
        }),
        row(
            "block slides",
            format!("solver: {{friction: exact}}\nmaterials: {{m: {{density: 1000, friction: 0.5}}}}\nbodies:\n{GROUND}  - {{name: block, material: m, box: {{size: [0.4, 0.4, 0.1]}}, position: [0, 0, 0.05], velocity: [5, 0, 0]}}\n"),
            |mut sim| {
                run(&mut sim, 1.2);
                // A step later or earlier is half a step's way.
                vec![near("stopping distance", sim.state.position[1].x, 2.548, 0.005), below("speed", sim.state.velocity[1].length(), 1e-4)]
            },
        ),
        row("incline that holds", slope(20.0, 0.5, BLOCK, 0.05), |mut sim| {
            let start = sim.state.position[1];
            run(&mut sim, 5.0);
            vec![below("drift in 5 s", (sim.state.position[1] - start).length(), 1e-4)]
        }),
        row("incline that slides, exact", "solver: {friction: exact}\n".to_string() + &slope(20.0, 0.2, BLOCK, 0.05), |mut sim| {
            run(&mut sim, 1.0);
            let angle = 20f64.to_radians();
            let acceleration = sim.state.velocity[1].length() / sim.state.time;
            vec![near("acceleration", acceleration, G * (angle.sin() - 0.2 * angle.cos()), 2e-3)]
        }),
        row("rolling down", slope(10.0, 0.6, BALL, 0.1), |mut sim| {
            run(&mut sim, 1.0);
            let acceleration = sim.state.velocity[1].length() / sim.state.time;
            vec![near("acceleration", acceleration, 5.0 / 7.0 * G * 10f64.to_radians().sin(), 2e-3)]
        }),
        row("5 spheres on each other", stack(5, BALL, 1.0), |sim| stands(sim, 2.0)),
        row("10 boxes on each other", stack(10, CUBE, 1.0), |sim| stands(sim, 2.0)),
        row("20 spheres under 1000 times", stack(21, BALL, 1000.0), |sim| stands(sim, 2.0)),
        row(
            "container",
            format!(
                "materials: {{m: {{density: 2500, friction: 0.3}}}}\nbodies:\n{GROUND}{}{}",
                [[-1, 0], [1, 0], [0, -1], [0, 1]]
                    .iter()
                    .enumerate()
                    .map(|(k, [x, y])| format!("  - {{name: wall{k}, material: m, plane: {{normal: [{x}, {y}, 0]}}, position: [{}, {}, 0]}}\n", -x, -y))
                    .collect::<String>(),
                (0..8)
                    .map(|i| {
                        let at = [i & 1, i >> 1 & 1, i >> 2].map(|k| f64::from(k) - 0.5);
                        format!("  - {{name: s{i}, material: m, mass: 5, sphere: {{radius: 0.5}}, position: [{}, {}, {}]}}\n", at[0], at[1], at[2] + 1.0)
                    })
                    .collect::<String>()
            ),
            |mut sim| {
                run(&mut sim, 2.0);
                vec![Found { what: "force on the ground", found: force_on_ground(&sim), expected: 392.4, within: 1e-3 }]
            },
        ),
        row(
            "idle, then load",
            format!("materials: {{m: {{density: 2500, friction: 0.5}}}}\nbodies:\n{GROUND}  - {{name: high, material: m, {BALL}, position: [3, 0, 60]}}\n  - {{name: stone, material: m, {CUBE}, position: [0, 0, 0.1]}}\n  - {{name: late, material: m, {CUBE}, position: [0, 0, 0.3], appears: 2}}\n"),
            |mut sim| {
                run(&mut sim, 3.0);
                let (stone, late) = (sim.state.position[2], sim.state.position[3]);
                vec![near("height", late.z, 0.3, 1e-3), below("drift", stone.truncate().length(), 1e-5), below("error of a fall of 44 m", sim.state.position[1].z - 60.0 + 0.5 * G * 9.0, 0.3)]
            },
        ),
        row(
            "free tumbling box",
            "gravity: [0, 0, 0]\nstep: 1e-3\nmaterials: {m: {density: 1000, friction: 0.3}}\nbodies:\n  - {name: box, material: m, box: {size: [0.1, 0.2, 0.4]}, angular_velocity: [0.01, 5, 0.01]}\n".into(),
            |mut sim| {
                let momentum = |sim: &Simulation| sim.state.orientation[0] * (sim.state.angular_velocity[0] / sim.model.inv_inertia[0]);
                let (l, e) = (momentum(&sim), sim.state.kinetic_energy(&sim.model));
                run(&mut sim, 10.0);
                let turned = (momentum(&sim) - l).length() / l.length();
                vec![below("energy drift", sim.state.kinetic_energy(&sim.model) / e - 1.0, 1e-5), below("momentum drift", turned, 1e-10)]
            },
        ),
        row(
            "momentum",
            format!(
                "gravity: [0, 0, 0]\nmaterials: {{m: {{density: 1000, friction: 0.4}}}}\nbodies:\n{}",
                (0..12)
                    .map(|i| {
                        let shape = [CUBE, BALL, "capsule: {radius: 0.05, length: 0.1}", "cylinder: {radius: 0.08, length: 0.12}"][i % 4];
                        let at = [i % 3, i / 3 % 2, i / 6].map(|k| 0.3 * (k as f64 - 0.7));
                        let v = at.map(|x| -2.0 * x);
                        format!("  - {{name: b{i}, material: m, {shape}, position: {at:?}, velocity: {v:?}, angular_velocity: [{i}, 1, -2]}}\n")
                    })
                    .collect::<String>()
            ),
            |mut sim| {
                let momentum = |sim: &Simulation| {
                    let (model, s) = (&sim.model, &sim.state);
                    let mut sum = [glam::DVec3::ZERO; 2];
                    for b in 0..model.n_bodies() {
                        let p = s.velocity[b] / model.inv_mass[b];
                        sum[0] += p;
                        sum[1] += s.position[b].cross(p) + s.orientation[b] * (s.angular_velocity[b] / model.inv_inertia[b]);
                    }
                    sum
                };
                let size: f64 = (0..12).map(|b| sim.state.velocity[b].length() / sim.model.inv_mass[b]).sum();
                let before = momentum(&sim);
                run(&mut sim, 1.0);
                let after = momentum(&sim);
                let change = |k: usize| (after[k] - before[k]).length() / size;
                vec![below("linear", change(0), 1e-10), below("angular", change(1), 1e-10)]
            },
        ),
        row(
            "revolute pendulum",
            "step: 5e-4\nmaterials: {m: {density: 1000, friction: 0}}\nbodies:\n  - {name: bob, shapes: [], mass: 1, inertia: [0.04, 0.1, 0.1], position: [2, 0, 0]}\njoints:\n  - {name: pin, kind: revolute, a: world, b: bob, position: [0, 0, 0], axis: [0, 1, 0]}\n".into(),
            |mut sim| {
                // Let go level, it comes to the other side after half a period: K(1/√2)/ω of small swings, twice.
                let omega = (G * 2.0 / 4.1f64).sqrt();
                let (mut before, mut half) = (sim.state.position[0].x, f64::NAN);
                let mut worst = 0f64;
                while half.is_nan() && sim.state.time < 5.0 {
                    sim.step();
                    let x = sim.state.position[0].x;
                    if x < 0.0 && x > before {
                        half = sim.state.time;
                    }
                    before = x;
                    worst = worst.max(sim.state.joints[0].violation);
                }
                vec![near("half a period", half, 2.0 * 1.854_074_677_301_372 / omega, 1e-3), below("gap of the joint", worst, 1e-5)]
            },
        ),
        row(
            "light chain",
            "step: 1e-3\nmaterials: {m: {density: 1000, friction: 0}}\nbodies:\n".to_string()
                + &(0..200)
                    .map(|k| format!("  - {{name: l{k}, shapes: [], mass: 0.01, inertia: [1e-6, 8e-6, 8e-6], position: [{}, 0, 0]}}\n", 0.1 * f64::from(k) + 0.05))
                    .collect::<String>()
                + "  - {name: load, shapes: [], mass: 1000, inertia: [10, 10, 10], position: [20, 0, 0]}\njoints:\n"
                + &(0..=200)
                    .map(|k| {
                        let a = if k == 0 { "world".into() } else { format!("l{}", k - 1) };
                        let b = if k == 200 { "load".into() } else { format!("l{k}") };
                        format!("  - {{name: j{k}, kind: spherical, a: {a}, b: {b}, position: [{}, 0, 0]}}\n", 0.1 * f64::from(k))
                    })
                    .collect::<String>(),
            |mut sim| {
                let mut longest = 0f64;
                while sim.state.time < 3.0 - 1e-9 {
                    sim.step();
                    longest = longest.max(sim.state.position[200].length());
                }
                vec![Found { what: "greatest length", found: longest, expected: 20.0, within: 1e-2 }]
            },
        ),
    ]
}

/// How far bodies on each other, of 0.2 m each, have moved.
fn stands(mut sim: Simulation, seconds: f64) -> Vec<Found> {
    run(&mut sim, seconds);
    let (mut drift, mut sunk, mut turned) = (0f64, 0f64, 0f64);
    for (i, p) in sim.state.position.iter().enumerate().skip(1) {
        drift = drift.max(p.truncate().length());
        sunk = sunk.max((p.z - (0.1 + 0.2 * (i - 1) as f64)).abs());
        turned = turned.max(2.0 * sim.state.orientation[i].w.abs().min(1.0).acos());
    }
    vec![below("drift", drift, 1e-5), below("sunk", sunk, 1e-3), below("turned", turned, 1e-4)]
}

fn run(sim: &mut Simulation, until: f64) {
    while sim.state.time < until - 1e-9 {
        sim.step();
    }
}

/// Vertical force on the bodies that are held, N.
fn force_on_ground(sim: &Simulation) -> f64 {
    let c = &sim.state.contacts;
    let held = |b: u32| sim.model.inv_mass[b as usize] == 0.0;
    let of = |i: usize| match c.bodies[i].map(held) {
        [true, false] => c.impulse[i].z,
        [false, true] => -c.impulse[i].z,
        _ => 0.0,
    };
    (0..c.len()).map(of).sum::<f64>().abs() / sim.model.step
}

fn main() {
    let words: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    let wanted = |name: &str, level: &str| words.iter().all(|w| name.contains(w.as_str()) || level == w);
    let mut table = String::from("row,quality,step [ms],number,found,expected,within\n");
    let mut is_out = false;
    for row in rows() {
        for quality in [Quality::Normal, Quality::Tight].into_iter().filter(|q| wanted(row.name, q.name())) {
            let text = format!("quality: {}\n{}", quality.name(), row.yaml);
            let (mut file, doc) = yaml::parse::<ModelFile>(Path::new("bench.yaml"), text).expect("sound YAML");
            file.choose(&doc).unwrap_or_else(|e| panic!("{}: {e}", row.name));
            let resolved = file.resolve(&doc).unwrap_or_else(|e| panic!("{}: {e}", row.name));
            let step = resolved.model.step;
            for Found { what, found, expected, within } in
                (row.measure)(Simulation::new(resolved.model, resolved.state))
            {
                let line = format!(
                    "{},{},{:.3},{what},{found:.6e},{expected:.6e},{within:.1e}",
                    row.name.replace(',', ";"),
                    quality.name(),
                    step * 1e3
                );
                let is_right = (found - expected).abs() <= within;
                is_out |= !is_right;
                eprintln!("{line}{}", if is_right { "" } else { "  <- out of its bound" });
                table += &(line + "\n");
            }
        }
    }
    if words.is_empty() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/results/rows.csv");
        std::fs::write(path, &table).expect("the results can be written");
    }
    if is_out {
        std::process::exit(1);
    }
}
