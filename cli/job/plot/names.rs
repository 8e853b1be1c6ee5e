//! Names of runs in a legend: what differs between the names of their folders.

use std::path::{Path, PathBuf};

/// The name of a run: that of its folder, or of its file.
pub fn name_of(path: &Path) -> String {
    let name = |p: &Path| p.file_name().map(|n| n.to_string_lossy().to_string());
    name(path).or_else(|| name(&path.canonicalize().ok()?)).unwrap_or_else(|| path.display().to_string())
}

/// The labels of runs: the parts of their names that not all have, else their names, else their paths.
pub fn labels(paths: &[PathBuf]) -> Vec<String> {
    let names: Vec<String> = paths.iter().map(|p| name_of(p)).collect();
    let parts: Vec<Vec<String>> = names.iter().map(|n| parts(n)).collect();
    let is_common = |part: &String| parts.iter().all(|own| own.contains(part));
    let own = |own: &Vec<String>| own.iter().filter(|p| !is_common(p)).cloned().collect::<Vec<_>>().join(", ");
    let differences: Vec<String> = parts.iter().map(own).collect();
    let are_distinct = |labels: &[String]| {
        labels.iter().enumerate().all(|(i, label)| !label.is_empty() && !labels[..i].contains(label))
    };
    match () {
        () if paths.len() > 1 && are_distinct(&differences) => differences,
        () if are_distinct(&names) => names,
        () => paths.iter().map(|p| p.display().to_string()).collect(),
    }
}

/// The parts of a name as sweeps make it, `gravity=0_0_-9.81_friction=0.3`: a key with its value each. A number goes on the value
/// before it, a word begins the key after it.
fn parts(name: &str) -> Vec<String> {
    let mut parts: Vec<String> = vec![];
    let mut is_open = false;
    for word in name.split('_') {
        let is_number = word.starts_with(|c: char| c.is_ascii_digit() || c == '-' || c == '+' || c == '.');
        match parts.last_mut() {
            Some(last) if is_open || (is_number && !word.contains('=')) => *last += &format!("_{word}"),
            _ => parts.push(word.into()),
        }
        is_open = !word.contains('=') && !is_number;
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_are_named_by_what_differs() {
        for (paths, expected) in [
            (&["s/friction=0.1", "s/friction=0.3"][..], &["friction=0.1", "friction=0.3"][..]),
            (
                &["s/gravity=0_0_-9.81_friction=0.1", "s/gravity=0_0_-9.81_friction=0.3"],
                &["friction=0.1", "friction=0.3"],
            ),
            (
                &["s/gravity=0_0_-9.81_push_speed=1", "s/gravity=0_0_-1.6_push_speed=1"],
                &["gravity=0_0_-9.81", "gravity=0_0_-1.6"],
            ),
            (&["a/run", "b/run"], &["a/run", "b/run"]),
            (&["soft_ground", "hard_ground"], &["soft_ground", "hard_ground"]),
            (&["only=1"], &["only=1"]),
        ] {
            let paths: Vec<PathBuf> = paths.iter().map(PathBuf::from).collect();
            assert_eq!(labels(&paths), expected);
        }
    }
}
