//! Legacy VTK files, text or big-endian bytes, of the versions 1 to 5.1 (VTK User's Guide, "VTK File Formats"; for 5.1,
//! IO/Legacy/vtkDataReader.cxx).

use super::arrays::{Array, Order, Points, Scalar, Source, Words, check_width};
use crate::{Column, Fault};

/// What every legacy file begins with.
pub(super) const MAGIC: &[u8] = b"# vtk DataFile Version";

/// Read the points of a file.
pub(super) fn points(source: Source<'_>) -> Result<Points, Fault> {
    let mut file = Legacy { source, at: 0, is_binary: false, points: Points::default(), of: Of::Header, cells: vec![] };
    file.header()?;
    let mut vertices = Some(vec![]);
    let mut has_points = false;
    while let Some(line) = file.line()? {
        match line.keyword().as_str() {
            "POINTS" => {
                let n = file.count(&line, 1)?;
                let kind = file.scalar(&line, 2)?;
                file.points.place = file.columns(&line, kind, n, 3)?;
                has_points = true;
            }
            "VERTICES" | "CELLS" => {
                let own = file.vertices(&line)?;
                vertices = vertices.filter(|v| v.is_empty()).and(own);
            }
            "LINES" | "POLYGONS" | "TRIANGLE_STRIPS" => {
                let n = file.count(&line, 1)?;
                file.vertices(&line)?;
                vertices = vertices.filter(|_| n == 0);
            }
            "CELL_TYPES" => {
                let n = file.count(&line, 1)?;
                file.columns(&line, Scalar::I32, n, 1)?;
            }
            "POINT_DATA" => {
                let n = file.count(&line, 1)?;
                if n != file.points.len() {
                    return Err(file.fault(&line, 1, format!("expected {}, the count of points", file.points.len())));
                }
                file.of = Of::Points;
            }
            "CELL_DATA" => file.of = Of::Cells(file.count(&line, 1)?),
            "METADATA" => file.skip_metadata(),
            _ => file.attribute(&line)?,
        }
    }
    if !has_points {
        let message = "ends here, expected `POINTS` and their coordinates";
        return Err(source.fault(source.bytes.len(), message).hint("the file was cut off, or is still being written"));
    }
    if let Some(vertices) = vertices {
        file.points.add_cells(file.cells, &vertices);
    }
    Ok(file.points)
}

/// What the arrays of a part of a file belong to.
#[derive(Clone, Copy)]
enum Of {
    Header,
    Points,
    /// As many cells.
    Cells(usize),
}

/// The words of a line, and where it begins.
struct Line<'a> {
    at: usize,
    text: &'a str,
    words: Vec<&'a str>,
}

impl Line<'_> {
    fn keyword(&self) -> String {
        self.words[0].to_ascii_uppercase()
    }
}

/// A file as it is read.
struct Legacy<'a> {
    source: Source<'a>,
    at: usize,
    is_binary: bool,
    points: Points,
    of: Of,
    /// The arrays of the cells.
    cells: Vec<Array>,
}

impl<'a> Legacy<'a> {
    /// A fault at a word of a line.
    fn fault(&self, line: &Line<'_>, word: usize, message: impl Into<String>) -> Fault {
        let offset = line
            .words
            .get(word)
            .map_or(line.text.trim_end().len(), |w| w.as_ptr() as usize - line.text.as_ptr() as usize);
        self.source.fault(line.at + offset, message)
    }

    /// The next line, of whatever bytes, without its end.
    fn raw_line(&mut self) -> &'a [u8] {
        let rest = &self.source.bytes[self.at..];
        let length = memchr::memchr(b'\n', rest).unwrap_or(rest.len());
        self.at = (self.at + length + 1).min(self.source.bytes.len());
        &rest[..length]
    }

    /// The next line that has words.
    fn line(&mut self) -> Result<Option<Line<'a>>, Fault> {
        /// Bytes that a line of keywords has at most.
        const LONGEST: usize = 1 << 12;
        let rest = &self.source.bytes[self.at..];
        let Some(start) = rest.iter().position(|b| !b.is_ascii_whitespace() && *b != 0) else { return Ok(None) };
        self.at += start;
        let at = self.at;
        let bytes = self.raw_line();
        let text = std::str::from_utf8(bytes).ok().filter(|text| text.len() < LONGEST);
        let text = text.filter(|text| !text.contains(|c: char| c.is_control() && !c.is_whitespace()));
        let words = |text: &'a str| text.split_whitespace().collect::<Vec<_>>();
        match text.map(|text| Line { at, text, words: words(text) }).filter(|line| !line.words.is_empty()) {
            Some(line) => Ok(Some(line)),
            None => Err(self
                .source
                .fault(at, "expected a keyword such as `POINT_DATA` or `SCALARS`")
                .hint("the count of the data above is not that of its values, or the file is damaged")),
        }
    }

    fn header(&mut self) -> Result<(), Fault> {
        self.raw_line();
        self.raw_line();
        let source = self.source;
        let cut = |expected: &str| source.fault(source.bytes.len(), format!("ends here, expected {expected}"));
        let line = self.line()?.ok_or_else(|| cut("`ASCII` or `BINARY`"))?;
        self.is_binary = match line.keyword().as_str() {
            "ASCII" => false,
            "BINARY" => true,
            _ => return Err(self.fault(&line, 0, "expected `ASCII` or `BINARY`")),
        };
        let line = self.line()?.ok_or_else(|| cut("`DATASET`"))?;
        let kind = line.words.get(1).map(|kind| kind.to_ascii_uppercase());
        match (line.keyword().as_str(), kind.as_deref()) {
            ("DATASET", Some("POLYDATA" | "UNSTRUCTURED_GRID")) => {}
            ("DATASET", _) => {
                let message = "expected POLYDATA or UNSTRUCTURED_GRID: particles are points, and other grids have none";
                return Err(self.fault(&line, 1, message));
            }
            _ => return Err(self.fault(&line, 0, "expected `DATASET`")),
        }
        Ok(())
    }

    /// The count that a word of a line is.
    fn count(&self, line: &Line<'_>, word: usize) -> Result<usize, Fault> {
        let count = line.words.get(word).and_then(|text| text.parse().ok());
        count.ok_or_else(|| self.fault(line, word, "expected a count, a whole number"))
    }

    /// The type that a word of a line names.
    fn scalar(&self, line: &Line<'_>, word: usize) -> Result<Scalar, Fault> {
        let kind = line.words.get(word).and_then(|name| Scalar::of_legacy(name));
        kind.ok_or_else(|| self.fault(line, word, "expected a type of numbers, such as `float` or `int`"))
    }

    /// The columns of `n` tuples, which stand below the line.
    fn columns(&mut self, line: &Line<'_>, kind: Scalar, n: usize, width: usize) -> Result<Vec<Column>, Fault> {
        let width = check_width(width).map_err(|e| self.fault(line, line.words.len(), e))?;
        if !self.is_binary {
            let mut words = Words { source: self.source, at: self.at, end: self.source.bytes.len() };
            let columns = words.columns(kind, n, width, &format!("`{}`", line.text.trim()))?;
            self.at = words.at;
            return Ok(columns);
        }
        let left = &self.source.bytes[self.at..];
        let length = n.checked_mul(width).and_then(|count| kind.bytes(count)).filter(|length| *length <= left.len());
        let Some(length) = length.filter(|length| 8 * *length as u64 <= guard::memory::room()) else {
            let message = format!("`{}` needs more bytes than the {} that follow", line.text.trim(), left.len());
            return Err(self.fault(line, 0, message).hint("the file was cut off, or its counts are wrong"));
        };
        self.at += length;
        Ok(kind.columns(&left[..length], n, width, Order::Big))
    }

    /// The point of each cell, if each has one.
    fn vertices(&mut self, line: &Line<'_>) -> Result<Option<Vec<i64>>, Fault> {
        let (n, size) = (self.count(line, 1)?, self.count(line, 2)?);
        let numbers = |columns: Vec<Column>| match columns.into_iter().next() {
            Some(Column::I64(numbers)) => numbers,
            _ => vec![],
        };
        if !self.is_next("OFFSETS") {
            let all = numbers(self.columns(line, Scalar::I32, size, 1)?);
            let is_vertex = n.checked_mul(2) == Some(size) && all.iter().step_by(2).all(|count| *count == 1);
            return Ok(is_vertex.then(|| all.into_iter().skip(1).step_by(2).collect()));
        }
        let mut part = |name: &str, n: usize| -> Result<Vec<i64>, Fault> {
            let end = self.source.bytes.len();
            let missing = self.source.fault(end, format!("ends here, expected `{name}`"));
            let own = self.line()?.ok_or(missing)?;
            if own.keyword() != name {
                return Err(self.fault(&own, 0, format!("expected `{name}`")));
            }
            let kind = self.scalar(&own, 1)?;
            Ok(numbers(self.columns(&own, kind, n, 1)?))
        };
        let offsets = part("OFFSETS", n)?;
        let points = part("CONNECTIVITY", size)?;
        let is_vertex = offsets.len() == points.len() + 1 && offsets.iter().zip(0..).all(|(own, k)| *own == k);
        Ok(is_vertex.then_some(points))
    }

    /// Whether a keyword is next.
    fn is_next(&self, keyword: &str) -> bool {
        let rest = &self.source.bytes[self.at..];
        let start = rest.iter().position(|b| !b.is_ascii_whitespace()).unwrap_or(0);
        rest[start..].get(..keyword.len()).is_some_and(|word| word.eq_ignore_ascii_case(keyword.as_bytes()))
    }

    /// Skip notes on an array, which end with an empty line.
    fn skip_metadata(&mut self) {
        while !self.raw_line().trim_ascii().is_empty() {}
    }

    /// Read an attribute of points or cells, or a field.
    fn attribute(&mut self, line: &Line<'_>) -> Result<(), Fault> {
        let n = match self.of {
            Of::Header if line.keyword() == "FIELD" => 0,
            Of::Header => {
                return Err(self.fault(line, 0, "expected `POINTS`, `POINT_DATA` or another keyword of this place"));
            }
            Of::Points => self.points.len(),
            Of::Cells(n) => n,
        };
        let width = match line.keyword().as_str() {
            "FIELD" => return self.field(line),
            "SCALARS" if line.words.len() > 3 => self.count(line, 3)?,
            "SCALARS" | "GLOBAL_IDS" | "PEDIGREE_IDS" | "EDGE_FLAGS" => 1,
            "VECTORS" | "NORMALS" => 3,
            "TENSORS6" => 6,
            "TENSORS" => 9,
            "TEXTURE_COORDINATES" => self.count(line, 2)?,
            "COLOR_SCALARS" => self.count(line, 2)?,
            "LOOKUP_TABLE" => {
                let (n, kind) = (self.count(line, 2)?, if self.is_binary { Scalar::U8 } else { Scalar::F32 });
                return self.columns(line, kind, n, 4).map(|_| ());
            }
            _ => {
                let message = "expected a keyword such as `SCALARS`, `VECTORS` or `FIELD`";
                let fault = self.fault(line, 0, message);
                return Err(fault.hint("there may be more values above than their count says"));
            }
        };
        let kind = match line.keyword().as_str() {
            "COLOR_SCALARS" if self.is_binary => Scalar::U8,
            "COLOR_SCALARS" => Scalar::F32,
            "TEXTURE_COORDINATES" => self.scalar(line, 3)?,
            _ => self.scalar(line, 2)?,
        };
        if line.keyword() == "SCALARS" && self.is_next("LOOKUP_TABLE") {
            self.line()?;
        }
        let columns = self.columns(line, kind, n, width)?;
        self.push(Array { name: decoded(line.words.get(1).unwrap_or(&"")), columns });
        Ok(())
    }

    fn push(&mut self, array: Array) {
        match self.of {
            Of::Header => {
                let is_time = ["time", "timevalue"].contains(&array.name.to_ascii_lowercase().as_str());
                if is_time && array.columns.len() == 1 && array.len() == 1 {
                    self.points.time = array.columns[0].number(0);
                }
            }
            Of::Points => self.points.arrays.push(array),
            Of::Cells(_) => self.cells.push(array),
        }
    }

    /// Read the arrays of a field.
    fn field(&mut self, line: &Line<'_>) -> Result<(), Fault> {
        let mut left = self.count(line, 2)?;
        while left > 0 {
            let end = self.source.bytes.len();
            let Some(own) = self.line()? else {
                let message = format!("ends here, expected {left} more arrays of `{}`", line.text.trim());
                return Err(self.source.fault(end, message).hint("the file was cut off, or is still being written"));
            };
            if own.keyword() == "METADATA" && own.words.len() == 1 {
                self.skip_metadata();
                continue;
            }
            left -= 1;
            if own.keyword() == "NULL_ARRAY" {
                continue;
            }
            let (width, n) = (self.count(&own, 1)?, self.count(&own, 2)?);
            if !self.is_binary && own.words.get(3).is_some_and(|kind| kind.eq_ignore_ascii_case("string")) {
                // Words have a line each, and may be empty.
                for _ in 0..n.saturating_mul(width) {
                    if self.at == end {
                        return Err(self.fault(&own, 1, "has more words than lines follow"));
                    }
                    self.raw_line();
                }
                continue;
            }
            let kind = self.scalar(&own, 3)?;
            let expected = match self.of {
                Of::Header => n,
                Of::Points => self.points.len(),
                Of::Cells(n) => n,
            };
            if n != expected {
                return Err(self.fault(&own, 2, format!("expected {expected}, a value for each point or cell")));
            }
            // A field may have arrays without values.
            let columns = if width == 0 && n == 0 { vec![] } else { self.columns(&own, kind, n, width)? };
            self.push(Array { name: decoded(own.words[0]), columns });
        }
        Ok(())
    }
}

/// A name, in which blanks and signs are written as `%20`.
fn decoded(name: &str) -> String {
    let mut bytes = vec![];
    let mut rest = name.as_bytes();
    while let [first, tail @ ..] = rest {
        let code = tail.get(..2).filter(|_| *first == b'%').and_then(|hex| std::str::from_utf8(hex).ok());
        match code.and_then(|hex| u8::from_str_radix(hex, 16).ok()) {
            Some(byte) => {
                bytes.push(byte);
                rest = &tail[2..];
            }
            None => {
                bytes.push(*first);
                rest = tail;
            }
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}
