//! The RIB reader: RIB, as text or bytestream → calls of an [`Ri`]. Every error has file, line, column and the offending line.

use crate::arguments::{Arguments, Known, Spot, describe};
use crate::dispatch::{self, Placed};
use crate::files::Files;
use crate::lexer::Token;
use crate::programs::{PATIENCE, Programs};
use crate::requests::Request;
use crate::ri::{Fail, Ri};
use crate::standing::Standing;
use crate::unread::Nobody;
use guard::memory::Bytes;
use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::fmt;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A place in a file; line and column count from 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// Path of the file.
    pub file: PathBuf,
    /// Line, from 1.
    pub line: usize,
    /// Column, from 1.
    pub column: usize,
}

/// An error in a RIB stream, with its place.
#[derive(Clone, Debug, PartialEq)]
pub struct RibError {
    /// Place of the error.
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

/// Maximum depth of archives that read each other.
const MAX_DEPTH: usize = 32;

/// Maximum depth of conditions within each other.
const MAX_BRANCHES: usize = 256;

/// A function that handles a directive, a comment `#scree …` of the stream. It gets the [`Ri`] and the directive's text after
/// `scree`, and answers with a warning, if there is one; an error stops the reading.
pub type Directive<'a> = dyn FnMut(&mut dyn Ri, &str) -> Result<Option<String>, Fail> + 'a;

/// Read the RIB stream `rib`, which came from `path`, and make its calls of `ri`. The stream is ASCII or binary, and may be
/// compressed by gzip. Archives are found through `files`; `on_directive` handles `#scree` comments.
pub fn read(
    path: &Path,
    rib: &[u8],
    files: &Files,
    ri: &mut dyn Ri,
    on_directive: &mut Directive<'_>,
) -> Result<(), RibError> {
    let mut known = Known::default();
    let unpacked = unpack(rib).map_err(|message| RibError {
        place: Place { file: path.into(), line: 1, column: 1 },
        text: String::new(),
        message,
    })?;
    // Editors begin text with the mark of UTF-8, which says nothing here.
    let bytes = unpacked.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&unpacked);
    let arguments = Arguments::new(path, bytes, &mut known);
    let mut shared = Shared { read: bytes.len() as u64, ..Default::default() };
    let (depth, branches, checks) = (0, vec![], false);
    let shared = &mut shared;
    let mut reader = Reader { path, bytes, line: 1, before: &[], arguments, shared, files, depth, branches, checks };
    if bytes.trim_ascii().is_empty() {
        return Err(*reader.error((1, 1), "is empty, expected RIB requests"));
    }
    reader.run(ri, on_directive).map_err(|e| *e)?;
    let (unread, codes) = (std::mem::take(&mut reader.shared.unread), reader.arguments.lexer.codes.clone());
    known.standing.end().into_iter().for_each(|warning| ri.warn(warning));
    for (name, own) in unread.into_values().flatten() {
        known.standing = Standing::default();
        let mut nobody = Nobody::default();
        let mut arguments = Arguments::new(&own.path, &own.bytes, &mut known);
        arguments.lexer.codes = codes.clone();
        arguments.lexer.begin_at(own.begins);
        let (path, bytes, line, before) = (own.path.as_path(), &own.bytes[..], own.begins.0, &own.before[..]);
        let (branches, checks) = (vec![], true);
        let shared = &mut Shared::default();
        let mut reader = Reader { path, bytes, line, before, arguments, shared, files, depth, branches, checks };
        let found = reader.run(&mut nobody, &mut |_, _| Ok(None)).err().map(|e| e.to_string());
        let says = nobody.warnings.into_iter().chain(found).chain(known.standing.end());
        says.for_each(|what| ri.warn(format!("{what}; the archive `{name}`, where that stands, is never read")));
    }
    Ok(())
}

/// A gzip file unpacked; anything else as it is.
fn unpack(rib: &[u8]) -> Result<Cow<'_, [u8]>, String> {
    /// Bytes that are unpacked at once.
    const PART: u64 = 1 << 20;
    if !rib.starts_with(&[0x1f, 0x8b]) {
        return Ok(Cow::Borrowed(rib));
    }
    let mut out = Vec::new();
    let mut packed = flate2::read::MultiGzDecoder::new(rib);
    loop {
        // A vector that grows is there twice for a moment.
        if guard::memory::room() < 2 * out.len() as u64 + PART {
            return Err(format!("the packed file has more than {}: {}", Bytes(out.len() as u64), guard::memory::Full));
        }
        match packed.by_ref().take(PART).read_to_end(&mut out) {
            Ok(0) => return Ok(Cow::Owned(out)),
            Ok(_) => {}
            Err(e) => return Err(format!("the packed file cannot be read: {e}")),
        }
    }
}

/// What a stream and the archives within it have in common, besides what their arguments know.
#[derive(Default)]
struct Shared {
    /// Archives that the stream itself holds.
    archives: HashMap<String, Arc<Inline>>,
    /// Those of them, by where they begin, that have not been read: their names, and they themselves.
    unread: BTreeMap<(PathBuf, Spot), Option<(String, Arc<Inline>)>>,
    /// Files of archives that were read.
    files: HashSet<PathBuf>,
    /// Bytes of the stream, and of files of archives that were read for the first time.
    read: u64,
    /// Bytes of archives that were read again.
    repeated: u64,
    /// Bytes of memory that archives have taken that were read again.
    added: u64,
    /// Bytes of memory that were taken when the outermost of those that are open was begun.
    since: Option<u64>,
    /// Programs that make geometry, kept running.
    programs: Programs,
    /// Times that they were asked.
    asked: u32,
}

/// An archive between `ArchiveBegin` and `ArchiveEnd`, and where it stands.
struct Inline {
    path: PathBuf,
    /// Line and column of its first byte, from 1.
    begins: Spot,
    /// What stands before it in that line.
    before: Vec<u8>,
    bytes: Vec<u8>,
}

/// Where a file begins: nothing stands before.
const FIRST: (Spot, &[u8]) = ((1, 1), &[]);

/// The most bytes of a line that an error shows.
const SHOWN: usize = 500;

/// An open `IfBegin`.
struct Branch {
    /// Its requests are made.
    taken: bool,
    /// A branch was taken, or none may be.
    done: bool,
}

/// The state of reading one stream.
struct Reader<'a> {
    path: &'a Path,
    bytes: &'a [u8],
    /// The line of the first byte, from 1, and what stands before that in it.
    line: usize,
    before: &'a [u8],
    arguments: Arguments<'a>,
    shared: &'a mut Shared,
    files: &'a Files,
    depth: usize,
    branches: Vec<Branch>,
    /// It is only found what is wrong: no other archive is read, no program is asked.
    checks: bool,
}

impl<'a> Reader<'a> {
    fn error(&self, (line, column): Spot, message: impl Into<String>) -> Box<RibError> {
        let n = line.saturating_sub(self.line);
        let text = self.bytes.split(|b| *b == b'\n').nth(n).unwrap_or(b"");
        let text = [if n == 0 { self.before } else { &[] }, &text[..text.len().min(SHOWN)]].concat();
        Box::new(RibError {
            place: Place { file: self.path.into(), line, column },
            text: String::from_utf8_lossy(&text[..text.len().min(SHOWN)]).trim_end_matches('\r').to_string(),
            message: message.into(),
        })
    }

    fn run(&mut self, ri: &mut dyn Ri, on_directive: &mut Directive<'_>) -> Result<(), Box<RibError>> {
        loop {
            let place = self.arguments.lexer.place();
            // Mostly a known request follows: found without making a token of it.
            if self.arguments.peeked().is_none()
                && self.branches.is_empty()
                && let Some(request) = self.arguments.lexer.request()
            {
                self.perform(Ok(request), ri, on_directive, place)?;
                continue;
            }
            let token = self.arguments.take().map_err(|m| self.error(place, m))?;
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
                        None => Ok(None),
                    };
                    if let Some(warning) = done.map_err(|f| self.error(place, f.message))? {
                        self.arguments.request = place;
                        self.arguments.warn(&comment, &warning);
                        self.arguments.warnings.drain(..).for_each(|w| ri.warn(w));
                    }
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
        place: Spot,
    ) -> Result<(), Box<RibError>> {
        guard::memory::check().map_err(|full| self.error(place, format!("the scene is too large: {full}")))?;
        self.arguments.request = place;
        let start = self.arguments.lexer.mark();
        let is_made = request.map_or(true, |request| self.arguments.note(request));
        let done = match request {
            _ if !is_made => self.arguments.pass_over().map_err(|f| self.error(place, f.message)),
            Ok(Request::ReadArchive) => self.read_archive(ri, on_directive, place),
            // Nested in one that is not read, it is not read either.
            Ok(Request::ArchiveBegin) if self.checks => self.archive_name(place).map(|_| ()),
            Ok(Request::ArchiveEnd) if self.checks => Ok(()),
            Ok(Request::ArchiveBegin) => self.inline_archive(place),
            Ok(Request::Procedural) => self.procedural(ri, on_directive, place),
            Ok(conditional) if conditional.is_condition() => {
                self.condition(conditional).map_err(|f| self.error(place, f.message))
            }
            known => {
                ri.stands_at(Some((self.path, place)));
                let done = match known {
                    Ok(request) => dispatch::dispatch(&mut self.arguments, ri, request),
                    Err(name) => dispatch::pass_over(&mut self.arguments, name),
                };
                ri.stands_at(None);
                done.map_err(|Placed { fail, in_arguments }| {
                    // A fault of the call itself is placed at its name.
                    let at = if in_arguments { self.arguments.fault(start) } else { place };
                    let error = self.error(at, fail.message);
                    match fail.at {
                        Some((file, (line, column))) => {
                            Box::new(RibError { place: Place { file, line, column }, text: String::new(), ..*error })
                        }
                        None => error,
                    }
                })
            }
        };
        if !self.arguments.warnings.is_empty() {
            self.arguments.warnings.drain(..).for_each(|w| ri.warn(w));
        }
        done
    }

    /// `IfBegin` and what belongs to it.
    fn condition(&mut self, request: Request) -> Result<(), Fail> {
        let outer = |branches: &[Branch]| branches.iter().all(|b| b.taken);
        match request {
            Request::IfBegin => {
                let text = self.arguments.text()?;
                if self.branches.len() >= MAX_BRANCHES {
                    return Err(Fail::new(format!("conditions are nested more than {MAX_BRANCHES} deep")));
                }
                let yes = outer(&self.branches) && self.arguments.known.conditions.holds(&text).map_err(Fail::new)?;
                self.branches.push(Branch { taken: yes, done: yes });
            }
            Request::ElseIf | Request::Else => {
                let text = if request == Request::ElseIf { self.arguments.text()? } else { "1".into() };
                let Some(mut branch) = self.branches.pop() else {
                    return Err(Fail::new(format!("`{}` without `IfBegin`", request.name())));
                };
                branch.taken = outer(&self.branches)
                    && !branch.done
                    && self.arguments.known.conditions.holds(&text).map_err(Fail::new)?;
                branch.done |= branch.taken;
                self.branches.push(branch);
            }
            _ => {
                self.branches.pop().ok_or(Fail::new("`IfEnd` without `IfBegin`"))?;
            }
        }
        Ok(())
    }

    fn read_archive(
        &mut self,
        ri: &mut dyn Ri,
        on_directive: &mut Directive<'_>,
        place: Spot,
    ) -> Result<(), Box<RibError>> {
        let name = self.archive_name(place)?;
        if self.checks {
            return Ok(());
        }
        self.archive(&name, ri, on_directive, place)
    }

    /// The name of an archive, and what may stand behind it.
    fn archive_name(&mut self, place: Spot) -> Result<String, Box<RibError>> {
        let name = self.arguments.text().map_err(|f| self.error(place, f.message))?;
        self.arguments.params().map_err(|f| self.error(place, f.message))?;
        Ok(name)
    }

    fn archive(
        &mut self,
        name: &str,
        ri: &mut dyn Ri,
        on_directive: &mut Directive<'_>,
        place: Spot,
    ) -> Result<(), Box<RibError>> {
        if self.depth >= MAX_DEPTH {
            return Err(self.error(
                place,
                format!("archives read each other more than {MAX_DEPTH} deep: does `{name}` read itself?"),
            ));
        }
        if let Some(own) = self.shared.archives.get(name).cloned() {
            self.shared.unread.insert((own.path.clone(), own.begins), None);
            self.repeat(own.bytes.len(), place)?;
            return self
                .counted(|reader| reader.nested(&own.path, (own.begins, &own.before), &own.bytes, ri, on_directive));
        }
        let (path, bytes) =
            self.files.read_bytes(name, &["scenes"]).map_err(|m| self.error(place, format!("archive {m}")))?;
        let bytes = unpack(&bytes).map_err(|m| self.error(place, format!("archive `{name}`: {m}")))?;
        if self.shared.files.insert(path.clone()) {
            self.shared.read += bytes.len() as u64;
            return self.nested(&path, FIRST, &bytes, ri, on_directive);
        }
        self.repeat(bytes.len(), place)?;
        self.counted(|reader| reader.nested(&path, FIRST, &bytes, ri, on_directive))
    }

    /// Count an archive that is read again: a few lines could read each other more often than there is time for. A long scene may read
    /// its archives more often than a short one.
    fn repeat(&mut self, n_bytes: usize, place: Spot) -> Result<(), Box<RibError>> {
        /// Bytes that a short archive counts for.
        const LEAST: u64 = 256;
        /// Bytes that may be read again for each byte of the scene and of its archives.
        const GAIN: u64 = 4096;
        /// Bytes that what is read again may take in memory for each of these.
        const GAIN_IN_MEMORY: u64 = 1 << 16;
        self.shared.repeated += (n_bytes as u64).max(LEAST);
        let (limit, own) = (guard::memory::limit(), self.shared.read.saturating_mul(GAIN));
        let most = (limit / 32 + own).min(limit / 4).min(8 << 30);
        let own = Bytes(self.shared.read);
        let too_much = |what: &str, most: u64| {
            let most = Bytes(most);
            format!(
                "archives are read again and again, {most} {what}, which is more than a scene of {own} may; --memory allows more"
            )
        };
        if self.shared.repeated > most {
            return Err(self.error(place, too_much("in all", most)));
        }
        // What they leave in memory is not in proportion to their text.
        let growth = self.shared.since.map_or(0, |before| guard::memory::used().saturating_sub(before));
        let most = (limit / 8).max(self.shared.read.saturating_mul(GAIN_IN_MEMORY));
        if self.shared.added.saturating_add(growth) > most {
            return Err(self.error(place, too_much("of memory", most)));
        }
        Ok(())
    }

    /// Count what an archive that is read again adds to the scene; `read` reads it.
    fn counted<R>(&mut self, read: impl FnOnce(&mut Self) -> R) -> R {
        let before = guard::memory::used();
        let is_outermost = self.shared.since.is_none();
        self.shared.since.get_or_insert(before);
        let done = read(self);
        if is_outermost {
            self.shared.since = None;
            self.shared.added += guard::memory::used().saturating_sub(before);
        }
        done
    }

    /// Read a stream within this one; `begins` is the place of its first byte, `before` what stands before that in its line.
    fn nested(
        &mut self,
        path: &Path,
        (begins, before): (Spot, &[u8]),
        bytes: &[u8],
        ri: &mut dyn Ri,
        on_directive: &mut Directive<'_>,
    ) -> Result<(), Box<RibError>> {
        let codes = self.arguments.lexer.codes.clone();
        let mut arguments = Arguments::new(path, bytes, self.arguments.known);
        arguments.lexer.codes = codes;
        arguments.lexer.begin_at(begins);
        let (shared, files, depth) = (&mut *self.shared, self.files, self.depth + 1);
        let (line, branches, checks) = (begins.0, vec![], self.checks);
        Reader { path, bytes, line, before, arguments, shared, files, depth, branches, checks }.run(ri, on_directive)
    }

    /// Keep what stands between `ArchiveBegin` and its `ArchiveEnd`.
    fn inline_archive(&mut self, place: Spot) -> Result<(), Box<RibError>> {
        let name = self.archive_name(place)?;
        let (begins, start) = self.arguments.next_start();
        let column = begins.1 - 1;
        let own = &self.bytes[start.saturating_sub(column)..start];
        let outer = if column > start { self.before } else { &[] };
        let mut before = [outer, &own[..own.len().min(SHOWN)]].concat();
        before.truncate(SHOWN);
        let mut depth = 1;
        loop {
            let (here, end) = self.arguments.next_start();
            let token = self.arguments.take().map_err(|m| self.error(here, m))?;
            match token {
                None => return Err(self.error(place, "`ArchiveBegin` without `ArchiveEnd`")),
                Some((Token::Word(word), _)) if word == "ArchiveBegin" => depth += 1,
                Some((Token::Word(word), _)) if word == "ArchiveEnd" => {
                    depth -= 1;
                    if depth == 0 {
                        let (path, bytes) = (self.path.into(), self.bytes[start..end].into());
                        let inline = Inline { path, begins, before, bytes };
                        let inline = Arc::new(inline);
                        let place = (inline.path.clone(), inline.begins);
                        self.shared.unread.entry(place).or_insert(Some((name.clone(), inline.clone())));
                        self.shared.archives.insert(name, inline);
                        return Ok(());
                    }
                }
                Some(_) => {}
            }
        }
    }

    /// Count that a program is asked: what it answers may ask it again, and that without end.
    fn count_asked(&mut self, program: &str, place: Spot) -> Result<(), Box<RibError>> {
        /// The most that programs are asked for a scene.
        const MAX_ASKED: u32 = 1 << 20;
        let name = program.escape_debug();
        if self.depth >= MAX_DEPTH {
            let message = format!(
                "programs and archives ask each other more than {MAX_DEPTH} deep: does `{name}` ask for itself?"
            );
            return Err(self.error(place, message));
        }
        self.shared.asked += 1;
        if self.shared.asked > MAX_ASKED {
            let message =
                format!("programs are asked more than {MAX_ASKED} times: does what `{name}` answers ask for more?");
            return Err(self.error(place, message));
        }
        Ok(())
    }

    /// `Procedural`: an archive, or what a program answers (RISpec 5.8).
    fn procedural(
        &mut self,
        ri: &mut dyn Ri,
        on_directive: &mut Directive<'_>,
        place: Spot,
    ) -> Result<(), Box<RibError>> {
        let read = |from: &mut Arguments<'_>| -> Result<(String, Vec<String>, [f32; 6]), Fail> {
            Ok((from.text()?, from.texts()?, from.numbers("a bound")?))
        };
        let (kind, args, bound) = read(&mut self.arguments).map_err(|f| self.error(place, f.message))?;
        if self.checks {
            return Ok(());
        }
        match (kind.as_str(), args.as_slice()) {
            ("DelayedReadArchive", [name]) => self.archive(name, ri, on_directive, place),
            ("RunProgram", [program, request]) => {
                let path = self.files.programs.path_of(program).map_err(|m| self.error(place, m))?;
                let Some(path) = path else {
                    ri.warn(format!("the program `{}` is not run in a check", program.escape_debug()));
                    return Ok(());
                };
                self.count_asked(program, place)?;
                let answer = self.shared.programs.ask(&path, program, (ri.detail(bound), request), self.files.program_time.unwrap_or(PATIENCE));
                let answer = answer.map_err(|m| self.error(place, m))?;
                self.nested(&path, FIRST, &answer, ri, on_directive)
            }
            ("DynamicLoad", _) => {
                self.arguments.warn("DynamicLoad", "`DynamicLoad` runs code of other programs and is passed over");
                self.arguments.warnings.drain(..).for_each(|w| ri.warn(w));
                Ok(())
            }
            _ => Err(self.error(
                place,
                format!("procedure `{kind}` with {} arguments: expected DelayedReadArchive [file], RunProgram [program request]", args.len()),
            )),
        }
    }
}
