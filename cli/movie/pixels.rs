//! Pixels of the images of a movie: 8-bit red, green and blue, whatever kind of PNG they are read from.
//!
//! 16 bits are rounded to 8, grey is all three colours, and alpha is left out: scree's images are premultiplied, as RenderMan's are,
//! so that what is left is the image over black.

use crate::image_file::{decode_png, read_png};
use frame::Fault;
use png::{BitDepth, ColorType, Transformations};
use std::path::Path;

/// The format of an image, or what many have in common.
#[derive(Clone, Copy, Debug)]
pub struct Format {
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// Channels and bits per channel, where all are alike and have no palette.
    pub kind: Option<(ColorType, BitDepth)>,
}

/// The format of an image, which is decoded whole: a truncated one is a fault.
pub fn format(path: &Path) -> Result<Format, Fault> {
    let png = read_png(path)?;
    let has_bytes = matches!(png.kind.1, BitDepth::Eight | BitDepth::Sixteen);
    Ok(Format { width: png.width, height: png.height, kind: (png.is_plain && has_bytes).then_some(png.kind) })
}

/// The pixels of an image as 8-bit red, green and blue, rows from the top, in an image of `size`, which may be larger: its right and
/// lower edges are repeated.
pub fn rgb(path: &Path, [width, height]: [u32; 2]) -> Result<Vec<u8>, Fault> {
    let png = decode_png(path, Transformations::EXPAND)?;
    let bytes_per_value = if png.kind.1 == BitDepth::Sixteen { 2 } else { 1 };
    let value = |at: usize| match bytes_per_value {
        1 => png.data[at],
        _ => ((u32::from(png.data[at]) * 256 + u32::from(png.data[at + 1]) + 128) / 257) as u8,
    };
    let n_channels = png.kind.0.samples();
    let has_color = n_channels >= 3;
    let mut out = Vec::with_capacity(width as usize * height as usize * 3);
    for y in (0..height).map(|y| y.min(png.height - 1) as usize) {
        for x in (0..width).map(|x| x.min(png.width - 1) as usize) {
            let at = (y * png.width as usize + x) * n_channels * bytes_per_value;
            let channel = |c: usize| value(at + if has_color { c * bytes_per_value } else { 0 });
            out.extend([channel(0), channel(1), channel(2)]);
        }
    }
    Ok(out)
}
