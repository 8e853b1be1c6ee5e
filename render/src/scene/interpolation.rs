//! Interpolation over a patch: between its corners, and by Bernstein's polynomials.

use glam::Vec3;

/// A number between those of four corners.
pub(crate) fn bilinear(c: [f32; 4], u: f32, v: f32) -> f32 {
    (c[0] * (1.0 - u) + c[1] * u) * (1.0 - v) + (c[2] * (1.0 - u) + c[3] * u) * v
}

/// Bilinear interpolation between corners.
pub(crate) fn lerp4(c: [Vec3; 4], u: f32, v: f32) -> Vec3 {
    c[0].lerp(c[1], u).lerp(c[2].lerp(c[3], u), v)
}

/// Bernstein's polynomials of the third degree.
pub(crate) fn bernstein(t: f32) -> [f32; 4] {
    let s = 1.0 - t;
    [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t]
}

/// Their derivatives.
pub(crate) fn bernstein_slope(t: f32) -> [f32; 4] {
    let s = 1.0 - t;
    [-3.0 * s * s, 3.0 * s * s - 6.0 * s * t, 6.0 * s * t - 3.0 * t * t, 3.0 * t * t]
}

/// The control points of a part of a cubic Bézier curve, between two of its parameters.
#[inline]
pub fn cubic_part<T: Copy + std::ops::Mul<f32, Output = T> + std::ops::Add<Output = T>>(
    p: [T; 4],
    [a, b]: [f32; 2],
) -> [T; 4] {
    let between = |p: T, q: T, t: f32| p * (1.0 - t) + q * t;
    // The blossom: three steps of de Casteljau, each at its own parameter.
    let at = |t: [f32; 3]| {
        let q = [0, 1, 2].map(|k| between(p[k], p[k + 1], t[0]));
        let r = [0, 1].map(|k| between(q[k], q[k + 1], t[1]));
        between(r[0], r[1], t[2])
    };
    [at([a, a, a]), at([a, a, b]), at([a, b, b]), at([b, b, b])]
}
