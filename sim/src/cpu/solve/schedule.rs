//! The order in which Gauss–Seidel visits blocks: those visited concurrently have no moving body in common, so that the result does not
//! depend on the number of threads.
//!
//! Blocks in general are coloured: those of a colour have no body in common. Contacts in tiles ([`crate::contacts::Tiles`]) are coloured
//! tile by tile, each tile is visited by one thread, whose cache has its bodies, and only the few contacts in no tile are coloured for
//! all threads together.

use super::cells::Cells;
use crate::contacts::Contacts;
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
    /// the blocks' bodies are 0 at first.
    ///
    /// # Safety
    /// No other thread touches the entries of the blocks' moving bodies.
    pub unsafe fn fill(&mut self, blocks: Range<u32>, bodies: impl Fn(u32) -> [Option<u32>; 2], taken: &Cells<u64>) {
        // A body with more than 64 blocks: its further blocks have colours of their own.
        let mut n_colors = 64;
        let color_of = |block: u32| {
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
        let color: Vec<u32> = blocks.clone().map(color_of).collect();
        let colored = || color.iter().copied().zip(blocks.clone());
        distribute_cpu(n_colors as usize, colored, &mut self.start, &mut self.order);
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

/// Contacts by tiles and colours.
#[derive(Default)]
pub struct Tiled {
    /// The tiles of both rounds; those of a round have no moving body in common.
    pub rounds: [Vec<Colored>; 2],
    /// The contacts in no tile.
    pub shared: Colored,
}

impl Tiled {
    /// Colour the contacts tile by tile.
    pub fn fill(&mut self, contacts: &Contacts, inv_mass: &[f64]) {
        let Contacts { bodies, tiles, .. } = contacts;
        let moving = |body: u32| (inv_mass[body as usize] > 0.0).then_some(body);
        let bodies = |contact: u32| bodies[contact as usize].map(moving);
        let mut taken = vec![0; inv_mass.len()];
        for (tiles, start) in self.rounds.iter_mut().zip(tiles.rounds()) {
            taken.fill(0);
            let taken = Cells::new(&mut taken);
            tiles.resize_with(start.len() - 1, Colored::default);
            let each = tiles.par_iter_mut().zip(start.par_windows(2)).with_max_len(1);
            // SAFETY: the tiles of a round have no moving body in common.
            each.for_each(|(colored, ends)| unsafe { colored.fill(ends[0]..ends[1], bodies, &taken) });
        }
        taken.fill(0);
        // SAFETY: no other thread is at work.
        unsafe { self.shared.fill(tiles.rest(), bodies, &Cells::new(&mut taken)) };
    }
}
