//! The vertical extent of plots: rounding noise is flat, and rare spikes do not flatten the rest.

use super::number;
use super::titles;
use crate::job::{Curve, Plot};
use crate::plot::range;
use std::collections::BTreeMap;

/// Rounding noise, over the greatest value of a quantity and of those beside it.
const NOISE: f64 = 1e-11;

/// Noise of lengths, angles, speeds and pure numbers, however small all of them are: by unit.
const LEAST_NOISE: [(&str, f64); 6] =
    [("m", 1e-13), ("m/s", 1e-12), ("1", 1e-11), ("", 1e-11), ("rad", 1e-11), ("rad/s", 1e-9)];

/// The part of the values of a curve that are above those of a plot's range, and below.
const RARE: f64 = 0.02;

/// Instants of curves whose rare values may be outside.
const MIN_INSTANTS: usize = 100;

/// How many times more all values range over where rare ones are left outside.
const MIN_RATIO: f64 = 3.0;

/// The greatest values of the quantities of a section.
pub struct Scales {
    greatest: BTreeMap<(String, String), f64>,
}

/// How a plot is seen at first.
#[derive(Debug)]
pub struct View {
    /// The vertical range, where it leaves something out.
    pub range: Option<[f64; 2]>,
    /// What is to be known of it.
    pub note: String,
    /// What the vertical range spans at least.
    pub span: f64,
}

impl Scales {
    /// The scales of the quantities of some plots.
    pub fn of(plots: &[Plot]) -> Scales {
        let mut greatest = BTreeMap::new();
        for plot in plots {
            let own = values(plot).fold(0.0, |most: f64, v| most.max(v.abs()));
            let of_all: &mut f64 = greatest.entry(key(plot)).or_default();
            *of_all = of_all.max(own);
        }
        Scales { greatest }
    }

    /// The size of rounding noise in a plot: of its own values, and of those of the same unit beside them.
    pub fn noise(&self, plot: &Plot) -> f64 {
        let greatest = self.greatest.get(&key(plot)).copied().unwrap_or(0.0);
        let least = LEAST_NOISE.iter().find(|(unit, _)| *unit == plot.unit).map_or(0.0, |(_, least)| *least);
        (NOISE * greatest).max(least)
    }
}

/// What a plot is of, and its unit.
fn key(plot: &Plot) -> (String, String) {
    let title = plot.title.as_str();
    let owner = match title.strip_suffix(plot.quantity.as_str()).and_then(|rest| rest.strip_suffix('.')) {
        Some(owner) if !plot.quantity.is_empty() => owner,
        _ => title,
    };
    (owner.into(), plot.unit.clone())
}

fn values(plot: &Plot) -> impl Iterator<Item = f64> {
    plot.curves.iter().flat_map(|c| &c.points).map(|p| p.1).filter(|v| v.is_finite())
}

/// Least and greatest finite value of a curve.
fn extent(curve: &Curve) -> Option<[f64; 2]> {
    let finite = curve.points.iter().map(|p| p.1).filter(|v| v.is_finite());
    finite.fold(None, |extent, v| {
        let [lo, hi] = extent.unwrap_or([v, v]);
        Some([lo.min(v), hi.max(v)])
    })
}

/// Whether the curves of a plot are constant but for noise, over two instants or more.
pub fn is_constant(plot: &Plot, noise: f64) -> bool {
    let is_still = |c: &Curve| c.points.len() > 1 && extent(c).is_some_and(|[lo, hi]| hi - lo <= noise);
    let is_residual = plot.title.starts_with("residual") && values(plot).any(|v| v > 0.0);
    !plot.curves.is_empty() && !is_residual && plot.curves.iter().all(is_still)
}

/// The value of a curve that is constant: exact where all are the same, else 0 where they are no more than noise.
pub fn middle(curve: &Curve, noise: f64) -> f64 {
    let Some([lo, hi]) = extent(curve) else { return f64::NAN };
    if lo == hi {
        return lo;
    }
    if lo.abs().max(hi.abs()) <= noise { 0.0 } else { 0.5 * (lo + hi) }
}

/// How a plot is seen at first: without the rare spikes of forces and of times, and without a first instant that flattens the rest.
pub fn view(plot: &Plot, is_log: bool, noise: f64) -> View {
    let note = |text: String| {
        let unit = titles::unit_note(plot);
        if unit.is_empty() || text.is_empty() { format!("{unit}{text}") } else { format!("{unit}; {text}") }
    };
    if is_log {
        return View { range: None, note: note("logarithmic".into()), span: 0.0 };
    }
    if let Some((range, text)) = without_spikes(plot, noise) {
        return View { range: Some(range), note: note(text), span: noise };
    }
    let vertical = range::vertical(&plot.curves, false);
    if vertical.hides_start {
        let text = "the first instant is outside of the vertical range".to_string();
        return View { range: Some(vertical.range), note: note(text), span: noise };
    }
    View { range: None, note: note(String::new()), span: noise }
}

/// The vertical range without rare spikes and what is outside of it; none if there are none.
fn without_spikes(plot: &Plot, noise: f64) -> Option<([f64; 2], String)> {
    if !["N", "N m", "ms"].contains(&plot.unit.as_str()) {
        return None;
    }
    let mut range: Option<[f64; 2]> = None;
    for curve in &plot.curves {
        let mut sorted: Vec<f64> = curve.points.iter().map(|p| p.1).filter(|v| v.is_finite()).collect();
        if sorted.len() < MIN_INSTANTS {
            return None;
        }
        sorted.sort_unstable_by(f64::total_cmp);
        let rank = (RARE * sorted.len() as f64) as usize;
        let own = [sorted[rank], sorted[sorted.len() - 1 - rank]];
        range = Some(range.map_or(own, |[lo, hi]| [lo.min(own[0]), hi.max(own[1])]));
    }
    let [lo, hi] = range?;
    let all = plot.curves.iter().filter_map(extent).reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])?;
    let span = hi - lo;
    if !(span > noise && all[1] - all[0] > MIN_RATIO * span) {
        return None;
    }
    let shown = [(lo - 0.25 * span).max(all[0] - 0.05 * span), (hi + 0.25 * span).min(all[1] + 0.05 * span)];
    let outside = |v: &f64| !(shown[0]..=shown[1]).contains(v);
    let (n, n_outside) = (values(plot).count(), values(plot).filter(outside).count());
    let percent = number::short((1000.0 * n_outside as f64 / n as f64).ceil() / 10.0);
    let quantity = |x: f64| number::quantity(x, titles::unit(plot));
    let mut ends = vec![];
    if all[0] < shown[0] {
        ends.push(format!("down to {}", quantity(all[0])));
    }
    if all[1] > shown[1] {
        ends.push(format!("up to {}", quantity(all[1])));
    }
    Some((shown, format!("{percent} % of the values, {}, are outside of the vertical range", ends.join(" and "))))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plot(title: &str, unit: &str, value: impl Fn(usize) -> f64, n: usize) -> Plot {
        let points = (0..n).map(|i| (i as f64 * 1e-3, value(i))).collect();
        let curves = vec![Curve { label: "a".into(), points, has_start: true }];
        let quantity = title.rsplit('.').next().unwrap_or("").into();
        Plot { name: String::new(), title: title.into(), quantity, unit: unit.into(), curves }
    }

    #[test]
    fn noise_beside_a_quantity_is_constant() {
        let plots = [
            plot("block.x", "m", |i| i as f64, 50),
            plot("block.y", "m", |i| 1e-14 * (i % 3) as f64, 50),
            plot("grain.y", "m", |i| 1e-9 * (i % 3) as f64, 50),
            plot("block.mass", "kg", |_| 2.5, 50),
        ];
        let scales = Scales::of(&plots);
        let still: Vec<bool> = plots.iter().map(|p| is_constant(p, scales.noise(p))).collect();
        assert_eq!(still, [false, true, false, true]);
        assert_eq!((middle(&plots[1].curves[0], 1e-10), middle(&plots[3].curves[0], 0.0)), (0.0, 2.5));
    }

    #[test]
    fn rare_spikes_are_outside_and_said() {
        let spiky = |i: usize| if i % 500 == 77 { 5000.0 } else { 150.0 + (i % 10) as f64 };
        let view = |unit: &str, n: usize| view(&plot("drive.fx", unit, spiky, n), false, 0.0);
        let seen = view("N", 5000);
        assert!(seen.range.is_some_and(|[lo, hi]| lo > 100.0 && hi < 200.0), "{seen:?}");
        assert_eq!(seen.note, "0.2 % of the values, up to 5000 N, are outside of the vertical range");
        assert!(view("m", 5000).range.is_none() && view("N", 90).range.is_none());
    }
}
