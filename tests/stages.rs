//! The stages of the step: the heads of their files say what the table of columns says.

use sim::stages::{COLUMNS, Stage};
use std::collections::BTreeSet;
use std::path::PathBuf;

/// The columns that the head of a stage's file says to come in, and to go out: lines `//! in name …`, `out` or `inout`.
fn head(text: &str) -> [BTreeSet<String>; 2] {
    let mut found = [BTreeSet::new(), BTreeSet::new()];
    for line in text.lines().map_while(|line| line.strip_prefix("//!")) {
        let mut words = line.split_whitespace();
        let (direction, name) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
        if ["in", "inout"].contains(&direction) {
            found[0].insert(name.to_string());
        }
        if ["out", "inout"].contains(&direction) {
            found[1].insert(name.to_string());
        }
    }
    found
}

#[test]
fn heads_are_read() {
    let [reads, writes] = head("//! Do it.\n//! in   a  [n]  m\n//! inout  b\n//! out    c\n\n//! in d\n");
    assert_eq!([reads.len(), writes.len()], [2, 2]);
    assert!(reads.contains("a") && reads.contains("b") && writes.contains("b") && writes.contains("c"));
}

#[test]
fn every_stage_has_a_file_whose_head_is_the_table() {
    // The sort is the gpu crate's, where its kernel stands beside it: what it reads is what it writes.
    for stage in Stage::ALL.into_iter().filter(|stage| *stage != Stage::BinSort) {
        let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join(format!("sim/src/cpu/{}.rs", stage.name()));
        let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let named = |stages: fn(&sim::stages::Spec) -> &'static [Stage]| -> BTreeSet<String> {
            COLUMNS.iter().filter(|spec| stages(spec).contains(&stage)).map(|spec| spec.name.to_string()).collect()
        };
        let [reads, writes] = head(&text);
        assert_eq!(reads, named(|spec| spec.readers), "what comes in: {} against COLUMNS", path.display());
        assert_eq!(writes, named(|spec| spec.writers), "what goes out: {} against COLUMNS", path.display());
    }
}

#[test]
fn every_column_is_written_before_it_is_read() {
    let place = |stage: Stage| Stage::ALL.iter().position(|s| *s == stage).unwrap();
    for spec in COLUMNS {
        let first = spec.writers.iter().map(|s| place(*s)).min().unwrap();
        let early: Vec<&Stage> = spec.readers.iter().filter(|s| place(**s) < first).collect();
        // What integration has moved comes from the step before.
        let is_state = spec.writers.contains(&Stage::Integrate);
        assert!(early.is_empty() || is_state, "`{}` is read by {early:?} before it is written", spec.name);
    }
}
