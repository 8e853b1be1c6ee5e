//! The bytes of an array of a VTK file in XML: as they are or in base64, compressed in blocks or not (VTK, "VTK XML Formats").
//!
//! Uncompressed data has the count of its bytes in front. Compressed data has the count of its blocks, the bytes of a block and of
//! the last one if that is shorter (else 0), and the compressed bytes of each; in base64 this head is encoded by itself.

use super::arrays::Order;
use flate2::bufread::ZlibDecoder;
use std::borrow::Cow;
use std::io::Read;
use std::ops::Range;

/// A place in the file, and what is wrong there.
type Wrong = (usize, String);

/// How blocks are compressed.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Compressor {
    None,
    Zlib,
    Lz4,
}

/// How the numbers of a file are written as bytes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Encoding {
    pub(super) order: Order,
    /// Bytes of a count.
    count: usize,
    compressor: Compressor,
}

impl Encoding {
    /// The encoding that attributes of the root tell. An error if it is not read.
    pub(super) fn of<'a>(get: impl Fn(&str) -> Option<&'a str>) -> Result<Encoding, String> {
        let order = match get("byte_order") {
            None | Some("LittleEndian") => Order::Little,
            Some("BigEndian") => Order::Big,
            Some(other) => return Err(format!("has the byte order `{other}`, expected LittleEndian or BigEndian")),
        };
        let count = match get("header_type") {
            None | Some("UInt32") => 4,
            Some("UInt64") => 8,
            Some(other) => return Err(format!("has the header type `{other}`, expected UInt32 or UInt64")),
        };
        let compressor = match get("compressor") {
            None | Some("") => Compressor::None,
            Some("vtkZLibDataCompressor") => Compressor::Zlib,
            Some("vtkLZ4DataCompressor") => Compressor::Lz4,
            Some(other) => {
                return Err(format!("is compressed by {other}; write it by vtkZLibDataCompressor or without"));
            }
        };
        Ok(Encoding { order, count, compressor })
    }

    /// Just `length` bytes of an input.
    pub(super) fn read<'a>(&self, mut input: Input<'a>, length: usize) -> Result<Cow<'a, [u8]>, Wrong> {
        let at = input.at;
        let first = self.counts(&mut input, 1)?[0];
        let mismatch = |n: u64| (at, format!("has {n} bytes, expected {length} by the counts of its values"));
        if self.compressor == Compressor::None {
            if first != length as u64 {
                return Err(mismatch(first));
            }
            return input.take(length);
        }
        let sizes = self.counts(&mut input, 2)?;
        let (n, size, last) = (first, sizes[0], sizes[1]);
        let total = n.checked_sub(u64::from(last > 0)).and_then(|whole| whole.checked_mul(size));
        let total = total.and_then(|bytes| bytes.checked_add(last)).unwrap_or(u64::MAX);
        if total != length as u64 || last > size {
            return Err(mismatch(total));
        }
        let packed = self.counts(&mut input, usize::try_from(n).unwrap_or(usize::MAX))?;
        let sum = packed.iter().try_fold(0u64, |sum, size| sum.checked_add(*size)).unwrap_or(u64::MAX);
        // Neither compressor makes more than 1032 bytes of one.
        if sum > input.left() as u64 || total.div_ceil(1032) > sum || total > guard::memory::room() {
            return Err((at, format!("has blocks that cannot be of {total} bytes")));
        }
        let mut bytes = vec![0; length];
        let mut blocks = bytes.chunks_mut(usize::try_from(size).unwrap_or(usize::MAX).max(1));
        for (k, packed) in packed.iter().enumerate() {
            let at = input.at;
            let block = blocks.next().unwrap_or_default();
            let packed = input.take(usize::try_from(*packed).unwrap_or(usize::MAX))?;
            let is_whole = match self.compressor {
                Compressor::Lz4 => lz4_flex::block::decompress_into(&packed, block).is_ok_and(|n| n == block.len()),
                _ => {
                    let mut own = ZlibDecoder::new(&packed[..]);
                    own.read_exact(block).is_ok() && own.read(&mut [0]).is_ok_and(|n| n == 0)
                }
            };
            if !is_whole {
                return Err((at, format!("is damaged in its compressed block {}", k + 1)));
            }
        }
        Ok(Cow::Owned(bytes))
    }

    /// The next counts of an input.
    fn counts(&self, input: &mut Input<'_>, n: usize) -> Result<Vec<u64>, Wrong> {
        let bytes = input.take(n.saturating_mul(self.count))?;
        let number = |bytes: &[u8]| {
            let big = bytes.iter().fold(0, |sum, b| sum << 8 | u64::from(*b));
            if self.order == Order::Big { big } else { big.swap_bytes() >> (64 - 8 * bytes.len()) }
        };
        Ok(bytes.chunks_exact(self.count).map(number).collect())
    }
}

/// Bytes of a file, as they are read.
pub(super) struct Input<'a> {
    bytes: &'a [u8],
    at: usize,
    end: usize,
    is_raw: bool,
    /// Bytes of base64 that are decoded and not yet taken.
    rest: Vec<u8>,
}

impl<'a> Input<'a> {
    /// A range of a file as it is.
    pub(super) fn raw(bytes: &'a [u8], range: Range<usize>) -> Input<'a> {
        Input { bytes, at: range.start, end: range.end, is_raw: true, rest: vec![] }
    }

    /// A range of a file in base64.
    pub(super) fn base64(bytes: &'a [u8], range: Range<usize>) -> Input<'a> {
        Input { is_raw: false, ..Input::raw(bytes, range) }
    }

    /// Most bytes that are left.
    fn left(&self) -> usize {
        let left = self.end - self.at;
        if self.is_raw { left } else { self.rest.len() + left.div_ceil(4) * 3 }
    }

    /// The next `n` bytes.
    fn take(&mut self, n: usize) -> Result<Cow<'a, [u8]>, Wrong> {
        if n > self.left() {
            return Err((self.at, format!("ends too early: {n} bytes are expected here, and {} left", self.left())));
        }
        if self.is_raw {
            let bytes = &self.bytes[self.at..self.at + n];
            self.at += n;
            return Ok(Cow::Borrowed(bytes));
        }
        if n as u64 > guard::memory::room() {
            return Err((self.at, guard::memory::Full.to_string()));
        }
        let mut bytes = Vec::with_capacity(n + 2);
        bytes.append(&mut self.rest);
        while bytes.len() < n {
            self.decode_whole(&mut bytes, n);
            if bytes.len() < n {
                self.decode_any(&mut bytes)?;
            }
        }
        self.rest = bytes.split_off(n);
        Ok(Cow::Owned(bytes))
    }

    /// Decode groups of four letters until there are `n` bytes, or something else stands there.
    fn decode_whole(&mut self, bytes: &mut Vec<u8>, n: usize) {
        let start = bytes.len();
        let groups = self.bytes[self.at..self.end].chunks_exact(4).take((n - start) / 3);
        bytes.resize(start + 3 * groups.len(), 0);
        let mut done = 0;
        for (group, place) in groups.zip(bytes[start..].chunks_exact_mut(3)) {
            let [a, b, c, d] = [0, 1, 2, 3].map(|k| LETTERS[group[k] as usize]);
            if (a | b | c | d) & NONE != 0 {
                break;
            }
            let [_, first, second, third] = (a << 18 | b << 12 | c << 6 | d).to_be_bytes();
            place.copy_from_slice(&[first, second, third]);
            done += 1;
        }
        self.at += 4 * done;
        bytes.truncate(start + 3 * done);
    }

    /// Decode the next four letters, with blanks between and signs of the end.
    fn decode_any(&mut self, bytes: &mut Vec<u8>) -> Result<(), Wrong> {
        let mut group = 0;
        let (mut n, mut n_ends) = (0, 0);
        while n + n_ends < 4 {
            let Some(letter) = self.bytes[..self.end].get(self.at) else {
                return Err((self.at, "ends too early, within its base64 text".into()));
            };
            match LETTERS[*letter as usize] {
                NONE if letter.is_ascii_whitespace() => {}
                NONE if *letter == b'=' && n >= 2 => n_ends += 1,
                NONE => return Err((self.at, "is no base64 text here".into())),
                _ if n_ends > 0 => return Err((self.at, "is no base64 text here".into())),
                value => {
                    group |= value << (18 - 6 * n);
                    n += 1;
                }
            }
            self.at += 1;
        }
        bytes.extend(&group.to_be_bytes()[1..n]);
        Ok(())
    }
}

/// What is no letter of base64.
const NONE: u32 = 1 << 31;

/// The values of the letters of base64 (RFC 4648, section 4).
static LETTERS: [u32; 256] = {
    let letters = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut values = [NONE; 256];
    let mut k = 0;
    while k < 64 {
        values[letters[k] as usize] = k as u32;
        k += 1;
    }
    values
};
