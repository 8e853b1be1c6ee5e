//! Tables over time: the probes and the report of a run, or any CSV with a column `time`.

use crate::report::Outcome;
use frame::{Column, Fault, FaultKind, Field, csv};
use std::path::{Path, PathBuf};

/// A run's columns over time.
pub struct TimeTable {
    /// The columns.
    pub columns: Vec<TimeColumn>,
}

/// A column over time.
pub struct TimeColumn {
    /// The column's name.
    pub name: String,
    /// The column's unit.
    pub unit: String,
    /// Times, s, and values.
    pub points: Vec<(f64, f64)>,
    /// Whether the first point is the first instant of the table.
    pub has_start: bool,
}

const PROBES: &str = "probes.csv";
const REPORT: &str = "report.csv";

/// Whether a path is a run directory, or a table itself.
pub fn is_table(path: &Path) -> bool {
    path.is_file() || ["run.json", PROBES, REPORT].iter().any(|name| path.join(name).is_file())
}

/// The tables of a path: its own, or those of the run directories in it.
pub fn find(path: &Path) -> Outcome<Vec<PathBuf>> {
    if is_table(path) {
        return Ok(vec![path.into()]);
    }
    let fault = |message: &str| Fault::whole(FaultKind::Data, path, message);
    if !path.exists() {
        return Err(fault("does not exist; expected a run directory or a folder of them").into());
    }
    let entries = std::fs::read_dir(path).map_err(|e| Fault::unreadable(FaultKind::Data, path, &e))?;
    let is_run = |p: &PathBuf| p.is_dir() && is_table(p);
    let mut runs: Vec<PathBuf> = entries.flatten().map(|e| e.path()).filter(is_run).collect();
    if runs.is_empty() {
        return Err(fault("is no run directory (it has no run.json), and none of its folders is one").into());
    }
    runs.sort_by_cached_key(|run| natural_order(&super::names::name_of(run)));
    Ok(runs)
}

/// The sort key of a name by which `2` comes before `10`: numbers are compared as numbers.
fn natural_order(name: &str) -> Vec<(String, u64)> {
    let is_number = |c: char| c.is_ascii_digit() || c == '.';
    let mut key = vec![];
    let mut rest = name;
    while !rest.is_empty() {
        let (word, tail) = rest.split_at(rest.find(is_number).unwrap_or(rest.len()));
        let (number, tail) = tail.split_at(tail.find(|c| !is_number(c)).unwrap_or(tail.len()));
        // The bits of positive numbers are in the order of the numbers.
        key.push((word.to_string(), number.parse::<f64>().unwrap_or(0.0).to_bits()));
        rest = tail;
    }
    key
}

/// Read the columns of a run, those of its probes first, or of a table.
pub fn read(path: &Path) -> Outcome<TimeTable> {
    if path.is_file() {
        return Ok(TimeTable { columns: read_file(path)? });
    }
    let (probes, report) = (path.join(PROBES), path.join(REPORT));
    let mut columns = vec![];
    if probes.is_file() || !report.is_file() {
        columns = read_file(&probes)?;
    }
    if report.is_file() {
        // A run that has just begun has a report without rows.
        let report = read_file(&report).unwrap_or_default();
        columns.extend(report.into_iter().filter(|c| c.unit != "ms" && c.name != "step"));
    }
    Ok(TimeTable { columns })
}

/// The columns of numbers of a CSV over its `time` column.
fn read_file(path: &Path) -> Outcome<Vec<TimeColumn>> {
    let table = csv::read(path, 0, &csv::Layout::default())?;
    let Some(time) = table.column("time").filter(|c| !matches!(c, Column::Category { .. })) else {
        let fault = Fault::whole(FaultKind::Data, path, "has no column `time` of numbers");
        return Err(fault.hint(format!("its columns are {}", table.names().join(", "))).into());
    };
    let is_curve = |name: &str, c: &Column| name != "time" && !matches!(c, Column::Category { .. });
    let points = |c: &Column| {
        let point = |r: usize| Some((time.number(r).filter(|t| t.is_finite())?, c.number(r)?));
        (0..table.rows()).filter_map(point).collect()
    };
    let columns = table.columns.iter().filter(|(f, c)| is_curve(&f.name, c));
    let column = |(f, c): &(Field, Column)| TimeColumn {
        name: f.name.clone(),
        // A pure number's axis shows no unit.
        unit: if f.unit == "1" { String::new() } else { f.unit.clone() },
        points: points(c),
        has_start: true,
    };
    Ok(columns.map(column).collect())
}

#[cfg(test)]
mod tests {
    use super::natural_order;

    #[test]
    fn names_are_sorted_by_their_numbers() {
        let mut names = ["mu=10", "mu=2", "mu=0.25", "mu=0.5", "a"];
        names.sort_by_key(|n| natural_order(n));
        assert_eq!(names, ["a", "mu=0.25", "mu=0.5", "mu=2", "mu=10"]);
    }
}
