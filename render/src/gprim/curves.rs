//! Curves as ribbons of patches.

use crate::gprim::basis::{BEZIER, to_bezier};
use crate::gprim::quadric::line;
use crate::scene::patch::Patch;
use glam::Vec3;
use ri::Fail;

/// A curve's segments as Bézier curves, each with the varying values at its ends.
pub struct CurveSegments {
    /// Control points, and indices of the two ends in varying values.
    pub segments: Vec<([Vec3; 4], [usize; 2])>,
    /// Varying values that the curve has.
    pub n_varying: usize,
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
            let p = |i: usize| points[(k * step + i) % n];
            let curve = if cubic {
                let mut grid = [Vec3::ZERO; 16];
                (0..16).for_each(|i| grid[i] = p(i % 4));
                let bezier = to_bezier(grid, &(*basis, BEZIER));
                [bezier[0], bezier[1], bezier[2], bezier[3]]
            } else {
                line(p(0), p(1))[0].0
            };
            (curve, [k % n_varying, (k + 1) % n_varying])
        })
        .collect();
    Ok(CurveSegments { segments, n_varying })
}

/// A segment as a ribbon of given widths at its ends: square to `facing(point)`, u across and v along.
pub fn ribbon(curve: &[Vec3; 4], width: [f32; 2], v: [f32; 2], facing: impl Fn(Vec3) -> Vec3) -> Patch {
    let mut p = [Vec3::ZERO; 16];
    let tangent = |k: usize| {
        let (a, b) = (curve[k.saturating_sub(1)], curve[(k + 1).min(3)]);
        let d = if b != a { b - a } else { curve[3] - curve[0] };
        d.normalize_or_zero()
    };
    for k in 0..4 {
        let half = 0.5 * (width[0] + (width[1] - width[0]) * k as f32 / 3.0);
        let side = facing(curve[k]).cross(tangent(k)).normalize_or_zero() * half;
        for i in 0..4 {
            p[4 * k + i] = curve[k] + side * (i as f32 / 1.5 - 1.0);
        }
    }
    Patch::smooth(p, [0.0, 1.0], v)
}
