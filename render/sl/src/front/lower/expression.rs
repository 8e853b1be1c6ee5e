//! Expressions: operators, casts, triples and matrices.

use super::super::ast::*;
use super::super::diagnostic::{Error, error, error_with};
use super::state::{Lower, Value};
use crate::ir::*;

impl<'a> Lower<'a> {
    pub(super) fn expr(&mut self, e: &Expr, expected: Option<Ty>) -> Result<Value, Error> {
        let at = e.at;
        match &e.kind {
            ExprKind::Number(x) => self.constant(at, *x),
            ExprKind::Text(t) => self.text(at, t),
            ExprKind::Name(name) => self.variable(at, name),
            ExprKind::Unary(op, operand) => {
                let a = match expected {
                    Some(_) => self.operand(operand, expected, expected)?,
                    None => self.expr(operand, None)?,
                };
                let op = if *op == "-" { Unary::Negate } else { Unary::Not };
                if a.ty == Ty::Text || (op == Unary::Not && a.ty != Ty::Float) {
                    return error(at, format!("this operator does not take a {}", a.ty.name()));
                }
                self.temp(at, a.ty, a.varying, |r| Op::Unary(op, r.reg(), a.reg()))
            }
            ExprKind::Binary(op, a, b) => {
                // A bare triple takes the type of what it is combined with.
                let (a, b) = if matches!(a.kind, ExprKind::Triple(_)) {
                    let b = self.expr(b, None)?;
                    (self.expr(a, Some(b.ty))?, b)
                } else {
                    let a = self.operand(a, None, expected)?;
                    let ty = Some(a.ty).filter(|_| matches!(b.kind, ExprKind::Triple(_)));
                    (a, self.operand(b, ty, expected)?)
                };
                self.arithmetic(at, op, a, b)
            }
            ExprKind::Choose(_, a, b) if assigns(a) || assigns(b) => error_with(
                at,
                "an assignment cannot stand in a choice, of which both parts are done",
                "write `if` and `else`",
            ),
            ExprKind::Choose(condition, a, b) => {
                let condition = self.condition(condition)?;
                let (a, b) = (self.expr(a, expected)?, self.expr(b, expected)?);
                if a.ty == Ty::Text && b.ty == Ty::Text {
                    let chosen = self.text(at, "")?;
                    let select = |v: Value| vec![Op::TextCopy(chosen.text(), v.text())];
                    self.push(at, Op::If(condition.float(), select(a), select(b)))?;
                    return Ok(chosen);
                }
                let ty = if a.ty == Ty::Float { b.ty } else { a.ty };
                let (a, b) = (self.convert(at, a, ty)?, self.convert(at, b, ty)?);
                self.temp(at, ty, condition.varying || a.varying || b.varying, |r| {
                    Op::Select(r.reg(), condition.float(), a.reg(), b.reg())
                })
            }
            ExprKind::Triple(parts) => {
                let ty = expected.filter(|t| t.is_triple()).unwrap_or(Ty::Color);
                self.pack(at, ty, &parts[..])
            }
            ExprKind::Matrix(parts) => self.pack(at, Ty::Matrix, parts),
            ExprKind::Array(_) => error(at, "`{…}` stands where an array starts"),
            ExprKind::Assign(target, op, value) => {
                self.assign(at, target, op, value)?;
                self.expr(target, expected)
            }
            ExprKind::Index(of, index) => self.element(at, of, index),
            ExprKind::Cast(ty, space, operand) => self.cast(at, *ty, space.as_deref(), operand),
            ExprKind::Call(name, args) => self.call(at, name, args, expected),
        }
    }

    pub(super) fn pack(&mut self, at: usize, ty: Ty, parts: &[Expr]) -> Result<Value, Error> {
        let mut regs = Vec::with_capacity(parts.len());
        let mut varying = false;
        for part in parts {
            let value = self.expr(part, Some(Ty::Float))?;
            let value = self.convert(part.at, value, Ty::Float)?;
            regs.push(value.float());
            varying |= value.varying;
        }
        self.temp(at, ty, varying, |r| Op::Pack(r.reg(), regs))
    }

    pub(super) fn cast(&mut self, at: usize, ty: Ty, space: Option<&str>, operand: &Expr) -> Result<Value, Error> {
        let value = self.expr(operand, Some(ty))?;
        if ty == Ty::Float && value.ty.is_triple() || (ty == Ty::Text) != (value.ty == Ty::Text) {
            return error(at, format!("a {} cannot be cast to {}", value.ty.name(), ty.name()));
        }
        let value =
            if value.ty.is_triple() && ty.is_triple() { value.taken_as(ty) } else { self.convert(at, value, ty)? };
        let Some(space) = space else { return Ok(value) };
        let how = match ty {
            Ty::Point => Transform::Point,
            Ty::Vector => Transform::Vector,
            Ty::Normal => Transform::Normal,
            Ty::Color if space == "rgb" => return Ok(value),
            Ty::Color => {
                if !crate::shadeop::color::SPACES.contains(&space) {
                    let known = crate::shadeop::color::SPACES.join(", ");
                    return error(at, format!("unknown colour space `{space}`, expected one of {known}"));
                }
                let (from, to) = (self.text(at, space)?, self.text(at, "rgb")?);
                return self.temp(at, ty, value.varying, |r| {
                    Op::ColorSpace(r.triple(), value.triple(), from.text(), to.text(), at as u32)
                });
            }
            Ty::Matrix => Transform::Matrix,
            _ => return error(at, format!("a {} has no space", ty.name())),
        };
        let (from, to) = (self.text(at, space)?, self.text(at, "current")?);
        self.temp(at, ty, value.varying, |r| {
            Op::Transform(how, r.reg(), value.reg(), from.text(), to.text(), at as u32)
        })
    }

    /// Two values to compare: a number beside a triple is one of three such numbers.
    fn alike(&mut self, at: usize, a: Value, b: Value) -> Result<(Value, Value), Error> {
        match (a.ty, b.ty) {
            (Ty::Float, ty) if ty.is_triple() => Ok((self.convert(at, a, ty)?, b)),
            (ty, Ty::Float) if ty.is_triple() => Ok((a, self.convert(at, b, ty)?)),
            _ => Ok((a, b)),
        }
    }

    /// A binary operator.
    pub(super) fn arithmetic(&mut self, at: usize, op: &str, a: Value, b: Value) -> Result<Value, Error> {
        let varying = a.varying || b.varying;
        let refuse = |what: &str| error(at, format!("`{op}` {what}, found {} and {}", a.ty.name(), b.ty.name()));
        if a.ty == Ty::Text || b.ty == Ty::Text {
            if a.ty != b.ty || !matches!(op, "==" | "!=") {
                return refuse("does not take these");
            }
            let same = self.temp(at, Ty::Float, false, |r| Op::TextEqual(r.float(), a.text(), b.text()))?;
            return if op == "==" {
                Ok(same)
            } else {
                self.temp(at, Ty::Float, false, |r| Op::Unary(Unary::Not, r.reg(), same.reg()))
            };
        }
        if a.ty == Ty::Void || b.ty == Ty::Void {
            return refuse("needs values");
        }
        if a.array != 0 || b.array != 0 {
            return refuse("does not take arrays");
        }
        if a.ty == Ty::Matrix || b.ty == Ty::Matrix {
            if a.ty.is_triple() || b.ty.is_triple() {
                return refuse("does not mix a matrix with a triple (see transform)");
            }
            return self.of_matrices(at, op, a, b);
        }
        let (a, b) = if matches!(op, "==" | "!=") { self.alike(at, a, b)? } else { (a, b) };
        let both_triples = a.ty.is_triple() && b.ty.is_triple();
        match op {
            "." | "^" if !both_triples => refuse("takes two vectors"),
            "." => self.temp(at, Ty::Float, varying, |r| Op::Call(Builtin::DOT, r.reg(), vec![a.reg(), b.reg()])),
            "^" => self.temp(at, Ty::Vector, varying, |r| Op::Call(Builtin::CROSS, r.reg(), vec![a.reg(), b.reg()])),
            "+" | "-" | "*" | "/" => {
                if both_triples && (a.ty == Ty::Color) != (b.ty == Ty::Color) {
                    return refuse("does not mix colours with directions");
                }
                let ty = match (a.ty, b.ty) {
                    (Ty::Float, t) => t,
                    (Ty::Point, Ty::Point) if op == "-" => Ty::Vector,
                    (t, _) => t,
                };
                let f = match op {
                    "+" => Binary::Add,
                    "-" => Binary::Sub,
                    "*" => Binary::Mul,
                    _ => Binary::Div,
                };
                self.temp(at, ty, varying, |r| Op::Binary(f, r.reg(), a.reg(), b.reg()))
            }
            "==" | "!=" if both_triples => {
                let equal = self.temp(at, a.ty, varying, |r| Op::Binary(Binary::Equal, r.reg(), a.reg(), b.reg()))?;
                let three = self.constant(at, 2.5)?;
                let sum = self.temp(at, Ty::Float, varying, |r| {
                    Op::Call(Builtin::DOT, r.reg(), vec![equal.reg(), equal.reg()])
                })?;
                let (lo, hi) = if op == "==" { (three, sum) } else { (sum, three) };
                self.temp(at, Ty::Float, varying, |r| Op::Binary(Binary::Less, r.reg(), lo.reg(), hi.reg()))
            }
            _ if a.ty != Ty::Float || b.ty != Ty::Float => refuse("compares two numbers"),
            "!=" => {
                let same =
                    self.temp(at, Ty::Float, varying, |r| Op::Binary(Binary::Equal, r.reg(), a.reg(), b.reg()))?;
                self.temp(at, Ty::Float, varying, |r| Op::Unary(Unary::Not, r.reg(), same.reg()))
            }
            _ => {
                let (f, a, b) = match op {
                    "==" => (Binary::Equal, a, b),
                    "<" => (Binary::Less, a, b),
                    "<=" => (Binary::LessEqual, a, b),
                    ">" => (Binary::Less, b, a),
                    ">=" => (Binary::LessEqual, b, a),
                    "&&" => (Binary::And, a, b),
                    _ => (Binary::Or, a, b),
                };
                self.temp(at, Ty::Float, varying, |r| Op::Binary(f, r.reg(), a.reg(), b.reg()))
            }
        }
    }

    /// A binary operator of two matrices, or of a matrix and a number.
    fn of_matrices(&mut self, at: usize, op: &str, a: Value, b: Value) -> Result<Value, Error> {
        let varying = a.varying || b.varying;
        let found = [a, b].map(|v| v.ty.name());
        let (a, b) = (self.convert(at, a, Ty::Matrix)?, self.convert(at, b, Ty::Matrix)?);
        let f = match op {
            "*" => Builtin::MATRIX_MULTIPLY,
            "/" => Builtin::MATRIX_DIVIDE,
            "==" | "!=" => Builtin::MATRIX_EQUAL,
            "+" | "-" => {
                let f = if op == "+" { Binary::Add } else { Binary::Sub };
                return self.temp(at, Ty::Matrix, varying, |r| Op::Binary(f, r.reg(), a.reg(), b.reg()));
            }
            _ => return error(at, format!("`{op}` does not take matrices, found {} and {}", found[0], found[1])),
        };
        let ty = if f == Builtin::MATRIX_EQUAL { Ty::Float } else { Ty::Matrix };
        let result = self.temp(at, ty, varying, |r| Op::Call(f, r.reg(), vec![a.reg(), b.reg()]))?;
        if op == "!=" {
            return self.temp(at, Ty::Float, varying, |r| Op::Unary(Unary::Not, r.reg(), result.reg()));
        }
        Ok(result)
    }

    /// A number-by-number function of two values, as wide as the wider.
    pub(super) fn componentwise(&mut self, at: usize, f: Binary, a: Value, b: Value) -> Result<Value, Error> {
        let ty = if a.ty == Ty::Float { b.ty } else { a.ty };
        self.temp(at, ty, a.varying || b.varying, |r| Op::Binary(f, r.reg(), a.reg(), b.reg()))
    }

    /// An operand. What is looked up in a map is a colour, unless the whole is to be a number or a place in space: then it is a
    /// number.
    pub(super) fn operand(&mut self, e: &Expr, ty: Option<Ty>, whole: Option<Ty>) -> Result<Value, Error> {
        let number = whole.filter(|t| *t == Ty::Float || (t.is_triple() && *t != Ty::Color));
        match &e.kind {
            ExprKind::Binary(..) | ExprKind::Unary(..) if number.is_some() => self.expr(e, number),
            ExprKind::Call(name, _)
                if number.is_some() && matches!(name.as_str(), "texture" | "environment" | "shadow") =>
            {
                self.expr(e, Some(Ty::Float))
            }
            _ => self.expr(e, ty),
        }
    }
}

/// Whether an expression assigns to a variable.
fn assigns(e: &Expr) -> bool {
    match &e.kind {
        ExprKind::Assign(..) => true,
        ExprKind::Number(_) | ExprKind::Text(_) | ExprKind::Name(_) => false,
        ExprKind::Unary(_, a) | ExprKind::Cast(_, _, a) => assigns(a),
        ExprKind::Binary(_, a, b) | ExprKind::Index(a, b) => assigns(a) || assigns(b),
        ExprKind::Choose(a, b, c) => assigns(a) || assigns(b) || assigns(c),
        ExprKind::Call(_, parts) | ExprKind::Matrix(parts) | ExprKind::Array(parts) => parts.iter().any(assigns),
        ExprKind::Triple(parts) => parts.iter().any(assigns),
    }
}
