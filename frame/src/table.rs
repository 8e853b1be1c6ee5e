//! Tables of other programs: where the frames of a pattern of files stand, and each of them read by what its file is.

use crate::csv::{self, Layout};
use crate::dump::{self, Snapshot};
use crate::{Fault, FaultKind, Frame, sequence};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// What a file of tables is, told by its first bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Text in rows and cells: CSV in its dialects.
    Csv,
    /// A dump of LAMMPS or LIGGGHTS.
    Dump,
}

impl Kind {
    /// The kind of a file; CSV if it is no other, and where it cannot be opened.
    pub fn of(path: &Path) -> Kind {
        if dump::is_dump(path) { Kind::Dump } else { Kind::Csv }
    }
}

/// A frame's table: a file, or a part of one.
#[derive(Clone, Debug, PartialEq)]
pub struct Stored {
    /// The file.
    pub path: PathBuf,
    /// What it is.
    pub kind: Kind,
    /// The part of a file that has several tables.
    part: Option<Snapshot>,
}

impl Stored {
    /// Read the table as the frame `number`; a CSV file by its layout.
    pub fn read(&self, number: u64, layout: &Layout) -> Result<Frame, Fault> {
        match self.kind {
            Kind::Csv => csv::read(&self.path, number, layout),
            Kind::Dump => dump::read(&self.path, self.part.as_ref(), number),
        }
    }
}

/// The tables of the files that match a pattern, by frame number: the last number in a file's name, or the time step where a dump has
/// several. An error as of [`sequence::find`].
pub fn find(pattern: &Path) -> Result<BTreeMap<u64, Stored>, Fault> {
    let files = sequence::find(pattern)?;
    let several = match files.values().next() {
        Some(first) if Kind::of(first) == Kind::Dump => dump::snapshots(first)?.len() > 1,
        _ => false,
    };
    if !several {
        let whole = |(number, path): (u64, PathBuf)| (number, Stored { kind: Kind::of(&path), path, part: None });
        return Ok(files.into_iter().map(whole).collect());
    }
    let mut found: BTreeMap<u64, Stored> = BTreeMap::new();
    for path in files.into_values() {
        for snapshot in dump::snapshots(&path)? {
            let stored = Stored { path: path.clone(), kind: Kind::Dump, part: Some(snapshot) };
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
