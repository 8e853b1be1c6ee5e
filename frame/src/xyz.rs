//! XYZ files, plain and extended, as frames: a count of rows, a line of comment, and the rows; one or several frames a file.
//!
//! The comment of an extended one names the columns, `Properties=species:S:1:pos:R:3:radius:R:1` (as ASE and OVITO write it): `pos`
//! becomes `x`, `y` and `z`, other vectors `NAME_x` and so on. A plain one has `kind`, `x`, `y`, `z`, `c5` and so on. The comment may
//! tell the time, `Time=0.5`, and the step, `Timestep=100`, `step=100` or, as LAMMPS has it (`dump xyz`), `Atoms. Timestep: 100`.

use crate::part::{self, Part, Scan};
use crate::rows::{self, Lines};
use crate::{Fault, FaultKind, Field, Frame};
use std::path::Path;

/// Whether a file begins as XYZ files do: a count alone, any text, and atoms from the third line on, `H 0 0 0.7`.
pub(crate) fn is_xyz(start: &[u8]) -> bool {
    let text = rows::beginning(start);
    let mut lines = text.lines();
    let Some(count) = lines.next().and_then(|line| line.trim().parse::<u64>().ok()) else { return false };
    let comment = lines.next().unwrap_or("");
    if comment.contains("Properties=") {
        return true;
    }
    let cells: Vec<&str> = lines.next().unwrap_or("").split_whitespace().collect();
    count > 0 && cells.len() >= 4 && cells[1..4].iter().all(|cell| cell.parse::<f64>().is_ok())
}

/// The frames of a file, in its order.
pub fn parts(path: &Path) -> Result<Vec<Part>, Fault> {
    let (mut scan, mut line) = (Scan::open(path)?, vec![]);
    while scan.read(&mut line)? {
        let text = String::from_utf8_lossy(&line);
        if text.trim().is_empty() {
            continue;
        }
        let count = count_of(&text).map_err(|message| scan.fault(&line, message))?;
        scan.begin();
        if !scan.read(&mut line)? {
            break;
        }
        let comment = Comment::of(&String::from_utf8_lossy(&line)).map_err(|message| scan.fault(&line, message))?;
        scan.is_at(comment.step);
        let mut n = 0;
        // What is missing is told when the frame is read.
        while n < count && scan.skip()? {
            n += 1;
        }
    }
    Ok(scan.parts)
}

fn count_of(line: &str) -> Result<u64, String> {
    line.trim().parse().map_err(|_| format!("`{}` is no count of rows, expected a whole number", shown(line.trim())))
}

/// The beginning of a text, for a message.
fn shown(text: &str) -> String {
    text.chars().take(40).collect()
}

/// Read a frame as the frame `number`; the only one of the file if none is given.
pub fn read(path: &Path, part: Option<&Part>, number: u64) -> Result<Frame, Fault> {
    let (text, before) = part::read(path, part)?;
    frame(path, &text, number).map_err(|fault| fault.moved(before))
}

fn frame(path: &Path, text: &str, number: u64) -> Result<Frame, Fault> {
    let fault = |line: usize, message: String| Fault::at(FaultKind::Data, path, text, line, 1, message);
    let mut lines = Lines::new(path, text);
    let count = count_of(lines.next("a count of rows")?).map_err(|message| fault(1, message))?;
    let comment = Comment::of(lines.next("a comment")?).map_err(|message| fault(2, message))?;
    let names = match comment.columns {
        Some(names) => names,
        None => {
            let n = lines.peek().map_or(4, |line| line.split_whitespace().count());
            let plain =
                |k: usize| ["kind", "x", "y", "z"].get(k).map_or(format!("c{}", k + 1), |name| name.to_string());
            (0..n.max(4)).map(plain).collect()
        }
    };
    if let Some(i) = crate::repeated(names.iter().map(String::as_str)) {
        return Err(fault(2, format!("two columns are named `{}`", names[i])));
    }
    let fields: Vec<Field> = names.iter().map(|name| Field::new(name, "")).collect();
    let columns = lines.columns(fields, count, 2)?;
    lines.end(count).map_err(|fault| match count_of(&fault.text) {
        Ok(_) => fault.hint("a file of several frames is given alone, or as the first of the pattern"),
        Err(_) => fault,
    })?;
    Ok(Frame { number, time: comment.time.unwrap_or(0.0), columns })
}

/// What a comment tells.
#[derive(Debug, Default, PartialEq)]
struct Comment {
    /// The names of the columns.
    columns: Option<Vec<String>>,
    /// The time, s.
    time: Option<f64>,
    /// The time step.
    step: Option<u64>,
}

impl Comment {
    fn of(line: &str) -> Result<Comment, String> {
        let mut comment = Comment::default();
        for (key, value) in pairs(line) {
            match key.to_ascii_lowercase().as_str() {
                "properties" => comment.columns = Some(columns_of(value)?),
                "time" => comment.time = value.parse().ok().filter(|time: &f64| time.is_finite()),
                "timestep" | "step" => {
                    let whole = |x: f64| ((0.0..9e15).contains(&x) && x.fract() == 0.0).then_some(x as u64);
                    let step = value.parse().ok().or_else(|| value.parse().ok().and_then(whole));
                    let message = || format!("`{}` is no time step, expected a whole number", shown(value));
                    comment.step = Some(step.ok_or_else(message)?);
                }
                _ => {}
            }
        }
        Ok(comment)
    }
}

/// The pairs of a key and a value in a comment: `key=value`, `key="a value"`, `key: value`.
fn pairs(line: &str) -> Vec<(&str, &str)> {
    let mut found = vec![];
    let mut rest = line.trim();
    while let Some(at) = rest.find(['=', ':']) {
        let key = rest[..at].trim_end().rsplit(char::is_whitespace).next().unwrap_or("");
        rest = &rest[at + 1..];
        let value = rest.trim_start();
        let quote = value.chars().next().filter(|c| matches!(c, '"' | '\'' | '{' | '['));
        let closing = quote.map(|c| {
            if c == '{' {
                '}'
            } else if c == '[' {
                ']'
            } else {
                c
            }
        });
        let (value, after) = match closing.and_then(|c| value[1..].split_once(c)) {
            Some(split) => split,
            None => value.split_once(char::is_whitespace).unwrap_or((value, "")),
        };
        found.push((key, value.trim_end_matches([',', ';'])));
        rest = after;
    }
    found
}

/// The names of the columns that the properties have, `species:S:1:pos:R:3`.
fn columns_of(properties: &str) -> Result<Vec<String>, String> {
    /// Columns of a property at most.
    const WIDEST: usize = 64;
    let words: Vec<&str> = properties.split(':').collect();
    let mut names = vec![];
    for property in words.chunks(3) {
        let &[name, kind, width] = property else {
            return Err("the properties end early, expected `name:type:columns` of each".into());
        };
        let width = width.parse().ok().filter(|width| (1..=WIDEST).contains(width));
        let (Some(width), "S" | "R" | "I" | "L", false) = (width, kind, name.is_empty()) else {
            let property = shown(&property.join(":"));
            return Err(format!(
                "`{property}` is no property, expected `name:type:columns` with the type S, R, I or L"
            ));
        };
        let is_turn = ["orientation", "quat"].iter().any(|turn| name.to_lowercase().contains(turn));
        let axes: &[&str] = match width {
            3 => &["x", "y", "z"],
            4 if is_turn => &["x", "y", "z", "w"],
            _ => &[],
        };
        names.extend((0..width).map(|k| match (axes.get(k), name) {
            _ if width == 1 => name.to_string(),
            (Some(axis), "pos" | "Position" | "position") => axis.to_string(),
            (Some(axis), _) => format!("{name}_{axis}"),
            (None, _) => format!("{name}_{}", k + 1),
        }));
    }
    Ok(names)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Column, rows::tests::mutated};

    fn read_text(text: &str) -> Result<Frame, Fault> {
        frame(Path::new("a.xyz"), text, 0)
    }

    /// As ASE writes (ase/io/extxyz.py, `write_xyz`), and OVITO's exporter.
    const EXTENDED: &str = "2\nLattice=\"5.0 0 0 0 5 0 0 0 5\" Properties=species:S:1:pos:R:3:velo:R:3:radius:R:1:orientation:R:4 \
         Time=0.25 Timestep=100 pbc=\"T T F\"\n\
         Si 0.5 1 2 0 0 -1 0.1 0 0 0 1\nO 1.5 1 2 0 0 -2 0.2 0 0 0 1\n";

    #[test]
    fn columns_are_those_of_the_properties() {
        let frame = read_text(EXTENDED).unwrap();
        let names = "species x y z velo_x velo_y velo_z radius orientation_x orientation_y orientation_z orientation_w";
        assert_eq!(frame.names().join(" "), names);
        assert_eq!((frame.time, frame.rows(), frame.column("species").unwrap().text(1)), (0.25, 2, "O".into()));
        assert_eq!(frame.column("radius"), Some(&Column::F64(vec![0.1, 0.2])));
        let plain = read_text("2\nwater\nH 0 0 0.5 7\nO 0 0 0 8\n\n").unwrap();
        assert_eq!(plain.names(), ["kind", "x", "y", "z", "c5"]);
        assert_eq!(read_text("0\n\n").unwrap().rows(), 0);
    }

    #[test]
    fn comments_tell_step_and_time() {
        let of = |line: &str| Comment::of(line).map(|c| (c.step, c.time));
        assert_eq!(of("Atoms. Timestep: 1200"), Ok((Some(1200), None)));
        assert_eq!(of("Atoms. Timestep: 12 Time: 0.5"), Ok((Some(12), Some(0.5))));
        assert_eq!(of("step=3.0, time = nan"), Ok((Some(3), None)));
        assert_eq!(of("a=\"step=4\" Time=2"), Ok((None, Some(2.0))));
        assert_eq!(of("i = 5, time = 2.5, E = -1"), Ok((None, Some(2.5))));
        assert!(of("Timestep=half").is_err());
    }

    #[test]
    fn several_frames_are_found_and_read_by_themselves() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let second = EXTENDED.replace("Timestep=100", "Timestep=200").replace("0.25", "0.5");
        std::fs::write(file.path(), [EXTENDED, &second, "\n"].concat()).unwrap();
        let found = parts(file.path()).unwrap();
        assert_eq!(found.iter().map(|p| p.step).collect::<Vec<_>>(), [Some(100), Some(200)]);
        assert_eq!(read(file.path(), Some(&found[1]), 200).unwrap().time, 0.5);
        assert!(is_xyz(EXTENDED.as_bytes()) && is_xyz(b"1\n\nH 0 0 0\n") && !is_xyz(b"2\n3\n4\n"));
        std::fs::write(file.path(), [EXTENDED, &second.replace("2\nL", "3\nL")].concat()).unwrap();
        let found = parts(file.path()).unwrap();
        let fault = read(file.path(), Some(&found[1]), 200).unwrap_err();
        assert!(fault.line == 8 && fault.message.contains("expected 3 rows, found 2"), "{fault}");
    }

    #[test]
    fn wrong_files_are_told_with_their_lines() {
        for (text, line, message) in [
            (EXTENDED.replace("O 1.5 1 2 0 0 -2 0.2 0 0 0 1\n", ""), 3, "expected 2 rows, found 1"),
            (EXTENDED.replace("O 1.5", "O"), 4, "row has 11 cells, expected 12"),
            (EXTENDED.replace("2\nLattice", "1\nLattice"), 4, "expected the end after 1 row"),
            (EXTENDED.replace("2\nLattice", "9999999999999999\nLattice"), 4, "found 2"),
            (EXTENDED.replace("2\nLattice", "many\nLattice"), 1, "no count of rows"),
            (EXTENDED.replace("pos:R:3", "pos:R"), 2, "no property"),
            (EXTENDED.replace("pos:R:3", "pos:R:99999999"), 2, "no property"),
            (EXTENDED.replace("radius", "x"), 2, "two columns are named `x`"),
            ([EXTENDED, EXTENDED].concat(), 5, "expected the end"),
            ("2".into(), 1, "expected a comment"),
        ] {
            let fault = read_text(&text).unwrap_err();
            assert!(fault.message.contains(message) && fault.line == line, "{fault} for\n{text}");
        }
        mutated(EXTENDED.as_bytes(), |bytes, path| {
            let _ = is_xyz(bytes);
            for part in parts(path).unwrap_or_default() {
                let _ = read(path, Some(&part), 0);
            }
            let _ = read(path, None, 0);
        });
    }
}
