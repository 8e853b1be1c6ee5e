//! The overlays as blocks: title, time stamp, scale bar, colour legend, axis triad.

use super::block::{Block, Mark, Style};
use super::canvas::Place;
use super::content::{Legend, Scale};
use super::text;
use crate::plot::axis::{name, ticks};
use bind::binding::Corner;

/// How high a line of text is, and its baseline from its top, ems.
pub const LINE: f32 = 1.2;
pub const BASE: f32 = 0.95;

/// The most ems that a title is wide.
const TITLE_WIDTH: f32 = 34.0;

/// A text from the left end of its baseline.
pub fn write(text: &str, at: Place, size: f32, style: &Style) -> Mark {
    Mark::Text(text.into(), at, size, style.ink)
}

/// A line of text.
pub fn line(words: &str, size: f32, corner: Corner, style: &Style) -> Block {
    let marks = vec![write(words, [0.0, BASE * size], size, style)];
    Block { corner, size: [text::width(words) * size, LINE * size], marks }
}

/// A title, broken into lines where it is too wide; a word that is wider than a line is made smaller.
pub fn title(words: &str, corner: Corner, room: f32, style: &Style) -> Block {
    const SIZE: f32 = 1.35;
    let widest = words.split_whitespace().map(text::width).fold(0.0, f32::max);
    let room = room.min(TITLE_WIDTH);
    let size = SIZE.min(room / widest.max(1e-3));
    let mut lines: Vec<String> = vec![];
    for word in words.split_whitespace() {
        match lines.last_mut() {
            Some(last) if size * text::width(&format!("{last} {word}")) <= room => *last += &format!(" {word}"),
            _ => lines.push(word.into()),
        }
    }
    let width = lines.iter().map(|line| text::width(line) * size).fold(0.0, f32::max);
    let place = |k: usize| [0.0, (BASE + LINE * k as f32) * size];
    let marks = lines.iter().enumerate().map(|(k, line)| write(line, place(k), size, style)).collect();
    Block { corner, size: [width, LINE * size * lines.len() as f32], marks }
}

/// A scale bar, of a length in ems.
pub fn scale(scale: &Scale, length: f32, corner: Corner, style: &Style) -> Block {
    let words = scale.label();
    let width = length.max(text::width(&words));
    let (y, left) = (LINE + 0.45, (width - length) / 2.0);
    let end = |x: f32| Mark::Line([[x, y - 0.3], [x, y + 0.3]], 0.1, style.ink);
    let marks = vec![
        write(&words, [(width - text::width(&words)) / 2.0, BASE], 1.0, style),
        Mark::Line([[left, y], [left + length, y]], 0.1, style.ink),
        end(left),
        end(left + length),
    ];
    Block { corner, size: [width, y + 0.35], marks }
}

/// A colour legend: a bar with ticks.
pub fn legend(legend: &Legend, corner: Corner, style: &Style) -> Block {
    const SIZE: f32 = 0.9;
    let (height, across, top) = (7.0, 0.9, LINE + 0.45);
    let Some([a, b]) = legend.range else {
        return line(&format!("{}: no values", legend.label), 1.0, corner, style);
    };
    let (lo, hi) = (a.min(b), a.max(b));
    let spread = if hi > lo { hi - lo } else { 1.0 };
    let found = ticks([lo, lo + spread], |labels, step| labels.len() > 1 && step as f32 * height > 1.5 * SIZE);
    let words = name(&legend.label, &legend.unit, found.exponent);
    let mut marks = vec![write(&words, [0.0, BASE], 1.0, style)];
    let steps = 128;
    for k in 0..steps {
        // Rows overlap, so that no seam is between them; from the lower end.
        let ends = [k as f32, if k + 1 < steps { k as f32 + 1.6 } else { steps as f32 }].map(|k| k / steps as f32);
        let value = lo + spread * (k as f64 + 0.5) / steps as f64;
        let [r, g, b] = legend.map.color((value - a) / if b == a { 1.0 } else { b - a }).map(encoded);
        let [y1, y0] = ends.map(|e| top + height * (1.0 - e));
        marks.push(Mark::Rectangle([[0.0, y0], [across, y1]], [r, g, b, 1.0]));
    }
    let mut width = text::width(&words);
    for (value, label) in found.values.iter().zip(&found.labels) {
        let y = top + height * (1.0 - ((value - lo) / spread) as f32);
        marks.push(Mark::Line([[across, y], [across + 0.25, y]], 0.07, style.ink));
        marks.push(write(label, [across + 0.5, y + 0.33 * SIZE], SIZE, style));
        width = width.max(across + 0.5 + SIZE * text::width(label));
    }
    Block { corner, size: [width, top + height + 0.4], marks }
}

/// An axis triad: where the axes of the world point in the image; x to the right, y down, z away.
pub fn axes(axes: &[[f32; 3]; 3], corner: Corner, style: &Style) -> Block {
    const SIDE: f32 = 4.2;
    let (middle, length) = (SIDE / 2.0, 1.35);
    let mut order = [0, 1, 2];
    // What is farther away is drawn first.
    order.sort_by(|i, j| axes[*j][2].total_cmp(&axes[*i][2]));
    let mut marks = vec![];
    for i in order {
        let ([x, y, _], ink) = (axes[i], style.color([1, 2, 0][i]));
        let at = |along: f32, aside: f32| {
            let size = x.hypot(y).max(1e-4);
            [middle + length * x * along - aside * y / size, middle + length * y * along + aside * x / size]
        };
        marks.push(Mark::Line([at(0.0, 0.0), at(0.9, 0.0)], 0.14, ink));
        if x.hypot(y) > 0.15 {
            marks.push(Mark::Triangle([at(1.1, 0.0), at(0.72, 0.24), at(0.72, -0.24)], ink));
        }
        let (letter, [tx, ty]) = (["x", "y", "z"][i], at(1.42, 0.0));
        marks.push(Mark::Text(letter.into(), [tx - text::width(letter) / 2.0, ty + 0.27], 1.0, ink));
    }
    Block { corner, size: [SIDE, SIDE], marks }
}

/// A linear value as sRGB.
fn encoded(x: f32) -> f32 {
    if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}
