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
        let suggestion = args.write.map(|path| Suggestion::check(path, &source, &frames, table.rows())).transpose()?;
        Ok(InspectJob { data: args.data, frames, table, suggestion, json: args.json })
    }
}

impl Suggestion {
    /// Read frames of the data. A frame that cannot be read is passed over here: who renders the data is told of it.
    fn check(path: PathBuf, source: &Source, frames: &[u64], n_rows: usize) -> Outcome<Suggestion> {
        let (mut read, mut fault) = (vec![], None);
        for frame in bind::suggest::sample(frames, n_rows) {
            match source.read(frame) {
                Ok(table) if table.rows() > 0 => read.push(table),
                Ok(_) => {}
                Err(e) => fault = Some(e),
            }
        }
        match (read.is_empty(), fault) {
            (true, Some(fault)) => Err(fault.into()),
            (true, None) => Err(Failure::new(Exit::Data, "the data has no rows from which a camera could be placed")),
            (false, _) => Ok(Suggestion { path, frames: read }),
        }
    }
}
