//! Values of up to sixteen numbers, and matrices.

use super::noise::{noise4, periodic_noise};

/// The element that a number names, if there is one.
pub fn element(i: f32, len: u16) -> Option<usize> {
    (i >= 0.0 && i < len as f32).then_some(i as usize)
}

pub fn one16(x: f32) -> [f32; 16] {
    let mut v = [0.0; 16];
    v[0] = x;
    v
}

pub fn triple16([x, y, z]: [f32; 3]) -> [f32; 16] {
    let mut v = [0.0; 16];
    (v[0], v[1], v[2]) = (x, y, z);
    v
}

/// The inverse; of a matrix that has none, zero.
pub fn inverse(m: glam::Mat4) -> glam::Mat4 {
    if m.determinant() != 0.0 { m.inverse() } else { glam::Mat4::ZERO }
}

/// Noise with periods: one, two, three or four numbers, then as many periods.
pub fn periodic(widths: &[usize], v: &[[f32; 16]]) -> [f32; 16] {
    let half = v.len() / 2;
    let numbers = |args: &[[f32; 16]]| {
        let mut all = [0.0f32; 4];
        let mut k = 0;
        for (value, width) in args.iter().zip(widths) {
            all[k..k + width].copy_from_slice(&value[..*width]);
            k += width;
        }
        (all, k)
    };
    let ((at, n), (period, _)) = (numbers(&v[..half]), numbers(&v[half..]));
    let (p, q) = ([at[0], at[1], at[2]], [period[0], period[1], period[2]]);
    triple16([0, 1, 2].map(|c| if n == 4 { noise4(p, at[3], Some(period), c) } else { periodic_noise(p, q, c) }))
}
