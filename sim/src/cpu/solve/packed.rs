//! Blocks packed in groups, chunk by chunk: the columns that a sweep streams through, and the order in which threads visit them.
//!
//! A chunk is what one thread visits without a stop: groups of one colour of a tile, or all colours of a small tile. Where a round has
//! many tiles, each thread takes whole tiles, whose bodies stay in its cache, and where it has few, those of its share, unless shares would be
//! so uneven that it takes less time to go through the colours of all tiles together, chunk by chunk. Sums are those of the chunks in their
//! order, whichever way it was.

use super::bodies::BodyOperator;
use super::cells::Cells;
use super::group::{self, Group, Grouped, Motion, Source, Work, act};
use super::response::Response;
use super::schedule::{Blocks, Colored, Tiled};
use crate::lanes::Lanes;
use crate::rows::{CHUNK, fill_rows};
use crate::settings::FrictionLaw;
use crate::team::Team;
use crate::twist::Twist;
use glam::DVec3;
use rayon::prelude::*;
use std::ops::Range;

/// All blocks in groups, and the motions of the bodies.
pub struct Packed<T: Grouped<L>, const L: usize, G: Group<T, L>> {
    /// The rows of all contacts, and of the bodies by places.
    rows: Vec<G::Row>,
    bodies: Vec<G::Body>,
    groups: Vec<G>,
    motion: Vec<Motion<T>>,
    chunks: Vec<Chunk>,
    /// What [`Group::visit`] returned of each chunk (n_chunks).
    visited: Vec<[f64; 2]>,
    /// The rounds of tiles; the blocks in no tile are one tile, the last round.
    rounds: [Round; 3],
}

/// Groups that one thread visits without a stop.
struct Chunk {
    round: usize,
    tile: usize,
    groups: Range<usize>,
    /// Their blocks in [`Colored::blocks`], or all of these, where the chunk is all of its tile.
    blocks: Option<Range<usize>>,
}

/// The tiles of a round.
#[derive(Default)]
struct Round {
    tiles: Vec<Tile>,
    /// The chunks of the first colour of each tile, of the second, and so on; chunks that are a whole tile are with the first.
    phases: Vec<Vec<usize>>,
    /// The tiles of each thread that has any, where that is the shortest way to visit all.
    shares: Vec<Vec<usize>>,
}

/// What is known of a tile.
#[derive(Clone, Default)]
struct Tile {
    chunks: Range<usize>,
    n_contacts: f64,
    /// What [`Group::visit`] returned when it was visited last.
    visited: [f64; 2],
    /// Whether its bodies are slow.
    is_slow: bool,
}

/// Which tiles a sweep visits; the blocks in no tile it does in any case.
#[derive(Clone, Copy)]
pub enum Which {
    /// All.
    All,
    /// Those in which a gap closed at this speed, m/s, or faster.
    Closing(f64),
    /// Those of slow bodies whose contacts had a greater residual than this in the root mean square, m/s.
    Unsettled(f64),
}

impl Which {
    fn has(self, tile: &Tile) -> bool {
        let [residual2, closing] = tile.visited;
        match self {
            Which::All => true,
            Which::Closing(least) => closing >= least,
            Which::Unsettled(residual) => tile.is_slow && residual2 > residual * residual * tile.n_contacts,
        }
    }
}

impl<T: Grouped<L>, const L: usize, G: Group<T, L>> Default for Packed<T, L, G> {
    fn default() -> Self {
        Packed {
            rows: vec![],
            bodies: vec![],
            groups: vec![],
            motion: vec![],
            chunks: vec![],
            visited: vec![],
            rounds: Default::default(),
        }
    }
}

impl<T: Grouped<L>, const L: usize, G: Group<T, L>> Packed<T, L, G> {
    /// Chunks up to which a tile is one chunk.
    const SMALL: usize = 2;
    /// The round of the blocks in no tile.
    const LAST: usize = 2;
    /// Tiles for each thread from which on threads take them as they come.
    const MANY: usize = 4;

    /// Groups of each chunk of a colour with `n` of them: chunks are even in number, for two threads.
    fn chunk(n: usize) -> usize {
        if n <= G::CHUNK { n } else { n.div_ceil(2 * n.div_ceil(2 * G::CHUNK)) }
    }

    /// Bytes of the groups, and of the rows of their contacts.
    pub fn size(&self) -> usize {
        size_of_val(&self.groups[..]) + size_of_val(&self.rows[..])
    }

    /// Pack the blocks with the impulses γ, project these onto their cones, and compute the motions of the bodies with them.
    pub fn fill(
        &mut self,
        team: &Team,
        op: &BodyOperator,
        (blocks, tiled): (&Blocks, &Tiled),
        gamma: &[DVec3],
        is_exact: bool,
    ) {
        let n_groups = self.lay_out(team.n_threads(), blocks, tiled);
        if self.groups.len() < n_groups {
            self.groups.resize(n_groups, G::empty());
        }
        let from = Source { op, blocks, place: &tiled.place, gamma, is_exact };
        let (mut rows, mut of_bodies) = (std::mem::take(&mut self.rows), std::mem::take(&mut self.bodies));
        rows.resize(op.contacts.len(), G::Row::default());
        fill_rows(&mut rows, |i| G::row(&from, i));
        // Places without a body are at rest.
        self.motion.clear();
        self.motion.resize(tiled.n_places, Motion::default());
        of_bodies.resize(tiled.n_places, G::Body::default());
        let (motion, body, masses) = (Cells::new(&mut self.motion), Cells::new(&mut of_bodies), op.masses);
        (0..masses.inv_mass.len()).into_par_iter().with_min_len(CHUNK).for_each(|b| {
            let place = tiled.place[b] as usize;
            // SAFETY: each body has a place of its own.
            unsafe {
                motion.set(place, Motion::of(&op.free(b), masses.inv_mass[b], masses.inv_moment[b]));
                body.set(place, G::body(&from, b));
            }
        });
        self.each_chunk(team, Which::All, |chunk, groups, motion| {
            let own = chunk.blocks_by_groups::<L>(tiled);
            // SAFETY: the promise of `each_chunk`.
            unsafe { group::widest(Pack { groups, own, from: &from, rows: (&rows, &of_bodies), motion }) };
            [0.0; 2]
        });
        (self.rows, self.bodies) = (rows, of_bodies);
    }

    /// Lay the chunks of all tiles out for a number of threads; returns the number of groups.
    fn lay_out(&mut self, n_threads: usize, blocks: &Blocks, tiled: &Tiled) -> usize {
        let Packed { chunks, rounds, .. } = self;
        let mut n_groups = 0;
        let mut take = |n_blocks: usize| {
            n_groups += n_blocks.div_ceil(L);
            n_groups - n_blocks.div_ceil(L)..n_groups
        };
        chunks.clear();
        for (round, (own, tiles)) in rounds.iter_mut().zip(tiled.all_rounds()).enumerate() {
            own.tiles.clear();
            own.phases.iter_mut().for_each(Vec::clear);
            for (tile, colored) in tiles.iter().enumerate() {
                let first = chunks.len();
                let of_tile: usize = colored.ranges().map(|color| color.len().div_ceil(L)).sum();
                if of_tile <= Self::SMALL * G::CHUNK {
                    own.phase(0).push(chunks.len());
                    let groups = colored.ranges().fold(None, |all: Option<Range<usize>>, color| {
                        let groups = take(color.len());
                        Some(all.map_or(groups.start, |all| all.start)..groups.end)
                    });
                    chunks.push(Chunk { round, tile, groups: groups.unwrap_or(0..0), blocks: None });
                } else {
                    for (phase, color) in colored.ranges().enumerate() {
                        let length = L * Self::chunk(color.len().div_ceil(L));
                        for start in color.clone().step_by(length) {
                            let blocks = start..(start + length).min(color.end);
                            own.phase(phase).push(chunks.len());
                            chunks.push(Chunk { round, tile, groups: take(blocks.len()), blocks: Some(blocks) });
                        }
                    }
                }
                let contacts = colored.blocks().iter().map(|block| blocks.contacts(*block).len());
                let n_contacts = contacts.sum::<usize>() as f64;
                own.tiles.push(Tile { chunks: first..chunks.len(), n_contacts, ..Tile::default() });
            }
            // A thread has the same neighbourhood in each phase.
            let place = |chunk: &usize| {
                let Chunk { tile, blocks, .. } = &chunks[*chunk];
                (*tile, blocks.clone().and_then(|own| tiles[*tile].blocks().get(own.start)))
            };
            own.phases.iter_mut().for_each(|phase| phase.sort_by_key(place));
            own.share_out(chunks, n_threads, (Self::MANY * n_threads, G::CHUNK));
        }
        self.visited.clear();
        self.visited.resize(self.chunks.len(), [0.0; 2]);
        n_groups
    }

    /// The velocity of a body.
    pub fn twist(&self, tiled: &Tiled, body: usize) -> Twist {
        self.motion[tiled.place[body] as usize].twist()
    }

    /// Load the motions of the bodies from a response.
    pub fn load(&mut self, tiled: &Tiled, response: &Response) {
        for (place, twist) in tiled.place.iter().zip(&response.twist) {
            let motion = &mut self.motion[*place as usize];
            *motion = Motion::of(twist, motion.row[3].wide(), motion.row[7].wide());
        }
    }

    /// Store the motions of the bodies to a response.
    pub fn store(&self, tiled: &Tiled, response: &mut Response) {
        response.twist.resize(tiled.place.len() - 1, Twist::default());
        fill_rows(&mut response.twist, |b| self.twist(tiled, b));
    }

    /// Maximum speed of a body, m/s.
    pub fn max_speed(&self) -> f64 {
        self.motion.iter().fold(0.0f64, |max, m| max.max(m.twist().v.length_squared())).sqrt()
    }

    /// Whether a sweep would visit any tile.
    pub fn has(&self, which: Which) -> bool {
        self.rounds.iter().flat_map(|round| &round.tiles).any(|tile| which.has(tile))
    }

    /// The blocks of some tiles.
    pub fn blocks(&self, tiled: &Tiled, which: Which) -> Vec<u32> {
        let tiles = self.rounds.iter().zip(tiled.all_rounds()).flat_map(|(round, tiles)| round.tiles.iter().zip(tiles));
        tiles.filter(|(tile, _)| which.has(tile)).flat_map(|(_, colored)| colored.blocks().iter().copied()).collect()
    }

    /// Find the tiles of slow bodies, which are no faster than a speed, m/s.
    pub fn find_slow(&mut self, speed: f64) {
        let Packed { groups, motion, chunks, rounds, .. } = self;
        let is_slow = |place: &u32| motion[*place as usize].twist().v.length_squared() <= speed * speed;
        let of_group = |group: &G| group.bodies().as_flattened().iter().all(is_slow);
        for tile in rounds.iter_mut().flat_map(|round| &mut round.tiles) {
            tile.is_slow =
                chunks[tile.chunks.clone()].iter().all(|chunk| groups[chunk.groups.clone()].iter().all(of_group));
        }
    }

    /// Visit the blocks of some tiles once, and those in no tile. Returns what [`Group::visit`] does.
    pub fn sweep(&mut self, team: &Team, friction: FrictionLaw, omega: f64, which: Which) -> [f64; 2] {
        match friction {
            FrictionLaw::Relaxed => self.visit::<{ act::RELAXED }>(team, omega, which),
            FrictionLaw::Exact => self.visit::<{ act::EXACT }>(team, omega, which),
        }
    }

    fn visit<const ACT: u8>(&mut self, team: &Team, omega: f64, which: Which) -> [f64; 2] {
        // SAFETY: the promise of `each_chunk`.
        self.each_chunk(team, which, |_, groups, motion| unsafe {
            group::widest(Visit::<T, L, G, ACT> { groups, motion, omega })
        })
    }

    /// Visit the chunks of some tiles, and those of the blocks in no tile. Sums what `visit` returns, the first numbers, and finds the greatest of the second.
    /// No other thread touches the groups of a chunk, or the motions of its moving bodies, while it is visited.
    fn each_chunk(
        &mut self,
        team: &Team,
        which: Which,
        visit: impl Fn(&Chunk, &mut [G], Cells<Motion<T>>) -> [f64; 2] + Sync,
    ) -> [f64; 2] {
        let Packed { groups, motion, chunks, visited, rounds, .. } = self;
        let (groups, motion, visited) = (Cells::new(groups), Cells::new(motion), Cells::new(visited));
        let visit_chunk = |k: usize| {
            let chunk = &chunks[k];
            // SAFETY: each chunk is visited by one task, and chunks have no group in common. Tasks that run concurrently have whole tiles of a
            // round, or chunks of a phase, neither of which have a moving body in common.
            unsafe { visited.set(k, visit(chunk, groups.range(chunk.groups.clone()), motion)) };
        };
        let and = |[a, b]: [f64; 2], [c, d]: [f64; 2]| [a + c, b.max(d)];
        let mut all = [0.0; 2];
        for (k, Round { tiles, phases, shares }) in rounds.iter_mut().enumerate() {
            let has = |tile: &Tile| k == Self::LAST || which.has(tile);
            let visit_tile = |tile: usize| {
                if has(&tiles[tile]) {
                    tiles[tile].chunks.clone().for_each(visit_chunk);
                }
            };
            if !shares.is_empty() && matches!(which, Which::All) {
                team.run(shares.len(), &|share| shares[share].iter().for_each(|tile| visit_tile(*tile)));
            } else if tiles.len() >= Self::MANY * team.n_threads() || team.n_threads() == 1 {
                team.run(tiles.len(), &visit_tile);
            } else {
                for phase in phases.iter() {
                    team.run(phase.len(), &|k| {
                        if has(&tiles[chunks[phase[k]].tile]) {
                            visit_chunk(phase[k]);
                        }
                    });
                }
            }
            for tile in tiles {
                let was_visited = has(tile);
                if was_visited {
                    // SAFETY: all tasks have ended.
                    let of_chunks = tile.chunks.clone().map(|chunk| unsafe { visited.get(chunk) });
                    tile.visited = of_chunks.fold([0.0; 2], and);
                }
                let [residual2, closing] = tile.visited;
                all = and(all, [if was_visited { residual2 } else { 0.0 }, closing]);
            }
        }
        all
    }

    /// Read the impulses of the contacts back, and the angular ones that follow them if there are any.
    pub fn unpack(&self, (blocks, tiled): (&Blocks, &Tiled), n_contacts: usize, gamma: &mut [DVec3]) {
        let rolls_from = (G::ROLLS && gamma.len() > n_contacts).then_some(n_contacts);
        let gamma = Cells::new(gamma);
        self.chunks.par_iter().for_each(|chunk| {
            let (groups, own) = (&self.groups[chunk.groups.clone()], chunk.blocks_by_groups::<L>(tiled));
            // SAFETY: each contact is in one block, and each chunk is one task's.
            unsafe { group::widest(Unpack { groups, own, blocks, gamma, rolls_from }) };
        });
    }
}

/// [`Group::visit`] with the action `ACT`. No other thread touches the motions of the groups' moving bodies.
struct Visit<'a, T, const L: usize, G, const ACT: u8> {
    groups: &'a mut [G],
    motion: Cells<'a, Motion<T>>,
    omega: f64,
}

impl<T: Grouped<L>, const L: usize, G: Group<T, L>, const ACT: u8> Work<T, L> for Visit<'_, T, L, G, ACT> {
    type Out = [f64; 2];

    #[inline(always)]
    unsafe fn run<V: Lanes<T, L>>(self) -> [f64; 2] {
        // SAFETY: the caller's promise.
        unsafe { G::visit::<ACT, V>(self.groups, &self.motion, self.omega) }
    }
}

/// Fill groups, and visit them for the first time while they are at hand. No other thread touches the motions of their moving bodies.
struct Pack<'a, T: Grouped<L>, const L: usize, G: Group<T, L>, B> {
    groups: &'a mut [G],
    /// The blocks of each group.
    own: B,
    from: &'a Source<'a>,
    rows: (&'a [G::Row], &'a [G::Body]),
    motion: Cells<'a, Motion<T>>,
}

impl<'a, T: Grouped<L>, const L: usize, G: Group<T, L>, B: Iterator<Item = &'a [u32]>> Work<T, L>
    for Pack<'a, T, L, G, B>
{
    type Out = ();

    #[inline(always)]
    unsafe fn run<V: Lanes<T, L>>(self) {
        for (group, own) in self.groups.iter_mut().zip(self.own) {
            group.fill::<V>(self.from, self.rows, own);
        }
        // SAFETY: the caller's promise.
        unsafe { G::visit::<{ act::APPLY }, V>(self.groups, &self.motion, 1.0) };
    }
}

/// Read the impulses of groups back. No other thread touches those of their contacts.
struct Unpack<'a, G, B> {
    groups: &'a [G],
    /// The blocks of each group.
    own: B,
    blocks: &'a Blocks,
    gamma: Cells<'a, DVec3>,
    /// First angular impulse, if there are any.
    rolls_from: Option<usize>,
}

impl<'a, T: Grouped<L>, const L: usize, G: Group<T, L>, B: Iterator<Item = &'a [u32]>> Work<T, L> for Unpack<'a, G, B> {
    type Out = ();

    #[inline(always)]
    unsafe fn run<V: Lanes<T, L>>(self) {
        let mut row = [[[T::default(); 8]; L]; Blocks::MOST];
        for (group, own) in self.groups.iter().zip(self.own) {
            group.impulses::<V>(&mut row);
            for (l, block) in own.iter().enumerate() {
                for (k, i) in self.blocks.contacts(*block).enumerate() {
                    let [x, y, z, u, v, w, ..] = row[k][l].map(T::wide);
                    // SAFETY: the caller's promise.
                    unsafe { self.gamma.set(i, DVec3::new(x, y, z)) };
                    if let Some(first) = self.rolls_from {
                        // SAFETY: as above.
                        unsafe { self.gamma.set(first + i, DVec3::new(u, v, w)) };
                    }
                }
            }
        }
    }
}

impl Round {
    /// The chunks of a phase.
    fn phase(&mut self, phase: usize) -> &mut Vec<usize> {
        if self.phases.len() <= phase {
            self.phases.resize_with(phase + 1, Vec::new);
        }
        &mut self.phases[phase]
    }

    /// Share the tiles out among threads where there are fewer than `many`, and the largest share takes less time than the phases, each of which begins
    /// and ends together: about the time of `chunk` groups.
    fn share_out(&mut self, chunks: &[Chunk], n_threads: usize, (many, chunk): (usize, usize)) {
        self.shares.clear();
        if n_threads == 1 || self.tiles.len() >= many {
            return;
        }
        let n_groups = |own: &mut dyn Iterator<Item = usize>| own.map(|k| chunks[k].groups.len()).sum::<usize>();
        let mut tiles: Vec<_> =
            self.tiles.iter().enumerate().map(|(k, tile)| (n_groups(&mut tile.chunks.clone()), k)).collect();
        tiles.sort_unstable_by(|a, b| b.cmp(a));
        let mut loads = vec![0; n_threads];
        self.shares.resize(n_threads, vec![]);
        for (n, tile) in tiles {
            let least = (0..n_threads).min_by_key(|k| loads[*k]).unwrap_or(0);
            loads[least] += n;
            self.shares[least].push(tile);
        }
        let of_phase = |phase: &Vec<usize>| n_groups(&mut phase.iter().copied()).div_ceil(n_threads) + chunk;
        let phases = self.phases.iter().filter(|phase| !phase.is_empty());
        if loads.iter().max() > Some(&phases.map(of_phase).sum()) {
            self.shares.clear();
        }
        self.shares.retain(|share| !share.is_empty());
    }
}

impl Chunk {
    /// The blocks of each of its groups of `L` lanes.
    fn blocks_by_groups<'a, const L: usize>(&self, tiled: &'a Tiled) -> impl Iterator<Item = &'a [u32]> + use<'a, L> {
        let colored: &Colored = &tiled.all_rounds()[self.round][self.tile];
        let (own, whole) = match self.blocks.clone() {
            Some(own) => (Some(own), None),
            None => (None, Some(colored.ranges())),
        };
        let colors = own.into_iter().chain(whole.into_iter().flatten());
        colors.flat_map(|color| colored.blocks()[color].chunks(L))
    }
}
