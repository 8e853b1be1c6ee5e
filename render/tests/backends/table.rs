//! The table of all scenes of the repository on both back ends: `render/benches/results/backends.csv`, made by
//! `cargo test --release -p render --test backends -- --ignored table`.

use super::{CAMERA, Compared, LIT, compared, device, drawn, root};
use render::{DeviceRenderer, DrawnBy, RenderResult};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

/// Pixels along an image, of larger images a part of that.
const WIDTH: usize = 320;

/// The files with an ending of some folders, in order.
fn ribs(folder: &str) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(root().join(folder)).unwrap().map(|entry| entry.unwrap().path());
    let mut paths: Vec<PathBuf> = entries.filter(|path| path.extension().is_some_and(|e| e == "rib")).collect();
    paths.sort();
    paths
}

/// The text of a scene, its image no wider than [`WIDTH`].
fn small(text: &str) -> String {
    let line = |line: &str| {
        let words: Vec<&str> = line.split_whitespace().collect();
        let number = |k: usize| words.get(k).and_then(|word| word.parse::<usize>().ok());
        match (words.first(), number(1), number(2)) {
            (Some(&"Format"), Some(w), Some(h)) if w > WIDTH => format!("Format {WIDTH} {} 1\n", h * WIDTH / w),
            _ => format!("{line}\n"),
        }
    };
    text.lines().map(line).collect()
}

/// The requests of a file of the corpus, with what makes an image of it: a camera, lights, and a sphere if it has nothing to show.
fn framed(text: &str, has_primitives: bool) -> String {
    let ball = if has_primitives { "" } else { "Color [0.8 0.6 0.3] Sphere 1 -1 1 360" };
    if !text.contains("WorldBegin") {
        return format!("{CAMERA}{text}\n{LIT}{ball} WorldEnd\n");
    }
    let lit = text.replacen("WorldBegin", LIT, 1).replacen("WorldEnd", &format!("{ball} WorldEnd"), 1);
    format!("{CAMERA}{lit}")
}

/// All scenes, by name, with their texts and where these stand.
fn scenes() -> Vec<(String, String, PathBuf)> {
    let mut all = vec![];
    for folder in ["docs/sheets", "docs/sheets/effects", "scenes", "tests/corpus/rib"] {
        for path in ribs(folder) {
            // Those of streams are of how RIB is read.
            let stem = path.file_stem().unwrap().to_string_lossy().to_string();
            if stem.starts_with("stream_") || stem == "gravel" {
                continue;
            }
            let text = std::fs::read_to_string(&path).unwrap();
            let of_corpus = folder.starts_with("tests");
            let text = if of_corpus { framed(&text, stem.starts_with("gprim_")) } else { small(&text) };
            all.push((format!("{folder}/{stem}"), text, root().join(folder)));
        }
    }
    all
}

/// A scene on a back end, with the seconds that it took, but for the compiling of kernels; what is wrong with it if there is no image.
fn timed(text: &str, folder: &Path, device: Option<Arc<DeviceRenderer>>) -> Result<(RenderResult, f64), String> {
    if device.is_some() {
        drawn(text, folder, device.clone(), None)?;
    }
    let start = Instant::now();
    let result = drawn(text, folder, device, None)?;
    Ok((result.ok_or("it makes no image")?, start.elapsed().as_secs_f64()))
}

/// The row of a scene, and whether both back ends agree as far as the device draws it.
fn row(name: &str, text: &str, folder: &Path, device: &Arc<DeviceRenderer>) -> (String, bool) {
    let both = timed(text, folder, Some(device.clone())).and_then(|own| Ok((own, timed(text, folder, None)?)));
    let ((own, seconds), (other, others)) = match both {
        Ok(both) => both,
        Err(why) => {
            return (format!("{name},none,,,,,,,\"{}\"\n", why.lines().next().unwrap_or("").replace('"', "'")), true);
        }
    };
    let (by, why) = match &own.drawn_by {
        DrawnBy::Fallback(why) => ("processor", why.replace('"', "'")),
        _ => ("device", String::new()),
    };
    let [w, h] = [own.image.width, own.image.height];
    if !why.is_empty() {
        return (format!("{name},{by},{w}x{h},,,,,{others:.2},\"{why}\"\n"), true);
    }
    let c @ Compared { ids, pixels, variables, seen, .. } = compared(&own, &other);
    let row = format!("{name},{by},{w}x{h},{ids:.6},{pixels:.6},{variables:.6},{seconds:.2},{others:.2},\n");
    (row, c.agrees() || seen == 0)
}

#[test]
#[ignore = "draws all scenes of the repository twice"]
fn table_of_all_scenes() {
    let Some(device) = device() else { return };
    let mut table = String::from(
        "scene,drawn_by,size,ids_equal,pixels_within_2,variables_equal,seconds_device,seconds_processor,why_not\n",
    );
    let mut wrong = String::new();
    for (name, text, folder) in scenes() {
        let (row, agrees) = row(&name, &text, &folder, &device);
        write!(table, "{row}").unwrap();
        wrong += if agrees { "" } else { &row };
    }
    let path = root().join("render/benches/results/backends.csv");
    std::fs::write(&path, table).unwrap();
    eprintln!("{} ({})", path.display(), device.adapter().name);
    assert!(wrong.is_empty(), "{wrong}");
}
