//! The rows of an object → columns of instances.

use crate::binding::{Binding, Color, Formula, Object, Shape};
use crate::expr::Expr;
use frame::{Fault, FaultKind, Frame};
use glam::{Quat, Vec3};
use ri::{Class, InstanceShape, Instances, Param, Type};

/// An object's instances, made before the scene is read, so that a fault in the data stops nothing half way.
pub(super) struct Prepared<'a> {
    pub(super) object: &'a Object,
    /// One set, but three for a capsule: its middle and its ends.
    pub(super) instances: Vec<Instances>,
    /// The retained object that the instances repeat, if they are not spheres.
    pub(super) handle: Option<String>,
}

/// Chosen rows of a frame, and where faults in them are told.
struct Rows<'a> {
    binding: &'a Binding,
    frame: &'a Frame,
    key: String,
    rows: Vec<usize>,
}

impl Rows<'_> {
    /// What is wrong with a part of the object.
    fn fault(&self, part: &str, message: String) -> Fault {
        self.binding.doc.fault(&format!("{}.{part}", self.key), message)
    }

    /// An expression's value for each row; every one must be finite.
    fn numbers(&self, part: &str, expr: &Expr) -> Result<Vec<f64>, Fault> {
        let values = expr.numbers(self.frame, &self.rows).map_err(|m| self.fault(part, m))?;
        match values.iter().position(|x| !x.is_finite()) {
            Some(k) => {
                let message = format!("row {} has {} in `{}`", self.rows[k] + 1, values[k], expr.text);
                Err(Fault { kind: FaultKind::Data, ..self.fault(part, message) })
            }
            None => Ok(values),
        }
    }

    /// Three expressions.
    fn three(&self, part: &str, [x, y, z]: [&Expr; 3]) -> Result<Vec<[f32; 3]>, Fault> {
        let columns = [self.numbers(part, x)?, self.numbers(part, y)?, self.numbers(part, z)?];
        Ok((0..self.rows.len()).map(|r| [0, 1, 2].map(|c| columns[c][r] as f32)).collect())
    }

    /// One expression, three times.
    fn same(&self, part: &str, x: &Expr) -> Result<Vec<[f32; 3]>, Fault> {
        Ok(self.numbers(part, x)?.into_iter().map(|x| [x as f32; 3]).collect())
    }

    /// Sizes of a shape along its axes.
    fn scale(&self, shape: &Shape) -> Result<Vec<[f32; 3]>, Fault> {
        let part = "geometry";
        let scale = match shape {
            Shape::Sphere(x) | Shape::Plane(x) | Shape::Archive(_, x) => self.same(part, &x.expr)?,
            Shape::Box(half) | Shape::Ellipsoid(half) => self.three(part, exprs(half))?,
            Shape::Cylinder([radius, half]) | Shape::Capsule([radius, half]) | Shape::Cone([radius, half]) => {
                self.three(part, [&radius.expr, &radius.expr, &half.expr])?
            }
        };
        match scale.iter().position(|s| s.iter().any(|x| !(*x > 0.0))) {
            Some(k) => {
                let fault = self.fault(part, format!("row {} has a size that is not above 0", self.rows[k] + 1));
                Err(Fault { kind: FaultKind::Data, ..fault })
            }
            None => Ok(scale),
        }
    }

    /// Quaternions (x, y, z, w), made unit; none if neither the object nor the data has any.
    fn orientation(&self, object: &Object) -> Result<Vec<[f32; 4]>, Fault> {
        let standard = ["quat_w", "quat_x", "quat_y", "quat_z"];
        let exprs = match &object.orientation {
            Some(q) => q.each_ref().map(|formula| formula.expr.clone()),
            None if standard.iter().all(|c| self.frame.column(c).is_some()) => standard.map(Expr::column),
            None => return Ok(vec![]),
        };
        let [w, x, y, z] = exprs.each_ref().map(|expr| self.numbers("orientation", expr));
        let (w, x, y, z) = (w?, x?, y?, z?);
        let unit = |i: usize| Quat::from_xyzw(x[i] as f32, y[i] as f32, z[i] as f32, w[i] as f32);
        Ok((0..w.len())
            .map(|i| if unit(i).length() > 0.0 { unit(i).normalize().to_array() } else { [0.0, 0.0, 0.0, 1.0] })
            .collect())
    }

    /// Velocities: the object's own, or those of the standard columns; none if the data does not have these either.
    fn velocity(&self, object: &Object) -> Result<Option<Vec<[f32; 3]>>, Fault> {
        let standard = ["vel_x", "vel_y", "vel_z"];
        let velocity = match &object.velocity {
            Some(own) => self.three("velocity", exprs(own))?,
            None if standard.iter().all(|c| self.frame.column(c).is_some()) => {
                self.three("velocity", standard.map(Expr::column).each_ref())?
            }
            None => return Ok(None),
        };
        Ok(Some(velocity))
    }
}

fn exprs<const N: usize>(formulas: &[Formula; N]) -> [&Expr; N] {
    formulas.each_ref().map(|formula| &formula.expr)
}

/// Evaluate the rows of the `i`th object into columns of instances.
pub(super) fn prepare<'a>(
    binding: &Binding,
    i: usize,
    object: &'a Object,
    frame: &Frame,
) -> Result<Prepared<'a>, Fault> {
    let mut rows = Rows { binding, frame, key: format!("objects.{i}"), rows: vec![] };
    rows.rows = match &object.select {
        Some(select) => select.expr.select(frame).map_err(|m| rows.fault("select", m))?,
        None => (0..frame.rows()).collect(),
    };
    let scale = rows.scale(&object.shape)?;
    let sphere = matches!(object.shape, Shape::Sphere(_) | Shape::Ellipsoid(_));
    let handle = (!sphere).then(|| format!("scree:{}", object.name));
    let mut instances = Instances {
        shape: handle.clone().map_or(InstanceShape::Sphere, InstanceShape::Object),
        position: rows.three("position", exprs(&object.position))?,
        orientation: rows.orientation(object)?,
        scale,
        params: vec![],
        moved: None,
    };
    if let Color::By { value, map, range } = &object.color {
        let values = rows.numbers("color", &value.expr)?;
        let (lo, hi) = range.map(|[a, b]| (a, b)).unwrap_or_else(|| range_of(&values));
        let width = if hi > lo { hi - lo } else { 1.0 };
        let colors = values.iter().flat_map(|x| map.color((x - lo) / width));
        instances.params.push(Param::floats("Cs", Class::Uniform, Type::Color, colors.collect::<Vec<f32>>()));
    }
    let shutter = binding.output.shutter as f32;
    if binding.output.shutter > 0.0
        && let Some(velocity) = rows.velocity(object)?
    {
        let to = instances.position.iter().zip(velocity).map(|(p, v)| [0, 1, 2].map(|c| p[c] + v[c] * shutter));
        instances.moved = Some(([0.0, shutter], to.collect()));
    }
    let ends = if matches!(object.shape, Shape::Capsule(_)) { capsule_ends(&instances) } else { vec![] };
    let instances = std::iter::once(instances).chain(ends).collect();
    Ok(Prepared { object, instances, handle })
}

/// The spheres at a capsule's ends.
fn capsule_ends(middle: &Instances) -> Vec<Instances> {
    let along = |places: &[[f32; 3]], i: usize, side: f32| {
        let q = middle.orientation.get(i).map_or(Quat::IDENTITY, |q| Quat::from_array(*q));
        let [_, _, half] = middle.scale[i];
        (Vec3::from(places[i]) + q * Vec3::new(0.0, 0.0, side * half)).to_array()
    };
    let all = |places: &[[f32; 3]], side: f32| (0..middle.len()).map(|i| along(places, i, side)).collect::<Vec<_>>();
    let sphere = |side: f32| Instances {
        shape: InstanceShape::Sphere,
        position: all(&middle.position, side),
        moved: middle.moved.as_ref().map(|(times, to)| (*times, all(to, side))),
        scale: middle.scale.iter().map(|[r, _, _]| [*r; 3]).collect(),
        ..middle.clone()
    };
    vec![sphere(-1.0), sphere(1.0)]
}

fn range_of(values: &[f64]) -> (f64, f64) {
    values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), x| (lo.min(*x), hi.max(*x)))
}
