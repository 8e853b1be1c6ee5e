//! `scree plot`: the probes and the report of a run as plots, PNG and SVG.

use crate::args::PlotArgs;
use crate::report::{Exit, Failure, Outcome};
use frame::sequence::matches;
use frame::{Column, Fault, FaultKind, csv};
use plotters::coord::Shift;
use plotters::prelude::*;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;

/// A column over time.
struct Series {
    name: String,
    unit: String,
    points: Vec<(f64, f64)>,
}

/// The command.
pub fn command(args: &PlotArgs) -> Outcome {
    let folder = args.output.clone().unwrap_or_else(|| args.run.join("plots"));
    let times = args.times.as_deref().map(interval).transpose()?;
    let mut all = read(&args.run.join("probes.csv"))?;
    if let Ok(report) = read(&args.run.join("report.csv")) {
        all.extend(report.into_iter().filter(|s| s.unit != "ms" && s.name != "step"));
    }
    let wanted = |s: &Series| args.columns.is_empty() || args.columns.iter().any(|p| fits(p, &s.name));
    if let Some(p) = args.columns.iter().find(|p| !all.iter().any(|s| fits(p, &s.name))) {
        let things = all.iter().filter_map(|s| s.name.rsplit_once('.').map(|(thing, _)| thing));
        let near = frame::nearest(p, all.iter().map(|s| s.name.as_str()).chain(things));
        let hint = near.map_or(String::new(), |n| format!(", did you mean `{n}`?"));
        return Err(Failure::new(Exit::Usage, format!("no column fits `{p}`{hint}")));
    }
    // One plot for the columns of one thing that have the same unit.
    let mut plots: BTreeMap<(String, String), Vec<Series>> = BTreeMap::new();
    for mut s in all.into_iter().filter(wanted) {
        if let Some([from, to]) = times {
            s.points.retain(|(t, _)| (from..=to).contains(t));
        }
        let thing = s.name.rsplit_once('.').map_or(s.name.clone(), |(thing, _)| thing.to_string());
        plots.entry((thing, s.unit.clone())).or_default().push(s);
    }
    // The machine may have no fonts of its own.
    plotters::style::register_font("sans-serif", FontStyle::Normal, epaint_default_fonts::UBUNTU_LIGHT)
        .map_err(|_| Failure::new(Exit::Fault, "the built-in font cannot be read"))?;
    std::fs::create_dir_all(&folder).map_err(|e| Fault::unwritable(&folder, &e))?;
    for ((thing, unit), series) in &plots {
        let name: String = format!("{thing}_{}", if unit.is_empty() { "number" } else { unit })
            .chars()
            .map(|c| if c.is_alphanumeric() || c == '_' || c == '-' { c } else { '_' })
            .collect();
        let title = if unit.is_empty() { thing.clone() } else { format!("{thing} [{unit}]") };
        let (png, svg) = (folder.join(format!("{name}.png")), folder.join(format!("{name}.svg")));
        let fail = |e: String| Failure::new(Exit::Fault, format!("{}: {e}", png.display()));
        draw(BitMapBackend::new(&png, (1200, 700)).into_drawing_area(), &title, series).map_err(fail)?;
        draw(SVGBackend::new(&svg, (1200, 700)).into_drawing_area(), &title, series).map_err(fail)?;
        // A reader that has seen enough is no fault.
        let _ = writeln!(std::io::stdout(), "{}", png.display());
    }
    Ok(())
}

/// `0.5-2`
fn interval(text: &str) -> Outcome<[f64; 2]> {
    let parsed = text.split_once('-').and_then(|(a, b)| Some([a.parse::<f64>().ok()?, b.parse::<f64>().ok()?]));
    parsed
        .filter(|[a, b]| b > a)
        .ok_or_else(|| Failure::new(Exit::Usage, format!("--times {text}: expected FROM-TO, as 0.5-2")))
}

/// Whether a column's name fits a pattern with `*`, or is of the thing that the pattern names: `hinge` has `hinge.fx`.
fn fits(pattern: &str, name: &str) -> bool {
    matches(pattern, name) || matches(&format!("{pattern}.*"), name)
}

/// The columns of a CSV of ours against its `time` column.
fn read(path: &Path) -> Outcome<Vec<Series>> {
    let table = csv::read(path, 0, &csv::Layout::default())?;
    let Some(time) = table.column("time") else {
        return Err(Fault::whole(FaultKind::Data, path, "has no column `time`").into());
    };
    let at = |c: &Column, row: usize| c.number(row).filter(|x| x.is_finite());
    let points = |c: &Column| (0..table.rows()).filter_map(|r| Some((at(time, r)?, at(c, r)?))).collect();
    let columns = table.columns.iter().filter(|(f, _)| f.name != "time");
    Ok(columns.map(|(f, c)| Series { name: f.name.clone(), unit: f.unit.clone(), points: points(c) }).collect())
}

/// Draw series over time with axes, grid and legend.
fn draw<B: DrawingBackend>(area: DrawingArea<B, Shift>, title: &str, series: &[Series]) -> Result<(), String> {
    let text = |e: DrawingAreaErrorKind<B::ErrorType>| e.to_string();
    let all = || series.iter().flat_map(|s| &s.points);
    let range = |values: &mut dyn Iterator<Item = f64>| {
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), x| (lo.min(x), hi.max(x)))
    };
    let (t0, t1) = range(&mut all().map(|p| p.0));
    let (lo, hi) = range(&mut all().map(|p| p.1));
    if !t0.is_finite() || !lo.is_finite() {
        return Err("there is nothing to plot in this time".into());
    }
    let pad = if hi > lo { 0.06 * (hi - lo) } else { 0.5 * hi.abs().max(1e-9) };
    area.fill(&WHITE).map_err(text)?;
    let mut chart = ChartBuilder::on(&area)
        .caption(title, ("sans-serif", 28))
        .margin(16)
        .x_label_area_size(48)
        .y_label_area_size(90)
        .build_cartesian_2d(t0..t1.max(t0 + 1e-9), lo - pad..hi + pad)
        .map_err(text)?;
    chart
        .configure_mesh()
        .x_desc("time [s]")
        .label_style(("sans-serif", 18))
        .axis_desc_style(("sans-serif", 20))
        .y_label_formatter(&|y| short(*y))
        .light_line_style(RGBColor(240, 240, 240))
        .draw()
        .map_err(text)?;
    for (i, s) in series.iter().enumerate() {
        let color = Palette99::pick(i).to_rgba();
        let line = LineSeries::new(s.points.iter().copied(), color.stroke_width(2));
        let label = s.name.rsplit_once('.').map_or(s.name.as_str(), |(_, part)| part);
        chart
            .draw_series(line)
            .map_err(text)?
            .label(label)
            .legend(move |(x, y)| PathElement::new(vec![(x, y), (x + 24, y)], color.stroke_width(3)));
    }
    if series.len() > 1 {
        chart
            .configure_series_labels()
            .label_font(("sans-serif", 18))
            .background_style(WHITE.mix(0.85))
            .border_style(RGBColor(200, 200, 200))
            .draw()
            .map_err(text)?;
    }
    area.present().map_err(text)
}

/// A number as short as it can be read.
fn short(y: f64) -> String {
    if y != 0.0 && !(1e-3..1e5).contains(&y.abs()) {
        format!("{y:.2e}")
    } else {
        format!("{}", (y * 1e6).round() / 1e6)
    }
}
