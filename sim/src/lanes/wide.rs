//! Lanes in vector registers of AVX2 and AVX-512.

// SAFETY, here and below: AVX2 or AVX-512 is there (see `Wide`), and loads and stores are of as many numbers as a register holds.
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

/// What registers of every width do alike: fill, load, store, square root.
macro_rules! alike {
    ([$T:ty; $L:literal], $splat:ident, $load:ident, $store:ident, $sqrt:ident) => {
        #[inline(always)]
        fn splat(x: $T) -> Self {
            Wide(unsafe { $splat(x) })
        }
        #[inline(always)]
        fn load(v: &[$T; $L]) -> Self {
            Wide(unsafe { $load(v.as_ptr()) })
        }
        #[inline(always)]
        fn to_array(self) -> [$T; $L] {
            let mut out = [0.0; $L];
            unsafe { $store(out.as_mut_ptr(), self.0) };
            out
        }
        #[inline(always)]
        fn sqrt(self) -> Self {
            Wide(unsafe { $sqrt(self.0) })
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
    alike!([f32; 8], _mm256_set1_ps, _mm256_loadu_ps, _mm256_storeu_ps, _mm256_sqrt_ps);
    #[inline(always)]
    fn select_le(self, max: Self, yes: Self, no: Self) -> Self {
        Wide(unsafe { _mm256_blendv_ps(no.0, yes.0, _mm256_cmp_ps::<_CMP_LE_OQ>(self.0, max.0)) })
    }
    #[inline(always)]
    fn columns(rows: &[[f32; 8]; 8]) -> [Self; 8] {
        let [a, b, c, d, e, f, g, h] = rows;
        let rows = [Self::load(a), Self::load(b), Self::load(c), Self::load(d)];
        unsafe {
            transpose([rows[0], rows[1], rows[2], rows[3], Self::load(e), Self::load(f), Self::load(g), Self::load(h)])
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

operator!(__m512, Add, add, _mm512_add_ps);
operator!(__m512, Sub, sub, _mm512_sub_ps);
operator!(__m512, Mul, mul, _mm512_mul_ps);
operator!(__m512, Div, div, _mm512_div_ps);

impl Lanes<f32, 16> for Wide<__m512> {
    alike!([f32; 16], _mm512_set1_ps, _mm512_loadu_ps, _mm512_storeu_ps, _mm512_sqrt_ps);
    #[inline(always)]
    fn select_le(self, max: Self, yes: Self, no: Self) -> Self {
        Wide(unsafe { _mm512_mask_blend_ps(_mm512_cmp_ps_mask::<_CMP_LE_OQ>(self.0, max.0), no.0, yes.0) })
    }
    #[inline(always)]
    fn columns(rows: &[[f32; 8]; 16]) -> [Self; 8] {
        let (low, high) = halves(rows);
        let (low, high) = (Wide::<__m256>::columns(low), Wide::<__m256>::columns(high));
        std::array::from_fn(|c| Wide(unsafe { together(low[c].0, high[c].0) }))
    }
    #[inline(always)]
    fn rows(columns: [Self; 8]) -> [[f32; 8]; 16] {
        let [low, high] = unsafe { [columns.map(|c| low_half(c.0)), columns.map(|c| high_half(c.0))] };
        joined([Wide::<__m256>::rows(low.map(Wide)), Wide::<__m256>::rows(high.map(Wide))])
    }
}

#[target_feature(enable = "avx512f")]
#[inline]
fn together(low: __m256, high: __m256) -> __m512 {
    let low = _mm512_castpd256_pd512(_mm256_castps_pd(low));
    _mm512_castpd_ps(_mm512_insertf64x4::<1>(low, _mm256_castps_pd(high)))
}

#[target_feature(enable = "avx512f")]
#[inline]
fn low_half(v: __m512) -> __m256 {
    _mm512_castps512_ps256(v)
}

#[target_feature(enable = "avx512f")]
#[inline]
fn high_half(v: __m512) -> __m256 {
    _mm256_castpd_ps(_mm512_extractf64x4_pd::<1>(_mm512_castps_pd(v)))
}

impl Lanes<f64, 4> for Wide<__m256d> {
    alike!([f64; 4], _mm256_set1_pd, _mm256_loadu_pd, _mm256_storeu_pd, _mm256_sqrt_pd);
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
