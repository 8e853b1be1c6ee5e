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

/// `f` of two runs, of one number or as many as come out each.
#[inline(always)]
pub fn zip(out: &mut [f32], a: &[f32], b: &[f32], f: impl Fn(f32, f32) -> f32) {
    let n = out.len();
    // Iterators over several slices might be compiled for any processor, see `wide`.
    match (a, b) {
        ([a], [b]) => out.fill(f(*a, *b)),
        ([a], b) => {
            let b = &b[..n];
            for k in 0..n {
                out[k] = f(*a, b[k]);
            }
        }
        (a, [b]) => {
            let a = &a[..n];
            for k in 0..n {
                out[k] = f(a[k], *b);
            }
        }
        (a, b) => {
            let (a, b) = (&a[..n], &b[..n]);
            for k in 0..n {
                out[k] = f(a[k], b[k]);
            }
        }
    }
}

/// `f` of three runs, likewise.
#[inline(always)]
pub fn zip3(out: &mut [f32], [a, b, c]: [&[f32]; 3], f: impl Fn(f32, f32, f32) -> f32) {
    let n = out.len();
    match (a, b, c) {
        ([a], [b], c) => zip(out, &[0.0], c, |_, c| f(*a, *b, c)),
        ([a], b, [c]) => zip(out, b, &[0.0], |b, _| f(*a, b, *c)),
        (a, [b], [c]) => zip(out, a, &[0.0], |a, _| f(a, *b, *c)),
        ([a], b, c) => zip(out, b, c, |b, c| f(*a, b, c)),
        (a, [b], c) => zip(out, a, c, |a, c| f(a, *b, c)),
        (a, b, [c]) => zip(out, a, b, |a, b| f(a, b, *c)),
        (a, b, c) => {
            let (a, b, c) = (&a[..n], &b[..n], &c[..n]);
            for k in 0..n {
                out[k] = f(a[k], b[k], c[k]);
            }
        }
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
