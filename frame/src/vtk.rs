//! Files of VTK and ParaView as frames: legacy (`.vtk`), XML (`.vtu`, `.vtp`), in pieces (`.pvtu`, `.pvtp`), and collections of time
//! steps (`.pvd`).
//!
//! A point is a row: x, y and z, and a column for each component of the arrays that have a tuple for each point. Arrays of three
//! components become `NAME_x`, `NAME_y` and `NAME_z`, of others `NAME_0`, `NAME_1` …; the second of two columns of one name is
//! `NAME_2`. Arrays of cells count where each cell is one point. Arrays of words, and cells, are left out.
//!
//! The reader is its own: the crate `vtkio` reads no collections, and reads no legacy files of version 5.

mod arrays;
mod collection;
mod encoding;
mod legacy;
mod xml;

pub use collection::DataSet;

use crate::{Fault, FaultKind, Frame, gzip};
use arrays::{Points, Source};
use std::collections::BTreeMap;
use std::path::Path;
use xml::File;

/// Kinds of VTK files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A table of points, or pieces of one.
    Points,
    /// A collection of time steps.
    Collection,
}

/// The kind of a file that begins with these bytes, if it is one of VTK.
pub fn kind_of(head: &[u8]) -> Option<Kind> {
    if head.starts_with(legacy::MAGIC) {
        return Some(Kind::Points);
    }
    let text = head.strip_prefix(crate::text::MARK.as_bytes()).unwrap_or(head).trim_ascii_start();
    let start = memchr::memmem::find(text, b"<VTKFile").filter(|_| text.starts_with(b"<"))?;
    let end = memchr::memchr(b'>', &text[start..]).map_or(text.len(), |length| start + length);
    let is_collection = memchr::memmem::find(&text[start..end], b"Collection").is_some();
    Some(if is_collection { Kind::Collection } else { Kind::Points })
}

/// Read a file as the frame `number`. Its time is 0 if it tells none.
pub fn read(path: &Path, number: u64) -> Result<Frame, Fault> {
    Ok(points(path, true)?.frame(number))
}

/// Read the files of a data set as the frame `number`.
pub fn read_set(set: &DataSet, number: u64) -> Result<Frame, Fault> {
    let mut all = Points::default();
    for path in &set.files {
        add(&mut all, path, true)?;
    }
    Ok(Frame { time: set.time, ..all.frame(number) })
}

/// The data sets of a collection, by frame number.
pub fn data_sets(path: &Path) -> Result<BTreeMap<u64, DataSet>, Fault> {
    let bytes = gzip::read(path)?;
    collection::data_sets(&File::open(Source { path, bytes: &bytes })?)
}

/// The points of a file; of pieces only if they may be there.
fn points(path: &Path, may_have_pieces: bool) -> Result<Points, Fault> {
    let bytes = gzip::read(path)?;
    points_of(path, &bytes, may_have_pieces)
}

/// The points of the bytes of a file.
fn points_of(path: &Path, bytes: &[u8], may_have_pieces: bool) -> Result<Points, Fault> {
    let source = Source { path, bytes };
    if bytes.starts_with(legacy::MAGIC) {
        return legacy::points(source);
    }
    let file = File::open(source)?;
    match file.kind() {
        "UnstructuredGrid" | "PolyData" => file.points(),
        "PUnstructuredGrid" | "PPolyData" if may_have_pieces => {
            let mut all = Points::default();
            for piece in collection::pieces(&file)? {
                add(&mut all, &piece, false).map_err(|fault| match fault.hint {
                    None => fault.hint(format!("it is a piece of {}", path.display())),
                    Some(_) => fault,
                })?;
            }
            Ok(all)
        }
        kind => {
            let message = format!("has the type `{kind}`, expected UnstructuredGrid or PolyData: particles are points");
            Err(source.fault(file.root.at, message))
        }
    }
}

/// Add the points of a file to others.
fn add(all: &mut Points, path: &Path, may_have_pieces: bool) -> Result<(), Fault> {
    let own = points(path, may_have_pieces)?;
    let fault = |message: String| Fault::whole(FaultKind::Data, path, message);
    all.append(own).map_err(fault)?;
    guard::memory::check().map_err(|e| fault(format!("is too large together with the pieces before it: {e}")))
}

#[cfg(test)]
mod tests;
