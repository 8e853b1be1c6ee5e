//! Curves as ribbons of patches.

use crate::gprim::basis::{BEZIER, to_bezier};
use crate::gprim::quadric::line;
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

/// Equal pieces that a segment is cut into, so that each turns by little. What moves may turn at another time: it is always cut into as many.
pub fn n_pieces(curve: &[Vec3; 4], moves: bool) -> usize {
    /// Of what moves.
    const MOVING: usize = 4;
    /// The turn of a piece, rad, and the most pieces.
    const TURN: f32 = std::f32::consts::FRAC_PI_4;
    const MOST: usize = 12;
    if moves {
        return MOVING;
    }
    ((turn(curve) / TURN).ceil() as usize).clamp(1, MOST)
}

/// The points of a segment as a ribbon of given widths at its control points, u fastest: square to `facing(point, weights)`, with the weights of the
/// control points there; u across and v along. Where `neighbours` of a straight segment go on another way, ends are cut so that both ribbons share
/// an edge.
pub fn ribbon(
    curve: &[Vec3; 4],
    neighbours: [Option<Vec3>; 2],
    widths: [f32; 4],
    facing: impl Fn(Vec3, [f32; 4]) -> Vec3,
) -> [Vec3; 16] {
    let tangent = |k: usize| {
        let (a, b) = (curve[k.saturating_sub(1)], curve[(k + 1).min(3)]);
        let d = if b != a { b - a } else { curve[3] - curve[0] };
        d.normalize_or_zero()
    };
    let half = widths.map(|width| 0.5 * width);
    let face = |k: usize| facing(curve[k], std::array::from_fn(|i| f32::from(u8::from(i == k))));
    // Its normal, which is that of u and v, is then `facing`.
    let across = [0, 1, 2, 3].map(|k| tangent(k).cross(face(k)).normalize_or_zero());
    let ends = [(0, neighbours[0].map(|to| curve[0] - to)), (3, neighbours[1].map(|to| to - curve[3]))];
    let mitred = ends.map(|(k, other)| mitre(curve[3] - curve[0], other?, face(k), half[k]));
    let tangents = [tangent(0), tangent(3)];
    let edges = if mitred == [None, None] && turn(curve) > STRAIGHT {
        let slope = curve[3] + curve[2] - curve[1] - curve[0];
        let middle = weighted(curve, MIDDLE);
        let out = slope.cross(facing(middle, MIDDLE)).normalize_or_zero() * weighted(&half, MIDDLE);
        let bend = Bend { tangents, across: [across[0], across[3]], half };
        [-1.0, 1.0].map(|side| bend.edge(curve, side, middle + out * side))
    } else {
        let [a, b] = [(0, 0), (1, 3)].map(|(end, k)| mitred[end].unwrap_or(across[k] * half[k]));
        let sides: [Vec3; 4] = match mitred {
            [None, None] => std::array::from_fn(|k| across[k] * half[k]),
            _ => [0.0, 1.0, 2.0, 3.0].map(|k| a.lerp(b, k / 3.0)),
        };
        [-1.0, 1.0].map(|side| std::array::from_fn(|k| curve[k] + sides[k] * side))
    };
    std::array::from_fn(|k| edges[0][k / 4].lerp(edges[1][k / 4], (k % 4) as f32 / 3.0))
}

/// Turn of a segment, rad, below which its edges are as straight as it is.
const STRAIGHT: f32 = 1e-3;

/// The angle by which a segment turns, rad, there and back.
fn turn(curve: &[Vec3; 4]) -> f32 {
    let legs = [0, 1, 2].map(|k| curve[k + 1] - curve[k]);
    let legs: Vec<Vec3> = legs.into_iter().filter(|leg| *leg != Vec3::ZERO).collect();
    legs.windows(2).map(|pair| pair[0].angle_between(pair[1])).sum()
}

/// Weights of the control points of a Bézier curve in its middle.
const MIDDLE: [f32; 4] = [0.125, 0.375, 0.375, 0.125];

fn weighted<T: Copy + Mul<f32, Output = T> + Sum>(points: &[T; 4], weights: [f32; 4]) -> T {
    points.iter().zip(weights).map(|(p, weight)| *p * weight).sum()
}

/// A segment that turns.
struct Bend {
    /// Directions along it at its ends, and across it.
    tangents: [Vec3; 2],
    across: [Vec3; 2],
    /// Half the widths at its control points.
    half: [f32; 4],
}

impl Bend {
    /// The edge on one `side` (-1 or 1) of the curve: it begins and ends beside that, goes along it there, and through a point beside its middle.
    /// Outside a bend it is longer than the curve, inside shorter: so are the arms of its control points.
    fn edge(&self, curve: &[Vec3; 4], side: f32, middle: Vec3) -> [Vec3; 4] {
        /// What keeps the arms as the curve has them, where the middle does not tell them apart.
        const AS_THEY_ARE: f32 = 0.01;
        let [t, s] = self.tangents;
        let out = |end: usize, k: usize| self.across[end] * (self.half[k] * side);
        let (from, to) = (curve[0] + out(0, 0), curve[3] + out(1, 3));
        let (first, last) = (curve[0] + out(0, 1), curve[3] + out(1, 2));
        let arms = [(curve[1] - curve[0]).length(), (curve[3] - curve[2]).length()];
        let found = weighted(&[from, first + t * arms[0], last - s * arms[1], to], MIDDLE);
        // Arms that are longer by a and b add 3/8 (a t - b s) in the middle: least squares.
        let missing = (middle - found) / MIDDLE[1];
        let (along, against) = (t.dot(missing), -s.dot(missing));
        let (own, other) = (1.0 + AS_THEY_ARE, -t.dot(s));
        let more =
            [own * along - other * against, own * against - other * along].map(|x| x / (own * own - other * other));
        // Inside a bend that is narrower than the ribbon they come together.
        let [a, b] = [0, 1].map(|end| (arms[end] + more[end]).max(0.0));
        [from, first + t * a, last - s * b, to]
    }
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
