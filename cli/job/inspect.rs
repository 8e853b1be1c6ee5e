//! The job of `scree inspect`.

use crate::args::{Axis, InspectArgs};
use crate::failed::FailedFrames;
use crate::report::{Exit, Failure, Outcome};
use bind::Up;
use bind::data::{Source, Store};
use frame::Frame;
use frame::list;
use frame::table::Kind;
use std::path::PathBuf;

/// Data to inspect.
pub struct InspectJob {
    /// The run directory, file or pattern.
    pub data: PathBuf,
    /// The frames of the data.
    pub frames: Vec<u64>,
    /// The table of the inspected frame.
    pub table: Frame,
    /// Frames that could not be read, of those that were looked at.
    pub failed: FailedFrames,
    /// The metadata file to write.
    pub suggestion: Option<Suggestion>,
    /// Whether JSON is printed.
    pub json: bool,
}

/// A metadata file to write.
pub struct Suggestion {
    /// The file.
    pub path: PathBuf,
    /// Frames of the whole data, from which it is suggested.
    pub frames: Vec<Frame>,
    /// The column of times, where rows are of different times.
    pub time: Option<String>,
    /// What the files of the data are, if it is no run directory.
    pub kind: Option<Kind>,
    /// The axis that points up.
    pub up: Up,
}

impl InspectJob {
    /// Check the arguments: open the data and read the frame, or the first that can be read.
    pub fn check(args: InspectArgs) -> Outcome<InspectJob> {
        let source = Source::open(&args.data, args.time.as_deref())?;
        let frames = source.numbers();
        let mut failed = FailedFrames::new("read");
        let table = match args.frame {
            Some(f) if !frames.contains(&f) => {
                let message = format!("--frame {f}: the data has {}", list::describe(&frames));
                return Err(Failure::new(Exit::Usage, message));
            }
            Some(f) => source.read(f)?,
            None => match first(&source, &frames, &mut failed)? {
                Some(table) => table,
                None => {
                    failed.outcome(frames.len(), "")?;
                    return Err(Failure::new(Exit::Data, "the data has no frames yet"));
                }
            },
        };
        let suggestion = match args.write {
            Some(path) => {
                let found = Suggestion::check(path, &source, &frames, table.rows(), &mut failed)?;
                let up = match (args.up, &source.store) {
                    (Some(axis), _) => up(axis),
                    (None, Store::Run(run)) => Up::of_run(&run.folder),
                    (None, Store::Files { .. }) => Up::default(),
                };
                Some(Suggestion { time: args.time, up, ..found })
            }
            None => None,
        };
        Ok(InspectJob { data: args.data, frames, table, failed, suggestion, json: args.json })
    }
}

/// What points up along an axis.
fn up(axis: Axis) -> Up {
    match axis {
        Axis::X => Up::X,
        Axis::Y => Up::Y,
        Axis::Z => Up::Z,
        Axis::MinusX => Up::MinusX,
        Axis::MinusY => Up::MinusY,
        Axis::MinusZ => Up::MinusZ,
    }
}

/// The first frame that can be read; those before it have failed.
fn first(source: &Source, frames: &[u64], failed: &mut FailedFrames) -> Outcome<Option<Frame>> {
    for frame in frames {
        match source.read(*frame) {
            Ok(table) => return Ok(Some(table)),
            Err(fault) => failed.note(*frame, fault.into(), false, frames.len())?,
        }
    }
    Ok(None)
}

impl Suggestion {
    /// Read frames of the data; those that cannot be read have failed.
    fn check(
        path: PathBuf,
        source: &Source,
        frames: &[u64],
        n_rows: usize,
        failed: &mut FailedFrames,
    ) -> Outcome<Suggestion> {
        let mut read = vec![];
        let mut sample = bind::suggest::sample(frames, n_rows);
        sample.retain(|frame| !failed.contains(*frame));
        for frame in sample {
            match source.read(frame) {
                Ok(table) => read.push(table),
                Err(fault) => failed.note(frame, fault.into(), false, frames.len())?,
            }
        }
        let kind = match &source.store {
            Store::Files { files, .. } => files.values().next().map(|stored| stored.kind),
            Store::Run(_) => None,
        };
        Ok(Suggestion { path, frames: read, time: None, kind, up: Up::default() })
    }
}
