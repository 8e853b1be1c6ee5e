//! The order in which Gauss–Seidel visits blocks: those visited concurrently have no moving body in common, so that the result does not
//! depend on the number of threads.
//!
//! Blocks in general are coloured: those of a colour have no body in common. Contacts in tiles ([`crate::contacts::Tiles`]) are coloured
//! tile by tile, each tile is visited by one thread, whose cache has its bodies, and only the few contacts in no tile are coloured for
//! all threads together.

use super::cells::Cells;
use super::flow::{Flow, NO_TILE};
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

    /// The blocks of each colour.
    pub fn colors(&self) -> impl Iterator<Item = &[u32]> {
        self.start.windows(2).map(|ends| &self.order[ends[0] as usize..ends[1] as usize])
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
    /// Which tiles have moving bodies in common; the blocks in no tile are as a last one.
    pub flow: Flow,
    /// The tile of each body in each round, counted on from round to round.
    tile_of: [Vec<u32>; 3],
    /// The bodies by their first tiles, those of none at the end (n_bodies): what a thread visits lies together.
    pub order: Vec<u32>,
    /// The place of each body in `order`; the one after the last is that of no body (n_bodies + 1).
    pub place: Vec<u32>,
}

impl Tiled {
    /// The blocks of each colour of each tile of both rounds, and of those in no tile.
    pub fn colors(&self) -> impl Iterator<Item = &[u32]> {
        self.rounds.iter().flatten().chain([&self.shared]).flat_map(Colored::colors)
    }

    /// Colour the blocks tile by tile.
    pub fn fill(&mut self, contacts: &Contacts, blocks: &Blocks, inv_mass: &[f64]) {
        let moving = |body: u32| (inv_mass[body as usize] > 0.0).then_some(body);
        let bodies = |block: u32| contacts.bodies[blocks.contacts(block).start].map(moving);
        let length = |block: u32| blocks.contacts(block).len();
        let (starts, n_first) = (blocks.starts(contacts), contacts.tiles.n_first);
        let mut taken = vec![0; inv_mass.len()];
        let mut n_tiles = 0;
        for tile_of in &mut self.tile_of {
            tile_of.clear();
            tile_of.resize(inv_mass.len(), NO_TILE);
        }
        let [of_first, of_second, of_shared] = &mut self.tile_of;
        let own = |blocks: Range<u32>, tile: u32, tile_of: &Cells<u32>| {
            for body in blocks.flat_map(bodies).flatten() {
                // SAFETY: no other thread touches the entries of the tile's moving bodies.
                unsafe { tile_of.set(body as usize, tile) };
            }
        };
        let rounds = self.rounds.iter_mut().zip(rounds_of(starts, n_first)).zip([of_first, of_second]);
        for ((tiles, start), tile_of) in rounds {
            taken.fill(0);
            let (taken, tile_of) = (Cells::new(&mut taken), Cells::new(tile_of));
            tiles.resize_with(start.len() - 1, Colored::default);
            let each = tiles.par_iter_mut().zip(start.par_windows(2)).enumerate().with_max_len(1);
            each.for_each(|(tile, (colored, ends))| {
                own(ends[0]..ends[1], n_tiles + tile as u32, &tile_of);
                // SAFETY: the tiles of a round have no moving body in common.
                unsafe { colored.fill(ends[0]..ends[1], bodies, length, &taken) }
            });
            n_tiles += tiles.len() as u32;
        }
        taken.fill(0);
        own(rest_of(starts), n_tiles, &Cells::new(of_shared));
        // SAFETY: no other thread is at work.
        unsafe { self.shared.fill(rest_of(starts), bodies, length, &Cells::new(&mut taken)) };
        let [n_first, end] = [self.rounds[0].len(), n_tiles as usize];
        self.flow.fill([0, n_first, end, end + 1], self.tile_of.each_ref().map(|tile_of| &tile_of[..]));
        let first_of = |body: u32| self.tile_of.each_ref().map(|tile_of| tile_of[body as usize]).into_iter().min();
        let n_bodies = inv_mass.len() as u32;
        let items = || (0..n_bodies).map(|body| (first_of(body).unwrap_or(NO_TILE).min(n_tiles + 1), body));
        distribute_cpu(n_tiles as usize + 2, items, &mut vec![], &mut self.order);
        self.place.resize(n_bodies as usize + 1, n_bodies);
        for (body, place) in self.order.iter().zip(0..) {
            self.place[*body as usize] = place;
        }
        self.place[n_bodies as usize] = n_bodies;
    }
}
