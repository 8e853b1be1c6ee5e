//! Shader text, free of comments, as tokens with their places.

use super::diagnostic::{Error, error};

/// A token.
#[derive(Clone, Debug, PartialEq)]
pub enum Tok {
    /// A name or keyword.
    Name(String),
    /// A number.
    Number(f32),
    /// A string, unescaped.
    Text(String),
    /// An operator or a bracket.
    Op(&'static str),
    /// The end of the file.
    End,
}

/// Operators, longest first.
const OPS: &[&str] = &[
    "+=", "-=", "*=", "/=", "==", "!=", "<=", ">=", "&&", "||", "(", ")", "{", "}", "[", "]", ",", ";", ":", "?", "+",
    "-", "*", "/", "^", ".", "=", "<", ">", "!",
];

/// All tokens, each with the byte where it starts; the last is [`Tok::End`].
pub fn lex(source: &str) -> Result<Vec<(Tok, usize)>, Error> {
    let bytes = source.as_bytes();
    let mut tokens = Vec::new();
    let mut i = 0;
    while i < bytes.len() {
        let b = bytes[i];
        let rest = &source[i..];
        if b.is_ascii_whitespace() {
            i += 1;
        } else if b.is_ascii_alphabetic() || b == b'_' {
            let n = rest.find(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).unwrap_or(rest.len());
            tokens.push((Tok::Name(rest[..n].into()), i));
            i += n;
        } else if b.is_ascii_digit() || (b == b'.' && bytes.get(i + 1).is_some_and(u8::is_ascii_digit)) {
            let n = number_length(rest.as_bytes());
            // As in C, an `f` may stand behind a number.
            let marked = matches!(bytes.get(i + n), Some(b'f' | b'F'))
                && !bytes.get(i + n + 1).is_some_and(|c| c.is_ascii_alphanumeric() || *c == b'_');
            match rest[..n].parse() {
                Ok(x) => tokens.push((Tok::Number(x), i)),
                Err(_) => return error(i, format!("`{}` is not a number", &rest[..n])),
            }
            i += n + marked as usize;
        } else if b == b'"' {
            let (text, n) = quoted(rest).ok_or(Error::new(i, "a string is not closed before the file ends"))?;
            tokens.push((Tok::Text(text), i));
            i += n;
        } else if let Some(op) = OPS.iter().find(|op| rest.starts_with(**op)) {
            tokens.push((Tok::Op(op), i));
            i += op.len();
        } else {
            return error(i, format!("unexpected character `{}`", rest.chars().next().unwrap_or('?')));
        }
    }
    tokens.push((Tok::End, bytes.len()));
    Ok(tokens)
}

fn number_length(b: &[u8]) -> usize {
    let digits = |from: usize| b[from..].iter().take_while(|c| c.is_ascii_digit()).count();
    let mut n = digits(0);
    if b.get(n) == Some(&b'.') {
        n += 1 + digits(n + 1);
    }
    if matches!(b.get(n), Some(b'e' | b'E')) {
        let sign = matches!(b.get(n + 1), Some(b'+' | b'-')) as usize;
        let exponent = digits((n + 1 + sign).min(b.len()));
        if exponent > 0 {
            n += 1 + sign + exponent;
        }
    }
    n
}

/// A quoted string at the start of `rest`: its text and its length in bytes.
fn quoted(rest: &str) -> Option<(String, usize)> {
    let mut out = String::new();
    let mut chars = rest.char_indices().skip(1);
    while let Some((i, c)) = chars.next() {
        match c {
            '"' => return Some((out, i + 1)),
            '\\' => match chars.next()?.1 {
                'n' => out.push('\n'),
                't' => out.push('\t'),
                other => out.push(other),
            },
            c => out.push(c),
        }
    }
    None
}
