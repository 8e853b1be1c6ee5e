//! Directions and places spread evenly: for rays into a cone or a hemisphere, and for points of area lights.

use super::noise::cell_noise;
use super::runs::dot;

/// A sample point of the unit square, [0, 1)²: element `i` of the R₂ low-discrepancy sequence (Roberts 2018), shifted by a hash of
/// the position `p`, so that neighbouring points of a surface have different samples.
pub fn spread(i: usize, p: [f32; 3]) -> [f32; 2] {
    let salt = |c: u32| cell_noise(p.map(|x| (x * 8192.0).round()), c);
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
pub fn in_cone(axis: [f32; 3], angle: f32, i: usize, n: usize, p: [f32; 3]) -> [f32; 3] {
    let length = dot(axis, axis).sqrt();
    let axis = if length > 0.0 { axis.map(|x| x / length) } else { [0.0, 0.0, 1.0] };
    if n == 1 || angle <= 0.0 {
        return axis;
    }
    let [x, y] = spread(i, p);
    around(axis, 1.0 - x * (1.0 - angle.min(std::f32::consts::PI).cos()), y)
}

/// A direction about a unit normal, by the cosine.
pub fn in_hemisphere(normal: [f32; 3], i: usize, p: [f32; 3]) -> [f32; 3] {
    let [x, y] = spread(i, p);
    around(normal, (1.0 - x).sqrt(), y)
}

fn around(axis: [f32; 3], cosine: f32, turn: f32) -> [f32; 3] {
    let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
    let (s, c) = (turn * std::f32::consts::TAU).sin_cos();
    let [u, v] = frame(axis);
    [0, 1, 2].map(|k| axis[k] * cosine + (u[k] * c + v[k] * s) * sine)
}
