//! Shard files: the buckets of one shard of an image, as `scree render --bucket I/N` writes them beside the image's place, in
//! NAME.part-I-of-N.
//!
//! A shard file is a line of JSON and the pixels of its buckets: four floats (RGBA) and those of the image's other variables for
//! each pixel, bucket after bucket, rows from the top. The line has a hash of itself and the pixels: a truncated or changed file is an
//! error, never a hole in an image.

use crate::report::{Exit, Failure, Outcome};
use frame::{Fault, FaultKind};
use render::film::bucket::{Shard, buckets};
use render::film::display;
use render::film::image::{self, Image};
use render::{Display, Options, RenderResult};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Version of the format.
const VERSION: u32 = 4;
/// Most shards of an image.
const MOST_PARTS: usize = 1_000_000;

/// The first line of a shard file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Header {
    /// Version of the format.
    scree_part: u32,
    /// Index of the shard, from 1.
    part: usize,
    /// Number of shards.
    parts: usize,
    /// Width of the whole image, pixels.
    width: usize,
    /// Height of the whole image, pixels.
    height: usize,
    /// Side of a bucket, pixels.
    bucket: usize,
    /// Displays that the image's file is written for.
    displays: Vec<Display>,
    /// Names and values written into the image's file.
    about: Vec<(String, String)>,
    /// Width of a pixel over its height.
    pixel_aspect: f32,
    /// Quantised value of 1.
    one: i32,
    /// Least and greatest quantised value.
    range: [i32; 2],
    /// Amplitude of the dither.
    dither: f32,
    /// Levels of depths that are alone in a file, and their dither.
    depth_levels: ([i32; 4], f32),
    /// Crop window: left, right, top and bottom, as fractions of the image.
    crop: [f32; 4],
    /// blake3 hash of this header, in which it is empty, and of the pixels, hexadecimal.
    hash: String,
}

/// The path of a shard file of an image.
pub fn path_of(image: &Path, shard: Shard) -> PathBuf {
    let name = image.file_name().unwrap_or_default().to_string_lossy();
    image.with_file_name(format!("{name}.part-{}-of-{}", shard.part, shard.parts))
}

/// The image and the shard of a shard file's path; none for other paths.
pub fn parse_path(path: &Path) -> Option<(PathBuf, Shard)> {
    let (image, shard) = path.file_name()?.to_str()?.rsplit_once(".part-")?;
    let (part, parts) = shard.split_once("-of-")?;
    let shard = Shard { part: part.parse().ok()?, parts: parts.parse().ok()? };
    let is_sound = (1..=shard.parts).contains(&shard.part) && path_of(&path.with_file_name(image), shard) == path;
    (is_sound && shard.parts <= MOST_PARTS).then(|| (path.with_file_name(image), shard))
}

/// Write a shard of an image.
pub fn write(result: &RenderResult, displays: &[&Display], image_path: &Path, shard: Shard) -> Outcome {
    let (image, options) = (&result.image, &result.options);
    let displays: Vec<Display> = displays.iter().map(|d| (*d).clone()).collect();
    let aovs = display::aovs(&displays);
    let mut pixels = Vec::new();
    for bucket in buckets(image.width, image.height, options.bucket_size, Some(shard)) {
        for y in bucket.y..bucket.y + bucket.height {
            for pixel in (0..bucket.width).map(|x| y * image.width + bucket.x + x) {
                let extra = aovs.iter().flat_map(|aov| image.values(pixel, aov));
                pixels.extend(image.pixels[pixel].iter().chain(extra).flat_map(|x| x.to_le_bytes()));
            }
        }
    }
    let mut header = Header {
        scree_part: VERSION,
        part: shard.part,
        parts: shard.parts,
        width: image.width,
        height: image.height,
        bucket: options.bucket_size,
        displays,
        about: options.about.clone(),
        pixel_aspect: options.pixel_aspect,
        one: options.quantize_one,
        range: options.quantize_range,
        dither: options.dither,
        depth_levels: options.quantize_depth,
        crop: options.crop,
        hash: String::new(),
    };
    header.hash = header.hash_with(&pixels);
    let mut bytes = serde_json::to_vec(&header).map_err(|e| Failure::new(Exit::Fault, e.to_string()))?;
    bytes.push(b'\n');
    bytes.extend(pixels);
    Ok(frame::atomic::write(&path_of(image_path, shard), &bytes)?)
}

/// Read a shard file: its header, and its pixels as bytes.
pub fn read(path: &Path) -> Result<(Header, Vec<u8>), Fault> {
    let mut bytes = frame::read_bytes(FaultKind::Data, path)?;
    let fault = |message: &str| Fault::whole(FaultKind::Data, path, message).hint("render this shard again");
    let end = bytes.iter().position(|b| *b == b'\n').ok_or_else(|| fault("is not a shard file"))?;
    let header: Header =
        serde_json::from_slice(&bytes[..end]).map_err(|e| fault(&format!("is not a shard file: {e}")))?;
    let pixels = bytes.split_off(end + 1);
    let sides = [header.width, header.height, header.bucket];
    let valid = header.scree_part == VERSION
        && (1..=header.parts).contains(&header.part)
        && sides.iter().all(|n| (1..=image::LONGEST_SIDE).contains(n));
    if !valid {
        return Err(fault("has a header that describes no image, or was written by another version"));
    }
    if header.hash_with(&pixels) != header.hash {
        return Err(fault("is truncated or changed: it is not what was written"));
    }
    let shard = Shard { part: header.part, parts: header.parts };
    let tiles = buckets(header.width, header.height, header.bucket, Some(shard));
    let n_pixels: usize = tiles.map(|b| b.width * b.height).sum();
    let n_values = 4 + display::depth(&display::aovs(&header.displays));
    if pixels.len() != 4 * n_values * n_pixels {
        return Err(fault("has fewer or more pixels than its shard"));
    }
    if (4 * n_values * header.width * header.height) as u64 > guard::memory::room() {
        let message = format!("is of {}×{} pixels: {}", header.width, header.height, guard::memory::Full);
        return Err(Fault::whole(FaultKind::Data, path, message));
    }
    Ok((header, pixels))
}

impl Header {
    /// The hash of the header and these pixels.
    fn hash_with(&self, pixels: &[u8]) -> String {
        let own = Header { hash: String::new(), ..self.clone() };
        let mut hasher = blake3::Hasher::new();
        hasher.update(&serde_json::to_vec(&own).unwrap_or_default()).update(pixels);
        hasher.finalize().to_hex().to_string()
    }

    /// An empty image of the header's size and variables.
    pub fn image(&self) -> Image {
        Image::new(self.width, self.height, display::aovs(&self.displays))
    }

    /// Whether a header is of another shard of the same image.
    pub fn is_alike(&self, other: &Header) -> bool {
        Header { part: other.part, hash: other.hash.clone(), ..self.clone() } == *other
    }

    /// Copy the pixels of a shard into the image.
    pub fn copy_pixels(&self, pixels: &[u8], image: &mut Image) {
        let mut values = pixels.chunks_exact(4).map(|b| f32::from_le_bytes(b.try_into().expect("four bytes")));
        let shard = Shard { part: self.part, parts: self.parts };
        for bucket in buckets(self.width, self.height, self.bucket, Some(shard)) {
            for y in bucket.y..bucket.y + bucket.height {
                let (depth, first) = (image.depth(), y * self.width + bucket.x);
                for pixel in first..first + bucket.width {
                    let extra = &mut image.extra[pixel * depth..][..depth];
                    image.pixels[pixel].iter_mut().chain(extra).for_each(|x| *x = values.next().unwrap_or(0.0));
                }
            }
        }
    }

    /// Encode the whole image as its displays say.
    pub fn encode(&self, image: &Image) -> Result<Vec<u8>, String> {
        let options = Options {
            width: self.width,
            height: self.height,
            quantize_one: self.one,
            quantize_range: self.range,
            dither: self.dither,
            quantize_depth: self.depth_levels,
            crop: self.crop,
            about: self.about.clone(),
            pixel_aspect: self.pixel_aspect,
            ..Options::default()
        };
        image.encode(&self.displays.iter().collect::<Vec<_>>(), &options.encoding())
    }
}
