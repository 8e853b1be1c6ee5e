//! Levels of quality: what they choose, what a model keeps, and what rests by them.

use crate::analytic::simulation;
use crate::cli::{scratch, scree};
use sim::watch::WarningKind;
use sim::workload::{self, Convex};
use sim::{Method, Quality, Simulation, State, checkpoint};

/// A workload of convex bodies at a level of quality.
fn scene(convex: Convex, n: usize, quality: Quality) -> Simulation {
    let mut model = workload::scene(convex, n);
    model.file.quality = Some(quality);
    model.simulation().unwrap()
}

/// Mean speed of the bodies that move, m/s.
fn mean_speed(sim: &Simulation) -> f64 {
    let n = sim.model.inv_mass.iter().filter(|inv_mass| **inv_mass > 0.0).count();
    sim.state.velocity.iter().map(|v| v.length()).sum::<f64>() / n as f64
}

#[test]
fn a_pyramid_rests_and_stays_where_it_is() {
    for (quality, overlap) in [(Quality::Draft, 1e-3), (Quality::Normal, 1e-4), (Quality::Tight, 1e-6)] {
        let mut sim = scene(Convex::Pyramid, 12, quality);
        let start = sim.state.position.clone();
        let mut worst = 0.0f64;
        while sim.state.time < 2.0 {
            worst = worst.max(sim.step().worst_penetration);
        }
        let moved = sim.state.position.iter().zip(&start).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
        assert!(mean_speed(&sim) < 1e-4, "{quality:?}: {} m/s", mean_speed(&sim));
        assert!(worst < overlap && moved < 1e-3, "{quality:?}: overlap {worst}, moved {moved}");
    }
}

#[test]
fn a_tall_pyramid_stands_upright_and_a_pile_between_walls_comes_to_rest() {
    // One box deep and 30 high: what leans out of its plane falls ever faster, unless the solver is right to less than it gains.
    let mut sim = scene(Convex::Pyramid, 30, Quality::Normal);
    while sim.state.time < 4.0 {
        sim.step();
    }
    assert!(mean_speed(&sim) < 1e-4, "pyramid: {} m/s", mean_speed(&sim));

    let walls: String = [("e", -1, 0), ("w", 1, 0), ("n", 0, -1), ("s", 0, 1)]
        .map(|(name, x, y)| {
            let at = [f64::from(x), f64::from(y)].map(|normal| -0.5 * normal);
            format!(
                "  - {{name: {name}, material: m, plane: {{normal: [{x}, {y}, 0]}}, position: [{}, {}, 0]}}\n",
                at[0], at[1]
            )
        })
        .concat();
    let boxes: String = (0..200)
        .map(|i| {
            let [x, y, z] = [i % 4, i / 4 % 4, i / 16].map(f64::from);
            let at = [0.22 * (x - 1.5), 0.22 * (y - 1.5), 0.2 + 0.25 * z];
            let turn = format!("rotate: {{axis: [1, 2, {}], angle: {}}}", i % 7, 20 * i);
            format!("  - {{name: b{i}, material: m, box: {{size: [0.2, 0.15, 0.1]}}, position: {at:?}, {turn}}}\n")
        })
        .collect();
    let pile = format!(
        "quality: normal
materials: {{m: {{density: 2500, friction: 0.5}}}}
bodies:
  - {{name: ground, material: m, plane: {{normal: [0, 0, 1]}}}}
{walls}{boxes}"
    );
    let mut sim = simulation(&pile);
    let mut fastest = 0.0f64;
    while sim.state.time < 4.5 {
        sim.step();
        fastest = if sim.state.time > 4.0 { fastest.max(mean_speed(&sim)) } else { 0.0 };
    }
    assert!(fastest < 1e-5, "pile: {fastest} m/s");
}

#[test]
fn hulls_and_boxes_that_are_poured_hardly_overlap() {
    // At the end a tenth of what the peers' engines leave of the inradius, and at no time so much that they pass into each other.
    for (convex, n, (bound, always)) in [(Convex::Boxes, 600, (0.08, 0.5)), (Convex::Pile, 2, (5e-3, 0.05))] {
        let mut sim = scene(convex, n, Quality::Normal);
        let measure = workload::Measure::new(&sim);
        let mut worst = 0.0f64;
        while sim.state.time < 2.0 {
            sim.step();
            worst = worst.max(measure.penetration(&sim.state));
        }
        let overlap = measure.penetration(&sim.state);
        assert!(overlap < bound && worst < always, "{convex:?}: {overlap} at the end, {worst} before");
    }
}

/// A wall of small bricks, one deep and fifty rows high, which gravity buckles, and what slides though it hardly moves.
#[test]
fn a_high_wall_of_small_bricks_rests_and_a_slope_does_not_hold_what_slides() {
    let ground = "  - {name: ground, material: m, plane: {normal: [0, 0, 1]}}\n";
    let brick = |k: usize, x: f64, z: f64| {
        format!("  - {{name: b{k}, material: m, position: [{x}, 0, {z}], box: {{size: [0.25, 0.12, 0.1]}}}}\n")
    };
    let model = |gravity: [f64; 3], bricks: &str| {
        simulation(&format!(
            "quality: normal\ngravity: {gravity:?}\nmaterials: {{m: {{density: 2000, friction: 0.5}}}}\nbodies:\n{ground}{bricks}"
        ))
    };
    let place = |k: usize| (k, 0.25 * (k % 3) as f64 + 0.125 * (k / 3 % 2) as f64, 0.05 + 0.1 * (k / 3) as f64);
    let bricks: String = (0..150).map(place).map(|(k, x, z)| brick(k, x, z)).collect();
    let mut wall = model([0.0, 0.0, -9.81], &bricks);
    while wall.state.time < 5.0 {
        wall.step();
    }
    assert!(mean_speed(&wall) < 1e-5, "{} m/s", mean_speed(&wall));

    // Slopes whose tangents are the coefficient of friction and 0.2 % less or more.
    let slide = |tangent: f64| {
        let (sin, cos) = tangent.atan().sin_cos();
        let mut slope = model([9.81 * sin, 0.0, -9.81 * cos], &brick(0, 0.0, 0.05));
        while slope.state.time < 2.0 {
            slope.step();
        }
        let (way, time) = (slope.state.position[1].x, slope.state.time);
        (way, 0.5 * 9.81 * (sin - 0.5 * cos) * time * time)
    };
    assert!(slide(0.499).0 < 1e-6);
    let (way, expected) = slide(0.501);
    assert!((way / expected - 1.0).abs() < 0.1, "{way} m of {expected}");
}

/// A column of eight boxes, and a wall, that begin with gaps and fall on each other: slow bodies are swept until they are solved.
#[test]
fn what_has_fallen_on_each_other_comes_to_rest() {
    let column =
        (0..8).map(|k| ([0.006 * f64::from(k % 3), 0.004 * f64::from(k % 2), 0.13 + 0.22 * f64::from(k)], [0.15; 3]));
    let wall = (0..66).map(|k: u32| {
        let (row, column) = (k / 6, f64::from(k % 6) + 0.5 * f64::from(k / 6 % 2));
        ([0.252 * column, 0.0, 0.052 + 0.102 * f64::from(row)], [0.25, 0.12, 0.1])
    });
    for (what, boxes) in [("column", column.collect::<Vec<_>>()), ("wall", wall.collect())] {
        let bodies: String = (boxes.iter().enumerate())
            .map(|(k, (at, size))| {
                format!("  - {{name: b{k}, material: m, position: {at:?}, box: {{size: {size:?}}}}}\n")
            })
            .collect();
        let mut sim = simulation(&format!(
            "quality: normal
materials: {{m: {{density: 2000, friction: 0.5}}}}
bodies:
  - {{name: ground, material: m, plane: {{normal: [0, 0, 1]}}}}
{bodies}"
        ));
        while sim.state.time < 5.0 {
            sim.step();
        }
        assert!(mean_speed(&sim) < 3e-5, "{what}: {} m/s", mean_speed(&sim));
    }
}

/// Straight columns of ten spheres, as on the sites of a lattice, that fall on each other: sweeps go on until such a step has converged.
#[test]
fn columns_of_spheres_that_fall_converge() {
    for quality in ["draft", "normal"] {
        let mut bodies = String::new();
        for k in 0..90 {
            let [x, y, z] = [k % 3, k / 3 % 3, k / 9].map(f64::from);
            bodies += &format!(
                "  - {{name: b{k}, material: m, sphere: {{radius: 0.05}}, position: [{}, {}, {}]}}\n",
                0.2 * x,
                0.2 * y,
                0.1 + 0.17 * z
            );
        }
        let mut sim = simulation(&format!(
            "quality: {quality}
materials: {{m: {{density: 1000, friction: 0.5}}}}
bodies:
  - {{name: ground, material: m, plane: {{normal: [0, 0, 1]}}}}
{bodies}"
        ));
        while sim.state.time < 1.0 {
            let report = sim.step();
            assert!(report.warnings.is_empty(), "{quality}, {} s: {:?}", sim.state.time, report.warnings);
        }
    }
}

#[test]
fn kept_manifolds_do_not_depend_on_threads_or_checkpoints() {
    let work = scratch();
    let path = |name: &str| work.path().join(name);
    let first = scene(Convex::Boxes, 300, Quality::Normal);
    let run = |threads: usize, state: State, steps: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut sim = Simulation::new(first.model.clone(), state);
        pool.install(|| (0..steps).for_each(|_| drop(sim.step())));
        sim.state
    };
    let whole = run(1, first.state.clone(), 300);
    assert!(whole.manifolds.parts.iter().map(|part| part.kept.len()).sum::<usize>() > 300);
    checkpoint::write(&path("whole"), &whole, "").unwrap();
    checkpoint::write(&path("half"), &run(2, first.state.clone(), 171), "").unwrap();
    let half = checkpoint::read(&path("half")).unwrap().0;
    checkpoint::write(&path("two"), &run(7, half, 129), "").unwrap();
    assert!(std::fs::read(path("whole")).unwrap() == std::fs::read(path("two")).unwrap(), "the states differ");
}

#[test]
fn what_a_model_gives_is_kept() {
    let mut model = workload::scene(Convex::Pyramid, 3);
    let plain = model.simulation().unwrap().model;
    assert_eq!((plain.step, plain.solver.method), (1e-3, None));
    model.file.quality = Some(Quality::Normal);
    let chosen = model.simulation().unwrap().model;
    assert_eq!((chosen.step, chosen.solver.method), (1.0 / 120.0, Some(Method::GaussSeidel)));

    let work = scratch();
    let place = |name: &str| work.path().join(name).to_str().unwrap().to_string();
    let (file, run) = (place("m.yaml"), place("run"));
    let body = "materials: {m: {density: 1000, friction: 0.5}}
bodies:
  - {name: ground, material: m, plane: {normal: [0, 0, 1]}}
  - {name: block, material: m, box: {size: [0.2, 0.2, 0.2]}, position: [0, 0, 0.1]}
duration: 0.05
";
    let resolved = |text: &str, args: &[&str]| {
        std::fs::write(&file, text.to_string() + body).unwrap();
        scree(&[&["simulate", &file, "-o", &run, "--fresh"], args].concat()).ok();
        std::fs::read_to_string(work.path().join("run/model.yaml")).unwrap()
    };
    let normal = resolved("quality: normal\n", &[]);
    assert!(normal.contains("quality: normal") && normal.contains("method: gauss_seidel"), "{normal}");
    assert_eq!(normal, resolved("", &["--quality", "normal"]));
    assert_eq!(normal, resolved("quality: normal\nsolver: {method: gauss_seidel}\n", &[]));
    assert_ne!(normal, resolved("quality: normal\n", &["--quality", "tight"]));
    let two = ["simulate", &file, "-o", &run, "--quality", "tight", "--set", "quality=draft"];
    assert!(scree(&two).fails(2).contains("give one"));
    let given = resolved("quality: tight\nstep: 0.002\nsolver: {method: apgd, tolerance: 1.0e-5}\n", &[]);
    for line in ["step: 0.002", "method: apgd", "tolerance: 0.00001", "friction: relaxed"] {
        assert!(given.contains(line), "{line}: {given}");
    }
    // What is chosen beside a step that is given is of that step.
    let given_step = resolved("quality: normal\nstep: 0.005\n", &[]);
    for (key, expected) in [("envelope", 15.0 * 9.81 * 0.005f64.powi(2)), ("rest_speed", 2e-3 * 9.81 * 0.005)] {
        let value = given_step.lines().find_map(|line| line.trim().strip_prefix(&format!("{key}: "))).unwrap();
        assert!((value.parse::<f64>().unwrap() / expected - 1.0).abs() < 1e-9, "{key}: {value}, expected {expected}");
    }
    // Where nothing falls, nothing settles.
    assert!(!resolved("quality: normal\ngravity: [0, 0, 0]\n", &[]).contains("settling"));
    let given = resolved("quality: tight\nstep: 0.002\nsolver: {method: apgd, tolerance: 1.0e-5}\n", &[]);
    // The model that a run leaves gives all, and so is the same again.
    let again = work.path().join("run/model.yaml");
    std::fs::copy(&again, place("again.yaml")).unwrap();
    scree(&["simulate", &place("again.yaml"), "-o", &place("other")]).ok();
    assert_eq!(given, std::fs::read_to_string(work.path().join("other/model.yaml")).unwrap());

    std::fs::write(&file, format!("quality: fine\n{body}")).unwrap();
    let said = scree(&["simulate", &file, "-o", &run, "--fresh"]).fails(3);
    assert!(said.contains("draft") && said.contains("normal") && said.contains("tight"), "{said}");
}

#[test]
fn the_bench_of_convex_bodies_prints_its_keys() {
    for (workload, n) in [("pyramid", "4"), ("pile", "1"), ("boxes", "40"), ("grid", "3")] {
        let args = ["bench", "sim", "--workload", workload, "--n", n, "--steps", "5", "--quality", "draft", "--json"];
        let text = scree(&args).ok();
        let found: serde_json::Value = serde_json::from_str(&text).unwrap();
        for key in [
            "startup_cpu_seconds",
            "cpu_seconds_per_simulated_second",
            "worst_penetration_over_inradius",
            "worst_penetration_over_inradius_run",
            "drift_max_m",
            "drop_max_m",
            "kinetic_energy_j",
        ] {
            assert!(found[key].is_number(), "{workload}: {key}: {text}");
        }
        assert_eq!(found["joint_gap_max_m"].is_number(), workload == "grid", "{text}");
        assert_eq!(found["quality"], "draft");
    }
}

/// Sweeps that end above the residual's bound with contacts that roll with friction, and sweeps over spheres whose first step is solved by more
/// iterations of another method.
#[test]
fn sweeps_name_the_worst_contact_and_start_by_another_method() {
    let rolling = "quality: normal
solver: {iterations: 5}
materials: {m: {density: 2000, friction: 0.5, rolling: 0.002}}
bodies:
  - {name: ground, material: m, plane: {normal: [0, 0, 1]}}
  - {name: h, material: m, hull: {points: [[0.1, 0, -0.05], [-0.1, 0.08, -0.05], [-0.05, -0.1, -0.05], [0, 0, 0.1]]}, position: [0, 0, 0.06]}
  - {name: c, material: m, cylinder: {radius: 0.1, length: 0.2}, position: [0.01, 0, 0.3]}
";
    let mut sim = simulation(rolling);
    while sim.state.time < 0.3 {
        sim.step();
    }
    let warning = sim.state.watch.warnings.iter().find(|w| w.first.kind == WarningKind::Residual).expect("a warning");
    assert!(warning.first.message.contains("it is greatest between body"), "{}", warning.first.message);

    let spheres = "solver: {method: gauss_seidel, start_iterations: 100}
materials: {m: {density: 2000, friction: 0.5}}
bodies:
  - {name: ground, material: m, plane: {normal: [0, 0, 1]}}
  - {name: a, material: m, sphere: {radius: 0.1}, position: [0, 0, 0.1]}
  - {name: b, material: m, sphere: {radius: 0.1}, position: [0, 0, 0.3]}
";
    for text in [spheres.to_string(), spheres.replace("solver: {", "solver: {friction: exact, ")] {
        let mut sim = simulation(&text);
        (0..100).for_each(|_| drop(sim.step()));
        assert!(mean_speed(&sim) < 1e-6, "{} m/s", mean_speed(&sim));
    }
}

/// Spheres that touch, in three and in five layers over a triangle, stand by their friction, which the lowest have to find at once.
#[test]
fn pyramids_of_spheres_stand() {
    for (n, friction) in [(3, 0.5), (5, 0.6)] {
        for quality in ["normal", "tight"] {
            let mut yaml = format!(
                "quality: {quality}
materials: {{m: {{density: 2000, friction: {friction}}}}}
bodies:
  - {{name: ground, material: m, plane: {{normal: [0, 0, 1]}}}}
"
            );
            let (side, height) = (0.2 * 0.75f64.sqrt(), 0.2 * (2.0f64 / 3.0).sqrt());
            let places = (0..n).flat_map(|k| (0..n - k).flat_map(move |i| (0..n - k - i).map(move |j| [i, j, k])));
            for [i, j, k] in places {
                let [x, y, z] = [i, j, k].map(f64::from);
                let at = [0.2 * (x + 0.5 * y + 0.5 * z), side * (y + z / 3.0), 0.1 + height * z];
                yaml +=
                    &format!("  - {{name: s{i}_{j}_{k}, material: m, sphere: {{radius: 0.1}}, position: {at:?}}}\n");
            }
            let mut sim = simulation(&yaml);
            let start = sim.state.position.clone();
            while sim.state.time < 3.0 {
                sim.step();
            }
            let moved = sim.state.position.iter().zip(&start).map(|(p, q)| p.distance(*q)).fold(0.0, f64::max);
            assert!(moved < 1e-5, "{n} layers, {quality}: {moved} m");
        }
    }
}
