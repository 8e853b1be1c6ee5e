//! RIB text as tokens with their places (RISpec appendix C).

/// A token.
#[derive(Clone, Debug, PartialEq)]
pub enum Token<'a> {
    /// A request's name.
    Word(&'a str),
    /// A quoted string, unescaped.
    Text(String),
    /// A number.
    Number(f32),
    /// `[`
    Open,
    /// `]`
    Close,
    /// `#` to the line's end, without the `#`.
    Comment(&'a str),
}

/// Reads tokens from RIB text.
pub struct Lexer<'a> {
    text: &'a str,
    at: usize,
    line: usize,
    line_start: usize,
}

impl<'a> Lexer<'a> {
    /// Start at the beginning.
    pub fn new(text: &'a str) -> Lexer<'a> {
        Lexer { text, at: 0, line: 1, line_start: 0 }
    }

    /// Skip blanks; the place (line, column from 1) of what comes next.
    pub fn place(&mut self) -> (usize, usize) {
        let bytes = self.text.as_bytes();
        while let Some(b) = bytes.get(self.at) {
            match b {
                b'\n' => {
                    self.at += 1;
                    self.line += 1;
                    self.line_start = self.at;
                }
                b' ' | b'\t' | b'\r' => self.at += 1,
                _ => break,
            }
        }
        (self.line, self.at - self.line_start + 1)
    }

    /// The next token; `Ok(None)` at the end; `Err` is what is wrong.
    pub fn next(&mut self) -> Result<Option<Token<'a>>, String> {
        self.place();
        let bytes = self.text.as_bytes();
        let start = self.at;
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
                Ok(Some(Token::Comment(self.text[start + 1..self.at].trim_end())))
            }
            b'"' => self.quoted().map(|t| Some(Token::Text(t))),
            b'0'..=b'9' | b'+' | b'-' | b'.' => {
                self.at = until(&|b| !(b.is_ascii_alphanumeric() || matches!(b, b'+' | b'-' | b'.')));
                let word = &self.text[start..self.at];
                word.parse().map(|x| Some(Token::Number(x))).map_err(|_| format!("`{word}` is not a number"))
            }
            b if b.is_ascii_alphabetic() => {
                self.at = until(&|b| !(b.is_ascii_alphanumeric() || b == b'_'));
                Ok(Some(Token::Word(&self.text[start..self.at])))
            }
            _ => {
                let c = self.text[start..].chars().next().unwrap_or('?');
                self.at += c.len_utf8();
                Err(format!("unexpected character `{c}`"))
            }
        }
    }

    fn quoted(&mut self) -> Result<String, String> {
        let bytes = self.text.as_bytes();
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
                        Some(b'\n') => {}
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
        String::from_utf8(out).map_err(|_| "a string is not UTF-8".into())
    }
}
