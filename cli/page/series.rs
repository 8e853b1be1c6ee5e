//! What a run's report and energies come to: figures, tables of the solver and of the energies, and their plots.

use super::number;
use super::view::{Cell, Stage, Table};
use crate::job::{Curve, Energies, Plot, RunData};

/// The milliseconds of a run's steps.
pub struct Times<'a> {
    /// The stages that take time, with the milliseconds of each step.
    stages: Vec<&'a Curve>,
    /// Milliseconds of each step.
    pub steps: Vec<(f64, f64)>,
}

/// Columns of a report that say how the contacts were solved: name, what it is called, unit.
const SOLVER: [(&str, &str, &str); 4] = [
    ("residual", "residual", "m/s"),
    ("iterations", "iterations", ""),
    ("contacts", "contacts", ""),
    ("worst_penetration", "deepest overlap", "m"),
];

/// Columns of a report that are no stages.
const OTHERS: [&str; 4] = ["step", "time", "parts", "limit"];

/// A column of a run's report.
pub fn column<'a>(run: &'a RunData, name: &str) -> Option<&'a Curve> {
    run.report.iter().find(|c| c.label == name && !c.points.is_empty())
}

/// The finite values of a column of a run's report.
pub fn values(run: &RunData, name: &str) -> Vec<f64> {
    let points = column(run, name).map_or(&[][..], |c| &c.points[..]);
    points.iter().map(|p| p.1).filter(|v| v.is_finite()).collect()
}

/// The greatest of some values; none of none.
pub fn greatest(values: &[f64]) -> Option<f64> {
    values.iter().copied().reduce(f64::max)
}

/// The mean of some values; none of none.
pub fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// The value below which a part of all values is; none of none.
pub fn quantile(values: &[f64], part: f64) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let last = sorted.len().checked_sub(1)?;
    Some(sorted[(part * last as f64).round() as usize])
}

/// The milliseconds of a run's steps, if its report has them.
pub fn times(run: &RunData) -> Option<Times<'_>> {
    let is_stage = |c: &&Curve| {
        let solver = SOLVER.iter().any(|(name, ..)| *name == c.label);
        !solver && !OTHERS.contains(&c.label.as_str()) && !c.points.is_empty()
    };
    let stages: Vec<&Curve> = run.report.iter().filter(is_stage).collect();
    let first = stages.first()?;
    let at = |row: usize| stages.iter().filter_map(move |c| c.points.get(row)).map(|p| p.1).filter(|v| v.is_finite());
    let steps = first.points.iter().enumerate().map(|(row, p)| (p.0, at(row).sum())).collect();
    Some(Times { stages, steps })
}

impl Times<'_> {
    /// Milliseconds of each step.
    pub fn values(&self) -> Vec<f64> {
        self.steps.iter().map(|p| p.1).collect()
    }

    /// The stages, the longest first, with their means.
    pub fn stages(&self) -> Vec<Stage> {
        let mean_of = |c: &Curve| mean(&c.points.iter().map(|p| p.1).filter(|v| v.is_finite()).collect::<Vec<_>>());
        let mut means: Vec<(&str, f64)> =
            self.stages.iter().map(|c| (c.label.as_str(), mean_of(c).unwrap_or(0.0))).collect();
        let all: f64 = means.iter().map(|m| m.1).sum();
        means.sort_by(|a, b| b.1.total_cmp(&a.1));
        let percent = |t: f64| if all > 0.0 { 100.0 * t / all } else { 0.0 };
        let stage = |(name, t): (&str, f64)| Stage {
            name: name.into(),
            time: number::quantity(t, "ms"),
            percent: format!("{:.1}", percent(t)),
        };
        means.into_iter().map(stage).collect()
    }
}

/// A plot of one curve or more.
pub fn plot(title: &str, quantity: &str, unit: &str, curves: Vec<Curve>) -> Plot {
    Plot { name: String::new(), title: title.into(), quantity: quantity.into(), unit: unit.into(), curves }
}

fn named(label: &str, points: Vec<(f64, f64)>) -> Curve {
    Curve { label: label.into(), points, has_start: true }
}

/// How the contacts of a run were solved: a row for each quantity.
pub fn solver(run: &RunData) -> Option<Table> {
    let mut rows = vec![];
    for (name, title, unit) in SOLVER {
        let values = values(run, name);
        let Some(greatest) = greatest(&values) else { continue };
        let unit = if unit.is_empty() { String::new() } else { format!(" [{unit}]") };
        let at = column(run, name).and_then(|c| c.points.iter().find(|p| p.1 == greatest)).map_or(f64::NAN, |p| p.0);
        let numbers = [mean(&values), quantile(&values, 0.5), quantile(&values, 0.95), Some(greatest), Some(at)];
        let mut row = vec![Cell::text(format!("{title}{unit}"))];
        row.extend(numbers.map(|x| Cell::number(x.unwrap_or(f64::NAN))));
        rows.push(row);
    }
    let columns = ["per step", "mean", "median", "95 % below", "greatest", "at [s]"].map(String::from).to_vec();
    (!rows.is_empty()).then_some(Table { columns, rows })
}

/// The plots of how the contacts of a run were solved.
pub fn solver_plots(run: &RunData) -> Vec<Plot> {
    let mut plots = vec![];
    for (name, title, unit) in SOLVER {
        if let Some(curve) = column(run, name) {
            plots.push(plot(title, title, unit, vec![named(title, curve.points.clone())]));
        }
    }
    if let Some(times) = times(run) {
        plots.push(plot("time of a step", "time of a step", "ms", vec![named("time of a step", times.steps)]));
    }
    plots
}

/// The energies of a run, their total, what came in, and what of both is dissipated, J.
fn energies(run: &RunData) -> Option<Vec<Curve>> {
    let Energies { kinetic, potential, elastic, arrived, work: [motors, loads] } = run.energies.as_ref()?;
    let known = |curves: &[(&str, Option<&Curve>)]| -> Vec<Curve> {
        curves.iter().filter_map(|(name, curve)| Some(named(name, (*curve)?.points.clone()))).collect()
    };
    let stored = known(&[("kinetic", Some(kinetic)), ("potential", Some(potential)), ("elastic", elastic.as_ref())]);
    let given = known(&[
        ("of bodies that came", arrived.as_ref()),
        ("work of motors", motors.as_ref()),
        ("work of loads", loads.as_ref()),
    ]);
    let (total, gain) = (sum(&stored), sum(&given));
    let (_, at_start) = *total.first()?;
    let gain_at = |i: usize| gain.get(i).map_or(0.0, |point| point.1);
    let taken = |(i, (t, total)): (usize, &(f64, f64))| (*t, gain_at(i) + at_start - total);
    let dissipated = named("dissipated", total.iter().enumerate().map(taken).collect());
    Some(stored.into_iter().chain([named(TOTAL, total)]).chain(given).chain([dissipated]).collect())
}

/// The name of the sum of the energies.
const TOTAL: &str = "total";

/// The sum of curves of the same times.
fn sum(curves: &[Curve]) -> Vec<(f64, f64)> {
    let Some((first, rest)) = curves.split_first() else { return vec![] };
    let add = |a: Vec<(f64, f64)>, b: &Curve| a.into_iter().zip(&b.points).map(|((t, a), (_, b))| (t, a + b)).collect();
    rest.iter().fold(first.points.clone(), add)
}

/// The change of a run's total energy from its first instant to its last, J.
pub fn change(run: &RunData) -> Option<f64> {
    let total = energies(run)?.into_iter().find(|curve| curve.label == TOTAL)?;
    let mut finite = total.points.iter().map(|p| p.1).filter(|v| v.is_finite());
    let first = finite.next()?;
    Some(finite.next_back().unwrap_or(first) - first)
}

/// The energy balance of a run.
pub fn balance(run: &RunData) -> Option<Table> {
    let curves = energies(run)?;
    let row = |c: &Curve| {
        let values: Vec<f64> = c.points.iter().map(|p| p.1).filter(|v| v.is_finite()).collect();
        let (first, last) = (*values.first()?, *values.last()?);
        let numbers = [first, last, last - first, values.iter().copied().reduce(f64::min)?, greatest(&values)?];
        let mut cells = vec![Cell::text(c.label.clone())];
        cells.extend(numbers.map(Cell::number));
        Some(cells)
    };
    let rows: Vec<Vec<Cell>> = curves.iter().filter_map(row).collect();
    let columns =
        ["energy [J]", "at the start", "at the end", "change", "least", "greatest"].map(String::from).to_vec();
    (!rows.is_empty()).then_some(Table { columns, rows })
}

/// The plot of the energies of a run.
pub fn energy_plots(run: &RunData) -> Vec<Plot> {
    energies(run).map(|curves| plot("energy", "energy", "J", curves)).into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_of_the_values() {
        let values: Vec<f64> = (0..=100).rev().map(f64::from).collect();
        assert_eq!([0.0, 0.5, 0.95, 1.0].map(|part| quantile(&values, part)), [0.0, 50.0, 95.0, 100.0].map(Some));
        assert_eq!((quantile(&[], 0.5), mean(&[]), greatest(&[])), (None, None, None));
        assert_eq!(mean(&[1.0, 2.0, 6.0]), Some(3.0));
    }
}
