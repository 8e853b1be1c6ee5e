//! The arguments of a request, from the stream's tokens: a method for each kind of the table (`groups.rs` has those of few requests).
//!
//! Numbers are taken from the bytes without making tokens of them where that is all that follows; anything else goes token by token.

use crate::conditions::Conditions;
use crate::lexer::{Lexer, Mark, Token};
use crate::params::{Class, Declarations, Param, Params, Type, Values, declaration_in};
use crate::requests::Request;
use crate::ri::Fail;
use crate::standing::Standing;
use std::collections::HashSet;
use std::path::Path;

/// What a stream and the archives within it know in common.
#[derive(Default)]
pub(crate) struct Known {
    /// Parameters by name.
    pub(crate) declarations: Declarations,
    /// The frame, and options that conditions ask for.
    pub(crate) conditions: Conditions,
    /// Where the stream is.
    pub(crate) standing: Standing,
    /// What has been warned of.
    warned: HashSet<String>,
    /// Red, green and blue of each sample of a colour, if `ColorSamples` said that (RISpec 4.2.3); and before the frame.
    pub(crate) samples: Option<Vec<[f32; 3]>>,
    pub(crate) samples_before: Option<Vec<[f32; 3]>>,
}

/// Line and column, from 1.
pub(crate) type Spot = (usize, usize);

/// Reads the arguments of one request after the other.
pub(crate) struct Arguments<'a> {
    path: &'a Path,
    pub(crate) lexer: Lexer<'a>,
    peeked: Option<(Token<'a>, Spot)>,
    /// The first byte of the token that was taken last, or looked at.
    token_start: usize,
    /// What is at fault, if that is not what comes next.
    pub(crate) at_fault: Option<Spot>,
    pub(crate) known: &'a mut Known,
    /// Where the request under way stands.
    pub(crate) request: Spot,
    /// Warnings that nobody has been told yet.
    pub(crate) warnings: Vec<String>,
}

/// Numbers that stand in a row, as the argument that takes them.
pub(crate) trait InRow {
    /// Count of numbers that it takes.
    const WIDTH: usize;
    /// Take it from the front of the numbers.
    fn take(row: &mut &[f32]) -> Self;
}

impl InRow for f32 {
    const WIDTH: usize = 1;
    #[inline(always)]
    fn take(row: &mut &[f32]) -> f32 {
        <[f32; 1]>::take(row)[0]
    }
}

impl InRow for i32 {
    const WIDTH: usize = 1;
    #[inline(always)]
    fn take(row: &mut &[f32]) -> i32 {
        f32::take(row) as i32
    }
}

impl<const N: usize> InRow for [f32; N] {
    const WIDTH: usize = N;
    #[inline(always)]
    fn take(row: &mut &[f32]) -> [f32; N] {
        let (own, rest) = row.split_first_chunk().expect("as many numbers as the arguments are wide");
        *row = rest;
        *own
    }
}

impl<'a> Arguments<'a> {
    /// Start at the beginning of a stream that came from `path`.
    pub(crate) fn new(path: &'a Path, bytes: &'a [u8], known: &'a mut Known) -> Arguments<'a> {
        let lexer = Lexer::new(bytes);
        let (peeked, at_fault) = (None, None);
        Arguments { path, lexer, peeked, token_start: 0, at_fault, known, request: (1, 1), warnings: vec![] }
    }

    /// Warn of something, once for each `key`, with the request's place.
    pub(crate) fn warn(&mut self, key: &str, message: &str) {
        if self.known.warned.insert(key.into()) {
            let (line, column) = self.request;
            self.warnings.push(format!("{}:{line}:{column}: {message}", self.path.display()));
        }
    }

    /// Whether there was a warning under this key.
    pub(crate) fn has_warned(&self, key: &str) -> bool {
        self.known.warned.contains(key)
    }

    /// Note the request under way, which is warned of where it is misplaced. Whether it is to be made.
    pub(crate) fn note(&mut self, request: Request) -> bool {
        match request {
            Request::FrameBegin => self.known.samples_before.clone_from(&self.known.samples),
            Request::FrameEnd => self.known.samples = self.known.samples_before.take(),
            _ => {}
        }
        self.known.standing.note(request, self.path, self.request, &mut self.warnings)
    }

    /// The token that was looked at and left in place.
    pub(crate) fn peeked(&self) -> Option<&(Token<'a>, Spot)> {
        self.peeked.as_ref()
    }

    /// The next token and its place.
    pub(crate) fn take(&mut self) -> Result<Option<(Token<'a>, Spot)>, String> {
        if let Some(token) = self.peeked.take() {
            return Ok(Some(token));
        }
        let place = self.lexer.place();
        self.token_start = self.lexer.position();
        let token = self.lexer.next().inspect_err(|_| self.at_fault = Some(place))?;
        Ok(token.map(|t| (t, place)))
    }

    /// The place of the token that follows, and its first byte.
    pub(crate) fn next_start(&mut self) -> (Spot, usize) {
        match &self.peeked {
            Some((_, place)) => (*place, self.token_start),
            None => (self.lexer.place(), self.lexer.position()),
        }
    }

    /// Where a fault of the arguments lies that begin at `start`: where reading stopped, unless it is known better.
    pub(crate) fn fault(&mut self, start: Mark) -> Spot {
        let known = self.at_fault.take().or(self.peeked.as_ref().map(|(_, place)| *place));
        known.unwrap_or_else(|| self.lexer.place_after(start))
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
        // What ends before all of its arguments is at fault itself, not the request that follows.
        let ends = match &self.peeked {
            Some((Token::Word(word), (line, _))) => *line != self.request.0 || Request::named(word).is_some(),
            Some((token, _)) => matches!(token, Token::Comment(_)),
            None => true,
        };
        self.at_fault = ends.then_some(self.request);
        Err(Fail::new(format!("expected {what}, found {found}")))
    }

    /// At a glance, whether a request follows, in letters or by its code; where it takes a closer look, not.
    #[inline]
    fn request_follows(&mut self) -> bool {
        self.peeked.is_none() && matches!(self.lexer.first(), Some(b'A'..=b'Z' | 0o246))
    }

    /// An error if arguments of the request `name` are left over.
    #[inline(always)]
    pub(crate) fn end_of(&mut self, name: &str) -> Result<(), Fail> {
        if self.request_follows() || !self.has_argument()? {
            return Ok(());
        }
        Err(Fail::new(format!("`{name}` has more arguments than it takes")))
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
    pub(crate) fn has_text(&mut self) -> Result<bool, Fail> {
        Ok(matches!(self.peek()?, Some(Token::Text(_))))
    }

    /// Read over the arguments of a request that is not known.
    pub(crate) fn pass_over(&mut self) -> Result<(), Fail> {
        while self.has_argument()? {
            self.peeked = None;
        }
        Ok(())
    }

    /// A number; a bracketed single one counts.
    pub(crate) fn number(&mut self) -> Result<f32, Fail> {
        match self.peek()? {
            Some(Token::Number(x)) => {
                let x = *x;
                self.peeked = None;
                Ok(x)
            }
            Some(Token::Open | Token::Numbers(_)) => Ok(self.numbers::<1>("a number")?[0]),
            _ => self.expected("a number"),
        }
    }

    /// A whole number.
    pub(crate) fn whole(&mut self) -> Result<i32, Fail> {
        let x = self.number()?;
        if x.fract() == 0.0 && x.abs() < 2e9 {
            Ok(x as i32)
        } else {
            Err(Fail::new(format!("expected a whole number, found {x}")))
        }
    }

    /// A switch: 0 or 1.
    pub(crate) fn flag(&mut self) -> Result<bool, Fail> {
        let x = self.number()?;
        if x != 0.0 && x != 1.0 {
            self.warn(&format!("a flag of {x}"), &format!("a flag is {x}, expected 0 or 1: it counts as 1"));
        }
        Ok(x != 0.0)
    }

    /// Exactly `N` numbers, with or without brackets.
    #[inline(always)]
    pub(crate) fn numbers<const N: usize>(&mut self, what: &str) -> Result<[f32; N], Fail> {
        let mut out = [0.0; N];
        let n = if self.peeked.is_none() { self.lexer.fill(&mut out).map_err(|m| self.stops_here(m))? } else { 0 };
        if n == N { Ok(out) } else { self.more_numbers(out, n, what) }
    }

    /// What cannot be read stands where reading has stopped.
    #[cold]
    fn stops_here(&mut self, message: String) -> Fail {
        self.at_fault = Some(self.lexer.place());
        Fail::new(message)
    }

    /// The numbers after the first `n`, token by token.
    #[cold]
    fn more_numbers<const N: usize>(&mut self, mut out: [f32; N], n: usize, what: &str) -> Result<[f32; N], Fail> {
        if n == 0 && matches!(self.peek()?, Some(Token::Open | Token::Numbers(_))) {
            let list = self.floats()?;
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
    pub(crate) fn floats(&mut self) -> Result<Vec<f32>, Fail> {
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
            self.lexer.numbers(&mut out).map_err(|message| self.stops_here(message))?;
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
    pub(crate) fn wholes(&mut self) -> Result<Vec<i32>, Fail> {
        Ok(self.floats()?.into_iter().map(|x| x as i32).collect())
    }

    /// A string; a bracketed single one counts.
    pub(crate) fn text(&mut self) -> Result<String, Fail> {
        match self.peek()? {
            Some(Token::Text(_)) => match self.peeked.take() {
                Some((Token::Text(text), _)) => Ok(text),
                _ => unreachable!("a string was seen"),
            },
            Some(Token::Open) => {
                self.peeked = None;
                let text = self.text()?;
                match self.peek()? {
                    Some(Token::Close) => self.peeked = None,
                    _ => return self.expected("`]`"),
                }
                Ok(text)
            }
            _ => self.expected("a string"),
        }
    }

    /// A bracketed list of strings; a single one counts.
    pub(crate) fn texts(&mut self) -> Result<Vec<String>, Fail> {
        if !matches!(self.peek()?, Some(Token::Open)) {
            return Ok(vec![self.text()?]);
        }
        self.peeked = None;
        let mut out = Vec::new();
        loop {
            match self.peek()? {
                Some(Token::Text(_)) => out.push(self.text()?),
                Some(Token::Close) => {
                    self.peeked = None;
                    return Ok(out);
                }
                _ => return self.expected("a string or `]`"),
            }
        }
    }

    /// A light's or an object's handle: a number or a string.
    pub(crate) fn handle(&mut self) -> Result<String, Fail> {
        match self.peek()? {
            Some(Token::Number(_)) => Ok(self.whole()?.to_string()),
            _ => self.text(),
        }
    }

    /// The parameter list that ends a request.
    #[inline(always)]
    pub(crate) fn params(&mut self) -> Result<Params, Fail> {
        self.params_of("")
    }

    /// The parameter list of an option or an attribute, which may have names of its group ([`declaration_in`]).
    #[inline(always)]
    pub(crate) fn params_of(&mut self, group: &str) -> Result<Params, Fail> {
        if self.request_follows() { Ok(Vec::new()) } else { self.parameters(group) }
    }

    fn parameters(&mut self, group: &str) -> Result<Params, Fail> {
        let mut params: Params = Vec::new();
        while self.has_text()? {
            let place = self.peeked.as_ref().map(|(_, place)| *place);
            let token = self.text()?;
            let Some(Param { decl, values }) = self.parameter(group, token, place)? else { continue };
            let n = match &values {
                Values::Floats(v) => v.len(),
                Values::Strings(v) => v.len(),
            };
            // Of no points there are no values.
            let is_none = n == 0 && (decl.class.is_whole() || decl.ty == Type::String);
            if is_none || n % decl.width() != 0 {
                let message = format!("`{}` has {n} values, expected a multiple of {}", decl.inline(), decl.width());
                self.at_fault = place;
                return Err(Fail::new(message));
            }
            params.push(Param { decl, values });
        }
        Ok(params)
    }

    /// A parameter by its token; none if that is not declared.
    fn parameter(&mut self, group: &str, token: String, place: Option<Spot>) -> Result<Option<Param>, Fail> {
        let decl = self.known.declarations.resolve(&token).map_err(|message| {
            self.at_fault = place;
            Fail::new(message)
        })?;
        if decl.is_none() && [group, &token] == ["visibility", "transmission"] {
            return self.number_or_text(&token).map(Some);
        }
        let Some(decl) = decl.or_else(|| declaration_in(group, &token)) else {
            // What is not declared is read over, as the specification asks.
            let ty = if self.pass_value()? { "string" } else { "float" };
            let message = self.undeclared(&token, ty);
            self.warn(&format!("parameter {token}"), &message);
            return Ok(None);
        };
        let values = if decl.ty == Type::String {
            Values::Strings(self.texts()?)
        } else {
            Values::Floats(self.colours_of(decl.ty)?)
        };
        Ok(Some(Param { decl, values }))
    }

    /// The value of a parameter that is a number or a text.
    fn number_or_text(&mut self, name: &str) -> Result<Param, Fail> {
        let is_listed = matches!(self.peek()?, Some(Token::Open));
        if is_listed {
            self.peeked = None;
        }
        let param = match self.peek()? {
            Some(Token::Text(_)) => Param::string(name, &self.text()?),
            Some(Token::Number(_)) => Param::floats(name, Class::Uniform, Type::Float, [self.number()?]),
            Some(Token::Numbers(_)) => Param::floats(name, Class::Uniform, Type::Float, self.floats()?),
            _ => return self.expected("a number or a string"),
        };
        match self.peek()? {
            Some(Token::Close) if is_listed => self.peeked = None,
            _ if is_listed => return self.expected("`]`"),
            _ => {}
        }
        Ok(param)
    }

    fn one_or_more(&mut self) -> Result<Vec<f32>, Fail> {
        match self.peek()? {
            Some(Token::Number(_)) => Ok(vec![self.number()?]),
            _ => self.floats(),
        }
    }

    /// The numbers of a parameter, of which colours of other samples become red, green and blue.
    fn colours_of(&mut self, ty: Type) -> Result<Vec<f32>, Fail> {
        let values = self.one_or_more()?;
        match &self.known.samples {
            Some(samples) if ty == Type::Color => to_rgb(&values, samples),
            _ => Ok(values),
        }
    }

    fn undeclared(&self, name: &str, ty: &str) -> String {
        let near =
            self.known.declarations.names().min_by_key(|n| (strsim::damerau_levenshtein(n, name), n.to_string()));
        let near = near
            .filter(|n| strsim::damerau_levenshtein(n, name) <= 2)
            .map_or(String::new(), |n| format!("; did you mean `{n}`?"));
        format!("parameter `{name}` is not declared: write \"uniform {ty} {name}\" or `Declare` it before{near}")
    }

    /// Read over the value of a parameter: whether texts are in it.
    fn pass_value(&mut self) -> Result<bool, Fail> {
        let mut is_text = matches!(self.peek()?, Some(Token::Text(_)));
        match self.peek()? {
            Some(Token::Text(_) | Token::Number(_) | Token::Numbers(_)) => self.peeked = None,
            Some(Token::Open) => {
                while !matches!(self.peek()?, Some(Token::Close)) {
                    if !matches!(self.peek()?, Some(Token::Text(_) | Token::Number(_) | Token::Open)) {
                        return self.expected("a value or `]`");
                    }
                    is_text |= matches!(self.peek()?, Some(Token::Text(_)));
                    self.peeked = None;
                }
                self.peeked = None;
            }
            _ => return self.expected("a value"),
        }
        Ok(is_text)
    }
}

/// Colours of some samples as red, green and blue.
pub(crate) fn to_rgb(values: &[f32], samples: &[[f32; 3]]) -> Result<Vec<f32>, Fail> {
    if !values.len().is_multiple_of(samples.len()) {
        return Err(Fail::new(format!("{} numbers, expected colours of {} samples", values.len(), samples.len())));
    }
    let component = |color: &[f32], c: usize| color.iter().zip(samples).map(|(x, rgb)| x * rgb[c]).sum::<f32>();
    Ok(values.chunks_exact(samples.len()).flat_map(|color| [0, 1, 2].map(|c| component(color, c))).collect())
}

/// A token as error texts name it.
pub(crate) fn describe(token: &Token<'_>) -> String {
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
