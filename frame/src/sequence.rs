//! A sequence of data files, one file per frame, found by a pattern with `*`. A frame's number is the last run of digits in its
//! file's name.

use crate::{Fault, FaultKind};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The files that match `pattern`, by frame number. The file name of the pattern may have `*` (any characters), its folders may
/// not. An error if no file matches, or if two files have the same frame number.
pub fn find(pattern: &Path) -> Result<BTreeMap<u64, PathBuf>, Fault> {
    let folder = pattern.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let name = pattern.file_name().and_then(|n| n.to_str()).unwrap_or("");
    let entries = std::fs::read_dir(folder).map_err(|e| Fault::unreadable(FaultKind::Data, folder, &e))?;
    let mut found: BTreeMap<u64, PathBuf> = BTreeMap::new();
    for entry in entries {
        let path = entry.map_err(|e| Fault::unreadable(FaultKind::Data, folder, &e))?.path();
        let Some(file) = path.file_name().and_then(|n| n.to_str()) else { continue };
        if !matches(name, file) || !path.is_file() {
            continue;
        }
        let number = number_in(file).unwrap_or(0);
        if let Some(other) = found.get(&number) {
            let message = format!("has frame number {number}, and so has {}", other.display());
            return Err(Fault::whole(FaultKind::Data, &path, message)
                .hint("narrow the pattern: a frame's number is the last number in its file name"));
        }
        found.insert(number, path);
    }
    if found.is_empty() {
        let message = format!("no file matches the pattern `{name}` in {}", folder.display());
        return Err(Fault::whole(FaultKind::Data, pattern, message));
    }
    Ok(found)
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

/// The frame number in a file name: the last run of digits before the extension, if any.
pub fn number_in(file: &str) -> Option<u64> {
    let stem = file.rsplit_once('.').map_or(file, |(stem, _)| stem);
    let end = stem.rfind(|c: char| c.is_ascii_digit())? + 1;
    let start = stem[..end].rfind(|c: char| !c.is_ascii_digit()).map_or(0, |i| i + 1);
    stem[start..end].parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_patterns() {
        assert_eq!(number_in("p_0003.csv"), Some(3));
        assert_eq!(number_in("run2_frame12.dat"), Some(12));
        assert_eq!(number_in("bed.csv"), None);
        assert!(matches("p_*.csv", "p_0003.csv") && matches("bed.csv", "bed.csv") && matches("*a*b", "xaybzb"));
        assert!(!matches("p_*.csv", "q_1.csv") && !matches("bed.csv", "bed.csv2") && !matches("p_*.csv", "p_1.txt"));
    }
}
