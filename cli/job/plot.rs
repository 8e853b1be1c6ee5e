//! The job of `scree plot`: the chosen columns, one plot for those of one joint, body or sum that have the same unit.

use crate::args::{Interval, PlotArgs};
use crate::report::{Exit, Failure, Outcome};
use frame::sequence::matches;
use frame::{Column, Fault, FaultKind, csv};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Plots to draw.
pub struct PlotJob {
    /// The plots.
    pub plots: Vec<Plot>,
    /// Their folder.
    pub folder: PathBuf,
}

/// A plot of series that share a unit.
pub struct Plot {
    /// The plot's file name, without ending.
    pub name: String,
    /// The plot's title.
    pub title: String,
    /// The series.
    pub series: Vec<Series>,
}

/// A column over time.
pub struct Series {
    /// The column's name.
    pub name: String,
    /// The column's unit.
    pub unit: String,
    /// Times, s, and values.
    pub points: Vec<(f64, f64)>,
}

impl PlotJob {
    /// Check the arguments: read the series and choose among them.
    pub fn check(args: PlotArgs) -> Outcome<PlotJob> {
        let mut all = read(&args.run.join("probes.csv"))?;
        if let Ok(report) = read(&args.run.join("report.csv")) {
            all.extend(report.into_iter().filter(|s| s.unit != "ms" && s.name != "step"));
        }
        let series = choose(all, &args.columns)?;
        let folder = args.output.unwrap_or_else(|| args.run.join("plots"));
        Ok(PlotJob { plots: group(series, args.times), folder })
    }
}

/// The series whose names match one of the patterns; all series if there are no patterns.
fn choose(all: Vec<Series>, patterns: &[String]) -> Outcome<Vec<Series>> {
    if let Some(p) = patterns.iter().find(|p| !all.iter().any(|s| is_selected(p, &s.name))) {
        let owners = all.iter().filter_map(|s| s.name.rsplit_once('.').map(|(owner, _)| owner));
        let near = frame::nearest(p, all.iter().map(|s| s.name.as_str()).chain(owners));
        let hint = near.map_or(String::new(), |n| format!(", did you mean `{n}`?"));
        return Err(Failure::new(Exit::Usage, format!("no column matches `{p}`{hint}")));
    }
    let chosen = |s: &Series| patterns.is_empty() || patterns.iter().any(|p| is_selected(p, &s.name));
    Ok(all.into_iter().filter(chosen).collect())
}

/// Whether a column's name matches a pattern with `*`, or is of what the pattern names: `hinge` has `hinge.fx_world`.
fn is_selected(pattern: &str, name: &str) -> bool {
    matches(pattern, name) || matches(&format!("{pattern}.*"), name)
}

/// The series by plots: those of one owner that have the same unit, within the interval.
fn group(series: Vec<Series>, times: Option<Interval>) -> Vec<Plot> {
    let mut plots: BTreeMap<(String, String), Vec<Series>> = BTreeMap::new();
    for mut s in series {
        if let Some(Interval { from, to }) = times {
            s.points.retain(|(t, _)| (from..=to).contains(t));
        }
        let owner = s.name.rsplit_once('.').map_or(s.name.clone(), |(owner, _)| owner.to_string());
        plots.entry((owner, s.unit.clone())).or_default().push(s);
    }
    let plot = |((owner, unit), series): ((String, String), Vec<Series>)| {
        let name = format!("{owner}_{}", if unit.is_empty() { "number" } else { &unit });
        let name = name.chars().map(|c| if c.is_alphanumeric() || c == '_' || c == '-' { c } else { '_' }).collect();
        let title = if unit.is_empty() { owner } else { format!("{owner} [{unit}]") };
        Plot { name, title, series }
    };
    plots.into_iter().map(plot).collect()
}

/// The columns of a probe or report file over its `time` column.
fn read(path: &Path) -> Outcome<Vec<Series>> {
    let table = csv::read(path, 0, &csv::Layout::default())?;
    let Some(time) = table.column("time") else {
        return Err(Fault::whole(FaultKind::Data, path, "has no column `time`").into());
    };
    let value = |c: &Column, row: usize| c.number(row).filter(|x| x.is_finite());
    let points = |c: &Column| (0..table.rows()).filter_map(|r| Some((value(time, r)?, value(c, r)?))).collect();
    let columns = table.columns.iter().filter(|(f, _)| f.name != "time");
    Ok(columns.map(|(f, c)| Series { name: f.name.clone(), unit: f.unit.clone(), points: points(c) }).collect())
}
