//! `scree render`: frames or a RIB scene → images.

use crate::failed::{FailedFrames, MissingValues};
use crate::job::{ImageJob, RenderFrames, RenderJob, RenderScene, Statistics};
use crate::machine::peak_bytes;
use crate::progress::Progress;
use crate::report::{Exit, Failure, Outcome};
use crate::{image_file, interrupt, model_run, shard_file};
use bind::emit;
use frame::{Fault, FaultKind};
use render::film::bucket::Shard;
use render::film::display;
use render::ri::files::Files;
use render::ri::reader;
use render::{Context, RenderResult};
use std::collections::{BTreeMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Run `scree render`.
pub fn run(job: RenderJob) -> Outcome {
    match job {
        RenderJob::Scene(job) => scene(&job),
        RenderJob::Frames(job) => frames(*job),
    }
}

fn frames(job: RenderFrames) -> Outcome {
    let (binding, source) = model_run::provide(job.frames)?;
    let image_job = ImageJob::resolve(binding, source, job.folder, &job.options)?;
    let failed = images(&image_job, job.shard, job.statistics)?;
    if failed.len() < image_job.frames.len() {
        println!("{}", image_job.folder.display());
        image_job.passes.iter().for_each(|pass| println!("{}", pass.folder.display()));
    }
    failed.outcome(image_job.frames.len(), "the others were rendered")?;
    missing_frames(&image_job)
}

/// Render the images of a job, or a shard of each; the frames whose data cannot be drawn are returned.
pub fn images(job: &ImageJob, shard: Option<Shard>, statistics: Statistics) -> Outcome<FailedFrames> {
    let mut failed = FailedFrames::new("rendered");
    images_but_failed(job, shard, statistics, &mut failed)?;
    Ok(failed)
}

fn images_but_failed(
    job: &ImageJob,
    shard: Option<Shard>,
    statistics: Statistics,
    failed: &mut FailedFrames,
) -> Outcome {
    let size = job.binding.output.resolution;
    let exists = |image: &Path| {
        image_file::is_complete(image, size) || shard.is_some_and(|s| shard_file::is_complete(image, s, size))
    };
    let wanted = |f: &&u64| !(failed.contains(**f) || job.missing && exists(&job.image(**f)));
    let frames: Vec<u64> = job.frames.iter().filter(wanted).copied().collect();
    let progress = Progress::start("rendering", frames.len() as u64, "frames");
    let (mut values, mut proven) = (MissingValues::default(), false);
    for (done, frame) in frames.iter().enumerate() {
        interrupt::remark(format!("{done} of {} images are rendered; go on with --missing", frames.len()));
        match image(job, *frame, shard, &mut values) {
            Ok(result) => {
                report_statistics(&result, *frame, &written(&job.image(*frame), shard), statistics)?;
                proven = true;
            }
            Err(failure) => failed.note(*frame, failure, proven, job.frames.len())?,
        }
        progress.at(done as u64 + 1);
    }
    interrupt::remark(String::new());
    progress.finish();
    values.warn();
    job.passes.iter().try_for_each(|pass| images_but_failed(pass, shard, statistics, failed))
}

/// Render a frame and write its image.
fn image(job: &ImageJob, frame: u64, shard: Option<Shard>, values: &mut MissingValues) -> Outcome<RenderResult> {
    let table = job.source.read(frame)?;
    // The metadata fits the data's first frame: a column that this one lacks is missing in the data.
    job.binding.check_columns(&table).map_err(|fault| Fault { kind: FaultKind::Data, ..fault })?;
    let mut context = context(&job.files)?;
    context.shard = shard;
    context.about = vec![("frame".into(), frame.to_string()), ("time".into(), table.time.to_string())];
    context.about.extend(job.source.run_hash().map(|hash| ("run".into(), hash.into())));
    let image = job.image(frame).to_string_lossy().to_string();
    context.image = Some(image.clone());
    context.allow_outside = job.allow_outside;
    let missing = emit::frame(&job.binding, &table, &image, &job.files, &mut context)?;
    values.add(frame, &missing);
    let no_world = || Failure::new(Exit::Input, "the scene has no WorldBegin and WorldEnd: there is no image");
    write(context, &job.folder)?.pop().ok_or_else(no_world)
}

fn context(files: &Files) -> Outcome<Context> {
    Context::new(files.clone()).map_err(|f| Failure::new(Exit::Fault, f.message))
}

/// Render a RIB scene; its images go where its `Display` requests say, from the job's folder.
fn scene(job: &RenderScene) -> Outcome {
    let mut context = context(&job.files)?;
    context.shard = job.shard;
    context.allow_outside = job.allow_outside;
    let progress = Arc::new(Progress::start("rendering", 100, "%"));
    let bar = progress.clone();
    context.on_progress(move |done, all| bar.at((100 * done / all.max(1)) as u64));
    reader::read(&job.path, &job.rib, &job.files, &mut context, &mut |_, _| Ok(()))?;
    let results = write(context, &job.folder)?;
    progress.finish();
    if results.is_empty() {
        let message = "the scene has no WorldBegin and WorldEnd: there is no image";
        return Err(Failure::new(Exit::Input, format!("{}: {message}", job.path.display())));
    }
    for result in &results {
        let files = display::files(&result.options.displays);
        let files: Vec<PathBuf> = files.iter().map(|(name, _)| written(&job.folder.join(name), job.shard)).collect();
        files.iter().for_each(|file| println!("{}", file.display()));
        if let Some(first) = files.first() {
            report_statistics(result, result.frame as u64, first, job.statistics)?;
        }
    }
    Ok(())
}

/// The file that is written of an image: its own, or that of a shard.
fn written(image: &Path, shard: Option<Shard>) -> PathBuf {
    shard.map_or_else(|| image.into(), |shard| shard_file::path_of(image, shard))
}

/// Write the images of a context to their displays, and print its warnings.
fn write(mut context: Context, folder: &Path) -> Outcome<Vec<RenderResult>> {
    let mut results = std::mem::take(&mut context.results);
    let (image, allow_outside) = (context.image.clone(), context.allow_outside);
    for warning in context.warnings() {
        eprintln!("warning: {warning}");
    }
    let mut written = HashSet::new();
    for result in &mut results {
        for warning in &result.warnings {
            eprintln!("warning: {warning}");
        }
        if result.options.displays.is_empty() && !result.options.unsupported_display {
            let (name, kind, mode) = ("ri.png".into(), "file".into(), "rgb".into());
            result.options.displays.push(render::Display { name, kind, mode, half: false });
        }
        for (name, displays) in display::files(&result.options.displays) {
            let path = match &image {
                Some(image) if *image == name => PathBuf::from(&name),
                _ => display_path(folder, name, allow_outside)?,
            };
            if !written.insert(path.clone()) {
                eprintln!("warning: {} is written again: an earlier image of the scene is replaced", path.display());
            }
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
fn report_statistics(result: &RenderResult, frame: u64, image: &Path, statistics: Statistics) -> Outcome {
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

/// Fail if frames are missing, as they are of an interrupted run; the others are rendered.
pub fn missing_frames(job: &ImageJob) -> Outcome {
    let missing = &job.lacking;
    match (missing.first(), missing.last()) {
        (Some(first), Some(last)) => Err(Failure::new(
            Exit::Partial,
            format!(
                "the simulation was interrupted: {} of {} frames are missing ({first} to {last}); the others were rendered",
                missing.len(),
                missing.len() + job.frames.len()
            ),
        )),
        _ => Ok(()),
    }
}
