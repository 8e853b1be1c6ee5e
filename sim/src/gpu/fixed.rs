//! Positions in fixed point: three whole numbers of 64 bits, in fine units, a power of two of a metre.
//!
//! Gaps and radii are in units q of at most 2⁻²² of the least radius; positions are in fine units of q/1024, so that the motion of a step is
//! carried on to 2⁻³² of that radius, and what moves by less than that in a step stands still. The difference of two positions is exact,
//! and rounded to q. A position that is taken from double precision is off by q/2048, a difference by q/2 + q/1024 along each axis, and a
//! radius by q/2, so that a gap is off by at most 1.9 q, 4.6e-7 of the least radius, anywhere within 2⁶² fine units of the origin: for
//! grains of a millimetre, the nearest 10⁶ m. Squares of differences are exact, and so is d² − R² of a distance d and a sum of radii R,
//! modulo 2⁶⁴; the gap is (d² − R²) / (d + R) with a few roundings of single precision, 6e-7 of the gap itself. Where |d² − R²| exceeds
//! 4e18 q² it is d − R in single precision, right to 5e-7 of R: spheres of the least radius are then more than a hundred radii apart, and
//! those of 300 times that radius overlap by more than a twelfth of R. Coordinates in the frame of a fixture are products of 64 by 64 bits
//! with axes of 60 bits, right to three fine units.
//!
//! Within 2⁵³ fine units, two million of the least radius, a position is a number of double precision, so that a checkpoint has it bit for
//! bit.
//!
//! Twin: fixed.wgsl

use super::rows::Fixed;
use glam::DVec3;

/// The units of lengths in fixed point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// The unit of gaps and radii, m.
    pub unit: f64,
}

/// Bits that the fine unit of positions is smaller than the unit.
const FRACTION: i32 = 10;

/// Bits that the unit is smaller than the least radius.
const BITS: i32 = 22;

/// The greatest ratio of radii: a radius has 32 bits.
pub const MAX_RATIO: f64 = 500.0;

impl Scale {
    /// The scale for spheres of at least this radius, m: the greatest power of two that is at most 2⁻²² of it.
    pub fn of(least_radius: f64) -> Scale {
        let exponent = least_radius.log2().floor() as i32 - BITS;
        let unit = 2f64.powi(exponent);
        // The logarithm may have been rounded up.
        Scale { unit: if unit * 2f64.powi(BITS) > least_radius { 0.5 * unit } else { unit } }
    }

    /// The unit of positions, m.
    pub fn fine(self) -> f64 {
        self.unit / (1 << FRACTION) as f64
    }

    /// A position, m, to the nearest fine units; none if it is not finite or further than 2⁶² of them from the origin along an axis.
    pub fn fix(self, position: DVec3) -> Option<Fixed> {
        const MOST: f64 = (1_u64 << 62) as f64;
        let units = (position / self.fine()).round();
        let is_near = units.is_finite() && units.abs().max_element() < MOST;
        is_near.then(|| {
            let [x, y, z] = units.to_array().map(|k| words(k as i64));
            Fixed { x, y, z }
        })
    }

    /// Components of a unit vector over 2⁶⁰.
    pub fn axis(axis: DVec3) -> Fixed {
        const ONE: f64 = (1_u64 << 60) as f64;
        let [x, y, z] = axis.to_array().map(|k| words((k * ONE) as i64));
        Fixed { x, y, z }
    }

    /// A position, m.
    pub fn unfix(self, fixed: Fixed) -> DVec3 {
        DVec3::from_array(whole(fixed).map(|k| k as f64)) * self.fine()
    }

    /// A radius, m, in units.
    pub fn radius(self, radius: f64) -> u32 {
        (radius / self.unit).round() as u32
    }
}

/// Low and high word of a number.
fn words(k: i64) -> [u32; 2] {
    [k as u32, (k >> 32) as u32]
}

/// The numbers of a position.
fn whole(fixed: Fixed) -> [i64; 3] {
    [fixed.x, fixed.y, fixed.z].map(|[low, high]| (high as i64) << 32 | low as i64)
}

/// The CPU twin of `normal_and_gap` in `fixed.wgsl`, in double precision over the exact numbers: the gap of two spheres, m.
pub fn gap_cpu(scale: Scale, [a, b]: [Fixed; 2], radii: [u32; 2]) -> f64 {
    let (a, b) = (whole(a), whole(b));
    let half = 1 << (FRACTION - 1);
    let d: [i128; 3] = std::array::from_fn(|k| (b[k] as i128 - a[k] as i128 + half) >> FRACTION);
    let squares: i128 = d.iter().map(|x| x * x).sum();
    let reach = radii[0] as i128 + radii[1] as i128;
    (squares - reach * reach) as f64 / ((squares as f64).sqrt() + reach as f64) * scale.unit
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fill::SplitMix64;

    #[test]
    fn the_unit_is_a_power_of_two_below_the_radius() {
        for radius in [1e-6, 1e-3, 0.075, 0.25, 0.5, 1.0, 3.0, 1e4] {
            let unit = Scale::of(radius).unit;
            assert_eq!(unit.log2().fract(), 0.0);
            let ratio = radius / unit;
            assert!((2f64.powi(22)..2f64.powi(23)).contains(&ratio), "{radius}: {ratio}");
        }
    }

    #[test]
    fn positions_come_back_and_differences_are_exact() {
        let scale = Scale::of(0.01);
        let mut random = SplitMix64(3);
        for size in [1e-3, 1.0, 1e3, 1e6] {
            let p = DVec3::from_array(std::array::from_fn(|_| random.between(-size, size)));
            let back = scale.unfix(scale.fix(p).unwrap());
            assert!((back - p).abs().max_element() <= 0.5 * scale.fine(), "{p}");
            assert_eq!(scale.fix(back), scale.fix(p));
        }
        assert_eq!(scale.fix(DVec3::splat(f64::NAN)), None);
        assert_eq!(scale.fix(DVec3::splat(1e30)), None);
        let fixed = scale.fix(DVec3::new(-1.0, 2.0, -scale.fine())).unwrap();
        assert_eq!(whole(fixed), [-(1.0 / scale.fine()) as i64, (2.0 / scale.fine()) as i64, -1]);
    }

    /// A kilometre and a thousand kilometres from the origin, a gap is right to 1e-6 of the least radius.
    #[test]
    fn a_gap_is_right_far_from_the_origin() {
        let mut random = SplitMix64(4);
        for far in [0.0, 1e3, 1e6] {
            for _ in 0..1000 {
                let least = 0.01;
                let scale = Scale::of(least);
                let radii = [least, random.between(least, 300.0 * least)];
                let reach = radii[0] + radii[1] + random.between(-0.3, 0.3) * least;
                let direction = random.rotation() * DVec3::X;
                let a = DVec3::from_array(std::array::from_fn(|_| far + random.between(-1.0, 1.0)));
                let b = a + direction * reach;
                let exact = (b - a).length() - radii[0] - radii[1];
                let gap = gap_cpu(scale, [a, b].map(|p| scale.fix(p).unwrap()), radii.map(|r| scale.radius(r)));
                assert!((gap - exact).abs() < 1e-6 * least, "{gap} {exact}");
            }
        }
    }
}
