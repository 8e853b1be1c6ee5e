//! Calls that ask the scene, or that change a variable.

use super::super::ast::*;
use super::super::diagnostic::{Error, error, error_with};
use super::state::{Lower, Value};
use crate::ir::builtins::Form;
use crate::ir::*;

impl<'a> Lower<'a> {
    /// A call whose arguments are names and variables.
    pub(super) fn scene_form(
        &mut self,
        at: usize,
        name: &str,
        form: Form,
        args: &[Expr],
        expected: Option<Ty>,
    ) -> Result<Value, Error> {
        match form {
            Form::Ask(what) => self.ask(at, name, what, args),
            Form::Map(Lookup::Shadow) => self.map(at, Lookup::Shadow, args, expected.or(Some(Ty::Float))),
            Form::Map(how) => self.map(at, how, args, expected),
            Form::SetComponent(component) => self.set_component(at, name, component, args),
            _ => {
                self.unsupported.push(format!("calls `{name}`: nothing is baked, and nothing is found that was"));
                for arg in args {
                    self.expr(arg, None)?;
                }
                self.constant(at, 0.0)
            }
        }
    }

    /// A question by name, whose answer goes to a variable.
    fn ask(&mut self, at: usize, name: &str, ask: Ask, args: &[Expr]) -> Result<Value, Error> {
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
            names.push(value.text());
        }
        let ExprKind::Name(variable) = &args[n_names].kind else {
            return error(args[n_names].at, "expected a variable for the answer");
        };
        let var = self.variable(args[n_names].at, variable)?;
        let (out, len) = (var.operand(), var.array.max(1));
        self.temp(at, Ty::Float, false, |r| Op::Ask { dst: r.float(), what: ask, names, out, len, place: at as u32 })
    }

    /// Whether an expression names an array.
    fn is_array(&self, e: &Expr) -> bool {
        let ExprKind::Name(name) = &e.kind else { return false };
        self.scopes.iter().rev().find_map(|s| s.get(name)).is_some_and(|value| value.array != 0)
    }

    /// `texture`, `environment` and `shadow`.
    pub(super) fn map(&mut self, at: usize, how: Lookup, args: &[Expr], expected: Option<Ty>) -> Result<Value, Error> {
        let Some((first, rest)) = args.split_first() else { return error(at, "expected the name of a map") };
        let (name, channel) = match &first.kind {
            ExprKind::Index(name, channel) if !self.is_array(name) => {
                let channel = self.expr(channel, Some(Ty::Float))?;
                (self.expr(name, None)?, self.convert(first.at, channel, Ty::Float)?)
            }
            _ => (self.expr(first, None)?, self.constant(at, 0.0)?),
        };
        if name.ty != Ty::Text {
            return error(first.at, format!("expected the name of a map, found {}", name.ty.name()));
        }
        self.convert(first.at, name, Ty::Text)?;
        let mut values = Vec::new();
        for arg in rest {
            let value = self.expr(arg, None)?;
            values.push(self.convert(arg.at, value, value.ty)?);
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
        let mut at_regs: Vec<Reg> = place.iter().map(|v| v.reg()).collect();
        if how == Lookup::Texture && at_regs.is_empty() {
            // Those of the surface, whatever variables of the shader have their names.
            at_regs = vec![self.global(at, Global::S)?.reg(), self.global(at, Global::T)?.reg()];
        }
        let mut named = Vec::new();
        for pair in options.chunks(2) {
            match pair {
                [key, value] if key.ty == Ty::Text => named.push((key.text(), value.operand())),
                _ => return error(at, "expected options as a name and a value each"),
            }
        }
        let ty = expected.filter(|t| *t == Ty::Float || t.is_triple()).unwrap_or(Ty::Color);
        self.temp(at, ty, true, |r| Op::Map {
            dst: r.reg(),
            how,
            name: name.text(),
            channel: channel.float(),
            at: at_regs,
            options: named,
            place: at as u32,
        })
    }

    /// `setcomp` and its kin.
    pub(super) fn set_component(
        &mut self,
        at: usize,
        name: &str,
        component: Option<u8>,
        args: &[Expr],
    ) -> Result<Value, Error> {
        let expected = || error(at, format!("expected a variable as the first argument of `{name}`"));
        let Some(first) = args.first() else { return expected() };
        // A variable, or an element of one that is an array.
        let (var, index) = match &first.kind {
            ExprKind::Name(variable) => (self.variable(at, variable)?, None),
            ExprKind::Index(array, index) => match &array.kind {
                ExprKind::Name(variable) => (self.variable(at, variable)?, Some(index)),
                _ => return expected(),
            },
            _ => return expected(),
        };
        let own = if index.is_some() { self.expr(first, None)? } else { var };
        let mut regs = vec![own.reg()];
        if let Some(k) = component {
            regs.push(self.constant(at, k as f32)?.reg());
        }
        let mut given = Vec::new();
        for arg in &args[1..] {
            let value = self.expr(arg, Some(Ty::Float))?;
            given.push(self.convert(arg.at, value, Ty::Float)?);
        }
        regs.extend(given.iter().map(|v| v.reg()));
        let wanted = if own.ty == Ty::Matrix { 4 } else { 3 };
        if regs.len() != wanted || !(own.ty.is_triple() || own.ty == Ty::Matrix) {
            return error(at, format!("other arguments of `{name}`: a triple or a matrix, its index, and a number"));
        }
        if component.is_none() {
            self.within(at, &given[..wanted - 2], if wanted == 4 { 4 } else { 3 })?;
        }
        let function = if own.ty == Ty::Matrix { Builtin::SET_MATRIX_COMPONENT } else { Builtin::SET_COMPONENT };
        let new = self.temp(at, own.ty, true, |r| Op::Call(function, r.reg(), regs))?;
        match index {
            Some(index) => self.store_element(at, var, index, new)?,
            None => self.store(at, var, new)?,
        }
        Ok(Value::of(Ty::Void, 0, false))
    }
}
