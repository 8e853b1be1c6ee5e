//! Probes and solver reports of a run → curves over time, as far as they are written.

use frame::Fault;
use rerun::{RecordingStream, RecordingStreamResult, Scalars, SeriesLines, TimeColumn};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// Columns of `report.csv` that are shown.
const REPORTED: [&str; 4] = ["contacts", "iterations", "residual", "worst_penetration"];

/// A column of a series.
struct Curve {
    /// Its entity.
    path: String,
    unit: String,
    column: usize,
}

/// A CSV file that grows.
pub struct Series {
    path: PathBuf,
    time: usize,
    curves: Vec<Curve>,
    /// Bytes that have been read.
    at: u64,
}

impl Series {
    /// The curves of `probes.csv`, or of `report.csv`, of a run; none if there is no such file yet.
    pub fn of_run(run: &Path) -> Vec<Series> {
        ["probes.csv", "report.csv"].iter().filter_map(|name| Series::open(&run.join(name)).ok().flatten()).collect()
    }

    fn open(path: &Path) -> Result<Option<Series>, Fault> {
        if !path.is_file() {
            return Ok(None);
        }
        let table = frame::csv::read(path, 0, &frame::csv::Layout::default())?;
        let head: Vec<&frame::Field> = table.columns.iter().map(|(field, _)| field).collect();
        let is_report = path.ends_with("report.csv");
        let Some(time) = head.iter().position(|field| field.name == "time") else { return Ok(None) };
        let is_shown = |name: &str| if is_report { REPORTED.contains(&name) } else { name != "step" };
        let curve = |(column, field): (usize, &&frame::Field)| {
            let folder = if is_report { "solver" } else { "probes" };
            Curve { path: format!("{folder}\u{1f}{}", field.name), unit: field.unit.clone(), column }
        };
        let shown = head.iter().enumerate().filter(|(k, field)| *k != time && is_shown(&field.name));
        Ok(Some(Series { path: path.into(), time, curves: shown.map(curve).collect(), at: 0 }))
    }

    /// The entities of each unit, solver and probes apart.
    pub fn groups(&self) -> BTreeMap<String, Vec<rerun::EntityPath>> {
        let mut groups: BTreeMap<String, Vec<rerun::EntityPath>> = BTreeMap::new();
        for curve in &self.curves {
            let folder = curve.path.split('\u{1f}').next().unwrap_or_default();
            let unit = if curve.unit.is_empty() { "1" } else { &curve.unit };
            groups.entry(format!("{folder}, {unit}")).or_default().push(entity(&curve.path));
        }
        groups
    }

    /// Send the lines that have been added since the last time. Of a file that became shorter, all lines are sent again.
    pub fn send(&mut self, stream: &RecordingStream) -> RecordingStreamResult<()> {
        let Some(text) = self.added() else { return Ok(()) };
        let (mut times, mut values) = (vec![], vec![vec![]; self.curves.len()]);
        for line in text.lines() {
            let cells: Vec<f64> = line.split(',').map(|cell| cell.trim().parse().unwrap_or(f64::NAN)).collect();
            // The header has no numbers.
            let Some(time) = cells.get(self.time).filter(|time| time.is_finite()) else { continue };
            times.push(*time);
            for (curve, values) in self.curves.iter().zip(&mut values) {
                values.push(cells.get(curve.column).copied().unwrap_or(f64::NAN));
            }
        }
        if times.is_empty() {
            return Ok(());
        }
        for (curve, values) in self.curves.iter().zip(values) {
            let path = entity(&curve.path);
            let name = curve.path.split('\u{1f}').next_back().unwrap_or_default();
            stream.log_static(path.clone(), &SeriesLines::new().with_names([name]))?;
            let time = TimeColumn::new_duration_secs("time", times.iter().copied());
            let columns = Scalars::new(values).columns_of_unit_batches()?;
            stream.send_columns(path, [time], columns)?;
        }
        Ok(())
    }

    /// The whole lines that have been added.
    fn added(&mut self) -> Option<String> {
        let mut file = File::open(&self.path).ok()?;
        if file.metadata().ok()?.len() < self.at {
            self.at = 0;
        }
        file.seek(SeekFrom::Start(self.at)).ok()?;
        let mut bytes = vec![];
        file.read_to_end(&mut bytes).ok()?;
        let end = bytes.iter().rposition(|b| *b == b'\n')? + 1;
        bytes.truncate(end);
        self.at += end as u64;
        String::from_utf8(bytes).ok()
    }
}

fn entity(path: &str) -> rerun::EntityPath {
    rerun::EntityPath::from_iter(path.split('\u{1f}').map(rerun::EntityPathPart::new))
}
