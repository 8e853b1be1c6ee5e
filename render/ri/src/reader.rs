//! RIB text → calls of an [`Ri`]. Every error has file, line, column and the offending line.

use crate::files::Files;
use crate::lexer::{Lexer, Token};
use crate::{Declarations, Fail, Param, Params, Ri, RiResult, Type, Values};
use std::fmt;
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

/// Read RIB text that came from `path` into `ri`; archives are looked for in `files`; `on_directive` sees `#scree` comments.
pub fn read(
    path: &Path,
    text: &str,
    files: &Files,
    ri: &mut dyn Ri,
    on_directive: &mut Directive<'_>,
) -> Result<(), RibError> {
    let mut declarations = Declarations::default();
    let mut reader = Reader::new(path, text, files, &mut declarations, 0);
    if text.trim().is_empty() {
        return Err(reader.error((1, 1), "is empty, expected RIB requests"));
    }
    reader.run(ri, on_directive)
}

/// The state of reading one stream.
pub(crate) struct Reader<'a> {
    path: &'a Path,
    text: &'a str,
    lexer: Lexer<'a>,
    peeked: Option<(Token<'a>, (usize, usize))>,
    pub(crate) declarations: &'a mut Declarations,
    files: &'a Files,
    depth: usize,
}

impl<'a> Reader<'a> {
    fn new(
        path: &'a Path,
        text: &'a str,
        files: &'a Files,
        declarations: &'a mut Declarations,
        depth: usize,
    ) -> Reader<'a> {
        Reader { path, text, lexer: Lexer::new(text), peeked: None, declarations, files, depth }
    }

    fn error(&self, (line, column): (usize, usize), message: impl Into<String>) -> RibError {
        let text = self.text.lines().nth(line - 1).unwrap_or("").to_string();
        RibError { place: Place { file: self.path.into(), line, column }, text, message: message.into() }
    }

    fn run(&mut self, ri: &mut dyn Ri, on_directive: &mut Directive<'_>) -> Result<(), RibError> {
        loop {
            let place = self.lexer.place();
            let token = self.take().map_err(|m| self.error(place, m))?;
            let place = token.as_ref().map_or(place, |(_, p)| *p);
            match token {
                None => return Ok(()),
                Some((Token::Comment(comment), _)) => {
                    let done = match comment.trim_start().strip_prefix("scree ") {
                        Some(directive) => on_directive(ri, directive.trim()),
                        None => Ok(()),
                    };
                    done.map_err(|f| self.error(place, f.message))?;
                }
                Some((Token::Word("ReadArchive"), _)) => self.read_archive(ri, on_directive, place)?,
                Some((Token::Word(name), _)) => {
                    let start = self.lexer.place();
                    if let Err(fail) = crate::requests::dispatch(self, ri, name) {
                        // A fault in the arguments is placed where reading stopped, one of the call itself at its name.
                        let at = if fail.1 { self.peeked.as_ref().map_or(start, |(_, p)| *p) } else { place };
                        return Err(self.error(at, fail.0.message));
                    }
                }
                Some((other, _)) => {
                    return Err(self.error(place, format!("expected a request, found {}", describe(&other))));
                }
            }
        }
    }

    fn read_archive(
        &mut self,
        ri: &mut dyn Ri,
        on_directive: &mut Directive<'_>,
        place: (usize, usize),
    ) -> Result<(), RibError> {
        let name = self.string().map_err(|f| self.error(place, f.message))?;
        if self.depth >= MAX_DEPTH {
            return Err(self.error(
                place,
                format!("archives read each other more than {MAX_DEPTH} deep: does `{name}` read itself?"),
            ));
        }
        let (path, text) =
            self.files.read(&name, &["scenes"]).map_err(|m| self.error(place, format!("archive {m}")))?;
        let mut inner = Reader::new(&path, &text, self.files, self.declarations, self.depth + 1);
        inner.run(ri, on_directive)
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

    /// Whether an argument follows rather than the next request.
    pub(crate) fn has_argument(&mut self) -> Result<bool, Fail> {
        Ok(!matches!(self.peek()?, None | Some(Token::Word(_) | Token::Comment(_))))
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
            Some(Token::Open) => Ok(self.numbers_of::<1>("a number")?[0]),
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
    pub(crate) fn numbers_of<const N: usize>(&mut self, what: &str) -> Result<[f32; N], Fail> {
        if matches!(self.peek()?, Some(Token::Open)) {
            let list = self.numbers()?;
            let n = list.len();
            return list.try_into().map_err(|_| Fail::new(format!("expected {what} ({N} numbers), found {n}")));
        }
        let mut out = [0.0; N];
        for x in &mut out {
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
        if !matches!(self.peek()?, Some(Token::Open)) {
            return self.expected("`[`");
        }
        self.peeked = None;
        let mut out = Vec::new();
        loop {
            match self.peek()? {
                Some(Token::Number(x)) => out.push(*x),
                Some(Token::Close) => {
                    self.peeked = None;
                    return Ok(out);
                }
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
    pub(crate) fn params(&mut self) -> Result<Params, Fail> {
        let mut params: Params = Vec::new();
        while matches!(self.peek()?, Some(Token::Text(_))) {
            let token = self.string()?;
            let decl = match self.declarations.resolve(&token).map_err(Fail::new)? {
                Some(decl) => decl,
                None => return Err(Fail::new(self.undeclared(&token))),
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
        let near = self.declarations.names().min_by_key(|n| (strsim::damerau_levenshtein(n, name), n.to_string()));
        let near = near
            .filter(|n| strsim::damerau_levenshtein(n, name) <= 2)
            .map_or(String::new(), |n| format!("; did you mean `{n}`?"));
        format!("parameter `{name}` is not declared: write \"uniform float {name}\" or `Declare` it before{near}")
    }

    fn one_or_more(&mut self) -> Result<Vec<f32>, Fail> {
        match self.peek()? {
            Some(Token::Number(_)) => Ok(vec![self.number()?]),
            _ => self.numbers(),
        }
    }

    fn strings(&mut self) -> Result<Vec<String>, Fail> {
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
        Token::Open => "`[`".into(),
        Token::Close => "`]`".into(),
        Token::Comment(c) => format!("the directive `#{c}`"),
    }
}
