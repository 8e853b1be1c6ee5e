//! Dumps of LAMMPS and LIGGGHTS as frames: text files of `ITEM:` sections, one time step after the other (LAMMPS manual, `dump`).
//!
//! The columns are those of the line `ITEM: ATOMS` (or `ENTRIES`), by their names there; the second of two columns of one name is
//! `NAME_2`. Scaled coordinates (`xs`, `xsu`) become `x`, `y` and `z`, m or whatever the box is in; unwrapped ones (`xu`) do where there
//! are no others.

use crate::part::{self, Part, Scan};
use crate::rows::Columns;
use crate::{Column, Fault, FaultKind, Field, Frame};
use std::collections::HashMap;
use std::fmt::Display;
use std::iter::{Enumerate, Peekable};
use std::path::Path;
use std::str::Lines;

/// Whether a file begins as dumps do.
pub(crate) fn is_dump(start: &[u8]) -> bool {
    start.starts_with(b"ITEM: ")
}

/// Whether a line is of the items that may stand before the time step that they belong to (LAMMPS manual, `dump_modify time` and
/// `units`).
fn is_before_step(line: &[u8]) -> bool {
    line.strip_prefix(b"ITEM: ").is_some_and(|item| [&b"UNITS"[..], b"TIME"].contains(&item.trim_ascii()))
}

/// The time steps of a dump, in the order of the file.
pub fn parts(path: &Path) -> Result<Vec<Part>, Fault> {
    let (mut scan, mut line) = (Scan::open(path)?, vec![]);
    // Whether the head of a time step has begun, as it does by its units and its time where these are written.
    let mut is_in_head = false;
    while scan.read(&mut line)? {
        if is_before_step(&line) && !is_in_head {
            scan.begin();
            is_in_head = true;
        }
        if !line.starts_with(b"ITEM: TIMESTEP") {
            continue;
        }
        if !is_in_head {
            scan.begin();
        }
        is_in_head = false;
        if scan.read(&mut line)? {
            let text = String::from_utf8_lossy(&line);
            let step = text.trim().parse().map_err(|_| {
                scan.fault(&line, format!("`{}` is no time step, expected a whole number", text.trim()))
            })?;
            scan.is_at(Some(step));
        }
    }
    Ok(scan.parts)
}

/// Read a time step of a dump as the frame `number`; the only one if none is given.
pub fn read(path: &Path, part: Option<&Part>, number: u64) -> Result<Frame, Fault> {
    let (text, before) = part::read(path, part)?;
    let dump = Dump { path, text: &text, lines: text.lines().enumerate().peekable(), number };
    dump.frame().map_err(|fault| fault.moved(before))
}

/// The text of a time step, as it is read.
struct Dump<'a> {
    path: &'a Path,
    text: &'a str,
    lines: Peekable<Enumerate<Lines<'a>>>,
    number: u64,
}

/// The box of a time step: its corner, and its edges from there.
#[derive(Clone, Copy, Debug)]
struct Bounds {
    corner: [f64; 3],
    edges: [[f64; 3]; 3],
}

impl<'a> Dump<'a> {
    fn fault(&self, line: usize, message: impl Into<String>) -> Fault {
        Fault::at(FaultKind::Data, self.path, self.text, line, 1, message)
    }

    /// The line after the one of an index, from 0, which has what is expected.
    fn next(&mut self, after: usize, expected: impl Display) -> Result<(usize, &'a str), Fault> {
        match self.lines.next() {
            Some((i, line)) if !line.starts_with("ITEM:") => Ok((i, line)),
            _ => Err(self
                .fault(after + 1, format!("ends here, expected {expected} below"))
                .hint("the program that wrote it was interrupted, or is still writing it")),
        }
    }

    fn frame(mut self) -> Result<Frame, Fault> {
        let (mut time, mut count, mut bounds) = (0.0, None, None);
        let mut is_begun = false;
        while let Some((i, line)) = self.lines.next() {
            let Some(item) = line.strip_prefix("ITEM:") else {
                return Err(self.fault(i + 1, "expected a line that begins with `ITEM:`"));
            };
            let words: Vec<&str> = item.split_whitespace().collect();
            match words[..] {
                ["TIMESTEP"] if is_begun => {
                    let message = "has a second time step: give it alone, without a pattern of several files";
                    return Err(self.fault(i + 1, message));
                }
                ["TIMESTEP"] => {
                    is_begun = true;
                    self.next(i, "the time step")?;
                }
                ["TIME"] => {
                    let (at, line) = self.next(i, "the time")?;
                    time = self.numbers::<1>(at, line)?[0];
                }
                ["NUMBER", "OF", "ATOMS" | "ENTRIES"] => {
                    let (at, line) = self.next(i, "a count")?;
                    let n: Result<usize, _> = line.trim().parse();
                    count = Some(n.map_err(|_| self.fault(at + 1, "expected a count, a whole number"))?);
                }
                ["BOX", "BOUNDS", "abc", ..] => bounds = Some(self.axes(i)?),
                ["BOX", "BOUNDS", ..] => bounds = Some(self.bounds(i, words.get(2) == Some(&"xy"))?),
                ["ATOMS" | "ENTRIES", ref names @ ..] => {
                    let Some(count) = count else {
                        return Err(self.fault(i + 1, "comes before `ITEM: NUMBER OF ATOMS`"));
                    };
                    let columns = self.columns(i, names, count)?;
                    let columns = self.placed(i, columns, bounds)?;
                    while self.lines.next_if(|(_, line)| line.trim().is_empty()).is_some() {}
                    if let Some((next, line)) = self.lines.next()
                        && !line.starts_with("ITEM: TIMESTEP")
                        && !is_before_step(line.as_bytes())
                    {
                        return Err(self.fault(next + 1, format!("expected the end after {count} rows")));
                    } else if self.lines.peek().is_some() {
                        let message = "has a second time step: give the file alone, without a pattern of several";
                        return Err(Fault::whole(FaultKind::Data, self.path, message));
                    }
                    return Ok(Frame { number: self.number, time, columns });
                }
                // Those of other versions: units, the cell's origin.
                _ => while self.lines.next_if(|(_, line)| !line.starts_with("ITEM:")).is_some() {},
            }
        }
        let last = self.text.lines().count();
        Err(self
            .fault(last, "ends here, expected `ITEM: ATOMS` and a row for each")
            .hint("the program that wrote it was interrupted, or is still writing it"))
    }

    /// Just N numbers of a line.
    fn numbers<const N: usize>(&self, at: usize, line: &str) -> Result<[f64; N], Fault> {
        let numbers: Vec<f64> = line.split_whitespace().filter_map(|word| word.parse().ok()).collect();
        numbers.try_into().map_err(|_| self.fault(at + 1, format!("expected {N} numbers")))
    }

    /// The bounds of an upright or tilted box.
    fn bounds(&mut self, i: usize, is_tilted: bool) -> Result<Bounds, Fault> {
        let (mut low, mut high, mut tilt) = ([0.0; 3], [0.0; 3], [0.0; 3]);
        for k in 0..3 {
            let (at, line) = self.next(i + k, "the bounds of the box")?;
            if is_tilted {
                [low[k], high[k], tilt[k]] = self.numbers(at, line)?;
            } else {
                [low[k], high[k]] = self.numbers(at, line)?;
            }
        }
        // The bounds are those of the upright box about a tilted one (LAMMPS manual, triclinic boxes).
        let [xy, xz, yz] = tilt;
        let of_x = [0.0, xy, xz, xy + xz];
        low[0] -= of_x.iter().copied().fold(0.0, f64::min);
        high[0] -= of_x.iter().copied().fold(0.0, f64::max);
        low[1] -= yz.min(0.0);
        high[1] -= yz.max(0.0);
        let edges = [[high[0] - low[0], 0.0, 0.0], [xy, high[1] - low[1], 0.0], [xz, yz, high[2] - low[2]]];
        Ok(Bounds { corner: low, edges })
    }

    /// The edges of a box of any edges, each with a coordinate of its corner (LAMMPS manual, `dump_modify triclinic/general`).
    fn axes(&mut self, i: usize) -> Result<Bounds, Fault> {
        let mut bounds = Bounds { corner: [0.0; 3], edges: [[0.0; 3]; 3] };
        for k in 0..3 {
            let (at, line) = self.next(i + k, "an edge of the box")?;
            let [x, y, z, corner] = self.numbers(at, line)?;
            (bounds.edges[k], bounds.corner[k]) = ([x, y, z], corner);
        }
        Ok(bounds)
    }

    /// The columns of the rows below the line of an index.
    fn columns(&mut self, i: usize, names: &[&str], count: usize) -> Result<Vec<(Field, Column)>, Fault> {
        if names.is_empty() {
            return Err(self.fault(i + 1, "names no columns"));
        }
        let mut columns = Columns::new(names.len());
        let again = self.lines.clone();
        for k in 0..count {
            let (at, line) = self.next(i + k, format_args!("{count} rows, found {k},"))?;
            let found = columns.push(line);
            if found != names.len() {
                let message = format!("row has {found} cells, expected {}", crate::column::counted(names));
                return Err(self.fault(at + 1, message));
            }
        }
        let found = columns.finish(again.map(|(_, line)| line));
        let mut columns: Vec<(Field, Column)> = vec![];
        let mut seen: HashMap<&str, usize> = HashMap::new();
        for (name, column) in names.iter().zip(found) {
            let column = column.ok_or_else(|| self.fault(i + 1, format!("`{name}` has numbers of two kinds")))?;
            let nth = seen.entry(name).and_modify(|n| *n += 1).or_insert(1);
            let name = if *nth == 1 { name.to_string() } else { format!("{name}_{nth}") };
            columns.push((Field::new(&name, ""), column));
        }
        Ok(columns)
    }

    /// Columns with the coordinates x, y and z, if they are there in any form.
    fn placed(
        &self,
        i: usize,
        mut columns: Vec<(Field, Column)>,
        bounds: Option<Bounds>,
    ) -> Result<Vec<(Field, Column)>, Fault> {
        const NAMES: [&str; 3] = ["x", "y", "z"];
        let place_of = |columns: &[(Field, Column)], name: &str| columns.iter().position(|(f, _)| f.name == name);
        let places = |columns: &[(Field, Column)], end: &str| -> Option<[usize; 3]> {
            let found: Vec<usize> = NAMES.iter().filter_map(|n| place_of(columns, &format!("{n}{end}"))).collect();
            found.try_into().ok()
        };
        if places(&columns, "").is_some() {
            return Ok(columns);
        }
        if let Some(own) = places(&columns, "u") {
            own.iter().zip(NAMES).for_each(|(k, name)| columns[*k].0.name = name.into());
        } else if let Some(own) = places(&columns, "s").or_else(|| places(&columns, "su")) {
            let Some(Bounds { corner, edges }) = bounds else {
                return Err(self.fault(i + 1, "has scaled coordinates, and above there are no bounds of the box"));
            };
            let n = columns[own[0]].1.len();
            let at = |k: usize, row: usize| columns[own[k]].1.number(row).unwrap_or(f64::NAN);
            let place = |row: usize| {
                let s = [at(0, row), at(1, row), at(2, row)];
                [0, 1, 2].map(|c| corner[c] + s[0] * edges[0][c] + s[1] * edges[1][c] + s[2] * edges[2][c])
            };
            let all: Vec<[f64; 3]> = (0..n).map(place).collect();
            for (k, name) in NAMES.into_iter().enumerate() {
                columns[own[k]] = (Field::new(name, ""), Column::F64(all.iter().map(|p| p[k]).collect()));
            }
        }
        Ok(columns)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(text: &str) -> tempfile::NamedTempFile {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), text).unwrap();
        file
    }

    fn step(step: u64, bounds: &str, rows: &str) -> String {
        let n = rows.lines().count() - 1;
        format!("ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n{n}\nITEM: BOX BOUNDS {bounds}\nITEM: ATOMS {rows}\n")
    }

    #[test]
    fn coordinates_are_those_of_the_world() {
        let upright = "pp pp pp\n-1 1\n0 4\n2 3";
        let tilted = "xy xz yz pp pp pp\n-1 3 2\n0 5 0\n2 3 1";
        let general = "abc origin pp pp pp\n0 2 0 -1\n0 0 4 0\n1 0 0 2";
        for (bounds, rows, expected) in [
            (upright, "id x y z\n7 0.5 1 2.5", [0.5, 1.0, 2.5]),
            (upright, "id xs ys zs\n7 0.75 0.25 0.5", [0.5, 1.0, 2.5]),
            (upright, "id xsu ysu zsu\n7 1.75 0.25 0.5", [2.5, 1.0, 2.5]),
            (upright, "id xu yu zu\n7 9 8 7", [9.0, 8.0, 7.0]),
            // The box has lengths 2, 4 and 1; its corner is at -1, 0, 2.
            (tilted, "id xs ys zs\n7 0.5 0.5 0.5", [0.0 + 1.0, 2.5, 2.5]),
            (general, "id xs ys zs\n7 0.5 0.25 0.125", [-0.875, 1.0, 3.0]),
        ] {
            let frame = read(file(&step(0, bounds, rows)).path(), None, 3).unwrap();
            let at = |name: &str| frame.column(name).unwrap().number(0).unwrap();
            assert_eq!(["x", "y", "z"].map(at), expected, "{bounds} {rows}");
            assert_eq!((frame.number, at("id")), (3, 7.0));
        }
    }

    #[test]
    fn several_time_steps_are_found_and_read_by_themselves() {
        let bounds = "pp pp pp\n0 1\n0 1\n0 1";
        let text = [
            step(0, bounds, "id type type x y z\n1 2 3 4 5 6"),
            step(500, bounds, "id type type x y z\n1 2 3 4 5 6\n2 2 3 4 5 7"),
            step(1000, bounds, "id x y z"),
        ]
        .concat();
        let file = file(&text);
        let found = parts(file.path()).unwrap();
        assert_eq!(found.iter().map(|p| p.step.unwrap()).collect::<Vec<_>>(), [0, 500, 1000]);
        let frames: Vec<Frame> = found.iter().map(|p| read(file.path(), Some(p), 0).unwrap()).collect();
        assert_eq!(frames.iter().map(Frame::rows).collect::<Vec<_>>(), [1, 2, 0]);
        assert_eq!(frames[1].names(), ["id", "type", "type_2", "x", "y", "z"]);
        assert_eq!(frames[1].column("z"), Some(&Column::I64(vec![6, 7])));
        assert!(read(file.path(), None, 0).unwrap_err().message.contains("second time step"));
        // An editor of Windows puts its mark before the first.
        let marked = std::fs::read_to_string(file.path()).unwrap();
        std::fs::write(file.path(), format!("\u{feff}{marked}")).unwrap();
        assert_eq!(crate::table::Kind::of(file.path()), crate::table::Kind::Dump);
        let found = parts(file.path()).unwrap();
        let rows = |p: &Part| read(file.path(), Some(p), 0).unwrap().rows();
        assert_eq!(found.iter().map(rows).collect::<Vec<_>>(), [1, 2, 0]);
        // With units and times before the time steps that they belong to.
        let text = [
            format!("ITEM: UNITS\nsi\nITEM: TIME\n0.5\n{}", step(0, bounds, "id x y z\n1 4 5 6")),
            format!("ITEM: TIME\n0.75\n{}", step(500, bounds, "id x y z\n1 4 5 6\n2 4 5 7")),
            format!("ITEM: TIME\n1\n{}", step(1000, bounds, "id x y z")),
        ];
        std::fs::write(file.path(), text.concat()).unwrap();
        let found = parts(file.path()).unwrap();
        assert_eq!(found.iter().map(|p| p.step.unwrap()).collect::<Vec<_>>(), [0, 500, 1000]);
        let frames: Vec<Frame> = found.iter().map(|p| read(file.path(), Some(p), 0).unwrap()).collect();
        assert_eq!(frames.iter().map(|f| (f.time, f.rows())).collect::<Vec<_>>(), [(0.5, 1), (0.75, 2), (1.0, 0)]);
    }

    #[test]
    fn a_cut_or_wrong_dump_is_told_with_its_line() {
        let bounds = "pp pp pp\n0 1\n0 1\n0 1";
        let good = step(5, bounds, "id x y z\n1 4 5 6\n2 4 5 6");
        let faults = [
            (good.replace("2 4 5 6\n", ""), 10, "expected 2 rows, found 1"),
            (good.replace("2 4 5 6", "2 4 5"), 11, "row has 3 cells, expected 4"),
            (good.replace("2 4 5 6", "2 4 5 6\n3 1 1 1"), 12, "expected the end after 2 rows"),
            (good.replace("\n2\nITEM", "\nmany\nITEM"), 4, "expected a count"),
            (good.replace("0 1\n0 1\n0 1", "0 1\n0 1"), 7, "expected the bounds of the box"),
            (good.replace("0 1\n0 1\n0 1", "0 1\n0\n0 1"), 7, "expected 2 numbers"),
            (good.split("ITEM: ATOMS").next().unwrap().into(), 8, "expected `ITEM: ATOMS`"),
            (
                good.replace("x y z\n1", "xs ys zs\n1").replace("ITEM: BOX BOUNDS pp pp pp\n0 1\n0 1\n0 1\n", ""),
                5,
                "no bounds",
            ),
        ];
        for (text, line, message) in faults {
            let fault = read(file(&text).path(), None, 0).unwrap_err();
            assert!(fault.message.contains(message) && fault.line == line, "{fault} for\n{text}");
        }
        let two = [good.clone(), good.replace("2 4 5 6", "2 4 5")].concat();
        let file = file(&two);
        let second = parts(file.path()).unwrap()[1];
        assert_eq!(read(file.path(), Some(&second), 0).unwrap_err().line, 22);
        assert!(parts(self::file("ITEM: TIMESTEP\nx\n").path()).unwrap_err().message.contains("no time step"));
    }
}
