//! The house in order: who may use whom, a head on every file, no circle of files, and neither files nor functions too long.

mod functions;
mod imports;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// The crates and the root file of each; the tests are one of their own.
const CRATES: [(&str, &str); 10] = [
    ("guard", "guard/src/lib.rs"),
    ("frame", "frame/src/lib.rs"),
    ("gpu", "gpu/src/lib.rs"),
    ("ri", "render/ri/src/lib.rs"),
    ("sl", "render/sl/src/lib.rs"),
    ("bind", "render/bind/src/lib.rs"),
    ("render", "render/src/lib.rs"),
    ("sim", "sim/src/lib.rs"),
    ("scree", "cli/main.rs"),
    ("tests", "tests/tests.rs"),
];

/// The most lines of a file.
const MAX_FILE: usize = 600;

/// The most lines of a function without a reason.
const MAX_FUNCTION: usize = 80;

/// Longer functions, by file and name, and why they are.
const LONG_FUNCTIONS: [(&str, &str, &str); 8] = [
    ("render/sl/src/back/machine/run.rs", "op", "an arm for each operation of the IR"),
    ("render/sl/src/front/lower/form.rs", "form", "a rule for each function whose arguments no row describes"),
    ("render/sl/src/ir/validate.rs", "op", "an arm for each operation of the IR"),
    ("render/sl/src/ir/walk.rs", "reads", "an arm for each operation of the IR"),
    ("sim/src/assembly/tracked_vehicle.rs", "track", "one track, part by part: shoes, pins, wheels, axles"),
    ("sim/benches/rows.rs", "rows", "the table of the rows, each with its model and what is measured"),
    ("sim/src/model_file/resolve/base.rs", "base", "copies a model column by column, over one table of new ids"),
    ("sim/src/model_file/resolve/bodies.rs", "body", "the checks of a body's keys, in the order of the file format"),
];

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
        ("scree", (".", vec!["bind", "frame", "gpu", "guard", "render", "sim"])),
        ("sim", ("sim", vec!["frame", "gpu", "guard"])),
        ("bind", ("render/bind", vec!["frame", "guard", "ri"])),
        ("render", ("render", vec!["gpu", "guard", "ri", "sl"])),
        ("ri", ("render/ri", vec!["guard"])),
        ("sl", ("render/sl", vec![])),
        ("frame", ("frame", vec!["guard"])),
        ("gpu", ("gpu", vec![])),
        ("guard", ("guard", vec![])),
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
        if path.is_dir() && !name.starts_with('.') && !["target", "runs", "corpus", "hostile"].contains(&name.as_str())
        {
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

/// The text of every Rust file of the tree, by its path from the root.
fn sources() -> imports::Sources {
    let mut all = Vec::new();
    files(&root(), &["rs"], &mut all);
    let relative = |path: &Path| path.strip_prefix(root()).unwrap().to_string_lossy().replace('\\', "/");
    all.iter().map(|path| (relative(path), std::fs::read_to_string(path).unwrap())).collect()
}

#[test]
fn no_files_import_each_other_in_a_circle() {
    let sources = sources();
    let mut wrong = String::new();
    for (name, root) in CRATES {
        let imports = imports::imports(&sources, root);
        assert!(imports.len() > 1, "{name}: only {} imports were found", imports.len());
        for circle in imports::circles(&imports) {
            wrong += &format!("{name}, {} files:\n{}", circle.len(), imports::show(&circle, &imports));
        }
    }
    assert!(wrong.is_empty(), "files that import each other in a circle:\n{wrong}");
}

#[test]
fn unsafe_code_is_counted() {
    let page = std::fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap();
    let sources = sources();
    let kinds = ["{", "fn", "impl", "trait"].map(|next| format!("unsafe {next}"));
    for (name, file) in CRATES.into_iter().filter(|(name, _)| *name != "tests") {
        let home = file.rsplit_once('/').unwrap().0;
        let own = sources.iter().filter(|(path, _)| path.strip_prefix(home).is_some_and(|rest| rest.starts_with('/')));
        let lines = own.flat_map(|(_, text)| text.lines()).filter(|line| !line.trim_start().starts_with("//"));
        let n: usize = lines.map(|line| kinds.iter().map(|kind| line.matches(kind).count()).sum::<usize>()).sum();
        assert!(page.contains(&format!("| `{name}` | {n} |")), "ARCHITECTURE.md: `{name}` has {n} of them");
    }
}

#[test]
fn no_file_is_too_long() {
    for (path, text) in sources() {
        let n = text.lines().count();
        assert!(n <= MAX_FILE, "{path} has {n} lines, more than {MAX_FILE}: split it by what it describes");
    }
}

#[test]
fn long_functions_have_a_reason() {
    let mut long = BTreeSet::new();
    for (path, text) in sources() {
        for function in functions::functions(&text).into_iter().filter(|f| f.length > MAX_FUNCTION) {
            let functions::Function { name, line, length } = &function;
            assert!(
                LONG_FUNCTIONS.iter().any(|(file, known, _)| *file == path && known == name),
                "{path}:{line}: `{name}` has {length} lines: cut it, or give its reason in LONG_FUNCTIONS"
            );
            long.insert((path.clone(), function.name));
        }
    }
    for (file, name, reason) in LONG_FUNCTIONS {
        assert!(reason.len() > 20, "{file}: `{name}` has no reason");
        let known = long.contains(&(file.to_string(), name.to_string()));
        assert!(known, "{file}: `{name}` is not long, or not there: take it out of LONG_FUNCTIONS");
    }
}
