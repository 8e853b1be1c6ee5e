//! Conditional RIB: the expressions of `IfBegin` and `ElseIf`.
//!
//! `$Frame`, `$name` or `$group:name` of an option, numbers, strings in single quotes, `defined(name)`, comparisons, `&&`, `||`,
//! `!`, `+ - * /` and brackets. What was never set counts as 0 and as an empty string.

use crate::params::Values;
use std::collections::HashMap;

/// What conditions may ask for.
#[derive(Default)]
pub struct Conditions(HashMap<String, Value>);

#[derive(Clone, Debug, PartialEq)]
enum Value {
    Number(f64),
    Text(String),
}

impl Value {
    fn number(&self) -> f64 {
        match self {
            Value::Number(x) => *x,
            Value::Text(t) => !t.is_empty() as u8 as f64,
        }
    }
}

impl Conditions {
    /// Set a value; its first number or string counts.
    pub fn set(&mut self, name: &str, value: Values) {
        let value = match value {
            Values::Floats(v) => Value::Number(v.first().copied().unwrap_or(0.0) as f64),
            Values::Strings(v) => Value::Text(v.first().cloned().unwrap_or_default()),
        };
        self.0.insert(name.into(), value);
    }

    /// Whether an expression holds.
    pub fn holds(&self, text: &str) -> Result<bool, String> {
        let mut e = Expression { known: self, text, rest: text, depth: 0 };
        let value = e.level(0)?;
        if !e.rest.trim_start().is_empty() {
            return Err(format!("condition `{text}`: unexpected `{}`", e.rest.trim()));
        }
        Ok(value.number() != 0.0)
    }
}

struct Expression<'a> {
    known: &'a Conditions,
    text: &'a str,
    rest: &'a str,
    depth: usize,
}

const LEVELS: &[&[&str]] = &[&["||"], &["&&"], &["==", "!="], &["<=", ">=", "<", ">"], &["+", "-"], &["*", "/"]];

impl Expression<'_> {
    fn eat(&mut self, op: &str) -> bool {
        let rest = self.rest.trim_start().strip_prefix(op);
        self.rest = rest.unwrap_or(self.rest);
        rest.is_some()
    }

    fn level(&mut self, level: usize) -> Result<Value, String> {
        let Some(ops) = LEVELS.get(level) else { return self.operand() };
        let mut a = self.level(level + 1)?;
        while let Some(op) = ops.iter().find(|op| self.eat(op)) {
            let b = self.level(level + 1)?;
            let (x, y) = (a.number(), b.number());
            let truth = |t: bool| t as u8 as f64;
            a = Value::Number(match *op {
                "||" => truth(x != 0.0 || y != 0.0),
                "&&" => truth(x != 0.0 && y != 0.0),
                "==" => truth(a == b),
                "!=" => truth(a != b),
                "<" => truth(x < y),
                "<=" => truth(x <= y),
                ">" => truth(x > y),
                ">=" => truth(x >= y),
                "+" => x + y,
                "-" => x - y,
                "*" => x * y,
                _ => x / y,
            });
        }
        Ok(a)
    }

    fn name(&mut self) -> String {
        let rest = self.rest.trim_start();
        let n = rest.find(|c: char| !(c.is_ascii_alphanumeric() || matches!(c, '_' | ':'))).unwrap_or(rest.len());
        self.rest = &rest[n..];
        rest[..n].into()
    }

    fn operand(&mut self) -> Result<Value, String> {
        self.depth += 1;
        if self.depth > 200 {
            return Err("the condition nests too deep".into());
        }
        let value = self.operand_inner();
        self.depth -= 1;
        value
    }

    fn operand_inner(&mut self) -> Result<Value, String> {
        let wrong = |e: &Self| format!("condition `{}`: expected a value at `{}`", e.text, e.rest.trim());
        if self.eat("!") {
            return Ok(Value::Number((self.operand()?.number() == 0.0) as u8 as f64));
        }
        if self.eat("(") {
            let value = self.level(0)?;
            return if self.eat(")") { Ok(value) } else { Err(wrong(self)) };
        }
        if self.eat("$") {
            let name = self.name();
            let found = self.known.0.get(&name).or_else(|| self.known.0.get(&format!("user:{name}")));
            return Ok(found.cloned().unwrap_or(Value::Number(0.0)));
        }
        if self.eat("'") {
            let (text, after) = self.rest.split_once('\'').ok_or_else(|| wrong(self))?;
            self.rest = after;
            return Ok(Value::Text(text.into()));
        }
        if self.eat("defined") {
            let bracket = self.eat("(");
            self.eat("$");
            let name = self.name();
            if bracket && !self.eat(")") {
                return Err(wrong(self));
            }
            let known = self.known.0.contains_key(&name) || self.known.0.contains_key(&format!("user:{name}"));
            return Ok(Value::Number(known as u8 as f64));
        }
        let rest = self.rest.trim_start();
        let sign = rest.starts_with(['-', '+']) as usize;
        let n = rest[sign..].find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap_or(rest.len() - sign) + sign;
        let x = rest[..n].parse().map_err(|_| wrong(self))?;
        self.rest = &rest[n..];
        Ok(Value::Number(x))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn conditions_hold() {
        let mut known = Conditions::default();
        known.set("Frame", Values::Floats(vec![3.0]));
        known.set("user:pass", Values::Strings(vec!["shadow".into()]));
        for yes in [
            "$Frame == 3",
            "$Frame > 1 && $user:pass == 'shadow'",
            "!defined(none)",
            "defined(pass)",
            "($Frame + 1) * 2 == 8",
            "$pass != 'beauty'",
        ] {
            assert_eq!(known.holds(yes), Ok(true), "{yes}");
        }
        assert_eq!(known.holds("$nothing"), Ok(false));
        for wrong in ["", "1 +", "(1", "1 2", "'open"] {
            assert!(known.holds(wrong).is_err(), "{wrong}");
        }
    }
}
