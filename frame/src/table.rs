//! Tables of other programs: where the frames of a pattern of files stand, and each of them read by what its file is.

use crate::csv::{self, Layout};
use crate::part::Part;
use crate::{Fault, FaultKind, Frame, chrono, dump, gzip, mercury, ply, sequence, xyz};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

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
}

impl Kind {
    /// The kind of a file; CSV if it is no other, and where it cannot be opened.
    pub fn of(path: &Path) -> Kind {
        /// Bytes that are looked at.
        const START: u64 = 1 << 14;
        let start = gzip::start(path, START);
        let kinds: [(fn(&[u8]) -> bool, Kind); 5] = [
            (dump::is_dump, Kind::Dump),
            (ply::is_ply, Kind::Ply),
            (xyz::is_xyz, Kind::Xyz),
            (mercury::is_mercury, Kind::Mercury),
            (chrono::is_chrono, Kind::Chrono),
        ];
        kinds.into_iter().find(|(is, _)| is(&start)).map_or(Kind::Csv, |(_, kind)| kind)
    }

    /// The tables of a file that may have several; none if its kind has one a file.
    fn parts(self, path: &Path) -> Result<Vec<Part>, Fault> {
        match self {
            Kind::Dump => dump::parts(path),
            Kind::Xyz => xyz::parts(path),
            Kind::Mercury => mercury::parts(path),
            Kind::Csv | Kind::Ply | Kind::Chrono => Ok(vec![]),
        }
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
    part: Option<Part>,
}

impl Stored {
    /// Read the table as the frame `number`; a CSV file by its layout.
    pub fn read(&self, number: u64, layout: &Layout) -> Result<Frame, Fault> {
        match self.kind {
            Kind::Csv => csv::read(&self.path, number, layout),
            Kind::Dump => dump::read(&self.path, self.part.as_ref(), number),
            Kind::Xyz => xyz::read(&self.path, self.part.as_ref(), number),
            Kind::Ply => ply::read(&self.path, number),
            Kind::Mercury => mercury::read(&self.path, self.part.as_ref(), number),
            Kind::Chrono => chrono::read(&self.path, number),
        }
    }
}

/// The tables of the files that match a pattern, by frame number: the last number in a file's name, or the time step where a file has
/// several tables. Those of one file that tells no steps count from 0. An error as of [`sequence::find`].
pub fn find(pattern: &Path) -> Result<BTreeMap<u64, Stored>, Fault> {
    let files = sequence::find(pattern)?;
    let kind = files.values().next().map_or(Kind::Csv, |first| Kind::of(first));
    let several = match files.values().next() {
        Some(first) => kind.parts(first)?.len() > 1,
        None => false,
    };
    if !several {
        let whole = |(number, path): (u64, PathBuf)| (number, Stored { kind: Kind::of(&path), path, part: None });
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
        let is_counted = is_alone && parts.iter().all(|part| part.step.is_none());
        for (k, part) in parts.into_iter().enumerate() {
            let step = part.step.or(is_counted.then_some(k as u64));
            let step = step.ok_or_else(|| without_step(&path, k, is_alone))?;
            let stored = Stored { path: path.clone(), kind, part: Some(part) };
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

/// The fault of the k-th table of a file, by whose step it would be counted.
fn without_step(path: &Path, k: usize, is_alone: bool) -> Fault {
    let message = format!("tells no time step of table {} of several, and frames are counted by these", k + 1);
    let fault = Fault::whole(FaultKind::Data, path, message);
    if is_alone { fault } else { fault.hint("give the file alone: its tables then count from 0") }
}
