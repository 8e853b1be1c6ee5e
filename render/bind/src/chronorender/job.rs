//! A job's file as it is read: maps with known keys, elements that may be one or a list of them, numbers in texts.

use frame::Fault;
use frame::yaml::Document;
use serde_yaml::Value;
use std::collections::BTreeMap;

/// The top-level key by which a file is recognised as a job of Chrono::Render.
pub const ROOT: &str = "chronorender";

/// A map of the file.
pub(super) type Map = BTreeMap<String, Value>;

/// Reads a job's file, and knows where things stand in it.
pub(super) struct Job<'a> {
    pub(super) doc: &'a Document,
}

impl Job<'_> {
    /// A map; a list of one counts. A key that nobody knows is warned of: the original took any.
    pub(super) fn map(&self, key: &str, value: &Value, known: &[&str]) -> Result<Map, Fault> {
        let value = match value {
            Value::Sequence(list) if list.len() == 1 => &list[0],
            other => other,
        };
        let Value::Mapping(map) = value else { return Err(self.doc.fault(key, "expected a map")) };
        let mut out = Map::new();
        for (name, value) in map {
            let name = text(name);
            if !known.is_empty() && !known.contains(&name.as_str()) {
                let at = format!("{key}.{name}");
                match name.as_str() {
                    "script" => self.no_python(&at, "write what it makes as a RIB file, or by the keys of the job"),
                    _ => self.warn(&at, &self.doc.unknown(&at, "key", &name, known).message),
                }
            }
            out.insert(name, value.clone());
        }
        Ok(out)
    }

    /// The elements of a key of the top map.
    pub(super) fn list(&self, map: &Map, name: &str) -> Result<Vec<(String, Value)>, Fault> {
        Ok(list_of(&format!("{ROOT}.{name}"), map.get(name)))
    }

    /// The first element of a key of the top map.
    pub(super) fn first(&self, map: &Map, name: &str) -> Result<Option<(String, Value)>, Fault> {
        Ok(self.list(map, name)?.into_iter().next())
    }

    /// Numbers of a list, or of a string of them.
    pub(super) fn numbers(&self, key: &str, value: &Value, n: usize) -> Result<Vec<f64>, Fault> {
        let words: Vec<String> = match value {
            Value::Sequence(list) => list.iter().map(text).collect(),
            other => text(other).replace(',', " ").split_whitespace().map(String::from).collect(),
        };
        let numbers: Option<Vec<f64>> = words.iter().map(|w| w.parse().ok()).collect();
        match numbers.filter(|v| v.len() == n) {
            Some(v) => Ok(v),
            None => Err(self.doc.fault(key, format!("expected {n} numbers, found `{}`", words.join(" ")))),
        }
    }

    /// Warn at the place of a key.
    pub(super) fn warn(&self, key: &str, message: &str) {
        let (line, column) = self.doc.place(key);
        eprintln!("warning: {}:{line}:{column}: {message}", self.doc.path.display());
    }

    /// Warn of the keys of a map that are known and change nothing, each with what to do instead.
    pub(super) fn no_effect(&self, key: &str, map: &Map, names: &[(&str, &str)]) {
        for (name, instead) in names.iter().filter(|(name, _)| map.contains_key(*name)) {
            self.warn(&format!("{key}.{name}"), &format!("`{name}` has no effect: {instead}"));
        }
    }

    /// Warn where the job calls Python, and say what to do instead.
    pub(super) fn no_python(&self, key: &str, instead: &str) {
        self.warn(key, &format!("calls Python, which is not run: {instead}"));
    }
}

/// An element's own text.
pub(super) fn text(value: &Value) -> String {
    match value {
        Value::String(s) => s.clone(),
        Value::Number(n) => n.to_string(),
        Value::Bool(b) => b.to_string(),
        Value::Sequence(list) => list.iter().map(text).collect::<Vec<_>>().join(" "),
        _ => String::new(),
    }
}

/// The elements of a value.
pub(super) fn elements_of(value: &Value) -> Vec<&Value> {
    match value {
        Value::Sequence(list) => list.iter().collect(),
        one => vec![one],
    }
}

/// One element or a list of them, with their keys.
pub(super) fn list_of(key: &str, value: Option<&Value>) -> Vec<(String, Value)> {
    match value {
        None | Some(Value::Null) => vec![],
        Some(Value::Sequence(list)) => {
            list.iter().enumerate().map(|(k, v)| (format!("{key}.{k}"), v.clone())).collect()
        }
        Some(one) => vec![(key.into(), one.clone())],
    }
}
