//! Gauss–Seidel on contacts with friction alone between balls, several at a time.
//!
//! A ball's contact arm lies along the normal, so that `D_iᵀ v = v_b − v_a − (r_a ω_a + r_b ω_b) × n`, and N_ii is diagonal in the
//! contact's frame: a for the normal, b for the tangents. The block's problem is then a projection in the metric (a, b, b): in
//! tangents stretched by √(b/a) it is the projection onto the cone of μ√(b/a). With Coulomb's law itself the normal has a problem
//! of its own, and the tangents are kept within the disc that its answer gives (Jourdan et al. 1998). All that a visit needs is laid out once a solve,
//! colour by colour, in groups of contacts that share no body; a visit streams through it. In single precision a group has
//! eight contacts and half the bytes, which is what a large bed's sweep is bound by.

use super::bodies::BodyOperator;
#[cfg(target_arch = "x86_64")]
use super::lanes::Wide;
use super::lanes::{Lane3, Lanes, Plain, Real, project};
use super::{Cells, Image, Twist};
use crate::FrictionLaw;
use crate::cpu::fill_rows;
use crate::state::Arms;
use glam::DVec3;
use rayon::prelude::*;

/// Contacts of one colour.
#[derive(Clone, Copy)]
struct Group<T, const L: usize> {
    bodies: [[u32; 2]; L],
    normal: [[T; L]; 3],
    gamma: [[T; L]; 3],
    /// The arms' lengths.
    reach: [[T; L]; 2],
    offset: [T; L],
    friction: [T; L],
}

/// The motion of a body, with its reciprocal mass and moment of inertia: what a visit takes of it, in one cache line.
#[derive(Clone, Copy, Default)]
#[repr(C, align(32))]
struct Motion<T> {
    /// v (3), the reciprocal mass, ω (3), the reciprocal moment of inertia.
    row: [T; 8],
}

impl<T: Real> Motion<T> {
    fn of(t: &Twist, inv_mass: f64, inv_inertia: f64) -> Motion<T> {
        Motion { row: [t.v.x, t.v.y, t.v.z, inv_mass, t.w.x, t.w.y, t.w.z, inv_inertia].map(T::of) }
    }

    fn twist(&self) -> Twist {
        let [vx, vy, vz, _, wx, wy, wz, _] = self.row.map(T::wide);
        Twist { v: DVec3::new(vx, vy, vz), w: DVec3::new(wx, wy, wz) }
    }
}

/// All contacts by colours, and the motions of the bodies.
pub struct Packed<T, const L: usize> {
    groups: Vec<Group<T, L>>,
    /// First group of each colour (n_colors + 1).
    start: Vec<usize>,
    motion: Vec<Motion<T>>,
}

impl<T, const L: usize> Default for Packed<T, L> {
    fn default() -> Self {
        Packed { groups: vec![], start: vec![], motion: vec![] }
    }
}

/// Groups that one task visits.
const TASK: usize = 128;

impl<T: Grouped<L>, const L: usize> Packed<T, L> {
    /// Lay out the contacts; `start` and `order` are the colours.
    pub fn fill(&mut self, op: &BodyOperator, start: &[u32], order: &[u32], gamma: &[DVec3], image: &Image) {
        self.start.clear();
        self.start.push(0);
        for ends in start.windows(2) {
            self.start.push(self.start[self.start.len() - 1] + ((ends[1] - ends[0]) as usize).div_ceil(L));
        }
        let n_groups = self.start[self.start.len() - 1];
        // What a colour's last group has no contact for is between the last motion, that of no body, and itself.
        let empty = Group {
            bodies: [[image.twist.len() as u32; 2]; L],
            normal: [[T::default(); L]; 3],
            gamma: [[T::default(); L]; 3],
            reach: [[T::default(); L]; 2],
            offset: [T::default(); L],
            friction: [T::default(); L],
        };
        self.groups.resize(n_groups, empty);
        let mut rest = &mut self.groups[..];
        for (color, ends) in start.windows(2).enumerate() {
            let (own, after) = std::mem::take(&mut rest).split_at_mut(self.start[color + 1] - self.start[color]);
            rest = after;
            let some = &order[ends[0] as usize..ends[1] as usize];
            fill_rows(own, |k| {
                let mut group = empty;
                let these = some[k * L..].iter().take(L).enumerate();
                these.for_each(|(l, i)| group.put(l, op, *i as usize, gamma[*i as usize]));
                group
            });
        }
        let masses = op.masses;
        self.motion.resize(image.twist.len() + 1, Motion::default());
        fill_rows(&mut self.motion[..image.twist.len()], |b| {
            Motion::of(&image.twist[b], masses.inv_mass[b], masses.round[b])
        });
    }

    /// Take the motions of the bodies.
    pub fn load(&mut self, image: &Image) {
        for (motion, twist) in self.motion.iter_mut().zip(&image.twist) {
            *motion = Motion::of(twist, motion.row[3].wide(), motion.row[7].wide());
        }
    }

    /// Give the motions of the bodies back.
    pub fn store(&self, image: &mut Image) {
        fill_rows(&mut image.twist, |b| self.motion[b].twist());
    }

    /// Visit all contacts once, colour by colour; returns the sum of `|Δγ/η|²`.
    pub fn sweep(&mut self, law: FrictionLaw, omega: f64) -> f64 {
        let motion = Cells::new(&mut self.motion);
        let mut rest = &mut self.groups[..];
        let mut missed = 0.0;
        for ends in self.start.windows(2) {
            let (color, after) = std::mem::take(&mut rest).split_at_mut(ends[1] - ends[0]);
            rest = after;
            missed += super::share(color.par_chunks_mut(TASK), |g| match law {
                FrictionLaw::Relaxed => visit::<T, L, false>(g, &motion, omega),
                FrictionLaw::Exact => visit::<T, L, true>(g, &motion, omega),
            });
        }
        missed
    }

    /// Read the impulses back.
    pub fn unpack(&self, start: &[u32], order: &[u32], gamma: &mut [DVec3]) {
        let gamma = Cells::new(gamma);
        for (color, ends) in start.windows(2).enumerate() {
            let groups = &self.groups[self.start[color]..];
            let pieces = order[ends[0] as usize..ends[1] as usize].par_chunks(TASK * L).zip(groups.par_chunks(TASK));
            pieces.with_min_len(4).for_each(|(contacts, groups)| {
                // Each contact is in the order once.
                contacts.iter().enumerate().for_each(|(k, i)| gamma.set(*i as usize, groups[k / L].gamma(k % L)));
            });
        }
    }
}

impl<T: Real, const L: usize> Group<T, L> {
    fn put(&mut self, l: usize, op: &BodyOperator, i: usize, gamma: DVec3) {
        let c = op.contacts;
        let [arm_a, arm_b] = match &c.arms {
            Arms::Along(reach) => reach[i],
            Arms::Any(_) => unreachable!("balls' arms lie along the normals"),
        };
        self.bodies[l] = c.bodies[i];
        for k in 0..3 {
            (self.normal[k][l], self.gamma[k][l]) = (T::of(c.normal[i][k]), T::of(gamma[k]));
        }
        (self.reach[0][l], self.reach[1][l]) = (T::of(arm_a), T::of(arm_b));
        self.offset[l] = T::of(op.offset(i));
        self.friction[l] = T::of(op.laws[c.law[i] as usize].friction);
    }

    fn gamma(&self, l: usize) -> DVec3 {
        DVec3::from_array(self.gamma.map(|x| x[l].wide()))
    }
}

/// Lanes of as many contacts as a group has.
pub trait Grouped<const L: usize>: Real {
    /// In registers.
    #[cfg(target_arch = "x86_64")]
    type Wide: Lanes<Self, L>;
    /// In arrays.
    type Plain: Lanes<Self, L>;
}

impl Grouped<8> for f32 {
    #[cfg(target_arch = "x86_64")]
    type Wide = Wide<std::arch::x86_64::__m256>;
    type Plain = Plain<f32, 8>;
}

impl Grouped<4> for f64 {
    #[cfg(target_arch = "x86_64")]
    type Wide = Wide<std::arch::x86_64::__m256d>;
    type Plain = Plain<f64, 4>;
}

/// Visit groups of one colour; returns the sum of `|Δγ/η|²`.
fn visit<T: Grouped<L>, const L: usize, const EXACT: bool>(
    groups: &mut [Group<T, L>],
    motion: &Cells<Motion<T>>,
    omega: f64,
) -> f64 {
    #[cfg(target_arch = "x86_64")]
    {
        #[target_feature(enable = "avx2")]
        unsafe fn wide<T: Grouped<L>, const L: usize, const EXACT: bool>(
            groups: &mut [Group<T, L>],
            motion: &Cells<Motion<T>>,
            omega: f64,
        ) -> f64 {
            visit_lanes::<T, L, EXACT, T::Wide>(groups, motion, omega)
        }
        if std::arch::is_x86_feature_detected!("avx2") {
            // SAFETY: the processor has AVX2.
            return unsafe { wide::<T, L, EXACT>(groups, motion, omega) };
        }
    }
    visit_lanes::<T, L, EXACT, T::Plain>(groups, motion, omega)
}

#[inline(always)]
fn visit_lanes<T: Real, const L: usize, const EXACT: bool, V: Lanes<T, L>>(
    groups: &mut [Group<T, L>],
    motion: &Cells<Motion<T>>,
    omega: f64,
) -> f64 {
    let mut missed = [0.0; L];
    let (zero, one, third, omega) =
        (V::splat(T::of(0.0)), V::splat(T::of(1.0)), V::splat(T::of(1.0 / 3.0)), V::splat(T::of(omega)));
    for g in groups {
        let (mut rows_a, mut rows_b) = ([[T::default(); 8]; L], [[T::default(); 8]; L]);
        for l in 0..L {
            let [a, b] = g.bodies[l];
            (rows_a[l], rows_b[l]) = (motion.get(a as usize).row, motion.get(b as usize).row);
        }
        let [vax, vay, vaz, mass_a, wax, way, waz, turn_a] = V::columns(&rows_a);
        let [vbx, vby, vbz, mass_b, wbx, wby, wbz, turn_b] = V::columns(&rows_b);
        let (va, vb) = (Lane3 { x: vax, y: vay, z: vaz }, Lane3 { x: vbx, y: vby, z: vbz });
        let (wa, wb) = (Lane3 { x: wax, y: way, z: waz }, Lane3 { x: wbx, y: wby, z: wbz });
        let n = Lane3 { x: V::load(&g.normal[0]), y: V::load(&g.normal[1]), z: V::load(&g.normal[2]) };
        let gamma = Lane3 { x: V::load(&g.gamma[0]), y: V::load(&g.gamma[1]), z: V::load(&g.gamma[2]) };
        let (reach_a, reach_b) = (V::load(&g.reach[0]), V::load(&g.reach[1]));
        let (lever_a, lever_b) = (reach_a * turn_a, reach_b * turn_b);
        // N_ii = diag(a, b, b); both are 0 in a lane without a contact.
        let a = mass_a + mass_b;
        let b = a + reach_a * lever_a + reach_b * lever_b;
        let along = a.up_to(zero, zero, one / a);
        let across = a.up_to(zero, zero, one / b);
        let rolling = wa.times(reach_a).plus(wb.times(reach_b)).cross(n);
        let v = vb.minus(va).minus(rolling);
        let v_n = v.dot(n);
        let before_n = gamma.dot(n);
        let normal = before_n - (v_n + V::load(&g.offset)) * along;
        let tangent = gamma.minus(n.times(before_n)).minus(v.minus(n.times(v_n)).times(across));
        let friction = V::load(&g.friction);
        let z = if EXACT {
            // Coulomb's law itself parts into the two directions.
            let (kept, length) = (zero.up_to(normal, normal, zero), tangent.dot(tangent).sqrt());
            let limit = friction * kept;
            n.times(kept).plus(tangent.times(length.up_to(limit, one, limit / length)))
        } else {
            let (stretch, shrink) = ((b * along).sqrt(), (a * across).sqrt());
            let z = project(n.times(normal).plus(tangent.times(stretch)), n, friction * stretch);
            let z_n = n.times(z.dot(n));
            z_n.plus(z.minus(z_n).times(shrink))
        };
        let d = z.minus(gamma).times(omega);
        let gamma = gamma.plus(d);
        g.gamma = [gamma.x.to_array(), gamma.y.to_array(), gamma.z.to_array()];
        let spin = n.cross(d);
        let (va, vb) = (va.minus(d.times(mass_a)), vb.plus(d.times(mass_b)));
        let (wa, wb) = (wa.minus(spin.times(lever_a)), wb.minus(spin.times(lever_b)));
        let rows_a = V::rows([va.x, va.y, va.z, mass_a, wa.x, wa.y, wa.z, turn_a]);
        let rows_b = V::rows([vb.x, vb.y, vb.z, mass_b, wb.x, wb.y, wb.z, turn_b]);
        for l in 0..L {
            let [a, b] = g.bodies[l];
            // What is held in place may be in several contacts at once: it is never written.
            if rows_a[l][3] > T::default() {
                motion.set(a as usize, Motion { row: rows_a[l] });
            }
            if rows_b[l][3] > T::default() {
                motion.set(b as usize, Motion { row: rows_b[l] });
            }
        }
        // 1/η is a third of the trace of N_ii.
        let trace = (a + b + b) * third;
        let squares = (d.dot(d) * trace * trace).to_array();
        for l in 0..L {
            missed[l] += squares[l].wide();
        }
    }
    missed.iter().sum()
}
