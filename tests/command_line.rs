//! The command line: the help of every command as a terminal of 80 columns shows it, the messages of wrong values, and the layers of
//! `cli/`.

use crate::cli::{scratch, scree, scree_with};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// The help of a command, long (`--help`) or short (`-h`).
fn help(command: &[String], flag: &str) -> String {
    let args: Vec<&str> = command.iter().map(String::as_str).chain([flag]).collect();
    scree_with(&[("COLUMNS", "80")], &args).ok()
}

/// An entry of a help text: a command, argument or flag, and its description.
struct Entry {
    section: String,
    name: String,
    description: String,
}

/// The entries of a help text. A description follows its entry after two spaces, or on deeper lines below it.
fn entries(help: &str) -> Vec<Entry> {
    let mut all: Vec<Entry> = vec![];
    let mut section = String::new();
    let mut column = usize::MAX;
    for line in help.lines().filter(|l| !l.trim().is_empty()) {
        let text = line.trim_start();
        let indent = line.len() - text.len();
        if indent == 0 {
            section = text.trim_end_matches(':').into();
        } else if !["Commands", "Arguments", "Options"].contains(&section.as_str()) {
            continue;
        } else if indent <= 6 && (section == "Commands" && indent == 2 || text.starts_with(['-', '<', '['])) {
            let (name, description) = text.split_once("  ").unwrap_or((text, ""));
            all.push(Entry { section: section.clone(), name: name.into(), description: description.trim().into() });
            column = indent;
        } else if let Some(last) = all.last_mut().filter(|_| indent > column) {
            last.description += &format!(" {text}");
        }
    }
    all
}

/// All commands: `scree` itself, its subcommands and theirs.
fn commands() -> Vec<Vec<String>> {
    let mut all: Vec<Vec<String>> = vec![vec![]];
    let mut next = 0;
    while next < all.len() {
        let command = all[next].clone();
        let named = entries(&help(&command, "--help")).into_iter().filter(|e| e.section == "Commands");
        all.extend(named.filter(|e| e.name != "help").map(|e| [&command[..], &[e.name]].concat()));
        next += 1;
    }
    assert!(all.len() > 15, "{all:?}");
    all
}

/// Words of prose that have a better one, by the glossary of the field.
const BANNED: [&str; 15] = [
    "picture",
    "pictures",
    "share",
    "shares",
    "anew",
    "see-through",
    "reckon",
    "roomy",
    "torn",
    "sound",
    "telling",
    "hangs on",
    "what it took",
    "so many",
    "how many",
];

#[test]
fn help_fits_a_terminal_of_80_columns_and_describes_every_entry() {
    let (mut n_flags, mut n_defaults) = (0, 0);
    for command in commands() {
        let call = format!("scree {}", command.join(" "));
        for flag in ["--help", "-h"] {
            let text = help(&command, flag);
            let wide: Vec<&str> = text.lines().filter(|l| l.chars().count() > 80).collect();
            assert!(wide.is_empty(), "{call} {flag}: {wide:#?}");
            let words: String = text.to_lowercase().chars().map(|c| if c.is_whitespace() { ' ' } else { c }).collect();
            let words = format!(" {} ", words.replace(['.', ',', ';', ':', '(', ')', '`'], " "));
            let found: Vec<&&str> = BANNED.iter().filter(|w| words.contains(&format!(" {w} "))).collect();
            assert!(found.is_empty(), "{call} {flag} says {found:?}");
            assert!(text.contains("Usage: scree"), "{call}: {text}");
        }
        let text = help(&command, "--help");
        for entry in entries(&text) {
            let words = entry.description.split_whitespace().filter(|w| w.chars().any(char::is_alphabetic)).count();
            assert!(words >= 2, "{call}: `{}` is described by `{}`", entry.name, entry.description);
            n_flags += usize::from(entry.section == "Options");
            n_defaults += usize::from(entry.description.contains("[default: "));
        }
        // Possible values are described one by one.
        let values = text.lines().filter_map(|l| l.trim_start().strip_prefix("- "));
        values.for_each(|v| assert!(v.split_once(": ").is_some_and(|(_, d)| !d.trim().is_empty()), "{call}: {v}"));
    }
    assert!(n_flags > 60 && n_defaults > 40, "{n_flags} flags, {n_defaults} defaults: the help is not read well");
}

#[test]
fn wrong_values_of_flags_are_refused_in_the_users_words() {
    let mut tried = vec![];
    for command in commands() {
        for entry in entries(&help(&command, "--help")).iter().filter(|e| e.section == "Options") {
            let Some(flag) = entry.name.split([' ', ',']).find(|w| w.starts_with("--")) else { continue };
            // Any text may be a path, or a line for a scheduler.
            let has_syntax =
                entry.name.contains('<') && !["<FILE>", "<DIR>", "<TEXT>"].iter().any(|any| entry.name.contains(any));
            if !has_syntax {
                continue;
            }
            let wrong = format!("{flag}=a|b");
            let args: Vec<&str> = command.iter().map(String::as_str).chain([wrong.as_str()]).collect();
            let message = scree(&args).fails(2);
            assert!(message.contains("invalid value 'a|b' for"), "{args:?}: {message}");
            assert!(message.contains("expected ") || message.contains("possible values"), "{args:?}: {message}");
            let of_rust = ["usize", "u64", "f64", "float", "literal", "digit", "..", "ParseInt"];
            assert!(!of_rust.iter().any(|word| message.contains(word)), "{args:?}: {message}");
            tried.push(flag.to_string());
        }
    }
    assert!(tried.len() > 35 && tried.contains(&"--until".into()) && tried.contains(&"--frames".into()), "{tried:?}");
}

/// The files of `cli/` by their paths without ending, with their texts.
fn files(folder: &Path, out: &mut BTreeMap<String, String>) {
    let root = cli_root();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files(&path, out);
        } else {
            let name = path.strip_prefix(&root).unwrap().with_extension("").to_string_lossy().replace('\\', "/");
            out.insert(name, std::fs::read_to_string(&path).unwrap());
        }
    }
}

fn cli_root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("cli")
}

/// The paths that follow a prefix (`crate::`, `super::`) in a text, those of braces one by one: `a::b`, `c`.
fn paths_after(text: &str, prefix: &str) -> Vec<String> {
    let mut found = vec![];
    for rest in text.split(prefix).skip(1) {
        let end = |s: &str| s.find(|c: char| !c.is_alphanumeric() && c != '_' && c != ':').unwrap_or(s.len());
        match rest.strip_prefix('{') {
            None => found.push(rest[..end(rest)].to_string()),
            Some(list) => {
                let mut depth = 0;
                let items = list.split(|c: char| {
                    depth += i32::from(c == '{') - i32::from(c == '}');
                    depth < 0 || depth == 0 && c == ','
                });
                let closing = list.find("};").unwrap_or(list.len());
                let inside = items.take_while(|item| item.as_ptr() as usize - list.as_ptr() as usize <= closing);
                found.extend(inside.map(|item| item.trim()[..end(item.trim())].to_string()));
            }
        }
    }
    found.retain(|path| !path.is_empty());
    found
}

/// The files that each file of `cli/` uses: by path, and the files of its own room that it declares.
fn uses(all: &BTreeMap<String, String>) -> BTreeMap<&str, BTreeSet<String>> {
    let file_of = |room: &str, path: &str| {
        let mut words = path.split("::");
        let first = format!("{room}{}", words.next().unwrap_or(""));
        let second = format!("{first}/{}", words.next().unwrap_or(""));
        [second, first].into_iter().find(|name| all.contains_key(name))
    };
    all.iter()
        .map(|(name, text)| {
            let room = name.rsplit_once('/').map_or(String::new(), |(room, _)| format!("{room}/"));
            let own = |line: &str| {
                let module = line.strip_prefix("mod ").or(line.strip_prefix("pub mod "))?.strip_suffix(';')?;
                Some(if name == "main" { module.to_string() } else { format!("{name}/{module}") })
            };
            let mut used: BTreeSet<String> = text.lines().filter_map(own).collect();
            used.extend(paths_after(text, "crate::").iter().filter_map(|path| file_of("", path)));
            used.extend(paths_after(text, "super::").iter().filter_map(|path| file_of(&room, path)));
            used.remove(name);
            (name.as_str(), used)
        })
        .collect()
}

#[test]
fn files_of_the_command_use_only_lower_layers() {
    let mut all = BTreeMap::new();
    files(&cli_root(), &mut all);
    let uses = uses(&all);
    assert!(all.len() > 40 && uses["main"].contains("job") && uses["job/bench"].contains("job/simulate"), "{uses:#?}");
    assert!(uses["model_run"].contains("geometry") && uses["run"].contains("movie"), "{uses:#?}");
    // Leaves know neither the command line nor jobs.
    let leaves = [
        "report",
        "arrivals",
        "print",
        "progress",
        "source",
        "library",
        "machine",
        "image_file",
        "shard_file",
        "geometry",
        "failed",
        "interrupt",
        "ledger",
        "batch",
    ];
    for (name, used) in &uses {
        let room = name.split('/').next().unwrap();
        for other in used {
            let other_room = other.split('/').next().unwrap();
            let allowed = match room {
                "main" => true,
                "args" => other_room == "args",
                "job" => ["job", "args"].contains(&other_room) || leaves.contains(&other_room),
                leaf if leaves.contains(&leaf) => leaves.contains(&other_room),
                _ => !["args", "main"].contains(&other_room),
            };
            assert!(allowed, "cli/{name}.rs uses cli/{other}.rs");
        }
        if room == "args" {
            let crates = ["sim::", "render::", "bind::", "gpu::"];
            let foreign = all[*name].lines().find(|l| crates.iter().any(|c| l.starts_with(&format!("use {c}"))));
            assert!(foreign.is_none(), "cli/{name}.rs: {foreign:?}");
        }
    }
    // No circles: what uses nothing of the rest is taken away until nothing is left.
    let mut left: BTreeMap<&str, BTreeSet<String>> = uses;
    while let Some(name) =
        left.iter().find(|(_, used)| used.iter().all(|u| !left.contains_key(u.as_str()))).map(|(n, _)| *n)
    {
        left.remove(name);
    }
    assert!(left.is_empty(), "circles among {left:#?}");
}

#[cfg(unix)]
#[test]
fn a_scheduler_that_does_not_answer_is_not_taken_for_none() {
    use std::os::unix::fs::PermissionsExt;
    let work = scratch();
    let said = |path: &str| scree_with(&[("PATH", path)], &["doctor", work.path().to_str().unwrap()]).ok();
    assert!(said(work.path().to_str().unwrap()).contains("Slurm is not on PATH"));
    let sinfo = work.path().join("sinfo");
    std::fs::write(&sinfo, "#!/bin/sh\necho 'cannot reach the controller' >&2\nexit 1\n").unwrap();
    std::fs::set_permissions(&sinfo, std::fs::Permissions::from_mode(0o755)).unwrap();
    let found = said(work.path().to_str().unwrap());
    assert!(!found.contains("Slurm is not on PATH"), "{found}");
    assert!(found.contains("sinfo does not answer: cannot reach the controller"), "{found}");
    assert!(found.contains("sbatch does not answer"), "{found}");
}
