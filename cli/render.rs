//! `scree render`: frames or a RIB scene → images.

use crate::device::Drawer;
use crate::displays::{context, report_statistics, write, written};
use crate::drawing::{self, Drawing};
use crate::images;
use crate::job::{RenderFrames, RenderJob, RenderScene};
use crate::progress::Progress;
use crate::report::{Exit, Failure, Outcome, Printed};
use bind::emit;
use render::DrawnBy;
use render::film::display;
use render::ri::reader;
use std::path::PathBuf;
use std::sync::Arc;

/// Run `scree render`.
pub fn run(job: RenderJob) -> Outcome {
    match job {
        RenderJob::Scene(job) => scene(&job),
        RenderJob::Frames(job) => frames(*job),
    }
}

fn frames(job: RenderFrames) -> Outcome {
    let RenderFrames { frames, folder, options, shard, statistics, on, gpu_memory } = job;
    let mut drawer = Drawer::new(on).within(gpu_memory);
    let how = Drawing { folder, options: &options, shard, statistics };
    let (image_job, failed) = drawing::draw(frames, how, &mut drawer)?;
    if failed.len() < image_job.frames.len() {
        println!("{}", image_job.folder.display());
        image_job.passes.iter().for_each(|pass| println!("{}", pass.folder.display()));
    }
    failed.outcome(image_job.frames.len(), "the others were rendered")?;
    images::check_missing(&image_job)
}

/// Render a RIB scene; its images go where its `Display` requests say, from the job's folder.
fn scene(job: &RenderScene) -> Outcome {
    let mut context = context(&job.files)?;
    context.shard = job.shard;
    context.allow_outside = job.allow_outside;
    context.device = Drawer::new(job.on.clone()).within(job.gpu_memory).device()?;
    let progress = Arc::new(Progress::start("rendering", 100, "%"));
    let bar = progress.clone();
    context.on_progress(move |done, all| bar.at((100 * done / all.max(1)) as u64));
    reader::read(&job.path, &job.rib, &job.files, &mut context, &mut |_, directive| {
        let is_asked = emit::take_alone(directive)?;
        let message = || {
            format!(
                "`#scree {directive}` has no effect in a scene that is rendered by itself: metadata says what it injects"
            )
        };
        Ok(is_asked.then(message))
    })?;
    let is_open = context.is_world_open();
    let results = write(context, &job.folder, None, &mut Printed::default())?;
    progress.finish();
    if is_open {
        let message = "the WorldBegin of the scene has no WorldEnd: what it holds is not drawn";
        return Err(Failure::new(Exit::Input, format!("{}: {message}", job.path.display())));
    }
    if results.is_empty() {
        let message = "the scene has no WorldBegin and WorldEnd: there is no image";
        return Err(Failure::new(Exit::Input, format!("{}: {message}", job.path.display())));
    }
    for result in &results {
        if let DrawnBy::Fallback(why) = &result.drawn_by {
            eprintln!("the processor has drawn the image: {why}");
        }
        let files = display::files(&result.options.displays);
        let files: Vec<PathBuf> = files.iter().map(|(name, _)| written(&job.folder.join(name), job.shard)).collect();
        files.iter().for_each(|file| println!("{}", file.display()));
        if let Some(first) = files.first() {
            report_statistics(result, result.frame as u64, first, job.statistics)?;
        }
    }
    Ok(())
}
