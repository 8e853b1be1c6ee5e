//! Images of others, read whole within the memory that reading may take.

use crate::{files, memory};
use exr::prelude::{MetaData, ReadChannels, ReadLayers, read};
use image::{DynamicImage, ImageFormat, ImageReader, Limits};
use std::io::{BufReader, Read, Seek};
use std::path::Path;

/// Most bytes of a decoded image.
const LARGEST: u64 = 4 << 30;

/// Read an image file of any kind that is known by its content. An error, as text, if it cannot be read or may not be, or if it would
/// take more than a quarter of the memory that is left.
pub fn read_image(path: &Path) -> Result<DynamicImage, String> {
    let room = (memory::room() / 4).min(LARGEST);
    let mut reader = reader_of(path, room)?;
    let mut limits = Limits::default();
    limits.max_alloc = Some(room);
    reader.limits(limits);
    reader.decode().map_err(|e| e.to_string())
}

/// A reader of an image file whose tiles find room.
fn reader_of(path: &Path, room: u64) -> Result<ImageReader<BufReader<std::fs::File>>, String> {
    let mut file = BufReader::new(files::open(path).map_err(|e| e.to_string())?);
    check_tiles(&mut file, room)?;
    let reader = ImageReader::new(file).with_guessed_format().map_err(|e| e.to_string())?;
    // The decoder is there for the sake of the encoder of reports; what reads images of others stays as small as it is.
    if reader.format() == Some(ImageFormat::Jpeg) {
        return Err("is a JPEG image, which is not read: expected PNG, TIFF or EXR".into());
    }
    Ok(reader)
}

/// Check that an image file begins as one of any kind that is read: its header, and none of its pixels. An error as [`read_image`]'s.
pub fn check_image(path: &Path) -> Result<(), String> {
    let begins = reader_of(path, (memory::room() / 4).min(LARGEST))?.into_dimensions().map(|_| ());
    begins.or_else(|e| if matches!(read_gray(path), Ok(Some(_))) { Ok(()) } else { Err(e.to_string()) })
}

/// An image of one channel of floats, as depths and heights are written.
pub struct Gray {
    /// Pixels along a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Row by row, from the top; `[width height]`.
    pub values: Vec<f32>,
}

/// Read an image file of one channel of floats, EXR or TIFF; nothing if it is another. An error as [`read_image`]'s.
pub fn read_gray(path: &Path) -> Result<Option<Gray>, String> {
    let room = (memory::room() / 4).min(LARGEST);
    let mut file = BufReader::new(files::open(path).map_err(|e| e.to_string())?);
    let mut magic = [0; 4];
    file.read_exact(&mut magic).and_then(|_| file.rewind()).map_err(|e| e.to_string())?;
    let gray = match &magic {
        [0x76, 0x2f, 0x31, 0x01] => gray_exr(file, room)?,
        b"II*\0" | b"MM\0*" | b"II+\0" | b"MM\0+" => gray_tiff(file, room)?,
        _ => None,
    };
    Ok(gray.filter(|gray| gray.values.len() == gray.width.saturating_mul(gray.height)))
}

/// Check that there is room for an image of floats and what it is decoded from.
fn fits(width: usize, height: usize, room: u64) -> Result<(), String> {
    let bytes = (width as u64).saturating_mul(height as u64).saturating_mul(16);
    if bytes <= room { Ok(()) } else { Err(format!("has {width}×{height} pixels: {}", memory::Full)) }
}

fn gray_exr(mut file: BufReader<std::fs::File>, room: u64) -> Result<Option<Gray>, String> {
    check_tiles(&mut file, room)?;
    let head = MetaData::read_from_buffered(&mut file, false).map_err(|e| e.to_string())?;
    let [header] = &head.headers[..] else { return Ok(None) };
    if header.channels.list.len() != 1 || header.deep {
        return Ok(None);
    }
    let (width, height) = (header.layer_size.width(), header.layer_size.height());
    fits(width, height, room)?;
    file.rewind().map_err(|e| e.to_string())?;
    let layers = read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer().all_attributes();
    let image = layers.from_buffered(file).map_err(|e| e.to_string())?;
    let values =
        image.layer_data.channel_data.list.first().map(|channel| channel.sample_data.values_as_f32().collect());
    Ok(values.map(|values| Gray { width, height, values }))
}

fn gray_tiff(file: BufReader<std::fs::File>, room: u64) -> Result<Option<Gray>, String> {
    use tiff::decoder::{Decoder, DecodingResult, Limits};
    let mut limits = Limits::default();
    limits.decoding_buffer_size = room as usize;
    limits.intermediate_buffer_size = room as usize;
    let mut tiff = Decoder::new(file).map_err(|e| e.to_string())?.with_limits(limits);
    let (width, height) = tiff.dimensions().map_err(|e| e.to_string())?;
    let (width, height) = (width as usize, height as usize);
    if !matches!(tiff.colortype(), Ok(tiff::ColorType::Gray(16 | 32 | 64))) {
        return Ok(None);
    }
    fits(width, height, room)?;
    let values = match tiff.read_image().map_err(|e| e.to_string())? {
        DecodingResult::F16(values) => values.into_iter().map(|x| x.to_f32()).collect(),
        DecodingResult::F32(values) => values,
        DecodingResult::F64(values) => values.into_iter().map(|x| x as f32).collect(),
        _ => return Ok(None),
    };
    Ok(Some(Gray { width, height, values }))
}

/// Check the tiles of an EXR file: the decoder takes memory for whole ones, however small the image is.
fn check_tiles(file: &mut (impl Read + Seek), room: u64) -> Result<(), String> {
    /// Bytes in which the headers of a file stand.
    const HEAD: u64 = 1 << 16;
    /// Name and type of the attribute, and the count of its bytes.
    const TILES: &[u8] = b"tiles\0tiledesc\0\x09\0\0\0";
    /// Bytes of a pixel: four floats.
    const PIXEL: u64 = 16;
    let mut head = vec![];
    file.by_ref().take(HEAD).read_to_end(&mut head).and_then(|_| file.rewind()).map_err(|e| e.to_string())?;
    for (at, _) in head.windows(TILES.len()).enumerate().filter(|(_, bytes)| *bytes == TILES) {
        let side = |k: usize| {
            let bytes = head.get(at + TILES.len() + 4 * k..)?.first_chunk()?;
            Some(u64::from(u32::from_le_bytes(*bytes)))
        };
        let [width, height] = [0, 1].map(|k| side(k).unwrap_or(0));
        if width.saturating_mul(height).saturating_mul(PIXEL) > room {
            return Err(format!("has tiles of {width}×{height} pixels: {}", memory::Full));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_larger_than_the_memory_are_refused() {
        let file = |width: u32, height: u32| {
            let sides = [width.to_le_bytes(), height.to_le_bytes()].concat();
            std::io::Cursor::new([b"v/1\x01....tiles\0tiledesc\0\x09\0\0\0", &sides[..], b"\0"].concat())
        };
        assert!(check_tiles(&mut file(64, 64), 1 << 20).is_ok());
        assert!(check_tiles(&mut file(64, u32::MAX), 1 << 20).unwrap_err().contains("tiles of 64×4294967295"));
        assert!(check_tiles(&mut file(u32::MAX, u32::MAX), 1 << 40).is_err());
        assert!(check_tiles(&mut std::io::Cursor::new(b"tiles\0tiledesc\0\x09\0\0\0"), 1).is_ok());
    }
}
