//! The solvers against each other, and on problems of others where they lie beside the tree.

use crate::analytic::simulation;
use crate::cli::scree;
use std::path::Path;

/// The velocities and angular velocities after a step that each method solves to the end: things of a shape that are pushed against each other,
/// of a material that has `law` besides friction. All methods have one answer.
fn one_answer(friction: &str, law: &str, shapes: [&str; 3]) {
    let [a, b, c] = shapes;
    let step = |method: &str| {
        let mut sim = simulation(&format!(
            "step: 1e-3
solver: {{method: {method}, friction: {friction}, iterations: 200000, tolerance: 1e-9, warm_start: false}}
materials: {{m: {{density: 1000, friction: 0.4{law}}}}}
bodies:
  - {{name: ground, material: m, plane: {{normal: [0, 0, 1]}}}}
  - {{name: a, material: m, {a}, position: [0, 0, 0.1], velocity: [1, 0.2, 0], angular_velocity: [3, 4, 10]}}
  - {{name: b, material: m, {b}, position: [0.2, 0, 0.1]}}
  - {{name: c, material: m, {c}, position: [0.1, 0, 0.273205]}}
"
        ));
        let report = sim.step();
        assert!(report.residual <= 1e-9 && report.contacts >= 5, "{method}: {report:?}");
        let levers = sim.state.angular_velocity.iter().map(|w| *w * 0.1);
        sim.state.velocity.iter().copied().chain(levers).collect::<Vec<_>>()
    };
    let first = step("apgd");
    for method in ["jacobi", "gauss_seidel", "barzilai_borwein"] {
        for (v, w) in step(method).iter().zip(&first) {
            assert!((*v - *w).length() < 1e-5, "{method}, {friction}{law}: {v} {w}");
        }
    }
}

const BALLS: [&str; 3] = ["sphere: {radius: 0.1}"; 3];

#[test]
fn the_four_methods_find_one_answer() {
    for friction in ["relaxed", "exact"] {
        one_answer(friction, "", BALLS);
    }
}

#[test]
fn the_methods_agree_on_rolling_friction_and_cohesion() {
    let mixed =
        ["sphere: {radius: 0.1}", "ellipsoid: {radii: [0.1, 0.07, 0.1]}", "capsule: {radius: 0.1, length: 0.05}"];
    for law in
        [", rolling: 5e-3", ", spinning: 4e-3", ", cohesion: 30", ", rolling: 2e-3, spinning: 1e-3, cohesion: 20"]
    {
        for shapes in [BALLS, mixed] {
            one_answer("relaxed", law, shapes);
            one_answer("exact", law, shapes);
        }
    }
}

#[test]
fn problems_of_others_are_solved() {
    // Those of `friction.rs` are of the same kind, and always there.
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/fc3d");
    let Ok(entries) = std::fs::read_dir(&folder) else {
        eprintln!("skipped: the collection of problems is not beside the tree");
        return;
    };
    for path in entries.flatten().map(|e| e.path()) {
        solved(&path);
    }
}

/// Solve a problem by both laws of friction with the command.
pub fn solved(path: &Path) {
    let path = path.to_str().unwrap();
    for friction in ["exact", "relaxed"] {
        let said = scree(&["solve", path, "--friction", friction, "--tolerance", "1e-4", "--json"]).ok();
        let result: serde_json::Value = serde_json::from_str(said.lines().next().unwrap_or("")).unwrap();
        assert!(result["error"].as_f64().unwrap() <= 1e-4, "{path}: {result}");
    }
}

#[test]
fn a_broken_problem_has_its_place() {
    let folder = tempfile::tempdir().unwrap();
    for (text, said) in [
        ("3 1 0 3 3 3 3 1 0 0 0 1 0 0 0 x -1 0 0 0.5", "`x` is not"),
        ("3 1 0 3 3 3 3 1 0 0 0 1 0 0 0", "ends where"),
        ("2 1", "2 dimensions"),
        ("3 1 5 3 3", "kind 5"),
        ("3 1 0 3 3 3 3 1 0 0 0 1 0 0 0 1 -1 0 0 -0.5", "coefficient of friction"),
    ] {
        let path = folder.path().join("p.dat");
        std::fs::write(&path, text).unwrap();
        let answer = scree(&["solve", path.to_str().unwrap()]).fails(3);
        assert!(answer.contains(said), "{answer}");
    }
}
