//! Pixels of the images of a movie: 8-bit red, green and blue, whatever kind of PNG they are read from.
//!
//! 16 bits are rounded to 8, grey is all three colours, and alpha is left out: scree's images are premultiplied, as RenderMan's are,
//! so that what is left is the image over black.

use frame::{Fault, FaultKind};
use png::{BitDepth, ColorType, Transformations};
use std::fs::File;
use std::io::BufReader;
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
    let (mut reader, _) = open(path, Transformations::IDENTITY)?;
    let info = reader.info();
    let plain =
        info.palette.is_none() && info.trns.is_none() && matches!(info.bit_depth, BitDepth::Eight | BitDepth::Sixteen);
    let kind = plain.then_some((info.color_type, info.bit_depth));
    let (width, height) = (info.width, info.height);
    while reader.next_row().map_err(|e| truncated(path, e))?.is_some() {}
    Ok(Format { width, height, kind })
}

/// The pixels of an image as 8-bit red, green and blue, rows from the top, in an image of `size`, which may be larger: its right and
/// lower edges are repeated.
pub fn rgb(path: &Path, [width, height]: [u32; 2]) -> Result<Vec<u8>, Fault> {
    let (mut reader, mut data) = open(path, Transformations::EXPAND)?;
    let info = reader.next_frame(&mut data).map_err(|e| truncated(path, e))?;
    let bytes_per_value = if info.bit_depth == BitDepth::Sixteen { 2 } else { 1 };
    let value = |at: usize| match bytes_per_value {
        1 => data[at],
        _ => ((u32::from(data[at]) * 256 + u32::from(data[at + 1]) + 128) / 257) as u8,
    };
    let n_channels = info.color_type.samples();
    let has_color = n_channels >= 3;
    let mut out = Vec::with_capacity(width as usize * height as usize * 3);
    for y in (0..height).map(|y| y.min(info.height - 1) as usize) {
        for x in (0..width).map(|x| x.min(info.width - 1) as usize) {
            let at = (y * info.width as usize + x) * n_channels * bytes_per_value;
            let channel = |c: usize| value(at + if has_color { c * bytes_per_value } else { 0 });
            out.extend([channel(0), channel(1), channel(2)]);
        }
    }
    Ok(out)
}

/// A PNG's reader, and memory for its pixels.
fn open(path: &Path, transformations: Transformations) -> Result<(png::Reader<BufReader<File>>, Vec<u8>), Fault> {
    let file = File::open(path).map_err(|e| Fault::unreadable(FaultKind::Data, path, &e))?;
    let mut decoder = png::Decoder::new(BufReader::new(file));
    decoder.set_transformations(transformations);
    let reader = decoder.read_info().map_err(|e| truncated(path, e))?;
    let data = vec![0; reader.output_buffer_size().unwrap_or(0)];
    Ok((reader, data))
}

fn truncated(path: &Path, e: png::DecodingError) -> Fault {
    Fault::whole(FaultKind::Data, path, format!("is not a complete PNG: {e}"))
}
