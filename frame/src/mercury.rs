//! Particles of MercuryDPM (`NAME.data`, or `NAME.data.7` of a file for each time) as frames.
//!
//! A frame is a line `N time xmin ymin zmin xmax ymax zmax` and N rows `x y z vx vy vz radius`, three angles, three rates of rotation
//! and a number of the particle's own; in two dimensions `N time xmin ymin xmax ymax` and `x y vx vy radius angle omega info`
//! (MercuryDPM, Kernel/DPMBase.cc: `outputXBallsData`, and `readNextDataFile` with its formats 14 and 8). No step is told.

use crate::part::{self, Part, Scan};
use crate::rows::{self, Lines};
use crate::{Column, Fault, FaultKind, Field, Frame};
use std::path::Path;

/// Columns of a row in three dimensions; others may follow.
const SPACE: [&str; 14] = [
    "x", "y", "z", "vx", "vy", "vz", "radius", "angle_x", "angle_y", "angle_z", "omega_x", "omega_y", "omega_z", "info",
];
/// Columns of a row in two dimensions.
const PLANE: [&str; 8] = ["x", "y", "vx", "vy", "radius", "angle", "omega", "info"];

/// The line before the rows of a frame.
struct Head {
    count: u64,
    time: f64,
    is_plane: bool,
}

impl Head {
    fn of(line: &str) -> Option<Head> {
        let (count, rest) = line.trim().split_once(' ')?;
        let numbers: Vec<f64> = rest.split_whitespace().map(|word| word.parse().ok()).collect::<Option<_>>()?;
        let is_plane = match numbers.len() {
            5 => true,
            7 => false,
            _ => return None,
        };
        Some(Head { count: count.parse().ok()?, time: numbers[0], is_plane })
    }

    /// Whether a line may be a row of the frame.
    fn fits(&self, row: &str) -> bool {
        let mut cells = row.split_whitespace();
        let n = cells.clone().count();
        (if self.is_plane { n == PLANE.len() } else { n >= SPACE.len() }) && cells.all(|c| c.parse::<f64>().is_ok())
    }
}

/// Whether a file begins as those of MercuryDPM do: were it a table without names, its first row would be the only short one.
pub(crate) fn is_mercury(start: &[u8]) -> bool {
    let mut lines = rows::beginning(start).lines();
    let mut is_first = true;
    while let Some(line) = lines.next() {
        let Some(head) = Head::of(line) else { return false };
        if head.count > 0 {
            return lines.next().is_some_and(|row| head.fits(row));
        }
        // Without particles there is nothing but the blank that ends the line.
        if is_first && !line.ends_with(' ') {
            return false;
        }
        is_first = false;
    }
    !is_first
}

const EXPECTED: &str = "expected a count of rows, a time, and the corners of a box: six or eight numbers";

/// The frames of a file, in its order.
pub fn parts(path: &Path) -> Result<Vec<Part>, Fault> {
    let (mut scan, mut line) = (Scan::open(path)?, vec![]);
    while scan.read(&mut line)? {
        let text = String::from_utf8_lossy(&line);
        if text.trim().is_empty() {
            continue;
        }
        let head = Head::of(&text).ok_or_else(|| scan.fault(&line, EXPECTED))?;
        scan.begin();
        let mut n = 0;
        // What is missing is told when the frame is read.
        while n < head.count && scan.skip()? {
            n += 1;
        }
    }
    Ok(scan.parts)
}

/// Read a frame as the frame `number`; the only one of the file if none is given.
pub fn read(path: &Path, part: Option<&Part>, number: u64) -> Result<Frame, Fault> {
    let (text, before) = part::read(path, part)?;
    frame(path, &text, number).map_err(|fault| fault.moved(before))
}

fn frame(path: &Path, text: &str, number: u64) -> Result<Frame, Fault> {
    let mut lines = Lines::new(path, text);
    let head = Head::of(lines.next("a count of rows")?).ok_or_else(|| lines.fault(EXPECTED))?;
    if !head.time.is_finite() {
        return Err(Fault::at(FaultKind::Data, path, text, 1, 1, "the time is no number"));
    }
    let names = if head.is_plane { &PLANE[..] } else { &SPACE[..] };
    let n = lines.peek().filter(|_| head.count > 0 && !head.is_plane).map_or(0, |row| row.split_whitespace().count());
    let more = (names.len()..n).map(|k| format!("c{}", k + 1));
    let fields = names.iter().map(|name| name.to_string()).chain(more).map(|name| Field::new(name, "")).collect();
    let mut columns = lines.columns(fields, head.count, 1)?;
    lines.end(head.count)?;
    if head.is_plane {
        columns.insert(2, (Field::new("z", ""), Column::F64(vec![0.0; columns[0].1.len()])));
    }
    Ok(Frame { number, time: head.time, columns })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rows::tests::mutated;

    const TWO: &str = "2 0 0 0 0 1 1 2 \n0.5 0.5 1 0 0 -1 0.1 0 0 0 0 0 3 0\n0.2 0.5 1 0 0 -1 0.2 0 0 0 0 0 0 1\n\
         1 0.25 0 0 0 1 1 2 \n0.5 0.5 0.75 0 0 -2 0.1 0 0 0 0 0 3 0\n";
    const FLAT: &str = "1 0.5 0 0 1 1 \n0.5 0.25 0 -1 0.1 0 3 0\n";

    #[test]
    fn frames_are_told_apart_in_one_file() {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), TWO).unwrap();
        let found = parts(file.path()).unwrap();
        let frames: Vec<Frame> = found.iter().map(|p| read(file.path(), Some(p), 0).unwrap()).collect();
        assert_eq!(frames.iter().map(|f| (f.time, f.rows())).collect::<Vec<_>>(), [(0.0, 2), (0.25, 1)]);
        assert_eq!(frames[0].column("radius"), Some(&Column::F64(vec![0.1, 0.2])));
        assert_eq!(frames[1].column("vz"), Some(&Column::I64(vec![-2])));
        let flat = frame(Path::new("a.data"), FLAT, 0).unwrap();
        assert_eq!(flat.names().join(" "), "x y z vx vy radius angle omega info");
        assert_eq!(flat.column("z"), Some(&Column::F64(vec![0.0])));
    }

    #[test]
    fn they_are_known_by_their_content() {
        for text in [TWO, FLAT, "0 0 0 0 0 1 1 2 \n", "0 0 0 0 1 1 \n1 0 0 0 1 1 \n1 2 3 4 5 6 7 8\n"] {
            assert!(is_mercury(text.as_bytes()), "{text}");
        }
        for text in ["1 2 3 4 5 6 7 8\n1 2 3 4 5 6 7 8\n", "0 1 2 3 4 5\n", "x y\n1 2\n", "", "1 0 0 0 1 1\n1 2 3\n"] {
            assert!(!is_mercury(text.as_bytes()), "{text}");
        }
    }

    #[test]
    fn wrong_files_are_told_with_their_lines() {
        for (text, line, message) in [
            (TWO.to_string(), 4, "expected the end after 2 rows"),
            (TWO.lines().take(2).collect::<Vec<_>>().join("\n"), 2, "expected 2 rows, found 1"),
            (FLAT.replace("0.1 0 3 0", "0.1 0 3"), 2, "row has 7 cells, expected 8"),
            (FLAT.replace("1 0.5", "many 0.5"), 1, "expected a count of rows"),
            (FLAT.replace("1 0.5", "18446744073709551615 0.5"), 2, "found 1"),
        ] {
            let fault = frame(Path::new("a.data"), &text, 0).unwrap_err();
            assert!(fault.message.contains(message) && fault.line == line, "{fault} for\n{text}");
        }
        mutated(TWO.as_bytes(), |bytes, path| {
            let _ = is_mercury(bytes);
            for part in parts(path).unwrap_or_default() {
                let _ = read(path, Some(&part), 0);
            }
            let _ = read(path, None, 0);
        });
    }
}
