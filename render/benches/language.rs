//! Speed of the language front: reading RIB, compiling and running shaders.
//!
//! `cargo bench -p render --bench language`: the marks are 150 MB/s of ASCII, 400 MB/s of the bytestream, 120 ns a point for
//! plastic with one light, 20 ms for a shader of 300 lines.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use render::ri::files::Files;
use render::ri::reader;
use render::ri::writer::Writer;
use render::ri::{Params, Ri, RiResult};
use render::sl::Global;
use render::sl::machine::{BoundShader, Lights, Machine, Points};
use std::path::Path;
use std::sync::Arc;

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

criterion_group! {
    name = language;
    config = Criterion::default().sample_size(20);
    targets = rib, shaders
}
criterion_main!(language);

fn rib(bench: &mut Criterion) {
    let mut group = bench.benchmark_group("rib");
    let mut spheres = String::from("WorldBegin\n");
    let mut state = 1u32;
    let mut random = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        state as f32 / u32::MAX as f32
    };
    for _ in 0..200_000 {
        let [a, b, c, d] = [0; 4].map(|_| random());
        spheres += &format!(
            "AttributeBegin\n  Color [{a:.3} {b:.3} {c:.3}]\n  Translate {d:.5} {a:.5} {b:.5}\n  Sphere 0.05 -0.05 0.05 360\nAttributeEnd\n"
        );
    }
    spheres += "WorldEnd\n";
    let mut mesh = String::from("WorldBegin\nPointsPolygons [");
    let n = 500_000;
    (0..n).for_each(|_| mesh += "3 ");
    mesh += "] [";
    (0..3 * n).for_each(|k| mesh += &format!("{} ", k % (n / 2)));
    mesh += "] \"P\" [";
    (0..3 * n / 2).for_each(|_| mesh += &format!("{:.6} ", random()));
    mesh += "]\nWorldEnd\n";
    for (name, ascii) in [("spheres", &spheres), ("mesh", &mesh)] {
        let mut writer = Writer::binary(Vec::new()).expect("a vector takes all");
        read(ascii.as_bytes(), &mut writer);
        let binary = writer.into_inner();
        for (kind, bytes) in [("ascii", ascii.as_bytes()), ("binary", &binary)] {
            group.throughput(Throughput::BytesDecimal(bytes.len() as u64));
            group.bench_function(format!("{name}, {kind}"), |b| b.iter(|| read(bytes, &mut Null)));
        }
    }
}

fn read(bytes: &[u8], ri: &mut dyn Ri) {
    reader::read(Path::new("bench.rib"), bytes, &Files::default(), ri, &mut |_, _| Ok(None)).expect("a sound stream");
}

fn shaders(bench: &mut Criterion) {
    let mut group = bench.benchmark_group("sl");
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
    let mut machine = Machine::new();
    let place: Vec<f32> = (0..3 * n).map(|k| (k as f32 * 0.37).sin()).collect();
    let mut points = Points::new(16, 16, 1.0);
    group.throughput(Throughput::Elements(n as u64));
    group.bench_function("plastic, one light, a grid of 256 points", |b| {
        b.iter(|| {
            for global in [Global::P, Global::I, Global::N, Global::Cs] {
                points.refill(global).extend_from_slice(&place);
            }
            points.refill(Global::Os).extend_from_slice(&[1.0; 3]);
            points.refill(Global::Ci).extend_from_slice(&[0.0; 3]);
            points.refill(Global::Oi).extend_from_slice(&[1.0; 3]);
            machine.run(&plastic, &mut points, &scene);
        });
    });
    let mut long = String::from("surface long(float k = 1;) {\n    color c = 0;\n");
    for i in 0..298 {
        long +=
            &format!("    c += color noise(P * {}) * k * diffuse(normalize(N)) + mix(Cs, c, 0.{});\n", i + 1, i % 10);
    }
    long += "    Ci = c;\n}\n";
    group.throughput(Throughput::Elements(300));
    group.bench_function("compile 300 lines", |b| b.iter(|| compile("long.sl", &long)));
}
