//! `scree render --backend gpu` and `scree bench render --backend gpu`, on an adapter, where there is one.

use crate::cli::{scratch, scree};
use crate::devices::has_adapter;

const CAMERA: &str =
    "Format 96 72 1 PixelSamples 4 4 PixelFilter \"gaussian\" 2 2 Projection \"perspective\" \"fov\" 45
    Translate 0 0 6 Rotate -35 1 0 0 Rotate 20 0 1 0\n";

/// The command says once why the processor has drawn images, and chooses adapters.
#[test]
fn scree_render_draws_on_a_device() {
    if !has_adapter() {
        return;
    }
    let folder = scratch();
    let scene = folder.path().join("t.rib");
    let write = |world: &str| {
        let lit = "WorldBegin LightSource \"distantlight\" 1 Surface \"matte\"";
        std::fs::write(&scene, format!("Display \"t.png\" \"png\" \"rgb\" {CAMERA}{lit} {world} WorldEnd")).unwrap();
    };
    let out = folder.path().display().to_string();
    let command = ["render", scene.to_str().unwrap(), "-o", &out, "--backend", "gpu", "--adapter", "0"];
    let image = || std::fs::read(folder.path().join("t.png")).unwrap();
    write("Opacity [0.5 0.5 0.5] Sphere 1 -1 1 360");
    let answer = scree(&command);
    assert!(!answer.errors().contains("processor"), "{}", answer.errors());
    answer.ok();
    let drawn = image();
    let answer = scree(&command.iter().copied().chain(["--gpu-memory", "64MiB"]).collect::<Vec<_>>());
    assert!(!answer.errors().contains("processor"), "{}", answer.errors());
    answer.ok();
    assert!(image() == drawn, "within less memory");
    let part = |x: f32| format!("SolidBegin \"primitive\" Translate {x} 0 0 Sphere 1 -1 1 360 SolidEnd");
    write(&format!("SolidBegin \"difference\" {} {} SolidEnd", part(0.0), part(1.0)));
    let answer = scree(&command);
    assert_eq!(
        answer.errors().matches("the processor has drawn the image: the scene has solids").count(),
        1,
        "{}",
        answer.errors()
    );
    answer.ok();
    let answer = scree(&["render", scene.to_str().unwrap(), "-o", &out, "--backend", "gpu", "--adapter", "nobody's"]);
    assert!(answer.fails(2).contains("nobody's"));
    let answer = scree(&["render", scene.to_str().unwrap(), "-o", &out, "--backend", "cpu", "--gpu-memory", "1GiB"]);
    assert!(answer.fails(2).contains("--gpu-memory"));
    let answer = scree(&["render", scene.to_str().unwrap(), "-o", &out, "--adapter", "0"]);
    assert!(answer.fails(2).contains("--backend gpu"));
}

/// The benchmark compares both back ends.
#[test]
fn the_benchmark_compares_both_back_ends() {
    if !has_adapter() {
        return;
    }
    let answer = scree(&[
        "bench",
        "render",
        "--n",
        "300",
        "--res",
        "96x54",
        "--backend",
        "gpu",
        "--adapter",
        "0",
        "--compare",
        "cpu",
        "--json",
    ]);
    let json: serde_json::Value = serde_json::from_str(&answer.ok()).unwrap();
    let part = |key: &str| json[key].as_f64().unwrap_or_else(|| panic!("{json}"));
    assert!(part("ids_equal_fraction") >= 0.9999 && part("pixels_within_2_fraction") >= 0.999, "{json}");
    assert!(json["backend"] == "gpu" && json["adapter"].is_string(), "{json}");
}
