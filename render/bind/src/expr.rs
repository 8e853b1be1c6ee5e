//! Conditions and derived columns: small typed expressions over a frame's columns. Nothing is executed but arithmetic.
//!
//! `class == 'stones' and 0.02 <= size_x < 0.05`, `sqrt(vel_x*vel_x + vel_y*vel_y)`. Operators by falling precedence: `-` and
//! `not`, `**`, `* / %`, `+ -`, comparisons (which chain), `and`, `or`. Functions: sqrt abs sin cos exp log min max floor.

use frame::{Column, Frame};

/// An expression.
#[derive(Clone, Debug, PartialEq)]
pub struct Expr {
    root: Node,
    /// The text that it was read from.
    pub text: String,
}

#[derive(Clone, Debug, PartialEq)]
enum Node {
    Number(f64),
    Text(String),
    Column(String, usize),
    Negate(Box<Node>),
    Not(Box<Node>),
    Binary(Op, Box<Node>, Box<Node>),
    /// first, then (comparison, next)…
    Chain(Box<Node>, Vec<(Op, Node)>),
    Call(Function, Vec<Node>),
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Op {
    Add,
    Sub,
    Mul,
    Div,
    Mod,
    Pow,
    And,
    Or,
    Less,
    LessEqual,
    Greater,
    GreaterEqual,
    Equal,
    NotEqual,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Function {
    Sqrt,
    Abs,
    Sin,
    Cos,
    Exp,
    Log,
    Floor,
    Min,
    Max,
}

/// What is wrong with an expression: the byte in its text, and the message.
#[derive(Clone, Debug, PartialEq)]
pub struct ExprError {
    /// Byte.
    pub at: usize,
    /// What is wrong.
    pub message: String,
}

/// A value of a row.
enum Value<'a> {
    Number(f64),
    Text(&'a str),
}

impl Expr {
    /// Parse.
    pub fn parse(text: &str) -> Result<Expr, ExprError> {
        let mut p = Parser { text, at: 0, depth: 0 };
        let root = p.or()?;
        p.skip();
        if p.at < text.len() {
            return p.fail(format!("unexpected `{}`", &text[p.at..]));
        }
        Ok(Expr { root, text: text.into() })
    }

    /// The columns that it reads, each with its byte in the text.
    pub fn columns(&self) -> Vec<(&str, usize)> {
        fn visit<'a>(n: &'a Node, out: &mut Vec<(&'a str, usize)>) {
            match n {
                Node::Column(name, at) => out.push((name, *at)),
                Node::Negate(a) | Node::Not(a) => visit(a, out),
                Node::Binary(_, a, b) => {
                    visit(a, out);
                    visit(b, out);
                }
                Node::Chain(a, rest) => {
                    visit(a, out);
                    rest.iter().for_each(|(_, b)| visit(b, out));
                }
                Node::Call(_, args) => args.iter().for_each(|a| visit(a, out)),
                Node::Number(_) | Node::Text(_) => {}
            }
        }
        let mut out = Vec::new();
        visit(&self.root, &mut out);
        out
    }

    /// Its value for each row. Every column must be there; words that are no numbers count nowhere.
    pub fn numbers(&self, frame: &Frame, rows: &[usize]) -> Result<Vec<f64>, String> {
        rows.iter()
            .map(|row| match eval(&self.root, frame, *row)? {
                Value::Number(x) => Ok(x),
                Value::Text(t) => {
                    t.parse().map_err(|_| format!("`{}` is the word `{t}`, expected a number", self.text))
                }
            })
            .collect()
    }

    /// The rows for which it is true.
    pub fn select(&self, frame: &Frame) -> Result<Vec<usize>, String> {
        let all: Vec<usize> = (0..frame.rows()).collect();
        let truth = self.numbers(frame, &all)?;
        Ok(all.into_iter().filter(|i| truth[*i] != 0.0).collect())
    }
}

fn eval<'a>(node: &'a Node, frame: &'a Frame, row: usize) -> Result<Value<'a>, String> {
    let number = |n: &'a Node| match eval(n, frame, row)? {
        Value::Number(x) => Ok(x),
        // A column that has words in other rows may have a number in this one.
        Value::Text(t) => t.parse().map_err(|_| format!("the word `{t}` stands where a number is needed")),
    };
    let truth = |b: bool| Ok(Value::Number(b as u8 as f64));
    Ok(Value::Number(match node {
        Node::Number(x) => *x,
        Node::Text(t) => return Ok(Value::Text(t)),
        Node::Column(name, _) => match frame.column(name).ok_or_else(|| format!("there is no column `{name}`"))? {
            Column::Category { codes, names } => return Ok(Value::Text(&names[codes[row] as usize])),
            column => column.number(row).unwrap_or(f64::NAN),
        },
        Node::Negate(a) => -number(a)?,
        Node::Not(a) => return truth(number(a)? == 0.0),
        Node::Binary(Op::And, a, b) => return truth(number(a)? != 0.0 && number(b)? != 0.0),
        Node::Binary(Op::Or, a, b) => return truth(number(a)? != 0.0 || number(b)? != 0.0),
        Node::Binary(op, a, b) => {
            let (a, b) = (number(a)?, number(b)?);
            match op {
                Op::Add => a + b,
                Op::Sub => a - b,
                Op::Mul => a * b,
                Op::Div => a / b,
                Op::Mod => a.rem_euclid(b),
                _ => a.powf(b),
            }
        }
        Node::Chain(first, rest) => {
            let mut left = eval(first, frame, row)?;
            for (op, right) in rest {
                let right = eval(right, frame, row)?;
                if !compare(*op, &left, &right)? {
                    return truth(false);
                }
                left = right;
            }
            return truth(true);
        }
        Node::Call(f, args) => {
            let x = number(&args[0])?;
            match f {
                Function::Sqrt => x.sqrt(),
                Function::Abs => x.abs(),
                Function::Sin => x.sin(),
                Function::Cos => x.cos(),
                Function::Exp => x.exp(),
                Function::Log => x.ln(),
                Function::Floor => x.floor(),
                Function::Min => x.min(number(&args[1])?),
                Function::Max => x.max(number(&args[1])?),
            }
        }
    }))
}

fn compare(op: Op, a: &Value<'_>, b: &Value<'_>) -> Result<bool, String> {
    let order = match (a, b) {
        (Value::Number(a), Value::Number(b)) => a.partial_cmp(b),
        (Value::Text(a), Value::Text(b)) => Some(a.cmp(b)),
        (Value::Number(x), Value::Text(t)) | (Value::Text(t), Value::Number(x)) => {
            return Err(format!("the word `{t}` cannot be compared with the number {x}"));
        }
    };
    Ok(match op {
        Op::Less => order.is_some_and(|o| o.is_lt()),
        Op::LessEqual => order.is_some_and(|o| o.is_le()),
        Op::Greater => order.is_some_and(|o| o.is_gt()),
        Op::GreaterEqual => order.is_some_and(|o| o.is_ge()),
        Op::Equal => order.is_some_and(|o| o.is_eq()),
        _ => order.is_none_or(|o| o.is_ne()),
    })
}

struct Parser<'a> {
    text: &'a str,
    at: usize,
    depth: usize,
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

    fn or(&mut self) -> Result<Node, ExprError> {
        if self.depth > 100 {
            return self.fail("nested too deep");
        }
        self.depth += 1;
        let mut left = self.and()?;
        while self.eat("or") || self.eat("||") {
            left = Node::Binary(Op::Or, Box::new(left), Box::new(self.and()?));
        }
        self.depth -= 1;
        Ok(left)
    }

    fn and(&mut self) -> Result<Node, ExprError> {
        let mut left = self.not()?;
        while self.eat("and") || self.eat("&&") {
            left = Node::Binary(Op::And, Box::new(left), Box::new(self.not()?));
        }
        Ok(left)
    }

    fn not(&mut self) -> Result<Node, ExprError> {
        if self.eat("not") { Ok(Node::Not(Box::new(self.not()?))) } else { self.comparison() }
    }

    fn comparison(&mut self) -> Result<Node, ExprError> {
        let first = self.sum()?;
        let mut rest = Vec::new();
        let ops = [
            ("<=", Op::LessEqual),
            (">=", Op::GreaterEqual),
            ("==", Op::Equal),
            ("!=", Op::NotEqual),
            ("<", Op::Less),
            (">", Op::Greater),
        ];
        while let Some((_, op)) = ops.iter().find(|(text, _)| self.eat(text)) {
            rest.push((*op, self.sum()?));
        }
        Ok(if rest.is_empty() { first } else { Node::Chain(Box::new(first), rest) })
    }

    fn sum(&mut self) -> Result<Node, ExprError> {
        let mut left = self.product()?;
        loop {
            let op = if self.eat("+") {
                Op::Add
            } else if self.eat("-") {
                Op::Sub
            } else {
                return Ok(left);
            };
            left = Node::Binary(op, Box::new(left), Box::new(self.product()?));
        }
    }

    fn product(&mut self) -> Result<Node, ExprError> {
        let mut left = self.power()?;
        loop {
            let op = if self.eat("*") {
                Op::Mul
            } else if self.eat("/") {
                Op::Div
            } else if self.eat("%") {
                Op::Mod
            } else {
                return Ok(left);
            };
            left = Node::Binary(op, Box::new(left), Box::new(self.power()?));
        }
    }

    fn power(&mut self) -> Result<Node, ExprError> {
        let base = self.unary()?;
        if self.eat("**") { Ok(Node::Binary(Op::Pow, Box::new(base), Box::new(self.power()?))) } else { Ok(base) }
    }

    fn unary(&mut self) -> Result<Node, ExprError> {
        if !self.eat("-") {
            return self.primary();
        }
        self.depth += 1;
        if self.depth > 100 {
            return self.fail("nested too deep");
        }
        let operand = self.unary()?;
        self.depth -= 1;
        Ok(Node::Negate(Box::new(operand)))
    }

    fn primary(&mut self) -> Result<Node, ExprError> {
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
            return Ok(Node::Text(rest[1..end + 1].into()));
        }
        let numeric = rest.find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap_or(rest.len());
        if numeric > 0 && rest.starts_with(|c: char| c.is_ascii_digit() || c == '.') {
            let mut n = numeric;
            let exponent = rest[n..].strip_prefix(['e', 'E']).map(|e| e.strip_prefix(['+', '-']).unwrap_or(e));
            if let Some(e) = exponent.filter(|e| e.starts_with(|c: char| c.is_ascii_digit())) {
                n = rest.len() - e.len() + e.find(|c: char| !c.is_ascii_digit()).unwrap_or(e.len());
            }
            self.at += n;
            return rest[..n]
                .parse()
                .map(Node::Number)
                .map_err(|_| ExprError { at: start, message: format!("`{}` is not a number", &rest[..n]) });
        }
        let n = rest.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(rest.len());
        if n == 0 {
            let found = rest.chars().next().map_or("the end".into(), |c| format!("`{c}`"));
            return self.fail(format!("expected a number, a column or `(`, found {found}"));
        }
        self.at += n;
        let name = &rest[..n];
        if self.eat("(") { self.call(name, start) } else { Ok(Node::Column(name.into(), start)) }
    }

    fn call(&mut self, name: &str, start: usize) -> Result<Node, ExprError> {
        let functions = [
            ("sqrt", Function::Sqrt, 1),
            ("abs", Function::Abs, 1),
            ("sin", Function::Sin, 1),
            ("cos", Function::Cos, 1),
            ("exp", Function::Exp, 1),
            ("log", Function::Log, 1),
            ("floor", Function::Floor, 1),
            ("min", Function::Min, 2),
            ("max", Function::Max, 2),
        ];
        let Some((_, f, n)) = functions.iter().find(|(known, ..)| *known == name) else {
            let message =
                format!("unknown function `{name}`, expected sqrt, abs, sin, cos, exp, log, floor, min or max");
            return Err(ExprError { at: start, message });
        };
        let mut args = vec![self.or()?];
        while self.eat(",") {
            args.push(self.or()?);
        }
        if !self.eat(")") {
            return self.fail("expected `)`");
        }
        if args.len() != *n {
            return Err(ExprError {
                at: start,
                message: format!("`{name}` takes {n} arguments, found {}", args.len()),
            });
        }
        Ok(Node::Call(*f, args))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> Frame {
        let mut f = Frame::new(0, 0.0);
        f.push("x", "m", Column::F64(vec![1.0, 2.0, 3.0]));
        f.push("kind", "", Column::Category { codes: vec![0, 1, 0], names: vec!["stone".into(), "wall".into()] });
        f
    }

    #[test]
    fn conditions_select_rows() {
        let rows = |text: &str| Expr::parse(text).unwrap().select(&table()).unwrap();
        assert_eq!(rows("kind == 'stone'"), [0, 2]);
        assert_eq!(rows("1 < x <= 3 and not kind == \"wall\""), [2]);
        assert_eq!(rows("x*x - 1 == 3 or x > 2.5e0"), [1, 2]);
        assert_eq!(rows("-x ** 2 < 0"), Vec::<usize>::new());
        assert_eq!(rows("max(x, 2) == 2"), [0, 1]);
    }

    #[test]
    fn faults_are_placed() {
        for (text, at) in [("x >", 3), ("x + (1", 6), ("sqrtt(x)", 0), ("x = 1", 2), ("kind == 'st", 8), ("", 0)] {
            assert_eq!(Expr::parse(text).unwrap_err().at, at, "{text}");
        }
        assert!(Expr::parse("kind > 3").unwrap().select(&table()).is_err());
    }
}
