//! ASCII RIB as the binary bytestream (RISpec appendix C.2); [`crate::lexer`] reads it.

use crate::lexer::{Lexer, Token};
use crate::ri::Fail;
use std::collections::HashMap;

/// Encodes request after request; names and strings get codes as they come.
#[derive(Default)]
pub struct Encoder {
    requests: HashMap<String, u8>,
    strings: HashMap<String, u16>,
}

impl Encoder {
    /// The bytes of a line of ASCII RIB.
    pub fn encode(&mut self, line: &str) -> Result<Vec<u8>, Fail> {
        let mut out = Vec::new();
        let mut lexer = Lexer::new(line.as_bytes());
        while let Some(token) = lexer.next().map_err(Fail::new)? {
            match token {
                Token::Word(name) => self.request(&name, &mut out),
                Token::Text(text) => self.string(&text, &mut out),
                Token::Number(x) => number(x, &mut out),
                Token::Numbers(list) => array(&list, &mut out),
                Token::Close => out.push(b']'),
                Token::Comment(text) => out.extend(format!("#{text}\n").bytes()),
                Token::Open => {
                    // A list of numbers alone becomes an array.
                    let mut list = Vec::new();
                    lexer.numbers(&mut list).map_err(Fail::new)?;
                    match lexer.next().map_err(Fail::new)? {
                        // Of an empty list nobody knows what it holds.
                        Some(Token::Close) if list.is_empty() => out.extend(b"[]"),
                        Some(Token::Close) => array(&list, &mut out),
                        Some(Token::Text(text)) => {
                            out.push(b'[');
                            self.string(&text, &mut out);
                        }
                        _ => return Err(Fail::new("a list is not closed")),
                    }
                }
            }
        }
        Ok(out)
    }

    fn request(&mut self, name: &str, out: &mut Vec<u8>) {
        if let Some(code) = self.requests.get(name) {
            return out.extend([0o246, *code]);
        }
        let code = self.requests.len() as u8;
        self.requests.insert(name.into(), code);
        out.extend([0o314, code]);
        plain(name, out);
        out.extend([0o246, code]);
    }

    fn string(&mut self, text: &str, out: &mut Vec<u8>) {
        let code = match self.strings.get(text) {
            Some(code) => *code,
            None if self.strings.len() > u16::MAX as usize => return plain(text, out),
            None => {
                let code = self.strings.len() as u16;
                self.strings.insert(text.into(), code);
                out.push(0o316);
                out.extend(code.to_be_bytes());
                plain(text, out);
                code
            }
        };
        out.push(0o320);
        out.extend(code.to_be_bytes());
    }
}

fn plain(text: &str, out: &mut Vec<u8>) {
    match text.len() {
        n @ 0..16 => out.push(0o220 + n as u8),
        n => {
            out.push(0o243);
            out.extend((n as u32).to_be_bytes());
        }
    }
    out.extend(text.bytes());
}

fn number(x: f32, out: &mut Vec<u8>) {
    if x.fract() == 0.0 && x.abs() < 128.0 && !(x == 0.0 && x.is_sign_negative()) {
        out.extend([0o200, x as i8 as u8]);
    } else {
        out.push(0o244);
        out.extend(x.to_be_bytes());
    }
}

fn array(list: &[f32], out: &mut Vec<u8>) {
    match u8::try_from(list.len()) {
        Ok(n) => out.extend([0o310, n]),
        Err(_) => {
            out.push(0o313);
            out.extend((list.len() as u32).to_be_bytes());
        }
    }
    list.iter().for_each(|x| out.extend(x.to_be_bytes()));
}
