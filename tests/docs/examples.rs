//! The fenced blocks of the pages, each by the word after its language: `yaml model`, `yaml metadata`, `yaml job`, `sl` and `rib` are
//! checked, `sh` is parsed, `sh run` is run in the page's own folder. A further word is the name of a file that later blocks may use;
//! `text shown` is no example.

use super::pages::{self, Block, Page};
use super::reference::{Command, commands};
use crate::cli::scratch;
use sim::Simulation;
use std::path::Path;
use std::process::Output;

/// Call the command in a folder.
fn scree_in(folder: &Path, args: &[String]) -> Output {
    std::process::Command::new(env!("CARGO_BIN_EXE_scree")).current_dir(folder).args(args).output().unwrap()
}

/// The words of a shell's line: quotes hold blanks together, a comment ends it.
fn words(line: &str) -> Vec<String> {
    let (mut words, mut quote, mut open) = (vec![], None, false);
    for c in line.chars() {
        match quote {
            Some(q) if c == q => quote = None,
            None if c == '\'' || c == '"' => {
                if !open {
                    words.push(String::new());
                }
                (quote, open) = (Some(c), true);
            }
            None if c == '#' && !open => break,
            None if c.is_whitespace() => open = false,
            _ => {
                if !open {
                    words.push(String::new());
                    open = true;
                }
                words.last_mut().unwrap().push(c);
            }
        }
    }
    words
}

/// The arguments of scree in a line of a block; none where the line calls cargo for something else, or nothing.
fn call(line: &str, place: &str) -> Option<Vec<String>> {
    let all = words(line);
    let starts = |with: &[&str]| all.len() >= with.len() && all.iter().zip(with).all(|(a, b)| a == b);
    if all.is_empty() || starts(&["cargo", "test"]) || starts(&["cargo", "bench"]) || starts(&["cargo", "build"]) {
        return None;
    }
    for head in [&["scree"][..], &["cargo", "run", "--release", "--"]] {
        if starts(head) {
            return Some(all[head.len()..].to_vec());
        }
    }
    panic!("{place}: `{line}` calls neither scree nor cargo");
}

/// Whether the command and the flags of a call are there.
fn parse(args: &[String], known: &[Command], place: &str) {
    let takes = |n: usize| known.iter().find(|c| n <= args.len() && c.name == args[..n].join(" "));
    let command = takes(2).or(takes(1)).unwrap_or_else(|| panic!("{place}: there is no command `{}`", args.join(" ")));
    for flag in args.iter().filter(|a| a.len() > 1 && a.starts_with('-') && !a.as_bytes()[1].is_ascii_digit()) {
        let flag = flag.split('=').next().unwrap();
        assert!(command.flags.iter().any(|f| f == flag), "{place}: `{}` has no flag {flag}", command.name);
    }
}

/// Lines of a block, those that end in a backslash joined to the next.
fn lines(text: &str) -> Vec<String> {
    text.replace("\\\n", " ").lines().map(String::from).collect()
}

/// Resolve a model and take a step.
fn step(path: &Path, place: &str) {
    let (_, resolved) = sim::model_file::read(path).unwrap_or_else(|f| panic!("{place}: {f}"));
    assert!(resolved.warnings.is_empty(), "{place}: {:?}", resolved.warnings);
    let mut sim = Simulation::new(resolved.model, resolved.state);
    let report = sim.step();
    assert!(report.broken.is_none() && report.warnings.is_empty(), "{place}: {report:?}");
}

/// Have a file checked; a warning counts as a fault, but for one of rows that lack values, as a page shows them.
fn check(folder: &Path, name: &str, kind: &str, place: &str) {
    let output = scree_in(folder, &["check".into(), name.into()]);
    let said = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    let has_warning = said.lines().any(|l| l.contains("warning") && !l.contains("for want of a value"));
    let is_sound = output.status.success() && said.contains(kind) && !has_warning;
    assert!(is_sound, "{place}: expected a sound {kind}, found {said}");
}

/// Run the calls of a block, each of which ends as its comment says: `# exit code 3`, or else with 0.
fn run(folder: &Path, block: &Block, known: &[Command], page: &Page) {
    for line in lines(&block.text) {
        let place = page.at(block.line);
        let Some(args) = call(&line, &place) else { continue };
        parse(&args, known, &place);
        let code = line.split_once("# exit code ").map_or(0, |(_, n)| n.trim().parse().unwrap());
        let output = scree_in(folder, &args);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(code), "{place}: {line}: {said}");
    }
}

/// Do what a block is for; its number names its file if nothing else does.
fn example(page: &Page, folder: &Path, number: usize, block: &Block, known: &[Command]) {
    let place = page.at(block.line);
    let words: Vec<&str> = block.words.iter().map(String::as_str).collect();
    let own = |ending: &str| format!("example_{number}.{ending}");
    let (kind, name) = match words[..] {
        ["sh"] => {
            for line in lines(&block.text) {
                let found = call(&line, &place);
                found.iter().for_each(|args| parse(args, known, &place));
            }
            return;
        }
        ["sh", "run"] => return run(folder, block, known, page),
        ["text", "shown"] => {
            let is_call = block.text.lines().any(|l| l.starts_with("scree ") || l.starts_with("cargo "));
            return assert!(!is_call, "{place}: a block that is only shown has calls: mark it `sh`");
        }
        ["yaml", kind @ ("model" | "metadata" | "job")] => (kind, own("yaml")),
        ["yaml", kind @ ("model" | "metadata" | "job"), name] => (kind, name.to_string()),
        [kind @ ("sl" | "rib")] => (kind, own(kind)),
        [kind @ ("sl" | "rib"), name] => (kind, name.to_string()),
        ["csv" | "obj" | "text", name] if name.contains('.') => ("data", name.to_string()),
        _ => panic!("{place}: the block is marked `{}`, which says not what to do with it", words.join(" ")),
    };
    std::fs::write(folder.join(&name), &block.text).unwrap();
    match kind {
        "model" => step(&folder.join(&name), &place),
        "metadata" | "job" => check(folder, &name, "metadata", &place),
        "sl" => check(folder, &name, "shader", &place),
        "rib" => check(folder, &name, "scene", &place),
        _ => {}
    }
}

#[test]
fn the_examples_of_every_page_run() {
    let known = commands();
    let mut n = 0;
    for page in pages::all() {
        let folder = scratch();
        for (number, block) in page.blocks().iter().enumerate() {
            example(&page, folder.path(), number, block, &known);
            n += 1;
        }
    }
    assert!(n > 60, "{n} examples");
}

#[test]
fn a_broken_example_is_found() {
    let page = Page { path: "broken.md".into(), lines: vec![] };
    let known = commands();
    let folder = scratch();
    let broken = [
        ("yaml model", "bodies: [{name: a, material: none, sphere: {radius: 1}}]\n"),
        ("yaml metadata", "objects: [{name: a, geometry: {sphere: {}}}]\n"),
        ("sl", "surface a() { Ci = nothing; }\n"),
        ("rib", "NoSuchRequest 1\n"),
        ("sh", "scree render --no-such-flag\n"),
        ("sh", "scree paint\n"),
        ("sh", "rm -r target\n"),
        ("sh run", "scree check missing.yaml\n"),
        ("text shown", "scree run model.yaml\n"),
        ("yaml", "step: 1\n"),
        ("", "step: 1\n"),
    ];
    for (mark, text) in broken {
        let block = Block { line: 1, words: mark.split_whitespace().map(String::from).collect(), text: text.into() };
        let tried = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
            example(&page, folder.path(), 0, &block, &known);
        }));
        assert!(tried.is_err(), "`{mark}` with `{text}` passes");
    }
}
