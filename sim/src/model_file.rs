//! The model file: its types, its checks, and its resolution into a [`Model`] and a [`State`].
//!
//! Units of the file are SI (m, kg, s, N, rad) but for rotations, limits of angles, free angles of springs and phases of sines, which are
//! in degrees. Most keys have a default; [`ModelFile::to_yaml`] writes the model with its defaults filled in.

pub(crate) mod quality;
mod resolve;
mod shape;
mod types;

pub use types::*;

use crate::{Model, State};
use frame::yaml::{Document, Written};
use frame::{Fault, FaultKind, nearest};
use std::path::Path;

/// Read, check and resolve a model file; returns the file as written and the resolved model.
///
/// # Errors
/// The first fault of the file, with its line and column.
pub fn read(path: &Path) -> Result<(ModelFile, Resolved), Fault> {
    let (file, doc) = load(path, &[])?;
    let resolved = file.resolve(&doc)?;
    Ok((file, resolved))
}

/// A value of a model file that another takes the place of.
#[derive(Clone, Debug)]
pub struct Replacement {
    /// Dotted path of the key, in which an item of a list has its index or its `name`: `bodies.block.mass`.
    pub path: String,
    /// The value, YAML.
    pub value: String,
    /// Key of the file where the value is written, as `sweep.step.2`; that of `--set` on the command line if there is none.
    pub written: Option<String>,
}

/// Read a model file, with values replaced, without resolving it, and fill in what its `quality` chooses.
///
/// # Errors
/// The faults of [`read`] that are found without resolving; those of a replacement, where its value is written.
pub fn load(path: &Path, replacements: &[Replacement]) -> Result<(ModelFile, Document), Fault> {
    // The file itself must be valid, so that the faults of others are those of the replacements.
    let (mut file, doc): (ModelFile, Document) = frame::yaml::read(path)?;
    if !replacements.is_empty() {
        return Variants { root: root(&doc)?, doc }.load(replacements);
    }
    name(&mut file, path);
    file.choose(&doc)?;
    Ok((file, doc))
}

/// A model file that is read many times, with other values each time.
pub struct Variants {
    doc: Document,
    root: serde_yaml::Value,
}

impl Variants {
    /// The variants of a model file, of which this is the document, without its sweep.
    ///
    /// # Errors
    /// A text that is not YAML.
    pub fn without_sweep(doc: &Document) -> Result<Variants, Fault> {
        let mut root = root(doc)?;
        if let Some(root) = root.as_mapping_mut() {
            root.remove("sweep");
        }
        Ok(Variants { doc: doc.clone(), root })
    }

    /// Read the file with values replaced, as [`load`] does.
    ///
    /// # Errors
    /// Those of [`load`].
    pub fn load(&self, replacements: &[Replacement]) -> Result<(ModelFile, Document), Fault> {
        let (mut file, doc): (ModelFile, Document) = replace(self.doc.clone(), self.root.clone(), replacements)?;
        name(&mut file, &doc.path);
        file.choose(&doc)?;
        Ok((file, doc))
    }
}

/// Name the model of a file that gives no name, and let the paths in it start at its folder.
fn name(file: &mut ModelFile, path: &Path) {
    file.anchor_paths(path.parent().unwrap_or(Path::new("")));
    if file.name.is_empty() {
        file.name = path.file_stem().and_then(|s| s.to_str()).unwrap_or("model").into();
    }
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

/// The values of a document.
fn root(doc: &Document) -> Result<serde_yaml::Value, Fault> {
    serde_yaml::from_str(&doc.text).map_err(|e| Fault::whole(FaultKind::Input, &doc.path, format!("is not YAML: {e}")))
}

/// Read a document again with values replaced or added. `root` has its values.
fn replace(
    doc: Document,
    mut root: serde_yaml::Value,
    replacements: &[Replacement],
) -> Result<(ModelFile, Document), Fault> {
    let mut replaced = vec![];
    for replacement in replacements {
        let written = replacement.place();
        let value: serde_yaml::Value = serde_yaml::from_str(&replacement.value)
            .map_err(|e| doc.fault_in(&written, format!("the value is not YAML: {e}")))?;
        let mut at = &mut root;
        let mut key = vec![];
        let n_parts = replacement.path.split('.').count();
        for (i, part) in replacement.path.split('.').enumerate() {
            // What a value goes into is there already, but for the sections of a model.
            let may_add = |known: &[String]| match &key[..] {
                _ if i == 0 || i + 1 == n_parts => true,
                [section] if section == "materials" => false,
                _ => nearest(part, known.iter().map(String::as_str)).is_none(),
            };
            let (name, next) = step_into(at, part, &may_add).map_err(|known| {
                let fault = doc.fault_in(&written, format!("there is no key, index or name `{part}`"));
                match nearest(part, known.iter().map(String::as_str)) {
                    Some(near) => fault.hint(format!("did you mean `{near}`?")),
                    None => fault,
                }
            })?;
            key.push(name);
            at = next;
        }
        *at = value;
        replaced.push((key.join("."), written));
    }
    frame::yaml::replace(doc, root, replaced)
}

impl Replacement {
    /// Where the value is written.
    fn place(&self) -> Written {
        match &self.written {
            Some(key) => Written::Key(key.clone()),
            None => Written::Argument(format!("--set {}={}", self.path, self.value)),
        }
    }
}

/// The value of a map's key, which is added if it is missing, or an item of a list by its index or its `name`, with its key or index;
/// else the names that are known. Of these, `may_add` tells whether another key may be added.
fn step_into<'a>(
    value: &'a mut serde_yaml::Value,
    part: &str,
    may_add: &dyn Fn(&[String]) -> bool,
) -> Result<(String, &'a mut serde_yaml::Value), Vec<String>> {
    use serde_yaml::Value;
    match value {
        Value::Sequence(items) => {
            let name_of = |item: &Value| item.get("name").and_then(Value::as_str).map(str::to_string);
            let index = part.parse::<usize>().ok().filter(|i| *i < items.len());
            match index.or_else(|| items.iter().position(|item| name_of(item).as_deref() == Some(part))) {
                Some(index) => Ok((index.to_string(), &mut items[index])),
                None => Err(items.iter().filter_map(name_of).collect()),
            }
        }
        Value::Mapping(map) => {
            let known: Vec<String> = map.keys().filter_map(Value::as_str).map(str::to_string).collect();
            match map.contains_key(part) || may_add(&known) {
                true => Ok((part.into(), map.entry(Value::String(part.into())).or_insert(Value::Null))),
                false => Err(known),
            }
        }
        Value::Null => {
            *value = Value::Mapping(Default::default());
            step_into(value, part, may_add)
        }
        _ => Err(vec![]),
    }
}
