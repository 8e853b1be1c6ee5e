//! The plot of an overlay: curves up to the frame's time, in axes of all times.

use super::block::{Block, Mark, Style};
use super::blocks::{BASE, LINE, write};
use super::canvas::Place;
use super::content::Graph;
use super::text;
use crate::plot::axis::{name, ticks};
use bind::binding::Corner;

/// Width and height of the axes, ems, and the size of their labels.
const AXES: Place = [13.0, 5.5];
const SIZE: f32 = 0.85;

/// The block of a plot.
pub fn block(graph: &Graph, corner: Corner, style: &Style) -> Block {
    let (times, range) = (graph.times, graph.range);
    let y = ticks(range, |labels, step| labels.len() > 1 && step as f32 * AXES[1] > 1.6 * SIZE);
    let widest = |labels: &[String]| SIZE * labels.iter().map(|l| text::width(l)).fold(0.0, f32::max);
    let x = ticks(times, |labels, step| labels.len() > 1 && step as f32 * AXES[0] > widest(labels) + 0.8);
    let left = widest(&y.labels) + 0.45;
    let heading = heading(graph, y.exponent, style);
    let top = heading.1 + 0.3;
    let at = |t: f64, v: f64| {
        let part = |x: f64, [lo, hi]: [f64; 2]| ((x - lo) / (hi - lo)) as f32;
        [left + AXES[0] * part(t, times), top + AXES[1] * (1.0 - part(v, range))]
    };
    let mut marks = heading.0;
    let (bottom, right) = (top + AXES[1], left + AXES[0]);
    for (value, label) in y.values.iter().zip(&y.labels) {
        let [_, y] = at(times[0], *value);
        marks.push(Mark::Line([[left, y], [right, y]], 0.04, style.faint));
        marks.push(write(label, [left - 0.35 - SIZE * text::width(label), y + 0.33 * SIZE], SIZE, style));
    }
    let below = bottom + 0.3 + BASE * SIZE;
    for (value, label) in x.values.iter().zip(&x.labels) {
        let [x, _] = at(*value, range[0]);
        marks.push(Mark::Line([[x, bottom], [x, bottom + 0.25]], 0.06, style.ink));
        marks.push(write(label, [x - SIZE * text::width(label) / 2.0, below], SIZE, style));
    }
    marks.push(Mark::Line([[left, top], [left, bottom]], 0.06, style.ink));
    marks.push(Mark::Line([[left, bottom], [right, bottom]], 0.06, style.ink));
    for (k, (_, points)) in graph.curves.iter().enumerate() {
        marks.extend(curve(points, graph, style.color(k), at));
    }
    let unit = name("time", "s", x.exponent);
    let middle = left + (AXES[0] - SIZE * text::width(&unit)) / 2.0;
    marks.push(write(&unit, [middle, below + SIZE * LINE], SIZE, style));
    Block { corner, size: [right + 0.5, below + SIZE * (LINE + 0.25)], marks }
}

/// What is written over the axes, and how high it is: the quantity, and the names of several curves in their colours.
fn heading(graph: &Graph, exponent: i32, style: &Style) -> (Vec<Mark>, f32) {
    let mut marks = vec![write(&name(&graph.label, &graph.unit, exponent), [0.0, BASE * SIZE], SIZE, style)];
    if graph.curves.len() < 2 {
        return (marks, LINE * SIZE);
    }
    for (k, (name, _)) in graph.curves.iter().enumerate() {
        let y = LINE * SIZE * (k as f32 + 1.0);
        marks.push(Mark::Text(name.clone(), [0.0, y + BASE * SIZE], SIZE, style.color(k)));
    }
    (marks, LINE * SIZE * (graph.curves.len() as f32 + 1.0))
}

/// A curve up to now, and a dot at its end. Values that are not finite are gaps; what is outside of the axes is at their edge.
fn curve(points: &[(f64, f64)], graph: &Graph, ink: [f32; 4], at: impl Fn(f64, f64) -> Place) -> Vec<Mark> {
    let [lo, hi] = graph.range;
    let until = points.partition_point(|(t, _)| *t <= graph.now);
    let mut past: Vec<(f64, f64)> = points[..until].to_vec();
    // Between two instants the curve is straight.
    if let (Some((t, v)), Some((next, to))) = (past.last().copied(), points.get(until)) {
        past.push((graph.now, v + (to - v) * (graph.now - t) / (next - t)));
    }
    let place = |(t, v): &(f64, f64)| v.is_finite().then(|| at(*t, v.clamp(lo, hi)));
    let mut marks: Vec<Mark> = vec![];
    let mut last: Option<Place> = None;
    for here in past.iter().map(place) {
        match (last, here) {
            // Shorter steps than a line is wide are not seen.
            (Some(from), Some(to)) if (to[0] - from[0]).hypot(to[1] - from[1]) < 0.03 => {}
            (Some(from), Some(to)) => {
                marks.push(Mark::Line([from, to], 0.13, ink));
                last = Some(to);
            }
            _ => last = here,
        }
    }
    if let Some(end) = past.last().and_then(place) {
        marks.extend(last.filter(|from| *from != end).map(|from| Mark::Line([from, end], 0.13, ink)));
        marks.push(Mark::Line([end, end], 0.5, ink));
    }
    marks
}
