//! Tables over time: the probes and the report of a run, or any CSV with a column of times.

use crate::report::Outcome;
use frame::{Column, Fault, FaultKind, Field, Frame, csv};
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

/// Whether a file is one of a run directory.
pub fn is_of_run(file: &Path) -> bool {
    file.file_name().is_some_and(|name| name == PROBES || name == REPORT)
}

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
    let runs: Vec<PathBuf> = entries.flatten().map(|e| e.path()).filter(is_run).collect();
    if runs.is_empty() {
        return Err(fault("is no run directory (it has no run.json), and none of its folders is one").into());
    }
    Ok(in_natural_order(runs))
}

/// Runs in the order of their names, by which `2` comes before `10`.
pub fn in_natural_order(mut runs: Vec<PathBuf>) -> Vec<PathBuf> {
    runs.sort_by_cached_key(|run| natural_order(&super::names::name_of(run)));
    runs
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
    let Some((field, time)) = time_of(&table) else {
        let fault = Fault::whole(FaultKind::Data, path, "has no column of times, `time` or `t`, of numbers");
        return Err(fault.hint(format!("its columns are {}", frame::listed(&table.names()))).into());
    };
    let seconds = seconds(path, field)?;
    let times: Vec<Option<f64>> = (0..table.rows()).map(|r| Some(time.number(r)? * seconds)).collect();
    if let Some(r) = times.windows(2).position(|w| w[1] < w[0]) {
        let [a, b] = [r, r + 1].map(|r| times[r].unwrap_or(f64::NAN));
        let message = format!("`{}` goes back from {a} to {b} s in row {}", field.name, r + 2);
        return Err(Fault::whole(FaultKind::Data, path, message).hint("sort the rows by time").into());
    }
    let is_curve = |name: &str, c: &Column| name != field.name && !matches!(c, Column::Category { .. });
    let points = |c: &Column| {
        let point = |r: usize| Some((times[r].filter(|t| t.is_finite())?, c.number(r)?));
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

/// The column of a table's times: `time`, or else a name that means it in other programs, in any case and with a unit or without, as
/// `Time`, `t` and `Time [s]`.
fn time_of(table: &Frame) -> Option<&(Field, Column)> {
    let plain =
        |name: &str| name.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect::<String>();
    let with = |is_name: &dyn Fn(&str) -> bool| {
        table.columns.iter().find(|(f, c)| is_name(&f.name) && !matches!(c, Column::Category { .. }))
    };
    let names = ["time", "t", "times", "simtime", "simulationtime", "timestamp"];
    with(&|name| name == "time").or_else(|| names.iter().find_map(|known| with(&|name| plain(name) == *known)))
}

/// Seconds over the unit of a table's times.
fn seconds(path: &Path, time: &Field) -> Outcome<f64> {
    const UNITS: [(&str, f64); 9] = [
        ("", 1.0),
        ("s", 1.0),
        ("sec", 1.0),
        ("ms", 1e-3),
        ("us", 1e-6),
        ("µs", 1e-6),
        ("min", 60.0),
        ("h", 3600.0),
        ("1", 1.0),
    ];
    let (name, unit) = (&time.name, time.unit.as_str());
    let known = UNITS.into_iter().find(|(name, _)| *name == unit).map(|(_, seconds)| seconds);
    known.ok_or_else(|| {
        Fault::whole(FaultKind::Data, path, format!("`{name}` has the unit [{unit}], expected s, ms, µs, min or h"))
            .into()
    })
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
