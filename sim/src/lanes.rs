//! Lanes: scalars and vectors of several contacts side by side, in vector registers where the processor has AVX2, in plain arrays
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

/// Whether loops over contacts run in vector registers: the processor has AVX2, and `SCREE_LANES=plain` is not in the environment (a switch
/// for tests, read once).
pub fn has_wide_lanes() -> bool {
    #[cfg(target_arch = "x86_64")]
    {
        use std::sync::LazyLock;
        static WIDE: LazyLock<bool> = LazyLock::new(|| {
            std::arch::is_x86_feature_detected!("avx2") && std::env::var_os("SCREE_LANES").is_none_or(|v| v != "plain")
        });
        *WIDE
    }
    #[cfg(not(target_arch = "x86_64"))]
    false
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
        if has_wide_lanes() {
            // SAFETY: the processor has AVX2.
            return unsafe { wide(lane_loop) };
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

/// Lanes in a vector register, for functions that are compiled for AVX2 and run on processors with AVX2 alone.
#[cfg(target_arch = "x86_64")]
#[derive(Clone, Copy)]
pub struct Wide<V>(V);

#[cfg(target_arch = "x86_64")]
mod wide {
    // SAFETY, here and below: AVX2 is there (see `Wide`), and loads and stores are of as many numbers as a register holds.
    use super::*;
    use std::arch::x86_64::*;

    macro_rules! operator {
        ($V:ty, $Op:ident, $op:ident, $f:ident) => {
            impl $Op for Wide<$V> {
                type Output = Self;
                #[inline(always)]
                fn $op(self, o: Self) -> Self {
                    Wide(unsafe { $f(self.0, o.0) })
                }
            }
        };
    }

    operator!(__m256, Add, add, _mm256_add_ps);
    operator!(__m256, Sub, sub, _mm256_sub_ps);
    operator!(__m256, Mul, mul, _mm256_mul_ps);
    operator!(__m256, Div, div, _mm256_div_ps);
    operator!(__m256d, Add, add, _mm256_add_pd);
    operator!(__m256d, Sub, sub, _mm256_sub_pd);
    operator!(__m256d, Mul, mul, _mm256_mul_pd);
    operator!(__m256d, Div, div, _mm256_div_pd);

    impl Lanes<f32, 8> for Wide<__m256> {
        #[inline(always)]
        fn splat(x: f32) -> Self {
            Wide(unsafe { _mm256_set1_ps(x) })
        }
        #[inline(always)]
        fn load(v: &[f32; 8]) -> Self {
            Wide(unsafe { _mm256_loadu_ps(v.as_ptr()) })
        }
        #[inline(always)]
        fn to_array(self) -> [f32; 8] {
            let mut out = [0.0; 8];
            unsafe { _mm256_storeu_ps(out.as_mut_ptr(), self.0) };
            out
        }
        #[inline(always)]
        fn sqrt(self) -> Self {
            Wide(unsafe { _mm256_sqrt_ps(self.0) })
        }
        #[inline(always)]
        fn select_le(self, max: Self, yes: Self, no: Self) -> Self {
            Wide(unsafe { _mm256_blendv_ps(no.0, yes.0, _mm256_cmp_ps::<_CMP_LE_OQ>(self.0, max.0)) })
        }
        #[inline(always)]
        fn columns(rows: &[[f32; 8]; 8]) -> [Self; 8] {
            let [a, b, c, d, e, f, g, h] = rows;
            let rows = [Self::load(a), Self::load(b), Self::load(c), Self::load(d)];
            unsafe {
                transpose([
                    rows[0],
                    rows[1],
                    rows[2],
                    rows[3],
                    Self::load(e),
                    Self::load(f),
                    Self::load(g),
                    Self::load(h),
                ])
            }
        }
        #[inline(always)]
        fn rows(columns: [Self; 8]) -> [[f32; 8]; 8] {
            let rows = unsafe { transpose(columns) };
            let mut out = [[0.0; 8]; 8];
            for i in 0..8 {
                unsafe { _mm256_storeu_ps(out[i].as_mut_ptr(), rows[i].0) };
            }
            out
        }
    }

    /// Transpose eight rows: pairs of values, then pairs of those, then halves.
    #[target_feature(enable = "avx2")]
    #[inline]
    fn transpose(r: [Wide<__m256>; 8]) -> [Wide<__m256>; 8] {
        let mut p = r;
        for i in 0..4 {
            p[2 * i].0 = _mm256_unpacklo_ps(r[2 * i].0, r[2 * i + 1].0);
            p[2 * i + 1].0 = _mm256_unpackhi_ps(r[2 * i].0, r[2 * i + 1].0);
        }
        let mut q = p;
        for k in 0..2 {
            let i = 4 * k;
            q[i].0 = _mm256_shuffle_ps::<0b01_00_01_00>(p[i].0, p[i + 2].0);
            q[i + 1].0 = _mm256_shuffle_ps::<0b11_10_11_10>(p[i].0, p[i + 2].0);
            q[i + 2].0 = _mm256_shuffle_ps::<0b01_00_01_00>(p[i + 1].0, p[i + 3].0);
            q[i + 3].0 = _mm256_shuffle_ps::<0b11_10_11_10>(p[i + 1].0, p[i + 3].0);
        }
        let mut out = q;
        for i in 0..4 {
            out[i].0 = _mm256_permute2f128_ps::<0x20>(q[i].0, q[i + 4].0);
            out[i + 4].0 = _mm256_permute2f128_ps::<0x31>(q[i].0, q[i + 4].0);
        }
        out
    }

    impl Lanes<f64, 4> for Wide<__m256d> {
        #[inline(always)]
        fn splat(x: f64) -> Self {
            Wide(unsafe { _mm256_set1_pd(x) })
        }
        #[inline(always)]
        fn load(v: &[f64; 4]) -> Self {
            Wide(unsafe { _mm256_loadu_pd(v.as_ptr()) })
        }
        #[inline(always)]
        fn to_array(self) -> [f64; 4] {
            let mut out = [0.0; 4];
            unsafe { _mm256_storeu_pd(out.as_mut_ptr(), self.0) };
            out
        }
        #[inline(always)]
        fn sqrt(self) -> Self {
            Wide(unsafe { _mm256_sqrt_pd(self.0) })
        }
        #[inline(always)]
        fn select_le(self, max: Self, yes: Self, no: Self) -> Self {
            Wide(unsafe { _mm256_blendv_pd(no.0, yes.0, _mm256_cmp_pd::<_CMP_LE_OQ>(self.0, max.0)) })
        }
        #[inline(always)]
        fn columns(rows: &[[f64; 8]; 4]) -> [Self; 8] {
            let (mut low, mut high) = ([Self::splat(0.0); 4], [Self::splat(0.0); 4]);
            for i in 0..4 {
                low[i].0 = unsafe { _mm256_loadu_pd(rows[i].as_ptr()) };
                high[i].0 = unsafe { _mm256_loadu_pd(rows[i].as_ptr().add(4)) };
            }
            let ([a, b, c, d], [e, f, g, h]) = unsafe { (transpose4(low), transpose4(high)) };
            [a, b, c, d, e, f, g, h]
        }
        #[inline(always)]
        fn rows(c: [Self; 8]) -> [[f64; 8]; 4] {
            let low = unsafe { transpose4([c[0], c[1], c[2], c[3]]) };
            let high = unsafe { transpose4([c[4], c[5], c[6], c[7]]) };
            let mut rows = [[0.0; 8]; 4];
            for i in 0..4 {
                unsafe { _mm256_storeu_pd(rows[i].as_mut_ptr(), low[i].0) };
                unsafe { _mm256_storeu_pd(rows[i].as_mut_ptr().add(4), high[i].0) };
            }
            rows
        }
    }

    /// Transpose four rows.
    #[target_feature(enable = "avx2")]
    #[inline]
    fn transpose4(r: [Wide<__m256d>; 4]) -> [Wide<__m256d>; 4] {
        let (a, b) = (_mm256_unpacklo_pd(r[0].0, r[1].0), _mm256_unpackhi_pd(r[0].0, r[1].0));
        let (c, d) = (_mm256_unpacklo_pd(r[2].0, r[3].0), _mm256_unpackhi_pd(r[2].0, r[3].0));
        [
            Wide(_mm256_permute2f128_pd::<0x20>(a, c)),
            Wide(_mm256_permute2f128_pd::<0x20>(b, d)),
            Wide(_mm256_permute2f128_pd::<0x31>(a, c)),
            Wide(_mm256_permute2f128_pd::<0x31>(b, d)),
        ]
    }

    impl Lanes4 for Wide<__m256d> {
        #[inline(always)]
        fn mask_le(self, max: Self) -> u32 {
            unsafe { _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_LE_OQ>(self.0, max.0)) as u32 }
        }
        #[inline(always)]
        fn load3(v: &[DVec3; 4]) -> Lane3<Self> {
            let [x, y, z] = unsafe { load3(v.as_ptr().cast()) };
            Lane3 { x: Wide(x), y: Wide(y), z: Wide(z) }
        }
        #[inline(always)]
        fn store3(v: Lane3<Self>, to: &mut [DVec3; 4]) {
            unsafe { store3([v.x.0, v.y.0, v.z.0], to.as_mut_ptr().cast()) }
        }
        #[inline(always)]
        fn load2(v: &[[f64; 2]; 4]) -> [Self; 2] {
            let [a, b] = unsafe { load2(v.as_ptr().cast()) };
            [Wide(a), Wide(b)]
        }
        #[inline(always)]
        fn twists(t: [&Twist; 4]) -> [Lane3<Self>; 2] {
            unsafe { twists(t) }
        }
        #[inline(always)]
        fn to_twists(v: Lane3<Self>, w: Lane3<Self>) -> [Twist; 4] {
            unsafe { to_twists(v, w) }
        }
    }

    /// Load twelve consecutive values as the components of four vectors.
    #[target_feature(enable = "avx2")]
    #[inline]
    unsafe fn load3(v: *const f64) -> [__m256d; 3] {
        // x₀ y₀ z₀ x₁ | y₁ z₁ x₂ y₂ | z₂ x₃ y₃ z₃
        let (r, s, t) = unsafe { (_mm256_loadu_pd(v), _mm256_loadu_pd(v.add(4)), _mm256_loadu_pd(v.add(8))) };
        let a = _mm256_blend_pd::<0b1100>(r, s);
        let b = _mm256_permute2f128_pd::<0x21>(r, t);
        let c = _mm256_blend_pd::<0b1100>(s, t);
        [_mm256_shuffle_pd::<0b1010>(a, b), _mm256_shuffle_pd::<0b0101>(a, c), _mm256_shuffle_pd::<0b1010>(b, c)]
    }

    /// The inverse of the function before.
    #[target_feature(enable = "avx2")]
    #[inline]
    unsafe fn store3([x, y, z]: [__m256d; 3], to: *mut f64) {
        let (a, c) = (_mm256_unpacklo_pd(x, y), _mm256_unpackhi_pd(y, z));
        let b = _mm256_shuffle_pd::<0b1010>(z, x);
        unsafe {
            _mm256_storeu_pd(to, _mm256_permute2f128_pd::<0x20>(a, b));
            _mm256_storeu_pd(to.add(4), _mm256_blend_pd::<0b1100>(c, a));
            _mm256_storeu_pd(to.add(8), _mm256_permute2f128_pd::<0x31>(b, c));
        }
    }

    /// Load eight consecutive values as four pairs.
    #[target_feature(enable = "avx2")]
    #[inline]
    unsafe fn load2(v: *const f64) -> [__m256d; 2] {
        let (r, s) = unsafe { (_mm256_loadu_pd(v), _mm256_loadu_pd(v.add(4))) };
        let (p, q) = (_mm256_permute2f128_pd::<0x20>(r, s), _mm256_permute2f128_pd::<0x31>(r, s));
        [_mm256_unpacklo_pd(p, q), _mm256_unpackhi_pd(p, q)]
    }

    /// Load the six components of four twists.
    #[target_feature(enable = "avx2")]
    #[inline]
    unsafe fn twists(t: [&Twist; 4]) -> [Lane3<Wide<__m256d>>; 2] {
        let mut first = [Wide(_mm256_setzero_pd()); 4];
        let mut rest = [_mm_setzero_pd(); 4];
        for i in 0..4 {
            let numbers: *const f64 = (t[i] as *const Twist).cast();
            first[i].0 = unsafe { _mm256_loadu_pd(numbers) };
            rest[i] = unsafe { _mm_loadu_pd(numbers.add(4)) };
        }
        let [vx, vy, vz, wx] = transpose4(first);
        let (p, q) = (_mm256_set_m128d(rest[2], rest[0]), _mm256_set_m128d(rest[3], rest[1]));
        let (wy, wz) = (Wide(_mm256_unpacklo_pd(p, q)), Wide(_mm256_unpackhi_pd(p, q)));
        [Lane3 { x: vx, y: vy, z: vz }, Lane3 { x: wx, y: wy, z: wz }]
    }

    /// The inverse of the function before.
    #[target_feature(enable = "avx2")]
    #[inline]
    unsafe fn to_twists(v: Lane3<Wide<__m256d>>, w: Lane3<Wide<__m256d>>) -> [Twist; 4] {
        let first = transpose4([v.x, v.y, v.z, w.x]);
        // y₀ z₀ y₂ z₂ | y₁ z₁ y₃ z₃
        let (p, q) = (_mm256_unpacklo_pd(w.y.0, w.z.0), _mm256_unpackhi_pd(w.y.0, w.z.0));
        let rest = [
            _mm256_castpd256_pd128(p),
            _mm256_castpd256_pd128(q),
            _mm256_extractf128_pd::<1>(p),
            _mm256_extractf128_pd::<1>(q),
        ];
        let mut out = [Twist::default(); 4];
        for i in 0..4 {
            let numbers: *mut f64 = (&raw mut out[i]).cast();
            unsafe {
                _mm256_storeu_pd(numbers, first[i].0);
                _mm_storeu_pd(numbers.add(4), rest[i]);
            }
        }
        out
    }
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
    let (zero, one) = (V::splat(T::of(0.0)), V::splat(T::of(1.0)));
    let normal = y.dot(n);
    let tangent = y.minus(n.times(normal));
    let t = tangent.dot(tangent).sqrt();
    let reach = t * mu;
    let kept = reach.select_le(zero - normal, zero, (reach + normal) / (mu * mu + one));
    let scale = t.select_le(zero, zero, mu * kept / t);
    let limit = mu * normal;
    // Without friction and tangent a negative normal passes the test of the cone, 0 ≤ −0.
    let pushing = zero.select_le(normal, normal, zero);
    n.times(t.select_le(limit, pushing, kept)).plus(tangent.times(t.select_le(limit, one, scale)))
}

#[cfg(all(test, target_arch = "x86_64"))]
mod tests;
