//! Overlays of images: title, time stamp, scale bar, colour legend, axis triad and a plot that grows, drawn into a PNG, or into the layer
//! `overlay` of an EXR, which leaves its data as it is. A shard of an image has its part of them.

mod block;
mod blocks;
mod canvas;
mod content;
mod graph;
mod text;

pub use content::{Content, Prepared};

use bind::Binding;
use bind::binding::{Corner, Overlays};
use block::{Block, Style};
use canvas::Canvas;
use frame::{Fault, Frame};
use render::Display;
use render::film::display::Aov;
use render::film::image::Image;
use render::sl::ir::Kind;

/// Name of the layer of an EXR: `overlay.R`, `overlay.G`, `overlay.B`, and its coverage `overlay.A`.
const LAYER: &str = "overlay";
const COVER: &str = "overlay.A";

/// The overlays of a frame.
#[derive(Debug)]
pub struct Overlay<'a> {
    binding: &'a Binding,
    content: Content,
}

impl Overlay<'_> {
    /// The overlays of a frame.
    pub fn of<'a>(binding: &'a Binding, prepared: &Prepared, table: &Frame) -> Result<Overlay<'a>, Fault> {
        Ok(Overlay { binding, content: Content::of(binding, prepared, table)? })
    }

    /// All that they are drawn from, for the hash of what an image is made of; empty if there are none.
    pub fn imprint(&self) -> String {
        let overlays = &self.binding.overlays;
        if overlays.is_empty() { String::new() } else { format!("{overlays:?} {:?}", self.content) }
    }

    /// Check that they can be drawn into an image of a size.
    pub fn check(&self, [width, height]: [u32; 2]) -> Result<(), Fault> {
        let size = [width as usize, height as usize];
        let em = block::em(size, self.binding.overlays.size);
        self.blocks(size, em, &Style::on(self.binding.overlays.panel)).map(|_| ())
    }

    /// Whether there is nothing to draw.
    pub fn is_empty(&self) -> bool {
        self.binding.overlays.is_empty()
    }

    /// Draw them into an image, whose colours are those of a screen.
    pub fn draw_into(&self, image: &mut Image) -> Result<(), Fault> {
        let size = [image.width, image.height];
        self.draw(&mut Canvas { size, pixels: &mut image.pixels })
    }

    /// Add them to an image as layers, linear and premultiplied, and give the displays that take these.
    pub fn add_layers(&self, image: &mut Image, like: &Display) -> Result<[Display; 2], Fault> {
        let size = [image.width, image.height];
        let mut pixels = vec![[0.0; 4]; size[0] * size[1]];
        self.draw(&mut Canvas { size, pixels: &mut pixels })?;
        let depth = image.depth();
        let mut extra = Vec::with_capacity(image.extra.len() + 4 * pixels.len());
        for (k, [r, g, b, a]) in pixels.into_iter().enumerate() {
            extra.extend_from_slice(&image.extra[k * depth..][..depth]);
            // Colours are premultiplied as screens have them: linear ones are by themselves.
            extra.extend([r, g, b].map(|c| if a > 0.0 { a * (c / a).powf(2.2) } else { 0.0 }));
            extra.push(a);
        }
        image.extra = extra;
        image.aovs.push(Aov { name: LAYER.into(), kind: Kind::Color });
        image.aovs.push(Aov { name: COVER.into(), kind: Kind::Float });
        let display = |mode: &str| Display { mode: mode.into(), ..like.clone() };
        Ok([display(&format!("color {LAYER}")), display(&format!("float {COVER}"))])
    }

    fn draw(&self, canvas: &mut Canvas<'_>) -> Result<(), Fault> {
        let overlays = &self.binding.overlays;
        let (em, style) = (block::em(canvas.size, overlays.size), Style::on(overlays.panel));
        let blocks = self.blocks(canvas.size, em, &style)?;
        block::draw(canvas, &blocks, &style, em);
        Ok(())
    }

    /// The blocks in the order in which those of a corner are stacked, from the corner.
    fn blocks(&self, size: [usize; 2], em: f32, style: &Style) -> Result<Vec<Block>, Fault> {
        let Overlays { title, time, scale_bar, legend, axes, plot, .. } = &self.binding.overlays;
        let mut all = vec![];
        if let (Some(at), Some(words)) = (title, &self.content.title) {
            all.push(blocks::title(words, at.corner, 0.55 * size[0] as f32 / em, style));
        }
        if let (Some(at), Some(words)) = (time, &self.content.time) {
            all.push(blocks::line(words, 1.0, at.corner, style));
        }
        if let (Some(at), Some(_)) = (scale_bar, &self.content.scale) {
            all.push(self.scale_block(size, em, at.corner, style)?);
        }
        if let (Some(at), Some(content)) = (legend, &self.content.legend) {
            all.push(blocks::legend(content, at.corner, style));
        }
        if let (Some(at), Some(content)) = (axes, &self.content.axes) {
            all.push(blocks::axes(content, at.corner, style));
        }
        if let (Some(at), Some(content)) = (plot, &self.content.graph) {
            all.push(graph::block(content, at.corner, style));
        }
        Ok(all)
    }

    fn scale_block(&self, size: [usize; 2], em: f32, corner: Corner, style: &Style) -> Result<Block, Fault> {
        let Some(scale) = &self.content.scale else { unreachable!("there is a scale bar") };
        let [width, height] = size.map(|n| n as f64);
        let metre = width.min(height) / scale.across;
        let is_given = scale.length > 0.0;
        let scale = scale.with_length(0.2 * width / metre);
        let pixels = scale.length * metre;
        if is_given && !(2.0..=0.9 * width).contains(&pixels) {
            let message = format!(
                "a bar of {} is {pixels:.1} of the image's {width} pixels long: give another length",
                scale.label()
            );
            return Err(self.binding.doc.fault("overlays.scale_bar.length", message));
        }
        Ok(blocks::scale(&scale, pixels as f32 / em, corner, style))
    }
}
