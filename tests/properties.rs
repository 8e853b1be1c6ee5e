//! Properties that hold for any input: scan, sort and compressed rows; tables there and back; the form of the columns of a step.

use crate::analytic::simulation;
use frame::csv::Layout;
use frame::{Column, Frame};
use gpu::radix_sort::{distribute_cpu, sort_cpu};
use gpu::scan::exclusive_cpu;
use proptest::prelude::*;
use std::path::Path;

/// Configuration of `n` cases; failures are printed, not stored.
fn cases(n: u32) -> ProptestConfig {
    ProptestConfig { cases: n, failure_persistence: None, ..ProptestConfig::default() }
}

/// Check compressed rows: starts ascend from 0 to the number of items, and a row has its items in their order.
fn rows_hold(n_rows: usize, start: &[u32], out: &[u32], row_of: &[u32]) -> Result<(), TestCaseError> {
    prop_assert_eq!(start.len(), n_rows + 1);
    prop_assert_eq!((start[0], start[n_rows] as usize, out.len()), (0, row_of.len(), row_of.len()));
    prop_assert!(start.is_sorted());
    for row in 0..n_rows {
        let items = &out[start[row] as usize..start[row + 1] as usize];
        prop_assert!(items.iter().all(|i| row_of[*i as usize] as usize == row), "row {} has another's items", row);
        prop_assert!(items.windows(2).all(|w| w[0] < w[1]), "row {} is out of order", row);
    }
    Ok(())
}

/// Numbers of a column, as their bits.
fn bits(column: &Column) -> Vec<u64> {
    match column {
        Column::F64(v) => v.iter().map(|x| x.to_bits()).collect(),
        Column::F32(v) => v.iter().map(|x| x.to_bits().into()).collect(),
        Column::I64(v) => v.iter().map(|x| *x as u64).collect(),
        Column::Category { codes, .. } => codes.iter().map(|c| (*c).into()).collect(),
    }
}

/// A column of `n` rows, any bits if so asked, else finite numbers.
fn column(n: usize, any_bits: bool) -> BoxedStrategy<Column> {
    let double = any::<u64>().prop_map(f64::from_bits).prop_filter("finite", move |x| any_bits || x.is_finite());
    let single = any::<u32>().prop_map(f32::from_bits).prop_filter("finite", move |x| any_bits || x.is_finite());
    let words = prop::collection::vec("w[ a-zé]{0,6}w", 1..5);
    let category = (prop::collection::vec(any::<prop::sample::Index>(), n), words).prop_map(|(codes, names)| {
        Column::Category { codes: codes.iter().map(|c| c.index(names.len()) as u32).collect(), names }
    });
    prop_oneof![
        prop::collection::vec(double, n).prop_map(Column::F64),
        prop::collection::vec(single, n).prop_map(Column::F32),
        prop::collection::vec(any::<i64>(), n).prop_map(Column::I64),
        category,
    ]
    .boxed()
}

/// A table of some rows; none only where `any_bits`, since CSV without rows is refused.
fn table(any_bits: bool) -> impl Strategy<Value = Frame> {
    let columns = (if any_bits { 0usize } else { 1 }..40)
        .prop_flat_map(move |n| prop::collection::vec((column(n, any_bits), 0usize..3), 2..7));
    let time = (0u32..1_000_000).prop_map(|t| f64::from(t) * 1e-4);
    (any::<u64>(), time, columns).prop_map(|(number, time, columns)| {
        let mut frame = Frame::new(number, time);
        for (k, (column, unit)) in columns.into_iter().enumerate() {
            frame.push(&format!("c_{k}"), ["", "m/s", "kg m²"][unit], column);
        }
        frame
    })
}

proptest! {
    #![proptest_config(cases(64))]

    #[test]
    fn a_scan_is_the_sums_of_what_goes_before(counts in prop::collection::vec(0u32..1000, 0..3000)) {
        let mut start = counts.clone();
        let total = exclusive_cpu(&mut start);
        start.push(total);
        prop_assert_eq!(start[0], 0);
        prop_assert!(start.is_sorted());
        prop_assert!(start.windows(2).zip(&counts).all(|(w, count)| w[1] - w[0] == *count));
    }

    #[test]
    fn a_sort_is_a_stable_permutation(
        keys in prop::collection::vec(any::<u32>(), 0..20_000),
        width in 1u32..=32,
    ) {
        let keys: Vec<u32> = keys.iter().map(|key| key >> (32 - width)).collect();
        let greatest = keys.iter().copied().max().unwrap_or(0);
        let mut expected: Vec<(u32, u32)> = keys.iter().copied().zip(0..).collect();
        expected.sort_by_key(|(key, _)| *key);
        let (mut sorted, mut values) = (keys.clone(), (0..keys.len() as u32).collect::<Vec<_>>());
        sort_cpu(&mut sorted, &mut values, greatest);
        prop_assert!(sorted.into_iter().zip(values).eq(expected));
    }

    #[test]
    fn buckets_are_compressed_rows_for_any_threads(
        n_buckets in 1usize..500,
        n in prop_oneof![0usize..200, 8_000usize..9_000, 20_000usize..21_000],
        salt in any::<u32>(),
        threads in 1usize..6,
    ) {
        let bucket = |i: u32| (i ^ salt).wrapping_mul(0x9e37_79b9) % n_buckets as u32;
        let row_of: Vec<u32> = (0..n as u32).map(bucket).collect();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        // Earlier content of the columns has no effect.
        let (mut start, mut out) = (vec![7; 3], vec![9; 5]);
        pool.install(|| distribute_cpu(n_buckets, || row_of.iter().enumerate().map(|(i, row)| (*row, i as u32)), &mut start, &mut out));
        rows_hold(n_buckets, &start, &out, &row_of)?;
    }

    #[test]
    fn tables_go_through_arrow_and_back(frame in table(true)) {
        let bytes = frame::arrow::encode(&frame);
        let back = frame::arrow::decode(Path::new("t.arrow"), bytes.clone(), 0).unwrap();
        prop_assert_eq!((back.number, back.time, back.rows()), (frame.number, frame.time, frame.rows()));
        for ((f, a), (g, b)) in frame.columns.iter().zip(&back.columns) {
            prop_assert_eq!((f, a.kind(), bits(a)), (g, b.kind(), bits(b)));
            prop_assert!((0..a.len()).all(|row| a.text(row) == b.text(row)));
        }
        prop_assert_eq!(frame::arrow::encode(&back), bytes, "the same table, the same bytes");
    }

    #[test]
    fn an_arrow_file_that_is_cut_is_refused(frame in table(true), at in any::<prop::sample::Index>()) {
        let bytes = frame::arrow::encode(&frame);
        let cut = at.index(bytes.len());
        prop_assert!(frame::arrow::decode(Path::new("t.arrow"), bytes[..cut].to_vec(), 0).is_err());
    }

    #[test]
    fn tables_go_through_csv_and_back(frame in table(false)) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.csv");
        std::fs::write(&path, frame::csv::encode(&frame)).unwrap();
        let back = frame::csv::read(&path, frame.number, &Layout::default()).unwrap();
        prop_assert_eq!((back.rows(), back.number), (frame.rows(), frame.number));
        for ((f, a), (g, b)) in frame.columns.iter().zip(&back.columns) {
            prop_assert_eq!(f, g);
            for row in 0..a.len() {
                match a {
                    Column::Category { .. } => prop_assert_eq!(a.text(row), b.text(row)),
                    // A single number's shortest text is read as a double: it is the same single.
                    Column::F32(v) => prop_assert_eq!(v[row], b.number(row).unwrap() as f32),
                    _ => prop_assert_eq!(a.number(row), b.number(row)),
                }
            }
        }
    }
}

proptest! {
    #![proptest_config(cases(12))]

    #[test]
    fn the_columns_of_a_step_have_their_form(seed in any::<u32>(), spheres in any::<bool>(), rolling in any::<bool>()) {
        let shapes = [
            "sphere: {radius: 0.1}", "box: {size: [0.2, 0.15, 0.1]}", "cylinder: {radius: 0.08, length: 0.2}",
            "capsule: {radius: 0.06, length: 0.15}", "cone: {radius: 0.1, length: 0.2}", "ellipsoid: {radii: [0.12, 0.08, 0.06]}",
        ];
        let rolls = if rolling { ", rolling: 1e-3, spinning: 1e-3" } else { "" };
        let mut yaml = format!(
            "step: 2e-3\nsolver: {{iterations: 20}}\nmaterials: {{m: {{density: 1000, friction: 0.5{rolls}}}}}\nbodies:\n  - {{name: ground, material: m, plane: {{normal: [0, 0, 1]}}}}\n"
        );
        for i in 0..60u32 {
            let kind = if spheres { 0 } else { (seed.wrapping_add(i) % 6) as usize };
            let shift = (seed.wrapping_mul(i + 1) >> 20) as f64 / 4096.0 * 0.04;
            let at = [(i % 5) as f64 * 0.26 + shift, (i / 5 % 4) as f64 * 0.26 - shift, 0.13 + (i / 20) as f64 * 0.26];
            yaml += &format!("  - {{name: b{i}, material: m, {}, position: {at:?}, velocity: [0, 0, -1]}}\n", shapes[kind]);
        }
        let mut sim = simulation(&yaml);
        let mut max = 0;
        for _ in 0..60 {
            let report = sim.checked_step().unwrap();
            let (c, n) = (&sim.state.contacts, sim.state.contacts.len());
            max = max.max(n);
            prop_assert_eq!(report.contacts, n);
            prop_assert_eq!([c.key.len(), c.normal.len(), c.gap.len(), c.law.len(), c.impulse.len()], [n; 5]);
            prop_assert_eq!(c.rolling_impulse.len(), if rolling { n } else { 0 });
            for i in 0..n {
                let [a, b] = c.bodies[i].map(|b| b as usize);
                prop_assert!(a < b && b < sim.model.n_bodies());
                let [s, t, _] = c.key[i].map(|s| s as usize);
                prop_assert_eq!([sim.model.shape_body[s] as usize, sim.model.shape_body[t] as usize], [a, b]);
                prop_assert!((c.normal[i].length() - 1.0).abs() < 1e-6 && c.gap[i].is_finite() && c.impulse[i].is_finite());
                prop_assert!((c.law[i] as usize) < sim.model.laws.len());
                let gamma = c.gamma(i);
                let mu = sim.model.laws[c.law[i] as usize].friction;
                prop_assert!(gamma.y.hypot(gamma.z) <= mu * gamma.x * (1.0 + 1e-9) + 1e-12, "{} is outside its cone", gamma);
                prop_assert!(c.arms(i).iter().all(|arm| arm.is_finite()));
            }
            let mut keys = c.key.clone();
            keys.sort();
            prop_assert!(keys.windows(2).all(|w| w[0] != w[1]), "a contact is there twice");
            prop_assert!(sim.state.position.iter().all(|p| p.is_finite()));
        }
        prop_assert!(max > 20, "{} contacts", max);
    }
}
