//! Frames that cannot be rendered or read because of their own data: reported at once, one by one, and named at the end.

use crate::report::{Exit, Failure, Outcome, Printed};
use bind::emit::{Lack, Missing};
use std::collections::BTreeMap;

/// Failures that are printed; further ones are counted.
const PRINTED: usize = 20;

/// Frames that could not be worked on, and why.
pub struct FailedFrames {
    /// What could not be done to them: `rendered`.
    done: &'static str,
    failures: BTreeMap<u64, Failure>,
}

impl FailedFrames {
    /// No frames yet of those that could not be `done`.
    pub fn new(done: &'static str) -> FailedFrames {
        FailedFrames { done, failures: BTreeMap::new() }
    }

    /// Note the failure of one of `n` frames if its data is at fault: it is then reported, and the others go on. What is wrong with the
    /// input is the frame's fault if the same input has drawn others (`proven`). Any other failure is returned.
    pub fn note(&mut self, frame: u64, failure: Failure, proven: bool, n: usize) -> Outcome {
        if !(failure.exit == Exit::Data || proven && failure.exit == Exit::Input) {
            return Err(failure);
        }
        // A single failure ends the command, which prints it.
        if n > 1 && self.failures.len() < PRINTED {
            eprintln!("error: frame {frame}: {failure}");
        } else if self.failures.len() == PRINTED {
            eprintln!("further frames that cannot be {} are counted", self.done);
        }
        self.failures.insert(frame, failure);
        Ok(())
    }

    /// Whether a frame has failed.
    pub fn contains(&self, frame: u64) -> bool {
        self.failures.contains_key(&frame)
    }

    /// Number of frames that have failed.
    pub fn len(&self) -> usize {
        self.failures.len()
    }

    /// The outcome of a command on `n` frames; `rest` is what is said of all others.
    pub fn outcome(mut self, n: usize, rest: &str) -> Outcome {
        let frames: Vec<String> = self.failures.keys().take(PRINTED).map(u64::to_string).collect();
        let (count, done) = (self.failures.len(), self.done);
        let Some((frame, first)) = self.failures.pop_first() else { return Ok(()) };
        if count == n {
            let message = if n > 1 {
                format!("none of the {n} frames could be {done}; frame {frame}: {first}")
            } else {
                first.message
            };
            return Err(Failure::new(first.exit, message));
        }
        let more = if count > PRINTED { ", …" } else { "" };
        let message = format!("{count} of {n} frames could not be {done} ({}{more}); {rest}", frames.join(", "));
        Err(Failure::new(Exit::Partial, message))
    }
}

/// What the rows of all frames lack, to be warned of once.
#[derive(Default)]
pub struct MissingValues {
    all: Missing,
    undrawn_in: Option<u64>,
    uncolored_in: Option<u64>,
    /// Objects that no frame so far has rows of; none before the first frame.
    absent: Option<Vec<String>>,
    n_frames: usize,
}

impl MissingValues {
    /// Add what the rows of a frame lack.
    pub fn add(&mut self, frame: u64, missing: &Missing) {
        self.all.undrawn.add(&missing.undrawn);
        self.all.uncolored.add(&missing.uncolored);
        match &mut self.absent {
            Some(absent) => absent.retain(|name| missing.absent.contains(name)),
            None => self.absent = Some(missing.absent.clone()),
        }
        for said in &missing.columns {
            if !self.all.columns.contains(said) {
                self.all.columns.push(said.clone());
            }
        }
        self.n_frames += 1;
        self.undrawn_in = self.undrawn_in.or((missing.undrawn.rows > 0).then_some(frame));
        self.uncolored_in = self.uncolored_in.or((missing.uncolored.rows > 0).then_some(frame));
    }

    /// Print what is missing.
    pub fn warn(&self, printed: &mut Printed) {
        self.notes().iter().for_each(|note| printed.print(format!("note: {note}")));
        self.warnings().iter().for_each(|warning| printed.print(format!("warning: {warning}")));
    }

    /// The objects that have no rows: one may lack them in some frames, but hardly in all.
    pub fn notes(&self) -> Vec<String> {
        let place = if self.n_frames == 1 { "the frame" } else { "any of the frames" };
        let note = |name: &String| format!("the object `{name}` has no rows in {place}: it is not drawn");
        self.absent.iter().flatten().map(note).collect()
    }

    /// What rows lack, and columns that the data has not.
    pub fn warnings(&self) -> Vec<String> {
        let warning = |lack: &Lack, frame: Option<u64>, effect: &str| {
            let ((row, text), frame) = (lack.first.as_ref()?, frame?);
            // A name that is not plain has quotes already.
            let text = if text.contains('`') { text.clone() } else { format!("`{text}`") };
            let (n, s) = (lack.rows, if lack.rows == 1 { "" } else { "s" });
            Some(format!("{n} row{s} {effect}; the first is row {row} of frame {frame}, in {text}"))
        };
        let undrawn = warning(&self.all.undrawn, self.undrawn_in, "not drawn for want of a value or a size");
        let effect = "drawn in magenta for want of a value of the colour";
        let rows = undrawn.into_iter().chain(warning(&self.all.uncolored, self.uncolored_in, effect));
        self.all.columns.iter().cloned().chain(rows).collect()
    }
}
