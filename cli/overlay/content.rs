//! What the overlays of an image say: of a job, found once, and of each frame.

use super::text;
use crate::job::{Curve, time_table};
use crate::plot::range;
use crate::report::Outcome;
use bind::binding::{Binding, Camera, Color, GrowingPlot, Overlays, Place, Projection, TIME_UNITS, TimeStamp};
use bind::data::{Source, Store};
use bind::emit;
use frame::{Fault, Frame, nearest};
use glam::Vec3;
use std::sync::Arc;

/// What the overlays of a job say in all its frames.
#[derive(Clone, Debug, Default)]
pub struct Prepared {
    /// Decimals of times.
    decimals: usize,
    /// The plot.
    graph: Option<Graph>,
}

/// What the overlays of an image say.
#[derive(Clone, Debug, Default)]
pub struct Content {
    /// The title.
    pub title: Option<String>,
    /// The time.
    pub time: Option<String>,
    /// The scale.
    pub scale: Option<Scale>,
    /// The colours.
    pub legend: Option<Legend>,
    /// Where the axes of the data point: to the right, down and away from the eye.
    pub axes: Option<[[f32; 3]; 3]>,
    /// The plot.
    pub graph: Option<Graph>,
}

/// The scale of an image.
#[derive(Clone, Debug)]
pub struct Scale {
    /// Metres across the image's shorter side, at what is looked at.
    pub across: f64,
    /// The length of the bar, m; 0 until it is chosen.
    pub length: f64,
}

/// The colours of values.
#[derive(Clone, Debug)]
pub struct Legend {
    /// What the values are.
    pub label: String,
    /// Their unit.
    pub unit: String,
    /// The colours.
    pub map: bind::colormap::Map,
    /// Values at the two ends of the colours; none if no value is finite.
    pub range: Option<[f64; 2]>,
}

/// A plot up to a time.
#[derive(Clone, Debug, Default)]
pub struct Graph {
    /// What the values are.
    pub label: String,
    /// Their unit.
    pub unit: String,
    /// Names and points of the curves.
    pub curves: Curves,
    /// All times, s, and all values.
    pub times: [f64; 2],
    /// The range of values.
    pub range: [f64; 2],
    /// The time of the frame, s.
    pub now: f64,
}

/// Curves by name. All images share them; in what tells images apart stands their hash, which is computed once.
#[derive(Clone, Default)]
pub struct Curves {
    all: Arc<[(String, Vec<(f64, f64)>)]>,
    hash: String,
}

impl Curves {
    fn new(all: Vec<(String, Vec<(f64, f64)>)>) -> Curves {
        let mut hasher = blake3::Hasher::new();
        for (name, points) in &all {
            hasher.update(&(name.len() as u64).to_le_bytes()).update(name.as_bytes());
            hasher.update(&(points.len() as u64).to_le_bytes());
            for (time, value) in points {
                hasher.update(&time.to_le_bytes()).update(&value.to_le_bytes());
            }
        }
        Curves { all: all.into(), hash: hasher.finalize().to_hex().to_string() }
    }
}

impl std::ops::Deref for Curves {
    type Target = [(String, Vec<(f64, f64)>)];

    fn deref(&self) -> &Self::Target {
        &self.all
    }
}

impl std::fmt::Debug for Curves {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.hash)
    }
}

impl Prepared {
    /// Find what the overlays of a binding say in all frames: read what is plotted, check that texts can be written.
    pub fn find(binding: &Binding, source: &Source) -> Outcome<Prepared> {
        let overlays = &binding.overlays;
        check_texts(binding)?;
        let mut decimals = 0;
        if let Some(time) = &overlays.time {
            decimals = match time.decimals {
                Some(given) => given,
                None => decimals_of(interval(binding, source, time)?, &time.unit),
            };
        }
        let graph = overlays.plot.as_ref().map(|plot| graph(binding, source, plot)).transpose()?;
        Ok(Prepared { decimals, graph })
    }
}

/// The texts of the overlays must have characters that the fonts know.
fn check_texts(binding: &Binding) -> Result<(), Fault> {
    let Overlays { title, time, legend, plot, .. } = &binding.overlays;
    let title = title.as_ref().map(|t| ("title", t.text.as_str()));
    let time = time.as_ref().map(|t| ("time.label", t.label.as_str()));
    let legend = legend.iter().flat_map(|l| [("legend.label", &l.label), ("legend.unit", &l.unit)]);
    let plot = plot.iter().flat_map(|p| [("plot.label", &p.label), ("plot.unit", &p.unit)]);
    let given = legend.chain(plot).filter_map(|(key, text)| Some((key, text.as_deref()?)));
    for (key, words) in title.into_iter().chain(time).chain(given) {
        if let Some(c) = text::unknown(words) {
            let message = format!("the fonts have no `{}`", c.escape_debug());
            return Err(binding.doc.fault(&format!("overlays.{key}"), message));
        }
    }
    Ok(())
}

/// The time between frames, s. An error if the data has none.
fn interval(binding: &Binding, source: &Source, time: &TimeStamp) -> Outcome<f64> {
    if let Some(seconds) = time.per_frame {
        return Ok(seconds);
    }
    // A run says it before all its frames are there.
    if let Store::Run(run) = &source.store
        && let Some(rate) = run.index.frame_rate
    {
        return Ok(1.0 / rate);
    }
    let numbers = source.numbers();
    let times: Vec<f64> = match &source.store {
        Store::Run(run) => run.index.frames.iter().map(|frame| frame.time).collect(),
        Store::Files { .. } => {
            let ends = numbers.iter().take(1).chain(numbers.iter().skip(1).last());
            ends.map(|n| Ok(source.read(*n)?.time)).collect::<Outcome<_>>()?
        }
    };
    let (first, last) = (times.first().copied().unwrap_or(0.0), times.last().copied().unwrap_or(0.0));
    if numbers.len() > 1 && last <= first {
        let message = "the data has no times: give the seconds from a frame to the next, `time: {per_frame: …}`";
        return Err(binding.doc.fault("overlays.time", message).into());
    }
    Ok((last - first) / (numbers.len().max(2) - 1) as f64)
}

/// As many decimals as tell times apart that lie this far from each other.
fn decimals_of(interval: f64, unit: &str) -> usize {
    let steps = interval / seconds_of(unit);
    if steps > 0.0 { (-steps.log10()).ceil().clamp(0.0, 9.0) as usize } else { 2 }
}

fn seconds_of(unit: &str) -> f64 {
    TIME_UNITS.iter().find(|(name, _)| *name == unit).map_or(1.0, |(_, seconds)| *seconds)
}

/// The time of a frame, s.
fn time_of(time: Option<&TimeStamp>, table: &Frame) -> f64 {
    time.and_then(|t| t.per_frame).map_or(table.time, |seconds| seconds * table.number as f64)
}

/// Read what is plotted.
fn graph(binding: &Binding, source: &Source, plot: &GrowingPlot) -> Outcome<Graph> {
    let path = match (&plot.file, &source.store, binding.data.as_ref().and_then(|data| data.place.as_ref())) {
        (Some(file), ..) => binding.folder().join(file),
        (None, Store::Run(run), _) => run.folder.clone(),
        (None, _, Some(Place::Run(folder))) => binding.folder().join(folder),
        _ => {
            let message = "needs `file`, a CSV with a column `time`: the data is no run, which would have probes";
            return Err(binding.doc.fault("overlays.plot", message).into());
        }
    };
    let table = time_table::read(&path)?;
    let names: Vec<&str> = table.columns.iter().map(|c| c.name.as_str()).collect();
    let mut graph = Graph { label: plot.columns.join(", "), ..Graph::default() };
    let mut curves = vec![];
    for (k, wanted) in plot.columns.iter().enumerate() {
        let Some(column) = table.columns.iter().find(|c| c.name == *wanted) else {
            let message = format!("unknown column `{wanted}` of {}", path.display());
            let fault = binding.doc.fault(&format!("overlays.plot.columns.{k}"), message);
            let hint = nearest(wanted, names.iter().copied()).map_or_else(
                || format!("its columns are {}", frame::listed(&names)),
                |near| format!("did you mean `{near}`?"),
            );
            return Err(fault.hint(hint).into());
        };
        if k > 0 && column.unit != graph.unit {
            let message = format!("`{wanted}` is in [{}], `{}` in [{}]", column.unit, plot.columns[0], graph.unit);
            return Err(binding.doc.fault(&format!("overlays.plot.columns.{k}"), message).into());
        }
        graph.unit.clone_from(&column.unit);
        let (label, points) = (column.name.clone(), column.points.clone());
        curves.push(Curve { label, points, has_start: column.has_start });
    }
    (graph.times, graph.range) = (range::times(&curves), range::vertical(&curves, false).range);
    graph.curves = Curves::new(curves.into_iter().map(|c| (c.label, c.points)).collect());
    graph.label = plot.label.clone().unwrap_or(graph.label);
    graph.unit = plot.unit.clone().unwrap_or(graph.unit);
    Ok(graph)
}

impl Content {
    /// What the overlays of a frame say. An error if the camera follows rows that the frame does not have.
    pub fn of(binding: &Binding, prepared: &Prepared, table: &Frame) -> Result<Content, Fault> {
        let overlays = &binding.overlays;
        if overlays.is_empty() {
            return Ok(Content::default());
        }
        let seconds = time_of(overlays.time.as_ref(), table);
        let time = overlays.time.as_ref().map(|time| {
            let value = seconds / seconds_of(&time.unit);
            let unit = if time.unit == "us" { "µs" } else { &time.unit };
            format!("{}{value:.*} {unit}", time.label, prepared.decimals).replace('-', "−")
        });
        let mut content =
            Content { time, title: overlays.title.as_ref().map(|t| t.text.clone()), ..Content::default() };
        if let (Some(Camera::Placed(camera)), Some(stand)) = (&binding.camera, emit::stand(binding, table)?) {
            let [eye, at] = [stand.eye, stand.at].map(Vec3::from);
            content.axes = overlays.axes.as_ref().map(|_| {
                let forward = (at - eye).normalize();
                let right = forward.cross(camera.up.into()).normalize();
                let down = forward.cross(right);
                let axes = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| binding.up.turn_vector(axis));
                axes.map(|axis| [right, down, forward].map(|way| axis.dot(way)))
            });
            content.scale = overlays.scale_bar.as_ref().map(|bar| {
                let across = match stand.projection {
                    Projection::Parallel(height) => height as f64,
                    Projection::Perspective(fov) => {
                        2.0 * (at - eye).length() as f64 * (fov as f64 / 2.0).to_radians().tan()
                    }
                };
                Scale { across, length: bar.length.unwrap_or(0.0) }
            });
        }
        content.legend = legend(binding, table);
        content.graph = prepared.graph.clone().map(|graph| Graph { now: seconds, ..graph });
        Ok(content)
    }
}

fn legend(binding: &Binding, table: &Frame) -> Option<Legend> {
    let legend = binding.overlays.legend.as_ref()?;
    let object = binding.objects.iter().find(|o| Some(&o.name) == legend.object.as_ref())?;
    let Color::By { value, map, range } = &object.color else { return None };
    let column = value.expr.text.clone();
    let unit = table.columns.iter().find(|(field, _)| field.name == column).map_or("", |(field, _)| &field.unit);
    let unit = legend.unit.clone().unwrap_or(if unit == "1" { String::new() } else { unit.into() });
    Some(Legend { label: legend.label.clone().unwrap_or(column), unit, map: *map, range: *range })
}

impl Scale {
    /// The scale with its length: that which is given, or the largest of 1, 2 or 5 and a power of ten that is at most `most` metres.
    pub fn with_length(&self, most: f64) -> Scale {
        let power = 10f64.powi(most.log10().floor() as i32);
        let round = [5.0, 2.0, 1.0].into_iter().map(|x| x * power).find(|x| *x <= most * (1.0 + 1e-9));
        let length = if self.length > 0.0 { self.length } else { round.unwrap_or(power) };
        Scale { length, ..self.clone() }
    }

    /// The length of the bar in a unit that suits it.
    pub fn label(&self) -> String {
        // Name, least length, m, and metres.
        let units = [("km", 1e3, 1e3), ("m", 0.1, 1.0), ("mm", 1e-3, 1e-3), ("µm", 1e-6, 1e-6), ("nm", 0.0, 1e-9)];
        let is_long = |(_, least, _): &(&str, f64, f64)| self.length >= least * (1.0 - 1e-9);
        let (unit, _, metres) = units.into_iter().find(is_long).unwrap_or(units[4]);
        // As many digits as the length was given with, without those of its binary form.
        let value = format!("{:.6}", self.length / metres);
        format!("{} {unit}", value.trim_end_matches('0').trim_end_matches('.'))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scale_bars_have_round_lengths_in_units_that_suit() {
        let label = |most: f64| Scale { across: 1.0, length: 0.0 }.with_length(most).label();
        assert_eq!([1.0, 0.99, 0.3, 0.05, 0.0007].map(label), ["1 m", "0.5 m", "0.2 m", "50 mm", "500 µm"]);
        assert_eq!([12.0, 5200.0, 2e-8].map(label), ["10 m", "5 km", "20 nm"]);
        assert_eq!(Scale { across: 1.0, length: 0.125 }.with_length(9.0).label(), "0.125 m", "as it was given");
    }

    #[test]
    fn images_are_told_apart_by_the_hash_of_what_is_plotted() {
        let text = |name: &str, last: f64| {
            let points = (0..9999).map(|k| (k as f64, 1.0)).chain([(9999.0, last)]).collect();
            format!("{:?}", Graph { curves: Curves::new(vec![(name.into(), points)]), ..Graph::default() })
        };
        assert!(text("load", 1.0).len() < 300, "not every point for every image");
        assert_eq!(text("load", 1.0), text("load", 1.0));
        assert!(text("load", 1.0) != text("load", 1.0 + 1e-15) && text("load", 1.0) != text("lift", 1.0));
    }

    #[test]
    fn decimals_tell_frames_apart() {
        assert_eq!([1.0 / 24.0, 0.01, 0.5, 1.0, 2.0].map(|s| decimals_of(s, "s")), [2, 2, 1, 0, 0]);
        assert_eq!([10.0, 50.0, 100.0, 1000.0, 3.0].map(|rate| decimals_of(1.0 / rate, "s")), [1, 2, 2, 3, 1]);
        assert_eq!((decimals_of(1.0 / 24.0, "ms"), decimals_of(1e-5, "ms"), decimals_of(0.0, "s")), (0, 2, 2));
    }
}
