//! `scree export`: frames of any data → files of other programs.

use crate::failed::FailedFrames;
use crate::interrupt;
use crate::job::ExportJob;
use crate::progress::Progress;
use crate::report::{Exit, Failure, Outcome};
use frame::export::{self, Format};
use frame::{Fault, FaultKind};
use std::path::Path;

/// Run `scree export`.
pub fn run(job: ExportJob) -> Outcome {
    let n = job.frames.len();
    let mut failed = FailedFrames::new("exported");
    let mut written: Vec<(String, f64)> = vec![];
    frame::atomic::sweep(&job.folder);
    let progress = Progress::start("exporting", n as u64, "frames");
    for (done, number) in job.frames.iter().enumerate() {
        interrupt::remark(format!("{done} of {n} frames are written"));
        let name = format!("{}_{number:06}.{}", job.stem, job.format.ending());
        match frame_to(&job, *number, &job.folder.join(&name)) {
            Ok(time) => written.push((name, time)),
            Err(failure) => failed.note(*number, failure, !written.is_empty(), n)?,
        }
        progress.at(done as u64 + 1);
    }
    interrupt::remark(String::new());
    progress.finish();
    if job.format == Format::Vtu && !written.is_empty() {
        let path = job.folder.join(format!("{}.pvd", job.stem));
        spare_inputs(&path)?;
        frame::atomic::write(&path, export::collection(&written).as_bytes())?;
    }
    if !written.is_empty() {
        println!("{}", job.folder.display());
    }
    failed.outcome(n, "the others were written")
}

/// Write a frame to a file; its time, s.
fn frame_to(job: &ExportJob, number: u64, path: &Path) -> Outcome<f64> {
    let table = job.source.read(number)?;
    spare_inputs(path)?;
    let lacks = |message| Fault { message, ..Fault::whole(FaultKind::Data, Path::new(&format!("frame {number}")), "") };
    let bytes = export::encode(&table, job.format).map_err(lacks)?;
    frame::atomic::write(path, &bytes)?;
    Ok(table.time)
}

/// Refuse to replace a file that the frames are read from.
fn spare_inputs(path: &Path) -> Outcome {
    match guard::was_seen(path) {
        true => Err(Failure::new(Exit::Usage, format!("{} is read: give another folder, -o DIR", path.display()))),
        false => Ok(()),
    }
}
