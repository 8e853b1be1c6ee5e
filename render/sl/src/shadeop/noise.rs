//! Noise functions (RISpec 15.1), the same in every run: gradient noise in [0, 1] with mean ½, and cell noise.

use super::wide::wide;

/// A whole coordinate along an axis, spread over all bits, for [`mix`].
#[inline(always)]
fn spread(c: i32, axis: usize) -> u32 {
    (c as u32).wrapping_mul([0x8da6_b343, 0xd816_3841, 0xcb1a_b31f][axis])
}

/// A well-mixed number of the coordinates' spread bits and a channel's.
#[inline(always)]
fn mix(bits: u32) -> u32 {
    let h = (bits ^ (bits >> 16)).wrapping_mul(0x7feb_352d);
    let h = (h ^ (h >> 15)).wrapping_mul(0x846c_a68b);
    h ^ (h >> 16)
}

/// The bits of a channel, for [`mix`].
#[inline(always)]
fn channel_bits(channel: u32) -> u32 {
    channel.wrapping_mul(0x9e37_79b9)
}

/// The cell that a coordinate is in, by what processors without an instruction for it do quickest.
#[inline(always)]
fn cell_of(x: f32) -> f32 {
    let whole = x as i32 as f32;
    let below = if whole > x { whole - 1.0 } else { whole };
    // Beyond, all are whole.
    if x.abs() < 8_388_608.0 { below } else { x }
}

/// The gradient of a lattice point times the way from it. The gradients are the twelve edge directions of a cube, four of them twice, by four
/// bits of the point's number.
#[inline(always)]
fn corner(mixed: u32, [x, y, z]: [f32; 3]) -> f32 {
    let h = mixed & 15;
    let u = if h < 8 { x } else { y };
    let v = if h < 4 {
        y
    } else if h & 13 == 12 {
        x
    } else {
        z
    };
    let signed = |x: f32, bit: u32| f32::from_bits(x.to_bits() ^ (bit & 1) << 31);
    signed(u, h) + signed(v, h >> 1)
}

#[inline(always)]
fn fade(t: f32) -> f32 {
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}

#[inline(always)]
fn lerp(t: f32, a: f32, b: f32) -> f32 {
    a + t * (b - a)
}

/// Gradient noise at a point, in [0, 1]; channels are independent of each other.
#[inline]
pub fn noise(p: [f32; 3], channel: u32) -> f32 {
    lattice(p, channel, |c, _| c)
}

/// Gradient noise at a point, in [0, 1], that repeats with a whole period (at least 1) along each axis.
pub fn periodic_noise(p: [f32; 3], period: [f32; 3], channel: u32) -> f32 {
    let period = period.map(|x| (x.abs() as i32).max(1));
    lattice(p, channel, |c, axis| c.rem_euclid(period[axis]))
}

/// Gradient noise in four dimensions, in [0, 1]: three-dimensional noise at `p`, interpolated smoothly along `t`. With `period`, it
/// repeats along each of the four axes.
pub fn noise4(p: [f32; 3], t: f32, period: Option<[f32; 4]>, channel: u32) -> f32 {
    let cell = t.floor();
    let layer = |k: f32| {
        let k = match period {
            Some(period) => k.rem_euclid(period[3].abs().floor().max(1.0)),
            None => k,
        };
        let salt = (k as i32 as u32).wrapping_mul(0x2545_f491) ^ channel;
        match period {
            Some([x, y, z, _]) => periodic_noise(p, [x, y, z], salt),
            None => noise(p, salt),
        }
    };
    lerp(fade(t - cell), layer(cell), layer(cell + 1.0))
}

/// Gradient noise; `wrap` brings a lattice point's coordinate along an axis into range.
#[inline(always)]
fn lattice(p: [f32; 3], channel: u32, wrap: impl Fn(i32, usize) -> i32) -> f32 {
    let cell = p.map(cell_of);
    let within = [p[0] - cell[0], p[1] - cell[1], p[2] - cell[2]];
    let near = plane(cell, within, 0, channel, &wrap);
    // On a lattice plane the next one adds nothing.
    if within[2] == 0.0 {
        return (0.5 + 0.5 * near).clamp(0.0, 1.0);
    }
    let far = plane(cell, within, 1, channel, &wrap);
    (0.5 + 0.5 * lerp(fade(within[2]), near, far)).clamp(0.0, 1.0)
}

/// What the lattice plane `dz` after a point's cell gives there.
#[inline(always)]
fn plane(cell: [f32; 3], [x, y, z]: [f32; 3], dz: i32, channel: u32, wrap: &impl Fn(i32, usize) -> i32) -> f32 {
    let bits = |axis: usize, d: i32| spread(wrap((cell[axis] as i32).wrapping_add(d), axis), axis);
    let rest = bits(2, dz) ^ channel_bits(channel);
    let z = z - dz as f32;
    let (low, high) = (bits(1, 0) ^ rest, bits(1, 1) ^ rest);
    let (left, right) = (bits(0, 0), bits(0, 1));
    let below = lerp(fade(x), corner(mix(left ^ low), [x, y, z]), corner(mix(right ^ low), [x - 1.0, y, z]));
    let above =
        lerp(fade(x), corner(mix(left ^ high), [x, y - 1.0, z]), corner(mix(right ^ high), [x - 1.0, y - 1.0, z]));
    lerp(fade(y), below, above)
}

wide! {
    /// Gradient noise at points in the plane z = 0, whose coordinates are runs of one number or one a point.
    pub fn noise_run_flat(out: &mut [f32], x: &[f32], y: &[f32], channel: u32) = flat_loop;
}

wide! {
    /// Gradient noise at points whose coordinates are runs of one number a point.
    pub fn noise_run(out: &mut [f32], p: [&[f32]; 3], channel: u32) = noise_loop;
}

#[inline(always)]
fn flat_loop(out: &mut [f32], x: &[f32], y: &[f32], channel: u32) {
    let n = out.len();
    // Without closures, which might be compiled for any processor.
    match (x, y) {
        ([x], [y]) => out.fill(flat_noise(*x, *y, channel)),
        ([x], y) => {
            let y = &y[..n];
            for k in 0..n {
                out[k] = flat_noise(*x, y[k], channel);
            }
        }
        (x, [y]) => {
            let x = &x[..n];
            for k in 0..n {
                out[k] = flat_noise(x[k], *y, channel);
            }
        }
        (x, y) => {
            let (x, y) = (&x[..n], &y[..n]);
            for k in 0..n {
                out[k] = flat_noise(x[k], y[k], channel);
            }
        }
    }
}

#[inline(always)]
fn flat_noise(x: f32, y: f32, channel: u32) -> f32 {
    let cell = [cell_of(x), cell_of(y), 0.0];
    let near = plane(cell, [x - cell[0], y - cell[1], 0.0], 0, channel, &|c, _| c);
    (0.5 + 0.5 * near).clamp(0.0, 1.0)
}

#[inline(always)]
fn noise_loop(out: &mut [f32], p: [&[f32]; 3], channel: u32) {
    let n = out.len();
    let [x, y, z] = p.map(|run| &run[..n]);
    for k in 0..n {
        let cell = [cell_of(x[k]), cell_of(y[k]), cell_of(z[k])];
        let within = [x[k] - cell[0], y[k] - cell[1], z[k] - cell[2]];
        let near = plane(cell, within, 0, channel, &|c, _| c);
        let far = plane(cell, within, 1, channel, &|c, _| c);
        out[k] = (0.5 + 0.5 * lerp(fade(within[2]), near, far)).clamp(0.0, 1.0);
    }
}

/// Cell noise: a number in [0, 1) that is constant over each unit cell; channels are independent of each other.
#[inline]
pub fn cell_noise(p: [f32; 3], channel: u32) -> f32 {
    noise_of_cell(p.map(|c| cell_of(c) as i32), channel)
}

/// The same of the cell of these numbers.
#[inline]
pub fn noise_of_cell(cell: [i32; 3], channel: u32) -> f32 {
    cell_value(cell, channel)
}

#[inline(always)]
fn cell_value([i, j, k]: [i32; 3], channel: u32) -> f32 {
    mix(spread(i, 0) ^ spread(j, 1) ^ spread(k, 2) ^ channel_bits(channel.wrapping_add(77))) as f32 / 4_294_967_296.0
}

wide! {
    /// Cell noise of the cells (x, y, k) of whole numbers, x from `first` on.
    pub fn noise_of_cells(out: &mut [f32], first: i32, y: i32, k: i32, channel: u32) = cells_loop;
}

#[inline(always)]
fn cells_loop(out: &mut [f32], first: i32, y: i32, k: i32, channel: u32) {
    for i in 0..out.len() {
        out[i] = cell_value([first.wrapping_add(i as i32), y, k], channel);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_whole_numbers_from_below() {
        for x in
            [0.0, 0.5, 1.0, -0.25, -1.0, -1.0000001, 7.9999995, 8_388_607.5, -8_388_607.5, 1e9, -3e12, f32::INFINITY]
        {
            assert_eq!(cell_of(x), x.floor(), "{x}");
        }
        assert!(cell_of(f32::NAN).is_nan());
    }

    #[test]
    fn runs_have_the_bits_of_single_points() {
        let n = 203;
        let run = |step: f32, first: f32| (0..n).map(|k| first + step * k as f32).collect::<Vec<f32>>();
        let (x, y, z) = (run(0.137, -9.0), run(-1.91, 40.0), run(0.25, -3.0));
        let far = [1e9, -8_388_607.5, 3.0, -0.0, 0.0];
        let (mut out, mut flat) = (vec![0.0; n], vec![0.0; n]);
        for (x, channel) in [(&x[..], 0), (&x[..], 2), (&far[..], 1)] {
            let n = x.len();
            noise_run(&mut out[..n], [x, &y[..n], &z[..n]], channel);
            noise_run_flat(&mut flat[..n], x, &y[..n], channel);
            for k in 0..n {
                assert_eq!(out[k].to_bits(), noise([x[k], y[k], z[k]], channel).to_bits());
                assert_eq!(flat[k].to_bits(), noise([x[k], y[k], 0.0], channel).to_bits());
            }
            noise_of_cells(&mut flat[..n], -7, 5, channel as i32, 9);
            (0..n).for_each(|k| assert_eq!(flat[k], noise_of_cell([k as i32 - 7, 5, channel as i32], 9)));
            noise_run_flat(&mut flat, &x[..1], &z, channel);
            out.iter_mut().zip(&z).for_each(|(out, z)| *out = noise([x[0], *z, 0.0], channel));
            assert_eq!(flat, out);
        }
    }

    #[test]
    fn periodic_noise_repeats_and_four_numbers_are_smooth() {
        let p = [0.3, 1.7, 2.2];
        let moved = [p[0] + 4.0, p[1] - 3.0, p[2] + 10.0];
        assert!((periodic_noise(p, [4.0, 3.0, 5.0], 2) - periodic_noise(moved, [4.0, 3.0, 5.0], 2)).abs() < 1e-5);
        assert!((noise4(p, 0.9999, None, 0) - noise4(p, 1.0001, None, 0)).abs() < 1e-3);
        let period = Some([4.0, 3.0, 5.0, 2.0]);
        assert!((noise4(p, 0.4, period, 0) - noise4(moved, 2.4, period, 0)).abs() < 1e-5);
    }

    #[test]
    fn noise_has_its_range_and_mean() {
        let (mut sum, mut lo, mut hi, n) = (0.0f64, 1.0f32, 0.0f32, 60);
        for i in 0..n * n * n {
            let p = [i % n, i / n % n, i / n / n].map(|c| c as f32 * 0.37 + 0.123);
            let x = noise(p, 0);
            (sum, lo, hi) = (sum + x as f64, lo.min(x), hi.max(x));
        }
        let mean = sum / (n * n * n) as f64;
        assert!((mean - 0.5).abs() < 5e-3, "mean {mean}");
        assert!((0.0..0.2).contains(&lo) && (0.8..=1.0).contains(&hi), "{lo} {hi}");
        assert_eq!(noise([3.0, -2.0, 7.0], 0), 0.5);
        assert_eq!(noise([0.3, 0.4, 0.5], 1), noise([0.3, 0.4, 0.5], 1));
    }
}
