//! Tables of other programs: where the frames of a pattern of files stand, and each of them read by what its file is.

use crate::csv::{self, Layout};
use crate::dump::{self, Snapshot};
use crate::vtk::{self, DataSet};
use crate::{Fault, FaultKind, Frame, arrow, parquet, sequence};
use std::collections::BTreeMap;
use std::io::Read;
use std::path::{Path, PathBuf};

/// What a file of tables is, told by its first bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Text in rows and cells: CSV in its dialects.
    Csv,
    /// A dump of LAMMPS or LIGGGHTS.
    Dump,
    /// A file of VTK, or of its pieces.
    Vtk,
    /// A ParaView collection of time steps.
    Collection,
    /// A Parquet file.
    Parquet,
    /// An Arrow IPC file, as Feather.
    Arrow,
}

impl Kind {
    /// The kind of a file; CSV if it is no other, and where it cannot be opened.
    pub fn of(path: &Path) -> Kind {
        if dump::is_dump(path) {
            return Kind::Dump;
        }
        let head = head(path);
        match vtk::kind_of(&head) {
            Some(vtk::Kind::Points) => Kind::Vtk,
            Some(vtk::Kind::Collection) => Kind::Collection,
            None if head.starts_with(parquet::MAGIC) => Kind::Parquet,
            None if head.starts_with(arrow::MAGIC) => Kind::Arrow,
            None => Kind::Csv,
        }
    }
}

/// The first bytes of a file; none if it cannot be read.
fn head(path: &Path) -> Vec<u8> {
    let mut bytes = vec![];
    let read = guard::open(path).and_then(|file| file.take(1 << 12).read_to_end(&mut bytes));
    if read.is_ok() { bytes } else { vec![] }
}

/// A frame's table: a file, or a part of one.
#[derive(Clone, Debug, PartialEq)]
pub struct Stored {
    /// The file.
    pub path: PathBuf,
    /// What it is.
    pub kind: Kind,
    /// The part of a file that has several tables.
    part: Part,
}

/// What of a file is a table.
#[derive(Clone, Debug, PartialEq)]
enum Part {
    /// All of it.
    Whole,
    /// A time step of a dump.
    Snapshot(Snapshot),
    /// A data set of a collection; the file is its first one.
    DataSet(DataSet),
}

impl Stored {
    /// Read the table as the frame `number`; a CSV file by its layout.
    pub fn read(&self, number: u64, layout: &Layout) -> Result<Frame, Fault> {
        match (&self.part, self.kind) {
            (Part::Snapshot(step), _) => dump::read(&self.path, Some(step), number),
            (Part::DataSet(set), _) => vtk::read_set(set, number),
            (Part::Whole, Kind::Csv) => csv::read(&self.path, number, layout),
            (Part::Whole, Kind::Dump) => dump::read(&self.path, None, number),
            (Part::Whole, Kind::Vtk | Kind::Collection) => vtk::read(&self.path, number),
            (Part::Whole, Kind::Parquet) => parquet::read(&self.path, number),
            (Part::Whole, Kind::Arrow) => arrow::read_table(&self.path, number),
        }
    }
}

/// The tables of the files that match a pattern, by frame number: the last number in a file's name, or the time step where a dump has
/// several. An error as of [`sequence::find`].
pub fn find(pattern: &Path) -> Result<BTreeMap<u64, Stored>, Fault> {
    let files = sequence::find(pattern)?;
    let several = match files.values().next().map(|first| (Kind::of(first), first)) {
        Some((Kind::Dump, first)) => dump::snapshots(first)?.len() > 1,
        Some((kind, _)) => kind == Kind::Collection,
        None => false,
    };
    if !several {
        let whole =
            |(number, path): (u64, PathBuf)| (number, Stored { kind: Kind::of(&path), path, part: Part::Whole });
        return Ok(files.into_iter().map(whole).collect());
    }
    let mut found: BTreeMap<u64, Stored> = BTreeMap::new();
    for path in files.into_values() {
        for (step, stored) in parts(&path)? {
            if let Some(other) = found.insert(step, stored) {
                let message = format!("has the time step {step}, and so has {}", other.path.display());
                return Err(
                    Fault::whole(FaultKind::Data, &path, message).hint("a time step is a frame: each may stand once")
                );
            }
        }
    }
    Ok(found)
}

/// The tables of a file that may have several: a collection, or else a dump.
fn parts(path: &Path) -> Result<Vec<(u64, Stored)>, Fault> {
    if Kind::of(path) == Kind::Collection {
        let stored = |set: DataSet| Stored { path: set.files[0].clone(), kind: Kind::Vtk, part: Part::DataSet(set) };
        return Ok(vtk::data_sets(path)?.into_iter().map(|(number, set)| (number, stored(set))).collect());
    }
    let stored = |step: Snapshot| Stored { path: path.into(), kind: Kind::Dump, part: Part::Snapshot(step) };
    Ok(dump::snapshots(path)?.into_iter().map(|step| (step.step, stored(step))).collect())
}
