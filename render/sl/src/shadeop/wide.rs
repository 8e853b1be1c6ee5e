//! Loops over points, compiled twice: for any processor, and for those with AVX2. Both give the same bits, since neither fuses a product
//! with a sum.
//!
//! A loop is `#[inline(always)]` with all that it calls but functions of the mathematics library, and writes into slices.

/// Whether loops run in wide vector registers: the processor has AVX2, and `SCREE_LANES=plain` is not in the environment (a switch for
/// tests, read once).
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

/// Define a function that runs a loop with the processor's widest registers.
macro_rules! wide {
    ($(#[$doc:meta])* $vis:vis fn $name:ident($($arg:ident: $ty:ty),*) = $points_loop:ident;) => {
        $(#[$doc])*
        $vis fn $name($($arg: $ty),*) {
            #[cfg(target_arch = "x86_64")]
            {
                #[target_feature(enable = "avx2")]
                fn wide($($arg: $ty),*) {
                    $points_loop($($arg),*)
                }
                if $crate::shadeop::wide::has_wide_lanes() {
                    // SAFETY: the processor has AVX2.
                    return unsafe { wide($($arg),*) };
                }
            }
            $points_loop($($arg),*)
        }
    };
}

pub(crate) use wide;
