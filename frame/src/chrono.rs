//! Bodies and shapes of Project Chrono as frames: what `utils::WriteVisualizationAssets` writes for images
//! (src/chrono/utils/ChUtilsInputOutput.cpp).
//!
//! The first line has the counts of bodies, shapes, links and springs. A row is `id, active, x, y, z, e0, e1, e2, e3` of each body, then
//! the same of each shape with its colour, its type and as many sizes as this has, then links and springs. A frame has the shapes, of
//! spheres with a `radius`, of all with `size_1` and so on; the bodies if there are no shapes. Links and springs are not read.

use crate::rows::{self, Lines};
use crate::{Column, Fault, FaultKind, Field, Frame, csv, gzip, text};
use std::path::Path;

/// Columns of a body.
const BODY: [&str; 9] = ["id", "active", "x", "y", "z", "e0", "e1", "e2", "e3"];
const COLOR: [&str; 3] = ["red", "green", "blue"];
/// Types of shapes by their numbers (`POVRayShapeType`).
const TYPES: [&str; 13] = [
    "sphere",
    "ellipsoid",
    "box",
    "cylinder",
    "hull",
    "mesh",
    "barrel",
    "capsule",
    "cone",
    "rounded_box",
    "rounded_cylinder",
    "rounded_cone",
    "curve",
];
/// Types of shapes that have a name in place of sizes.
const NAMED: [&str; 3] = ["hull", "mesh", "curve"];
/// Sizes of a shape at most.
const MOST: usize = 8;

/// The cells of a row: each ends with a comma, but maybe the last.
fn cells(line: &str) -> Vec<&str> {
    let line = line.trim();
    line.strip_suffix(',').unwrap_or(line).split(',').map(str::trim).collect()
}

/// The counts in the first line.
fn counts(line: &str) -> Option<Vec<u64>> {
    let counts: Vec<u64> = cells(line).iter().map(|cell| cell.parse().ok()).collect::<Option<_>>()?;
    (line.trim_end().ends_with(',') && matches!(counts.len(), 3 | 4)).then_some(counts)
}

/// Whether a file begins with counts, and goes on with the row of a body or a shape: were it a table without names, its first row would
/// be a short one.
pub(crate) fn is_chrono(start: &[u8]) -> bool {
    let mut lines = rows::beginning(start).lines().filter(|line| !line.trim().is_empty());
    let Some(counts) = lines.next().and_then(counts) else { return false };
    let row = cells(lines.next().unwrap_or(""));
    let is_number = |cell: &&str| cell.parse::<f64>().is_ok();
    counts[..2].iter().any(|count| *count > 0) && row.len() >= BODY.len() && row[..BODY.len()].iter().all(is_number)
}

/// Read a file as the frame `number`, at time 0.
pub fn read(path: &Path, number: u64) -> Result<Frame, Fault> {
    let text = text::decode(gzip::read(path)?);
    let text = text.map_err(|_| Fault::whole(FaultKind::Data, path, "has bytes that are no text"))?;
    frame(path, &text, number)
}

/// A row, and its line.
struct Row<'a> {
    cells: Vec<&'a str>,
    line: usize,
}

fn frame(path: &Path, text: &str, number: u64) -> Result<Frame, Fault> {
    let mut lines = Lines::new(path, text);
    let first = lines.next("the counts of bodies and shapes")?;
    let counts =
        counts(first).ok_or_else(|| lines.fault("expected the counts of bodies, shapes, links and springs"))?;
    let all = counts.iter().copied().fold(0, u64::saturating_add);
    let [bodies, shapes] = [counts[0], counts[1]];
    let mut rows = vec![];
    for k in 0..all {
        let line = loop {
            let line = lines.next(format_args!("{all} rows, found {k},"))?;
            if !line.trim().is_empty() {
                break line;
            }
        };
        let is_read = if shapes > 0 { k >= bodies && k - bodies < shapes } else { k < bodies };
        if is_read {
            rows.push(Row { cells: cells(line), line: lines.line() });
        } else if k < bodies && cells(line).len() != BODY.len() {
            return Err(lines.fault(format!("row of a body has {} cells, expected {}", cells(line).len(), BODY.len())));
        }
    }
    lines.end(all)?;
    let columns = if shapes > 0 { of_shapes(path, text, &rows) } else { of_bodies(path, text, &rows) }?;
    Ok(Frame { number, time: 0.0, columns })
}

/// A column of numbers, the cell `k` of each row.
fn numbers(path: &Path, text: &str, rows: &[Row<'_>], k: usize, name: &str) -> Result<(Field, Column), Fault> {
    let number = |row: &Row<'_>| {
        let cell = row.cells.get(k).copied().unwrap_or("");
        let wrong = || format!("`{cell}` is no number, as `{name}` is");
        cell.parse().map_err(|_| Fault::at(FaultKind::Data, path, text, row.line, 1, wrong()))
    };
    Ok((Field::new(name, ""), Column::F64(rows.iter().map(number).collect::<Result<_, _>>()?)))
}

/// The columns that shapes and bodies have.
fn of_bodies(path: &Path, text: &str, rows: &[Row<'_>]) -> Result<Vec<(Field, Column)>, Fault> {
    let mut columns =
        BODY.iter().enumerate().map(|(k, name)| numbers(path, text, rows, k, name)).collect::<Result<Vec<_>, _>>()?;
    for (_, column) in &mut columns[..2] {
        if let Column::F64(v) = column {
            *column = Column::I64(v.iter().map(|x| *x as i64).collect());
        }
    }
    Ok(columns)
}

fn of_shapes(path: &Path, text: &str, rows: &[Row<'_>]) -> Result<Vec<(Field, Column)>, Fault> {
    let fault = |row: &Row<'_>, message: String| Fault::at(FaultKind::Data, path, text, row.line, 1, message);
    // Colours are not there in files of old versions.
    let has_color = |row: &Row<'_>| {
        let is_part = |cell: &&str| cell.parse().is_ok_and(|x: f32| (0.0..=1.0).contains(&x));
        row.cells.len() > 13 && row.cells[9..12].iter().all(is_part) && type_of(row.cells[12]).is_some()
    };
    let is_colored = rows.iter().all(has_color);
    let at = if is_colored { 12 } else { 9 };
    let mut columns = of_bodies(path, text, rows)?;
    if is_colored {
        for (k, name) in COLOR.into_iter().enumerate() {
            columns.push(numbers(path, text, rows, 9 + k, name)?);
        }
    }
    let (mut types, mut names, mut radii) = (vec![], vec![], vec![]);
    let mut sizes: Vec<Vec<f64>> = vec![];
    for (k, row) in rows.iter().enumerate() {
        let of = row.cells.get(at).and_then(|cell| type_of(cell)).ok_or_else(|| {
            fault(row, format!("expected the type of a shape, a whole number up to 12, in cell {}", at + 1))
        })?;
        let rest = &row.cells[at + 1..];
        if rest.is_empty() || rest.len() > MOST {
            return Err(fault(row, format!("has {} sizes, expected 1 to {MOST}", rest.len())));
        }
        let is_named = NAMED.contains(&of);
        let mut own = vec![];
        for cell in rest.iter().filter(|_| !is_named) {
            own.push(cell.parse().map_err(|_| fault(row, format!("`{cell}` is no number, as sizes are")))?);
        }
        while sizes.len() < own.len() {
            sizes.push(vec![f64::NAN; k]);
        }
        sizes.iter_mut().enumerate().for_each(|(i, size)| size.push(own.get(i).copied().unwrap_or(f64::NAN)));
        radii.push(if of == "sphere" { own[0] } else { f64::NAN });
        types.push(of);
        names.push(if is_named { rest[0].trim_matches('"') } else { "" });
    }
    columns.push((Field::new("type", ""), csv::words(&types)));
    columns.push((Field::new("radius", ""), Column::F64(radii)));
    columns.extend(
        sizes.into_iter().enumerate().map(|(i, size)| (Field::new(format!("size_{}", i + 1), ""), Column::F64(size))),
    );
    if names.iter().any(|name| !name.is_empty()) {
        columns.push((Field::new("name", ""), csv::words(&names)));
    }
    Ok(columns)
}

fn type_of(cell: &str) -> Option<&'static str> {
    TYPES.get(cell.parse::<usize>().ok()?).copied()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rows::tests::mutated;

    /// As `WriteVisualizationAssets` writes a box that holds two spheres and a wheel, with a hinge and a spring.
    const FILE: &str = "3,4,1,1,\n\n\
        -1,0,0,0,0,1,0,0,0,\n1,1,0.5,0,1.25,1,0,0,0,\n2,1,0.5,0,2.5,0.7,0.7,0,0,\n\
        -1,0,0,0,-0.1,1,0,0,0,0.5,0.5,0.5,2,2,2,0.1\n\
        1,1,0.5,0,1.25,1,0,0,0,1,1,1,0,0.25,\n2,1,0.5,0,2.5,0.7,0.7,0,0,0,0,1,0,0.125,\n\
        2,1,0.5,0,2.5,1,0,0,0,1,0,0,5,\"wheel\",\n\
        0,0.5,0,2.5,0,0,1,\n1,0.5,0,2.5,0,0,1,\n";

    fn read_text(text: &str) -> Result<Frame, Fault> {
        frame(Path::new("a.dat"), text, 0)
    }

    #[test]
    fn shapes_are_rows_with_their_sizes() {
        let frame = read_text(FILE).unwrap();
        assert_eq!(
            frame.names().join(" "),
            "id active x y z e0 e1 e2 e3 red green blue type radius size_1 size_2 size_3 name"
        );
        let at = |name: &str, row: usize| frame.column(name).unwrap().text(row);
        assert_eq!([0, 1, 3].map(|row| at("type", row)), ["box", "sphere", "mesh"]);
        assert_eq!([at("radius", 1), at("size_2", 0), at("size_2", 1), at("name", 3)], ["0.25", "2", "NaN", "wheel"]);
        let old = "0,2,0,\n1,1,0,0,1,1,0,0,0,0,0.5,\n2,1,0,0,2,1,0,0,0,3,0.5,0,1,0,0,-1,0,\n";
        let frame = read_text(old).unwrap();
        assert_eq!(frame.column("type").unwrap().text(1), "cylinder");
        assert_eq!(frame.column("size_3").unwrap().number(1), Some(1.0));
    }

    #[test]
    fn bodies_are_rows_where_there_are_no_shapes() {
        let frame = read_text("2,0,0,0,\n4,1,0,0,1,1,0,0,0,\n5,0,0,0,2,1,0,0,0,\n").unwrap();
        assert_eq!(frame.names(), BODY);
        assert_eq!(frame.column("id"), Some(&Column::I64(vec![4, 5])));
        assert!(is_chrono(FILE.as_bytes()) && !is_chrono(b"1,2,3,\n4,5,6,\n") && !is_chrono(b"0,0,0,0,\n"));
    }

    #[test]
    fn wrong_files_are_told_with_their_lines() {
        for (text, line, message) in [
            (FILE.replace("1,0.5,0,2.5,0,0,1,\n", ""), 10, "expected 9 rows, found 8"),
            (FILE.replace("3,4,1,1,", "3,4,1,9999999999999999999,"), 11, "found 9"),
            (FILE.replace("3,4,1,1,", "3,4,1,0,"), 11, "expected the end after 8 rows"),
            (FILE.replace("3,4,1,1,", "4,3,1,1,"), 6, "row of a body has 16 cells"),
            (FILE.replace("2,2,2,0.1", "2,2,b,0.1"), 6, "`b` is no number"),
            (FILE.replace("-1,0,0,0,-0.1", "-1,0,0,x,-0.1"), 6, "`x` is no number, as `y` is"),
        ] {
            let fault = read_text(&text).unwrap_err();
            assert!(fault.message.contains(message) && fault.line == line, "{fault} for\n{text}");
        }
        mutated(FILE.as_bytes(), |bytes, path| {
            let _ = is_chrono(bytes);
            let _ = read(path, 0);
        });
    }
}
