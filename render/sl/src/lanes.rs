//! Runs of values: one for all points, or one a point; triples as three runs.

/// One component's values: one, or one a point.
#[inline]
pub(crate) fn run_of(v: &[f32], width: usize, c: usize, n: usize) -> &[f32] {
    let c = if width == 1 { 0 } else { c };
    if v.len() == width { &v[c..c + 1] } else { &v[c * n..(c + 1) * n] }
}

#[inline]
pub(crate) fn at(run: &[f32], i: usize) -> f32 {
    if run.len() == 1 { run[0] } else { run[i] }
}

/// Append `f` of two runs.
#[inline]
pub(crate) fn zip(out: &mut Vec<f32>, a: &[f32], b: &[f32], n: usize, f: impl Fn(f32, f32) -> f32) {
    match (a, b) {
        ([a], [b]) => out.extend(std::iter::repeat_n(f(*a, *b), n)),
        ([a], b) => out.extend(b.iter().map(|b| f(*a, *b))),
        (a, [b]) => out.extend(a.iter().map(|a| f(*a, *b))),
        (a, b) => out.extend(a.iter().zip(b).map(|(a, b)| f(*a, *b))),
    }
}

/// xʸ, 0 where it is not a number.
pub(crate) fn power(x: f32, y: f32) -> f32 {
    let p = x.powf(y);
    if p.is_nan() { 0.0 } else { p }
}

#[inline]
pub(crate) fn triple(v: &[f32], k: usize, n: usize) -> [f32; 3] {
    if v.len() == 3 { [v[0], v[1], v[2]] } else { [v[k], v[n + k], v[2 * n + k]] }
}

#[inline]
pub(crate) fn put(out: &mut [f32], k: usize, lanes: usize, v: [f32; 3]) {
    for c in 0..3 {
        out[c * lanes + k] = v[c];
    }
}

#[inline]
pub(crate) fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline]
pub(crate) fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(crate) fn refract(i: [f32; 3], m: [f32; 3], eta: f32) -> [f32; 3] {
    let d = dot(i, m);
    let k = 1.0 - eta * eta * (1.0 - d * d);
    if k < 0.0 {
        return [0.0; 3];
    }
    let f = eta * d + k.sqrt();
    [0, 1, 2].map(|c| eta * i[c] - f * m[c])
}

/// Append `f` of two triples, `width` of its numbers, at every point, or once if both are uniform.
#[inline]
pub(crate) fn triples2(
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

/// Two numbers in [0, 1) for sample `i` of `n`: an (R₂) low-discrepancy sequence (Roberts 2018), moved by the place so that
/// neighbours differ.
pub fn spread(i: usize, p: [f32; 3]) -> [f32; 2] {
    let salt = |c: u32| crate::noise::cell_noise(p.map(|x| (x * 8192.0).round()), c);
    let i = i as f32 + 1.0;
    [(i * 0.754_877_7 + salt(0)).fract(), (i * 0.569_840_3 + salt(1)).fract()]
}

/// Two directions square to a unit one.
fn frame(n: [f32; 3]) -> [[f32; 3]; 2] {
    let sign = 1f32.copysign(n[2]);
    let a = -1.0 / (sign + n[2]);
    let b = n[0] * n[1] * a;
    [[1.0 + sign * n[0] * n[0] * a, sign * b, -sign * n[0]], [b, sign + n[1] * n[1] * a, -n[1]]]
}

/// A direction about a unit axis within an angle, even in solid angle.
pub(crate) fn in_cone(axis: [f32; 3], angle: f32, i: usize, n: usize, p: [f32; 3]) -> [f32; 3] {
    let length = dot(axis, axis).sqrt();
    let axis = if length > 0.0 { axis.map(|x| x / length) } else { [0.0, 0.0, 1.0] };
    if n == 1 || angle <= 0.0 {
        return axis;
    }
    let [x, y] = spread(i, p);
    around(axis, 1.0 - x * (1.0 - angle.min(std::f32::consts::PI).cos()), y)
}

/// A direction about a unit normal, by the cosine.
pub(crate) fn in_hemisphere(normal: [f32; 3], i: usize, p: [f32; 3]) -> [f32; 3] {
    let [x, y] = spread(i, p);
    around(normal, (1.0 - x).sqrt(), y)
}

fn around(axis: [f32; 3], cosine: f32, turn: f32) -> [f32; 3] {
    let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
    let (s, c) = (turn * std::f32::consts::TAU).sin_cos();
    let [u, v] = frame(axis);
    [0, 1, 2].map(|k| axis[k] * cosine + (u[k] * c + v[k] * s) * sine)
}
