//! Speed of the language front: reading RIB, compiling and running shaders.
//!
//! `cargo bench -p render --bench language` prints MB/s, ms and ns; the marks are 150 MB/s of ASCII, 400 MB/s of the bytestream,
//! 120 ns a point for plastic with one light, 20 ms for a shader of 300 lines. With `mutate N` it feeds N wounded streams and
//! shaders to the readers instead: none may panic, hang or take the memory of the machine.

use render::ri::files::Files;
use render::ri::reader;
use render::ri::writer::Writer;
use render::ri::{Params, Ri, RiResult};
use render::sl::machine::{BoundShader, Lights, Machine, Points};
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

/// Takes every call that the streams here make and does nothing.
struct Null;

impl Ri for Null {
    fn version(&mut self, _: f32) -> RiResult {
        Ok(())
    }
    fn world_begin(&mut self) -> RiResult {
        Ok(())
    }
    fn world_end(&mut self) -> RiResult {
        Ok(())
    }
    fn attribute_begin(&mut self) -> RiResult {
        Ok(())
    }
    fn attribute_end(&mut self) -> RiResult {
        Ok(())
    }
    fn color(&mut self, _: [f32; 3]) -> RiResult {
        Ok(())
    }
    fn translate(&mut self, _: [f32; 3]) -> RiResult {
        Ok(())
    }
    fn sphere(&mut self, _: f32, _: f32, _: f32, _: f32, _: Params) -> RiResult {
        Ok(())
    }
    fn points_polygons(&mut self, _: Vec<i32>, _: Vec<i32>, _: Params) -> RiResult {
        Ok(())
    }
    fn warn(&mut self, _: String) {}
}

fn main() {
    let args: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with("--")).collect();
    match args.as_slice() {
        [word, n] if word == "mutate" => mutate(n.parse().expect("a number")),
        _ => {
            rib();
            shaders();
        }
    }
}

/// The best of a few runs, s.
fn best(mut f: impl FnMut()) -> f64 {
    (0..5)
        .map(|_| {
            let start = Instant::now();
            f();
            start.elapsed().as_secs_f64()
        })
        .fold(f64::INFINITY, f64::min)
}

fn rib() {
    let mut balls = String::from("WorldBegin\n");
    let mut state = 1u32;
    let mut random = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        state as f32 / u32::MAX as f32
    };
    for _ in 0..200_000 {
        let [a, b, c, d] = [0; 4].map(|_| random());
        balls += &format!(
            "AttributeBegin\n  Color [{a:.3} {b:.3} {c:.3}]\n  Translate {d:.5} {a:.5} {b:.5}\n  Sphere 0.05 -0.05 0.05 360\nAttributeEnd\n"
        );
    }
    balls += "WorldEnd\n";
    let mut mesh = String::from("WorldBegin\nPointsPolygons [");
    let n = 500_000;
    (0..n).for_each(|_| mesh += "3 ");
    mesh += "] [";
    (0..3 * n).for_each(|k| mesh += &format!("{} ", k % (n / 2)));
    mesh += "] \"P\" [";
    (0..3 * n / 2).for_each(|_| mesh += &format!("{:.6} ", random()));
    mesh += "]\nWorldEnd\n";
    for (name, ascii) in [("balls", &balls), ("mesh", &mesh)] {
        let mut writer = Writer::binary(Vec::new()).expect("a vector takes all");
        read(ascii.as_bytes(), &mut writer);
        let binary = writer.into_inner();
        for (kind, bytes) in [("ascii", ascii.as_bytes()), ("binary", &binary)] {
            let s = best(|| read(bytes, &mut Null));
            let mb = bytes.len() as f64 / 1e6;
            println!("rib {name} {kind}: {:.0} MB/s ({mb:.1} MB)", mb / s);
        }
    }
}

fn read(bytes: &[u8], ri: &mut dyn Ri) {
    reader::read(Path::new("bench.rib"), bytes, &Files::default(), ri, &mut |_, _| Ok(())).expect("a sound stream");
}

fn shaders() {
    let library = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shaders");
    let source = |name: &str| std::fs::read_to_string(library.join(name)).expect("a shader of the library");
    let compile = |name: &str, text: &str| render::sl::compile(Path::new(name), text).expect("a sound shader");
    let none = Lights(vec![]);
    let bind =
        |name: &str, text: &str| Arc::new(BoundShader::new(Arc::new(compile(name, text)), vec![], vec![], &none));
    let light = bind("sun.sl", "light sun() { solar(vector(0.3, 0.2, 1), 0) { Cl = 1; } }");
    let scene = Lights(vec![light]);
    let plastic = bind("plastic.sl", &source("surface/plastic.sl"));
    let n = 256;
    let grids = 1_000_000 / n;
    let mut machine = Machine::new();
    let place: Vec<f32> = (0..3 * n).map(|k| (k as f32 * 0.37).sin()).collect();
    let mut points = Points { nu: 16, nv: 16, orientation: 1.0, ..Points::default() };
    let s = best(|| {
        for _ in 0..grids {
            for name in ["P", "I", "N", "Cs"] {
                points.refill(name).extend_from_slice(&place);
            }
            points.refill("Os").extend_from_slice(&[1.0; 3]);
            points.refill("Ci").extend_from_slice(&[0.0; 3]);
            points.refill("Oi").extend_from_slice(&[1.0; 3]);
            machine.run(&plastic, &mut points, &scene);
        }
    });
    println!("sl plastic, one light: {:.0} ns a point", s * 1e9 / (grids * n) as f64);
    let mut long = String::from("surface long(float k = 1;) {\n    color c = 0;\n");
    for i in 0..298 {
        long +=
            &format!("    c += color noise(P * {}) * k * diffuse(normalize(N)) + mix(Cs, c, 0.{});\n", i + 1, i % 10);
    }
    long += "    Ci = c;\n}\n";
    let s = best(|| {
        compile("long.sl", &long);
    });
    println!("sl compile, 300 lines: {:.1} ms", s * 1e3);
}

/// Feed wounded texts to the readers.
fn mutate(n: u64) {
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/corpus");
    let all = |room: &str| -> Vec<Vec<u8>> {
        let files = std::fs::read_dir(corpus.join(room)).expect("the corpus").map(|e| e.expect("a file").path());
        let mut files: Vec<_> = files.filter(|f| !f.to_string_lossy().contains("run_program")).collect();
        files.sort();
        files.iter().map(|f| std::fs::read(f).expect("a file of the corpus")).collect()
    };
    let (ribs, shaders) = (all("rib"), all("shader"));
    let mut state = 7u64;
    let mut random = |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below.max(1)
    };
    let (mut sound, mut most, start) = (0u64, peak(), Instant::now());
    for i in 0..n {
        let texts = if i % 2 == 0 { &ribs } else { &shaders };
        let mut text = texts[random(texts.len())].clone();
        for _ in 0..1 + random(4) {
            let at = random(text.len());
            match random(6) {
                0 => text[at] = random(256) as u8,
                1 => text.truncate(at),
                2 => {
                    let other = &texts[random(texts.len())];
                    let (a, b) = (random(other.len()), random(other.len()));
                    let part = other[a.min(b)..a.max(b)].to_vec();
                    text.splice(at..at, part);
                }
                3 => {
                    let end = (at + random(20)).min(text.len());
                    text.drain(at..end);
                }
                4 => text.insert(at, b"0123456789[](){}\";,.-+*/#"[random(25)]),
                _ => {
                    let end = (at + random(40)).min(text.len());
                    let part = text[at..end].to_vec();
                    text.splice(at..at, part);
                }
            }
            if text.is_empty() {
                text.push(b'\n');
            }
        }
        // A wounded stream must not start programs.
        if text.windows(10).any(|w| w == b"RunProgram") {
            continue;
        }
        sound += if i % 2 == 0 {
            let mut context = render::Context::new(
                Files::default()
                    .with(&[("shaders/surface/defaultsurface.sl", "surface defaultsurface() { Ci = Cs; }")]),
            )
            .expect("a context");
            context.dry = true;
            reader::read(Path::new("m.rib"), &text, &Files::default(), &mut context, &mut |_, _| Ok(())).is_ok() as u64
        } else {
            let text = String::from_utf8_lossy(&text);
            render::sl::compile(Path::new("m.sl"), &text).is_ok() as u64
        };
        let now = peak();
        if now > most + 200_000 {
            println!(
                "input {i} took the peak to {} MB:\n{}",
                now / 1000,
                String::from_utf8_lossy(&text[..text.len().min(3000)])
            );
        }
        most = most.max(now);
        if start.elapsed().as_secs() > 0 && i % 100_000 == 99_999 {
            println!("{} inputs, {sound} sound, {:.0} s", i + 1, start.elapsed().as_secs_f64());
        }
    }
    let seconds = start.elapsed().as_secs_f64();
    println!("{n} inputs, {sound} sound, {seconds:.0} s, at most {} MB: no panic", most / 1000);
}

/// The most memory that this process has had, kB; 0 where nobody says.
fn peak() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"));
    line.and_then(|l| l.split_whitespace().next()?.parse().ok()).unwrap_or(0)
}
