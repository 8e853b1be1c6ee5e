//! A sequence of data files, one file per frame, found by a pattern with `*`. A frame's number is the last run of digits in its
//! file's name.

use crate::{Fault, FaultKind, dump, foreign};
use std::collections::BTreeMap;
use std::io::Read;
use std::path::{Path, PathBuf};

/// The files that match `pattern`, by frame number. The file name of the pattern may have `*` (any characters), its folders may
/// not. An error if no file matches, or if two files have the same frame number.
pub fn find(pattern: &Path) -> Result<BTreeMap<u64, PathBuf>, Fault> {
    let folder = pattern.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let name = pattern.file_name().and_then(|n| n.to_str()).unwrap_or("");
    let entries = guard::permit(folder)
        .and_then(|()| std::fs::read_dir(folder))
        .map_err(|e| Fault::unreadable(FaultKind::Data, folder, &e))?;
    let mut files: Vec<PathBuf> = vec![];
    for entry in entries {
        let path = entry.map_err(|e| Fault::unreadable(FaultKind::Data, folder, &e))?.path();
        let Some(file) = path.file_name().and_then(|n| n.to_str()) else { continue };
        if !matches(name, file) || path.is_dir() {
            continue;
        }
        if !path.is_file() {
            let message = "is no file that can be read: a device, a pipe, or a link to a file that is gone";
            return Err(Fault::whole(FaultKind::Data, &path, message));
        }
        files.push(path);
    }
    files.sort();
    // Numbers behind the last `*` are the same in all names.
    let same =
        name.rsplit_once('*').map(|(_, same)| same).filter(|same| digits(same).is_some() && !same.starts_with('.'));
    let counted = |path: &Path| {
        let file = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        same.and_then(|same| file.strip_suffix(same)).map_or(file.clone(), |rest| format!("{rest}.csv"))
    };
    let names: Vec<String> = files.iter().map(|path| counted(path)).collect();
    let decimals = decimals(&names, &files, pattern)?;
    let mut found: BTreeMap<u64, PathBuf> = BTreeMap::new();
    for (path, file) in files.into_iter().zip(names) {
        let own = decimals.map_or_else(|| number_in(&file), |decimals| scaled(&file, decimals));
        let number = match own {
            None if digits(&file).is_some() => {
                return Err(Fault::whole(
                    FaultKind::Data,
                    &path,
                    "has a number in its name that is too large to count by",
                ));
            }
            number => number.unwrap_or(0),
        };
        if let Some(other) = found.get(&number) {
            let message = format!("has frame number {number}, and so has {}", other.display());
            return Err(Fault::whole(FaultKind::Data, &path, message)
                .hint("a frame's number is the last number in its file name: narrow the pattern, or write what follows the number, as in `frame*_v3.csv`"));
        }
        found.insert(number, path);
    }
    if found.is_empty() {
        let message = format!("no file matches the pattern `{name}` in {}", folder.display());
        return Err(Fault::whole(FaultKind::Data, pattern, message));
    }
    Ok(found)
}

/// The fault of a folder that is no run directory, with what is in it.
pub fn not_a_run(folder: &Path) -> Fault {
    let fault = |message: &str| Fault::whole(FaultKind::Data, folder, format!("is not a run directory: {message}"));
    let entries = match std::fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(e) => return Fault::unreadable(FaultKind::Data, folder, &e),
    };
    let mut tables: BTreeMap<String, Vec<String>> = BTreeMap::new();
    let (mut runs, mut others) = (Vec::new(), Vec::new());
    for path in entries.flatten().map(|entry| entry.path()) {
        let name = path.file_name().unwrap_or_default().to_string_lossy().to_string();
        if path.is_dir() {
            runs.extend(path.join("run.json").is_file().then(|| path.display().to_string()));
        } else if is_table(&path) || is_dump(&path) {
            tables.entry(pattern_of(&name)).or_default().push(name);
        } else {
            others.extend(foreign::by_ending(&path).map(|format| (name, format)));
        }
    }
    runs.sort();
    others.sort_by(|(a, _), (b, _)| a.cmp(b));
    let place = |name: &str| folder.join(name).display().to_string();
    if let Some((pattern, names)) = tables.iter().max_by_key(|(_, names)| names.len()) {
        let files = if names.len() == 1 { "file that is a table" } else { "files that are tables" };
        return fault(&format!("it has no run.json, but {} {files}", names.len())).hint(format!(
            "give them as a pattern: scree inspect '{}' --write md.yaml; scree render md.yaml",
            place(pattern)
        ));
    }
    if !runs.is_empty() {
        let shown = runs.iter().take(3).map(String::as_str).collect::<Vec<_>>().join(", ");
        let more = if runs.len() > 3 { ", …" } else { "" };
        return fault(&format!("it has no run.json, but {} of its folders do", runs.len()))
            .hint(format!("give one: {shown}{more}"));
    }
    match others.first() {
        Some((name, format)) => {
            let found = format.fault(&folder.join(name));
            Fault {
                message: format!("{}; {name} {}", fault("it has no run.json, and no tables").message, found.message),
                ..found
            }
        }
        None => fault("it has no run.json, and no tables")
            .hint("a table is a file, as CSV or VTK, with a row for each particle"),
    }
}

/// Whether a file begins as the dumps of LAMMPS and LIGGGHTS do, whatever its name ends in.
fn is_dump(path: &Path) -> bool {
    let mut start = [0; 6];
    let read = guard::permit(path).and_then(|()| std::fs::File::open(path));
    path.is_file() && read.and_then(|mut file| file.read_exact(&mut start)).is_ok() && dump::is_dump(&start)
}

/// A file's name without the ending of what is packed by gzip.
fn unpacked(name: &str) -> &str {
    [".gz", ".GZ"].iter().find_map(|ending| name.strip_suffix(ending)).unwrap_or(name)
}

/// Whether a file is a table by the ending of its name.
pub fn is_table(path: &Path) -> bool {
    let name = path.file_name().and_then(|name| name.to_str()).unwrap_or("");
    let ending = unpacked(name).rsplit_once('.').map_or("", |(_, ending)| ending).to_lowercase();
    let text = ["csv", "tsv", "txt", "dat", "tab", "asc", "prn"];
    let particles = ["dump", "lammpstrj", "liggghts", "xyz", "extxyz", "ply", "data"];
    let other = ["vtk", "vtu", "vtp", "pvtu", "pvtp", "pvd", "parquet", "pq", "arrow", "feather"];
    [&text[..], &particles, &other].iter().any(|endings| endings.contains(&ending.as_str()))
}

/// The pattern of a file and its like: the last number of its name may be any.
fn pattern_of(name: &str) -> String {
    let stem = name.rfind('.').unwrap_or(name.len());
    let Some(last) = name[..stem].rfind(|c: char| c.is_ascii_digit()) else { return name.into() };
    let first = name[..last]
        .rfind(|c: char| !c.is_ascii_digit())
        .map_or(0, |i| i + name[i..].chars().next().map_or(1, char::len_utf8));
    format!("{}*{}", &name[..first], &name[last + 1..])
}

/// Whether `name` matches `pattern`, in which `*` stands for any characters.
pub fn matches(pattern: &str, name: &str) -> bool {
    let mut parts = pattern.split('*');
    let first = parts.next().unwrap_or("");
    let Some(mut rest) = name.strip_prefix(first) else { return false };
    let mut parts: Vec<&str> = parts.collect();
    let Some(last) = parts.pop() else { return rest.is_empty() };
    for part in parts {
        match rest.find(part) {
            Some(at) => rest = &rest[at + part.len()..],
            None => return false,
        }
    }
    rest.ends_with(last)
}

/// The digits before and behind the point of a number at the end of a file's name, as of a time: `p_0.15.csv`, `p_1.5e-01.csv`.
fn fraction(file: &str) -> Option<(String, String)> {
    let file = unpacked(file);
    let stem = file.rsplit_once('.').map_or(file, |(stem, _)| stem);
    if let Some(number) = scientific(stem) {
        return Some(number);
    }
    let (whole, fraction) = stem.rsplit_once('.')?;
    let start = whole.rfind(|c: char| !c.is_ascii_digit()).map_or(0, |i| i + 1);
    let is_number = start < whole.len() && whole.is_char_boundary(start);
    let is_fraction = !fraction.is_empty() && fraction.bytes().all(|b| b.is_ascii_digit());
    (is_number && is_fraction).then(|| (whole[start..].into(), fraction.into()))
}

/// The same of a number with an exponent that has a sign.
fn scientific(stem: &str) -> Option<(String, String)> {
    /// Exponents beyond it are no times.
    const MOST: usize = 18;
    let at = stem.rfind(['e', 'E'])?;
    let exponent = &stem[at + 1..];
    let (is_negative, size) = match exponent.split_at_checked(1)? {
        ("-", size) => (true, size),
        ("+", size) => (false, size),
        _ => return None,
    };
    let shift = size.parse::<usize>().ok().filter(|shift| *shift <= MOST)?;
    let start = stem[..at].rfind(|c: char| !c.is_ascii_digit() && c != '.').map_or(0, |i| i + 1);
    let mantissa = stem.get(start..at)?.trim_start_matches('.');
    let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    if whole.is_empty() || fraction.contains('.') {
        return None;
    }
    let all = format!("{whole}{fraction}");
    let (whole, fraction) = if is_negative {
        let all = format!("{}{all}", "0".repeat((shift + 1).saturating_sub(whole.len())));
        let point = all.len() - fraction.len() - shift;
        (all[..point].to_string(), all[point..].to_string())
    } else {
        let all = format!("{all}{}", "0".repeat(shift.saturating_sub(fraction.len())));
        let point = whole.len() + shift;
        (all[..point].to_string(), all[point..].to_string())
    };
    Some((whole, fraction.trim_end_matches('0').to_string()))
}

/// Decimals by which the numbers in the names of files are counted; none where they are whole numbers, or where all have the same digits
/// before the point, so that those behind it count. An error if it is not known which.
fn decimals(names: &[String], files: &[PathBuf], pattern: &Path) -> Result<Option<usize>, Fault> {
    let stem = |name: &String| {
        let name = unpacked(name);
        name.rsplit_once('.').map_or(name, |(stem, _)| stem).to_string()
    };
    let fractions: Vec<(String, String)> = names.iter().filter_map(|name| fraction(name)).collect();
    let longest = fractions.iter().map(|(_, fraction)| fraction.len()).max().unwrap_or(0);
    if names.iter().any(|name| scientific(&stem(name)).is_some()) {
        return Ok(Some(longest));
    }
    let Some(((whole, first), i)) = fractions.first().zip(names.iter().position(|name| fraction(name).is_some()))
    else {
        return Ok(None);
    };
    if files.len() == 1 {
        return Ok(None);
    }
    let is_one_whole = fractions.len() == files.len() && fractions.iter().all(|(w, _)| w == whole);
    match (is_one_whole, fractions.iter().all(|(_, f)| f.len() == first.len())) {
        (true, true) => Ok(None),
        // Times below one.
        (true, false) if whole != "0" => {
            let message = "has a number with a point in its name, and so have the others, of other lengths: they are times or versions";
            let pattern = pattern.display();
            Err(Fault::whole(FaultKind::Data, &files[i], message).hint(format!(
                "number the files, in this order: n=0; for f in $(ls {pattern} | sort -V); do mv \"$f\" frame_$(printf %06d $n).csv; n=$((n+1)); done"
            )))
        }
        _ => Ok(Some(longest)),
    }
}

/// The number at the end of a file's name in units of its last decimal: `p_0.5.csv` is 50 of two decimals.
fn scaled(file: &str, decimals: usize) -> Option<u64> {
    let (whole, fraction) = fraction(file).or_else(|| Some((digits(file)?.to_string(), String::new())))?;
    format!("{whole}{fraction:0<decimals$}").parse().ok()
}

/// The frame number in a file name, if any: its ending if that is one, `dump.100`, or else the last run of digits before that.
pub fn number_in(file: &str) -> Option<u64> {
    digits(file)?.parse().ok()
}

/// The last run of digits of a file name: its ending, or before that. What follows a digit and a point is no ending, but a fraction.
fn digits(file: &str) -> Option<&str> {
    let file = unpacked(file);
    let (stem, ending) = file.rsplit_once('.').unwrap_or((file, ""));
    let is_number = !ending.is_empty() && ending.bytes().all(|b| b.is_ascii_digit());
    if is_number && !stem.ends_with(|c: char| c.is_ascii_digit()) {
        return Some(ending);
    }
    let end = stem.rfind(|c: char| c.is_ascii_digit())? + 1;
    let start = stem[..end].rfind(|c: char| !c.is_ascii_digit()).map_or(0, |i| i + 1);
    Some(&stem[start..end])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_that_is_no_run_is_described() {
        let scratch = tempfile::tempdir().unwrap();
        let folder = scratch.path();
        std::fs::create_dir_all(folder.join("one")).unwrap();
        let write = |name: &str| std::fs::write(folder.join(name), "x").unwrap();
        assert!(not_a_run(folder).message.contains("no tables"));
        write("a.h5");
        assert!(not_a_run(folder).message.contains("a.h5 is an HDF5 file"));
        write("one/run.json");
        assert!(not_a_run(folder).message.contains("1 of its folders"));
        ["p_1.csv", "p_2.csv", "readme.txt"].iter().for_each(|name| write(name));
        let fault = not_a_run(folder);
        assert!(fault.message.contains("2 files that are tables") && fault.hint.unwrap().contains("p_*.csv"));
        // Dumps may have any names.
        for k in 1..=3 {
            std::fs::write(folder.join(format!("dump{k}000.fill")), "ITEM: TIMESTEP\n1\n").unwrap();
        }
        let fault = not_a_run(folder);
        assert!(fault.message.contains("3 files that are tables"), "{fault}");
        assert!(fault.hint.unwrap().contains("dump*.fill"));
    }

    #[test]
    fn numbers_with_a_point_count_by_their_decimals() {
        let numbers = |names: &[&str]| {
            let scratch = tempfile::tempdir().unwrap();
            names.iter().for_each(|name| std::fs::write(scratch.path().join(name), "").unwrap());
            find(&scratch.path().join("*.csv")).map(|found| found.into_keys().collect::<Vec<_>>())
        };
        assert_eq!(numbers(&["t0.5.csv", "t1.csv", "t1.25.csv"]).unwrap(), [50, 100, 125]);
        assert_eq!(numbers(&["run2.0001.csv", "run2.0010.csv"]).unwrap(), [1, 10]);
        assert_eq!(numbers(&["run2.5.csv"]).unwrap(), [5]);
        assert_eq!(numbers(&["t_0.1.csv", "t_0.25.csv"]).unwrap(), [10, 25]);
        assert_eq!(numbers(&["t_3e-03.csv", "t_2e-04.csv", "t_1e-05.csv"]).unwrap(), [1, 20, 300]);
        assert_eq!(numbers(&["out_1.00e-05.csv", "out_2.50e-05.csv", "out_1.2e+00.csv"]).unwrap(), [10, 25, 1_200_000]);
        assert_eq!(numbers(&["t2e+03.csv", "t1.5e+02.csv"]).unwrap(), [150, 2000]);
        let fault = numbers(&["run2.9.csv", "run2.10.csv"]).unwrap_err();
        assert!(fault.message.contains("times or versions") && fault.hint.unwrap().contains("*.csv"));
        assert!(numbers(&["t1.5.csv", "t99999999999999999999.5.csv"]).is_err());
    }

    #[test]
    fn what_follows_the_star_is_no_number() {
        let scratch = tempfile::tempdir().unwrap();
        for name in ["sim1_frame2_v3.csv", "sim1_frame10_v3.csv"] {
            std::fs::write(scratch.path().join(name), "").unwrap();
        }
        assert!(find(&scratch.path().join("sim1_*.csv")).unwrap_err().hint.unwrap().contains("frame*_v3.csv"));
        let found = find(&scratch.path().join("sim1_frame*_v3.csv")).unwrap();
        assert_eq!(found.into_keys().collect::<Vec<_>>(), [2, 10]);
    }

    #[test]
    fn numbers_and_patterns() {
        assert_eq!(number_in("p_0003.csv"), Some(3));
        assert_eq!(number_in("run2_frame12.dat"), Some(12));
        assert_eq!(["bed.csv", "bed", "bed.csv.gz"].map(number_in), [None; 3]);
        let numbered = ["p_0007.csv.gz", "dump.7", "dump.7.gz", "run1.data.7", "p_7.mp4.gz", "p_7.5"];
        assert_eq!(numbered.map(number_in), [Some(7); 6]);
        let fractions =
            ["p_0.15.csv", "p.15.csv", "p_0.15b.csv", "v1.2_3.csv", "p_0.15.csv.gz", "p_15.csv.gz"].map(fraction);
        let some = || Some(("0".to_string(), "15".to_string()));
        assert_eq!(fractions, [some(), None, None, None, some(), None]);
        assert!(is_table(Path::new("a.CSV.gz")) && !is_table(Path::new("a.rib.gz")));
        assert!(matches("p_*.csv", "p_0003.csv") && matches("bed.csv", "bed.csv") && matches("*a*b", "xaybzb"));
        assert_eq!(
            ["p_0003.csv", "bed.csv", "7.txt", "é2_3b.dat"].map(pattern_of),
            ["p_*.csv", "bed.csv", "*.txt", "é2_*b.dat"]
        );
        assert!(!matches("p_*.csv", "q_1.csv") && !matches("bed.csv", "bed.csv2") && !matches("p_*.csv", "p_1.txt"));
    }
}
