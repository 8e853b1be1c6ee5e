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
//! While the candidate pairs are those of the last step, contacts of sphere pairs have the same order in both steps, and one pass
//! along both matches them. The others, and all after a run of the broad phase, are matched by their keys.
//!
//! Faces on faces have contacts whose features change from step to step while they rest. What such a contact had goes on with the nearest
//! new contact of the same two shapes, or the nearest one at all, so that no force between two shapes is lost while they touch.

use crate::contacts::{Arms, Contacts, NO_SPHERE_PAIR};
use crate::plan::StepPlan;
use crate::rows::{cut, fill_rows, reduce_chunks};
use glam::{DVec3, Vec3};
use gpu::radix_sort::distribute_cpu;
use rayon::prelude::*;

/// The contacts of the last step. Single precision is enough for a starting point.
#[derive(Default)]
pub struct Last {
    /// Whether the candidate pairs are still those of the last step.
    pairs_hold: bool,
    /// Contacts that are matched by their keys, and the keys: those that are not of sphere pairs if the pairs hold, else all.
    known: Vec<u32>,
    key: Vec<[u32; 3]>,
    /// Arms of those contacts, m (none where all are of spheres).
    arms: Vec<[Vec3; 2]>,
    impulse: Vec<Vec3>,
    rolling_impulse: Vec<Vec3>,
    /// Indices of the sphere pairs that touched, and the first contact of each tile.
    pair: Vec<u32>,
    start: Vec<u32>,
}

/// The match of a contact that was not in the last step.
const NEW: u32 = u32::MAX;

/// Indices of the sphere pairs that touch, by tile.
fn pairs_by_tile<'a>(pair: &'a [u32], start: &[u32]) -> Vec<&'a [u32]> {
    let of_tile = |ends: &[u32]| {
        let own = &pair[ends[0] as usize..ends[1] as usize];
        &own[..own.partition_point(|pair| *pair != NO_SPHERE_PAIR)]
    };
    start.windows(2).map(of_tile).collect()
}

/// Indices of the contacts that are not of sphere pairs.
fn others(pair: &[u32]) -> Vec<u32> {
    pair.iter().zip(0..).filter(|(pair, _)| **pair == NO_SPHERE_PAIR).map(|(_, i)| i).collect()
}

impl Last {
    /// Take the contacts of the last step, before those of this step are written; `pairs_hold` asserts that the candidate pairs are the
    /// same.
    pub fn take(&mut self, contacts: &mut Contacts, pairs_hold: bool) {
        self.pairs_hold = pairs_hold;
        std::mem::swap(&mut self.start, &mut contacts.tiles.start);
        std::mem::swap(&mut self.pair, &mut contacts.pair);
        if pairs_hold {
            self.known = others(&self.pair);
            self.key = self.known.iter().map(|i| contacts.key[*i as usize]).collect();
        } else {
            self.known = (0..contacts.len() as u32).collect();
            self.key = std::mem::take(&mut contacts.key);
        }
        self.arms = match &contacts.arms {
            Arms::Any(arms) => self.known.iter().map(|i| arms[*i as usize].map(|arm| arm.as_vec3())).collect(),
            Arms::Along(_) => vec![],
        };
        self.impulse.resize(contacts.impulse.len(), Vec3::ZERO);
        fill_rows(&mut self.impulse, |i| contacts.impulse[i].as_vec3());
        self.rolling_impulse.resize(contacts.rolling_impulse.len(), Vec3::ZERO);
        fill_rows(&mut self.rolling_impulse, |i| contacts.rolling_impulse[i].as_vec3());
    }

    /// Match the contacts of sphere pairs, tile by tile along the pairs.
    fn find_spheres(&self, contacts: &Contacts, same: &mut [u32]) {
        let start = &contacts.tiles.start;
        let same = cut(same, start.windows(2).map(|ends| (ends[1] - ends[0]) as usize));
        let (now, last) = (pairs_by_tile(&contacts.pair, start), pairs_by_tile(&self.pair, &self.start));
        (now, last, &self.start[..self.start.len() - 1], same).into_par_iter().for_each(|(now, last, first, same)| {
            let mut at = 0;
            for (pair, same) in now.iter().zip(same) {
                while last.get(at).is_some_and(|known| known < pair) {
                    at += 1;
                }
                if last.get(at) == Some(pair) {
                    *same = first + at as u32;
                }
            }
        });
    }

    /// Match contacts by their keys along both lists, which have most contacts in the same order; what is not found stays as it is.
    fn find_along(&self, keys: impl Fn(usize) -> [u32; 3], same: &mut [u32]) {
        /// How far contacts are looked for ahead.
        const AHEAD: usize = 16;
        let mut at = 0;
        for (k, same) in same.iter_mut().enumerate() {
            let key = keys(k);
            let ahead = &self.key[at..self.key.len().min(at + AHEAD)];
            if let Some(passed) = ahead.iter().position(|known| *known == key) {
                *same = self.known[at + passed];
                at += passed + 1;
            }
        }
    }

    /// Match the contacts that have no match yet by their keys, in the shorter list of the contacts of their two shapes.
    fn find(&self, n_shapes: usize, keys: impl Fn(usize) -> [u32; 3] + Sync, same: &mut [u32]) {
        let sides = || (0..2 * self.key.len()).map(|k| (self.key[k / 2][k % 2], k as u32 / 2));
        let (mut start, mut of_shape) = (vec![], vec![]);
        distribute_cpu(n_shapes, sides, &mut start, &mut of_shape);
        let of = |s: u32| &of_shape[start[s as usize] as usize..start[s as usize + 1] as usize];
        let [] = reduce_chunks(same, |first, rows| {
            for (i, same) in rows.iter_mut().enumerate().filter(|(_, same)| **same == NEW) {
                let key = keys(first + i);
                let (a, b) = (of(key[0]), of(key[1]));
                let shorter = if a.len() < b.len() { a } else { b };
                *same = shorter.iter().find(|k| self.key[**k as usize] == key).map_or(NEW, |k| self.known[*k as usize]);
            }
            []
        });
    }
}

impl Last {
    /// Pairs of contacts of two shapes that still touch: one of the last step that is no more, and the one that goes on with its impulse.
    fn successors(&self, contacts: &Contacts, same: &[u32]) -> Vec<[u32; 2]> {
        let Arms::Any(arms) = &contacts.arms else { return vec![] };
        let mut goes_on = vec![false; self.impulse.len()];
        same.iter().filter(|i| **i != NEW).for_each(|i| goes_on[*i as usize] = true);
        let shapes = |key: &[u32; 3]| [key[0], key[1]];
        let is_gone = |k: &usize| {
            let i = self.known[*k] as usize;
            // A state that was read from a checkpoint has no pairs; contacts of spheres have no successors in any case.
            let is_other = self.pair.get(i).is_none_or(|pair| *pair == NO_SPHERE_PAIR);
            !goes_on[i] && is_other && self.impulse[i] != Vec3::ZERO
        };
        let mut gone: Vec<usize> = (0..self.arms.len()).filter(is_gone).collect();
        gone.sort_by_key(|k| (shapes(&self.key[*k]), *k));
        if gone.is_empty() {
            return vec![];
        }
        let now = others(&contacts.pair);
        let key = |i: &u32| &contacts.key[*i as usize];
        let mut pairs = vec![];
        for run in now.chunk_by(|i, j| shapes(key(i)) == shapes(key(j))) {
            let own = shapes(key(&run[0]));
            let first = gone.partition_point(|k| shapes(&self.key[*k]) < own);
            for &k in gone[first..].iter().take_while(|k| shapes(&self.key[**k]) == own) {
                let distance2 = |i: &u32| {
                    let [a, b] = arms[*i as usize].map(|arm| arm.as_vec3());
                    (a - self.arms[k][0]).length_squared() + (b - self.arms[k][1]).length_squared()
                };
                let nearer = |i: &&u32, j: &&u32| {
                    let is_old = |i: &u32| same[*i as usize] != NEW;
                    is_old(i).cmp(&is_old(j)).then(distance2(i).total_cmp(&distance2(j)))
                };
                let heir = run.iter().min_by(nearer).expect("a run has contacts");
                pairs.push([self.known[k], *heir]);
            }
        }
        pairs
    }
}

/// The stage. The memory of the last step's keys is released.
pub fn run(plan: &StepPlan, n_shapes: usize, last: &mut Last, contacts: &mut Contacts) {
    let mut impulse = std::mem::take(&mut contacts.impulse);
    let mut rolling_impulse = std::mem::take(&mut contacts.rolling_impulse);
    let n = contacts.len();
    impulse.resize(n, DVec3::ZERO);
    rolling_impulse.resize(if plan.rolls { n } else { 0 }, DVec3::ZERO);
    if plan.warm_starts {
        let mut same = vec![NEW; n];
        if last.pairs_hold {
            last.find_spheres(contacts, &mut same);
            let by_key = others(&contacts.pair);
            let mut found = vec![NEW; by_key.len()];
            let key = |k: usize| contacts.key[by_key[k] as usize];
            last.find_along(key, &mut found);
            if found.contains(&NEW) {
                last.find(n_shapes, key, &mut found);
            }
            by_key.iter().zip(found).for_each(|(i, found)| same[*i as usize] = found);
        } else {
            last.find(n_shapes, |i| contacts.key[i], &mut same);
        }
        let of = |column: &[Vec3], i: usize| column.get(same[i] as usize).map_or(DVec3::ZERO, |v| v.as_dvec3());
        fill_rows(&mut impulse, |i| of(&last.impulse, i));
        fill_rows(&mut rolling_impulse, |i| of(&last.rolling_impulse, i));
        for pair in last.successors(contacts, &same) {
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
    (last.known, last.key, last.arms) = (vec![], vec![], vec![]);
}
