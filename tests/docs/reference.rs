//! The tables of the pages against what the program has: keys, commands and flags, functions, requests, shaders, scenes, tests.

use super::pages::{self, Page, Row, quoted, root};
use crate::cli::scree;
use render::sl::{Global, ir::builtins};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};

/// A command, and all its flags, short and long.
pub struct Command {
    /// Its name, as `render` or `bench sim`; empty for what every command has.
    pub name: String,
    pub flags: Vec<String>,
    /// Long flags and their defaults, where these are numbers.
    numbers: Vec<(String, String)>,
}

/// A command as its help has it, with the names of its own commands.
fn command(name: &str) -> (Command, Vec<String>) {
    let args: Vec<&str> = name.split_whitespace().chain(["--help"]).collect();
    let help = scree(&args).ok();
    let (mut flags, mut numbers, mut inner) = (vec![], vec![], vec![]);
    let mut section = "";
    for line in help.lines() {
        let text = line.trim_start();
        let indent = line.len() - text.len();
        if indent == 0 && text.ends_with(':') {
            section = line;
        } else if section == "Commands:" {
            inner.extend(text.split_whitespace().next().map(String::from));
        } else if indent <= 6 && text.starts_with('-') {
            let named = text.split_whitespace().take_while(|w| w.starts_with('-'));
            flags.extend(named.map(|w| w.trim_end_matches(',').to_string()));
        }
        let default = text.split_once("[default: ").and_then(|(_, rest)| rest.split_once(']'));
        if let (Some((value, _)), Some(flag)) = (default, flags.last())
            && value.parse::<f64>().is_ok()
        {
            numbers.push((flag.clone(), value.to_string()));
        }
    }
    inner.retain(|n| n != "help");
    (Command { name: name.into(), flags, numbers }, inner)
}

/// All commands, and at the end what every command has.
pub fn commands() -> Vec<Command> {
    let (top, names) = command("");
    let mut all = vec![];
    for name in names {
        let (found, inner) = command(&name);
        all.push(found);
        all.extend(inner.iter().map(|i| command(&format!("{name} {i}")).0));
    }
    assert!(all.len() >= 14, "{} commands", all.len());
    assert!(all.iter().map(|c| c.numbers.len()).sum::<usize>() >= 8, "defaults are not found in the help texts");
    all.push(top);
    all
}

#[test]
fn every_command_and_flag_is_described() {
    let page = pages::page("command.md");
    let known = commands();
    let common = known.last().unwrap().flags.clone();
    for command in &known {
        let heading = if command.name.is_empty() { "Every command".into() } else { format!("scree {}", command.name) };
        let rows = page.rows(page.section(&heading));
        let flags_of = |row: &Row| -> Vec<String> {
            let words = quoted(&row.cells[0]).into_iter().filter_map(|q| q.split_whitespace().next());
            words.filter(|w| w.starts_with('-')).map(String::from).collect()
        };
        let told: BTreeSet<String> = rows.iter().flat_map(flags_of).collect();
        let own = |flag: &&String| command.name.is_empty() || !common.contains(flag);
        let there: BTreeSet<String> = command.flags.iter().filter(own).cloned().collect();
        assert_eq!(told, there, "flags of `{heading}`: those of the page, those of --help");
        for (flag, value) in &command.numbers {
            let row = rows.iter().find(|row| flags_of(row).contains(flag)).unwrap();
            let numbers = numbers(&row.cells.join(" "));
            assert!(numbers.contains(&value.parse().unwrap()), "{}: the default is {value}", page.at(row.line));
        }
    }
    let sections = page.headings().iter().filter(|h| h.2.starts_with("scree ")).count();
    assert_eq!(sections, known.len() - 1, "a command is described that is not there");
}

/// The numbers in a text.
fn numbers(text: &str) -> Vec<f64> {
    let plain = text.replace('−', "-");
    let words = plain.split(|c: char| !(c.is_ascii_alphanumeric() || matches!(c, '.' | '-' | '+')));
    words.filter_map(|w| w.trim_end_matches('.').parse().ok()).collect()
}

/// Rows of the tables that a comment `<!-- keys: TYPE, … -->` stands before, by type.
fn keys(page: &Page) -> BTreeMap<String, Vec<Row>> {
    let mut found: BTreeMap<String, Vec<Row>> = BTreeMap::new();
    for (line, text) in page.prose() {
        let Some(types) = text.strip_prefix("<!-- keys: ").and_then(|t| t.strip_suffix(" -->")) else { continue };
        let end = (line..page.lines.len()).find(|l| !page.lines[*l].starts_with('|')).unwrap_or(page.lines.len());
        for name in types.split(", ") {
            found.entry(name.into()).or_default().extend(page.rows([line + 1, end + 1]));
        }
    }
    found
}

/// Whether a row says in its third cell what a default is.
fn says(row: &Row, default: &Value) -> bool {
    let text = &row.cells[2];
    match default {
        Value::Number(x) => numbers(text).contains(&x.as_f64().unwrap()),
        Value::String(s) => s.is_empty() || text.contains(s.as_str()),
        Value::Bool(b) => text.contains(&b.to_string()),
        Value::Array(list) => list.iter().all(|v| says(row, v)),
        Value::Object(_) | Value::Null => true,
    }
}

/// Hold a page's tables of keys to a schema: every key of every type, with its default, and no other.
fn hold_keys(page: &Page, root: &str, schema: &Value) {
    let told = keys(page);
    let mut types: BTreeMap<&str, &Value> = BTreeMap::from([(root, schema)]);
    types.extend(schema["$defs"].as_object().unwrap().iter().map(|(name, s)| (name.as_str(), s)));
    let properties = |name: &str| types.get(name).and_then(|s| s["properties"].as_object());
    for (name, rows) in &told {
        assert!(properties(name).is_some(), "{}: there is no type {name}", page.name());
        for row in rows {
            for key in quoted(&row.cells[0]) {
                let mut lists = told.iter().filter(|(_, rows)| rows.iter().any(|r| r.line == row.line));
                let is_there = lists.any(|(name, _)| properties(name).unwrap().contains_key(key));
                assert!(is_there, "{}: there is no key `{key}`", page.at(row.line));
            }
        }
    }
    for (name, schema) in &types {
        for (key, property) in schema["properties"].as_object().into_iter().flatten() {
            let rows = told.get(*name).unwrap_or_else(|| panic!("{}: {name} has no table of keys", page.name()));
            let named: Vec<&Row> = rows.iter().filter(|r| quoted(&r.cells[0]).contains(&key.as_str())).collect();
            assert!(!named.is_empty(), "{}: the table of {name} lacks `{key}`", page.name());
            let default = &property["default"];
            let is_said = named.iter().any(|row| says(row, default));
            assert!(is_said, "{}: the default of `{key}` is {default}", page.at(named[0].line));
        }
        let text = page.lines.join("\n");
        for word in schema["oneOf"].as_array().into_iter().flatten().filter_map(|one| one["const"].as_str()) {
            assert!(text.contains(&format!("`{word}`")), "{}: {name} may be `{word}`, which is missing", page.name());
        }
    }
}

#[test]
fn every_key_is_described_with_its_default() {
    for (kind, root) in [("model", "ModelFile"), ("metadata", "Metadata")] {
        let schema = serde_json::from_str(&scree(&["schema", kind]).ok()).unwrap();
        hold_keys(&pages::page(&format!("{kind}.md")), root, &schema);
    }
}

/// Names before a bracket, in the first cells of tables: `noise(p)` has `noise`.
fn called(rows: &[Row]) -> BTreeSet<String> {
    let cells = rows.iter().flat_map(|row| quoted(&row.cells[0]));
    cells.filter_map(|q| q.split_once('(')).map(|(name, _)| name.trim().to_string()).collect()
}

#[test]
fn every_shading_function_and_variable_is_described() {
    let page = pages::page("shading.md");
    let mut there: BTreeSet<String> = builtins::TABLE.iter().map(|row| row.name.to_string()).collect();
    there.remove("");
    // Functions of the prelude; those that end in `_` stand behind a row of the table.
    let prelude = std::fs::read_to_string(root().join("render/sl/src/front/prelude.rs")).unwrap();
    let types = ["color", "float", "point", "vector", "normal", "void"];
    for line in prelude.lines().filter(|l| l.ends_with('{') || l.ends_with('}')) {
        let head = line.split_once('(').and_then(|(head, _)| head.split_once(' '));
        there.extend(head.filter(|(ty, name)| types.contains(ty) && !name.ends_with('_')).map(|(_, n)| n.to_string()));
    }
    assert!(there.len() > 90 && there.contains("diffuse") && there.contains("raylevel"), "{there:?}");
    let groups = ["Numbers", "Triples", "Matrices and spaces", "Patterns", "Derivatives", "Light and rays", "Maps"];
    let groups = groups.into_iter().chain(["Strings", "Messages"]);
    let told: BTreeSet<String> = groups.flat_map(|g| called(&page.rows(page.section(g)))).collect();
    let lacks: Vec<&String> = there.difference(&told).collect();
    let strange: Vec<&String> = told.difference(&there).collect();
    assert!(
        lacks.is_empty() && strange.is_empty(),
        "shading.md lacks {lacks:?}, and has {strange:?} that are not there"
    );
    let rows = page.rows(page.section("Predefined variables"));
    let told: BTreeSet<&str> = rows.iter().flat_map(|row| quoted(&row.cells[0])).collect();
    assert_eq!(told, Global::all().map(|g| g.name()).collect(), "predefined variables");
}

#[test]
fn every_request_is_described() {
    let page = pages::page("shading.md");
    let table = std::fs::read_to_string(root().join("render/ri/src/table.rs")).unwrap();
    let request = |line: &str| {
        let (name, rest) = line.trim_start().split_once(" [")?;
        let is_row = ["options", "world", "any"].iter().any(|w| rest.starts_with(w)) && !name.contains('/');
        is_row.then(|| name.to_string())
    };
    let there: BTreeSet<String> = table.lines().filter_map(request).collect();
    assert!(there.len() > 90, "{} requests", there.len());
    let groups =
        ["Frames and blocks", "Options", "Attributes", "Transformations", "Primitives", "Archives and the rest"];
    let rows: Vec<Row> = groups.iter().flat_map(|g| page.rows(page.section(g))).collect();
    let words = rows.iter().flat_map(|row| quoted(&row.cells[0])).filter_map(|q| q.split_whitespace().next());
    // What `Option` and `Attribute` set stands in quotes.
    let told: BTreeSet<String> = words.filter(|w| !w.starts_with('"')).map(String::from).collect();
    assert_eq!(told, there, "requests: those of the page, those of the table");
}

/// Hold the parameters and defaults in a row's second cell to what `scree shader` says.
fn hold_parameters(page: &Page, row: &Row, said: &str) {
    // A name in backticks, and what follows it up to the next.
    let told: Vec<&str> = row.cells[1].split('`').skip(1).collect();
    let told: BTreeMap<&str, Vec<f64>> = told.chunks(2).map(|c| (c[0], numbers(c.get(1).unwrap_or(&"")))).collect();
    let lines: Vec<&str> = said.lines().skip(1).collect();
    let params: BTreeMap<&str, Vec<f64>> =
        lines.chunks(2).map(|l| (l[0].split('"').nth(1).unwrap(), numbers(l[1].split_once(": ").unwrap().1))).collect();
    assert_eq!(
        told.keys().collect::<Vec<_>>(),
        params.keys().collect::<Vec<_>>(),
        "{}: parameters of {}",
        page.at(row.line),
        row.cells[0]
    );
    for (name, values) in params {
        let is_told = |x: &f64| told[name].iter().any(|y| (x - y).abs() <= 1e-3 * x.abs());
        assert!(values.iter().all(is_told), "{}: the default of `{name}` is {values:?}", page.at(row.line));
    }
}

#[test]
fn the_library_is_described() {
    let page = pages::page("shading.md");
    for kind in ["surface", "displacement", "light", "volume", "imager"] {
        let heading = format!("Library: {kind} shaders");
        let rows = page.rows(page.section(&heading));
        let files = std::fs::read_dir(root().join("shaders").join(kind)).unwrap().map(|e| e.unwrap().path());
        let names: BTreeSet<String> = files.map(|p| p.file_stem().unwrap().to_string_lossy().into_owned()).collect();
        let told: BTreeSet<String> = rows.iter().map(|row| quoted(&row.cells[0])[0].to_string()).collect();
        assert_eq!(told, names, "{heading}");
        for row in &rows {
            let file = root().join(format!("shaders/{kind}/{}.sl", quoted(&row.cells[0])[0]));
            let said = scree(&["shader", file.to_str().unwrap()]).ok();
            hold_parameters(&page, row, &said);
        }
    }
    let page = pages::page("metadata.md");
    let rows = page.rows(page.section("Scenes of the library"));
    let told: BTreeSet<String> = rows.iter().map(|row| quoted(&row.cells[0])[0].to_string()).collect();
    let files = std::fs::read_dir(root().join("scenes")).unwrap().map(|e| e.unwrap().file_name());
    assert_eq!(told, files.map(|f| f.to_string_lossy().into_owned()).collect(), "scenes");
    let text = page.lines.join("\n");
    for map in bind::colormap::names() {
        assert!(text.contains(&format!("`{map}`")), "metadata.md lacks the colour map {map}");
    }
}

#[test]
fn the_tests_that_pages_name_are_there() {
    let mut n = 0;
    for page in pages::all() {
        for (line, text) in page.prose() {
            let named = quoted(text).into_iter().filter_map(|q| q.split_once("::"));
            for (file, test) in named {
                let path = root().join(format!("tests/{file}.rs"));
                let source = std::fs::read_to_string(&path).unwrap_or_default();
                assert!(source.contains(&format!("fn {test}(")), "{}: there is no {file}::{test}", page.at(line));
                n += 1;
            }
        }
    }
    assert!(n > 15, "{n} tests are named");
}
