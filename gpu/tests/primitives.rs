//! Scan, sort, reductions and compaction on the device, each against its CPU twin, with counts of the host and counts on the device.

use crate::{Bench, benches, numbers};
use gpu::compact::{Compact, compact_cpu};
use gpu::radix_sort::{Key, RadixSort, sort_cpu};
use gpu::reduce::{Combine, Reduce, reduce_cpu};
use gpu::scan::{Scan, exclusive_cpu};
use gpu::segments::{SegmentSum, sums_cpu};
use gpu::{Buffer, Commands, Count};

/// Sizes about the ends of blocks, subgroups and levels.
const SIZES: [usize; 11] = [0, 1, 2, 255, 256, 257, 1025, 4097, 65_535, 65_537, 1_000_000];

/// The count `n` in both forms: known to the host, and on the device, where the host knows a larger bound alone.
fn counts(bench: &Bench, n: usize) -> [Count; 2] {
    let found = Count::found(&bench.device, n + n / 3 + 5).unwrap();
    found.n.write(&bench.device, &[n as u32]);
    [Count::of(&bench.device, n).unwrap(), found]
}

/// Run what is recorded for each device, size and form of the count.
fn for_all(sizes: &[usize], test: impl Fn(&Bench, usize, &Count)) {
    for bench in benches() {
        for n in sizes {
            counts(bench, *n).iter().for_each(|count| test(bench, *n, count));
        }
    }
}

fn submit(bench: &Bench, record: impl FnOnce(&mut Commands)) {
    let mut commands = Commands::new();
    record(&mut commands);
    commands.submit(&bench.device).unwrap().wait(&bench.device).unwrap();
}

#[test]
fn scan_is_its_twin() {
    for_all(&SIZES, |bench @ Bench { device, kernels }, n, count| {
        let scan = Scan::new(device, kernels, count.capacity).unwrap();
        let mut expected: Vec<u32> = numbers(n, 100).iter().map(|x| *x as u32).collect();
        let values = Buffer::of(device, "values", &expected).unwrap();
        submit(bench, |commands| scan.record(device, commands, &values, count));
        exclusive_cpu(&mut expected);
        assert!(values.read(device, n).unwrap() == expected, "n = {n}");
    });
}

/// Sort keys below a bound, and sorted, reversed and equal ones.
fn sort<K: Key + Ord>(bound: u64, key: impl Fn(u64) -> K) {
    for_all(&SIZES, |bench @ Bench { device, kernels }, n, count| {
        let sort = RadixSort::<K>::new(device, kernels, count.capacity).unwrap();
        let random = numbers(n, bound);
        let ascending: Vec<u64> = (0..n as u64).map(|k| k % bound).collect();
        let descending: Vec<u64> = ascending.iter().rev().copied().collect();
        let equal = vec![bound - 1; n];
        let orders = if n > 100_000 { vec![random] } else { vec![random, ascending, descending, equal] };
        for order in orders {
            let mut keys: Vec<K> = order.into_iter().map(&key).collect();
            let mut values: Vec<u32> = (0..n as u32).collect();
            let (k, v) = (Buffer::of(device, "keys", &keys).unwrap(), Buffer::of(device, "values", &values).unwrap());
            let max_key = key(bound - 1);
            // Buffers with room for as many as there might be.
            let room = |commands: &mut Commands| {
                let (k, v) = (grown(bench, &k, count.capacity), grown(bench, &v, count.capacity));
                sort.record(device, commands, (&k, &v), count, max_key);
                (k, v)
            };
            let mut commands = Commands::new();
            let (k, v) = room(&mut commands);
            commands.submit(device).unwrap();
            sort_cpu(&mut keys, &mut values, max_key);
            assert!(keys.is_sorted());
            assert!(k.read(device, n).unwrap() == keys, "keys, n = {n}");
            assert!(v.read(device, n).unwrap() == values, "the sort is stable, n = {n}");
        }
    });
}

fn grown<T: gpu::layout::bytemuck::Pod>(bench: &Bench, buffer: &Buffer<T>, n: usize) -> Buffer<T> {
    let mut buffer = buffer.clone();
    buffer.reserve(&bench.device, n).unwrap();
    buffer
}

#[test]
fn sort_by_32_bits_is_its_twin() {
    sort(1 << 32, |x| x as u32);
}

#[test]
fn sort_by_few_bits_is_its_twin() {
    sort(5, |x| x as u32);
    sort(70_000, |x| x as u32);
}

#[test]
fn sort_by_64_bits_is_its_twin() {
    sort(1 << 45, |x| x);
}

#[test]
fn reductions_are_their_twins_bit_for_bit() {
    for combine in [Combine::Sum, Combine::Max] {
        for_all(&SIZES, |bench @ Bench { device, kernels }, n, count| {
            let values: Vec<f32> = numbers(n, 1 << 40).iter().map(|x| *x as f32 * 1e-9 - 300.0).collect();
            let reduce = Reduce::new(device, kernels, combine, count.capacity).unwrap();
            let column = grown(bench, &Buffer::of(device, "values", &values).unwrap(), count.capacity);
            let result = Buffer::of(device, "result", &[1.5]).unwrap();
            submit(bench, |commands| reduce.record(device, commands, &column, count, &result));
            let found = result.read(device, 1).unwrap()[0];
            assert_eq!(found.to_bits(), reduce_cpu(combine, &values).to_bits(), "n = {n}");
        });
    }
}

#[test]
fn a_sum_in_the_order_of_a_tree_is_near_that_of_double_precision() {
    let values: Vec<f32> = numbers(1_000_000, 1 << 20).iter().map(|x| *x as f32 * 1e-6).collect();
    let exact: f64 = values.iter().map(|x| *x as f64).sum();
    assert!((reduce_cpu(Combine::Sum, &values) as f64 / exact - 1.0).abs() < 1e-6);
}

#[test]
fn segmented_sums_are_their_twin_bit_for_bit() {
    for_all(&[0, 1, 2, 255, 256, 257, 65_537], |bench @ Bench { device, kernels }, n, count| {
        // Empty segments, short ones, and now and then one of thousands of values.
        let length = |x: &u64| match x % 97 {
            0 => x % 5_000,
            1..20 => 0,
            _ => x % 70,
        };
        let mut start: Vec<u32> = numbers(n, 1 << 30).iter().map(|x| length(x) as u32).chain([0]).collect();
        let n_values = exclusive_cpu(&mut start) as usize;
        let values: Vec<f32> = numbers(n_values, 1 << 20).iter().map(|x| *x as f32 * 1e-3 - 500.0).collect();
        let segments = SegmentSum::new(device, kernels, count.capacity).unwrap();
        let starts = Buffer::of(device, "starts", &start).unwrap();
        let (column, sums) =
            (Buffer::of(device, "values", &values).unwrap(), Buffer::zeros(device, "sums", count.capacity).unwrap());
        submit(bench, |commands| segments.record(device, commands, [&column, &sums], &starts, count));
        let bits = |sums: Vec<f32>| sums.into_iter().map(f32::to_bits).collect::<Vec<u32>>();
        assert!(bits(sums.read(device, n).unwrap()) == bits(sums_cpu(&values, &start)), "n = {n}");
    });
}

#[test]
fn a_segment_of_a_million_values_is_summed() {
    let values: Vec<f32> = numbers(1_000_000, 1 << 20).iter().map(|x| *x as f32 * 1e-3).collect();
    let start = [0, 0, 1_000_000];
    for bench @ Bench { device, kernels } in benches() {
        let count = Count::of(device, 2).unwrap();
        let segments = SegmentSum::new(device, kernels, 2).unwrap();
        let starts = Buffer::of(device, "starts", &start).unwrap();
        let (column, sums) =
            (Buffer::of(device, "values", &values).unwrap(), Buffer::zeros(device, "sums", 2).unwrap());
        submit(bench, |commands| segments.record(device, commands, [&column, &sums], &starts, &count));
        assert_eq!(sums.read(device, 2).unwrap(), sums_cpu(&values, &start));
    }
}

#[test]
fn compaction_is_its_twin_and_its_count_feeds_what_follows() {
    for_all(&SIZES, |bench @ Bench { device, kernels }, n, count| {
        let flags: Vec<u32> = numbers(n, 3).iter().map(|x| *x as u32).collect();
        let compact = Compact::new(device, kernels, count.capacity).unwrap();
        let reduce = Scan::new(device, kernels, count.capacity).unwrap();
        let column = Buffer::of(device, "flags", &flags).unwrap();
        let ids = Buffer::zeros(device, "ids", count.capacity).unwrap();
        let n_kept = Count::found(device, count.capacity).unwrap();
        let sums = Buffer::zeros(device, "sums", count.capacity).unwrap();
        submit(bench, |commands| {
            compact.record(device, commands, &column, count, &ids, &n_kept);
            commands.copy(&ids, &sums, count.capacity);
            // As many as were found, which the host does not know.
            reduce.record(device, commands, &sums, &n_kept);
        });
        let mut expected = compact_cpu(&flags);
        assert_eq!(n_kept.read(device).unwrap(), expected.len(), "n = {n}");
        assert!(ids.read(device, expected.len()).unwrap() == expected, "n = {n}");
        expected.iter_mut().for_each(|id| *id %= 1 << 20);
        exclusive_cpu(&mut expected);
        assert!(
            sums.read(device, expected.len()).unwrap()[..expected.len().min(2000)]
                == expected[..expected.len().min(2000)],
            "n = {n}"
        );
    });
}
