//! Lanes: scalars and vectors of several contacts side by side, in vector registers where the processor has AVX2 or AVX-512, in plain arrays
//! elsewhere. No operation is fused, so that all machines get the same bits.
//!
//! A lane loop is a function generic over [`Lanes`], `#[inline(always)]` down to here. A function compiled for AVX2 calls it with
//! [`Wide`], another one with [`Plain`] ([`widest`] does this for double precision). There are no closures in between: they would be
//! compiled without AVX2.

use crate::twist::Twist;
use glam::DVec3;
use std::ops::{Add, Div, Mul, Sub};

/// A floating-point type: single or double precision.
pub trait Real: Copy + Default + PartialOrd + Send + Sync {
    /// Conversion from double precision, rounded.
    fn of(x: f64) -> Self;
    /// Conversion to double precision.
    fn wide(self) -> f64;
}

impl Real for f64 {
    #[inline(always)]
    fn of(x: f64) -> f64 {
        x
    }
    #[inline(always)]
    fn wide(self) -> f64 {
        self
    }
}

impl Real for f32 {
    #[inline(always)]
    fn of(x: f64) -> f32 {
        x as f32
    }
    #[inline(always)]
    fn wide(self) -> f64 {
        self as f64
    }
}

/// A scalar of each of L contacts.
pub trait Lanes<T: Real, const L: usize>:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// The same value in all lanes.
    fn splat(x: T) -> Self;
    /// Load from an array.
    fn load(v: &[T; L]) -> Self;
    /// Store to an array.
    fn to_array(self) -> [T; L];
    /// Square root.
    fn sqrt(self) -> Self;
    /// Select `yes` where `self` ≤ `max`, else `no`.
    fn select_le(self, max: Self, yes: Self, no: Self) -> Self;
    /// Transpose rows of eight values to eight columns.
    fn columns(rows: &[[T; 8]; L]) -> [Self; 8];
    /// Transpose eight columns to rows of eight values.
    fn rows(columns: [Self; 8]) -> [[T; 8]; L];
}

/// Lanes of four contacts in double precision, with the loads and stores of the descent methods and the narrow phase.
pub trait Lanes4: Lanes<f64, 4> {
    /// Mask whose bit l is set where lane l of `self` ≤ that of `max`.
    fn mask_le(self, max: Self) -> u32;
    /// Load four vectors.
    fn load3(v: &[DVec3; 4]) -> Lane3<Self>;
    /// Store four vectors.
    fn store3(v: Lane3<Self>, to: &mut [DVec3; 4]);
    /// Load four pairs.
    fn load2(v: &[[f64; 2]; 4]) -> [Self; 2];
    /// Load four twists: linear and angular parts.
    fn twists(t: [&Twist; 4]) -> [Lane3<Self>; 2];
    /// Store four twists.
    fn to_twists(v: Lane3<Self>, w: Lane3<Self>) -> [Twist; 4];
}

/// A lane loop in double precision, four contacts side by side, with its arguments.
pub trait LaneLoop {
    /// Result of the loop.
    type Out;
    /// Run the loop; `#[inline(always)]`.
    fn run<V: Lanes4>(self) -> Self::Out;
}

/// The registers of loops over contacts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Registers {
    /// Plain arrays.
    Arrays,
    /// Registers of 256 bits.
    Avx2,
    /// Registers of 512 bits, where a loop has lanes for them; else twice as many of 256.
    Avx512,
}

/// The widest registers that the processor has and `SCREE_LANES` (a switch for tests, read once: `plain` or `avx2`) allows.
pub fn registers() -> Registers {
    #[cfg(target_arch = "x86_64")]
    {
        use std::sync::LazyLock;
        static WIDEST: LazyLock<Registers> = LazyLock::new(|| {
            let allowed = std::env::var_os("SCREE_LANES").unwrap_or_default();
            if !std::arch::is_x86_feature_detected!("avx2") || allowed == "plain" {
                Registers::Arrays
            } else if !has_avx512() || allowed == "avx2" {
                Registers::Avx2
            } else {
                Registers::Avx512
            }
        });
        *WIDEST
    }
    #[cfg(not(target_arch = "x86_64"))]
    Registers::Arrays
}

/// Whether the processor has 32 registers of 512 bits, which may be used as registers of 256.
#[cfg(target_arch = "x86_64")]
fn has_avx512() -> bool {
    std::arch::is_x86_feature_detected!("avx512f") && std::arch::is_x86_feature_detected!("avx512vl")
}

/// Align the stack of the calling function to cache lines: what lies on the stack is aligned only where something must be, and registers that
/// are saved there astride two lines took half of a sweep's time on AMD's Zen 4.
#[inline(always)]
pub fn align_stack() {
    #[repr(align(64))]
    struct Line(#[expect(dead_code, reason = "only its place matters")] u8);
    std::hint::black_box(&mut Line(0));
}

/// Run a lane loop with the widest lanes that the processor has.
pub fn widest<L: LaneLoop>(lane_loop: L) -> L::Out {
    #[cfg(target_arch = "x86_64")]
    {
        #[target_feature(enable = "avx2")]
        unsafe fn wide<L: LaneLoop>(lane_loop: L) -> L::Out {
            align_stack();
            lane_loop.run::<Wide<std::arch::x86_64::__m256d>>()
        }
        /// The same with twice as many registers.
        #[target_feature(enable = "avx512f,avx512vl")]
        unsafe fn many<L: LaneLoop>(lane_loop: L) -> L::Out {
            align_stack();
            lane_loop.run::<Wide<std::arch::x86_64::__m256d>>()
        }
        match registers() {
            // SAFETY: the processor has AVX-512.
            Registers::Avx512 => return unsafe { many(lane_loop) },
            // SAFETY: the processor has AVX2.
            Registers::Avx2 => return unsafe { wide(lane_loop) },
            Registers::Arrays => {}
        }
    }
    lane_loop.run::<Plain<f64, 4>>()
}

/// Four rows of a column, from row `k` on.
#[inline(always)]
pub fn four<T>(column: &[T], k: usize) -> &[T; 4] {
    column[k..k + 4].try_into().expect("four rows")
}

/// Four rows of a column, from row `k` on, for writing.
#[inline(always)]
pub fn four_mut<T>(column: &mut [T], k: usize) -> &mut [T; 4] {
    (&mut column[k..k + 4]).try_into().expect("four rows")
}

/// Lanes as an array.
#[derive(Clone, Copy)]
pub struct Plain<T, const L: usize>([T; L]);

macro_rules! plain {
    ($T:ty) => {
        impl<const L: usize> Plain<$T, L> {
            #[inline(always)]
            fn with(mut self, o: Self, f: impl Fn($T, $T) -> $T) -> Self {
                self.0.iter_mut().zip(o.0).for_each(|(a, b)| *a = f(*a, b));
                self
            }
        }
        plain!($T, Add, add, |a, b| a + b);
        plain!($T, Sub, sub, |a, b| a - b);
        plain!($T, Mul, mul, |a, b| a * b);
        plain!($T, Div, div, |a, b| a / b);
        impl<const L: usize> Lanes<$T, L> for Plain<$T, L> {
            #[inline(always)]
            fn splat(x: $T) -> Self {
                Plain([x; L])
            }
            #[inline(always)]
            fn load(v: &[$T; L]) -> Self {
                Plain(*v)
            }
            #[inline(always)]
            fn to_array(self) -> [$T; L] {
                self.0
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                Plain(self.0.map(<$T>::sqrt))
            }
            #[inline(always)]
            fn select_le(self, max: Self, yes: Self, no: Self) -> Self {
                Plain(std::array::from_fn(|l| if self.0[l] <= max.0[l] { yes.0[l] } else { no.0[l] }))
            }
            #[inline(always)]
            fn columns(rows: &[[$T; 8]; L]) -> [Self; 8] {
                std::array::from_fn(|c| Plain(std::array::from_fn(|l| rows[l][c])))
            }
            #[inline(always)]
            fn rows(columns: [Self; 8]) -> [[$T; 8]; L] {
                std::array::from_fn(|l| std::array::from_fn(|c| columns[c].0[l]))
            }
        }
    };
    ($T:ty, $Op:ident, $op:ident, $f:expr) => {
        impl<const L: usize> $Op for Plain<$T, L> {
            type Output = Self;
            #[inline(always)]
            fn $op(self, o: Self) -> Self {
                self.with(o, $f)
            }
        }
    };
}

plain!(f32);
plain!(f64);

impl Lanes4 for Plain<f64, 4> {
    #[inline(always)]
    fn mask_le(self, max: Self) -> u32 {
        (0..4).fold(0, |bits, l| bits | ((self.0[l] <= max.0[l]) as u32) << l)
    }
    #[inline(always)]
    fn load3(v: &[DVec3; 4]) -> Lane3<Self> {
        Lane3 { x: Plain(v.map(|v| v.x)), y: Plain(v.map(|v| v.y)), z: Plain(v.map(|v| v.z)) }
    }
    #[inline(always)]
    fn store3(v: Lane3<Self>, to: &mut [DVec3; 4]) {
        *to = std::array::from_fn(|l| DVec3::new(v.x.0[l], v.y.0[l], v.z.0[l]));
    }
    #[inline(always)]
    fn load2(v: &[[f64; 2]; 4]) -> [Self; 2] {
        [Plain(v.map(|v| v[0])), Plain(v.map(|v| v[1]))]
    }
    #[inline(always)]
    fn twists(t: [&Twist; 4]) -> [Lane3<Self>; 2] {
        [Self::load3(&t.map(|t| t.v)), Self::load3(&t.map(|t| t.w))]
    }
    #[inline(always)]
    fn to_twists(v: Lane3<Self>, w: Lane3<Self>) -> [Twist; 4] {
        let vector = |u: &Lane3<Self>, l: usize| DVec3::new(u.x.0[l], u.y.0[l], u.z.0[l]);
        std::array::from_fn(|l| Twist { v: vector(&v, l), w: vector(&w, l) })
    }
}

/// Lanes in a vector register, for functions that are compiled for AVX2 (AVX-512 where it has 512 bits) and run on processors that have it
/// alone.
#[cfg(target_arch = "x86_64")]
#[derive(Clone, Copy)]
pub struct Wide<V>(V);

#[cfg(target_arch = "x86_64")]
mod wide;

/// Twice as many lanes as V has, in two halves, so that one is worked on while the other waits.
#[derive(Clone, Copy)]
pub struct Double<V>([V; 2]);

impl<V: Copy> Double<V> {
    #[inline(always)]
    fn with(self, o: Self, f: impl Fn(V, V) -> V) -> Self {
        Double([f(self.0[0], o.0[0]), f(self.0[1], o.0[1])])
    }
}

macro_rules! double {
    ($Op:ident, $op:ident) => {
        impl<V: Copy + $Op<Output = V>> $Op for Double<V> {
            type Output = Self;
            #[inline(always)]
            fn $op(self, o: Self) -> Self {
                self.with(o, V::$op)
            }
        }
    };
}

double!(Add, add);
double!(Sub, sub);
double!(Mul, mul);
double!(Div, div);

impl<V: Lanes<f32, 8>> Lanes<f32, 16> for Double<V> {
    #[inline(always)]
    fn splat(x: f32) -> Self {
        Double([V::splat(x); 2])
    }
    #[inline(always)]
    fn load(v: &[f32; 16]) -> Self {
        let (a, b) = halves(v);
        Double([V::load(a), V::load(b)])
    }
    #[inline(always)]
    fn to_array(self) -> [f32; 16] {
        joined(self.0.map(V::to_array))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Double([self.0[0].sqrt(), self.0[1].sqrt()])
    }
    #[inline(always)]
    fn select_le(self, max: Self, yes: Self, no: Self) -> Self {
        let of = |k: usize| self.0[k].select_le(max.0[k], yes.0[k], no.0[k]);
        Double([of(0), of(1)])
    }
    #[inline(always)]
    fn columns(rows: &[[f32; 8]; 16]) -> [Self; 8] {
        let (a, b) = halves(rows);
        let (a, b) = (V::columns(a), V::columns(b));
        std::array::from_fn(|c| Double([a[c], b[c]]))
    }
    #[inline(always)]
    fn rows(columns: [Self; 8]) -> [[f32; 8]; 16] {
        joined([V::rows(columns.map(|c| c.0[0])), V::rows(columns.map(|c| c.0[1]))])
    }
}

#[inline(always)]
fn halves<T>(v: &[T; 16]) -> (&[T; 8], &[T; 8]) {
    let (a, b) = v.split_at(8);
    (a.try_into().expect("eight"), b.try_into().expect("eight"))
}

#[inline(always)]
fn joined<T: Copy>(v: [[T; 8]; 2]) -> [T; 16] {
    std::array::from_fn(|l| v[l / 8][l % 8])
}

/// A 3-vector of each contact.
#[derive(Clone, Copy)]
pub struct Lane3<V> {
    /// x components.
    pub x: V,
    /// y components.
    pub y: V,
    /// z components.
    pub z: V,
}

impl<V: Copy + Add<Output = V> + Sub<Output = V> + Mul<Output = V>> Lane3<V> {
    #[inline(always)]
    pub fn plus(self, b: Self) -> Self {
        Lane3 { x: self.x + b.x, y: self.y + b.y, z: self.z + b.z }
    }

    #[inline(always)]
    pub fn minus(self, b: Self) -> Self {
        Lane3 { x: self.x - b.x, y: self.y - b.y, z: self.z - b.z }
    }

    #[inline(always)]
    pub fn times(self, s: V) -> Self {
        Lane3 { x: self.x * s, y: self.y * s, z: self.z * s }
    }

    #[inline(always)]
    pub fn dot(self, b: Self) -> V {
        self.x * b.x + self.y * b.y + self.z * b.z
    }

    #[inline(always)]
    pub fn cross(self, b: Self) -> Self {
        Lane3 { x: self.y * b.z - self.z * b.y, y: self.z * b.x - self.x * b.z, z: self.x * b.y - self.y * b.x }
    }
}

/// Project onto the cones |γ_t| ≤ μ γ_n, without branches.
#[inline(always)]
pub fn project<T: Real, const L: usize, V: Lanes<T, L>>(y: Lane3<V>, n: Lane3<V>, mu: V) -> Lane3<V> {
    let normal = y.dot(n);
    let tangent = y.minus(n.times(normal));
    let (kept, share) = cone(normal, tangent.dot(tangent).sqrt(), mu);
    n.times(kept).plus(tangent.times(share))
}

/// The projection onto the cones |γ_t| ≤ μ γ_n of vectors with a normal part and a tangential part of length `t`: its normal part, and its share
/// of the tangential one.
#[inline(always)]
pub fn cone<T: Real, const L: usize, V: Lanes<T, L>>(normal: V, t: V, mu: V) -> (V, V) {
    let (zero, one) = (V::splat(T::of(0.0)), V::splat(T::of(1.0)));
    // What does not wait for t and the normal part stands apart.
    let (reach, flat) = (t * mu, one / (mu * mu + one));
    let kept = reach.select_le(zero - normal, zero, (reach + normal) * flat);
    let share = t.select_le(zero, zero, mu * kept * (one / t));
    let limit = mu * normal;
    // Without friction and tangent a negative normal passes the test of the cone, 0 ≤ −0.
    let pushing = zero.select_le(normal, normal, zero);
    (t.select_le(limit, pushing, kept), t.select_le(limit, one, share))
}

#[cfg(all(test, target_arch = "x86_64"))]
mod tests;
