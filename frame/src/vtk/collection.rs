//! Files of VTK that name others: the pieces of `.pvtu` and `.pvtp`, and the data sets of a ParaView collection, `.pvd`
//! (ParaView's guide, "PVD File Format").

use super::xml::File;
use crate::{Fault, FaultKind, sequence};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A frame of a collection.
#[derive(Clone, Debug, PartialEq)]
pub struct DataSet {
    /// Time, s.
    pub time: f64,
    /// The files of its parts.
    pub files: Vec<PathBuf>,
}

/// The files of the pieces of a parallel file. An error if one is named twice.
pub(super) fn pieces(file: &File<'_>) -> Result<Vec<PathBuf>, Fault> {
    let mut found: Vec<PathBuf> = vec![];
    let mut seen = std::collections::HashSet::new();
    for piece in file.data()?.all("Piece") {
        let name = piece.get("Source").ok_or_else(|| file.source.fault(piece.at, "expected `Source`, a file"))?;
        let path = beside(file.source.path, name);
        if !seen.insert(path.clone()) {
            return Err(file.source.fault(piece.at, format!("names `{name}` a second time")));
        }
        found.push(path);
    }
    Ok(found)
}

/// The data sets of a collection, by frame number: the last number in a file's name, or where files of several times have one name, as
/// in folders of their own, their time in units of its last decimal. An error if two are of one number, and not parts of one time.
pub(super) fn data_sets(file: &File<'_>) -> Result<BTreeMap<u64, DataSet>, Fault> {
    let of_names = numbered(file, |name, _| sequence::number_in(name));
    let Err(fault) = of_names else { return of_names };
    let times: Vec<&str> = file.data()?.all("DataSet").filter_map(|set| set.get("timestep")).collect();
    let decimals = times.iter().map(|time| time.trim().split_once('.').map_or(0, |(_, f)| f.len())).max().unwrap_or(0);
    if times.iter().any(|time| time.contains(['e', 'E'])) || decimals > 12 {
        return Err(fault);
    }
    let of_time = |time: f64| Some((time * 10f64.powi(decimals as i32)).round()).filter(|t| (0.0..1e15).contains(t));
    numbered(file, |_, time| of_time(time).map(|t| t as u64)).map_err(|_| fault)
}

/// The data sets of a collection by numbers that names and times tell.
fn numbered(file: &File<'_>, number: impl Fn(&str, f64) -> Option<u64>) -> Result<BTreeMap<u64, DataSet>, Fault> {
    let fault = |at: usize, message: String| file.source.fault(at, message);
    let mut found: BTreeMap<u64, DataSet> = BTreeMap::new();
    for set in file.data()?.all("DataSet") {
        let name = set.get("file").ok_or_else(|| fault(set.at, "expected `file`".into()))?;
        let time = match set.get("timestep").map(str::trim) {
            None | Some("") => 0.0,
            Some(text) => {
                text.parse().map_err(|_| fault(set.at, format!("has the time `{text}`, which is no number")))?
            }
        };
        let path = beside(file.source.path, name);
        let own = path.file_name().and_then(|name| name.to_str()).unwrap_or("");
        let number = number(own, time);
        if number.is_none() && own.split('.').next().is_some_and(|stem| stem.contains(|c: char| c.is_ascii_digit())) {
            return Err(fault(set.at, format!("names `{name}`, whose number is too large to count by")));
        }
        let number = number.unwrap_or(0);
        let set_of = found.entry(number).or_insert(DataSet { time, files: vec![] });
        if set_of.time != time || set_of.files.contains(&path) {
            let other = set_of.files[0].display();
            let hint = "a frame's number is the last number in its file's name; parts of one time may have one number";
            return Err(fault(set.at, format!("has frame number {number}, and so has {other}")).hint(hint));
        }
        set_of.files.push(path);
    }
    if found.is_empty() {
        return Err(Fault::whole(FaultKind::Data, file.source.path, "has no data sets"));
    }
    Ok(found)
}

/// The path of a file that another names.
fn beside(path: &Path, name: &str) -> PathBuf {
    path.parent().unwrap_or(Path::new("")).join(name)
}
