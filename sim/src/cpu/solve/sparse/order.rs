//! The order in which groups of rows are eliminated. Bodies and the groups between them are a graph: what hangs on it as a tree is
//! eliminated from its leaves on, without fill; what is left, by nested dissection: the groups between two halves of the bodies come
//! after those within each half.
//! Source: George, *Nested dissection of a regular finite element mesh* (1973).

use super::bisection::Graph;

/// Order groups of rows; `ends` are their bodies below `n_bodies`: one, or two. Returns the groups in the order of elimination.
pub fn order(n_bodies: usize, ends: &[[Option<u32>; 2]]) -> Vec<u32> {
    let mut at = Incidence::of(n_bodies, ends);
    let mut order = at.strip(ends);
    let mut from_end = vec![];
    dissect(&mut at, ends, &mut from_end);
    order.extend(from_end.iter().rev());
    order
}

/// Order bodies, the groups between which couple them, by nested dissection: those of one half that have neighbours in the other come after
/// all others. `ends` are as those of [`order`].
pub fn dissection(n_bodies: usize, ends: &[[Option<u32>; 2]]) -> Vec<u32> {
    /// Bodies that are not divided any more.
    const LEAST: usize = 4;
    let at = Incidence::of(n_bodies, ends);
    let mut number = vec![u32::MAX; n_bodies];
    let mut from_end = Vec::with_capacity(n_bodies);
    let mut parts: Vec<Vec<u32>> = vec![(0..n_bodies as u32).collect()];
    while let Some(part) = parts.pop() {
        if part.len() <= LEAST {
            from_end.extend(part);
            continue;
        }
        let graph = graph_of(&part, &at, ends, &mut number);
        let side = graph.bisect();
        let crosses = |i: usize| graph.around(i).iter().any(|[w, _]| side[*w as usize] != side[i]);
        let border = |of: bool| (0..part.len()).filter(|i| side[*i] == of && crosses(*i)).count();
        let of = border(true) < border(false);
        let mut halves = [vec![], vec![]];
        for (i, b) in part.iter().enumerate() {
            if side[i] == of && crosses(i) { from_end.push(*b) } else { halves[side[i] as usize].push(*b) }
        }
        parts.extend(halves.into_iter().filter(|half| !half.is_empty()));
    }
    from_end.reverse();
    from_end
}

/// The groups of each body, and how many of them are left.
struct Incidence {
    start: Vec<u32>,
    group: Vec<u32>,
    n_left: Vec<u32>,
    is_done: Vec<bool>,
}

impl Incidence {
    fn of(n_bodies: usize, ends: &[[Option<u32>; 2]]) -> Incidence {
        let mut start = vec![0u32; n_bodies + 1];
        let bodies =
            || ends.iter().enumerate().flat_map(|(g, e)| e.iter().flatten().map(move |b| (g as u32, *b as usize)));
        bodies().for_each(|(_, b)| start[b + 1] += 1);
        let n_left = start[1..].to_vec();
        (0..n_bodies).for_each(|b| start[b + 1] += start[b]);
        let (mut next, mut group) = (start.clone(), vec![0; start[n_bodies] as usize]);
        for (g, b) in bodies() {
            group[next[b] as usize] = g;
            next[b] += 1;
        }
        Incidence { start, group, n_left, is_done: vec![false; ends.len()] }
    }

    fn around(&self, body: usize) -> impl Iterator<Item = u32> {
        let all = &self.group[self.start[body] as usize..self.start[body + 1] as usize];
        all.iter().copied().filter(|g| !self.is_done[*g as usize])
    }

    /// Take the groups of one body, and the last group of a body, as long as there are any.
    fn strip(&mut self, ends: &[[Option<u32>; 2]]) -> Vec<u32> {
        let mut order = vec![];
        let single = |g: &usize| ends[*g].iter().flatten().count() < 2;
        let mut open: Vec<u32> = (0..ends.len()).filter(single).map(|g| g as u32).collect();
        let last_of = |at: &Incidence, b: usize| if at.n_left[b] == 1 { at.around(b).next() } else { None };
        open.extend((0..self.n_left.len()).filter_map(|b| last_of(self, b)));
        let mut next = 0;
        while next < open.len() {
            let g = open[next] as usize;
            next += 1;
            if std::mem::replace(&mut self.is_done[g], true) {
                continue;
            }
            order.push(g as u32);
            for b in ends[g].iter().flatten() {
                self.n_left[*b as usize] -= 1;
                open.extend(last_of(self, *b as usize));
            }
        }
        order
    }
}

/// Order what is left, from the end.
fn dissect(at: &mut Incidence, ends: &[[Option<u32>; 2]], from_end: &mut Vec<u32>) {
    const NONE: u32 = u32::MAX;
    let mut number = vec![NONE; at.n_left.len()];
    let all: Vec<u32> = (0..at.n_left.len()).filter(|b| at.n_left[*b] > 0).map(|b| b as u32).collect();
    let mut parts = components(at, ends, all);
    while let Some(part) = parts.pop() {
        let graph = graph_of(&part, at, ends, &mut number);
        let side = graph.bisect();
        let mut halves = [vec![], vec![]];
        part.iter().zip(&side).for_each(|(b, s)| halves[*s as usize].push(*b));
        let [a, b] = halves;
        a.iter().enumerate().for_each(|(i, body)| number[*body as usize] = i as u32);
        for body in &b {
            for k in at.start[*body as usize]..at.start[*body as usize + 1] {
                let g = at.group[k as usize] as usize;
                let crosses = ends[g].iter().flatten().any(|e| number[*e as usize] != NONE);
                if !at.is_done[g] && crosses {
                    at.is_done[g] = true;
                    from_end.push(g as u32);
                }
            }
        }
        a.iter().for_each(|body| number[*body as usize] = NONE);
        parts.extend([a, b].into_iter().filter(|half| half.len() > 1));
    }
}

/// Bodies that are connected by groups that are left.
fn components(at: &Incidence, ends: &[[Option<u32>; 2]], bodies: Vec<u32>) -> Vec<Vec<u32>> {
    let mut is_seen = vec![false; at.n_left.len()];
    let mut all = vec![];
    for first in bodies {
        if std::mem::replace(&mut is_seen[first as usize], true) {
            continue;
        }
        let mut part = vec![first];
        let mut next = 0;
        while next < part.len() {
            for g in at.around(part[next] as usize) {
                for b in ends[g as usize].iter().flatten() {
                    if !std::mem::replace(&mut is_seen[*b as usize], true) {
                        part.push(*b);
                    }
                }
            }
            next += 1;
        }
        all.push(part);
    }
    all
}

/// The graph of some bodies and the groups that are left between them. `number` is [`u32::MAX`] everywhere, before and after.
fn graph_of(part: &[u32], at: &Incidence, ends: &[[Option<u32>; 2]], number: &mut [u32]) -> Graph {
    part.iter().enumerate().for_each(|(i, b)| number[*b as usize] = i as u32);
    let mut graph = Graph { start: vec![0], near: vec![], weight: vec![1; part.len()] };
    for body in part {
        for g in at.around(*body as usize) {
            let other = ends[g as usize].iter().flatten().find(|b| *b != body);
            let other = other.map_or(u32::MAX, |b| number[*b as usize]);
            if other != u32::MAX {
                graph.near.push([other, 1]);
            }
        }
        graph.start.push(graph.near.len() as u32);
    }
    part.iter().for_each(|b| number[*b as usize] = u32::MAX);
    graph
}
