//! Functions of a grid: what changes from a point to its neighbours.

use super::call::Call;
use super::runs::{cross, dot, put, run_of};

/// Differences of a value to the next point of the row and of the column, central where there are two neighbours; of `n` points
/// in rows of `nu`.
pub fn differences(x: &[f32], k: usize, nu: usize, n: usize) -> [f32; 2] {
    let nv = n / nu.max(1);
    if x.len() == 1 {
        return [0.0; 2];
    }
    let (i, j) = (k % nu, k / nu);
    let slope = |here: usize, count: usize, stride: usize| {
        let (lo, hi) = (here.saturating_sub(1), (here + 1).min(count - 1));
        let base = k - here * stride;
        if hi > lo { (x[base + hi * stride] - x[base + lo * stride]) / (hi - lo) as f32 } else { 0.0 }
    };
    [slope(i, nu, 1), slope(j, nv, nu)]
}

/// The changes of a value to the next points, as those over what the point stands for.
#[inline]
pub fn over([a, b]: [f32; 2], footprint: Option<&[f32; 3]>) -> [f32; 2] {
    footprint.map_or([a, b], |[uu, uv, vv]| [a * uu + b * uv, a * uv + b * vv])
}

/// Derivative along u: of a value, by u and v.
pub fn along_u(call: &Call<'_>, out: &mut Vec<f32>) {
    parametric(call, out, |[xi, xj], _, [vi, vj]| xi * vj - xj * vi);
}

/// Derivative along v.
pub fn along_v(call: &Call<'_>, out: &mut Vec<f32>) {
    parametric(call, out, |[xi, xj], [ui, uj], _| xj * ui - xi * uj);
}

/// Derivative along u or v, whatever way the rows run on the surface.
fn parametric(call: &Call<'_>, out: &mut Vec<f32>, slope: impl Fn([f32; 2], [f32; 2], [f32; 2]) -> f32) {
    let (u, v) = (call.arg(1), call.arg(2));
    let change = |x: &[f32], k: usize| differences(x, k, call.nu, call.n);
    for c in 0..call.width {
        let x = run_of(call.arg(0), call.width, c, call.n);
        out.extend((0..call.n).map(|k| {
            let (x, u, v) = (change(x, k), change(u, k), change(v, k));
            let det = u[0] * v[1] - u[1] * v[0];
            let slope = slope(x, u, v);
            if det != 0.0 { slope / det } else { 0.0 }
        }));
    }
}

/// Normal of the surface that points make.
pub fn normal(call: &Call<'_>, out: &mut Vec<f32>) {
    out.resize(3 * call.n, 0.0);
    for k in 0..call.n {
        put(out, k, call.n, spanned(call, k).map(|x| x * call.orientation));
    }
}

/// Area of a point's micropolygon.
pub fn area(call: &Call<'_>, out: &mut Vec<f32>) {
    out.extend((0..call.n).map(|k| {
        let m = spanned(call, k);
        dot(m, m).sqrt()
    }));
}

/// The cross product of the ways to the next point of the row and of the column.
fn spanned(call: &Call<'_>, k: usize) -> [f32; 3] {
    let d = [0, 1, 2].map(|c| differences(run_of(call.arg(0), 3, c, call.n), k, call.nu, call.n));
    cross(d.map(|d| d[0]), d.map(|d| d[1]))
}

/// How much a value changes from point to point of the grid, and over a pixel at least.
pub fn width(call: &Call<'_>, out: &mut Vec<f32>) {
    let x = call.arg(0);
    let change = |k: usize| {
        let [a, b] = over(differences(x, k, call.nu, call.n), call.footprints.get(k));
        a.abs().max(b.abs())
    };
    out.extend((0..if x.len() == 1 { 1 } else { call.n }).map(change));
}
