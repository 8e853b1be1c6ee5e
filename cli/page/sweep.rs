//! The page of a folder of runs: an image of each, their values in a table to sort, the curves of their probes and reports laid over each
//! other.

use super::drawing::Drawing;
use super::view::{Cell, Page, Run, Table, Tone, Warning};
use super::{ending, files, media, number, series, single};
use crate::job::{PAGE, Plot, ReportJob, RunData};
use rayon::prelude::*;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// Width of the image of a run, pixels.
const IMAGE_WIDTH: u32 = 400;

/// The page of the runs of a folder, of which `n_unreadable` more cannot be read, and the data of its plots.
pub fn page(name: &str, runs: &[RunData], plots: &[Plot], n_unreadable: usize, job: &ReportJob) -> (Page, Value) {
    let cards: Vec<(Run, Vec<String>)> = runs.par_iter().map(|run| card(run, job)).collect();
    let (cards, faults): (Vec<Run>, Vec<Vec<String>>) = cards.into_iter().unzip();
    let solver = solver_plots(runs);
    let mut drawing = Drawing::of(plots.iter().chain(&solver).map(|p| p.curves.len()).sum());
    // Contacts and residual have room before places and orientations.
    let solver = drawing.section("solver", &solver);
    let sections = vec![drawing.section("probes", plots), solver];
    let worst = cards.iter().map(|card| card.tone).max().unwrap_or_default();
    let is_one = runs.iter().all(|run| run.model == runs[0].model);
    let (title, folder) = single::names(if is_one { &runs[0].model } else { "" }, name);
    let page = Page {
        title,
        folder,
        kind: "runs".into(),
        state: state_of(runs, n_unreadable),
        tone: if n_unreadable > 0 { Tone::Bad } else { worst },
        notes: runs.iter().flat_map(|run| run.notes.iter().cloned()).collect(),
        faults: faults.into_iter().flatten().collect(),
        warnings: warnings(runs),
        no_warnings: "None was counted in any of the runs.".into(),
        has_images: cards.iter().any(|card| card.image.is_some()),
        runs: cards,
        table: Some(table(runs)),
        sections,
        plot_note: drawing.note(),
        provenance: files::provenance_of(runs),
        ..Page::default()
    };
    let labels: Vec<String> = runs.iter().map(|run| guard::text::line(&run.label)).collect();
    let (keys, values) = named_values(runs);
    (page, json!({"plots": drawing.data, "runs": {"labels": labels, "keys": keys, "values": values}}))
}

/// How far the runs are, counted.
fn state_of(runs: &[RunData], n_unreadable: usize) -> String {
    let mut counts: BTreeMap<String, u64> = BTreeMap::new();
    runs.iter().for_each(|run| *counts.entry(ending::word(run)).or_default() += 1);
    let n = runs.len() + n_unreadable;
    let all = number::counted(n as u64, "run");
    if n_unreadable == 0 && counts.len() == 1 {
        let word = counts.keys().next().map_or("", String::as_str);
        return if n > 1 { format!("{all}, all {word}") } else { format!("{all}, {word}") };
    }
    let mut parts: Vec<String> = counts.iter().map(|(word, n)| format!("{} {word}", number::count(*n))).collect();
    if n_unreadable > 0 {
        parts.push(format!("{} cannot be read", number::count(n_unreadable as u64)));
    }
    format!("{all}: {}", parts.join("; "))
}

/// The warnings of all runs, with why those ended that did not come to their end.
fn warnings(runs: &[RunData]) -> Vec<Warning> {
    let early = |run: &RunData| {
        let ended = run.run.index.ended.as_ref().filter(|_| !ending::cause(run).is_empty())?;
        Some(Warning {
            run: run.label.clone(),
            kind: ending::word(run),
            steps: "–".into(),
            first: format!("step {}, {}", number::count(ended.step), number::quantity(ended.time, "s")),
            message: ending::cause(run),
        })
    };
    runs.iter().flat_map(|run| early(run).into_iter().chain(single::warnings(run, &run.label))).collect()
}

/// How the contacts of the runs were solved: plots of columns of their reports, with a curve for each run. The others are the probes' too,
/// or differ from machine to machine.
fn solver_plots(runs: &[RunData]) -> Vec<Plot> {
    const SHOWN: [&str; 3] = ["residual", "iterations", "contacts"];
    let mut plots: Vec<Plot> = vec![];
    for run in runs {
        for mut plot in series::solver_plots(run).into_iter().filter(|plot| SHOWN.contains(&plot.title.as_str())) {
            plot.curves.iter_mut().for_each(|curve| curve.label.clone_from(&run.label));
            match plots.iter_mut().find(|p| p.title == plot.title) {
                Some(there) => there.curves.extend(plot.curves),
                None => plots.push(plot),
            }
        }
    }
    plots
}

/// What the grid has of a run, and what of the run cannot be read.
fn card(data: &RunData, job: &ReportJob) -> (Run, Vec<String>) {
    let mut faults = data.faults.clone();
    let last = data.images.last().filter(|_| job.n_images > 0);
    let image = last.and_then(|(frame, path)| {
        let image = media::image(path, single::caption(data, *frame), IMAGE_WIDTH, &job.output);
        image.map_err(|e| faults.push(e.message)).ok()
    });
    let own = data.run.folder.join(PAGE);
    let card = Run {
        name: data.name.clone(),
        values: data.label.split(", ").map(written_pair).collect(),
        image,
        page: own.is_file().then(|| media::link(&own, &job.output)).flatten(),
        state: ending::state(data, faults.len()),
        tone: ending::tone(data, faults.len()),
    };
    (card, faults)
}

/// A value in a name as it was written before: the name has `_` where a list has commas.
fn written(value: &str) -> String {
    let is_list = value.contains('_') && value.split('_').all(|part| part.parse::<f64>().is_ok());
    if is_list { value.replace('_', ", ") } else { value.into() }
}

/// A key and its value likewise.
fn written_pair(pair: &str) -> String {
    pair.split_once('=').map_or(pair.into(), |(key, value)| format!("{key} = {}", written(value)))
}

/// The values of the sweep in the names of the runs: keys, and a value of each for every run. None if not all names have them.
fn swept(runs: &[RunData]) -> Option<(Vec<String>, Vec<Vec<String>>)> {
    let pairs = |run: &RunData| -> Option<Vec<(String, String)>> {
        let pair = |part: &str| part.split_once('=').map(|(key, value)| (key.to_string(), written(value)));
        run.label.split(", ").map(pair).collect()
    };
    let all: Vec<Vec<(String, String)>> = runs.iter().map(pairs).collect::<Option<_>>()?;
    let mut keys: Vec<String> = vec![];
    for (key, _) in all.iter().flatten() {
        if !keys.contains(key) {
            keys.push(key.clone());
        }
    }
    let value = |pairs: &Vec<(String, String)>, key: &String| {
        pairs.iter().find(|(k, _)| k == key).map_or(String::new(), |(_, value)| value.clone())
    };
    let values = all.iter().map(|pairs| keys.iter().map(|key| value(pairs, key)).collect()).collect();
    Some((keys, values))
}

/// The values of the sweep, or the names of runs that are of none.
fn named_values(runs: &[RunData]) -> (Vec<String>, Vec<Vec<String>>) {
    swept(runs).unwrap_or_else(|| (vec!["run".into()], runs.iter().map(|run| vec![run.label.clone()]).collect()))
}

/// The table of the runs.
fn table(runs: &[RunData]) -> Table {
    const RESULTS: [&str; 9] = [
        "frames",
        "steps",
        "time per step [ms]",
        "contacts, at most",
        "iterations, mean",
        "residual, median [m/s]",
        "residual, greatest [m/s]",
        "deepest overlap [m]",
        "change of energy [J]",
    ];
    let (keys, values) = named_values(runs);
    let mut columns = keys;
    columns.push("state".into());
    columns.extend(RESULTS.map(String::from));
    let row = |(run, own): (&RunData, Vec<String>)| {
        let of = |name: &str| series::values(run, name);
        let time = series::times(run).and_then(|times| series::mean(&times.values()));
        let numbers = [
            Some(run.run.index.frames.len() as f64),
            series::greatest(&of("step")),
            time,
            series::greatest(&of("contacts")),
            series::mean(&of("iterations")),
            series::quantile(&of("residual"), 0.5),
            series::greatest(&of("residual")),
            series::greatest(&of("worst_penetration")),
            series::change(run),
        ];
        let mut row: Vec<Cell> = own.into_iter().map(Cell::text).collect();
        row.push(Cell::text(ending::word(run)));
        row.extend(numbers.map(|x| Cell::number(x.unwrap_or(f64::NAN))));
        row
    };
    Table { columns, rows: runs.iter().zip(values).map(row).collect() }
}
