//! Functions that lowering has a rule for: those whose arguments no row describes, or that become several operations.

use super::super::ast::*;
use super::super::diagnostic::{Error, error};
use super::call::{fits, result};
use super::state::{Lower, Value};
use crate::ir::builtins::{Form, Row, rows};
use crate::ir::*;

impl Lower<'_> {
    /// An error if a constant among the indices of components is none of `n`; a warning of others as the shader runs.
    pub(super) fn within(&mut self, at: usize, indices: &[Value], n: u16) -> Result<(), Error> {
        for index in indices {
            match self.constant_of(*index) {
                Some(i) if !(0.0..n as f32).contains(&i) => {
                    return error(at, format!("the index of a component is {i}, expected 0 to {}", n - 1));
                }
                Some(_) => {}
                None => self.push(at, Op::Within(index.float(), n, at as u32))?,
            }
        }
        Ok(())
    }

    /// A call by a rule. Long, because it is the list of the rules.
    pub(super) fn form(
        &mut self,
        at: usize,
        row: &Row,
        form: Form,
        v: &[Value],
        expected: Option<Ty>,
    ) -> Result<Value, Error> {
        let varying = v.iter().any(|v| v.varying);
        let types: Vec<Ty> = v.iter().map(|v| v.ty).collect();
        match (form, types.as_slice()) {
            (Form::SignedNoise, _) => {
                let Some((noise, row)) = rows("noise").find(|(_, row)| fits(row, v)) else {
                    return error(at, format!("expected {}", row.usage));
                };
                let noise = self.called(at, noise, result(row.gives, v, expected), varying, v)?;
                let (two, one) = (self.constant(at, 2.0)?, self.constant(at, 1.0)?);
                let twice = self.arithmetic(at, "*", noise, two)?;
                self.arithmetic(at, "-", twice, one)
            }
            (Form::Random, []) => {
                let ty = expected.filter(|t| t.is_triple()).unwrap_or(Ty::Float);
                let (p, salt) = (self.global(at, Global::P)?, self.constant(at, self.n_ops as f32)?);
                // For a uniform variable it is one number a grid, otherwise one a point.
                if self.for_uniform {
                    self.called(at, Builtin::RANDOM_OF_GRID, ty, false, &[salt])
                } else {
                    self.called(at, Builtin::RANDOM, ty, true, &[salt, p])
                }
            }
            (Form::Spline, _) => self.spline(at, v),
            (Form::ColorTransform, [Ty::Text, c]) if c.is_triple() => {
                let from = self.text(at, "rgb")?;
                self.temp(at, Ty::Color, varying, |r| {
                    Op::ColorSpace(r.triple(), v[1].triple(), from.text(), v[0].text(), at as u32)
                })
            }
            (Form::ColorTransform, [Ty::Text, Ty::Text, c]) if c.is_triple() => {
                self.temp(at, Ty::Color, varying, |r| {
                    Op::ColorSpace(r.triple(), v[2].triple(), v[0].text(), v[1].text(), at as u32)
                })
            }
            (Form::MatrixTransform, [Ty::Text, Ty::Matrix]) => {
                let from = self.text(at, "current")?;
                self.temp(at, Ty::Matrix, varying, |r| {
                    Op::Transform(Transform::Matrix, r.reg(), v[1].reg(), from.text(), v[0].text(), at as u32)
                })
            }
            (Form::MatrixTransform, [Ty::Text, Ty::Text, Ty::Matrix]) => self.temp(at, Ty::Matrix, varying, |r| {
                Op::Transform(Transform::Matrix, r.reg(), v[2].reg(), v[0].text(), v[1].text(), at as u32)
            }),
            (Form::Concat, list) if !list.is_empty() && list.iter().all(|t| *t == Ty::Text) => {
                let pattern = self.text(at, &"%s".repeat(list.len()))?;
                let args = std::iter::once(pattern).chain(v.iter().copied()).map(Value::operand).collect();
                self.temp(at, Ty::Text, false, |r| Op::Format(r.text(), args, at as u32))
            }
            (Form::Format, [Ty::Text, ..]) => {
                let args = v.iter().copied().map(Value::operand).collect();
                self.temp(at, Ty::Text, false, |r| Op::Format(r.text(), args, at as u32))
            }
            (Form::Print, [Ty::Text, ..]) => {
                self.push(at, Op::Print(v.iter().copied().map(Value::operand).collect()))?;
                Ok(Value::of(Ty::Void, 0, false))
            }
            (Form::ShaderName, []) => {
                let name = self.name.clone();
                self.text(at, &name)
            }
            (Form::ShaderName, [Ty::Text]) => {
                let (names, nothing) = (vec![v[0].text()], self.text(at, "")?);
                let name = self.temp(at, Ty::Text, false, |r| Op::TextCopy(r.text(), nothing.text()))?;
                let what = Ask::ShaderName;
                self.temp(at, Ty::Float, false, |r| Op::Ask {
                    dst: r.float(),
                    what,
                    names,
                    out: name.operand(),
                    len: 1,
                    place: at as u32,
                })?;
                Ok(name)
            }
            (Form::Match, [Ty::Text, Ty::Text]) => {
                self.temp(at, Ty::Float, false, |r| Op::Match(r.float(), v[0].text(), v[1].text()))
            }
            (Form::Mix, [a, b, Ty::Float]) if *a != Ty::Text && (a == b || (a.is_triple() && b.is_triple())) => {
                self.called(at, Builtin::MIX, *a, varying, v)
            }
            (Form::Mix, [a, b, Ty::Float]) if *a != Ty::Text && *b != Ty::Text => {
                let ty = if *a == Ty::Float { *b } else { *a };
                let (a, b) = (self.convert(at, v[0], ty)?, self.convert(at, v[1], ty)?);
                self.called(at, Builtin::MIX, ty, varying, &[a, b, v[2]])
            }
            (Form::Mix, [a, b, c]) if [a, b, c].into_iter().all(|t| *t == Ty::Color) => {
                let way = self.arithmetic(at, "-", v[1], v[0])?;
                let part = self.arithmetic(at, "*", way, v[2])?;
                self.arithmetic(at, "+", v[0], part)
            }
            (Form::Clamp, [a, lo, hi]) if [a, lo, hi].iter().all(|t| **t != Ty::Text) => {
                let low = self.componentwise(at, Binary::Max, v[0], v[1])?;
                self.componentwise(at, Binary::Min, low, v[2])
            }
            (Form::FaceForward, [n, i]) if n.is_triple() && i.is_triple() => {
                // By the surface's own normal (RISpec 15.2); lights, volumes and imagers have none.
                let of_surface = matches!(self.kind, Some(ShaderKind::Surface | ShaderKind::Displacement));
                let reference = if of_surface { self.global(at, Global::Ng)? } else { v[0] };
                let varying = varying || of_surface;
                self.called(at, Builtin::FACE_FORWARD, Ty::Normal, varying, &[v[0], v[1], reference])
            }
            (Form::FaceForward, [n, i, reference]) if [n, i, reference].iter().all(|t| t.is_triple()) => {
                self.called(at, Builtin::FACE_FORWARD, Ty::Normal, varying, v)
            }
            (Form::Du, [t]) if *t != Ty::Text => self.derivative(at, Builtin::DU, v[0]),
            (Form::Dv, [t]) if *t != Ty::Text => self.derivative(at, Builtin::DV, v[0]),
            (Form::Deriv, [a, Ty::Float]) if *a != Ty::Text => {
                let (au, bu) = (self.derivative(at, Builtin::DU, v[0])?, self.derivative(at, Builtin::DU, v[1])?);
                let (av, bv) = (self.derivative(at, Builtin::DV, v[0])?, self.derivative(at, Builtin::DV, v[1])?);
                let (u, w) = (self.arithmetic(at, "/", au, bu)?, self.arithmetic(at, "/", av, bv)?);
                self.arithmetic(at, "+", u, w)
            }
            (Form::Component, [Ty::Matrix, Ty::Float, Ty::Float]) => {
                self.within(at, &v[1..], 4)?;
                self.called(at, Builtin::MATRIX_COMPONENT, Ty::Float, varying, v)
            }
            (Form::Component, [t, Ty::Float]) if t.is_triple() => {
                self.within(at, &v[1..], 3)?;
                match self.constant_of(v[1]) {
                    Some(i) => self.temp(at, Ty::Float, varying, |r| Op::Component(r.float(), v[0].triple(), i as u8)),
                    None => self.called(at, Builtin::COMPONENT, Ty::Float, varying, v),
                }
            }
            (Form::Transform(how), _) => self.transform(at, row, how, v),
            _ => error(at, format!("expected {}", row.usage)),
        }
    }

    /// `transform` and its kin: by spaces or by a matrix.
    fn transform(&mut self, at: usize, row: &Row, how: Transform, v: &[Value]) -> Result<Value, Error> {
        let varying = v.iter().any(|v| v.varying);
        let types: Vec<Ty> = v.iter().map(|v| v.ty).collect();
        let ty = match how {
            Transform::Point => Ty::Point,
            Transform::Vector => Ty::Vector,
            Transform::Normal => Ty::Normal,
            Transform::Matrix => Ty::Matrix,
        };
        match types.as_slice() {
            [Ty::Matrix, t] if t.is_triple() => {
                let function = match how {
                    Transform::Point => Builtin::MATRIX_POINT,
                    Transform::Vector => Builtin::MATRIX_VECTOR,
                    _ => Builtin::MATRIX_NORMAL,
                };
                self.called(at, function, ty, varying, v)
            }
            [Ty::Text, Ty::Matrix, t] if t.is_triple() => {
                // From a named space by a matrix that is given in it.
                let now = self.text(at, "current")?;
                let there = self.temp(at, ty, varying, |r| {
                    Op::Transform(how, r.reg(), v[2].reg(), v[0].text(), now.text(), at as u32)
                })?;
                let function = if how == Transform::Point { Builtin::MATRIX_POINT } else { Builtin::MATRIX_VECTOR };
                self.called(at, function, ty, varying, &[v[1], there])
            }
            [Ty::Text, t] if t.is_triple() => {
                let from = self.text(at, "current")?;
                self.temp(at, ty, varying, |r| {
                    Op::Transform(how, r.reg(), v[1].reg(), from.text(), v[0].text(), at as u32)
                })
            }
            [Ty::Text, Ty::Text, t] if t.is_triple() => self.temp(at, ty, varying, |r| {
                Op::Transform(how, r.reg(), v[2].reg(), v[0].text(), v[1].text(), at as u32)
            }),
            _ => error(at, format!("expected {}", row.usage)),
        }
    }

    /// `spline([basis,] value, knots …)` or with an array of knots.
    pub(super) fn spline(&mut self, at: usize, v: &[Value]) -> Result<Value, Error> {
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
            list.extend((0..knot.array.max(1)).map(|k| knot.element(k)));
        }
        if value.ty != Ty::Float || list.len() < 4 {
            return error(at, wrong);
        }
        self.check_basis(at, basis, list.len())?;
        let mut args = vec![value.reg()];
        for knot in list {
            args.push(self.convert(at, knot, ty)?.reg());
        }
        let varying = v.iter().any(|v| v.varying);
        self.temp(at, ty, varying, |r| Op::Spline(r.reg(), basis.text(), args))
    }

    /// An error if a basis that is written in its place is none, or the knots do not make whole segments of it (RISpec 15.1).
    fn check_basis(&self, at: usize, basis: Value, n: usize) -> Result<(), Error> {
        let written = self.ops.iter().rev().find_map(|op| match op {
            Op::TextConst(dst, text) if *dst == basis.text() => Some(text.as_str()),
            _ => None,
        });
        let Some(name) = written else { return Ok(()) };
        let (first, step) = match name.strip_prefix("solve").unwrap_or(name) {
            "catmull-rom" | "bspline" | "b-spline" | "linear" => return Ok(()),
            "bezier" => (4, 3),
            "hermite" => (4, 2),
            _ => {
                let known =
                    "expected catmull-rom, bspline, bezier, hermite or linear, with `solve` before it to invert it";
                return error(at, format!("unknown basis `{name}` of `spline`, {known}"));
            }
        };
        if (n - first).is_multiple_of(step) {
            return Ok(());
        }
        error(at, format!("a `{name}` spline has {first} knots and {step} more for each further segment, found {n}"))
    }

    pub(super) fn derivative(&mut self, at: usize, f: Builtin, x: Value) -> Result<Value, Error> {
        let (u, v) = (self.global(at, Global::U)?.reg(), self.global(at, Global::V)?.reg());
        let ty = if x.ty == Ty::Point { Ty::Vector } else { x.ty };
        self.temp(at, ty, true, |r| Op::Call(f, r.reg(), vec![x.reg(), u, v]))
    }
}
