//! SIMD lanes: eight numbers at once, for loops over samples: AVX2 where the processor has it, plain arrays elsewhere. Both give the same bits.
//!
//! A lanes loop is a function generic over [`Lanes`], `#[inline(always)]` down to here and without closures, which would be compiled
//! for plain processors; [`with_lanes!`] calls it for the processor at hand.

use std::ops::{Add, Div, Mul, Sub};

/// Numbers of a register.
pub const LANES: usize = 8;

/// Eight numbers, or eight answers: all bits set where something holds.
pub trait Lanes: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> {
    /// One number in all lanes.
    fn splat(x: f32) -> Self;
    /// Those of a column from `k` on; columns are padded to whole lanes.
    fn load(v: &[f32], k: usize) -> Self;
    /// Put them there.
    fn store(self, v: &mut [f32], k: usize);
    /// As an array.
    fn to_array(self) -> [f32; LANES];
    /// Where they are less than others.
    fn lt(self, o: Self) -> Self;
    /// Where they are greater or equal.
    fn ge(self, o: Self) -> Self;
    /// Where they differ.
    fn ne(self, o: Self) -> Self;
    /// Where both hold.
    fn and(self, o: Self) -> Self;
    /// Where either holds.
    fn or(self, o: Self) -> Self;
    /// Where the answers hold, `a`, else `b`.
    fn select(self, a: Self, b: Self) -> Self;
    /// With the other sign where `o` is negative.
    fn xor_sign(self, o: Self) -> Self;
    /// The answers as bits.
    fn bits(self) -> u32;
    /// Where the answers hold, put one of two ids into a column from `k` on: the second where `second` holds.
    fn store_id(self, second: Self, names: [u32; 2], v: &mut [u32], k: usize);

    /// Where they are not below one number nor above another.
    #[inline(always)]
    fn between(self, low: f32, high: f32) -> Self {
        self.ge(Self::splat(low)).and(Self::splat(high).ge(self))
    }

    /// −x
    #[inline(always)]
    fn negated(self) -> Self {
        self.xor_sign(Self::splat(-0.0))
    }

    /// The minimum.
    #[inline(always)]
    fn min(self, o: Self) -> Self {
        o.lt(self).select(o, self)
    }

    /// The maximum.
    #[inline(always)]
    fn max(self, o: Self) -> Self {
        self.lt(o).select(o, self)
    }
}

/// Lanes as an array.
#[derive(Clone, Copy)]
pub struct Plain([f32; LANES]);

impl Plain {
    #[inline(always)]
    fn with(self, o: Plain, f: impl Fn(f32, f32) -> f32) -> Plain {
        let mut out = self.0;
        out.iter_mut().zip(o.0).for_each(|(a, b)| *a = f(*a, b));
        Plain(out)
    }

    #[inline(always)]
    fn by_bits(self, o: Plain, f: impl Fn(u32, u32) -> u32) -> Plain {
        self.with(o, |a, b| f32::from_bits(f(a.to_bits(), b.to_bits())))
    }

    #[inline(always)]
    fn where_both(self, o: Plain, f: impl Fn(f32, f32) -> bool) -> Plain {
        self.with(o, |a, b| f32::from_bits(if f(a, b) { u32::MAX } else { 0 }))
    }
}

impl Add for Plain {
    type Output = Plain;
    #[inline(always)]
    fn add(self, o: Plain) -> Plain {
        self.with(o, |a, b| a + b)
    }
}

impl Sub for Plain {
    type Output = Plain;
    #[inline(always)]
    fn sub(self, o: Plain) -> Plain {
        self.with(o, |a, b| a - b)
    }
}

impl Mul for Plain {
    type Output = Plain;
    #[inline(always)]
    fn mul(self, o: Plain) -> Plain {
        self.with(o, |a, b| a * b)
    }
}

impl Div for Plain {
    type Output = Plain;
    #[inline(always)]
    fn div(self, o: Plain) -> Plain {
        self.with(o, |a, b| a / b)
    }
}

impl Lanes for Plain {
    #[inline(always)]
    fn splat(x: f32) -> Plain {
        Plain([x; LANES])
    }
    #[inline(always)]
    fn load(v: &[f32], k: usize) -> Plain {
        Plain(v[k..k + LANES].try_into().expect("columns are padded"))
    }
    #[inline(always)]
    fn store(self, v: &mut [f32], k: usize) {
        v[k..k + LANES].copy_from_slice(&self.0);
    }
    #[inline(always)]
    fn to_array(self) -> [f32; LANES] {
        self.0
    }
    #[inline(always)]
    fn lt(self, o: Plain) -> Plain {
        self.where_both(o, |a, b| a < b)
    }
    #[inline(always)]
    fn ge(self, o: Plain) -> Plain {
        self.where_both(o, |a, b| a >= b)
    }
    #[inline(always)]
    fn ne(self, o: Plain) -> Plain {
        self.where_both(o, |a, b| a != b)
    }
    #[inline(always)]
    fn and(self, o: Plain) -> Plain {
        self.by_bits(o, |a, b| a & b)
    }
    #[inline(always)]
    fn or(self, o: Plain) -> Plain {
        self.by_bits(o, |a, b| a | b)
    }
    #[inline(always)]
    fn select(self, a: Plain, b: Plain) -> Plain {
        let (a, b) = (self.by_bits(a, |m, a| m & a), self.by_bits(b, |m, b| !m & b));
        a.or(b)
    }
    #[inline(always)]
    fn xor_sign(self, o: Plain) -> Plain {
        self.by_bits(o, |a, b| a ^ (b & 0x8000_0000))
    }
    #[inline(always)]
    fn bits(self) -> u32 {
        self.0.iter().enumerate().fold(0, |bits, (i, m)| bits | (m.to_bits() >> 31) << i)
    }
    #[inline(always)]
    fn store_id(self, second: Plain, names: [u32; 2], v: &mut [u32], k: usize) {
        for (i, v) in v[k..k + LANES].iter_mut().enumerate().filter(|(i, _)| self.0[*i].to_bits() != 0) {
            *v = names[(second.0[i].to_bits() != 0) as usize];
        }
    }
}

#[cfg(target_arch = "x86_64")]
pub use wide::Wide;

#[cfg(target_arch = "x86_64")]
mod wide {
    use super::{LANES, Lanes};
    use std::arch::x86_64::*;
    use std::ops::{Add, Div, Mul, Sub};

    /// Lanes as a vector register of AVX2. `with_lanes!` alone makes loops over it, where the processor has that: this is what
    /// makes every `unsafe` below sound. Loads and stores go through slices of the right length.
    #[derive(Clone, Copy)]
    pub struct Wide(__m256);

    impl Add for Wide {
        type Output = Wide;
        #[inline(always)]
        fn add(self, o: Wide) -> Wide {
            Wide(unsafe { _mm256_add_ps(self.0, o.0) })
        }
    }

    impl Sub for Wide {
        type Output = Wide;
        #[inline(always)]
        fn sub(self, o: Wide) -> Wide {
            Wide(unsafe { _mm256_sub_ps(self.0, o.0) })
        }
    }

    impl Mul for Wide {
        type Output = Wide;
        #[inline(always)]
        fn mul(self, o: Wide) -> Wide {
            Wide(unsafe { _mm256_mul_ps(self.0, o.0) })
        }
    }

    impl Div for Wide {
        type Output = Wide;
        #[inline(always)]
        fn div(self, o: Wide) -> Wide {
            Wide(unsafe { _mm256_div_ps(self.0, o.0) })
        }
    }

    impl Lanes for Wide {
        #[inline(always)]
        fn splat(x: f32) -> Wide {
            Wide(unsafe { _mm256_set1_ps(x) })
        }
        #[inline(always)]
        fn load(v: &[f32], k: usize) -> Wide {
            Wide(unsafe { _mm256_loadu_ps(v[k..k + LANES].as_ptr()) })
        }
        #[inline(always)]
        fn store(self, v: &mut [f32], k: usize) {
            unsafe { _mm256_storeu_ps(v[k..k + LANES].as_mut_ptr(), self.0) }
        }
        #[inline(always)]
        fn to_array(self) -> [f32; LANES] {
            let mut out = [0.0; LANES];
            self.store(&mut out, 0);
            out
        }
        #[inline(always)]
        fn lt(self, o: Wide) -> Wide {
            Wide(unsafe { _mm256_cmp_ps::<_CMP_LT_OQ>(self.0, o.0) })
        }
        #[inline(always)]
        fn ge(self, o: Wide) -> Wide {
            Wide(unsafe { _mm256_cmp_ps::<_CMP_GE_OQ>(self.0, o.0) })
        }
        #[inline(always)]
        fn ne(self, o: Wide) -> Wide {
            Wide(unsafe { _mm256_cmp_ps::<_CMP_NEQ_UQ>(self.0, o.0) })
        }
        #[inline(always)]
        fn and(self, o: Wide) -> Wide {
            Wide(unsafe { _mm256_and_ps(self.0, o.0) })
        }
        #[inline(always)]
        fn or(self, o: Wide) -> Wide {
            Wide(unsafe { _mm256_or_ps(self.0, o.0) })
        }
        #[inline(always)]
        fn select(self, a: Wide, b: Wide) -> Wide {
            Wide(unsafe { _mm256_blendv_ps(b.0, a.0, self.0) })
        }
        #[inline(always)]
        fn xor_sign(self, o: Wide) -> Wide {
            Wide(unsafe { _mm256_xor_ps(self.0, _mm256_and_ps(o.0, _mm256_set1_ps(-0.0))) })
        }
        #[inline(always)]
        fn bits(self) -> u32 {
            unsafe { _mm256_movemask_ps(self.0) as u32 }
        }
        #[inline(always)]
        fn store_id(self, second: Wide, names: [u32; 2], v: &mut [u32], k: usize) {
            let v = &mut v[k..k + LANES];
            unsafe {
                let (a, b) = (_mm256_set1_epi32(names[0] as i32), _mm256_set1_epi32(names[1] as i32));
                let old = _mm256_castsi256_ps(_mm256_loadu_si256(v.as_ptr().cast()));
                let new = _mm256_blendv_ps(_mm256_castsi256_ps(a), _mm256_castsi256_ps(b), second.0);
                _mm256_storeu_si256(v.as_mut_ptr().cast(), _mm256_castps_si256(_mm256_blendv_ps(old, new, self.0)));
            }
        }
    }
}

/// Define a method that runs a lanes loop, generic over [`Lanes`] and `#[inline(always)]`, with the processor's widest.
macro_rules! with_lanes {
    ($(#[$doc:meta])* $vis:vis fn $name:ident = $lanes_loop:ident ($($arg:ident: $ty:ty),*) -> $out:ty) => {
        $(#[$doc])*
        $vis fn $name(&mut self, $($arg: $ty),*) -> $out {
            #[cfg(target_arch = "x86_64")]
            {
                #[target_feature(enable = "avx2")]
                unsafe fn wide(own: &mut Samples, $($arg: $ty),*) -> $out {
                    own.$lanes_loop::<$crate::cpu::lanes::Wide>($($arg),*)
                }
                if sl::has_wide_lanes() {
                    // SAFETY: the processor has AVX2.
                    return unsafe { wide(self, $($arg),*) };
                }
            }
            self.$lanes_loop::<$crate::cpu::lanes::Plain>($($arg),*)
        }
    };
}

pub(crate) use with_lanes;

#[cfg(test)]
mod tests {
    use super::*;

    /// What a lanes loop might do with numbers that are awkward: the bits of every step.
    #[inline(always)]
    fn mixed<L: Lanes>(a: &[f32], b: &[f32]) -> Vec<u32> {
        let (x, y) = (L::load(a, 0), L::load(b, 0));
        let second = x.lt(y);
        let mut names = vec![7; LANES];
        second.or(x.ne(x)).store_id(y.ge(L::splat(0.0)), [1, 2], &mut names, 0);
        let all = [
            x + y,
            x - y,
            x * y,
            x / y,
            x.min(y),
            x.max(y),
            second.select(x, y),
            x.xor_sign(y),
            x.negated(),
            second.and(x.ge(y)),
        ];
        let numbers = all.into_iter().flat_map(|v| v.to_array().map(|x| if x.is_nan() { 1 } else { x.to_bits() }));
        numbers.chain([second.bits()]).chain(names).collect()
    }

    #[test]
    #[cfg(target_arch = "x86_64")]
    fn wide_lanes_give_the_bits_of_plain_ones() {
        #[target_feature(enable = "avx2")]
        unsafe fn wide(a: &[f32], b: &[f32]) -> Vec<u32> {
            mixed::<Wide>(a, b)
        }
        if std::arch::is_x86_feature_detected!("avx2") {
            let a = [0.0, -0.0, 1.5, f32::INFINITY, f32::NAN, -3.25, 1e-40, 7.0];
            let b = [-0.0, 2.0, 1.5, -1.0, 1.0, f32::NAN, -1e-40, f32::NEG_INFINITY];
            // SAFETY: the processor has AVX2.
            assert_eq!(unsafe { wide(&a, &b) }, mixed::<Plain>(&a, &b));
        }
    }
}
