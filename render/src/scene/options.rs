//! Options of the whole image (RISpec section 4).

use crate::film::bucket::Shard;
use crate::film::display::{Display, Quantization};
use crate::film::filter::FilterKind;
use crate::film::image::Encoding;
use crate::texture::texels;
use glam::Vec4;
use sl::machine::BoundShader;
use std::sync::Arc;

/// Hider (RISpec 4.1.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hider {
    /// All samples, lights and layers.
    Hidden,
    /// One sample in the middle of a pixel, and nothing blurred: for depth.
    Depth,
    /// No image is rendered.
    Null,
}

/// Options of the image, fixed at `WorldBegin` (RISpec section 4).
#[derive(Clone)]
pub struct Options {
    /// Width of the whole image, pixels.
    pub width: usize,
    /// Height of the whole image, pixels.
    pub height: usize,
    /// Width and height that `Format` asks for, pixels; the image is the largest of the frame's aspect ratio within.
    pub format: [usize; 2],
    /// Pixel aspect ratio: width of a pixel over its height.
    pub pixel_aspect: f32,
    /// Aspect ratio of the frame (`FrameAspectRatio`), if given; else that of the format.
    pub frame_aspect: Option<f32>,
    /// Left, right, bottom and top of the screen window (`ScreenWindow`), screen space; from the aspect ratio of the frame if not
    /// given. What runs from right to left, or from top to bottom, mirrors the image.
    pub screen_window: Option<[f32; 4]>,
    /// What the transformation before `Projection` does to screen space: factors of x and y, and a shift (RISpec 4.1.1).
    pub screen: [[f32; 2]; 2],
    /// Whether there was a `Projection`.
    pub projected: bool,
    /// Full angle of view, degrees, of a perspective projection; `None` is orthographic.
    pub fov: Option<f32>,
    /// Distances of the near and far clipping planes, camera space.
    pub clipping: [f32; 2],
    /// No planes were given: what is nearer than the near one is seen all the same, which then is that of depths and spaces alone.
    pub sees_near: bool,
    /// User clipping planes, camera space: a normal and a number; what has a product below −that number is kept (RISpec 4.1.1).
    pub clipping_planes: Vec<Vec4>,
    /// Times at which the shutter opens and closes, in the unit of motion blocks' times.
    pub shutter: [f32; 2],
    /// f-stop, focal length and focal distance (`DepthOfField`), lengths in camera space; `None` is a pinhole.
    pub lens: Option<[f32; 3]>,
    /// Count of samples along x and y of a pixel.
    pub samples: [usize; 2],
    /// Pixel filter.
    pub filter: FilterKind,
    /// Widths of the pixel filter along x and y, pixels.
    pub filter_width: [f32; 2],
    /// Gain of the exposure.
    pub gain: f32,
    /// Gamma of the exposure.
    pub gamma: f32,
    /// Maximum quantized value (`one` of `Quantize`): 255 for 8 bits, 65535 for 16, 0 for floats.
    pub quantize_one: i32,
    /// Least and greatest quantized value.
    pub quantize_range: [i32; 2],
    /// Amplitude of the dither, quantization steps.
    pub dither: f32,
    /// Quantization and dither of depths that are alone in a file (`Quantize "z"`), as [`Display::levels`] has them.
    pub quantize_depth: ([i32; 4], f32),
    /// Displays.
    pub displays: Vec<Display>,
    /// An unsupported display was named: without another, nothing is rendered.
    pub unsupported_display: bool,
    /// Edge of a bucket, pixels.
    pub bucket_size: usize,
    /// Crop window, the part of the image that is rendered and written: left, right, top and bottom as fractions, 0 to 1, of its
    /// width and height.
    pub crop: [f32; 4],
    /// The shard to render; all buckets if not given.
    pub shard: Option<Shard>,
    /// Memory limit of textures, bytes; tiles beyond it are read from files as they are needed.
    pub texture_memory: usize,
    /// Whether textures of whole numbers are encoded for screens; if not given, as they say themselves, and else they are linear.
    pub texture_encoded: Option<bool>,
    /// Factor on all levels of detail (`RelativeDetail`).
    pub relative_detail: f32,
    /// Hider: the hidden-surface algorithm (RISpec 4.1.3).
    pub hider: Hider,
    /// Metadata for the image files, as keys and values.
    pub about: Vec<(String, String)>,
    /// Imager shader, if any.
    pub imager: Option<Arc<BoundShader>>,
    /// Whether the identities of what samples see are kept, for comparisons.
    pub keep_ids: bool,
}

impl Default for Options {
    fn default() -> Options {
        Options {
            width: 640,
            height: 480,
            format: [640, 480],
            pixel_aspect: 1.0,
            frame_aspect: None,
            screen_window: None,
            screen: [[1.0; 2], [0.0; 2]],
            projected: false,
            fov: None,
            clipping: [1e-3, 1e30],
            sees_near: true,
            clipping_planes: vec![],
            shutter: [0.0, 0.0],
            lens: None,
            samples: [2, 2],
            filter: FilterKind::Gaussian,
            filter_width: [2.0, 2.0],
            gain: 1.0,
            gamma: 1.0,
            quantize_one: 255,
            quantize_range: [0, 255],
            quantize_depth: ([0; 4], 0.0),
            dither: 0.5,
            displays: vec![],
            unsupported_display: false,
            bucket_size: 64,
            crop: [0.0, 1.0, 0.0, 1.0],
            shard: None,
            texture_memory: texels::MEMORY,
            texture_encoded: None,
            relative_detail: 1.0,
            hider: Hider::Hidden,
            about: vec![],
            imager: None,
            keep_ids: false,
        }
    }
}

impl Options {
    /// Aspect ratio of the frame: of what the image shows, not of its pixels.
    pub fn aspect(&self) -> f32 {
        self.frame_aspect.unwrap_or(self.format[0] as f32 * self.pixel_aspect / self.format[1] as f32)
    }

    /// Make the image the largest of the frame's aspect ratio that fits into the format (RISpec 4.1.1).
    pub fn fit_frame(&mut self) {
        let [width, height] = self.format.map(|n| n as f32);
        let (pixel, frame) = (self.pixel_aspect, self.aspect());
        let side = |n: f32, most: usize| (n.round() as usize).clamp(1, most);
        (self.width, self.height) = if frame * height >= width * pixel {
            (self.format[0], side(width * pixel / frame, self.format[1]))
        } else {
            (side(height * frame / pixel, self.format[0]), self.format[1])
        };
    }

    /// The pixels inside the crop window (RISpec 4.1.1): `[[x0, y0], [x1, y1]]`, the first pixel and one past the last.
    pub fn window(&self) -> [[usize; 2]; 2] {
        let range = |n: usize, lo: f32, hi: f32| {
            let pixel = |part: f32| ((n as f32 * part).ceil().max(0.0) as usize).min(n);
            let first = pixel(lo).min(n - 1);
            [first, pixel(hi).max(first + 1)]
        };
        let ([x0, x1], [y0, y1]) =
            (range(self.width, self.crop[0], self.crop[1]), range(self.height, self.crop[2], self.crop[3]));
        [[x0, y0], [x1, y1]]
    }

    /// Quantization and dither of colours and of depths.
    pub fn quantization(&self) -> Quantization {
        let [min, max] = self.quantize_range;
        Quantization { colors: ([0, self.quantize_one, min, max], self.dither), depths: self.quantize_depth }
    }

    /// The settings with which the image is encoded to files.
    pub fn encoding(&self) -> Encoding<'_> {
        Encoding {
            window: self.window(),
            pixel_aspect: self.pixel_aspect,
            quantization: self.quantization(),
            about: &self.about,
        }
    }
}
