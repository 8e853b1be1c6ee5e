//! Blocks: what an overlay is drawn of, in ems from its upper left, and their places in the corners of an image.

use super::canvas::{Canvas, Ink, Place};
use super::text;
use bind::binding::{Corner, Panel};

/// Room around the text of a block, and between blocks and the image's edge, ems.
const PADDING: f32 = 0.5;
const MARGIN: f32 = 0.7;
const BETWEEN: f32 = 0.4;

/// The least em, pixels: smaller texts are not legible.
const LEAST_EM: f32 = 12.0;

/// A part of a drawing.
#[derive(Clone, Debug)]
pub enum Mark {
    /// A text from the left end of its baseline, and its size in ems.
    Text(String, Place, f32, Ink),
    /// A line, and its width.
    Line([Place; 2], f32, Ink),
    /// A triangle.
    Triangle([Place; 3], Ink),
    /// A rectangle by two corners.
    Rectangle([Place; 2], Ink),
}

impl Mark {
    fn ink(&self) -> Ink {
        match self {
            Mark::Text(.., ink) | Mark::Line(.., ink) | Mark::Triangle(_, ink) | Mark::Rectangle(_, ink) => *ink,
        }
    }
}

/// An overlay, ready to be placed.
#[derive(Clone, Debug)]
pub struct Block {
    /// Corner of the image.
    pub corner: Corner,
    /// Width and height, ems.
    pub size: Place,
    /// What it is drawn of.
    pub marks: Vec<Mark>,
}

/// The colours that overlays are drawn in.
#[derive(Clone, Copy, Debug)]
pub struct Style {
    /// Of texts and lines.
    pub ink: Ink,
    /// Of lines that stand back.
    pub faint: Ink,
    /// Of the panel.
    pub panel: Ink,
    /// Of the rim of texts and lines; it is there where there is no panel.
    pub rim: Option<Ink>,
}

impl Style {
    /// The colours on a panel.
    pub fn on(panel: Panel) -> Style {
        let (pale, dark) = ([0.97, 0.97, 0.96, 1.0], [0.08, 0.09, 0.1, 1.0]);
        let faint = |ink: Ink| [ink[0], ink[1], ink[2], 0.4];
        match panel {
            Panel::Dark => Style { ink: pale, faint: faint(pale), panel: [0.05, 0.055, 0.065, 0.74], rim: None },
            Panel::Light => Style { ink: dark, faint: faint(dark), panel: [1.0, 1.0, 1.0, 0.82], rim: None },
            Panel::None => {
                Style { ink: pale, faint: faint(pale), panel: [0.0; 4], rim: Some([0.03, 0.03, 0.04, 0.75]) }
            }
        }
    }

    /// The colour of a curve or an axis by its index; told apart by the colour-blind, too (Okabe and Ito).
    pub fn color(&self, index: usize) -> Ink {
        let on_dark = [[0.34, 0.71, 0.91], [0.9, 0.62, 0.0], [0.25, 0.78, 0.6], [0.85, 0.55, 0.72]];
        let on_light = [[0.0, 0.45, 0.7], [0.84, 0.37, 0.0], [0.0, 0.55, 0.4], [0.7, 0.35, 0.55]];
        let [r, g, b] = if self.ink[0] > 0.5 { on_dark[index % 4] } else { on_light[index % 4] };
        [r, g, b, 1.0]
    }
}

/// Pixels of an em in an image of this size.
pub fn em(size: [usize; 2], factor: f32) -> f32 {
    let [width, height] = size.map(|n| n as f32);
    (factor * height.min(0.75 * width) / 34.0).max(LEAST_EM * factor.min(1.0))
}

/// Where the upper left of each block is, pixels: those of a corner are stacked from there.
pub fn places(blocks: &[Block], size: [usize; 2], em: f32) -> Vec<Place> {
    let mut used = [MARGIN; 4];
    let place = |block: &Block| {
        let [w, h] = block.size.map(|x| x + 2.0 * PADDING);
        let from = &mut used[block.corner as usize];
        let along = *from * em;
        *from += h + BETWEEN;
        let [width, height] = size.map(|n| n as f32);
        let (left, right) = (MARGIN * em, width - (MARGIN + w) * em);
        let (top, bottom) = (along, height - along - h * em);
        match block.corner {
            Corner::TopLeft => [left, top],
            Corner::TopRight => [right, top],
            Corner::BottomLeft => [left, bottom],
            Corner::BottomRight => [right, bottom],
        }
        .map(f32::round)
    };
    blocks.iter().map(place).collect()
}

/// The box of a block with its panel, pixels: width and height.
pub fn outer(block: &Block, em: f32) -> Place {
    block.size.map(|x| (x + 2.0 * PADDING) * em)
}

/// Draw blocks at their places.
pub fn draw(canvas: &mut Canvas<'_>, blocks: &[Block], style: &Style, em: f32) {
    for (block, at) in blocks.iter().zip(places(blocks, canvas.size, em)) {
        let [w, h] = outer(block, em);
        if style.panel[3] > 0.0 {
            canvas.panel(at, [at[0] + w, at[1] + h], 0.25 * em, style.panel);
        }
        let from = at.map(|x| x + PADDING * em);
        if let Some(rim) = style.rim {
            // The rim of all lies under all; what stands back has none.
            let r = (0.055 * em).max(0.8);
            for (dx, dy) in [(-r, 0.0), (r, 0.0), (0.0, -r), (0.0, r), (-r, -r), (r, r), (-r, r), (r, -r)] {
                let moved = [from[0] + dx, from[1] + dy];
                let in_front = block.marks.iter().filter(|mark| mark.ink()[3] == 1.0);
                in_front.for_each(|mark| draw_mark(canvas, mark, moved, em, Some(rim)));
            }
        }
        block.marks.iter().for_each(|mark| draw_mark(canvas, mark, from, em, None));
    }
}

fn draw_mark(canvas: &mut Canvas<'_>, mark: &Mark, from: Place, em: f32, instead: Option<Ink>) {
    let at = |p: &Place| [from[0] + p[0] * em, from[1] + p[1] * em];
    match mark {
        // Texts stand on whole rows of pixels.
        Mark::Text(text, place, size, ink) => {
            let [x, y] = at(place);
            text::draw(canvas, text, [x, y.round()], em * size, instead.unwrap_or(*ink));
        }
        Mark::Line([a, b], width, ink) => {
            canvas.line(at(a), at(b), (width * em).max(1.0), instead.unwrap_or(*ink));
        }
        Mark::Triangle(corners, ink) => canvas.triangle(corners.each_ref().map(at), instead.unwrap_or(*ink)),
        Mark::Rectangle([a, b], ink) => canvas.panel(at(a), at(b), 0.0, instead.unwrap_or(*ink)),
    }
}
