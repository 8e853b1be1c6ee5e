//! The solvers against each other, and on problems of others where they lie beside the tree.

use crate::analytic::simulation;
use crate::cli::scree;
use std::path::Path;

#[test]
fn the_four_methods_find_one_answer() {
    // A block that is pushed against others: sticking and sliding contacts.
    let step = |method: &str, friction: &str| {
        let mut sim = simulation(&format!(
            "step: 1e-3
solver: {{method: {method}, friction: {friction}, iterations: 200000, tolerance: 1e-9, warm_start: false}}
materials: {{m: {{density: 1000, friction: 0.4}}}}
bodies:
  - {{name: ground, material: m, plane: {{normal: [0, 0, 1]}}}}
  - {{name: a, material: m, sphere: {{radius: 0.1}}, position: [0, 0, 0.1], velocity: [1, 0.2, 0]}}
  - {{name: b, material: m, sphere: {{radius: 0.1}}, position: [0.2, 0, 0.1]}}
  - {{name: c, material: m, sphere: {{radius: 0.1}}, position: [0.1, 0, 0.273205]}}
"
        ));
        let report = sim.step();
        assert!(report.residual <= 1e-9, "{method}: {report:?}");
        sim.state.velocity.clone()
    };
    for friction in ["relaxed", "exact"] {
        let first = step("apgd", friction);
        for method in ["jacobi", "gauss_seidel", "barzilai_borwein"] {
            for (v, w) in step(method, friction).iter().zip(&first) {
                assert!((*v - *w).length() < 1e-5, "{method}, {friction}: {v} {w}");
            }
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
