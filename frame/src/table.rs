//! Tables of other programs: where the frames of a pattern of files stand, and each of them read by what its file is.

use crate::csv::{self, Layout};
use crate::dump::{self, Snapshot};
use crate::{Fault, FaultKind, Frame, sequence};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A frame's table: a file, or a part of one.
#[derive(Clone, Debug, PartialEq)]
pub struct Stored {
    /// The file.
    pub path: PathBuf,
    /// The time step of a dump that has several.
    snapshot: Option<Snapshot>,
}

impl Stored {
    /// Whether the table is one of a dump of LAMMPS or LIGGGHTS.
    pub fn is_dump(&self) -> bool {
        self.snapshot.is_some() || dump::is_dump(&self.path)
    }

    /// Read the table as the frame `number`: a dump of LAMMPS or LIGGGHTS if it begins as one does, else a CSV file of a layout.
    pub fn read(&self, number: u64, layout: &Layout) -> Result<Frame, Fault> {
        if self.is_dump() {
            return dump::read(&self.path, self.snapshot.as_ref(), number);
        }
        csv::read(&self.path, number, layout)
    }
}

/// The tables of the files that match a pattern, by frame number: the last number in a file's name, or the time step where a dump has
/// several. An error as of [`sequence::find`].
pub fn find(pattern: &Path) -> Result<BTreeMap<u64, Stored>, Fault> {
    let files = sequence::find(pattern)?;
    let several = match files.values().next() {
        Some(first) if dump::is_dump(first) => dump::snapshots(first)?.len() > 1,
        _ => false,
    };
    if !several {
        return Ok(files.into_iter().map(|(number, path)| (number, Stored { path, snapshot: None })).collect());
    }
    let mut found: BTreeMap<u64, Stored> = BTreeMap::new();
    for path in files.into_values() {
        for snapshot in dump::snapshots(&path)? {
            let stored = Stored { path: path.clone(), snapshot: Some(snapshot) };
            if let Some(other) = found.insert(snapshot.step, stored) {
                let message = format!("has the time step {}, and so has {}", snapshot.step, other.path.display());
                return Err(
                    Fault::whole(FaultKind::Data, &path, message).hint("a time step is a frame: each may stand once")
                );
            }
        }
    }
    Ok(found)
}
