//! Images: exposure, quantization, and PNG, TIFF and EXR bytes (RISpec 4.1.2).

use crate::film::display::{self, Aov, Channel, Display, Layer, Quantization, channels};
use ::image::codecs::tiff::TiffEncoder as WholeTiffEncoder;
use ::image::{ExtendedColorType, ImageEncoder};
use rayon::prelude::*;
use tiff::encoder::{TiffEncoder, colortype};

/// Longest side of an image, pixels.
pub const LONGEST_SIDE: usize = 65_536;

/// An image: colour, coverage and arbitrary output variables of each pixel, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Width, pixels.
    pub width: usize,
    /// Height, pixels.
    pub height: usize,
    /// Red, green, blue (premultiplied, linear before exposure) and coverage; `[width × height]`.
    pub pixels: Vec<[f32; 4]>,
    /// The arbitrary output variables.
    pub aovs: Vec<Aov>,
    /// Numbers of the arbitrary output variables, pixel after pixel; `[width × height × depth]`, see [`Image::depth`].
    pub extra: Vec<f32>,
}

/// Settings of an image file's encoding: window, quantization and metadata.
pub struct Encoding<'a> {
    /// The pixels to write, `[[x0, y0], [x1, y1]]`: the first pixel and one past the last.
    pub window: [[usize; 2]; 2],
    /// Pixel aspect ratio: width of a pixel over its height.
    pub pixel_aspect: f32,
    /// Quantization of what displays have none of their own for.
    pub quantization: Quantization,
    /// Metadata for the file, as keys and values.
    pub about: &'a [(String, String)],
}

/// Expose the colours of pixels (`Exposure`): (gain · c)^(1/gamma), of negative ones with their sign.
pub fn expose(pixels: &mut [[f32; 4]], gain: f32, gamma: f32) {
    pixels.par_iter_mut().with_min_len(4096).for_each(|p| {
        for c in &mut p[..3] {
            *c *= gain;
            if gamma != 1.0 {
                *c = c.abs().powf(1.0 / gamma).copysign(*c);
            }
        }
    });
}

impl Image {
    /// A black image without coverage.
    pub fn new(width: usize, height: usize, aovs: Vec<Aov>) -> Image {
        let mut image = Image { width, height, pixels: vec![[0.0; 4]; width * height], aovs, extra: vec![] };
        image.extra.resize(width * height * image.depth(), 0.0);
        image
    }

    /// Count of numbers that the arbitrary output variables have in a pixel.
    pub fn depth(&self) -> usize {
        display::depth(&self.aovs)
    }

    /// Forget all arbitrary output variables but the first `n`.
    pub fn keep_variables(&mut self, n: usize) {
        let depth = self.depth();
        self.aovs.truncate(n);
        let kept = self.depth();
        if kept < depth {
            self.extra = self.extra.chunks_exact(depth).flat_map(|own| &own[..kept]).copied().collect();
        }
    }

    /// Encode the image as the bytes of the one file that these displays share; the first display gives the format. EXR stores
    /// floats, and so does TIFF where the value of 1 and the greatest are 0. An error if no display is given, or if a PNG or TIFF file
    /// would not have 1, 3 or 4 channels.
    pub fn encode(&self, displays: &[&Display], encoding: &Encoding<'_>) -> Result<Vec<u8>, String> {
        let Some(display) = displays.first() else { return Err("no display takes the image".into()) };
        let layers: Vec<Layer> = displays.iter().flat_map(|d| d.layers()).collect();
        let channels = channels(&layers, &self.aovs);
        match display.format() {
            "exr" => self.exr(&channels, displays.iter().all(|d| d.half), encoding),
            kind => {
                let (levels, dither) = display.levels(&encoding.quantization);
                self.plain(kind, &channels, (levels, dither, encoding))
            }
        }
    }

    /// The numbers of an arbitrary output variable, one of the image's own, at the pixel of this index.
    pub fn values(&self, pixel: usize, aov: &Aov) -> &[f32] {
        let first = display::place_of(&self.aovs, &aov.name).unwrap_or_default();
        &self.extra[pixel * self.depth() + first..][..aov.width()]
    }

    /// A number of a pixel, as [`display::Channel`] counts them.
    fn number(&self, pixel: usize, at: usize) -> f32 {
        if at < 4 { self.pixels[pixel][at] } else { self.extra[pixel * self.depth() + at - 4] }
    }

    fn exr(&self, channels: &[Channel], half: bool, encoding: &Encoding<'_>) -> Result<Vec<u8>, String> {
        use exr::prelude::{
            AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, LayerAttributes, LineOrder, Text,
            WritableImage, f16,
        };
        let text = |s: &str| Text::new_or_none(s).unwrap_or_else(|| Text::from("?"));
        let [[x0, y0], [x1, y1]] = encoding.window;
        let (width, height) = (x1 - x0, y1 - y0);
        let list = channels.iter().map(|c| {
            let pixels = (y0..y1).flat_map(|y| (x0..x1).map(move |x| y * self.width + x));
            let values = pixels.map(|p| self.number(p, c.at));
            // What is no colour needs all its digits.
            let colour = matches!(c.name.rsplit('.').next(), Some("R" | "G" | "B" | "A"));
            let samples = if half && colour {
                FlatSamples::F16(values.map(f16::from_f32).collect())
            } else {
                FlatSamples::F32(values.collect())
            };
            AnyChannel::new(text(&c.name), samples)
        });
        // In a fixed order: the same image is the same bytes.
        let about: Vec<String> = encoding.about.iter().map(|(key, value)| format!("{key}={value}")).collect();
        let attributes = LayerAttributes {
            software_name: Some(text(SOFTWARE)),
            comments: Some(text(&about.join(" "))).filter(|_| !about.is_empty()),
            ..LayerAttributes::default()
        };
        let blocks =
            Encoding { compression: Compression::ZIP16, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };
        let layer = exr::image::Layer::new((width, height), attributes, blocks, AnyChannels::sort(list.collect()));
        let mut image = exr::image::Image::from_layer(layer);
        image.attributes.pixel_aspect = encoding.pixel_aspect;
        let mut bytes = std::io::Cursor::new(Vec::new());
        image.write().to_buffered(&mut bytes).map_err(|e| e.to_string())?;
        Ok(bytes.into_inner())
    }

    /// PNG or TIFF.
    fn plain(
        &self,
        kind: &str,
        channels: &[Channel],
        (levels @ [zero, one, min, max], dither, encoding): ([i32; 4], f32, &Encoding<'_>),
    ) -> Result<Vec<u8>, String> {
        let n = channels.len();
        let [[x0, y0], [x1, y1]] = encoding.window;
        let [w, h] = [x1 - x0, y1 - y0].map(|n| n as u32);
        let mut bytes = Vec::new();
        let mut levels_as_tiff = |data: &[u8], color| {
            let goal = std::io::Cursor::new(&mut bytes);
            WholeTiffEncoder::new(goal).write_image(data, w, h, color).map_err(|e| e.to_string())
        };
        if display::stores_floats(kind, levels) {
            let pixels = (y0..y1).flat_map(|y| (x0..x1).map(move |x| y * self.width + x));
            let numbers = pixels.flat_map(|p| channels.iter().map(move |c| self.number(p, c.at)));
            let numbers: Vec<f32> = numbers.collect();
            let mut goal = TiffEncoder::new(std::io::Cursor::new(&mut bytes)).map_err(|e| e.to_string())?;
            let done = match n {
                1 => goal.write_image::<colortype::Gray32Float>(w, h, &numbers),
                3 => goal.write_image::<colortype::RGB32Float>(w, h, &numbers),
                4 => goal.write_image::<colortype::RGBA32Float>(w, h, &numbers),
                _ => return Err(format!("a TIFF file has 1, 3 or 4 channels, not {n}: take EXR")),
            };
            done.map_err(|e| e.to_string())?;
            return Ok(bytes);
        }
        let deep = one.max(max) > 255;
        let most = if deep { 65535 } else { 255 };
        // Of a file that cannot have floats they are bytes.
        let [zero, one, min, max] = if one == 0 && max == 0 { [0, most, 0, most] } else { [zero, one, min, max] };
        let [zero, one, min, max] = [zero, one, min.max(0), max.min(most)].map(|x| x as f32);
        let bits = if kind == "png" { u16::to_be_bytes } else { u16::to_ne_bytes };
        let data = self.quantized(channels, encoding.window, ([zero, one, min, max], dither), deep.then_some(bits));
        let (color, tiff_color) = match (n, deep) {
            (1, false) => (png::ColorType::Grayscale, ExtendedColorType::L8),
            (1, true) => (png::ColorType::Grayscale, ExtendedColorType::L16),
            (3, false) => (png::ColorType::Rgb, ExtendedColorType::Rgb8),
            (3, true) => (png::ColorType::Rgb, ExtendedColorType::Rgb16),
            (4, false) => (png::ColorType::Rgba, ExtendedColorType::Rgba8),
            (4, true) => (png::ColorType::Rgba, ExtendedColorType::Rgba16),
            _ => return Err(format!("a {kind} file has 1, 3 or 4 channels, not {n}: take EXR")),
        };
        if kind == "tiff" {
            levels_as_tiff(&data, tiff_color)?;
            return Ok(bytes);
        }
        let fault = |e: png::EncodingError| e.to_string();
        let mut encoder = png::Encoder::new(&mut bytes, w, h);
        encoder.set_color(color);
        encoder.set_depth(if deep { png::BitDepth::Sixteen } else { png::BitDepth::Eight });
        encoder.set_compression(png::Compression::Fast);
        encoder.add_itxt_chunk("Software".into(), SOFTWARE.into()).map_err(fault)?;
        for (key, value) in encoding.about {
            encoder.add_itxt_chunk(format!("scree:{key}"), value.clone()).map_err(fault)?;
        }
        let mut writer = encoder.write_header().map_err(fault)?;
        writer.write_image_data(&data).map_err(fault)?;
        writer.finish().map_err(fault)?;
        Ok(bytes)
    }

    /// The numbers of the pixels of a window as whole ones, dithered: bytes, or two of each as `bits` has them.
    fn quantized(
        &self,
        channels: &[Channel],
        [[x0, y0], [x1, y1]]: [[usize; 2]; 2],
        ([zero, one, min, max], dither): ([f32; 4], f32),
        bits: Option<fn(u16) -> [u8; 2]>,
    ) -> Vec<u8> {
        let most = max.max(min);
        let each = channels.len() * if bits.is_some() { 2 } else { 1 };
        let row_length = (x1 - x0) * each;
        let mut data = vec![0; row_length * (y1 - y0)];
        let memory = || (vec![0.0; x1 - x0], vec![0.0; x1 - x0]);
        let rows = data.par_chunks_exact_mut(row_length.max(1)).enumerate().with_min_len(8);
        rows.for_each_init(memory, |(noise, row), (k, out)| {
            let y = y0 + k;
            for (c, channel) in channels.iter().enumerate() {
                let pixels = y * self.width + x0..y * self.width + x1;
                // Dither is noise of the pixel's own, the same in every run.
                sl::noise::noise_of_cells(noise, x0 as i32, y as i32, channel.at as i32, 9);
                row.iter_mut().zip(pixels).for_each(|(x, p)| *x = self.number(p, channel.at));
                for (x, noise) in row.iter_mut().zip(&*noise) {
                    let level = zero + *x * (one - zero) + dither * (2.0 * noise - 1.0);
                    // Rounded to the nearest whole number, as what is cut off by the conversion below.
                    *x = level.clamp(min, most) + 0.5;
                }
                let places = out.chunks_exact_mut(each).zip(&*row);
                match bits {
                    Some(bits) => {
                        places.for_each(|(place, x)| place[2 * c..2 * c + 2].copy_from_slice(&bits(*x as u16)))
                    }
                    None => places.for_each(|(place, x)| place[c] = *x as u8),
                }
            }
        });
        data
    }
}

/// The program and its version, as it is written into images.
const SOFTWARE: &str = concat!("scree ", env!("CARGO_PKG_VERSION"));

/// Width and height, pixels, of an image file; `None` if the file cannot be decoded whole.
pub fn decode_size(path: &std::path::Path) -> Option<(u32, u32)> {
    ::image::open(path).ok().map(|i| (i.width(), i.height()))
}
