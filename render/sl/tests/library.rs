//! The shader library compiles, and shaders compute what they say.

use sl::Global;
use sl::machine::{BoundShader, Machine, Points, Scene, Segment, VariableSlots};
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
    fn transmission(&self, segments: &[Segment], light: &mut [[f32; 3]]) {
        // Everything above x = 0.5 of the target's way is in shadow.
        segments.iter().zip(light).for_each(|(s, light)| *light = if s.to[0] > 0.5 { [0.0; 3] } else { [1.0; 3] });
    }
}

fn bind(source: &str) -> Arc<BoundShader> {
    let program = sl::compile(Path::new("test.sl"), source).unwrap_or_else(|e| panic!("{e}"));
    Arc::new(BoundShader::new(Arc::new(program), vec![], vec![], &Nothing(vec![])))
}

/// Run a surface shader over a 4×2 grid with P.x = 0, 1, 2, 3 and N = I = −z; its Ci.
fn ci(source: &str, lights: &[&str]) -> Vec<f32> {
    let mut points = Points::new(4, 2, 1.0);
    let row = |i: usize| i % 4;
    points.set(
        Global::P,
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
    );
    points.set(Global::N, vec![0.0, 0.0, -1.0]);
    points.set(Global::I, vec![0.0, 0.0, 1.0]);
    points.set(Global::U, (0..8).map(|i| row(i) as f32 / 3.0).collect());
    points.set(Global::V, (0..8).map(|i| (i / 4) as f32).collect());
    points.set(Global::Cs, vec![1.0; 3]);
    points.set(Global::Os, vec![1.0; 3]);
    points.set(Global::Ci, vec![0.0; 3]);
    points.set(Global::Oi, vec![1.0; 3]);
    let scene = Nothing(lights.iter().map(|l| bind(l)).collect());
    Machine::new().run(&bind(source), &mut points, &scene);
    let ci = points.get(Global::Ci).unwrap();
    if ci.len() == 3 { vec![ci[0]; 4] } else { ci[..4].to_vec() }
}

#[test]
fn every_library_shader_compiles() {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shaders");
    let mut n = 0;
    for room in ["surface", "displacement", "light", "volume", "imager"] {
        for entry in std::fs::read_dir(root.join(room)).unwrap() {
            let path = entry.unwrap().path();
            let source = std::fs::read_to_string(&path).unwrap();
            let program = sl::compile_with(&path, &source, &|name, _| {
                let path = root.join("include").join(name);
                std::fs::read_to_string(&path).map(|text| (path, text)).map_err(|e| e.to_string())
            });
            let program = program.unwrap_or_else(|e| panic!("{e}"));
            assert_eq!(Some(program.name.as_str()), path.file_stem().and_then(|s| s.to_str()));
            n += 1;
        }
    }
    assert!(n >= 35);
}

#[test]
fn arrays_matrices_and_strings() {
    let body = |b: &str| ci(&format!("surface t() {{ {b} }}"), &[]);
    assert_eq!(body("float a[4] = {1, 2, 3, 4}; Ci = a[xcomp(P)];"), [1.0, 2.0, 3.0, 4.0]);
    assert_eq!(
        body("float a[4]; float i; for (i = 0; i < 4; i += 1) a[i] = i * i; Ci = a[3 - xcomp(P)];"),
        [9.0, 4.0, 1.0, 0.0]
    );
    assert_eq!(body("float a[3]; a[xcomp(P)] = 5; Ci = a[1];"), [0.0, 5.0, 0.0, 0.0]);
    assert_eq!(body("string a[2] = {\"x\", \"y\"}; Ci = a[1] == \"y\" ? 1 : 0;"), [1.0; 4]);
    assert_eq!(body("matrix m = translate(1, vector(1, 0, 0)); Ci = xcomp(transform(m, P));"), [1.0, 2.0, 3.0, 4.0]);
    assert_eq!(
        body("matrix m = rotate(1, 1.5707963, vector(0, 0, 1)); Ci = round(ycomp(vtransform(m, vector P)));"),
        [0.0, 1.0, 2.0, 3.0]
    );
    assert_eq!(body("matrix m = scale(1, vector(2, 3, 4)); Ci = determinant(m) + comp(m, 1, 1);"), [27.0; 4]);
    assert_eq!(body("matrix m = 2; matrix i = m / m; Ci = i == 1 ? 7 : 0;"), [7.0; 4]);
    assert_eq!(
        body("matrix m = (1,0,0,0, 0,1,0,0, 0,0,1,0, 5,6,7,1); Ci = comp(transform(m, point(0, 0, 0)), 1);"),
        [6.0; 4]
    );
    assert_eq!(body("color c = (1, 2, 3); setcomp(c, 1, 9); Ci = comp(c, 1) + c[2];"), [12.0; 4]);
    assert_eq!(
        body("Ci = match(\"gr.*\", concat(\"gra\", \"vel\")) + (format(\"%d\", 42) == \"42\" ? 1 : 0);"),
        [2.0; 4]
    );
    assert_eq!(
        body("Ci = comp(color \"hsv\" (1/3, 1, 1), 1) + comp(ctransform(\"hsv\", color(0, 0, 1)), 2);"),
        [2.0; 4]
    );
}

#[test]
fn control_flow_and_the_preprocessor() {
    let shader = |s: &str| ci(s, &[]);
    let early = "float f(float x) { if (x > 1.5) return 10; float i; for (i = 0; i < 3; i += 1) { if (i >= x) return i; } return 99; }
        surface t() { Ci = f(xcomp(P)); }";
    assert_eq!(shader(early), [0.0, 1.0, 10.0, 10.0]);
    let levels = "surface t() { float i, j, n = 0; for (i = 0; i < 3; i += 1) { for (j = 0; j < 3; j += 1) { if (j > xcomp(P)) break 2; n += 1; } } Ci = n; }";
    assert_eq!(shader(levels), [1.0, 2.0, 9.0, 9.0]);
    let macros = "#define SQUARE(x) ((x) * (x))\n#define N 3\n#if N > 2 && defined(SQUARE)\n#define M SQUARE(N)\n#else\n#define M 0\n#endif
        /* a comment\n that runs on */ surface t() { Ci = M + SQUARE(xcomp(P)); // done\n }";
    assert_eq!(shader(macros), [9.0, 10.0, 13.0, 18.0]);
    let inner =
        "surface t(float k = 3) { float twice(float x) { extern float k; return k * x; } Ci = twice(xcomp(P)); }";
    assert_eq!(shader(inner), [0.0, 3.0, 6.0, 9.0]);
    let outputs = "void g(float x; output float y; output color c) { y = x + 1; c = color(x, x, x); }
        surface t() { float y; color c; g(xcomp(P), y, c); Ci = y + c; }";
    assert_eq!(shader(outputs), [1.0, 3.0, 5.0, 7.0]);
}

#[test]
fn known_answers_of_functions() {
    let body = |b: &str| ci(&format!("surface t() {{ {b} }}"), &[]);
    let near = |a: Vec<f32>, b: [f32; 4]| assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-4), "{a:?} {b:?}");
    near(body("Ci = spline(0.25, 0, 1, 4, 9, 16);"), [2.25; 4]);
    near(body("float k[5] = {0, 1, 4, 9, 16}; Ci = spline(\"linear\", 0.75, k);"), [6.5; 4]);
    near(body("float kr, kt; fresnel(vector(0,0,1), normal(0,0,-1), 1/1.5, kr, kt); Ci = kr;"), [0.04; 4]);
    near(body("Ci = ptlined(point(0,0,0), point(3,0,0), P + vector(0, 2, 0) * (1 - ycomp(P)));"), [2.0; 4]);
    near(body("Ci = ycomp(rotate(P, 1.5707963, point(0,0,0), point(0,0,1)));"), [0.0, 1.0, 2.0, 3.0]);
    near(body("Ci = filterstep(1.5, xcomp(P));"), [0.0, 0.0, 1.0, 1.0]);
    near(body("Ci = pnoise(xcomp(P) * 0.3, 2) - pnoise(xcomp(P) * 0.3 + 4, 2);"), [0.0; 4]);
    near(body("Ci = snoise(P * 0.37) - (2 * noise(P * 0.37) - 1);"), [0.0; 4]);
    near(body("Ci = log(8, 2);"), [3.0; 4]);
    near(body("Ci = mod(-1, 3) + clamp(5, 0, 2) + smoothstep(0, 1, 0.5) + max(1, 4, 2);"), [8.5; 4]);
    near(body("Ci = Du(xcomp(P));"), [3.0; 4]);
    near(body("Ci = area(P);"), [1.0; 4]);
}

#[test]
fn three_lights_against_the_closed_form() {
    // Suns with known directions on a surface whose normal is −z: the sum of Cl max(0, n · l).
    let suns = [([0.0, 0.0, 1.0], 0.5), ([3.0, 0.0, 4.0], 1.5), ([0.0, 1.0, -1.0], 9.0)];
    let lights: Vec<String> = suns
        .iter()
        .map(|(d, c)| format!("light l() {{ solar(vector({}, {}, {}), 0) {{ Cl = {c}; }} }}", d[0], d[1], d[2]))
        .collect();
    let lights: Vec<&str> = lights.iter().map(String::as_str).collect();
    let expected = 0.5 + 1.5 * 0.8;
    let loops = "surface t() { illuminance(P, N, PI / 2) { Ci += Cl * (normalize(L) . normalize(N)); } }";
    for source in [loops, "surface t() { Ci = diffuse(normalize(N)); }"] {
        let found = ci(source, &lights);
        assert!(found.iter().all(|x| (x - expected).abs() < 1e-6), "{source}: {found:?}, expected {expected}");
    }
}

#[test]
fn the_normal_of_a_displaced_sphere() {
    // r = 1 + 0.2 z on the unit sphere: n ∝ r r̂ − (dr/dθ) θ̂.
    const N: usize = 33;
    let angle = |k: usize| 0.6 + 1.2 * k as f32 / (N - 1) as f32;
    let mut place = vec![0.0; 3 * N * N];
    for k in 0..N * N {
        let (around, theta) = (angle(k % N), angle(k / N));
        let p = [theta.sin() * around.cos(), theta.sin() * around.sin(), theta.cos()];
        (0..3).for_each(|c| place[c * N * N + k] = p[c]);
    }
    let mut points = Points::new(N, N, -1.0);
    points.set(Global::P, place.clone());
    points.set(Global::N, place);
    let shader = bind("displacement d() { P += 0.2 * zcomp(P) * normalize(N); N = calculatenormal(P); }");
    Machine::new().run(&shader, &mut points, &Nothing(vec![]));
    let n = points.get(Global::N).unwrap();
    for k in (0..N * N).filter(|k| (1..N - 1).contains(&(k % N)) && (1..N - 1).contains(&(k / N))) {
        let (around, theta) = (angle(k % N), angle(k / N));
        let (r, slope) = (1.0 + 0.2 * theta.cos(), -0.2 * theta.sin());
        let out = [theta.sin() * around.cos(), theta.sin() * around.sin(), theta.cos()];
        let down = [theta.cos() * around.cos(), theta.cos() * around.sin(), -theta.sin()];
        let exact = [0, 1, 2].map(|c| r * out[c] - slope * down[c]);
        let own = [0, 1, 2].map(|c| n[c * N * N + k]);
        let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let cosine = dot(exact, own) / (dot(exact, exact) * dot(own, own)).sqrt();
        assert!(cosine > 0.99999, "at {k}: {own:?}, expected along {exact:?}");
    }
}

#[test]
fn lights_have_categories_and_messages() {
    let near_light = "light a(string __category = \"key,warm\"; float __nondiffuse = 0; output float power = 5;) { illuminate(point(0, 0, -1)) { Cl = 1; power = 7; } }";
    let far_light =
        "light b(string __category = \"fill\"; float __nondiffuse = 1;) { solar(vector(0, 0, 1), 0) { Cl = 3; } }";
    let lights = &[near_light, far_light];
    let body = |b: &str| ci(&format!("surface t() {{ {b} }}"), lights)[0];
    assert_eq!(body("illuminance(\"key\", P) { Ci += Cl; }"), 1.0);
    assert_eq!(body("illuminance(\"-key\", P) { Ci += Cl; }"), 3.0);
    assert_eq!(body("illuminance(P) { Ci += Cl; }"), 4.0);
    assert_eq!(body("illuminance(\"key\", P) { float p = 0; lightsource(\"power\", p); Ci += p; }"), 7.0);
    assert_eq!(body("float p = 0; illuminance(\"key\", P, \"light:power\", p) { Ci += p; }"), 7.0);
    // A loop in a loop, there or in a function, leaves the light of the outer one as it was.
    let inner = "color inner() { color sum = 0; illuminance(P) { sum += Cl; } return sum; }";
    for nested in ["float n = 0; illuminance(P) { n += 1; }", "color n = inner();", "color n = diffuse(N);"] {
        let shader = format!(
            "{inner} surface t() {{ illuminance(P) {{ color before = Cl; vector way = L; {nested} if (Cl == before && L == way) Ci += Cl; }} }}"
        );
        assert_eq!(ci(&shader.replace("(P)", "(point(0, 0, 0))"), lights)[0], 4.0, "{nested}");
    }
    // The fill light gives no diffuse light, and the key light stands straight above the first point.
    assert_eq!(body("Ci = diffuse(N);"), 1.0);
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

#[test]
fn primitive_variables_go_before_parameters() {
    let shader = bind(
        "surface s(float a = 0.1; float b = 0.2; string c = \"c\"; float d[2] = {3, 4}) { Ci = color(a, b, d[1]); }",
    );
    // Of two variables of a name the first counts; what no parameter is named as is passed over, as are numbers for texts.
    let names = [("other", 1), ("b", 1), ("c", 1), ("d", 2), ("b", 1)].map(|(name, width)| (name.to_string(), width));
    let slots = VariableSlots::of(&shader.program, &names);
    let mut points = Points::new(2, 1, 1.0);
    points.set(Global::Ci, vec![0.0; 3]);
    let mut run = |values: &[&[f32]]| {
        points.clear_variables();
        values.iter().for_each(|v| points.next_variable().extend_from_slice(v));
        Machine::new().run_with(&shader, &slots, &mut points, &Nothing(vec![]));
        points.get(Global::Ci).unwrap().to_vec()
    };
    let all: [&[f32]; 5] = [&[9.0], &[0.5, 0.6], &[7.0], &[5.0, 6.0], &[8.0]];
    assert_eq!(run(&all), [0.1, 0.1, 0.5, 0.6, 6.0, 6.0]);
    // A slot without values leaves the parameter its own; nothing of the last points is left.
    assert_eq!(run(&all[..1]), [0.1, 0.2, 4.0]);
    assert_eq!(VariableSlots::of(&shader.program, &names[..1]), VariableSlots::default());
    // Nor does a parameter take what has other numbers.
    let others = [("a", 3), ("b", 1), ("c", 3), ("d", 3)].map(|(name, width)| (name.to_string(), width));
    let misfits: Vec<_> = VariableSlots::misfits(&shader.program, &others).collect();
    assert_eq!(misfits, [("a", 3, Some(1)), ("c", 3, None), ("d", 3, Some(2))]);
    assert_eq!(VariableSlots::of(&shader.program, &others[2..]), VariableSlots::default());
}
