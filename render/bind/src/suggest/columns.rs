//! The columns of a frame by their kind, and by names that other programs write in many ways.

use frame::{Column, Frame};

/// Whether a frame has a column of numbers of this name.
pub(super) fn is_numeric(frame: &Frame, name: &str) -> bool {
    // What stands between backticks cannot have one.
    !name.contains('`') && frame.column(name).is_some_and(|c| !matches!(c, Column::Category { .. }))
}

/// The one column that is accepted and whose name is this but for capitals, units and characters between letters.
pub(super) fn only<'a>(frame: &'a Frame, simple: &str, accepts: fn(&Frame, &str) -> bool) -> Option<&'a str> {
    let mut found = frame.names().into_iter().filter(|name| simplified(name) == simple && accepts(frame, name));
    found.next().filter(|_| found.next().is_none())
}

/// A name in small letters, without a unit in brackets or behind a line, without the number of a query (EDEM: `Q02 : `), and without
/// other characters than letters and digits.
pub(super) fn simplified(name: &str) -> String {
    let name = name.split_once(['(', '[']).map_or(name, |(name, _)| name);
    let name =
        ["_mm", "_cm", "_um", "_nm", "_km", "_m"].iter().find_map(|unit| name.strip_suffix(unit)).unwrap_or(name);
    let is_query = |head: &str| head.trim().strip_prefix('Q').is_some_and(|n| n.chars().all(|c| c.is_ascii_digit()));
    let name = name.split_once(':').filter(|(head, _)| is_query(head)).map_or(name, |(_, rest)| rest);
    name.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect()
}
