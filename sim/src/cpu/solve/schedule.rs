//! The order in which Gauss–Seidel visits blocks: those visited concurrently have no moving body in common, so that the result does not
//! depend on the number of threads.
//!
//! Blocks in general are coloured: those of a colour have no body in common. Contacts in tiles ([`crate::contacts::Tiles`]) are coloured
//! tile by tile, each tile is visited by one thread, whose cache has its bodies, and only the few contacts in no tile are coloured for
//! all threads together.

use super::cells::Cells;
use crate::contacts::{Contacts, rest_of, rounds_of};
use crate::rows::{SERIAL_LIMIT, reduce_tasks};
use gpu::radix_sort::distribute_cpu;
use rayon::prelude::*;
use std::ops::Range;

/// Blocks by colours.
#[derive(Default)]
pub struct Colored {
    order: Vec<u32>,
    /// First block of each colour, and the end (n_colors + 1).
    start: Vec<u32>,
}

impl Colored {
    /// Give each block the first colour that its moving bodies do not have yet. `taken` has the colours of each body as a mask; those of
    /// the blocks' bodies are 0 at first. Within a colour, blocks of more contacts come first: `length` has their count, at most
    /// [`Blocks::MOST`].
    ///
    /// # Safety
    /// No other thread touches the entries of the blocks' moving bodies.
    pub unsafe fn fill(
        &mut self,
        blocks: Range<u32>,
        bodies: impl Fn(u32) -> [Option<u32>; 2],
        length: impl Fn(u32) -> usize,
        taken: &Cells<u64>,
    ) {
        // A body with more than 64 blocks: its further blocks have colours of their own.
        let mut n_colors = 64;
        let mut color_of = |block: u32| {
            let own = bodies(block);
            let own = own.iter().flatten().map(|b| *b as usize);
            // SAFETY: the caller's promise, here and below.
            let used = own.clone().fold(0, |used, b| used | unsafe { taken.get(b) });
            let first = (!used).trailing_zeros();
            if first == 64 {
                n_colors += 1;
                return n_colors - 1;
            }
            own.for_each(|b| unsafe { taken.set(b, taken.get(b) | 1 << first) });
            first
        };
        let most = Blocks::MOST;
        let place_of = |block: u32| color_of(block) * most as u32 + (most - length(block)) as u32;
        let place: Vec<u32> = blocks.clone().map(place_of).collect();
        let placed = || place.iter().copied().zip(blocks.clone());
        let mut start = vec![];
        distribute_cpu(n_colors as usize * most, placed, &mut start, &mut self.order);
        self.start.clear();
        self.start.extend(start.iter().step_by(most));
    }

    /// Give each of `n` blocks a colour of its own.
    pub fn one_by_one(&mut self, n: u32) {
        (self.order, self.start) = ((0..n).collect(), (0..=n).collect());
    }

    /// The blocks, colour by colour.
    pub fn blocks(&self) -> &[u32] {
        &self.order
    }

    /// The range in `blocks` of each colour that has any.
    pub fn ranges(&self) -> impl Iterator<Item = Range<usize>> {
        self.start.windows(2).map(|ends| ends[0] as usize..ends[1] as usize).filter(|color| !color.is_empty())
    }

    /// The blocks of each colour that has any.
    pub fn colors(&self) -> impl Iterator<Item = &[u32]> {
        self.ranges().map(|color| &self.order[color])
    }
}

/// Visit every contact once, concurrently those that have no moving body in common.
pub fn each(contacts: &Contacts, visit: impl Fn(usize) + Sync) {
    let n = contacts.len();
    if n == 0 {
        return;
    }
    let tile = |first: u32, end: u32| (first as usize..end as usize).for_each(&visit);
    for round in contacts.tiles.rounds() {
        let [] = reduce_tasks(round.par_windows(2), n <= SERIAL_LIMIT, |ends| {
            tile(ends[0], ends[1]);
            []
        });
    }
    contacts.tiles.rest().for_each(|contact| visit(contact as usize));
}

/// Blocks of contacts: each contact by itself, or manifolds, runs of at most [`Blocks::MOST`] contacts of the same two bodies.
#[derive(Default)]
pub struct Blocks {
    /// First contact of each manifold, and the end; empty where each contact is a block.
    first: Vec<u32>,
    /// First block of each tile and of the blocks in no tile, and the end (n_tiles + 2), where the blocks are manifolds.
    start: Vec<u32>,
}

impl Blocks {
    /// The most contacts of a manifold.
    pub const MOST: usize = 4;

    /// Each contact is a block.
    pub fn be_contacts(&mut self) {
        self.first.clear();
    }

    /// Each pair's contacts are blocks.
    pub fn be_manifolds(&mut self, contacts: &Contacts) {
        let Blocks { first, start } = self;
        first.clear();
        start.clear();
        for ends in contacts.tiles.start.windows(2) {
            start.push(first.len() as u32);
            let mut own = 0;
            for i in ends[0]..ends[1] {
                let is_next =
                    own > 0 && own < Self::MOST && contacts.bodies[i as usize] == contacts.bodies[i as usize - 1];
                own = if is_next { own + 1 } else { 1 };
                if own == 1 {
                    first.push(i);
                }
            }
        }
        start.push(first.len() as u32);
        first.push(contacts.len() as u32);
    }

    /// Number of the blocks that are manifolds.
    pub fn n_manifolds(&self) -> u32 {
        self.first.len().saturating_sub(1) as u32
    }

    /// The contacts of a block.
    #[inline]
    pub fn contacts(&self, block: u32) -> Range<usize> {
        let b = block as usize;
        if self.first.is_empty() { b..b + 1 } else { self.first[b] as usize..self.first[b + 1] as usize }
    }

    /// First block of each tile and of the blocks in no tile, and the end, of blocks with these contacts.
    fn starts<'a>(&'a self, contacts: &'a Contacts) -> &'a [u32] {
        if self.first.is_empty() { &contacts.tiles.start } else { &self.start }
    }
}

/// Blocks by tiles and colours.
#[derive(Default)]
pub struct Tiled {
    /// The tiles of both rounds; those of a round have no moving body in common.
    pub rounds: [Vec<Colored>; 2],
    /// The blocks in no tile.
    pub shared: Colored,
    /// Where each body lies in columns in which those of a tile are neighbours, and where what belongs to no body (n_bodies + 1).
    pub place: Vec<u32>,
    /// Length of these columns.
    pub n_places: usize,
}

impl Tiled {
    /// The tiles of all rounds; those of the last, the blocks in no tile, are one.
    pub fn all_rounds(&self) -> [&[Colored]; 3] {
        let [first, second] = &self.rounds;
        [first, second, std::slice::from_ref(&self.shared)]
    }

    /// Colour the blocks tile by tile.
    pub fn fill(&mut self, contacts: &Contacts, blocks: &Blocks, inv_mass: &[f64]) {
        self.n_places = contacts.tiles.places(inv_mass.len(), &mut self.place) + 1;
        self.place.push(self.n_places as u32 - 1);
        let moving = |body: u32| (inv_mass[body as usize] > 0.0).then_some(body);
        let bodies = |block: u32| contacts.bodies[blocks.contacts(block).start].map(moving);
        let length = |block: u32| blocks.contacts(block).len();
        let (starts, n_first) = (blocks.starts(contacts), contacts.tiles.n_first);
        let mut taken = vec![0; inv_mass.len()];
        for (tiles, start) in self.rounds.iter_mut().zip(rounds_of(starts, n_first)) {
            taken.fill(0);
            let taken = Cells::new(&mut taken);
            tiles.resize_with(start.len() - 1, Colored::default);
            let each = tiles.par_iter_mut().zip(start.par_windows(2)).with_max_len(1);
            // SAFETY: the tiles of a round have no moving body in common.
            each.for_each(|(colored, ends)| unsafe { colored.fill(ends[0]..ends[1], bodies, length, &taken) });
        }
        taken.fill(0);
        // SAFETY: no other thread is at work.
        unsafe { self.shared.fill(rest_of(starts), bodies, length, &Cells::new(&mut taken)) };
    }
}
