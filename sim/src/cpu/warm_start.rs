//! Start each contact from the impulse that the same contact had in the last step.
//! in     contact_start    [n_tiles + 2]
//! in     contact_key      [n_contacts]
//! in     contact_pair     [n_contacts]
//! in     contact_arms     [n_contacts]  m, of the last step and of this one, or
//! in     contact_reach    [n_contacts]  m
//! inout  impulse          [n_contacts]  N s, world: that of the last step; zero for a new contact
//! inout  rolling_impulse  [n_contacts]  N m s, world, where the plan has rolling or spinning friction
//! Source: PHYSICS, "warm start from the last step's γ of the same pair".
//!
//! While the candidate pairs are those of the last step, the contacts of a tile have the order of their pairs in both steps, and passes along
//! both match them; after a run of the broad phase they are looked for by their shapes. A contact between the shapes that were matched is the
//! one of the same feature.
//!
//! Faces on faces have contacts whose features change from step to step while they rest. What such a contact had goes on with the nearest
//! new contact of the same two shapes, or the nearest one at all, so that no force between two shapes is lost while they touch.

use super::by_shape::ByShape;
use crate::contacts::{Arms, Contacts, NO_PAIR, OTHER};
use crate::plan::StepPlan;
use crate::rows::{SERIAL_LIMIT, cut, fill_rows};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::ops::Range;

/// The contacts of the last step. Single precision is enough for a starting point.
#[derive(Default)]
pub struct Last {
    /// Whether the candidate pairs are still those of the last step.
    pairs_hold: bool,
    /// The contacts' keys; none where all are of sphere pairs that hold.
    key: Vec<[u32; 3]>,
    /// The contacts' arms, m (none where all are of spheres).
    arms: Vec<[Vec3; 2]>,
    impulse: Vec<Vec3>,
    rolling_impulse: Vec<Vec3>,
    /// The contacts' pairs within their tiles, and the first contact of each tile.
    pair: Vec<u32>,
    start: Vec<u32>,
    /// The runs of contacts of the same two shapes, by these, where the plan warm-starts and the pairs do not hold.
    runs: ByShape<[u32; 2]>,
}

/// The match of a contact that was not in the last step.
const NEW: u32 = u32::MAX;

/// Contacts that one task matches, but for those of the last two shapes.
const PART: usize = 1024;

impl Last {
    /// Take the contacts of the last step, before those of this step are written, of a model with `n_shapes` shapes; `pairs_hold` asserts that the
    /// candidate pairs are the same.
    pub fn take(&mut self, plan: &StepPlan, contacts: &mut Contacts, n_shapes: usize, pairs_hold: bool) {
        // Contacts that were read from a file, or from a device, do not know their pairs.
        self.pairs_hold = pairs_hold && contacts.pair.last() != Some(&NO_PAIR);
        std::mem::swap(&mut self.start, &mut contacts.tiles.start);
        std::mem::swap(&mut self.pair, &mut contacts.pair);
        let is_other = |pair: &u32| *pair >= OTHER;
        self.key = match self.pairs_hold && !self.pair.iter().any(is_other) {
            true => vec![],
            false => std::mem::take(&mut contacts.key),
        };
        self.arms.clear();
        if let Arms::Any(arms) = &contacts.arms {
            self.arms.resize(arms.len(), Default::default());
            fill_rows(&mut self.arms, |i| arms[i].map(|arm| arm.as_vec3()));
        }
        self.impulse.resize(contacts.impulse.len(), Vec3::ZERO);
        fill_rows(&mut self.impulse, |i| contacts.impulse[i].as_vec3());
        self.rolling_impulse.resize(contacts.rolling_impulse.len(), Vec3::ZERO);
        fill_rows(&mut self.rolling_impulse, |i| contacts.rolling_impulse[i].as_vec3());
        let is_by_shapes = plan.warm_starts && !self.pairs_hold;
        self.runs = if is_by_shapes { Last::runs(&self.key, n_shapes) } else { ByShape::default() };
    }

    /// The end of the contacts from `first` on, up to `end`, that are of the same two shapes.
    fn run_end(key: &[[u32; 3]], first: usize, end: usize) -> usize {
        (first + 1..end).find(|i| key[*i][..2] != key[first][..2]).unwrap_or(end)
    }

    /// Match contacts of a tile along the pairs, which hold; `last` has the tile's contacts of the last step.
    fn match_along(&self, contacts: &Contacts, last: Range<usize>, out: &mut Matches) {
        let (pair, known) = (&contacts.pair, &self.pair[..last.end]);
        // The first that may be of the first pair, or of its shapes.
        let begin = out.now.start;
        let mut at = last.start + known[last.start..].partition_point(|known| *known < pair[begin]);
        let is_of_shapes = |at: usize| known[at] >= OTHER && self.key[at][..2] == contacts.key[begin][..2];
        while at > last.start && pair[begin] >= OTHER && is_of_shapes(at - 1) {
            at -= 1;
        }
        let n_spheres = pair[out.now.clone()].partition_point(|pair| *pair < OTHER);
        for k in 0..n_spheres {
            let pair = pair[out.now.start + k];
            while at < known.len() && known[at] < pair {
                at += 1;
            }
            if known.get(at) == Some(&pair) {
                out.same[k] = at as u32;
            }
        }
        let mut i = out.now.start + n_spheres;
        while i < out.now.end {
            let run = i..Last::run_end(&contacts.key, i, out.now.end);
            let is_same = |at: usize| known[at] >= OTHER && self.key[at][..2] == contacts.key[i][..2];
            // The last step's contacts of these shapes may be of pairs before these: of other triangles of a surface.
            while at < known.len() && known[at] < pair[i] && !is_same(at) {
                at += 1;
            }
            if at < known.len() && is_same(at) {
                let end = Last::run_end(&self.key, at, known.len());
                self.match_run(contacts, run.clone(), at..end, out);
                at = end;
            }
            i = run.end;
        }
    }

    /// Match contacts by their shapes.
    fn match_by_shapes(&self, contacts: &Contacts, out: &mut Matches) {
        let mut i = out.now.start;
        while i < out.now.end {
            let run = i..Last::run_end(&contacts.key, i, out.now.end);
            let [s, t, _] = contacts.key[i];
            for [first, end] in self.runs.find([s, t]) {
                self.match_run(contacts, run.clone(), *first as usize..*end as usize, out);
            }
            i = run.end;
        }
    }

    /// Match contacts of two shapes with those of the last step, by their features.
    fn match_run(&self, contacts: &Contacts, run: Range<usize>, last: Range<usize>, out: &mut Matches) {
        let Matches { now, same, successors } = out;
        let own = &mut same[run.start - now.start..run.end - now.start];
        for (same, i) in own.iter_mut().zip(run.clone()) {
            let is_same = |k: &usize| self.key[*k][2] == contacts.key[i][2];
            if let Some(k) = last.clone().find(is_same) {
                *same = k as u32;
            }
        }
        let Arms::Any(arms) = &contacts.arms else { return };
        for k in last {
            if self.impulse[k] == Vec3::ZERO || own.contains(&(k as u32)) {
                continue;
            }
            let distance2 = |j: usize| {
                let [a, b] = arms[run.start + j].map(|arm| arm.as_vec3());
                (a - self.arms[k][0]).length_squared() + (b - self.arms[k][1]).length_squared()
            };
            let nearer = |i: &usize, j: &usize| {
                let is_old = |j: usize| own[j] != NEW;
                is_old(*i).cmp(&is_old(*j)).then(distance2(*i).total_cmp(&distance2(*j)))
            };
            let heir = (0..own.len()).min_by(nearer).map(|j| (run.start + j) as u32);
            successors.extend(heir.map(|heir| [k as u32, heir]));
        }
    }

    /// The runs of contacts with these keys of the same two shapes, by these.
    fn runs(key: &[[u32; 3]], n_shapes: usize) -> ByShape<[u32; 2]> {
        let (mut runs, mut first) = (vec![], 0);
        while first < key.len() {
            let end = Last::run_end(key, first, key.len());
            runs.push([first as u32, end as u32]);
            first = end;
        }
        ByShape::of(n_shapes, runs.len(), |r| {
            let [s, t, _] = key[runs[r][0] as usize];
            ([s, t], runs[r])
        })
    }

    /// Match all contacts, some of a tile at a time.
    fn matches<'a>(&self, contacts: &Contacts, same: &'a mut [u32]) -> Vec<Matches<'a>> {
        let is_serial = same.len() <= SERIAL_LIMIT;
        let mut parts = vec![];
        for (tile, ends) in contacts.tiles.start.windows(2).enumerate() {
            let (mut first, end) = (ends[0] as usize, ends[1] as usize);
            while first < end {
                // Runs are whole.
                let last = if is_serial { end - 1 } else { (first + PART - 1).min(end - 1) };
                let own = first..Last::run_end(&contacts.key, last, end);
                first = own.end;
                parts.push((tile, own));
            }
        }
        let of_parts = cut(same, parts.iter().map(|(_, own)| own.len()));
        let min_len = if is_serial { parts.len().max(1) } else { 1 };
        let tasks = parts.into_par_iter().zip(of_parts).with_min_len(min_len).with_max_len(min_len);
        let of_part = |((tile, now), same): ((usize, Range<usize>), &'a mut [u32])| {
            let mut out = Matches { now, same, successors: vec![] };
            match self.pairs_hold {
                true => {
                    let last = self.start[tile] as usize..self.start[tile + 1] as usize;
                    self.match_along(contacts, last, &mut out);
                }
                false => self.match_by_shapes(contacts, &mut out),
            }
            out
        };
        tasks.map(of_part).collect()
    }
}

/// What is matched of some contacts of a tile.
struct Matches<'a> {
    /// The contacts.
    now: Range<usize>,
    /// The contact of the last step that each is.
    same: &'a mut [u32],
    /// Contacts of the last step that are no more, though their shapes touch, and the contact that goes on with the impulse of each.
    successors: Vec<[u32; 2]>,
}

/// The stage. The memory of the last step's keys, arms and runs is released.
pub fn run(plan: &StepPlan, last: &mut Last, contacts: &mut Contacts) {
    let mut impulse = std::mem::take(&mut contacts.impulse);
    let mut rolling_impulse = std::mem::take(&mut contacts.rolling_impulse);
    let n = contacts.len();
    impulse.resize(n, DVec3::ZERO);
    rolling_impulse.resize(if plan.rolls { n } else { 0 }, DVec3::ZERO);
    if plan.warm_starts {
        let mut same = vec![NEW; n];
        let successors: Vec<[u32; 2]> =
            last.matches(contacts, &mut same).into_iter().flat_map(|part| part.successors).collect();
        let of = |column: &[Vec3], i: usize| column.get(same[i] as usize).map_or(DVec3::ZERO, |v| v.as_dvec3());
        fill_rows(&mut impulse, |i| of(&last.impulse, i));
        fill_rows(&mut rolling_impulse, |i| of(&last.rolling_impulse, i));
        for pair in successors {
            let [gone, heir] = pair.map(|i| i as usize);
            impulse[heir] += last.impulse[gone].as_dvec3();
            if plan.rolls {
                rolling_impulse[heir] += last.rolling_impulse[gone].as_dvec3();
            }
        }
    } else {
        impulse.fill(DVec3::ZERO);
        rolling_impulse.fill(DVec3::ZERO);
    }
    contacts.impulse = impulse;
    contacts.rolling_impulse = rolling_impulse;
    (last.key, last.arms, last.runs) = (vec![], vec![], ByShape::default());
}
