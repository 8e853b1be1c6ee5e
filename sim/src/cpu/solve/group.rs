//! Groups of blocks in lanes, and the motions of the bodies that they act on.

use super::bodies::BodyOperator;
use super::cells::Cells;
use super::schedule::Blocks;
#[cfg(target_arch = "x86_64")]
use crate::lanes::{Double, Registers, Wide};
use crate::lanes::{Lane3, Lanes, Plain, Real, project};
use crate::twist::Twist;
use glam::DVec3;

/// Blocks of one colour side by side in lanes.
pub trait Group<T: Grouped<L>, const L: usize>: Copy + Send + Sync {
    /// Groups that are worth a task of a thread, some microseconds.
    const CHUNK: usize;
    /// Whether contacts may have angular impulses.
    const ROLLS: bool;
    /// What a contact has, rounded, side by side.
    type Row: Copy + Default + Send + Sync;
    /// What a body has, rounded, besides its motion.
    type Body: Copy + Default + Send + Sync;

    /// A group that is to be filled before it is visited.
    fn empty() -> Self;

    /// The row of a contact.
    fn row(from: &Source, contact: usize) -> Self::Row;

    /// That of a body.
    fn body(from: &Source, body: usize) -> Self::Body;

    /// Put the contacts of blocks into the lanes, at most one block each, from the rows of all contacts and of the bodies by places.
    fn fill<V: Lanes<T, L>>(&mut self, from: &Source, rows: (&[Self::Row], &[Self::Body]), own: &[u32]);

    /// The motions of bodies A and B of the block in each lane.
    fn bodies(&self) -> &[[u32; 2]; L];

    /// The impulses (3) and, of groups whose contacts have them, the angular impulses (3) of the first contact of each block, of the second, and
    /// so on.
    fn impulses<V: Lanes<T, L>>(&self, out: &mut [[[T; 8]; L]; Blocks::MOST]);

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

/// What groups are filled from.
pub struct Source<'a> {
    /// The operator of the step.
    pub op: &'a BodyOperator<'a>,
    /// The blocks.
    pub blocks: &'a Blocks,
    /// The places of the motions of the bodies, and that of a motion that belongs to no body (n_bodies + 1).
    pub place: &'a [u32],
    /// The impulses γ.
    pub gamma: &'a [DVec3],
    /// Whether the law of friction is the exact one.
    pub is_exact: bool,
}

impl Source<'_> {
    /// The place of the motion that belongs to no body, which lanes without a block refer to.
    #[inline(always)]
    pub fn nowhere(&self) -> u32 {
        self.place[self.place.len() - 1]
    }

    /// The places of the motions of two bodies, and whether both move.
    #[inline(always)]
    pub fn places(&self, bodies: [u32; 2]) -> ([u32; 2], bool) {
        let [a, b] = bodies.map(|b| b as usize);
        let inv_mass = &self.op.masses.inv_mass;
        ([self.place[a], self.place[b]], inv_mass[a] > 0.0 && inv_mass[b] > 0.0)
    }
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

/// Work on lanes of blocks.
pub trait Work<T: Grouped<L>, const L: usize> {
    /// What comes of it.
    type Out;

    /// Do it; `#[inline(always)]`.
    ///
    /// # Safety
    /// As the work tells.
    unsafe fn run<V: Lanes<T, L>>(self) -> Self::Out;
}

/// Work with the widest lanes that the processor has.
///
/// # Safety
/// As [`Work::run`].
pub unsafe fn widest<T: Grouped<L>, const L: usize, W: Work<T, L>>(work: W) -> W::Out {
    #[cfg(target_arch = "x86_64")]
    {
        #[target_feature(enable = "avx2")]
        unsafe fn wide<T: Grouped<L>, const L: usize, W: Work<T, L>>(work: W) -> W::Out {
            crate::lanes::align_stack();
            // SAFETY: the caller's promise.
            unsafe { work.run::<T::Wide>() }
        }
        #[target_feature(enable = "avx512f,avx512vl")]
        unsafe fn many<T: Grouped<L>, const L: usize, W: Work<T, L>>(work: W) -> W::Out {
            crate::lanes::align_stack();
            // SAFETY: the caller's promise.
            unsafe { work.run::<T::Widest>() }
        }
        match crate::lanes::registers() {
            // SAFETY: the processor has AVX-512; the caller's promise.
            Registers::Avx512 => return unsafe { many(work) },
            // SAFETY: the processor has AVX2; the caller's promise.
            Registers::Avx2 => return unsafe { wide(work) },
            Registers::Arrays => {}
        }
    }
    // SAFETY: the caller's promise.
    unsafe { work.run::<T::Plain>() }
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

/// Store columns; not by a closure, which would be compiled without the registers.
#[inline(always)]
pub fn store<T: Real, const L: usize, V: Lanes<T, L>, const N: usize>(to: &mut [[T; L]; N], columns: [V; N]) {
    for k in 0..N {
        to[k] = columns[k].to_array();
    }
}

/// Rows of impulses (3) and, where there are any, angular impulses (3), from their columns.
#[inline(always)]
pub fn impulse_rows<T: Real, const L: usize, V: Lanes<T, L>>(
    gamma: &[[T; L]; 3],
    roll: Option<&[[T; L]; 3]>,
) -> [[T; 8]; L] {
    let mut columns = [V::splat(T::default()); 8];
    for k in 0..3 {
        columns[k] = V::load(&gamma[k]);
        if let Some(roll) = roll {
            columns[3 + k] = V::load(&roll[k]);
        }
    }
    V::rows(columns)
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
