//! The corpus: sound RIB and shaders of every call, statement and function, held to snapshots; and broken files of every kind,
//! each answered with file, line and column, and none with a panic.

use crate::cli::scree;
use render::ri::files::{Files, Permission};
use render::ri::reader;
use render::ri::writer::Writer;
use render::sl;
use render::sl::Global;
use render::sl::machine::{BoundShader, Lights, Machine, Points};
use std::path::{Path, PathBuf};
use std::sync::Arc;

#[test]
fn broken_files_are_answered_with_their_place() {
    for (kind, ending) in [("model", "yaml"), ("metadata", "yaml"), ("rib", "rib"), ("shader", "sl")] {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/corpus/broken").join(kind);
        let mut files: Vec<PathBuf> = std::fs::read_dir(&folder).unwrap().map(|e| e.unwrap().path()).collect();
        files.retain(|f| f.extension().is_some_and(|e| e == ending));
        files.sort();
        assert!(files.len() >= 10, "{} has {} files", folder.display(), files.len());
        for file in files {
            let path = file.to_str().unwrap();
            let said = scree(&["check", path]).fails(3);
            let placed =
                said.lines().next().and_then(|l| l.split_once(&format!("{path}:"))).map(|(_, rest)| rest.to_string());
            let numbers: Vec<&str> = placed.as_deref().unwrap_or("").split(':').collect();
            let has_place = numbers.len() > 2 && numbers[..2].iter().all(|n| n.parse::<u32>().is_ok_and(|n| n > 0));
            assert!(has_place, "{path}: no place in: {said}");
            assert!(!said.contains("internal") && !said.contains("panicked"), "{said}");
            // A file that names the line of its fault is held to it.
            let text = std::fs::read(&file).unwrap();
            let text = String::from_utf8_lossy(&text);
            if let Some(line) = text.lines().position(|l| l.contains("FAULT")) {
                assert_eq!(numbers[0], (line + 1).to_string(), "{said}");
            }
        }
    }
}

fn corpus(room: &str, ending: &str) -> Vec<(PathBuf, Vec<u8>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/corpus").join(room);
    let mut files: Vec<PathBuf> = std::fs::read_dir(&folder).unwrap().map(|e| e.unwrap().path()).collect();
    files.retain(|f| f.extension().is_some_and(|e| e == ending));
    files.sort();
    assert!(files.len() >= 150, "{} has {} files", folder.display(), files.len());
    files.into_iter().map(|f| (f.clone(), std::fs::read(f).unwrap())).collect()
}

/// Hold a text to a snapshot beside the corpus; with `SCREE_UPDATE=1`, write the snapshot instead. Images are never written so.
fn hold(name: &str, now: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/corpus").join(name);
    if std::env::var_os("SCREE_UPDATE").is_some_and(|v| v == "1") {
        return std::fs::write(path, now).unwrap();
    }
    let before = std::fs::read_to_string(&path).unwrap_or_else(|e| {
        panic!("{}: {e}; written by: SCREE_UPDATE=1 cargo test --release --test tests -- corpus", path.display())
    });
    let differs = before.lines().zip(now.lines()).position(|(a, b)| a != b);
    if before != now {
        let line = differs.unwrap_or(before.lines().count().min(now.lines().count()));
        let show = |t: &str| t.lines().nth(line).unwrap_or("(the end)").to_string();
        panic!("{name}:{}: was `{}`, is `{}`", line + 1, show(&before), show(now));
    }
}

/// The calls of a RIB stream as ASCII, or as the bytestream.
fn calls(path: &Path, rib: &[u8], binary: bool) -> Vec<u8> {
    let mut writer = if binary { Writer::binary(Vec::new()) } else { Writer::new(Vec::new()) }.unwrap();
    let path = PathBuf::from(path.file_name().unwrap());
    let files = Files { programs: Permission::All, ..Files::default() };
    match reader::read(&path, rib, &files, &mut writer, &mut |_, _| Ok(None)) {
        Ok(()) => writer.into_inner(),
        Err(e) => format!("error: {e}\n").into_bytes(),
    }
}

#[test]
fn the_calls_of_the_corpus_are_as_they_were() {
    let mut all = String::new();
    for (path, rib) in corpus("rib", "rib") {
        let once = calls(&path, &rib, false);
        assert!(!once.starts_with(b"error"), "{}", String::from_utf8_lossy(&once));
        all += &format!("== {}\n{}", path.file_name().unwrap().to_string_lossy(), String::from_utf8_lossy(&once));
        // What was written reads as what it was written from: ASCII, binary, and packed.
        let show = |rib: &[u8]| String::from_utf8_lossy(&calls(&path, rib, false)).into_owned();
        let expected = String::from_utf8_lossy(&once);
        assert_eq!(show(&once), expected, "{}", path.display());
        let binary = calls(&path, &rib, true);
        assert_eq!(show(&binary), expected, "{}", path.display());
        let mut packer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        std::io::Write::write_all(&mut packer, &binary).unwrap();
        assert_eq!(show(&packer.finish().unwrap()), expected, "{}", path.display());
    }
    hold("rib.snapshot", &all);
}

#[test]
fn the_corpus_is_taken_by_the_renderer() {
    let files: Vec<String> = corpus("rib", "rib").into_iter().map(|(p, _)| p.to_string_lossy().into_owned()).collect();
    let args: Vec<&str> = std::iter::once("check").chain(files.iter().map(String::as_str)).collect();
    scree(&args).ok();
}

#[test]
fn every_shader_runs_over_grids_of_any_shape() {
    let bind = |name: &str, source: &str, scene: &Lights| {
        let program = sl::compile_with(Path::new(name), source, &include).unwrap_or_else(|e| panic!("{e}"));
        Arc::new(BoundShader::new(Arc::new(program), vec![], vec![], scene))
    };
    fn include(name: &str, _: &Path) -> Result<(PathBuf, String), String> {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders/include").join(name);
        std::fs::read_to_string(&path).map(|text| (path, text)).map_err(|e| e.to_string())
    }
    let nothing = Lights(vec![]);
    let lights = [
        "light a(float intensity = 2;) { Cl = intensity; }",
        "light b(string __category = \"key\";) { illuminate(point(1, 1, -3)) { Cl = 1 / (L . L); } }",
        "light c() { solar(vector(0, 0, 1), 0) { Cl = 1 - shadow(\"map\", Ps); } }",
    ];
    let scene = Lights(lights.iter().map(|l| bind("light.sl", l, &nothing)).collect());
    let library = Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders");
    let mut all = corpus("shader", "sl");
    for room in ["surface", "displacement", "light", "volume", "imager"] {
        let files = std::fs::read_dir(library.join(room)).unwrap().map(|e| e.unwrap().path());
        all.extend(files.map(|f| (f.clone(), std::fs::read(f).unwrap())));
    }
    let mut machine = Machine::new();
    for (path, source) in all {
        let shader = bind(path.to_str().unwrap(), &String::from_utf8(source).unwrap(), &scene);
        for (nu, nv) in [(1, 1), (5, 3), (16, 16)] {
            let n = nu * nv;
            let grid = |f: &dyn Fn(f32, f32) -> f32| -> Vec<f32> {
                (0..n).map(|k| f((k % nu) as f32 / nu as f32, (k / nu) as f32 / nv as f32)).collect()
            };
            let mut points = Points::new(nu, nv, 1.0);
            let place = [grid(&|u, _| u), grid(&|_, v| v), grid(&|u, v| u * v)].concat();
            for global in [Global::P, Global::I] {
                points.set(global, place.clone());
            }
            for global in [Global::N, Global::Ng] {
                points.set(global, [vec![0.0; n], vec![0.0; n], vec![-1.0; n]].concat());
            }
            for global in [Global::U, Global::S] {
                points.set(global, grid(&|u, _| u));
            }
            for global in [Global::V, Global::T] {
                points.set(global, grid(&|_, v| v));
            }
            for global in [Global::Cs, Global::Os, Global::Oi] {
                points.set(global, vec![1.0; 3]);
            }
            points.set(Global::Ci, vec![0.0; 3]);
            machine.run(&shader, &mut points, &scene);
            let ci = points.get(Global::Ci).unwrap();
            assert!(ci.len() == 3 || ci.len() == 3 * n, "{}: {} values for {n} points", path.display(), ci.len());
            assert!(ci.iter().all(|x| x.is_finite()), "{}: {ci:?}", path.display());
        }
    }
}

#[test]
fn the_ir_of_the_corpus_is_as_it_was() {
    let mut all = String::new();
    for (path, source) in corpus("shader", "sl") {
        let name = PathBuf::from(path.file_name().unwrap());
        let program = sl::compile(&name, &String::from_utf8(source).unwrap()).unwrap_or_else(|e| panic!("{e}"));
        all += &format!("== {}\n{program}", name.display());
    }
    hold("shader.snapshot", &all);
}
