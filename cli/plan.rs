//! `scree plan`: the tasks of a film and the time that they would take, from images that are there or a few that are drawn to be timed.

use crate::device::Drawer;
use crate::images;
use crate::job::{DrawOn, PlanJob, Statistics, images_of};
use crate::ledger::{Ledger, Standing};
use crate::report::{Exit, Failure, Outcome};
use crate::status::{describe, duration};
use std::collections::BTreeMap;

/// Frames that are drawn for an estimate.
const SAMPLES: usize = 3;

/// Run `scree plan`.
pub fn run(job: PlanJob) -> Outcome {
    let plan = &job.plan;
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    let mut seconds = None;
    let mut open = plan.frames.clone();
    if plan.simulation.is_none() {
        let mut images = images_of(plan, &plan.frames)?;
        let is_new = !Ledger::of(&images.folder).folder().is_dir();
        let standings = if is_new { vec![] } else { images::standings(&mut images, 1)? };
        for (_, standing) in &standings {
            *counts.entry(standing[0].to_string()).or_default() += 1;
        }
        let done: Vec<u64> = standings.iter().filter(|(_, s)| s[0] == Standing::Done).map(|(f, _)| *f).collect();
        open.retain(|frame| !done.contains(frame));
        let ledger = Ledger::of(&images.folder);
        let file = |frame: &u64| images.image(*frame).file_name().unwrap_or_default().to_string_lossy().into_owned();
        let known: Vec<f64> = done.iter().filter_map(|frame| Some(ledger.entry(&file(frame))?.seconds)).collect();
        seconds = match known.len() {
            0 if job.samples && !open.is_empty() => Some(time(plan, &open)?),
            0 => None,
            n => Some(known.iter().sum::<f64>() / n as f64),
        };
    }
    if job.json {
        println!(
            "{}",
            serde_json::json!({
                "frames": plan.frames, "tasks": plan.n_tasks(), "standing": counts, "to_draw": open.len(),
                "seconds_per_image": seconds, "seconds": seconds.map(|s| s * open.len() as f64),
                "simulate": plan.simulation.as_ref().map(|s| serde_json::json!({"model": s.model, "until": s.until, "combinations": s.sweep})),
            })
        );
        return Ok(());
    }
    if let Some(simulation) = &plan.simulation {
        match simulation.sweep {
            0 => println!("simulate {} in {} parts", simulation.model.display(), simulation.until.len()),
            n => println!("simulate {n} combinations of {}", simulation.model.display()),
        }
    }
    println!("{}: {} tasks that draw into {}", describe(&plan.frames), plan.n_tasks(), plan.images_folder().display());
    counts.iter().for_each(|(standing, n)| println!("  {n} {standing}"));
    if let Some(seconds) = seconds {
        let all = seconds * open.len() as f64;
        println!("{} an image, {} for the {} to draw by one process", duration(seconds), duration(all), open.len());
    }
    Ok(())
}

/// The time that an image takes, s: a few are drawn into a folder that is then removed.
fn time(plan: &crate::batch::Plan, frames: &[u64]) -> Outcome<f64> {
    let folder = tempfile::tempdir().map_err(|e| Failure::new(Exit::Fault, e.to_string()))?;
    let n = frames.len().min(SAMPLES);
    let chosen: Vec<u64> = (0..n).map(|k| frames[(2 * k + 1) * frames.len() / (2 * n)]).collect();
    let mut job = images_of(plan, &chosen)?;
    images::redirect(&mut job, folder.path());
    let failed = images::render(&mut job, None, Statistics::default(), &mut Drawer::new(DrawOn::Cpu))?;
    failed.outcome(n, "the others were drawn to be timed")?;
    let ledger = Ledger::of(folder.path());
    let seconds = ledger.files().iter().filter_map(|file| Some(ledger.entry(file)?.seconds)).sum::<f64>();
    Ok(seconds / n as f64)
}
