//! Tables of other programs: where the frames of a pattern of files stand, and each of them read by what its file is.

use crate::csv::{self, Layout};
use crate::history::Histories;
use crate::part::Part;
use crate::vtk::{self, DataSet};
use crate::{Fault, FaultKind, Frame, arrow, chrono, dump, gzip, mercury, parquet, ply, sequence, xyz};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What a file of tables is, told by its first bytes, once it is unpacked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Text in rows and cells: CSV in its dialects.
    Csv,
    /// A dump of LAMMPS or LIGGGHTS.
    Dump,
    /// XYZ, plain or extended.
    Xyz,
    /// A cloud of points, or the vertices of a mesh, in PLY.
    Ply,
    /// Particles of MercuryDPM.
    Mercury,
    /// Bodies and shapes of Project Chrono.
    Chrono,
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
        /// Bytes that are looked at.
        const START: u64 = 1 << 14;
        let start = gzip::start(path, START);
        let text = start.strip_prefix(crate::text::MARK.as_bytes()).unwrap_or(&start);
        let is_vtk = |kind: vtk::Kind| vtk::kind_of(&start) == Some(kind);
        let kinds = [
            (dump::is_dump(text), Kind::Dump),
            (is_vtk(vtk::Kind::Points), Kind::Vtk),
            (is_vtk(vtk::Kind::Collection), Kind::Collection),
            (start.starts_with(parquet::MAGIC), Kind::Parquet),
            (start.starts_with(arrow::MAGIC), Kind::Arrow),
            (ply::is_ply(&start), Kind::Ply),
            (xyz::is_xyz(text), Kind::Xyz),
            (mercury::is_mercury(text), Kind::Mercury),
            (chrono::is_chrono(&start), Kind::Chrono),
        ];
        kinds.into_iter().find(|(is, _)| *is).map_or(Kind::Csv, |(_, kind)| kind)
    }

    /// The tables of a file that may have several, and the number of each, if it is told; none if its kind has one a file.
    fn parts(self, path: &Path) -> Result<Vec<(Option<u64>, Place)>, Fault> {
        let behind = |parts: Vec<Part>| parts.into_iter().map(|part| (part.step, Place::Part(part))).collect();
        Ok(match self {
            Kind::Dump => behind(dump::parts(path)?),
            Kind::Xyz => behind(xyz::parts(path)?),
            Kind::Mercury => behind(mercury::parts(path)?),
            Kind::Collection => {
                let sets = vtk::data_sets(path)?.into_iter();
                sets.map(|(number, set)| (Some(number), Place::DataSet(set))).collect()
            }
            Kind::Csv | Kind::Ply | Kind::Chrono | Kind::Vtk | Kind::Parquet | Kind::Arrow => vec![],
        })
    }
}

/// A frame's table: a file, or a part of one.
#[derive(Clone, Debug, PartialEq)]
pub struct Stored {
    /// The file; of several, the first.
    pub path: PathBuf,
    /// What it is.
    pub kind: Kind,
    place: Place,
}

/// What of a file is a table.
#[derive(Clone, Debug, PartialEq)]
enum Place {
    /// All of it.
    Whole,
    /// One of several that stand one behind the other.
    Part(Part),
    /// A data set of a collection, in files of its own.
    DataSet(DataSet),
    /// The rows of one time, by its index.
    Time(Arc<Histories>, usize),
}

impl Stored {
    fn new(path: PathBuf, kind: Kind, place: Place) -> Stored {
        match &place {
            Place::DataSet(set) => Stored { path: set.files[0].clone(), kind, place },
            _ => Stored { path, kind, place },
        }
    }

    /// The files that the table is in.
    pub fn files(&self) -> &[PathBuf] {
        match &self.place {
            Place::DataSet(set) => &set.files,
            Place::Time(histories, _) => &histories.files,
            Place::Whole | Place::Part(_) => std::slice::from_ref(&self.path),
        }
    }

    /// Read the table as the frame `number`; a CSV file by its layout.
    pub fn read(&self, number: u64, layout: &Layout) -> Result<Frame, Fault> {
        let part = match &self.place {
            Place::DataSet(set) => return vtk::read_set(set, number),
            Place::Time(histories, index) => return Ok(Frame { number, ..histories.frame(*index) }),
            Place::Part(part) => Some(part),
            Place::Whole => None,
        };
        match self.kind {
            Kind::Csv => csv::read(&self.path, number, layout),
            Kind::Dump => dump::read(&self.path, part, number),
            Kind::Xyz => xyz::read(&self.path, part, number),
            Kind::Ply => ply::read(&self.path, number),
            Kind::Mercury => mercury::read(&self.path, part, number),
            Kind::Chrono => chrono::read(&self.path, number),
            Kind::Vtk | Kind::Collection => vtk::read(&self.path, number),
            Kind::Parquet => parquet::read(&self.path, number),
            Kind::Arrow => arrow::read_table(&self.path, number),
        }
    }
}

/// The tables of the files that match a pattern, by frame number: the last number in a file's name, or the time step where a file has
/// several tables. Those of one file that tells no steps count from 0. An error as of [`sequence::find`].
pub fn find(pattern: &Path) -> Result<BTreeMap<u64, Stored>, Fault> {
    let files = sequence::find(pattern)?;
    let kind = files.values().next().map_or(Kind::Csv, |first| Kind::of(first));
    let several = match files.values().next() {
        Some(first) => kind == Kind::Collection || kind.parts(first)?.len() > 1,
        None => false,
    };
    if !several {
        let whole = |(number, path): (u64, PathBuf)| (number, Stored::new(path.clone(), Kind::of(&path), Place::Whole));
        return Ok(files.into_iter().map(whole).collect());
    }
    let is_alone = files.len() == 1;
    let mut found: BTreeMap<u64, Stored> = BTreeMap::new();
    for path in files.into_values() {
        if Kind::of(&path) != kind {
            let message = "has no tables one behind the other, as the first file of the pattern has";
            return Err(Fault::whole(FaultKind::Data, &path, message).hint("narrow the pattern"));
        }
        let parts = kind.parts(&path)?;
        let is_counted = is_alone && parts.iter().all(|(step, _)| step.is_none());
        for (k, (step, place)) in parts.into_iter().enumerate() {
            let step = step.or(is_counted.then_some(k as u64));
            let step = step.ok_or_else(|| without_step(&path, k, is_alone))?;
            // A run that was gone on with writes the step of its restart again: the later table counts.
            let other = found.insert(step, Stored::new(path.clone(), kind, place));
            if let Some(other) = other.filter(|other| other.path != path) {
                let message = format!("has the time step {step}, and so has {}", other.path.display());
                return Err(
                    Fault::whole(FaultKind::Data, &path, message).hint("a time step is a frame: each may stand once")
                );
            }
        }
    }
    Ok(found)
}

/// The tables of each time of files whose rows are of different times, which the column `time` has. An error as of
/// [`Histories::read`].
pub fn by_time(pattern: &Path, layout: &Layout, time: &str) -> Result<BTreeMap<u64, Stored>, Fault> {
    let read = |path: &Path, number| Stored::new(path.into(), Kind::of(path), Place::Whole).read(number, layout);
    let histories = Arc::new(Histories::read(pattern, read, time)?);
    let path = histories.files[0].clone();
    let stored = |k: usize| Stored { path: path.clone(), kind: Kind::Csv, place: Place::Time(histories.clone(), k) };
    Ok((0..histories.len()).map(|k| (k as u64, stored(k))).collect())
}

/// The fault of the k-th table of a file, by whose step it would be counted.
fn without_step(path: &Path, k: usize, is_alone: bool) -> Fault {
    let message = format!("tells no time step of table {} of several, and frames are counted by these", k + 1);
    let fault = Fault::whole(FaultKind::Data, path, message);
    if is_alone { fault } else { fault.hint("give the file alone: its tables then count from 0") }
}
