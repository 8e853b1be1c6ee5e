//! Calls of shading functions: the row of a call, and the operation that it stands for.

use super::super::ast::*;
use super::super::diagnostic::{Error, error, error_with};
use super::state::{Lower, Value, nearest};
use crate::ir::builtins::{Arg, Form, Gives, How, Row, TABLE, rows};
use crate::ir::*;

impl<'a> Lower<'a> {
    pub(super) fn call(&mut self, at: usize, name: &str, args: &[Expr], expected: Option<Ty>) -> Result<Value, Error> {
        let (form, plain) = form_of(name, args);
        if let Some(form) = form.filter(|form| form.starts_with("filterstep")) {
            return self.filter_step(at, form, args, plain);
        }
        self.reads_over(name, form.is_some() && plain < args.len());
        let (name, args) = form.map_or((name, args), |form| (form, &args[..plain]));
        if let Some(function) = self.functions.get(name).copied() {
            return self.inline(at, function, args);
        }
        let overloads = rows(name).filter(|(_, row)| !matches!(row.how, How::Prelude(..)));
        let Some((_, first)) = overloads.clone().next() else {
            let named = TABLE.iter().filter(|row| is_of_values(row)).map(|row| row.name);
            let message =
                format!("unknown function `{name}`{}", nearest(name, self.functions.keys().copied().chain(named)));
            return error_with(at, message, "functions of one's own stand before the shader, or come by `#include`");
        };
        if let How::Form(form) = first.how
            && !is_of_values(first)
        {
            return self.scene_form(at, name, form, args, expected);
        }
        let mut values = Vec::new();
        for (i, arg) in args.iter().enumerate() {
            let hint = match first.takes.get(i).filter(|_| first.usage.is_empty()) {
                Some(Arg::Float) => Some(Ty::Float),
                Some(Arg::Triple | Arg::Direction) => Some(Ty::Vector),
                Some(Arg::Matrix) => Some(Ty::Matrix),
                Some(Arg::Any | Arg::Value) => expected,
                None if matches!(first.how, How::Form(Form::Clamp | Form::Mix)) && i < 2 => expected,
                None => None,
            };
            values.push(self.expr(arg, hint)?);
        }
        if let How::Form(form) = first.how {
            return self.form(at, first, form, &values, expected);
        }
        if first.usage.is_empty() {
            // Options by name that follow the arguments ask for nothing that would be done otherwise here.
            let options = values.iter().position(|v| v.ty == Ty::Text).unwrap_or(values.len());
            self.reads_over(name, options < values.len());
            values.truncate(options);
        }
        // min and max of more than two are taken two at a time.
        if let How::Binary(f @ (Binary::Min | Binary::Max)) = first.how
            && values.len() > 2
        {
            let mut result = values[0];
            for value in &values[1..] {
                result = self.componentwise(at, f, result, *value)?;
            }
            return Ok(result);
        }
        let Some((function, row)) = overloads.clone().find(|(_, row)| fits(row, &values)) else {
            if !first.usage.is_empty() {
                return error(at, format!("expected {}", first.usage));
            }
            let found: Vec<&str> = values.iter().map(|v| v.ty.name()).collect();
            let takes: Vec<String> = overloads.map(|(_, row)| signature(name, row.takes)).collect();
            return error(at, format!("expected {}, found {name}({})", takes.join(" or "), found.join(", ")));
        };
        let varying = row.varying || values.iter().any(|v| v.varying);
        for (value, arg) in values.iter_mut().zip(row.takes) {
            if *arg == Arg::Matrix {
                *value = self.convert(at, *value, Ty::Matrix)?;
            }
        }
        let ty = result(row.gives, &values, expected);
        match row.how {
            How::Unary(f) => self.temp(at, ty, varying, |r| Op::Unary(f, r.reg(), values[0].reg())),
            How::Binary(f) => self.componentwise(at, f, values[0], values[1]),
            How::Component(c) => self.temp(at, ty, varying, |r| Op::Component(r.float(), values[0].triple(), c)),
            How::Grid(_) | How::Scene(_) => self.called(at, function, ty, varying, &values),
            How::Form(_) | How::Prelude(..) => unreachable!("done above"),
        }
    }

    /// A step under a filter: how far the filter is from the edge, in parts of its width, then the sum of the filter up to there.
    /// Options by name begin at `plain` (RISpec 15.1, appendix E).
    fn filter_step(&mut self, at: usize, form: &str, args: &[Expr], plain: usize) -> Result<Value, Error> {
        let (mut width, mut filter, mut is_other) = (Expr { at, kind: ExprKind::Number(1.0) }, "step_box_", false);
        for option in args[plain..].chunks(2) {
            match option {
                [Expr { kind: ExprKind::Text(key), .. }, given] if matches!(key.as_str(), "width" | "swidth") => {
                    width = given.clone();
                }
                [Expr { kind: ExprKind::Text(key), .. }, Expr { kind: ExprKind::Text(name), .. }]
                    if key == "filter" =>
                {
                    match name.as_str() {
                        "box" => filter = "step_box_",
                        "triangle" => filter = "step_triangle_",
                        "gaussian" => filter = "step_gaussian_",
                        "catmull-rom" => filter = "step_catmullrom_",
                        _ => is_other = true,
                    }
                }
                _ => is_other = true,
            }
        }
        self.reads_over("filterstep", is_other);
        let own = args[..plain].iter().cloned().chain([width]).collect();
        let along = Expr { at, kind: ExprKind::Call(form.into(), own) };
        match self.functions.get(filter).copied() {
            Some(function) => self.inline(at, function, &[along]),
            None => error(at, format!("`{filter}` is not known")),
        }
    }

    /// Note that a function is given options by name, if it is.
    fn reads_over(&mut self, name: &str, is_given: bool) {
        if is_given {
            self.unsupported.push(format!("gives `{name}` options by name, which are read over"));
        }
    }

    /// A call of a function by its row.
    pub(super) fn called(
        &mut self,
        at: usize,
        function: Builtin,
        ty: Ty,
        varying: bool,
        args: &[Value],
    ) -> Result<Value, Error> {
        self.temp(at, ty, varying, |r| Op::Call(function, r.reg(), args.iter().map(|v| v.reg()).collect()))
    }
}

/// The function that a call of one of several forms, written in the language, stands for: the number of arguments tells, which is the
/// second; options by name follow them.
fn form_of(name: &str, args: &[Expr]) -> (Option<&'static str>, usize) {
    let plain = args.iter().take_while(|a| !matches!(a.kind, ExprKind::Text(_))).count();
    let form = rows(name).find_map(|(_, row)| match row.how {
        How::Prelude(function, n) if n == plain => Some(function),
        _ => None,
    });
    (form, plain)
}

/// Whether a function's arguments are values; those of questions and maps are names and variables.
fn is_of_values(row: &Row) -> bool {
    match row.how {
        How::Form(Form::Ask(_) | Form::Map(_) | Form::SetComponent(_) | Form::Bake) | How::Prelude(..) => false,
        _ => !row.name.is_empty(),
    }
}

/// Whether values are what a row takes.
pub(super) fn fits(row: &Row, values: &[Value]) -> bool {
    let fits = |arg: &Arg, ty: Ty| match arg {
        Arg::Float => ty == Ty::Float,
        Arg::Triple => ty.is_triple(),
        Arg::Direction => ty.is_triple() && ty != Ty::Color,
        Arg::Matrix => matches!(ty, Ty::Matrix | Ty::Float),
        Arg::Any => ty == Ty::Float || ty.is_triple(),
        Arg::Value => ty == Ty::Float || ty.is_triple() || ty == Ty::Matrix,
    };
    row.takes.len() == values.len() && row.takes.iter().zip(values).all(|(arg, v)| fits(arg, v.ty))
}

/// The type of a call's result.
pub(super) fn result(gives: Gives, values: &[Value], expected: Option<Ty>) -> Ty {
    match gives {
        Gives::Is(kind) => kind.into(),
        Gives::First => values.first().map_or(Ty::Float, |v| v.ty),
        Gives::TripleOrFloat => expected.filter(|t| t.is_triple()).unwrap_or(Ty::Float),
        Gives::FloatOrColor => expected.filter(|t| *t == Ty::Float).unwrap_or(Ty::Color),
    }
}

/// `name(float, triple …)`, for messages.
fn signature(name: &str, args: &[Arg]) -> String {
    let list: Vec<&str> = args
        .iter()
        .map(|a| match a {
            Arg::Float => "float",
            Arg::Triple | Arg::Direction => "a triple",
            Arg::Matrix => "matrix",
            Arg::Any => "float or a triple",
            Arg::Value => "a value",
        })
        .collect();
    format!("{name}({})", list.join(", "))
}
