//! The same input gives the same bits, for any number of threads and any size of bucket.

use crate::cli::{scratch, scree};
use sim::workload::{self, Workload};
use sim::{Method, Simulation, State, checkpoint};
use std::path::Path;

/// All files of a folder, by name, as bytes.
fn bytes(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut all: Vec<(String, Vec<u8>)> = std::fs::read_dir(folder)
        .unwrap()
        .map(|e| e.unwrap().path())
        .filter(|p| p.is_file())
        .map(|p| (p.file_name().unwrap().to_string_lossy().to_string(), std::fs::read(&p).unwrap()))
        .collect();
    all.sort();
    all
}

#[test]
fn simulation_and_images_do_not_depend_on_threads() {
    let work = scratch();
    let mut frames = Vec::new();
    let mut images = Vec::new();
    for threads in ["1", "2", "7"] {
        let run = work.path().join(format!("run{threads}"));
        let run_text = run.to_str().unwrap();
        scree(&["simulate", "sim/models/pour.yaml", "--until", "0.3", "--threads", threads, "-o", run_text]).ok();
        frames.push(bytes(&run.join("frames")));
        scree(&["render", run_text, "-f", "7", "--res", "120x68", "--samples", "2", "--threads", threads]).ok();
        images.push(bytes(&run.join("images")));
    }
    assert_eq!(frames[0].len(), 8);
    assert!(frames[1] == frames[0] && frames[2] == frames[0], "the frame files differ");
    assert!(images[1] == images[0] && images[2] == images[0], "the images differ");
}

/// A bed of many tiles, by threads of different number and with a stop at a checkpoint on the way: the same bits; and no two
/// tiles of a round share a moving body.
#[test]
fn a_bed_of_many_tiles_does_not_depend_on_threads() {
    let work = scratch();
    for method in [Method::GaussSeidel, Method::Apgd] {
        let (model, state) = workload::build(Workload::S, 12_000, workload::solver(method, 12), 2e-3);
        let run = |threads: usize, state: State, steps: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let mut sim = Simulation::new(model.clone(), state);
            pool.install(|| {
                for _ in 0..steps {
                    sim.step();
                }
            });
            sim.state
        };
        let path = |name: &str| work.path().join(name);
        let whole = run(1, state.clone(), 120);
        checkpoint::write(&path("whole"), &whole, "").unwrap();
        checkpoint::write(&path("half"), &run(2, state, 63), "").unwrap();
        let half = checkpoint::read(&path("half")).unwrap().0;
        checkpoint::write(&path("two"), &run(7, half, 57), "").unwrap();
        assert!(
            std::fs::read(path("whole")).unwrap() == std::fs::read(path("two")).unwrap(),
            "{method:?}: the states differ"
        );

        let contacts = &whole.contacts;
        let [first, second] = contacts.tiles.rounds();
        assert!(contacts.len() > 8_000 && first.len() > 8 && second.len() > 8, "{} {}", contacts.len(), first.len());
        for starts in [first, second] {
            let mut tile_of = vec![None; model.n_bodies()];
            for (tile, ends) in starts.windows(2).enumerate() {
                let bodies = contacts.bodies[ends[0] as usize..ends[1] as usize].as_flattened();
                for body in bodies.iter().map(|b| *b as usize).filter(|b| model.inv_mass[*b] > 0.0) {
                    assert_eq!(*tile_of[body].get_or_insert(tile), tile, "body {body} is in two tiles of a round");
                }
            }
        }
    }
}

#[test]
fn a_run_goes_on_from_a_checkpoint_bit_for_bit() {
    let work = scratch();
    let place = |name: &str| work.path().join(name).to_str().unwrap().to_string();
    let sweeps = ["--set", "solver.method=gauss_seidel", "--set", "solver.friction=exact"];
    // Lines that are due in the middle between two steps are in the same one.
    let between = ["--set", "probes.interval=0.00175"];
    let all = [("pour", 1000, &[][..]), ("pour", 1000, &sweeps), ("pendulums", 800, &[]), ("pendulums", 800, &between)];
    for (case, (model, steps, set)) in all.into_iter().enumerate() {
        let path = format!("sim/models/{model}.yaml");
        let (half, whole) = if model == "pour" { ("0.5", "1.0") } else { ("0.2", "0.4") };
        let (one, two) = (place(&format!("{case}a")), place(&format!("{case}b")));
        let run = |rest: &[&str]| scree(&[&["simulate", &path][..], set, rest].concat()).ok();
        run(&["--until", whole, "--threads", "1", "-o", &one]);
        run(&["--until", half, "--threads", "2", "-o", &two]);
        run(&["--until", whole, "--threads", "7", "--resume", "-o", &two]);
        let last = format!("checkpoints/{steps:09}.state");
        for file in [last.as_str(), "probes.csv"] {
            let read = |run: &str| std::fs::read(Path::new(run).join(file)).unwrap();
            assert!(read(&one) == read(&two), "{model}: {file} differs");
        }
        assert!(bytes(&Path::new(&one).join("frames")) == bytes(&Path::new(&two).join("frames")), "{model}");
    }
}

#[test]
fn images_do_not_depend_on_the_bucket_size() {
    holds_for_all_bucket_sizes("", "");
}

#[test]
fn blurred_images_do_not_depend_on_the_bucket_size() {
    holds_for_all_bucket_sizes(
        "Shutter 0 1 DepthOfField 2 0.5 5",
        "MotionBegin [0 0.3 1] Translate 0 0 0 Translate 0.2 0 0 Translate 0.3 0.2 0 MotionEnd",
    );
}

/// Draw with buckets of several sizes and numbers of threads: the same bits.
fn holds_for_all_bucket_sizes(options: &str, moves: &str) {
    let work = scratch();
    let mut images = Vec::new();
    for (size, threads) in [(8, "1"), (16, "2"), (37, "3"), (64, "7"), (200, "2")] {
        let scene = format!(
            "Option \"limits\" \"uniform integer bucketsize\" [{size}]
Format 150 100 1 PixelSamples 3 3 PixelFilter \"catmull-rom\" 4 4 Display \"p{size}.png\" \"file\" \"rgba\"
{options} Projection \"perspective\" \"fov\" 40 Translate 0 0 5
WorldBegin
LightSource \"distantlight\" 1 \"to\" [1 -1 2]
TransformBegin {moves}
Displacement \"rock\" \"uniform float Km\" [0.1] \"uniform float size\" [0.4]
Color 1 .5 .2 Sphere 1 -1 1 360
TransformBegin Translate 0.8 0.2 -1 Opacity .5 .5 .5 Color .2 .5 1 Sphere .6 -.6 .6 360 TransformEnd
TransformEnd
Displacement \"null\" Opacity 1 1 1
Polygon \"P\" [-5 -1 -2 5 -1 -2 5 -1 30 -5 -1 30]
WorldEnd
"
        );
        let path = work.path().join("t.rib");
        std::fs::write(&path, scene).unwrap();
        let out = work.path().to_str().unwrap();
        scree(&["render", path.to_str().unwrap(), "--threads", threads, "-o", out]).ok();
        images.push(std::fs::read(work.path().join(format!("p{size}.png"))).unwrap());
    }
    assert!(images.iter().all(|p| *p == images[0]));
}

#[test]
fn shards_are_stitched_to_the_image_of_one_render() {
    let work = scratch();
    let at = |name: &str| work.path().join(name);
    let text = |name: &str| at(name).to_str().unwrap().to_string();
    let scene = "Option \"limits\" \"integer bucketsize\" [16] Format 150 100 1 PixelSamples 3 3 PixelFilter \"mitchell\" 4 4 Shutter 0 1
Display \"a.png\" \"file\" \"rgba\" Display \"+b.exr\" \"file\" \"rgb\" Imager \"background\" \"bgcolor\" [.1 .2 .3]
Projection \"perspective\" \"fov\" 40 Translate 0 0 5
WorldBegin
LightSource \"distantlight\" 1 \"to\" [1 -1 2]
MotionBegin [0 1] Translate 0 0 0 Translate 0.2 0 0 MotionEnd
Displacement \"rock\" \"uniform float Km\" [0.1] \"uniform float size\" [0.4] Color 1 .5 .2 Sphere 1 -1 1 360
WorldEnd
";
    std::fs::write(at("t.rib"), scene).unwrap();
    scree(&["render", &text("t.rib"), "-o", &text("whole")]).ok();
    // More shards than buckets, too: the last ones have none.
    for parts in [1, 2, 3, 16, 80] {
        let folder = text(&format!("in{parts}"));
        for part in (1..=parts).rev() {
            let shard = format!("{part}/{parts}");
            scree(&["render", &text("t.rib"), "--bucket", &shard, "--threads", "2", "-o", &folder]).ok();
        }
        scree(&["stitch", &folder]).ok();
        assert!(bytes(Path::new(&folder)) == bytes(&at("whole")), "{parts} parts");
    }
    // Missing and truncated shards are reported, and no image is written.
    let folder = text("broken");
    for part in [1, 3] {
        scree(&["render", &text("t.rib"), "--bucket", &format!("{part}/3"), "-o", &folder]).ok();
    }
    let said = scree(&["stitch", &folder]).fails(5);
    assert!(said.contains("a.png: shard 2 of 3") && !at("broken/a.png").exists(), "{said}");
    scree(&["render", &text("t.rib"), "--bucket", "2/3", "-o", &folder]).ok();
    let truncated = at("broken/a.png.part-2-of-3");
    let whole = std::fs::read(&truncated).unwrap();
    std::fs::write(&truncated, &whole[..whole.len() - 7]).unwrap();
    let said = scree(&["stitch", &folder]).fails(4);
    assert!(said.contains("truncated") && !at("broken/a.png").exists(), "{said}");
    scree(&["render", &text("t.rib"), "--bucket", "4/3"]).fails(2);
}
