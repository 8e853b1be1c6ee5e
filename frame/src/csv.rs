//! CSV files as frames: any columns, separated by comma, semicolon, tab or blanks, with or without a header.
//!
//! A header cell may have a unit in square brackets, `speed [m/s]`. Lines that start with `#` are comments. A column is a column of
//! numbers if all its cells are numbers, otherwise a column of words. Without a header, columns are named `c1`, `c2` and so on.

use crate::{Column, Fault, FaultKind, Field, Frame, read_text};
use std::collections::HashMap;
use std::fmt::Write;
use std::path::Path;

/// The layout of a CSV file; what is `None` is detected from the file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layout {
    /// The delimiter of cells, an ASCII character.
    pub delimiter: Option<u8>,
    /// Whether the first line names the columns.
    pub header: Option<bool>,
    /// Names of the columns, which replace those of a header.
    pub names: Option<Vec<String>>,
    /// Minimum count of cells in a row; numbers missing after these are 0. If not given, every row must have all its cells.
    pub min_cells: Option<usize>,
}

/// Read a CSV file as the frame `number`, at time 0. An error, with its line and column, if the file cannot be read, has no rows or
/// has a row with missing or surplus cells.
pub fn read(path: &Path, number: u64, layout: &Layout) -> Result<Frame, Fault> {
    let text = read_text(FaultKind::Data, path)?;
    parse(path, &text, number, layout)
}

fn parse(path: &Path, text: &str, number: u64, layout: &Layout) -> Result<Frame, Fault> {
    let fault =
        |line: usize, column: usize, message: String| Fault::at(FaultKind::Data, path, text, line, column, message);
    let mut lines = text
        .trim_start_matches('\u{feff}')
        .lines()
        .enumerate()
        .map(|(i, l)| (i + 1, l))
        .filter(|(_, l)| !l.trim().is_empty() && !l.starts_with('#'))
        .peekable();
    let Some(&(first_line, first)) = lines.peek() else {
        return Err(fault(1, 1, "has no rows".into()).hint("a table needs at least one line of numbers"));
    };
    let delimiter = layout.delimiter.unwrap_or_else(|| sniff_delimiter(first));
    let first_cells = split(first, delimiter);
    let header = layout.header.unwrap_or_else(|| first_cells.iter().any(|(_, c)| number_of(c).is_none()));
    if header {
        lines.next();
    }
    let names: Vec<String> = match &layout.names {
        Some(names) => names.clone(),
        None if header => first_cells.iter().map(|(_, c)| c.to_string()).collect(),
        None => (1..=first_cells.len()).map(|i| format!("c{i}")).collect(),
    };
    let min_cells = layout.min_cells.unwrap_or(names.len());
    if !(min_cells..=names.len()).contains(&first_cells.len()) {
        let message = format!("has {} columns, but {} are named", first_cells.len(), names.len());
        return Err(fault(first_line, 1, message));
    }
    let fields: Vec<Field> = names.iter().map(|n| field_of(n)).collect();
    let mut cells: Vec<Vec<&str>> = vec![Vec::new(); fields.len()];
    let mut last = None;
    for (line, row) in lines {
        let found = split(row, delimiter);
        if !(min_cells..=fields.len()).contains(&found.len()) {
            let at = found.last().map_or(1, |(at, _)| at + 1);
            let message = format!("row has {} cells, expected {} ({})", found.len(), fields.len(), names.join(", "));
            return Err(
                fault(line, at, message).hint("a row that is cut off at the end means that its writer was interrupted")
            );
        }
        let missing = std::iter::repeat_n((row.len(), "0"), fields.len() - found.len());
        for ((at, cell), column) in found.into_iter().chain(missing).zip(&mut cells) {
            if cell.is_empty() {
                return Err(fault(line, at + 1, "cell is empty".into()).hint("give every row a value in every column"));
            }
            column.push(cell);
        }
        last = Some(line);
    }
    if last.is_none() {
        return Err(fault(first_line, 1, "has a header but no rows".into()));
    }
    let columns = fields.into_iter().zip(cells).map(|(f, c)| (f, column_of(&c))).collect();
    Ok(Frame { number, time: 0.0, columns })
}

/// The separator of a line: the first of tab, semicolon and comma that it has, else blanks.
fn sniff_delimiter(line: &str) -> u8 {
    [b'\t', b';', b','].into_iter().find(|d| line.as_bytes().contains(d)).unwrap_or(b' ')
}

/// The cells of a line, trimmed and unquoted, each with the byte where it starts. A separator at the line's end adds no cell.
fn split(line: &str, delimiter: u8) -> Vec<(usize, &str)> {
    let mut cells = Vec::new();
    let mut start = 0;
    let mut quoted = false;
    let bytes = line.as_bytes();
    for i in 0..=bytes.len() {
        let end = i == bytes.len();
        if !end && bytes[i] == b'"' {
            quoted = !quoted;
        }
        if end || (bytes[i] == delimiter && !quoted) || (delimiter == b' ' && bytes[i] == b'\t' && !quoted) {
            let cell = line[start..i].trim();
            let skip = (delimiter == b' ' && cell.is_empty()) || (end && cell.is_empty() && !cells.is_empty());
            if !skip {
                cells.push((start, cell.trim_matches('"')));
            }
            start = i + 1;
        }
    }
    cells
}

fn field_of(name: &str) -> Field {
    match name.trim().strip_suffix(']').and_then(|n| n.split_once('[')) {
        Some((name, unit)) => Field::new(name.trim(), unit.trim()),
        None => Field::new(name.trim(), ""),
    }
}

fn number_of(cell: &str) -> Option<f64> {
    cell.parse().ok()
}

fn column_of(cells: &[&str]) -> Column {
    if let Some(whole) = cells.iter().map(|c| c.parse::<i64>().ok()).collect::<Option<Vec<_>>>() {
        return Column::I64(whole);
    }
    if let Some(numbers) = cells.iter().map(|c| number_of(c)).collect::<Option<Vec<_>>>() {
        return Column::F64(numbers);
    }
    let mut names: Vec<String> = Vec::new();
    let mut seen: HashMap<&str, u32> = HashMap::new();
    let codes = cells
        .iter()
        .map(|cell| {
            *seen.entry(cell).or_insert_with(|| {
                names.push(cell.to_string());
                names.len() as u32 - 1
            })
        })
        .collect();
    Column::Category { codes, names }
}

/// Encode a frame as CSV text: a header with units, then one line per row, numbers in their shortest exact form.
pub fn encode(frame: &Frame) -> String {
    let heads: Vec<String> = frame
        .columns
        .iter()
        .map(|(f, _)| if f.unit.is_empty() { f.name.clone() } else { format!("{} [{}]", f.name, f.unit) })
        .collect();
    let mut out = heads.join(",");
    out.push('\n');
    for row in 0..frame.rows() {
        for (i, (_, column)) in frame.columns.iter().enumerate() {
            let comma = if i > 0 { "," } else { "" };
            let _ = write!(out, "{comma}{}", column.text(row));
        }
        out.push('\n');
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read_text(text: &str) -> Result<Frame, Fault> {
        parse(Path::new("t.csv"), text, 0, &Layout::default())
    }

    #[test]
    fn separators_headers_and_units_are_found_out() {
        for text in ["x;y [m]\n1;2.5\n", "x,y [m]\n1,2.5,\n", "x\ty [m]\n1\t2.5\n", "# remark\nx  y[m]\n 1  2.5\n"] {
            let text = text.replace(
                "y [m]",
                if text.contains(' ') && !text.contains(';') && text.starts_with('#') { "y[m]" } else { "y [m]" },
            );
            let frame = read_text(&text).unwrap();
            assert_eq!(frame.names(), ["x", "y"], "{text}");
            assert_eq!(frame.columns[1].0.unit, "m");
            assert_eq!(frame.column("x"), Some(&Column::I64(vec![1])));
            assert_eq!(frame.column("y"), Some(&Column::F64(vec![2.5])));
        }
        assert_eq!(read_text("1 2\n3 4\n").unwrap().names(), ["c1", "c2"]);
    }

    #[test]
    fn a_torn_row_is_named_with_its_place() {
        let fault = read_text("x,y\n1,2\n3").unwrap_err();
        assert_eq!((fault.line, fault.column), (3, 1));
        assert_eq!(read_text("x,y\n1,\"\"\n").unwrap_err().line, 2);
    }

    #[test]
    fn what_is_written_is_read_back() {
        let mut frame = Frame::new(3, 0.0);
        frame.push("a", "m", Column::F64(vec![0.1, 1e-9]));
        frame.push("kind", "", Column::Category { codes: vec![1, 0], names: vec!["p".into(), "q".into()] });
        let back = read_text(&encode(&frame)).unwrap();
        assert_eq!(back.column("a"), frame.column("a"));
        assert_eq!(back.column("kind").unwrap().text(0), "q");
    }
}
