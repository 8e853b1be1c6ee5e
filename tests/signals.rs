//! Signals: what ends at once, and what is whole then.
#![cfg(unix)]

use crate::cli::scree;
use crate::runs::{STONES, Work, frames};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

/// Start the command, send it a signal once it is `ready`, and have what it said; it ends with the exit code of an interruption.
fn interrupted(args: &[&str], signal: &str, ready: impl Fn() -> bool) -> String {
    let mut child = Command::new(env!("CARGO_BIN_EXE_scree")).args(args).stderr(Stdio::piped()).spawn().unwrap();
    while !ready() && child.try_wait().unwrap().is_none() {
        std::thread::sleep(Duration::from_millis(1));
    }
    Command::new("kill").args([&format!("-{signal}"), &child.id().to_string()]).status().unwrap();
    let output = child.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(130), "{said}");
    said
}

/// Before the first frame a signal ends the program at once: the many bodies of a model take their time to be made ready.
#[test]
fn a_signal_ends_a_run_that_has_not_begun() {
    let work = Work::new();
    let many = "step: 0.001\nduration: 400\nmaterials: {stone: {density: 2600, friction: 0.5}}\nfills:\n  - \
                {name: grains, material: stone, radius: [0.004, 0.005], min: [-1, -1, 0], max: [1, 1, 0.1], count: 250000}\n";
    let (model, run) = (work.write("m.yaml", many), work.at("run"));
    let has_begun = || Path::new(&run).join("commands.txt").exists();
    let said = interrupted(&["simulate", &model, "-o", &run, "--backend", "cpu"], "TERM", has_begun);
    assert!(said.contains("interrupted: no step is taken yet; the same command begins again"), "{said}");
    assert!(!Path::new(&run).join("frames/000000.arrow").exists(), "{said}");
    scree(&["simulate", &model, "-o", &run, "--until", "0.001"]).ok();
}

/// A signal is sent as soon as the run has frames; the run ends with a checkpoint, from which it resumes to the same bits.
#[test]
fn a_signal_ends_a_run_with_a_checkpoint() {
    let work = Work::new();
    let slow = STONES.replace("duration: 0.1", "duration: 400").replace("frame_rate: 50", "frame_rate: 2");
    for signal in ["TERM", "INT"] {
        let (model, run) = (work.write("m.yaml", &slow), work.at(signal));
        let has_frames = || Path::new(&run).join("frames/000002.arrow").exists();
        let said = interrupted(&["simulate", &model, "-o", &run], signal, has_frames);
        assert!(said.contains("interrupted at") && said.contains("--resume"), "{said}");
        let n = frames(&run).len();
        assert!((3..800).contains(&n), "{n} frames");
        let span = ["--until", "12"];
        scree(&[&["simulate", &model, "-o", &run, "--resume"], &span[..]].concat()).ok();
        let whole = work.at("whole");
        if !Path::new(&whole).exists() {
            scree(&[&["simulate", &model, "-o", &whole], &span[..]].concat()).ok();
        }
        assert_eq!(frames(&run), frames(&whole));
    }
}

#[test]
fn a_signal_ends_a_render_between_whole_images() {
    let work = Work::new();
    let (model, run) = (work.write("m.yaml", STONES), work.at("run"));
    scree(&["simulate", &model, "-o", &run]).ok();
    let first = Path::new(&run).join("images/000000.png");
    let said = interrupted(&["render", &run, "--res", "1600x900", "--samples", "6"], "TERM", || first.exists());
    assert!(said.contains("of 5 images are done; the same command goes on"), "{said}");
    let images = std::fs::read_dir(Path::new(&run).join("images")).unwrap().flatten();
    for path in images.map(|e| e.path()).filter(|p| p.extension().is_some_and(|e| e == "png")) {
        image::open(path).unwrap();
    }
}
