//! Files that have several tables, one behind the other: where each of these stands, and its text.

use crate::{Fault, FaultKind, gzip, text};
use std::io::{BufRead, Read};
use std::path::Path;

/// A table of a file of several, and where it stands in what is unpacked of the file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part {
    /// Its time step, if the file tells it.
    pub step: Option<u64>,
    /// Its first byte.
    offset: u64,
    /// Count of its bytes.
    length: u64,
    /// Its first line, from 1.
    line: usize,
}

/// The lines of a file, one at a time, in constant memory; and the parts that are found.
pub(crate) struct Scan<'a> {
    path: &'a Path,
    file: Box<dyn BufRead>,
    /// Number of the last line, from 1.
    pub(crate) line: usize,
    /// Where the next line begins.
    offset: u64,
    /// Count of the bytes of the last.
    length: u64,
    /// The parts that have begun.
    pub(crate) parts: Vec<Part>,
}

impl<'a> Scan<'a> {
    pub(crate) fn open(path: &'a Path) -> Result<Scan<'a>, Fault> {
        Ok(Scan { path, file: gzip::open(path)?, line: 0, offset: 0, length: 0, parts: vec![] })
    }

    /// Read the next line, at most its first 64 KiB, with its end; false at the end of the file.
    pub(crate) fn read(&mut self, line: &mut Vec<u8>) -> Result<bool, Fault> {
        /// Bytes that a line has at most, beyond which it is not kept.
        const LONGEST: u64 = 1 << 16;
        line.clear();
        let unreadable = |e: std::io::Error| gzip::fault(self.path, &e);
        let mut n = self.file.by_ref().take(LONGEST).read_until(b'\n', line).map_err(unreadable)? as u64;
        if n == 0 {
            return Ok(false);
        }
        if line.last() != Some(&b'\n') {
            n += self.file.skip_until(b'\n').map_err(unreadable)? as u64;
        }
        if self.line == 0 && line.starts_with(text::MARK.as_bytes()) {
            line.drain(..text::MARK.len());
        }
        self.go_on(n);
        Ok(true)
    }

    /// Pass over the next line; false at the end of the file.
    pub(crate) fn skip(&mut self) -> Result<bool, Fault> {
        let n = self.file.skip_until(b'\n').map_err(|e| gzip::fault(self.path, &e))? as u64;
        if n > 0 {
            self.go_on(n);
        }
        Ok(n > 0)
    }

    fn go_on(&mut self, n: u64) {
        self.line += 1;
        self.offset += n;
        self.length = n;
        if let Some(last) = self.parts.last_mut() {
            last.length = self.offset - last.offset;
        }
    }

    /// Let a part begin with the last line.
    pub(crate) fn begin(&mut self) {
        let Scan { offset, length, line, .. } = *self;
        if let Some(last) = self.parts.last_mut() {
            last.length -= length;
        }
        self.parts.push(Part { step: None, offset: offset - length, length, line });
    }

    /// Note the time step of the part that has begun.
    pub(crate) fn is_at(&mut self, step: Option<u64>) {
        if let Some(last) = self.parts.last_mut() {
            last.step = step;
        }
    }

    /// A fault in the last line.
    pub(crate) fn fault(&self, line: &[u8], message: impl Into<String>) -> Fault {
        let text = String::from_utf8_lossy(line);
        Fault::at(FaultKind::Data, self.path, text.trim_end(), 1, 1, message).moved(self.line.max(1) - 1)
    }
}

/// The text of a part of a file, of the whole if none is given; and the lines before it.
pub(crate) fn read(path: &Path, part: Option<&Part>) -> Result<(String, usize), Fault> {
    let (bytes, before) = match part {
        None => (gzip::read(path)?, 0),
        Some(part) => (gzip::read_part(path, part.offset, part.length)?, part.line - 1),
    };
    let mut text =
        text::decode(bytes).map_err(|_| Fault::whole(FaultKind::Data, path, "has bytes that are no text"))?;
    if text.starts_with(text::MARK) {
        text.remove(0);
    }
    Ok((text, before))
}
