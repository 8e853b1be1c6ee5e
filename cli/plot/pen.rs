//! A pen: lines and texts in pixels of a plot, on a drawing of several times its size.

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// A place, pixels from the upper left.
pub type Place = [f64; 2];

/// A drawing and its scale.
pub struct Pen<'a, B: DrawingBackend> {
    /// The drawing.
    pub area: &'a DrawingArea<B, Shift>,
    /// Pixels of the drawing per pixel of the plot.
    pub scale: u32,
}

impl<B: DrawingBackend> Pen<'_, B> {
    fn at(&self, [x, y]: Place) -> (i32, i32) {
        let s = self.scale as f64;
        ((x * s).round() as i32, (y * s).round() as i32)
    }

    /// Fill everything.
    pub fn fill(&self, color: RGBColor) -> Result<(), String> {
        self.area.fill(&color).map_err(|e| e.to_string())
    }

    /// Draw a line through places.
    pub fn line(&self, places: &[Place], color: RGBColor, width: f64) -> Result<(), String> {
        let style = color.stroke_width((width * self.scale as f64).round().max(1.0) as u32);
        let places: Vec<(i32, i32)> = places.iter().map(|p| self.at(*p)).collect();
        self.area.draw(&PathElement::new(places, style)).map_err(|e| e.to_string())
    }

    /// Draw a dot.
    pub fn dot(&self, place: Place, color: RGBColor, radius: f64) -> Result<(), String> {
        let radius = (radius * self.scale as f64).round() as i32;
        self.area.draw(&Circle::new(self.at(place), radius, color.filled())).map_err(|e| e.to_string())
    }

    fn style(&self, size: f64) -> TextStyle<'static> {
        ("sans-serif", size * self.scale as f64).into_font().color(&RGBColor(30, 30, 30))
    }

    /// Write a text whose anchor is at a place.
    pub fn text(&self, text: &str, place: Place, size: f64, (h, v): (HPos, VPos)) -> Result<(), String> {
        let style = self.style(size).pos(Pos::new(h, v));
        self.area.draw(&Text::new(text.to_string(), self.at(place), style)).map_err(|e| e.to_string())
    }

    /// Write a text upwards, with its middle at a place.
    pub fn text_upwards(&self, text: &str, place: Place, size: f64) -> Result<(), String> {
        let font = ("sans-serif", size * self.scale as f64).into_font().transform(FontTransform::Rotate270);
        let style = font.color(&RGBColor(30, 30, 30)).pos(Pos::new(HPos::Center, VPos::Center));
        self.area.draw(&Text::new(text.to_string(), self.at(place), style)).map_err(|e| e.to_string())
    }

    /// The width of a text.
    pub fn width(&self, text: &str, size: f64) -> f64 {
        let estimate = self.area.estimate_text_size(text, &self.style(size));
        estimate.map_or(0.6 * size * text.chars().count() as f64, |(w, _)| w as f64 / self.scale as f64)
    }

    /// A text without what does not fit into a width: its middle is left out.
    pub fn shortened(&self, text: &str, size: f64, width: f64) -> String {
        /// More characters fit nowhere.
        const MOST: usize = 256;
        let all: Vec<char> = text.chars().collect();
        let without_middle = |keep: usize| -> String {
            let (head, tail) = (&all[..keep.div_ceil(2)], &all[all.len() - keep / 2..]);
            head.iter().chain(&['…']).chain(tail).collect()
        };
        let mut keep = all.len().min(MOST);
        let mut short = if keep == all.len() { text.to_string() } else { without_middle(keep) };
        while self.width(&short, size) > width && keep > 2 {
            keep -= 1;
            short = without_middle(keep);
        }
        short
    }
}
