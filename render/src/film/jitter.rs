//! Sample positions, times and lens positions: jittered in the strata of a pixel. All depend on the pixel alone, so that every
//! bucket sees the same samples.

/// Period of the sample pattern along x and y, pixels; a power of two.
pub const PERIOD: usize = 32;

/// Steps of a pixel that samples lie on.
const STEPS: f32 = 1024.0;

/// The sample pattern of an image.
pub struct Jitter {
    /// Count of samples along x and y of a pixel, one in each stratum.
    pub strata: [usize; 2],
    /// For each stratum of the pattern, the sample's place from its pixel's corner on.
    offset: Vec<[f32; 2]>,
    /// Whether the camera has a lens, and so depth of field.
    pub lens: bool,
    /// Times and lens positions; none if neither motion nor a lens blurs the image.
    pub moments: Option<Moments>,
}

/// Times and lens positions of samples. The shutter's time has as many strata as a pixel has samples, each paired with one cell of
/// the lens; the assignment of these strata to the samples of a pixel is shuffled from pixel to pixel.
pub struct Moments {
    /// For each pixel of the pattern and each stratum of time, the sample's column and row in the pixel.
    order: Vec<[u8; 2]>,
    /// Likewise its time, 0 to 1, and its place on the lens, a disk of radius 1.
    moment: Vec<[f32; 3]>,
    /// For each stratum of time, the minimum and maximum over all pixels of time (0 to 1 of the shutter), lens x and lens y (unit
    /// disk).
    pub bounds: Vec<[[f32; 2]; 3]>,
}

/// A number in [0, 1) of its own for every index.
fn number(i: usize) -> f32 {
    let mut h = (i as u32).wrapping_mul(0x9e37_79b9) ^ 0x5bd1_e995;
    h = (h ^ (h >> 16)).wrapping_mul(0x7feb_352d);
    h = (h ^ (h >> 15)).wrapping_mul(0x846c_a68b);
    (h ^ (h >> 16)) as f32 / 4_294_967_808.0
}

/// A square, 0 to 1, on the unit disk, neighbours beside neighbours (Shirley and Chiu 1997).
fn on_disk(x: f32, y: f32) -> [f32; 2] {
    let (a, b) = (2.0 * x - 1.0, 2.0 * y - 1.0);
    let quarter = std::f32::consts::FRAC_PI_4;
    let (r, angle) = match () {
        () if a == 0.0 && b == 0.0 => return [0.0; 2],
        () if a.abs() > b.abs() => (a, quarter * b / a),
        () => (b, 2.0 * quarter - quarter * a / b),
    };
    [r * angle.cos(), r * angle.sin()]
}

impl Jitter {
    /// The pattern for `strata` samples along x and y of a pixel; `lens` and `moves` say whether the camera has a lens and whether
    /// the scene moves.
    pub fn new(strata: [usize; 2], lens: bool, moves: bool) -> Jitter {
        let (nx, ny) = (PERIOD * strata[0], PERIOD * strata[1]);
        // Of steps that single precision adds to any pixel's number without rounding, so that it matters to no sum whether places
        // are counted from the image's corner or a bucket's.
        let step = |k: usize, n: usize, random: f32| (((k % n) as f32 + random) / n as f32 * STEPS).floor() / STEPS;
        let place = |i: usize| {
            let random = if strata == [1, 1] { [0.5, 0.5] } else { [number(2 * i), number(2 * i + 1)] };
            [step(i % nx, strata[0], random[0]), step(i / nx, strata[1], random[1])]
        };
        let offset = (0..nx * ny).map(place).collect();
        Jitter { strata, offset, lens, moments: (lens || moves).then(|| Moments::new(strata)) }
    }

    /// The positions of the pattern's samples from their pixels' corners on, row by row of strata.
    pub(crate) fn offsets(&self) -> &[[f32; 2]] {
        &self.offset
    }

    /// The position of the sample in a stratum of a pixel, counted from the image's corner; 0 to 1 from the pixel's upper left
    /// corner.
    #[inline]
    pub fn in_pixel(&self, pixel: [i64; 2], stratum: [usize; 2]) -> [f32; 2] {
        let [column, row] = [0, 1].map(|c| (pixel[c] & (PERIOD as i64 - 1)) as usize * self.strata[c] + stratum[c]);
        self.offset[row * PERIOD * self.strata[0] + column]
    }
}

impl Moments {
    fn new(strata: [usize; 2]) -> Moments {
        let n = strata[0] * strata[1];
        // A step that meets every cell of the lens and leaves no two strata that follow each other side by side.
        let step = (1..=n).filter(|k| gcd(*k, n) == 1).min_by_key(|k| k.abs_diff(n * 5 / 13)).unwrap_or(1);
        let mut moments = Moments { order: vec![], moment: vec![], bounds: vec![[[1.0, -1.0]; 3]; n] };
        for pixel in 0..PERIOD * PERIOD {
            let random = |k: usize| number((pixel * n + k) * 4 + 0x51ed_270b);
            let mut order: Vec<u16> = (0..n as u16).collect();
            (1..n).rev().for_each(|k| order.swap(k, (random(k) * (k + 1) as f32) as usize));
            for s in 0..n {
                let r = |c: usize| number((pixel * n + s) * 4 + c);
                let cell = s * step % n;
                let [x, y] = on_disk(
                    ((cell % strata[0]) as f32 + r(1)) / strata[0] as f32,
                    ((cell / strata[0]) as f32 + r(2)) / strata[1] as f32,
                );
                let moment = [(s as f32 + r(3)) / n as f32, x, y];
                for (bound, m) in moments.bounds[s].iter_mut().zip(moment) {
                    *bound = if bound[0] > bound[1] { [m, m] } else { [bound[0].min(m), bound[1].max(m)] };
                }
                moments.moment.push(moment);
            }
            let place = |k: u16| [(k as usize % strata[0]) as u8, (k as usize / strata[0]) as u8];
            moments.order.extend(order.into_iter().map(place));
        }
        moments
    }

    /// The sample of pixel (`x`, `y`), counted from the image's corner, that falls in a stratum of time: its column and row among
    /// the pixel's strata, and its time (0 to 1 of the shutter), lens x and lens y (unit disk).
    #[inline]
    pub fn of(&self, x: i64, y: i64, stratum: usize) -> ([u8; 2], [f32; 3]) {
        let last = PERIOD as i64 - 1;
        let at = ((y & last) as usize * PERIOD + (x & last) as usize) * self.bounds.len() + stratum;
        (self.order[at], self.moment[at])
    }
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sample_has_one_moment() {
        for strata in [[1, 1], [4, 4], [3, 5]] {
            let n = strata[0] * strata[1];
            let jitter = Jitter::new(strata, true, true);
            let moments = jitter.moments.unwrap();
            let (mut mean, mut area) = ([0.0; 3], 0.0);
            for (x, y) in (0..32).flat_map(|y| (0..32).map(move |x| (x - 16, y - 40))) {
                let place = |s: usize| moments.of(x, y, s).0.map(usize::from);
                let mut places: Vec<usize> = (0..n).map(|s| place(s)[1] * strata[0] + place(s)[0]).collect();
                places.sort();
                assert_eq!(places, (0..n).collect::<Vec<_>>());
                for s in 0..n {
                    let m = moments.of(x, y, s).1;
                    assert!((s as f32..=(s + 1) as f32).contains(&(m[0] * n as f32)), "{m:?}");
                    (0..3).for_each(|c| mean[c] += m[c] / (1024 * n) as f32);
                    area += (m[1] * m[1] + m[2] * m[2]) / (1024 * n) as f32;
                }
            }
            // Time is even, the lens is even over a disk: the mean of r² is ½.
            assert!((mean[0] - 0.5).abs() < 0.02 && mean[1].abs() < 0.03 && mean[2].abs() < 0.03, "{mean:?}");
            assert!((area - 0.5).abs() < 0.02, "{area}");
        }
    }
}
