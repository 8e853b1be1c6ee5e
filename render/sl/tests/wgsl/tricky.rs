//! Shaders that try what is hard for a kernel: control flow around derivatives, loops that are left from deep within, arrays, strings,
//! lights within lights; and what is found wrong at run time.

use crate::compare::{compare, compare_grids, host, points};
use crate::world::{World, bind, program};
use sl::Global;
use sl::ir::Ask;
use sl::machine::{BoundShader, Lights, Message, Points, VariableSlots};
use sl::wgsl::{Batch, Fault, Host, Kernel};
use std::path::Path;
use std::sync::Arc;

/// A surface's body, between functions and the end of the file.
fn surface(functions: &str, body: &str) -> Arc<BoundShader> {
    let rgb = "color rgb(vector v) { return color(xcomp(v), ycomp(v), zcomp(v)); }";
    bind(&format!(
        "{rgb} {functions} surface t(float Km = 0.3; string mode = \"b\"; color tints[3] = {{1, 0.5, 0.25}};) {{ {body} }}"
    ))
}

const LIGHTS: [&str; 4] = [
    "light a(string __category = \"key\"; output float power = 5; float twice = 2;) {
        illuminate(point(0.3, 0.2, -2)) { Cl = color(1, 0.9, 0.8); power = 7 + xcomp(L); }
    }",
    "light b(string __category = \"fill,soft\";) { solar(vector(0.1, 0.3, 1), 0) { Cl = 0.5; } }",
    "light c(float ripples = 9;) {
        illuminate(point(-1, 0.5, -1.5), vector(0.3, 0, 1), 0.9) {
            float i, sum = 0;
            for (i = 0; i < 4; i += 1) { if (i > 2 + xcomp(Ps)) break; sum += noise(ripples * Ps + i); }
            Cl = sum / 4;
        }
    }",
    "light d() { Cl = 0.1 + 0.1 * noise(4 * Ps); }",
];

fn world(lights: &[&str]) -> World {
    World { lights: lights.iter().map(|l| bind(l)).collect(), ..World::default() }
}

/// What is wrong with a shader's kernel.
fn wrong(shader: &Arc<BoundShader>, world: &World) -> Option<String> {
    match compare(shader, world) {
        Err(why) => Some(why.to_string()),
        Ok(Some(found)) if found.difference > 1e-4 || !found.faults.is_empty() => {
            Some(format!("{} {:?} {}", found.difference, found.faults, found.place))
        }
        Ok(_) => None,
    }
}

fn holds(name: &str, shader: &Arc<BoundShader>, world: &World) {
    assert_eq!(wrong(shader, world), None, "{name}");
}

/// Shaders by what they try: functions, body.
const SHADERS: &[(&str, &str, &str)] = &[
    ("derivatives in a condition", "", "if (s > 0.7) { Ci = Du(s * s) + filterwidth(t * s); } else { Ci = rgb(Dv(P)); }"),
    (
        "derivatives of a variable set in a condition",
        "",
        "float x = s; if (t > 0.1) x = s * t; else { if (s > 0.9) x = 2 * s; } Ci = color(Du(x), Dv(x), filterwidth(x));",
    ),
    (
        "derivatives in a loop whose turns differ",
        "",
        "float i, x = 0; for (i = 0; i < 1 + 5 * s; i += 1) { x += filterwidth(s * i) + noise(P * i); if (x > 1.9) break; } Ci = x;",
    ),
    (
        "continue around derivatives",
        "",
        "float i, x = 0; for (i = 0; i < 6; i += 1) { if (mod(floor(9 * s), 3) == mod(i, 3)) continue; x += Du(s * i) * t; } Ci = x;",
    ),
    (
        "two loops left at once around derivatives",
        "",
        "float i, j, x = 0; for (i = 0; i < 4; i += 1) { for (j = 0; j < 4; j += 1) { if (i * j > 5 * s) break 2; if (j > 3 * t + 2) continue 2; x += filterwidth(s * j) + 0.1; } x += 1; } Ci = x;",
    ),
    (
        "two loops left at once",
        "",
        "float i, j, x = 0; for (i = 0; i < 4; i += 1) { for (j = 0; j < 4; j += 1) { if (i * j > 5 * s) break 2; if (j > 3 * t + 1) continue 2; x += 1; } x += 10; } Ci = x;",
    ),
    (
        "a function that returns early, from loops",
        "float f(float x) { float i, j; for (i = 0; i < 5; i += 1) { for (j = 0; j < 5; j += 1) { if (i + j > 6 * x) return i * 10 + j; } if (x < 0.3) return -i; } return 99; }",
        "Ci = color(f(s), f(t), f(s * t));",
    ),
    (
        "a function that returns early, with derivatives",
        "float f(float x) { float i; if (x < 0.4) return filterwidth(x); for (i = 0; i < 5; i += 1) { if (i > 4 * x) return i + Du(x * i); } return 99 + Dv(x); }",
        "Ci = color(f(s), f(t), s > 0.5 ? f(s * t) : 3);",
    ),
    (
        "functions within functions, with outputs",
        "void g(float x; output float y; output color c) { y = x + 1; if (x > 0.6) { c = color(x, 0, 1); return; } c = color(x, x, x); }
         float h(float x) { float y; color c; g(x, y, c); return y * comp(c, 0); }",
        "float y; color c; g(s, y, c); Ci = y + c + h(t);",
    ),
    ("the area and normal of moved points", "", "if (s > 0.2) P += 0.1 * noise(5 * P) * normalize(N); N = calculatenormal(P); Ci = area(P) * 10;"),
    ("an array by index", "", "float a[5] = {1, 2, 4, 8, 16}; float i; for (i = 0; i < 5; i += 1) { if (s > 0.5) a[i] = a[4 - i] + t; } Ci = color(a[floor(4.99 * u)], a[2], a[4 * v]);"),
    ("an array of triples", "", "color c[4]; float i; for (i = 0; i < 4; i += 1) c[i] = color(i, s, t) * tints[mod(i, 3)]; Ci = c[floor(3.99 * v)];"),
    ("strings that parameters decide", "", "if (mode == \"a\") Ci = texture(\"none\"); else if (mode == \"b\") Ci = rgb(transform(\"shader\", P)); else printf(\"no\");"),
    ("strings made of others", "", "string space = concat(\"obj\", \"ect\"); if (match(\"^ob\", space)) Ci = rgb(vtransform(space, vector P)); else Ci = rgb(ntransform(\"camera\", N));"),
    (
        "matrices",
        "",
        "matrix m = rotate(translate(1, vector(s, 0, t)), 0.7 + s, vector(1, 2, 0.5)); matrix k = m * scale(1, vector(1, 2, 3)); matrix q = m / k;
         Ci = rgb(transform(q, P)) + rgb(vtransform(k, vector N)) + rgb(ntransform(m, N)) + determinant(k) + comp(q, 1, 2); setcomp(m, 0, 1, s); Ci += comp(m, 0, 1) + (m == k ? 1 : 0);",
    ),
    ("a matrix of a space", "", "matrix m = mtransform(\"shader\", matrix 2); Ci = rgb(transform(m, P)) + comp(mtransform(\"object\", m), 3, 1);"),
    ("mixed matrices", "", "matrix a = 2; matrix b = (1,2,3,4,5,6,7,8,9,1,2,3,4,5,6,8); Ci = comp(mix(a, b, s), 2, 1) + comp(s > 0.5 ? a : b, 1, 1);"),
    (
        "noise of all kinds",
        "",
        "point q = P * 7.3; float f = noise(q) + noise(9 * s) + noise(8 * s, 7 * t) + noise(q, 3 * s) + cellnoise(q) + cellnoise(q, 4 * t) + snoise(q) + pnoise(q, point(2, 3, 4)) + pnoise(9 * s, 3) + pnoise(9 * s, 8 * t, 3, 4) + pnoise(q, 5 * s, point(2, 3, 4), 2);
         color c = noise(q) ; vector w = noise(q, 3 * t); c += cellnoise(q) + pnoise(q, point(3, 2, 5)); Ci = f + c + color(xcomp(w), ycomp(w), zcomp(w));",
    ),
    ("noise of negative and large places", "", "Ci = noise(-31.7 * P + point(1000.3, -2000.7, 55.5)) + cellnoise(P * 100 - 5000);"),
    ("random numbers in loops", "", "float i, x = 0; for (i = 0; i < 3; i += 1) { x += random(); if (s > 0.5) { float j; for (j = 0; j < 2; j += 1) x += random(); } } color c = random(); Ci = x + c; uniform float g = random(); Ci += g;"),
    ("angles", "", "float x = 20 * s - 9; Ci = color(sin(x) + cos(3 * x), tan(0.1 * x), sin(43758.5 * s)) + color(asin(t), acos(t), atan(x)) + atan(t, x) + atan(-s, -t) + asin(5) + acos(-7);"),
    ("powers and logarithms", "", "Ci = color(pow(s, 3.3), pow(-s, 3) + pow(-s, 2) + pow(-s, 0.5), exp(2 * t)) + log(s) + log(s, 10) + log(-1) * 0.001 + sqrt(t) + inversesqrt(s) + pow(0, 2) + pow(0, 0) + mod(-3.3 * s, 1.1) + mod(1, 0) + 1 / 0;"),
    ("rounding", "", "Ci = color(round(9 * s), floor(-9 * s), ceil(7 * t)) + sign(t) + abs(t) + round(2.5) + round(-0.5) + step(0.3, s) + smoothstep(0.2, 0.8, s) + clamp(3 * s, 0.5, 1) + min(s, t, 0.2) + max(s, t);"),
    ("conditions of all kinds", "", "Ci = color((s > 0.5 && t < 0.2) ? 1 : 2, (s <= 0.4 || t >= 0.1) ? 3 : 4, (!(s == t) && s != 0) ? 5 : 6);"),
    ("colours", "", "Ci = ctransform(\"hsv\", color(s, t, 0.4)) + ctransform(\"hsl\", \"rgb\", color(s, 0.7, 0.4)) + color \"YIQ\" (0.5, 0.1 * s, t) + color \"xyY\" (0.3, 0.3, s) + ctransform(\"XYZ\", Cs) + 0.1 * ctransform(\"YIQ\", Cs) + color \"hsv\" (s * 3, 0.5, 0.5);"),
    ("splines", "", "float k[6] = {0, 1, 4, 9, 16, 3}; Ci = spline(s, color(1, 0, 0), color(0, s, 0), color(0, 0, 1), color(t, 1, 1), color(0, 1, 0)) + spline(\"bezier\", t, 0, 1, 4, 9, 3, 2, 1) + spline(\"linear\", s, k) + spline(\"bspline\", s, k) + spline(\"solvecatmull-rom\", 2 + s, 0, 1, 4, 9, 16);"),
    ("reflection and refraction", "", "vector i = normalize(I); normal n = normalize(N); float kr, kt; vector r, q; fresnel(i, n, 1 / 1.5, kr, kt, r, q); Ci = kr + kt * color(xcomp(r), ycomp(q), zcomp(refract(i, n, 1.4))) + length(i ^ n) + rgb(rotate(P, s, point(0, 0, 1), point(1, 1, 0))) + ptlined(point(0, 0, 0), point(1, 1, 1), P);"),
    ("components", "", "color c = Cs; setcomp(c, floor(2.9 * u), 7); Ci = c + comp(c, floor(2.9 * v)) + xcomp(P) - zcomp(N) + c[1]; "),
    ("the light of all lights", "", "normal n = faceforward(normalize(N), I); Ci = ambient() + diffuse(n) + specular(n, -normalize(I), 0.1) + phong(n, -normalize(I), 12);"),
    ("categories of lights", "", "illuminance(\"key\", P) { Ci += Cl; } illuminance(\"-key\", P) { Ci += 0.5 * Cl; } illuminance(\"soft\", P, -N, 1.3) { Ci += normalize(L) . normalize(N); }"),
    (
        "messages of lights",
        "",
        "illuminance(P) { float p = 0, q = 9, r = 1; if (lightsource(\"power\", p) == 1) Ci += p * Cl; r = lightsource(\"ripples\", q); Ci += 0.01 * q + r; } float p = 3; illuminance(P, -N, 1.5, \"light:power\", p) { Ci += p; } Ci += lightsource(\"power\", p);",
    ),
    (
        "lights within lights",
        "",
        "illuminance(P) { color outer = Cl; float w = 0; lightsource(\"twice\", w); color inner = 0; illuminance(\"fill\", P) { inner += Cl; float v = 1; lightsource(\"twice\", v); inner += v; } lightsource(\"twice\", w); Ci += outer * inner * (1 + w); }",
    ),
    (
        "a loop left from within the lights",
        "",
        "float i; for (i = 0; i < 5; i += 1) { illuminance(P) { Ci += Cl * 0.1; if (comp(Ci, 0) > 0.3 * s) break; } Ci += 0.01; }",
    ),
    ("a loop over lights that is left", "", "float n = 0; illuminance(P) { n += 1; if (n > 1 + 2 * s) break; Ci += Cl; } Ci += n;"),
    ("lights that are gone on from", "", "illuminance(P) { if (comp(Cl, 0) > 0.2 + 0.3 * s) continue; float i; for (i = 0; i < 3; i += 1) { if (i > 2 * t) break 2; Ci += Cl; } Ci += 0.1; }"),
    ("a loop over lights that is left, with derivatives", "", "float n = 0; illuminance(P) { n += 1 + filterwidth(s); if (n > 1 + 2 * s) break; if (t < 0.3) continue; Ci += Cl * filterwidth(t); } Ci += n;"),
    ("components by index", "", "float i = clamp(floor(3 * s), 0, 2), j = clamp(floor(3 * t), 0, 2); vector v = P; v[i] = 5; setcomp(v, j, 2); Ci = rgb(v) + comp(v, i);"),
    ("normals turned to the eye", "", "Ci = rgb(faceforward(normalize(N), I)) + rgb(faceforward(N, I, vector(s - 0.5, t, 1)));"),
    ("lights among lights", "color inner(point p) { color sum = 0; illuminance(p) { sum += Cl; } return sum; }", "illuminance(P) { if (s > 0.3) Ci += 0.1 * inner(P); Ci += Cl * abs(normalize(L) . N); }"),
    ("derivatives among lights", "", "illuminance(P) { Ci += Cl * filterwidth(s) + Du(xcomp(L)); if (s > 0.5) Ci += filterwidth(comp(Ci, 0)); }"),
    (
        "derivatives among lights in a loop that is left",
        "",
        "float i; for (i = 0; i < 3; i += 1) { illuminance(P) { Ci += Cl * 0.3 + filterwidth(s); if (comp(Ci, 0) > s) break; Ci += 0.001; } Ci += Dv(t); }",
    ),
    ("what is asked by name", "", "uniform float clip[2] = {0, 1}; float rate = 7, depth = 5; if (option(\"Clipping\", clip) == 1) Ci = clip[0] + 0.1 * clip[1]; string name = \"none\"; attribute(\"identifier:name\", name); if (name == \"pebble\") Ci += 2; Ci += attribute(\"ShadingRate\", rate) + rate + attribute(\"unknown\", rate); rayinfo(\"depth\", depth); Ci += depth + depth(P) + surface(\"Km\", rate) + rate;"),
    ("time", "", "Ci = time + 10 * dtime + ncomps;"),
    ("rays", "", "Ci = occlusion(P, N, 32) + transmission(P, P + N) + float trace(P, N) + rgb(openness(P, N, vector(0, 0, 1))) + comp(surroundings(P, N, vector(0, 0, 1), vector(0, 1, 1)), 0, 2);"),
    ("rays in a condition with derivatives", "", "if (s > 0.4) { Ci = occlusion(P, N, 8) * filterwidth(s) + transmission(P, P + 2 * N); }"),
    ("texture maps", "", "Ci = texture(\"a.tx\") + color texture(\"wood\"[1], 2 * s, t * s, \"blur\", 0.1 * s, \"swidth\", 2, \"tblur\", 0.3, \"fill\", t) + float texture(\"a.tx\", s, t, s + 0.1, t, s, t + 0.2, s + 0.1, t + 0.3);"),
    ("texture maps in conditions", "", "if (s > 0.5) { float i; for (i = 0; i < 3 * t + 1; i += 1) Ci += texture(\"wood\", s * i, t); } else Ci = environment(\"sky\", N, \"width\", 2) * float shadow(\"sun.sm\", P, \"samples\", 4, \"bias\", 0.1);"),
    ("a loop over rays", "", "float far = 0; vector w = 0; gather(\"\", P, N, 0.4, 5, \"ray:length\", far, \"ray:direction\", w) { Ci += 0.1 * far + rgb(w); } else { Ci += 0.01 + random() * 0.1; if (s > 0.6) Ci += 0.3; }"),
    ("a loop over rays beside derivatives", "", "if (t > 0) { gather(\"\", P, -N, 1.2, 3) { Ci += 0.1; } } Ci += Du(comp(Ci, 0));"),
    ("words that WGSL keeps", "float let(float var) { return var * 2; }", "float fn = 1, loop = 2, vec3 = 3, ptr = s; float work = let(fn + loop), point_ = 1, on = 3, base = 4, lights = 5; Ci = work * vec3 + ptr + point_ + on + base + lights;"),
    ("swapped variables in loops", "", "float a = s, b = t, i; for (i = 0; i < 3; i += 1) { float c = a; a = b + 0.1 * i; b = c; if (a > b) { float d = a; a = b; b = d; } } Ci = color(a, b, a - b);"),
    ("while", "", "float x = s, n = 0; while (x < 10) { x = x * 1.7 + 0.1; n += 1; if (n > 30) break; } Ci = n + x * 0.1;"),
    ("declared in a loop with derivatives", "", "float i, sum = 0; for (i = 0; i < 3; i += 1) { if (s > 0.2 * i) { float x = s * (i + 1); if (t > 0) x += t; sum += filterwidth(x); } } Ci = sum;"),
];

#[test]
fn what_is_hard_is_the_same_on_a_device() {
    let world = world(&LIGHTS);
    let wrong = |(name, functions, body): &(&str, &str, &str)| {
        wrong(&surface(functions, body), &world).map(|what| format!("{name}: {what}\n"))
    };
    let found: String = SHADERS.iter().filter_map(wrong).collect();
    assert!(found.is_empty(), "{found}");
}

#[test]
fn lights_ask_the_scene_and_know_the_eye() {
    let asks = "light asks() { solar(vector(0.2, 0.4, 1), 0) { float dim = 7; if (xcomp(Ps) > 0) option(\"user:dim\", dim); Cl = 0.1 * dim; } }";
    let eye = "light eye() { solar(vector(0.2, 0.4, 1), 0) { Cl = 0.1 * abs(color(E)); } }";
    for light in [asks, eye] {
        holds(light, &surface("", "illuminance(P) { Ci += Cl; }"), &world(&[light]));
    }
}

#[test]
fn lights_look_up_maps() {
    let slide = "light slide() { illuminate(point(0.2, 0, -3)) { Cl = texture(\"slide\", xcomp(Ps), ycomp(Ps)) * (1 - shadow(\"s.sm\", Ps)); } }";
    let sky = "light sky() { solar(vector(0.2, 0.4, 1), 0) { Cl = 0.1 + 0.1 * environment(\"sky\", L) + 0.01 * float shadow(\"raytrace\", Ps); } }";
    let lit = world(&[slide, sky]);
    holds("maps in lights", &surface("", "illuminance(P) { Ci += Cl; }"), &lit);
}

#[test]
fn lights_that_look_at_neighbours() {
    let strip = "light strip() { illuminate(point(0.2, 0, -3), vector(0, 0, 1), 0.4) { float w = filterwidth(xcomp(Ps)); if (xcomp(Ps) > 0) w += Du(ycomp(Ps) * 3); Cl = 0.5 + w; } }";
    let glow = "light glow() { Cl = 0.1 + filterwidth(ycomp(Ps)); }";
    let lit = world(&[LIGHTS[0], strip, LIGHTS[3], glow]);
    let lambert = surface("", "normal n = faceforward(normalize(N), I); Ci = diffuse(n);");
    holds("from a surface that does not", &lambert, &lit);
    let conditional = surface(
        "",
        "if (s > 0.6) { Ci = diffuse(normalize(N)) + ambient(); } else { illuminance(P) { if (t > 0) Ci += Cl; } } float i; for (i = 0; i < 2 + s; i += 1) { illuminance(P) { Ci += Cl * 0.1; if (comp(Ci, 0) > 0.8) break; } }",
    );
    holds("in conditions and loops", &conditional, &lit);
}

#[test]
fn other_kinds_of_shaders() {
    let none = world(&[]);
    for (name, source) in [
        (
            "displacement",
            "displacement d(output float height = 0;) { height = noise(4 * P); P += 0.2 * height * normalize(N); N = calculatenormal(P); }",
        ),
        (
            "volume",
            "volume v(float density = 0.3;) { float k = 1 - exp(-density * length(I)); Ci = mix(Ci, color(0.5, 0.6, 0.7), k); Oi = mix(Oi, color(1, 1, 1), k); }",
        ),
        ("imager", "imager i() { Ci += (1 - alpha) * color(0.1, 0.2, 0.3); Oi = 1; alpha = 1; }"),
    ] {
        holds(name, &bind(source), &none);
    }
}

/// Constants beyond the numbers that there are, which WGSL would refuse to work out.
#[test]
fn constants_that_are_infinite_are_the_largest_number() {
    let body = "float most = 1e30 * 1e30, least = -1e38 * 10 - 1e38, e = exp(100); Ci = color(min(most, u), max(least, v), min(e, 2));";
    let found = compare(&surface("", body), &world(&LIGHTS)).unwrap_or_else(|why| panic!("{why}"));
    assert!(found.is_some_and(|found| found.difference <= 1e-4));
}

/// Of an array of strings each has its own, given or by default.
#[test]
fn strings_of_arrays_are_known() {
    let source = "surface t(string names[3] = {\"a\", \"b\", \"c\"}; string others[2] = {\"d\", \"e\"};) {
        Ci = color(names[0] == \"x\" ? 0.2 : 0.1, names[1] == \"y\" ? u : 0, names[2] == \"\" ? v : 0);
        if (others[1] == \"e\") Ci += 0.3;
    }";
    let program = Arc::new(program(Path::new("test.sl"), source).unwrap());
    let given = BoundShader::given(program, vec![], vec![(0, vec!["x".into(), "y".into()])]);
    let found = compare(&Arc::new(given), &world(&LIGHTS)).unwrap_or_else(|why| panic!("{why}"));
    assert!(found.is_some_and(|found| found.difference <= 1e-4));
}

#[test]
fn what_is_given_goes_before_defaults() {
    let source = "surface t(float a = 0.1; float b = sqrt(2) + 1; color c = color(0.1, 0.2, 0.3); float d[2] = {3, 4}; string e = \"object\";) {
        float h = 9, k = 9; displacement(\"height\", h); displacement(\"unknown\", k);
        Ci = color(a, b, d[1]) + c * h + k + xcomp(transform(e, P)) + d[floor(1.9 * u)];
    }";
    let program = Arc::new(program(Path::new("test.sl"), source).unwrap());
    // Defaults that are not computed when the shader is bound are computed where it runs.
    let given = BoundShader::given(program.clone(), vec![(0, vec![0.7])], vec![(4, vec!["shader".into()])]);
    let names = [("other", 1), ("b", 1), ("d", 2), ("c", 3)].map(|(name, width)| (name.to_string(), width));
    let slots = VariableSlots::of(&program, &names);
    let n = points().n();
    let varying = |width: usize| (0..width * n).map(|k| 0.01 * k as f32).collect::<Vec<f32>>();
    for variables in [
        vec![vec![5.0], varying(1), varying(2), vec![0.5, 0.6, 0.7]],
        vec![vec![5.0], vec![0.25], vec![7.0, 8.0], varying(3)],
        vec![vec![5.0]],
    ] {
        let mut grid = points();
        variables.into_iter().for_each(|v| *grid.next_variable() = v);
        grid.messages.push(Message { from: Ask::Displacement, name: "height".into(), values: varying(1) });
        let found = compare_grids(&Arc::new(given.clone()), &slots, vec![grid, points()], &world(&LIGHTS)).unwrap();
        if let Some(found) = found {
            assert!(found.difference <= 1e-4 && found.faults.is_empty(), "{} {:?}", found.place, found.faults);
        }
    }
}

#[test]
fn a_grid_that_is_too_large_is_refused() {
    let large = || {
        let mut points = Points::new(20, 15, 1.0);
        points.set(Global::S, (0..300).map(|k| k as f32).collect());
        points.set(Global::Ci, vec![0.0; 3]);
        vec![points]
    };
    let compared = |body: &str| compare_grids(&surface("", body), &VariableSlots::default(), large(), &world(&[]));
    let why = compared("Ci = filterwidth(s);").err().expect("it is refused").to_string();
    assert!(why.contains("300 points, more than 256"), "{why}");
    if let Some(found) = compared("Ci = 2 * s;").unwrap() {
        assert!(found.difference == 0.0, "points that run alone may be any number: {}", found.place);
    }
}

#[test]
fn a_kernel_is_not_used_where_the_scene_answers_by_other_strings() {
    let shader =
        surface("", "string name = \"none\"; attribute(\"identifier:name\", name); if (name == \"pebble\") Ci = 1;");
    let world = world(&[]);
    let kernel = Kernel::new(&shader, &[], host(&world)).unwrap();
    let nameless = Lights(vec![]);
    let mut batch = Batch::new(&kernel, &[], &nameless).unwrap();
    let slots = VariableSlots::default();
    assert_eq!(batch.add(&shader, &slots, &points(), &world), Ok(0));
    let why = batch.add(&shader, &slots, &points(), &nameless).expect_err("it is refused").to_string();
    assert!(why.contains("`identifier:name`"), "{why}");
}

#[test]
fn an_index_outside_is_told_of() {
    let shader = surface("", "float a[3] = {1, 2, 3};\nCi = a[9 * s]; a[2 - 9 * s] = 4; Ci += a[2];");
    let world = world(&[]);
    let Some(found) = compare(&shader, &world).unwrap() else { return };
    assert!(found.difference <= 1e-4, "{}", found.place);
    let [Fault::Outside(name, place)] = &found.faults[..] else { panic!("{:?}", found.faults) };
    assert!(name == "t" && place.contains("test.sl:2"), "{place}");
    assert!(world.warnings.lock().unwrap().iter().any(|w| w.contains("test.sl:2")));
}

#[test]
fn a_loop_without_an_end_is_told_of() {
    for body in [
        "float x = s;\nwhile (x > -5) { x += 1; } Ci = x;",
        "float x = s;\nwhile (x > -5) { x += filterwidth(s); } Ci = x;",
    ] {
        let shader = surface("", body);
        let Some(found) = compare(&shader, &world(&[])).unwrap() else { return };
        let [Fault::Endless(name, place)] = &found.faults[..] else { panic!("{:?}", found.faults) };
        assert!(name == "t" && place.contains("test.sl:2"), "{place}");
    }
}

#[test]
fn what_has_no_kernel_is_named() {
    let refused = |source: &str, lights: &[&str]| {
        compare(&bind(source), &world(lights)).err().expect("it is refused").to_string()
    };
    let body = |b: &str| refused(&format!("surface t() {{ {b} }}"), &[]);
    let alone = World::default();
    let without = |source: &str| {
        let host = Host { functions: &[], ..host(&alone) };
        Kernel::new(&bind(source), &[], host).expect_err("it is refused").to_string()
    };
    assert_eq!(
        without("surface t() { Ci = texture(\"wood.tex\"); }"),
        "the shader `t` looks up the texture map `wood.tex`, which is not built for graphics devices"
    );
    assert!(body("Ci = trace(P, N);").contains("colours of rays by `trace`"));
    assert!(without("surface t() { gather(\"\", P, N, 1, 4) { Ci += 1; } }").contains("gathers rays"));
    assert!(without("surface t() { Ci = occlusion(P, N, 4); }").contains("calls `occlusion`"));
    assert!(without("surface t() { Ci = transmission(P, P + N); }").contains("calls `transmission`"));
    assert!(body("color c; gather(\"\", P, N, 1, 4, \"surface:Ci\", c) { Ci += c; }").contains("colours of rays"));
    assert!(body("gather(\"\", P, N, 1, 4) { Ci += filterwidth(s); }").contains("in a loop over rays"));
    assert!(body("printf(\"%f\", s);").contains("prints"));
    assert!(
        body("string a = \"x\"; if (s > 0.5) a = \"y\"; if (a == \"x\") Ci = 1;").contains("only known while it runs")
    );
    assert!(refused("light l() { Cl = 1; }", &[]).contains("is a light's"));
    let dark = "light l() { Cl = trace(Ps, Ns); }";
    assert!(refused("surface t() { Ci = ambient(); }", &[dark]).contains("`l` asks for the colours of rays"));
}
