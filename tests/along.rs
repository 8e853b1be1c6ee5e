//! Images that are drawn while their frames are simulated: each as soon as it can be, the same as afterwards, and none in the way of the
//! simulation.

use crate::cli::{Answer, images, scratch, scree};
use crate::devices::has_adapter;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, SystemTime};

/// Stones that fall, in so many short steps that images are drawn meanwhile.
const MODEL: &str = "# Stones that fall.
step: 0.0001
duration: 0.8
frame_rate: 10
checkpoint_interval: 0.2
materials: {stone: {density: 2600, friction: 0.5}}
bodies:
  - {name: ground, material: stone, plane: {normal: [0, 0, 1]}}
  - {name: block, material: stone, fixed: true, box: {size: [0.4, 0.4, 0.2]}, position: [0, 0, 0.1]}
fills:
  - {name: stones, material: stone, count: 40, radius: [0.03, 0.05], min: [-0.3, -0.3, 0.3], max: [0.3, 0.3, 1.2]}
probes: {contact_tables: true}
";

/// What the whole run would not change: a camera that turns, a time, colours of a range, trails, forces of contacts.
const METADATA: &str = "# Stones, their trails and forces.
model: model.yaml
camera: {eye: [1.2, -1.6, 0.9], look_at: [0, 0, 0.2], turns: 1}
objects:
  - {name: stones, select: class == 'stones', geometry: {sphere: {radius: half_x}}, color: {column: speed, range: [0, 3]}}
  - {name: trails, select: class == 'stones', geometry: {trail: {frames: 3}}, color: [0.1, 0.3, 0.8]}
  - name: forces
    rows: contacts
    geometry: {arrow: {vector: [force_x, force_y, force_z], scale: 0.001}}
    color: [0.8, 0.1, 0.1]
  - {name: block, select: class == 'block', geometry: {box: {half: [half_x, half_y, half_z]}}}
overlays: {time: true}
output: {levels: [0.04, 0.95]}
";

/// Number of the frames.
const N: usize = 8;

/// A folder with a model and metadata.
struct Work(tempfile::TempDir);

impl Work {
    fn new(model: &str, metadata: &str) -> Work {
        let work = scratch();
        std::fs::write(work.path().join("model.yaml"), model).unwrap();
        std::fs::write(work.path().join("md.yaml"), metadata).unwrap();
        Work(work)
    }

    fn at(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// The arguments of `scree run` into a folder.
    fn words(&self, folder: &str, more: &[&str]) -> Vec<String> {
        let [md, home] = ["md.yaml", folder].map(|name| self.at(name).display().to_string());
        let own = ["run", &md, "-o", &home, "--res", "48x27", "--samples", "2"].map(String::from);
        own.into_iter().chain(more.iter().map(|word| word.to_string())).collect()
    }

    fn run(&self, folder: &str, more: &[&str]) -> Answer {
        let words = self.words(folder, more);
        scree(&words.iter().map(String::as_str).collect::<Vec<_>>())
    }

    /// The images of a run, in the order of their frames.
    fn images(&self, folder: &str) -> Vec<Vec<u8>> {
        images(&self.at(folder).join("images")).iter().map(|path| std::fs::read(path).unwrap()).collect()
    }
}

fn changed(path: &Path) -> SystemTime {
    path.metadata().unwrap().modified().unwrap()
}

/// Whether the first image of a run is older than its last frame.
fn is_drawn_along(home: &Path) -> bool {
    changed(&home.join("images/000000.png")) < changed(&home.join(format!("frames/{:06}.arrow", N - 1)))
}

#[test]
fn images_drawn_along_are_those_drawn_afterwards() {
    let work = Work::new(MODEL, METADATA);
    let said = work.run("along", &[]);
    assert!(said.ok().contains(&format!("images: {N}")) && is_drawn_along(&work.at("along")), "{}", said.errors());
    for task in ["simulating: 0 of 8", "rendering: 0 of 8", "simulating: done", "rendering: done"] {
        assert!(said.errors().contains(task), "{task}: {}", said.errors());
    }
    let after = work.at("after").display().to_string();
    scree(&["simulate", work.at("model.yaml").to_str().unwrap(), "-o", &after]).ok();
    work.run("after", &[]).ok();
    assert!(!is_drawn_along(&work.at("after")));
    assert!(work.images("along").len() == N && work.images("along") == work.images("after"));
    // Nothing is left to draw, by whatever command.
    for folder in ["along", "after"] {
        let said = work.run(folder, &[]);
        assert!(said.errors().contains("8 of 8 images were up to date"), "{}", said.errors());
    }
}

/// Frames in the order of a list, of which a later one may come first.
#[test]
fn chosen_frames_are_drawn_along() {
    let work = Work::new(MODEL, METADATA);
    let said = work.run("some", &["-f", "3,0-7x2"]);
    assert!(said.ok().contains("images: 5") && is_drawn_along(&work.at("some")), "{}", said.errors());
    let names: Vec<String> =
        images(&work.at("some/images")).iter().map(|p| p.file_stem().unwrap().to_string_lossy().into()).collect();
    assert_eq!(names, ["000000", "000002", "000003", "000004", "000006"]);
    // What no frame will be is said before anything is simulated.
    let said = work.run("none", &["-f", "8"]).fails(2);
    assert!(said.contains("there is no frame 8; the data has 8 frames") && !work.at("none").exists(), "{said}");
}

#[test]
fn what_the_whole_run_tells_is_drawn_once_it_is_there() {
    let cases = [
        ("levels: [0.04, 0.95]", "quality: draft", "the output's `levels` depends"),
        ("color: {column: speed, range: [0, 3]}", "color: {column: speed}", "the `range` of the colours of `stones`"),
        ("scale: 0.001", "width: 0.01", "the `scale` of the arrows of `forces`"),
        ("turns: 1}", "follow: \"class == 'stones'\", damping: 2}", "the camera's `damping`"),
        ("{time: true}", "{time: true, plot: contacts}", "the overlay `plot`"),
    ];
    for (given, open, says) in cases {
        assert!(METADATA.contains(given), "{given}");
        let work = Work::new(&MODEL.replace("step: 0.0001", "step: 0.001"), &METADATA.replace(given, open));
        let said = work.run("run", &["-f", "0,7"]);
        said.ok();
        let says = format!("note: the images are drawn once the simulation has ended: {says}");
        assert!(said.errors().contains(&says), "{}", said.errors());
        assert!(!is_drawn_along(&work.at("run")));
    }
}

/// A simulation that ends early ends the drawing: with its own message and exit code, and the images that are done.
#[test]
fn a_simulation_that_fails_ends_the_drawing() {
    let springs: String = (0..6)
        .map(|k| {
            format!("  - {{name: s{k}, a: world, b: bob, position: [-1, 0, 3], position_b: [0, 0, 0], stiffness: 1e+9, rest: 0.9, from: 0.55}}\n")
        })
        .collect();
    let bob = "  - {name: bob, material: stone, sphere: {radius: 0.1}, position: [0, 0, 3]}\nfills:";
    let model = format!("{}on_divergence: stop\nsprings:\n{springs}", MODEL.replace("fills:", bob));
    let work = Work::new(&model, METADATA);
    let said = work.run("run", &[]);
    let errors = said.fails(4);
    assert!(errors.contains("diverged at step 55") && errors.contains("frames before 6"), "{errors}");
    let made = images(&work.at("run/images"));
    assert!(!made.is_empty() && made.len() <= 6, "{errors}");
    assert!(errors.contains(&format!("{} of 8 images are done", made.len())) || made.len() == 6, "{errors}");
    made.iter().for_each(|path| assert_eq!(image::open(path).unwrap().width(), 48));
    assert!(!said.said().contains("movie"), "{}", said.said());
}

/// What ends a simulation before any frame is there says nothing of images, of which none is under way.
#[test]
fn a_simulation_that_cannot_begin_says_nothing_of_images() {
    let work = Work::new(MODEL, METADATA);
    let taken = work.at("taken");
    std::fs::write(&taken, "a file").unwrap();
    let said = work.run("taken/run", &[]).fails(1);
    assert!(said.contains("taken/run: cannot be written") && !said.contains("image"), "{said}");
    // One that diverges as soon as its first frame is there: the image of that is drawn, or none, and it is said which.
    let pull = "springs:\n  - {name: s, a: world, b: bob, position: [-1, 0, 3], position_b: [0, 0, 0], stiffness: 1e+18, rest: 0.9}\n";
    let bob = "  - {name: bob, material: stone, sphere: {radius: 0.1}, position: [0, 0, 3]}\nfills:";
    let model = format!("{}on_divergence: stop\n{pull}", MODEL.replace("fills:", bob));
    let work = Work::new(&model, METADATA);
    let said = work.run("run", &[]).fails(4);
    let home = work.at("run");
    let n_images = usize::from(home.join("images/000000.png").exists());
    let drawn = if n_images == 1 { "1 of 8 images are done, and stay" } else { "no image is drawn" };
    let draws = format!("{drawn}; `scree render {} -o DIR` draws the frames that are there", home.display());
    assert!(said.contains("frames before 1 are kept") && said.contains(&draws), "{said}");
    assert!(n_images == 1 || !said.contains("images that are being drawn"), "{said}");
    let other = work.at("other").display().to_string();
    scree(&["render", home.to_str().unwrap(), "-o", &other, "--res", "32x18", "--samples", "1"]).fails(5);
    assert_eq!(images(Path::new(&other)).len(), 1);
}

/// A signal ends both; the same command goes on to the same images.
#[cfg(unix)]
#[test]
fn an_interrupted_run_goes_on_by_the_same_command() {
    let work = Work::new(MODEL, METADATA);
    work.run("whole", &[]).ok();
    let child = Command::new(env!("CARGO_BIN_EXE_scree"))
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .args(work.words("run", &[]))
        .stderr(Stdio::piped())
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    while !work.at("run/images/000001.png").exists() {
        std::thread::sleep(Duration::from_millis(2));
    }
    Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    let output = child.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(130), "{said}");
    assert!(said.contains("interrupted at") && said.contains("the same command goes on"), "{said}");
    assert!(said.contains("of 8 images are done, and stay"), "{said}");
    let done = images(&work.at("run/images")).len();
    assert!((2..N).contains(&done), "{done} images");
    let said = work.run("run", &[]);
    said.ok();
    assert!(said.errors().contains("resume: from") && said.errors().contains(&format!("{done} of 8 images were up")));
    assert!(work.images("run") == work.images("whole"));
}

/// What cannot be drawn is said at once, and the simulation goes on to its end.
#[test]
fn a_drawing_that_fails_leaves_the_simulation() {
    let work = Work::new(MODEL, &METADATA.replace("column: speed", "column: spede"));
    let said = work.run("run", &[]).fails(3);
    assert!(said.contains("did you mean `speed`?") && said.contains("the simulation goes on"), "{said}");
    let at = |text: &str| said.find(text).unwrap_or_else(|| panic!("{text}: {said}"));
    assert!(at("the simulation goes on") < at("simulating: done"), "{said}");
    let run = frame::run::RunReader::open(&work.at("run")).unwrap();
    assert!(run.index.complete && run.index.frames.len() == N);
}

/// All on an adapter: frames are drawn as they appear, and are those that are drawn afterwards.
#[test]
fn devices_draw_along() {
    if !has_adapter() {
        return;
    }
    let work = Work::new(&MODEL.replace("step: 0.0001", "step: 0.002"), METADATA);
    // What it takes to compile kernels is longer than so few steps.
    let device = ["--backend", "gpu", "--adapter", "0", "-f", "0,5,7"];
    let said = work.run("along", &device);
    said.ok();
    let errors = said.errors();
    let at = |text: &str| errors.find(text).unwrap_or_else(|| panic!("{text}: {errors}"));
    assert!(at("rendering: 0 of 3") < at("simulating: done") && !errors.contains("the processor"), "{errors}");
    let run = frame::run::RunReader::open(&work.at("along")).unwrap();
    assert_eq!(run.index.backend, "gpu");
    let first = work.images("along");
    work.run("along", &[&device[..], &["--redraw"]].concat()).ok();
    assert!(first.len() == 3 && first == work.images("along"));
}
