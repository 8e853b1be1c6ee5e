//! Surfaces of RIB as bicubic patches: quadrics, patch meshes, NURBS, curves and the teapot.

use crate::gprim::variables::to_bezier;
use crate::scene::patch::Patch;
use glam::{Vec3, Vec4};
use ri::{Fail, Knots};
use std::f32::consts::TAU;
use std::sync::OnceLock;

/// The greatest arc of a patch: it misses the circle by less than 1e-6 of its radius.
const ARC: f32 = 30.0;

/// A piece of a profile: a cubic curve in space, and its range of v.
pub type Profile = ([Vec3; 4], [f32; 2]);

/// A straight profile.
pub fn line(a: Vec3, b: Vec3) -> Vec<Profile> {
    vec![([a, a.lerp(b, 1.0 / 3.0), a.lerp(b, 2.0 / 3.0), b], [0.0, 1.0])]
}

/// A circular profile about a centre (r, z) in the xz plane, from one angle to another, radians.
pub fn circle(center: [f32; 2], radius: f32, from: f32, to: f32) -> Vec<Profile> {
    // Once around is all there is.
    let to = from + (to - from).clamp(-TAU, TAU);
    let n = pieces(to - from);
    let at = |k: usize| k as f32 / n as f32;
    (0..n)
        .map(|k| {
            let points = arc(from + (to - from) * at(k), from + (to - from) * at(k + 1));
            let p = points.map(|[c, s]| Vec3::new(center[0] + radius * c, 0.0, center[1] + radius * s));
            (p, [at(k), at(k + 1)])
        })
        .collect()
}

/// A parabola from the tip: r = R √(z/z_max), from z_min to z_max.
pub fn parabola(radius: f32, z_min: f32, z_max: f32) -> Vec<Profile> {
    const PIECES: usize = 8;
    // In r the profile is of second degree; v goes with z, so that short pieces follow it.
    let r_of = |z: f32| radius * (z / z_max).max(0.0).sqrt();
    let (r0, r1) = (r_of(z_min), r_of(z_max));
    let z_of = |r: f32| z_max * (r / radius) * (r / radius);
    let r_at = |k: usize| r0 + (r1 - r0) * k as f32 / PIECES as f32;
    let v_of = |r: f32| if z_max != z_min { (z_of(r) - z_min) / (z_max - z_min) } else { 0.0 };
    (0..PIECES)
        .map(|k| {
            let (a, b) = (r_at(k), r_at(k + 1));
            let (pa, pb) = (Vec3::new(a, 0.0, z_of(a)), Vec3::new(b, 0.0, z_of(b)));
            let slope = |r: f32| Vec3::new(1.0, 0.0, 2.0 * z_max * r / (radius * radius)) * (b - a) / 3.0;
            ([pa, pa + slope(a), pb - slope(b), pb], [v_of(a), v_of(b)])
        })
        .collect()
}

fn pieces(angle: f32) -> usize {
    (angle.abs().min(TAU).to_degrees() / ARC).ceil().max(1.0) as usize
}

/// Bézier points (cosine, sine) of the unit circle's arc between two angles.
fn arc(a: f32, b: f32) -> [[f32; 2]; 4] {
    let k = 4.0 / 3.0 * ((b - a) / 4.0).tan();
    let ((sa, ca), (sb, cb)) = (a.sin_cos(), b.sin_cos());
    [[ca, sa], [ca - k * sa, sa + k * ca], [cb + k * sb, sb - k * cb], [cb, sb]]
}

/// Sweep a profile about the z axis by an angle in degrees; u goes around, v along the profile.
pub fn revolve(profile: &[Profile], sweep: f32) -> Vec<Patch> {
    let turn = sweep.to_radians();
    let n = pieces(turn);
    let at = |k: usize| k as f32 / n as f32;
    let mut patches = Vec::new();
    for (curve, v) in profile {
        for i in 0..n {
            let around = arc(turn * at(i), turn * at(i + 1));
            let mut p = [Vec3::ZERO; 16];
            for (k, q) in p.iter_mut().enumerate() {
                let (c, [cos, sin]) = (curve[k / 4], around[k % 4]);
                *q = Vec3::new(c.x * cos - c.y * sin, c.x * sin + c.y * cos, c.z);
            }
            patches.push(Patch::smooth(p, [at(i), at(i + 1)], *v));
        }
    }
    patches
}

/// The patches of the unit sphere.
pub fn whole_sphere() -> &'static [Patch] {
    static PATCHES: OnceLock<Vec<Patch>> = OnceLock::new();
    PATCHES.get_or_init(|| {
        let quarter = 0.5 * std::f32::consts::PI;
        revolve(&circle([0.0; 2], 1.0, -quarter, quarter), 360.0)
    })
}

impl Patch {
    /// The patch through points of a surface, given over unit parameters: exact for what is bicubic.
    pub fn through(at: impl Fn(f32, f32) -> Vec3, u: [f32; 2], v: [f32; 2]) -> Patch {
        let place = |r: [f32; 2], k: usize| r[0] + (r[1] - r[0]) * k as f32 / 3.0;
        let mut p = [Vec3::ZERO; 16];
        for (k, q) in p.iter_mut().enumerate() {
            *q = at(place(u, k % 4), place(v, k / 4));
        }
        // From points at thirds to control points, along rows and then along columns.
        let control = |p: [Vec3; 4]| {
            let inner = |a: Vec3, b: Vec3, c: Vec3, d: Vec3| (-5.0 * a + 18.0 * b - 9.0 * c + 2.0 * d) / 6.0;
            [p[0], inner(p[0], p[1], p[2], p[3]), inner(p[3], p[2], p[1], p[0]), p[3]]
        };
        for j in 0..4 {
            let row = control([p[4 * j], p[4 * j + 1], p[4 * j + 2], p[4 * j + 3]]);
            p[4 * j..4 * j + 4].copy_from_slice(&row);
        }
        for i in 0..4 {
            let column = control([p[i], p[4 + i], p[8 + i], p[12 + i]]);
            (0..4).for_each(|j| p[4 * j + i] = column[j]);
        }
        Patch::smooth(p, u, v)
    }
}

/// A patch mesh (RISpec 5.3): patches, each with the places of its corners (0,0), (1,0), (0,1), (1,1) in varying values.
pub fn patch_mesh(
    bicubic: bool,
    points: &[Vec3],
    [nu, nv]: [usize; 2],
    periodic: [bool; 2],
    bases: &([f32; 16], [f32; 16]),
    steps: [usize; 2],
) -> Result<Vec<(Patch, [usize; 4])>, Fail> {
    if nu.checked_mul(nv) != Some(points.len()) {
        return Err(Fail::new(format!("a mesh of {nu} × {nv} points has {} in \"P\"", points.len())));
    }
    let step = if bicubic { steps } else { [1, 1] };
    let count = |n: usize, axis: usize| -> Result<usize, Fail> {
        let wrong = || {
            Fail::new(format!(
                "{n} points along an axis make no {} patches",
                if bicubic { "bicubic" } else { "bilinear" }
            ))
        };
        let room =
            if periodic[axis] { n } else { n.checked_sub(if bicubic { 4 } else { 2 }).ok_or_else(wrong)? + step[axis] };
        if step[axis] == 0 || room % step[axis] != 0 || room == 0 {
            return Err(wrong());
        }
        Ok(room / step[axis])
    };
    let (pu, pv) = (count(nu, 0)?, count(nv, 1)?);
    let point = |i: usize, j: usize| points[(j % nv) * nu + i % nu];
    let at = |k: usize, n: usize| k as f32 / n as f32;
    // Corners of patches: one more than patches along an open axis.
    let (cu, cv) = (if periodic[0] { pu } else { pu + 1 }, if periodic[1] { pv } else { pv + 1 });
    let mut patches = Vec::new();
    for j in 0..pv {
        for i in 0..pu {
            let (u, v) = ([at(i, pu), at(i + 1, pu)], [at(j, pv), at(j + 1, pv)]);
            let patch = if bicubic {
                let mut p = [Vec3::ZERO; 16];
                for (k, q) in p.iter_mut().enumerate() {
                    *q = point(i * step[0] + k % 4, j * step[1] + k / 4);
                }
                Patch::smooth(to_bezier(p, bases), u, v)
            } else {
                let mut patch = Patch::bilinear([point(i, j), point(i + 1, j), point(i, j + 1), point(i + 1, j + 1)]);
                let corners = [[u[0], v[0]], [u[1], v[0]], [u[0], v[1]], [u[1], v[1]]];
                (patch.uv, patch.st) = (corners, corners);
                patch
            };
            let corner = |a: usize, b: usize| (b % cv) * cu + a % cu;
            patches.push((patch, [corner(i, j), corner(i + 1, j), corner(i, j + 1), corner(i + 1, j + 1)]));
        }
    }
    Ok(patches)
}

/// Basis functions of order k at t that are not zero: the first one's index and their values (Cox and de Boor).
fn basis(knots: &[f32], n: usize, order: usize, t: f32) -> (usize, Vec<f32>) {
    let mut span = order - 1;
    while span + 1 < n && t >= knots[span + 1] {
        span += 1;
    }
    let mut b = vec![1.0];
    for k in 1..order {
        let mut next = vec![0.0; k + 1];
        for (i, x) in b.iter().enumerate() {
            let (lo, hi) = (knots[span + 1 + i - k], knots[span + 1 + i]);
            let w = if hi > lo { (t - lo) / (hi - lo) } else { 0.0 };
            next[i] += x * (1.0 - w);
            next[i + 1] += x * w;
        }
        b = next;
    }
    (span + 1 - order, b)
}

/// Check the numbers of a NURBS along one parameter.
fn check(k: &Knots, axis: &str) -> Result<(), Fail> {
    let (n, order) = (k.n as usize, k.order as usize);
    let wrong = |what: String| Err(Fail::new(format!("NURBS along {axis}: {what}")));
    if k.order < 2 || k.n < k.order || k.n > 1 << 20 || k.order > 32 {
        return wrong(format!("{} points of order {}", k.n, k.order));
    }
    if k.knots.len() != n + order {
        return wrong(format!("{} knots, expected {}", k.knots.len(), n + order));
    }
    if k.knots.windows(2).any(|w| !(w[0] <= w[1])) {
        return wrong("its knots fall".into());
    }
    let (lo, hi) = (k.knots[order - 1], k.knots[n]);
    if !(k.range[0] < k.range[1] && k.range[0] >= lo - 1e-6 && k.range[1] <= hi + 1e-6) {
        return wrong(format!("its range {} to {} is not within its knots, {lo} to {hi}", k.range[0], k.range[1]));
    }
    Ok(())
}

/// A NURBS patch of homogeneous points; each span becomes patches, exact up to cubics with even weights.
pub fn nurbs(points: &[Vec4], u: &Knots, v: &Knots) -> Result<Vec<Patch>, Fail> {
    check(u, "u")?;
    check(v, "v")?;
    let (nu, nv) = (u.n as usize, v.n as usize);
    if points.len() != nu * nv {
        return Err(Fail::new(format!("a NURBS patch of {nu} × {nv} points has {}", points.len())));
    }
    let at = |s: f32, t: f32| nurbs_point(points, u, v, s, t);
    let even = points.iter().all(|p| (p.w - points[0].w).abs() < 1e-6 * points[0].w.abs());
    let exact = even && u.order <= 4 && v.order <= 4;
    let cuts = |k: &Knots| -> Vec<[f32; 2]> {
        let mut ends: Vec<f32> = vec![k.range[0]];
        ends.extend(k.knots.iter().copied().filter(|x| *x > k.range[0] && *x < k.range[1]));
        ends.push(k.range[1]);
        ends.dedup();
        let parts = if exact { 1 } else { 6 };
        ends.windows(2)
            .flat_map(|w| {
                let at = move |i: usize| w[0] + (w[1] - w[0]) * i as f32 / parts as f32;
                (0..parts).map(move |i| [at(i), at(i + 1)])
            })
            .collect()
    };
    let mut patches = Vec::new();
    for tv in cuts(v) {
        for su in cuts(u) {
            // Just inside the span's end, so that the next span's polynomial is not taken.
            let inside = |x: f32, r: [f32; 2]| if x >= r[1] { r[1] - (r[1] - r[0]) * 1e-6 } else { x };
            patches.push(Patch::through(|s, t| at(inside(s, su), inside(t, tv)), su, tv));
        }
    }
    Ok(patches)
}

/// A point of a NURBS patch.
fn nurbs_point(points: &[Vec4], u: &Knots, v: &Knots, s: f32, t: f32) -> Vec3 {
    let nu = u.n as usize;
    let (i0, bu) = basis(&u.knots, nu, u.order as usize, s);
    let (j0, bv) = basis(&v.knots, v.n as usize, v.order as usize, t);
    let mut sum = Vec4::ZERO;
    for (j, y) in bv.iter().enumerate() {
        for (i, x) in bu.iter().enumerate() {
            sum += points[(j0 + j) * nu + i0 + i] * (x * y);
        }
    }
    if sum.w != 0.0 { sum.truncate() / sum.w } else { sum.truncate() }
}

/// The values of a NURBS patch's variable, `width` numbers each, at (s, t), if it has as many as the patch has control points
/// (then it follows the surface) or corners of spans (then it is bilinear in each). RISpec 5.3.
pub fn nurbs_variable(
    values: &[f32],
    width: usize,
    points: &[Vec4],
    u: &Knots,
    v: &Knots,
    s: f32,
    t: f32,
) -> Option<Vec<f32>> {
    let (nu, nv) = (u.n as usize, v.n as usize);
    if values.len() == nu * nv * width {
        let component = |c: usize| {
            let own: Vec<Vec4> =
                points.iter().enumerate().map(|(k, p)| Vec4::new(values[k * width + c] * p.w, 0.0, 0.0, p.w)).collect();
            nurbs_point(&own, u, v, s, t).x
        };
        return Some((0..width).map(component).collect());
    }
    let spans = |k: &Knots| (k.n - k.order + 1) as usize;
    let columns = spans(u) + 1;
    if values.len() != columns * (spans(v) + 1) * width {
        return None;
    }
    // Which span a parameter is in, and how far along it.
    let place = |k: &Knots, x: f32| {
        let first = k.order as usize - 1;
        let at = (0..spans(k)).rev().find(|i| k.knots[first + i] <= x).unwrap_or(0);
        let (a, b) = (k.knots[first + at], k.knots[first + at + 1]);
        (at, if b > a { ((x - a) / (b - a)).clamp(0.0, 1.0) } else { 0.0 })
    };
    let ((i, x), (j, y)) = (place(u, s), place(v, t));
    let component = |c: usize| {
        let at = |di: usize, dj: usize| values[((j + dj) * columns + i + di) * width + c];
        (at(0, 0) * (1.0 - x) + at(1, 0) * x) * (1.0 - y) + (at(0, 1) * (1.0 - x) + at(1, 1) * x) * y
    };
    Some((0..width).map(component).collect())
}

/// A point of a NURBS curve in u, v, w.
pub fn nurbs_curve(points: &[Vec3], knots: &[f32], order: usize, t: f32) -> [f32; 2] {
    let (first, b) = basis(knots, points.len(), order, t);
    let sum: Vec3 = b.iter().enumerate().map(|(i, x)| points[first + i] * *x).sum();
    if sum.z != 0.0 { [sum.x / sum.z, sum.y / sum.z] } else { [sum.x, sum.y] }
}

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
                let bezier = to_bezier(grid, &(*basis, crate::gprim::variables::BEZIER));
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

/// The teapot of Newell (1975), its axis along z and its bottom at 0.
pub fn teapot() -> Vec<Patch> {
    let profile = |list: &[[f32; 2]]| -> Vec<Profile> {
        let n = (list.len() - 1) / 3;
        (0..n)
            .map(|k| {
                let p = [0, 1, 2, 3].map(|i| Vec3::new(list[3 * k + i][0], 0.0, list[3 * k + i][1]));
                (p, [k as f32 / n as f32, (k + 1) as f32 / n as f32])
            })
            .collect()
    };
    #[rustfmt::skip]
    let body = [
        [0.0, 0.0], [1.425, 0.0], [1.5, 0.075], [1.5, 0.15], [1.5, 0.225], [2.0, 0.45], [2.0, 0.9], [2.0, 1.35],
        [1.75, 1.875], [1.5, 2.4], [1.4375, 2.53125], [1.3375, 2.53125], [1.4, 2.4],
    ];
    let lid = [[1.3, 2.4], [1.3, 2.4], [0.4, 2.4], [0.2, 2.55], [0.0, 2.7], [0.8, 3.15], [0.0, 3.15]];
    // Half of the spout and of the handle: rows from the body outwards, y going to one side; the other is its mirror image.
    #[rustfmt::skip]
    let spout: [[[f32; 3]; 4]; 7] = [
        [[1.7, 0.0, 1.425], [1.7, 0.66, 1.425], [1.7, 0.66, 0.6], [1.7, 0.0, 0.6]],
        [[2.6, 0.0, 1.425], [2.6, 0.66, 1.425], [3.1, 0.66, 0.825], [3.1, 0.0, 0.825]],
        [[2.3, 0.0, 2.1], [2.3, 0.25, 2.1], [2.4, 0.25, 2.025], [2.4, 0.0, 2.025]],
        [[2.7, 0.0, 2.4], [2.7, 0.25, 2.4], [3.3, 0.25, 2.4], [3.3, 0.0, 2.4]],
        [[2.8, 0.0, 2.475], [2.8, 0.25, 2.475], [3.525, 0.25, 2.49375], [3.525, 0.0, 2.49375]],
        [[2.9, 0.0, 2.475], [2.9, 0.15, 2.475], [3.45, 0.15, 2.5125], [3.45, 0.0, 2.5125]],
        [[2.8, 0.0, 2.4], [2.8, 0.15, 2.4], [3.2, 0.15, 2.4], [3.2, 0.0, 2.4]],
    ];
    #[rustfmt::skip]
    let handle: [[[f32; 3]; 4]; 7] = [
        [[-1.6, 0.0, 2.025], [-1.6, 0.3, 2.025], [-1.5, 0.3, 2.25], [-1.5, 0.0, 2.25]],
        [[-2.3, 0.0, 2.025], [-2.3, 0.3, 2.025], [-2.5, 0.3, 2.25], [-2.5, 0.0, 2.25]],
        [[-2.7, 0.0, 2.025], [-2.7, 0.3, 2.025], [-3.0, 0.3, 2.25], [-3.0, 0.0, 2.25]],
        [[-2.7, 0.0, 1.8], [-2.7, 0.3, 1.8], [-3.0, 0.3, 1.8], [-3.0, 0.0, 1.8]],
        [[-2.7, 0.0, 1.575], [-2.7, 0.3, 1.575], [-3.0, 0.3, 1.35], [-3.0, 0.0, 1.35]],
        [[-2.5, 0.0, 1.125], [-2.5, 0.3, 1.125], [-2.65, 0.3, 0.9375], [-2.65, 0.0, 0.9375]],
        [[-2.0, 0.0, 0.9], [-2.0, 0.3, 0.9], [-1.9, 0.3, 0.6], [-1.9, 0.0, 0.6]],
    ];
    let mut patches = revolve(&profile(&body), 360.0);
    patches.extend(revolve(&profile(&lid), 360.0));
    // Seen from outside, u × v points outwards on each half.
    for (rows, outward) in [(spout, true), (handle, false)] {
        for k in [0, 3] {
            for mirrored in [false, true] {
                let mut p = [Vec3::ZERO; 16];
                for (i, q) in p.iter_mut().enumerate() {
                    let column = if mirrored == outward { i % 4 } else { 3 - i % 4 };
                    let [x, y, z] = rows[k + i / 4][column];
                    *q = Vec3::new(x, if mirrored { -y } else { y }, z);
                }
                patches.push(Patch::smooth(p, [0.0, 1.0], [0.0, 1.0]));
            }
        }
    }
    patches
}
