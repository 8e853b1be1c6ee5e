//! Syntax tree → IR: names are resolved, types checked, user functions inlined.

use crate::ast::*;
use crate::builtins::{Arg, GLOBALS, How, SIGNATURES, SPECIAL};
use crate::ir::*;
use crate::{Error, error, error_with};
use std::collections::HashMap;

/// The most operations of a program: inlining without end is an error, not a full memory.
const MAX_OPS: usize = 100_000;

/// A value: its type and its register (of strings for text), and whether it can differ between points.
#[derive(Clone, Copy, Debug)]
struct Value {
    ty: Ty,
    reg: u16,
    varying: bool,
    /// Elements of an array, whose registers follow each other; 0 of a single value.
    array: u16,
    /// Declared uniform.
    fixed: bool,
}

impl Value {
    fn of(ty: Ty, reg: u16, varying: bool) -> Value {
        Value { ty, reg, varying, array: 0, fixed: false }
    }

    fn operand(self) -> Operand {
        if self.ty == Ty::Text { Operand::Text(self.reg) } else { Operand::Number(self.reg) }
    }
}

#[derive(Default)]
struct Lower<'a> {
    functions: HashMap<&'a str, &'a Function>,
    calling: Vec<&'a str>,
    scopes: Vec<HashMap<String, Value>>,
    /// The scopes around the functions that are being inlined.
    outer: Vec<Vec<HashMap<String, Value>>>,
    /// Where the result of each of them goes; none while `return` stands at the end alone.
    results: Vec<Option<Value>>,
    globals: Vec<(String, Reg)>,
    widths: Vec<u8>,
    n_texts: u16,
    ops: Vec<Op>,
    n_ops: usize,
    /// What is lowered goes to a uniform variable.
    for_uniform: bool,
    kind: Option<ShaderKind>,
    directed: bool,
    loops: usize,
}

/// Lower the shader of a file; its functions go before those of the prelude.
pub fn lower(file: &File, prelude: &[Function]) -> Result<Program, Error> {
    let Some(shader) = &file.shader else {
        let hint = "a file of functions alone is for `#include`";
        return error_with(file.end, "the file has no shader: expected surface, displacement, light …", hint);
    };
    let mut l = Lower { kind: Some(shader.kind), ..Lower::default() };
    for function in prelude.iter().chain(&file.functions) {
        l.functions.insert(&function.name, function);
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
        keeps_opacity: false,
        reads_neighbours: true,
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
        self.widths.push(if ty == Ty::Matrix {
            16
        } else if ty.is_triple() {
            3
        } else {
            1
        });
        Ok(self.widths.len() as u16 - 1)
    }

    /// A new temporary, written by `op(register)`.
    fn temp(&mut self, at: usize, ty: Ty, varying: bool, op: impl FnOnce(u16) -> Op) -> Result<Value, Error> {
        let reg = self.reg(at, ty)?;
        self.push(at, op(reg))?;
        Ok(Value::of(ty, reg, varying))
    }

    fn constant(&mut self, at: usize, x: f32) -> Result<Value, Error> {
        self.temp(at, Ty::Float, false, |r| Op::Const(r, x))
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
        if param.value.is_none() && param.array.is_none() {
            let hint = format!("write `{} = …`", param.name);
            return error_with(param.at, format!("parameter `{}` needs a default value", param.name), hint);
        }
        let var = self.new_variable(param)?;
        let (default, ()) = self.block(|l| l.start(param, var))?;
        self.declare(param.at, &param.name, var)?;
        let kind = match param.ty {
            Ty::Float | Ty::Void => Kind::Float,
            Ty::Color => Kind::Color,
            Ty::Point => Kind::Point,
            Ty::Vector => Kind::Vector,
            Ty::Normal => Kind::Normal,
            Ty::Matrix => Kind::Matrix,
            Ty::Text => Kind::Text,
        };
        let array = param.array.map(|_| var.array);
        let (name, varying, output) = (param.name.clone(), param.varying, param.output);
        Ok(Parameter { name, kind, varying, output, array, reg: var.reg, default })
    }

    /// Registers of a variable.
    fn new_variable(&mut self, v: &Variable) -> Result<Value, Error> {
        let reg = self.reg(v.at, v.ty)?;
        for _ in 1..v.array.unwrap_or(1) {
            self.reg(v.at, v.ty)?;
        }
        // What a function's own variables hold hangs on what it is called with.
        let varying = v.varying && self.calling.is_empty();
        Ok(Value {
            ty: v.ty,
            reg,
            varying,
            array: v.array.map_or(0, |n| n.max(1) as u16),
            fixed: !v.varying && !v.output,
        })
    }

    /// Store what a variable starts with.
    fn start(&mut self, v: &Variable, var: Value) -> Result<(), Error> {
        let element = |k: u16| Value { reg: var.reg + k, array: 0, ..var };
        let zero = |l: &mut Self| if v.ty == Ty::Text { l.text(v.at, "") } else { l.constant(v.at, 0.0) };
        match &v.value {
            Some(Expr { kind: ExprKind::Array(values), at }) if v.array.is_some() => {
                if values.len() > var.array as usize {
                    return error(*at, format!("{} values for an array of {}", values.len(), var.array));
                }
                for k in 0..var.array {
                    let value = match values.get(k as usize) {
                        Some(value) => self.expr(value, Some(v.ty))?,
                        None => zero(self)?,
                    };
                    let value = self.convert(v.at, value, v.ty)?;
                    self.store(v.at, element(k), value)?;
                }
                Ok(())
            }
            Some(value) if v.array.is_none() => {
                let found = self.value_for(var, value)?;
                let value = self.convert(value.at, found, v.ty)?;
                self.check_class(v.at, &v.name, var, value)?;
                // A declaration inside a loop starts afresh at every turn, so it is stored and not only defined.
                self.store(v.at, var, value)
            }
            Some(value) => {
                let found = self.expr(value, Some(v.ty))?;
                if found.array != 0 {
                    return self.copy_array(value.at, var, found);
                }
                // One value fills the array.
                let found = self.convert(value.at, found, v.ty)?;
                (0..var.array).try_for_each(|k| self.store(v.at, element(k), found))
            }
            None => {
                let value = zero(self)?;
                let value = self.convert(v.at, value, v.ty)?;
                (0..var.array.max(1)).try_for_each(|k| self.store(v.at, element(k), value))
            }
        }
    }

    fn copy_array(&mut self, at: usize, to: Value, from: Value) -> Result<(), Error> {
        if to.array != from.array || to.ty != from.ty {
            let show = |v: Value| format!("{}[{}]", v.ty.name(), v.array);
            return error(at, format!("expected {}, found {}", show(to), show(from)));
        }
        let element = |v: Value, k: u16| Value { reg: v.reg + k, array: 0, ..v };
        (0..to.array).try_for_each(|k| self.store(at, element(to, k), element(from, k)))
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
            return Ok(Some(Value::of(*ty, *reg, true)));
        }
        let reg = self.reg(at, *ty)?;
        self.globals.push((name.into(), reg));
        Ok(Some(Value::of(*ty, reg, true)))
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
        if name == "du" || name == "dv" {
            let x = self.variable(at, if name == "du" { "u" } else { "v" })?;
            return self.temp(at, Ty::Float, true, |r| Op::Call(Builtin::Width, r, vec![x.reg]));
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
        if value.array != 0 {
            return error(at, format!("expected {}, found an array: which element?", to.name()));
        }
        let spatial = |t: Ty| t.is_triple() && t != Ty::Color;
        if value.ty == Ty::Float && to == Ty::Matrix {
            return self.temp(at, to, value.varying, |r| Op::Call(Builtin::Diagonal, r, vec![value.reg]));
        }
        if value.ty == to || (spatial(value.ty) && spatial(to)) {
            return Ok(Value { ty: to, ..value });
        }
        if value.ty == Ty::Float && to.is_triple() {
            return self.temp(at, to, value.varying, |r| Op::Unary(Unary::Copy, r, value.reg));
        }
        let message = format!("expected {}, found {}", to.name(), value.ty.name());
        match (value.ty, to) {
            (Ty::Color, Ty::Float) => error_with(at, message, "`comp(c, 0)` is the first component of a colour"),
            (from, Ty::Float) if spatial(from) => {
                error_with(at, message, "`xcomp(p)` is a component, `length(v)` the length of a vector")
            }
            (from, Ty::Color) if spatial(from) => {
                error_with(at, message, "`color(p)` takes its components for a colour")
            }
            (Ty::Color, to) if spatial(to) => {
                error_with(at, message, format!("`{}(c)` takes its components", to.name()))
            }
            (Ty::Text, _) => error_with(at, message, "a string is no number and becomes none"),
            _ => error(at, message),
        }
    }

    fn statement(&mut self, s: &'a Stmt) -> Result<(), Error> {
        let at = s.at;
        match &s.kind {
            StmtKind::Declare(variables) => variables.iter().try_for_each(|v| self.local(v)),
            StmtKind::Assign(target, op, value) => self.assign(at, target, op, value),
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
            StmtKind::Break(n) | StmtKind::Continue(n) if self.loops < *n => match self.loops {
                0 => error_with(at, "break and continue stand inside a loop", "`return` leaves a function"),
                loops => error(at, format!("there are {loops} loops around this, not {n}")),
            },
            StmtKind::Break(n) => self.push(at, Op::Break(*n as u16)),
            StmtKind::Continue(n) => self.push(at, Op::Continue(*n as u16)),
            StmtKind::Return(value) => self.give_back(at, value.as_ref()),
            StmtKind::Extern(names) => {
                for (name, at) in names {
                    let found = self.outer.iter().rev().flat_map(|s| s.iter().rev()).find_map(|s| s.get(name)).copied();
                    let found = match found {
                        Some(found) => Some(found),
                        None => self.global(*at, name)?,
                    };
                    let Some(found) = found else {
                        return error(*at, format!("there is no `{name}` around this function"));
                    };
                    self.declare(*at, name, found)?;
                }
                Ok(())
            }
            StmtKind::Gather(args, hit, miss) => self.gather(at, args, hit, miss.as_deref()),
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
        let var = self.new_variable(v)?;
        self.start(v, var)?;
        self.declare(v.at, &v.name, var)
    }

    fn check_class(&self, at: usize, name: &str, var: Value, value: Value) -> Result<(), Error> {
        if value.varying && var.fixed {
            let message = format!("a varying value cannot be assigned to the uniform variable `{name}`");
            return error_with(at, message, "declare it without `uniform`, so that it may differ from point to point");
        }
        Ok(())
    }

    /// The value that a variable is to have.
    fn value_for(&mut self, var: Value, value: &Expr) -> Result<Value, Error> {
        let before = std::mem::replace(&mut self.for_uniform, var.fixed);
        let found = self.expr(value, Some(var.ty));
        self.for_uniform = before;
        found
    }

    fn assign(&mut self, at: usize, target: &Expr, op: &str, value: &Expr) -> Result<(), Error> {
        let (name, index) = match &target.kind {
            ExprKind::Index(array, index) => match &array.kind {
                ExprKind::Name(name) => (name, Some(&**index)),
                _ => return error(at, "expected a variable"),
            },
            ExprKind::Name(name) => (name, None),
            _ => return error(at, "expected a variable"),
        };
        let var = self.variable(at, name)?;
        if let (ExprKind::Array(values), None) = (&value.kind, index) {
            let (ty, array) = (var.ty, Some(var.array as usize));
            let whole = Expr { at, kind: ExprKind::Array(values.clone()) };
            let v = Variable { at, name: name.clone(), ty, array, varying: true, output: false, value: Some(whole) };
            return self.start(&v, var);
        }
        let mut value = self.value_for(var, value)?;
        if var.array != 0 && index.is_none() {
            return self.copy_array(at, var, value);
        }
        if op != "=" {
            let op = ["+", "-", "*", "/"].into_iter().find(|o| op.starts_with(o)).unwrap_or("+");
            let now = match index {
                Some(_) => self.expr(target, None)?,
                None => var,
            };
            value = self.arithmetic(at, op, now, value)?;
        }
        let ty = if index.is_some() && var.array == 0 { Ty::Float } else { var.ty };
        let value = self.convert(at, value, ty)?;
        self.check_class(at, name, var, value)?;
        match index {
            None => self.store(at, var, value),
            Some(index) => self.store_element(at, var, index, value),
        }
    }

    /// Assign to an element of an array, or to a component of a triple.
    fn store_element(&mut self, at: usize, var: Value, index: &Expr, value: Value) -> Result<(), Error> {
        let i = self.expr(index, Some(Ty::Float))?;
        let i = self.convert(index.at, i, Ty::Float)?;
        if var.array == 0 {
            if !var.ty.is_triple() {
                return error(at, format!("a {} has no elements", var.ty.name()));
            }
            let new =
                self.temp(at, var.ty, true, |r| Op::Call(Builtin::SetComp, r, vec![var.reg, i.reg, value.reg]))?;
            return self.store(at, var, new);
        }
        match self.constant_of(i.reg) {
            Some(k) => {
                let k = self.in_array(index.at, var, k)?;
                self.store(at, Value { reg: var.reg + k, array: 0, ..var }, value)
            }
            None if var.ty == Ty::Text => self.push(at, Op::TextStore(var.reg, var.array, i.reg, value.reg)),
            None => self.push(at, Op::Store(var.reg, var.array, i.reg, value.reg)),
        }
    }

    fn in_array(&self, at: usize, var: Value, k: f32) -> Result<u16, Error> {
        if k >= 0.0 && (k as usize) < var.array as usize {
            return Ok(k as u16);
        }
        error(at, format!("element {k} of an array of {}", var.array))
    }

    /// The number that a register of this block was made with, if it is a constant.
    fn constant_of(&self, reg: u16) -> Option<f32> {
        self.ops.iter().rev().find_map(|op| match op {
            Op::Const(r, x) if *r == reg => Some(*x),
            _ => None,
        })
    }

    /// An element of an array, or a component of a triple.
    fn element(&mut self, at: usize, of: &Expr, index: &Expr) -> Result<Value, Error> {
        let var = self.expr(of, None)?;
        let i = self.expr(index, Some(Ty::Float))?;
        let i = self.convert(index.at, i, Ty::Float)?;
        let varying = var.varying || i.varying;
        if var.array != 0 {
            return match self.constant_of(i.reg) {
                Some(k) => {
                    let k = self.in_array(index.at, var, k)?;
                    Ok(Value { reg: var.reg + k, array: 0, ..var })
                }
                None if var.ty == Ty::Text => {
                    self.temp(at, Ty::Text, false, |r| Op::TextLoad(r, var.reg, var.array, i.reg))
                }
                None => self.temp(at, var.ty, varying, |r| Op::Load(r, var.reg, var.array, i.reg)),
            };
        }
        match (var.ty.is_triple(), self.constant_of(i.reg)) {
            (true, Some(k)) if (0.0..3.0).contains(&k) => {
                self.temp(at, Ty::Float, varying, |r| Op::Component(r, var.reg, k as u8))
            }
            (true, None) => self.temp(at, Ty::Float, varying, |r| Op::Call(Builtin::Comp, r, vec![var.reg, i.reg])),
            (true, Some(k)) => error(index.at, format!("a {} has no component {k}", var.ty.name())),
            (false, _) => error(at, format!("a {} has no elements", var.ty.name())),
        }
    }

    /// `return`.
    fn give_back(&mut self, at: usize, value: Option<&Expr>) -> Result<(), Error> {
        let Some(result) = self.results.last().copied() else { return error(at, "`return` stands in a function") };
        if let (Some(value), Some(result)) = (value, result) {
            if result.ty == Ty::Void {
                return error_with(
                    at,
                    "a void function returns no value",
                    "give the function the value's type in place of `void`",
                );
            }
            let found = self.expr(value, Some(result.ty))?;
            let found = self.convert(value.at, found, result.ty)?;
            self.store(at, result, found)?;
        }
        self.push(at, Op::Return)
    }

    fn condition(&mut self, e: &Expr) -> Result<Value, Error> {
        let value = self.expr(e, Some(Ty::Float))?;
        if value.ty == Ty::Float {
            Ok(value)
        } else {
            let hint = "compare it with something, as in `length(v) > 0`";
            error_with(e.at, format!("expected a condition, found {}", value.ty.name()), hint)
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
        let mut category = None;
        let mut wanted = vec![];
        if which == "illuminance" {
            if values.first().is_some_and(|v| v.ty == Ty::Text) {
                category = Some(values.remove(0).reg);
            }
            let n = args.len() - values.len();
            if let Some(k) = values.iter().position(|v| v.ty == Ty::Text) {
                wanted = self.wanted(&args[n + k..])?;
                values.truncate(k);
            }
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
            _ => {
                let message = format!("expected {which}(position) or {which}(position, axis, angle)");
                let hint = match which {
                    "illuminance" => "over the hemisphere of a normal: `illuminance(P, N, PI / 2)`",
                    _ => "into a cone: `illuminate(from, axis, coneangle)`",
                };
                return error_with(at, message, hint);
            }
        };
        if which == "illuminate" {
            self.directed = true;
            let ps = self.global(at, "Ps")?.expect("Ps is a global").reg;
            let (body, ()) = self.block(|l| l.scoped(std::slice::from_ref(body)))?;
            return self.push(at, Op::Illuminate { args, l, ps, body });
        }
        let cl = self.global(at, "Cl")?.expect("Cl is a global").reg;
        let (body, ()) = self.block(|l| l.scoped(std::slice::from_ref(body)))?;
        let wanted = wanted.into_iter().map(|(n, r)| (n.trim_start_matches("light:").to_string(), r)).collect();
        self.push(at, Op::Illuminance { args, l, cl, category, wanted, body })
    }

    /// Pairs of a name and the variable that takes it.
    fn wanted(&mut self, args: &[Expr]) -> Result<Vec<(String, Reg)>, Error> {
        let mut out = Vec::new();
        for pair in args.chunks(2) {
            let [Expr { kind: ExprKind::Text(name), .. }, to] = pair else {
                return error(pair[0].at, "expected a name in quotes and a variable for it");
            };
            if !name.contains(':') {
                continue;
            }
            match &to.kind {
                ExprKind::Name(variable) => out.push((name.clone(), self.variable(to.at, variable)?.reg)),
                _ => return error(to.at, format!("expected a variable for \"{name}\"")),
            }
        }
        Ok(out)
    }

    fn gather(&mut self, at: usize, args: &'a [Expr], hit: &'a Stmt, miss: Option<&'a Stmt>) -> Result<(), Error> {
        let mut values = Vec::new();
        for arg in &args[..args.len().min(5)] {
            values.push(self.expr(arg, None)?);
        }
        let types: Vec<Ty> = values.iter().map(|v| v.ty).collect();
        let [Ty::Text, p, axis, Ty::Float, Ty::Float] = types[..] else {
            return error(at, "expected gather(category, P, axis, angle, samples, …)");
        };
        if !p.is_triple() || !axis.is_triple() {
            return error(at, "expected gather(category, P, axis, angle, samples, …)");
        }
        let out = self.wanted(&args[5..])?;
        let (hit, ()) = self.block(|l| l.scoped(std::slice::from_ref(hit)))?;
        let (miss, ()) = self.block(|l| miss.map_or(Ok(()), |m| l.scoped(std::slice::from_ref(m))))?;
        let args = [values[1].reg, values[2].reg, values[3].reg, values[4].reg];
        self.push(at, Op::Gather { args, out, hit, miss })
    }

    fn expr(&mut self, e: &Expr, expected: Option<Ty>) -> Result<Value, Error> {
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
                self.temp(at, a.ty, a.varying, |r| Op::Unary(op, r, a.reg))
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
            ExprKind::Choose(condition, a, b) => {
                let condition = self.condition(condition)?;
                let (a, b) = (self.expr(a, expected)?, self.expr(b, expected)?);
                if a.ty == Ty::Text && b.ty == Ty::Text {
                    let chosen = self.text(at, "")?;
                    let pick = |v: Value| vec![Op::TextCopy(chosen.reg, v.reg)];
                    self.push(at, Op::If(condition.reg, pick(a), pick(b)))?;
                    return Ok(chosen);
                }
                let ty = if a.ty == Ty::Float { b.ty } else { a.ty };
                let (a, b) = (self.convert(at, a, ty)?, self.convert(at, b, ty)?);
                self.temp(at, ty, condition.varying || a.varying || b.varying, |r| {
                    Op::Select(r, condition.reg, a.reg, b.reg)
                })
            }
            ExprKind::Triple(parts) => {
                let ty = expected.filter(|t| t.is_triple()).unwrap_or(Ty::Color);
                self.pack(at, ty, &parts[..])
            }
            ExprKind::Matrix(parts) => self.pack(at, Ty::Matrix, parts),
            ExprKind::Array(_) => error(at, "`{…}` stands where an array starts"),
            ExprKind::Index(of, index) => self.element(at, of, index),
            ExprKind::Cast(ty, space, operand) => self.cast(at, *ty, space.as_deref(), operand),
            ExprKind::Call(name, args) => self.call(at, name, args, expected),
        }
    }

    fn pack(&mut self, at: usize, ty: Ty, parts: &[Expr]) -> Result<Value, Error> {
        let mut regs = Vec::with_capacity(parts.len());
        let mut varying = false;
        for part in parts {
            let value = self.expr(part, Some(Ty::Float))?;
            let value = self.convert(part.at, value, Ty::Float)?;
            regs.push(value.reg);
            varying |= value.varying;
        }
        self.temp(at, ty, varying, |r| Op::Pack(r, regs))
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
            Ty::Color => {
                if !crate::color::SPACES.contains(&space) {
                    let known = crate::color::SPACES.join(", ");
                    return error(at, format!("unknown colour space `{space}`, expected one of {known}"));
                }
                let (from, to) = (self.text(at, space)?, self.text(at, "rgb")?);
                return self.temp(at, ty, value.varying, |r| Op::ColorSpace(r, value.reg, from.reg, to.reg));
            }
            Ty::Matrix => Transform::Matrix,
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
        if a.array != 0 || b.array != 0 {
            return refuse("does not take arrays");
        }
        if a.ty == Ty::Matrix || b.ty == Ty::Matrix {
            if a.ty.is_triple() || b.ty.is_triple() {
                return refuse("does not mix a matrix with a triple (see transform)");
            }
            let (a, b) = (self.convert(at, a, Ty::Matrix)?, self.convert(at, b, Ty::Matrix)?);
            let f = match op {
                "*" => Builtin::MatrixMultiply,
                "/" => Builtin::MatrixDivide,
                "==" | "!=" => Builtin::MatrixEqual,
                "+" | "-" => {
                    let f = if op == "+" { Binary::Add } else { Binary::Sub };
                    return self.temp(at, Ty::Matrix, varying, |r| Op::Binary(f, r, a.reg, b.reg));
                }
                _ => return refuse("does not take matrices"),
            };
            let ty = if f == Builtin::MatrixEqual { Ty::Float } else { Ty::Matrix };
            let result = self.temp(at, ty, varying, |r| Op::Call(f, r, vec![a.reg, b.reg]))?;
            if op == "!=" {
                return self.temp(at, Ty::Float, varying, |r| Op::Unary(Unary::Not, r, result.reg));
            }
            return Ok(result);
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
        // Functions of several forms, written in the language: the number of arguments tells.
        let plain = args.iter().take_while(|a| !matches!(a.kind, ExprKind::Text(_))).count();
        let form = match (name, plain) {
            ("fresnel", 5) => "fresnel5_",
            ("fresnel", 7) => "fresnel7_",
            ("rotate", 4) => "rotate_",
            ("filterstep", 2) => "filterstep2_",
            ("filterstep", 3) => "filterstep3_",
            _ => name,
        };
        let args = if form != name { &args[..plain] } else { args };
        if let Some(function) = self.functions.get(form).copied() {
            return self.inline(at, function, args);
        }
        if let Some(value) = self.scene_call(at, name, args, expected)? {
            return Ok(value);
        }
        let overloads: Vec<_> = SIGNATURES.iter().filter(|s| s.0 == name).collect();
        if overloads.is_empty() && !SPECIAL.contains(&name) {
            let known =
                self.functions.keys().copied().chain(SIGNATURES.iter().map(|s| s.0)).chain(SPECIAL.iter().copied());
            let message = format!("unknown function `{name}`{}", nearest(name, known));
            return error_with(at, message, "functions of one's own stand before the shader, or come by `#include`");
        }
        let mut values = Vec::new();
        for (i, arg) in args.iter().enumerate() {
            let hint = match overloads.first().and_then(|s| s.2.get(i)) {
                Some(Arg::Float) => Some(Ty::Float),
                Some(Arg::Triple) => Some(Ty::Vector),
                Some(Arg::Matrix) => Some(Ty::Matrix),
                Some(Arg::Any) => expected,
                None if matches!(name, "clamp" | "mix") && i < 2 => expected,
                None => None,
            };
            values.push(self.expr(arg, hint)?);
        }
        if overloads.is_empty() {
            return self.special(at, name, &values, expected);
        }
        // Options by name that follow the arguments ask for nothing that would be done otherwise here.
        let options = values.iter().position(|v| v.ty == Ty::Text).unwrap_or(values.len());
        values.truncate(options);
        let fits = |s: &&&(&str, Option<Ty>, &[Arg], How)| {
            s.2.len() == values.len()
                && s.2.iter().zip(&values).all(|(arg, v)| match arg {
                    Arg::Float => v.ty == Ty::Float,
                    Arg::Triple => v.ty.is_triple(),
                    Arg::Matrix => matches!(v.ty, Ty::Matrix | Ty::Float),
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
        let Some((_, ret, takes, how)) = overloads.iter().find(fits) else {
            let found: Vec<&str> = values.iter().map(|v| v.ty.name()).collect();
            let takes: Vec<String> = overloads.iter().map(|s| signature(name, s.2)).collect();
            return error(at, format!("expected {}, found {name}({})", takes.join(" or "), found.join(", ")));
        };
        let varying = matches!(
            name,
            "ambient" | "transmission" | "area" | "calculatenormal" | "trace" | "occlusion" | "indirectdiffuse"
        ) || values.iter().any(|v| v.varying);
        for (value, arg) in values.iter_mut().zip(*takes) {
            if *arg == Arg::Matrix {
                *value = self.convert(at, *value, Ty::Matrix)?;
            }
        }
        let ret = ret.or(values.first().map(|v| v.ty)).unwrap_or(Ty::Float);
        let ret = if name == "trace" && expected == Some(Ty::Float) { Ty::Float } else { ret };
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
            ("noise" | "cellnoise" | "snoise", [Ty::Float] | [Ty::Float, Ty::Float])
            | (
                "noise" | "cellnoise" | "snoise",
                [Ty::Point | Ty::Vector | Ty::Normal | Ty::Color] | [Ty::Point | Ty::Vector | Ty::Normal, Ty::Float],
            )
            | (
                "pnoise",
                [Ty::Float, Ty::Float]
                | [Ty::Float, Ty::Float, Ty::Float, Ty::Float]
                | [Ty::Point | Ty::Vector | Ty::Normal, Ty::Point | Ty::Vector | Ty::Normal | Ty::Color]
                | [Ty::Point | Ty::Vector | Ty::Normal, Ty::Float, Ty::Point | Ty::Vector | Ty::Normal, Ty::Float],
            ) => {
                let f = match name {
                    "cellnoise" => Builtin::CellNoise,
                    "pnoise" => Builtin::PeriodicNoise,
                    _ => Builtin::Noise,
                };
                let ty = expected.filter(|t| t.is_triple()).unwrap_or(Ty::Float);
                let noise = self.temp(at, ty, varying, |r| Op::Call(f, r, regs))?;
                if name != "snoise" {
                    return Ok(noise);
                }
                let (two, one) = (self.constant(at, 2.0)?, self.constant(at, 1.0)?);
                let twice = self.arithmetic(at, "*", noise, two)?;
                self.arithmetic(at, "-", twice, one)
            }
            ("noise" | "cellnoise" | "snoise", _) => {
                usage(&format!("{name}(float), {name}(float, float), {name}(point) or {name}(point, float)"))
            }
            ("pnoise", _) => {
                usage("pnoise(float, period), pnoise(x, y, periods), pnoise(point, period) or of point and float")
            }
            ("random", []) => {
                let ty = expected.filter(|t| t.is_triple()).unwrap_or(Ty::Float);
                let (p, salt) = (self.variable(at, "P")?, self.constant(at, self.n_ops as f32)?);
                // For a uniform variable it is one number a grid, otherwise one a point.
                let args = if self.for_uniform { vec![salt.reg] } else { vec![salt.reg, p.reg] };
                self.temp(at, ty, !self.for_uniform, |r| Op::Call(Builtin::Random, r, args))
            }
            ("random", _) => usage("random()"),
            ("spline", _) => self.spline(at, v),
            ("ctransform", [Ty::Text, c]) if c.is_triple() => {
                let from = self.text(at, "rgb")?;
                self.temp(at, Ty::Color, varying, |r| Op::ColorSpace(r, regs[1], from.reg, regs[0]))
            }
            ("ctransform", [Ty::Text, Ty::Text, c]) if c.is_triple() => {
                self.temp(at, Ty::Color, varying, |r| Op::ColorSpace(r, regs[2], regs[0], regs[1]))
            }
            ("ctransform", _) => usage("ctransform(to, colour) or ctransform(from, to, colour)"),
            ("comp", [Ty::Matrix, Ty::Float, Ty::Float]) => {
                self.temp(at, Ty::Float, varying, |r| Op::Call(Builtin::Comp, r, regs))
            }
            ("mtransform", [Ty::Text, Ty::Matrix]) => {
                let from = self.text(at, "current")?;
                self.temp(at, Ty::Matrix, varying, |r| Op::Transform(Transform::Matrix, r, regs[1], from.reg, regs[0]))
            }
            ("mtransform", [Ty::Text, Ty::Text, Ty::Matrix]) => {
                self.temp(at, Ty::Matrix, varying, |r| Op::Transform(Transform::Matrix, r, regs[2], regs[0], regs[1]))
            }
            ("mtransform", _) => usage("mtransform(to, matrix) or mtransform(from, to, matrix)"),
            ("concat", list) if !list.is_empty() && list.iter().all(|t| *t == Ty::Text) => {
                let pattern = self.text(at, &"%s".repeat(list.len()))?;
                let args = std::iter::once(pattern).chain(v.iter().copied()).map(Value::operand).collect();
                self.temp(at, Ty::Text, false, |r| Op::Format(r, args))
            }
            ("concat", _) => usage("concat of strings"),
            ("format", [Ty::Text, ..]) => {
                let args = v.iter().copied().map(Value::operand).collect();
                self.temp(at, Ty::Text, false, |r| Op::Format(r, args))
            }
            ("printf", [Ty::Text, ..]) => {
                self.push(at, Op::Print(v.iter().copied().map(Value::operand).collect()))?;
                Ok(Value::of(Ty::Void, 0, false))
            }
            ("format" | "printf", _) => usage(&format!("{name}(pattern, values …)")),
            ("match", [Ty::Text, Ty::Text]) => self.temp(at, Ty::Float, false, |r| Op::Match(r, regs[0], regs[1])),
            ("match", _) => usage("match(pattern, text)"),
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
            ("comp", [t, Ty::Float]) if t.is_triple() => match self.constant_of(regs[1]) {
                Some(i) if (0.0..3.0).contains(&i) => {
                    self.temp(at, Ty::Float, varying, |r| Op::Component(r, regs[0], i as u8))
                }
                Some(_) => error(at, "the index of `comp` must be 0, 1 or 2"),
                None => self.temp(at, Ty::Float, varying, |r| Op::Call(Builtin::Comp, r, regs)),
            },
            ("comp", _) => usage("comp(triple, index) or comp(matrix, row, column)"),
            ("transform" | "vtransform" | "ntransform", _) => {
                let (how, ty) = match name {
                    "transform" => (Transform::Point, Ty::Point),
                    "vtransform" => (Transform::Vector, Ty::Vector),
                    _ => (Transform::Normal, Ty::Normal),
                };
                if let [Ty::Matrix, t] = types.as_slice()
                    && t.is_triple()
                {
                    let f = match how {
                        Transform::Point => Builtin::MatrixPoint,
                        Transform::Vector => Builtin::MatrixVector,
                        _ => Builtin::MatrixNormal,
                    };
                    return self.temp(at, ty, varying, |r| Op::Call(f, r, regs));
                }
                if let [Ty::Text, Ty::Matrix, t] = types.as_slice()
                    && t.is_triple()
                {
                    // From a named space by a matrix that is given in it.
                    let now = self.text(at, "current")?;
                    let there = self.temp(at, ty, varying, |r| Op::Transform(how, r, regs[2], regs[0], now.reg))?;
                    let f = if how == Transform::Point { Builtin::MatrixPoint } else { Builtin::MatrixVector };
                    return self.temp(at, ty, varying, |r| Op::Call(f, r, vec![regs[1], there.reg]));
                }
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

    /// `spline([basis,] value, knots …)` or with an array of knots.
    fn spline(&mut self, at: usize, v: &[Value]) -> Result<Value, Error> {
        let (basis, rest) = match v.split_first() {
            Some((basis, rest)) if basis.ty == Ty::Text => (*basis, rest),
            _ => (self.text(at, "catmull-rom")?, v),
        };
        let wrong = "expected spline(value, four or more knots) or spline(value, array)";
        let Some((value, knots)) = rest.split_first() else { return error(at, wrong) };
        let mut list = Vec::new();
        let mut ty = Ty::Float;
        for knot in knots {
            if knot.ty == Ty::Text || knot.ty == Ty::Matrix {
                return error(at, wrong);
            }
            ty = if knot.ty == Ty::Float { ty } else { knot.ty };
            list.extend((0..knot.array.max(1)).map(|k| Value { reg: knot.reg + k, array: 0, ..*knot }));
        }
        if value.ty != Ty::Float || list.len() < 2 {
            return error(at, wrong);
        }
        let mut args = vec![value.reg];
        for knot in list {
            args.push(self.convert(at, knot, ty)?.reg);
        }
        let varying = v.iter().any(|v| v.varying);
        self.temp(at, ty, varying, |r| Op::Spline(r, basis.reg, args))
    }

    /// Calls that ask the scene, or that change a variable; none if `name` is not one of them.
    fn scene_call(
        &mut self,
        at: usize,
        name: &str,
        args: &[Expr],
        expected: Option<Ty>,
    ) -> Result<Option<Value>, Error> {
        let ask = match name {
            "surface" => Ask::Surface,
            "displacement" => Ask::Displacement,
            "atmosphere" => Ask::Atmosphere,
            "lightsource" => Ask::LightSource,
            "incident" => Ask::Incident,
            "opposite" => Ask::Opposite,
            "attribute" => Ask::Attribute,
            "option" => Ask::Option,
            "rendererinfo" => Ask::RendererInfo,
            "rayinfo" => Ask::RayInfo,
            "textureinfo" => Ask::TextureInfo,
            "texture" => return self.map(at, Lookup::Texture, args, expected).map(Some),
            "environment" => return self.map(at, Lookup::Environment, args, expected).map(Some),
            "shadow" => return self.map(at, Lookup::Shadow, args, expected.or(Some(Ty::Float))).map(Some),
            "setcomp" | "setxcomp" | "setycomp" | "setzcomp" => return self.set_component(at, name, args).map(Some),
            // What is baked is not kept, and so nothing is found of it.
            "bake" | "bake3d" | "texture3d" => {
                for arg in args {
                    self.expr(arg, None)?;
                }
                return self.constant(at, 0.0).map(Some);
            }
            _ => return Ok(None),
        };
        let n_names = if ask == Ask::TextureInfo { 2 } else { 1 };
        if args.len() != n_names + 1 {
            return error(
                at,
                format!("expected {name}({}, variable)", if n_names == 2 { "texture, name" } else { "name" }),
            );
        }
        let mut names = Vec::new();
        for arg in &args[..n_names] {
            let value = self.expr(arg, None)?;
            if value.ty != Ty::Text {
                let hint = "names stand in quotes";
                return error_with(arg.at, format!("expected a string, found {}", value.ty.name()), hint);
            }
            names.push(value.reg);
        }
        let ExprKind::Name(variable) = &args[n_names].kind else {
            return error(args[n_names].at, "expected a variable for the answer");
        };
        let var = self.variable(args[n_names].at, variable)?;
        let (out, len) = (var.operand(), var.array.max(1));
        self.temp(at, Ty::Float, false, |dst| Op::Ask { dst, what: ask, names, out, len }).map(Some)
    }

    /// `texture`, `environment` and `shadow`.
    fn map(&mut self, at: usize, how: Lookup, args: &[Expr], expected: Option<Ty>) -> Result<Value, Error> {
        let Some((first, rest)) = args.split_first() else { return error(at, "expected the name of a map") };
        let (name, channel) = match &first.kind {
            ExprKind::Index(name, channel) => {
                let channel = self.expr(channel, Some(Ty::Float))?;
                (self.expr(name, None)?, self.convert(first.at, channel, Ty::Float)?)
            }
            _ => (self.expr(first, None)?, self.constant(at, 0.0)?),
        };
        if name.ty != Ty::Text {
            return error(first.at, format!("expected the name of a map, found {}", name.ty.name()));
        }
        let mut values = Vec::new();
        for arg in rest {
            values.push(self.expr(arg, None)?);
        }
        let n = values.iter().position(|v| v.ty == Ty::Text).unwrap_or(values.len());
        let (place, options) = values.split_at(n);
        let types: Vec<Ty> = place.iter().map(|v| v.ty).collect();
        let all = |n: usize, f: &dyn Fn(Ty) -> bool| types.len() == n && types.iter().all(|t| f(*t));
        let fits = match how {
            Lookup::Texture => types.is_empty() || all(2, &|t| t == Ty::Float) || all(8, &|t| t == Ty::Float),
            Lookup::Environment | Lookup::Shadow => all(1, &Ty::is_triple) || all(4, &Ty::is_triple),
        };
        if !fits {
            let usage = match how {
                Lookup::Texture => "texture(name), texture(name, s, t) or texture(name, four pairs of s and t)",
                Lookup::Environment => "environment(name, direction)",
                Lookup::Shadow => "shadow(name, point)",
            };
            return error(at, format!("expected {usage}"));
        }
        let mut at_regs: Vec<Reg> = place.iter().map(|v| v.reg).collect();
        if how == Lookup::Texture && at_regs.is_empty() {
            at_regs = vec![self.variable(at, "s")?.reg, self.variable(at, "t")?.reg];
        }
        let mut named = Vec::new();
        for pair in options.chunks(2) {
            match pair {
                [key, value] if key.ty == Ty::Text => named.push((key.reg, value.operand())),
                _ => return error(at, "expected options as a name and a value each"),
            }
        }
        let ty = expected.filter(|t| *t == Ty::Float || t.is_triple()).unwrap_or(Ty::Color);
        self.temp(at, ty, true, |dst| Op::Map {
            dst,
            how,
            name: name.reg,
            channel: channel.reg,
            at: at_regs,
            options: named,
        })
    }

    /// An operand. What is looked up in a map is a colour, unless the whole is to be a number or a place in space: then it is a
    /// number.
    fn operand(&mut self, e: &Expr, ty: Option<Ty>, whole: Option<Ty>) -> Result<Value, Error> {
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

    /// `setcomp` and its kin.
    fn set_component(&mut self, at: usize, name: &str, args: &[Expr]) -> Result<Value, Error> {
        let Some(ExprKind::Name(variable)) = args.first().map(|a| &a.kind) else {
            return error(at, format!("expected a variable as the first argument of `{name}`"));
        };
        let var = self.variable(at, variable)?;
        let mut regs = vec![var.reg];
        if let Some(k) = ["setxcomp", "setycomp", "setzcomp"].iter().position(|n| *n == name) {
            regs.push(self.constant(at, k as f32)?.reg);
        }
        for arg in &args[1..] {
            let value = self.expr(arg, Some(Ty::Float))?;
            regs.push(self.convert(arg.at, value, Ty::Float)?.reg);
        }
        let wanted = if var.ty == Ty::Matrix { 4 } else { 3 };
        if regs.len() != wanted || !(var.ty.is_triple() || var.ty == Ty::Matrix) {
            return error(at, format!("other arguments of `{name}`: a triple or a matrix, its index, and a number"));
        }
        let new = self.temp(at, var.ty, true, |r| Op::Call(Builtin::SetComp, r, regs))?;
        self.store(at, var, new)?;
        Ok(Value::of(Ty::Void, 0, false))
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
            let reg = self.reg(at, param.ty)?;
            let mut var = Value::of(param.ty, reg, value.varying);
            if param.array.is_some() {
                if value.array == 0 {
                    return error(arg.at, format!("`{}` takes an array", param.name));
                }
                for _ in 1..value.array {
                    self.reg(at, param.ty)?;
                }
                var.array = value.array;
                self.copy_array(arg.at, var, value)?;
            } else {
                let value = self.convert(arg.at, value, param.ty)?;
                self.store(at, var, value)?;
            }
            if param.output {
                if !matches!(arg.kind, ExprKind::Name(_) | ExprKind::Index(..)) {
                    let hint = "what the function gives back needs a variable to go to";
                    return error_with(arg.at, format!("`{}` is an output: expected a variable", param.name), hint);
                }
                outputs.push((arg, var));
            }
            inner.insert(param.name.clone(), var);
        }
        let outer = std::mem::replace(&mut self.scopes, vec![inner]);
        self.outer.push(outer);
        self.calling.push(&function.name);
        let result = self.function_body(at, function);
        self.calling.pop();
        self.scopes = self.outer.pop().expect("pushed above");
        let result = result?;
        for (target, var) in outputs {
            match &target.kind {
                ExprKind::Index(array, index) => {
                    let ExprKind::Name(name) = &array.kind else { return error(target.at, "expected a variable") };
                    let array = self.variable(target.at, name)?;
                    self.store_element(target.at, array, index, var)?;
                }
                ExprKind::Name(name) => {
                    let to = self.variable(target.at, name)?;
                    if var.array != 0 { self.copy_array(target.at, to, var)? } else { self.store(at, to, var)? }
                }
                _ => {}
            }
        }
        Ok(result)
    }

    fn function_body(&mut self, at: usize, function: &'a Function) -> Result<Value, Error> {
        let early = function.body.split_last().is_some_and(|(last, before)| {
            before.iter().any(returns) || (returns(last) && !matches!(last.kind, StmtKind::Return(_)))
        });
        let loops = std::mem::take(&mut self.loops);
        let result = if early { self.body_with_returns(at, function) } else { self.plain_body(at, function) };
        self.loops = loops;
        result
    }

    /// A body that may be left anywhere: its result is a variable.
    fn body_with_returns(&mut self, at: usize, function: &'a Function) -> Result<Value, Error> {
        let result = if function.ret == Ty::Void {
            Value::of(Ty::Void, 0, false)
        } else {
            let var = Value::of(function.ret, self.reg(at, function.ret)?, true);
            let zero = if function.ret == Ty::Text { self.text(at, "")? } else { self.constant(at, 0.0)? };
            let zero = self.convert(at, zero, function.ret)?;
            self.store(at, var, zero)?;
            var
        };
        self.results.push(Some(result));
        let body = self.block(|l| function.body.iter().try_for_each(|s| l.statement(s)));
        self.results.pop();
        self.push(at, Op::Inline(body?.0))?;
        Ok(result)
    }

    fn plain_body(&mut self, at: usize, function: &'a Function) -> Result<Value, Error> {
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
            _ if function.ret == Ty::Void => Ok(Value::of(Ty::Void, 0, false)),
            _ => error(at, format!("`{}` must end with `return`", function.name)),
        }
    }
}

/// Whether a statement may return.
fn returns(s: &Stmt) -> bool {
    match &s.kind {
        StmtKind::Return(_) => true,
        StmtKind::Block(body) => body.iter().any(returns),
        StmtKind::If(_, a, b) => returns(a) || b.as_deref().is_some_and(returns),
        StmtKind::While(_, a) | StmtKind::For(_, _, _, a) | StmtKind::Light(_, _, a) => returns(a),
        StmtKind::Gather(_, a, b) => returns(a) || b.as_deref().is_some_and(returns),
        _ => false,
    }
}

/// `name(float, triple …)`, for messages.
fn signature(name: &str, args: &[Arg]) -> String {
    let list: Vec<&str> = args
        .iter()
        .map(|a| match a {
            Arg::Float => "float",
            Arg::Triple => "a triple",
            Arg::Matrix => "matrix",
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
