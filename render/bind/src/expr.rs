//! Expressions over the columns of a frame, for conditions and derived columns: typed arithmetic and comparisons, without side
//! effects.
//!
//! `class == 'stones' and 0.02 <= half_x < 0.05`, `sqrt(vel_x*vel_x + vel_y*vel_y)`. Operators by falling precedence: unary `-`
//! (so that `-x ** 2` is `(-x) ** 2`), `**`, `* / %`, `+ -`, comparisons (which chain), `not`, `and`, `or`. Functions: sqrt abs sin
//! cos exp log min max floor.
//!
//! A text is parsed once, into a program over column names (`program.rs`), which then runs on the table of each frame.

mod parse;
mod program;

pub use parse::ExprError;

use frame::{Frame, csv};
use program::{Program, Value};

/// A column's name as an expression: in backticks if it is not of letters, digits and `_` alone, or means something else.
pub fn quoted(column: &str) -> String {
    let is_plain =
        column.chars().all(|c| c.is_alphanumeric() || c == '_') && !column.starts_with(|c: char| c.is_ascii_digit());
    if is_plain && !column.is_empty() && !["and", "or", "not"].contains(&column) {
        column.into()
    } else {
        format!("`{column}`")
    }
}

/// A compiled expression. Its value for a row is a number or a word; conditions are true where the number is not 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Expr {
    /// Text of the expression.
    pub text: String,
    program: Program,
}

impl Expr {
    /// Parse an expression. An error, with its byte in the text, if it is malformed.
    pub fn parse(text: &str) -> Result<Expr, ExprError> {
        Ok(Expr { text: text.into(), program: parse::parse(text)? })
    }

    /// The expression whose value is that of a column; unlike in [`Expr::parse`], the name may have any characters.
    pub fn column(name: &str) -> Expr {
        Expr { text: name.into(), program: Program::column(name) }
    }

    /// Names of the columns that the expression reads, each once, in the order of the text.
    pub fn columns(&self) -> &[String] {
        &self.program.columns
    }

    /// The value of the expression for each of the rows of these indices. An error if the frame lacks a column, or a word that is
    /// not a number stands where a number is needed.
    pub fn numbers(&self, frame: &Frame, rows: &[usize]) -> Result<Vec<f64>, String> {
        let mut run = self.program.run(frame);
        rows.iter()
            .map(|row| match run.row(*row)? {
                Value::Number(x) => Ok(x),
                Value::Word(w) => {
                    csv::number(w).ok_or_else(|| format!("`{}` is the word `{w}`, expected a number", self.text))
                }
            })
            .collect()
    }

    /// Indices of the rows for which the expression is true; a missing value is not. Errors as in [`Expr::numbers`].
    pub fn select(&self, frame: &Frame) -> Result<Vec<usize>, String> {
        let all: Vec<usize> = (0..frame.rows()).collect();
        let truth = self.numbers(frame, &all)?;
        Ok(all.into_iter().filter(|i| truth[*i] != 0.0 && !truth[*i].is_nan()).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use frame::Column;

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
    fn columns_of_any_name_are_read_in_backticks() {
        let mut f = table();
        f.push("Points:0", "m", Column::F64(vec![4.0, 5.0, f64::NAN]));
        f.push("not", "", Column::Category { codes: vec![0, 1, 1], names: vec!["NA".into(), "7".into()] });
        let of = |text: &str| Expr::parse(text).unwrap().numbers(&f, &[0, 1]);
        assert_eq!(of("`Points:0` * 2 + `x`"), Ok(vec![9.0, 12.0]));
        assert_eq!(
            [quoted("Points:0"), quoted("not"), quoted("2d"), quoted("pos_x")],
            ["`Points:0`", "`not`", "`2d`", "pos_x"]
        );
        // A word that stands for no value is a missing number.
        let words = of("`not` + 1").unwrap();
        assert!(words[0].is_nan() && words[1] == 8.0);
        // What is missing is in no comparison, and is no truth.
        assert_eq!(Expr::parse("`Points:0` > 0").unwrap().select(&f), Ok(vec![0, 1]));
        assert_eq!(Expr::parse("`Points:0`").unwrap().select(&f), Ok(vec![0, 1]));
        assert_eq!(Expr::parse("x + `Points").unwrap_err().at, 4);
        assert!(Expr::parse("Points:0").unwrap_err().message.contains("backticks"));
    }

    #[test]
    fn faults_are_placed() {
        for (text, at) in [("x >", 3), ("x + (1", 6), ("sqrtt(x)", 0), ("x = 1", 2), ("kind == 'st", 8), ("", 0)] {
            assert_eq!(Expr::parse(text).unwrap_err().at, at, "{text}");
        }
        assert!(Expr::parse("kind > 3").unwrap().select(&table()).is_err());
    }

    #[test]
    fn what_is_decided_is_not_evaluated() {
        let of = |text: &str| Expr::parse(text).unwrap().numbers(&table(), &[0]);
        assert_eq!(of("x > 5 and nothing > 0"), Ok(vec![0.0]));
        assert_eq!(of("x == 1 or kind > 0"), Ok(vec![1.0]));
        assert_eq!(of("5 < x < nothing"), Ok(vec![0.0]));
        assert_eq!(of("0 < x < 2 <= 2 and not (x == 2 or kind == 'wall')"), Ok(vec![1.0]));
        assert_eq!(of("'3' + x"), Ok(vec![4.0]));
        assert_eq!(of("nothing"), Err("there is no column `nothing`".into()));
        assert_eq!(of("kind + 1"), Err("the word `stone` stands where a number is needed".into()));
        assert_eq!(of("kind"), Err("`kind` is the word `stone`, expected a number".into()));
        assert_eq!(Expr::parse("x + y * x").unwrap().columns(), ["x", "y"]);
    }
}
