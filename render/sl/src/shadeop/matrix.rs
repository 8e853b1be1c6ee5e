//! Functions of matrices, and of components by index. A matrix has its sixteen numbers row after row, for row vectors.

use super::call::{Call, Values};
use super::runs::run_of;
use glam::{Mat4, Vec3};

/// The element of an index, if there is one.
pub fn element(i: f32, len: u16) -> Option<usize> {
    (i >= 0.0 && i < len as f32).then_some(i as usize)
}

/// A number as a value.
pub fn one16(x: f32) -> [f32; 16] {
    let mut v = [0.0; 16];
    v[0] = x;
    v
}

/// A triple as a value.
pub fn triple16([x, y, z]: [f32; 3]) -> [f32; 16] {
    let mut v = [0.0; 16];
    (v[0], v[1], v[2]) = (x, y, z);
    v
}

/// The inverse; of a matrix that has none, zero.
fn inverse(m: Mat4) -> Mat4 {
    if m.determinant() != 0.0 { m.inverse() } else { Mat4::ZERO }
}

// Row vectors: a matrix's numbers are the columns of its transpose, and products go the other way round.
fn matrix(v: &[f32; 16]) -> Mat4 {
    Mat4::from_cols_array(v)
}

fn vector3(v: &[f32; 16]) -> Vec3 {
    Vec3::new(v[0], v[1], v[2])
}

/// The place of a component: of a triple by its index, of a matrix by row and column.
fn place(of_matrix: bool, indices: &[[f32; 16]]) -> Option<usize> {
    if of_matrix {
        element(indices[0][0], 4).zip(element(indices[1][0], 4)).map(|(r, c)| 4 * r + c)
    } else {
        element(indices[0][0], 3)
    }
}

/// Component of a triple, or of a matrix (row, column), by index; 0 if there is none.
pub fn component(call: &Call<'_>, out: &mut Vec<f32>) {
    let of_matrix = call.args[0].width == 16;
    if let [of, indices @ ..] = call.args
        && indices.iter().all(Values::is_uniform)
    {
        // One component of all.
        let indices: Vec<[f32; 16]> = indices.iter().map(|index| one16(index.v[0])).collect();
        match place(of_matrix, &indices) {
            Some(k) => out.extend_from_slice(run_of(of.v, of.width, k, call.n)),
            None => out.resize(call.lanes(), 0.0),
        }
        return;
    }
    call.pointwise(out, |v| one16(place(of_matrix, &v[1..]).map_or(0.0, |k| v[0][k])));
}

/// A triple or matrix with one component replaced.
pub fn with_component(call: &Call<'_>, out: &mut Vec<f32>) {
    let of_matrix = call.args[0].width == 16;
    call.pointwise(out, |v| {
        let mut m = v[0];
        if let Some(k) = place(of_matrix, &v[1..]) {
            m[k] = v[v.len() - 1][0];
        }
        m
    });
}

/// A number on the diagonal.
pub fn diagonal(call: &Call<'_>, out: &mut Vec<f32>) {
    call.pointwise(out, |v| {
        let mut m = [0.0; 16];
        [0, 5, 10, 15].into_iter().for_each(|k| m[k] = v[0][0]);
        m
    });
}

/// a b
pub fn multiply(call: &Call<'_>, out: &mut Vec<f32>) {
    call.pointwise(out, |v| (matrix(&v[1]) * matrix(&v[0])).to_cols_array());
}

/// a b⁻¹
pub fn divide(call: &Call<'_>, out: &mut Vec<f32>) {
    call.pointwise(out, |v| (inverse(matrix(&v[1])) * matrix(&v[0])).to_cols_array());
}

/// Whether two matrices are equal: 1 or 0.
pub fn equal(call: &Call<'_>, out: &mut Vec<f32>) {
    call.pointwise(out, |v| one16((v[0] == v[1]) as u8 as f32));
}

/// Determinant.
pub fn determinant(call: &Call<'_>, out: &mut Vec<f32>) {
    call.pointwise(out, |v| one16(matrix(&v[0]).determinant()));
}

/// A point by a matrix.
pub fn point(call: &Call<'_>, out: &mut Vec<f32>) {
    call.pointwise(out, |v| triple16(matrix(&v[0]).project_point3(vector3(&v[1])).into()));
}

/// A vector by a matrix.
pub fn vector(call: &Call<'_>, out: &mut Vec<f32>) {
    call.pointwise(out, |v| triple16(matrix(&v[0]).transform_vector3(vector3(&v[1])).into()));
}

/// A normal by a matrix.
pub fn normal(call: &Call<'_>, out: &mut Vec<f32>) {
    call.pointwise(out, |v| triple16(inverse(matrix(&v[0])).transpose().transform_vector3(vector3(&v[1])).into()));
}

/// A translation before a matrix.
pub fn translate(call: &Call<'_>, out: &mut Vec<f32>) {
    call.pointwise(out, |v| (matrix(&v[0]) * Mat4::from_translation(vector3(&v[1]))).to_cols_array());
}

/// A scale before a matrix.
pub fn scale(call: &Call<'_>, out: &mut Vec<f32>) {
    call.pointwise(out, |v| (matrix(&v[0]) * Mat4::from_scale(vector3(&v[1]))).to_cols_array());
}

/// A rotation (angle, axis) before a matrix.
pub fn rotate(call: &Call<'_>, out: &mut Vec<f32>) {
    call.pointwise(out, |v| {
        let axis = vector3(&v[2]).normalize_or(Vec3::Z);
        (matrix(&v[0]) * Mat4::from_axis_angle(axis, v[1][0])).to_cols_array()
    });
}
