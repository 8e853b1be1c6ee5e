//! A compiled expression: steps on a stack of values, run for row after row of a frame's table.
//!
//! Every step has its operands' types. Words come from quoted texts and from columns of words; what a column holds, only the frame
//! tells. Where a number is needed and a word may stand, [`Step::ToNumber`] is between.

use frame::{Column, Frame, csv};

/// A step: what it takes from the stack → what it puts there.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Step {
    /// → a number.
    Number(f64),
    /// → a word.
    Word(String),
    /// → the row's value of a column, by its index in [`Program::columns`]: a number or a word.
    Column(usize),
    /// A number or a word → the number that it is.
    ToNumber,
    /// A number → its negative.
    Negate,
    /// A number → 1 if it is 0, else 0.
    Not,
    /// A number → 0 if it is 0, else 1.
    Truth,
    /// Two numbers → one.
    Arithmetic(Arithmetic),
    /// One number → one.
    Call(Function),
    /// A number → nothing; or 0 if it is 0, and on at another step.
    And(usize),
    /// A number → nothing; or 1 if it is not 0, and on at another step.
    Or(usize),
    /// Two values → the second, if they compare so; else 0, and on at another step.
    Chain(Comparison, usize),
    /// Two values → 1 if they compare so, else 0.
    Compare(Comparison),
}

/// An operation on two numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Arithmetic {
    Add,
    Sub,
    Mul,
    Div,
    Mod,
    Pow,
    Min,
    Max,
}

/// A comparison of two values of one type.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Comparison {
    Less,
    LessEqual,
    Greater,
    GreaterEqual,
    Equal,
    NotEqual,
}

/// A function of one number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Function {
    Sqrt,
    Abs,
    Sin,
    Cos,
    Exp,
    Log,
    Floor,
}

/// Steps, and the columns that they read.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Program {
    pub(super) steps: Vec<Step>,
    /// Names, each once, as they come in the text.
    pub(super) columns: Vec<String>,
}

/// A value of a row.
#[derive(Clone, Copy, Debug)]
pub(super) enum Value<'a> {
    Number(f64),
    Word(&'a str),
}

impl Value<'_> {
    fn number(self) -> Result<f64, String> {
        match self {
            Value::Number(x) => Ok(x),
            // A column that has words in other rows may have a number in this one.
            Value::Word(w) => csv::number(w).ok_or_else(|| format!("the word `{w}` stands where a number is needed")),
        }
    }
}

/// A program over the columns of a frame.
pub(super) struct Run<'a> {
    program: &'a Program,
    /// None: the frame has no such column, which is an error once a row asks for it.
    columns: Vec<Option<&'a Column>>,
    stack: Vec<Value<'a>>,
}

impl Program {
    /// The program that reads a column.
    pub(super) fn column(name: &str) -> Program {
        Program { steps: vec![Step::Column(0)], columns: vec![name.into()] }
    }

    /// Look its columns up in a frame.
    pub(super) fn run<'a>(&'a self, frame: &'a Frame) -> Run<'a> {
        let columns = self.columns.iter().map(|name| frame.column(name)).collect();
        Run { program: self, columns, stack: vec![] }
    }
}

fn truth<'a>(holds: bool) -> Value<'a> {
    Value::Number(holds as u8 as f64)
}

impl<'a> Run<'a> {
    /// The value of a row.
    pub(super) fn row(&mut self, row: usize) -> Result<Value<'a>, String> {
        self.stack.clear();
        let program = self.program;
        let mut at = 0;
        while let Some(step) = program.steps.get(at) {
            at += 1;
            let value = match step {
                Step::Number(x) => Value::Number(*x),
                Step::Word(word) => Value::Word(word),
                Step::Column(k) => match self.columns[*k] {
                    Some(Column::Category { codes, names }) => Value::Word(&names[codes[row] as usize]),
                    Some(column) => Value::Number(column.number(row).unwrap_or(f64::NAN)),
                    None => return Err(format!("there is no column `{}`", program.columns[*k])),
                },
                Step::ToNumber => Value::Number(self.pop().number()?),
                Step::Negate => Value::Number(-self.number()),
                Step::Not => truth(self.number() == 0.0),
                Step::Truth => truth(self.number() != 0.0),
                Step::Arithmetic(op) => {
                    let (b, a) = (self.number(), self.number());
                    Value::Number(op.of(a, b))
                }
                Step::Call(f) => Value::Number(f.of(self.number())),
                Step::And(end) | Step::Or(end) => {
                    let decided = matches!(step, Step::Or(_));
                    if (self.number() != 0.0) != decided {
                        continue;
                    }
                    at = *end;
                    truth(decided)
                }
                Step::Chain(op, end) => {
                    let (right, left) = (self.pop(), self.pop());
                    if op.holds(&left, &right)? {
                        right
                    } else {
                        at = *end;
                        truth(false)
                    }
                }
                Step::Compare(op) => {
                    let (right, left) = (self.pop(), self.pop());
                    truth(op.holds(&left, &right)?)
                }
            };
            self.stack.push(value);
        }
        Ok(self.pop())
    }

    fn pop(&mut self) -> Value<'a> {
        self.stack.pop().expect("a step's operands are on the stack")
    }

    /// The number on top: the compiler has put [`Step::ToNumber`] before what needs one.
    fn number(&mut self) -> f64 {
        match self.pop() {
            Value::Number(x) => x,
            Value::Word(_) => unreachable!("a word where the program has a number"),
        }
    }
}

impl Arithmetic {
    fn of(self, a: f64, b: f64) -> f64 {
        match self {
            Arithmetic::Add => a + b,
            Arithmetic::Sub => a - b,
            Arithmetic::Mul => a * b,
            Arithmetic::Div => a / b,
            Arithmetic::Mod => a.rem_euclid(b),
            Arithmetic::Pow => a.powf(b),
            Arithmetic::Min => a.min(b),
            Arithmetic::Max => a.max(b),
        }
    }
}

impl Function {
    fn of(self, x: f64) -> f64 {
        match self {
            Function::Sqrt => x.sqrt(),
            Function::Abs => x.abs(),
            Function::Sin => x.sin(),
            Function::Cos => x.cos(),
            Function::Exp => x.exp(),
            Function::Log => x.ln(),
            Function::Floor => x.floor(),
        }
    }
}

impl Comparison {
    fn holds(self, a: &Value<'_>, b: &Value<'_>) -> Result<bool, String> {
        let order = match (a, b) {
            (Value::Number(a), Value::Number(b)) => a.partial_cmp(b),
            (Value::Word(a), Value::Word(b)) => Some(a.cmp(b)),
            (Value::Number(x), Value::Word(w)) | (Value::Word(w), Value::Number(x)) => {
                return Err(format!("the word `{w}` cannot be compared with the number {x}"));
            }
        };
        Ok(match self {
            Comparison::Less => order.is_some_and(|o| o.is_lt()),
            Comparison::LessEqual => order.is_some_and(|o| o.is_le()),
            Comparison::Greater => order.is_some_and(|o| o.is_gt()),
            Comparison::GreaterEqual => order.is_some_and(|o| o.is_ge()),
            Comparison::Equal => order.is_some_and(|o| o.is_eq()),
            Comparison::NotEqual => order.is_none_or(|o| o.is_ne()),
        })
    }
}
