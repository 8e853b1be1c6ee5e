//! RIB as tokens with their places: ASCII and the binary bytestream, mixed as they come (RISpec appendix C).
//!
//! In the bytestream, bytes from 0200 on encode: numbers of fixed point, strings, floats, arrays of floats, and requests and
//! strings that were given a code before.

use crate::files::text_of;
use crate::requests::Request;
use std::borrow::Cow;

/// A token.
#[derive(Clone, Debug, PartialEq)]
pub enum Token<'a> {
    /// A request's name.
    Word(Cow<'a, str>),
    /// A quoted string, unescaped.
    Text(String),
    /// A number.
    Number(f32),
    /// An encoded array of numbers, which stands for `[ … ]`.
    Numbers(Vec<f32>),
    /// `[`
    Open,
    /// `]`
    Close,
    /// `#` to the line's end, without the `#`.
    Comment(Cow<'a, str>),
}

/// The codes that a bytestream has defined.
#[derive(Clone, Default)]
pub struct Codes {
    /// Requests by code: their names, and their rows of the table if they have one.
    requests: Vec<Option<(Cow<'static, str>, Option<Request>)>>,
    strings: Vec<Option<String>>,
}

/// Put a value at a place of a list that grows as it must.
fn put<T: Clone>(list: &mut Vec<Option<T>>, at: usize, value: T) {
    if list.len() <= at {
        list.resize(at + 1, None);
    }
    list[at] = Some(value);
}

/// Reads tokens.
pub struct Lexer<'a> {
    bytes: &'a [u8],
    at: usize,
    /// The line that `at` is in, from 1, and its first byte.
    line: usize,
    line_start: usize,
    /// The codes that are known.
    pub codes: Codes,
}

/// Where reading stood.
#[derive(Clone, Copy)]
pub(crate) struct Mark {
    at: usize,
    line: usize,
    line_start: usize,
}

/// Maximum length of an encoded string or array; more is a broken stream.
const LONGEST: usize = 1 << 30;

impl<'a> Lexer<'a> {
    /// Start at the beginning.
    pub fn new(bytes: &'a [u8]) -> Lexer<'a> {
        Lexer { bytes, at: 0, line: 1, line_start: 0, codes: Codes::default() }
    }

    /// Count lines and columns from these: what is read is a part of a file.
    pub(crate) fn begin_at(&mut self, (line, column): (usize, usize)) {
        self.line = line;
        // The line begins before what is read.
        self.line_start = self.at.wrapping_sub(column - 1);
    }

    /// The byte that comes next.
    pub fn position(&self) -> usize {
        self.at
    }

    /// Where reading stands, for [`Lexer::place_after`].
    #[inline]
    pub(crate) fn mark(&self) -> Mark {
        Mark { at: self.at, line: self.line, line_start: self.line_start }
    }

    /// The place of what comes after a mark.
    pub(crate) fn place_after(&self, mark: Mark) -> (usize, usize) {
        let Mark { at, line, line_start } = mark;
        Lexer { bytes: self.bytes, at, line, line_start, codes: Codes::default() }.place()
    }

    /// Skip blanks; the place (line, column from 1) of what comes next.
    #[inline]
    pub fn place(&mut self) -> (usize, usize) {
        while let Some(b) = self.bytes.get(self.at) {
            match b {
                b'\n' => {
                    self.at += 1;
                    self.line += 1;
                    self.line_start = self.at;
                }
                // The end mark of a program's answer ends nothing here.
                b' ' | b'\t' | b'\r' | 0xff => self.at += 1,
                _ => break,
            }
        }
        (self.line, self.at.wrapping_sub(self.line_start) + 1)
    }

    /// The next token; `Ok(None)` at the end; `Err` is what is wrong.
    pub fn next(&mut self) -> Result<Option<Token<'a>>, String> {
        self.place();
        let (bytes, start) = (self.bytes, self.at);
        let Some(&first) = bytes.get(start) else { return Ok(None) };
        let until =
            |stop: &dyn Fn(u8) -> bool| bytes[start..].iter().position(|b| stop(*b)).map_or(bytes.len(), |n| start + n);
        match first {
            b'[' | b']' => {
                self.at += 1;
                Ok(Some(if first == b'[' { Token::Open } else { Token::Close }))
            }
            b'#' => {
                self.at = until(&|b| b == b'\n');
                Ok(Some(Token::Comment(String::from_utf8_lossy(bytes[start + 1..self.at].trim_ascii_end()))))
            }
            b'"' => self.quoted().map(|t| Some(Token::Text(t))),
            b'0'..=b'9' | b'+' | b'-' | b'.' => self.number().map(|x| Some(Token::Number(x))),
            b if b.is_ascii_alphabetic() => {
                self.at = until(&|b| !(b.is_ascii_alphanumeric() || b == b'_'));
                Ok(Some(Token::Word(String::from_utf8_lossy(&bytes[start..self.at]))))
            }
            0x80.. => self.encoded(first),
            _ => {
                let rest = String::from_utf8_lossy(&bytes[start..(start + 4).min(bytes.len())]);
                let c = rest.chars().next().unwrap_or('?');
                self.at += c.len_utf8();
                Err(format!("unexpected character `{}`", c.escape_default()))
            }
        }
    }

    /// Numbers up to what is none, appended.
    pub fn numbers(&mut self, out: &mut Vec<f32>) -> Result<(), String> {
        loop {
            self.place();
            match self.bytes.get(self.at) {
                Some(b'0'..=b'9' | b'+' | b'-' | b'.') => out.push(self.number()?),
                Some(b @ (0x80..=0x8f | 0xa4 | 0xa5)) => match self.encoded(*b)? {
                    Some(Token::Number(x)) => out.push(x),
                    _ => unreachable!("these bytes begin numbers"),
                },
                _ => return Ok(()),
            }
        }
    }

    /// The first byte of the next token, left in place; none at the end.
    #[inline]
    pub fn first(&mut self) -> Option<u8> {
        self.place();
        self.bytes.get(self.at).copied()
    }

    /// A request that is known, if one comes next; anything else is left in place.
    #[inline]
    pub(crate) fn request(&mut self) -> Option<Request> {
        match self.first()? {
            0o246 => {
                let code = *self.bytes.get(self.at + 1)?;
                let request = self.codes.requests.get(code as usize)?.as_ref()?.1?;
                self.at += 2;
                Some(request)
            }
            b if b.is_ascii_alphabetic() => {
                let rest = &self.bytes[self.at..];
                let n = rest.iter().position(|b| !b.is_ascii_alphanumeric()).unwrap_or(rest.len());
                // A name goes on with `_`, which no known one has.
                let word = std::str::from_utf8(&rest[..n]).ok().filter(|_| rest.get(n) != Some(&b'_'))?;
                let request = Request::named(word)?;
                self.at += n;
                Some(request)
            }
            _ => None,
        }
    }

    /// Read the numbers that follow each other, at most as many as `out` takes, or an encoded array of just its length; their count.
    #[inline]
    pub fn fill(&mut self, out: &mut [f32]) -> Result<usize, String> {
        for i in 0..out.len() {
            out[i] = match self.first() {
                Some(b'0'..=b'9' | b'+' | b'-' | b'.') => self.number()?,
                Some(0o244) => {
                    self.at += 1;
                    self.float()?
                }
                Some(b @ 0o200..=0o217) => {
                    self.at += 1;
                    self.fixed_point(b)?
                }
                Some(b @ 0o310..=0o313) if i == 0 => {
                    let start = self.at;
                    self.at += 1;
                    if self.whole((b & 3) as usize + 1)? != out.len() {
                        self.at = start;
                        return Ok(0);
                    }
                    let bytes = self.take(4 * out.len())?;
                    for (x, b) in out.iter_mut().zip(bytes.chunks_exact(4)) {
                        *x = f32::from_be_bytes(b.try_into().expect("four bytes"));
                    }
                    return Ok(out.len());
                }
                _ => return Ok(i),
            };
        }
        Ok(out.len())
    }

    /// A float's four bytes.
    #[inline]
    fn float(&mut self) -> Result<f32, String> {
        Ok(f32::from_be_bytes(self.take(4)?.try_into().expect("four bytes")))
    }

    /// A number of fixed point, after its first byte: two's complement, the highest byte first.
    #[inline]
    fn fixed_point(&mut self, first: u8) -> Result<f32, String> {
        /// The unit of the last byte, by the bytes after the point.
        const UNIT: [f64; 4] = [1.0, 1.0 / 256.0, 1.0 / 65_536.0, 1.0 / 16_777_216.0];
        let (fraction, width) = ((first >> 2 & 3) as usize, (first & 3) as usize + 1);
        let bytes = self.take(width)?;
        let sign = if bytes[0] & 0x80 != 0 { -1i64 } else { 0 };
        let x = bytes.iter().fold(sign, |x, b| x << 8 | *b as i64);
        Ok((x as f64 * UNIT[fraction]) as f32)
    }

    /// A number in ASCII.
    #[inline]
    fn number(&mut self) -> Result<f32, String> {
        let bytes = &self.bytes[self.at..];
        let digit = |i: usize| bytes.get(i).map(|b| b.wrapping_sub(b'0')).filter(|d| *d < 10);
        let negative = bytes[0] == b'-';
        let mut i = (negative || bytes[0] == b'+') as usize;
        let (mut mantissa, mut digits, mut scale) = (0u64, 0u32, 0i32);
        while let Some(d) = digit(i) {
            mantissa = mantissa.wrapping_mul(10).wrapping_add(d as u64);
            digits += 1;
            i += 1;
        }
        if bytes.get(i) == Some(&b'.') {
            i += 1;
            while let Some(d) = digit(i) {
                mantissa = mantissa.wrapping_mul(10).wrapping_add(d as u64);
                digits += 1;
                scale -= 1;
                i += 1;
            }
        }
        // Up to here powers of ten are exact in double precision, and so is what is read.
        const EXACT: [f64; 16] = [1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15];
        let ends = !bytes.get(i).is_some_and(|b| b.is_ascii_alphanumeric() || matches!(b, b'+' | b'-' | b'.'));
        if ends && (1..=15).contains(&digits) {
            self.at += i;
            let x = mantissa as f64 / EXACT[-scale as usize];
            return Ok(if negative { -x } else { x } as f32);
        }
        let end = bytes
            .iter()
            .position(|b| !(b.is_ascii_alphanumeric() || matches!(b, b'+' | b'-' | b'.')))
            .unwrap_or(bytes.len());
        let word = String::from_utf8_lossy(&bytes[..end]);
        let number = word.parse().map_err(|_| format!("`{word}` is not a number"))?;
        self.at += end;
        Ok(number)
    }

    fn quoted(&mut self) -> Result<String, String> {
        let bytes = self.bytes;
        let mut out = Vec::new();
        let mut i = self.at + 1;
        loop {
            match bytes.get(i) {
                None => return Err("a string is not closed before the file ends".into()),
                Some(b'"') => break,
                Some(b'\\') => {
                    i += 1;
                    match bytes.get(i) {
                        Some(b'n') => out.push(b'\n'),
                        Some(b't') => out.push(b'\t'),
                        Some(b'r') => out.push(b'\r'),
                        Some(b'b') => out.push(8),
                        Some(b'f') => out.push(12),
                        Some(b'\n') => {}
                        Some(b'0'..=b'7') => {
                            let digits: Vec<u8> =
                                bytes[i..].iter().take(3).copied().take_while(|b| (b'0'..=b'7').contains(b)).collect();
                            out.push(digits.iter().fold(0u32, |x, d| 8 * x + (d - b'0') as u32) as u8);
                            i += digits.len() - 1;
                        }
                        Some(c) => out.push(*c),
                        None => return Err("a string is not closed before the file ends".into()),
                    }
                    i += 1;
                }
                Some(b'\n') => {
                    self.line += 1;
                    self.line_start = i + 1;
                    out.push(b'\n');
                    i += 1;
                }
                Some(c) => {
                    out.push(*c);
                    i += 1;
                }
            }
        }
        self.at = i + 1;
        Ok(text_of(out))
    }

    /// The next `n` bytes.
    #[inline]
    fn take(&mut self, n: usize) -> Result<&'a [u8], String> {
        let found = self.bytes.get(self.at..self.at.saturating_add(n));
        self.at = self.at.saturating_add(n).min(self.bytes.len());
        found.ok_or_else(|| "the stream ends within an encoded value".into())
    }

    /// A whole number of `n` bytes, the highest first.
    #[inline]
    fn whole(&mut self, n: usize) -> Result<usize, String> {
        let x = self.take(n)?.iter().fold(0usize, |x, b| x << 8 | *b as usize);
        if x > LONGEST { Err(format!("an encoded value of {x} bytes")) } else { Ok(x) }
    }

    fn text(&mut self, n: usize) -> Result<String, String> {
        Ok(text_of(self.take(n)?.to_vec()))
    }

    /// An encoded string: the second part of a definition.
    fn definition(&mut self) -> Result<String, String> {
        self.place();
        match self.next()? {
            Some(Token::Text(text)) => Ok(text),
            _ => Err("expected a string in a definition of the bytestream".into()),
        }
    }

    /// What an encoding byte begins.
    fn encoded(&mut self, first: u8) -> Result<Option<Token<'a>>, String> {
        self.at += 1;
        Ok(Some(match first {
            0o200..=0o217 => Token::Number(self.fixed_point(first)?),
            0o220..=0o237 => Token::Text(self.text((first & 15) as usize)?),
            0o240..=0o243 => {
                let n = self.whole((first & 3) as usize + 1)?;
                Token::Text(self.text(n)?)
            }
            0o244 => Token::Number(self.float()?),
            0o245 => Token::Number(f64::from_be_bytes(self.take(8)?.try_into().expect("eight bytes")) as f32),
            0o246 => {
                let code = self.take(1)?[0];
                let name = self.codes.requests.get(code as usize).and_then(Option::as_ref);
                Token::Word(name.ok_or_else(|| format!("request code {code} is not defined"))?.0.clone())
            }
            0o310..=0o313 => {
                let n = self.whole((first & 3) as usize + 1)?;
                let bytes = self.take(4 * n)?;
                let float = |b: &[u8]| f32::from_be_bytes(b.try_into().expect("four bytes"));
                Token::Numbers(bytes.chunks_exact(4).map(float).collect())
            }
            0o314 => {
                let code = self.take(1)?[0];
                let name = self.definition()?;
                // Names that are known are not copied at every use.
                let known = Request::named(&name);
                let name = known.map_or(Cow::Owned(name), |request| Cow::Borrowed(request.name()));
                put(&mut self.codes.requests, code as usize, (name, known));
                return self.next();
            }
            0o315 | 0o316 => {
                let code = self.whole((first - 0o315) as usize + 1)?;
                let text = self.definition()?;
                put(&mut self.codes.strings, code, text);
                return self.next();
            }
            0o317 | 0o320 => {
                let code = self.whole((first - 0o317) as usize + 1)?;
                let text = self.codes.strings.get(code).and_then(Option::as_ref);
                Token::Text(text.ok_or_else(|| format!("string code {code} is not defined"))?.clone())
            }
            _ => return Err(format!("byte 0{first:o} has no meaning in RIB")),
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_read_as_the_standard_library_reads_them() {
        for text in
            ["0", "-1.5", "+.25", "3.", "1e-3", "-2.5E+4", "123456789.123456789", "0.1", "16777217", "1e39", ".5e1"]
        {
            let x = Lexer::new(text.as_bytes()).next().unwrap();
            assert_eq!(x, Some(Token::Number(text.parse().unwrap())), "{text}");
        }
        for text in ["1x", "--1", "1.2.3", "-", "."] {
            assert!(Lexer::new(text.as_bytes()).next().is_err(), "{text}");
        }
    }

    #[test]
    fn the_bytestream() {
        // Sphere as request 7, radius 1 as an integer, −0.5 in fixed point, a float, a short string, a float array.
        let mut bytes = vec![0o314, 7, 0o226];
        bytes.extend(b"Sphere");
        bytes.extend([0o246, 7, 0o200, 1, 0o204, 0x80, 0o244]);
        bytes.extend(2.5f32.to_be_bytes());
        bytes.extend([0o315, 3, 0o222]);
        bytes.extend(b"Kd");
        bytes.extend([0o317, 3, 0o310, 2]);
        bytes.extend(1f32.to_be_bytes());
        bytes.extend((-3f32).to_be_bytes());
        let mut lexer = Lexer::new(&bytes);
        let mut all = vec![];
        while let Some(token) = lexer.next().unwrap() {
            all.push(token);
        }
        let expected = vec![
            Token::Word("Sphere".into()),
            Token::Number(1.0),
            Token::Number(-0.5),
            Token::Number(2.5),
            Token::Text("Kd".into()),
            Token::Numbers(vec![1.0, -3.0]),
        ];
        assert_eq!(all, expected);
        assert!(Lexer::new(&[0o244, 1]).next().is_err());
        assert!(Lexer::new(&[0o246, 1]).next().is_err());
        assert!(Lexer::new(&[0o243, 255, 255, 255, 255]).next().is_err());
    }
}
