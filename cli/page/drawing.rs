//! The plots of a page: their data for its script, and their heads for its template.

use super::curves::{self, MAX_CURVES, Room};
use super::view::{PlotHead, Section};
use crate::job::Plot;
use crate::plot::range;
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

    /// Add plots as a section of the page. Those beyond the page's room are counted.
    pub fn section(&mut self, name: &str, plots: &[Plot]) -> Section {
        let mut heads = vec![];
        for plot in plots {
            self.n_curves += plot.curves.len();
            if self.n_curves > MAX_CURVES.max(plot.curves.len()) {
                self.n_left_out += 1;
                continue;
            }
            let is_log = is_log(plot);
            let (mut data, is_thinned) = curves::data(plot, is_log, self.room);
            self.is_thinned |= is_thinned;
            let vertical = range::vertical(&plot.curves, is_log);
            let note = match (is_log, vertical.hides_start) {
                (true, _) => "logarithmic",
                (_, true) => "the first instant is outside of the vertical range",
                _ => "",
            };
            if vertical.hides_start {
                data["range"] = json!(vertical.range);
            }
            heads.push(PlotHead { index: self.data.len(), title: title(plot), note: note.into() });
            self.data.push(data);
        }
        Section { name: name.into(), plots: heads }
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
                "{} not shown: name the columns that matter, as in `scree report RUN 'hinge.*'`. ",
                match self.n_left_out {
                    1 => "One further plot is".to_string(),
                    n => format!("{n} further plots are"),
                }
            );
        }
        note
    }
}

/// The title of a plot: that of a single column is its name.
fn title(plot: &Plot) -> String {
    match plot.quantity.as_str() {
        quantity if quantity.is_empty() || plot.title.ends_with(quantity) => plot.title.clone(),
        quantity => format!("{}.{quantity}", plot.title),
    }
}

/// Whether a plot is drawn over a logarithmic axis: that of residuals, which range over decades.
fn is_log(plot: &Plot) -> bool {
    let values = || plot.curves.iter().flat_map(|c| &c.points).map(|p| p.1).filter(|v| *v > 0.0 && v.is_finite());
    let [lo, hi] = values().fold([f64::INFINITY, 0.0f64], |[lo, hi], v| [lo.min(v), hi.max(v)]);
    plot.title.starts_with("residual") && hi > 100.0 * lo
}
