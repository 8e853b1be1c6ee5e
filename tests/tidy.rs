//! The house in order: who may use whom, and a head on every file.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// Our own crates that a manifest depends on, outside tests.
fn uses(manifest: &Path, ours: &[&str]) -> Vec<String> {
    let text = std::fs::read_to_string(manifest).unwrap();
    let mut in_dependencies = false;
    let mut found = Vec::new();
    for line in text.lines() {
        if line.starts_with('[') {
            in_dependencies = line == "[dependencies]";
        } else if in_dependencies && let Some(name) = line.split(['.', ' ', '=']).next().filter(|n| ours.contains(n)) {
            found.push(name.to_string());
        }
    }
    found.sort();
    found
}

#[test]
fn crates_use_only_whom_they_may() {
    let rooms = BTreeMap::from([
        ("scree", (".", vec!["bind", "frame", "gpu", "render", "sim"])),
        ("sim", ("sim", vec!["frame", "gpu"])),
        ("bind", ("render/bind", vec!["frame", "ri"])),
        ("render", ("render", vec!["gpu", "ri", "sl"])),
        ("ri", ("render/ri", vec![])),
        ("sl", ("render/sl", vec![])),
        ("frame", ("frame", vec![])),
        ("gpu", ("gpu", vec![])),
    ]);
    let ours: Vec<&str> = rooms.keys().copied().collect();
    for (name, (folder, allowed)) in &rooms {
        let used = uses(&root().join(folder).join("Cargo.toml"), &ours);
        let strange: Vec<&String> = used.iter().filter(|u| !allowed.contains(&u.as_str())).collect();
        assert!(strange.is_empty(), "{name} uses {strange:?}, it may use {allowed:?}");
    }
}

/// All files of the tree below a folder with one of these endings.
fn files(folder: &Path, endings: &[&str], out: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().to_string();
        if path.is_dir() && !name.starts_with('.') && name != "target" && name != "runs" && name != "corpus" {
            files(&path, endings, out);
        } else if path.extension().is_some_and(|e| endings.contains(&e.to_string_lossy().as_ref())) {
            out.push(path);
        }
    }
}

#[test]
fn every_file_says_what_it_is() {
    let mut all = Vec::new();
    files(&root(), &["rs", "wgsl", "sl", "rib", "yaml"], &mut all);
    assert!(all.len() > 60);
    for path in all {
        let text = std::fs::read_to_string(&path).unwrap();
        let head = text.lines().next().unwrap_or("");
        let sound = match path.extension().unwrap().to_str().unwrap() {
            "rs" => head.starts_with("//! ") && head.len() > 12,
            "wgsl" | "sl" => head.starts_with("// ") && head.len() > 12,
            "rib" => text.lines().take(3).any(|l| l.starts_with("# ") && l.len() > 12),
            _ => head.starts_with("# ") && head.len() > 10,
        };
        assert!(sound, "{} does not begin by saying what it is", path.display());
    }
}

#[test]
fn every_stage_has_its_file_and_says_what_goes_in_and_out() {
    for stage in sim::stages::Stage::ALL.map(|stage| stage.name()) {
        // The sort is the gpu crate's, where its kernel stands beside it.
        let path = if stage == "bin_sort" {
            root().join("gpu/src/radix_sort.rs")
        } else {
            root().join(format!("sim/src/cpu/{stage}.rs"))
        };
        let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        assert!(
            stage == "bin_sort" || text.contains("//! in ") && text.contains("out "),
            "{} lacks inputs and outputs",
            path.display()
        );
    }
}
