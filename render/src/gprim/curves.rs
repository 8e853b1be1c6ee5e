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

impl CurveSegments {
    /// Of a linear curve, the far ends of the segments before and after one that are no points.
    pub fn beside(&self, k: usize, (cubic, periodic): (bool, bool)) -> [Option<Vec3>; 2] {
        let n = self.segments.len();
        if cubic {
            return [None, None];
        }
        let (before, after) = if periodic { (n - 1, n - 1) } else { (k, n - 1 - k) };
        let far = |k: usize, end: usize| {
            let c = &self.segments[k % n].control;
            (c[0] != c[3]).then_some(c[end])
        };
        [(1..=before).find_map(|i| far(k + n - i, 0)), (1..=after).find_map(|i| far(k + i, 3))]
    }
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

/// How much longer than half a width a mitre may be.
const LONGEST_MITRE: f32 = 4.0;

/// A segment as a ribbon of given widths at its control points: square to `facing(point, part)`, at a part of the segment; u
/// across and v along. Where `neighbours` of a straight segment go on another way, ends are cut so that both ribbons share an edge.
pub fn ribbon(
    curve: &[Vec3; 4],
    neighbours: [Option<Vec3>; 2],
    widths: [f32; 4],
    v: [f32; 2],
    facing: impl Fn(Vec3, f32) -> Vec3,
) -> Patch {
    let mut p = [Vec3::ZERO; 16];
    let tangent = |k: usize| {
        let (a, b) = (curve[k.saturating_sub(1)], curve[(k + 1).min(3)]);
        let d = if b != a { b - a } else { curve[3] - curve[0] };
        d.normalize_or_zero()
    };
    let face = |k: usize| facing(curve[k], k as f32 / 3.0);
    // Its normal, which is that of u and v, is then `facing`.
    let mut sides = [0, 1, 2, 3].map(|k| tangent(k).cross(face(k)).normalize_or_zero() * (0.5 * widths[k]));
    let ends = [(0, neighbours[0].map(|to| curve[0] - to)), (3, neighbours[1].map(|to| to - curve[3]))];
    let mitred = ends.map(|(k, other)| mitre(curve[3] - curve[0], other?, face(k), 0.5 * widths[k]));
    if mitred != [None, None] {
        let [a, b] = [mitred[0].unwrap_or(sides[0]), mitred[1].unwrap_or(sides[3])];
        sides = [0.0, 1.0, 2.0, 3.0].map(|k| a.lerp(b, k / 3.0));
    }
    for k in 0..4 {
        for i in 0..4 {
            p[4 * k + i] = curve[k] + sides[k] * (i as f32 / 1.5 - 1.0);
        }
    }
    Patch::smooth(p, [0.0, 1.0], v)
}

/// From where two straight ribbons meet to where their edges do; none where these are too far away, or one ribbon is too short for it.
fn mitre(own: Vec3, other: Vec3, facing: Vec3, half: f32) -> Option<Vec3> {
    let sides = [own, other].map(|along| along.cross(facing).try_normalize());
    let [Some(a), Some(b)] = sides else { return None };
    // Half the turn between them has this cosine, and this sine.
    let (cosine, sine) = (0.5 * (a + b).length(), 0.5 * (a - b).length());
    let shortest = own.length().min(other.length());
    let fits = LONGEST_MITRE * cosine >= 1.0 && half * sine <= 0.5 * shortest * cosine;
    (fits && sine > 0.0).then(|| (a + b) * (half / (2.0 * cosine * cosine)))
}
