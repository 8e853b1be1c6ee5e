//! The page of a folder of runs: an image of each, their values in a table to sort, the curves of their probes laid over each other.

use super::drawing::Drawing;
use super::view::{Cell, Page, Run, Table};
use super::{media, series, single};
use crate::job::{PAGE, Plot, ReportJob, RunData};
use rayon::prelude::*;
use serde_json::Value;

/// Width of the image of a run, pixels.
const IMAGE_WIDTH: u32 = 400;

/// The page of the runs of a folder, and the data of its plots.
pub fn page(name: &str, runs: &[RunData], plots: &[Plot], job: &ReportJob) -> (Page, Vec<Value>) {
    let cards: Vec<(Run, Vec<String>)> = runs.par_iter().map(|run| card(run, job)).collect();
    let (cards, faults): (Vec<Run>, Vec<Vec<String>>) = cards.into_iter().unzip();
    let mut drawing = Drawing::of(plots.iter().map(|p| p.curves.len()).sum());
    let sections = vec![drawing.section("probes", plots)];
    let n_open = cards.iter().filter(|card| card.is_open).count();
    let state = match n_open {
        0 => format!("{} runs, all finished", runs.len()),
        n => format!("{} runs, {n} of them unfinished or with warnings", runs.len()),
    };
    let page = Page {
        title: name.into(),
        kind: "runs".into(),
        state,
        is_open: n_open > 0,
        notes: runs.iter().flat_map(|run| run.notes.iter().cloned()).collect(),
        faults: faults.into_iter().flatten().collect(),
        runs: cards,
        table: Some(table(runs)),
        sections,
        plot_note: drawing.note(),
        ..Page::default()
    };
    (page, drawing.data)
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
        state: single::state(data),
        is_open: single::is_open(data),
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
    let (keys, values) =
        swept(runs).unwrap_or_else(|| (vec!["run".into()], runs.iter().map(|run| vec![run.label.clone()]).collect()));
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
        row.push(Cell::text(state(run)));
        row.extend(numbers.map(|x| Cell::number(x.unwrap_or(f64::NAN))));
        row
    };
    Table { columns, rows: runs.iter().zip(values).map(row).collect() }
}

/// How far a run is, in a word or two.
fn state(run: &RunData) -> &'static str {
    match (run.run.index.complete, run.run.index.warnings.is_empty()) {
        (true, true) => "finished",
        (true, false) => "finished, warnings",
        (false, true) => "unfinished",
        (false, false) => "unfinished, warnings",
    }
}
