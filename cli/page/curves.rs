//! Curves as the data of a page: rounded to what can be seen, and thinned where they are long.
//!
//! A long curve is cut into bins of equally many instants, of which the least and the greatest value stay, each at its own time: no
//! extreme is lost, however short.

use super::titles;
use crate::job::{Curve, Plot};
use serde_json::{Value, json};

/// Numbers in the data of a page, about ten bytes each.
const MAX_NUMBERS: usize = 200_000;

/// Curves that a page shows at most.
pub const MAX_CURVES: usize = 600;

/// How much of each curve a page has room for.
#[derive(Clone, Copy, Debug)]
pub struct Room {
    /// Numbers of a curve, times included.
    numbers: usize,
}

impl Room {
    /// The room of each of these many curves.
    pub fn of(n_curves: usize) -> Room {
        Room { numbers: MAX_NUMBERS / n_curves.clamp(1, MAX_CURVES) }
    }

    /// Bins that a thinned curve is cut to.
    pub fn n_bins(self) -> usize {
        (self.numbers / 4).min(2000)
    }

    /// Whether curves that have their times in common are shown whole.
    fn holds(self, n_instants: usize, n_curves: usize) -> bool {
        n_instants * (n_curves + 1) <= self.numbers * n_curves
    }
}

/// The data of a plot for the page's script, and whether some of its curves are thinned. `is_log`: the vertical axis is logarithmic, and
/// what is not above 0 is a gap.
pub fn data(plot: &Plot, is_log: bool, room: Room) -> (Value, bool) {
    let shown = |v: f64| v.is_finite() && (!is_log || v > 0.0);
    let lengths = plot.curves.iter().map(|c| c.points.len());
    let most = lengths.clone().max().unwrap_or(0);
    let is_whole = room.holds(most, plot.curves.len());
    let times = |curve: &Curve| -> Vec<f64> { curve.points.iter().map(|p| p.0).collect() };
    let have_same_times = plot.curves.windows(2).all(|pair| same_times(&pair[0], &pair[1]));
    let digits = digits(plot);
    let time_digits = time_digits(plot);
    let value = |v: f64| if shown(v) { json!(rounded(v, digits)) } else { Value::Null };
    let column = |points: &[(f64, f64)]| Value::Array(points.iter().map(|p| value(p.1)).collect());
    let row = |times: &[f64]| Value::Array(times.iter().map(|t| json!(rounded(*t, time_digits))).collect());
    let mut is_thinned = false;
    let tables: Vec<Value> = if is_whole && have_same_times && !plot.curves.is_empty() {
        let mut table = vec![row(&times(&plot.curves[0]))];
        table.extend(plot.curves.iter().map(|c| column(&c.points)));
        vec![Value::Array(table)]
    } else {
        let own = |curve: &Curve| {
            let points = if is_whole { curve.points.clone() } else { thinned(&curve.points, room.n_bins()) };
            is_thinned |= points.len() < curve.points.len();
            let times: Vec<f64> = points.iter().map(|p| p.0).collect();
            json!([row(&times), column(&points)])
        };
        plot.curves.iter().map(own).collect()
    };
    let labels: Vec<String> = plot.curves.iter().map(|c| guard::text::line(&c.label)).collect();
    let axis = guard::text::line(&titles::axis(plot));
    (json!({"axis": axis, "log": is_log, "labels": labels, "tables": tables}), is_thinned)
}

fn same_times(a: &Curve, b: &Curve) -> bool {
    a.points.len() == b.points.len() && a.points.iter().zip(&b.points).all(|(p, q)| p.0 == q.0)
}

/// The points that stay of a curve: the first and the last, and of every bin the least, the greatest and one that is missing.
pub fn thinned(points: &[(f64, f64)], n_bins: usize) -> Vec<(f64, f64)> {
    let n = points.len();
    if n <= 2 * n_bins.max(1) {
        return points.to_vec();
    }
    let mut kept = vec![0, n - 1];
    for bin in 0..n_bins.max(1) {
        let range = bin * n / n_bins.max(1)..(bin + 1) * n / n_bins.max(1);
        let finite = || range.clone().filter(|i| points[*i].1.is_finite());
        kept.extend(finite().min_by(|a, b| points[*a].1.total_cmp(&points[*b].1)));
        kept.extend(finite().max_by(|a, b| points[*a].1.total_cmp(&points[*b].1)));
        kept.extend(range.clone().find(|i| !points[*i].1.is_finite()));
    }
    kept.sort_unstable();
    kept.dedup();
    kept.into_iter().map(|i| points[i]).collect()
}

/// Digits of the values of a plot: a hundred-thousandth of what they range over counts, however far from 0 that is.
fn digits(plot: &Plot) -> usize {
    digits_over(plot.curves.iter().flat_map(|c| &c.points).map(|p| p.1))
}

/// Digits of its times: such that no two are written alike.
fn time_digits(plot: &Plot) -> usize {
    let times = || plot.curves.iter().flat_map(|c| &c.points).map(|p| p.0);
    let longest = plot.curves.iter().map(|c| c.points.len()).max().unwrap_or(0).max(1);
    (digits_over(times()) + (longest as f64).log10().ceil() as usize).min(15)
}

fn digits_over(values: impl Iterator<Item = f64>) -> usize {
    let [lo, hi, greatest] = values
        .filter(|v| v.is_finite())
        .fold([f64::INFINITY, f64::NEG_INFINITY, 0.0], |[lo, hi, greatest]: [f64; 3], v| {
            [lo.min(v), hi.max(v), greatest.max(v.abs())]
        });
    let range = hi - lo;
    if !(range > 0.0) {
        return 6;
    }
    (5 + (greatest / range).log10().ceil().max(0.0) as usize).min(15)
}

/// A number rounded to some digits that count.
fn rounded(x: f64, digits: usize) -> f64 {
    format!("{x:.*e}", digits.max(1) - 1).parse().unwrap_or(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(values: impl Fn(usize) -> f64, n: usize) -> Curve {
        let points = (0..n).map(|i| (i as f64 * 1e-3, values(i))).collect();
        Curve { label: "a".into(), points, has_start: true }
    }

    fn plot(curves: Vec<Curve>) -> Plot {
        Plot { name: "a".into(), title: "a".into(), quantity: String::new(), unit: "m".into(), curves }
    }

    #[test]
    fn extremes_gaps_and_ends_stay() {
        let values = |i: usize| match i {
            7_777 => 50.0,
            31_111 => -50.0,
            60_000..60_010 => f64::NAN,
            _ => (i as f64 * 0.01).sin(),
        };
        let curve = curve(values, 100_000);
        let kept = thinned(&curve.points, 100);
        assert!(kept.len() <= 302, "{}", kept.len());
        let has = |v: f64| kept.iter().any(|p| p.1 == v);
        assert!(has(50.0) && has(-50.0) && kept.iter().any(|p| p.1.is_nan()));
        assert_eq!((kept[0], kept[kept.len() - 1]), (curve.points[0], curve.points[99_999]));
        assert!(kept.windows(2).all(|w| w[0].0 < w[1].0), "times in order, each once");
    }

    #[test]
    fn data_is_bounded_and_short_curves_are_whole() {
        let whole = data(&plot(vec![curve(|i| i as f64, 2000); 3]), false, Room::of(40));
        assert!(!whole.1);
        assert_eq!(whole.0["tables"][0].as_array().unwrap().len(), 4);
        let (long, is_thinned) = data(&plot(vec![curve(|i| (i as f64).cos(), 50_000)]), false, Room::of(40));
        assert!(is_thinned && long.to_string().len() < 60_000, "{}", long.to_string().len());
        let empty = data(&plot(vec![]), false, Room::of(0));
        assert_eq!(empty.0["tables"], json!([]));
    }

    #[test]
    fn values_keep_the_digits_that_are_seen() {
        let far = data(&plot(vec![curve(|i| 1e6 + i as f64 * 1e-3, 10)]), false, Room::of(1)).0;
        assert_eq!(far["tables"][0][1][9], json!(1000000.009));
        let third = data(&plot(vec![curve(|i| i as f64 / 3.0, 2)]), false, Room::of(1)).0;
        assert_eq!(third["tables"][0][1][1], json!(0.33333));
        let log = data(&plot(vec![curve(|i| i as f64 - 1.0, 3)]), true, Room::of(1)).0;
        assert_eq!(log["tables"][0][1], json!([null, null, 1.0]));
    }
}
