//! Broken files of every kind: each is answered with file, line and column, and none with a panic.

use crate::cli::scree;
use std::path::{Path, PathBuf};

#[test]
fn broken_files_are_answered_with_their_place() {
    for (kind, ending) in [("model", "yaml"), ("metadata", "yaml"), ("rib", "rib"), ("shader", "sl")] {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/corpus/broken").join(kind);
        let mut files: Vec<PathBuf> = std::fs::read_dir(&folder).unwrap().map(|e| e.unwrap().path()).collect();
        files.retain(|f| f.extension().is_some_and(|e| e == ending));
        files.sort();
        assert!(files.len() >= 10, "{} has {} files", folder.display(), files.len());
        for file in files {
            let path = file.to_str().unwrap();
            let said = scree(&["check", path]).fails(3);
            let placed =
                said.lines().next().and_then(|l| l.split_once(&format!("{path}:"))).map(|(_, rest)| rest.to_string());
            let numbers: Vec<&str> = placed.as_deref().unwrap_or("").split(':').collect();
            let has_place = numbers.len() > 2 && numbers[..2].iter().all(|n| n.parse::<u32>().is_ok_and(|n| n > 0));
            assert!(has_place, "{path}: no place in: {said}");
            assert!(!said.contains("internal") && !said.contains("panicked"), "{said}");
            // A file that names the line of its fault is held to it.
            let text = std::fs::read(&file).unwrap();
            let text = String::from_utf8_lossy(&text);
            if let Some(line) = text.lines().position(|l| l.contains("FAULT")) {
                assert_eq!(numbers[0], (line + 1).to_string(), "{said}");
            }
        }
    }
}
