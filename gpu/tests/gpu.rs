//! The tests of devices and kernels: every kernel against its CPU twin. Without any adapter they say so; `REQUIRE_GPU=1` makes that a
//! failure.

mod device;
mod layout;
mod primitives;

use gpu::{Choice, Device, Kernels};
use std::sync::OnceLock;

/// A device, with the kernels compiled for it.
struct Bench {
    device: Device,
    kernels: Kernels,
}

fn open(has_subgroups: bool) -> Option<Bench> {
    match Device::open(&Choice::Any) {
        Ok(device) => {
            let device = if has_subgroups { device } else { device.without_subgroups() };
            Some(Bench { device, kernels: Kernels::default() })
        }
        Err(error) if std::env::var_os("REQUIRE_GPU").is_some() => panic!("REQUIRE_GPU is set, but {error}"),
        Err(error) => {
            eprintln!("skipped: {error}");
            None
        }
    }
}

/// The device as it is, and as one without subgroup operations; none without an adapter.
fn benches() -> impl Iterator<Item = &'static Bench> {
    static BENCHES: OnceLock<Vec<Bench>> = OnceLock::new();
    BENCHES.get_or_init(|| [true, false].into_iter().filter_map(open).collect()).iter()
}

/// Repeatable numbers below `bound`.
fn numbers(n: usize, bound: u64) -> Vec<u64> {
    let mut state = 12345 + n as u64;
    let mut next = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state ^ state >> 29).wrapping_mul(0x9e37_79b9_7f4a_7c15) % bound
    };
    (0..n).map(|_| next()).collect()
}
