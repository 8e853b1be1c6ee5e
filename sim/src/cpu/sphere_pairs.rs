//! Narrow phase of sphere pairs, four at a time, where the plan has spheres only.

use super::contact_rows::{Rows, along};
use crate::lanes::{Lane3, LaneLoop, Lanes4, four, four_mut};
use crate::sphere::Sphere;
use crate::twist::Twist;

/// Four spheres.
struct Spheres<V> {
    centre: Lane3<V>,
    reach: V,
    radius: V,
}

impl<V: Lanes4> Spheres<V> {
    /// The first (side 0) or the second (side 1) spheres of four pairs. A sphere has the layout of a twist.
    #[inline(always)]
    fn of(spheres: &[Sphere], pairs: &[[u32; 2]; 4], side: usize) -> Spheres<V> {
        let row = |pair: [u32; 2]| -> &Twist { bytemuck::cast_ref(&spheres[pair[side] as usize]) };
        let [centre, rest] = V::twists([row(pairs[0]), row(pairs[1]), row(pairs[2]), row(pairs[3])]);
        Spheres { centre, reach: rest.x, radius: rest.y }
    }
}

/// Find the pairs that touch: their count, and their indices at the beginning of `place`. The branch could not be predicted, so that
/// every index is written and only those of pairs that touch are counted.
pub struct Find<'a> {
    /// The pairs.
    pub pairs: &'a [[u32; 2]],
    /// The spheres (n_shapes).
    pub spheres: &'a [Sphere],
    /// Indices of the pairs that touch (n_pairs).
    pub place: &'a mut [u32],
}

impl LaneLoop for Find<'_> {
    type Out = usize;

    #[inline(always)]
    fn run<V: Lanes4>(self) -> usize {
        let Find { pairs, spheres, place } = self;
        let (fours, rest) = pairs.as_chunks();
        let mut n = 0;
        for (k, pairs) in fours.iter().enumerate() {
            let (p, q) = (Spheres::<V>::of(spheres, pairs, 0), Spheres::of(spheres, pairs, 1));
            let (offset, reach) = (p.centre.minus(q.centre), p.reach + q.reach);
            let near = offset.dot(offset).mask_le(reach * reach);
            for l in 0..4 {
                place[n] = (4 * k + l) as u32;
                n += (near >> l & 1) as usize;
            }
        }
        for (k, [s, t]) in rest.iter().enumerate() {
            place[n] = (4 * fours.len() + k) as u32;
            n += spheres[*s as usize].is_near(&spheres[*t as usize]) as usize;
        }
        n
    }
}

/// Write the contacts of the pairs that touch.
pub struct Write<'a, 'b> {
    /// The pairs.
    pub pairs: &'a [[u32; 2]],
    /// Indices of the pairs that touch.
    pub places: &'a [u32],
    /// The spheres (n_shapes).
    pub spheres: &'a [Sphere],
    /// The rows to write.
    pub rows: &'a mut Rows<'b, [f64; 2]>,
}

impl LaneLoop for Write<'_, '_> {
    type Out = ();

    #[inline(always)]
    fn run<V: Lanes4>(self) {
        let Write { pairs, places, spheres, rows } = self;
        let (zero, one) = (V::splat(0.0), V::splat(1.0));
        let whole = places.len() - places.len() % 4;
        for k in (0..whole).step_by(4) {
            let pairs = four(places, k).map(|place| pairs[place as usize]);
            let (p, q) = (Spheres::<V>::of(spheres, &pairs, 0), Spheres::of(spheres, &pairs, 1));
            let offset = q.centre.minus(p.centre);
            let distance = offset.dot(offset).sqrt();
            let gap = distance - (p.radius + q.radius);
            let half = V::splat(0.5) * gap;
            let (reach_p, reach_q) = ((p.radius + half).to_array(), (q.radius + half).to_array());
            let mut out = [1.0; 4];
            for l in 0..4 {
                let [s, t] = pairs[l];
                let (p, q) = (&spheres[s as usize], &spheres[t as usize]);
                let is_swapped = p.body > q.body;
                rows.bodies[k + l] = if is_swapped { [q.body, p.body] } else { [p.body, q.body] };
                rows.arms[k + l] = if is_swapped { [reach_q[l], reach_p[l]] } else { [reach_p[l], reach_q[l]] };
                rows.key[k + l] = [s, t, 0];
                rows.law[k + l] = p.material * rows.n_materials + q.material;
                out[l] = if is_swapped { -1.0 } else { 1.0 };
            }
            let normal = Lane3 {
                x: distance.select_le(zero, zero, offset.x / distance),
                y: distance.select_le(zero, zero, offset.y / distance),
                z: distance.select_le(zero, one, offset.z / distance),
            };
            V::store3(normal.times(V::load(&out)), four_mut(rows.normal, k));
            *four_mut(rows.gap, k) = gap.to_array();
        }
        for (k, place) in places.iter().enumerate().skip(whole) {
            let pair = pairs[*place as usize];
            rows.put_spheres(k, pair, pair.map(|s| spheres[s as usize]), along);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SplitMix64;
    use crate::lanes::{Plain, widest};
    use glam::DVec3;

    type Columns = (Vec<[u32; 2]>, Vec<[u32; 3]>, Vec<DVec3>, Vec<f64>, Vec<u32>, Vec<[f64; 2]>);

    fn written(n: usize, write: impl FnOnce(&mut Rows<[f64; 2]>)) -> Columns {
        let mut c: Columns =
            (vec![[0; 2]; n], vec![[0; 3]; n], vec![DVec3::ZERO; n], vec![0.0; n], vec![0; n], vec![[0.0; 2]; n]);
        let (bodies, key, normal, gap, law, arms) = (&mut c.0, &mut c.1, &mut c.2, &mut c.3, &mut c.4, &mut c.5);
        write(&mut Rows { bodies, key, normal, gap, law, arms, n_materials: 3 });
        c
    }

    /// Four at a time, in registers and in arrays, have the same bits as one at a time; also for spheres with a common centre.
    #[test]
    fn four_pairs_are_four_single_ones() {
        let mut random = SplitMix64(6);
        let mut sphere = |body: u32| {
            let centre = DVec3::from_array(std::array::from_fn(|_| random.between(-0.2, 0.2)));
            let radius = random.between(0.05, 0.1);
            Sphere { centre, reach: radius + 0.01, radius, body: body * 7 % 31, material: body % 3 }
        };
        let mut spheres: Vec<Sphere> = (0..31).map(&mut sphere).collect();
        spheres[9].centre = spheres[4].centre;
        let pairs: Vec<[u32; 2]> = (0..31).flat_map(|t| (0..t).map(move |s| [s, t])).collect();
        let near = |[s, t]: &[u32; 2]| spheres[*s as usize].is_near(&spheres[*t as usize]);
        let touching: Vec<u32> = (0..pairs.len() as u32).filter(|k| near(&pairs[*k as usize])).collect();
        assert!(
            touching.len() > 40 && !touching.len().is_multiple_of(4) && touching.len() < pairs.len() / 2,
            "{}",
            touching.len()
        );

        let mut place = vec![0; pairs.len()];
        let n = widest(Find { pairs: &pairs, spheres: &spheres, place: &mut place });
        assert_eq!(place[..n], touching);
        let n = Find { pairs: &pairs, spheres: &spheres, place: &mut place }.run::<Plain<f64, 4>>();
        assert_eq!(place[..n], touching);

        let single = written(n, |rows| {
            for (i, place) in touching.iter().enumerate() {
                let pair = pairs[*place as usize];
                rows.put_spheres(i, pair, pair.map(|s| spheres[s as usize]), along);
            }
        });
        let (pairs, places, spheres) = (&pairs[..], &touching[..], &spheres[..]);
        let wide = written(n, |rows| widest(Write { pairs, places, spheres, rows }));
        assert_eq!(wide, single);
        let plain = written(n, |rows| Write { pairs, places, spheres, rows }.run::<Plain<f64, 4>>());
        assert_eq!(plain, single);
    }
}
