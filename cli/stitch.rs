//! Shares of pictures: `scree render --bucket I/N` writes the buckets of one share to a part file, `scree stitch` joins parts to
//! exactly the pictures that one run makes.
//!
//! A part file is a line of JSON and the pixels of its buckets, four floats and those of its other variables each, bucket after
//! bucket, rows from the top. The line
//! has a hash of the pixels: a torn or changed file is an error, never a hole in a picture.

use crate::args::StitchArgs;
use crate::report::{Exit, Failure, Outcome};
use frame::{Fault, FaultKind};
use render::film::bucket::{Shard, buckets};
use render::film::display;
use render::film::image::Image;
use render::{Display, Options, RenderResult};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The first line of a part file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Head {
    /// The format's number.
    scree_part: u32,
    /// This one, from 1, and how many there are.
    part: usize,
    parts: usize,
    /// Of the whole picture and of a bucket, pixels.
    width: usize,
    height: usize,
    bucket: usize,
    /// How the picture is written: the displays of its file, and what goes into it besides.
    displays: Vec<Display>,
    about: Vec<(String, String)>,
    pixel_aspect: f32,
    one: i32,
    dither: f32,
    crop: [f32; 4],
    /// blake3 of the pixels, hexadecimal.
    hash: String,
}

/// The part file of a picture.
pub fn part_of(picture: &Path, share: Shard) -> PathBuf {
    let name = picture.file_name().unwrap_or_default().to_string_lossy();
    picture.with_file_name(format!("{name}.part-{}-of-{}", share.part, share.parts))
}

/// Write a share of a picture as its part file.
pub fn write_part(finished: &RenderResult, displays: &[&Display], picture: &Path, share: Shard) -> Outcome {
    let (image, options) = (&finished.image, &finished.options);
    let displays: Vec<Display> = displays.iter().map(|d| (*d).clone()).collect();
    let own = display::aovs(&displays);
    let mut pixels = Vec::new();
    for tile in buckets(image.width, image.height, options.bucket_size, Some(share)) {
        for y in tile.y..tile.y + tile.height {
            for at in (0..tile.width).map(|x| y * image.width + tile.x + x) {
                let extra = own.iter().flat_map(|aov| image.values(at, aov));
                pixels.extend(image.pixels[at].iter().chain(extra).flat_map(|x| x.to_le_bytes()));
            }
        }
    }
    let head = Head {
        scree_part: 1,
        part: share.part,
        parts: share.parts,
        width: image.width,
        height: image.height,
        bucket: options.bucket_size,
        displays,
        about: options.about.clone(),
        pixel_aspect: options.pixel_aspect,
        one: options.quantize_one,
        dither: options.dither,
        crop: options.crop,
        hash: blake3::hash(&pixels).to_hex().to_string(),
    };
    let mut bytes = serde_json::to_vec(&head).map_err(|e| Failure::new(Exit::Fault, e.to_string()))?;
    bytes.push(b'\n');
    bytes.extend(pixels);
    Ok(frame::atomic::write(&part_of(picture, share), &bytes)?)
}

/// Whether the part of a picture is there and whole.
pub fn is_part(picture: &Path, share: Shard, [width, height]: [u32; 2]) -> bool {
    read(&part_of(picture, share)).is_ok_and(|(head, _)| (head.width, head.height) == (width as usize, height as usize))
}

fn read(path: &Path) -> Result<(Head, Vec<u8>), Fault> {
    let mut bytes = frame::read_bytes(FaultKind::Data, path)?;
    let fault = |message: &str| Fault::whole(FaultKind::Data, path, message).hint("render this part again");
    let end = bytes.iter().position(|b| *b == b'\n').ok_or_else(|| fault("is no part of a picture"))?;
    let head: Head =
        serde_json::from_slice(&bytes[..end]).map_err(|e| fault(&format!("is no part of a picture: {e}")))?;
    let pixels = bytes.split_off(end + 1);
    let sound = head.scree_part == 1
        && (1..=head.parts).contains(&head.part)
        && head.bucket > 0
        && head.width.checked_mul(head.height).is_some_and(|n| n <= 1 << 32);
    if !sound {
        return Err(fault("has numbers that make no picture"));
    }
    if blake3::hash(&pixels).to_hex().as_str() != head.hash {
        return Err(fault("is torn: its pixels are not those that were written"));
    }
    let share = Shard { part: head.part, parts: head.parts };
    let count: usize = buckets(head.width, head.height, head.bucket, Some(share)).map(|t| t.width * t.height).sum();
    let numbers = 4 + display::depth(&display::aovs(&head.displays));
    if pixels.len() != 4 * numbers * count {
        return Err(fault("has not as many pixels as its share"));
    }
    Ok((head, pixels))
}

/// The command: join the parts in a folder.
pub fn command(args: &StitchArgs) -> Outcome {
    let entries = std::fs::read_dir(&args.folder).map_err(|e| Fault::unreadable(FaultKind::Data, &args.folder, &e))?;
    let mut pictures: BTreeMap<PathBuf, BTreeMap<usize, Vec<usize>>> = BTreeMap::new();
    for entry in entries {
        let path = entry.map_err(|e| Fault::unreadable(FaultKind::Data, &args.folder, &e))?.path();
        let name = path.file_name().and_then(|n| n.to_str()).unwrap_or_default();
        let Some((picture, share)) = name.rsplit_once(".part-") else { continue };
        let numbers = share.split_once("-of-").and_then(|(a, b)| Some((a.parse().ok()?, b.parse().ok()?)));
        if let Some((part, parts)) = numbers {
            pictures.entry(args.folder.join(picture)).or_default().entry(parts).or_default().push(part);
        }
    }
    if pictures.is_empty() {
        return Err(Failure::new(Exit::Data, format!("there are no parts of pictures in {}", args.folder.display())));
    }
    let mut missing = Vec::new();
    for (picture, counts) in &pictures {
        if counts.len() > 1 {
            let message = format!("has parts of different shares: {:?}", counts.keys().collect::<Vec<_>>());
            let fault = Fault::whole(FaultKind::Data, picture, message);
            return Err(fault.hint("remove those of the share that is not wanted").into());
        }
        let (parts, found) = counts.iter().next().expect("a picture is listed with its parts");
        let absent: Vec<String> = (1..=*parts).filter(|p| !found.contains(p)).map(|p| p.to_string()).collect();
        if absent.is_empty() {
            join(picture, *parts, args.keep)?;
            println!("{}", picture.display());
        } else {
            missing.push(format!("{}: part {} of {parts}", picture.display(), absent.join(", ")));
        }
    }
    if missing.is_empty() {
        return Ok(());
    }
    Err(Failure::new(Exit::Partial, format!("parts are missing:\n  {}", missing.join("\n  "))))
}

/// Join the parts of a picture, write it, and remove them.
fn join(picture: &Path, parts: usize, keep: bool) -> Outcome {
    let path = |part: usize| part_of(picture, Shard { part, parts });
    let mut first: Option<Head> = None;
    let mut image = Image::new(0, 0, vec![]);
    for part in 1..=parts {
        let (head, pixels) = read(&path(part))?;
        let first = first.get_or_insert_with(|| {
            image = Image::new(head.width, head.height, display::aovs(&head.displays));
            head.clone()
        });
        if (Head { part, hash: head.hash.clone(), ..first.clone() }) != head {
            let message = "is of another picture than part 1: size, samples or display differ";
            return Err(Fault::whole(FaultKind::Data, &path(part), message).hint("render all parts alike").into());
        }
        let mut numbers = pixels.chunks_exact(4).map(|b| f32::from_le_bytes(b.try_into().expect("four bytes")));
        for tile in buckets(head.width, head.height, head.bucket, Some(Shard { part, parts })) {
            for y in tile.y..tile.y + tile.height {
                let (depth, from) = (image.depth(), y * head.width + tile.x);
                for at in from..from + tile.width {
                    let extra = &mut image.extra[at * depth..][..depth];
                    image.pixels[at].iter_mut().chain(extra).for_each(|x| *x = numbers.next().unwrap_or(0.0));
                }
            }
        }
    }
    let Some(head) = first else { return Ok(()) };
    let options = Options {
        width: head.width,
        height: head.height,
        quantize_one: head.one,
        dither: head.dither,
        crop: head.crop,
        about: head.about,
        pixel_aspect: head.pixel_aspect,
        ..Options::default()
    };
    let bytes = image.encode(&head.displays.iter().collect::<Vec<_>>(), &options.encoding());
    frame::atomic::write(picture, &bytes.map_err(|m| Failure::new(Exit::Fault, m))?)?;
    if !keep {
        for part in 1..=parts {
            std::fs::remove_file(path(part)).map_err(|e| Fault::unwritable(&path(part), &e))?;
        }
    }
    Ok(())
}
