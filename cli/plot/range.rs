//! Ranges of a plot's axes.
//!
//! Before the first step a joint has no force, and in it what the model was built with is set right: the first instant of a run may
//! be far from all others. The vertical range leaves it out where it would take more than half of the range, and the plot says so.
//! No later instant is ever left out.

use super::axis::short;
use crate::job::Curve;

/// The vertical range of a plot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vertical {
    /// Lower and upper end.
    pub range: [f64; 2],
    /// Whether the first instant of some curve is outside.
    pub hides_start: bool,
}

/// Instants that a plot has at least if the first is left out.
const MIN_INSTANTS: usize = 4;

/// The range of times.
pub fn times(curves: &[Curve]) -> [f64; 2] {
    let [lo, hi] = extent(curves.iter().flat_map(|c| &c.points).map(|p| p.0)).unwrap_or([0.0, 1.0]);
    if hi > lo { [lo, hi] } else { [lo - 0.5, lo + 0.5] }
}

/// The vertical range, with room above and below; `full` leaves nothing out.
pub fn vertical(curves: &[Curve], full: bool) -> Vertical {
    let values =
        |from: fn(&Curve) -> usize| extent(curves.iter().flat_map(move |c| c.points.iter().skip(from(c))).map(|p| p.1));
    let all = values(|_| 0);
    let later = values(|c| usize::from(c.has_start));
    let n_instants = curves.iter().map(|c| c.points.len()).max().unwrap_or(0);
    if let (Some(all), Some(later), false) = (all, later, full || n_instants < MIN_INSTANTS) {
        let [all_span, span] = [all, later].map(|[lo, hi]| hi - lo);
        if !is_constant(later) && span < 0.5 * all_span {
            return Vertical { range: padded(later), hides_start: true };
        }
    }
    Vertical { range: padded(all.unwrap_or([0.0, 1.0])), hides_start: false }
}

/// The line at the foot of a plot: which first instants are outside its vertical range, and how to see them.
pub fn note(curves: &[Curve], [lo, hi]: [f64; 2], unit: &str) -> String {
    let start = |c: &&Curve| c.has_start.then(|| c.points.first().copied()).flatten();
    let outside: Vec<(&Curve, (f64, f64))> = curves
        .iter()
        .filter_map(|c| Some((c, start(&c)?)))
        .filter(|(_, (_, y))| y.is_finite() && !(lo..=hi).contains(y))
        .collect();
    let value =
        |(c, (_, y)): &(&Curve, (f64, f64))| format!("{} = {} {unit}", c.label, short(*y)).trim_end().to_string();
    let mut values: Vec<String> = outside.iter().take(3).map(value).collect();
    if outside.len() > values.len() {
        values.push(format!("{} more", outside.len() - values.len()));
    }
    let t = outside.first().map_or(0.0, |(_, (t, _))| *t);
    format!("Outside the vertical range: the first instant, t = {t} s ({}). --full-range shows it.", values.join(", "))
}

/// Least and greatest of the finite values.
fn extent(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    values.filter(|x| x.is_finite()).fold(None, |extent, x| {
        let [lo, hi] = extent.unwrap_or([x, x]);
        Some([lo.min(x), hi.max(x)])
    })
}

/// Whether values differ by no more than their last digits.
fn is_constant([lo, hi]: [f64; 2]) -> bool {
    hi - lo <= 1e-12 * lo.abs().max(hi.abs())
}

/// A range with room at both ends; of a constant, about its value.
fn padded(range: [f64; 2]) -> [f64; 2] {
    let [lo, hi] = range;
    let room = match is_constant(range) {
        false => 0.05 * (hi - lo),
        true if lo == 0.0 => 1.0,
        true => 0.5 * lo.abs(),
    };
    [lo - room, hi + room]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(values: &[f64]) -> Curve {
        let points = values.iter().enumerate().map(|(i, y)| (i as f64, *y)).collect();
        Curve { label: "fx".into(), points, has_start: true }
    }

    #[test]
    fn only_a_first_instant_that_flattens_the_rest_is_left_out() {
        let range = |values: &[f64]| vertical(&[curve(values)], false);
        let spike = range(&[900.0, 10.0, 11.0, 10.0, 12.0]);
        assert!(spike.hides_start && spike.range[0] > 9.0 && spike.range[1] < 13.0, "{spike:?}");
        assert!(vertical(&[curve(&[900.0, 10.0, 11.0, 10.0])], true).range[1] > 900.0);
        for shown in
            [&[900.0, 10.0, 11.0][..], &[2.0, 1.5, 1.0, 0.5], &[0.0, 4.0, 4.0, 4.0], &[10.0, 900.0, 10.0, 11.0]]
        {
            let found = range(shown);
            assert!(
                !found.hides_start && found.range[0] <= 10.0 && found.range[1] >= shown[0].max(shown[1]),
                "{found:?}"
            );
        }
        let note = note(&[curve(&[900.0, 10.0, 11.0])], spike.range, "N");
        assert!(note.contains("t = 0 s (fx = 900.0 N)") && note.contains("--full-range"), "{note}");
    }

    #[test]
    fn constants_and_nothing_have_ranges() {
        assert_eq!(vertical(&[curve(&[5.0, 5.0])], false).range, [2.5, 7.5]);
        assert_eq!(vertical(&[curve(&[0.0])], false).range, [-1.0, 1.0]);
        assert!(vertical(&[curve(&[f64::NAN])], false).range[0] < 0.0);
        assert_eq!(times(&[curve(&[3.0])]), [-0.5, 0.5]);
    }
}
