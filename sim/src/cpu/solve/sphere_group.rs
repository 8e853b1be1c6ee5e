//! Groups of contacts between spheres.
//!
//! A sphere's contact arm lies along the normal, so that `D_iᵀ v = v_b − v_a − (r_a ω_a + r_b ω_b) × n`, and N_ii is diagonal in the
//! contact's frame: a for the normal, b for the tangents. The block's problem is then a projection in the metric (a, b, b): in
//! tangents stretched by √(b/a) it is the projection onto the cone of μ√(b/a). With Coulomb's law itself the normal has a problem
//! of its own, and the tangents are projected onto the disc that its solution gives (Jourdan et al. 1998): no outer loop is needed.
//! The response of a rolling block is a scalar, so that its problem is a projection too (`resistance`).

use super::cells::Cells;
use super::group::{self, Group, Grouped, Motion, Source, act, gather, projected, scatter};
use super::resistance::Resistance;
use super::schedule::Blocks;
use crate::contacts::Arms;
use crate::lanes::{Lane3, Lanes, cone};

/// A group of contacts of one colour, in lanes; R is 1 where contacts roll with friction or stick, else 0.
#[derive(Clone, Copy)]
pub struct SphereGroup<T, const L: usize, const R: usize> {
    bodies: [[u32; 2]; L],
    /// Whether all bodies move.
    moves: bool,
    normal: [[T; L]; 3],
    gamma: [[T; L]; 3],
    /// Lengths of the arms, m.
    reach: [[T; L]; 2],
    offset: [T; L],
    friction: [T; L],
    resistance: [Resistance<T, L>; R],
}

impl<T: Grouped<L>, const L: usize, const R: usize> Group<T, L> for SphereGroup<T, L, R> {
    const CHUNK: usize = 256 / L;
    const ROLLS: bool = R > 0;
    // The columns of the contacts are as near, and no body has a tensor.
    type Row = ();
    type Body = ();

    fn empty() -> Self {
        SphereGroup {
            bodies: [[0; 2]; L],
            moves: false,
            normal: [[T::default(); L]; 3],
            gamma: [[T::default(); L]; 3],
            reach: [[T::default(); L]; 2],
            offset: [T::default(); L],
            friction: [T::default(); L],
            resistance: [Resistance::empty(); R],
        }
    }

    #[inline(always)]
    fn row(_: &Source, _: usize) {}

    #[inline(always)]
    fn body(_: &Source, _: usize) {}

    #[inline(always)]
    fn fill<V: Lanes<T, L>>(&mut self, from: &Source, _: (&[()], &[()]), own: &[u32]) {
        if own.len() < L {
            *self = Self::empty();
        }
        let Source { op, blocks, gamma, .. } = from;
        let c = op.contacts;
        let Arms::Along(reach) = &c.arms else { unreachable!("spheres' arms lie along the normals") };
        // Rows of the contacts, lane by lane; the columns are these transposed.
        let mut row = [[T::default(); 8]; L];
        self.bodies = [[from.nowhere(); 2]; L];
        self.moves = own.len() == L;
        for (l, block) in own.iter().enumerate() {
            let i = blocks.contacts(*block).start;
            if let Some(resistance) = self.resistance.first_mut() {
                resistance.put(l, op, i, gamma);
            }
            let (places, move_both) = from.places(c.bodies[i]);
            self.bodies[l] = places;
            self.moves &= move_both;
            let (n, g, [reach_a, reach_b]) = (c.normal[i], gamma[i], reach[i]);
            row[l] = [n.x, n.y, n.z, g.x, g.y, g.z, reach_a, reach_b].map(T::of);
            (self.offset[l], self.friction[l]) = (T::of(op.offset(i)), T::of(op.law(i).friction));
        }
        let [nx, ny, nz, gx, gy, gz, reach_a, reach_b] = V::columns(&row);
        group::store(&mut self.normal, [nx, ny, nz]);
        group::store(&mut self.gamma, [gx, gy, gz]);
        group::store(&mut self.reach, [reach_a, reach_b]);
    }

    fn bodies(&self) -> &[[u32; 2]; L] {
        &self.bodies
    }

    #[inline(always)]
    fn impulses<V: Lanes<T, L>>(&self, out: &mut [[[T; 8]; L]; Blocks::MOST]) {
        out[0] = group::impulse_rows::<T, L, V>(&self.gamma, self.resistance.first().map(|r| &r.impulse));
    }

    #[inline(always)]
    unsafe fn visit<const ACT: u8, V: Lanes<T, L>>(
        groups: &mut [Self],
        motion: &Cells<Motion<T>>,
        omega: f64,
    ) -> [f64; 2] {
        let (zero, one, third, omega) =
            (V::splat(T::of(0.0)), V::splat(T::of(1.0)), V::splat(T::of(1.0 / 3.0)), V::splat(T::of(omega)));
        let (mut residual2, mut closing) = (zero, zero);
        for g in groups {
            // SAFETY: the caller's promise, here and below.
            let [a, b] = unsafe { gather::<T, L, V>(motion, &g.bodies) };
            let [vax, vay, vaz, mass_a, wax, way, waz, turn_a] = a;
            let [vbx, vby, vbz, mass_b, wbx, wby, wbz, turn_b] = b;
            let (va, vb) = (Lane3 { x: vax, y: vay, z: vaz }, Lane3 { x: vbx, y: vby, z: vbz });
            let (wa, wb) = (Lane3 { x: wax, y: way, z: waz }, Lane3 { x: wbx, y: wby, z: wbz });
            let n = Lane3 { x: V::load(&g.normal[0]), y: V::load(&g.normal[1]), z: V::load(&g.normal[2]) };
            let gamma = Lane3 { x: V::load(&g.gamma[0]), y: V::load(&g.gamma[1]), z: V::load(&g.gamma[2]) };
            let (reach_a, reach_b) = (V::load(&g.reach[0]), V::load(&g.reach[1]));
            let (lever_a, lever_b) = (reach_a * turn_a, reach_b * turn_b);
            // N_ii = diag(a, b, b); both are 0 in a lane without a contact.
            let a = mass_a + mass_b;
            let b = a + reach_a * lever_a + reach_b * lever_b;
            let along = a.select_le(zero, zero, one / a);
            let across = a.select_le(zero, zero, one / b);
            let tip = g.resistance.first().map_or(zero, |r| r.tip());
            // 1/η is a third of the trace of N_ii.
            let trace = (a + b + b) * third;
            let d = if ACT == act::APPLY {
                let gamma = projected(gamma, n, V::load(&g.friction), tip);
                g.gamma = [gamma.x.to_array(), gamma.y.to_array(), gamma.z.to_array()];
                gamma
            } else {
                let rolling = wa.times(reach_a).plus(wb.times(reach_b)).cross(n);
                let v = vb.minus(va).minus(rolling);
                let v_n = v.dot(n);
                let before_n = gamma.dot(n);
                let opening = v_n + V::load(&g.offset);
                closing = group::faster(closing, opening);
                let normal = before_n + tip - opening * along;
                let tangent = gamma.minus(v.times(across)).minus(n.times(before_n - v_n * across));
                let length = tangent.dot(tangent).sqrt();
                let friction = V::load(&g.friction);
                let (kept, share) = if ACT == act::EXACT {
                    // Coulomb's law itself splits into the two directions.
                    let kept = zero.select_le(normal, normal, zero);
                    let limit = friction * kept;
                    (kept, length.select_le(limit, one, limit / length))
                } else {
                    let stretch = (b * along).sqrt();
                    cone(normal, length * stretch, friction * stretch)
                };
                let z = n.times(kept - tip).plus(tangent.times(share));
                let d = z.minus(gamma).times(omega);
                let gamma = gamma.plus(d);
                g.gamma = [gamma.x.to_array(), gamma.y.to_array(), gamma.z.to_array()];
                residual2 = residual2 + d.dot(d) * trace * trace;
                d
            };
            let spin = n.cross(d);
            let (va, vb) = (va.minus(d.times(mass_a)), vb.plus(d.times(mass_b)));
            let (mut wa, mut wb) = (wa.minus(spin.times(lever_a)), wb.minus(spin.times(lever_b)));
            if let Some(resistance) = g.resistance.first_mut() {
                let d = if ACT == act::APPLY {
                    resistance.prepare(turn_a + turn_b);
                    resistance.roll()
                } else {
                    let gamma = Lane3 { x: V::load(&g.gamma[0]), y: V::load(&g.gamma[1]), z: V::load(&g.gamma[2]) };
                    let (d, term) = resistance.visit(wb.minus(wa), (n, gamma), (omega, trace));
                    residual2 = residual2 + term;
                    d
                };
                (wa, wb) = (wa.minus(d.times(turn_a)), wb.plus(d.times(turn_b)));
            }
            let a = [va.x, va.y, va.z, mass_a, wa.x, wa.y, wa.z, turn_a];
            let b = [vb.x, vb.y, vb.z, mass_b, wb.x, wb.y, wb.z, turn_b];
            unsafe { scatter(motion, &g.bodies, g.moves, [a, b]) };
        }
        [group::sum(residual2), group::max(closing)]
    }
}
