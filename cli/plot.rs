//! `scree plot`: the probes and the report of a run as plots, PNG and SVG.

use crate::job::{PlotJob, Series};
use crate::report::{Exit, Failure, Outcome};
use frame::Fault;
use plotters::coord::Shift;
use plotters::prelude::*;
use std::io::Write;

/// Run `scree plot`.
pub fn run(job: PlotJob) -> Outcome {
    let PlotJob { plots, folder } = job;
    // The machine may have no fonts of its own.
    plotters::style::register_font("sans-serif", FontStyle::Normal, epaint_default_fonts::UBUNTU_LIGHT)
        .map_err(|_| Failure::new(Exit::Fault, "the built-in font cannot be read"))?;
    std::fs::create_dir_all(&folder).map_err(|e| Fault::unwritable(&folder, &e))?;
    for plot in &plots {
        let [png, svg] = ["png", "svg"].map(|ending| folder.join(format!("{}.{ending}", plot.name)));
        let fail = |e: String| Failure::new(Exit::Fault, format!("{}: {e}", png.display()));
        draw(BitMapBackend::new(&png, (1200, 700)).into_drawing_area(), &plot.title, &plot.series).map_err(fail)?;
        draw(SVGBackend::new(&svg, (1200, 700)).into_drawing_area(), &plot.title, &plot.series).map_err(fail)?;
        // A reader may stop early, as `head` does.
        let _ = writeln!(std::io::stdout(), "{}", png.display());
    }
    Ok(())
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
        return Err("there is nothing to plot in this interval of time".into());
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

/// The short text of an axis value.
fn short(y: f64) -> String {
    if y != 0.0 && !(1e-3..1e5).contains(&y.abs()) {
        format!("{y:.2e}")
    } else {
        format!("{}", (y * 1e6).round() / 1e6)
    }
}
