//! Drawing of a plot: title, axes, curves clipped to the vertical range, legend, note.

use super::axis;
use super::layout::{Figure, LABEL, Layout, NAME, SAMPLE, SIZE, TITLE};
use super::pen::{Pen, Place};
use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

/// Colors that are told apart also by those who do not see all of them (Okabe and Ito).
const COLORS: [RGBColor; 6] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(60, 60, 60),
];
const FRAME: RGBColor = RGBColor(90, 90, 90);
const GRID: RGBColor = RGBColor(226, 226, 226);

/// Dash and gap of the curves after the first six, pixels.
const DASH: [f64; 2] = [9.0, 6.0];

/// Draw a figure.
pub fn draw<B: DrawingBackend>(area: &DrawingArea<B, Shift>, figure: &Figure, scale: u32) -> Result<(), String> {
    let pen = Pen { area, scale };
    let layout = Layout::of(figure, &pen);
    pen.fill(WHITE)?;
    axes(&pen, figure, &layout)?;
    for (i, curve) in figure.plot.curves.iter().enumerate() {
        for piece in pieces(&curve.points, figure.range) {
            let places: Vec<Place> = piece.iter().map(|p| layout.place(figure, *p)).collect();
            stroke(&pen, &thinned(places), i)?;
        }
    }
    legend(&pen, &layout)?;
    let [left, _, right, bottom] = layout.frame;
    let title = pen.shortened(&figure.plot.title, TITLE, SIZE[0] as f64 - 40.0);
    pen.text(&title, [left, 22.0], TITLE, (HPos::Left, VPos::Top))?;
    if let Some(note) = &figure.note {
        let note = pen.shortened(note, LABEL - 1.0, SIZE[0] as f64 - left - 20.0);
        pen.text(&note, [left, SIZE[1] as f64 - 34.0], LABEL - 1.0, (HPos::Left, VPos::Top))?;
    }
    let Figure { plot, .. } = figure;
    if !plot.curves.iter().flat_map(|c| &c.points).any(|p| p.1.is_finite()) {
        let middle = [(left + right) / 2.0, (layout.frame[1] + bottom) / 2.0];
        pen.text("no finite value", middle, NAME, (HPos::Center, VPos::Center))?;
    }
    area.present().map_err(|e| e.to_string())
}

/// Grid, frame, ticks with labels, names of the axes.
fn axes<B: DrawingBackend>(pen: &Pen<B>, figure: &Figure, layout: &Layout) -> Result<(), String> {
    let [left, top, right, bottom] = layout.frame;
    for (value, label) in layout.x.values.iter().zip(&layout.x.labels) {
        let [x, _] = layout.place(figure, (*value, figure.range[0]));
        pen.line(&[[x, top], [x, bottom]], GRID, 1.0)?;
        pen.line(&[[x, bottom], [x, bottom + 5.0]], FRAME, 1.0)?;
        pen.text(label, [x, bottom + 9.0], LABEL, (HPos::Center, VPos::Top))?;
    }
    for (value, label) in layout.y.values.iter().zip(&layout.y.labels) {
        let [_, y] = layout.place(figure, (figure.times[0], *value));
        let color = if *value == 0.0 { RGBColor(170, 170, 170) } else { GRID };
        pen.line(&[[left, y], [right, y]], color, 1.0)?;
        pen.line(&[[left - 5.0, y], [left, y]], FRAME, 1.0)?;
        pen.text(label, [left - 9.0, y + 1.5], LABEL, (HPos::Right, VPos::Center))?;
    }
    pen.line(&[[left, top], [right, top], [right, bottom], [left, bottom], [left, top]], FRAME, 1.0)?;
    let middle = [(left + right) / 2.0, (top + bottom) / 2.0];
    let time = axis::name("time", "s", layout.x.exponent);
    pen.text(&time, [middle[0], bottom + 9.0 + LABEL + 8.0], NAME, (HPos::Center, VPos::Top))?;
    let value = axis::name(&figure.plot.quantity, &figure.plot.unit, layout.y.exponent);
    let value = pen.shortened(&value, NAME, bottom - top);
    pen.text_upwards(&value, [20.0 + NAME / 2.0, middle[1]], NAME)
}

/// The names of the curves, right of the frame.
fn legend<B: DrawingBackend>(pen: &Pen<B>, layout: &Layout) -> Result<(), String> {
    let [_, top, right, _] = layout.frame;
    for (i, text) in layout.legend.iter().enumerate() {
        let (x, y) = (right + 14.0, top + 12.0 + 26.0 * i as f64);
        stroke(pen, &[[x, y], [x + SAMPLE - 10.0, y]], i)?;
        pen.text(text, [x + SAMPLE, y + 1.5], LABEL, (HPos::Left, VPos::Center))?;
    }
    Ok(())
}

/// Draw a piece of the curve of an index, in its color and dashes; a single place is a dot.
fn stroke<B: DrawingBackend>(pen: &Pen<B>, places: &[Place], index: usize) -> Result<(), String> {
    let color = COLORS[index % COLORS.len()];
    match places {
        [] => Ok(()),
        [place] => pen.dot(*place, color, 4.0),
        _ if index < COLORS.len() => pen.line(places, color, 2.0),
        _ => dashes(places).iter().try_for_each(|dash| pen.line(dash, color, 2.0)),
    }
}

/// A line that looks the same with fewer places: of many in a column of pixels, the first, the lowest, the highest and the last.
fn thinned(places: Vec<Place>) -> Vec<Place> {
    /// Places that are drawn one by one.
    const FEW: usize = 20_000;
    if places.len() <= FEW {
        return places;
    }
    let column = |place: &Place| place[0].floor();
    let mut thin = vec![];
    for group in places.chunk_by(|a, b| column(a) == column(b)) {
        let by_height = |a: &usize, b: &usize| group[*a][1].total_cmp(&group[*b][1]);
        let mut kept: Vec<usize> = [0, group.len() - 1].into();
        kept.extend((0..group.len()).min_by(by_height));
        kept.extend((0..group.len()).max_by(by_height));
        kept.sort_unstable();
        kept.dedup();
        thin.extend(kept.into_iter().map(|i| group[i]));
    }
    thin
}

/// The dashes along a line.
fn dashes(places: &[Place]) -> Vec<Vec<Place>> {
    let mut all = vec![];
    let mut dash = vec![places[0]];
    let mut is_dash = true;
    let mut left = DASH[0];
    for pair in places.windows(2) {
        let ([x0, y0], [x1, y1]) = (pair[0], pair[1]);
        let length = (x1 - x0).hypot(y1 - y0);
        let mut done = 0.0;
        while length - done > left {
            done += left;
            let part = done / length;
            let place = [x0 + part * (x1 - x0), y0 + part * (y1 - y0)];
            if is_dash {
                dash.push(place);
                all.push(std::mem::take(&mut dash));
            } else {
                dash = vec![place];
            }
            is_dash = !is_dash;
            left = DASH[usize::from(!is_dash)];
        }
        left -= length - done;
        if is_dash {
            dash.push([x1, y1]);
        }
    }
    if dash.len() > 1 {
        all.push(dash);
    }
    all
}

/// The pieces of a curve within the vertical range; values that are not finite are gaps.
fn pieces(points: &[(f64, f64)], [lo, hi]: [f64; 2]) -> Vec<Vec<(f64, f64)>> {
    let is_inside = |p: &(f64, f64)| (lo..=hi).contains(&p.1);
    let mut all: Vec<Vec<(f64, f64)>> = vec![];
    let mut piece: Vec<(f64, f64)> = vec![];
    let mut last: Option<(f64, f64)> = None;
    for &point in points {
        if !point.1.is_finite() {
            all.push(std::mem::take(&mut piece));
            last = None;
            continue;
        }
        if let Some(from) = last {
            // Where the line from the last point enters and leaves the range.
            let at = |y: f64| (from.0 + (y - from.1) / (point.1 - from.1) * (point.0 - from.0), y);
            let clamped = |p: (f64, f64)| if is_inside(&p) { p } else { at(p.1.clamp(lo, hi)) };
            let misses = from.1.max(point.1) < lo || from.1.min(point.1) > hi;
            if !is_inside(&from) && !misses {
                piece.push(clamped(from));
            }
            if !is_inside(&point) {
                if !misses {
                    piece.push(clamped(point));
                }
                all.push(std::mem::take(&mut piece));
            }
        }
        if is_inside(&point) {
            piece.push(point);
        }
        last = Some(point);
    }
    all.push(piece);
    all.retain(|piece| !piece.is_empty());
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_are_clipped_and_broken_at_gaps() {
        let clip = |values: &[f64]| {
            let points: Vec<(f64, f64)> = values.iter().enumerate().map(|(i, y)| (i as f64, *y)).collect();
            pieces(&points, [0.0, 1.0])
        };
        assert_eq!(clip(&[0.0, 1.0]), [[(0.0, 0.0), (1.0, 1.0)]]);
        assert_eq!(clip(&[3.0, 0.5, 0.5]), [[(0.8, 1.0), (1.0, 0.5), (2.0, 0.5)]]);
        assert_eq!(clip(&[0.5, f64::NAN, 0.5]), [[(0.0, 0.5)], [(2.0, 0.5)]]);
        assert_eq!(clip(&[-1.0, 2.0]), [[(1.0 / 3.0, 0.0), (2.0 / 3.0, 1.0)]]);
        assert!(clip(&[2.0, 3.0, 2.0]).is_empty() && clip(&[]).is_empty());
    }

    #[test]
    fn dashes_go_on_around_corners() {
        let found = dashes(&[[0.0, 0.0], [5.0, 0.0], [5.0, 20.0]]);
        assert_eq!(found, [vec![[0.0, 0.0], [5.0, 0.0], [5.0, 4.0]], vec![[5.0, 10.0], [5.0, 19.0]]]);
    }
}
