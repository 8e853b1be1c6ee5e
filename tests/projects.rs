//! What a new user begins with, and what programs around scree read: projects that `scree init` lays, completions, pages of the manual,
//! and what commands report as JSON.

use crate::cli::{scratch, scree};
use std::process::Command;

#[test]
fn starters_are_valid_and_refuse_folders_in_use() {
    let work = scratch();
    for starter in ["drop", "plough"] {
        let folder = work.path().join(starter);
        let at = |name: &str| folder.join(name).to_str().unwrap().to_string();
        scree(&["init", folder.to_str().unwrap(), "--starter", starter]).ok();
        assert!(scree(&["check", &at("model.yaml"), &at("metadata.yaml")]).ok().contains("valid model"));
        let readme = std::fs::read_to_string(folder.join("README.md")).unwrap();
        assert!(readme.starts_with(&format!("# {starter}\n")) && !readme.contains("SUMMARY"), "{readme}");
        assert!(scree(&["init", folder.to_str().unwrap()]).fails(2).contains("is not an empty folder"));
    }
    assert!(scree(&["init", work.path().join("x").to_str().unwrap(), "--starter", "rain"]).fails(2).contains("drop"));
}

#[test]
fn a_new_project_runs_to_its_film() {
    let work = scratch();
    let (folder, run) = (work.path().join("demo"), work.path().join("run"));
    scree(&["init", folder.to_str().unwrap()]).ok();
    // Fewer stones for less time: the files are the same.
    let model = folder.join("model.yaml");
    let text = std::fs::read_to_string(&model).unwrap();
    std::fs::write(&model, text.replace("count: 400", "count: 20").replace("duration: 1.5", "duration: 0.2")).unwrap();
    let metadata = folder.join("metadata.yaml");
    let call = ["run", metadata.to_str().unwrap(), "-o", run.to_str().unwrap(), "--res", "64x36", "--samples", "1"];
    assert!(scree(&call).ok().contains("movie: "));
    assert!(scree(&["report", run.to_str().unwrap()]).ok().contains("report.html"));
}

#[test]
fn shells_and_man_are_served() {
    let work = scratch();
    for shell in ["bash", "zsh", "fish"] {
        let text = scree(&["completions", shell]).ok();
        assert!(["simulate", "frames-per-task", "scheduler"].iter().all(|word| text.contains(word)), "{shell}");
        assert!(!text.contains("rainbow"));
    }
    let script = work.path().join("scree.bash");
    std::fs::write(&script, scree(&["completions", "bash"]).ok()).unwrap();
    assert!(Command::new("bash").arg("-n").arg(&script).status().unwrap().success());
    let said = scree(&["man", work.path().join("man1").to_str().unwrap()]).ok();
    assert!(said.lines().count() > 20, "{said}");
    let page = std::fs::read_to_string(work.path().join("man1/scree-render.1")).unwrap();
    assert!(page.contains(".TH") && page.contains("samples"), "{page}");
}

#[test]
fn commands_that_report_speak_json() {
    let json =
        |text: String| serde_json::from_str::<serde_json::Value>(&text).unwrap_or_else(|e| panic!("{e}: {text}"));
    let work = scratch();
    let at = |name: &str| work.path().join(name).to_str().unwrap().to_string();
    // Faults have their places, and the exit code is the worst.
    std::fs::write(at("bad.yaml"), "name: a\nbodies:\n  - {name: b, box: {size: [1, 1, 1]}, masss: 3}\n").unwrap();
    let answer = scree(&["check", "metadata/quickstart.yaml", &at("bad.yaml"), &at("none.sl"), "--json"]);
    answer.fails(3);
    let files = json(answer.said());
    let [good, bad, none] = [0, 1, 2].map(|i| &files[i]);
    assert_eq!((&good["is_valid"], &good["fault"]), (&true.into(), &serde_json::Value::Null));
    assert_eq!((&bad["fault"]["line"], &bad["is_valid"]), (&3.into(), &false.into()));
    assert!(bad["fault"]["message"].as_str().unwrap().contains("masss"), "{bad}");
    assert_eq!(none["fault"]["line"], serde_json::Value::Null);

    // What is lost of a folder of images is named.
    std::fs::write(at("p_0.csv"), "x,y,z,radius\n0,0,0,0.1\n").unwrap();
    std::fs::write(at("p_1.csv"), "x,y,z,radius\n0,0,0.5,0.1\n").unwrap();
    scree(&["inspect", &at("p_*.csv"), "--write", &at("md.yaml")]).ok();
    scree(&["render", &at("md.yaml"), "-o", &at("o"), "--res", "32x18", "--samples", "1"]).ok();
    let whole = json(scree(&["verify", &at("o"), "--json"]).ok());
    assert_eq!((&whole["images"], &whole["is_done"]), (&2.into(), &true.into()));
    std::fs::write(at("o/000001.png"), "no image").unwrap();
    let answer = scree(&["verify", &at("o"), "--json"]);
    answer.fails(5);
    assert_eq!(json(answer.said())["not_done"][0]["what"], "frame 1");

    let shaders = json(scree(&["shader", "matte", "gravel", "--json"]).ok());
    let first = &shaders[0]["parameters"][0];
    assert_eq!(
        (&shaders[0]["kind"], &first["name"], &first["type"]),
        (&"surface".into(), &"Ka".into(), &"float".into())
    );
    assert!(first["default"].as_f64().is_some() && shaders.as_array().unwrap().len() == 2, "{shaders}");
    let machine = json(scree(&["doctor", "--json", work.path().to_str().unwrap()]).ok());
    assert!(
        machine["processors"].as_u64() > Some(0) && machine["output"]["free_bytes"].as_u64() > Some(0),
        "{machine}"
    );
    assert!(machine["output"]["write_bytes_per_second"].as_f64() > Some(0.0));
    scree(&["doctor", &at("nowhere")]).fails(2);
    assert_eq!(std::fs::read_dir(work.path()).unwrap().filter(|e| e.as_ref().unwrap().path().is_file()).count(), 4);
}
