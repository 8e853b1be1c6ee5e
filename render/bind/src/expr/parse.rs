//! An expression's text → its program, in one pass: a step is emitted once its operands are.

use super::program::{Arithmetic, Comparison, Function, Program, Step};

/// A syntax or type error in an expression.
#[derive(Clone, Debug, PartialEq)]
pub struct ExprError {
    /// Byte offset of the error in the text, from 0.
    pub at: usize,
    /// The error message.
    pub message: String,
}

/// What is known of an operand before a frame is there.
#[derive(Clone, Copy, PartialEq)]
enum Operand {
    Number,
    /// A word, or a column, whose type the frame tells.
    Any,
}

/// Compile a text.
pub(super) fn parse(text: &str) -> Result<Program, ExprError> {
    let mut p = Parser { text, at: 0, depth: 0, program: Program::default() };
    p.or()?;
    p.skip();
    if p.at < text.len() {
        let rest = &text[p.at..];
        let named = rest.starts_with([':', '[', '.', '#', '@', '$', '('])
            && text[..p.at].ends_with(|c: char| c.is_alphanumeric() || c == '_');
        let hint = if named {
            "; a column whose name has other characters than letters, digits and `_` stands in backticks"
        } else {
            ""
        };
        let shown = &rest[..rest.floor_char_boundary(40)];
        let more = if shown.len() < rest.len() { "…" } else { "" };
        return p.fail(format!("unexpected `{shown}{more}`{hint}"));
    }
    Ok(p.program)
}

struct Parser<'a> {
    text: &'a str,
    at: usize,
    depth: usize,
    program: Program,
}

impl Parser<'_> {
    fn fail<T>(&self, message: impl Into<String>) -> Result<T, ExprError> {
        Err(ExprError { at: self.at, message: message.into() })
    }

    fn skip(&mut self) {
        self.at += self.text[self.at..].len() - self.text[self.at..].trim_start().len();
    }

    fn eat(&mut self, op: &str) -> bool {
        self.skip();
        let rest = &self.text[self.at..];
        let word = op.starts_with(|c: char| c.is_ascii_alphabetic());
        let ends = |c: char| !(c.is_alphanumeric() || c == '_');
        let found = rest.starts_with(op) && (!word || rest[op.len()..].chars().next().is_none_or(ends));
        if found {
            self.at += op.len();
        }
        found
    }

    /// Emit a step; its place.
    fn emit(&mut self, step: Step) -> usize {
        self.program.steps.push(step);
        self.program.steps.len() - 1
    }

    /// See to it that the operand just emitted is a number.
    fn need_number(&mut self, operand: Operand) {
        if operand == Operand::Any {
            self.emit(Step::ToNumber);
        }
    }

    /// Let steps that decide an expression early go on after what is emitted last.
    fn land(&mut self, jumps: &[usize]) {
        let here = self.program.steps.len();
        for at in jumps {
            match &mut self.program.steps[*at] {
                Step::And(end) | Step::Or(end) | Step::Chain(_, end) => *end = here,
                _ => unreachable!("a step that does not go on elsewhere"),
            }
        }
    }

    fn or(&mut self) -> Result<Operand, ExprError> {
        if self.depth > 100 {
            return self.fail("nested too deep");
        }
        self.depth += 1;
        let mut left = self.and()?;
        while self.eat("or") || self.eat("||") {
            left = self.logic(left, Step::Or(0), Self::and)?;
        }
        self.depth -= 1;
        Ok(left)
    }

    fn and(&mut self) -> Result<Operand, ExprError> {
        let mut left = self.not()?;
        while self.eat("and") || self.eat("&&") {
            left = self.logic(left, Step::And(0), Self::not)?;
        }
        Ok(left)
    }

    /// The second operand of `and` or `or`, which runs only if the first leaves it open.
    fn logic(
        &mut self,
        left: Operand,
        step: Step,
        right: fn(&mut Self) -> Result<Operand, ExprError>,
    ) -> Result<Operand, ExprError> {
        self.need_number(left);
        let decide = self.emit(step);
        let right = right(self)?;
        self.need_number(right);
        self.emit(Step::Truth);
        self.land(&[decide]);
        Ok(Operand::Number)
    }

    fn not(&mut self) -> Result<Operand, ExprError> {
        if !self.eat("not") {
            return self.comparison();
        }
        let operand = self.not()?;
        self.need_number(operand);
        self.emit(Step::Not);
        Ok(Operand::Number)
    }

    fn comparison(&mut self) -> Result<Operand, ExprError> {
        let first = self.sum()?;
        let ops = [
            ("<=", Comparison::LessEqual),
            (">=", Comparison::GreaterEqual),
            ("==", Comparison::Equal),
            ("!=", Comparison::NotEqual),
            ("<", Comparison::Less),
            (">", Comparison::Greater),
        ];
        let mut chain = Vec::new();
        while let Some((_, op)) = ops.iter().find(|(text, _)| self.eat(text)) {
            self.sum()?;
            chain.push(self.emit(Step::Chain(*op, 0)));
        }
        // The last comparison has the answer of all.
        let Some(last) = chain.pop() else { return Ok(first) };
        if let Step::Chain(op, _) = self.program.steps[last] {
            self.program.steps[last] = Step::Compare(op);
        }
        self.land(&chain);
        Ok(Operand::Number)
    }

    fn sum(&mut self) -> Result<Operand, ExprError> {
        let mut left = self.product()?;
        loop {
            let op = if self.eat("+") {
                Arithmetic::Add
            } else if self.eat("-") {
                Arithmetic::Sub
            } else {
                return Ok(left);
            };
            left = self.arithmetic(left, op, Self::product)?;
        }
    }

    fn product(&mut self) -> Result<Operand, ExprError> {
        let mut left = self.power()?;
        loop {
            let op = if self.eat("*") {
                Arithmetic::Mul
            } else if self.eat("/") {
                Arithmetic::Div
            } else if self.eat("%") {
                Arithmetic::Mod
            } else {
                return Ok(left);
            };
            left = self.arithmetic(left, op, Self::power)?;
        }
    }

    fn power(&mut self) -> Result<Operand, ExprError> {
        let base = self.unary()?;
        if self.eat("**") { self.arithmetic(base, Arithmetic::Pow, Self::power) } else { Ok(base) }
    }

    /// The second operand of an operation on numbers.
    fn arithmetic(
        &mut self,
        left: Operand,
        op: Arithmetic,
        right: fn(&mut Self) -> Result<Operand, ExprError>,
    ) -> Result<Operand, ExprError> {
        self.need_number(left);
        let right = right(self)?;
        self.need_number(right);
        self.emit(Step::Arithmetic(op));
        Ok(Operand::Number)
    }

    fn unary(&mut self) -> Result<Operand, ExprError> {
        if !self.eat("-") {
            return self.primary();
        }
        self.depth += 1;
        if self.depth > 100 {
            return self.fail("nested too deep");
        }
        let operand = self.unary()?;
        self.depth -= 1;
        self.need_number(operand);
        self.emit(Step::Negate);
        Ok(Operand::Number)
    }

    fn primary(&mut self) -> Result<Operand, ExprError> {
        self.skip();
        let start = self.at;
        let rest = &self.text[start..];
        if self.eat("(") {
            let inner = self.or()?;
            return if self.eat(")") { Ok(inner) } else { self.fail("expected `)`") };
        }
        if let Some(quote) = rest.chars().next().filter(|c| matches!(c, '\'' | '"')) {
            let Some(end) = rest[1..].find(quote) else { return self.fail("a quoted word is not closed") };
            self.at += end + 2;
            self.emit(Step::Word(rest[1..end + 1].into()));
            return Ok(Operand::Any);
        }
        if let Some(name) = rest.strip_prefix('`') {
            let Some(end) = name.find('`') else {
                return self.fail("a column's name is not closed by a backtick");
            };
            self.at += end + 2;
            return Ok(self.column(&name[..end]));
        }
        if rest.starts_with(|c: char| c.is_ascii_digit() || c == '.') {
            let word = &rest[..number_length(rest)];
            self.at += word.len();
            let number =
                word.parse().map_err(|_| ExprError { at: start, message: format!("`{word}` is not a number") })?;
            self.emit(Step::Number(number));
            return Ok(Operand::Number);
        }
        let n = rest.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(rest.len());
        if n == 0 {
            let found = rest.chars().next().map_or("the end".into(), |c| format!("`{c}`"));
            return self.fail(format!("expected a number, a column or `(`, found {found}"));
        }
        self.at += n;
        let name = &rest[..n];
        if self.eat("(") {
            return self.call(name, start);
        }
        Ok(self.column(name))
    }

    fn column(&mut self, name: &str) -> Operand {
        let known = self.program.columns.iter().position(|c| c == name);
        let column = known.unwrap_or_else(|| {
            self.program.columns.push(name.into());
            self.program.columns.len() - 1
        });
        self.emit(Step::Column(column));
        Operand::Any
    }

    fn call(&mut self, name: &str, start: usize) -> Result<Operand, ExprError> {
        let functions = [
            ("sqrt", Step::Call(Function::Sqrt), 1),
            ("abs", Step::Call(Function::Abs), 1),
            ("sin", Step::Call(Function::Sin), 1),
            ("cos", Step::Call(Function::Cos), 1),
            ("exp", Step::Call(Function::Exp), 1),
            ("log", Step::Call(Function::Log), 1),
            ("floor", Step::Call(Function::Floor), 1),
            ("min", Step::Arithmetic(Arithmetic::Min), 2),
            ("max", Step::Arithmetic(Arithmetic::Max), 2),
        ];
        let Some((_, step, n)) = functions.into_iter().find(|(known, ..)| *known == name) else {
            let message =
                format!("unknown function `{name}`, expected sqrt, abs, sin, cos, exp, log, floor, min or max");
            return Err(ExprError { at: start, message });
        };
        let mut found = 0;
        loop {
            let argument = self.or()?;
            self.need_number(argument);
            found += 1;
            if !self.eat(",") {
                break;
            }
        }
        if !self.eat(")") {
            return self.fail("expected `)`");
        }
        if found != n {
            return Err(ExprError { at: start, message: format!("`{name}` takes {n} arguments, found {found}") });
        }
        self.emit(step);
        Ok(Operand::Number)
    }
}

/// The length of the number that a text begins with: digits and points, and an exponent if it has one.
fn number_length(text: &str) -> usize {
    let n = text.find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap_or(text.len());
    let exponent = text[n..].strip_prefix(['e', 'E']).map(|e| e.strip_prefix(['+', '-']).unwrap_or(e));
    match exponent.filter(|e| e.starts_with(|c: char| c.is_ascii_digit())) {
        Some(e) => text.len() - e.len() + e.find(|c: char| !c.is_ascii_digit()).unwrap_or(e.len()),
        None => n,
    }
}
