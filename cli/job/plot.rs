//! The job of `scree plot`: the chosen columns of one run, one plot for those of one joint, body or sum that have the same unit; of
//! several runs, one plot for each column with a curve for each run.

pub(super) mod names;
pub mod table;

use super::output;
use super::run_folder::spare_link;
use crate::args::{Interval, PlotArgs};
use crate::report::{Exit, Failure, Outcome};
use frame::sequence::matches;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use table::{TimeColumn, TimeTable};

/// Plots to draw.
pub struct PlotJob {
    /// The plots.
    pub plots: Vec<Plot>,
    /// Their folder.
    pub folder: PathBuf,
    /// Whether the vertical range extends to the first instant of every run.
    pub full_range: bool,
    /// What is missing in the data.
    pub warnings: Vec<String>,
}

/// A plot of curves that have the same unit.
#[derive(Clone)]
pub struct Plot {
    /// The plot's file name, without ending.
    pub name: String,
    /// The plot's title.
    pub title: String,
    /// What the vertical axis shows, if it is one quantity.
    pub quantity: String,
    /// The unit of the vertical axis; empty for plain numbers.
    pub unit: String,
    /// The curves.
    pub curves: Vec<Curve>,
}

/// A quantity over time.
#[derive(Clone)]
pub struct Curve {
    /// The curve's name in the legend.
    pub label: String,
    /// Times, s, and values; a value that is not finite is a gap.
    pub points: Vec<(f64, f64)>,
    /// Whether the first point is the first instant of the run.
    pub has_start: bool,
}

/// The most curves of a plot that are told apart by color and dashes.
const MAX_CURVES: usize = 12;

impl PlotJob {
    /// Check the arguments: read the tables and choose among their columns.
    pub fn check(args: PlotArgs) -> Outcome<PlotJob> {
        let PlotArgs { run, columns: patterns, with, output, times, full_range } = args;
        no_paths(&patterns, &run)?;
        let is_overlay = !with.is_empty() || !table::is_table(&run);
        let mut paths = vec![];
        for path in std::iter::once(&run).chain(&with) {
            paths.extend(table::find(path)?);
        }
        let mut seen = BTreeSet::new();
        paths.retain(|path| seen.insert(path.canonicalize().unwrap_or(path.clone())));
        let mut tables = paths.iter().map(|path| table::read(path)).collect::<Outcome<Vec<_>>>()?;
        choose(&mut tables, &patterns)?;
        cut(&mut tables, times)?;
        let (plots, mut warnings) =
            if is_overlay { overlay(&paths, tables)? } else { (by_owner(&run, tables.remove(0)), vec![]) };
        if plots.is_empty() {
            let message = format!("{} has no columns of numbers beside the times", run.display());
            return Err(Failure::new(Exit::Data, message));
        }
        let is_blank = |plot: &&Plot| plot.curves.iter().flat_map(|c| &c.points).all(|p| !p.1.is_finite());
        warnings.extend(
            plots.iter().filter(is_blank).map(|plot| format!("`{}` has no values: its plot is empty", plot.title)),
        );
        let beside = if run.is_file() { run.parent().unwrap_or(Path::new("")) } else { &run };
        let folder = match output {
            Some(folder) => folder,
            None => {
                spare_link(&beside.join("plots"), beside)?;
                beside.join("plots")
            }
        };
        if folder.is_file() {
            return Err(Failure::new(Exit::Usage, format!("--output {}: is a file, and no folder", folder.display())));
        }
        Ok(PlotJob { plots: with_own_names(split(plots)), folder, full_range, warnings })
    }
}

/// Refuse runs among the columns, as a shell's `runs/*` gives them.
fn no_paths(patterns: &[String], run: &Path) -> Outcome {
    let Some(path) = patterns.iter().find(|p| p.contains('/') && Path::new(p).exists()) else { return Ok(()) };
    let message = format!(
        "`{path}` is a path where a column's name was expected\n  = runs go into one plot by --with: \
         scree plot {} --with {path} …; or give the folder that holds them all",
        run.display()
    );
    Err(Failure::new(Exit::Usage, message))
}

/// Keep the columns whose names match one of the patterns, or all if there are no patterns.
pub(super) fn choose(tables: &mut [TimeTable], patterns: &[String]) -> Outcome {
    let names: BTreeSet<&str> = tables.iter().flat_map(|t| &t.columns).map(|c| c.name.as_str()).collect();
    if let Some(p) = patterns.iter().find(|p| !names.iter().any(|n| is_selected(p, n))) {
        let owners = names.iter().filter_map(|n| n.rsplit_once('.').map(|(owner, _)| owner));
        let near = frame::nearest(p, names.iter().copied().chain(owners));
        let hint = near.map_or(String::new(), |n| format!(", did you mean `{n}`?"));
        return Err(Failure::new(Exit::Usage, format!("no column matches `{p}`{hint}")));
    }
    for table in tables {
        table.columns.retain(|c| patterns.is_empty() || patterns.iter().any(|p| is_selected(p, &c.name)));
    }
    Ok(())
}

/// Whether a column's name matches a pattern with `*`, or is of what the pattern names: `hinge` has `hinge.fx_world`.
fn is_selected(pattern: &str, name: &str) -> bool {
    matches(pattern, name) || matches(&format!("{pattern}.*"), name)
}

/// Cut the columns to an interval of time.
fn cut(tables: &mut [TimeTable], times: Option<Interval>) -> Outcome {
    let Some(Interval { from, to }) = times else { return Ok(()) };
    let all = || tables.iter().flat_map(|t| &t.columns).flat_map(|c| &c.points).map(|p| p.0);
    let (first, last) = all().fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), t| (lo.min(t), hi.max(t)));
    if !all().any(|t| (from..=to).contains(&t)) {
        let message =
            format!("--times {from}-{to}: there is no instant in this interval; the data has {first} to {last} s");
        return Err(Failure::new(Exit::Usage, message));
    }
    for column in tables.iter_mut().flat_map(|t| &mut t.columns) {
        column.has_start &= column.points.first().is_some_and(|p| p.0 >= from);
        column.points.retain(|(t, _)| (from..=to).contains(t));
    }
    Ok(())
}

impl Curve {
    fn new(label: &str, column: TimeColumn) -> Curve {
        Curve { label: label.into(), points: column.points, has_start: column.has_start }
    }
}

/// The plots of one table, as files of their own.
fn by_owner(run: &Path, table: TimeTable) -> Vec<Plot> {
    // The tables of a folder have plots of their own.
    let is_own = !run.is_file() || table::is_of_run(run);
    let prefix = if is_own { String::new() } else { format!("{}_", output::stem(run)) };
    let run = names::name_of(run);
    let mut plots = of_owners(table);
    for plot in &mut plots {
        plot.name.insert_str(0, &prefix);
        plot.title += &format!("  ({run})");
    }
    plots
}

/// One plot for the columns of each owner that have the same unit.
pub(super) fn of_owners(table: TimeTable) -> Vec<Plot> {
    let mut plots: BTreeMap<(String, String), Vec<TimeColumn>> = BTreeMap::new();
    for column in table.columns {
        let owner = column.name.rsplit_once('.').map_or(column.name.as_str(), |(owner, _)| owner);
        // The same vector in two frames of reference would be curves that hide each other.
        let frame = ["_joint", "_world"].into_iter().find(|frame| column.name.ends_with(frame)).unwrap_or("");
        plots.entry((format!("{owner}{frame}"), column.unit.clone())).or_default().push(column);
    }
    let plot = |((owner, unit), columns): ((String, String), Vec<TimeColumn>)| {
        let part = |c: &TimeColumn| c.name.rsplit_once('.').map_or(c.name.clone(), |(_, part)| part.into());
        let quantity = if columns.len() == 1 { part(&columns[0]) } else { String::new() };
        let curves = columns.into_iter().map(|c| Curve::new(&part(&c), c)).collect();
        Plot { name: file_name(&owner, &unit), title: owner, quantity, unit, curves }
    };
    plots.into_iter().map(plot).collect()
}

/// One plot for each column, with a curve for each run that has it. Runs that have not are named.
pub(super) fn overlay(paths: &[PathBuf], tables: Vec<TimeTable>) -> Outcome<(Vec<Plot>, Vec<String>)> {
    let mut plots: Vec<Plot> = vec![];
    let labels = names::labels(paths);
    let mut all: BTreeMap<String, usize> = BTreeMap::new();
    let mut own: Vec<BTreeSet<String>> = vec![];
    for (i, table) in tables.into_iter().enumerate() {
        own.push(table.columns.iter().map(|c| c.name.clone()).collect());
        for column in table.columns {
            let name = column.name.clone();
            let at = *all.entry(name.clone()).or_insert(plots.len());
            if at == plots.len() {
                let (unit, quantity) = (column.unit.clone(), name.rsplit('.').next().unwrap_or("").to_string());
                let file = file_name(&name, &unit);
                plots.push(Plot { name: file, title: name.clone(), quantity, unit, curves: vec![] });
            }
            let plot = &mut plots[at];
            if plot.unit != column.unit {
                let message = format!(
                    "`{name}` has the unit [{}] in {}, and [{}] in the runs before it: these do not go into one plot",
                    column.unit,
                    paths[i].display(),
                    plot.unit
                );
                return Err(Failure::new(Exit::Data, message));
            }
            plot.curves.push(Curve::new(&labels[i], column));
        }
    }
    let warning = |(path, own): (&PathBuf, &BTreeSet<String>)| {
        let lacking: Vec<String> = all.keys().filter(|n| !own.contains(*n)).map(|n| format!("`{n}`")).collect();
        let more = if lacking.len() > 5 { format!(" and {} more", lacking.len() - 5) } else { String::new() };
        let some = lacking.iter().take(5).cloned().collect::<Vec<_>>().join(", ");
        (!lacking.is_empty()).then(|| format!("{} has no column {some}{more}", path.display()))
    };
    let warnings = paths.iter().zip(&own).filter_map(warning).collect();
    Ok((plots, warnings))
}

/// A file name of what a plot shows.
fn file_name(what: &str, unit: &str) -> String {
    guard::text::file_name(&format!("{what}_{}", if unit.is_empty() { "number" } else { unit }), "-")
}

/// Split plots of more curves than can be told apart.
fn split(plots: Vec<Plot>) -> Vec<Plot> {
    let mut out = vec![];
    for mut plot in plots {
        let n = plot.curves.len().div_ceil(MAX_CURVES);
        if n < 2 {
            out.push(plot);
            continue;
        }
        for i in 1..=n {
            let rest = plot.curves.split_off(plot.curves.len().min(MAX_CURVES));
            let curves = std::mem::replace(&mut plot.curves, rest);
            let (name, title) = (format!("{}_{i}", plot.name), format!("{}, {i} of {n}", plot.title));
            out.push(Plot { name, title, quantity: plot.quantity.clone(), unit: plot.unit.clone(), curves });
        }
    }
    out
}

/// Plots whose file names would be the same get names of their own.
fn with_own_names(mut plots: Vec<Plot>) -> Vec<Plot> {
    let mut taken = BTreeSet::new();
    for plot in &mut plots {
        let base = plot.name.clone();
        let mut i = 1;
        while !taken.insert(plot.name.to_lowercase()) {
            i += 1;
            plot.name = format!("{base}_{i}");
        }
    }
    plots
}
