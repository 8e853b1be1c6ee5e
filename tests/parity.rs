//! GPU kernels against their CPU twins. Without any adapter they say so; `REQUIRE_GPU=1` makes that a failure.

use gpu::Device;
use gpu::radix_sort::{RadixSort, sort_cpu};
use gpu::scan::{Scan, exclusive_cpu};

/// A device for a test, the software one if need be.
fn device() -> Option<Device> {
    match Device::open(true) {
        Ok(device) => Some(device),
        Err(error) if std::env::var_os("REQUIRE_GPU").is_some() => panic!("REQUIRE_GPU is set, but {error}"),
        Err(error) => {
            eprintln!("skipped: {error}");
            None
        }
    }
}

/// Repeatable numbers below `bound`.
fn numbers(n: usize, bound: u32) -> Vec<u32> {
    let mut state = 12345u64;
    let mut next = || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 33) as u32 % bound
    };
    (0..n).map(|_| next()).collect()
}

#[test]
fn scan_on_the_gpu_is_its_twin() {
    let Some(device) = device() else { return };
    let scan = Scan::new(&device);
    for n in [1, 2, 1023, 1024, 1025, 70_000, 1_200_000] {
        let mut expected = numbers(n, 100);
        let buffer = device.upload(&expected);
        scan.exclusive(&device, &buffer, n);
        exclusive_cpu(&mut expected);
        assert_eq!(device.download::<u32>(&buffer, n).unwrap(), expected, "n = {n}");
    }
}

#[test]
fn radix_sort_on_the_gpu_is_its_twin() {
    let Some(device) = device() else { return };
    let sort = RadixSort::new(&device);
    for (n, bound) in [(1, 5), (1000, 16), (1025, 300), (100_000, 70_000), (200_000, u32::MAX)] {
        let mut keys = numbers(n, bound);
        let mut values: Vec<u32> = (0..n as u32).collect();
        let (k, v) = sort.sort(&device, device.upload(&keys), device.upload(&values), n, bound - 1);
        sort_cpu(&mut keys, &mut values, bound - 1);
        assert!(keys.is_sorted());
        assert_eq!(device.download::<u32>(&k, n).unwrap(), keys, "n = {n}");
        assert_eq!(device.download::<u32>(&v, n).unwrap(), values, "the sort is stable, n = {n}");
    }
}
