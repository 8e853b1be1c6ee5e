//! The state of lowering: scopes, registers, and the operations so far.

use super::super::ast::*;
use super::super::diagnostic::{Error, error, error_with};
use crate::ir::*;
use crate::shadeop::number::{binary_value, unary_value};
use std::collections::HashMap;

/// The most operations of a program: inlining without end is an error, not a full memory.
const MAX_OPS: usize = 100_000;

/// A value: its type and its register, and whether it can differ between points.
#[derive(Clone, Copy, Debug)]
pub(super) struct Value {
    pub(super) ty: Ty,
    /// Index of its register, among those of strings for text.
    index: u16,
    pub(super) varying: bool,
    /// Elements of an array, whose registers follow each other; 0 of a single value.
    pub(super) array: u16,
    /// Declared uniform.
    pub(super) fixed: bool,
}

/// The index of no register: where a value has another type than is asked for, which validation refuses.
const NOWHERE: u16 = u16::MAX;

impl Value {
    pub(super) fn of(ty: Ty, index: u16, varying: bool) -> Value {
        Value { ty, index, varying, array: 0, fixed: false }
    }

    /// Its register of numbers.
    pub(super) fn reg(self) -> Reg {
        match self.ty {
            Ty::Text => Reg::of(NOWHERE, 1),
            ty => Reg::of(self.index, width(ty)),
        }
    }

    /// Its register of a number.
    pub(super) fn float(self) -> FloatReg {
        self.reg().try_into().unwrap_or(FloatReg::of_index(NOWHERE))
    }

    /// Its register of a triple.
    pub(super) fn triple(self) -> TripleReg {
        self.reg().try_into().unwrap_or(TripleReg::of_index(NOWHERE))
    }

    /// Its register of a string.
    pub(super) fn text(self) -> TextReg {
        TextReg::of_index(if self.ty == Ty::Text { self.index } else { NOWHERE })
    }

    pub(super) fn operand(self) -> Operand {
        if self.ty == Ty::Text { Operand::Text(self.text()) } else { Operand::Number(self.reg()) }
    }

    /// The same numbers as another type of the same width.
    pub(super) fn taken_as(self, ty: Ty) -> Value {
        Value { ty, ..self }
    }

    /// An element of an array.
    pub(super) fn element(self, k: u16) -> Value {
        Value { index: self.index + k, array: 0, ..self }
    }
}

/// Numbers of a value of a type.
fn width(ty: Ty) -> usize {
    match ty {
        Ty::Matrix => 16,
        ty if ty.is_triple() => 3,
        _ => 1,
    }
}

#[derive(Default)]
pub(super) struct Lower<'a> {
    pub(super) functions: HashMap<&'a str, &'a Function>,
    pub(super) calling: Vec<&'a str>,
    pub(super) scopes: Vec<HashMap<String, Value>>,
    /// The scopes around the functions that are being inlined.
    pub(super) outer: Vec<Vec<HashMap<String, Value>>>,
    /// Where the result of each of them goes; none while `return` stands at the end alone.
    pub(super) results: Vec<Option<Value>>,
    pub(super) globals: Vec<(Global, Reg)>,
    pub(super) widths: Vec<u8>,
    pub(super) n_texts: u16,
    pub(super) ops: Vec<Op>,
    pub(super) n_ops: usize,
    /// What is lowered goes to a uniform variable.
    pub(super) for_uniform: bool,
    pub(super) kind: Option<ShaderKind>,
    /// Name of the shader.
    pub(super) name: String,
    /// What the shader asks for that is not done, for a warning.
    pub(super) unsupported: Vec<String>,
    pub(super) directed: bool,
    /// Loops around the statement, within its function.
    pub(super) loops: usize,
    /// Loops over lights around the statement, those around the functions that it is in too.
    pub(super) light_loops: usize,
    /// Within a loop over lights or rays that is in no other: whether it is left from within.
    pub(super) turns: Option<bool>,
}

impl<'a> Lower<'a> {
    pub(super) fn push(&mut self, at: usize, op: Op) -> Result<(), Error> {
        self.n_ops += 1;
        if self.n_ops > MAX_OPS {
            return error(at, format!("the shader has more than {MAX_OPS} operations after inlining"));
        }
        self.ops.push(op);
        Ok(())
    }

    pub(super) fn reg(&mut self, at: usize, ty: Ty) -> Result<u16, Error> {
        if self.widths.len() + 1 >= u16::MAX as usize || self.n_texts + 1 == u16::MAX {
            return error(at, "the shader has too many values");
        }
        if ty == Ty::Text {
            self.n_texts += 1;
            return Ok(self.n_texts - 1);
        }
        self.widths.push(width(ty) as u8);
        Ok(self.widths.len() as u16 - 1)
    }

    /// A new temporary, written by `op(register)`.
    pub(super) fn temp(
        &mut self,
        at: usize,
        ty: Ty,
        varying: bool,
        op: impl FnOnce(Value) -> Op,
    ) -> Result<Value, Error> {
        let value = Value::of(ty, self.reg(at, ty)?, varying);
        self.push(at, op(value))?;
        Ok(value)
    }

    pub(super) fn constant(&mut self, at: usize, x: f32) -> Result<Value, Error> {
        self.temp(at, Ty::Float, false, |r| Op::Const(r.reg(), x))
    }

    pub(super) fn text(&mut self, at: usize, text: &str) -> Result<Value, Error> {
        self.temp(at, Ty::Text, false, |r| Op::TextConst(r.text(), text.into()))
    }

    /// The operations of what `f` lowers, apart from the current block.
    pub(super) fn block<T>(&mut self, f: impl FnOnce(&mut Self) -> Result<T, Error>) -> Result<(Vec<Op>, T), Error> {
        let outer = std::mem::take(&mut self.ops);
        let result = f(self);
        let inner = std::mem::replace(&mut self.ops, outer);
        Ok((inner, result?))
    }

    pub(super) fn declare(&mut self, at: usize, name: &str, value: Value) -> Result<(), Error> {
        let scope = self.scopes.last_mut().expect("a scope is open");
        if scope.insert(name.into(), value).is_some() {
            return error(at, format!("`{name}` is already declared here"));
        }
        Ok(())
    }

    /// The value of a global variable.
    pub(super) fn global(&mut self, at: usize, global: Global) -> Result<Value, Error> {
        let ty = Ty::from(global.kind());
        if let Some((_, reg)) = self.globals.iter().find(|(g, _)| *g == global) {
            return Ok(Value::of(ty, reg.index() as u16, global.varies()));
        }
        let of_surface = !matches!(self.kind, Some(ShaderKind::Light | ShaderKind::Imager | ShaderKind::Volume));
        let lacks = match global {
            Global::DPdtime if !of_surface => {
                Some("uses `dPdtime`, which is 0 in it: surfaces and displacements have it")
            }
            Global::U | Global::V | Global::S | Global::T if self.kind == Some(ShaderKind::Light) => {
                Some("uses u, v, s or t, which are 0 in it: surfaces and displacements have them")
            }
            Global::Ol if matches!(self.kind, Some(ShaderKind::Imager | ShaderKind::Displacement)) => {
                Some("uses `Ol`, which is 0 in it: lights and loops over them have it")
            }
            _ => None,
        };
        self.unsupported.extend(lacks.map(String::from));
        let value = Value::of(ty, self.reg(at, ty)?, global.varies());
        self.globals.push((global, value.reg()));
        Ok(value)
    }

    pub(super) fn variable(&mut self, at: usize, name: &str) -> Result<Value, Error> {
        if let Some(value) = self.scopes.iter().rev().find_map(|s| s.get(name)) {
            return Ok(*value);
        }
        if let Some(global) = Global::of_name(name) {
            return self.global(at, global);
        }
        if name == "dPdu" || name == "dPdv" {
            let p = self.global(at, Global::P)?;
            return self.derivative(at, if name == "dPdu" { Builtin::DU } else { Builtin::DV }, p);
        }
        if name == "du" || name == "dv" {
            let x = self.global(at, if name == "du" { Global::U } else { Global::V })?;
            return self.temp(at, Ty::Float, true, |r| Op::Call(Builtin::WIDTH, r.reg(), vec![x.reg()]));
        }
        if name == "PI" {
            return self.constant(at, std::f32::consts::PI);
        }
        let locals = self.scopes.iter().flat_map(|s| s.keys().map(String::as_str));
        let near = nearest(name, locals.chain(Global::all().map(|g| g.name())));
        error(at, format!("unknown variable `{name}`{near}"))
    }

    /// A value as another type: a number as any triple, a point as a vector or normal and back.
    pub(super) fn convert(&mut self, at: usize, value: Value, to: Ty) -> Result<Value, Error> {
        if value.array != 0 {
            return error(at, format!("expected {}, found an array: which element?", to.name()));
        }
        let spatial = |t: Ty| t.is_triple() && t != Ty::Color;
        if value.ty == Ty::Float && to == Ty::Matrix {
            return self.temp(at, to, value.varying, |r| Op::Call(Builtin::DIAGONAL, r.reg(), vec![value.reg()]));
        }
        if value.ty == to || (spatial(value.ty) && spatial(to)) {
            return Ok(value.taken_as(to));
        }
        if value.ty == Ty::Float && to.is_triple() {
            return self.temp(at, to, value.varying, |r| Op::Unary(Unary::Copy, r.reg(), value.reg()));
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

    /// The number of a value that this block makes of constants.
    pub(super) fn constant_of(&self, value: Value) -> Option<f32> {
        self.constant_in(value.reg())
    }

    fn constant_in(&self, reg: Reg) -> Option<f32> {
        self.ops.iter().rev().find_map(|op| match op {
            Op::Const(r, x) if *r == reg => Some(Some(*x)),
            Op::Unary(f, r, a) if *r == reg => Some(self.constant_in(*a).map(|a| unary_value(*f, a))),
            Op::Binary(f, r, a, b) if *r == reg => {
                Some(self.constant_in(*a).zip(self.constant_in(*b)).map(|(a, b)| binary_value(*f, a, b)))
            }
            _ => None,
        })?
    }
}

/// `, did you mean …?` with the candidate nearest in spelling, or nothing.
pub(super) fn nearest<'n>(name: &str, candidates: impl Iterator<Item = &'n str>) -> String {
    candidates
        .map(|c| (strsim::damerau_levenshtein(name, c), c))
        .filter(|(d, c)| *d <= 1 + c.len() / 4)
        .min()
        .map_or(String::new(), |(_, c)| format!(", did you mean `{c}`?"))
}
