//! Variables: parameters, local variables, arrays, assignments.

use super::super::ast::*;
use super::super::diagnostic::{Error, error, error_with};
use super::state::{Lower, Value};
use crate::ir::*;

impl<'a> Lower<'a> {
    pub(super) fn parameter(&mut self, param: &Variable) -> Result<Parameter, Error> {
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
        Ok(Parameter { name, kind, varying, output, array, reg: var.operand(), default })
    }

    /// Registers of a variable.
    pub(super) fn new_variable(&mut self, v: &Variable) -> Result<Value, Error> {
        let index = self.reg(v.at, v.ty)?;
        for _ in 1..v.array.unwrap_or(1) {
            self.reg(v.at, v.ty)?;
        }
        // What a function's own variables hold depends on what it is called with.
        let varying = v.varying && self.calling.is_empty();
        let mut value = Value::of(v.ty, index, varying);
        (value.array, value.fixed) = (v.array.map_or(0, |n| n.max(1) as u16), !v.varying && !v.output);
        Ok(value)
    }

    /// A variable without a name that may vary: 0, or an empty text.
    pub(super) fn empty_variable(&mut self, at: usize, ty: Ty) -> Result<Value, Error> {
        let var = Value::of(ty, self.reg(at, ty)?, true);
        let zero = if ty == Ty::Text { self.text(at, "")? } else { self.constant(at, 0.0)? };
        let zero = self.convert(at, zero, ty)?;
        self.store(at, var, zero)?;
        Ok(var)
    }

    /// Store what a variable starts with.
    pub(super) fn start(&mut self, v: &Variable, var: Value) -> Result<(), Error> {
        let zero = |l: &mut Self| if v.ty == Ty::Text { l.text(v.at, "") } else { l.constant(v.at, 0.0) };
        match &v.value {
            Some(Expr { kind: ExprKind::Array(values), at }) if v.array.is_some() => {
                if values.len() > var.array as usize {
                    return error(*at, format!("{} values for an array of {}", values.len(), var.array));
                }
                if values.len() < var.array as usize {
                    let (name, rest) = (&v.name, if v.ty == Ty::Text { "empty" } else { "0" });
                    let (n, len) = (values.len(), var.array);
                    self.unsupported.push(format!("gives {n} values for the {len} of `{name}`: the rest are {rest}"));
                }
                for k in 0..var.array {
                    let value = match values.get(k as usize) {
                        Some(value) => self.expr(value, Some(v.ty))?,
                        None => zero(self)?,
                    };
                    let value = self.convert(v.at, value, v.ty)?;
                    self.store(v.at, var.element(k), value)?;
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
                (0..var.array).try_for_each(|k| self.store(v.at, var.element(k), found))
            }
            None => {
                let value = zero(self)?;
                let value = self.convert(v.at, value, v.ty)?;
                (0..var.array.max(1)).try_for_each(|k| self.store(v.at, var.element(k), value))
            }
        }
    }

    pub(super) fn copy_array(&mut self, at: usize, to: Value, from: Value) -> Result<(), Error> {
        if to.array != from.array || to.ty != from.ty {
            let show = |v: Value| match v.array {
                0 => v.ty.name().to_string(),
                n => format!("{}[{n}]", v.ty.name()),
            };
            return error(at, format!("expected {}, found {}", show(to), show(from)));
        }
        (0..to.array).try_for_each(|k| self.store(at, to.element(k), from.element(k)))
    }

    /// Store a value of the variable's own type.
    pub(super) fn store(&mut self, at: usize, var: Value, value: Value) -> Result<(), Error> {
        if var.ty == Ty::Text {
            return self.push(at, Op::TextCopy(var.text(), value.text()));
        }
        self.push(at, Op::Assign(var.reg(), value.reg()))
    }

    pub(super) fn local(&mut self, v: &Variable) -> Result<(), Error> {
        let var = self.new_variable(v)?;
        self.start(v, var)?;
        self.declare(v.at, &v.name, var)
    }

    pub(super) fn check_class(&self, at: usize, name: &str, var: Value, value: Value) -> Result<(), Error> {
        if value.varying && var.fixed {
            let message = format!("a varying value cannot be assigned to the uniform variable `{name}`");
            return error_with(at, message, "declare it without `uniform`, so that it may differ from point to point");
        }
        Ok(())
    }

    /// The value that a variable is to have.
    pub(super) fn value_for(&mut self, var: Value, value: &Expr) -> Result<Value, Error> {
        let before = std::mem::replace(&mut self.for_uniform, var.fixed);
        let found = self.expr(value, Some(var.ty));
        self.for_uniform = before;
        found
    }

    pub(super) fn assign(&mut self, at: usize, target: &Expr, op: &str, value: &Expr) -> Result<(), Error> {
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
    pub(super) fn store_element(&mut self, at: usize, var: Value, index: &Expr, value: Value) -> Result<(), Error> {
        let i = self.expr(index, Some(Ty::Float))?;
        let i = self.convert(index.at, i, Ty::Float)?;
        if var.array == 0 {
            if !var.ty.is_triple() {
                return error(at, format!("a {} has no elements", var.ty.name()));
            }
            self.within(index.at, &[i], 3)?;
            let new = self.temp(at, var.ty, true, |r| {
                Op::Call(Builtin::SET_COMPONENT, r.reg(), vec![var.reg(), i.reg(), value.reg()])
            })?;
            return self.store(at, var, new);
        }
        match self.constant_of(i) {
            Some(k) => {
                let k = self.in_array(index.at, var, k)?;
                self.store(at, var.element(k), value)
            }
            None if var.ty == Ty::Text => {
                self.push(at, Op::TextStore(var.text(), var.array, i.float(), value.text(), at as u32))
            }
            None => self.push(at, Op::Store(var.reg(), var.array, i.float(), value.reg(), at as u32)),
        }
    }

    pub(super) fn in_array(&self, at: usize, var: Value, k: f32) -> Result<u16, Error> {
        if k >= 0.0 && (k as usize) < var.array as usize {
            return Ok(k as u16);
        }
        error(at, format!("element {k} of an array of {}", var.array))
    }

    /// An element of an array, or a component of a triple.
    pub(super) fn element(&mut self, at: usize, of: &Expr, index: &Expr) -> Result<Value, Error> {
        let var = self.expr(of, None)?;
        let i = self.expr(index, Some(Ty::Float))?;
        let i = self.convert(index.at, i, Ty::Float)?;
        let varying = var.varying || i.varying;
        if var.array != 0 {
            return match self.constant_of(i) {
                Some(k) => {
                    let k = self.in_array(index.at, var, k)?;
                    Ok(var.element(k))
                }
                None if var.ty == Ty::Text => self
                    .temp(at, Ty::Text, false, |r| Op::TextLoad(r.text(), var.text(), var.array, i.float(), at as u32)),
                None => {
                    self.temp(at, var.ty, varying, |r| Op::Load(r.reg(), var.reg(), var.array, i.float(), at as u32))
                }
            };
        }
        match (var.ty.is_triple(), self.constant_of(i)) {
            (true, Some(k)) if (0.0..3.0).contains(&k) => {
                self.temp(at, Ty::Float, varying, |r| Op::Component(r.float(), var.triple(), k as u8))
            }
            (true, None) => {
                self.within(index.at, &[i], 3)?;
                self.temp(at, Ty::Float, varying, |r| Op::Call(Builtin::COMPONENT, r.reg(), vec![var.reg(), i.reg()]))
            }
            (true, Some(_)) => self.within(index.at, &[i], 3).map(|()| i),
            (false, _) => error(at, format!("a {} has no elements", var.ty.name())),
        }
    }
}
