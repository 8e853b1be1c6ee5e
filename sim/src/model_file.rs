//! The model file: what an engineer writes, checked and resolved into a [`Model`] and a [`State`].
//!
//! Units are SI (m, kg, s, N, rad) but for angles in the file, which are in degrees. Almost everything has a default;
//! [`ModelFile::to_yaml`] writes the model with its defaults filled in.

mod resolve;
mod shape;
mod types;

pub use types::*;

use crate::{Model, State};
use frame::yaml::Document;
use frame::{Fault, FaultKind};
use std::path::Path;

/// Read, check and resolve a model file.
pub fn read(path: &Path) -> Result<(ModelFile, Resolved), Fault> {
    read_with(path, &[])
}

/// Read a model file with values set from outside: `solver.iterations=80`, `bodies.block.mass=3`.
pub fn read_with(path: &Path, set: &[(String, String)]) -> Result<(ModelFile, Resolved), Fault> {
    let (file, doc) = load(path, set)?;
    let resolved = file.resolve(&doc)?;
    Ok((file, resolved))
}

/// Read a model file without resolving it.
pub fn load(path: &Path, set: &[(String, String)]) -> Result<(ModelFile, Document), Fault> {
    let (mut file, mut doc): (ModelFile, Document) = if set.is_empty() {
        frame::yaml::read(path)?
    } else {
        // The file as it stands must be sound, so that faults in it are shown where they are.
        let (_, original): (ModelFile, Document) = frame::yaml::read(path)?;
        let text = with_values(&original, set)?;
        frame::yaml::parse(path, text)?
    };
    doc.path = path.into();
    file.anchor_paths(path.parent().unwrap_or(Path::new("")));
    if file.name.is_empty() {
        file.name = path.file_stem().and_then(|s| s.to_str()).unwrap_or("model").into();
    }
    Ok((file, doc))
}

/// A model ready to run.
#[derive(Clone, Debug, Default)]
pub struct Resolved {
    /// The model.
    pub model: Model,
    /// Its state at the start.
    pub state: State,
    /// What is written down while it runs.
    pub probes: Probes,
    /// Names and end times of the stages.
    pub stages: Vec<(String, f64)>,
    /// What is odd but not wrong: deep overlaps at the start, for instance.
    pub warnings: Vec<String>,
}

/// What is written to `probes.csv`, resolved.
#[derive(Clone, Debug, Default)]
pub struct Probes {
    /// Time between two lines, s.
    pub interval: f64,
    /// Bodies.
    pub bodies: Vec<u32>,
    /// Joints.
    pub joints: Vec<u32>,
    /// Springs.
    pub springs: Vec<u32>,
    /// Pairs of classes whose contacts are added up, with a name.
    pub contacts: Vec<(String, [u32; 2])>,
    /// Whether energies are written.
    pub energies: bool,
    /// Whether every frame has a table of its contacts.
    pub contact_tables: bool,
}

/// The text of a document with values put in place of others, or added.
fn with_values(doc: &Document, set: &[(String, String)]) -> Result<String, Fault> {
    let usage = |message: String| Fault::whole(FaultKind::Input, &doc.path, message);
    let mut root: serde_yaml::Value =
        serde_yaml::from_str(&doc.text).map_err(|e| usage(format!("is not YAML: {e}")))?;
    for (path, text) in set {
        let value: serde_yaml::Value =
            serde_yaml::from_str(text).map_err(|e| usage(format!("--set {path}={text}: is not a value: {e}")))?;
        let mut at = &mut root;
        for part in path.split('.') {
            at = step_into(at, part).ok_or_else(|| usage(format!("--set {path}: there is no `{part}` to go into")))?;
        }
        *at = value;
    }
    serde_yaml::to_string(&root).map_err(|e| usage(format!("--set: {e}")))
}

/// A key of a map (made if it is missing), or an item of a list by its number or its `name`.
fn step_into<'a>(value: &'a mut serde_yaml::Value, part: &str) -> Option<&'a mut serde_yaml::Value> {
    use serde_yaml::Value;
    match value {
        Value::Sequence(items) => {
            let index = part
                .parse::<usize>()
                .ok()
                .filter(|i| *i < items.len())
                .or_else(|| items.iter().position(|item| item.get("name").and_then(Value::as_str) == Some(part)))?;
            items.get_mut(index)
        }
        Value::Mapping(map) => Some(map.entry(Value::String(part.into())).or_insert(Value::Null)),
        Value::Null => {
            *value = Value::Mapping(Default::default());
            step_into(value, part)
        }
        _ => None,
    }
}
