//! Loops over contacts and samples have the same bits in vector registers and in plain arrays: whole runs and images both ways.

use crate::cli::{scratch, scree, scree_with};
use std::path::Path;

/// The switch that forces plain arrays, and the one that keeps loops from the widest registers.
const PLAIN: &[(&str, &str)] = &[("SCREE_LANES", "plain")];
const AVX2: &[(&str, &str)] = &[("SCREE_LANES", "avx2")];

/// Whether this machine has the wide lanes at all, and the switch turns them off.
fn both_are_there() -> bool {
    let lanes = |said: String| said.lines().find(|l| l.starts_with("lanes: ")).unwrap().to_string();
    assert_eq!(lanes(scree_with(PLAIN, &["doctor"]).ok()), "lanes: plain for contacts, plain for samples");
    match lanes(scree(&["doctor"]).ok()).as_str() {
        "lanes: AVX-512 for contacts, AVX2 for samples" | "lanes: AVX2 for contacts, AVX2 for samples" => {
            assert_eq!(lanes(scree_with(AVX2, &["doctor"]).ok()), "lanes: AVX2 for contacts, AVX2 for samples");
            true
        }
        "lanes: plain for contacts, plain for samples" if !has_avx2() => {
            eprintln!("skipped: this processor has no AVX2");
            false
        }
        other => panic!("{other}"),
    }
}

fn has_avx2() -> bool {
    #[cfg(target_arch = "x86_64")]
    return std::arch::is_x86_feature_detected!("avx2");
    #[cfg(not(target_arch = "x86_64"))]
    false
}

/// Do the same with each kind of lanes into a folder of its own, and hold the files to each other.
fn same_both_ways(args: &[&str], files: &[&str]) {
    let work = scratch();
    let outputs = [&[][..], AVX2, PLAIN].map(|lanes| {
        let out = work.path().join(lanes.first().map_or("widest", |(_, lanes)| lanes));
        scree_with(lanes, &[args, &["-o", out.to_str().unwrap()]].concat()).ok();
        out
    });
    for file in files {
        let [widest, wide, plain] = [0, 1, 2].map(|k| std::fs::read(outputs[k].join(file)).unwrap());
        assert!(widest == wide && wide == plain && wide.len() > 500, "{args:?}: {file} differs");
    }
}

#[test]
fn runs_have_the_same_bits_in_plain_lanes() {
    if !both_are_there() {
        return;
    }
    // Spheres, which have lane loops of their own for pairs and for sweeps; by every method, and the exact law.
    for set in [
        &["solver.method=apgd"][..],
        &["solver.method=jacobi"],
        &["solver.method=barzilai_borwein"],
        &["solver.method=gauss_seidel", "solver.friction=exact"],
    ] {
        let set: Vec<&str> = set.iter().flat_map(|s| ["--set", *s]).collect();
        let args = [&["simulate", "sim/models/pour.yaml", "--until", "0.3"], &set[..]].concat();
        same_both_ways(&args, &["checkpoints/000000300.state", "probes.csv", "frames/000007.arrow"]);
    }
    // Blocks, with contacts that have several points, and joints.
    for (model, until, state) in [("wall", "0.05", None), ("pendulums", "0.1", Some("checkpoints/000000200.state"))] {
        let model = format!("sim/models/{model}.yaml");
        let files: Vec<&str> = ["probes.csv", "frames/000001.arrow"].into_iter().chain(state).collect();
        same_both_ways(&["simulate", &model, "--until", until], &files);
    }
    // Sweeps over manifolds.
    let swept = ["simulate", "sim/models/wall.yaml", "--until", "0.05", "--quality", "normal"];
    same_both_ways(&swept, &["probes.csv", "frames/000001.arrow"]);
}

#[test]
fn images_have_the_same_bits_in_plain_lanes() {
    if !both_are_there() {
        return;
    }
    let work = scratch();
    let path = work.path().join("t.rib");
    // Still and opaque, still and translucent, moving, through a lens.
    for (options, opacity, moves) in [
        ("", "1 1 1", ""),
        ("", ".5 .6 .7", ""),
        (
            "Shutter 0 1",
            ".5 .6 .7",
            "MotionBegin [0 0.3 1] Translate 0 0 0 Translate 0.2 0 0 Translate 0.3 0.2 0 MotionEnd",
        ),
        ("DepthOfField 2 0.5 5", "1 1 1", ""),
    ] {
        let scene = format!(
            "Format 150 100 1 PixelSamples 5 3 PixelFilter \"catmull-rom\" 4 4
Display \"a.exr\" \"exr\" \"rgbaz\" Display \"+a.exr\" \"exr\" \"N\" Display \"+a.exr\" \"exr\" \"id\"
{options} Projection \"perspective\" \"fov\" 40 Translate 0 0 5
WorldBegin
LightSource \"distantlight\" 1 \"to\" [1 -1 2]
TransformBegin {moves}
Displacement \"rock\" \"uniform float Km\" [0.1] \"uniform float size\" [0.4]
Color 1 .5 .2 Sphere 1 -1 1 360
TransformBegin Translate 0.8 0.2 -1 Opacity {opacity} Color .2 .5 1 Sphere .6 -.6 .6 360 TransformEnd
TransformEnd
Displacement \"null\" Opacity 1 1 1 Surface \"plastic\"
Translate -1 -0.5 0 Torus .4 .15 0 360 360
Polygon \"P\" [-5 -1 -2 5 -1 -2 5 -1 30 -5 -1 30]
WorldEnd
"
        );
        std::fs::write(&path, scene).unwrap();
        same_both_ways(&["render", path.to_str().unwrap()], &["a.exr"]);
    }
    // A whole frame of stones.
    let run = work.path().join("run");
    let run = run.to_str().unwrap();
    scree(&["simulate", "sim/models/pour.yaml", "--until", "0.1", "-o", run]).ok();
    assert!(Path::new(run).is_dir());
    same_both_ways(&["render", run, "-f", "2", "--res", "160x90"], &["000002.png"]);
}
