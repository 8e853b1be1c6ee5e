//! Bases of bicubic patches and curves.

use glam::Mat4;
use std::iter::Sum;
use std::ops::Mul;

/// The Bézier basis, rows by falling powers (RISpec 5.3).
pub const BEZIER: [f32; 16] = [-1.0, 3.0, -3.0, 1.0, 3.0, -6.0, 3.0, 0.0, -3.0, 3.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];

/// Control points, or values at them, of a bicubic patch of any basis as Bézier ones.
pub fn to_bezier<T: Copy + Mul<f32, Output = T> + Sum>(p: [T; 16], (u, v): &([f32; 16], [f32; 16])) -> [T; 16] {
    // p(t) = T M G with rows of M by falling powers; Bézier points are B⁻¹ M G.
    let matrix = |m: &[f32; 16]| Mat4::from_cols_array(m).transpose();
    let change = |m: &[f32; 16]| matrix(&BEZIER).inverse() * matrix(m);
    let (cu, cv) = (change(u), change(v));
    let apply = |m: &Mat4, g: [T; 4]| [0, 1, 2, 3].map(|i| (0..4).map(|k| g[k] * m.row(i)[k]).sum::<T>());
    let mut out = p;
    for j in 0..4 {
        let row = apply(&cu, [out[4 * j], out[4 * j + 1], out[4 * j + 2], out[4 * j + 3]]);
        out[4 * j..4 * j + 4].copy_from_slice(&row);
    }
    for i in 0..4 {
        let column = apply(&cv, [out[i], out[4 + i], out[8 + i], out[12 + i]]);
        (0..4).for_each(|j| out[4 * j + i] = column[j]);
    }
    out
}
