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

/// Length of an axis that lies in the image, ems.
const ARM: f32 = 1.35;

/// An axis triad: where the axes of the world point in the image; x to the right, y down, z away. One that points at the eye is a dot, one
/// that points away from it a cross.
pub fn axes(axes: &[[f32; 3]; 3], corner: Corner, style: &Style) -> Block {
    const SIDE: f32 = 4.2;
    let middle = SIDE / 2.0;
    let mut order = [0, 1, 2];
    // What is farther away is drawn first.
    order.sort_by(|i, j| axes[*j][2].total_cmp(&axes[*i][2]));
    let (mut marks, letters) = (vec![], letters(axes));
    for i in order {
        let ([x, y, z], ink) = (axes[i], style.color([1, 2, 0][i]));
        let size = x.hypot(y);
        let at = |along: f32, aside: f32| {
            let (along, aside) = (ARM * along, aside / size.max(1e-4));
            [middle + x * along - y * aside, middle + y * along + x * aside]
        };
        if size > 0.15 {
            marks.push(Mark::Line([at(0.0, 0.0), at(0.9, 0.0)], 0.2, ink));
            marks.push(Mark::Triangle([at(1.1, 0.0), at(0.66, 0.32), at(0.66, -0.32)], ink));
        } else if z < 0.0 {
            marks.push(Mark::Line([[middle, middle]; 2], 0.5, ink));
        } else {
            let (low, high) = (middle - 0.26, middle + 0.26);
            marks.push(Mark::Line([[low, low], [high, high]], 0.18, ink));
            marks.push(Mark::Line([[low, high], [high, low]], 0.18, ink));
        }
        let (letter, [x, y]) = (NAMES[i], letters[i]);
        marks.push(Mark::Text(letter.into(), [middle + x - text::width(letter) / 2.0, middle + y + 0.27], 1.0, ink));
    }
    Block { corner, size: [SIDE, SIDE], marks }
}

/// The names of the axes.
const NAMES: [&str; 3] = ["x", "y", "z"];

/// Where the middles of the axes' names are, ems from where the axes meet: behind their tips, or aside where another name or axis is.
fn letters(axes: &[[f32; 3]; 3]) -> [[f32; 2]; 3] {
    /// Least distance from another name, and from an axis.
    const APART: [f32; 2] = [0.85, 0.5];
    /// Angles between the places that are tried, of which there are as many each way.
    const TURN: f32 = std::f32::consts::PI / TURNS as f32;
    const TURNS: i32 = 12;
    let size = |i: usize| axes[i][0].hypot(axes[i][1]);
    let mut order = [0, 1, 2];
    order.sort_by(|i, j| size(*j).total_cmp(&size(*i)));
    let mut places = [[f32::INFINITY; 2]; 3];
    for i in order {
        let far = (ARM * size(i) + 0.55).max(0.9);
        let first = axes[i][1].atan2(axes[i][0]);
        let turned = |k: i32| [first + k as f32 * TURN, first - k as f32 * TURN];
        let mut tried = (0..=TURNS).flat_map(turned).map(|angle| [far * angle.cos(), far * angle.sin()]);
        let is_free = |place: &[f32; 2]| {
            let from_arm = |j: usize| from_line(*place, [ARM * axes[j][0], ARM * axes[j][1]]);
            let from_name = |j: usize| (place[0] - places[j][0]).hypot(place[1] - places[j][1]);
            (0..3).all(|j| from_arm(j) >= APART[1] && (j == i || from_name(j) >= APART[0]))
        };
        places[i] = tried.find(is_free).unwrap_or([far * first.cos(), far * first.sin()]);
    }
    places
}

/// Distance of a place from the line from the origin to an end.
fn from_line([x, y]: [f32; 2], [ex, ey]: [f32; 2]) -> f32 {
    let t = ((x * ex + y * ey) / (ex * ex + ey * ey).max(1e-9)).clamp(0.0, 1.0);
    (x - t * ex).hypot(y - t * ey)
}

/// A linear value as sRGB.
fn encoded(x: f32) -> f32 {
    if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_axes_keep_apart_from_each_other_and_from_the_axes() {
        for azimuth in (0..360).step_by(5) {
            for height in (-90..=90).step_by(5) {
                let [[s, c], [up, level]] =
                    [azimuth, height].map(|a| (a as f32).to_radians()).map(|a| [a.sin(), a.cos()]);
                // What x, y and z are to an eye that looks down at this height.
                let axes = [[-s, c * up, -c * level], [c, s * up, -s * level], [0.0, -level, -up]];
                let places = letters(&axes);
                for i in 0..3 {
                    for j in 0..3 {
                        let [a, b] = [places[i], places[j]];
                        assert!(i == j || (a[0] - b[0]).hypot(a[1] - b[1]) > 0.8, "{azimuth} {height}: {places:?}");
                        let arm = [ARM * axes[j][0], ARM * axes[j][1]];
                        assert!(from_line(a, arm) > 0.45, "{azimuth} {height}: {i} on {j}, {places:?}");
                    }
                    assert!(places[i][0].hypot(places[i][1]) < 2.0);
                }
            }
        }
    }
}
