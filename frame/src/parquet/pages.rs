//! The sizes of a column's pages, read from their heads before the decoder takes memory by them.
//!
//! A head is a structure of Thrift's compact protocol (`PageHeader` of Apache Parquet's `parquet.thrift`), of which the fields 2 and 3
//! are the sizes of the page before and after it was compressed.

use parquet::basic::Compression;
use parquet::file::metadata::ColumnChunkMetaData;
use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};

/// What deflate makes of a byte at most.
const DEFLATE: u64 = 1032;

/// Whether the pages of a column, unpacked one by one, take no more than `room` bytes each. An error if a page is outside of the
/// file or has no whole head.
pub(super) fn fit(file: &mut File, column: &ColumnChunkMetaData, room: u64) -> io::Result<bool> {
    let outside = || io::Error::other("a page is outside of its column");
    let (start, length) = column.byte_range();
    let (mut at, end) = (start, start.checked_add(length).ok_or_else(outside)?);
    while at < end {
        let head = read_head(file, at, end)?;
        let most = match column.compression() {
            // Its decoder goes on for as long as the bytes do.
            Compression::GZIP(_) => head.unpacked.max(head.packed.saturating_mul(DEFLATE)),
            _ => head.unpacked,
        };
        if most > room {
            return Ok(false);
        }
        at = at.checked_add(head.length + head.packed).filter(|next| *next <= end).ok_or_else(outside)?;
    }
    Ok(true)
}

/// The head of a page.
#[derive(Debug, PartialEq)]
struct Head {
    /// Bytes of the page before it was compressed.
    unpacked: u64,
    /// Bytes of the page in the file.
    packed: u64,
    /// Bytes of the head.
    length: u64,
}

/// The head at a place of the file.
fn read_head(file: &mut File, at: u64, end: u64) -> io::Result<Head> {
    // Most are short; those with texts as statistics may be longer.
    for most in [256, 1 << 16, 1 << 24] {
        file.seek(SeekFrom::Start(at))?;
        let mut bytes = vec![];
        Read::by_ref(file).take((end - at).min(most)).read_to_end(&mut bytes)?;
        if let Some(head) = head(&bytes) {
            return Ok(head);
        }
    }
    Err(io::Error::other("a page has no whole head"))
}

/// The head that bytes begin with.
fn head(bytes: &[u8]) -> Option<Head> {
    let mut own = Compact(bytes);
    let (mut sizes, mut id) = ([None; 2], 0);
    while let Some(kind) = own.field(&mut id)? {
        match (id, kind) {
            (2 | 3, Compact::I32) => sizes[id as usize - 2] = Some(u64::try_from(own.integer()?).ok()?),
            _ => own.skip(kind, 0)?,
        }
    }
    Some(Head { unpacked: sizes[0]?, packed: sizes[1]?, length: (bytes.len() - own.0.len()) as u64 })
}

/// Bytes of the compact protocol that are not read yet.
struct Compact<'a>(&'a [u8]);

impl Compact<'_> {
    const I32: u8 = 5;

    fn byte(&mut self) -> Option<u8> {
        let (first, rest) = self.0.split_first()?;
        self.0 = rest;
        Some(*first)
    }

    fn pass(&mut self, n: u64) -> Option<()> {
        self.0 = self.0.get(usize::try_from(n).ok()?..)?;
        Some(())
    }

    /// A number of seven bits a byte, the lowest first.
    fn count(&mut self) -> Option<u64> {
        let mut all = 0;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            all |= u64::from(byte & 127) << shift;
            if byte < 128 {
                return Some(all);
            }
        }
        None
    }

    /// A signed number, whose lowest bit is its sign.
    fn integer(&mut self) -> Option<i64> {
        let n = self.count()?;
        Some((n >> 1) as i64 ^ -((n & 1) as i64))
    }

    /// The kind of the next field of a structure, and `id` set to its number; none at the end.
    fn field(&mut self, id: &mut i64) -> Option<Option<u8>> {
        let byte = self.byte()?;
        if byte == 0 {
            return Some(None);
        }
        *id = match byte >> 4 {
            0 => self.integer()?,
            step => id.checked_add(step.into())?,
        };
        Some(Some(byte & 15))
    }

    /// Pass over a value.
    fn skip(&mut self, kind: u8, depth: usize) -> Option<()> {
        if depth > 8 {
            return None;
        }
        match kind {
            // True and false, which are their field's kind.
            1 | 2 => Some(()),
            3 => self.pass(1),
            4..=6 => self.count().map(drop),
            7 => self.pass(8),
            8 => {
                let n = self.count()?;
                self.pass(n)
            }
            9 | 10 => {
                let byte = self.byte()?;
                let n = if byte >> 4 == 15 { self.count()? } else { u64::from(byte >> 4) };
                let kind = byte & 15;
                (0..n).try_for_each(|_| if kind <= 2 { self.pass(1) } else { self.skip(kind, depth + 1) })
            }
            12 => {
                let mut id = 0;
                while let Some(kind) = self.field(&mut id)? {
                    self.skip(kind, depth + 1)?;
                }
                Some(())
            }
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heads_are_read_to_their_end() {
        // Data page, 300 bytes, 20 in the file, a structure with a count and a text, a list of three numbers.
        let bytes = [
            0x15, 0, 0x15, 0xd8, 0x04, 0x15, 40, 0x2c, 0x15, 6, 0x18, 2, b'a', b'b', 0, 0x19, 0x35, 2, 4, 6, 0, 99, 99,
        ];
        assert_eq!(head(&bytes), Some(Head { unpacked: 300, packed: 20, length: bytes.len() as u64 - 2 }));
        assert!((0..bytes.len() - 2).all(|end| head(&bytes[..end]).is_none()));
        // A negative size, a size that is missing, structures without an end, and lists of as many elements as there are numbers.
        assert_eq!(head(&[0x15, 0, 0x15, 1, 0x15, 40, 0]), None);
        assert_eq!(head(&[0x15, 0, 0x15, 2, 0]), None);
        assert_eq!(head(&[0x1c; 5000]), None);
        assert_eq!(head(&[0x19, 0xf5, 255, 255, 255, 255, 255, 255, 255, 255, 255, 1]), None);
    }
}
