//! Films and images of a page: within it as `data:` addresses, or linked by a path that is relative to it.

use super::number;
use super::view::{Film, Image, Link};
use crate::report::{Exit, Failure, Outcome};
use guard::text::html::address;
use image::codecs::jpeg::JpegEncoder;
use image::{DynamicImage, GenericImageView};
use std::ffi::OsStr;
use std::path::{Component, Path, PathBuf};

/// Quality of the JPEG images of a page, of 100.
const QUALITY: u8 = 84;

/// The film of a run, within the page if it is not larger than `limit`, bytes. Players know no Matroska: such a film is linked.
pub fn film(path: &Path, output: &Path, limit: u64) -> Outcome<Film> {
    let fail = |e: std::io::Error| Failure::new(Exit::Data, format!("{}: {e}", path.display()));
    let name = name_of(path);
    let ending = path.extension().and_then(OsStr::to_str).unwrap_or("").to_lowercase();
    // Players take QuickTime files of H.264 for MP4, and some refuse them by their own name.
    let (tag, kind) = match ending.as_str() {
        "mp4" | "mov" => ("video", "video/mp4"),
        "webm" => ("video", "video/webm"),
        "gif" => ("image", "image/gif"),
        "apng" => ("image", "image/apng"),
        _ => ("link", ""),
    };
    let bytes = path.metadata().map_err(fail)?.len();
    let size = number::size(bytes);
    let link = relative(path, output);
    if bytes > limit || tag == "link" {
        let tag = if link.is_some() { tag } else { "none" }.to_string();
        let why = if bytes > limit { format!("larger than {}", number::size(limit)) } else { "Matroska".into() };
        let note =
            format!("{name}, {size}: linked, since it is {why}; it plays where page and film stay where they are.");
        return Ok(Film { tag, source: link.unwrap_or_default(), name, note });
    }
    let content = guard::read(path).map_err(fail)?;
    let note = format!("{name}, {size}: embedded in this page.");
    Ok(Film { tag: tag.into(), source: data(kind, &content), name, note })
}

/// A link to a file.
pub fn link(path: &Path, output: &Path) -> Option<Link> {
    Some(Link { name: name_of(path), address: relative(path, output)? })
}

/// An image, not wider than `width` pixels, as JPEG within the page.
pub fn image(path: &Path, caption: String, width: u32, output: &Path) -> Outcome<Image> {
    let fail = |e: String| Failure::new(Exit::Data, format!("{}: {e}", path.display()));
    let whole = guard::read_image(path).map_err(fail)?;
    let [w, h] = [whole.width(), whole.height()];
    let small = if w > width { whole.thumbnail(width, u32::MAX / 2) } else { whole };
    // Images are premultiplied: without alpha this is the image over black.
    let small = DynamicImage::ImageRgb8(small.to_rgb8());
    let mut bytes = vec![];
    JpegEncoder::new_with_quality(&mut bytes, QUALITY).encode_image(&small).map_err(|e| fail(e.to_string()))?;
    let (shown_width, shown_height) = small.dimensions();
    Ok(Image {
        source: data("image/jpeg", &bytes),
        address: relative(path, output),
        title: format!("{}, {w} × {h} pixels", name_of(path)),
        caption,
        width: shown_width,
        height: shown_height,
    })
}

/// Images at even distances: the first, the last, and those between them.
pub fn some<T>(all: &[T], n: usize) -> Vec<&T> {
    match n.min(all.len()) {
        0 => vec![],
        1 => vec![&all[all.len() - 1]],
        n => (0..n).map(|k| &all[k * (all.len() - 1) / (n - 1)]).collect(),
    }
}

fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// The address of a file for a page: its path from the page's folder. None if there is no such path, or it is no text.
fn relative(path: &Path, output: &Path) -> Option<String> {
    let path = path.parent()?.canonicalize().ok()?.join(path.file_name()?);
    let folder = output.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let folder = std::path::absolute(guard::place_of(folder)).ok()?;
    let parts = |path: &Path| path.components().map(|c| c.as_os_str().to_owned()).collect::<Vec<_>>();
    let (to, from) = (parts(&path), parts(&folder));
    let common = to.iter().zip(&from).take_while(|(a, b)| a == b).count();
    let first = path.components().next();
    if common == 0 && matches!(first, Some(Component::Prefix(_))) {
        return None;
    }
    let up = from[common..].iter().map(|_| OsStr::new(".."));
    let whole: PathBuf = up.chain(to[common..].iter().map(AsRef::as_ref)).collect();
    let parts: Option<Vec<&str>> = whole.components().map(|c| c.as_os_str().to_str()).collect();
    Some(address(&parts?.join("/")))
}

/// Bytes as an address that holds them.
fn data(kind: &str, bytes: &[u8]) -> String {
    format!("data:{kind};base64,{}", base64(bytes))
}

/// Bytes in base 64 (RFC 4648, section 4).
fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for part in bytes.chunks(3) {
        let byte = |k: usize| u32::from(part.get(k).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for k in 0..4 {
            let digit = DIGITS[(bits >> (18 - 6 * k) & 63) as usize];
            out.push(if k <= part.len() { char::from(digit) } else { '=' });
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_written_in_base_64() {
        for (text, expected) in
            [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foob", "Zm9vYg=="), ("foobar", "Zm9vYmFy")]
        {
            assert_eq!(base64(text.as_bytes()), expected, "{text}");
        }
        assert_eq!(base64(&[0xff, 0xfe, 0xfb]), "//77");
    }

    #[test]
    fn images_are_chosen_at_even_distances() {
        let all: Vec<usize> = (0..41).collect();
        assert_eq!(some(&all, 5), [&0, &10, &20, &30, &40]);
        assert_eq!(some(&all, 1), [&40]);
        assert_eq!((some(&all[..2], 6), some(&all, 0).len()), (vec![&0, &1], 0));
    }

    #[test]
    fn addresses_lead_from_the_page_to_the_file() {
        let work = tempfile::tempdir().unwrap();
        let run = work.path().join("a b");
        std::fs::create_dir(&run).unwrap();
        std::fs::write(run.join("m#.mp4"), "x").unwrap();
        let to = |output: PathBuf| relative(&run.join("m#.mp4"), &output).unwrap();
        assert_eq!(to(run.join("report.html")), "m%23.mp4");
        assert_eq!(to(work.path().join("p.html")), "a%20b/m%23.mp4");
        assert_eq!(to(work.path().join("q/p.html")), "../a%20b/m%23.mp4");
    }
}
