//! Gauss–Seidel on contacts with friction alone between balls, several at a time.
//!
//! A ball's contact arm lies along the normal, so that `D_iᵀ v = v_b − v_a − (r_a ω_a + r_b ω_b) × n`, and N_ii is diagonal in the
//! contact's frame: a for the normal, b for the tangents. The block's problem is then a projection in the metric (a, b, b): in
//! tangents stretched by √(b/a) it is the projection onto the cone of μ√(b/a). All that a visit needs is laid out once a solve,
//! colour by colour, in groups of contacts that share no body; a visit streams through it. In single precision a group has
//! eight contacts and half the bytes, which is what a large bed's sweep is bound by.

use super::bodies::BodyOperator;
use super::lanes::{Lane, Lane3, Real, each, project};
use super::{Cells, Image, Twist};
use crate::cpu::fill_rows;
use glam::DVec3;
use rayon::prelude::*;

/// Contacts of one colour.
#[derive(Clone, Copy)]
struct Group<T, const L: usize> {
    bodies: [[u32; 2]; L],
    normal: Lane3<T, L>,
    gamma: Lane3<T, L>,
    radius: [Lane<T, L>; 2],
    inv_mass: [Lane<T, L>; 2],
    /// Radius times reciprocal moment of inertia.
    lever: [Lane<T, L>; 2],
    offset: Lane<T, L>,
    /// 1/a and 1/b.
    along: Lane<T, L>,
    across: Lane<T, L>,
    stretch: Lane<T, L>,
    /// μ times the stretch.
    friction: Lane<T, L>,
}

/// The motion of a body.
#[derive(Clone, Copy, Default)]
#[repr(align(32))]
struct Motion<T> {
    v: [T; 3],
    w: [T; 3],
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

impl<T: Real, const L: usize> Packed<T, L> {
    /// Lay out the contacts; `start` and `order` are the colours.
    pub fn fill(&mut self, op: &BodyOperator, start: &[u32], order: &[u32], gamma: &[DVec3], image: &Image) {
        self.start.clear();
        self.start.push(0);
        for ends in start.windows(2) {
            self.start.push(self.start[self.start.len() - 1] + ((ends[1] - ends[0]) as usize).div_ceil(L));
        }
        let n_groups = self.start[self.start.len() - 1];
        // What a colour's last group has no contact for does nothing.
        let empty = Group {
            bodies: [[0; 2]; L],
            normal: Lane3::default(),
            gamma: Lane3::default(),
            radius: [[T::default(); L]; 2],
            inv_mass: [[T::default(); L]; 2],
            lever: [[T::default(); L]; 2],
            offset: [T::default(); L],
            along: [T::of(1.0); L],
            across: [T::of(1.0); L],
            stretch: [T::of(1.0); L],
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
        self.load(image);
    }

    /// Take the motions of the bodies.
    pub fn load(&mut self, image: &Image) {
        self.motion.resize(image.twist.len(), Motion::default());
        fill_rows(&mut self.motion, |b| {
            let Twist { v, w } = image.twist[b];
            Motion { v: v.to_array().map(T::of), w: w.to_array().map(T::of) }
        });
    }

    /// Give the motions of the bodies back.
    pub fn store(&self, image: &mut Image) {
        let wide = |v: [T; 3]| DVec3::from_array(v.map(T::wide));
        fill_rows(&mut image.twist, |b| Twist { v: wide(self.motion[b].v), w: wide(self.motion[b].w) });
    }

    /// Visit all contacts once, colour by colour; returns the sum of `|Δγ/η|²`.
    pub fn sweep(&mut self, omega: f64) -> f64 {
        let motion = Cells::new(&mut self.motion);
        let mut rest = &mut self.groups[..];
        let mut missed = 0.0;
        for ends in self.start.windows(2) {
            let (color, after) = std::mem::take(&mut rest).split_at_mut(ends[1] - ends[0]);
            rest = after;
            missed += super::share(color.par_chunks_mut(TASK), |g| visit(g, &motion, omega));
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
                contacts.iter().enumerate().for_each(|(k, i)| gamma.set(*i as usize, groups[k / L].gamma.get(k % L)));
            });
        }
    }
}

impl<T: Real, const L: usize> Group<T, L> {
    fn put(&mut self, l: usize, op: &BodyOperator, i: usize, gamma: DVec3) {
        let (c, masses) = (op.contacts, op.masses);
        let n = c.normal[i];
        let reach = [c.arm_a[i].dot(n), -c.arm_b[i].dot(n)];
        self.bodies[l] = c.bodies[i];
        let (mut a, mut b) = (0.0, 0.0);
        for side in 0..2 {
            let body = c.bodies[i][side] as usize;
            let (m, j) = (masses.inv_mass[body], masses.round[body]);
            // A body that is held in place has no ball's arm, and needs none.
            let r = if m > 0.0 { reach[side] } else { 0.0 };
            self.inv_mass[side][l] = T::of(m);
            self.radius[side][l] = T::of(r);
            self.lever[side][l] = T::of(r * j);
            a += m;
            b += m + r * r * j;
        }
        self.normal.set(l, n);
        self.gamma.set(l, gamma);
        self.offset[l] = T::of(op.offset[i]);
        self.along[l] = T::of(1.0 / a);
        self.across[l] = T::of(1.0 / b);
        self.stretch[l] = T::of((b / a).sqrt());
        self.friction[l] = T::of(op.friction[i] * (b / a).sqrt());
    }
}

/// Visit groups of one colour; returns the sum of `|Δγ/η|²`.
fn visit<T: Real, const L: usize>(groups: &mut [Group<T, L>], motion: &Cells<Motion<T>>, omega: f64) -> f64 {
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2") {
        // SAFETY: the processor has AVX2.
        return unsafe { visit_avx2(groups, motion, omega) };
    }
    visit_lanes(groups, motion, omega)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
unsafe fn visit_avx2<T: Real, const L: usize>(
    groups: &mut [Group<T, L>],
    motion: &Cells<Motion<T>>,
    omega: f64,
) -> f64 {
    visit_lanes(groups, motion, omega)
}

#[inline(always)]
fn visit_lanes<T: Real, const L: usize>(groups: &mut [Group<T, L>], motion: &Cells<Motion<T>>, omega: f64) -> f64 {
    let mut missed = [0.0; L];
    let (one, third) = (T::of(1.0), T::of(1.0 / 3.0));
    for g in groups {
        let side = |s: usize| -> [Motion<T>; L] { each(|l| motion.get(g.bodies[l][s] as usize)) };
        let v = |m: &[Motion<T>; L]| Lane3 { x: each(|l| m[l].v[0]), y: each(|l| m[l].v[1]), z: each(|l| m[l].v[2]) };
        let w = |m: &[Motion<T>; L]| Lane3 { x: each(|l| m[l].w[0]), y: each(|l| m[l].w[1]), z: each(|l| m[l].w[2]) };
        let (ta, tb) = (side(0), side(1));
        let n = g.normal;
        let (va, wa, vb, wb) = (v(&ta), w(&ta), v(&tb), w(&tb));
        let rolling = wa.times(g.radius[0]).plus(wb.times(g.radius[1])).cross(n);
        let v = vb.minus(va).minus(rolling);
        let v_n = v.dot(n);
        let before_n = g.gamma.dot(n);
        let normal = each(|l| before_n[l] - (v_n[l] + g.offset[l]) * g.along[l]);
        let tangent = g.gamma.minus(n.times(before_n)).minus(v.minus(n.times(v_n)).times(g.across));
        let z = project(n.times(normal).plus(tangent.times(g.stretch)), n, g.friction);
        let along = n.times(z.dot(n));
        let z = along.plus(z.minus(along).times(each(|l| one / g.stretch[l])));
        let d = z.minus(g.gamma).times([T::of(omega); L]);
        g.gamma = g.gamma.plus(d);
        let spin = n.cross(d);
        let (va, vb) = (va.minus(d.times(g.inv_mass[0])), vb.plus(d.times(g.inv_mass[1])));
        let (wa, wb) = (wa.minus(spin.times(g.lever[0])), wb.minus(spin.times(g.lever[1])));
        for l in 0..L {
            let at = |v: &Lane3<T, L>| [v.x[l], v.y[l], v.z[l]];
            if g.inv_mass[0][l] > T::default() {
                motion.set(g.bodies[l][0] as usize, Motion { v: at(&va), w: at(&wa) });
            }
            if g.inv_mass[1][l] > T::default() {
                motion.set(g.bodies[l][1] as usize, Motion { v: at(&vb), w: at(&wb) });
            }
        }
        // 1/η is a third of the trace of N_ii = diag(a, b, b).
        let square = d.dot(d);
        for l in 0..L {
            let trace = (one / g.along[l] + (one + one) / g.across[l]) * third;
            missed[l] += (square[l] * trace * trace).wide();
        }
    }
    missed.iter().sum()
}
