//! Films: what is drawn again and what is kept, by the ledger of images; tasks, and the scripts of schedulers.

use crate::cli::{scratch, scree};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

const SHADER: &str = "surface paint(float k = 1) { Ci = k * Cs * Os; Oi = Os; }\n";
const SMALL: [&str; 4] = ["--res", "48x32", "--samples", "2"];

/// A folder with tables `p_0.csv` …, a shader and a metadata file `md.yaml` that draws them.
fn data(n: usize) -> tempfile::TempDir {
    let work = scratch();
    for i in 0..n {
        std::fs::write(work.path().join(format!("p_{i}.csv")), table(i as f64)).unwrap();
    }
    std::fs::write(work.path().join("paint.sl"), SHADER).unwrap();
    let text = "\
data: {csv: 'p_*.csv'}
camera: {eye: [0, -6, 2], look_at: [0, 0, 0]}
objects:
  - name: grains
    position: [x, y, z]
    geometry: {sphere: {radius: 0.4}}
    surface: {name: paint}
    color: {column: speed, map: viridis}
";
    std::fs::write(work.path().join("md.yaml"), text).unwrap();
    work
}

fn table(speed: f64) -> String {
    format!("x,y,z,speed\n-0.6,0,0,0.5\n0.6,0,0,{speed}\n")
}

fn call(args: &[&str], more: &[&str]) -> crate::cli::Answer {
    scree(&[args, more].concat())
}

fn at(work: &Path, name: &str) -> String {
    work.join(name).to_str().unwrap().into()
}

/// The images of a folder, by name.
fn images(folder: impl Into<PathBuf>) -> BTreeMap<String, Vec<u8>> {
    let all = crate::cli::images(&folder.into());
    all.iter().map(|p| (p.file_name().unwrap().to_string_lossy().into_owned(), std::fs::read(p).unwrap())).collect()
}

/// Files below a folder that begin with a name.
fn named(folder: &Path, start: &str) -> usize {
    let below = |path: PathBuf| match path.is_dir() {
        true => named(&path, start),
        false => path.file_name().unwrap().to_string_lossy().starts_with(start) as usize,
    };
    std::fs::read_dir(folder).into_iter().flatten().flatten().map(|e| below(e.path())).sum()
}

#[test]
fn just_the_images_that_hang_on_a_change_are_drawn_again() {
    let work = data(4);
    let (md, out) = (at(work.path(), "md.yaml"), at(work.path(), "o"));
    let render = || call(&["render", &md, "-o", &out], &SMALL).errors();
    let first = render();
    assert!(first.contains("go from 0 to 3, the range of all frames"), "{first}");
    assert!(render().contains("4 of 4 images were up to date"));
    let change = |name: &str, text: &str| std::fs::write(work.path().join(name), text).unwrap();
    // A table within the range of the colours: one image.
    change("p_1.csv", &table(1.5));
    let said = render();
    assert!(
        said.contains("3 of 4 images were up to date") && said.contains("1 of 4 images were drawn again"),
        "{said}"
    );
    // A table that makes the range wider: all of them.
    change("p_2.csv", &table(9.0));
    let said = render();
    assert!(said.contains("go from 0 to 9") && said.contains("4 of 4 images were drawn again"), "{said}");
    // A shader: all; the message names it.
    change("paint.sl", &SHADER.replace("k = 1", "k = 0.5"));
    let said = render();
    assert!(said.contains("4 of 4 images were drawn again: stale:") && said.contains("paint.sl has changed"), "{said}");
    // A shader that now stands before one of the library.
    change("background.sl", "imager background() { }\n");
    render();
    // What no image hangs on.
    let text = std::fs::read_to_string(&md).unwrap() + "movie: {frame_rate: 30}\n";
    change("md.yaml", &text);
    assert!(render().contains("4 of 4 images were up to date"));
    // Another size, and a value of the metadata.
    assert!(
        call(&["render", &md, "-o", &out], &["--res", "24x16"]).errors().contains("4 of 4 images were drawn again")
    );
    change("md.yaml", &text.replace("radius: 0.4", "radius: 0.3"));
    assert!(render().contains("4 of 4 images were drawn again"));
    // An image that was edited or lost, and an entry that is broken.
    change("o/000000.png", "no image");
    change("o/.ledger/000001.png.json", "{");
    std::fs::remove_file(work.path().join("o/000002.png")).unwrap();
    let bad = scree(&["verify", &out]).fails(5);
    assert!(bad.contains("3 of 4 images are not done"), "{bad}");
    assert!(render().contains("1 of 4 images were up to date"));
    assert!(scree(&["verify", &out]).ok().contains("4 images are as they were written"));
    assert!(call(&["render", &md, "-o", &out, "--redraw"], &SMALL).errors().find("up to date").is_none());
}

#[test]
fn a_project_that_is_copied_has_its_own_files() {
    let work = data(2);
    let (from, to) = (work.path().to_path_buf(), scratch());
    let render =
        |folder: &Path| call(&["render", &at(folder, "md.yaml"), "-o", &at(folder, "images")], &SMALL).errors();
    render(&from);
    let copy = Command::new("cp").arg("-r").arg(from.join(".")).arg(to.path()).status().unwrap();
    assert!(copy.success() && to.path().join("images/.ledger").is_dir());
    let images = at(to.path(), "images");
    assert!(scree(&["verify", &images]).ok().contains("2 images"));
    assert!(render(to.path()).contains("2 of 2 images were up to date"));
    // What is another in the copy counts there, and not in the original.
    std::fs::write(to.path().join("paint.sl"), SHADER.replace("k = 1", "k = 0.25")).unwrap();
    let verify = |expected: &str| {
        let answer = scree(&["verify", &images]);
        answer.fails(5);
        assert!(answer.said().contains(expected), "{}", answer.said());
    };
    verify("paint.sl has changed");
    assert!(render(to.path()).contains("2 of 2 images were drawn again"));
    assert!(render(&from).contains("2 of 2 images were up to date"));
    // Data that has changed, or is gone, is told of a folder without a plan too, and gaps are.
    std::fs::write(to.path().join("p_1.csv"), table(0.75)).unwrap();
    verify("frame 1: stale");
    for i in 3..6 {
        std::fs::write(to.path().join(format!("p_{i}.csv")), table(0.75)).unwrap();
    }
    assert!(render(to.path()).contains("frame 2 is missing between the others"));
    std::fs::remove_file(to.path().join("p_5.csv")).unwrap();
    assert!(render(to.path()).contains("000005.png): what is there stays"));
    verify("frame 5: of a frame that the data does not have");
}

#[cfg(unix)]
#[test]
fn a_render_that_is_killed_again_and_again_ends_as_one_that_is_not() {
    let work = data(30);
    let (md, out, alone) = (at(work.path(), "md.yaml"), at(work.path(), "o"), at(work.path(), "alone"));
    call(&["render", &md, "-o", &alone], &SMALL).ok();
    for k in 0..6 {
        let mut child = Command::new(env!("CARGO_BIN_EXE_scree"))
            .args([&["render", &md, "-o", &out][..], &SMALL].concat())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(std::time::Duration::from_millis(40 + 37 * k));
        child.kill().unwrap();
        child.wait().unwrap();
    }
    call(&["render", &md, "-o", &out], &SMALL).ok();
    assert!(images(&out) == images(&alone));
    assert_eq!(named(Path::new(&out), ".part-"), 0);
}

#[test]
fn two_renders_into_one_folder_share_the_work() {
    let work = data(12);
    let (md, out, alone) = (at(work.path(), "md.yaml"), at(work.path(), "o"), at(work.path(), "alone"));
    call(&["render", &md, "-o", &alone], &SMALL).ok();
    let start = || {
        let mut command = Command::new(env!("CARGO_BIN_EXE_scree"));
        command.args([&["render", &md, "-o", &out, "--stats"][..], &SMALL].concat()).stderr(Stdio::piped());
        command.spawn().unwrap()
    };
    let both = [start(), start()].map(|child| child.wait_with_output().unwrap());
    assert!(both.iter().all(|output| output.status.success()));
    assert!(images(&out) == images(&alone));
    assert_eq!(scree(&["verify", &out]).ok().split_whitespace().next(), Some("12"));
}

#[test]
fn renders_of_other_settings_into_one_folder_are_told() {
    let work = data(24);
    let (md, out) = (at(work.path(), "md.yaml"), at(work.path(), "o"));
    let mut long = Command::new(env!("CARGO_BIN_EXE_scree"));
    long.args(["render", &md, "-o", &out, "--res", "320x180", "--samples", "4"]).stderr(Stdio::piped());
    let long = long.spawn().unwrap();
    while !work.path().join("o/000000.png").exists() {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    call(&["render", &md, "-o", &out, "--frames", "0"], &SMALL).ok();
    let ended = long.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&ended.stderr);
    assert_eq!(ended.status.code(), Some(5), "{said}");
    assert!(said.contains("another command has drawn 1 of the 24 images") && said.contains("000000.png"), "{said}");
}

/// The model of a falling block, in a folder, and the folder of its film.
fn film(folder: &Path) -> (String, String) {
    let model = folder.join("it's a drop.yaml");
    std::fs::write(
        &model,
        "step: 0.002
duration: 0.2
frame_rate: 20
materials: {stone: {density: 2600, friction: 0.5}}
bodies:
  - {name: ground, material: stone, plane: {normal: [0, 0, 1]}}
  - {name: block, material: stone, box: {size: [0.2, 0.2, 0.2]}, position: [0, 0, 0.2]}
",
    )
    .unwrap();
    (model.to_str().unwrap().into(), at(folder, "film $(x)"))
}

#[test]
fn a_film_that_is_damaged_is_mended() {
    let work = scratch();
    let (model, home) = film(work.path());
    call(&["submit", &model, "-o", &home, "--scheduler", "local"], &SMALL).ok();
    assert!(scree(&["resume", &home]).ok().contains("all is done"));
    // A task that fails is named, the others are done, and it goes on.
    let image = Path::new(&home).join("images/000002.png");
    std::fs::remove_file(&image).unwrap();
    std::fs::create_dir(&image).unwrap();
    let failed = scree(&["resume", &home]).fails(5);
    assert!(failed.contains("draw-2") && failed.contains("000002.png"), "{failed}");
    let status = scree(&["status", &home]).ok();
    assert!(status.contains("images: 3 of 4 done") && status.contains("task draw-2 failed: "), "{status}");
    assert!(status.contains("nobody works on what is left"), "{status}");
    std::fs::remove_dir(&image).unwrap();
    scree(&["resume", &home]).ok();
    // A frame that is damaged or lost is simulated again, a movie made again; until then they are not done.
    let spoil = |path: &Path| std::fs::write(path, "no frame").unwrap();
    let remove = |path: &Path| std::fs::remove_file(path).unwrap();
    for damage in [&spoil as &dyn Fn(&Path), &remove] {
        damage(&Path::new(&home).join("frames/000002.arrow"));
        let movie = std::fs::read_dir(&home).unwrap().flatten().map(|entry| entry.path());
        let movies = movie.filter(|path| path.extension().is_some_and(|e| e == "mp4" || e == "apng"));
        movies.for_each(|path| std::fs::remove_file(path).unwrap());
        assert!(scree(&["status", &home]).ok().contains("movie: not there"));
        let bad = scree(&["verify", &home]).fails(5);
        assert!(bad.contains("2 other parts") || bad.contains("1 of 4 images and 2 other parts"), "{bad}");
        scree(&["resume", &home]).ok();
        assert!(scree(&["verify", &home]).ok().contains("4 images"));
    }
    // So is a run whose index is damaged.
    let index = Path::new(&home).join("run.json");
    let whole = std::fs::read(&index).unwrap();
    std::fs::write(&index, &whole[..whole.len() / 2]).unwrap();
    let status = scree(&["status", &home]).ok();
    assert!(status.contains("is not a run's index") && status.contains("; it is cut off or was replaced"), "{status}");
    assert!(!status.contains(" | "), "what a line quotes is left out: {status}");
    scree(&["verify", &home]).fails(4);
    scree(&["resume", &home]).ok();
    assert!(scree(&["verify", &home]).ok().contains("4 images"));
    // A film of a run that was there, whose model is another since.
    call(&["submit", &model, "-o", &home, "--scheduler", "local"], &SMALL).ok();
    let text = std::fs::read_to_string(&model).unwrap();
    std::fs::write(&model, text.replace("friction: 0.5", "friction: 0.4")).unwrap();
    let bad = scree(&["verify", &home]).fails(5);
    assert!(bad.contains("4 of 4 images and 1 other part"), "{bad}");
}

/// Frames may be drawn in any order: the movie has theirs.
#[test]
fn a_movie_has_the_order_of_the_frames() {
    let work = data(3);
    let metadata = at(work.path(), "md.yaml");
    let movie = |name: &str, more: &[&str]| {
        let home = at(work.path(), name);
        call(&[&["run", &metadata, "-o", &home], more].concat(), &SMALL).ok();
        let mut entries = std::fs::read_dir(&home).unwrap().flatten().map(|entry| entry.path());
        std::fs::read(entries.find(|path| path.is_file()).unwrap()).unwrap()
    };
    let forwards = movie("forwards", &["-f", "0-2"]);
    assert!(movie("backwards", &["-f", "2,1,0"]) == forwards);
    assert!(movie("forwards", &["-f", "1,0"]) == forwards, "a part of the images replaces no movie");
    assert!(movie("forwards", &["-f", "2,0,1", "--redraw"]) == forwards);
}

#[test]
fn a_film_is_made_by_tasks_of_this_machine() {
    let work = scratch();
    let (model, home) = film(work.path());
    let submit = ["submit", &model, "-o", &home, "--scheduler", "local", "-j", "2", "--buckets", "2"];
    call(&submit, &SMALL).ok();
    let status: serde_json::Value = serde_json::from_str(&scree(&["status", &home, "--json"]).ok()).unwrap();
    assert_eq!((&status["images"], &status["done"]), (&4.into(), &4.into()), "{status}");
    assert!(named(Path::new(&home), "it's a drop.") > 0, "there is no movie");
    assert!(scree(&["verify", &home]).ok().contains("4 images"));
    // As one render draws them.
    let alone = at(work.path(), "alone");
    call(&["render", &home, "-o", &alone], &SMALL).ok();
    assert!(images(Path::new(&home).join("images")) == images(&alone));
    assert!(scree(&["task", &home, "draw-99"]).fails(2).contains("no task of the plan"));
    // What stands in a plan is not taken on trust.
    let plan = Path::new(&home).join("plan/plan.json");
    let text = std::fs::read_to_string(&plan).unwrap();
    for (from, to, code, expected) in [
        ("\"allow_programs\": false", "\"allow_programs\": true", 2, "--trust says that it is yours"),
        ("\"directives\": []", "\"directives\": [\"-x\\nrm -r /\"]", 4, "texts of several lines"),
        ("\"frames_per_task\": 1", "\"frames_per_task\": 0", 4, "tasks of nothing"),
        ("{", "{ \"zz\": 1,", 4, "is not a plan"),
    ] {
        assert!(text.contains(from), "{from} is not in {text}");
        std::fs::write(&plan, text.replacen(from, to, 1)).unwrap();
        assert!(scree(&["resume", &home]).fails(code).contains(expected), "{to}");
    }
    std::fs::write(&plan, &text).unwrap();
    let other = at(work.path(), "other.yaml");
    std::fs::copy(model, &other).unwrap();
    let refused = scree(&["submit", &other, "-o", &home, "--scheduler", "local"]).fails(2);
    assert!(refused.contains("holds the film of"), "{refused}");
    // A plan that was moved does not write where it was.
    let moved = at(work.path(), "moved");
    std::fs::rename(&home, &moved).unwrap();
    assert!(scree(&["resume", &moved]).fails(4).contains("moved or copied"));
}

#[test]
fn each_segment_of_a_simulation_has_the_frames_that_are_drawn_of_it() {
    let work = scratch();
    let (model, home) = film(work.path());
    let md = at(work.path(), "md.yaml");
    let head = "model: \"it's a drop.yaml\"\ncamera: {eye: [0, -3, 1], look_at: [0, 0, 0]}\nmovie: {frame_rate: 10}\noutput: {levels: [0.1, 0.9]}\n";
    let object = "objects: [{name: b, select: class == 'block', position: [pos_x, pos_y, pos_z], geometry: {sphere: {radius: 0.1}}}]\n";
    std::fs::write(&md, format!("{head}{object}")).unwrap();
    let submit = ["submit", &md, "-o", &home, "--scheduler", "local", "--segments", "2"];
    // Levels of the film that are not given are those of the whole run.
    let open = std::fs::read_to_string(&md).unwrap().replace("levels: [0.1, 0.9]", "format: png");
    std::fs::write(at(work.path(), "open.yaml"), open).unwrap();
    let open = [
        "submit",
        &at(work.path(), "open.yaml"),
        "-o",
        &at(work.path(), "o"),
        "--scheduler",
        "local",
        "--segments",
        "2",
    ];
    assert!(scree(&open).fails(2).contains("its output `levels`"));
    call(&submit, &SMALL).ok();
    let plan: serde_json::Value =
        serde_json::from_slice(&std::fs::read(Path::new(&home).join("plan/plan.json")).unwrap()).unwrap();
    let until = plan["simulation"]["until"][0].to_string();
    let first = at(work.path(), "first");
    scree(&["simulate", &model, "-o", &first, "--until", &until]).ok();
    assert_eq!(named(&Path::new(&first).join("frames"), "00000"), 2, "{plan}");
    // The rate of a movie is a part of it, and so is the model of a run.
    assert!(scree(&["verify", &home]).ok().contains("4 images"));
    let verify = |expected: &str| {
        let answer = scree(&["verify", &home]);
        answer.fails(5);
        assert!(answer.said().contains(expected), "{}", answer.said());
    };
    std::fs::write(&md, format!("{head}{object}").replace("frame_rate: 10", "frame_rate: 5")).unwrap();
    verify("movie: stale");
    let text = std::fs::read_to_string(&model).unwrap();
    std::fs::write(&model, text.replace("friction: 0.5", "friction: 0.6")).unwrap();
    verify("has changed since it was simulated");
}

#[test]
fn sweeps_resume_what_is_open() {
    let work = scratch();
    let (model, home) = film(work.path());
    let text = std::fs::read_to_string(&model).unwrap();
    std::fs::write(&model, format!("{text}sweep: {{materials.stone.friction: [0.2, 0.4, 0.6]}}\n")).unwrap();
    let submit = ["submit", &model, "-o", &home, "--scheduler", "local"];
    assert!(scree(&[&submit[..], &["--chain", "2"]].concat()).fails(2).contains("are of a single run"));
    scree(&submit).ok();
    assert!(scree(&["resume", &home]).ok().contains("all is done"));
    let frame = Path::new(&home).join("friction=0.4/frames/000001.arrow");
    std::fs::write(&frame, "cut").unwrap();
    scree(&["verify", &home]).fails(5);
    assert!(scree(&["resume", &home]).errors().contains("tasks: 1,"));
    scree(&["verify", &home]).ok();
}

#[test]
fn scripts_of_schedulers_are_as_they_should_be() {
    let work = data(20);
    let (md, home) = (at(work.path(), "md.yaml"), at(work.path(), "film"));
    let requests = ["--time", "1:00:00", "--mem", "4G", "--cpus", "2", "--partition", "night", "--max-running", "3"];
    let script = |scheduler: &str, more: &[&str]| {
        let all = ["submit", &md, "-o", &home, "--dry-run", "--frames-per-task", "2", "--scheduler", scheduler];
        scree(&[&all[..], &requests, more].concat()).ok()
    };
    let expected = [
        ("slurm", vec!["#SBATCH --array=0-9%3", "#SBATCH --time=1:00:00", "#SBATCH --mem=4G", "SLURM_ARRAY_TASK_ID"]),
        ("pbs", vec!["#PBS -J 0-9%3", "#PBS -l select=1:ncpus=2:mem=4G", "#PBS -q night", "PBS_ARRAY_INDEX"]),
        ("torque", vec!["#PBS -t 0-9%3", "#PBS -l nodes=1:ppn=2", "#PBS -l mem=4G", "PBS_ARRAYID"]),
        ("gridengine", vec!["#$ -t 1-10", "#$ -tc 3", "#$ -pe smp 2", "#$ -l h_vmem=4G", "index=$((SGE_TASK_ID - 1))"]),
    ];
    for (scheduler, lines) in expected {
        let text = script(scheduler, &[]);
        lines.iter().for_each(|line| assert!(text.contains(line), "{scheduler}: {line} is not in\n{text}"));
        assert!(text.contains("\"draw-$index\"") && text.contains(" finish '--threads' '2'\n"), "{text}");
        let check = Command::new("bash").args(["-n", "-c", &text]).output().unwrap();
        assert!(check.status.success(), "{}", String::from_utf8_lossy(&check.stderr));
    }
    assert!(!Path::new(&home).exists(), "a dry run has written");
    let text = script("slurm", &["--requeue", "--directive=--constraint=avx2", "-f", "3,7-9", "--buckets", "2"]);
    for line in ["#SBATCH --requeue", "#SBATCH --constraint=avx2", "#SBATCH --array=0-3%3", "scontrol requeue"] {
        assert!(text.contains(line), "{line} is not in\n{text}");
    }
    // A template of the user's.
    let template = at(work.path(), "own.sh");
    std::fs::write(&template, "#!/bin/sh\n#OWN {{ name }} {{ array }}\n{{ setup }}\nnice {{ command }}\n").unwrap();
    let text = script("slurm", &["--template", &template]);
    assert!(text.contains("#OWN scree-film-draw-0 0-9") && text.contains("\nnice '"), "{text}");
    std::fs::write(&template, "{{ command }} {{ nome }}").unwrap();
    let submit = ["submit", &md, "--scheduler", "slurm", "--dry-run", "--template", &template];
    assert!(scree(&submit).fails(3).contains("own.sh"));
    assert!(scree(&["submit", &md, "--scheduler", "local", "--time", "1"]).fails(2).contains("takes no requests"));
    assert!(scree(&["status", &at(work.path(), "none")]).fails(4).contains("neither a plan"));
}

#[cfg(target_os = "linux")]
#[test]
fn two_simulations_do_not_share_a_directory() {
    let work = scratch();
    let model = at(work.path(), "m.yaml");
    let text = "step: 0.001
duration: 60
materials: {stone: {density: 2600, friction: 0.5}}
bodies:
  - {name: ground, material: stone, plane: {normal: [0, 0, 1]}}
  - {name: block, material: stone, box: {size: [0.2, 0.2, 0.2]}, position: [0, 0, 0.2]}
";
    std::fs::write(&model, text).unwrap();
    let run = at(work.path(), "run");
    let mut child = Command::new(env!("CARGO_BIN_EXE_scree"))
        .args(["simulate", &model, "-o", &run])
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    while !Path::new(&run).join("run.json").exists() && child.try_wait().unwrap().is_none() {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let refused = scree(&["simulate", &model, "-o", &run, "--fresh"]).fails(2);
    assert!(refused.contains("another process is simulating into it"), "{refused}");
    child.kill().unwrap();
    child.wait().unwrap();
    // One that was killed holds nothing.
    scree(&["simulate", &model, "-o", &run, "--fresh", "--until", "0.05"]).ok();
}
