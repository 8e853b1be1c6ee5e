//! Runs of values: one for all points, or one a point; triples as three runs.

/// One component's values: one, or one a point.
#[inline]
pub fn run_of(v: &[f32], width: usize, c: usize, n: usize) -> &[f32] {
    let c = if width == 1 { 0 } else { c };
    if v.len() == width { &v[c..c + 1] } else { &v[c * n..(c + 1) * n] }
}

#[inline]
pub fn at(run: &[f32], i: usize) -> f32 {
    if run.len() == 1 { run[0] } else { run[i] }
}

/// Append `f` of two runs.
#[inline]
pub fn zip(out: &mut Vec<f32>, a: &[f32], b: &[f32], n: usize, f: impl Fn(f32, f32) -> f32) {
    match (a, b) {
        ([a], [b]) => out.extend(std::iter::repeat_n(f(*a, *b), n)),
        ([a], b) => out.extend(b.iter().map(|b| f(*a, *b))),
        (a, [b]) => out.extend(a.iter().map(|a| f(*a, *b))),
        (a, b) => out.extend(a.iter().zip(b).map(|(a, b)| f(*a, *b))),
    }
}

#[inline]
pub fn triple(v: &[f32], k: usize, n: usize) -> [f32; 3] {
    if v.len() == 3 { [v[0], v[1], v[2]] } else { [v[k], v[n + k], v[2 * n + k]] }
}

#[inline]
pub fn put(out: &mut [f32], k: usize, lanes: usize, v: [f32; 3]) {
    for c in 0..3 {
        out[c * lanes + k] = v[c];
    }
}

#[inline]
pub fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline]
pub fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Append `f` of two triples, `width` of its numbers, at every point, or once if both are uniform.
#[inline]
pub fn triples2(
    out: &mut Vec<f32>,
    a: &[f32],
    b: &[f32],
    n: usize,
    width: usize,
    f: impl Fn([f32; 3], [f32; 3]) -> [f32; 3],
) {
    let lanes = if a.len() == 3 && b.len() == 3 { 1 } else { n };
    out.resize(width * lanes, 0.0);
    for k in 0..lanes {
        let r = f(triple(a, k, n), triple(b, k, n));
        for c in 0..width {
            out[c * lanes + k] = r[c];
        }
    }
}
