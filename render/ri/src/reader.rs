//! RIB text → calls of an [`Ri`]. Every error has file, line, column and the offending line.

use crate::conditions::Conditions;
use crate::files::Files;
use crate::lexer::{Lexer, Token};
use crate::programs::Programs;
use crate::requests::{self, Placed, Request};
use crate::{Declarations, Fail, Param, Params, Ri, RiResult, Type, Values};
use std::borrow::Cow;
use std::collections::{HashMap, HashSet};
use std::fmt;
use std::io::Read;
use std::path::{Path, PathBuf};

/// A place in a file; line and column count from 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// File.
    pub file: PathBuf,
    /// Line.
    pub line: usize,
    /// Column.
    pub column: usize,
}

/// What is wrong with a RIB stream, and where.
#[derive(Clone, Debug, PartialEq)]
pub struct RibError {
    /// Where.
    pub place: Place,
    /// The line as it stands in the file.
    pub text: String,
    /// What is wrong and what was expected.
    pub message: String,
}

impl fmt::Display for RibError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}:{}: {}", self.place.file.display(), self.place.line, self.place.column, self.message)
    }
}

impl std::error::Error for RibError {}

/// The deepest that archives may read each other.
const MAX_DEPTH: usize = 32;

/// What is done with a directive: a comment that starts with `scree`, given without that word. `Err` stops the reading.
pub type Directive<'a> = dyn FnMut(&mut dyn Ri, &str) -> RiResult + 'a;

/// Read RIB that came from `path` into `ri`: ASCII or binary, packed by gzip or not. Archives are looked for in `files`;
/// `on_directive` sees `#scree` comments.
pub fn read(
    path: &Path,
    rib: &[u8],
    files: &Files,
    ri: &mut dyn Ri,
    on_directive: &mut Directive<'_>,
) -> Result<(), RibError> {
    let mut shared = Shared::default();
    let unpacked = unpack(rib).map_err(|message| RibError {
        place: Place { file: path.into(), line: 1, column: 1 },
        text: String::new(),
        message,
    })?;
    let mut reader = Reader::new(path, &unpacked, files, &mut shared, 0);
    if unpacked.trim_ascii().is_empty() {
        return Err(*reader.error((1, 1), "is empty, expected RIB requests"));
    }
    reader.run(ri, on_directive).map_err(|e| *e)
}

/// What gzip has packed, unpacked; anything else as it is.
fn unpack(rib: &[u8]) -> Result<Cow<'_, [u8]>, String> {
    /// A packed file that grows beyond this is not a scene.
    const MOST: u64 = 16 << 30;
    if !rib.starts_with(&[0x1f, 0x8b]) {
        return Ok(Cow::Borrowed(rib));
    }
    let mut out = Vec::new();
    let n = flate2::read::MultiGzDecoder::new(rib).take(MOST).read_to_end(&mut out);
    match n {
        Ok(n) if (n as u64) < MOST => Ok(Cow::Owned(out)),
        Ok(_) => Err("the packed file is too large".into()),
        Err(e) => Err(format!("the packed file cannot be read: {e}")),
    }
}

/// What a stream and the archives within it have in common.
#[derive(Default)]
pub(crate) struct Shared {
    pub(crate) declarations: Declarations,
    /// Archives that the stream itself holds.
    archives: HashMap<String, Vec<u8>>,
    /// The frame, and options that conditions ask for.
    conditions: Conditions,
    /// Programs that make geometry, kept running.
    programs: Programs,
    /// What has been warned of.
    warned: HashSet<String>,
}

/// An open `IfBegin`.
struct Branch {
    /// Its requests are made.
    taken: bool,
    /// A branch was taken, or none may be.
    done: bool,
}

/// The state of reading one stream.
pub(crate) struct Reader<'a> {
    path: &'a Path,
    bytes: &'a [u8],
    lexer: Lexer<'a>,
    peeked: Option<(Token<'a>, (usize, usize))>,
    pub(crate) shared: &'a mut Shared,
    files: &'a Files,
    depth: usize,
    branches: Vec<Branch>,
    /// Where the request under way stands.
    request: (usize, usize),
    warnings: Vec<String>,
}

impl<'a> Reader<'a> {
    fn new(path: &'a Path, bytes: &'a [u8], files: &'a Files, shared: &'a mut Shared, depth: usize) -> Reader<'a> {
        Reader {
            path,
            bytes,
            lexer: Lexer::new(bytes),
            peeked: None,
            shared,
            files,
            depth,
            branches: vec![],
            request: (1, 1),
            warnings: vec![],
        }
    }

    fn error(&self, (line, column): (usize, usize), message: impl Into<String>) -> Box<RibError> {
        let text = self.bytes.split(|b| *b == b'\n').nth(line - 1).unwrap_or(b"");
        Box::new(RibError {
            place: Place { file: self.path.into(), line, column },
            text: String::from_utf8_lossy(&text[..text.len().min(500)]).trim_end_matches('\r').to_string(),
            message: message.into(),
        })
    }

    /// Warn of something, once for each `key`, with the request's place.
    pub(crate) fn warn(&mut self, key: &str, message: &str) {
        if self.shared.warned.insert(key.into()) {
            let (line, column) = self.request;
            self.warnings.push(format!("{}:{line}:{column}: {message}", self.path.display()));
        }
    }

    fn run(&mut self, ri: &mut dyn Ri, on_directive: &mut Directive<'_>) -> Result<(), Box<RibError>> {
        loop {
            let place = self.lexer.place();
            // Mostly a known request follows: found without making a token of it.
            if self.peeked.is_none()
                && self.branches.is_empty()
                && let Some(request) = self.lexer.request()
            {
                self.perform(Ok(request), ri, on_directive, place)?;
                continue;
            }
            let token = self.take().map_err(|m| self.error(place, m))?;
            let place = token.as_ref().map_or(place, |(_, p)| *p);
            let taken = self.branches.iter().all(|b| b.taken);
            match token {
                None if self.branches.is_empty() => return Ok(()),
                None => return Err(self.error(place, "`IfBegin` without `IfEnd`")),
                // Where a branch is not taken, conditions within it are still counted.
                Some((Token::Word(name), _)) if !taken => {
                    if let Some(request) = Request::named(&name).filter(|r| r.is_condition()) {
                        self.condition(request).map_err(|f| self.error(place, f.message))?;
                    }
                }
                Some(_) if !taken => {}
                Some((Token::Comment(comment), _)) => {
                    let done = match comment.trim_start().strip_prefix("scree ") {
                        Some(directive) => on_directive(ri, directive.trim()),
                        None => Ok(()),
                    };
                    done.map_err(|f| self.error(place, f.message))?;
                }
                Some((Token::Word(name), _)) => {
                    self.perform(Request::named(&name).ok_or(&*name), ri, on_directive, place)?;
                }
                Some((other, _)) => {
                    return Err(self.error(place, format!("expected a request, found {}", describe(&other))));
                }
            }
        }
    }

    /// A request whose name, known or not, was read at `place`.
    fn perform(
        &mut self,
        request: Result<Request, &str>,
        ri: &mut dyn Ri,
        on_directive: &mut Directive<'_>,
        place: (usize, usize),
    ) -> Result<(), Box<RibError>> {
        self.request = place;
        let start = self.lexer.mark();
        let done = match request {
            Ok(Request::ReadArchive) => self.read_archive(ri, on_directive, place),
            Ok(Request::ArchiveBegin) => self.inline_archive(place),
            Ok(Request::Procedural) => self.procedural(ri, on_directive, place),
            Ok(conditional) if conditional.is_condition() => {
                self.condition(conditional).map_err(|f| self.error(place, f.message))
            }
            known => {
                let done = match known {
                    Ok(request) => requests::dispatch(self, ri, request),
                    Err(name) => requests::pass_over(self, name),
                };
                done.map_err(|Placed { fail, in_arguments }| {
                    // A fault in the arguments is placed where reading stopped, one of the call itself at its name.
                    let at = if in_arguments {
                        self.peeked.as_ref().map_or_else(|| self.lexer.place_after(start), |(_, p)| *p)
                    } else {
                        place
                    };
                    self.error(at, fail.message)
                })
            }
        };
        if !self.warnings.is_empty() {
            self.warnings.drain(..).for_each(|w| ri.warn(w));
        }
        done
    }

    /// `IfBegin` and what belongs to it.
    fn condition(&mut self, request: Request) -> Result<(), Fail> {
        let outer = |branches: &[Branch]| branches.iter().all(|b| b.taken);
        match request {
            Request::IfBegin => {
                let text = self.string()?;
                let yes = outer(&self.branches) && self.shared.conditions.holds(&text).map_err(Fail::new)?;
                self.branches.push(Branch { taken: yes, done: yes });
            }
            Request::ElseIf | Request::Else => {
                let text = if request == Request::ElseIf { self.string()? } else { "1".into() };
                let Some(mut branch) = self.branches.pop() else {
                    return Err(Fail::new(format!("`{request:?}` without `IfBegin`")));
                };
                branch.taken =
                    outer(&self.branches) && !branch.done && self.shared.conditions.holds(&text).map_err(Fail::new)?;
                branch.done |= branch.taken;
                self.branches.push(branch);
            }
            _ => {
                self.branches.pop().ok_or(Fail::new("`IfEnd` without `IfBegin`"))?;
            }
        }
        Ok(())
    }

    /// Remember a value that conditions may ask for.
    pub(crate) fn remember(&mut self, name: &str, value: Values) {
        self.shared.conditions.set(name, value);
    }

    fn read_archive(
        &mut self,
        ri: &mut dyn Ri,
        on_directive: &mut Directive<'_>,
        place: (usize, usize),
    ) -> Result<(), Box<RibError>> {
        let name = self.string().map_err(|f| self.error(place, f.message))?;
        self.params().map_err(|f| self.error(place, f.message))?;
        self.archive(&name, ri, on_directive, place)
    }

    fn archive(
        &mut self,
        name: &str,
        ri: &mut dyn Ri,
        on_directive: &mut Directive<'_>,
        place: (usize, usize),
    ) -> Result<(), Box<RibError>> {
        if self.depth >= MAX_DEPTH {
            return Err(self.error(
                place,
                format!("archives read each other more than {MAX_DEPTH} deep: does `{name}` read itself?"),
            ));
        }
        if let Some(own) = self.shared.archives.get(name).cloned() {
            return self.nested(self.path, &own, ri, on_directive);
        }
        let (path, bytes) =
            self.files.read_bytes(name, &["scenes"]).map_err(|m| self.error(place, format!("archive {m}")))?;
        let bytes = unpack(&bytes).map_err(|m| self.error(place, format!("archive `{name}`: {m}")))?;
        self.nested(&path, &bytes, ri, on_directive)
    }

    fn nested(
        &mut self,
        path: &Path,
        bytes: &[u8],
        ri: &mut dyn Ri,
        on_directive: &mut Directive<'_>,
    ) -> Result<(), Box<RibError>> {
        let codes = self.lexer.codes.clone();
        let mut inner = Reader::new(path, bytes, self.files, self.shared, self.depth + 1);
        inner.lexer.codes = codes;
        inner.run(ri, on_directive)
    }

    /// Keep what stands between `ArchiveBegin` and its `ArchiveEnd`.
    fn inline_archive(&mut self, place: (usize, usize)) -> Result<(), Box<RibError>> {
        let name = self.string().map_err(|f| self.error(place, f.message))?;
        self.params().map_err(|f| self.error(place, f.message))?;
        let start = self.peeked_start();
        let mut depth = 1;
        loop {
            let here = self.lexer.place();
            let before = self.peeked_start();
            let token = self.take().map_err(|m| self.error(here, m))?;
            match token {
                None => return Err(self.error(place, "`ArchiveBegin` without `ArchiveEnd`")),
                Some((Token::Word(word), _)) if word == "ArchiveBegin" => depth += 1,
                Some((Token::Word(word), _)) if word == "ArchiveEnd" => {
                    depth -= 1;
                    if depth == 0 {
                        self.shared.archives.insert(name, self.bytes[start..before].to_vec());
                        return Ok(());
                    }
                }
                Some(_) => {}
            }
        }
    }

    /// The byte where the next token starts.
    fn peeked_start(&mut self) -> usize {
        match &self.peeked {
            // A peeked token is a word here, and ends where the lexer is.
            Some((Token::Word(word), _)) => self.lexer.position() - word.len(),
            _ => {
                self.lexer.place();
                self.lexer.position()
            }
        }
    }

    /// `Procedural`: an archive, or what a program answers (RISpec 5.8).
    fn procedural(
        &mut self,
        ri: &mut dyn Ri,
        on_directive: &mut Directive<'_>,
        place: (usize, usize),
    ) -> Result<(), Box<RibError>> {
        let arguments = |r: &mut Self| -> Result<(String, Vec<String>, [f32; 6]), Fail> {
            Ok((r.string()?, r.strings()?, r.numbers_of("a bound")?))
        };
        let (kind, args, bound) = arguments(self).map_err(|f| self.error(place, f.message))?;
        match (kind.as_str(), args.as_slice()) {
            ("DelayedReadArchive", [name]) => self.archive(name, ri, on_directive, place),
            ("RunProgram", [program, request]) => {
                let answer = self.shared.programs.ask(program, ri.detail(bound), request);
                let answer = answer.map_err(|m| self.error(place, m))?;
                let path = PathBuf::from(program.split_whitespace().next().unwrap_or("program"));
                self.nested(&path, &answer, ri, on_directive)
            }
            ("DynamicLoad", _) => {
                self.warn("DynamicLoad", "`DynamicLoad` runs code of other programs and is passed over");
                self.warnings.drain(..).for_each(|w| ri.warn(w));
                Ok(())
            }
            _ => Err(self.error(
                place,
                format!("procedure `{kind}` with {} arguments: expected DelayedReadArchive [file], RunProgram [program request]", args.len()),
            )),
        }
    }

    fn take(&mut self) -> Result<Option<(Token<'a>, (usize, usize))>, String> {
        if let Some(token) = self.peeked.take() {
            return Ok(Some(token));
        }
        let place = self.lexer.place();
        Ok(self.lexer.next()?.map(|t| (t, place)))
    }

    /// The next token, left in place. Comments within a request are passed over.
    fn peek(&mut self) -> Result<Option<&Token<'a>>, Fail> {
        while self.peeked.is_none() {
            match self.take().map_err(Fail::new)? {
                None => return Ok(None),
                Some((Token::Comment(c), _)) if !c.trim_start().starts_with("scree ") => {}
                some => self.peeked = some,
            }
        }
        Ok(self.peeked.as_ref().map(|(t, _)| t))
    }

    fn expected<T>(&mut self, what: &str) -> Result<T, Fail> {
        let found = self.peek()?.map_or("the end of the file".into(), describe);
        Err(Fail::new(format!("expected {what}, found {found}")))
    }

    /// At a glance, whether a request follows, in letters or by its code; where it takes a closer look, not.
    #[inline]
    fn request_follows(&mut self) -> bool {
        self.peeked.is_none() && matches!(self.lexer.first(), Some(b'A'..=b'Z' | 0o246))
    }

    /// An error if arguments are left over.
    #[inline(always)]
    pub(crate) fn end_of(&mut self, request: Request) -> Result<(), Fail> {
        if self.request_follows() || !self.has_argument()? {
            return Ok(());
        }
        Err(Fail::new(format!("`{request:?}` has more arguments than it takes")))
    }

    /// Whether an argument follows rather than the next request.
    pub(crate) fn has_argument(&mut self) -> Result<bool, Fail> {
        Ok(!matches!(self.peek()?, None | Some(Token::Word(_) | Token::Comment(_))))
    }

    /// Whether a bracketed list follows.
    pub(crate) fn has_list(&mut self) -> Result<bool, Fail> {
        Ok(matches!(self.peek()?, Some(Token::Open | Token::Numbers(_))))
    }

    /// Whether a string follows.
    pub(crate) fn has_string(&mut self) -> Result<bool, Fail> {
        Ok(matches!(self.peek()?, Some(Token::Text(_))))
    }

    /// A number; a bracketed single one counts.
    pub(crate) fn number(&mut self) -> Result<f32, Fail> {
        match self.peek()? {
            Some(Token::Number(x)) => {
                let x = *x;
                self.peeked = None;
                Ok(x)
            }
            Some(Token::Open | Token::Numbers(_)) => Ok(self.numbers_of::<1>("a number")?[0]),
            _ => self.expected("a number"),
        }
    }

    /// A whole number.
    pub(crate) fn integer(&mut self) -> Result<i32, Fail> {
        let x = self.number()?;
        if x.fract() == 0.0 && x.abs() < 2e9 {
            Ok(x as i32)
        } else {
            Err(Fail::new(format!("expected a whole number, found {x}")))
        }
    }

    /// Exactly `N` numbers, with or without brackets.
    #[inline(always)]
    pub(crate) fn numbers_of<const N: usize>(&mut self, what: &str) -> Result<[f32; N], Fail> {
        let mut out = [0.0; N];
        let n = if self.peeked.is_none() { self.lexer.fill(&mut out).map_err(Fail::new)? } else { 0 };
        if n == N { Ok(out) } else { self.more_numbers(out, n, what) }
    }

    /// The numbers after the first `n`, token by token.
    #[cold]
    fn more_numbers<const N: usize>(&mut self, mut out: [f32; N], n: usize, what: &str) -> Result<[f32; N], Fail> {
        if n == 0 && matches!(self.peek()?, Some(Token::Open | Token::Numbers(_))) {
            let list = self.numbers()?;
            let n = list.len();
            return list.try_into().map_err(|_| Fail::new(format!("expected {what} ({N} numbers), found {n}")));
        }
        for x in &mut out[n..] {
            *x = match self.peek()? {
                Some(Token::Number(x)) => *x,
                _ => return self.expected(what),
            };
            self.peeked = None;
        }
        Ok(out)
    }

    /// A bracketed list of numbers.
    pub(crate) fn numbers(&mut self) -> Result<Vec<f32>, Fail> {
        match self.peek()? {
            Some(Token::Open) => self.peeked = None,
            Some(Token::Numbers(_)) => match self.peeked.take() {
                Some((Token::Numbers(list), _)) => return Ok(list),
                _ => unreachable!("an array was seen"),
            },
            _ => return self.expected("`[`"),
        }
        let mut out = Vec::new();
        loop {
            self.lexer.numbers(&mut out).map_err(Fail::new)?;
            match self.peek()? {
                Some(Token::Close) => {
                    self.peeked = None;
                    return Ok(out);
                }
                // A comment between the numbers was passed over.
                Some(Token::Number(x)) => out.push(*x),
                _ => return self.expected("a number or `]`"),
            }
            self.peeked = None;
        }
    }

    /// A bracketed list of whole numbers.
    pub(crate) fn integers(&mut self) -> Result<Vec<i32>, Fail> {
        Ok(self.numbers()?.into_iter().map(|x| x as i32).collect())
    }

    /// A string; a bracketed single one counts.
    pub(crate) fn string(&mut self) -> Result<String, Fail> {
        match self.peek()? {
            Some(Token::Text(_)) => match self.peeked.take() {
                Some((Token::Text(text), _)) => Ok(text),
                _ => unreachable!("a string was seen"),
            },
            Some(Token::Open) => {
                self.peeked = None;
                let text = self.string()?;
                match self.peek()? {
                    Some(Token::Close) => self.peeked = None,
                    _ => return self.expected("`]`"),
                }
                Ok(text)
            }
            _ => self.expected("a string"),
        }
    }

    /// A light's or an object's handle: a number or a string.
    pub(crate) fn handle(&mut self) -> Result<String, Fail> {
        match self.peek()? {
            Some(Token::Number(_)) => Ok(self.integer()?.to_string()),
            _ => self.string(),
        }
    }

    /// The parameter list that ends a request.
    #[inline(always)]
    pub(crate) fn params(&mut self) -> Result<Params, Fail> {
        if self.request_follows() { Ok(Vec::new()) } else { self.parameters() }
    }

    fn parameters(&mut self) -> Result<Params, Fail> {
        let mut params: Params = Vec::new();
        while matches!(self.peek()?, Some(Token::Text(_))) {
            let token = self.string()?;
            let Some(decl) = self.shared.declarations.resolve(&token).map_err(Fail::new)? else {
                // What is not declared is read over, as the specification asks.
                let message = self.undeclared(&token);
                self.warn(&format!("parameter {token}"), &message);
                self.pass_value()?;
                continue;
            };
            let values = if decl.ty == Type::String {
                Values::Strings(self.strings()?)
            } else {
                Values::Floats(self.one_or_more()?)
            };
            let n = match &values {
                Values::Floats(v) => v.len(),
                Values::Strings(v) => v.len(),
            };
            if n == 0 || n % decl.width() != 0 {
                let message = format!("`{}` has {n} values, expected a multiple of {}", decl.inline(), decl.width());
                return Err(Fail::new(message));
            }
            params.push(Param { decl, values });
        }
        Ok(params)
    }

    fn undeclared(&self, name: &str) -> String {
        let near =
            self.shared.declarations.names().min_by_key(|n| (strsim::damerau_levenshtein(n, name), n.to_string()));
        let near = near
            .filter(|n| strsim::damerau_levenshtein(n, name) <= 2)
            .map_or(String::new(), |n| format!("; did you mean `{n}`?"));
        format!("parameter `{name}` is not declared: write \"uniform float {name}\" or `Declare` it before{near}")
    }

    /// Read over the value of a parameter.
    fn pass_value(&mut self) -> Result<(), Fail> {
        match self.peek()? {
            Some(Token::Text(_) | Token::Number(_) | Token::Numbers(_)) => self.peeked = None,
            Some(Token::Open) => {
                while !matches!(self.peek()?, Some(Token::Close)) {
                    if !matches!(self.peek()?, Some(Token::Text(_) | Token::Number(_) | Token::Open)) {
                        return self.expected("a value or `]`");
                    }
                    self.peeked = None;
                }
                self.peeked = None;
            }
            _ => return self.expected("a value"),
        }
        Ok(())
    }

    /// Read over the arguments of a request that is not known.
    pub(crate) fn pass_arguments(&mut self) -> Result<(), Fail> {
        while self.has_argument()? {
            self.peeked = None;
        }
        Ok(())
    }

    fn one_or_more(&mut self) -> Result<Vec<f32>, Fail> {
        match self.peek()? {
            Some(Token::Number(_)) => Ok(vec![self.number()?]),
            _ => self.numbers(),
        }
    }

    pub(crate) fn strings(&mut self) -> Result<Vec<String>, Fail> {
        if !matches!(self.peek()?, Some(Token::Open)) {
            return Ok(vec![self.string()?]);
        }
        self.peeked = None;
        let mut out = Vec::new();
        loop {
            match self.peek()? {
                Some(Token::Text(_)) => out.push(self.string()?),
                Some(Token::Close) => {
                    self.peeked = None;
                    return Ok(out);
                }
                _ => return self.expected("a string or `]`"),
            }
        }
    }
}

fn describe(token: &Token<'_>) -> String {
    match token {
        Token::Word(w) => format!("`{w}`"),
        Token::Text(t) => format!("the string \"{t}\""),
        Token::Number(x) => format!("the number {x}"),
        Token::Numbers(_) => "an array of numbers".into(),
        Token::Open => "`[`".into(),
        Token::Close => "`]`".into(),
        Token::Comment(c) => format!("the directive `#{c}`"),
    }
}
