//! User functions, inlined where they are called.

use super::super::ast::*;
use super::super::diagnostic::{Error, error, error_with};
use super::state::{Lower, Value};
use crate::ir::*;
use std::collections::HashMap;

impl<'a> Lower<'a> {
    /// A user function's body in place of its call.
    pub(super) fn inline(&mut self, at: usize, function: &'a Function, args: &[Expr]) -> Result<Value, Error> {
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

    pub(super) fn function_body(&mut self, at: usize, function: &'a Function) -> Result<Value, Error> {
        let early = function.body.split_last().is_some_and(|(last, before)| {
            before.iter().any(returns) || (returns(last) && !matches!(last.kind, StmtKind::Return(_)))
        });
        let (loops, turns) = (std::mem::take(&mut self.loops), self.turns.take());
        let result = if early { self.body_with_returns(at, function) } else { self.plain_body(at, function) };
        (self.loops, self.turns) = (loops, turns);
        result
    }

    /// A body that may be left anywhere: its result is a variable.
    pub(super) fn body_with_returns(&mut self, at: usize, function: &'a Function) -> Result<Value, Error> {
        let result = if function.ret == Ty::Void {
            Value::of(Ty::Void, 0, false)
        } else {
            self.empty_variable(at, function.ret)?
        };
        self.results.push(Some(result));
        let body = self.block(|l| function.body.iter().try_for_each(|s| l.statement(s)));
        self.results.pop();
        self.push(at, Op::Inline(body?.0))?;
        Ok(result)
    }

    pub(super) fn plain_body(&mut self, at: usize, function: &'a Function) -> Result<Value, Error> {
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
