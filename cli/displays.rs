//! The files of images: what a renderer's results are written to, and their statistics.

use crate::job::Statistics;
use crate::machine::peak_bytes;
use crate::overlay::Overlay;
use crate::report::{Exit, Failure, Outcome, Printed};
use crate::{image_file, shard_file};
use render::film::bucket::Shard;
use render::film::display;
use render::ri::files::Files;
use render::{Context, Display, RenderResult};
use std::collections::{BTreeMap, HashSet};
use std::path::{Path, PathBuf};

/// A renderer that finds what scenes name by a search path.
pub fn context(files: &Files) -> Outcome<Context> {
    Context::new(files.clone()).map_err(|f| Failure::new(Exit::Input, f.message))
}

/// The file that is written of an image: its own, or that of a shard.
pub fn written(image: &Path, shard: Option<Shard>) -> PathBuf {
    shard.map_or_else(|| image.into(), |shard| shard_file::path_of(image, shard))
}

/// Write the images of a context to their displays, the frame's own with its overlays, and print its warnings.
pub fn write(
    mut context: Context,
    folder: &Path,
    overlay: Option<&Overlay<'_>>,
    printed: &mut Printed,
) -> Outcome<Vec<RenderResult>> {
    let mut results = std::mem::take(&mut context.results);
    let (image, allow_outside) = (context.image.clone(), context.allow_outside);
    for warning in context.warnings() {
        printed.print(format!("warning: {warning}"));
    }
    let mut written = HashSet::new();
    for result in &mut results {
        for warning in &result.warnings {
            printed.print(format!("warning: {warning}"));
        }
        if result.options.displays.is_empty() && !result.options.unsupported_display {
            let (name, kind, mode) = ("ri.png".into(), "file".into(), "rgb".into());
            result.options.displays.push(Display { name, kind, mode, half: false, quantize: None, dither: None });
        }
        let all = result.options.displays.clone();
        let mut files: Vec<(&str, Vec<&Display>)> = display::files(&all);
        // The frame's own image comes last: the others are without overlays.
        files.sort_by_key(|(name, _)| image.as_deref() == Some(*name));
        for (name, mut displays) in files {
            let path = match &image {
                Some(image) if *image == name => PathBuf::from(&name),
                _ => display_path(folder, name, allow_outside)?,
            };
            if !written.insert(path.clone()) {
                eprintln!("warning: {} is written again: an earlier image of the scene is replaced", path.display());
            }
            let mut layers = None;
            if let Some(overlay) = overlay.filter(|o| !o.is_empty() && image.as_deref() == Some(name)) {
                if displays[0].format() == "exr" {
                    layers = Some(overlay.add_layers(&mut result.image, displays[0])?);
                } else {
                    overlay.draw_into(&mut result.image)?;
                }
            }
            displays.extend(layers.iter().flatten());
            if let Some(shard) = result.options.shard {
                shard_file::write(result, &displays, &path, shard)?;
                continue;
            }
            let bytes = result.image.encode(&displays, &result.options.encoding());
            let bytes = bytes.map_err(|m| Failure::new(Exit::Input, format!("{name}: {m}")))?;
            frame::atomic::write(&path, &bytes)?;
        }
    }
    Ok(results)
}

/// The file of a scene's display: no input, and no symbolic link leads it out of the output folder, unless that is allowed.
fn display_path(folder: &Path, name: &str, allow_outside: bool) -> Outcome<PathBuf> {
    let path = folder.join(name);
    if guard::was_seen(&path) {
        let message = format!("{}: the display would replace a file that the scene is made of", path.display());
        return Err(Failure::new(Exit::Input, message));
    }
    image_file::spare_others(&path)?;
    if !allow_outside && path.parent().is_some_and(|parent| guard::leads_out(parent, folder)) {
        let message = format!("{}: a link leads out of the output folder; --allow-outside allows it", path.display());
        return Err(Failure::new(Exit::Input, message));
    }
    Ok(path)
}

/// Report the render statistics of an image: printed, and in a file beside the image.
pub fn report_statistics(result: &RenderResult, frame: u64, image: &Path, statistics: Statistics) -> Outcome {
    if statistics.print {
        print_statistics(result, frame);
    }
    if statistics.write {
        let options = &result.options;
        let all = serde_json::json!({
            "frame": frame, "about": options.about.iter().cloned().collect::<BTreeMap<_, _>>(),
            "resolution": [result.image.width, result.image.height], "stats": result.stats,
            "peak_bytes": peak_bytes(), "warnings": result.warnings,
        });
        let name = image.file_name().unwrap_or_default().to_string_lossy();
        let text = serde_json::to_vec_pretty(&all).map_err(|e| Failure::new(Exit::Fault, e.to_string()))?;
        frame::atomic::write(&image.with_file_name(format!("{name}.stats.json")), &text)?;
    }
    Ok(())
}

fn print_statistics(result: &RenderResult, frame: u64) {
    let (s, t) = (&result.stats, &result.stats.seconds);
    eprintln!(
        "frame {frame}: {} primitives, {} splits, {} grids ({} hidden), {} points shaded, {} micropolygons, {} samples tested; \
         hierarchy {:.2} s, bounds {:.2}, dicing {:.2}, sampling {:.2}, shading {:.2}, filtering {:.2}; peak memory {} MB",
        s.items,
        s.splits,
        s.grids,
        s.grids_hidden,
        s.shaded_points,
        s.micropolygons,
        s.samples,
        t.hierarchy,
        t.bound,
        t.dice,
        t.sample,
        t.shade,
        t.filter,
        peak_bytes() / 1_000_000
    );
}
