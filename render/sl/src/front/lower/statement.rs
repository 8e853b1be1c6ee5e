//! Statements.

use super::super::ast::*;
use super::super::diagnostic::{Error, error, error_with};
use super::state::{Lower, Value};
use crate::ir::*;
use std::collections::HashMap;

impl<'a> Lower<'a> {
    pub(super) fn statement(&mut self, s: &'a Stmt) -> Result<(), Error> {
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
                self.push(at, Op::If(condition.float(), then, otherwise))
            }
            StmtKind::While(condition, body) => self.repeat(at, condition, body, None),
            StmtKind::For(start, condition, step, body) => {
                self.statement(start)?;
                self.repeat(at, condition, body, Some(step))
            }
            // The one beyond all loops is that over lights or rays, by the loops that `turns` puts around its body.
            StmtKind::Break(n) | StmtKind::Continue(n) if self.loops + 1 == *n && self.turns.is_some() => {
                self.turns = Some(true);
                let leaves_all = matches!(s.kind, StmtKind::Break(_));
                self.push(at, Op::Break(if leaves_all { *n + 1 } else { *n } as u16))
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
                    let found = match (found, Global::of_name(name)) {
                        (Some(found), _) => found,
                        (None, Some(global)) => self.global(*at, global)?,
                        (None, None) => return error(*at, format!("there is no `{name}` around this function")),
                    };
                    self.declare(*at, name, found)?;
                }
                Ok(())
            }
            StmtKind::Gather(args, hit, miss) => self.gather(at, args, hit, miss.as_deref()),
            StmtKind::Light(which, args, body) => self.light(at, which, args, body),
        }
    }

    pub(super) fn scoped(&mut self, body: &'a [Stmt]) -> Result<(), Error> {
        self.scopes.push(HashMap::new());
        let done = body.iter().try_for_each(|s| self.statement(s));
        self.scopes.pop();
        done
    }

    /// `return`.
    pub(super) fn give_back(&mut self, at: usize, value: Option<&Expr>) -> Result<(), Error> {
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

    pub(super) fn condition(&mut self, e: &Expr) -> Result<Value, Error> {
        let value = self.expr(e, Some(Ty::Float))?;
        if value.ty == Ty::Float {
            Ok(value)
        } else {
            let hint = "compare it with something, as in `length(v) > 0`";
            error_with(e.at, format!("expected a condition, found {}", value.ty.name()), hint)
        }
    }

    pub(super) fn repeat(
        &mut self,
        at: usize,
        condition: &Expr,
        body: &'a Stmt,
        step: Option<&'a Stmt>,
    ) -> Result<(), Error> {
        let (head, condition) = self.block(|l| l.condition(condition))?;
        self.loops += 1;
        let body = self.block(|l| l.scoped(std::slice::from_ref(body)));
        self.loops -= 1;
        let (step, ()) = self.block(|l| step.map_or(Ok(()), |s| l.statement(s)))?;
        self.push(at, Op::Loop(head, condition.float(), body?.0, step, at as u32))
    }

    pub(super) fn light(&mut self, at: usize, which: &str, args: &[Expr], body: &'a Stmt) -> Result<(), Error> {
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
                category = Some(values.remove(0).text());
            }
            let n = args.len() - values.len();
            if let Some(k) = values.iter().position(|v| v.ty == Ty::Text) {
                wanted = self.wanted(&args[n + k..])?;
                values.truncate(k);
            }
        }
        let l = self.global(at, Global::L)?.triple();
        let types: Vec<Ty> = values.iter().map(|v| v.ty).collect();
        let spatial = |i: usize| types.get(i).is_some_and(|t| t.is_triple());
        let angle = |i: usize| types.get(i) == Some(&Ty::Float);
        let (pi, zero) = (self.constant(at, std::f32::consts::PI)?, self.constant(at, 0.0)?);
        let nowhere = self.convert(at, zero, Ty::Vector)?;
        if which == "solar" {
            self.directed = true;
            let (axis, angle) = match types.len() {
                0 => (nowhere.triple(), pi.float()),
                2 if spatial(0) && angle(1) => (values[0].triple(), values[1].float()),
                _ => return error(at, "expected solar() or solar(axis, angle)"),
            };
            let (body, ()) = self.block(|l| l.scoped(std::slice::from_ref(body)))?;
            return self.push(at, Op::Solar { axis, angle, l, body });
        }
        let (position, axis, angle) = match types.len() {
            1 if spatial(0) => (values[0].triple(), nowhere.triple(), pi.float()),
            3 if spatial(0) && spatial(1) && angle(2) => (values[0].triple(), values[1].triple(), values[2].float()),
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
            let ps = self.global(at, Global::Ps)?.triple();
            let (body, ()) = self.block(|l| l.scoped(std::slice::from_ref(body)))?;
            return self.push(at, Op::Illuminate { position, axis, angle, l, ps, body });
        }
        let outer = if self.light_loops > 0 { self.own_light(at)? } else { vec![] };
        let [l, cl] = [self.global(at, Global::L)?, self.global(at, Global::Cl)?].map(Value::triple);
        self.light_loops += 1;
        let lowered = self.turns(at, [Some(body), None]);
        self.light_loops -= 1;
        let ([body, _], leaves) = lowered?;
        let mut wanted: Vec<(String, Reg)> =
            wanted.into_iter().map(|(n, r)| (n.trim_start_matches("light:").to_string(), r)).collect();
        let opacity = self.globals.iter().find(|(g, _)| *g == Global::Ol);
        wanted.extend(opacity.map(|(g, r)| (g.name().to_string(), *r)));
        outer.into_iter().for_each(|(k, reg)| self.globals[k].1 = reg);
        self.over_turns(at, leaves, Op::Illuminance { position, axis, angle, l, cl, category, wanted, body })
    }

    /// Have a loop over lights within another set registers of its own, so that the other's light stays as it is. Returns the places of the variables
    /// among the globals, and their registers in the other.
    fn own_light(&mut self, at: usize) -> Result<Vec<(usize, Reg)>, Error> {
        let is_set = |global: Global| matches!(global, Global::L | Global::Cl | Global::Ol);
        let places: Vec<usize> = (0..self.globals.len()).filter(|k| is_set(self.globals[*k].0)).collect();
        let own = |k: usize| {
            let ty = Ty::from(self.globals[k].0.kind());
            let own = self.empty_variable(at, ty)?;
            Ok((k, std::mem::replace(&mut self.globals[k].1, own.reg())))
        };
        places.into_iter().map(own).collect()
    }

    /// The bodies of a loop over lights or rays, and whether they leave it or go on with its next turn. By the specification `break` and
    /// `continue` are those of the `for` or `while` around; where there is none, they are this loop's: a turn is then a loop that is done
    /// once, and all turns are within another.
    fn turns(&mut self, at: usize, bodies: [Option<&'a Stmt>; 2]) -> Result<([Vec<Op>; 2], bool), Error> {
        let outer = self.turns.replace(false);
        if self.loops > 0 {
            self.turns = None;
        }
        let lowered = bodies.map(|body| self.block(|l| body.map_or(Ok(()), |b| l.scoped(std::slice::from_ref(b)))));
        let leaves = std::mem::replace(&mut self.turns, outer) == Some(true);
        let [a, b] = lowered.map(|body| body.map(|(ops, ())| ops));
        let (mut a, mut b) = (a?, b?);
        if leaves {
            for body in [&mut a, &mut b] {
                *body = self.once(at, std::mem::take(body))?;
            }
        }
        Ok(([a, b], leaves))
    }

    /// A loop over lights or rays, within another that is done once if its bodies leave it.
    fn over_turns(&mut self, at: usize, leaves: bool, op: Op) -> Result<(), Error> {
        if !leaves {
            return self.push(at, op);
        }
        for op in self.once(at, vec![op])? {
            self.push(at, op)?;
        }
        Ok(())
    }

    /// A loop that is done once.
    fn once(&mut self, at: usize, mut body: Vec<Op>) -> Result<Vec<Op>, Error> {
        let (head, one) = self.block(|l| l.constant(at, 1.0))?;
        body.push(Op::Break(1));
        Ok(vec![Op::Loop(head, one.float(), body, vec![], at as u32)])
    }

    /// Pairs of a name and the variable that takes it.
    pub(super) fn wanted(&mut self, args: &[Expr]) -> Result<Vec<(String, Reg)>, Error> {
        let mut out = Vec::new();
        for pair in args.chunks(2) {
            let [Expr { kind: ExprKind::Text(name), .. }, to] = pair else {
                return error(pair[0].at, "expected a name in quotes and a variable for it");
            };
            if !name.contains(':') {
                continue;
            }
            match &to.kind {
                ExprKind::Name(variable) => {
                    let variable = self.variable(to.at, variable)?;
                    if variable.ty == Ty::Text {
                        return error(to.at, format!("expected a variable of numbers for \"{name}\""));
                    }
                    out.push((name.clone(), variable.reg()));
                }
                _ => return error(to.at, format!("expected a variable for \"{name}\"")),
            }
        }
        Ok(out)
    }

    pub(super) fn gather(
        &mut self,
        at: usize,
        args: &'a [Expr],
        hit: &'a Stmt,
        miss: Option<&'a Stmt>,
    ) -> Result<(), Error> {
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
        let ([hit, miss], leaves) = self.turns(at, [Some(hit), miss])?;
        let (position, axis) = (values[1].triple(), values[2].triple());
        let (angle, samples) = (values[3].float(), values[4].float());
        self.over_turns(at, leaves, Op::Gather { position, axis, angle, samples, out, hit, miss })
    }
}
