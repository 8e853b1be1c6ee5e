//! Run directories as their user meets them: nothing is lost, nothing is stale, and what was guessed is said.

use crate::cli::{scratch, scree};
use std::path::Path;
use std::process::Command;

/// A pile of few stones on a plane.
pub const STONES: &str = "\
step: 0.002
duration: 0.1
frame_rate: 50
materials: {stone: {density: 2600, friction: 0.5}}
bodies:
  - {name: ground, material: stone, plane: {normal: [0, 0, 1]}}
fills:
  - {name: stones, material: stone, count: 20, radius: [0.03, 0.05], min: [-0.3, -0.3, 0.1], max: [0.3, 0.3, 0.6]}
";

/// Paths below a folder, as arguments.
pub struct Work(tempfile::TempDir);

impl Work {
    pub fn new() -> Work {
        Work(scratch())
    }

    pub fn at(&self, name: &str) -> String {
        self.0.path().join(name).to_str().unwrap().into()
    }

    pub fn write(&self, name: &str, text: &str) -> String {
        std::fs::write(self.0.path().join(name), text).unwrap();
        self.at(name)
    }

    fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.0.path().join(name)).unwrap()
    }
}

/// The frames of a run with their hashes, as `run.json` lists them.
pub fn frames(run: &str) -> Vec<(u64, String)> {
    let text = std::fs::read_to_string(Path::new(run).join("run.json")).unwrap();
    let index: serde_json::Value = serde_json::from_str(&text).unwrap();
    let entry = |f: &serde_json::Value| (f["number"].as_u64().unwrap(), f["hash"].as_str().unwrap().to_string());
    index["frames"].as_array().unwrap().iter().map(entry).collect()
}

#[test]
fn the_run_of_another_model_is_replaced_only_on_request() {
    let work = Work::new();
    let (model, run) = (work.write("m.yaml", STONES), work.at("run"));
    scree(&["simulate", &model, "-o", &run]).ok();
    let before = frames(&run);
    work.write("m.yaml", &STONES.replace("[0.03, 0.05]", "[0.03, 0.04]"));
    for command in ["simulate", "run"] {
        let said = scree(&[command, &model, "-o", &run]).fails(2);
        assert!(said.contains("another model (5 frames); changed since: fills.stones.radius.1"), "{said}");
        assert!(said.contains(&format!("`scree {command} --fresh` replaces it")), "{said}");
    }
    let said = scree(&["simulate", &model, "-o", &run, "--resume"]).fails(2);
    assert!(said.contains("another model"), "{said}");
    assert_eq!(frames(&run), before);
    scree(&["simulate", &model, "-o", &run, "--fresh"]).ok();
    assert_ne!(frames(&run), before);
    // A part of the same run would lose the rest.
    let said = scree(&["simulate", &model, "-o", &run, "--until", "0.05"]).fails(2);
    assert!(said.contains("holds 5 frames of this model, and this run would have 3"), "{said}");
    // Tables of somebody else.
    std::fs::create_dir_all(work.at("mine/frames")).unwrap();
    let table = work.write("mine/frames/p_1.csv", "x,y\n1,2\n");
    let said = scree(&["simulate", &model, "-o", &work.at("mine")]).fails(2);
    assert!(said.contains("is no run directory") && Path::new(&table).exists(), "{said}");
}

#[test]
fn metadata_that_the_user_has_edited_stays() {
    let work = Work::new();
    let (model, run) = (work.write("m.yaml", STONES), work.at("run"));
    scree(&["simulate", &model, "-o", &run]).ok();
    let edited = work.read("run/metadata.yaml").replace("studio.rib", "quarry.rib");
    work.write("run/metadata.yaml", &edited);
    let said = scree(&["simulate", &model, "-o", &run, "--fresh"]);
    said.ok();
    assert!(said.errors().contains("metadata.yaml was edited and stays"), "{}", said.errors());
    assert_eq!(work.read("run/metadata.yaml"), edited);
    std::fs::remove_file(work.at("run/metadata.yaml")).unwrap();
    scree(&["simulate", &model, "-o", &run]).ok();
    assert!(work.read("run/metadata.yaml").contains("studio.rib"));
    // A file that is not scree's is not replaced by a suggestion either.
    let notes = work.write("notes.yaml", "mine: 1\n");
    let said = scree(&["inspect", &run, "--write", &notes]).fails(2);
    assert!(said.contains("notes.yaml") && said.contains("exists"), "{said}");
    assert_eq!(work.read("notes.yaml"), "mine: 1\n");
}

#[test]
fn a_run_resumes_to_a_longer_duration_and_not_to_a_shorter_one() {
    let work = Work::new();
    let long = STONES.replace("duration: 0.1", "duration: 0.2");
    let whole = work.at("whole");
    scree(&["simulate", &work.write("long.yaml", &format!("name: m\n{long}")), "-o", &whole]).ok();
    let (model, run) = (work.write("m.yaml", &format!("name: m\n{STONES}")), work.at("run"));
    scree(&["simulate", &model, "-o", &run]).ok();
    work.write("m.yaml", &format!("name: m\n{long}"));
    scree(&["simulate", &model, "-o", &run, "--resume"]).ok();
    assert_eq!(frames(&run), frames(&whole));
    let said = scree(&["simulate", &model, "-o", &run, "--resume", "--until", "0.1"]).fails(2);
    assert!(said.contains("this run would have 5"), "{said}");
    assert_eq!(frames(&run).len(), 10);
    // A run that ends early is not the model's whole run.
    let early = work.at("early");
    scree(&["simulate", &model, "-o", &early, "--until", "0.1"]).ok();
    scree(&["run", &model, "-o", &early, "--res", "32x18", "--samples", "1", "-f", "0"]).ok();
    assert_eq!(frames(&early), frames(&whole));
}

#[test]
fn a_run_that_stops_when_a_body_appears_resumes_with_the_same_frames() {
    let work = Work::new();
    let model = work.write(
        "m.yaml",
        "name: m
step: 1e-3
duration: 0.2
frame_rate: 20
materials: {m: {density: 1000, friction: 0.5}}
bodies:
  - {name: ground, material: m, plane: {normal: [0, 0, 1]}}
  - {name: first, material: m, sphere: {radius: 0.1}, position: [0, 0, 0.1]}
  - {name: later, material: m, sphere: {radius: 0.1}, position: [0, 0, 0.5], appears: 0.1}
",
    );
    let [whole, run] = ["whole", "run"].map(|name| work.at(name));
    scree(&["simulate", &model, "-o", &whole]).ok();
    scree(&["simulate", &model, "-o", &run, "--until", "0.1"]).ok();
    scree(&["simulate", &model, "-o", &run, "--resume"]).ok();
    assert_eq!(frames(&run), frames(&whole));
}

#[test]
fn files_of_others_and_the_model_itself_are_spared() {
    let work = Work::new();
    let own = work.at("own");
    std::fs::create_dir_all(&own).unwrap();
    let model = work.write("own/model.yaml", STONES);
    for more in [&[][..], &["--fresh"]] {
        for command in ["simulate", "run"] {
            let said = scree(&[&[command, &model, "-o", &own], more].concat()).fails(2);
            assert!(said.contains("would replace the model file itself"), "{said}");
        }
    }
    assert_eq!(work.read("own/model.yaml"), STONES);
    let model = work.write("m.yaml", STONES);
    for file in ["frames/u.csv", "checkpoints/u.state", "contacts/u.csv", "probes.csv", "model.yaml", "report.csv"] {
        let folder = work.at("other");
        let path = Path::new(&folder).join(file);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, "mine").unwrap();
        let said = scree(&["simulate", &model, "-o", &folder]).fails(2);
        assert!(said.contains("is no run directory") && said.contains(file), "{said}");
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "mine");
        std::fs::remove_dir_all(&folder).unwrap();
    }
    let run = work.at("run");
    scree(&["simulate", &model, "-o", &run]).ok();
    let again = scree(&["simulate", &model, "-o", &run]);
    again.ok();
    assert!(
        again.errors().contains("held 5 of 5 frames of this model, which is simulated again"),
        "{}",
        again.errors()
    );
    let sweep = work.write("s.yaml", &format!("{STONES}sweep:\n  step: [0.001, 0.002]\n"));
    assert!(scree(&["simulate", &sweep, "-o", &run]).fails(2).contains("is the directory of one run"));
    let nothing = scree(&["simulate", &model, "-o", &work.at("new"), "--resume"]);
    nothing.ok();
    assert!(nothing.errors().contains("has no checkpoint to resume from"), "{}", nothing.errors());
}

#[test]
fn combinations_keep_apart() {
    let work = Work::new();
    let sweep = |values: &str| work.write("s.yaml", &format!("{STONES}sweep:\n  {values}\n"));
    let out = work.at("out");
    for values in ["step: [0.001, 0.001]", "bodies.ground.name: [a/b, ab]"] {
        let said = scree(&["check", &sweep(values)]).fails(3);
        assert!(said.contains("s.yaml:9:1: combinations 0 and 1 would share the run directory"), "{said}");
    }
    let model = sweep("step: [0.001, 0.002]");
    let said = scree(&["simulate", &model, "-o", &out, "--set", "step=0.0005"]).fails(2);
    assert!(said.contains("--set step=0.0005: the model's `sweep` gives this key its values"), "{said}");
    scree(&["simulate", &model, "-o", &out, "--plan", "--sweep-index", "1"]).fails(2);
    scree(&["simulate", &model, "-o", &out, "--plan", "--set", "materials.stone.friction=0.3"]).ok();
    let two = work.write(
        "two.yaml",
        &format!("{STONES}sweep:\n  bodies.ground.group: [a, b]\n  fills.stones.group: [c]\n  fills.stones.radius.1: [0.05]\n"),
    );
    let shown = scree(&["simulate", &two, "-o", &work.at("two"), "--plan"]).ok();
    assert!(shown.contains("ground.group=a_stones.group=c_radius.1=0.05"), "{shown}");
    let submit = |set: &str| scree(&["submit", &model, "-o", &out, "--scheduler", "local", "--set", set]);
    assert!(submit("step=0.0005").fails(2).contains("`sweep` gives this key its values"));
    submit("materials.stone.friction=0.3").ok();
    assert!(work.read("out/step=0.001/model.yaml").contains("friction: 0.3"));
}

#[test]
fn lost_lines_of_a_series_are_no_resume() {
    let work = Work::new();
    let (model, run) = (work.write("m.yaml", STONES), work.at("run"));
    for name in ["probes.csv", "report.csv"] {
        scree(&["simulate", &model, "-o", &run, "--until", "0.05", "--fresh"]).ok();
        let cut: String = work.read(&format!("run/{name}")).lines().take(5).flat_map(|l| [l, "\n"]).collect();
        work.write(&format!("run/{name}"), &cut);
        let said = scree(&["simulate", &model, "-o", &run, "--resume"]).fails(4);
        assert!(said.contains(name) && said.contains("before the checkpoint, from which it goes on"), "{said}");
    }
}

/// Nobody may read what the command says; its work is done nevertheless.
#[cfg(unix)]
#[test]
fn a_closed_pipe_stops_no_work() {
    let work = Work::new();
    let (model, run) = (work.write("m.yaml", STONES), work.at("run"));
    let command = format!("'{}' simulate '{model}' -o '{run}' 2>&1 | true", env!("CARGO_BIN_EXE_scree"));
    assert!(Command::new("sh").args(["-c", &command]).status().unwrap().success());
    assert_eq!(frames(&run).len(), 5);
    assert!(work.read("run/run.json").contains("\"complete\": true"));
}

#[test]
fn faults_of_replaced_values_are_told_where_they_are_written() {
    let work = Work::new();
    let model = work.write("m.yaml", STONES);
    let run = work.at("run");
    for (set, says) in [
        (
            "solver.iterations=abc",
            "--set solver.iterations=abc: `iterations`: invalid type: string \"abc\", expected a whole number",
        ),
        ("solver.iteratoins=3", "did you mean `iterations`?"),
        ("solver.rest_gap=1", "--set solver.rest_gap=1: `rest_gap` is 1 m, above the envelope of "),
        ("quality=[draft]", "--set quality=[draft]: `quality`: invalid type: sequence, expected a word"),
        ("step=-1", "--set step=-1: `step` is -1, expected a number above 0"),
        ("bodies.grund.mass=3", "did you mean `ground`?"),
        ("materials.ston.friction=0.3", "there is no key, index or name `ston`"),
        ("materials.rock.friction=0.3", "there is no key, index or name `rock`"),
        ("fills.stones.radius=[0.05, x]", "--set fills.stones.radius=[0.05, x]: "),
        ("materials=[", "the value is not YAML"),
    ] {
        let said = scree(&["simulate", &model, "-o", &run, "--set", set]).fails(3);
        assert!(said.contains(says), "{set}: {said}");
        assert!(!said.contains("m.yaml:"), "the file is sound: {said}");
    }
    let said = scree(&["simulate", &model, "-o", &run, "--set", "bodies.ground.sphere={radius: 1}"]).fails(3);
    assert!(said.contains("a value in it is replaced by --set bodies.ground.sphere={radius: 1}"), "{said}");
    let sweep = format!("{STONES}sweep:\n  materials.stone.friction: [0.2, -0.4]\n  step: [0.001, 0.002]\n");
    let model = work.write("s.yaml", &sweep);
    assert!(scree(&["check", &model]).fails(3).contains("s.yaml:10:35: "));
    for plan in [&["--plan"][..], &[]] {
        let said = scree(&[&["simulate", &model, "-o", &run], plan].concat()).fails(3);
        assert!(said.contains("s.yaml:10:35: ") && said.contains("is -0.4"), "{said}");
        assert!(!Path::new(&run).exists(), "nothing is written before all combinations are checked");
    }
}

#[test]
fn hardly_meant_values_are_said() {
    let work = Work::new();
    let odd = STONES.replace("density: 2600", "density: 2.6").replace("frame_rate: 50", "frame_rate: 1000");
    let model = work.write("m.yaml", &odd);
    let said = scree(&["simulate", &model, "-o", &work.at("run"), "--until", "3"]);
    said.ok();
    let said = said.errors();
    let wide = STONES.replace("[-0.3, -0.3, 0.1], max: [0.3", "[-3, -3, 0.1], max: [3");
    let answer = scree(&["simulate", &work.write("w.yaml", &wide), "-o", &work.at("wide")]);
    answer.ok();
    let one_sided = "w.yaml:8:37: 20 spheres cover one side of the region alone";
    assert!(answer.errors().contains(one_sided) && answer.errors().contains("poisson_disk"), "{}", answer.errors());
    for part in [
        "m.yaml:4:21: a density of 2.6 kg/m³",
        "2.6 g/cm³ is 2600",
        "m.yaml:3:1: 1000 frames a second are more than the 500 steps",
        "--until 3 is after the end of the model: its `duration` is 0.1 s",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
}

#[test]
fn a_compound_has_one_id_and_parts_and_forces_have_two_frames() {
    let work = Work::new();
    let text = "\
step: 0.001
duration: 0.02
frame_rate: 100
format: csv
materials: {m: {density: 1000, friction: 0.3}}
bodies:
  - name: bar
    shapes:
      - {box: {size: [0.4, 0.1, 0.1]}, material: m}
      - {sphere: {radius: 0.1}, material: m, position: [0.2, 0, 0]}
    rotate: {axis: [0, 0, 1], angle: 90}
joints:
  - {name: hinge, kind: revolute, a: bar, b: world, position: [0, -0.2, 0], axis: [1, 0, 0]}
";
    let run = work.at("run");
    scree(&["simulate", &work.write("m.yaml", text), "-o", &run]).ok();
    let table = work.read("run/frames/000001.csv");
    let cell = |row: usize, column: usize| table.lines().nth(row).unwrap().split(',').nth(column).unwrap();
    assert_eq!([cell(0, 0), cell(0, 1)], ["id", "part"]);
    assert_eq!([cell(1, 0), cell(1, 1), cell(2, 0), cell(2, 1)], ["0", "0", "0", "1"], "{table}");
    assert!(cell(0, 7).ends_with("[1]") && table.lines().next().unwrap().contains("half_x [m]"), "{table}");
    let probes = work.read("run/probes.csv");
    let header: Vec<&str> = probes.lines().next().unwrap().split(',').collect();
    assert!(header.iter().all(|name| name.ends_with(']')), "every column has a unit: {header:?}");
    let last: Vec<f64> = probes.lines().last().unwrap().split(',').map(|x| x.parse().unwrap()).collect();
    let value = |name: &str| last[header.iter().position(|h| h.starts_with(name)).unwrap()];
    // The hinge's z axis is the world's x. In both frames the force is of one length.
    let length =
        |frame: &str| ["fx", "fy", "fz"].map(|f| value(&format!("hinge.{f}_{frame}")).powi(2)).iter().sum::<f64>();
    assert!((length("joint") / length("world") - 1.0).abs() < 1e-9 && length("world") > 1.0);
    assert!((value("hinge.fz_joint").abs() - value("hinge.fx_world").abs()).abs() < 1e-9);
    assert!(value("hinge.fz_world").abs() > 0.5 * length("world").sqrt());
}

#[test]
fn springs_are_rows_from_point_to_point() {
    let work = Work::new();
    let text = "\
step: 0.001
duration: 0.02
frame_rate: 100
format: csv
materials: {m: {density: 1000, friction: 0.3}}
bodies:
  - {name: bob, material: m, sphere: {radius: 0.1}, position: [0.3, 0, 0.6]}
  - {name: flap, material: m, box: {size: [0.2, 0.2, 0.02]}, position: [2, 0, 1]}
joints:
  - {name: hinge, kind: revolute, a: world, b: flap, position: [1.9, 0, 1], axis: [0, 1, 0]}
springs:
  - {name: coil, a: world, b: bob, position: [0, 0, 1], position_b: [0.3, 0, 0.6], stiffness: 100}
  - {name: late, a: world, b: bob, position: [0, 0, 1], position_b: [0.3, 0, 0.6], stiffness: 100, from: 0.005}
  - {name: return, a: world, b: flap, position: [1.9, 0, 1], about: [0, 1, 0], stiffness: 10}
";
    let run = work.at("run");
    scree(&["simulate", &work.write("m.yaml", text), "-o", &run]).ok();
    let rows = |frame: &str| {
        let table = work.read(&format!("run/frames/{frame}.csv"));
        let mut lines = table.lines().map(|l| l.split(',').map(str::to_string).collect::<Vec<_>>());
        let header = lines.next().unwrap();
        let at = |name: &str| header.iter().position(|h| h.starts_with(name)).unwrap();
        let columns = ["class", "shape", "pos_x", "pos_z", "half_z"].map(at);
        lines.map(|l| columns.map(|c| l[c].clone())).collect::<Vec<_>>()
    };
    let first = rows("000000");
    assert_eq!(first.len(), 3, "{first:?}");
    assert_eq!(first[2], ["coil", "spring", "0.15", "0.8", "0.25"]);
    assert_eq!(rows("000001").iter().map(|r| r[0].clone()).collect::<Vec<_>>(), ["bob", "flap", "coil", "late"]);
    let metadata = work.read("run/metadata.yaml");
    assert!(metadata.contains("- name: coil") && metadata.contains("- name: late"), "{metadata}");
    scree(&["render", &run, "--res", "32x18", "--samples", "1"]).ok();
}

#[test]
fn a_ground_is_left_out_in_scenes_that_have_one() {
    let work = Work::new();
    let run = work.at("run");
    scree(&["simulate", &work.write("m.yaml", STONES), "-o", &run]).ok();
    let metadata = work.read("run/metadata.yaml");
    assert!(metadata.contains("frame_rate: 50"), "a movie as fast as time goes: {metadata}");
    let grounds = |scene: &str| {
        work.write("run/metadata.yaml", &metadata.replace("studio.rib", scene));
        scree(&["rib", &run, "-f", "0"]).ok().matches("Surface \"ground\"").count()
    };
    // The quarry has a surface for a floor, and lays none.
    assert_eq!([grounds("studio.rib"), grounds("quarry.rib")], [1, 2]);
    assert!(
        !scree(&["rib", &run, "-f", "0"]).ok().contains("Polygon \"vertex point P\" [-60 -60 0"),
        "no floor over the ground"
    );
    assert_eq!([grounds("lunar.rib"), grounds("laboratory.rib")], [0, 0]);
}

#[test]
fn what_brings_no_ground_has_the_floor_of_its_scene_under_it() {
    let work = Work::new();
    let scene = |bodies: &str| {
        let head = "step: 0.002\nduration: 0.02\nframe_rate: 50\nmaterials: {m: {density: 2600, friction: 0.5}}\n";
        let model = work.write("m.yaml", &format!("{head}bodies:\n{bodies}"));
        scree(&["simulate", &model, "-o", &work.at("run"), "--fresh"]).ok();
        work.read("run/metadata.yaml").lines().find(|l| l.starts_with("scene: ")).unwrap_or("").to_string()
    };
    let ball = "  - {name: ball, material: m, sphere: {radius: 0.1}, position: [0, 0, 1]}\n";
    let ramp =
        "  - {name: ramp, material: m, fixed: true, box: {size: [2, 1, 0.1]}, rotate: {axis: [0, 1, 0], angle: 20}}\n";
    let ground = "  - {name: ground, material: m, plane: {normal: [0, 0, 1]}}\n";
    assert_eq!(scene(&format!("{ramp}{ball}")), "scene: seamless.rib");
    assert_eq!(scene(&format!("{ground}{ball}")), "scene: studio.rib");
}

#[test]
fn the_ground_of_a_scene_goes_below_the_data() {
    let work = Work::new();
    let height = |bodies: &str| {
        let head = "step: 0.002\nduration: 0.02\nframe_rate: 50\nmaterials: {m: {density: 2600, friction: 0.5}}\n";
        let model = work.write("m.yaml", &format!("{head}{bodies}"));
        let run = work.at("run");
        scree(&["simulate", &model, "-o", &run, "--fresh"]).ok();
        let metadata = work.read("run/metadata.yaml");
        let metadata = metadata.replace("studio.rib", "lunar.rib").replace("seamless.rib", "lunar.rib");
        work.write("run/metadata.yaml", &metadata);
        let rib = scree(&["rib", &run, "-f", "0"]).ok();
        let shift = rib
            .lines()
            .map(str::trim)
            .find(|l| l.starts_with("Translate 0 0 "))
            .map_or(0.0, |l| l.rsplit(' ').next().unwrap().parse::<f64>().unwrap());
        std::fs::remove_dir_all(&run).unwrap();
        (shift, rib.matches("Surface \"ground\"").count())
    };
    // A plane that is not z = 0, terrain with a trough of half a metre, and a ball that nothing carries.
    let plane = "{name: floor, material: m, plane: {normal: [0, 0, 1]}, position: [0, 0, -0.7]}";
    let ball = "{name: ball, material: m, sphere: {radius: 0.1}, position: [0, 0, 0.2]}";
    assert_eq!(height(&format!("bodies: [{plane}, {ball}]\n")), (-0.7, 0));
    let field = "{name: soil, material: m, height_field: {grid: soil.txt, size: [2, 2]}}";
    work.write("soil.txt", "0 0 0\n0 -0.5 0\n0 0 0\n");
    let (below, n_grounds) = height(&format!("bodies: [{field}, {ball}]\n"));
    assert!((-0.55..-0.5).contains(&below) && n_grounds == 1, "{below}");
    let (below, _) = height(&format!("bodies: [{}]\n", ball.replace("0.2]", "-2]")));
    assert!((below - -2.1).abs() < 0.01, "{below}");
}

#[test]
fn a_model_may_be_copied_and_renamed() {
    let work = Work::new();
    let (model, run) = (work.write("m.yaml", STONES), work.at("run"));
    scree(&["simulate", &model, "-o", &run]).ok();
    let copy = work.write("copy.yaml", &STONES.replace("duration: 0.1", "duration: 0.12"));
    scree(&["simulate", &copy, "-o", &run, "--resume"]).ok();
    assert_eq!(frames(&run).len(), 6);
    let changed = work.write("copy.yaml", &STONES.replace("0.1\n", "0.2\n").replace("2600", "2500"));
    let said = scree(&["simulate", &changed, "-o", &run]).fails(2);
    assert!(said.contains("changed since: materials.stone.density\n"), "{said}");
}

#[test]
fn the_camera_goes_with_a_small_machine() {
    let work = Work::new();
    let text = "\
step: 0.002
duration: 0.2
frame_rate: 20
materials: {m: {density: 2600, friction: 0.1}}
bodies:
  - {name: ground, material: m, plane: {normal: [0, 0, 1]}}
  - {name: cart, material: m, box: {size: [0.3, 0.2, 0.1]}, position: [0, 0, 0.05], velocity: [3, 0, 0]}
  - {name: post, material: m, fixed: true, box: {size: [0.3, 0.3, 0.9]}, position: [3, 2, 0.45]}
fills:
  - {name: stones, material: m, count: 200, radius: [0.03, 0.05], packing: poisson_disk, min: [-6, -6, 0.2], max: [6, 6, 0.4]}
";
    let run = work.at("run");
    scree(&["simulate", &work.write("m.yaml", text), "-o", &run]).ok();
    let metadata = work.read("run/metadata.yaml");
    assert!(metadata.contains("follow: class == 'cart'\n"), "{metadata}");
    // What stands still is no subject, nor is what fills the image.
    scree(&["simulate", &work.write("m.yaml", &text.replace("[3, 0, 0]", "[0, 0, 0]")), "-o", &run, "--fresh"]).ok();
    assert!(!work.read("run/metadata.yaml").contains("follow"));
    // Things that stand about neither make the image wider nor hold what lies between them.
    let post = |k: i32| {
        let [x, y] = [20 - 5 * k, if k % 2 == 0 { 15 } else { -15 }];
        format!(
            "  - {{name: p{k}, class: post, material: m, fixed: true, box: {{size: [0.1, 0.1, 0.9]}}, position: [{x}, {y}, 0.45]}}\n"
        )
    };
    let posts: String = (0..8).map(post).collect();
    let wide = text.replace("fills:", &format!("{posts}fills:")).replace("[3, 0, 0]", "[0, 0, 0]");
    scree(&["simulate", &work.write("m.yaml", &wide), "-o", &run, "--fresh"]).ok();
    let metadata = work.read("run/metadata.yaml");
    let eye = metadata.split("eye:\n").nth(1).unwrap().lines().take(3);
    let far = eye.map(|l| l.trim().trim_start_matches("- ").parse::<f32>().unwrap().abs()).fold(0.0, f32::max);
    assert!(far < 40.0 && !metadata.contains("opacity"), "{metadata}");
    let near = text
        .replace("[-6, -6, 0.2], max: [6, 6, 0.4]", "[-1, -1, 0.2], max: [1, 1, 1]")
        .replace("[3, 2, 0.45]", "[1, 2, 0.45]");
    scree(&["simulate", &work.write("m.yaml", &near), "-o", &run, "--fresh"]).ok();
    assert!(!work.read("run/metadata.yaml").contains("follow"));
}

#[test]
fn what_holds_the_grains_is_seen_through() {
    let work = Work::new();
    let text = "\
step: 0.002
duration: 0.1
frame_rate: 50
materials: {m: {density: 2600, friction: 0.5}}
bodies:
  - name: bin
    material: m
    fixed: true
    shapes:
      - {box: {size: [0.02, 0.8, 1.2]}, position: [-0.4, 0, 0.6]}
      - {box: {size: [0.02, 0.8, 1.2]}, position: [0.4, 0, 0.6]}
  - {name: block, material: m, box: {size: [0.2, 0.2, 0.2]}, position: [1, 0, 0.1]}
fills:
  - {name: stones, material: m, count: 80, radius: [0.03, 0.05], min: [-0.35, -0.35, 0.1], max: [0.35, 0.35, 1.1]}
";
    let run = work.at("run");
    scree(&["simulate", &work.write("m.yaml", text), "-o", &run]).ok();
    let metadata = work.read("run/metadata.yaml");
    let object = |name: &str| metadata.split("- name: ").find(|o| o.starts_with(name)).unwrap().to_string();
    assert!(object("bin").contains("opacity: 0.12") && object("bin").contains("name: pane"), "{metadata}");
    assert!(!object("block").contains("opacity") && !object("stones").contains("opacity"), "{metadata}");
    // So are walls with names of their own, but not the floor or what stands beside.
    let wall = |name: &str, x: f64, y: f64| {
        let size = if x == 0.0 { "[0.8, 0.02, 1.2]" } else { "[0.02, 0.8, 1.2]" };
        format!("  - {{name: {name}, material: m, fixed: true, box: {{size: {size}}}, position: [{x}, {y}, 0.6]}}\n")
    };
    let walls =
        [wall("west", -0.4, 0.0), wall("east", 0.4, 0.0), wall("south", 0.0, -0.4), wall("north", 0.0, 0.4)].concat();
    let rest = "  - {name: slab, material: m, fixed: true, box: {size: [2, 2, 0.1]}, position: [0, 0, -0.05]}\n";
    let (head, tail) = (text.split("  - name: bin").next().unwrap(), text.split_once("  - {name: block").unwrap().1);
    let post = |name: &str, x: f64, y: f64| {
        let body = "class: post, material: m, fixed: true, box: {size: [0.04, 0.04, 1.3]}";
        format!("  - {{name: {name}, {body}, position: [{x}, {y}, 0.65]}}\n")
    };
    let posts =
        [post("a", -0.44, -0.44), post("b", 0.44, -0.44), post("c", -0.44, 0.44), post("d", 0.44, 0.44)].concat();
    let model = work.write("w.yaml", &format!("{head}{walls}{posts}{rest}  - {{name: block{tail}"));
    scree(&["simulate", &model, "-o", &run, "--fresh"]).ok();
    let metadata = work.read("run/metadata.yaml");
    let is_clear = |name: &str| {
        metadata.split("- name: ").find(|o| o.starts_with(&format!("{name}\n"))).unwrap().contains("opacity: 0.12")
    };
    assert_eq!(["west", "east", "south", "north"].map(is_clear), [true; 4], "{metadata}");
    assert_eq!(["slab", "post", "block", "stones"].map(is_clear), [false; 4], "{metadata}");
    // Only what is there is listed, and only missing frames that are asked for are missing.
    let shown = scree(&["inspect", &run]).ok();
    assert!(shown.contains("names: sphere, box\n") || shown.contains("names: box, sphere\n"), "{shown}");
}
