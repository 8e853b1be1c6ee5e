//! NURBS patches as bicubic patches, their variables, and NURBS curves.

use crate::scene::patch::Patch;
use crate::scene::variables::Varying;
use glam::{Vec3, Vec4};
use ri::{Class, Fail, Knots, Param};
use std::ops::{Add, Div, Mul, Sub};

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
    let at = |s: f32, t: f32| project(nurbs_point(points, u, v, s, t));
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
            patches.push(Patch::smooth(control_points(at, su, tv), su, tv));
        }
    }
    Ok(patches)
}

/// A homogeneous point in space.
fn project(p: Vec4) -> Vec3 {
    if p.w != 0.0 { p.truncate() / p.w } else { p.truncate() }
}

/// A homogeneous point of a NURBS patch.
fn nurbs_point(points: &[Vec4], u: &Knots, v: &Knots, s: f32, t: f32) -> Vec4 {
    let nu = u.n as usize;
    let (i0, bu) = basis(&u.knots, nu, u.order as usize, s);
    let (j0, bv) = basis(&v.knots, v.n as usize, v.order as usize, t);
    let mut sum = Vec4::ZERO;
    for (j, y) in bv.iter().enumerate() {
        for (i, x) in bu.iter().enumerate() {
            sum += points[(j0 + j) * nu + i0 + i] * (x * y);
        }
    }
    sum
}

/// The values of a NURBS patch's variable over one of its patches, `width` numbers each. It has as many as the patch has control
/// points, and then follows the surface, or one at each corner of its spans, and is bilinear in each (RISpec 5.3); none if it has
/// another number. A varying one that could be either is the latter.
pub fn nurbs_variable(param: &Param, points: &[Vec4], u: &Knots, v: &Knots, patch: &Patch) -> Option<Varying> {
    let (values, width) = (param.numbers(), param.decl.width());
    let spans = |k: &Knots| (k.n - k.order + 1) as usize;
    let columns = spans(u) + 1;
    let is_at_corners = values.len() == columns * (spans(v) + 1) * width;
    if param.decl.class == Class::Vertex || !is_at_corners {
        return (values.len() == points.len() * width).then(|| following(values, width, points, u, v, patch));
    }
    // Which span a parameter is in, and how far along it.
    let place = |k: &Knots, x: f32| {
        let first = k.order as usize - 1;
        let at = (0..spans(k)).rev().find(|i| k.knots[first + i] <= x).unwrap_or(0);
        let (a, b) = (k.knots[first + at], k.knots[first + at + 1]);
        (at, if b > a { ((x - a) / (b - a)).clamp(0.0, 1.0) } else { 0.0 })
    };
    let at_corner = |[s, t]: [f32; 2]| {
        let ((i, x), (j, y)) = (place(u, s), place(v, t));
        (0..width).map(move |c| {
            let at = |di: usize, dj: usize| values[((j + dj) * columns + i + di) * width + c];
            (at(0, 0) * (1.0 - x) + at(1, 0) * x) * (1.0 - y) + (at(0, 1) * (1.0 - x) + at(1, 1) * x) * y
        })
    };
    Some(Varying::new(width, patch.uv.into_iter().flat_map(at_corner).collect()))
}

/// The number of the span of a NURBS patch that one of its patches is in, counted along u first, and how many there are.
pub fn span_of(patch: &Patch, u: &Knots, v: &Knots) -> [usize; 2] {
    let spans = |k: &Knots| (k.n - k.order + 1) as usize;
    let at = |k: &Knots, axis: usize| {
        let [a, .., b] = patch.uv.map(|uv| uv[axis]);
        let (first, middle) = (k.order as usize - 1, 0.5 * (a + b));
        (0..spans(k)).rev().find(|i| k.knots[first + i] <= middle).unwrap_or(0)
    };
    [at(v, 1) * spans(u) + at(u, 0), spans(u) * spans(v)]
}

/// The values over a patch of a variable that follows the surface.
fn following(values: &[f32], width: usize, points: &[Vec4], u: &Knots, v: &Knots, patch: &Patch) -> Varying {
    let [[u0, v0], .., [u1, v1]] = patch.uv;
    let mut all = vec![0.0; 16 * width];
    for c in 0..width {
        let own = |(k, p): (usize, &Vec4)| Vec4::new(values[k * width + c] * p.w, 0.0, 0.0, p.w);
        let own: Vec<Vec4> = points.iter().enumerate().map(own).collect();
        let at = |s: f32, t: f32| project(nurbs_point(&own, u, v, s, t)).x;
        let net = control_points(at, [u0, u1], [v0, v1]);
        net.into_iter().enumerate().for_each(|(k, x)| all[k * width + c] = x);
    }
    Varying::new(width, all)
}

/// A point of a NURBS curve in u, v, w.
pub fn nurbs_curve(points: &[Vec3], knots: &[f32], order: usize, t: f32) -> [f32; 2] {
    let (first, b) = basis(knots, points.len(), order, t);
    let sum: Vec3 = b.iter().enumerate().map(|(i, x)| points[first + i] * *x).sum();
    if sum.z != 0.0 { [sum.x / sum.z, sum.y / sum.z] } else { [sum.x, sum.y] }
}

/// The control points of a patch through points of a surface, or through values on it, over a range of its parameters: exact for
/// what is bicubic.
pub fn control_points<T>(at: impl Fn(f32, f32) -> T, u: [f32; 2], v: [f32; 2]) -> [T; 16]
where
    T: Copy + Add<Output = T> + Sub<Output = T> + Mul<f32, Output = T> + Div<f32, Output = T>,
{
    let place = |r: [f32; 2], k: usize| r[0] + (r[1] - r[0]) * k as f32 / 3.0;
    // Just inside the span's end, so that the next span's polynomial is not taken.
    let inside = |x: f32, r: [f32; 2]| if x >= r[1] { r[1] - (r[1] - r[0]) * 1e-6 } else { x };
    let mut p: [T; 16] = std::array::from_fn(|k| at(inside(place(u, k % 4), u), inside(place(v, k / 4), v)));
    // From points at thirds to control points, along rows and then along columns.
    let control = |p: [T; 4]| {
        let inner = |a: T, b: T, c: T, d: T| (a * -5.0 + b * 18.0 - c * 9.0 + d * 2.0) / 6.0;
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
    p
}
