//! Points in columns, of which the farthest in a direction is sought: the support function of a polyhedron, and its most facing face.

use crate::lanes::{LaneLoop, Lanes4, widest};
use glam::DVec3;

/// Points in columns of four. The last ones are repeated to fill the columns.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Columns {
    xyz: Vec<[[f64; 4]; 3]>,
}

impl Columns {
    /// The columns of some points.
    pub fn of(points: &[DVec3]) -> Columns {
        let four = |points: &[DVec3]| {
            let point = |k: usize| points[k.min(points.len() - 1)];
            [0, 1, 2].map(|axis| [0, 1, 2, 3].map(|k| point(k)[axis]))
        };
        Columns { xyz: points.chunks(4).map(four).collect() }
    }

    /// Index of the point that is farthest in a direction, the first one of several; 0 without points.
    pub fn farthest(&self, direction: DVec3) -> usize {
        widest(Farthest { points: self, direction })
    }
}

/// The arguments of [`Columns::farthest`].
struct Farthest<'a> {
    points: &'a Columns,
    direction: DVec3,
}

impl LaneLoop for Farthest<'_> {
    type Out = usize;

    #[inline(always)]
    fn run<V: Lanes4>(self) -> usize {
        let [x, y, z] = self.direction.to_array().map(V::splat);
        let (mut far, mut at) = (V::splat(f64::NEG_INFINITY), V::splat(0.0));
        for (k, c) in self.points.xyz.iter().enumerate() {
            let here = V::load(&c[0]) * x + V::load(&c[1]) * y + V::load(&c[2]) * z;
            at = here.select_le(far, at, V::splat(k as f64));
            far = here.select_le(far, far, here);
        }
        let (far, at) = (far.to_array(), at.to_array());
        let mut best = (f64::NEG_INFINITY, 0);
        for lane in 0..4 {
            let index = 4 * at[lane] as usize + lane;
            if far[lane] > best.0 || (far[lane] == best.0 && index < best.1) {
                best = (far[lane], index);
            }
        }
        best.1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fill::SplitMix64;

    #[test]
    fn the_farthest_is_that_of_a_plain_search() {
        let mut random = SplitMix64(3);
        for n in (1..30).chain([64, 257]) {
            // On a grid, so that several are equally far.
            let mut point = || DVec3::from([0; 3].map(|_| random.between(-2.0, 2.0).round()));
            let points: Vec<DVec3> = (0..n).map(|_| point()).collect();
            let columns = Columns::of(&points);
            for _ in 0..50 {
                let d = point();
                let far = |k: usize| points[k].x * d.x + points[k].y * d.y + points[k].z * d.z;
                let first = (0..n).rev().max_by(|i, j| far(*i).total_cmp(&far(*j))).unwrap();
                let found = columns.farthest(d);
                assert!(found < n && far(found) == far(first), "{n}: {found} {first}");
            }
        }
        assert_eq!(Columns::default().farthest(DVec3::X), 0);
    }
}
