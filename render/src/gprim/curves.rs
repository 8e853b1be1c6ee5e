//! Curves as ribbons of patches.

use crate::gprim::basis::{BEZIER, to_bezier};
use crate::gprim::quadric::line;
use crate::scene::patch::Patch;
use glam::Vec3;
use ri::Fail;
use std::iter::Sum;
use std::ops::Mul;

/// A curve's segments as Bézier curves, each with the varying values at its ends.
pub struct CurveSegments {
    /// The segments.
    pub segments: Vec<Segment>,
    /// Varying values that the curve has.
    pub n_varying: usize,
}

/// A segment of a curve.
pub struct Segment {
    /// Its control points, Bézier.
    pub control: [Vec3; 4],
    /// Indices of its two ends in varying values.
    pub ends: [usize; 2],
    /// Indices of its control points, as they were given, in vertex values; of a linear one, those of its ends.
    pub vertices: [usize; 4],
}

/// Cut a curve into segments.
pub fn curve(
    points: &[Vec3],
    cubic: bool,
    periodic: bool,
    basis: &[f32; 16],
    step: usize,
) -> Result<CurveSegments, Fail> {
    let n = points.len();
    let wrong = || Fail::new(format!("{n} points make no {} curve", if cubic { "cubic" } else { "linear" }));
    let room = if periodic {
        n
    } else if cubic {
        n.checked_sub(4).ok_or_else(wrong)? + step
    } else {
        n.checked_sub(1).ok_or_else(wrong)?
    };
    let step = if cubic { step } else { 1 };
    if step == 0 || room % step != 0 || room == 0 {
        return Err(wrong());
    }
    let count = room / step;
    let n_varying = if periodic { count } else { count + 1 };
    let segments = (0..count)
        .map(|k| {
            let place = |i: usize| (k * step + i) % n;
            let control = if cubic {
                along([0, 1, 2, 3].map(|i| points[place(i)]), basis)
            } else {
                line(points[place(0)], points[place(1)])[0].0
            };
            let vertices = [0, 1, 2, 3].map(|i| place(if cubic { i } else { i / 3 }));
            Segment { control, ends: [k % n_varying, (k + 1) % n_varying], vertices }
        })
        .collect();
    Ok(CurveSegments { segments, n_varying })
}

/// Control points of a curve of any basis, or values at them, as Bézier ones.
pub fn along<T: Copy + Mul<f32, Output = T> + Sum>(p: [T; 4], basis: &[f32; 16]) -> [T; 4] {
    let bezier = to_bezier(std::array::from_fn(|i| p[i % 4]), &(*basis, BEZIER));
    [bezier[0], bezier[1], bezier[2], bezier[3]]
}

/// A segment as a ribbon of given widths at its control points: square to `facing(point, part)`, at a part of the segment; u
/// across and v along.
pub fn ribbon(curve: &[Vec3; 4], widths: [f32; 4], v: [f32; 2], facing: impl Fn(Vec3, f32) -> Vec3) -> Patch {
    let mut p = [Vec3::ZERO; 16];
    let tangent = |k: usize| {
        let (a, b) = (curve[k.saturating_sub(1)], curve[(k + 1).min(3)]);
        let d = if b != a { b - a } else { curve[3] - curve[0] };
        d.normalize_or_zero()
    };
    for k in 0..4 {
        let half = 0.5 * widths[k];
        // Its normal, which is that of u and v, is then `facing`.
        let side = tangent(k).cross(facing(curve[k], k as f32 / 3.0)).normalize_or_zero() * half;
        for i in 0..4 {
            p[4 * k + i] = curve[k] + side * (i as f32 / 1.5 - 1.0);
        }
    }
    Patch::smooth(p, [0.0, 1.0], v)
}
