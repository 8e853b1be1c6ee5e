//! `scree report`: a run, or the runs of a folder, as one HTML file that opens without a network.

mod curves;
mod drawing;
mod ending;
mod files;
mod media;
mod number;
mod scale;
mod series;
mod single;
mod sweep;
mod template;
mod titles;
mod view;

use crate::job::{ReportJob, Subject};
use crate::report::{Exit, Failure, Outcome};

/// Run `scree report`.
pub fn run(job: ReportJob) -> Outcome {
    let (page, data) = match &job.subject {
        Subject::Run(run) => single::page(run, &job),
        Subject::Sweep { name, runs, plots, notes, faults } => {
            let mut found = sweep::page(name, runs, plots, faults.len(), &job);
            found.0.notes.extend(notes.iter().cloned());
            found.0.faults.extend(faults.iter().cloned());
            found
        }
    };
    for note in page.notes.iter().chain(&page.faults) {
        eprintln!("warning: {note}");
    }
    let text = template::render(&page, &data)?;
    frame::atomic::write(&job.output, text.as_bytes())?;
    if let Some(film) = &page.film {
        eprintln!("film: {}", film.note);
    }
    println!("{}", job.output.display());
    match page.faults.len() {
        0 => Ok(()),
        n => {
            let what = number::counted(n as u64, "part");
            Err(Failure::new(Exit::Partial, format!("{what} of the data cannot be read; the page says so")))
        }
    }
}
