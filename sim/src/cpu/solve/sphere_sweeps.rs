//! Gauss–Seidel sweeps on contacts between spheres with friction alone, several contacts at a time.
//!
//! A sphere's contact arm lies along the normal, so that `D_iᵀ v = v_b − v_a − (r_a ω_a + r_b ω_b) × n`, and N_ii is diagonal in the
//! contact's frame: a for the normal, b for the tangents. The block's problem is then a projection in the metric (a, b, b): in
//! tangents stretched by √(b/a) it is the projection onto the cone of μ√(b/a). With Coulomb's law itself the normal has a problem
//! of its own, and the tangents are projected onto the disc that its solution gives (Jourdan et al. 1998): no outer loop is needed.
//!
//! The data of the contacts is packed once per solve, tile by tile and colour by colour (`schedule`), in groups of contacts that have no
//! body in common; a sweep streams through it. The first sweeps are in single precision, where a group has eight contacts and half the
//! bytes; double precision follows once the residual is near the rounding error. The bodies' velocities are then computed again from the
//! impulses, so that the momentum has no rounding error of single precision.

use super::bodies::BodyOperator;
use super::cells::Cells;
use super::operator::Operator;
use super::response::Response;
use super::schedule::{Colored, Tiled};
use crate::contacts::Arms;
#[cfg(target_arch = "x86_64")]
use crate::lanes::Wide;
use crate::lanes::{Lane3, Lanes, Plain, Real, project};
use crate::outcome::Outcome;
use crate::rows::{add, cut, fill_rows, reduce_tasks};
use crate::settings::{FrictionLaw, SolverSettings};
use crate::twist::Twist;
use glam::DVec3;
use rayon::prelude::*;

/// Root mean square of the residual terms at which single precision ends, over the maximum speed of a body.
const COARSE: f64 = 1e-5;

/// The columns of the sweeps, which keep their memory from step to step.
#[derive(Default)]
pub struct Sweeps {
    tiled: Tiled,
    coarse: Packed<f32, 8>,
    fine: Packed<f64, 4>,
}

impl Sweeps {
    /// Release the memory of columns that the next solve lays out again.
    pub fn release(&mut self) {
        (self.coarse, self.fine) = Default::default();
    }
}

/// Solve: γ comes in as the starting point and goes out as the solution, `response` as its response.
pub fn run(
    op: &mut BodyOperator,
    settings: &SolverSettings,
    gamma: &mut [DVec3],
    response: &mut Response,
    work: &mut Sweeps,
) -> Outcome {
    let Sweeps { tiled, coarse, fine } = work;
    tiled.fill(op.contacts, &op.masses.inv_mass);
    op.joints.reset(response);
    let mut outcome = Outcome { iterations: 0, residual: f64::INFINITY };
    if op.joints.rows.is_empty() {
        coarse.fill(op, tiled, gamma);
        let tolerance = COARSE * coarse.max_speed() / (gamma.len() as f64).sqrt();
        coarse.sweeps(settings, gamma.len(), settings.tolerance.max(tolerance), &mut outcome, |_| ());
        coarse.unpack(tiled, gamma);
    }
    if outcome.iterations < settings.max_iterations(gamma.len()) && outcome.residual > settings.tolerance {
        fine.fill(op, tiled, gamma);
        let mut solve_joints = |fine: &mut Packed<f64, 4>| {
            if !op.joints.rows.is_empty() {
                fine.store(response);
                op.solve_joints(response);
                fine.load(response);
            }
        };
        solve_joints(fine);
        fine.sweeps(settings, gamma.len(), settings.tolerance, &mut outcome, solve_joints);
        fine.unpack(tiled, gamma);
        fine.store(response);
    } else {
        op.response(gamma, response);
    }
    outcome
}

/// A group of contacts of one colour, in lanes.
#[derive(Clone, Copy)]
struct Group<T, const L: usize> {
    bodies: [[u32; 2]; L],
    /// Whether all bodies move.
    moves: bool,
    normal: [[T; L]; 3],
    gamma: [[T; L]; 3],
    /// Lengths of the arms, m.
    reach: [[T; L]; 2],
    offset: [T; L],
    friction: [T; L],
}

/// The velocities of a body with its reciprocal mass and moment of inertia, in one cache line.
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

/// All contacts in groups, and the motions of the bodies.
pub struct Packed<T, const L: usize> {
    groups: Vec<Group<T, L>>,
    /// Number of groups of each tile of both rounds, and of each colour of the contacts in no tile.
    n_groups: [Vec<usize>; 3],
    motion: Vec<Motion<T>>,
}

impl<T, const L: usize> Default for Packed<T, L> {
    fn default() -> Self {
        Packed { groups: vec![], n_groups: Default::default(), motion: vec![] }
    }
}

/// Number of groups up to which one thread visits them.
const SERIAL_LIMIT: usize = 512;

/// The action of a visit on a contact.
mod act {
    /// Apply its impulse to its bodies.
    pub const APPLY: u8 = 0;
    /// Solve its problem with relaxed friction.
    pub const RELAXED: u8 = 1;
    /// Solve its problem with exact friction.
    pub const EXACT: u8 = 2;
}

impl<T: Grouped<L>, const L: usize> Packed<T, L> {
    /// Pack the contacts with the impulses γ, projected onto their cones, and compute the motions of the bodies with them.
    fn fill(&mut self, op: &BodyOperator, tiled: &Tiled, gamma: &[DVec3]) {
        let (masses, n_bodies) = (op.masses, op.masses.inv_mass.len());
        let groups_of = |color: &[u32]| color.len().div_ceil(L);
        let of_round = |tiles: &[Colored]| tiles.iter().map(|tile| tile.colors().map(groups_of).sum()).collect();
        let [first, second] = &tiled.rounds;
        self.n_groups = [of_round(first), of_round(second), tiled.shared.colors().map(groups_of).collect()];
        let n_groups = self.n_groups.iter().flatten().sum();
        self.groups.truncate(n_groups);
        self.groups.reserve_exact(n_groups - self.groups.len());
        self.groups.resize(n_groups, Group::empty(n_bodies));
        let [first, second, shared] = self.parts();
        for (parts, tiles) in [first, second].into_iter().zip(&tiled.rounds) {
            let tiles = parts.into_par_iter().zip(tiles).with_max_len(1);
            tiles.for_each(|(groups, tile)| pack(groups, tile.colors(), op, gamma));
        }
        let colors = shared.into_iter().zip(tiled.shared.colors());
        colors.for_each(|(groups, color)| pack(groups, [color].into_iter(), op, gamma));
        self.motion.resize(n_bodies + 1, Motion::default());
        fill_rows(&mut self.motion[..n_bodies], |b| Motion::of(&op.free(b), masses.inv_mass[b], masses.inv_moment[b]));
        self.visit::<{ act::APPLY }>(1.0);
    }

    /// The groups of each tile of both rounds, and of each colour of the contacts in no tile.
    fn parts(&mut self) -> [Vec<&mut [Group<T, L>]>; 3] {
        let mut rest = &mut self.groups[..];
        self.n_groups.each_ref().map(|lengths| {
            let (own, after) = std::mem::take(&mut rest).split_at_mut(lengths.iter().sum());
            rest = after;
            cut(own, lengths.iter().copied())
        })
    }

    /// Load the motions of the bodies from a response.
    fn load(&mut self, response: &Response) {
        for (motion, twist) in self.motion.iter_mut().zip(&response.twist) {
            *motion = Motion::of(twist, motion.row[3].wide(), motion.row[7].wide());
        }
    }

    /// Store the motions of the bodies to a response.
    fn store(&self, response: &mut Response) {
        response.twist.resize(self.motion.len() - 1, Twist::default());
        fill_rows(&mut response.twist, |b| self.motion[b].twist());
    }

    /// Maximum speed of a body, m/s.
    fn max_speed(&self) -> f64 {
        self.motion.iter().fold(0.0f64, |max, m| max.max(m.twist().v.length_squared())).sqrt()
    }

    /// Sweep until the residual is within a tolerance, m/s, or the maximum number of iterations; `solve_joints` follows every sweep.
    fn sweeps(
        &mut self,
        settings: &SolverSettings,
        n: usize,
        tolerance: f64,
        outcome: &mut Outcome,
        mut solve_joints: impl FnMut(&mut Self),
    ) {
        let omega = settings.omega.unwrap_or(1.0);
        while outcome.iterations < settings.max_iterations(n) {
            // The residual terms of the blocks at the time of their visits, squared and summed.
            let residual2 = match settings.friction {
                FrictionLaw::Relaxed => self.visit::<{ act::RELAXED }>(omega),
                FrictionLaw::Exact => self.visit::<{ act::EXACT }>(omega),
            };
            *outcome = Outcome { iterations: outcome.iterations + 1, residual: residual2.sqrt() / n as f64 };
            solve_joints(self);
            if outcome.residual <= tolerance {
                break;
            }
        }
    }

    /// Visit all contacts once; returns the sum of `|Δγ/η|²`.
    fn visit<const ACT: u8>(&mut self, omega: f64) -> f64 {
        /// Number of groups of a shared colour that one task visits.
        const TASK: usize = 128;
        let mut motion = std::mem::take(&mut self.motion);
        let cells = Cells::new(&mut motion);
        // SAFETY: the tiles of a round, and the contacts of a shared colour, have no moving body in common.
        let visit = |groups: &mut [Group<T, L>]| [unsafe { visit::<T, L, ACT>(groups, &cells, omega) }];
        let mut residual2 = [0.0];
        let [first, second, shared] = self.parts();
        for tiles in [first, second] {
            let is_serial = tiles.iter().map(|groups| groups.len()).sum::<usize>() < SERIAL_LIMIT;
            residual2 = add(residual2, reduce_tasks(tiles.into_par_iter(), is_serial, visit));
        }
        for color in shared {
            let is_serial = color.len() < SERIAL_LIMIT;
            residual2 = add(residual2, reduce_tasks(color.par_chunks_mut(TASK), is_serial, visit));
        }
        self.motion = motion;
        residual2[0]
    }

    /// Read the impulses back.
    fn unpack(&mut self, tiled: &Tiled, gamma: &mut [DVec3]) {
        let gamma = Cells::new(gamma);
        let read = |groups: &[Group<T, L>], color: &[u32]| {
            for (group, contacts) in groups.iter().zip(color.chunks(L)) {
                // SAFETY: each contact is in one group, and each group is one task's.
                contacts.iter().enumerate().for_each(|(l, i)| unsafe { gamma.set(*i as usize, group.gamma(l)) });
            }
        };
        let [first, second, shared] = self.parts();
        for (parts, tiles) in [first, second].into_iter().zip(&tiled.rounds) {
            let tiles = parts.into_par_iter().zip(tiles).with_max_len(1);
            tiles.for_each(|(mut groups, tile)| {
                for color in tile.colors() {
                    let (own, after) = std::mem::take(&mut groups).split_at_mut(color.len().div_ceil(L));
                    groups = after;
                    read(own, color);
                }
            });
        }
        shared.into_iter().zip(tiled.shared.colors()).for_each(|(groups, color)| read(groups, color));
    }
}

/// Pack the contacts of some colours into groups.
fn pack<'a, T: Real, const L: usize>(
    groups: &mut [Group<T, L>],
    colors: impl Iterator<Item = &'a [u32]>,
    op: &BodyOperator,
    gamma: &[DVec3],
) {
    let inv_mass = &op.masses.inv_mass;
    for (group, contacts) in groups.iter_mut().zip(colors.flat_map(|color| color.chunks(L))) {
        *group = Group::empty(inv_mass.len());
        for (l, i) in contacts.iter().enumerate() {
            group.put(l, op, *i as usize, op.project(*i as usize, gamma[*i as usize], gamma));
        }
        let moves = |b: &u32| inv_mass.get(*b as usize).is_some_and(|inv_mass| *inv_mass > 0.0);
        group.moves = group.bodies.as_flattened().iter().all(moves);
    }
}

impl<T: Real, const L: usize> Group<T, L> {
    /// A group without contacts: its lanes refer to the motion after the last body's, which belongs to no body.
    fn empty(n_bodies: usize) -> Group<T, L> {
        Group {
            bodies: [[n_bodies as u32; 2]; L],
            moves: false,
            normal: [[T::default(); L]; 3],
            gamma: [[T::default(); L]; 3],
            reach: [[T::default(); L]; 2],
            offset: [T::default(); L],
            friction: [T::default(); L],
        }
    }

    fn put(&mut self, l: usize, op: &BodyOperator, i: usize, gamma: DVec3) {
        let c = op.contacts;
        let [arm_a, arm_b] = match &c.arms {
            Arms::Along(reach) => reach[i],
            Arms::Any(_) => unreachable!("spheres' arms lie along the normals"),
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
    /// Lanes in registers.
    #[cfg(target_arch = "x86_64")]
    type Wide: Lanes<Self, L>;
    /// Lanes in arrays.
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

/// Visit groups one after the other; returns the sum of `|Δγ/η|²`.
///
/// # Safety
/// No other thread touches the motions of the groups' moving bodies.
unsafe fn visit<T: Grouped<L>, const L: usize, const ACT: u8>(
    groups: &mut [Group<T, L>],
    motion: &Cells<Motion<T>>,
    omega: f64,
) -> f64 {
    #[cfg(target_arch = "x86_64")]
    {
        #[target_feature(enable = "avx2")]
        unsafe fn wide<T: Grouped<L>, const L: usize, const ACT: u8>(
            groups: &mut [Group<T, L>],
            motion: &Cells<Motion<T>>,
            omega: f64,
        ) -> f64 {
            // SAFETY: the caller's promise.
            unsafe { visit_lanes::<T, L, ACT, T::Wide>(groups, motion, omega) }
        }
        if crate::lanes::has_wide_lanes() {
            // SAFETY: the processor has AVX2; the caller's promise.
            return unsafe { wide::<T, L, ACT>(groups, motion, omega) };
        }
    }
    // SAFETY: the caller's promise.
    unsafe { visit_lanes::<T, L, ACT, T::Plain>(groups, motion, omega) }
}

/// # Safety
/// As for [`visit`].
#[inline(always)]
unsafe fn visit_lanes<T: Real, const L: usize, const ACT: u8, V: Lanes<T, L>>(
    groups: &mut [Group<T, L>],
    motion: &Cells<Motion<T>>,
    omega: f64,
) -> f64 {
    let (zero, one, third, omega) =
        (V::splat(T::of(0.0)), V::splat(T::of(1.0)), V::splat(T::of(1.0 / 3.0)), V::splat(T::of(omega)));
    let mut residual2 = zero;
    for g in groups {
        let (mut rows_a, mut rows_b) = ([[T::default(); 8]; L], [[T::default(); 8]; L]);
        for l in 0..L {
            let [a, b] = g.bodies[l];
            // SAFETY: the caller's promise, here and below.
            (rows_a[l], rows_b[l]) = unsafe { (motion.get(a as usize).row, motion.get(b as usize).row) };
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
        let along = a.select_le(zero, zero, one / a);
        let across = a.select_le(zero, zero, one / b);
        let d = if ACT == act::APPLY {
            gamma
        } else {
            let rolling = wa.times(reach_a).plus(wb.times(reach_b)).cross(n);
            let v = vb.minus(va).minus(rolling);
            let v_n = v.dot(n);
            let before_n = gamma.dot(n);
            let normal = before_n - (v_n + V::load(&g.offset)) * along;
            let tangent = gamma.minus(n.times(before_n)).minus(v.minus(n.times(v_n)).times(across));
            let friction = V::load(&g.friction);
            let z = if ACT == act::EXACT {
                // Coulomb's law itself splits into the two directions.
                let (kept, length) = (zero.select_le(normal, normal, zero), tangent.dot(tangent).sqrt());
                let limit = friction * kept;
                n.times(kept).plus(tangent.times(length.select_le(limit, one, limit / length)))
            } else {
                let (stretch, shrink) = ((b * along).sqrt(), (a * across).sqrt());
                let z = project(n.times(normal).plus(tangent.times(stretch)), n, friction * stretch);
                let z_n = n.times(z.dot(n));
                z_n.plus(z.minus(z_n).times(shrink))
            };
            let d = z.minus(gamma).times(omega);
            let gamma = gamma.plus(d);
            g.gamma = [gamma.x.to_array(), gamma.y.to_array(), gamma.z.to_array()];
            // 1/η is a third of the trace of N_ii.
            let trace = (a + b + b) * third;
            residual2 = residual2 + d.dot(d) * trace * trace;
            d
        };
        let spin = n.cross(d);
        let (va, vb) = (va.minus(d.times(mass_a)), vb.plus(d.times(mass_b)));
        let (wa, wb) = (wa.minus(spin.times(lever_a)), wb.minus(spin.times(lever_b)));
        let rows_a = V::rows([va.x, va.y, va.z, mass_a, wa.x, wa.y, wa.z, turn_a]);
        let rows_b = V::rows([vb.x, vb.y, vb.z, mass_b, wb.x, wb.y, wb.z, turn_b]);
        for l in 0..L {
            let [a, b] = g.bodies[l];
            // A body that is held in place may be in several groups that are visited concurrently: it is never written.
            if g.moves || rows_a[l][3] > T::default() {
                unsafe { motion.set(a as usize, Motion { row: rows_a[l] }) };
            }
            if g.moves || rows_b[l][3] > T::default() {
                unsafe { motion.set(b as usize, Motion { row: rows_b[l] }) };
            }
        }
    }
    residual2.to_array().iter().map(|m| m.wide()).sum()
}
