//! `scree simulate --backend gpu`: what it refuses and how, and whole runs on an adapter, where there is one.

use crate::cli::{scratch, scree, scree_with};
use std::fs;
use std::path::Path;

/// Grains that fall onto a block and the ground, in few steps.
const MODEL: &str = "# Grains that fall.
name: grains
step: 0.001
duration: 0.06
frame_rate: 100
checkpoint_interval: 0.02
seed: 3
materials:
  stone: {density: 2600, friction: 0.5}
bodies:
  - {name: ground, material: stone, plane: {normal: [0, 0, 1]}}
  - {name: block, material: stone, fixed: true, box: {size: [0.6, 0.6, 0.3]}, position: [0, 0, 0.15]}
fills:
  - name: stones
    material: stone
    count: 60
    radius: [0.03, 0.05]
    min: [-0.4, -0.4, 0.3]
    max: [0.4, 0.4, 0.9]
    velocity: [0, 0, -2]
";

/// Whether there is an adapter; without one the tests of runs are left out, unless `REQUIRE_GPU` is set.
pub fn has_adapter() -> bool {
    let has_one = !gpu::adapters().is_empty();
    assert!(has_one || std::env::var_os("REQUIRE_GPU").is_none(), "REQUIRE_GPU is set, but there is no adapter");
    if !has_one {
        eprintln!("skipped: there is no Vulkan adapter");
    }
    has_one
}

fn model(folder: &Path, change: impl FnOnce(String) -> String) -> String {
    let path = folder.join("grains.yaml");
    fs::write(&path, change(MODEL.into())).unwrap();
    path.display().to_string()
}

#[test]
fn what_a_device_cannot_do_is_named() {
    if !has_adapter() {
        return;
    }
    let folder = scratch();
    let run = folder.path().join("run").display().to_string();
    let refused = |from: &str, to: &str, what: &str| {
        let path = model(folder.path(), |text| {
            assert!(text.contains(from), "{from}");
            text.replace(from, to)
        });
        let answer = scree(&["simulate", &path, "-o", &run, "--backend", "gpu", "--adapter", "0"]);
        assert!(answer.fails(2).contains(what), "{}", answer.errors());
        assert!(!folder.path().join("run/run.json").exists(), "no run is written");
    };
    let moon = "  - {name: moon, material: stone, position: [0, 0, 60], sphere: {radius: 40}}\nfills:";
    refused("fills:", moon, "the sizes of the moving shapes differ");
}

#[test]
fn adapters_are_chosen_for_devices_alone() {
    let folder = scratch();
    let path = model(folder.path(), |text| text);
    let run = folder.path().join("run").display().to_string();
    let simulate = ["simulate", &path, "-o", &run];
    let says = |code: i32, environment: &[(&str, &str)], args: &[&str], what: &str| {
        let answer = scree_with(environment, args);
        assert!(answer.fails(code).contains(what), "{}", answer.errors());
    };
    says(2, &[], &[&simulate[..], &["--adapter", "0"]].concat(), "--backend gpu");
    let gpu = [&simulate[..], &["--backend", "gpu", "--adapter", "no such adapter"]].concat();
    if has_adapter() {
        says(2, &[], &gpu, "no such adapter");
    }
    // Without a driver.
    let environment = [("VK_DRIVER_FILES", "/nowhere"), ("VK_ICD_FILENAMES", "/nowhere")];
    says(1, &environment, &gpu, "install the Vulkan driver");
}

/// Stages from one on, by the command line or by the model: on an adapter the same run but for its last bits, and refused by name without one.
#[test]
fn stages_are_run_on_a_device_from_one_on() {
    let folder = scratch();
    let path = model(folder.path(), |text| text);
    let at = |name: &str| folder.path().join(name).display().to_string();
    let run = |name: &str, more: &[&str]| scree(&[&["simulate", &path, "-o", &at(name)], more].concat());
    let said = run("no", &["--gpu-from", "contact_solv"]).fails(2);
    assert!(said.contains("'contact_solve'") && said.contains("similar"), "{said}");
    let said = run("no", &["--set", "gpu_from=contact_solv"]).fails(3);
    assert!(said.contains("gpu_from") && said.contains("did you mean `contact_solve`?"), "{said}");
    for more in [["--gpu-from", "force"], ["--set", "gpu_from=force"]] {
        let said = run("no", &[&more[..], &["--backend", "cpu"]].concat()).fails(2);
        assert!(said.contains("`gpu_from: force`") && said.contains("--backend gpu"), "{said}");
    }
    assert!(!folder.path().join("no").exists());
    if !has_adapter() {
        return;
    }
    let gpu = ["--backend", "gpu", "--adapter", "0"];
    run("whole", &["--until", "0.02", "--backend", "cpu"]).ok();
    for stage in ["pair_write", "contact_solve"] {
        run(stage, &[&gpu[..], &["--until", "0.02", "--gpu-from", stage]].concat()).ok();
        let text = |file: &str| fs::read_to_string(folder.path().join(stage).join(file)).unwrap();
        assert!(text("model.yaml").contains(&format!("gpu_from: {stage}")) && text("run.json").contains("\"gpu\""));
        let frame = |run: &str| {
            let run = frame::run::RunReader::open(&folder.path().join(run)).unwrap();
            let table = run.read_frame(1).unwrap();
            let values = |name: &str| {
                let column = table.column(name).unwrap();
                (0..table.rows()).map(|row| column.number(row).unwrap()).collect::<Vec<f64>>()
            };
            ["pos_x", "pos_y", "pos_z"].map(values)
        };
        let (a, b) = (frame("whole"), frame(stage));
        let off = a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off > 0.0 && off < 1e-4, "from {stage}: {off} m");
    }
    // It goes on with all stages on the processor: the model is the same.
    run("pair_write", &["--until", "0.03", "--resume"]).ok();
}

/// A large model without an adapter of hardware, or with one that cannot simulate it, is the processor's, which is said once; a small one is
/// without a word.
#[test]
fn auto_falls_back_to_the_processor_and_says_why() {
    let folder = scratch();
    let environment = [("VK_DRIVER_FILES", "/nowhere"), ("VK_ICD_FILENAMES", "/nowhere")];
    let simulate = |count: &str| {
        let run = folder.path().join(count).display().to_string();
        let path = model(folder.path(), |text| {
            let text = text
                .replace("count: 60", &format!("count: {count}"))
                .replace("max: [0.4, 0.4, 0.9]", "max: [2, 2, 40]");
            text.replace("radius: [0.03, 0.05]", "radius: [0.04, 0.04]\n    packing: lattice")
        });
        let answer = scree_with(&environment, &["simulate", &path, "-o", &run, "--until", "0.002"]);
        let said = answer.errors().to_string();
        answer.ok();
        let index = fs::read_to_string(folder.path().join(count).join("run.json")).unwrap();
        assert!(index.contains("\"backend\": \"cpu\""), "{index}");
        said.matches("--backend auto: the processor simulates this model: no hardware Vulkan adapter").count()
    };
    assert_eq!((simulate("20000"), simulate("100")), (1, 0));
}

#[test]
fn a_run_on_a_device_is_repeated_resumed_and_goes_on_on_the_processor() {
    if !has_adapter() {
        return;
    }
    let folder = scratch();
    let path = model(folder.path(), |text| text);
    let at = |name: &str| folder.path().join(name).display().to_string();
    let simulate = |name: &str, more: &[&str]| {
        scree(&[&["simulate", &path, "-o", &at(name)], more].concat()).ok();
    };
    let gpu = ["--backend", "gpu", "--adapter", "0"];
    simulate("first", &gpu);
    simulate("again", &gpu);
    simulate("part", &[&gpu[..], &["--until", "0.03"]].concat());
    simulate("part", &[&gpu[..], &["--resume"]].concat());
    let index = fs::read_to_string(folder.path().join("first/run.json")).unwrap();
    assert!(index.contains("\"backend\": \"gpu\"") && index.contains(&gpu::adapters()[0].driver), "{index}");
    for frame in 0..6 {
        let file = |run: &str| fs::read(folder.path().join(format!("{run}/frames/{frame:06}.arrow"))).unwrap();
        assert!(file("first") == file("again"), "frame {frame} is repeated");
        assert!(file("first") == file("part"), "frame {frame} of a run that was resumed");
    }
    // The same model, on the other back end from its middle.
    simulate("mixed", &[&gpu[..], &["--until", "0.03"]].concat());
    simulate("mixed", &["--resume"]);
    simulate("other", &["--until", "0.03"]);
    simulate("other", &[&gpu[..], &["--resume"]].concat());
    let positions = |run: &str| {
        let run = frame::run::RunReader::open(&folder.path().join(run)).unwrap();
        let table = run.read_frame(5).unwrap();
        let values = |name| {
            let column = table.column(name).unwrap();
            (0..table.rows()).map(|row| column.number(row).unwrap()).collect::<Vec<f64>>()
        };
        ["pos_x", "pos_y", "pos_z"].map(values)
    };
    let first = positions("first");
    for run in ["mixed", "other"] {
        let own = positions(run);
        let off = own.iter().flatten().zip(first.iter().flatten()).map(|(a, b)| (a - b).abs());
        let off = off.fold(0.0, f64::max);
        assert!(off < 1e-4, "{run}: {off} m");
    }
}

/// The models of the library, with the number of steps after which they are given to a device.
const MODELS: [(&str, usize); 11] = [
    ("anchor", 720),
    ("card_house", 100),
    ("crater", 400),
    ("heap", 400),
    ("hopper", 400),
    ("incline", 300),
    ("pendulums", 100),
    ("pour", 500),
    ("quickstart", 320),
    ("tracked_vehicle", 600),
    ("wall", 380),
];

fn simulation(name: &str) -> sim::Simulation {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("sim/models/{name}.yaml"));
    let (file, doc) = sim::model_file::load(&path, &[]).unwrap();
    let resolved = file.resolve(&doc).unwrap();
    sim::Simulation::new(resolved.model, resolved.state)
}

#[test]
fn models_go_on_on_a_device_as_on_the_processor() {
    if !has_adapter() {
        return;
    }
    let open = || gpu::Device::open(&gpu::Choice::Any).unwrap();
    let names = fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("sim/models")).unwrap();
    assert_eq!(names.count(), MODELS.len(), "each model stands in the table");
    for (name, steps) in MODELS {
        let mut cpu = simulation(name);
        // Each method alone: what takes over a landing sweeps in another order on a device.
        cpu.model.solver.sweep_landings = false;
        (0..steps).for_each(|_| drop(cpu.step()));
        // Solved so far that how a method has begun does not matter.
        cpu.model.solver.iterations = Some(60);
        let mut own = sim::Simulation::on_device(cpu.model.clone(), cpu.state.clone(), open()).unwrap();
        for _ in 0..20 {
            own.step();
            cpu.step();
        }
        own.fetch().unwrap();
        // The processor makes no contacts that nothing closes in the step.
        let carries = |s: &sim::Simulation| {
            let impulses = || s.state.contacts.impulse.iter().map(|impulse| impulse.length());
            let least = 1e-3 * impulses().fold(0.0, f64::max);
            impulses().filter(|impulse| *impulse > least).count()
        };
        let contacts = [carries(&own), carries(&cpu)];
        let off: Vec<f64> =
            own.state.position.iter().zip(&cpu.state.position).map(|(a, b)| (*a - *b).length()).collect();
        let (worst, mean) = (off.iter().fold(0.0, |a: f64, b| a.max(*b)), off.iter().sum::<f64>() / off.len() as f64);
        let energies = [&own, &cpu].map(|s| s.state.kinetic_energy(&s.model));
        eprintln!(
            "{name}: {contacts:?} contacts that carry, {worst:.2e} m at most, {mean:.2e} m in the mean, {energies:?} J"
        );
        // Pendulums swing free.
        let enough = contacts[1] > 10 || name == "pendulums";
        // One may be at the rim of a face, or of the reach, and bricks in flight may touch with two corners or with three; of the lines along which shoes
        // touch rollers the processor has here and there but one end, where the normal is off by 1e-5.
        let may_differ = (contacts[1] / 10).max(1);
        assert!(enough && contacts[0].abs_diff(contacts[1]) <= may_differ, "{name}: {contacts:?}");
        // In a bed that comes to rest some grains roll another way; they move by up to some centimetres.
        assert!(worst < 1e-3 && mean < 5e-5, "{name}: {worst} m at most, {mean} m in the mean");
        // Cards that stand have next to none.
        assert!((energies[0] - energies[1]).abs() < 0.01 * energies[1] + 1e-6, "{name}: {energies:?} J");
    }
}
