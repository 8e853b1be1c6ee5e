//! What a new user begins with: projects that `scree init` lays, completions and pages of the manual.

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
