//! Layout of a plot: where its parts are, by the widths of its labels.

use super::axis::{self, Ticks};
use super::pen::{Pen, Place};
use crate::job::Plot;
use plotters::prelude::DrawingBackend;

/// Width and height of a plot, pixels.
pub const SIZE: [u32; 2] = [1200, 700];

/// What is drawn.
pub struct Figure<'a> {
    /// The plot.
    pub plot: &'a Plot,
    /// First and last time, s.
    pub times: [f64; 2],
    /// Lower and upper end of the vertical range.
    pub range: [f64; 2],
    /// The note at the foot.
    pub note: Option<String>,
}

/// Sizes of text, pixels.
pub const TITLE: f64 = 28.0;
pub const NAME: f64 = 20.0;
pub const LABEL: f64 = 18.0;

const MARGIN: f64 = 20.0;
const MAX_LEGEND: f64 = 320.0;

/// Where the parts of a plot are.
pub struct Layout {
    /// Left, top, right and bottom of the frame of the curves.
    pub frame: [f64; 4],
    /// The ticks of time.
    pub x: Ticks,
    /// The ticks of the values.
    pub y: Ticks,
    /// The texts of the legend.
    pub legend: Vec<String>,
}

/// Length of a curve's sample in the legend, with the room after it.
pub const SAMPLE: f64 = 44.0;

impl Layout {
    /// Lay out a figure.
    pub fn of<B: DrawingBackend>(figure: &Figure, pen: &Pen<B>) -> Layout {
        let legend: Vec<String> =
            figure.plot.curves.iter().map(|c| pen.shortened(&entry(c), LABEL, MAX_LEGEND - SAMPLE)).collect();
        let widest = |texts: &[String], size: f64| texts.iter().map(|t| pen.width(t, size)).fold(0.0, f64::max);
        let right = SIZE[0] as f64 - MARGIN - SAMPLE - widest(&legend, LABEL) - 14.0;
        let top = 66.0;
        let bottom = SIZE[1] as f64 - MARGIN - NAME - 38.0 - if figure.note.is_some() { 28.0 } else { 0.0 };
        let y = axis::ticks(figure.range, |_, part| part * (bottom - top) >= 2.6 * LABEL);
        let left = MARGIN + NAME + 18.0 + widest(&y.labels, LABEL) + 10.0;
        let x = axis::ticks(figure.times, |labels, part| part * (right - left) >= widest(labels, LABEL) + 28.0);
        Layout { frame: [left, top, right, bottom], x, y, legend }
    }

    /// The place of a time and a value.
    pub fn place(&self, figure: &Figure, (t, v): (f64, f64)) -> Place {
        let [left, top, right, bottom] = self.frame;
        let part = |x: f64, [lo, hi]: [f64; 2]| (x - lo) / (hi - lo);
        [left + part(t, figure.times) * (right - left), bottom - part(v, figure.range) * (bottom - top)]
    }
}

/// The text of a curve in the legend.
fn entry(curve: &crate::job::Curve) -> String {
    let is_finite = |p: &(f64, f64)| p.1.is_finite();
    match () {
        () if curve.points.is_empty() => format!("{} (no instant)", curve.label),
        () if !curve.points.iter().any(is_finite) => format!("{} (no finite value)", curve.label),
        () => curve.label.clone(),
    }
}
