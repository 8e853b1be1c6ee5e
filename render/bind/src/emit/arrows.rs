//! Arrows along vectors: a cylinder and a cone for each row.

use super::camera;
use super::group::{Group, select};
use super::rows::{Rows, exprs};
use crate::binding::{Arrow, Binding, Object, Shape};
use frame::Fault;
use glam::{Quat, Vec3};
use ri::{InstanceShape, Instances};

/// Part of the view that the longest arrow takes.
const LONGEST: f32 = 0.2;
/// Length and radius of the head, in diameters of the shaft, and the most of an arrow that its head takes.
const HEAD: f32 = 4.0;
const HEAD_RADIUS: f32 = 1.5;
const MOST: f32 = 0.45;

/// The lengths of the vectors of an object's rows; none if it has no arrows.
pub(super) fn lengths(rows: &Rows, object: &Object) -> Result<Vec<f64>, Fault> {
    let Shape::Arrow(arrow) = &object.shape else { return Ok(vec![]) };
    let [x, y, z] = exprs(&arrow.vector).map(|expr| rows.values("geometry.arrow.vector", expr));
    let (x, y, z) = (x?, y?, z?);
    Ok((0..x.len()).map(|i| (x[i] * x[i] + y[i] * y[i] + z[i] * z[i]).sqrt()).collect())
}

/// Length of the arrow of a vector of length 1, m, if the longest is `longest`.
pub(super) fn scale(binding: &Binding, i: usize, longest: f64) -> Result<f64, Fault> {
    let view = camera::view(binding).ok_or_else(|| {
        let message = "the file's camera does not say how much it sees: give `scale`, metres for a vector of length 1";
        binding.doc.fault(&format!("objects.{i}.geometry.arrow.scale"), message)
    })?;
    Ok(if longest > 0.0 { (LONGEST * view) as f64 / longest } else { 0.0 })
}

/// The shafts and heads of the arrows of the `i`th object; `at` has places, motion and parameters of all rows.
pub(super) fn groups<'a>(
    (binding, i, object): (&Binding, usize, &Object),
    arrow: &Arrow,
    rows: &Rows,
    at: &Instances,
) -> Result<Vec<Group<'a>>, Fault> {
    let vectors = rows.vectors("geometry.arrow.vector", exprs(&arrow.vector))?;
    let longest = vectors.iter().map(|v| Vec3::from(*v).length()).fold(0.0, f32::max);
    let scale = match arrow.scale {
        Some(scale) => scale,
        None => scale(binding, i, longest as f64)?,
    } as f32;
    let width = camera::width(binding, i, "arrow", arrow.width)?;
    // What is zero has no direction, and no arrow.
    let chosen: Vec<usize> = (0..vectors.len()).filter(|k| scale * Vec3::from(vectors[*k]).length() > 0.0).collect();
    let all = select(at, &chosen);
    let vectors: Vec<Vec3> = chosen.iter().map(|k| Vec3::from(vectors[*k]) * scale).collect();
    let part = |is_head: bool| {
        let sizes = vectors.iter().map(|vector| {
            let length = vector.length();
            // Arrows too short for a head are thinner.
            let thin = (length * MOST / (HEAD * width)).min(1.0) * width;
            let head = HEAD * thin;
            match is_head {
                true => (length - 0.5 * head, [HEAD_RADIUS * thin, HEAD_RADIUS * thin, 0.5 * head]),
                false => (0.5 * (length - head), [0.5 * thin, 0.5 * thin, 0.5 * (length - head)]),
            }
        });
        let sizes: Vec<(f32, [f32; 3])> = sizes.collect();
        let along = |places: &[[f32; 3]]| {
            let place = |k: usize| Vec3::from(places[k]) + sizes[k].0 * vectors[k].normalize();
            (0..places.len()).map(|k| place(k).to_array()).collect::<Vec<_>>()
        };
        let handle = format!("scree:{}:{}", object.name, if is_head { "head" } else { "shaft" });
        let turn = |v: &Vec3| Quat::from_rotation_arc(Vec3::Z, v.normalize()).to_array();
        let instances = Instances {
            shape: InstanceShape::Object(handle.clone()),
            position: along(&all.position),
            orientation: vectors.iter().map(turn).collect(),
            scale: sizes.iter().map(|(_, scale)| *scale).collect(),
            offset: vec![],
            params: all.params.clone(),
            moved: all.moved.as_ref().map(|(times, to)| (*times, along(to))),
        };
        Group { handle: Some(handle), archive: None, is_head, instances: vec![instances] }
    };
    Ok(if vectors.is_empty() { vec![] } else { vec![part(false), part(true)] })
}
