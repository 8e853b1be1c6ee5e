//! Images of others, read whole within the memory that reading may take.

use crate::{files, memory};
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
    reader_of(path, (memory::room() / 4).min(LARGEST))?.into_dimensions().map(|_| ()).map_err(|e| e.to_string())
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
