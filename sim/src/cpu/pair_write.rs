//! Write every pair of shapes whose boxes overlap, once: the bin that holds the midpoint of the overlap claims it.
//! in   bin, shape [n_pairs]     sorted by bin
//!      bin_start  [n_active]    first and last-but-one pair of each active bin
//!      aabb       [n_shapes]    m, world
//! out  candidate  [n_candidates]  pairs of shapes, the lower index first, in the order of the bins
//! Source: paper §3, stages 7–9, count, scan and write.

use super::bin_emit::BinGrid;
use super::{Aabb, fill_rows, scatter_rows};
use crate::{Model, ShapeKind};

/// The stage. `count` is scratch.
#[allow(clippy::too_many_arguments)]
pub fn run(
    model: &Model,
    aabb: &[Aabb],
    grid: &BinGrid,
    bin: &[u32],
    shape: &[u32],
    bin_start: &[[u32; 2]],
    count: &mut Vec<u32>,
    candidate: &mut Vec<[u32; 2]>,
) {
    let planes: Vec<u32> =
        (0..model.n_shapes() as u32).filter(|s| model.shape_kind[*s as usize] == ShapeKind::Plane).collect();
    // Rows: the active bins, then one row a shape for the planes that it meets.
    let n_bins = bin_start.len();
    let n_rows = n_bins + if planes.is_empty() { 0 } else { model.n_shapes() };
    let visit = |row: usize, found: &mut dyn FnMut([u32; 2])| match row.checked_sub(n_bins) {
        None => in_bin(model, aabb, grid, bin, shape, bin_start[row], found),
        Some(s) => planes.iter().filter(|p| may_meet(model, s as u32, **p)).for_each(|&p| found(ordered(s as u32, p))),
    };
    count.clear();
    count.resize(n_rows + 1, 0);
    fill_rows(&mut count[..n_rows], |row| {
        let mut n = 0;
        visit(row, &mut |_| n += 1);
        n
    });
    let n = gpu::scan::exclusive_cpu(count) as usize;
    candidate.resize(n, [0; 2]);
    scatter_rows(candidate, count, |row, out| {
        let mut slot = out.iter_mut();
        visit(row, &mut |pair| *slot.next().expect("counted before") = pair);
    });
}

/// The pairs that a bin claims.
#[inline]
fn in_bin(
    model: &Model,
    aabb: &[Aabb],
    grid: &BinGrid,
    bin: &[u32],
    shape: &[u32],
    [first, end]: [u32; 2],
    found: &mut dyn FnMut([u32; 2]),
) {
    let here = bin[first as usize];
    let members = &shape[first as usize..end as usize];
    for (i, &s) in members.iter().enumerate() {
        let a = &aabb[s as usize];
        for &t in &members[i + 1..] {
            let b = &aabb[t as usize];
            if a.overlaps(b) && may_meet(model, s, t) {
                let midpoint = 0.5 * (a.min.max(b.min) + a.max.min(b.max));
                if grid.index(grid.bin_of(midpoint)) == here {
                    found(ordered(s, t));
                }
            }
        }
    }
}

/// Whether two shapes may touch at all: not of one body, and not both held in place.
#[inline]
fn may_meet(model: &Model, s: u32, t: u32) -> bool {
    let (a, b) = (model.shape_body[s as usize], model.shape_body[t as usize]);
    a != b && (model.inv_mass[a as usize] > 0.0 || model.inv_mass[b as usize] > 0.0)
}

fn ordered(s: u32, t: u32) -> [u32; 2] {
    [s.min(t), s.max(t)]
}
