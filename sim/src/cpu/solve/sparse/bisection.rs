//! Bisection of a graph: two sides of about equal weight with few edges between them. A graph is made coarser by matching along heavy
//! edges; the coarsest one is divided by growing a side, and the division is refined on the way back.
//! Source: Karypis and Kumar, *A fast and high quality multilevel scheme for partitioning irregular graphs* (1998); Fiduccia and
//! Mattheyses, *A linear-time heuristic for improving network partitions* (1982). The same graph gives the same division.

use crate::fill::SplitMix64;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// A graph in compressed rows, with weights.
#[derive(Default)]
pub struct Graph {
    /// First neighbour of each vertex (n + 1).
    pub start: Vec<u32>,
    /// Neighbours, and the weights of the edges to them.
    pub near: Vec<[u32; 2]>,
    /// Weights of the vertices (n).
    pub weight: Vec<u32>,
}

/// Vertices up to which a graph is divided as it is.
const COARSEST: usize = 48;
/// Divisions of the coarsest graph that are tried.
const TRIES: usize = 3;
/// Passes of the refinement, and moves without gain after which a pass ends.
const PASSES: usize = 4;
const STALLED: usize = 20;

impl Graph {
    /// Number of vertices.
    pub fn len(&self) -> usize {
        self.weight.len()
    }

    /// Neighbours of a vertex, and the weights of the edges to them.
    pub fn around(&self, v: usize) -> &[[u32; 2]] {
        &self.near[self.start[v] as usize..self.start[v + 1] as usize]
    }

    /// The side of each vertex. Of two vertices and more, no side is empty.
    pub fn bisect(&self) -> Vec<bool> {
        if self.len() > COARSEST {
            let (coarse, merged) = self.coarsened();
            // Stars hardly become smaller.
            if coarse.len() * 10 < self.len() * 9 {
                let sides = coarse.bisect();
                let mut side: Vec<bool> = merged.iter().map(|m| sides[*m as usize]).collect();
                self.refine(&mut side);
                return side;
            }
        }
        let n = self.len();
        let tries = if n <= 8 { 2 } else { TRIES.min(n) };
        let grown = (0..tries).map(|k| {
            let mut side = self.grown(k * n / tries);
            let cut = self.refine(&mut side);
            (cut, side)
        });
        grown.min_by_key(|(cut, _)| *cut).map(|(_, side)| side).unwrap_or_default()
    }

    /// The graph of matched pairs of vertices, and the vertex of it that each one went to.
    fn coarsened(&self) -> (Graph, Vec<u32>) {
        const NONE: u32 = u32::MAX;
        let n = self.len();
        let mut order: Vec<u32> = (0..n as u32).collect();
        let mut random = SplitMix64(n as u64);
        (1..n).rev().for_each(|i| order.swap(i, random.below(i + 1)));
        let mut merged = vec![NONE; n];
        let mut pairs: Vec<[u32; 2]> = Vec::with_capacity(n / 2 + 1);
        for v in order {
            if merged[v as usize] != NONE {
                continue;
            }
            let free = self.around(v as usize).iter().filter(|[w, _]| merged[*w as usize] == NONE && *w != v);
            // The heaviest edge, to the lightest vertex.
            let best = free.max_by_key(|[w, weight]| (*weight, Reverse((self.weight[*w as usize], *w))));
            let mate = best.map_or(v, |[w, _]| *w);
            merged[v as usize] = pairs.len() as u32;
            merged[mate as usize] = pairs.len() as u32;
            pairs.push([v, mate]);
        }
        let mut coarse = Graph { start: vec![0], ..Graph::default() };
        let mut slot = vec![NONE; pairs.len()];
        for (c, [v, mate]) in pairs.iter().enumerate() {
            let first = coarse.near.len();
            let both = if v == mate { &[*v][..] } else { &[*v, *mate][..] };
            for [w, weight] in both.iter().flat_map(|v| self.around(*v as usize)) {
                let w = merged[*w as usize];
                if w as usize == c {
                    continue;
                }
                match slot[w as usize] {
                    s if s != NONE && s as usize >= first => coarse.near[s as usize][1] += weight,
                    _ => {
                        slot[w as usize] = coarse.near.len() as u32;
                        coarse.near.push([w, *weight]);
                    }
                }
            }
            coarse.start.push(coarse.near.len() as u32);
            coarse.weight.push(both.iter().map(|v| self.weight[*v as usize]).sum());
        }
        (coarse, merged)
    }

    /// Half of the graph: what is grown from a vertex, by the vertices that add least to the edges cut.
    fn grown(&self, seed: usize) -> Vec<bool> {
        let n = self.len();
        let mut side = vec![false; n];
        let mut gain: Vec<i64> = (0..n).map(|v| -self.around(v).iter().map(|e| e[1] as i64).sum::<i64>()).collect();
        let half = self.weight.iter().sum::<u32>() / 2;
        let (mut grown, mut next) = (0, 0);
        let mut open = BinaryHeap::from([(gain[seed], Reverse(seed as u32))]);
        while grown < half {
            let Some((g, Reverse(v))) = open.pop() else {
                // The next component.
                while next < n && side[next] {
                    next += 1;
                }
                open.push((gain[next], Reverse(next as u32)));
                continue;
            };
            let v = v as usize;
            if side[v] || g != gain[v] {
                continue;
            }
            side[v] = true;
            grown += self.weight[v];
            for [w, weight] in self.around(v) {
                gain[*w as usize] += 2 * *weight as i64;
                if !side[*w as usize] {
                    open.push((gain[*w as usize], Reverse(*w)));
                }
            }
        }
        side
    }

    /// Move vertices to the other side as long as the cut becomes smaller or the sides more equal. Returns how bad the division is.
    fn refine(&self, side: &mut [bool]) -> (bool, i64, i64) {
        let total: i64 = self.weight.iter().map(|w| *w as i64).sum();
        let heaviest = self.weight.iter().max().map_or(0, |w| *w as i64);
        let max = (total * 11 / 20).max(total / 2 + heaviest.min(total / 8) + 1).min(total - 1);
        let mut sums = [0i64; 2];
        side.iter().zip(&self.weight).for_each(|(s, w)| sums[*s as usize] += *w as i64);
        let mut cut: i64 = (0..self.len())
            .map(|v| {
                self.around(v).iter().filter(|[w, _]| side[*w as usize] != side[v]).map(|e| e[1] as i64).sum::<i64>()
            })
            .sum::<i64>()
            / 2;
        let badness = |cut: i64, sums: [i64; 2]| (sums[0].max(sums[1]) > max, cut, sums[0].max(sums[1]));
        for _ in 0..PASSES {
            let before = badness(cut, sums);
            self.pass(side, &mut sums, &mut cut, max);
            if badness(cut, sums) >= before {
                break;
            }
        }
        badness(cut, sums)
    }

    /// One pass: every vertex moves once at most, the best first; what came after the best division is taken back.
    fn pass(&self, side: &mut [bool], sums: &mut [i64; 2], cut: &mut i64, max: i64) {
        let n = self.len();
        let mut gain = vec![0i64; n];
        let mut open: [BinaryHeap<(i64, Reverse<u32>)>; 2] = Default::default();
        for v in 0..n {
            let mut is_inside = true;
            for [w, weight] in self.around(v) {
                let is_cut = side[*w as usize] != side[v];
                gain[v] += if is_cut { *weight as i64 } else { -(*weight as i64) };
                is_inside &= !is_cut;
            }
            if !is_inside || n <= COARSEST {
                open[side[v] as usize].push((gain[v], Reverse(v as u32)));
            }
        }
        let mut moved = vec![false; n];
        let mut moves: Vec<u32> = vec![];
        let badness = |cut: i64, sums: [i64; 2]| (sums[0].max(sums[1]) > max, cut, sums[0].max(sums[1]));
        let (mut best, mut n_best) = (badness(*cut, *sums), 0);
        while moves.len() < n_best + STALLED {
            // Drop what has moved or has another gain by now.
            for (s, heap) in open.iter_mut().enumerate() {
                while heap.peek().is_some_and(|(g, Reverse(v))| {
                    let v = *v as usize;
                    moved[v] || *g != gain[v] || side[v] as usize != s
                }) {
                    heap.pop();
                }
            }
            let top = |s: usize| open[s].peek().map(|(g, v)| (*g, *v));
            let can = |s: usize, v: u32| sums[1 - s] + self.weight[v as usize] as i64 <= max || sums[s] > max;
            let from = [0, 1].into_iter().filter(|s| sums[1 - *s] <= max);
            let Some((_, s)) =
                from.filter_map(|s| top(s).filter(|(_, v)| can(s, v.0)).map(|(g, _)| ((g, sums[s]), s))).max()
            else {
                break;
            };
            let v = open[s].pop().expect("it was seen").1.0;
            moved[v as usize] = true;
            self.switch(v as usize, side, sums);
            *cut -= gain[v as usize];
            moves.push(v);
            for [w, weight] in self.around(v as usize) {
                let w = *w as usize;
                gain[w] += if side[w] == side[v as usize] { -2 * *weight as i64 } else { 2 * *weight as i64 };
                if !moved[w] {
                    open[side[w] as usize].push((gain[w], Reverse(w as u32)));
                }
            }
            let now = badness(*cut, *sums);
            if now < best {
                (best, n_best) = (now, moves.len());
            }
        }
        for v in moves.drain(n_best..) {
            self.switch(v as usize, side, sums);
        }
        *cut = best.1;
    }

    fn switch(&self, v: usize, side: &mut [bool], sums: &mut [i64; 2]) {
        sums[side[v] as usize] -= self.weight[v] as i64;
        side[v] = !side[v];
        sums[side[v] as usize] += self.weight[v] as i64;
    }
}
