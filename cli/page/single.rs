//! The page of a run.

use super::drawing::Drawing;
use super::view::{Figure, Page, Warning};
use super::{ending, files, media, number, series};
use crate::job::{Plot, ReportJob, RunData};
use frame::{Column, Frame};
use rayon::prelude::*;
use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet};

/// Width of the images of a run, pixels.
const IMAGE_WIDTH: u32 = 720;

/// The page of a run, and the data of its plots.
pub fn page(run: &RunData, job: &ReportJob) -> (Page, Value) {
    let mut faults = run.faults.clone();
    let probes: Vec<Plot> = run.plots.iter().filter(|p| !is_energy(p)).cloned().collect();
    let (energy, solver) = (series::energy_plots(run), series::solver_plots(run));
    let n_curves = |plots: &mut dyn Iterator<Item = &Plot>| plots.map(|p| p.curves.len()).sum::<usize>();
    let mut drawing = Drawing::of(n_curves(&mut probes.iter().chain(&energy).chain(&solver)));
    let sections = vec![
        drawing.section("energy", &energy),
        drawing.section("solver", &solver),
        drawing.section("probes", &probes),
    ];
    let shown = media::some(&run.images, job.n_images);
    let images: Vec<_> = shown
        .par_iter()
        .map(|(frame, path)| media::image(path, caption(run, *frame), IMAGE_WIDTH, &job.output))
        .collect();
    let images: Vec<_> =
        images.into_iter().filter_map(|image| image.map_err(|e| faults.push(e.message)).ok()).collect();
    let mut films = run.films.iter();
    let film = films
        .next()
        .and_then(|path| media::film(path, &job.output, job.embed_film).map_err(|e| faults.push(e.message)).ok());
    let n_images = match (run.images.len(), images.len()) {
        (0, _) => "The run has no images yet: `scree render` draws them.".into(),
        (all, shown) if shown < all => format!("{shown} of {}.", number::counted(all as u64, "image")),
        _ => String::new(),
    };
    let energy = series::balance(run);
    let (figures, files) = (figures(run, &mut faults), files::files(run, &mut faults));
    let (title, folder) = names(&run.model, &run.name);
    let page = Page {
        title,
        folder,
        kind: "run".into(),
        state: ending::state(run, faults.len()),
        tone: ending::tone(run, faults.len()),
        cause: ending::cause(run),
        notes: run.notes.clone(),
        film,
        films: films.filter_map(|path| media::link(path, &job.output)).collect(),
        images,
        n_images,
        figures,
        warnings: warnings(run, ""),
        no_warnings: ending::without_warnings(run).into(),
        energy_note: energy_note(energy.is_some()).into(),
        energy,
        solver: series::solver(run),
        stages: series::times(run).map_or(vec![], |times| times.stages()),
        sections,
        plot_note: drawing.note(),
        provenance: files::provenance(run),
        files,
        model: files::model(run),
        faults,
        ..Page::default()
    };
    (page, json!({"plots": drawing.data}))
}

/// The title of a page and the folder beneath it: a model without a name is called by its folder.
pub fn names(model: &str, folder: &str) -> (String, String) {
    match model.trim() {
        name if name.is_empty() || name == folder => (folder.into(), String::new()),
        name => (name.into(), folder.into()),
    }
}

/// Whether a plot is that of the energies or of work, which stand in a section of their own.
fn is_energy(plot: &Plot) -> bool {
    let are = |known: &[&str]| plot.curves.iter().all(|c| known.contains(&c.label.as_str()));
    match plot.title.as_str() {
        "energy" => are(&["kinetic", "potential", "elastic", "arrived"]),
        "work" => are(&["motors", "loads"]),
        _ => false,
    }
}

/// What stands below an image.
pub fn caption(run: &RunData, frame: u64) -> String {
    let entry = run.run.index.frames.iter().find(|f| f.number == frame);
    entry.map_or(format!("frame {frame}"), |f| format!("frame {frame}, {}", number::quantity(f.time, "s")))
}

fn energy_note(is_there: bool) -> &'static str {
    match is_there {
        true => {
            "The total is of the kinetic energy, the potential energy of gravity, whose zero is at the origin, and the elastic \
             energy of springs. What is dissipated, by friction, impacts and dampers, is the work of motors and loads and the energy \
             of bodies that came later, less the change of the total."
        }
        false => {
            "The run has no energies: they are left out by `no_energies` of its probes, or it has not taken a step yet, or its \
             probes.csv cannot be read."
        }
    }
}

/// The warnings of a run, which goes by `label`.
pub fn warnings(run: &RunData, label: &str) -> Vec<Warning> {
    let warning = |w: &frame::run::WarningEntry| Warning {
        run: label.into(),
        kind: w.kind.clone(),
        steps: number::count(w.steps),
        first: format!("step {}, {}", number::count(w.first_step), number::quantity(w.first_time, "s")),
        message: w.message.clone(),
    };
    run.run.index.warnings.iter().map(warning).collect()
}

/// The numbers of a run.
fn figures(run: &RunData, faults: &mut Vec<String>) -> Vec<Figure> {
    let index = &run.run.index;
    let mut figures = vec![];
    if let Some(last) = index.frames.last() {
        match run.run.read_frame(last.number) {
            Ok(table) => figures.push(bodies(&table, last.rows)),
            Err(fault) => faults.push(fault.to_string()),
        }
    }
    let steps = series::values(run, "step");
    let n_steps = series::greatest(&steps);
    let simulated = n_steps.unwrap_or(f64::NAN) * index.step_size;
    let of_each = format!("of {} each", number::quantity(index.step_size, "s"));
    // Where there is no report, nobody knows: a run that has just begun has an empty one.
    let (steps, time) = match n_steps {
        Some(n) => (number::count(n as u64), number::duration(simulated)),
        None if index.frames.len() > 1 => ("–".into(), "–".into()),
        None => ("0".into(), number::duration(0.0)),
    };
    figures.push(Figure::new("steps", steps).noted(of_each));
    figures.push(Figure::new("simulated time", time));
    let n_frames = index.frames.len() as u64;
    let expected = match n_frames == index.expected_frames {
        true => String::new(),
        false => format!("of {}", number::count(index.expected_frames)),
    };
    figures.push(Figure::new("frames", number::count(n_frames)).noted(expected));
    if let Some(times) = series::times(run) {
        let values = times.values();
        let all = values.iter().sum::<f64>() / 1e3;
        let greatest = number::quantity(series::greatest(&values).unwrap_or(f64::NAN), "ms");
        let mean = number::quantity(series::mean(&values).unwrap_or(f64::NAN), "ms");
        figures.push(Figure::new("time per step", mean).noted(format!("at most {greatest}")));
        let ratio = number::short(all / simulated);
        figures
            .push(Figure::new("time of all steps", number::duration(all)).noted(format!("{ratio} s per simulated s")));
    }
    let contacts = series::values(run, "contacts");
    if let (Some(greatest), Some(mean)) = (series::greatest(&contacts), series::mean(&contacts)) {
        let note = format!("{} on average", number::short(mean.round()));
        figures.push(Figure::new("contacts, at most", number::count(greatest as u64)).noted(note));
    }
    figures
}

/// The number of bodies in a frame, and their classes.
fn bodies(table: &Frame, n_rows: usize) -> Figure {
    /// Classes that are named.
    const NAMED: usize = 4;
    let text = |name: &str, row: usize| match table.column(name) {
        Some(Column::Category { codes, names }) => names.get(codes[row] as usize).map(String::as_str),
        _ => None,
    };
    let mut ids = BTreeSet::new();
    let mut classes: BTreeMap<&str, u64> = BTreeMap::new();
    for row in 0..table.rows() {
        let id = table.column("id").and_then(|c| c.number(row)).unwrap_or(row as f64);
        if text("shape", row) != Some("spring") && ids.insert(id.to_bits()) {
            *classes.entry(text("class", row).unwrap_or("")).or_default() += 1;
        }
    }
    let mut by_count: Vec<(&str, u64)> = classes.into_iter().filter(|(name, _)| !name.is_empty()).collect();
    by_count.sort_by(|a, b| b.1.cmp(&a.1).then(a.0.cmp(b.0)));
    // A single further class is named like the others.
    let n_named = if by_count.len() == NAMED + 1 { NAMED + 1 } else { NAMED };
    let mut named: Vec<String> =
        by_count.iter().take(n_named).map(|(name, n)| format!("{} {name}", number::count(*n))).collect();
    if by_count.len() > n_named {
        named.push(format!("{} more classes", by_count.len() - n_named));
    }
    let rows =
        if n_rows == ids.len() { String::new() } else { format!("; {} rows of a frame", number::count(n_rows as u64)) };
    Figure::new("bodies", number::count(ids.len() as u64)).noted(format!("{}{rows}", named.join(", ")))
}
