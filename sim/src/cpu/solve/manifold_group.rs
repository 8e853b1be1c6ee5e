//! Groups of manifolds: the contacts of a pair of bodies of any shapes, visited one after the other while the bodies' velocities are in
//! registers.
//!
//! With N_ii n = a n + k, k along the tangents, and b the largest eigenvalue of the tangents' part of N_ii, a visit is: Coulomb's law
//! itself: the normal's own problem, with a (or, where friction that lifts makes the normal response of what slides greater, up to
//! a + μ |k|, with two thirds of that: less would swing); then the tangents, which see k times the normal's change, make a step of 1/b and
//! are projected onto the disc that the normal's solution gives. The relaxed law: a step in the metric (a, b, b) times 1 + |k|/√(ab), which
//! is an upper bound of N_ii, and in that metric the projection onto the cone, as for spheres (`sphere_group`).

use super::cells::Cells;
use super::group::{self, Group, Grouped, Motion, Source, act, gather, projected, scatter};
use super::resistance::Resistance;
use super::schedule::Blocks;
use crate::lanes::{Lane3, Lanes, Real, cone};
use glam::DMat3;

/// A group of manifolds of one colour, in lanes; R is 1 where contacts roll with friction or stick, else 0.
#[derive(Clone, Copy)]
pub struct ManifoldGroup<T, const L: usize, const R: usize> {
    bodies: [[u32; 2]; L],
    /// Whether all bodies move.
    moves: bool,
    /// Whether the law of friction is the exact one.
    is_exact: bool,
    /// The most contacts of a manifold of the group.
    n_contacts: u32,
    /// Inverse inertia tensors of A and B: xx, yy, zz, yz, xz, xy.
    inv_inertia: [[[T; L]; 6]; 2],
    contacts: [Contact<T, L, R>; Blocks::MOST],
}

/// The contacts of one number in a group's manifolds; zero in a lane whose manifold has fewer.
#[derive(Clone, Copy)]
struct Contact<T, const L: usize, const R: usize> {
    normal: [[T; L]; 3],
    /// Arms on A and B, m.
    arms: [[[T; L]; 3]; 2],
    gamma: [[T; L]; 3],
    /// The tangential part k of N n, 1/kg, where the law of friction is the exact one.
    coupling: [[T; L]; 3],
    offset: [T; L],
    friction: [T; L],
    /// Step lengths along the normal and the tangents, kg.
    along: [T; L],
    across: [T; L],
    /// √(b/a).
    stretch: [T; L],
    /// 1/η, 1/kg.
    inv_eta: [T; L],
    resistance: [Resistance<T, L>; R],
}

impl<T: Real, const L: usize, const R: usize> Contact<T, L, R> {
    fn empty() -> Self {
        let (zero, one) = ([T::default(); L], [T::of(1.0); L]);
        Contact {
            normal: [zero; 3],
            arms: [[zero; 3]; 2],
            gamma: [zero; 3],
            coupling: [zero; 3],
            offset: zero,
            friction: zero,
            along: one,
            across: one,
            stretch: one,
            inv_eta: zero,
            resistance: [Resistance::empty(); R],
        }
    }

    /// Project the impulses onto their cones, and evaluate what a visit needs of N_ii, for the sum of the reciprocal masses and the inverse
    /// inertia tensors of the bodies.
    #[inline(always)]
    fn prepare<V: Lanes<T, L>>(&mut self, is_exact: bool, mass: V, inv_inertia: &[[[T; L]; 6]; 2]) {
        let (zero, one) = (V::splat(T::of(0.0)), V::splat(T::of(1.0)));
        let n: Lane3<V> = load3(&self.normal);
        let tip = self.resistance.first().map_or(zero, |r| r.tip());
        let gamma: Lane3<V> = projected(load3(&self.gamma), n, V::load(&self.friction), tip);
        self.gamma = [gamma.x.to_array(), gamma.y.to_array(), gamma.z.to_array()];
        let (u, w) = tangents(n);
        let arms: [Lane3<V>; 2] = [load3(&self.arms[0]), load3(&self.arms[1])];
        let of_n = respond(n, arms, mass, inv_inertia);
        let (of_u, of_w) = (respond(u, arms, mass, inv_inertia), respond(w, arms, mass, inv_inertia));
        let half = V::splat(T::of(0.5));
        let (uu, ww, uw) = (of_u.dot(u), of_w.dot(w), of_u.dot(w));
        let spread = (uu - ww) * half;
        // Lanes without a contact have no response.
        let a = of_n.dot(n);
        let a = a.select_le(zero, one, a);
        let b = (uu + ww) * half + (spread * spread + uw * uw).sqrt();
        let b = b.select_le(zero, one, b);
        let coupling = of_n.minus(n.times(a));
        let coupled = coupling.dot(coupling);
        let bound = if is_exact { one } else { one + (coupled / (a * b)).sqrt() };
        let lifted = (a + V::load(&self.friction) * coupled.sqrt()) * V::splat(T::of(2.0 / 3.0));
        let of_normal = if is_exact { lifted.select_le(a, a, lifted) } else { a };
        if is_exact {
            self.coupling = [coupling.x.to_array(), coupling.y.to_array(), coupling.z.to_array()];
        }
        self.along = (one / (bound * of_normal)).to_array();
        self.across = (one / (bound * b)).to_array();
        self.stretch = (b / a).sqrt().to_array();
        self.inv_eta = ((a + uu + ww) * V::splat(T::of(1.0 / 3.0))).to_array();
        if let Some(resistance) = self.resistance.first_mut() {
            resistance.prepare(turned_most::<T, L, V>(inv_inertia));
        }
    }

    /// The change of the impulses of a visit; what it adds to the sum of the squared residual terms and to the greatest speed of closing.
    #[inline(always)]
    fn solve<const ACT: u8, V: Lanes<T, L>>(
        &mut self,
        v: Lane3<V>,
        n: Lane3<V>,
        omega: V,
        (residual2, closing): (&mut V, &mut V),
    ) -> Lane3<V> {
        let (zero, one) = (V::splat(T::of(0.0)), V::splat(T::of(1.0)));
        let gamma = load3(&self.gamma);
        let (along, across, friction) = (V::load(&self.along), V::load(&self.across), V::load(&self.friction));
        let v_n = v.dot(n);
        let before_n = gamma.dot(n);
        let opening = v_n + V::load(&self.offset);
        *closing = group::faster(*closing, opening);
        let tip = self.resistance.first().map_or(zero, |r| r.tip());
        let normal = before_n + tip - opening * along;
        let (kept, tangent, share) = if ACT == act::EXACT {
            let kept = zero.select_le(normal, normal, zero);
            let v_t = v.minus(n.times(v_n)).plus(load3::<T, L, V>(&self.coupling).times(kept - tip - before_n));
            let tangent = gamma.minus(n.times(before_n)).minus(v_t.times(across));
            let (limit, length) = (friction * kept, tangent.dot(tangent).sqrt());
            (kept, tangent, length.select_le(limit, one, limit / length))
        } else {
            let tangent = gamma.minus(n.times(before_n)).minus(v.minus(n.times(v_n)).times(across));
            let stretch = V::load(&self.stretch);
            let (kept, share) = cone(normal, tangent.dot(tangent).sqrt() * stretch, friction * stretch);
            (kept, tangent, share)
        };
        let z = n.times(kept - tip).plus(tangent.times(share));
        let d = z.minus(gamma).times(omega);
        let gamma = gamma.plus(d);
        self.gamma = [gamma.x.to_array(), gamma.y.to_array(), gamma.z.to_array()];
        let inv_eta = V::load(&self.inv_eta);
        *residual2 = *residual2 + d.dot(d) * inv_eta * inv_eta;
        d
    }
}

impl<T: Grouped<L>, const L: usize, const R: usize> Group<T, L> for ManifoldGroup<T, L, R> {
    const CHUNK: usize = 64 / L;
    const ROLLS: bool = R > 0;
    /// The normal, the impulse, the offset and the friction; the arms.
    type Row = [[T; 8]; 2];
    /// The inverse inertia tensor: xx, yy, zz, yz, xz, xy.
    type Body = [T; 8];

    fn empty() -> Self {
        ManifoldGroup {
            bodies: [[0; 2]; L],
            moves: false,
            is_exact: false,
            n_contacts: 0,
            inv_inertia: [[[T::default(); L]; 6]; 2],
            contacts: [Contact::empty(); Blocks::MOST],
        }
    }

    #[inline(always)]
    fn row(Source { op, gamma, .. }: &Source, i: usize) -> [[T; 8]; 2] {
        let c = op.contacts;
        let (n, g, [a, b]) = (c.normal[i], gamma[i], c.arms(i));
        [
            [n.x, n.y, n.z, g.x, g.y, g.z, op.offset(i), op.law(i).friction].map(T::of),
            [a.x, a.y, a.z, b.x, b.y, b.z, 0.0, 0.0].map(T::of),
        ]
    }

    #[inline(always)]
    fn body(from: &Source, body: usize) -> [T; 8] {
        let DMat3 { x_axis: x, y_axis: y, z_axis: z } = from.op.masses.inv_inertia(body);
        [x.x, y.y, z.z, y.z, x.z, x.y, 0.0, 0.0].map(T::of)
    }

    #[inline(always)]
    fn fill<V: Lanes<T, L>>(&mut self, from: &Source, (rows, of_bodies): (&[Self::Row], &[[T; 8]]), own: &[u32]) {
        let Source { op, blocks, gamma, is_exact, .. } = from;
        let zero = T::default();
        // Rows of the contacts and of the bodies, lane by lane; the columns are these transposed.
        let (mut row, mut arms) = ([[[zero; 8]; L]; Blocks::MOST], [[[zero; 8]; L]; Blocks::MOST]);
        let mut inv_inertia = [[[zero; 8]; L]; 2];
        (self.is_exact, self.n_contacts, self.moves) = (*is_exact, 0, own.len() == L);
        self.bodies = [[from.nowhere(); 2]; L];
        if R > 0 {
            self.contacts.iter_mut().for_each(|contact| contact.resistance = [Resistance::empty(); R]);
        }
        for (l, block) in own.iter().enumerate() {
            let contacts = blocks.contacts(*block);
            self.n_contacts = self.n_contacts.max(contacts.len() as u32);
            let bodies = op.contacts.bodies[contacts.start];
            let (places, move_both) = from.places(bodies);
            self.bodies[l] = places;
            self.moves &= move_both;
            for side in 0..2 {
                inv_inertia[side][l] = of_bodies[places[side] as usize];
            }
            for (k, i) in contacts.enumerate() {
                if let Some(resistance) = self.contacts[k].resistance.first_mut() {
                    resistance.put(l, op, i, gamma);
                }
                [row[k][l], arms[k][l]] = rows[i];
            }
        }
        for side in 0..2 {
            let [xx, yy, zz, yz, xz, xy, ..] = V::columns(&inv_inertia[side]);
            group::store(&mut self.inv_inertia[side], [xx, yy, zz, yz, xz, xy]);
        }
        for k in 0..self.n_contacts as usize {
            let contact = &mut self.contacts[k];
            let [nx, ny, nz, gx, gy, gz, offset, friction] = V::columns(&row[k]);
            group::store(&mut contact.normal, [nx, ny, nz]);
            group::store(&mut contact.gamma, [gx, gy, gz]);
            (contact.offset, contact.friction) = (offset.to_array(), friction.to_array());
            let [ax, ay, az, bx, by, bz, ..] = V::columns(&arms[k]);
            group::store(&mut contact.arms[0], [ax, ay, az]);
            group::store(&mut contact.arms[1], [bx, by, bz]);
        }
    }

    fn bodies(&self) -> &[[u32; 2]; L] {
        &self.bodies
    }

    #[inline(always)]
    fn impulses<V: Lanes<T, L>>(&self, out: &mut [[[T; 8]; L]; Blocks::MOST]) {
        for (contact, out) in self.contacts[..self.n_contacts as usize].iter().zip(out) {
            let roll = contact.resistance.first().map(|r| &r.impulse);
            *out = group::impulse_rows::<T, L, V>(&contact.gamma, roll);
        }
    }

    #[inline(always)]
    unsafe fn visit<const ACT: u8, V: Lanes<T, L>>(
        groups: &mut [Self],
        motion: &Cells<Motion<T>>,
        omega: f64,
    ) -> [f64; 2] {
        let (zero, omega) = (V::splat(T::of(0.0)), V::splat(T::of(omega)));
        let (mut residual2, mut closing) = (zero, zero);
        for g in groups {
            // SAFETY: the caller's promise, here and below.
            let [a, b] = unsafe { gather::<T, L, V>(motion, &g.bodies) };
            let [vax, vay, vaz, mass_a, wax, way, waz, turn_a] = a;
            let [vbx, vby, vbz, mass_b, wbx, wby, wbz, turn_b] = b;
            let (mut va, mut vb) = (Lane3 { x: vax, y: vay, z: vaz }, Lane3 { x: vbx, y: vby, z: vbz });
            // The velocity of B relative to A, and the sum of what its contacts have changed by.
            let mass = mass_a + mass_b;
            let (mut wa, mut wb) = (Lane3 { x: wax, y: way, z: waz }, Lane3 { x: wbx, y: wby, z: wbz });
            for contact in &mut g.contacts[..g.n_contacts as usize] {
                let n: Lane3<V> = load3(&contact.normal);
                let (arm_a, arm_b): (Lane3<V>, Lane3<V>) = (load3(&contact.arms[0]), load3(&contact.arms[1]));
                let d = if ACT == act::APPLY {
                    contact.prepare::<V>(g.is_exact, mass, &g.inv_inertia);
                    load3(&contact.gamma)
                } else {
                    let v = vb.plus(wb.cross(arm_b)).minus(va).minus(wa.cross(arm_a));
                    contact.solve::<ACT, V>(v, n, omega, (&mut residual2, &mut closing))
                };
                va = va.minus(d.times(mass_a));
                vb = vb.plus(d.times(mass_b));
                wa = wa.minus(turned(&g.inv_inertia[0], arm_a.cross(d)));
                wb = wb.plus(turned(&g.inv_inertia[1], arm_b.cross(d)));
                let (gamma, inv_eta) = (load3(&contact.gamma), V::load(&contact.inv_eta));
                if let Some(resistance) = contact.resistance.first_mut() {
                    let d = if ACT == act::APPLY {
                        resistance.roll()
                    } else {
                        let (d, term) = resistance.visit(wb.minus(wa), (n, gamma), (omega, inv_eta));
                        residual2 = residual2 + term;
                        d
                    };
                    wa = wa.minus(turned(&g.inv_inertia[0], d));
                    wb = wb.plus(turned(&g.inv_inertia[1], d));
                }
            }
            let a = [va.x, va.y, va.z, mass_a, wa.x, wa.y, wa.z, turn_a];
            let b = [vb.x, vb.y, vb.z, mass_b, wb.x, wb.y, wb.z, turn_b];
            unsafe { scatter(motion, &g.bodies, g.moves, [a, b]) };
        }
        [group::sum(residual2), group::max(closing)]
    }
}

#[inline(always)]
fn load3<T: Real, const L: usize, V: Lanes<T, L>>(v: &[[T; L]; 3]) -> Lane3<V> {
    Lane3 { x: V::load(&v[0]), y: V::load(&v[1]), z: V::load(&v[2]) }
}

/// The products N_ii d of contacts with these arms: the change of their relative velocity by the impulses d.
#[inline(always)]
fn respond<T: Real, const L: usize, V: Lanes<T, L>>(
    d: Lane3<V>,
    arms: [Lane3<V>; 2],
    mass: V,
    inv_inertia: &[[[T; L]; 6]; 2],
) -> Lane3<V> {
    let turn_a = turned(&inv_inertia[0], arms[0].cross(d)).cross(arms[0]);
    d.times(mass).plus(turn_a).plus(turned(&inv_inertia[1], arms[1].cross(d)).cross(arms[1]))
}

/// Product of inverse inertia tensors and vectors.
#[inline(always)]
fn turned<T: Real, const L: usize, V: Lanes<T, L>>(inv_inertia: &[[T; L]; 6], v: Lane3<V>) -> Lane3<V> {
    let [xx, yy, zz, yz, xz, xy] = inv_inertia;
    let (xx, yy, zz) = (V::load(xx), V::load(yy), V::load(zz));
    let (yz, xz, xy) = (V::load(yz), V::load(xz), V::load(xy));
    Lane3 { x: xx * v.x + xy * v.y + xz * v.z, y: xy * v.x + yy * v.y + yz * v.z, z: xz * v.x + yz * v.y + zz * v.z }
}

/// A bound of the response to an angular impulse between two bodies with these inverse inertia tensors: the largest sum of the absolute
/// values of a row.
#[inline(always)]
fn turned_most<T: Real, const L: usize, V: Lanes<T, L>>(inv_inertia: &[[[T; L]; 6]; 2]) -> V {
    let zero = V::splat(T::of(0.0));
    let [xx, yy, zz, yz, xz, xy] = std::array::from_fn(|k| {
        let sum = V::load(&inv_inertia[0][k]) + V::load(&inv_inertia[1][k]);
        zero.select_le(sum, sum, zero - sum)
    });
    let greater = |a: V, b: V| a.select_le(b, b, a);
    greater(greater(xx + xy + xz, xy + yy + yz), xz + yz + zz)
}

/// Tangents of unit normals (as [`crate::contacts::tangents`]).
#[inline(always)]
fn tangents<T: Real, const L: usize, V: Lanes<T, L>>(n: Lane3<V>) -> (Lane3<V>, Lane3<V>) {
    let (zero, one) = (V::splat(T::of(0.0)), V::splat(T::of(1.0)));
    let sign = zero.select_le(n.z, one, zero - one);
    let a = (zero - one) / (sign + n.z);
    let b = n.x * n.y * a;
    let u = Lane3 { x: one + sign * n.x * n.x * a, y: sign * b, z: zero - sign * n.x };
    (u, Lane3 { x: b, y: sign + n.y * n.y * a, z: zero - n.y })
}
