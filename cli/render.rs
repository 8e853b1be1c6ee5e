//! `scree render`: frames → pictures.

use crate::args::RenderArgs;
use crate::job::Pictures;
use crate::library;
use crate::progress::Progress;
use crate::report::{Exit, Failure, Outcome, peak_bytes};
use crate::{source, stitch};
use bind::emit;
use frame::FaultKind;
use render::film::bucket::Shard;
use render::film::display;
use render::ri::reader;
use render::{Context, RenderResult};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The command.
pub fn command(args: &RenderArgs) -> Outcome {
    if is_scene(&args.input) {
        return scene(args);
    }
    let (checked, data, home) = source::open(&args.input)?;
    let folder = args.output.clone().unwrap_or_else(|| home.join("images"));
    let pictures = Pictures::resolve(checked, data, folder, &args.pictures)?;
    pictures_of(&pictures, args.bucket, args.pictures.missing, args.telling())?;
    println!("{}", pictures.folder.display());
    pictures.passes.iter().for_each(|pass| println!("{}", pass.folder.display()));
    missing_frames(&pictures)
}

/// Whether an input is RIB: by its name, `-` for the standard input.
pub fn is_scene(input: &Path) -> bool {
    let name = input.to_string_lossy();
    name == "-" || [".rib", ".rib.gz", ".ribz"].iter().any(|e| name.ends_with(e))
}

/// Draw the frames of a job, or a share of each; with `missing`, only those whose picture or part is not there.
pub fn pictures_of(pictures: &Pictures, share: Option<Shard>, missing: bool, telling: Telling) -> Outcome {
    let size = pictures.checked.output.resolution;
    let there =
        |picture: &Path| is_picture(picture, size) || share.is_some_and(|share| stitch::is_part(picture, share, size));
    let wanted = |f: &&u64| !(missing && there(&pictures.image(**f)));
    let frames: Vec<u64> = pictures.frames.iter().filter(wanted).copied().collect();
    let progress = Progress::start("rendering", frames.len() as u64);
    for (done, number) in frames.iter().enumerate() {
        let finished = picture(pictures, *number, share)?;
        let image = pictures.image(*number);
        tell(&finished, *number, &share.map_or(image.clone(), |share| stitch::part_of(&image, share)), telling)?;
        progress.at(done as u64 + 1);
    }
    progress.finish();
    pictures.passes.iter().try_for_each(|pass| pictures_of(pass, share, missing, telling))
}

/// Draw a frame and write its picture.
fn picture(pictures: &Pictures, number: u64, share: Option<Shard>) -> Outcome<RenderResult> {
    let table = pictures.source.read(number)?;
    pictures.checked.check_columns(&table)?;
    let mut context = context(&pictures.files)?;
    context.shard = share;
    context.about = vec![("frame".into(), number.to_string()), ("time".into(), table.time.to_string())];
    context.about.extend(pictures.source.run_hash().map(|hash| ("run".into(), hash.into())));
    let image = pictures.image(number);
    emit::frame(&pictures.checked, &table, &image.to_string_lossy(), &pictures.files, &mut context)?;
    write_all(context, Path::new("."))?
        .pop()
        .ok_or_else(|| Failure::new(Exit::Input, "the scene has no WorldBegin and WorldEnd: there is no picture"))
}

fn context(files: &render::ri::files::Files) -> Outcome<Context> {
    Context::new(files.clone()).map_err(|f| Failure::new(Exit::Fault, f.message))
}

/// Draw a RIB file; its pictures go where its `Display` calls say, from `-o` or the working folder.
fn scene(args: &RenderArgs) -> Outcome {
    if args.pictures.frames.is_some() || args.pictures.missing {
        return Err(Failure::new(
            Exit::Usage,
            "a RIB scene has no frames to choose: --frames and --missing are for data",
        ));
    }
    let files = library::files(args.input.parent().unwrap_or(Path::new(".")));
    let rib = frame::read_bytes(FaultKind::Input, &args.input)?;
    let mut context = context(&files)?;
    context.shard = args.bucket;
    let progress = std::sync::Arc::new(Progress::start("rendering", 100));
    let bar = progress.clone();
    context.on_progress(move |done, all| bar.at((100 * done / all.max(1)) as u64));
    let (res, samples) = (args.pictures.res, args.pictures.samples);
    if res.is_some() || samples.is_some() {
        return Err(Failure::new(
            Exit::Usage,
            "--res and --samples are for data: a RIB scene has its own Format and PixelSamples",
        ));
    }
    reader::read(&args.input, &rib, &files, &mut context, &mut |_, _| Ok(()))?;
    let folder = args.output.clone().unwrap_or_else(|| PathBuf::from("."));
    let finished = write_all(context, &folder)?;
    progress.finish();
    if finished.is_empty() {
        return Err(Failure::new(
            Exit::Input,
            format!("{}: the scene has no WorldBegin and WorldEnd: there is no picture", args.input.display()),
        ));
    }
    for f in &finished {
        let mut first = None;
        for (name, _) in display::files(&f.options.displays) {
            let picture = folder.join(name);
            let written = args.bucket.map_or(picture.clone(), |share| stitch::part_of(&picture, share));
            println!("{}", written.display());
            first.get_or_insert(written);
        }
        if let Some(written) = first {
            tell(f, f.frame as u64, &written, args.telling())?;
        }
    }
    Ok(())
}

/// Write every finished picture to its displays, and say what was odd.
fn write_all(mut context: Context, folder: &Path) -> Outcome<Vec<RenderResult>> {
    let mut finished = std::mem::take(&mut context.results);
    for warning in context.warnings() {
        eprintln!("warning: {warning}");
    }
    for f in &mut finished {
        for warning in &f.warnings {
            eprintln!("warning: {warning}");
        }
        if f.options.displays.is_empty() && !f.options.unsupported_display {
            let (name, kind, mode) = ("ri.png".into(), "file".into(), "rgb".into());
            f.options.displays.push(render::Display { name, kind, mode, half: false });
        }
        for (name, displays) in display::files(&f.options.displays) {
            if let Some(share) = f.options.shard {
                stitch::write_part(f, &displays, &folder.join(name), share)?;
                continue;
            }
            let bytes = f.image.encode(&displays, &f.options.encoding());
            let bytes = bytes.map_err(|m| Failure::new(Exit::Input, format!("{name}: {m}")))?;
            frame::atomic::write(&folder.join(name), &bytes)?;
        }
    }
    Ok(finished)
}

/// Whether a picture is there, whole and of the right size.
pub fn is_picture(path: &Path, [w, h]: [u32; 2]) -> bool {
    match path.extension().and_then(|e| e.to_str()) {
        Some("png") => crate::movie::read_png(path).is_ok_and(|p| (p.width, p.height) == (w, h)),
        _ => render::film::image::decode_size(path).is_some_and(|size| size == (w, h)),
    }
}

/// Say what a picture took, as far as that is wanted: to the user, and as a file beside the picture.
fn tell(f: &RenderResult, number: u64, picture: &Path, telling: Telling) -> Outcome {
    let s = &f.stats;
    if telling.aloud {
        let t = &s.seconds;
        eprintln!(
            "frame {number}: {} primitives, {} splits, {} grids ({} hidden), {} points shaded, {} micropolygons, {} samples tried; \
             hierarchy {:.2} s, bounds {:.2}, dicing {:.2}, sampling {:.2}, shading {:.2}, filtering {:.2}; {} MB at most",
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
    if telling.as_file {
        let all = serde_json::json!({
            "frame": number, "about": f.options.about.iter().cloned().collect::<BTreeMap<_, _>>(),
            "resolution": [f.image.width, f.image.height], "stats": s, "peak_bytes": peak_bytes(), "warnings": f.warnings,
        });
        let name = picture.file_name().unwrap_or_default().to_string_lossy();
        let text = serde_json::to_vec_pretty(&all).map_err(|e| Failure::new(Exit::Fault, e.to_string()))?;
        frame::atomic::write(&picture.with_file_name(format!("{name}.stats.json")), &text)?;
    }
    Ok(())
}

/// How what pictures take is told.
#[derive(Clone, Copy, Default)]
pub struct Telling {
    /// To the user.
    pub aloud: bool,
    /// As a file beside each picture.
    pub as_file: bool,
}

/// A run that was interrupted has fewer frames than it should: what is there was drawn, what is missing is said.
pub fn missing_frames(pictures: &Pictures) -> Outcome {
    let absent = pictures.source.missing();
    match (absent.first(), absent.last()) {
        (Some(first), Some(last)) => Err(Failure::new(
            Exit::Partial,
            format!(
                "the simulation was interrupted: {} of {} frames are missing ({first} to {last}); the others were drawn",
                absent.len(),
                absent.len() + pictures.source.numbers().len()
            ),
        )),
        _ => Ok(()),
    }
}
