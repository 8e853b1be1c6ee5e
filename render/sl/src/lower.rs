//! Syntax tree → IR: names are resolved, types checked, user functions inlined.

use crate::ast::*;
use crate::builtins::{Arg, GLOBALS, How, NOT_YET, SIGNATURES, SPECIAL};
use crate::ir::*;
use crate::{Error, error};
use std::collections::HashMap;

/// The most operations of a program: inlining without end is an error, not a full memory.
const MAX_OPS: usize = 100_000;

/// A value: its type and its register (of strings for text), and whether it can differ between points.
#[derive(Clone, Copy, Debug)]
struct Value {
    ty: Ty,
    reg: u16,
    varying: bool,
}

#[derive(Default)]
struct Lower<'a> {
    functions: HashMap<&'a str, &'a Function>,
    calling: Vec<&'a str>,
    scopes: Vec<HashMap<String, Value>>,
    globals: Vec<(String, Reg)>,
    widths: Vec<u8>,
    n_texts: u16,
    ops: Vec<Op>,
    n_ops: usize,
    kind: Option<ShaderKind>,
    directed: bool,
    loops: usize,
}

/// Lower the shader of a file; its functions go before those of the prelude.
pub fn lower(file: &File, prelude: &[Function]) -> Result<Program, Error> {
    let Some(shader) = &file.shader else {
        return error(file.end, "the file has no shader: expected surface, displacement, light …");
    };
    let mut l = Lower { kind: Some(shader.kind), ..Lower::default() };
    for function in prelude.iter().chain(&file.functions) {
        l.functions.insert(&function.name, function);
    }
    if matches!(shader.kind, ShaderKind::Volume | ShaderKind::Imager) {
        return error(0, format!("{} shaders are not supported yet", shader.kind.name()));
    }
    l.scopes.push(HashMap::new());
    let mut params = Vec::new();
    for param in &shader.params {
        params.push(l.parameter(param)?);
    }
    for statement in &shader.body {
        l.statement(statement)?;
    }
    Ok(Program {
        kind: shader.kind,
        name: shader.name.clone(),
        widths: l.widths,
        n_texts: l.n_texts as usize,
        params,
        globals: l.globals,
        body: l.ops,
        is_ambient: shader.kind == ShaderKind::Light && !l.directed,
    })
}

impl<'a> Lower<'a> {
    fn push(&mut self, at: usize, op: Op) -> Result<(), Error> {
        self.n_ops += 1;
        if self.n_ops > MAX_OPS {
            return error(at, format!("the shader has more than {MAX_OPS} operations after inlining"));
        }
        self.ops.push(op);
        Ok(())
    }

    fn reg(&mut self, at: usize, ty: Ty) -> Result<u16, Error> {
        if self.widths.len() + 1 >= u16::MAX as usize || self.n_texts + 1 == u16::MAX {
            return error(at, "the shader has too many values");
        }
        if ty == Ty::Text {
            self.n_texts += 1;
            return Ok(self.n_texts - 1);
        }
        self.widths.push(if ty.is_triple() { 3 } else { 1 });
        Ok(self.widths.len() as u16 - 1)
    }

    /// A new temporary, written by `op(register)`.
    fn temp(&mut self, at: usize, ty: Ty, varying: bool, op: impl FnOnce(u16) -> Op) -> Result<Value, Error> {
        let reg = self.reg(at, ty)?;
        self.push(at, op(reg))?;
        Ok(Value { ty, reg, varying })
    }

    fn constant(&mut self, at: usize, x: f32) -> Result<Value, Error> {
        self.temp(at, Ty::Float, false, |r| Op::Const(r, [x; 3]))
    }

    fn text(&mut self, at: usize, text: &str) -> Result<Value, Error> {
        self.temp(at, Ty::Text, false, |r| Op::TextConst(r, text.into()))
    }

    /// The operations of what `f` lowers, apart from the current block.
    fn block<T>(&mut self, f: impl FnOnce(&mut Self) -> Result<T, Error>) -> Result<(Vec<Op>, T), Error> {
        let outer = std::mem::take(&mut self.ops);
        let result = f(self);
        let inner = std::mem::replace(&mut self.ops, outer);
        Ok((inner, result?))
    }

    fn parameter(&mut self, param: &Variable) -> Result<Parameter, Error> {
        let reg = self.reg(param.at, param.ty)?;
        let var = Value { ty: param.ty, reg, varying: param.varying };
        let Some(value) = &param.value else {
            return error(param.at, format!("parameter `{}` needs a default value", param.name));
        };
        let (default, ()) = self.block(|l| {
            let value = l.expr(value, Some(param.ty))?;
            let value = l.convert(param.at, value, param.ty)?;
            l.store(param.at, var, value)
        })?;
        self.declare(param.at, &param.name, var)?;
        let kind = match param.ty {
            Ty::Float | Ty::Void => Kind::Float,
            Ty::Color => Kind::Color,
            Ty::Point => Kind::Point,
            Ty::Vector => Kind::Vector,
            Ty::Normal => Kind::Normal,
            Ty::Text => Kind::Text,
        };
        Ok(Parameter { name: param.name.clone(), kind, varying: param.varying, reg, default })
    }

    fn declare(&mut self, at: usize, name: &str, value: Value) -> Result<(), Error> {
        let scope = self.scopes.last_mut().expect("a scope is open");
        if scope.insert(name.into(), value).is_some() {
            return error(at, format!("`{name}` is already declared here"));
        }
        Ok(())
    }

    fn global(&mut self, at: usize, name: &str) -> Result<Option<Value>, Error> {
        let Some((_, ty)) = GLOBALS.iter().find(|(n, _)| *n == name) else { return Ok(None) };
        if let Some((_, reg)) = self.globals.iter().find(|(n, _)| n == name) {
            return Ok(Some(Value { ty: *ty, reg: *reg, varying: true }));
        }
        let reg = self.reg(at, *ty)?;
        self.globals.push((name.into(), reg));
        Ok(Some(Value { ty: *ty, reg, varying: true }))
    }

    fn variable(&mut self, at: usize, name: &str) -> Result<Value, Error> {
        if let Some(value) = self.scopes.iter().rev().find_map(|s| s.get(name)) {
            return Ok(*value);
        }
        if let Some(value) = self.global(at, name)? {
            return Ok(value);
        }
        if name == "dPdu" || name == "dPdv" {
            let p = self.variable(at, "P")?;
            return self.derivative(at, if name == "dPdu" { Builtin::Du } else { Builtin::Dv }, p);
        }
        if name == "PI" {
            return self.constant(at, std::f32::consts::PI);
        }
        let locals = self.scopes.iter().flat_map(|s| s.keys().map(String::as_str));
        let near = nearest(name, locals.chain(GLOBALS.iter().map(|(n, _)| *n)));
        error(at, format!("unknown variable `{name}`{near}"))
    }

    /// Store a value of the variable's own type.
    fn store(&mut self, at: usize, var: Value, value: Value) -> Result<(), Error> {
        if var.ty == Ty::Text {
            return self.push(at, Op::TextCopy(var.reg, value.reg));
        }
        self.push(at, Op::Assign(var.reg, value.reg))
    }

    /// A value as another type: a number as any triple, a point as a vector or normal and back.
    fn convert(&mut self, at: usize, value: Value, to: Ty) -> Result<Value, Error> {
        let spatial = |t: Ty| t.is_triple() && t != Ty::Color;
        if value.ty == to || (spatial(value.ty) && spatial(to)) {
            return Ok(Value { ty: to, ..value });
        }
        if value.ty == Ty::Float && to.is_triple() {
            return self.temp(at, to, value.varying, |r| Op::Unary(Unary::Copy, r, value.reg));
        }
        error(at, format!("expected {}, found {}", to.name(), value.ty.name()))
    }

    fn statement(&mut self, s: &'a Stmt) -> Result<(), Error> {
        let at = s.at;
        match &s.kind {
            StmtKind::Declare(variables) => variables.iter().try_for_each(|v| self.local(v)),
            StmtKind::Assign(name, op, value) => self.assign(at, name, op, value),
            StmtKind::Call(call) => self.expr(call, None).map(|_| ()),
            StmtKind::Block(body) => self.scoped(body),
            StmtKind::If(condition, then, otherwise) => {
                let condition = self.condition(condition)?;
                let (then, ()) = self.block(|l| l.scoped(std::slice::from_ref(then)))?;
                let (otherwise, ()) =
                    self.block(|l| otherwise.iter().try_for_each(|o| l.scoped(std::slice::from_ref(o))))?;
                self.push(at, Op::If(condition.reg, then, otherwise))
            }
            StmtKind::While(condition, body) => self.repeat(at, condition, body, None),
            StmtKind::For(start, condition, step, body) => {
                self.statement(start)?;
                self.repeat(at, condition, body, Some(step))
            }
            StmtKind::Break | StmtKind::Continue if self.loops == 0 => {
                error(at, "break and continue stand inside a loop")
            }
            StmtKind::Break => self.push(at, Op::Break),
            StmtKind::Continue => self.push(at, Op::Continue),
            StmtKind::Return(_) => {
                error(at, "`return` stands at the end of a function; elsewhere it is not supported yet")
            }
            StmtKind::Light(which, args, body) => self.light(at, which, args, body),
        }
    }

    fn scoped(&mut self, body: &'a [Stmt]) -> Result<(), Error> {
        self.scopes.push(HashMap::new());
        let done = body.iter().try_for_each(|s| self.statement(s));
        self.scopes.pop();
        done
    }

    fn local(&mut self, v: &Variable) -> Result<(), Error> {
        let reg = self.reg(v.at, v.ty)?;
        let var = Value { ty: v.ty, reg, varying: v.varying };
        let value = match &v.value {
            Some(value) => self.expr(value, Some(v.ty))?,
            None if v.ty == Ty::Text => self.text(v.at, "")?,
            None => self.constant(v.at, 0.0)?,
        };
        let value = self.convert(v.at, value, v.ty)?;
        self.check_class(v.at, &v.name, var, value)?;
        // A declaration inside a loop starts afresh at every turn, so it is stored and not only defined.
        self.store(v.at, var, value)?;
        self.declare(v.at, &v.name, var)
    }

    fn check_class(&self, at: usize, name: &str, var: Value, value: Value) -> Result<(), Error> {
        if value.varying && !var.varying {
            return error(at, format!("a varying value cannot be assigned to the uniform variable `{name}`"));
        }
        Ok(())
    }

    fn assign(&mut self, at: usize, name: &str, op: &str, value: &Expr) -> Result<(), Error> {
        let var = self.variable(at, name)?;
        let mut value = self.expr(value, Some(var.ty))?;
        if op != "=" {
            let op = ["+", "-", "*", "/"].into_iter().find(|o| op.starts_with(o)).unwrap_or("+");
            value = self.arithmetic(at, op, var, value)?;
        }
        let value = self.convert(at, value, var.ty)?;
        self.check_class(at, name, var, value)?;
        self.store(at, var, value)
    }

    fn condition(&mut self, e: &Expr) -> Result<Value, Error> {
        let value = self.expr(e, Some(Ty::Float))?;
        if value.ty == Ty::Float {
            Ok(value)
        } else {
            error(e.at, format!("expected a condition, found {}", value.ty.name()))
        }
    }

    fn repeat(&mut self, at: usize, condition: &Expr, body: &'a Stmt, step: Option<&'a Stmt>) -> Result<(), Error> {
        let (head, condition) = self.block(|l| l.condition(condition))?;
        self.loops += 1;
        let body = self.block(|l| l.scoped(std::slice::from_ref(body)));
        self.loops -= 1;
        let (step, ()) = self.block(|l| step.map_or(Ok(()), |s| l.statement(s)))?;
        self.push(at, Op::Loop(head, condition.reg, body?.0, step))
    }

    fn light(&mut self, at: usize, which: &str, args: &[Expr], body: &'a Stmt) -> Result<(), Error> {
        let in_light = self.kind == Some(ShaderKind::Light);
        if in_light == (which == "illuminance") {
            let place = if in_light { "cannot stand in a light shader" } else { "stands in light shaders only" };
            return error(at, format!("`{which}` {place}"));
        }
        let mut values = Vec::new();
        for arg in args {
            values.push(self.expr(arg, None)?);
        }
        let l = self.global(at, "L")?.expect("L is a global").reg;
        let types: Vec<Ty> = values.iter().map(|v| v.ty).collect();
        let spatial = |i: usize| types.get(i).is_some_and(|t| t.is_triple());
        let angle = |i: usize| types.get(i) == Some(&Ty::Float);
        let (pi, zero) = (self.constant(at, std::f32::consts::PI)?, self.constant(at, 0.0)?);
        let nowhere = self.convert(at, zero, Ty::Vector)?;
        if which == "solar" {
            self.directed = true;
            let args = match types.len() {
                0 => [nowhere.reg, pi.reg],
                2 if spatial(0) && angle(1) => [values[0].reg, values[1].reg],
                _ => return error(at, "expected solar() or solar(axis, angle)"),
            };
            let (body, ()) = self.block(|l| l.scoped(std::slice::from_ref(body)))?;
            return self.push(at, Op::Solar { args, l, body });
        }
        let args = match types.len() {
            1 if spatial(0) => [values[0].reg, nowhere.reg, pi.reg],
            3 if spatial(0) && spatial(1) && angle(2) => [values[0].reg, values[1].reg, values[2].reg],
            _ => return error(at, format!("expected {which}(position) or {which}(position, axis, angle)")),
        };
        if which == "illuminate" {
            self.directed = true;
            let ps = self.global(at, "Ps")?.expect("Ps is a global").reg;
            let (body, ()) = self.block(|l| l.scoped(std::slice::from_ref(body)))?;
            return self.push(at, Op::Illuminate { args, l, ps, body });
        }
        let cl = self.global(at, "Cl")?.expect("Cl is a global").reg;
        let (body, ()) = self.block(|l| l.scoped(std::slice::from_ref(body)))?;
        self.push(at, Op::Illuminance { args, l, cl, body })
    }

    fn expr(&mut self, e: &Expr, expected: Option<Ty>) -> Result<Value, Error> {
        let at = e.at;
        match &e.kind {
            ExprKind::Number(x) => self.constant(at, *x),
            ExprKind::Text(t) => self.text(at, t),
            ExprKind::Name(name) => self.variable(at, name),
            ExprKind::Unary(op, operand) => {
                let a = self.expr(operand, expected)?;
                let op = if *op == "-" { Unary::Negate } else { Unary::Not };
                if a.ty == Ty::Text || (op == Unary::Not && a.ty != Ty::Float) {
                    return error(at, format!("this operator does not take a {}", a.ty.name()));
                }
                self.temp(at, a.ty, a.varying, |r| Op::Unary(op, r, a.reg))
            }
            ExprKind::Binary(op, a, b) => {
                // A bare triple takes the type of what it is combined with.
                let (a, b) = if matches!(a.kind, ExprKind::Triple(_)) {
                    let b = self.expr(b, None)?;
                    (self.expr(a, Some(b.ty))?, b)
                } else {
                    let a = self.expr(a, None)?;
                    (a, self.expr(b, Some(a.ty).filter(|_| matches!(b.kind, ExprKind::Triple(_))))?)
                };
                self.arithmetic(at, op, a, b)
            }
            ExprKind::Choose(condition, a, b) => {
                let condition = self.condition(condition)?;
                let (a, b) = (self.expr(a, expected)?, self.expr(b, expected)?);
                if a.ty == Ty::Text || b.ty == Ty::Text {
                    return error(at, "a choice between strings is not supported yet");
                }
                let ty = if a.ty == Ty::Float { b.ty } else { a.ty };
                let (a, b) = (self.convert(at, a, ty)?, self.convert(at, b, ty)?);
                self.temp(at, ty, condition.varying || a.varying || b.varying, |r| {
                    Op::Select(r, condition.reg, a.reg, b.reg)
                })
            }
            ExprKind::Triple(parts) => {
                let mut regs = [0; 3];
                let mut varying = false;
                for (reg, part) in regs.iter_mut().zip(parts.iter()) {
                    let value = self.expr(part, Some(Ty::Float))?;
                    let value = self.convert(part.at, value, Ty::Float)?;
                    (*reg, varying) = (value.reg, varying || value.varying);
                }
                let ty = expected.filter(|t| t.is_triple()).unwrap_or(Ty::Color);
                self.temp(at, ty, varying, |r| Op::Pack(r, regs))
            }
            ExprKind::Cast(ty, space, operand) => self.cast(at, *ty, space.as_deref(), operand),
            ExprKind::Call(name, args) => self.call(at, name, args, expected),
        }
    }

    fn cast(&mut self, at: usize, ty: Ty, space: Option<&str>, operand: &Expr) -> Result<Value, Error> {
        let value = self.expr(operand, Some(ty))?;
        if ty == Ty::Float && value.ty.is_triple() || (ty == Ty::Text) != (value.ty == Ty::Text) {
            return error(at, format!("a {} cannot be cast to {}", value.ty.name(), ty.name()));
        }
        let value =
            if value.ty.is_triple() && ty.is_triple() { Value { ty, ..value } } else { self.convert(at, value, ty)? };
        let Some(space) = space else { return Ok(value) };
        let how = match ty {
            Ty::Point => Transform::Point,
            Ty::Vector => Transform::Vector,
            Ty::Normal => Transform::Normal,
            Ty::Color if space == "rgb" => return Ok(value),
            Ty::Color => return error(at, format!("colour space `{space}` is not supported yet")),
            _ => return error(at, format!("a {} has no space", ty.name())),
        };
        let (from, to) = (self.text(at, space)?, self.text(at, "current")?);
        self.temp(at, ty, value.varying, |r| Op::Transform(how, r, value.reg, from.reg, to.reg))
    }

    fn arithmetic(&mut self, at: usize, op: &str, a: Value, b: Value) -> Result<Value, Error> {
        let varying = a.varying || b.varying;
        let refuse = |what: &str| error(at, format!("`{op}` {what}, found {} and {}", a.ty.name(), b.ty.name()));
        if a.ty == Ty::Text || b.ty == Ty::Text {
            if a.ty != b.ty || !matches!(op, "==" | "!=") {
                return refuse("does not take these");
            }
            let same = self.temp(at, Ty::Float, false, |r| Op::TextEqual(r, a.reg, b.reg))?;
            return if op == "==" {
                Ok(same)
            } else {
                self.temp(at, Ty::Float, false, |r| Op::Unary(Unary::Not, r, same.reg))
            };
        }
        if a.ty == Ty::Void || b.ty == Ty::Void {
            return refuse("needs values");
        }
        let both_triples = a.ty.is_triple() && b.ty.is_triple();
        match op {
            "." | "^" if !both_triples => refuse("takes two vectors"),
            "." => self.temp(at, Ty::Float, varying, |r| Op::Call(Builtin::Dot, r, vec![a.reg, b.reg])),
            "^" => self.temp(at, Ty::Vector, varying, |r| Op::Call(Builtin::Cross, r, vec![a.reg, b.reg])),
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
                self.temp(at, ty, varying, |r| Op::Binary(f, r, a.reg, b.reg))
            }
            "==" | "!=" if both_triples => {
                let equal = self.temp(at, a.ty, varying, |r| Op::Binary(Binary::Equal, r, a.reg, b.reg))?;
                let three = self.constant(at, 2.5)?;
                let sum =
                    self.temp(at, Ty::Float, varying, |r| Op::Call(Builtin::Dot, r, vec![equal.reg, equal.reg]))?;
                let (lo, hi) = if op == "==" { (three, sum) } else { (sum, three) };
                self.temp(at, Ty::Float, varying, |r| Op::Binary(Binary::Less, r, lo.reg, hi.reg))
            }
            _ if a.ty != Ty::Float || b.ty != Ty::Float => refuse("compares two numbers"),
            "!=" => {
                let same = self.temp(at, Ty::Float, varying, |r| Op::Binary(Binary::Equal, r, a.reg, b.reg))?;
                self.temp(at, Ty::Float, varying, |r| Op::Unary(Unary::Not, r, same.reg))
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
                self.temp(at, Ty::Float, varying, |r| Op::Binary(f, r, a.reg, b.reg))
            }
        }
    }

    fn call(&mut self, at: usize, name: &str, args: &[Expr], expected: Option<Ty>) -> Result<Value, Error> {
        if let Some(function) = self.functions.get(name).copied() {
            return self.inline(at, function, args);
        }
        let overloads: Vec<_> = SIGNATURES.iter().filter(|s| s.0 == name).collect();
        if overloads.is_empty() && !SPECIAL.contains(&name) {
            if NOT_YET.contains(&name) {
                return error(at, format!("`{name}` is not supported yet"));
            }
            let known =
                self.functions.keys().copied().chain(SIGNATURES.iter().map(|s| s.0)).chain(SPECIAL.iter().copied());
            return error(at, format!("unknown function `{name}`{}", nearest(name, known)));
        }
        let mut values = Vec::new();
        for (i, arg) in args.iter().enumerate() {
            let hint = match overloads.first().and_then(|s| s.2.get(i)) {
                Some(Arg::Float) => Some(Ty::Float),
                Some(Arg::Triple) => Some(Ty::Vector),
                Some(Arg::Any) => expected,
                None if matches!(name, "clamp" | "mix") && i < 2 => expected,
                None => None,
            };
            values.push(self.expr(arg, hint)?);
        }
        if overloads.is_empty() {
            return self.special(at, name, &values, expected);
        }
        let fits = |s: &&&(&str, Option<Ty>, &[Arg], How)| {
            s.2.len() == values.len()
                && s.2.iter().zip(&values).all(|(arg, v)| match arg {
                    Arg::Float => v.ty == Ty::Float,
                    Arg::Triple => v.ty.is_triple(),
                    Arg::Any => v.ty == Ty::Float || v.ty.is_triple(),
                })
        };
        // min and max of more than two are taken two at a time.
        if matches!(name, "min" | "max") && values.len() > 2 {
            let f = if name == "min" { Binary::Min } else { Binary::Max };
            let mut result = values[0];
            for value in &values[1..] {
                result = self.componentwise(at, f, result, *value)?;
            }
            return Ok(result);
        }
        let Some((_, ret, _, how)) = overloads.iter().find(fits) else {
            let found: Vec<&str> = values.iter().map(|v| v.ty.name()).collect();
            let takes: Vec<String> = overloads.iter().map(|s| signature(name, s.2)).collect();
            return error(at, format!("expected {}, found {name}({})", takes.join(" or "), found.join(", ")));
        };
        let varying =
            matches!(name, "ambient" | "transmission" | "area" | "calculatenormal") || values.iter().any(|v| v.varying);
        let ret = ret.or(values.first().map(|v| v.ty)).unwrap_or(Ty::Float);
        match how {
            How::Unary(f) => self.temp(at, ret, varying, |r| Op::Unary(*f, r, values[0].reg)),
            How::Binary(f) => self.componentwise(at, *f, values[0], values[1]),
            How::Component(c) => self.temp(at, ret, varying, |r| Op::Component(r, values[0].reg, *c)),
            How::Call(f) => self.temp(at, ret, varying, |r| Op::Call(*f, r, values.iter().map(|v| v.reg).collect())),
        }
    }

    /// A number-by-number function of two values, as wide as the wider.
    fn componentwise(&mut self, at: usize, f: Binary, a: Value, b: Value) -> Result<Value, Error> {
        let ty = if a.ty == Ty::Float { b.ty } else { a.ty };
        self.temp(at, ty, a.varying || b.varying, |r| Op::Binary(f, r, a.reg, b.reg))
    }

    fn special(&mut self, at: usize, name: &str, v: &[Value], expected: Option<Ty>) -> Result<Value, Error> {
        let varying = v.iter().any(|v| v.varying);
        let regs: Vec<u16> = v.iter().map(|v| v.reg).collect();
        let types: Vec<Ty> = v.iter().map(|v| v.ty).collect();
        let usage = |text: &str| error(at, format!("expected {text}"));
        match (name, types.as_slice()) {
            ("noise" | "cellnoise", [Ty::Float] | [Ty::Float, Ty::Float])
            | ("noise" | "cellnoise", [Ty::Point | Ty::Vector | Ty::Normal | Ty::Color]) => {
                let f = if name == "noise" { Builtin::Noise } else { Builtin::CellNoise };
                let ty = expected.filter(|t| t.is_triple()).unwrap_or(Ty::Float);
                self.temp(at, ty, varying, |r| Op::Call(f, r, regs))
            }
            ("noise" | "cellnoise", _) => usage(&format!("{name}(float), {name}(float, float) or {name}(point)")),
            ("mix", [a, b, Ty::Float]) if a == b || (a.is_triple() && b.is_triple()) => {
                self.temp(at, *a, varying, |r| Op::Call(Builtin::Mix, r, regs))
            }
            ("mix", [a, b, Ty::Float]) if *a != Ty::Text && *b != Ty::Text => {
                let ty = if *a == Ty::Float { *b } else { *a };
                let (a, b) = (self.convert(at, v[0], ty)?, self.convert(at, v[1], ty)?);
                self.temp(at, ty, varying, |r| Op::Call(Builtin::Mix, r, vec![a.reg, b.reg, regs[2]]))
            }
            ("mix", _) => usage("mix(a, b, float)"),
            ("clamp", [a, lo, hi]) if [a, lo, hi].iter().all(|t| **t != Ty::Text) => {
                let low = self.componentwise(at, Binary::Max, v[0], v[1])?;
                self.componentwise(at, Binary::Min, low, v[2])
            }
            ("clamp", _) => usage("clamp(value, low, high)"),
            ("faceforward", [n, i]) if n.is_triple() && i.is_triple() => self
                .temp(at, Ty::Normal, varying, |r| Op::Call(Builtin::FaceForward, r, vec![regs[0], regs[1], regs[0]])),
            ("faceforward", [n, i, reference]) if [n, i, reference].iter().all(|t| t.is_triple()) => {
                self.temp(at, Ty::Normal, varying, |r| Op::Call(Builtin::FaceForward, r, regs))
            }
            ("faceforward", _) => usage("faceforward(N, I) or faceforward(N, I, Nref)"),
            ("Du" | "Dv", [t]) if *t != Ty::Text => {
                let f = if name == "Du" { Builtin::Du } else { Builtin::Dv };
                self.derivative(at, f, v[0])
            }
            ("Deriv", [a, Ty::Float]) if *a != Ty::Text => {
                let (au, bu) = (self.derivative(at, Builtin::Du, v[0])?, self.derivative(at, Builtin::Du, v[1])?);
                let (av, bv) = (self.derivative(at, Builtin::Dv, v[0])?, self.derivative(at, Builtin::Dv, v[1])?);
                let (u, w) = (self.arithmetic(at, "/", au, bu)?, self.arithmetic(at, "/", av, bv)?);
                self.arithmetic(at, "+", u, w)
            }
            ("Du" | "Dv" | "Deriv", _) => usage(&format!("{name} of numbers or triples")),
            ("comp", [t, Ty::Float]) if t.is_triple() => {
                let Some(Op::Const(_, [i, ..])) =
                    self.ops.iter().find(|op| matches!(op, Op::Const(r, _) if *r == regs[1]))
                else {
                    return error(at, "the index of `comp` must be 0, 1 or 2");
                };
                let i = *i;
                if !(0.0..3.0).contains(&i) {
                    return error(at, "the index of `comp` must be 0, 1 or 2");
                }
                self.temp(at, Ty::Float, varying, |r| Op::Component(r, regs[0], i as u8))
            }
            ("transform" | "vtransform" | "ntransform", _) => {
                let (how, ty) = match name {
                    "transform" => (Transform::Point, Ty::Point),
                    "vtransform" => (Transform::Vector, Ty::Vector),
                    _ => (Transform::Normal, Ty::Normal),
                };
                let (from, to, operand) = match types.as_slice() {
                    [Ty::Text, t] if t.is_triple() => (self.text(at, "current")?.reg, regs[0], regs[1]),
                    [Ty::Text, Ty::Text, t] if t.is_triple() => (regs[0], regs[1], regs[2]),
                    _ => return usage(&format!("{name}(to, value) or {name}(from, to, value)")),
                };
                self.temp(at, ty, varying, |r| Op::Transform(how, r, operand, from, to))
            }
            _ => usage(&format!("other arguments of `{name}`")),
        }
    }

    fn derivative(&mut self, at: usize, f: Builtin, x: Value) -> Result<Value, Error> {
        let (u, v) =
            (self.global(at, "u")?.expect("u is a global").reg, self.global(at, "v")?.expect("v is a global").reg);
        let ty = if x.ty == Ty::Point { Ty::Vector } else { x.ty };
        self.temp(at, ty, true, |r| Op::Call(f, r, vec![x.reg, u, v]))
    }

    /// A user function's body in place of its call.
    fn inline(&mut self, at: usize, function: &'a Function, args: &[Expr]) -> Result<Value, Error> {
        if self.calling.contains(&function.name.as_str()) {
            return error(
                at,
                format!("`{}` calls itself: recursion is an error in the shading language", function.name),
            );
        }
        if args.len() != function.params.len() {
            let message =
                format!("`{}` takes {} arguments, found {}", function.name, function.params.len(), args.len());
            return error(at, message);
        }
        let mut inner = HashMap::new();
        let mut outputs = Vec::new();
        for (param, arg) in function.params.iter().zip(args) {
            let value = self.expr(arg, Some(param.ty))?;
            let value = self.convert(arg.at, value, param.ty)?;
            let var = Value { ty: param.ty, reg: self.reg(at, param.ty)?, varying: true };
            self.store(at, var, value)?;
            if param.output {
                let ExprKind::Name(target) = &arg.kind else {
                    return error(arg.at, format!("`{}` is an output: expected a variable", param.name));
                };
                outputs.push((self.variable(arg.at, target)?, var));
            }
            inner.insert(param.name.clone(), var);
        }
        let outer = std::mem::replace(&mut self.scopes, vec![inner]);
        self.calling.push(&function.name);
        let result = self.function_body(at, function);
        self.calling.pop();
        self.scopes = outer;
        let result = result?;
        for (target, var) in outputs {
            self.store(at, target, var)?;
        }
        Ok(result)
    }

    fn function_body(&mut self, at: usize, function: &'a Function) -> Result<Value, Error> {
        let (last, before) = match function.body.split_last() {
            Some((last, before)) if matches!(last.kind, StmtKind::Return(_)) => (Some(last), before),
            _ => (None, function.body.as_slice()),
        };
        for statement in before {
            self.statement(statement)?;
        }
        match last.map(|s| (&s.kind, s.at)) {
            Some((StmtKind::Return(Some(value)), place)) => {
                let value = self.expr(value, Some(function.ret))?;
                self.convert(place, value, function.ret)
            }
            _ if function.ret == Ty::Void => Ok(Value { ty: Ty::Void, reg: 0, varying: false }),
            _ => error(at, format!("`{}` must end with `return`", function.name)),
        }
    }
}

/// `name(float, triple …)`, for messages.
fn signature(name: &str, args: &[Arg]) -> String {
    let list: Vec<&str> = args
        .iter()
        .map(|a| match a {
            Arg::Float => "float",
            Arg::Triple => "a triple",
            Arg::Any => "float or a triple",
        })
        .collect();
    format!("{name}({})", list.join(", "))
}

/// `, did you mean …?` with the candidate nearest in spelling, or nothing.
fn nearest<'n>(name: &str, candidates: impl Iterator<Item = &'n str>) -> String {
    candidates
        .map(|c| (strsim::damerau_levenshtein(name, c), c))
        .filter(|(d, c)| *d <= 1 + c.len() / 4)
        .min()
        .map_or(String::new(), |(_, c)| format!(", did you mean `{c}`?"))
}
