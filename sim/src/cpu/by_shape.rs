//! Rows that belong to pairs of shapes, found by the two shapes.

use gpu::radix_sort::distribute_cpu;

/// Rows of pairs of shapes, each in the lists of both.
#[derive(Default)]
pub struct ByShape<T> {
    /// First row of each shape, and the end (n_shapes + 1).
    start: Vec<u32>,
    /// The other shape of each row, and the row.
    rows: Vec<(u32, T)>,
}

impl<T: Copy + Default + Send> ByShape<T> {
    /// List `n` rows, given with their shapes, of which there are `n_shapes`.
    pub fn of(n_shapes: usize, n: usize, row: impl Fn(usize) -> ([u32; 2], T) + Sync) -> ByShape<T> {
        let side = |k: usize| {
            let (shapes, row) = row(k / 2);
            (shapes[k % 2], (shapes[1 - k % 2], row))
        };
        let (mut start, mut rows) = (vec![], vec![]);
        distribute_cpu(n_shapes, || (0..2 * n).map(side), &mut start, &mut rows);
        ByShape { start, rows }
    }

    /// The rows of two different shapes, in their order: from the list of the shape that has fewer.
    pub fn find(&self, [a, b]: [u32; 2]) -> impl Iterator<Item = &T> {
        let of = |s: u32| match self.start.get(s as usize..s as usize + 2) {
            Some(ends) => &self.rows[ends[0] as usize..ends[1] as usize],
            None => &[],
        };
        let (of_a, of_b) = (of(a), of(b));
        let (rows, other) = if of_a.len() < of_b.len() { (of_a, b) } else { (of_b, a) };
        rows.iter().filter(move |(known, _)| *known == other).map(|(_, row)| row)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_found_by_both_shapes_in_their_order() {
        let pairs = [[0, 1], [0, 2], [1, 0], [0, 3], [2, 1]];
        let known = ByShape::of(5, pairs.len(), |i| (pairs[i], i as u32));
        let of = |pair| known.find(pair).copied().collect::<Vec<u32>>();
        assert_eq!([of([0, 1]), of([1, 0])], [vec![0, 2], vec![0, 2]]);
        assert_eq!([of([3, 0]), of([3, 1]), of([4, 0])], [vec![3], vec![], vec![]]);
        assert_eq!(ByShape::<u32>::default().find([0, 1]).count(), 0);
    }
}
