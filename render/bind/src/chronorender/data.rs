//! The data of a job: CSV files, and what is done to them.

use super::job::{Job, Map, list_of, text};
use super::places::Places;
use frame::Fault;
use frame::csv::Layout;
use serde_yaml::Value;
use std::path::PathBuf;

/// The files of a job's data, how they are laid out, and what is done to each.
pub(super) struct Table {
    pub(super) pattern: PathBuf,
    pub(super) delimiter: Option<char>,
    pub(super) header: Option<bool>,
    pub(super) columns: Option<Vec<String>>,
    /// Cells that every row has at least.
    pub(super) min_cells: Option<usize>,
    /// Columns and the formulas that they are computed by.
    pub(super) derive: Vec<(String, String)>,
    pub(super) select: Option<String>,
}

impl Table {
    /// Whether the rows say themselves what they are.
    pub(super) fn is_exported(&self) -> bool {
        self.columns.as_deref().unwrap_or_default() == EXPORTED
    }

    /// The files' layout.
    pub(super) fn layout(&self, delimiter: Option<u8>) -> Layout {
        Layout { delimiter, header: self.header, names: self.columns.clone(), min_cells: self.min_cells }
    }

    /// The file of the first frame.
    pub(super) fn first_file(&self) -> Option<PathBuf> {
        frame::sequence::find(&self.pattern).ok()?.into_values().next()
    }

    /// Whether files without a header look as the exporter writes them: the tenth cell is the name of a shape.
    fn looks_exported(&self) -> bool {
        let Some(text) = self.first_file().and_then(|path| guard::read_to_string(&path).ok()) else { return false };
        let line = text.lines().find(|l| !l.trim().is_empty() && !l.starts_with('#')).unwrap_or_default();
        let cells: Vec<&str> = line.split(self.delimiter.unwrap_or(',')).map(str::trim).collect();
        let shapes = ["sphere", "cube", "box", "ellipsoid", "cylinder", "cone", "obj"];
        cells.len() >= MIN_EXPORTED && shapes.contains(&cells[9])
    }
}

/// Columns of a table that Chrono::Render's exporter for Blender has written; the last ones as far as the row's type has sizes.
const EXPORTED: [&str; 13] =
    ["group", "id", "pos_x", "pos_y", "pos_z", "quat_w", "quat_x", "quat_y", "quat_z", "type", "ep1", "ep2", "ep3"];

/// The minimum of cells of its rows.
const MIN_EXPORTED: usize = 11;

/// The data of a simulation.
pub(super) fn table(job: &Job<'_>, key: &str, simulation: &Map, places: &Places) -> Result<Table, Fault> {
    let at = format!("{key}.data");
    let Some(data) = simulation.get("data") else { return Err(job.doc.fault(key, "has no `data`")) };
    let map = job.map(&at, data, &["name", "datasource", "dataprocess"])?;
    let process = (format!("{at}.dataprocess"), map.get("dataprocess").cloned());
    let sources = list_of(&format!("{at}.datasource"), map.get("datasource"));
    let Some((at, source)) = sources.first() else { return Err(job.doc.fault(&at, "has no `datasource`")) };
    let known = ["type", "name", "resource", "fields", "delim", "read_header", "skip_rows", "comments", "missing"];
    let map = job.map(at, source, &known)?;
    if let Some(kind) = map.get("type").map(text).filter(|t| t != "csv") {
        return Err(job.doc.unknown(&format!("{at}.type"), "data source", &kind, &["csv"]));
    }
    let resource = map.get("resource").map(text).unwrap_or_default();
    let found = places.locate_pattern(&resource).ok_or_else(|| {
        job.doc.fault(&format!("{at}.resource"), format!("no file fits `{resource}` in the search paths"))
    })?;
    let mut columns = Vec::new();
    for field in map.get("fields").and_then(Value::as_sequence).into_iter().flatten() {
        columns.push(match field {
            Value::Sequence(pair) if !pair.is_empty() => text(&pair[0]),
            other => text(other),
        });
    }
    let delimiter = map.get("delim").map(text).and_then(|d| d.chars().next()).filter(|c| *c != ' ');
    let header = map.get("read_header").and_then(Value::as_bool);
    let mut table = Table {
        pattern: found,
        delimiter,
        header: header.or((!columns.is_empty()).then_some(false)),
        columns: (!columns.is_empty()).then_some(columns),
        min_cells: None,
        derive: vec![],
        select: None,
    };
    if table.columns.is_none() && table.looks_exported() {
        table.columns = Some(EXPORTED.map(String::from).to_vec());
        (table.header, table.min_cells) = (Some(false), Some(MIN_EXPORTED));
    }
    processes(job, &process.0, process.1.as_ref(), &mut table)?;
    Ok(table)
}

/// What is done to the data: rows are chosen, columns derived.
pub(super) fn processes(job: &Job<'_>, key: &str, value: Option<&Value>, table: &mut Table) -> Result<(), Fault> {
    for (at, value) in list_of(key, value) {
        let map = job.map(&at, &value, &["type", "name", "condition", "formula", "field_name", "inputs", "args"])?;
        let need = |name: &str| {
            let found = map.get(name).map(text).filter(|t| !t.trim().is_empty());
            found.ok_or_else(|| job.doc.fault(&at, format!("needs a `{name}`")))
        };
        match map.get("type").map(text).unwrap_or_default().as_str() {
            "select" => {
                let condition = need("condition")?;
                table.select = Some(match table.select.take() {
                    Some(before) => format!("({before}) and ({condition})"),
                    None => condition,
                });
            }
            "derive" => table.derive.push((need("field_name")?, need("formula")?)),
            other => {
                return Err(job.doc.unknown(&format!("{at}.type"), "data process", other, &["select", "derive"]));
            }
        }
    }
    Ok(())
}
