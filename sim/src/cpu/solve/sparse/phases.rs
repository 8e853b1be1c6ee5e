//! A solve with a factor as sums of products, for machines that do many rows at once. With W = F₂₁ F₁₁⁻¹ of each supernode,
//! b′ = b − Σ W b′ over the supernodes below, by ascending heights; then x = F₁₁⁻¹ b′ − Wᵀ x over the border, by descending heights. A
//! phase is the rows of a height: none of them needs another.
//!
//! The terms follow from the structure alone, and name their numbers by place: these are made again after each factorisation.

use super::supernodes::{Node, Structure, TILE};

/// The terms of a solve. Rows of b′ are numbered from 0, those of x from `n_rows` on.
#[derive(Clone, Debug, Default)]
pub struct Phases {
    /// Number of rows of the factor.
    pub n_rows: usize,
    /// First row of each phase, and the end (n_phases + 1).
    pub start: Vec<u32>,
    /// Row that is found, and its terms: the first, and the end. A row of b′ is added to what is there.
    pub row: Vec<[u32; 3]>,
    /// Row and number whose product a term is.
    pub term: Vec<[u32; 2]>,
}

impl Phases {
    fn push(&mut self, row: usize, terms: impl Iterator<Item = [usize; 2]>) {
        let first = self.term.len() as u32;
        self.term.extend(terms.map(|term| term.map(|i| i as u32)));
        self.row.push([row as u32, first, self.term.len() as u32]);
    }

    fn end_phase(&mut self) {
        if self.start.last().is_some_and(|first| *first < self.row.len() as u32) {
            self.start.push(self.row.len() as u32);
        }
    }
}

/// The phases of a solve.
pub fn phases(structure: &Structure) -> Phases {
    let Structure { nodes, n_rows, .. } = structure;
    let (heights, numbers) = (structure.heights(), structure.first_numbers());
    let mut phases = Phases { n_rows: *n_rows, start: vec![0], ..Phases::default() };
    let mut of_heights: Vec<Vec<usize>> = vec![vec![]; heights.iter().max().map_or(0, |top| top + 1)];
    heights.iter().enumerate().for_each(|(k, height)| of_heights[*height].push(k));
    let below = structure.terms_below(&numbers);
    for of_height in &of_heights {
        for row in of_height.iter().flat_map(|k| nodes[*k].first..nodes[*k].first + nodes[*k].n_own) {
            if !below[row].is_empty() {
                phases.push(row, below[row].iter().copied());
            }
        }
        phases.end_phase();
    }
    for of_height in of_heights.iter().rev() {
        of_height.iter().for_each(|k| structure.push_solution(&mut phases, &nodes[*k], numbers[*k]));
        phases.end_phase();
    }
    phases
}

/// The numbers of the terms, of a factor with these panels: of each supernode F₁₁⁻¹, then −W, by rows.
pub fn numbers(structure: &Structure, panels: &[f64], out: &mut Vec<f32>) {
    out.clear();
    for node in &structure.nodes {
        let (own, n) = (node.own, node.n_own);
        let panel = &panels[node.panel..][..own * (own + node.border)];
        let at = |i: usize, j: usize| panel[i / TILE * own * TILE + j * TILE + i % TILE];
        let inverse = inverse(own, at);
        let sign = if node.is_negative { -1.0 } else { 1.0 };
        let product =
            |i: usize, j: usize| (i.max(j)..own).map(|k| inverse[k * own + i] * inverse[k * own + j]).sum::<f64>();
        out.extend((0..n * n).map(|e| (sign * product(e / n, e % n)) as f32));
        let border = |i: usize, j: usize| (j..own).map(|k| at(own + i, k) * inverse[k * own + j]).sum::<f64>();
        out.extend((0..node.rows.len() * n).map(|e| -border(e / n, e % n) as f32));
    }
}

impl Structure {
    /// Heights of the supernodes over those without any below.
    fn heights(&self) -> Vec<usize> {
        let mut heights = vec![0; self.nodes.len()];
        for (k, node) in self.nodes.iter().enumerate() {
            let of_children = self.children[node.children.clone()].iter().map(|c| heights[*c as usize] + 1);
            heights[k] = of_children.max().unwrap_or(0);
        }
        heights
    }

    /// The terms of each row of b′: of the supernodes that have it in their borders.
    fn terms_below(&self, numbers: &[usize]) -> Vec<Vec<[usize; 2]>> {
        let mut below = vec![vec![]; self.n_rows];
        for (node, first) in self.nodes.iter().zip(numbers) {
            for (i, row) in self.border[node.rows.clone()].iter().enumerate() {
                let number = |j: usize| first + (node.n_own + i) * node.n_own + j;
                below[*row as usize].extend((0..node.n_own).map(|j| [node.first + j, number(j)]));
            }
        }
        below
    }

    /// First number of each supernode.
    fn first_numbers(&self) -> Vec<usize> {
        let mut next = 0;
        let of = |node: &Node| {
            next += node.n_own * (node.n_own + node.rows.len());
            next - node.n_own * (node.n_own + node.rows.len())
        };
        self.nodes.iter().map(of).collect()
    }

    /// The rows of x of a supernode whose numbers begin at `first`.
    fn push_solution(&self, phases: &mut Phases, node: &Node, first: usize) {
        let (n, n_rows) = (node.n_own, self.n_rows);
        let border = &self.border[node.rows.clone()];
        for j in 0..n {
            let own = (0..n).map(|i| [node.first + i, first + j * n + i]);
            let above = border.iter().enumerate().map(|(i, row)| [n_rows + *row as usize, first + (n + i) * n + j]);
            phases.push(n_rows + node.first + j, own.chain(above));
        }
    }
}

/// The inverse of the lower triangle of a panel, by rows, of which the tiles on the diagonal are inverses already.
fn inverse(own: usize, at: impl Fn(usize, usize) -> f64) -> Vec<f64> {
    let mut inverse = vec![0.0; own * own];
    for j in 0..own {
        for tile in (j / TILE * TILE..own).step_by(TILE) {
            let rest: [f64; TILE] = std::array::from_fn(|l| {
                let i = tile + l;
                let done = (j / TILE * TILE..tile).map(|k| at(i, k) * inverse[k * own + j]).sum::<f64>();
                if i == j { 1.0 - done } else { -done }
            });
            for l in 0..TILE {
                inverse[(tile + l) * own + j] = (0..=l).map(|m| at(tile + l, tile + m) * rest[m]).sum();
            }
        }
    }
    inverse
}
