//! Sparse Cholesky factorisation S = L Σ Lᵀ of a symmetric matrix of groups of rows, positive definite but for groups whose pivots are
//! known to be negative (a quasidefinite matrix; Σ has their signs): nested dissection, then supernodes
//! in dense fronts along the elimination tree. The structure is analysed once; fronts that do not depend on each other are eliminated
//! in parallel, each in the same order of operations whatever the number of threads.
//! Source: Duff and Reid, *The multifrontal solution of indefinite sparse symmetric linear equations* (1983).

mod bisection;
mod front;
mod order;
mod phases;
mod supernodes;

use crate::lanes::{LaneLoop, Lanes4, widest};
use crate::rows::cut;
use rayon::prelude::*;
use std::ops::Range;
use supernodes::{Node, TILE};

pub use order::{dissection, order};
pub use phases::Phases;
pub use supernodes::Structure;

/// Work of a tree whose supernodes are eliminated one after the other, multiplications.
const TREE: u64 = 1 << 21;

/// A factorisation and its structure.
#[derive(Clone, Debug, Default)]
pub struct Factor {
    structure: Structure,
    /// Supernodes that are eliminated at the same time: trees, then the supernodes above them, by levels.
    levels: Vec<Vec<Range<usize>>>,
    panels: Vec<f64>,
    updates: Vec<f64>,
    scratch: Vec<f64>,
    /// What is added to the diagonal (n_rows).
    diagonal: Vec<f64>,
    /// Rows of a right-hand side (n_rows), and scratch of a solve.
    x: Vec<f64>,
    at_border: Vec<f64>,
    sums: Vec<[f64; TILE]>,
}

/// A front while elements are added to it.
pub struct Front<'a> {
    panel: &'a mut [f64],
    update: &'a mut [f64],
    own: usize,
    border: usize,
}

/// Row i of a front, up to the diagonal.
pub struct FrontRow<'a> {
    own: usize,
    panel: &'a mut [f64],
    update: &'a mut [f64],
}

impl FrontRow<'_> {
    /// Add to the entry in column j, which is not above the diagonal.
    #[inline(always)]
    pub fn add(&mut self, j: usize, value: f64) {
        if j < self.own {
            self.panel[j * TILE] += value;
        } else {
            self.update[(j - self.own) * TILE] += value;
        }
    }
}

impl Front<'_> {
    /// Row i.
    #[inline(always)]
    pub fn row(&mut self, i: usize) -> FrontRow<'_> {
        let own = self.own;
        let panel = &mut self.panel[i / TILE * own * TILE + i % TILE..];
        let update = match i.checked_sub(own) {
            Some(i) => &mut self.update[i / TILE * self.border * TILE + i % TILE..],
            None => &mut [],
        };
        FrontRow { own, panel, update }
    }
}

impl Factor {
    /// A factorisation of the given structure.
    pub fn new(structure: Structure) -> Factor {
        let levels = levels(&structure);
        let max = |of: fn(&Node) -> usize| structure.nodes.iter().map(of).max().unwrap_or(0);
        Factor {
            levels,
            panels: vec![0.0; structure.n_factor],
            updates: vec![0.0; structure.n_updates],
            diagonal: vec![0.0; structure.n_rows],
            x: vec![0.0; structure.n_rows],
            scratch: vec![],
            at_border: vec![0.0; max(|n| n.border)],
            sums: vec![[0.0; TILE]; max(|n| n.own)],
            structure,
        }
    }

    /// First row of each group among the rows of [`Factor::rows`].
    pub fn first(&self) -> &[u32] {
        &self.structure.first
    }

    /// Numbers of the factor, those that are zero included.
    pub fn n_numbers(&self) -> usize {
        self.panels.len()
    }

    /// Multiplications of a factorisation.
    pub fn work(&self) -> u64 {
        let roots = self.structure.nodes.iter().filter(|n| n.rows.is_empty());
        roots.map(|n| n.work).sum()
    }

    /// The pivots of the rows of [`Factor::rows`]: what the rows before a row leave of its diagonal.
    pub fn pivots(&self) -> Vec<f64> {
        let mut pivots = vec![0.0; self.structure.n_rows];
        for node in &self.structure.nodes {
            let panel = &self.panels[node.panel..];
            // The tiles on the diagonal are inverses of those of L.
            let reciprocal = |i: usize| panel[(i / TILE * node.own + i) * TILE + i % TILE];
            (0..node.own).for_each(|i| pivots[node.first + i] = reciprocal(i).powi(-2));
        }
        pivots
    }

    /// The phases of a solve.
    pub fn phases(&self) -> Phases {
        phases::phases(&self.structure)
    }

    /// The numbers of the phases' terms.
    pub fn numbers(&self, out: &mut Vec<f32>) {
        phases::numbers(&self.structure, &self.panels, out);
    }

    /// What is added to the diagonal of S, by the rows of [`Factor::rows`].
    pub fn diagonal(&mut self) -> &mut [f64] {
        &mut self.diagonal
    }

    /// Factorise. `fill` adds an element's part of S to a front: the element, and the first rows there of its groups, ascending. Pivots below
    /// `min_pivot` are raised to it.
    pub fn factorise(&mut self, min_pivot: f64, fill: impl Fn(&mut Front, usize, &[u32]) + Sync) {
        let (structure, diagonal) = (&self.structure, &self.diagonal[..]);
        let eliminate = |nodes: Range<usize>, panels: &mut [f64], updates: &mut [f64], scratch: &mut Vec<f64>| {
            let first = (structure.nodes[nodes.start].panel, structure.nodes[nodes.start].update);
            for k in nodes {
                structure.eliminate(k, (panels, updates), first, scratch, (diagonal, min_pivot), &fill);
            }
        };
        for level in &self.levels {
            if let [nodes] = &level[..] {
                let panels = &mut self.panels[structure.panels(nodes)];
                let updates = &mut self.updates[structure.updates(nodes)];
                eliminate(nodes.clone(), panels, updates, &mut self.scratch);
                continue;
            }
            let panels = pieces(&mut self.panels, level.iter().map(|nodes| structure.panels(nodes)));
            let updates = pieces(&mut self.updates, level.iter().map(|nodes| structure.updates(nodes)));
            let tasks: Vec<_> = level.iter().zip(panels).zip(updates).collect();
            let eliminate = |((nodes, panels), updates): ((&Range<usize>, _), _)| {
                eliminate(nodes.clone(), panels, updates, &mut vec![]);
            };
            tasks.into_par_iter().for_each(eliminate);
        }
    }

    /// The rows of the right-hand side, and after [`Factor::solve`] of the solution; rows of no group stay zero.
    pub fn rows(&mut self) -> &mut [f64] {
        &mut self.x
    }

    /// Solve for the right-hand side in [`Factor::rows`], in place.
    pub fn solve(&mut self) {
        let Factor { structure, panels, x, at_border, sums, .. } = self;
        widest(Solve { structure, panels, x, at_border, sums });
    }
}

impl Structure {
    /// Numbers of the panels of some supernodes.
    fn panels(&self, nodes: &Range<usize>) -> Range<usize> {
        let last = &self.nodes[nodes.end - 1];
        self.nodes[nodes.start].panel..last.panel + last.own * (last.own + last.border)
    }

    /// Numbers of the updates of trees of supernodes, or of one with the trees below it.
    fn updates(&self, nodes: &Range<usize>) -> Range<usize> {
        self.nodes[nodes.start].update..self.nodes[nodes.end - 1].update_end
    }

    /// Eliminate a supernode: its elements, its rows of `diagonal`, and the updates of its children.
    fn eliminate(
        &self,
        k: usize,
        (panels, updates): (&mut [f64], &mut [f64]),
        (first_panel, first_update): (usize, usize),
        scratch: &mut Vec<f64>,
        (diagonal, min_pivot): (&[f64], f64),
        fill: &impl Fn(&mut Front, usize, &[u32]),
    ) {
        let node = &self.nodes[k];
        let (own, border) = (node.own, node.border);
        let panel = &mut panels[node.panel - first_panel..][..own * (own + border)];
        panel.fill(0.0);
        scratch.resize(scratch.len().max(border * border), 0.0);
        let scratch = &mut scratch[..border * border];
        lower_rows(scratch, border).for_each(|row| row.fill(0.0));
        let sign = if node.is_negative { -1.0 } else { 1.0 };
        let mut front = Front { panel, update: scratch, own, border };
        for i in 0..own {
            front.row(i).add(i, if i < node.n_own { diagonal[node.first + i] } else { sign });
        }
        for e in &self.elements[node.elements.clone()] {
            let e = *e as usize;
            fill(&mut front, e, &self.local[self.local_start[e] as usize..self.local_start[e + 1] as usize]);
        }
        for c in &self.children[node.children.clone()] {
            let child = &self.nodes[*c as usize];
            let update = &updates[child.update - first_update..][..child.border * child.border];
            front.add_update(update, child.border, &self.in_parent[child.rows.clone()]);
        }
        let Front { panel, update: scratch, .. } = front;
        let update = &mut updates[node.update - first_update..][..border * border];
        if node.is_negative {
            // −F = L Lᵀ.
            panel.iter_mut().for_each(|x| *x = -*x);
            lower_rows(scratch, border).flatten().for_each(|x| *x = -*x);
        }
        widest(front::Eliminate { panel, update: scratch, own, border, min_pivot });
        if node.is_negative {
            lower_rows(scratch, border).flatten().for_each(|x| *x = -*x);
        }
        lower_rows(update, border).zip(lower_rows(scratch, border)).for_each(|(to, from)| to.copy_from_slice(from));
    }
}

impl Front<'_> {
    /// Add the update of a child, whose rows are `rows` here.
    fn add_update(&mut self, update: &[f64], border: usize, rows: &[u32]) {
        let n_own = rows.partition_point(|r| (*r as usize) < self.own);
        for (t, tile) in rows.chunks(TILE).enumerate() {
            let numbers = &update[t * border * TILE..];
            let first = t * TILE;
            if tile.len() == TILE {
                let of = |width: usize, own: usize| {
                    std::array::from_fn::<usize, { TILE }, _>(|l| {
                        let i = (tile[l] as usize).wrapping_sub(own);
                        (i / TILE).wrapping_mul(width * TILE).wrapping_add(i % TILE)
                    })
                };
                let at = of(self.own, 0);
                for j in 0..first.min(n_own) {
                    let (column, four) = (rows[j] as usize * TILE, &numbers[j * TILE..][..TILE]);
                    for l in 0..TILE {
                        self.panel[at[l] + column] += four[l];
                    }
                }
                if n_own < first {
                    let at = of(self.border, self.own);
                    for j in n_own..first {
                        let (column, four) = ((rows[j] as usize - self.own) * TILE, &numbers[j * TILE..][..TILE]);
                        for l in 0..TILE {
                            self.update[at[l] + column] += four[l];
                        }
                    }
                }
            } else {
                for j in 0..first {
                    for (l, i) in tile.iter().enumerate() {
                        self.row(*i as usize).add(rows[j] as usize, numbers[j * TILE + l]);
                    }
                }
            }
            for j in 0..tile.len() {
                for l in j..tile.len() {
                    self.row(tile[l] as usize).add(tile[j] as usize, numbers[(first + j) * TILE + l]);
                }
            }
        }
    }
}

/// The rows of tiles of a square, up to the diagonal.
fn lower_rows(square: &mut [f64], width: usize) -> impl Iterator<Item = &mut [f64]> {
    square.chunks_exact_mut((width * TILE).max(1)).enumerate().map(|(t, row)| &mut row[..(t + 1) * TILE * TILE])
}

/// Pieces of a column at ascending ranges that do not overlap.
fn pieces(column: &mut [f64], ranges: impl Iterator<Item = Range<usize>>) -> Vec<&mut [f64]> {
    let mut at = 0;
    let mut lengths = vec![];
    for range in ranges {
        lengths.extend([range.start - at, range.len()]);
        at = range.end;
    }
    cut(column, lengths).into_iter().skip(1).step_by(2).collect()
}

/// Supernodes that do not depend on each other: whole trees of little work, those side by side together, then the others by their
/// heights above these.
fn levels(structure: &Structure) -> Vec<Vec<Range<usize>>> {
    let nodes = &structure.nodes;
    let mut levels: Vec<Vec<Range<usize>>> = vec![vec![]];
    let mut height = vec![0usize; nodes.len()];
    let mut covered = nodes.len();
    for k in (0..nodes.len()).rev() {
        if k < covered && nodes[k].work <= TREE {
            levels[0].push(nodes[k].descendants..k + 1);
            covered = nodes[k].descendants;
        }
    }
    let mut trees: Vec<Range<usize>> = vec![];
    let mut work = 0;
    for tree in levels[0].drain(..).rev() {
        work += nodes[tree.end - 1].work;
        match trees.last_mut() {
            Some(last) if last.end == tree.start && work <= TREE => last.end = tree.end,
            _ => {
                work = nodes[tree.end - 1].work;
                trees.push(tree);
            }
        }
    }
    levels[0] = trees;
    for (k, node) in nodes.iter().enumerate() {
        if node.work <= TREE {
            continue;
        }
        let children = &structure.children[node.children.clone()];
        height[k] = 1 + children.iter().map(|c| height[*c as usize]).max().unwrap_or(0);
        if levels.len() == height[k] {
            levels.push(vec![]);
        }
        levels[height[k]].push(k..k + 1);
    }
    levels.retain(|level| !level.is_empty());
    levels
}

/// A solve with the factor.
struct Solve<'a> {
    structure: &'a Structure,
    panels: &'a [f64],
    x: &'a mut [f64],
    at_border: &'a mut [f64],
    sums: &'a mut [[f64; TILE]],
}

impl LaneLoop for Solve<'_> {
    type Out = ();
    #[inline(always)]
    fn run<V: Lanes4>(self) {
        let Solve { structure, panels, x, at_border, sums } = self;
        for node in &structure.nodes {
            let panel = &panels[node.panel..][..node.own * (node.own + node.border)];
            let rows = &structure.border[node.rows.clone()];
            let (own, above) = x[node.first..].split_at_mut(node.own);
            let after = node.first + node.own;
            let change = &mut at_border[..node.border];
            front::forward::<V>(panel, own, change);
            if node.is_negative {
                own.iter_mut().for_each(|x| *x = -*x);
            }
            rows.iter().zip(change).for_each(|(row, change)| above[*row as usize - after] += *change);
        }
        for node in structure.nodes.iter().rev() {
            let panel = &panels[node.panel..][..node.own * (node.own + node.border)];
            let rows = &structure.border[node.rows.clone()];
            let (own, above) = x[node.first..].split_at_mut(node.own);
            let after = node.first + node.own;
            let at_border = &mut at_border[..node.border];
            at_border.iter_mut().zip(rows).for_each(|(x, row)| *x = above[*row as usize - after]);
            at_border[rows.len()..].fill(0.0);
            front::backward::<V>(panel, own, at_border, sums);
        }
    }
}

#[cfg(test)]
mod tests;
