//! The job of `scree inspect`.

use crate::args::InspectArgs;
use crate::report::{Exit, Failure, Outcome};
use bind::data::Source;
use frame::Frame;
use frame::list;
use std::path::PathBuf;

/// Data to inspect.
pub struct InspectJob {
    /// The run directory, file or pattern.
    pub data: PathBuf,
    /// The frames of the data.
    pub frames: Vec<u64>,
    /// The table of the inspected frame.
    pub table: Frame,
    /// The table from which metadata is suggested: the first with rows after an inspected one without any.
    pub sample: Option<Frame>,
    /// The metadata file to write.
    pub write: Option<PathBuf>,
    /// Whether JSON is printed.
    pub json: bool,
}

impl InspectJob {
    /// Check the arguments: open the data and read the frame.
    pub fn check(args: InspectArgs) -> Outcome<InspectJob> {
        let source = Source::open(&args.data)?;
        let frames = source.numbers();
        let frame = match args.frame {
            Some(f) if !frames.contains(&f) => {
                let message = format!("--frame {f}: the data has {}", list::describe(&frames));
                return Err(Failure::new(Exit::Usage, message));
            }
            Some(f) => f,
            None => *frames.first().ok_or_else(|| Failure::new(Exit::Data, "the data has no frames yet"))?,
        };
        let table = source.read(frame)?;
        let sample = match table.rows() == 0 && args.write.is_some() {
            true => later_rows(&source, &frames, frame)?,
            false => None,
        };
        Ok(InspectJob { data: args.data, frames, table, sample, write: args.write, json: args.json })
    }
}

/// The first table after an empty frame that has rows.
fn later_rows(source: &Source, frames: &[u64], empty: u64) -> Outcome<Option<Frame>> {
    for frame in frames.iter().filter(|frame| **frame > empty) {
        let table = source.read(*frame)?;
        if table.rows() > 0 {
            return Ok(Some(table));
        }
    }
    Ok(None)
}
