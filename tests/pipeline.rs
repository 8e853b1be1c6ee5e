//! The whole way on a small model: run directory, RIB, images.

use crate::cli::{scratch, scree};
use crate::golden;

const MODEL: &str = "# Three stones above the ground.
step: 0.002
duration: 0.2
frame_rate: 20
materials: {m: {density: 2000, friction: 0.5}}
bodies:
  - {name: ground, material: m, plane: {normal: [0, 0, 1]}}
  - {name: block, material: m, fixed: true, box: {size: [0.4, 0.4, 0.2]}, position: [0, 0, 0.1]}
fills:
  - {name: stones, material: m, count: 3, radius: [0.04, 0.05], min: [-0.2, -0.2, 0.3], max: [0.2, 0.2, 0.6]}
";

#[test]
fn from_a_model_to_images_in_one_command() {
    let work = scratch();
    let model = work.path().join("stones.yaml");
    std::fs::write(&model, MODEL).unwrap();
    let home = work.path().join("out");
    let said =
        scree(&["run", model.to_str().unwrap(), "-o", home.to_str().unwrap(), "--res", "64x36", "--samples", "2"]).ok();
    assert!(said.contains("images: 4"), "{said}");
    let movie = said.lines().find_map(|l| l.strip_prefix("movie: ")).expect("a movie or its fallback");
    assert!(std::fs::metadata(movie).unwrap().len() > 500);
    // A missing or truncated image makes no movie.
    let images = home.join("images");
    let last = images.join("000002.png");
    let whole = std::fs::read(&last).unwrap();
    std::fs::write(&last, &whole[..whole.len() / 2]).unwrap();
    assert!(scree(&["movie", images.to_str().unwrap()]).fails(4).contains("000002.png"));
    std::fs::remove_file(&last).unwrap();
    assert!(
        scree(&["movie", images.to_str().unwrap()])
            .fails(4)
            .contains("1 image is missing between the others: frames 2")
    );
    std::fs::write(&last, &whole).unwrap();
    for frame in 0..4 {
        let image = image::open(home.join(format!("images/{frame:06}.png"))).unwrap();
        assert_eq!((image.width(), image.height()), (64, 36));
    }
    // The run directory is as its format says.
    let index: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(home.join("run.json")).unwrap()).unwrap();
    assert_eq!(index["format_version"], 1);
    assert_eq!(index["complete"], true);
    assert_eq!(index["frames"].as_array().unwrap().len(), 4);
    let columns: Vec<&str> = index["columns"].as_array().unwrap().iter().map(|c| c["name"].as_str().unwrap()).collect();
    assert!(
        ["id", "class", "shape", "pos_x", "quat_w", "vel_z", "omega_x", "half_y"].iter().all(|c| columns.contains(c))
    );
    for file in ["model.yaml", "metadata.yaml", "report.csv", "frames/000003.arrow"] {
        assert!(home.join(file).is_file(), "{file}");
    }
    let report = std::fs::read_to_string(home.join("report.csv")).unwrap();
    assert!(report.starts_with("step,time [s],contacts,iterations,residual [m/s],worst_penetration [m]"));
    // The model that was written down runs again, to the same frames.
    let again = work.path().join("again");
    scree(&["simulate", home.join("model.yaml").to_str().unwrap(), "-o", again.to_str().unwrap()]).ok();
    let frame = |folder: &std::path::Path| std::fs::read(folder.join("frames/000003.arrow")).unwrap();
    assert!(frame(&home) == frame(&again));
    // CSV on request has the same columns.
    let tables = work.path().join("tables");
    scree(&["simulate", model.to_str().unwrap(), "--csv", "-o", tables.to_str().unwrap()]).ok();
    let table = std::fs::read_to_string(tables.join("frames/000000.csv")).unwrap();
    assert!(table.starts_with("id,part,class,shape,pos_x [m],"), "{}", &table[..60]);
    scree(&["render", tables.to_str().unwrap(), "-f", "2", "--res", "32x18", "--samples", "1"]).ok();
}

#[test]
fn the_rib_of_a_frame_is_standard_and_draws_the_same() {
    let work = scratch();
    let model = work.path().join("stones.yaml");
    std::fs::write(&model, MODEL).unwrap();
    let run = work.path().join("run");
    let run = run.to_str().unwrap();
    scree(&["simulate", model.to_str().unwrap(), "-o", run]).ok();
    let rib = work.path().join("frame.rib");
    let text = scree(&["rib", run, "-f", "3"]).ok();
    assert_eq!(text.matches("Sphere ").count(), 3);
    assert!(!text.contains("scree inject") && text.contains("WorldBegin") && text.trim_end().ends_with("WorldEnd"));
    std::fs::write(&rib, &text).unwrap();
    let out = work.path().to_str().unwrap();
    scree(&["render", rib.to_str().unwrap(), "-o", out]).ok();
    scree(&["render", run, "-f", "3", "-o", out]).ok();
    let by_rib = std::fs::read(work.path().join("000003.png")).unwrap();
    let direct = work.path().join("direct");
    scree(&["render", run, "-f", "3", "-o", direct.to_str().unwrap()]).ok();
    let by_data = image::open(direct.join("000003.png")).unwrap().to_rgb8();
    let by_rib = image::load_from_memory(&by_rib).unwrap().to_rgb8();
    // Numbers go through text, so that a last bit may differ.
    golden::compare(&by_rib, &by_data, 1.0).unwrap_or_else(|e| panic!("{e}"));
}

#[test]
fn a_sweep_makes_a_run_of_each_combination() {
    let work = scratch();
    let model = work.path().join("block.yaml");
    std::fs::write(
        &model,
        "step: 1e-3
duration: 0.1
materials: {m: {density: 1000, friction: 0.4}}
bodies:
  - {name: ground, material: m, plane: {normal: [0, 0, 1]}}
  - {name: block, material: m, box: {size: [0.2, 0.2, 0.2]}, position: [0, 0, 0.1], velocity: [1, 0, 0]}
sweep: {materials.m.friction: [0.1, 0.3], gravity: [[0, 0, -9.81], [0, 0, -1.6]]}
",
    )
    .unwrap();
    let out = work.path().join("out");
    let (model, goal) = (model.to_str().unwrap(), out.to_str().unwrap());
    let plan = scree(&["simulate", model, "--plan", "-o", goal]).ok();
    assert_eq!(plan.lines().count(), 5, "{plan}");
    assert!(!out.exists());
    let script = scree(&["submit", model, "--scheduler", "slurm", "--dry-run", "-o", goal]).ok();
    assert!(script.contains("--array=0-3"), "{script}");
    scree(&["simulate", model, "--sweep-index", "1", "-o", goal]).ok();
    scree(&["simulate", model, "-o", goal]).ok();
    // More friction and more weight: slower.
    let speed = |name: &str| {
        let text = std::fs::read_to_string(out.join(name).join("probes.csv")).unwrap();
        let column = text.lines().next().unwrap().split(',').position(|h| h.starts_with("block.vx")).unwrap();
        text.lines().last().unwrap().split(',').nth(column).unwrap().parse::<f64>().unwrap()
    };
    let names = ["gravity=0_0_-9.81_friction=0.1", "gravity=0_0_-9.81_friction=0.3", "gravity=0_0_-1.6_friction=0.3"];
    assert!(speed(names[1]) < speed(names[0]) && speed(names[1]) < speed(names[2]));
    let set = scree(&["simulate", model, "--set", "bodies.block.mas=3", "-o", goal]).fails(3);
    assert!(set.contains("did you mean `mass`"), "{set}");
}

#[test]
fn a_run_is_plotted_and_another_goes_on_from_it() {
    let work = scratch();
    let one = work.path().join("one");
    let one_text = one.to_str().unwrap();
    scree(&["simulate", "sim/models/pendulums.yaml", "--until", "0.1", "-o", one_text]).ok();
    scree(&["plot", one_text, "hinge", "energy.*"]).ok();
    for file in ["hinge_joint_N.png", "hinge_world_N.svg", "hinge_rad.png", "energy_J.png"] {
        assert!(std::fs::metadata(one.join("plots").join(file)).unwrap().len() > 3000, "{file}");
    }
    assert!(scree(&["plot", one_text, "hindge"]).fails(2).contains("did you mean"));
    let model = work.path().join("more.yaml");
    std::fs::write(
        &model,
        format!(
            "base: {{run: {one_text}}}
step: 5e-4
duration: 0.05
materials: {{m: {{density: 1000, friction: 0.4}}}}
bodies: [{{name: extra, material: m, sphere: {{radius: 0.1}}, position: [0, 3, 1]}}]
probes: {{bodies: [hinged, extra], joints: [hinge]}}
"
        ),
    )
    .unwrap();
    let two = work.path().join("two");
    // Its motors begin again at time 0, where what they drive is not: that is said, and its joints hold.
    let said = scree(&["simulate", model.to_str().unwrap(), "-o", two.to_str().unwrap()]).fails(0);
    assert!(said.contains("warning: the motor of joint `slide"), "{said}");
    let last = |run: &std::path::Path, line: usize, name: &str| {
        let text = std::fs::read_to_string(run.join("probes.csv")).unwrap();
        let column = text.lines().next().unwrap().split(',').position(|h| h.starts_with(name)).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        lines[if line == 0 { lines.len() - 1 } else { line }].split(',').nth(column).unwrap().parse::<f64>().unwrap()
    };
    // The second run begins where the first ended.
    assert!((last(&one, 0, "hinged.z") - last(&two, 1, "hinged.z")).abs() < 1e-9);
    assert!((last(&one, 0, "hinged.vz") - last(&two, 1, "hinged.vz")).abs() < 1e-9);
}
