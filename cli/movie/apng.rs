//! Movies as animated PNGs: without loss, and without any other program.

use super::pixels::{self, Format};
use crate::image_file::read_png;
use crate::progress::Progress;
use crate::report::{Exit, Failure, Outcome};
use png::{BitDepth, ColorType};
use std::path::PathBuf;

/// The bytes of an animated PNG of images. They keep their channels and bits if all have the same, else they become 8-bit colours.
pub fn encode(images: &[PathBuf], format: Format, frame_rate: f64) -> Outcome<Vec<u8>> {
    let fault = |e: png::EncodingError| Failure::new(Exit::Fault, format!("animated PNG: {e}"));
    let Format { width, height, kind } = format;
    let progress = Progress::start("encoding", images.len() as u64, "images");
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    let (color, depth) = kind.unwrap_or((ColorType::Rgb, BitDepth::Eight));
    encoder.set_color(color);
    encoder.set_depth(depth);
    encoder.set_animated(images.len() as u32, 0).map_err(fault)?;
    let [numerator, denominator] = delay(frame_rate);
    encoder.set_frame_delay(numerator, denominator).map_err(fault)?;
    let mut writer = encoder.write_header().map_err(fault)?;
    for (i, path) in images.iter().enumerate() {
        let data = match kind {
            Some(_) => read_png(path)?.data,
            None => pixels::rgb(path, [width, height])?,
        };
        writer.write_image_data(&data).map_err(fault)?;
        progress.at(i as u64 + 1);
    }
    writer.finish().map_err(fault)?;
    progress.finish();
    Ok(bytes)
}

/// The time of an image as numerator and denominator of seconds, exact for whole frame rates.
fn delay(frame_rate: f64) -> [u16; 2] {
    if frame_rate.fract() == 0.0 {
        return [1, frame_rate as u16];
    }
    // The largest denominator whose numerator still fits.
    let denominator =
        [10_000.0, 1000.0, 100.0, 10.0, 1.0].into_iter().find(|d| d / frame_rate < 65_535.0).unwrap_or(1.0);
    [(denominator / frame_rate).round().clamp(1.0, 65_535.0) as u16, denominator as u16]
}

#[cfg(test)]
mod tests {
    use super::delay;

    #[test]
    fn delays_are_as_long_as_the_frame_rate_says() {
        assert_eq!(delay(24.0), [1, 24]);
        assert_eq!(delay(12.5), [800, 10_000]);
        assert_eq!(delay(0.01), [10_000, 100]);
        assert_eq!(delay(1e-9), [65_535, 1]);
    }
}
