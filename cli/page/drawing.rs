//! The plots of a page: their data for its script, and their heads for its template.

use super::curves::{self, MAX_CURVES, Room};
use super::scale::{self, Scales};
use super::titles;
use super::view::{Constant, PlotHead, Section};
use crate::job::Plot;
use serde_json::{Value, json};

/// The data of plots, and their heads on a page.
pub struct Drawing {
    /// The data of the plots, by their indices.
    pub data: Vec<Value>,
    room: Room,
    n_curves: usize,
    n_left_out: usize,
    is_thinned: bool,
}

impl Drawing {
    /// A drawing with room for these many curves.
    pub fn of(n_curves: usize) -> Drawing {
        Drawing { room: Room::of(n_curves), data: vec![], n_curves: 0, n_left_out: 0, is_thinned: false }
    }

    /// Add plots as a section of the page. Those whose curves are constant are listed; of those beyond the page's room the less telling
    /// ones are left out and counted.
    pub fn section(&mut self, name: &str, plots: &[Plot]) -> Section {
        let scales = Scales::of(plots);
        let is_still = |plot: &&Plot| scale::is_constant(plot, scales.noise(plot));
        let constants = plots.iter().filter(is_still).map(|plot| constant(plot, scales.noise(plot))).collect();
        let moving: Vec<&Plot> = plots.iter().filter(|plot| !is_still(plot)).collect();
        let chosen = self.choose(&moving);
        let mut heads = vec![];
        for plot in moving.iter().zip(chosen).filter(|(_, is_chosen)| *is_chosen).map(|(plot, _)| *plot) {
            let is_log = is_log(plot);
            let (mut data, is_thinned) = curves::data(plot, is_log, self.room);
            self.is_thinned |= is_thinned;
            let view = scale::view(plot, is_log, scales.noise(plot));
            if let Some(range) = view.range {
                data["range"] = json!(range);
            }
            if view.span > 0.0 {
                data["span"] = json!(view.span);
            }
            let title = titles::title(plot);
            heads.push(PlotHead { index: self.data.len(), title, note: view.note, is_cut: view.range.is_some() });
            self.data.push(data);
        }
        Section { name: name.into(), plots: heads, constants }
    }

    /// Which of some plots the page has room for: those that tell more before others.
    fn choose(&mut self, plots: &[&Plot]) -> Vec<bool> {
        let mut order: Vec<usize> = (0..plots.len()).collect();
        order.sort_by_key(|i| titles::rank(plots[*i]));
        let mut chosen = vec![false; plots.len()];
        for i in order {
            let n = plots[i].curves.len();
            if self.n_curves + n > MAX_CURVES.max(n) {
                self.n_left_out += 1;
                continue;
            }
            self.n_curves += n;
            chosen[i] = true;
        }
        chosen
    }

    /// What is to be known of the plots.
    pub fn note(&self) -> String {
        let mut note = String::new();
        if self.is_thinned {
            note += &format!(
                "Long curves are thinned: of each of {} parts of a curve its least and its greatest value are drawn, so that no \
                 extreme is lost. ",
                self.room.n_bins()
            );
        }
        if self.n_left_out > 0 {
            note += &format!(
                "A page has at most {MAX_CURVES} curves, and {} not shown: name the columns that matter, as in `scree report RUN \
                 'hinge.*'`. ",
                match self.n_left_out {
                    1 => "one further plot is".to_string(),
                    n => format!("{n} further plots are"),
                }
            );
        }
        note
    }
}

/// The values of a plot that is not drawn, since each of its curves is constant.
fn constant(plot: &Plot, noise: f64) -> Constant {
    let mut values: Vec<(&str, f64)> =
        plot.curves.iter().map(|c| (c.label.as_str(), scale::middle(c, noise))).collect();
    let is_same = values.iter().all(|v| v.1 == values[0].1);
    let value = |x: f64| super::number::quantity(x, titles::unit(plot));
    let text = if is_same {
        values.truncate(1);
        values.first().map_or("–".into(), |v| value(v.1))
    } else {
        /// Values that are listed.
        const LISTED: usize = 6;
        let mut listed: Vec<String> =
            values.iter().take(LISTED).map(|(label, v)| format!("{label} {}", value(*v))).collect();
        if values.len() > LISTED {
            listed.push(format!("{} more", values.len() - LISTED));
        }
        listed.join(", ")
    };
    Constant { name: titles::title(plot), value: text }
}

/// Whether a plot is drawn over a logarithmic axis: that of residuals, which range over decades.
fn is_log(plot: &Plot) -> bool {
    let values = || plot.curves.iter().flat_map(|c| &c.points).map(|p| p.1).filter(|v| *v > 0.0 && v.is_finite());
    let [lo, hi] = values().fold([f64::INFINITY, 0.0f64], |[lo, hi], v| [lo.min(v), hi.max(v)]);
    plot.title.starts_with("residual") && hi > 100.0 * lo
}
