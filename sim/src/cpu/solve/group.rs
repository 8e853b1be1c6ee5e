//! Groups of blocks in lanes, and the motions of the bodies that they act on.

use super::bodies::BodyOperator;
use super::cells::Cells;
#[cfg(target_arch = "x86_64")]
use crate::lanes::{Double, Registers, Wide};
use crate::lanes::{Lane3, Lanes, Plain, Real, project};
use crate::twist::Twist;
use glam::DVec3;
use std::ops::Range;

/// Blocks of one colour side by side in lanes.
pub trait Group<T: Grouped<L>, const L: usize>: Copy + Send + Sync {
    /// Groups that are worth a task of a thread, some microseconds.
    const CHUNK: usize;

    /// A group without blocks: its lanes refer to the motion after the last body's, which belongs to no body.
    fn empty(n_bodies: usize) -> Self;

    /// Put the contacts of blocks into the lanes, at most one block each, with the impulses γ, for the exact law of friction or the relaxed.
    fn fill(
        &mut self,
        op: &BodyOperator,
        blocks: impl ExactSizeIterator<Item = Range<usize>> + Clone,
        gamma: &[DVec3],
        is_exact: bool,
    );

    /// The motions of bodies A and B of the block in each lane; as [`Group::fill`] leaves them, the bodies.
    fn bodies(&self) -> &[[u32; 2]; L];

    /// As [`Group::bodies`], to change.
    fn bodies_mut(&mut self) -> &mut [[u32; 2]; L];

    /// Impulse of contact `k` of the block in a lane.
    fn gamma(&self, l: usize, k: usize) -> DVec3;

    /// Angular impulse of contact `k` of the block in a lane, of groups whose contacts have one.
    fn roll(&self, l: usize, k: usize) -> Option<DVec3>;

    /// Visit groups one after the other, with the action `ACT`; returns the sum of `|Δγ/η|²`, and the greatest speed at which a gap closed
    /// by more than its width when it was visited, m/s.
    ///
    /// # Safety
    /// No other thread touches the motions of the groups' moving bodies.
    unsafe fn visit<const ACT: u8, V: Lanes<T, L>>(
        groups: &mut [Self],
        motion: &Cells<Motion<T>>,
        omega: f64,
    ) -> [f64; 2];
}

/// The action of a visit on a contact.
pub mod act {
    /// Evaluate what the later visits need of it, project its impulse onto its cone and apply it to its bodies; the first visit of a solve.
    pub const APPLY: u8 = 0;
    /// Solve its problem with relaxed friction.
    pub const RELAXED: u8 = 1;
    /// Solve its problem with exact friction.
    pub const EXACT: u8 = 2;
}

/// The velocities of a body with its reciprocal mass and moment of inertia, in one cache line.
#[derive(Clone, Copy, Default)]
#[repr(C, align(32))]
pub struct Motion<T> {
    /// v (3), the reciprocal mass, ω (3), the reciprocal moment of inertia.
    pub row: [T; 8],
}

impl<T: Real> Motion<T> {
    /// The motion of a body with a velocity, a reciprocal mass and a reciprocal moment of inertia.
    pub fn of(t: &Twist, inv_mass: f64, inv_inertia: f64) -> Motion<T> {
        Motion { row: [t.v.x, t.v.y, t.v.z, inv_mass, t.w.x, t.w.y, t.w.z, inv_inertia].map(T::of) }
    }

    /// The velocity.
    pub fn twist(&self) -> Twist {
        let [vx, vy, vz, _, wx, wy, wz, _] = self.row.map(T::wide);
        Twist { v: DVec3::new(vx, vy, vz), w: DVec3::new(wx, wy, wz) }
    }
}

/// Lanes of as many blocks as a group has.
pub trait Grouped<const L: usize>: Real {
    /// Lanes in registers of AVX2.
    #[cfg(target_arch = "x86_64")]
    type Wide: Lanes<Self, L>;
    /// Lanes in registers of AVX-512, or in as many of 256 bits where there are too few.
    #[cfg(target_arch = "x86_64")]
    type Widest: Lanes<Self, L>;
    /// Lanes in arrays.
    type Plain: Lanes<Self, L>;
}

impl Grouped<8> for f32 {
    #[cfg(target_arch = "x86_64")]
    type Wide = Wide<std::arch::x86_64::__m256>;
    #[cfg(target_arch = "x86_64")]
    type Widest = Self::Wide;
    type Plain = Plain<f32, 8>;
}

impl Grouped<16> for f32 {
    #[cfg(target_arch = "x86_64")]
    type Wide = Double<Wide<std::arch::x86_64::__m256>>;
    #[cfg(target_arch = "x86_64")]
    type Widest = Wide<std::arch::x86_64::__m512>;
    type Plain = Plain<f32, 16>;
}

impl Grouped<4> for f64 {
    #[cfg(target_arch = "x86_64")]
    type Wide = Wide<std::arch::x86_64::__m256d>;
    #[cfg(target_arch = "x86_64")]
    type Widest = Self::Wide;
    type Plain = Plain<f64, 4>;
}

/// [`Group::visit`] with the widest lanes that the processor has.
///
/// # Safety
/// As there.
pub unsafe fn visit<T: Grouped<L>, const L: usize, G: Group<T, L>, const ACT: u8>(
    groups: &mut [G],
    motion: &Cells<Motion<T>>,
    omega: f64,
) -> [f64; 2] {
    #[cfg(target_arch = "x86_64")]
    {
        #[target_feature(enable = "avx2")]
        unsafe fn wide<T: Grouped<L>, const L: usize, G: Group<T, L>, const ACT: u8>(
            groups: &mut [G],
            motion: &Cells<Motion<T>>,
            omega: f64,
        ) -> [f64; 2] {
            crate::lanes::align_stack();
            // SAFETY: the caller's promise.
            unsafe { G::visit::<ACT, T::Wide>(groups, motion, omega) }
        }
        #[target_feature(enable = "avx512f,avx512vl")]
        unsafe fn widest<T: Grouped<L>, const L: usize, G: Group<T, L>, const ACT: u8>(
            groups: &mut [G],
            motion: &Cells<Motion<T>>,
            omega: f64,
        ) -> [f64; 2] {
            crate::lanes::align_stack();
            // SAFETY: the caller's promise.
            unsafe { G::visit::<ACT, T::Widest>(groups, motion, omega) }
        }
        match crate::lanes::registers() {
            // SAFETY: the processor has AVX-512; the caller's promise.
            Registers::Avx512 => return unsafe { widest::<T, L, G, ACT>(groups, motion, omega) },
            // SAFETY: the processor has AVX2; the caller's promise.
            Registers::Avx2 => return unsafe { wide::<T, L, G, ACT>(groups, motion, omega) },
            Registers::Arrays => {}
        }
    }
    // SAFETY: the caller's promise.
    unsafe { G::visit::<ACT, T::Plain>(groups, motion, omega) }
}

/// The motions of bodies A and B of a group's blocks, as columns: of v (3), the reciprocal mass, ω (3), the reciprocal moment of inertia.
///
/// # Safety
/// No other thread writes the motions.
#[inline(always)]
pub unsafe fn gather<T: Real, const L: usize, V: Lanes<T, L>>(
    motion: &Cells<Motion<T>>,
    bodies: &[[u32; 2]; L],
) -> [[V; 8]; 2] {
    let mut rows = [[[T::default(); 8]; L]; 2];
    for (l, of_lane) in bodies.iter().enumerate() {
        for k in 0..2 {
            // SAFETY: the caller's promise.
            rows[k][l] = unsafe { motion.get(of_lane[k] as usize).row };
        }
    }
    [V::columns(&rows[0]), V::columns(&rows[1])]
}

/// Write the motions of the bodies that move; `moves` tells that all do.
///
/// # Safety
/// No other thread touches the motions of the bodies that move.
#[inline(always)]
pub unsafe fn scatter<T: Real, const L: usize, V: Lanes<T, L>>(
    motion: &Cells<Motion<T>>,
    bodies: &[[u32; 2]; L],
    moves: bool,
    columns: [[V; 8]; 2],
) {
    let [a, b] = columns;
    let rows = [V::rows(a), V::rows(b)];
    for (l, of_lane) in bodies.iter().enumerate() {
        for k in 0..2 {
            let body = of_lane[k] as usize;
            // SAFETY: the caller's promise. A body that is held in place may be in several groups that are visited concurrently: it is never
            // written.
            unsafe {
                if moves || motion.get(body).row[3] > T::default() {
                    motion.set(body, Motion { row: rows[k][l] });
                }
            }
        }
    }
}

/// Impulses projected onto the cones of contacts with adhesion `tip`, N s.
#[inline(always)]
pub fn projected<T: Real, const L: usize, V: Lanes<T, L>>(
    gamma: Lane3<V>,
    n: Lane3<V>,
    friction: V,
    tip: V,
) -> Lane3<V> {
    project(gamma.plus(n.times(tip)), n, friction).minus(n.times(tip))
}

/// The greater of the speeds of closing, m/s, so far and of contacts that open at some speed.
#[inline(always)]
pub fn faster<T: Real, const L: usize, V: Lanes<T, L>>(closing: V, opening: V) -> V {
    let own = V::splat(T::of(0.0)) - opening;
    closing.select_le(own, own, closing)
}

/// Sum of all lanes.
#[inline(always)]
pub fn sum<T: Real, const L: usize, V: Lanes<T, L>>(v: V) -> f64 {
    v.to_array().iter().map(|x| x.wide()).sum()
}

/// The greatest of all lanes.
#[inline(always)]
pub fn max<T: Real, const L: usize, V: Lanes<T, L>>(v: V) -> f64 {
    v.to_array().iter().map(|x| x.wide()).fold(0.0, f64::max)
}
