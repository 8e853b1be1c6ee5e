//! All shaders of the library and of the corpus: each has a kernel that computes what the grid machine does, or is refused by name.

use crate::compare::compare;
use crate::world::{World, bind, bind_file, root};
use sl::ir::ShaderKind;
use sl::machine::BoundShader;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Lights of the kinds that there are.
const LIGHTS: [&str; 4] = [
    "light sun() { solar(vector(0.3, -0.2, 1), 0) { Cl = color(0.9, 0.8, 0.7); } }",
    "light lamp(float intensity = 3; string __category = \"key,warm\"; float __nonspecular = 0; output float power = 1;) {
        illuminate(point(0.4, 0.9, -2.2)) { Cl = intensity * color(0.5, 1, 0.8) / (L . L); power = 2 + zcomp(L); }
    }",
    "light spot(float cone = 0.5; float delta = 0.1; string __category = \"fill\"; float __nondiffuse = 1;) {
        illuminate(point(-1.1, 0.3, -3), normalize(vector(0.4, -0.1, 1)), cone) {
            float c = (L . vector(0.4, -0.1, 1)) / length(L) / length(vector(0.4, -0.1, 1));
            Cl = smoothstep(cos(cone), cos(cone - delta), c) * transmission(Ps, point(-1.1, 0.3, -3));
        }
    }",
    "light everywhere() { Cl = 0.15 + 0.05 * ycomp(normalize(Ns)); }",
];

fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    let mut entries: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            files(&path, found);
        } else if path.extension().is_some_and(|e| e == "sl") {
            found.push(path);
        }
    }
}

/// A shader alone; for a light, a surface that it shines on.
fn stage(shader: Arc<BoundShader>, lights: &[Arc<BoundShader>]) -> (Arc<BoundShader>, World) {
    let is_light = shader.program.kind == ShaderKind::Light;
    let lit = "surface lit(float Ks = 0.5) { normal n = faceforward(normalize(N), I);
        Ci = ambient() + diffuse(n) + Ks * specular(n, -normalize(I), 0.2);
        illuminance(P, n, 1.2) { Ci += 0.1 * Cl * abs(xcomp(normalize(L))); } }";
    match is_light {
        true => (bind(lit), World { lights: vec![shader], ..World::default() }),
        false => (shader, World { lights: lights.to_vec(), ..World::default() }),
    }
}

/// Compare all shaders of a folder: a line for each that is refused, and how far the others differ.
fn survey(folder: &Path) -> (String, String, usize) {
    let lights: Vec<Arc<BoundShader>> = LIGHTS.iter().map(|l| bind(l)).collect();
    let mut paths = vec![];
    files(folder, &mut paths);
    let (mut refused, mut wrong, mut n) = (String::new(), String::new(), 0);
    for path in paths {
        // Those of the corpus that are no shaders are for other tests.
        let Ok(shader) = bind_file(&path) else { continue };
        let name = path.file_stem().unwrap().to_string_lossy().to_string();
        let (shader, world) = stage(shader, &lights);
        match compare(&shader, &world) {
            Err(why) => writeln!(refused, "{name}: {why}").unwrap(),
            Ok(found) => {
                n += 1;
                let told = world.warnings.lock().unwrap();
                if let Some(found) = found.filter(|f| f.difference > 1e-4 || f.faults.is_empty() != told.is_empty()) {
                    writeln!(wrong, "{name}: {} {:?} {}", found.difference, found.faults, found.place).unwrap();
                }
            }
        }
    }
    (refused, wrong, n)
}

/// Hold a text to a file beside the tests; with `SCREE_UPDATE=1`, write the file instead.
pub fn hold(name: &str, now: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/wgsl").join(name);
    if std::env::var_os("SCREE_UPDATE").is_some_and(|v| v == "1") {
        return std::fs::write(path, now).unwrap();
    }
    let before = std::fs::read_to_string(&path).unwrap_or_else(|e| {
        panic!("{}: {e}; written by: SCREE_UPDATE=1 cargo test --release -p sl --test wgsl", path.display())
    });
    for (k, (a, b)) in before.lines().zip(now.lines()).enumerate() {
        assert_eq!(a, b, "{name}:{}", k + 1);
    }
    assert_eq!(before.lines().count(), now.lines().count(), "{name}");
}

#[test]
fn the_library_is_the_same_on_a_device() {
    let (refused, wrong, n) = survey(&root().join("shaders"));
    assert!(wrong.is_empty(), "{wrong}");
    hold("library_refused.txt", &refused);
    assert!(n > 30, "{n} shaders have kernels");
}

#[test]
fn the_corpus_is_the_same_on_a_device() {
    let (refused, wrong, n) = survey(&root().join("tests/corpus/shader"));
    assert!(wrong.is_empty(), "{wrong}");
    hold("corpus_refused.txt", &refused);
    assert!(n > 120, "{n} shaders have kernels");
}
