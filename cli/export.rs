//! `scree export`: frames of any data → files of other programs.

use crate::failed::FailedFrames;
use crate::interrupt;
use crate::job::ExportJob;
use crate::progress::Progress;
use crate::report::{Exit, Failure, Outcome};
use frame::export::{self, Format};
use frame::{Fault, FaultKind};
use std::collections::HashSet;
use std::path::{Path, PathBuf};

/// Run `scree export`.
pub fn run(job: ExportJob) -> Outcome {
    let n = job.frames.len();
    let mut failed = FailedFrames::new("exported");
    let mut written: Vec<(String, f64)> = vec![];
    let name = |number: &u64| format!("{}_{number:06}.{}", job.stem, job.format.ending());
    let collection = job.folder.join(format!("{}.pvd", job.stem));
    spare_inputs(&job, job.frames.iter().map(|number| job.folder.join(name(number))).chain([collection.clone()]))?;
    frame::atomic::sweep(&job.folder);
    let progress = Progress::start("exporting", n as u64, "frames");
    for (done, number) in job.frames.iter().enumerate() {
        interrupt::remark(format!("{done} of {n} frames are written"));
        match frame_to(&job, *number, &job.folder.join(name(number))) {
            Ok(time) => written.push((name(number), time)),
            Err(failure) => failed.note(*number, failure, !written.is_empty(), n)?,
        }
        progress.at(done as u64 + 1);
    }
    interrupt::remark(String::new());
    progress.finish();
    if job.format == Format::Vtu && !written.is_empty() {
        frame::atomic::write(&collection, export::collection(&timed(&job, written.clone())).as_bytes())?;
    }
    if !written.is_empty() {
        println!("{}", job.folder.display());
    }
    failed.outcome(n, "the others were written")
}

/// The files with the times that a collection tells: those of the frames, or their numbers where the data has no times.
fn timed(job: &ExportJob, mut files: Vec<(String, f64)>) -> Vec<(String, f64)> {
    let first = files[0].1;
    if files.len() > 1 && files.iter().all(|(_, time)| *time == first) {
        eprintln!("note: the data tells no times: those of the collection are the numbers of the frames");
        let number = |name: &str| job.frames.iter().find(|n| name.contains(&format!("_{n:06}."))).copied().unwrap_or(0);
        files.iter_mut().for_each(|(name, time)| *time = number(name) as f64);
    }
    files
}

/// Write a frame to a file; its time, s.
fn frame_to(job: &ExportJob, number: u64, path: &Path) -> Outcome<f64> {
    let table = job.source.read(number)?;
    let lacks = |message| Fault { message, ..Fault::whole(FaultKind::Data, Path::new(&format!("frame {number}")), "") };
    let bytes = export::encode(&table, job.format).map_err(lacks)?;
    frame::atomic::write(path, &bytes)?;
    Ok(table.time)
}

/// Refuse to replace files that frames are read from.
fn spare_inputs(job: &ExportJob, mut paths: impl Iterator<Item = PathBuf>) -> Outcome {
    let inputs: HashSet<PathBuf> = job.source.files().iter().filter_map(|file| file.canonicalize().ok()).collect();
    match paths.find(|path| path.canonicalize().is_ok_and(|real| inputs.contains(&real))) {
        Some(path) => {
            Err(Failure::new(Exit::Usage, format!("{} is read: give another folder, -o DIR", path.display())))
        }
        None => Ok(()),
    }
}
