//! Chosen rows of a frame, and the values of expressions in them.

use super::missing::{Lack, ORIENTATION, VELOCITY};
use crate::binding::{Binding, Formula, Object, Shape};
use crate::colormap::Map;
use crate::expr::Expr;
use frame::{Column, Fault, FaultKind, Frame};
use glam::Quat;
use ri::{Class, InstanceShape, Instances, Param, Type};
use std::cell::RefCell;
use std::collections::BTreeMap;

/// Chosen rows of a frame, and where faults in them are told.
pub(super) struct Rows<'a> {
    pub(super) binding: &'a Binding,
    pub(super) frame: &'a Frame,
    pub(super) key: String,
    pub(super) rows: Vec<usize>,
    /// Rows without a value of what places them or gives their size, and the expression that has none.
    pub(super) missing: RefCell<BTreeMap<usize, String>>,
}

impl<'a> Rows<'a> {
    /// The rows of the `i`th object.
    pub(super) fn of(binding: &'a Binding, i: usize, object: &Object, frame: &'a Frame) -> Result<Rows<'a>, Fault> {
        let mut rows = Rows::all(binding, i, frame);
        if let Some(select) = &object.select {
            rows.rows = select.expr.select(frame).map_err(|m| rows.row_fault("select", &select.expr, m))?;
        }
        Ok(rows)
    }

    /// All rows of a frame, for the `i`th object.
    pub(super) fn all(binding: &'a Binding, i: usize, frame: &'a Frame) -> Rows<'a> {
        let (key, rows) = (format!("objects.{i}"), (0..frame.rows()).collect());
        Rows { binding, frame, key, rows, missing: RefCell::default() }
    }

    /// What is wrong with a part of the object.
    pub(super) fn fault(&self, part: &str, message: String) -> Fault {
        self.binding.doc.fault(&format!("{}.{part}", self.key), message)
    }

    /// An expression's value for each row; rows without one that is finite, in the single precision of what is drawn, are noted.
    pub(super) fn numbers(&self, part: &str, expr: &Expr) -> Result<Vec<f64>, Fault> {
        let values = self.values(part, expr)?;
        for (k, _) in values.iter().enumerate().filter(|(_, x)| !(**x as f32).is_finite()) {
            self.missing.borrow_mut().entry(self.rows[k]).or_insert_with(|| expr.text.clone());
        }
        Ok(values)
    }

    /// An expression's value for each row, not-a-number where it is missing.
    pub(super) fn values(&self, part: &str, expr: &Expr) -> Result<Vec<f64>, Fault> {
        expr.numbers(self.frame, &self.rows).map_err(|m| self.row_fault(part, expr, m))
    }

    /// The fault of an expression that has no number in a row: of the data if it has one in others, else of the expression.
    pub(super) fn row_fault(&self, part: &str, expr: &Expr, message: String) -> Fault {
        let holds = |row: &usize| expr.numbers(self.frame, &[*row]).is_ok();
        match self.rows.iter().position(|row| !holds(row)) {
            Some(k) if self.rows.iter().any(holds) => {
                let message = format!("row {} of frame {}: {message}", self.rows[k] + 1, self.frame.number);
                Fault { kind: FaultKind::Data, ..self.fault(part, message) }
            }
            _ => self.fault(part, message),
        }
    }

    /// Three expressions.
    pub(super) fn three(&self, part: &str, [x, y, z]: [&Expr; 3]) -> Result<Vec<[f32; 3]>, Fault> {
        let columns = [self.numbers(part, x)?, self.numbers(part, y)?, self.numbers(part, z)?];
        Ok((0..self.rows.len()).map(|r| [0, 1, 2].map(|c| columns[c][r] as f32)).collect())
    }

    /// Places or vectors, turned as the data is.
    pub(super) fn vectors(&self, part: &str, vector: [&Expr; 3]) -> Result<Vec<[f32; 3]>, Fault> {
        let up = self.binding.up;
        Ok(self.three(part, vector)?.into_iter().map(|v| up.turn(v)).collect())
    }

    /// One expression, three times.
    pub(super) fn same(&self, part: &str, x: &Expr) -> Result<Vec<[f32; 3]>, Fault> {
        Ok(self.numbers(part, x)?.into_iter().map(|x| [x as f32; 3]).collect())
    }

    /// Sizes of a shape along its axes. Rows with a size that is not above 0 are noted as those that lack it: some programs let bodies
    /// vanish so.
    pub(super) fn scale(&self, shape: &Shape) -> Result<Vec<[f32; 3]>, Fault> {
        let sizes = match shape {
            Shape::Sphere(x) | Shape::Plane(x) | Shape::Archive(_, x) => [&x.expr; 3],
            Shape::Box(half) | Shape::Ellipsoid(half) => exprs(half),
            Shape::Cylinder([radius, half]) | Shape::Capsule([radius, half]) | Shape::Cone([radius, half]) => {
                [&radius.expr, &radius.expr, &half.expr]
            }
            // Their rows need vectors and places, which are noted where they are missing.
            Shape::Arrow(arrow) => {
                self.three("geometry.arrow.vector", exprs(&arrow.vector))?;
                return Ok(vec![[1.0; 3]; self.rows.len()]);
            }
            Shape::Trail(_) => return Ok(vec![[1.0; 3]; self.rows.len()]),
        };
        let is_round = std::ptr::eq(sizes[0], sizes[2]);
        let scale = if is_round { self.same("geometry", sizes[0])? } else { self.three("geometry", sizes)? };
        for (k, row) in scale.iter().enumerate() {
            if let Some(axis) = row.iter().position(|x| *x <= 0.0) {
                self.missing.borrow_mut().entry(self.rows[k]).or_insert_with(|| sizes[axis].text.clone());
            }
        }
        Ok(scale)
    }

    /// Which of the files each row is drawn from: that of its value in the column. An error if there is none.
    pub(super) fn files(&self, column: &str, files: &[(String, String)]) -> Result<Vec<usize>, Fault> {
        let part = "geometry.archive";
        let Some(values) = self.frame.column(column) else {
            return Err(self.binding.doc.unknown(
                &format!("{}.{part}.column", self.key),
                "column",
                column,
                &self.frame.names(),
            ));
        };
        let file = |row: &usize| {
            let is_value = |value: &str| match values.number(*row) {
                Some(x) => value.parse() == Ok(x),
                None => value == values.text(*row),
            };
            files.iter().position(|(value, _)| is_value(value)).ok_or_else(|| {
                let (row, value) = (row + 1, values.text(*row));
                let frame = self.frame.number;
                let message =
                    format!("row {row} of frame {frame} has `{value}` in `{column}`, for which there is no file");
                Fault { kind: FaultKind::Data, ..self.fault(&format!("{part}.files"), message) }
            })
        };
        self.rows.iter().map(file).collect()
    }

    /// Place, size, orientation and motion of an object's rows.
    pub(super) fn instances(&self, object: &Object, handle: Option<&String>) -> Result<Instances, Fault> {
        let mut instances = Instances {
            shape: handle.cloned().map_or(InstanceShape::Sphere, InstanceShape::Object),
            scale: self.scale(&object.shape)?,
            position: self.vectors("position", exprs(&object.position))?,
            orientation: self.orientation(object)?,
            offset: vec![],
            params: vec![],
            moved: None,
        };
        let shutter = self.binding.output.shutter as f32;
        if self.binding.output.shutter > 0.0
            && let Some(velocity) = self.velocity(object)?
        {
            let to = instances.position.iter().zip(velocity).map(|(p, v)| [0, 1, 2].map(|c| p[c] + v[c] * shutter));
            instances.moved = Some(([0.0, shutter], to.collect()));
        }
        Ok(instances)
    }

    /// The rows that lack a value are taken out.
    pub(super) fn drop_missing(&mut self) -> Lack {
        let missing = self.missing.take();
        self.rows.retain(|row| !missing.contains_key(row));
        let first = missing.iter().next().map(|(row, text)| (row + 1, text.clone()));
        Lack { rows: missing.len(), first }
    }

    /// The colours of rows by a value, and those that lack it.
    pub(super) fn colors(&self, value: &Formula, map: Map, range: Option<[f64; 2]>) -> Result<(Param, Lack), Fault> {
        let mut values = self.values("color", &value.expr)?;
        values.iter_mut().filter(|x| x.is_infinite()).for_each(|x| *x = f64::NAN);
        let (lo, hi) = range.map(|[a, b]| (a, b)).unwrap_or_else(|| range_of(&values));
        // Of a range that is turned round, the map is too.
        let width = if hi == lo { 1.0 } else { hi - lo };
        let colors = values.iter().flat_map(|x| map.color((x - lo) / width)).collect::<Vec<f32>>();
        let mut missing =
            values.iter().enumerate().filter(|(_, x)| x.is_nan()).map(|(k, _)| self.rows[k] + 1).peekable();
        let first = missing.peek().map(|row| (*row, value.expr.text.clone()));
        Ok((Param::floats("Cs", Class::Uniform, Type::Color, colors), Lack { rows: missing.count(), first }))
    }

    /// What tells bodies apart, for shaders with a parameter `id`: the column of that name, or the row's place.
    pub(super) fn ids(&self) -> Param {
        let column = self.frame.column("id");
        // Numbers up to 2^20 are whole in single precision with room for halves.
        let id = |row: &usize| match column {
            Some(Column::I64(ids)) => ids[*row].rem_euclid(1 << 20) as f32,
            ids => ids.and_then(|ids| ids.number(*row)).unwrap_or(*row as f64).rem_euclid(1_048_576.0) as f32,
        };
        let ids = self.rows.iter().map(id);
        Param::floats("id", Class::Uniform, Type::Float, ids.collect::<Vec<f32>>())
    }

    /// Quaternions (x, y, z, w), made unit and turned as the data is; none if neither the object nor the data has any and nothing is turned.
    pub(super) fn orientation(&self, object: &Object) -> Result<Vec<[f32; 4]>, Fault> {
        let standard = ORIENTATION;
        let exprs = match &object.orientation {
            Some(q) => q.each_ref().map(|formula| formula.expr.clone()),
            None if standard.iter().all(|c| self.frame.column(c).is_some()) => standard.map(Expr::column),
            None if self.binding.up.is_z() => return Ok(vec![]),
            None => return Ok(vec![self.binding.up.rotation().to_array(); self.rows.len()]),
        };
        let [w, x, y, z] = exprs.each_ref().map(|expr| self.numbers("orientation", expr));
        let (w, x, y, z) = (w?, x?, y?, z?);
        let unit = |i: usize| Quat::from_xyzw(x[i] as f32, y[i] as f32, z[i] as f32, w[i] as f32);
        let own = |i: usize| if unit(i).length() > 0.0 { unit(i).normalize() } else { Quat::IDENTITY };
        let up = self.binding.up;
        let turned = |q: Quat| if up.is_z() { q } else { up.rotation() * q };
        Ok((0..w.len()).map(|i| turned(own(i)).to_array()).collect())
    }

    /// Velocities: the object's own, or those of the standard columns; none if the data does not have these either.
    pub(super) fn velocity(&self, object: &Object) -> Result<Option<Vec<[f32; 3]>>, Fault> {
        let standard = VELOCITY;
        let velocity = match &object.velocity {
            Some(own) => self.vectors("velocity", exprs(own))?,
            None if standard.iter().all(|c| self.frame.column(c).is_some()) => {
                self.vectors("velocity", standard.map(Expr::column).each_ref())?
            }
            None => return Ok(None),
        };
        Ok(Some(velocity))
    }
}

pub(super) fn exprs<const N: usize>(formulas: &[Formula; N]) -> [&Expr; N] {
    formulas.each_ref().map(|formula| &formula.expr)
}

/// Least and greatest of some values.
pub(super) fn range_of(values: &[f64]) -> (f64, f64) {
    let finite = values.iter().filter(|x| x.is_finite());
    finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), x| (lo.min(*x), hi.max(*x)))
}
