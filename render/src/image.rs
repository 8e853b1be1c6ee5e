//! Pictures: exposure, quantization, and PNG, TIFF and EXR bytes (RISpec 4.2).

use crate::options::Options;
use ::image::codecs::{openexr::OpenExrEncoder, png::PngEncoder, tiff::TiffEncoder};
use ::image::{ExtendedColorType, ImageEncoder};

/// A picture: rows from the top, red, green, blue (premultiplied) and coverage.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Pixels.
    pub width: usize,
    /// Pixels.
    pub height: usize,
    /// The pixels.
    pub pixels: Vec<[f32; 4]>,
}

impl Image {
    /// A black picture.
    pub fn new(width: usize, height: usize) -> Image {
        Image { width, height, pixels: vec![[0.0; 4]; width * height] }
    }

    /// Expose the colours: (gain · c)^(1/gamma).
    pub fn expose(&mut self, gain: f32, gamma: f32) {
        for p in &mut self.pixels {
            for c in &mut p[..3] {
                *c = (*c * gain).max(0.0);
                if gamma != 1.0 {
                    *c = c.powf(1.0 / gamma);
                }
            }
        }
    }

    /// The picture as the bytes of a file of `kind` (`png`, `tiff` or `exr`) with or without coverage. EXR has floats, and so has
    /// TIFF where colours are not quantized. `options` are those that it was made with.
    pub fn encode(&self, kind: &str, with_alpha: bool, options: &Options) -> Result<Vec<u8>, String> {
        let mut bytes = Vec::new();
        let [[x0, y0], [x1, y1]] = options.window();
        let (w, h) = ((x1 - x0) as u32, (y1 - y0) as u32);
        let n = if with_alpha { 4 } else { 3 };
        let window = (y0..y1).flat_map(|y| (x0..x1).map(move |x| y * self.width + x)).map(|i| (i, &self.pixels[i]));
        if kind == "exr" || (kind == "tiff" && options.quantize_one == 0) {
            let floats: Vec<u8> = window.flat_map(|(_, p)| p[..n].iter().flat_map(|x| x.to_ne_bytes())).collect();
            let color = if with_alpha { ExtendedColorType::Rgba32F } else { ExtendedColorType::Rgb32F };
            let goal = std::io::Cursor::new(&mut bytes);
            let done = match kind {
                "exr" => OpenExrEncoder::new(goal).write_image(&floats, w, h, color),
                _ => TiffEncoder::new(goal).write_image(&floats, w, h, color),
            };
            done.map_err(|e| e.to_string())?;
            return Ok(bytes);
        }
        let deep = options.quantize_one > 255;
        let one = if deep { 65535.0 } else { 255.0 };
        let quantize = |i: usize, c: usize, x: f32| {
            // Dither is noise of the pixel's own, the same in every run.
            let noise = sl::noise::cell_noise(
                [(i % self.width) as f32 + 0.5, (i / self.width) as f32 + 0.5, c as f32 + 0.5],
                9,
            );
            (x * one + options.dither * (2.0 * noise - 1.0)).round().clamp(0.0, one)
        };
        let values = window.flat_map(|(i, p)| (0..n).map(move |c| (i, c, p[c])));
        let data: Vec<u8> = if deep {
            values.flat_map(|(i, c, x)| (quantize(i, c, x) as u16).to_ne_bytes()).collect()
        } else {
            values.map(|(i, c, x)| quantize(i, c, x) as u8).collect()
        };
        let color = match (deep, with_alpha) {
            (false, false) => ExtendedColorType::Rgb8,
            (false, true) => ExtendedColorType::Rgba8,
            (true, false) => ExtendedColorType::Rgb16,
            (true, true) => ExtendedColorType::Rgba16,
        };
        let done = match kind {
            "tiff" => TiffEncoder::new(std::io::Cursor::new(&mut bytes)).write_image(&data, w, h, color),
            _ => PngEncoder::new(&mut bytes).write_image(&data, w, h, color),
        };
        done.map_err(|e| e.to_string())?;
        Ok(bytes)
    }
}

/// Width and height of a picture file, if it can be decoded whole.
pub fn decode_size(path: &std::path::Path) -> Option<(u32, u32)> {
    ::image::open(path).ok().map(|i| (i.width(), i.height()))
}
