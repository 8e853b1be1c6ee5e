//! Noise functions (RISpec 15.1), the same in every run: gradient noise in [0, 1] with mean ½, and cell noise.

/// A whole coordinate along an axis, spread over all bits, for [`mix`].
#[inline]
fn spread(c: i32, axis: usize) -> u32 {
    (c as u32).wrapping_mul([0x8da6_b343, 0xd816_3841, 0xcb1a_b31f][axis])
}

/// A well-mixed number of the coordinates' spread bits and a channel's.
#[inline]
fn mix(bits: u32) -> u32 {
    let h = (bits ^ (bits >> 16)).wrapping_mul(0x7feb_352d);
    let h = (h ^ (h >> 15)).wrapping_mul(0x846c_a68b);
    h ^ (h >> 16)
}

/// The bits of a channel, for [`mix`].
#[inline]
fn channel_bits(channel: u32) -> u32 {
    channel.wrapping_mul(0x9e37_79b9)
}

/// The cell that a coordinate is in, by what processors without an instruction for it do quickest.
#[inline]
fn cell_of(x: f32) -> f32 {
    // Beyond, all are whole.
    if !(x.abs() < 8_388_608.0) {
        return x;
    }
    let whole = x as i32 as f32;
    if whole > x { whole - 1.0 } else { whole }
}

/// The gradients of lattice points by four bits of their numbers: the twelve edge directions of a cube, four of them twice.
const GRADIENTS: [[f32; 3]; 16] = {
    let mut all = [[0.0; 3]; 16];
    let mut h = 0;
    while h < 16 {
        let u = if h < 8 { 0 } else { 1 };
        let v = match h {
            0..4 => 1,
            12 | 14 => 0,
            _ => 2,
        };
        all[h][u] = if h & 1 == 0 { 1.0 } else { -1.0 };
        all[h][v] = if h & 2 == 0 { 1.0 } else { -1.0 };
        h += 1;
    }
    all
};

#[inline]
fn fade(t: f32) -> f32 {
    t * t * t * (t * (t * 6.0 - 15.0) + 10.0)
}

#[inline]
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
#[inline]
fn lattice(p: [f32; 3], channel: u32, wrap: impl Fn(i32, usize) -> i32) -> f32 {
    let cell = p.map(cell_of);
    let [x, y, z] = [p[0] - cell[0], p[1] - cell[1], p[2] - cell[2]];
    let cell = cell.map(|c| c as i32);
    // Of the two planes of lattice points along each axis.
    let bits = [0, 1, 2].map(|axis| [0, 1].map(|d: i32| spread(wrap(cell[axis].wrapping_add(d), axis), axis)));
    let channel = channel_bits(channel);
    let (u, v, w) = (fade(x), fade(y), fade(z));
    let plane = |dz: usize| {
        let mixed: [u32; 4] = std::array::from_fn(|c| mix(bits[0][c & 1] ^ bits[1][c >> 1] ^ bits[2][dz] ^ channel));
        // A lattice point's gradient times the way from it; two of the three products count.
        let corner = |dx: usize, dy: usize| {
            let [a, b, c] = GRADIENTS[(mixed[dx + 2 * dy] & 15) as usize];
            a * (x - dx as f32) + b * (y - dy as f32) + c * (z - dz as f32)
        };
        lerp(v, lerp(u, corner(0, 0), corner(1, 0)), lerp(u, corner(0, 1), corner(1, 1)))
    };
    let near = plane(0);
    // Of two numbers alone, and on any other lattice plane, the next plane adds nothing.
    if z == 0.0 {
        return (0.5 + 0.5 * near).clamp(0.0, 1.0);
    }
    let far = plane(1);
    (0.5 + 0.5 * lerp(w, near, far)).clamp(0.0, 1.0)
}

/// Cell noise: a number in [0, 1) that is constant over each unit cell; channels are independent of each other.
#[inline]
pub fn cell_noise(p: [f32; 3], channel: u32) -> f32 {
    noise_of_cell(p.map(|c| cell_of(c) as i32), channel)
}

/// The same of the cell of these numbers.
#[inline]
pub fn noise_of_cell([i, j, k]: [i32; 3], channel: u32) -> f32 {
    mix(spread(i, 0) ^ spread(j, 1) ^ spread(k, 2) ^ channel_bits(channel.wrapping_add(77))) as f32 / 4_294_967_296.0
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
