//! CSV files as frames: any columns, separated by comma, semicolon, tab or blanks, with or without a header.
//!
//! A header cell may have a unit in square brackets, `speed [m/s]`. Lines that start with `#` are comments, but for one that names
//! the columns of the row below it. A column is a column of numbers if all its cells are numbers or missing, otherwise a column of
//! words. Without a header, columns are named `c1`, `c2` and so on.

mod cells;
mod numbers;
mod values;

pub(crate) use numbers::Numbers;
pub use values::number;
pub(crate) use values::words;

use crate::{Column, Fault, FaultKind, Field, Frame, foreign, gzip, repeated, text};
use cells::{Row, Rows, Unclosed};
use std::borrow::Cow;
use std::fmt::Write;
use std::path::Path;
use values::{CellKind, Decimal, Mixed, kind_of};

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
    let bytes = gzip::read(path)?;
    if let Some(format) = foreign::by_content(&bytes) {
        return Err(format.fault(path));
    }
    let text = text::decode(bytes).map_err(|at| foreign::binary(path, at))?;
    parse(path, &text, number, layout)
}

/// A column of cells: numbers if every cell that is not missing is one, else words. None if numbers in it are not written alike.
pub(crate) fn column(cells: &[&str]) -> Option<Column> {
    values::column(cells).ok().map(|(column, _)| column)
}

const ALIKE: &str = "write all numbers alike; separators of thousands are not read";

/// The text of a table, and the file that faults are told of.
#[derive(Clone, Copy)]
struct Table<'a> {
    path: &'a Path,
    text: &'a str,
}

impl Table<'_> {
    fn fault(&self, line: usize, column: usize, message: impl Into<String>) -> Fault {
        Fault::at(FaultKind::Data, self.path, self.text, line, column, message)
    }

    /// A fault at a byte of the text.
    fn fault_at(&self, byte: usize, message: impl Into<String>) -> Fault {
        let before = &self.text[..byte];
        let column = before.rsplit('\n').next().unwrap_or("").chars().count();
        self.fault(before.matches('\n').count() + 1, column + 1, message)
    }

    /// A fault at a cell, which is a slice of the text.
    fn fault_of(&self, cell: &str, message: impl Into<String>) -> Fault {
        self.fault_at((cell.as_ptr() as usize).saturating_sub(self.text.as_ptr() as usize), message)
    }

    fn unclosed(&self, Unclosed { line, at }: Unclosed) -> Fault {
        let column = self.text[..at].rsplit('\n').next().unwrap_or("").chars().count();
        self.fault(line, column + 1, "a quote opens a cell here and nothing closes it")
            .hint("a quote within a quoted cell is doubled")
    }
}

/// How the columns are named, and the first row if it is one of values.
struct Head<'a> {
    names: Vec<String>,
    /// Where the names stand, if they do.
    header: Vec<&'a str>,
    first: Option<Row>,
}

fn parse(path: &Path, text: &str, number: u64, layout: &Layout) -> Result<Frame, Fault> {
    let text = text.trim_start_matches(crate::text::MARK);
    let table = Table { path, text };
    let Some(first) = text.lines().find(|line| is_data(line)) else { return without_rows(&table, number, layout) };
    if layout == &Layout::default()
        && let Some((at, lines)) = preamble(text)
    {
        return parse(path, &text[at..], number, layout).map_err(|fault| fault.moved(lines));
    }
    let delimiter = layout.delimiter.unwrap_or_else(|| cells::sniff(first));
    let mut rows = Rows::new(text, delimiter);
    let mut row = Vec::new();
    let head = head(&table, &mut rows, &mut row, delimiter, layout)?;
    let fields: Vec<Field> = head.names.iter().map(|n| field_of(n)).collect();
    check_names(&table, &fields, &head)?;
    let again = (head.first, row.clone(), rows.clone());
    let mut numbers = vec![Numbers::default(); fields.len()];
    let mut next = match head.first {
        Some(first) => Some(first),
        None => rows.read(&mut row).map_err(|e| table.unclosed(e))?,
    };
    while let Some(found) = next {
        fit(&table, &mut row, found, &head.names, layout)?;
        row.iter().zip(&mut numbers).for_each(|(cell, column)| column.push(cell));
        next = rows.read(&mut row).map_err(|e| table.unclosed(e))?;
    }
    let others = others(&table, again, &numbers, &head.names, layout)?;
    if let Some(cell) = others.iter().filter(|_| delimiter == b',').find_map(|cells| values::grouped(cells)) {
        let message = format!(
            "has `{cell}`, which may be a thousand or more, with a separator, or a number with a decimal comma"
        );
        return Err(table
            .fault_of(cell, message)
            .hint("write numbers without separators of thousands, and with a point"));
    }
    let mut others = others.into_iter();
    let column = |numbers: Numbers| match numbers.is_other() {
        true => values::column(&others.next().unwrap_or_default()),
        false => Ok(numbers.column()),
    };
    let columns = numbers.into_iter().map(column).collect::<Result<Vec<_>, _>>();
    let columns = columns.map_err(|Mixed { comma, point }| {
        let message = format!("has `{comma}` with a comma, and `{point}` of the same column has a point");
        table.fault_of(comma, message).hint(ALIKE)
    })?;
    let (columns, decimals): (Vec<_>, Vec<_>) = columns.into_iter().unzip();
    if let Some(Decimal::Comma(cell)) = decimals.iter().find(|d| matches!(d, Decimal::Comma(_)))
        && decimals.contains(&Decimal::Point)
    {
        let message = format!("has `{cell}` with a comma, and other columns have numbers with a point");
        return Err(table.fault_of(cell, message).hint(ALIKE));
    }
    Ok(Frame { number, time: 0.0, columns: fields.into_iter().zip(columns).collect() })
}

/// Whether a line has cells: it is neither blank nor a remark.
fn is_data(line: &str) -> bool {
    !line.trim().is_empty() && cells::remark(line).is_none()
}

/// What stands above the names of the columns, as a title or `sep=;`: the byte and the count of lines where the names begin. These are
/// words, a row of as many numbers follows, and no line before them has as many cells.
fn preamble(text: &str) -> Option<(usize, usize)> {
    /// Lines that are looked at.
    const LINES: usize = 40;
    let mut start = 0;
    let mut lines = vec![];
    for (k, line) in text.split_inclusive('\n').enumerate().take(LINES) {
        if is_data(line) {
            lines.push((start, k, line.trim_end_matches(['\r', '\n'])));
        }
        start += line.len();
    }
    let of = |line: &str, kind: CellKind, delimiter: u8| {
        cells::split(line, delimiter).iter().filter(|cell| kind_of(cell) == kind).count()
    };
    let is_head = |pair: &[(usize, usize, &str)]| {
        let delimiter = cells::sniff(pair[1].2);
        let below = cells::split(pair[1].2, delimiter);
        let n = below.len();
        let is_names = n >= 3
            && cells::split(pair[0].2, delimiter).len() == n
            && of(pair[0].2, CellKind::Number, delimiter) == 0
            && of(pair[0].2, CellKind::Word, delimiter) + 1 >= n
            && (2 * of(pair[1].2, CellKind::Number, delimiter) >= n || are_units(&below, n));
        is_names.then_some((n, delimiter))
    };
    let head = lines.windows(2).position(|pair| is_head(pair).is_some()).filter(|k| *k > 0)?;
    let (n, delimiter) = is_head(&lines[head..head + 2])?;
    let is_above = |(_, _, line): &(usize, usize, &str)| cells::split(line, delimiter).len() != n;
    lines[..head].iter().all(is_above).then_some((lines[head].0, lines[head].1))
}

/// Read the rows again, for the cells of the columns that have others than plain numbers.
fn others<'a>(
    table: &Table<'_>,
    (first, mut row, mut rows): (Option<Row>, Vec<&'a str>, Rows<'a>),
    numbers: &[Numbers],
    names: &[String],
    layout: &Layout,
) -> Result<Vec<Vec<&'a str>>, Fault> {
    let places: Vec<usize> = (0..numbers.len()).filter(|k| numbers[*k].is_other()).collect();
    let mut cells = vec![Vec::new(); places.len()];
    if places.is_empty() {
        return Ok(cells);
    }
    let mut next = match first {
        Some(first) => Some(first),
        None => rows.read(&mut row).map_err(|e| table.unclosed(e))?,
    };
    while let Some(found) = next {
        fit(table, &mut row, found, names, layout)?;
        places.iter().zip(&mut cells).for_each(|(k, cells)| cells.push(row[*k]));
        next = rows.read(&mut row).map_err(|e| table.unclosed(e))?;
    }
    Ok(cells)
}

/// The frame of a text of comments alone, without rows: the last comment names the columns, unless it has numbers.
fn without_rows(table: &Table, number: u64, layout: &Layout) -> Result<Frame, Fault> {
    let comment = table.text.lines().rev().find_map(cells::remark);
    let is_number = |word: &str| !word.is_empty() && values::number(word).is_some();
    let has_numbers = |line: &str| line.split([',', ';', '\t', ' ']).any(is_number);
    if let Some(names) = comment.map(str::trim).filter(|line| !line.is_empty() && !has_numbers(line)) {
        return parse(table.path, names, number, &Layout { header: Some(true), ..layout.clone() });
    }
    let (message, hint) = match table.text.is_empty() {
        true => ("is empty", "the program that wrote it was interrupted, or has not written it yet"),
        false => ("has no rows", "a table needs a line of column names or of numbers"),
    };
    Err(table.fault(1, 1, message).hint(hint))
}

/// Read the first row, and find out how the columns are named: by it, by the remark above it, or by their places.
fn head<'a>(
    table: &Table<'_>,
    rows: &mut Rows<'a>,
    row: &mut Vec<&'a str>,
    delimiter: u8,
    layout: &Layout,
) -> Result<Head<'a>, Fault> {
    let Some(first) = rows.read(row).map_err(|e| table.unclosed(e))? else {
        return Err(table.fault(1, 1, "has no rows"));
    };
    let mut n = row.len() - usize::from(row.len() > 1 && row.last().is_some_and(|c| c.is_empty()));
    // Only a table of which nothing is said is searched for names in a remark.
    let told = layout.header.is_some() || layout.names.is_some();
    let remark = rows.remark.filter(|_| !told).and_then(|remark| names_in(remark, delimiter, n));
    let remark = remark.or_else(|| format_names(table.text, n).filter(|_| !told));
    let is_header = layout.header.unwrap_or_else(|| looks_like_header(row, rows, remark.is_some()));
    let mut header = Vec::new();
    let mut found: Option<Vec<String>> = None;
    if is_header {
        row.truncate(n);
        header = std::mem::take(row);
        let mut own = with_units(&header, delimiter);
        n = own.len();
        let mut below = rows.clone();
        let mut units = Vec::new();
        let mut values = Vec::new();
        let is_read = |rows: &mut Rows<'a>, row: &mut Vec<&'a str>| rows.read(row).is_ok_and(|row| row.is_some());
        if !told
            && is_read(&mut below, &mut units)
            && are_units(&units, n)
            && is_read(&mut below.clone(), &mut values)
            && values.iter().any(|cell| kind_of(cell) == CellKind::Number)
        {
            let unit = |(name, unit): (&mut String, &&str)| {
                *name += &format!(" [{}]", unit.trim_matches(['[', ']', '(', ')']))
            };
            own.iter_mut().zip(&units).filter(|(name, _)| !name.ends_with(']')).for_each(unit);
            *rows = below;
        }
        found = Some(own);
    } else if let Some(remark) = remark {
        found = Some(remark);
    }
    let by_place = |(i, name): (usize, String)| if name.is_empty() { format!("c{}", i + 1) } else { name };
    let names = match &layout.names {
        Some(names) => names.clone(),
        None => found.unwrap_or_else(|| vec![String::new(); n]).into_iter().enumerate().map(by_place).collect(),
    };
    let min_cells = layout.min_cells.unwrap_or(names.len());
    if !(min_cells..=names.len()).contains(&n) && (n + 1 != names.len() || row.len() != names.len()) {
        let named = names.len();
        let message = match layout.min_cells.filter(|least| *least > named) {
            Some(least) => {
                format!("rows are to have at least {least} cells (`least_cells`), but {named} columns are named")
            }
            None => format!("has {n} columns, but {named} are named"),
        };
        return Err(table.fault(first.line, 1, message));
    }
    Ok(Head { names, header, first: (!is_header).then_some(first) })
}

/// Whether a row has the units of `n` columns, as some programs write it below their names.
fn are_units(row: &[&str], n: usize) -> bool {
    const UNITS: [&str; 40] = [
        "-", "1", "", "m", "mm", "cm", "um", "µm", "μm", "km", "in", "ft", "s", "ms", "us", "min", "h", "m/s", "mm/s",
        "cm/s", "m/s2", "m/s^2", "kg", "g", "t", "N", "kN", "mN", "N/m", "Nm", "N.m", "J", "W", "Pa", "kPa", "MPa",
        "GPa", "K", "rad", "deg",
    ];
    let is_unit = |cell: &&str| {
        let unit = cell.trim_matches(['[', ']', '(', ')']);
        UNITS.contains(&unit)
            || ["C", "°C", "°", "rad/s", "deg/s", "rpm", "1/s", "Hz", "kg/m3", "kg/m^3"].contains(&unit)
    };
    let has_length = row.iter().any(|cell| cell.trim_matches(['[', ']', '(', ')']).contains('m'));
    row.len() == n && has_length && row.iter().all(is_unit)
}

/// Whether a first row names the columns: it has words, and no row like it follows. `remark`: the line above it names them already.
fn looks_like_header(first: &[&str], rows: &Rows<'_>, remark: bool) -> bool {
    let kinds: Vec<CellKind> = first.iter().map(|cell| kind_of(cell)).collect();
    let has = |kind: CellKind| kinds.contains(&kind);
    if !has(CellKind::Word) || !has(CellKind::Number) {
        return has(CellKind::Word);
    }
    let mut second = Vec::new();
    if remark || !rows.clone().read(&mut second).is_ok_and(|row| row.is_some()) {
        return !remark;
    }
    let unlike = |(a, b): (&CellKind, &&str)| *a == CellKind::Word && kind_of(b) == CellKind::Number;
    first.len() != second.len() || kinds.iter().zip(&second).any(unlike)
}

/// The `n` names of a remark, if it is just that.
fn names_in(remark: &str, delimiter: u8, n: usize) -> Option<Vec<String>> {
    let remark = remark.trim_start_matches(['#', '%']).trim();
    let names = |delimiter: u8| with_units(&cells::split(remark, delimiter), delimiter);
    let is_naming = |names: &Vec<String>| names.len() == n && names.iter().all(|name| kind_of(name) == CellKind::Word);
    [delimiter, cells::sniff(remark)].into_iter().map(names).find(is_naming)
}

/// The `n` names of the format that YADE writes in the first line, `#format x_y_z_r`; those of `attrs`, at its end, are not told
/// (YADE, py/export.py: `text` and `textExt`).
fn format_names(text: &str, n: usize) -> Option<Vec<String>> {
    let format = text.lines().next()?.strip_prefix("#format ")?.trim();
    let mut names: Vec<String> = format.split('_').map(String::from).collect();
    if names.last().is_some_and(|name| name == "attrs") && names.len() <= n + 1 {
        names.pop();
        names.resize(n, String::new());
    }
    let is_name = |name: &String| name.is_empty() || kind_of(name) == CellKind::Word;
    (names.len() == n && !format.contains(char::is_whitespace) && names.iter().all(is_name)).then_some(names)
}

/// Names of columns from their cells: where blanks separate these, a unit belongs to the name before it (`x [m]`).
fn with_units(cells: &[&str], delimiter: u8) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for cell in cells {
        match names.last_mut() {
            Some(name) if delimiter == b' ' && cell.starts_with('[') && cell.ends_with(']') && !name.ends_with(']') => {
                *name += &format!(" {cell}");
            }
            _ => names.push(cell.replace("\"\"", "\"")),
        }
    }
    names
}

/// Two columns of one name are a fault: an expression could not tell which it reads.
fn check_names(table: &Table<'_>, fields: &[Field], head: &Head<'_>) -> Result<(), Fault> {
    let Some(i) = repeated(fields.iter().map(|field| field.name.as_str())) else { return Ok(()) };
    let message = format!("two columns are named `{}`", fields[i].name);
    let fault = match head.header.get(i).filter(|_| head.header.len() == fields.len()) {
        Some(cell) => table.fault_of(cell, message),
        None => table.fault(1, 1, message),
    };
    Err(fault.hint("name all columns in a metadata file, `data: {csv: …, columns: […]}`, or in the table"))
}

/// Make a row have a cell for each column: a separator at its end adds none, and missing ones are 0 where the layout allows it.
fn fit(table: &Table<'_>, row: &mut Vec<&str>, found: Row, names: &[String], layout: &Layout) -> Result<(), Fault> {
    let ends_blank = row.last().is_some_and(|cell| cell.is_empty());
    if ends_blank && (row.len() == names.len() + 1 || layout.min_cells.is_some() || found.is_cut) {
        row.pop();
    }
    if !(layout.min_cells.unwrap_or(names.len())..=names.len()).contains(&row.len()) {
        let cells = if row.len() == 1 { "cell" } else { "cells" };
        let named: Vec<&str> = names.iter().map(String::as_str).collect();
        let message = format!("row has {} {cells}, expected {}", row.len(), crate::column::counted(&named));
        let column = table.text.lines().nth(found.line - 1).map_or(1, |l| l.trim_end().chars().count().max(1));
        let fault = table.fault(found.line, column, message);
        let is_last = table.text.lines().count() <= found.line;
        return Err(match (is_last && row.len() < names.len(), names.len()) {
            (true, _) => fault.hint("a row that is cut off at the end means that its writer was interrupted"),
            (false, 1) => {
                fault.hint("the first line is taken for the names of the columns: remove what stands above these")
            }
            (false, _) => fault,
        });
    }
    row.resize(names.len(), "0");
    Ok(())
}

fn field_of(name: &str) -> Field {
    match name.trim().strip_suffix(']').and_then(|n| n.split_once('[')) {
        Some((name, unit)) => Field::new(name.trim(), unit.trim()),
        None => Field::new(name.trim(), ""),
    }
}

/// A cell's text as it is written: in quotes if it has separators, quotes, line ends or blanks at its ends, or begins like a remark.
fn cell(text: &str) -> Cow<'_, str> {
    if text.contains([',', '"', '\n', '\r', ';', '\t']) || text.starts_with('#') || text.trim() != text {
        Cow::Owned(format!("\"{}\"", text.replace('"', "\"\"")))
    } else {
        Cow::Borrowed(text)
    }
}

/// Encode a frame as CSV text: a header with units, then one line per row, numbers in their shortest exact form.
pub fn encode(frame: &Frame) -> String {
    let mut out = String::new();
    for (i, (f, _)) in frame.columns.iter().enumerate() {
        let comma = if i > 0 { "," } else { "" };
        let head = if f.unit.is_empty() { f.name.clone() } else { format!("{} [{}]", f.name, f.unit) };
        let _ = write!(out, "{comma}{}", cell(&head));
    }
    out.push('\n');
    for row in 0..frame.rows() {
        for (i, (_, column)) in frame.columns.iter().enumerate() {
            let comma = if i > 0 { "," } else { "" };
            let _ = write!(out, "{comma}{}", cell(&column.text(row)));
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

    fn names(text: &str) -> Vec<String> {
        read_text(text).unwrap().names().iter().map(|n| n.to_string()).collect()
    }

    #[test]
    fn titles_and_units_are_told_from_rows() {
        for text in [
            "Exported on 2024-05-01, by EDEM\nParticles\nx,y,z,radius\n1,2,3,0.5\n2,2,3,0.5\n",
            "sep=;\nx;y;z;radius\n1;2;3;0.5\n2;2;3;0.5\n",
            "x|y|z|radius\n1|2|3|0.5\n2|2|3|0.5\n",
            "[Name]\nBed 1\n\n[Data]\nx, y, z, radius\n[m],[m],[m],[m]\n1,2,3,0.5\n2,2,3,0.5\n",
        ] {
            let frame = parse(Path::new("a.csv"), text, 0, &Layout::default()).unwrap();
            assert_eq!((frame.names(), frame.rows()), (vec!["x", "y", "z", "radius"], 2), "{text}");
        }
        let own = parse(Path::new("a.csv"), "x,v,k\nmm,m/s,-\n1,2,3\n", 0, &Layout::default()).unwrap();
        let units: Vec<&str> = own.columns.iter().map(|(field, _)| field.unit.as_str()).collect();
        assert_eq!((own.rows(), units), (1, vec!["mm", "m/s", "-"]));
        // A header that lacks a name is no title, and words are no units.
        let parsed = |text: &str| parse(Path::new("a.csv"), text, 0, &Layout::default());
        assert!(parsed("x,y,z\n1,2,3,4\n1,2,3,4\n").is_err());
        assert_eq!(parsed("kind,m\nm,m\ns,s\n").unwrap().rows(), 2);
        assert_eq!(parsed("title\n\nx,y,z\n1,2,3\n1,2\n").unwrap_err().line, 5);
    }

    #[test]
    fn a_frame_without_rows_may_have_its_header_in_a_comment() {
        let frame = read_text("# made by a program\n# id,x,y,z\n").unwrap();
        assert_eq!((frame.rows(), frame.names()), (0, vec!["id", "x", "y", "z"]));
        for text in ["", "# 17 particles, 3 s\n", "#\n\n"] {
            assert!(read_text(text).is_err(), "{text:?}");
        }
    }

    #[test]
    fn separators_headers_and_units_are_found_out() {
        for text in [
            "x;y [m]\n1;2.5\n",
            "x,y [m]\n1,2.5,\n",
            "x\ty [m]\n1\t2.5\n",
            "# remark\nx  y[m]\n 1  2.5\n",
            "x y [m]\n1 2.5\n",
            "# x y [m]\n1 2.5\n",
            "x;y [m]\n1;2,5\n",
            "\"x\",\"y [m]\"\n1,\"2,5\"\n",
            "x y[m]\n1 2,5",
        ] {
            let frame = read_text(text).unwrap();
            assert_eq!(frame.names(), ["x", "y"], "{text}");
            assert_eq!(frame.columns[1].0.unit, "m");
            assert_eq!(frame.column("x"), Some(&Column::I64(vec![1])));
            assert_eq!(frame.column("y"), Some(&Column::F64(vec![2.5])));
        }
        assert_eq!(names("1 2\n3 4\n"), ["c1", "c2"]);
    }

    #[test]
    fn a_header_may_stand_in_a_remark_or_be_missing() {
        assert_eq!(names("# made by hand\n#id,x\n1,2\n"), ["id", "x"]);
        assert_eq!(names("# id x [m]\n1,2\n"), ["id", "x"]);
        assert_eq!(names("# x kind\n1 stone\n"), ["x", "kind"]);
        for text in ["# three words here\n1 2\n", "# 1 2\n3 4\n", "# a b\n\n3 4\n", "1 2\n# a b\n3 4\n"] {
            assert_eq!(names(text), ["c1", "c2"], "{text}");
        }
        assert_eq!(names("# a b\nx y\n3 4\n"), ["x", "y"]);
        assert_eq!(names("1,stone\n2,brick\n"), ["c1", "c2"]);
        assert_eq!(names("name,1\n3,4\n"), ["name", "1"]);
        assert_eq!(names(",x,y,\n0,1,2\n"), ["c1", "x", "y"]);
    }

    /// Files as the programs that are named write them.
    #[test]
    fn tables_of_other_programs_are_read() {
        for (text, expected, rows) in [
            // YADE, py/export.py: `text`, and `textExt` with attributes and a comment.
            ("#format x_y_z_r\n-0.02\t-0.01\t0.1\t0.006\n", "x y z r", 1),
            ("#format x_y_z_r_attrs\n# velocity and id\n-0.02\t-0.01\t0.1\t0.006\t0\t-1\n", "x y z r c5 c6", 1),
            ("#format x_y_z_r_matId\n0\t0\t1\t0.1\t3\n0\t0\t2\t0.1\t3\n", "x y z r matId", 2),
            // DEM-Engine, src/DEM/dT.cpp: `writeSpheresAsCsv` and `writeClumpsAsCsv`.
            ("X,Y,Z,r,absv,v_x,v_y,v_z,family\n0.1,0.2,0.3,0.01,1,0,0,-1,0\n", "X Y Z r absv v_x v_y v_z family", 1),
            (
                "X,Y,Z,Qw,Qx,Qy,Qz,clump_type,absv\n0,0,0.5,1,0,0,0,ellipsoid,0\n0,0,0.7,1,0,0,0,NULL,0\n",
                "X Y Z Qw Qx Qy Qz clump_type absv",
                2,
            ),
            // Chrono::GPU, src/chrono_gpu/physics/ChSystemGpu_impl.cu: `WriteCsvParticles`.
            ("x,y,z,vx,vy,vz,absv,wx,wy,wz\n0,0,1,0,0,-2,2,0,0,0\n", "x y z vx vy vz absv wx wy wz", 1),
            // Chrono::Postprocess, src/chrono_postprocess/ChPovRay.cpp: `ExportData`, clones of particles.
            ("0, 0.5, 1.25, 1, 0, 0, 0, \n0, 0.5, 2.25, 1, 0, 0, 0, \n", "c1 c2 c3 c4 c5 c6 c7", 2),
        ] {
            let frame = read_text(text).unwrap();
            assert_eq!((frame.names().join(" ").as_str(), frame.rows()), (expected, rows), "{text}");
        }
        assert_eq!(names("#format x_y_z\n1\t2\t3\t4\n"), ["c1", "c2", "c3", "c4"]);
        for cut in ["#format x_y_z_r\n0\t0\t1\t0.1\n0\t0", "0, 0.5, 1.25, 1, 0, 0, 0, \n0, 0.5, 2.25, 1, 0, "] {
            assert!(read_text(cut).is_err(), "{cut}");
        }
    }

    #[test]
    fn a_torn_row_is_named_with_its_place() {
        let fault = read_text("x,y\n1,2\n3").unwrap_err();
        assert_eq!((fault.line, fault.column), (3, 1));
        // Behind a separator at the end of the text a cell is cut off, elsewhere it is empty.
        assert_eq!(read_text("x,y\n1,2\n3,").unwrap_err().line, 3);
        assert_eq!(read_text("x,y\n1,2\n3,\n").unwrap().rows(), 2);
        assert_eq!(read_text("x,y\n1,\"2\n3,4\n").unwrap_err().column, 3);
        assert_eq!(read_text("").unwrap_err().message, "is empty");
        assert_eq!(read_text("# at 3 s\n").unwrap_err().message, "has no rows");
    }

    #[test]
    fn missing_values_and_tables_without_rows_are_read() {
        let frame = read_text("x,y,kind\n1,,stone\nNA,2,\n").unwrap();
        assert!(frame.column("x").unwrap().number(1).unwrap().is_nan());
        assert!(frame.column("y").unwrap().number(0).unwrap().is_nan());
        assert_eq!(frame.column("kind").unwrap().text(1), "");
        let frame = read_text("x,y\n").unwrap();
        assert_eq!((frame.names(), frame.rows()), (vec!["x", "y"], 0));
    }

    #[test]
    fn what_two_readers_would_read_in_two_ways_is_refused() {
        let fault = read_text("x,y\n0.5,\"1,234\"\n").unwrap_err();
        assert_eq!((fault.line, fault.column), (2, 6), "{fault}");
        let fault = read_text("x,y,x [mm]\n1,2,3\n").unwrap_err();
        assert!(fault.message.contains("two columns are named `x`") && fault.column == 5, "{fault}");
    }

    #[test]
    fn what_is_written_is_read_back() {
        let words = ["p", "a,b", "say \"hi\"", "two\nlines", "#1", " wide "];
        let mut frame = Frame::new(3, 0.0);
        frame.push("a, the first", "m", Column::F64((0..6).map(|k| k as f64 * 0.1).collect()));
        let names = words.map(String::from).to_vec();
        frame.push("kind", "", Column::Category { codes: vec![1, 0, 2, 5, 4, 3], names });
        let back = read_text(&encode(&frame)).unwrap();
        assert_eq!(back.columns[0], frame.columns[0]);
        for row in 0..6 {
            assert_eq!(back.columns[1].1.text(row), frame.columns[1].1.text(row));
        }
    }
}
