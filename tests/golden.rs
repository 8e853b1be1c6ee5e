//! Images held to golden ones, block by block, with a report of the differences.
//!
//! The measure is the largest error over small blocks: over each block of 4 × 4 pixels, at every second pixel, the mean of the
//! pixels' greatest differences of a channel, in steps of 255. A mean over the whole image would not see a stone: one of
//! 600 that vanishes changes it by less than a tenth of a step. A block is as large as the smallest thing that must be seen; over
//! less, a single sample at an edge would count for a stone.
//!
//! The tolerance of [`STEADY`] leaves room for what another machine's library of sines may change: all pixels by a step, or a few
//! samples at edges (of 4 × 4 samples in a pixel, one at the strongest contrast is a step of its block). A stone of which five
//! pixels or more are seen is ten times as much when it goes or moves by its radius.
//!
//! A golden image is never written by a test. Where it is missing or differs, the test fails with the command that renders it, and
//! leaves a report (`index.html`) in the target folder: what was expected, what came out, and the difference eight times as strong.

use image::{Rgb, RgbImage};
use std::path::{Path, PathBuf};

/// Length of a block, pixels.
const BLOCK: u32 = 4;

/// The tolerance for filtered colours, in steps of 255.
pub const STEADY: f64 = 1.5;

/// The block in which two images differ most.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Worst {
    /// The mean over the block of the pixels' greatest differences of a channel, in steps of 255.
    pub error: f64,
    /// The block's first pixel.
    pub at: [u32; 2],
}

/// The greatest difference of a channel between two pixels.
fn apart(a: &Rgb<u8>, b: &Rgb<u8>) -> u8 {
    (0..3).map(|c| a[c].abs_diff(b[c])).max().unwrap_or(0)
}

/// The block in which two images of one size differ most.
pub fn worst_block(a: &RgbImage, b: &RgbImage) -> Worst {
    assert_eq!(a.dimensions(), b.dimensions());
    let (w, h) = a.dimensions();
    let (bw, bh) = (BLOCK.min(w), BLOCK.min(h));
    let mut worst = Worst::default();
    // Blocks overlap by half, and the last ones end where the image does.
    let places = |length: u32, block: u32| (0..=length - block).filter(move |x| x % 2 == 0 || *x == length - block);
    for y0 in places(h, bh) {
        for x0 in places(w, bw) {
            let pixels = (0..bh).flat_map(|y| (0..bw).map(move |x| (x0 + x, y0 + y)));
            let sum: u32 = pixels.map(|(x, y)| apart(a.get_pixel(x, y), b.get_pixel(x, y)) as u32).sum();
            let error = sum as f64 / (bw * bh) as f64;
            if error > worst.error {
                worst = Worst { error, at: [x0, y0] };
            }
        }
    }
    worst
}

/// Where golden images are.
fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden")
}

/// Where a report goes.
fn report_folder(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join("golden").join(name)
}

/// Hold a part of an image to the same part of another: an error that says where they differ by more than the tolerance.
pub fn compare(now: &RgbImage, expected: &RgbImage, tolerance: f64) -> Result<Worst, String> {
    if now.dimensions() != expected.dimensions() {
        return Err(format!("is of {:?} pixels, the golden one of {:?}", now.dimensions(), expected.dimensions()));
    }
    let worst = worst_block(now, expected);
    if worst.error <= tolerance {
        return Ok(worst);
    }
    let [x, y] = worst.at;
    Err(format!("differs by {:.1} of 255 in the block at ({x}, {y}), the tolerance is {tolerance}", worst.error))
}

/// A part of a golden image with a tolerance of its own: name, first pixel, size, tolerance.
pub type Panel<'a> = (&'a str, [u32; 2], [u32; 2], f64);

/// Hold the panels of an image to the golden one of a name, `tests/golden/NAME.png`; `command` renders that.
pub fn hold_panels(name: &str, now: &RgbImage, panels: &[Panel], command: &str) -> Result<(), String> {
    let path = folder().join(format!("{name}.png"));
    let remade = format!("rendered by: {command}\nlook at it before it is committed as {}", path.display());
    let expected = match image::open(&path) {
        Ok(image) => image.to_rgb8(),
        Err(e) => {
            let report = report(name, now, None, &e.to_string());
            return Err(format!("{}: {e}\nit is {remade}\nwhat came out now: {}", path.display(), report.display()));
        }
    };
    let whole = [("the image", [0, 0], expected.dimensions().into(), STEADY)];
    let panels = if now.dimensions() == expected.dimensions() { panels } else { &whole };
    let mut faults = vec![];
    for (panel, [x, y], [w, h], tolerance) in panels {
        let cut = |image: &RgbImage| {
            let (w, h) = ((*w).min(image.width() - x), (*h).min(image.height() - y));
            image::imageops::crop_imm(image, *x, *y, w, h).to_image()
        };
        if let Err(fault) = compare(&cut(now), &cut(&expected), *tolerance) {
            faults.push(format!("{panel} {fault}"));
        }
    }
    if faults.is_empty() {
        return Ok(());
    }
    let faults = faults.join("\n");
    let report = report(name, now, Some(&expected), &faults);
    Err(format!("{name}:\n{faults}\nreport: {}\nif it is meant: {remade}", report.display()))
}

/// Hold an image to the golden one of a name, `tests/golden/NAME.png`; `command` renders that.
pub fn hold(name: &str, now: &RgbImage, tolerance: f64, command: &str) -> Result<(), String> {
    hold_panels(name, now, &[("the image", [0, 0], now.dimensions().into(), tolerance)], command)
}

/// Write a report of what differs; returns its page.
fn report(name: &str, now: &RgbImage, expected: Option<&RgbImage>, said: &str) -> PathBuf {
    let folder = report_folder(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    let mut images = vec![("got", now.clone())];
    if let Some(expected) = expected {
        images.insert(0, ("expected", expected.clone()));
        if expected.dimensions() == now.dimensions() {
            let strong = |x: u32, y: u32| {
                let (a, b) = (now.get_pixel(x, y), expected.get_pixel(x, y));
                Rgb([0, 1, 2].map(|c| a[c].abs_diff(b[c]).saturating_mul(8)))
            };
            images.push(("difference", RgbImage::from_fn(now.width(), now.height(), strong)));
        }
    }
    let mut page = format!(
        "<!doctype html><meta charset=utf-8><title>{name}</title>\n<style>img{{width:100%;image-rendering:pixelated}}figure{{display:inline-block;width:31%;margin:1%}}</style>\n<h1>{name}</h1>\n<pre>{}</pre>\n",
        said.replace('&', "&amp;").replace('<', "&lt;")
    );
    for (what, image) in &images {
        image.save(folder.join(format!("{what}.png"))).unwrap();
        page += &format!("<figure><img src={what}.png><figcaption>{what}</figcaption></figure>\n");
    }
    let path = folder.join("index.html");
    std::fs::write(&path, page).unwrap();
    path
}

#[test]
fn blocks_are_seen_and_steps_are_not() {
    let flat = RgbImage::from_pixel(37, 21, Rgb([100, 120, 140]));
    assert_eq!(worst_block(&flat, &flat), Worst::default());
    // A step everywhere is within the tolerance, a spot of four pixels is not, wherever it lies.
    let mut steps = flat.clone();
    steps.pixels_mut().enumerate().for_each(|(i, p)| p[i % 3] += 1);
    assert!(compare(&steps, &flat, STEADY).is_ok());
    for (x, y) in [(0, 0), (35, 19), (17, 3), (8, 19), (35, 10)] {
        let mut spot = flat.clone();
        for (x, y) in [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)] {
            spot.put_pixel(x, y, Rgb([112, 120, 140]));
        }
        let worst = worst_block(&spot, &flat);
        assert_eq!(worst.error, 3.0, "{worst:?}");
        assert!(worst.at[0] <= x && x < worst.at[0] + BLOCK && worst.at[1] <= y && y < worst.at[1] + BLOCK);
        assert!(compare(&spot, &flat, STEADY).is_err());
    }
    assert!(compare(&RgbImage::new(37, 20), &flat, 255.0).is_err());
}

#[test]
fn a_golden_image_that_is_missing_fails_and_stays_missing() {
    let now = RgbImage::from_pixel(8, 8, Rgb([1, 2, 3]));
    let said = hold("there_is_none", &now, STEADY, "scree render nothing").unwrap_err();
    assert!(said.contains("scree render nothing") && said.contains("there_is_none.png"), "{said}");
    assert!(!folder().join("there_is_none.png").exists());
    assert_eq!(image::open(report_folder("there_is_none").join("got.png")).unwrap().to_rgb8(), now);
}

#[test]
fn a_report_shows_what_was_expected_what_came_and_the_difference() {
    let [a, b] = [10, 30].map(|red| RgbImage::from_pixel(8, 8, Rgb([red, 2, 3])));
    let page = report("a_report", &a, Some(&b), "the image differs by 20 < 30");
    let text = std::fs::read_to_string(&page).unwrap();
    assert!(text.contains("differs by 20 &lt; 30"), "{text}");
    for (name, expected) in [("expected", [30, 2, 3]), ("got", [10, 2, 3]), ("difference", [160, 0, 0])] {
        assert!(text.contains(&format!("src={name}.png")), "{text}");
        let image = image::open(page.with_file_name(format!("{name}.png"))).unwrap().to_rgb8();
        assert!(image.pixels().all(|p| p.0 == expected), "{name}");
    }
}
