//! Image files: reading PNGs whole, and whether the file of an image is complete.

use frame::{Fault, FaultKind};
use png::{BitDepth, ColorType, Transformations};
use std::io::Read;
use std::path::Path;

/// A decoded PNG.
pub struct Png {
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// Channels and bits per channel of the data.
    pub kind: (ColorType, BitDepth),
    /// Whether the data is all that tells the colours: there is no palette, and no colour that is transparent.
    pub is_plain: bool,
    /// Rows of pixels from the top.
    pub data: Vec<u8>,
}

/// Read a PNG whole, its pixels as they are stored; a truncated one is a fault.
pub fn read_png(path: &Path) -> Result<Png, Fault> {
    decode_png(path, Transformations::IDENTITY)
}

/// Read a PNG whole, its pixels transformed; a truncated one is a fault.
pub fn decode_png(path: &Path, transformations: Transformations) -> Result<Png, Fault> {
    let truncated = |e: png::DecodingError| Fault::whole(FaultKind::Data, path, format!("is not a complete PNG: {e}"));
    let file = guard::open(path).map_err(|e| Fault::unreadable(FaultKind::Data, path, &e))?;
    let mut decoder = png::Decoder::new(std::io::BufReader::new(file));
    decoder.set_transformations(transformations);
    let mut reader = decoder.read_info().map_err(truncated)?;
    let is_plain = reader.info().palette.is_none() && reader.info().trns.is_none();
    let size = reader.output_buffer_size().filter(|size| *size as u64 <= guard::memory::room());
    let [width, height] = [reader.info().width, reader.info().height];
    let size = size.ok_or_else(|| {
        Fault::whole(FaultKind::Data, path, format!("has {width}×{height} pixels: {}", guard::memory::Full))
    })?;
    let mut data = vec![0; size];
    let info = reader.next_frame(&mut data).map_err(truncated)?;
    Ok(Png { width: info.width, height: info.height, kind: (info.color_type, info.bit_depth), is_plain, data })
}

/// An error if a file is there that is no image: images whose names come from files of others take no other file's place.
pub fn spare_others(path: &Path) -> Result<(), Fault> {
    let mut start = Vec::new();
    let is_file = match path.metadata() {
        Ok(there) if !there.is_dir() => there.is_file(),
        _ => return Ok(()),
    };
    if is_file && let Ok(file) = std::fs::File::open(path) {
        let _ = file.take(8).read_to_end(&mut start);
    }
    let is_image = |magic: &&[u8]| start.starts_with(magic);
    let magics: [&[u8]; 4] = [b"\x89PNG", b"\x76\x2f\x31\x01", b"II*\0", b"MM\0*"];
    if (is_file && start.is_empty()) || magics.iter().any(is_image) {
        return Ok(());
    }
    let fault =
        Fault::whole(FaultKind::Input, path, "is a file that is no image: an image is not written in its place");
    Err(fault.hint("remove it, or write to another folder, -o DIR (--output)"))
}
