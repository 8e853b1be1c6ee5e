//! Tokens → syntax tree, by recursive descent (RISpec part II, section 17 has the grammar).

use super::ast::*;
use super::diagnostic::{Error, error, error_with};
use super::lex::Tok;
use crate::ir::ShaderKind;

/// The deepest that expressions and statements may nest.
const MAX_DEPTH: usize = 200;

/// The most terms that operators of one rank join: the tree of a sum is as deep as the sum is long.
const MAX_TERMS: usize = 500;

/// Binary operators by rising precedence.
const LEVELS: &[&[&str]] =
    &[&["||"], &["&&"], &["==", "!="], &["<", "<=", ">", ">="], &["+", "-"], &["^"], &["/", "*"], &["."]];

/// Statements that begin with a name and a parenthesis.
const STATEMENTS: &[&str] = &["if", "while", "for", "illuminance", "illuminate", "solar", "gather", "return"];

struct Parser<'a> {
    tokens: &'a [(Tok, usize)],
    at: usize,
    depth: usize,
    functions: Vec<Function>,
}

/// Parse a source file: functions and at most one shader.
pub fn parse(tokens: &[(Tok, usize)]) -> Result<File, Error> {
    let mut p = Parser { tokens, at: 0, depth: 0, functions: vec![] };
    let mut file = File::default();
    while *p.peek() != Tok::End {
        let at = p.place();
        let head = p.name("a shader or a function")?;
        if let Some(kind) = ShaderKind::of_name(&head) {
            if file.shader.is_some() {
                return error_with(at, "a file holds one shader, this is the second", "give it a file of its own");
            }
            let name = p.name("the shader's name")?;
            let (params, body) = (p.parameters(false)?, p.block()?);
            file.shader = Some(Shader { kind, name, params, body });
        } else if let Some(ret) = Ty::of_name(&head) {
            let name = p.name("the function's name")?;
            let function = p.function(ret, name)?;
            p.functions.push(function);
        } else if *p.peek() == Tok::Op("(") {
            let function = p.function(Ty::Float, head)?;
            p.functions.push(function);
        } else {
            return error(
                at,
                format!("expected surface, displacement, light, volume, imager or a function's type, found `{head}`"),
            );
        }
    }
    file.end = p.place();
    file.functions = p.functions;
    Ok(file)
}

impl Parser<'_> {
    fn peek(&self) -> &Tok {
        &self.tokens[self.at].0
    }

    fn ahead(&self, n: usize) -> &Tok {
        &self.tokens[(self.at + n).min(self.tokens.len() - 1)].0
    }

    fn place(&self) -> usize {
        self.tokens[self.at].1
    }

    fn take(&mut self) -> Tok {
        let token = self.tokens[self.at].0.clone();
        self.at = (self.at + 1).min(self.tokens.len() - 1);
        token
    }

    fn describe(&self) -> String {
        match self.peek() {
            Tok::Name(n) => format!("`{n}`"),
            Tok::Number(x) => format!("the number {x}"),
            Tok::Text(t) => format!("the string \"{t}\""),
            Tok::Op(op) => format!("`{op}`"),
            Tok::End => "the end of the file".into(),
        }
    }

    fn eat(&mut self, op: &str) -> bool {
        let found = matches!(self.peek(), Tok::Op(o) if *o == op);
        if found {
            self.take();
        }
        found
    }

    fn expect(&mut self, op: &str) -> Result<(), Error> {
        if self.eat(op) {
            return Ok(());
        }
        let message = format!("expected `{op}`, found {}", self.describe());
        match op {
            ";" => error_with(self.place(), message, "the statement before this has no `;` at its end"),
            _ => error(self.place(), message),
        }
    }

    fn name(&mut self, what: &str) -> Result<String, Error> {
        match self.peek().clone() {
            Tok::Name(name) => {
                self.take();
                Ok(name)
            }
            _ => error(self.place(), format!("expected {what}, found {}", self.describe())),
        }
    }

    fn eat_name(&mut self, name: &str) -> bool {
        let found = matches!(self.peek(), Tok::Name(n) if n == name);
        if found {
            self.take();
        }
        found
    }

    fn deeper<T>(&mut self, f: impl FnOnce(&mut Self) -> Result<T, Error>) -> Result<T, Error> {
        if self.depth >= MAX_DEPTH {
            return error(self.place(), format!("nested more than {MAX_DEPTH} deep"));
        }
        self.depth += 1;
        let result = f(self);
        self.depth -= 1;
        result
    }

    /// A function after its name; one without a type gives a number.
    fn function(&mut self, ret: Ty, name: String) -> Result<Function, Error> {
        let (params, body) = (self.parameters(true)?, self.block()?);
        Ok(Function { name, ret, params, body })
    }

    /// `(type name [= value], … ; …)`; functions' parameters are varying unless said otherwise, shaders' uniform.
    fn parameters(&mut self, varying: bool) -> Result<Vec<Variable>, Error> {
        self.expect("(")?;
        let mut params = Vec::new();
        while !self.eat(")") {
            let output = self.eat_name("output");
            params.extend(self.variables(varying, output)?);
            let ends = self.eat(";") || matches!(self.peek(), Tok::Op(")")) || (varying && self.eat(","));
            if !ends {
                return error(self.place(), format!("expected `;` or `)`, found {}", self.describe()));
            }
        }
        Ok(params)
    }

    /// `[class] type name [= value] {, name [= value]}`
    fn variables(&mut self, mut varying: bool, output: bool) -> Result<Vec<Variable>, Error> {
        if self.eat_name("varying") {
            varying = true;
        } else if self.eat_name("uniform") {
            varying = false;
        }
        let at = self.place();
        let word = self.name("a type")?;
        let ty = match Ty::of_name(&word) {
            Some(ty) if ty != Ty::Void => ty,
            _ => {
                return error(
                    at,
                    format!("expected a type (float, color, point, vector, normal, matrix, string), found `{word}`"),
                );
            }
        };
        let mut list = Vec::new();
        loop {
            let at = self.place();
            let name = self.name("a variable's name")?;
            let mut array = if self.eat("[") { Some(self.array_length()?) } else { None };
            let value = if self.eat("=") { Some(self.initial()?) } else { None };
            if let (Some(0), Some(Expr { kind: ExprKind::Array(values), .. })) = (array, &value) {
                array = Some(values.len());
            }
            list.push(Variable { at, name, ty, array, varying, output, value });
            // In a function's parameter list a comma may also start the next declaration.
            let next_declares = matches!(self.ahead(1), Tok::Name(n) if Ty::of_name(n).is_some() || n == "uniform" || n == "varying" || n == "output");
            if next_declares || !self.eat(",") {
                return Ok(list);
            }
        }
    }

    /// `length]`; without a length (0 here) an array is as long as what it starts with, or as what is given for it.
    fn array_length(&mut self) -> Result<usize, Error> {
        /// Longer arrays are not worth their registers.
        const LONGEST: usize = 4096;
        if self.eat("]") {
            return Ok(0);
        }
        let at = self.place();
        let length = match self.take() {
            Tok::Number(x) if x >= 1.0 && x.fract() == 0.0 && x <= LONGEST as f32 => x as usize,
            _ => return error(at, format!("an array's length must be a whole number from 1 to {LONGEST}")),
        };
        self.expect("]")?;
        Ok(length)
    }

    /// What a variable starts with: an expression, or the elements of an array.
    fn initial(&mut self) -> Result<Expr, Error> {
        let at = self.place();
        if !self.eat("{") {
            return self.expression();
        }
        let mut values = Vec::new();
        while !self.eat("}") {
            values.push(self.expression()?);
            if !self.eat(",") && !matches!(self.peek(), Tok::Op("}")) {
                return error(self.place(), format!("expected `,` or `}}`, found {}", self.describe()));
            }
        }
        Ok(Expr { at, kind: ExprKind::Array(values) })
    }

    fn block(&mut self) -> Result<Vec<Stmt>, Error> {
        self.expect("{")?;
        let mut body = Vec::new();
        while !self.eat("}") {
            if *self.peek() == Tok::End {
                return error(self.place(), "expected `}`, found the end of the file");
            }
            // A function within a shader; `extern` lets it see what is around it.
            let ret = match self.peek() {
                Tok::Name(n) if matches!((self.ahead(1), self.ahead(2)), (Tok::Name(_), Tok::Op("("))) => {
                    Ty::of_name(n)
                }
                _ => None,
            };
            if ret.is_some() || self.defines_untyped() {
                if ret.is_some() {
                    self.take();
                }
                let name = self.name("the function's name")?;
                let function = self.deeper(|p| p.function(ret.unwrap_or(Ty::Float), name))?;
                self.functions.push(function);
                continue;
            }
            body.push(self.statement()?);
        }
        Ok(body)
    }

    /// Whether a function without a type is defined here: a name, then a block behind its parameters.
    fn defines_untyped(&self) -> bool {
        let (Tok::Name(_), Tok::Op("(")) = (self.peek(), self.ahead(1)) else { return false };
        if matches!(self.peek(), Tok::Name(word) if STATEMENTS.contains(&word.as_str())) {
            return false;
        }
        let end = self.tokens[self.at + 1..].iter().scan(0usize, |open, (token, _)| {
            match token {
                Tok::Op("(") => *open += 1,
                Tok::Op(")") => *open = open.saturating_sub(1),
                _ => {}
            }
            Some(*open)
        });
        let end = end.take_while(|open| *open > 0).count();
        matches!(self.ahead(end + 2), Tok::Op("{"))
    }

    fn statement(&mut self) -> Result<Stmt, Error> {
        self.deeper(|p| {
            let at = p.place();
            Ok(Stmt { at, kind: p.statement_kind(at)? })
        })
    }

    fn statement_kind(&mut self, at: usize) -> Result<StmtKind, Error> {
        let word = match self.peek().clone() {
            Tok::Op("{") => return Ok(StmtKind::Block(self.block()?)),
            Tok::Op(";") => {
                self.take();
                return Ok(StmtKind::Block(vec![]));
            }
            Tok::Name(word) => word,
            _ => return error(at, format!("expected a statement, found {}", self.describe())),
        };
        let kind = match word.as_str() {
            "if" => {
                self.take();
                let (condition, then) = (self.parenthesised()?, self.statement()?);
                let otherwise = if self.eat_name("else") { Some(Box::new(self.statement()?)) } else { None };
                return Ok(StmtKind::If(condition, Box::new(then), otherwise));
            }
            "while" => {
                self.take();
                let condition = self.parenthesised()?;
                return Ok(StmtKind::While(condition, Box::new(self.statement()?)));
            }
            "for" => {
                self.take();
                self.expect("(")?;
                let nothing = |at| Stmt { at, kind: StmtKind::Block(vec![]) };
                let is_next = |p: &Self, end: &str| matches!(p.peek(), Tok::Op(op) if *op == end);
                let start = if is_next(self, ";") { nothing(self.place()) } else { self.simple()? };
                self.expect(";")?;
                let always = Expr { at: self.place(), kind: ExprKind::Number(1.0) };
                let condition = if is_next(self, ";") { always } else { self.expression()? };
                self.expect(";")?;
                let step = if is_next(self, ")") { nothing(self.place()) } else { self.simple()? };
                self.expect(")")?;
                return Ok(StmtKind::For(Box::new(start), condition, Box::new(step), Box::new(self.statement()?)));
            }
            "illuminance" | "illuminate" | "solar" => {
                self.take();
                self.expect("(")?;
                let args = self.arguments()?;
                let which = ["illuminance", "illuminate", "solar"].into_iter().find(|w| *w == word).unwrap_or("solar");
                return Ok(StmtKind::Light(which, args, Box::new(self.statement()?)));
            }
            "break" => {
                self.take();
                StmtKind::Break(self.levels()?)
            }
            "continue" => {
                self.take();
                StmtKind::Continue(self.levels()?)
            }
            "return" => {
                self.take();
                StmtKind::Return(if matches!(self.peek(), Tok::Op(";")) { None } else { Some(self.expression()?) })
            }
            "extern" => {
                self.take();
                StmtKind::Extern(self.externs()?)
            }
            "gather" => {
                self.take();
                self.expect("(")?;
                let args = self.arguments()?;
                let hit = Box::new(self.statement()?);
                let miss = if self.eat_name("else") { Some(Box::new(self.statement()?)) } else { None };
                return Ok(StmtKind::Gather(args, hit, miss));
            }
            "uniform" | "varying" => StmtKind::Declare(self.variables(true, false)?),
            w if Ty::of_name(w).is_some() && matches!(self.ahead(1), Tok::Name(_)) && !self.casts_call() => {
                StmtKind::Declare(self.variables(true, false)?)
            }
            _ => self.simple()?.kind,
        };
        self.expect(";")?;
        Ok(kind)
    }

    /// The type and the names of `extern`, with the place of each name.
    fn externs(&mut self) -> Result<Vec<(String, usize)>, Error> {
        if !self.eat_name("uniform") {
            self.eat_name("varying");
        }
        self.name("a type")?;
        let mut names = Vec::new();
        loop {
            let at = self.place();
            names.push((self.name("a variable's name")?, at));
            if self.eat("[") && !self.eat("]") {
                self.array_length()?;
            }
            if !self.eat(",") {
                return Ok(names);
            }
        }
    }

    /// An assignment or a call.
    fn simple(&mut self) -> Result<Stmt, Error> {
        let at = self.place();
        let whole = self.expression()?;
        let kind = match whole.kind {
            ExprKind::Assign(target, op, value) => StmtKind::Assign(*target, op, *value),
            // What a cast call gives is dropped.
            ExprKind::Cast(_, _, ref inner) if matches!(inner.kind, ExprKind::Call(..)) => StmtKind::Call(whole),
            ExprKind::Call(..) => StmtKind::Call(whole),
            _ => return error(at, "expected a statement: an assignment or a call"),
        };
        Ok(Stmt { at, kind })
    }

    /// What an assignment to `target` is, whose operator is next; its value may be another, as in `a = b = c`.
    fn assignment(&mut self, target: Expr, op: &'static str) -> Result<Expr, Error> {
        let at = target.at;
        let named = |e: &Expr| matches!(e.kind, ExprKind::Name(_));
        let whole = match &target.kind {
            ExprKind::Index(array, _) => named(array),
            _ => named(&target),
        };
        if !whole {
            return error(at, "expected a variable or an element of an array before `=`");
        }
        self.take();
        let value = self.initial()?;
        Ok(Expr { at, kind: ExprKind::Assign(Box::new(target), op, Box::new(value)) })
    }

    /// The number of loops after `break` or `continue`.
    fn levels(&mut self) -> Result<usize, Error> {
        let at = self.place();
        match self.peek() {
            Tok::Number(x) if *x >= 1.0 && x.fract() == 0.0 && *x < 100.0 => {
                let n = *x as usize;
                self.take();
                Ok(n)
            }
            Tok::Number(_) => error(at, "expected the number of loops to leave"),
            _ => Ok(1),
        }
    }

    /// Whether a type is followed by a call, as in `float noise(P);`, and not by a variable.
    fn casts_call(&self) -> bool {
        matches!(self.ahead(2), Tok::Op("("))
    }

    fn parenthesised(&mut self) -> Result<Expr, Error> {
        self.expect("(")?;
        let e = self.expression()?;
        self.expect(")")?;
        Ok(e)
    }

    /// Arguments up to the closing parenthesis.
    fn arguments(&mut self) -> Result<Vec<Expr>, Error> {
        let mut args = Vec::new();
        if self.eat(")") {
            return Ok(args);
        }
        loop {
            args.push(self.expression()?);
            if self.eat(")") {
                return Ok(args);
            }
            self.expect(",")?;
        }
    }

    fn expression(&mut self) -> Result<Expr, Error> {
        self.deeper(|p| {
            let at = p.place();
            let condition = p.binary(0)?;
            if let Tok::Op(op @ ("=" | "+=" | "-=" | "*=" | "/=")) = *p.peek() {
                return p.assignment(condition, op);
            }
            if !p.eat("?") {
                return Ok(condition);
            }
            let then = p.expression()?;
            p.expect(":")?;
            let otherwise = p.expression()?;
            Ok(Expr { at, kind: ExprKind::Choose(Box::new(condition), Box::new(then), Box::new(otherwise)) })
        })
    }

    fn binary(&mut self, level: usize) -> Result<Expr, Error> {
        let Some(ops) = LEVELS.get(level) else { return self.unary() };
        let mut left = self.binary(level + 1)?;
        let mut n_terms = 1;
        while let Tok::Op(op) = *self.peek() {
            if !ops.contains(&op) {
                break;
            }
            let at = self.place();
            n_terms += 1;
            if n_terms > MAX_TERMS {
                return error(at, format!("an expression of more than {MAX_TERMS} terms: compute it in parts"));
            }
            self.take();
            let right = self.binary(level + 1)?;
            left = Expr { at, kind: ExprKind::Binary(op, Box::new(left), Box::new(right)) };
        }
        Ok(left)
    }

    fn unary(&mut self) -> Result<Expr, Error> {
        let at = self.place();
        for op in ["-", "!"] {
            if self.eat(op) {
                let operand = self.deeper(|p| p.unary())?;
                return Ok(Expr { at, kind: ExprKind::Unary(op, Box::new(operand)) });
            }
        }
        self.primary()
    }

    fn primary(&mut self) -> Result<Expr, Error> {
        let at = self.place();
        let kind = match self.peek().clone() {
            Tok::Number(x) => {
                self.take();
                ExprKind::Number(x)
            }
            Tok::Text(t) => {
                self.take();
                ExprKind::Text(t)
            }
            Tok::Op("(") => {
                self.take();
                let first = self.expression()?;
                if self.eat(",") {
                    let mut parts = vec![first, self.expression()?];
                    while self.eat(",") {
                        parts.push(self.expression()?);
                    }
                    let close = self.place();
                    self.expect(")")?;
                    match parts.len() {
                        16 => ExprKind::Matrix(parts),
                        n => ExprKind::Triple(Box::new(parts.try_into().map_err(|_| {
                            Error::new(close, format!("expected 3 numbers, or 16 of a matrix, in brackets, found {n}"))
                        })?)),
                    }
                } else {
                    self.expect(")")?;
                    return Ok(first);
                }
            }
            Tok::Name(name) => {
                self.take();
                match Ty::of_name(&name) {
                    Some(ty) if ty != Ty::Void => {
                        let space = match self.peek().clone() {
                            Tok::Text(space) => {
                                self.take();
                                Some(space)
                            }
                            _ => None,
                        };
                        let operand = self.deeper(|p| p.unary())?;
                        ExprKind::Cast(ty, space, Box::new(operand))
                    }
                    _ if self.eat("(") => ExprKind::Call(name, self.arguments()?),
                    _ => ExprKind::Name(name),
                }
            }
            _ => return error(at, format!("expected an expression, found {}", self.describe())),
        };
        let mut whole = Expr { at, kind };
        while self.eat("[") {
            let index = self.expression()?;
            self.expect("]")?;
            whole = Expr { at, kind: ExprKind::Index(Box::new(whole), Box::new(index)) };
        }
        Ok(whole)
    }
}
