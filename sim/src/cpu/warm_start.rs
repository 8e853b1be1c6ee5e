//! Start each contact from the impulse that the same contact had in the last step.
//! in   last     contacts of the last step, with their impulses
//!      contacts [n_contacts]  all but the impulses
//! out  impulse  [n_contacts]  N s, world; zero for a new contact
//!      twist    [n_contacts]  N m s, world, where the model has rolling or spinning friction
//! Source: PHYSICS, "warm start from the last step's γ of the same pair".
//!
//! While the list of candidates holds, the contacts of two balls stand in its order in both steps, and one walk along both
//! finds the same ones. The others, and all after the list was made anew, are looked for by their keys.

use super::contact_write::{Balls, Touching};
use super::{cut, fill_rows};
use crate::{Contacts, Model};
use glam::{DVec3, Vec3};
use gpu::radix_sort::distribute_cpu;
use rayon::prelude::*;

/// What is kept of a step's contacts. A starting point needs no double precision.
#[derive(Default)]
pub struct Last {
    /// Whether the list of candidates still holds.
    kept: bool,
    /// Contacts that are looked for by their keys, and these: those that are not between two balls if the list holds, else all.
    known: Vec<u32>,
    key: Vec<[u32; 3]>,
    impulse: Vec<Vec3>,
    twist: Vec<Vec3>,
    /// The candidates of two balls that touched, piece by piece, and the first contact of each piece.
    balls: Balls,
    start: Vec<u32>,
}

/// No contact of the last step.
const NEW: u32 = u32::MAX;

impl Last {
    /// Take these contacts with the candidates that they are of; `kept` says that the list of candidates holds.
    pub fn take(&mut self, contacts: &mut Contacts, touching: &mut Touching, kept: bool) {
        self.kept = kept;
        std::mem::swap(&mut self.start, &mut contacts.tiles.start);
        std::mem::swap(&mut self.balls, &mut touching.balls);
        if kept {
            self.known = others(contacts.len(), &self.start, &self.balls);
            self.key = self.known.iter().map(|i| contacts.key[*i as usize]).collect();
        } else {
            self.known = (0..contacts.len() as u32).collect();
            self.key = std::mem::take(&mut contacts.key);
        }
        self.impulse.resize(contacts.impulse.len(), Vec3::ZERO);
        fill_rows(&mut self.impulse, |i| contacts.impulse[i].as_vec3());
        self.twist.resize(contacts.twist.len(), Vec3::ZERO);
        fill_rows(&mut self.twist, |i| contacts.twist[i].as_vec3());
    }

    /// Find the contacts between two balls, piece by piece along the candidates.
    fn find_balls(&self, touching: &Touching, same: &mut [u32]) {
        let same = cut(same, touching.lengths());
        let pieces = (touching.balls.pieces(), self.balls.pieces(), &self.start, same).into_par_iter();
        pieces.for_each(|(now, last, first, same)| {
            let mut at = 0;
            for (candidate, same) in now.iter().zip(same) {
                while last.get(at).is_some_and(|known| known < candidate) {
                    at += 1;
                }
                if last.get(at) == Some(candidate) {
                    *same = first + at as u32;
                }
            }
        });
    }

    /// Find contacts by their keys, in the shorter list of their two shapes.
    fn find(&self, n_shapes: usize, keys: impl Fn(usize) -> [u32; 3] + Sync, same: &mut [u32]) {
        let sides = || (0..2 * self.key.len()).map(|k| (self.key[k / 2][k % 2], k as u32 / 2));
        let (mut start, mut of_shape) = (vec![], vec![]);
        distribute_cpu(n_shapes, sides, &mut start, &mut of_shape);
        fill_rows(same, |i| {
            let key = keys(i);
            let of = |s: u32| &of_shape[start[s as usize] as usize..start[s as usize + 1] as usize];
            let (a, b) = (of(key[0]), of(key[1]));
            let shorter = if a.len() < b.len() { a } else { b };
            shorter.iter().find(|k| self.key[**k as usize] == key).map_or(NEW, |k| self.known[*k as usize])
        });
    }
}

/// Those of `n` contacts that are not between two balls.
fn others(n: usize, start: &[u32], balls: &Balls) -> Vec<u32> {
    let end = start.iter().skip(1).copied().chain([n as u32]);
    let pieces = start.iter().zip(balls.pieces()).zip(end);
    pieces.flat_map(|((first, balls), end)| first + balls.len() as u32..end).collect()
}

/// The stage. `touching` has the candidates that the contacts are of. The last step's keys are let go.
pub fn run(model: &Model, last: &mut Last, touching: &Touching, contacts: &mut Contacts) {
    let mut impulse = std::mem::take(&mut contacts.impulse);
    let mut twist = std::mem::take(&mut contacts.twist);
    let rolls = model.laws.iter().any(|l| l.rolling > 0.0 || l.spinning > 0.0);
    let n = contacts.len();
    impulse.resize(n, DVec3::ZERO);
    twist.resize(if rolls { n } else { 0 }, DVec3::ZERO);
    if model.solver.warm_start {
        let mut same = vec![NEW; n];
        if last.kept {
            last.find_balls(touching, &mut same);
            let asked = others(n, &contacts.tiles.start, &touching.balls);
            let mut found = vec![NEW; asked.len()];
            last.find(model.n_shapes(), |k| contacts.key[asked[k] as usize], &mut found);
            asked.iter().zip(found).for_each(|(i, found)| same[*i as usize] = found);
        } else {
            last.find(model.n_shapes(), |i| contacts.key[i], &mut same);
        }
        let of = |column: &[Vec3], i: usize| column.get(same[i] as usize).map_or(DVec3::ZERO, |v| v.as_dvec3());
        fill_rows(&mut impulse, |i| of(&last.impulse, i));
        fill_rows(&mut twist, |i| of(&last.twist, i));
    } else {
        impulse.fill(DVec3::ZERO);
        twist.fill(DVec3::ZERO);
    }
    contacts.impulse = impulse;
    contacts.twist = twist;
    (last.known, last.key) = (vec![], vec![]);
}
