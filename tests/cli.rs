//! The command as its user meets it: exit codes, files, messages.

use std::path::PathBuf;
use std::process::{Command, Output};

/// What a call of the command answered.
pub struct Answer {
    /// What it has printed, and how it ended.
    pub output: Output,
    call: String,
}

impl Answer {
    /// Standard output, if the call succeeded.
    pub fn ok(&self) -> String {
        assert!(self.output.status.success(), "scree {} failed: {}", self.call, self.errors());
        String::from_utf8(self.output.stdout.clone()).unwrap()
    }

    /// Standard error, if the call ended with this exit code.
    pub fn fails(&self, code: i32) -> String {
        assert_eq!(self.output.status.code(), Some(code), "scree {}: {}", self.call, self.errors());
        self.errors()
    }

    /// Standard output, whatever the exit code.
    pub fn said(&self) -> String {
        String::from_utf8_lossy(&self.output.stdout).to_string()
    }

    /// Standard error.
    pub fn errors(&self) -> String {
        String::from_utf8_lossy(&self.output.stderr).to_string()
    }
}

/// Call the command from the tree's root.
pub fn scree(args: &[&str]) -> Answer {
    scree_with(&[], args)
}

/// The same with more variables in its environment.
pub fn scree_with(environment: &[(&str, &str)], args: &[&str]) -> Answer {
    let mut command = Command::new(env!("CARGO_BIN_EXE_scree"));
    command.current_dir(env!("CARGO_MANIFEST_DIR")).envs(environment.iter().copied()).args(args);
    Answer { output: command.output().unwrap(), call: args.join(" ") }
}

/// The images of a folder, in the order of their names.
pub fn images(folder: &std::path::Path) -> Vec<PathBuf> {
    let all = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut images: Vec<_> = all.filter(|path| path.extension().is_some_and(|e| e == "png" || e == "exr")).collect();
    images.sort();
    images
}

/// An empty folder that goes away.
pub fn scratch() -> tempfile::TempDir {
    tempfile::tempdir().unwrap()
}

fn write_table(folder: &std::path::Path, name: &str) -> PathBuf {
    let mut text = String::from("x;y;z;radius;speed\n");
    for i in 0..500 {
        let (x, y, z) = (i % 10, i / 10 % 10, i / 100);
        text += &format!("{};{};{};0.045;{}\n", x as f64 * 0.1, y as f64 * 0.1, z as f64 * 0.1, i as f64 * 0.01);
    }
    let path = folder.join(name);
    std::fs::write(&path, text).unwrap();
    path
}

#[test]
fn foreign_tables_are_inspected_drawn_and_coloured() {
    let work = scratch();
    write_table(work.path(), "p_0003.csv");
    let pattern = work.path().join("p_*.csv");
    let metadata = work.path().join("md.yaml");
    let shown = scree(&["inspect", pattern.to_str().unwrap(), "--write", metadata.to_str().unwrap()]).ok();
    assert!(shown.contains("speed") && shown.contains("500 rows"), "{shown}");
    let draw = || {
        let out = work.path().join("o");
        scree(&[
            "render",
            metadata.to_str().unwrap(),
            "-f",
            "3",
            "--res",
            "64x48",
            "--samples",
            "2",
            "-o",
            out.to_str().unwrap(),
        ])
        .ok();
        image::open(out.join("000003.png")).unwrap().to_rgb8()
    };
    let spread = |image: &image::RgbImage| image.pixels().map(|p| p[0].abs_diff(p[2]) as u32).max().unwrap();
    let plain = draw();
    let text = std::fs::read_to_string(&metadata).unwrap();
    let (plain_color, by_speed) = ("color: [0.38, 0.29, 0.21] # or ", "color: ");
    let colored = text.replace(plain_color, by_speed);
    assert_ne!(colored, text);
    std::fs::write(&metadata, colored).unwrap();
    let colored = draw();
    assert!(spread(&colored) > spread(&plain) + 60, "{} {}", spread(&colored), spread(&plain));
}

#[test]
fn usage_and_bad_input_have_their_exit_codes() {
    let work = scratch();
    let there = |name: &str| work.path().join(name).to_str().unwrap().to_string();
    scree(&["simulate"]).fails(2);
    assert!(scree(&["simulate", &there("no.yaml")]).fails(3).contains("no.yaml: cannot be read"));
    scree(&["render", &there("no.yaml")]).fails(3);
    scree(&["render", work.path().to_str().unwrap()]).fails(4);
    scree(&["simulate", "sim/models/pour.yaml", "--until", "-1", "-o", &there("r")]).fails(2);
    scree(&["inspect", &there("p_*.csv")]).fails(4);
    assert!(!work.path().join("r").exists(), "nothing is written where nothing was done");
}

#[test]
fn faults_in_metadata_name_the_nearest_and_the_place() {
    let work = scratch();
    write_table(work.path(), "p_1.csv");
    let metadata = work.path().join("md.yaml");
    let head = "data: {csv: 'p_*.csv'}\ncamera: {eye: [0, -3, 1], look_at: [0, 0, 0]}\nobjects:\n  - name: a\n    position: [x, y, z]\n";
    for (line, expected) in [
        ("    geometry: {sphere: {radius: radus}}", "md.yaml:6:25: unknown column `radus`"),
        (
            "    geometry: {sphere: {radius: radius}}\n    surface: {name: gravl}",
            "md.yaml:7:15: surface shader `gravl.sl`",
        ),
        (
            "    geometry: {sphere: {radius: radius}}\n    surface: {name: gravel, siz: 3}",
            "md.yaml:7:29: unknown parameter of `gravel` `siz`",
        ),
        (
            "    geometry: {sphere: {radius: radius}}\n    select: radius >",
            "md.yaml:7:5: in the expression, at character 9",
        ),
        ("    geometry: {sphere: {radius: radius}}\n    colour: [1, 1, 1]", "md.yaml:7:5: unknown field `colour`"),
    ] {
        std::fs::write(&metadata, format!("{head}{line}\n")).unwrap();
        let said =
            scree(&["render", metadata.to_str().unwrap(), "-o", work.path().join("o").to_str().unwrap()]).fails(3);
        assert!(said.contains(expected), "expected {expected}, found {said}");
        assert!(said.contains("did you mean") || line.contains("select"), "{said}");
    }
    assert!(!work.path().join("o").exists());
}

#[test]
fn an_interrupted_run_is_drawn_as_far_as_it_goes() {
    let work = scratch();
    let run = work.path().join("run");
    let run = run.to_str().unwrap();
    scree(&["simulate", "sim/models/pour.yaml", "--until", "0.2", "-o", run]).ok();
    // As a simulation that was stopped after its third frame would have left it.
    let index = std::fs::read_to_string(format!("{run}/run.json")).unwrap();
    let mut index: serde_json::Value = serde_json::from_str(&index).unwrap();
    index["complete"] = false.into();
    index["frames"].as_array_mut().unwrap().truncate(3);
    std::fs::write(format!("{run}/run.json"), index.to_string()).unwrap();
    let said = scree(&["render", run, "--res", "32x24", "--samples", "1"]).fails(5);
    assert!(said.contains("2 of 5 frames are missing (3 to 4)"), "{said}");
    assert_eq!(images(format!("{run}/images").as_ref()).len(), 3);
    // A frame that was cut off is named, and never drawn.
    let frame = format!("{run}/frames/000001.arrow");
    let bytes = std::fs::read(&frame).unwrap();
    std::fs::write(&frame, &bytes[..bytes.len() / 2]).unwrap();
    assert!(scree(&["render", run, "-f", "1", "--res", "32x24"]).fails(4).contains("000001.arrow"));
}

#[test]
fn an_unwritable_folder_is_a_clear_message() {
    let work = scratch();
    let file = work.path().join("file");
    std::fs::write(&file, "").unwrap();
    let said =
        scree(&["simulate", "sim/models/pour.yaml", "--until", "0.01", "-o", file.join("run").to_str().unwrap()])
            .fails(1);
    assert!(said.contains("run: cannot be written"), "{said}");
}
