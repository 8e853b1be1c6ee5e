//! The model file: its types, its checks, and its resolution into a [`Model`] and a [`State`].
//!
//! Units of the file are SI (m, kg, s, N, rad) but for rotations, limits of angles, free angles of springs and phases of sines, which are
//! in degrees. Most keys have a default; [`ModelFile::to_yaml`] writes the model with its defaults filled in.

mod resolve;
mod shape;
mod types;

pub use types::*;

use crate::{Model, State};
use frame::yaml::Document;
use frame::{Fault, FaultKind};
use std::path::Path;

/// Read, check and resolve a model file; returns the file as written and the resolved model.
///
/// # Errors
/// The first fault of the file, with its line and column.
pub fn read(path: &Path) -> Result<(ModelFile, Resolved), Fault> {
    read_with(path, &[])
}

/// Read, check and resolve a model file with values in place of those of the file. `set` has pairs of a key's path and a YAML value, as
/// (`solver.iterations`, `80`) or (`bodies.block.mass`, `3`): the command's option `--set`.
///
/// # Errors
/// The faults of [`read`], a path in `set` that leads to no key, and a value in `set` that is not YAML.
pub fn read_with(path: &Path, set: &[(String, String)]) -> Result<(ModelFile, Resolved), Fault> {
    let (file, doc) = load(path, set)?;
    let resolved = file.resolve(&doc)?;
    Ok((file, resolved))
}

/// Read a model file, with values in place of those of the file as in [`read_with`], without resolving it.
///
/// # Errors
/// The faults of [`read_with`] that are found without resolving.
pub fn load(path: &Path, set: &[(String, String)]) -> Result<(ModelFile, Document), Fault> {
    let (mut file, mut doc): (ModelFile, Document) = if set.is_empty() {
        frame::yaml::read(path)?
    } else {
        // The file itself must be valid, so that its faults are reported at their lines.
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

/// A resolved model, ready to run.
#[derive(Clone, Debug, Default)]
pub struct Resolved {
    /// The model.
    pub model: Model,
    /// The initial state.
    pub state: State,
    /// The quantities of `probes.csv`.
    pub probes: Probes,
    /// Name and end time, s, of each stage.
    pub stages: Vec<(String, f64)>,
    /// Warnings for the user, as of deep overlaps at the start.
    pub warnings: Vec<String>,
}

/// The quantities of `probes.csv`, resolved to ids.
#[derive(Clone, Debug, Default)]
pub struct Probes {
    /// Time between lines, s.
    pub interval: f64,
    /// Ids of the probed bodies.
    pub bodies: Vec<u32>,
    /// Ids of the probed joints.
    pub joints: Vec<u32>,
    /// Ids of the probed springs.
    pub springs: Vec<u32>,
    /// Name of each total contact force, and its two classes, indices into [`Model::class_names`]; the force is on the second.
    pub contacts: Vec<(String, [u32; 2])>,
    /// Whether energies are written.
    pub energies: bool,
    /// Whether every frame has a table of its contacts.
    pub contact_tables: bool,
}

/// Text of a document with values replaced or added.
fn with_values(doc: &Document, set: &[(String, String)]) -> Result<String, Fault> {
    let usage = |message: String| Fault::whole(FaultKind::Input, &doc.path, message);
    let mut root: serde_yaml::Value =
        serde_yaml::from_str(&doc.text).map_err(|e| usage(format!("is not YAML: {e}")))?;
    for (path, text) in set {
        let value: serde_yaml::Value = serde_yaml::from_str(text)
            .map_err(|e| usage(format!("--set {path}={text}: the value is not YAML: {e}")))?;
        let mut at = &mut root;
        for part in path.split('.') {
            at = step_into(at, part)
                .ok_or_else(|| usage(format!("--set {path}: there is no key, index or name `{part}`")))?;
        }
        *at = value;
    }
    serde_yaml::to_string(&root).map_err(|e| usage(format!("--set: {e}")))
}

/// The value of a map's key, which is added if it is missing, or an item of a list by its index or its `name`.
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
