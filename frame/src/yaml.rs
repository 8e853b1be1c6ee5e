//! Hand-written YAML read into types; every error has its place in the file.
//!
//! Structure (types, unknown and missing keys) is checked while reading. Meaning is checked later by the caller, who makes faults
//! through the [`Document`], which knows the place of each key: `doc.fault("materials.stone.density", "must be positive")`.

use crate::{Fault, FaultKind, listed, nearest, read_text};
use saphyr_parser::{Event, Parser};
use serde::de::DeserializeOwned;
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The text of a YAML file, and the place of each of its keys. Copies share them.
#[derive(Clone, Debug, Default)]
pub struct Document {
    /// Path of the file.
    pub path: PathBuf,
    /// The whole text.
    pub text: Arc<str>,
    places: Arc<Places>,
    /// Keys whose values were replaced after reading, each with the place of its new value.
    replaced: Vec<(String, Written)>,
}

/// Where a value is written that takes the place of another.
#[derive(Clone, Debug)]
pub enum Written {
    /// At a key of the document.
    Key(String),
    /// In this argument of the command line.
    Argument(String),
}

/// Read a YAML file into `T`. An error, with its place, if the file cannot be read or does not fit `T`.
pub fn read<T: DeserializeOwned>(path: &Path) -> Result<(T, Document), Fault> {
    let text = read_text(FaultKind::Input, path)?;
    parse(path, text)
}

/// Read YAML text, which came from `path`, into `T`. An error, with its place, if the text does not fit `T`.
pub fn parse<T: DeserializeOwned>(path: &Path, mut text: String) -> Result<(T, Document), Fault> {
    // Editors of Windows begin a file with a mark of its encoding.
    if text.starts_with(crate::text::MARK) {
        text.remove(0);
    }
    if text.trim().is_empty() {
        return Err(Fault::at(FaultKind::Input, path, "", 1, 1, "is empty"));
    }
    let places = Places::of(&text).map_err(|(line, column)| {
        Fault::at(FaultKind::Input, path, &text, line, column, format!("is nested more than {MAX_DEPTH} deep"))
    })?;
    let doc = Document { path: path.into(), places: Arc::new(places), text: text.into(), replaced: vec![] };
    let value = deserialize(&doc, serde_yaml::Deserializer::from_str(&doc.text))?;
    Ok((value, doc))
}

/// Read a document again as `value`, in which values are replaced. `replaced` has their keys, each with the place of its new value.
pub fn replace<T: DeserializeOwned>(
    doc: Document,
    value: serde_yaml::Value,
    replaced: Vec<(String, Written)>,
) -> Result<(T, Document), Fault> {
    let doc = Document { replaced, ..doc };
    let value = deserialize(&doc, value)?;
    Ok((value, doc))
}

fn deserialize<'a, T: DeserializeOwned>(
    doc: &Document,
    reader: impl serde::Deserializer<'a, Error = serde_yaml::Error>,
) -> Result<T, Fault> {
    serde_path_to_error::deserialize::<_, T>(reader)
        .map_err(|error| explain(doc, &error.path().to_string(), error.inner()))
}

impl Document {
    /// A fault at the key of a dotted path (`bodies.2.mass`), or at the longest part of the path that the file has; of a replaced
    /// value, where that is written. A message that begins with its verb (`is 0, expected …`) is given the key as its subject. That a value
    /// within the key's was replaced is said.
    pub fn fault(&self, key: &str, message: impl Into<String>) -> Fault {
        let message = with_subject(key, message.into());
        if let Some(written) = self.replacement(key) {
            return self.fault_in(written, message);
        }
        let (line, column) = self.place(key);
        let mut message = message;
        if let Some((_, with)) = self.replaced.iter().rev().find(|(path, _)| path.starts_with(&format!("{key}."))) {
            let with = self.fault_in(with, "");
            let place = if with.line == 0 { String::new() } else { format!(":{}:{}", with.line, with.column) };
            message += &format!("; a value in it is replaced by {}{place}", with.file.display());
        }
        Fault::at(FaultKind::Input, &self.path, &self.text, line, column, message)
    }

    /// Whether the file, or what replaces its values, gives the key of a dotted path.
    pub fn has(&self, key: &str) -> bool {
        self.places.find(key).is_some() || self.replacement(key).is_some()
    }

    /// Where the value is written that takes the place of that of a key, or of one around it; none if it is the file's.
    fn replacement(&self, key: &str) -> Option<&Written> {
        let is_within =
            |path: &str| key.strip_prefix(path).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'));
        self.replaced.iter().rev().find(|(path, _)| is_within(path)).map(|(_, written)| written)
    }

    /// A fault of a value that takes the place of another.
    pub fn fault_in(&self, written: &Written, message: impl Into<String>) -> Fault {
        match written {
            Written::Key(key) => {
                let (line, column) = self.place(key);
                Fault::at(FaultKind::Input, &self.path, &self.text, line, column, message)
            }
            Written::Argument(argument) => Fault::whole(FaultKind::Input, Path::new(argument), message),
        }
    }

    /// A fault of another file that the value of a key names: told with that file's place and hint, at the key.
    pub fn fault_of_named(&self, key: &str, other: Fault) -> Fault {
        let hint = other.hint.clone();
        let message = Fault { text: String::new(), hint: None, ..other }.to_string();
        Fault { hint, ..self.fault(key, message) }
    }

    /// Let a key that the file does not have, by which its readers name a value, stand where the key `at` does.
    pub fn stand(&mut self, key: &str, at: &str) {
        let place = self.place(at);
        Arc::make_mut(&mut self.places).standing.insert(key.into(), place);
    }

    /// The place of the key of a dotted path, or of the longest part of the path that the file has: line and column, from 1.
    pub fn place(&self, key: &str) -> (usize, usize) {
        let mut key = key;
        loop {
            if let Some(place) = self.places.find(key) {
                return place;
            }
            match key.rsplit_once('.') {
                Some((parent, _)) => key = parent,
                None => return (1, 1),
            }
        }
    }

    /// A fault at a dotted path for the unknown name `name` of a `what`, such as a material; its advice is the nearest of the known
    /// names.
    pub fn unknown(&self, key: &str, what: &str, name: &str, known: &[&str]) -> Fault {
        let fault = self.fault(key, format!("unknown {what} `{name}`, expected one of {}", listed(known)));
        match nearest(name, known.iter().copied()) {
            Some(near) => fault.hint(format!("did you mean `{near}`?")),
            None => fault,
        }
    }
}

/// A message about the value of a key, with the key before it if it does not say what it speaks of.
fn with_subject(key: &str, message: String) -> String {
    const VERBS: [&str; 16] = [
        "acts", "belong", "belongs", "bound", "cannot", "connects", "has", "is", "makes", "must", "names", "needs",
        "run", "runs", "stands", "takes",
    ];
    const OTHERS: [&str; 2] = ["expected", "invalid"];
    let is_index = |part: &str| part.bytes().all(|c| c.is_ascii_digit());
    let (first, _) = message.split_once(' ').unwrap_or_default();
    let joint = match first {
        verb if VERBS.contains(&verb) => " ",
        other if OTHERS.contains(&other) => ": ",
        _ => return message,
    };
    let mut parts = key.rsplit('.');
    let (last, around) = (parts.next().unwrap_or_default(), parts.find(|part| !is_index(part)));
    let subject = match (is_index(last).then(|| last.parse::<usize>().ok()).flatten(), around) {
        _ if last.is_empty() => return message,
        (Some(index), Some(list)) => format!("item {} of `{list}`", index + 1),
        _ => format!("`{last}`"),
    };
    format!("{subject}{joint}{message}")
}

/// The fault of a tab in the indentation of a line that cannot be read, or of the line before it.
fn tab(doc: &Document, error: &serde_yaml::Error) -> Option<Fault> {
    let message = error.to_string();
    // Within braces tabs are allowed: only what the scanner refuses is looked into.
    if !["cannot start any token", "tab character", "did not find expected"].iter().any(|part| message.contains(part)) {
        return None;
    }
    let at = error.location()?.line();
    let indentation = |line: usize| {
        let text = doc.text.lines().nth(line.checked_sub(1)?)?;
        let blanks = &text[..text.len() - text.trim_start().len()];
        blanks.find('\t').map(|tab| (line, tab + 1))
    };
    let (line, column) = [at, at.saturating_sub(1), at + 1].into_iter().find_map(indentation)?;
    let message = "a tab stands in the indentation: YAML does not allow tabs there";
    let fault = Fault::at(FaultKind::Input, &doc.path, &doc.text, line, column, message);
    Some(fault.hint("use spaces, the same number for all keys of one map"))
}

/// The fault of a text that ends before its last line, as the reader sees it: where a second one begins.
fn second(doc: &Document, error: &serde_yaml::Error) -> Option<Fault> {
    if !error.to_string().contains("more than one document") {
        return None;
    }
    let indentation = |line: &str| line.len() - line.trim_start().len();
    let is_content =
        |line: &str| !matches!(line.trim_start().chars().next(), None | Some('#' | '%')) && line.trim_end() != "---";
    let mut lines = doc.text.lines().enumerate().skip_while(|(_, line)| !is_content(line));
    let (_, first) = lines.next()?;
    let (at, line) = lines.find(|(_, line)| {
        let is_mark = line.starts_with("---") || line.starts_with("...");
        is_mark || is_content(line) && indentation(line) < indentation(first)
    })?;
    let is_mark = line.starts_with("---") || line.starts_with("...");
    let message = "a second document begins here: expected one in a file";
    let fault = Fault::at(FaultKind::Input, &doc.path, &doc.text, at + 1, 1 + indentation(line), message);
    Some(if is_mark { fault } else { fault.hint("give all keys of one map the same indentation: the first has more") })
}

/// A structural error as a fault: the place from the reader where it knows it, else from the path; the nearest key as a hint.
fn explain(doc: &Document, path: &str, error: &serde_yaml::Error) -> Fault {
    if let Some(fault) = tab(doc, error).or_else(|| second(doc, error)) {
        return fault;
    }
    let full = error.to_string();
    let message = full.split(" at line ").next().unwrap_or(&full);
    let message = message.strip_prefix(&format!("{path}: ")).unwrap_or(message);
    // The reader puts the path before some of its messages; the place says it already.
    let message = match message.split_once(": ") {
        Some((head, rest)) if !head.contains(' ') && path.starts_with(head) => rest,
        _ => message,
    };
    let name = ["unknown field `", "unknown variant `"]
        .iter()
        .find_map(|head| message.split_once(head))
        .and_then(|(_, rest)| rest.split('`').next());
    let known: Vec<&str> = message.split('`').skip(1).step_by(2).filter(|k| Some(*k) != name).collect();
    let near = name.and_then(|n| nearest(n, known));
    let fault = structural_fault(doc, path, name, error, in_plain_words(message));
    match near {
        Some(near) => fault.hint(format!("did you mean `{near}`?")),
        None => fault,
    }
}

/// The fault of a structural error of the value at `path`, in which the key `name` may be unknown.
fn structural_fault(
    doc: &Document,
    path: &str,
    name: Option<&str>,
    error: &serde_yaml::Error,
    message: String,
) -> Fault {
    let path = path.replace('[', ".").replace(']', "");
    let key = match name {
        Some(n) if path != "." && path != n && !path.ends_with(&format!(".{n}")) => format!("{path}.{n}"),
        _ => path,
    };
    let key = key.trim_start_matches('.');
    let message = with_subject(key, message);
    // The file was sound before values were replaced: one of those is at fault.
    let is_below = |replaced: &str| key.is_empty() || replaced.starts_with(&format!("{key}."));
    if let Some((_, written)) = doc.replaced.iter().rev().find(|(replaced, _)| is_below(replaced)) {
        return doc.fault_in(written, message);
    }
    let known_place = name.is_some() && doc.places.find(key).is_some();
    let (line, column) = match error.location() {
        _ if message.starts_with("duplicate") && doc.places.repeated.is_some() => {
            doc.places.repeated.unwrap_or_default()
        }
        Some(at) if !known_place && message.contains("invalid ") => (at.line(), at.column()),
        // Of a value that fits none of several types the reader knows the map around it alone.
        Some(at) if !known_place => (at.line(), at.column()).max(doc.places.find(key).unwrap_or_default()),
        _ => return doc.fault(key, message),
    };
    Fault::at(FaultKind::Input, &doc.path, &doc.text, line, column, message)
}

/// A message of the reader without the names of the program's types.
fn in_plain_words(message: &str) -> String {
    let Some((head, expected)) = message.rsplit_once("expected ") else { return message.into() };
    let words = match expected {
        "u8" | "u16" | "u32" | "u64" | "usize" => "a whole number, 0 or more",
        "i8" | "i16" | "i32" | "i64" | "isize" => "a whole number",
        "f32" | "f64" => "a number",
        "a string" | "str" => "a text",
        "a boolean" => "true or false",
        "a YAML tag starting with '!'" | "a Value::Tagged enum" => "a word",
        "a sequence" => "a list",
        other if other.starts_with("struct ") => "keys with values",
        other if other.starts_with("tuple ") || other.starts_with("an array of length") => {
            return format!("{head}expected a list{}", other.find(" of ").map_or("", |at| &other[at..]));
        }
        _ => return message.into(),
    };
    format!("{head}expected {words}")
}

/// The deepest nesting of lists and maps.
const MAX_DEPTH: usize = 64;

/// Where every key and list item of a YAML text stands.
#[derive(Clone, Debug, Default)]
struct Places {
    /// Each value of a key and each item of a list; the first is the whole text.
    values: Vec<Value>,
    /// Where a key stands for the second time.
    repeated: Option<(usize, usize)>,
    /// Keys that the text does not have, and where they stand.
    standing: HashMap<String, (usize, usize)>,
}

/// A value of the text.
#[derive(Clone, Debug, Default)]
struct Value {
    /// Line and column, from 1, of its key, or of itself in a list.
    line: u32,
    column: u32,
    /// What is in it; none in a scalar.
    parts: Option<Box<Parts>>,
}

/// Indices of the values in a value.
#[derive(Clone, Debug)]
enum Parts {
    Map(HashMap<String, u32>),
    List(Vec<u32>),
}

impl Places {
    /// Where all stands in a text; of one that is not YAML, what came before the error. An error, with its place, if lists and maps are nested
    /// too deep.
    fn of(text: &str) -> Result<Places, (usize, usize)> {
        let mut places = Places { values: vec![Value::default()], ..Places::default() };
        // The lists and maps that are open, each with the value of the key that has been read last.
        let mut open: Vec<(u32, Option<u32>)> = vec![];
        for event in Parser::new_from_str(text) {
            let (event, span) = match event {
                Ok(next) => next,
                // The parser reads ahead of what it tells of.
                Err(e) if e.info().contains("recursion") => return Err((e.marker().line(), e.marker().col() + 1)),
                Err(_) => break,
            };
            let at = (span.start.line(), span.start.col() + 1);
            if open.len() > MAX_DEPTH {
                return Err(at);
            }
            match event {
                Event::MappingStart(..) => {
                    let value = places.begin(&mut open, at);
                    places.values[value as usize].parts = Some(Box::new(Parts::Map(HashMap::new())));
                    open.push((value, None));
                }
                Event::SequenceStart(..) => {
                    let value = places.begin(&mut open, at);
                    places.values[value as usize].parts = Some(Box::new(Parts::List(vec![])));
                    open.push((value, None));
                }
                Event::MappingEnd | Event::SequenceEnd => {
                    open.pop();
                }
                Event::Scalar(name, ..) => match open.last_mut() {
                    Some((map, key @ None)) if places.is_map(*map) => *key = Some(places.key(*map, &name, at)),
                    _ => {
                        places.begin(&mut open, at);
                    }
                },
                Event::Alias(_) => {
                    places.begin(&mut open, at);
                }
                _ => {}
            }
        }
        Ok(places)
    }

    fn is_map(&self, value: u32) -> bool {
        self.values[value as usize].parts.as_deref().is_some_and(|parts| matches!(parts, Parts::Map(_)))
    }

    fn push(&mut self, (line, column): (usize, usize)) -> u32 {
        self.values.push(Value { line: line as u32, column: column as u32, parts: None });
        self.values.len() as u32 - 1
    }

    /// The value that begins here: that of the key before, a new item of a list, or the whole text.
    fn begin(&mut self, open: &mut [(u32, Option<u32>)], at: (usize, usize)) -> u32 {
        let Some((around, key)) = open.last_mut() else { return 0 };
        if let Some(value) = key.take() {
            return value;
        }
        let (around, value) = (*around as usize, self.push(at));
        if let Some(Parts::List(items)) = self.values[around].parts.as_deref_mut() {
            items.push(value);
        }
        value
    }

    /// The value of a key of a map.
    fn key(&mut self, map: u32, name: &str, at: (usize, usize)) -> u32 {
        let value = self.push(at);
        if let Some(Parts::Map(keys)) = self.values[map as usize].parts.as_deref_mut()
            && keys.insert(name.into(), value).is_some()
        {
            self.repeated.get_or_insert(at);
        }
        value
    }

    /// Line and column, from 1, of a key by its dotted path (`a.b.2.c`), if there is one.
    fn find(&self, path: &str) -> Option<(usize, usize)> {
        if let Some(place) = self.standing.get(path) {
            return Some(*place);
        }
        let value = &self.values[self.find_in(0, path)? as usize];
        Some((value.line as usize, value.column as usize))
    }

    /// The value at a path within another. Keys may have dots.
    fn find_in(&self, value: u32, path: &str) -> Option<u32> {
        let part = |name: &str| match self.values.get(value as usize)?.parts.as_deref()? {
            Parts::Map(keys) => keys.get(name).copied(),
            Parts::List(items) => items.get(name.parse::<usize>().ok()?).copied(),
        };
        let within = |(dot, _)| self.find_in(part(&path[..dot])?, &path[dot + 1..]);
        part(path).or_else(|| path.match_indices('.').find_map(within))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Deserialize;

    #[derive(Deserialize, Debug)]
    #[serde(deny_unknown_fields)]
    struct Stone {
        #[allow(dead_code)]
        density: f64,
    }

    #[derive(Deserialize, Debug)]
    #[serde(deny_unknown_fields)]
    struct Top {
        #[allow(dead_code)]
        stones: Vec<Stone>,
    }

    #[derive(Deserialize, Debug)]
    #[serde(rename_all = "snake_case")]
    enum Tone {
        Dark,
    }

    #[derive(Deserialize, Debug)]
    struct Shade {
        #[allow(dead_code)]
        shade: Tone,
    }

    fn fault(text: &str) -> Fault {
        parse::<Top>(Path::new("m.yaml"), text.into()).unwrap_err()
    }

    #[test]
    fn an_unknown_key_is_placed_and_its_neighbour_named() {
        let f = fault("stones:\n  - density: 1\n  - densty: 2\n");
        assert_eq!((f.line, f.column), (3, 5), "{f}");
        assert_eq!(f.hint.as_deref(), Some("did you mean `density`?"));
    }

    #[test]
    fn a_wrong_type_and_a_torn_file_are_placed() {
        let f = fault("stones:\n  - density: heavy\n");
        assert_eq!((f.line, f.column), (2, 14), "{f}");
        let choice = parse::<Shade>(Path::new("m.yaml"), "shade: [dark]\n".into()).unwrap_err();
        assert!(choice.message.ends_with("expected a word"), "{choice}");
        assert_eq!(fault("stones: [\n  {density: 1},\n").line, 3);
        assert_eq!(fault(" \n").message, "is empty");
    }

    #[test]
    fn a_tab_in_the_indentation_is_explained() {
        for text in
            ["stones:\n\t- density: 1\n", "stones:\n  - density: 1\n\t- density: 2\n", "stones:\n  -\n\tdensity: 1\n"]
        {
            let f = fault(text);
            let line = text.lines().position(|l| l.starts_with('\t')).unwrap() + 1;
            assert!(f.message.contains("YAML does not allow tabs"), "{text}: {f}");
            assert_eq!((f.line, f.column), (line, 1), "{f}");
        }
    }

    #[test]
    fn meaning_is_placed_by_path() {
        let (_, doc) = parse::<Top>(Path::new("m.yaml"), "stones:\n  - density: -1\n".into()).unwrap();
        assert_eq!(doc.place("stones.0.density"), (2, 5));
        assert_eq!(doc.place("stones.0.no.such"), (2, 5));
    }

    #[test]
    fn a_second_document_is_placed() {
        let f = fault("# stones\n stones:\n   - density: 1\n\nmore: 2\n");
        assert_eq!((f.line, f.column, f.hint.is_some()), (5, 1, true), "{f}");
        let f = fault("---\nstones: [{density: 1}]\n---\nstones: []\n");
        assert_eq!((f.line, f.column, f.hint.is_some()), (3, 1, false), "{f}");
    }

    #[test]
    fn a_message_has_its_key_as_subject() {
        let (_, doc) = parse::<Top>(Path::new("m.yaml"), "stones:\n  - density: -1\n".into()).unwrap();
        for (key, message, expected) in [
            ("stones.0.density", "is -1, expected a number above 0", "`density` is -1, expected a number above 0"),
            ("stones.0.density", "expected a number", "`density`: expected a number"),
            ("stones.0", "needs a `density`", "item 1 of `stones` needs a `density`"),
            ("stones.0", "there is a stone already", "there is a stone already"),
            ("stones.0", "isolated stones", "isolated stones"),
            ("", "has no stones", "has no stones"),
        ] {
            assert_eq!(doc.fault(key, message).message, expected);
        }
        assert!(fault("stones:\n  - density: heavy\n").message.starts_with("`density`: invalid type"));
    }
}
