//! Lines of text, and the rows of numbers and words between blanks in them, as columns.

use crate::csv::{self, Numbers};
use crate::{Column, Fault, FaultKind, Field};
use std::fmt::Display;
use std::path::Path;

/// The lines of a text that are still to be read.
#[derive(Clone)]
pub(crate) struct Lines<'a> {
    path: &'a Path,
    text: &'a str,
    /// Where the next line begins.
    at: usize,
    /// Number of the last line, from 1.
    line: usize,
}

impl<'a> Lines<'a> {
    pub(crate) fn new(path: &'a Path, text: &'a str) -> Lines<'a> {
        Lines { path, text, at: 0, line: 0 }
    }

    /// The next line, which has what is expected.
    pub(crate) fn next(&mut self, expected: impl Display) -> Result<&'a str, Fault> {
        self.take().ok_or_else(|| self.cut(&format!("expected {expected} below")))
    }

    /// The next line, if there is one.
    pub(crate) fn take(&mut self) -> Option<&'a str> {
        let rest = &self.text[self.at..];
        if rest.is_empty() {
            return None;
        }
        let end = rest.find('\n').unwrap_or(rest.len());
        self.at += (end + 1).min(rest.len());
        self.line += 1;
        Some(rest[..end].strip_suffix('\r').unwrap_or(&rest[..end]))
    }

    /// Number of the last line, from 1; 0 before the first.
    pub(crate) fn line(&self) -> usize {
        self.line
    }

    /// The next line, which is not passed.
    pub(crate) fn peek(&self) -> Option<&'a str> {
        self.text[self.at..].lines().next()
    }

    /// A fault in the last line.
    pub(crate) fn fault(&self, message: impl Into<String>) -> Fault {
        Fault::at(FaultKind::Data, self.path, self.text, self.line.max(1), 1, message)
    }

    /// The fault of a text that ends with the last line.
    fn cut(&self, expected: &str) -> Fault {
        self.fault(format!("ends here, {expected}"))
            .hint("the program that wrote it was interrupted, or is still writing it")
    }

    /// The columns of the next rows, each with a cell of every field. Names stand in the line `named`.
    pub(crate) fn columns(
        &mut self,
        fields: Vec<Field>,
        count: u64,
        named: usize,
    ) -> Result<Vec<(Field, Column)>, Fault> {
        let rows = &self.text[self.at..];
        let mut columns = Columns::new(fields.len());
        for k in 0..count {
            let Some(line) = self.take() else { return Err(self.cut(&format!("expected {count} rows, found {k}"))) };
            let found = columns.push(line);
            if found != fields.len() {
                let names: Vec<&str> = fields.iter().map(|field| field.name.as_str()).collect();
                let message = format!("row has {found} cells, expected {}", crate::column::counted(&names));
                return Err(self.fault(message));
            }
        }
        let column = |(field, column): (Field, Option<Column>)| match column {
            Some(column) => Ok((field, column)),
            None => {
                let message = format!("`{}` has numbers of two kinds", field.name);
                Err(Fault::at(FaultKind::Data, self.path, self.text, named, 1, message))
            }
        };
        fields.into_iter().zip(columns.finish(rows.lines())).map(column).collect()
    }

    /// Check that nothing but blanks is behind a number of rows.
    pub(crate) fn end(mut self, count: u64) -> Result<(), Fault> {
        while let Some(line) = self.take() {
            if !line.trim().is_empty() {
                let rows = if count == 1 { "row" } else { "rows" };
                return Err(self.fault(format!("expected the end after {count} {rows}")));
            }
        }
        Ok(())
    }
}

/// Columns of rows of cells between blanks, as far as they have been read.
pub(crate) struct Columns {
    numbers: Vec<Numbers>,
    n_rows: usize,
}

impl Columns {
    pub(crate) fn new(count: usize) -> Columns {
        Columns { numbers: vec![Numbers::default(); count], n_rows: 0 }
    }

    /// Read a row; the count of its cells, which is that of the columns if it is a whole one.
    pub(crate) fn push(&mut self, row: &str) -> usize {
        let mut found = 0;
        for cell in row.split_ascii_whitespace() {
            if let Some(column) = self.numbers.get_mut(found) {
                column.push(cell);
            }
            found += 1;
        }
        self.n_rows += 1;
        found
    }

    /// The columns, given the rows again for those that have others than plain numbers; none for numbers that are not written alike.
    pub(crate) fn finish<'a>(self, rows: impl Iterator<Item = &'a str>) -> Vec<Option<Column>> {
        let is_other: Vec<bool> = self.numbers.iter().map(Numbers::is_other).collect();
        let mut cells: Vec<Vec<&str>> = vec![vec![]; is_other.len()];
        if is_other.contains(&true) {
            for row in rows.take(self.n_rows) {
                let own = row.split_ascii_whitespace().zip(&mut cells).zip(&is_other);
                own.filter(|(_, is_other)| **is_other).for_each(|((cell, cells), _)| cells.push(cell));
            }
        }
        let column = |(numbers, cells): (Numbers, Vec<&str>)| match numbers.is_other() {
            true => csv::column(&cells),
            false => Some(numbers.column().0),
        };
        self.numbers.into_iter().zip(cells).map(column).collect()
    }
}

/// The text that a file begins with, as far as it is text.
pub(crate) fn beginning(start: &[u8]) -> &str {
    std::str::from_utf8(start).unwrap_or_else(|e| std::str::from_utf8(&start[..e.valid_up_to()]).unwrap_or(""))
}

#[cfg(test)]
pub(crate) mod tests {
    use std::path::Path;

    /// Give wounded copies of a file to a reader, as bytes and as a file.
    pub(crate) fn mutated(good: &[u8], read: impl Fn(&[u8], &Path)) {
        let file = tempfile::NamedTempFile::new().unwrap();
        let mut state = 0x2545_f491_4f6c_dd1du64;
        let mut random = |below: usize| {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 11) as usize % below.max(1)
        };
        for _ in 0..2000 {
            let mut bytes = good.to_vec();
            for _ in 0..=random(4) {
                let at = random(bytes.len());
                match random(6) {
                    0 => bytes.truncate(at),
                    1 => bytes.insert(at, b"0123456789 \n-+.e:=\xff\0"[random(20)]),
                    2 if at < bytes.len() => drop(bytes.remove(at)),
                    3 if at < bytes.len() => bytes[at] ^= 1 << random(8),
                    4 => bytes.splice(at..at, *b"99999999999").for_each(drop),
                    _ if at < bytes.len() => bytes[at] = random(256) as u8,
                    _ => {}
                }
            }
            // A file that is there is not written over, since some systems wait for the disk then.
            let _ = std::fs::remove_file(file.path());
            std::fs::write(file.path(), &bytes).unwrap();
            read(&bytes, file.path());
        }
    }
}
