//! `scree plot`: the probes and the report of runs as plots, PNG and SVG.

pub mod axis;
mod draw;
mod layout;
mod pen;
pub mod range;

use crate::job::{Plot, PlotJob};
use crate::report::{Exit, Failure, Outcome};
use layout::{Figure, SIZE};
use plotters::prelude::*;

/// Pixels of drawing per pixel of a plot: the PNG is drawn larger and reduced, so that its lines are smooth; the SVG has places
/// finer than pixels.
const PNG_SCALE: u32 = 3;
const SVG_SCALE: u32 = 4;

/// Run `scree plot`.
pub fn run(job: PlotJob) -> Outcome {
    let PlotJob { plots, folder, full_range, warnings } = job;
    for warning in warnings {
        eprintln!("warning: {warning}");
    }
    // The machine may have no fonts of its own.
    plotters::style::register_font("sans-serif", FontStyle::Normal, epaint_default_fonts::UBUNTU_LIGHT)
        .map_err(|_| Failure::new(Exit::Fault, "the built-in font cannot be read"))?;
    for plot in &plots {
        let file = |ending: &str| folder.join(format!("{}.{ending}", plot.name));
        let figure = figure(plot, full_range);
        let fail = |e: String| Failure::new(Exit::Fault, format!("{}: {e}", file("png").display()));
        frame::atomic::write(&file("svg"), svg(&figure).map_err(fail)?.as_bytes())?;
        frame::atomic::write(&file("png"), &png(&figure).map_err(fail)?)?;
        println!("{}", file("png").display());
    }
    Ok(())
}

/// What is drawn of a plot.
fn figure(plot: &Plot, full_range: bool) -> Figure<'_> {
    let times = range::times(&plot.curves);
    let range::Vertical { range, hides_start } = range::vertical(&plot.curves, full_range);
    let note = hides_start.then(|| range::note(&plot.curves, range, &plot.unit));
    Figure { plot, times, range, note }
}

fn png(figure: &Figure) -> Result<Vec<u8>, String> {
    let [width, height] = SIZE.map(|n| n * PNG_SCALE);
    let mut pixels = vec![255; (width * height * 3) as usize];
    let area = BitMapBackend::with_buffer(&mut pixels, (width, height)).into_drawing_area();
    draw::draw(&area, figure, PNG_SCALE)?;
    drop(area);
    let mut bytes = vec![];
    let mut encoder = png::Encoder::new(&mut bytes, SIZE[0], SIZE[1]);
    encoder.set_color(png::ColorType::Rgb);
    let mut writer = encoder.write_header().map_err(|e| e.to_string())?;
    writer.write_image_data(&reduce(&pixels, width as usize)).map_err(|e| e.to_string())?;
    writer.finish().map_err(|e| e.to_string())?;
    Ok(bytes)
}

/// An image reduced to the size of a plot: the means of its squares of pixels.
fn reduce(pixels: &[u8], width: usize) -> Vec<u8> {
    let n = PNG_SCALE as usize;
    let height = pixels.len() / 3 / width;
    let mut out = Vec::with_capacity(pixels.len() / (n * n));
    for y in 0..height / n {
        for x in 0..width / n {
            for c in 0..3 {
                let at = |i: usize| u32::from(pixels[((y * n + i / n) * width + x * n + i % n) * 3 + c]);
                out.push(((0..n * n).map(at).sum::<u32>() / (n * n) as u32) as u8);
            }
        }
    }
    out
}

fn svg(figure: &Figure) -> Result<String, String> {
    let [width, height] = SIZE.map(|n| n * SVG_SCALE);
    let mut text = String::new();
    let area = SVGBackend::with_string(&mut text, (width, height)).into_drawing_area();
    draw::draw(&area, figure, SVG_SCALE)?;
    drop(area);
    // The view box has the finer places; the size is that of the PNG.
    let [w, h] = SIZE;
    let (drawn, shown) = (format!("width=\"{width}\" height=\"{height}\""), format!("width=\"{w}\" height=\"{h}\""));
    Ok(text.replacen(&drawn, &shown, 1))
}
