//! Calls of built-in functions.

use super::super::ast::*;
use super::super::builtins::{Arg, How, SIGNATURES, SPECIAL};
use super::super::diagnostic::{Error, error, error_with};
use super::state::nearest;
use super::state::{Lower, Value};
use crate::ir::*;

impl<'a> Lower<'a> {
    pub(super) fn call(&mut self, at: usize, name: &str, args: &[Expr], expected: Option<Ty>) -> Result<Value, Error> {
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

    pub(super) fn special(&mut self, at: usize, name: &str, v: &[Value], expected: Option<Ty>) -> Result<Value, Error> {
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

    pub(super) fn derivative(&mut self, at: usize, f: Builtin, x: Value) -> Result<Value, Error> {
        let (u, v) =
            (self.global(at, "u")?.expect("u is a global").reg, self.global(at, "v")?.expect("v is a global").reg);
        let ty = if x.ty == Ty::Point { Ty::Vector } else { x.ty };
        self.temp(at, ty, true, |r| Op::Call(f, r, vec![x.reg, u, v]))
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
