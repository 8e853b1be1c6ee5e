//! The shader library compiles, and shaders compute what they say.

use sl::machine::{BoundShader, Machine, Points, Scene};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// An empty scene.
struct Nothing(Vec<Arc<BoundShader>>);

impl Scene for Nothing {
    fn lights(&self) -> &[Arc<BoundShader>] {
        &self.0
    }
    fn matrix(&self, _: &str, _: &str) -> Option<[f32; 16]> {
        None
    }
    fn transmission(&self, _: [f32; 3], to: [f32; 3]) -> [f32; 3] {
        // Everything above x = 0.5 of the target's way is in shadow.
        if to[0] > 0.5 { [0.0; 3] } else { [1.0; 3] }
    }
}

fn bind(source: &str) -> Arc<BoundShader> {
    let program = sl::compile(Path::new("test.sl"), source).unwrap_or_else(|e| panic!("{e}"));
    Arc::new(BoundShader { program: Arc::new(program), numbers: vec![], texts: vec![] })
}

/// Run a surface shader over a 4×2 grid with P.x = 0, 1, 2, 3 and N = I = −z; its Ci.
fn ci(source: &str, lights: &[&str]) -> Vec<f32> {
    let mut points = Points { nu: 4, nv: 2, orientation: 1.0, ..Points::default() };
    let row = |i: usize| i % 4;
    points.globals.push((
        "P",
        (0..24)
            .map(|i| {
                if i < 8 {
                    row(i) as f32
                } else if i < 16 {
                    (i % 8 / 4) as f32
                } else {
                    0.0
                }
            })
            .collect(),
    ));
    points.globals.push(("N", vec![0.0, 0.0, -1.0]));
    points.globals.push(("I", vec![0.0, 0.0, 1.0]));
    points.globals.push(("u", (0..8).map(|i| row(i) as f32 / 3.0).collect()));
    points.globals.push(("v", (0..8).map(|i| (i / 4) as f32).collect()));
    points.globals.push(("Cs", vec![1.0; 3]));
    points.globals.push(("Os", vec![1.0; 3]));
    points.globals.push(("Ci", vec![0.0; 3]));
    points.globals.push(("Oi", vec![1.0; 3]));
    let scene = Nothing(lights.iter().map(|l| bind(l)).collect());
    Machine::new().run(&bind(source), &mut points, &scene);
    let ci = points.get("Ci").unwrap();
    if ci.len() == 3 { vec![ci[0]; 4] } else { ci[..4].to_vec() }
}

#[test]
fn every_library_shader_compiles() {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shaders");
    let mut n = 0;
    for room in ["surface", "displacement", "light"] {
        for entry in std::fs::read_dir(root.join(room)).unwrap() {
            let path = entry.unwrap().path();
            let source = std::fs::read_to_string(&path).unwrap();
            let program = sl::compile(&path, &source).unwrap_or_else(|e| panic!("{e}"));
            assert_eq!(Some(program.name.as_str()), path.file_stem().and_then(|s| s.to_str()));
            n += 1;
        }
    }
    assert!(n >= 11);
}

#[test]
fn expressions_statements_and_functions() {
    let body = |b: &str| ci(&format!("surface t() {{ {b} }}"), &[]);
    assert_eq!(body("float x = xcomp(P); Ci = x * 2 + 1;"), [1.0, 3.0, 5.0, 7.0]);
    assert_eq!(body("float x = xcomp(P); if (x > 1.5) Ci = 1; else Ci = x;"), [0.0, 1.0, 1.0, 1.0]);
    assert_eq!(
        body("float s = 0; float i; for (i = 0; i < xcomp(P); i += 1) { if (i == 2) break; s += 1; } Ci = s;"),
        [0.0, 1.0, 2.0, 2.0]
    );
    assert_eq!(
        body("float s = 0; float i; for (i = 0; i < 4; i += 1) { if (i < xcomp(P)) continue; s += 1; } Ci = s;"),
        [4.0, 3.0, 2.0, 1.0]
    );
    assert_eq!(body("Ci = mod(xcomp(P) - 1, 2);"), [1.0, 0.0, 1.0, 0.0]);
    assert_eq!(body("Ci = (1, 2, 3) . (1, 1, 1) == 6 ? clamp(xcomp(P), 1, 2) : 9;"), [1.0, 1.0, 2.0, 2.0]);
    assert_eq!(body("Ci = Du(xcomp(P));")[1], 3.0);
    assert_eq!(body("vector n = calculatenormal(P); Ci = zcomp(n);")[0], 1.0);
    let sum = ci(
        "float twice(float x) { return 2 * x; } float f(float a, b) { return twice(a) + b; } surface t() { Ci = f(xcomp(P), 1); }",
        &[],
    );
    assert_eq!(sum, [1.0, 3.0, 5.0, 7.0]);
}

#[test]
fn lights_reach_surfaces() {
    let matte = include_str!("../../../shaders/surface/matte.sl");
    let sun = "light sun() { solar((0, 0, 1), 0) { Cl = 0.5; } }";
    let behind = "light behind() { solar((0, 0, -1), 0) { Cl = 8; } }";
    let all = "light all() { Cl = 0.25; }";
    assert_eq!(ci(matte, &[sun, behind, all]), [0.75; 4]);
    let lamp = "light lamp() { illuminate(point (0, 0, -1)) { Cl = 1 / (L . L); } }";
    let lit = ci(matte, &[lamp]);
    for (x, value) in lit.iter().enumerate() {
        // Lambert's cosine and the square of the distance.
        let d2 = 1.0 + (x * x) as f32;
        assert!((value - 1.0 / d2 / d2.sqrt()).abs() < 1e-6, "{lit:?}");
    }
    let shadowed = "light s() { solar((0, 0, 1), 0) { Cl = 1; Cl *= transmission(Ps, Ps - (0, 0, 1)); } }";
    assert_eq!(ci(matte, &[shadowed]), [1.0, 0.0, 0.0, 0.0]);
}

#[test]
fn faults_have_their_places() {
    let fault = |source: &str| {
        let e = sl::compile(Path::new("t.sl"), source).unwrap_err();
        (e.line, e.column, e.message)
    };
    assert_eq!(fault("surface t() {\n  Ci = Cz;\n}"), (2, 8, "unknown variable `Cz`, did you mean `Ci`?".into()));
    assert_eq!(fault("surface t() { Ci = 1 }"), (1, 22, "expected `;`, found `}`".into()));
    assert_eq!(
        fault("surface t() { uniform float x = xcomp(P); }").2,
        "a varying value cannot be assigned to the uniform variable `x`"
    );
    assert_eq!(fault("surface t() { Ci = normlize(N); }").2, "unknown function `normlize`, did you mean `normalize`?");
    assert_eq!(
        fault("float f(float x) { return f(x); } surface t() { Ci = f(1); }").2,
        "`f` calls itself: recursion is an error in the shading language"
    );
    assert_eq!(fault("surface t() { Ci = P; }").2, "expected color, found point");
    assert!(fault("surface t() { if (1) { Ci = 1; ").2.contains("end of the file"));
    assert_eq!(fault("  \n").2, "is empty, expected a shader");
}
