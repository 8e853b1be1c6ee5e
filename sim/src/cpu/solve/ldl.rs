//! Sparse LDLᵀ factorisation of a symmetric positive definite matrix, up-looking (Davis 2005): row k of L solves a triangular
//! system with the rows before it, along paths of the elimination tree. The sparsity pattern is analysed once.

/// A factorisation and its sparsity pattern.
#[derive(Clone, Debug, Default)]
pub struct Ldl {
    /// Position of each row in the elimination order (n).
    place: Vec<u32>,
    /// Entries of the upper triangle in elimination order: column starts (n + 1), rows, and values.
    start: Vec<u32>,
    row: Vec<u32>,
    value: Vec<f64>,
    /// The elimination tree (n), u32::MAX for a root.
    parent: Vec<u32>,
    /// L by columns: starts (n + 1), rows, values; and D.
    l_start: Vec<u32>,
    l_row: Vec<u32>,
    l_value: Vec<f64>,
    d: Vec<f64>,
    scratch: Vec<f64>,
}

impl Ldl {
    /// Analyse a sparsity pattern: `entries` are the pairs (i, j), each once, i ≤ j, with the diagonal; `group` has the group of each row,
    /// and rows of a group are eliminated together. Returns also the slot of each entry for [`Ldl::add`].
    pub fn analyse(n: usize, entries: &[[u32; 2]], group: &[u32]) -> (Ldl, Vec<u32>) {
        let place = order(n, entries, group);
        let mut list: Vec<([u32; 2], usize)> = entries
            .iter()
            .enumerate()
            .map(|(k, [i, j])| {
                let (p, q) = (place[*i as usize], place[*j as usize]);
                ([p.max(q), p.min(q)], k)
            })
            .collect();
        list.sort_unstable();
        let mut ldl = Ldl { place, start: vec![0; n + 1], ..Ldl::default() };
        let mut slot = vec![0; entries.len()];
        for (s, ([column, row], k)) in list.iter().enumerate() {
            ldl.start[*column as usize + 1] = s as u32 + 1;
            ldl.row.push(*row);
            slot[*k] = s as u32;
        }
        (1..=n).for_each(|k| ldl.start[k] = ldl.start[k].max(ldl.start[k - 1]));
        ldl.value = vec![0.0; list.len()];
        ldl.symbolic(n);
        (ldl, slot)
    }

    /// Elimination tree, and the positions of L's entries.
    fn symbolic(&mut self, n: usize) {
        const NONE: u32 = u32::MAX;
        self.parent = vec![NONE; n];
        let mut flag = vec![NONE; n];
        let mut count = vec![0u32; n];
        for k in 0..n {
            flag[k] = k as u32;
            for p in self.start[k] as usize..self.start[k + 1] as usize {
                let mut i = self.row[p] as usize;
                while flag[i] != k as u32 {
                    if self.parent[i] == NONE {
                        self.parent[i] = k as u32;
                    }
                    count[i] += 1;
                    flag[i] = k as u32;
                    i = self.parent[i] as usize;
                }
            }
        }
        self.l_start = vec![0; n + 1];
        for k in 0..n {
            self.l_start[k + 1] = self.l_start[k] + count[k];
        }
        let filled = self.l_start[n] as usize;
        (self.l_row, self.l_value, self.d) = (vec![0; filled], vec![0.0; filled], vec![0.0; n]);
        self.scratch = vec![0.0; n];
    }

    /// Number of entries of L.
    #[cfg(test)]
    fn filled(&self) -> usize {
        self.l_row.len()
    }

    /// Set all entries to zero.
    pub fn clear(&mut self) {
        self.value.fill(0.0);
    }

    /// Add to the entry of a slot.
    #[inline]
    pub fn add(&mut self, slot: u32, value: f64) {
        self.value[slot as usize] += value;
    }

    /// Factorise. Pivots below `min_pivot` (redundant rows) are raised to it.
    pub fn factorise(&mut self, min_pivot: f64) {
        let n = self.d.len();
        let mut used = vec![0u32; n];
        let mut flag = vec![u32::MAX; n];
        let (mut pattern, mut path) = (vec![0usize; n], vec![0usize; n]);
        let mut y = vec![0.0; n];
        for k in 0..n {
            // The pattern of row k of L: all of the tree above the entries of column k, in topological order.
            let mut top = n;
            flag[k] = k as u32;
            for p in self.start[k] as usize..self.start[k + 1] as usize {
                let mut i = self.row[p] as usize;
                y[i] += self.value[p];
                let mut length = 0;
                while flag[i] != k as u32 {
                    path[length] = i;
                    length += 1;
                    flag[i] = k as u32;
                    i = self.parent[i] as usize;
                }
                while length > 0 {
                    (top, length) = (top - 1, length - 1);
                    pattern[top] = path[length];
                }
            }
            let mut d = std::mem::take(&mut y[k]);
            for &i in &pattern[top..] {
                let yi = std::mem::take(&mut y[i]);
                let range = self.l_start[i] as usize..(self.l_start[i] + used[i]) as usize;
                for p in range {
                    y[self.l_row[p] as usize] -= self.l_value[p] * yi;
                }
                let l = yi / self.d[i];
                d -= l * yi;
                let p = (self.l_start[i] + used[i]) as usize;
                (self.l_row[p], self.l_value[p]) = (k as u32, l);
                used[i] += 1;
            }
            self.d[k] = d.max(min_pivot);
        }
    }

    /// Solve for a right-hand side, in place.
    pub fn solve(&mut self, b: &mut [f64]) {
        let x = &mut self.scratch;
        for (i, p) in self.place.iter().enumerate() {
            x[*p as usize] = b[i];
        }
        let column = |k: usize| self.l_start[k] as usize..self.l_start[k + 1] as usize;
        for k in 0..x.len() {
            let xk = x[k];
            for p in column(k) {
                x[self.l_row[p] as usize] -= self.l_value[p] * xk;
            }
        }
        for k in (0..x.len()).rev() {
            let mut sum = x[k] / self.d[k];
            for p in column(k) {
                sum -= self.l_value[p] * x[self.l_row[p] as usize];
            }
            x[k] = sum;
        }
        for (i, p) in self.place.iter().enumerate() {
            b[i] = x[*p as usize];
        }
    }
}

/// A minimum-degree elimination order of groups of rows. Returns each row's position.
fn order(n: usize, entries: &[[u32; 2]], group: &[u32]) -> Vec<u32> {
    let n_groups = group.iter().map(|g| *g as usize + 1).max().unwrap_or(0);
    let mut near: Vec<std::collections::BTreeSet<u32>> = vec![Default::default(); n_groups];
    for [i, j] in entries {
        let (g, h) = (group[*i as usize], group[*j as usize]);
        if g != h {
            near[g as usize].insert(h);
            near[h as usize].insert(g);
        }
    }
    let mut open: std::collections::BTreeSet<(usize, u32)> =
        near.iter().enumerate().map(|(g, s)| (s.len(), g as u32)).collect();
    let mut rank = vec![0u32; n_groups];
    let mut next = 0;
    while let Some((_, g)) = open.pop_first() {
        rank[g as usize] = next;
        next += 1;
        let around: Vec<u32> = std::mem::take(&mut near[g as usize]).into_iter().collect();
        for &h in &around {
            open.remove(&(near[h as usize].len(), h));
            near[h as usize].remove(&g);
            near[h as usize].extend(around.iter().filter(|k| **k != h));
            open.insert((near[h as usize].len(), h));
        }
    }
    let mut rows: Vec<u32> = (0..n as u32).collect();
    rows.sort_by_key(|i| (rank[group[*i as usize] as usize], *i));
    let mut place = vec![0; n];
    rows.iter().enumerate().for_each(|(p, i)| place[*i as usize] = p as u32);
    place
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SplitMix64;

    #[test]
    fn a_ring_with_a_hub_is_solved() {
        // Rows 0..n form a ring, row n touches all of them.
        let n = 40u32;
        let mut entries: Vec<[u32; 2]> = (0..=n).map(|i| [i, i]).collect();
        entries.extend((0..n - 1).map(|i| [i, i + 1]));
        entries.push([0, n - 1]);
        entries.extend((0..n).map(|i| [i, n]));
        let group: Vec<u32> = (0..=n).collect();
        let (mut ldl, slots) = Ldl::analyse(n as usize + 1, &entries, &group);
        let mut random = SplitMix64(5);
        let values: Vec<f64> =
            entries.iter().map(|[i, j]| if i == j { 60.0 } else { random.between(-1.0, 1.0) }).collect();
        slots.iter().zip(&values).for_each(|(s, v)| ldl.add(*s, *v));
        ldl.factorise(0.0);
        let x: Vec<f64> = (0..=n).map(|i| i as f64 - 7.0).collect();
        let mut b = vec![0.0; n as usize + 1];
        for ([i, j], v) in entries.iter().zip(&values) {
            b[*i as usize] += v * x[*j as usize];
            if i != j {
                b[*j as usize] += v * x[*i as usize];
            }
        }
        ldl.solve(&mut b);
        assert!(b.iter().zip(&x).all(|(p, q)| (p - q).abs() < 1e-11));
        assert!(ldl.filled() < 3 * n as usize, "the hub goes last: {} entries", ldl.filled());
    }
}
