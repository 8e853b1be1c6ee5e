//! The preprocessor (RISpec 11.2: that of C): `#include`, `#define` with and without arguments, `#undef`, `#if` and its kin,
//! `#error`. Works on tokens, which keep the place where they stand in their own file; those of a macro get the place of its use.

use super::diagnostic::{Error, error};
use super::lex::{Tok, lex};
use super::source::Sources;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// A function that finds an included file: from the name in the `#include` line and the path of the file with that line to the path
/// and text of the included file, or a message for the diagnostic.
pub type Include<'a> = dyn Fn(&str, &Path) -> Result<(PathBuf, String), String> + 'a;

type Tokens = Vec<(Tok, usize)>;

/// The deepest that files include each other.
const MAX_INCLUDES: usize = 64;
/// The most files that are included in all.
const MAX_FILES: usize = 2000;
/// The deepest that `#if` and its kin may nest.
const MAX_BRANCHES: usize = 100;
/// The most tokens that a file may grow to.
const MAX_TOKENS: usize = 2_000_000;

struct Macro {
    params: Option<Vec<String>>,
    body: Tokens,
}

/// One `#if`: whether its lines are taken, whether a branch was taken already, and where it stands.
struct Branch {
    taken: bool,
    done: bool,
    at: usize,
}

struct Preprocessor<'a> {
    sources: &'a mut Sources,
    include: &'a Include<'a>,
    macros: HashMap<String, Macro>,
    pending: Tokens,
    out: Tokens,
    depth: usize,
    /// Files that were included.
    n_files: usize,
}

/// Tokens of a file and all that it includes, macros expanded; the last is [`Tok::End`].
pub fn preprocess(path: &Path, text: &str, sources: &mut Sources, include: &Include<'_>) -> Result<Tokens, Error> {
    let mut p =
        Preprocessor { sources, include, macros: HashMap::new(), pending: vec![], out: vec![], depth: 0, n_files: 0 };
    let end = p.file(path, text)?;
    p.flush()?;
    let mut out = p.out;
    out.push((Tok::End, end));
    Ok(out)
}

impl Preprocessor<'_> {
    /// Read a file; returns the byte after its last.
    fn file(&mut self, path: &Path, text: &str) -> Result<usize, Error> {
        let base = self.sources.add(path, text);
        let plain = without_comments(text)
            .map_err(|at| Error::new(base + at, "a comment is not closed before the file ends"))?;
        let mut branches: Vec<Branch> = vec![];
        let mut at = 0;
        for line in plain.split_inclusive('\n') {
            let (start, content) = (base + at, line.trim_start());
            at += line.len();
            let taken = branches.iter().all(|b| b.taken);
            if let Some(directive) = content.strip_prefix('#') {
                self.flush()?;
                let place = start + line.len() - content.len();
                self.directive(directive, place, &mut branches, taken)?;
            } else if taken {
                for (token, i) in lex(line).map_err(|e| Error { at: start + e.at, ..e })? {
                    if token != Tok::End {
                        self.pending.push((token, start + i));
                    }
                }
            }
        }
        match branches.last() {
            Some(open) => error(open.at, "`#if` without `#endif`"),
            None => Ok(base + text.len()),
        }
    }

    /// A directive, given without its `#`.
    fn directive(&mut self, line: &str, at: usize, branches: &mut Vec<Branch>, taken: bool) -> Result<(), Error> {
        let line = line.trim_start();
        let name: String = line.chars().take_while(|c| c.is_ascii_alphabetic()).collect();
        let rest = &line[name.len()..];
        let tokens = |from: &str| -> Result<Tokens, Error> {
            let mut all = lex(from).map_err(|e| Error { at, ..e })?;
            all.pop();
            all.iter_mut().for_each(|t| t.1 = at);
            Ok(all)
        };
        if name.starts_with("if") && branches.len() >= MAX_BRANCHES {
            return error(at, format!("conditions are nested more than {MAX_BRANCHES} deep"));
        }
        match name.as_str() {
            "ifdef" | "ifndef" => {
                let known = self.macros.contains_key(rest.trim());
                let yes = taken && known == (name == "ifdef");
                branches.push(Branch { taken: yes, done: yes, at });
            }
            "if" => {
                let yes = taken && self.condition(tokens(rest)?, at)?;
                branches.push(Branch { taken: yes, done: yes, at });
            }
            "elif" | "else" => {
                let Some(mut branch) = branches.pop() else { return error(at, format!("`#{name}` without `#if`")) };
                let outer = branches.iter().all(|b| b.taken);
                branch.taken = outer && !branch.done && (name == "else" || self.condition(tokens(rest)?, at)?);
                branch.done |= branch.taken;
                branches.push(branch);
            }
            "endif" => {
                if branches.pop().is_none() {
                    return error(at, "`#endif` without `#if`");
                }
            }
            _ if !taken => {}
            "define" => return self.define(rest, at),
            "undef" => {
                self.macros.remove(rest.trim());
            }
            "include" => return self.include(rest.trim(), at),
            "error" => return error(at, format!("#error{rest}").trim_end().to_string()),
            "pragma" | "line" | "" => {}
            other => {
                return error(
                    at,
                    format!(
                        "unknown directive `#{other}`, expected include, define, undef, if, ifdef, ifndef, elif, else, endif or error"
                    ),
                );
            }
        }
        Ok(())
    }

    fn define(&mut self, rest: &str, at: usize) -> Result<(), Error> {
        let rest = rest.trim();
        let length = rest.find(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).unwrap_or(rest.len());
        let (name, after) = rest.split_at(length);
        if name.is_empty() {
            return error(at, "`#define` needs a name");
        }
        let (params, body) = match after.strip_prefix('(').and_then(|a| a.split_once(')')) {
            Some((list, body)) => {
                let names = list.split(',').map(|p| p.trim().to_string()).filter(|p| !p.is_empty()).collect();
                (Some(names), body)
            }
            None if after.starts_with('(') => return error(at, "expected `)` after a macro's parameters"),
            None => (None, after),
        };
        let mut body = lex(body).map_err(|e| Error { at, ..e })?;
        body.pop();
        self.macros.insert(name.into(), Macro { params, body });
        Ok(())
    }

    fn include(&mut self, rest: &str, at: usize) -> Result<(), Error> {
        let name = rest
            .strip_prefix('"')
            .and_then(|r| r.strip_suffix('"'))
            .or(rest.strip_prefix('<').and_then(|r| r.strip_suffix('>')));
        let Some(name) = name else { return error(at, "expected `#include \"file\"`") };
        if self.depth >= MAX_INCLUDES {
            return error(
                at,
                format!("files include each other more than {MAX_INCLUDES} deep: does `{name}` include itself?"),
            );
        }
        self.n_files += 1;
        if self.n_files > MAX_FILES {
            return error(at, format!("more than {MAX_FILES} files are included"));
        }
        let (path, text) = (self.include)(name, self.sources.path(at)).map_err(|message| Error::new(at, message))?;
        self.depth += 1;
        self.file(&path, &text)?;
        self.depth -= 1;
        Ok(())
    }

    /// Expand what has been read since the last directive.
    fn flush(&mut self) -> Result<(), Error> {
        let tokens = std::mem::take(&mut self.pending);
        let mut out = std::mem::take(&mut self.out);
        let done = self.expand(&tokens, &mut Vec::new(), &mut out);
        self.out = out;
        done
    }

    /// Expand macros; those whose names are in `open` are being expanded and stay as they are.
    fn expand(&self, tokens: &[(Tok, usize)], open: &mut Vec<String>, out: &mut Tokens) -> Result<(), Error> {
        let mut i = 0;
        while i < tokens.len() {
            let (token, at) = &tokens[i];
            i += 1;
            if out.len() > MAX_TOKENS || open.len() > 200 {
                return error(*at, "macros expand without end");
            }
            let Tok::Name(name) = token else {
                out.push(tokens[i - 1].clone());
                continue;
            };
            let Some(found) = self.macros.get(name).filter(|_| !open.contains(name)) else {
                out.push(tokens[i - 1].clone());
                continue;
            };
            let mut body: Tokens = found.body.iter().map(|(t, _)| (t.clone(), *at)).collect();
            if let Some(params) = &found.params {
                if !matches!(tokens.get(i), Some((Tok::Op("("), _))) {
                    out.push(tokens[i - 1].clone());
                    continue;
                }
                let (args, after) = arguments(tokens, i, *at, name)?;
                i = after;
                if args.len() != params.len() && !(params.is_empty() && args.len() == 1 && args[0].is_empty()) {
                    let message = format!("macro `{name}` takes {} arguments, found {}", params.len(), args.len());
                    return error(*at, message);
                }
                let mut expanded = Vec::new();
                for arg in args {
                    let mut inner = Vec::new();
                    self.expand(&arg, open, &mut inner)?;
                    expanded.push(inner);
                }
                body = body
                    .into_iter()
                    .flat_map(|t| match &t.0 {
                        Tok::Name(p) => match params.iter().position(|q| q == p) {
                            Some(k) => expanded[k].clone(),
                            None => vec![t],
                        },
                        _ => vec![t],
                    })
                    .collect();
            }
            open.push(name.clone());
            self.expand(&body, open, out)?;
            open.pop();
        }
        Ok(())
    }

    /// The value of an `#if`.
    fn condition(&self, tokens: Tokens, at: usize) -> Result<bool, Error> {
        let mut known = Vec::new();
        let mut i = 0;
        while i < tokens.len() {
            if tokens[i].0 == Tok::Name("defined".into()) {
                let bracket = matches!(tokens.get(i + 1), Some((Tok::Op("("), _)));
                let Some((Tok::Name(name), _)) = tokens.get(i + 1 + bracket as usize) else {
                    return error(at, "expected `defined(NAME)`");
                };
                known.push((Tok::Number(self.macros.contains_key(name) as u8 as f32), at));
                i += 2 + 2 * bracket as usize;
            } else {
                known.push(tokens[i].clone());
                i += 1;
            }
        }
        let mut expanded = Vec::new();
        self.expand(&known, &mut Vec::new(), &mut expanded)?;
        let mut e = Condition { tokens: &expanded, i: 0, at };
        let value = e.level(0, 0)?;
        match expanded.get(e.i) {
            Some(_) => error(at, "unexpected text after the condition"),
            None => Ok(value != 0.0),
        }
    }
}

/// The arguments of a macro, from its `(` at `i`; and the place after its `)`.
fn arguments(tokens: &[(Tok, usize)], mut i: usize, at: usize, name: &str) -> Result<(Vec<Tokens>, usize), Error> {
    let (mut args, mut depth) = (vec![Vec::new()], 0);
    while let Some((token, _)) = tokens.get(i) {
        match token {
            Tok::Op("(") if depth == 0 => depth = 1,
            Tok::Op(")") if depth == 1 => return Ok((args, i + 1)),
            Tok::Op(",") if depth == 1 => args.push(Vec::new()),
            token => {
                depth += matches!(token, Tok::Op("(")) as i32 - matches!(token, Tok::Op(")")) as i32;
                args.last_mut().expect("there is one at least").push(tokens[i].clone());
            }
        }
        i += 1;
    }
    error(at, format!("the arguments of macro `{name}` are not closed"))
}

/// The expression of an `#if`; names that are no macros count as 0.
struct Condition<'a> {
    tokens: &'a [(Tok, usize)],
    i: usize,
    at: usize,
}

impl Condition<'_> {
    fn level(&mut self, level: usize, depth: usize) -> Result<f64, Error> {
        const LEVELS: &[&[&str]] =
            &[&["||"], &["&&"], &["==", "!="], &["<", "<=", ">", ">="], &["+", "-"], &["*", "/"]];
        let Some(ops) = LEVELS.get(level) else { return self.operand(depth) };
        let mut a = self.level(level + 1, depth)?;
        while let Some((Tok::Op(op), _)) = self.tokens.get(self.i) {
            if !ops.contains(op) {
                break;
            }
            self.i += 1;
            let b = self.level(level + 1, depth)?;
            let truth = |x: bool| x as u8 as f64;
            a = match *op {
                "||" => truth(a != 0.0 || b != 0.0),
                "&&" => truth(a != 0.0 && b != 0.0),
                "==" => truth(a == b),
                "!=" => truth(a != b),
                "<" => truth(a < b),
                "<=" => truth(a <= b),
                ">" => truth(a > b),
                ">=" => truth(a >= b),
                "+" => a + b,
                "-" => a - b,
                "*" => a * b,
                _ if b == 0.0 => return error(self.at, "a condition divides by 0"),
                _ => a / b,
            };
        }
        Ok(a)
    }

    fn operand(&mut self, depth: usize) -> Result<f64, Error> {
        if depth > 100 {
            return error(self.at, "the condition nests too deep");
        }
        self.i += 1;
        match self.tokens.get(self.i - 1).map(|t| &t.0) {
            Some(Tok::Number(x)) => Ok(*x as f64),
            Some(Tok::Name(_)) => Ok(0.0),
            Some(Tok::Op("!")) => Ok((self.operand(depth + 1)? == 0.0) as u8 as f64),
            Some(Tok::Op("-")) => Ok(-self.operand(depth + 1)?),
            Some(Tok::Op("(")) => {
                let value = self.level(0, depth + 1)?;
                self.i += 1;
                match self.tokens.get(self.i - 1) {
                    Some((Tok::Op(")"), _)) => Ok(value),
                    _ => error(self.at, "expected `)` in a condition"),
                }
            }
            _ => error(self.at, "expected a condition"),
        }
    }
}

/// The text with comments as blanks and continued lines joined, byte for byte; `Err` is where an open comment starts.
fn without_comments(text: &str) -> Result<String, usize> {
    let bytes = text.as_bytes();
    let mut out = bytes.to_vec();
    let blank = |out: &mut [u8], from: usize, to: usize| {
        // A comment does not end a directive's line, but the lines below keep their numbers by their places alone.
        out[from..to].iter_mut().for_each(|b| *b = b' ');
    };
    let mut i = 0;
    while i < bytes.len() {
        match bytes[i] {
            b'"' => {
                i += 1;
                while i < bytes.len() && bytes[i] != b'"' && bytes[i] != b'\n' {
                    i += 1 + (bytes[i] == b'\\') as usize;
                }
                i += 1;
            }
            b'/' if bytes.get(i + 1) == Some(&b'/') => {
                let end = bytes[i..].iter().position(|b| *b == b'\n').map_or(bytes.len(), |n| i + n);
                blank(&mut out, i, end);
                i = end;
            }
            b'/' if bytes.get(i + 1) == Some(&b'*') => {
                let end = bytes[i + 2..].windows(2).position(|w| w == b"*/").map(|n| i + n + 4).ok_or(i)?;
                blank(&mut out, i, end);
                i = end;
            }
            b'\\' if bytes.get(i + 1) == Some(&b'\n') => {
                blank(&mut out, i, i + 2);
                i += 2;
            }
            b'\\' if bytes.get(i + 1) == Some(&b'\r') && bytes.get(i + 2) == Some(&b'\n') => {
                blank(&mut out, i, i + 3);
                i += 3;
            }
            _ => i += 1,
        }
    }
    String::from_utf8(out).map_err(|e| e.utf8_error().valid_up_to())
}
