//! Sweeps over tiles that wait for their neighbours alone: a tile is visited once those before it that share a body with it have been, so that
//! threads do not wait for each other at the end of each round. Beds of thousands of bodies have few tiles, of different sizes.
//!
//! Two tiles that share a body are visited in the same order as in rounds, so that the result is the same bits for any number of threads.

use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};
use std::sync::{Mutex, TryLockError};

/// The tile of a body that has none.
pub const NO_TILE: u32 = u32::MAX;

/// Which tiles of a sweep share moving bodies; those come in the order of a sweep, of one round after the other.
#[derive(Default)]
pub struct Flow {
    /// Neighbours of each tile.
    neighbors: Vec<Vec<u32>>,
    /// First tile of each round, and the end.
    rounds: [usize; 4],
}

/// The sweeps of a run.
pub struct Sweeps<W, E> {
    /// The most sweeps.
    pub most: u32,
    /// Whether a sweep begins only once it is known what those before it have left. Others begin while the one before is at work.
    pub waits: W,
    /// Whether what a sweep has left is enough. It is then the last one, or the one after it, if that does not wait.
    pub is_enough: E,
}

/// How many sweeps are at work at most.
const AHEAD: u32 = 2;

/// How many times a thread looks for a tile before it lets others run.
const LOOKS: u32 = 64;

/// How many times a thread looks for a tile before it visits those of other threads, as of one that is not running: a tile that changes threads
/// costs as much as several visits.
const STEALS: u32 = 1024;

impl Flow {
    /// Find the neighbours among the tiles of all rounds: `rounds` has the first tile of each round and the end, `tile_of` the tile of each body in
    /// each round, counted on from round to round, or [`NO_TILE`].
    pub fn fill(&mut self, rounds: [usize; 4], tile_of: [&[u32]; 3]) {
        self.rounds = rounds;
        self.neighbors.iter_mut().for_each(Vec::clear);
        self.neighbors.resize(rounds[3], vec![]);
        let [first, second, third] = tile_of;
        for ((a, b), c) in first.iter().zip(second).zip(third) {
            for [a, b] in [[*a, *b], [*a, *c], [*b, *c]] {
                if a != NO_TILE && b != NO_TILE && !self.neighbors[a as usize].contains(&b) {
                    self.neighbors[a as usize].push(b);
                    self.neighbors[b as usize].push(a);
                }
            }
        }
    }

    /// Visit all tiles, sweep after sweep: `tiles` has what `visit` needs of each besides the sweep, `cost` how long it takes. What the visits of
    /// a sweep return is added up in the order of the tiles (the first number), and the greatest taken (the second). Returns the number of
    /// sweeps, and what the last one has left.
    pub fn run<T: Send>(
        &self,
        sweeps: &Sweeps<impl Fn(u32) -> bool + Sync, impl Fn(u32, [f64; 2]) -> bool + Sync>,
        tiles: Vec<T>,
        cost: impl Fn(&T) -> usize,
        visit: impl Fn(&mut T, u32) -> [f64; 2] + Sync,
    ) -> (u32, [f64; 2]) {
        let n_threads = rayon::current_num_threads().min(self.neighbors.len());
        let cost: Vec<usize> = tiles.iter().map(cost).collect();
        let run = Run {
            flow: self,
            home: self.rounds.windows(2).flat_map(|ends| homes(n_threads, &cost[ends[0]..ends[1]])).collect(),
            tiles: tiles.into_iter().map(Mutex::new).collect(),
            n_done: (0..self.neighbors.len()).map(|_| AtomicU32::new(0)).collect(),
            left: (0..self.neighbors.len()).map(|_| Default::default()).collect(),
            n_open: std::array::from_fn(|_| AtomicU32::new(self.neighbors.len() as u32)),
            known: AtomicU32::new(0),
            end: AtomicU32::new(sweeps.most),
        };
        let work = |thread: usize| run.work(thread, sweeps, &visit);
        rayon::scope(|scope| {
            for thread in 1..n_threads {
                let work = &work;
                scope.spawn(move |_| work(thread));
            }
            work(0);
        });
        let end = run.end.into_inner();
        let at = (end as usize + SLOTS - 1) % SLOTS;
        (end, run.left.iter().map(|left| left[at].read()).fold([0.0; 2], and))
    }
}

/// Sweeps whose results are kept: those at work, and the one before.
const SLOTS: usize = AHEAD as usize + 1;

/// What a visit has left.
#[derive(Default)]
struct Left([AtomicU64; 2]);

impl Left {
    fn write(&self, left: [f64; 2]) {
        self.0.iter().zip(left).for_each(|(slot, value)| slot.store(value.to_bits(), Ordering::Relaxed));
    }

    fn read(&self) -> [f64; 2] {
        self.0.each_ref().map(|slot| f64::from_bits(slot.load(Ordering::Relaxed)))
    }
}

/// What two tiles have left together.
fn and([a, b]: [f64; 2], [c, d]: [f64; 2]) -> [f64; 2] {
    [a + c, b.max(d)]
}

/// The thread of each of the tiles of a round that cost so much, which lie one behind the other in space: all threads have about as much to do, and
/// few tiles a neighbour of another thread.
fn homes(n_threads: usize, cost: &[usize]) -> impl Iterator<Item = usize> {
    let all = cost.iter().sum::<usize>().max(1);
    cost.iter().scan(0, move |before, cost| {
        let middle = 2 * *before + cost;
        *before += cost;
        Some((n_threads * middle / (2 * all)).min(n_threads - 1))
    })
}

/// The state of a run.
struct Run<'a, T> {
    flow: &'a Flow,
    tiles: Vec<Mutex<T>>,
    /// The thread that visits each tile unless another has nothing to do: its cache has it.
    home: Vec<usize>,
    /// Number of sweeps that each tile has had.
    n_done: Vec<AtomicU32>,
    /// What the last visits of each tile have left, by their sweeps.
    left: Vec<[Left; SLOTS]>,
    /// Number of tiles that a sweep has not come to yet, of those that have begun.
    n_open: [AtomicU32; SLOTS],
    /// Number of sweeps that have come to their end.
    known: AtomicU32,
    /// Number of sweeps that there will be, as far as is known.
    end: AtomicU32,
}

impl<T> Run<'_, T> {
    /// Visit tiles until all have been visited by all sweeps.
    fn work(
        &self,
        thread: usize,
        sweeps: &Sweeps<impl Fn(u32) -> bool, impl Fn(u32, [f64; 2]) -> bool>,
        visit: &impl Fn(&mut T, u32) -> [f64; 2],
    ) {
        let n = self.tiles.len();
        let (mut next, mut looks) = (0, 0);
        loop {
            let mut is_over = true;
            let found = (next..n).chain(0..next).find(|tile| {
                let sweep = self.n_done[*tile].load(Ordering::Acquire);
                is_over &= sweep >= self.end.load(Ordering::Acquire);
                let is_own = self.home[*tile] == thread || looks >= STEALS;
                is_own && self.is_ready(*tile, sweep, &sweeps.waits) && self.visit(*tile, sweeps, visit)
            });
            match found {
                Some(tile) => (next, looks) = ((tile + 1) % n, 0),
                None if is_over => return,
                None => {
                    looks += 1;
                    if looks % LOOKS == 0 { std::thread::yield_now() } else { std::hint::spin_loop() }
                }
            }
        }
    }

    /// Whether a sweep may come to a tile: it has come to the neighbours before it, the sweep before to those after it.
    fn is_ready(&self, tile: usize, sweep: u32, waits: &impl Fn(u32) -> bool) -> bool {
        let known = self.known.load(Ordering::Acquire);
        let ahead = if waits(sweep) { 1 } else { AHEAD };
        let n_of = |neighbor: u32| self.n_done[neighbor as usize].load(Ordering::Acquire);
        let has_been = |neighbor: &u32| n_of(*neighbor) >= sweep + ((*neighbor as usize) < tile) as u32;
        sweep < known + ahead
            && sweep < self.end.load(Ordering::Acquire)
            && self.flow.neighbors[tile].iter().all(has_been)
    }

    /// Visit a tile unless another thread does, or has. Returns whether it has been visited.
    fn visit(
        &self,
        tile: usize,
        sweeps: &Sweeps<impl Fn(u32) -> bool, impl Fn(u32, [f64; 2]) -> bool>,
        visit: &impl Fn(&mut T, u32) -> [f64; 2],
    ) -> bool {
        let mut own = match self.tiles[tile].try_lock() {
            Ok(own) => own,
            Err(TryLockError::WouldBlock) => return false,
            Err(TryLockError::Poisoned(fault)) => panic!("{fault}"),
        };
        let sweep = self.n_done[tile].load(Ordering::Acquire);
        if !self.is_ready(tile, sweep, &sweeps.waits) {
            return false;
        }
        let slot = sweep as usize % SLOTS;
        self.left[tile][slot].write(visit(&mut own, sweep));
        self.n_done[tile].store(sweep + 1, Ordering::Release);
        if self.n_open[slot].fetch_sub(1, Ordering::AcqRel) == 1 {
            // The last tile of the sweep: those after it cannot have ended yet.
            self.n_open[slot].store(self.tiles.len() as u32, Ordering::Relaxed);
            if (sweeps.is_enough)(sweep, self.left.iter().map(|left| left[slot].read()).fold([0.0; 2], and)) {
                let last = if (sweeps.waits)(sweep + 1) { sweep } else { sweep + 1 };
                self.end.fetch_min(last + 1, Ordering::AcqRel);
            }
            self.known.store(sweep + 1, Ordering::Release);
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tiles in a row, the even ones in the first round and the odd ones in the second, mix what their bodies have: as in rounds, by any number of
    /// threads.
    #[test]
    fn tiles_see_what_their_neighbours_have_done() {
        const TILES: usize = 9;
        let order: Vec<usize> = (0..TILES).step_by(2).chain((1..TILES).step_by(2)).collect();
        let place = |tile: usize| order.iter().position(|t| *t == tile).unwrap() as u32;
        // Body b lies between the tiles b − 1 and b.
        let of_round = |odd: usize| -> Vec<u32> {
            let of_body = |b: usize| [b.wrapping_sub(1), b].into_iter().find(|t| *t < TILES && t % 2 == odd);
            (0..=TILES).map(|b| of_body(b).map_or(NO_TILE, place)).collect()
        };
        let mut flow = Flow::default();
        flow.fill([0, TILES.div_ceil(2), TILES, TILES], [&of_round(0), &of_round(1), &[NO_TILE; TILES + 1]]);
        let mix = |a: f64, b: f64| [(3.0 * a + b) / 4.0 + 0.1, (a + 2.0 * b) / 3.0];
        let serial = |sweeps: u32| {
            let mut bodies: Vec<f64> = (0..=TILES).map(|b| b as f64).collect();
            for tile in (0..sweeps).flat_map(|_| &order) {
                [bodies[*tile], bodies[tile + 1]] = mix(bodies[*tile], bodies[tile + 1]);
            }
            bodies
        };
        for threads in [1, 2, 3, 7] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            for (enough, waits, n_sweeps) in [(f64::INFINITY, false, 2), (f64::INFINITY, true, 1), (-1.0, false, 20)] {
                let bodies: Vec<AtomicU64> = (0..=TILES).map(|b| AtomicU64::new((b as f64).to_bits())).collect();
                let visit = |tile: &mut usize, _: u32| {
                    let pair = [*tile, *tile + 1].map(|b| &bodies[b]);
                    let [a, b] = pair.map(|body| f64::from_bits(body.load(Ordering::Relaxed)));
                    let mixed = mix(a, b);
                    std::thread::sleep(std::time::Duration::from_micros(37 * (*tile as u64 % 4)));
                    pair.iter().zip(mixed).for_each(|(body, x)| body.store(x.to_bits(), Ordering::Relaxed));
                    [mixed[0], mixed[1]]
                };
                let sweeps = Sweeps { most: 20, waits: |_| waits, is_enough: |_, left: [f64; 2]| left[0] <= enough };
                let (n, left) = pool.install(|| flow.run(&sweeps, order.clone(), |_| 1, visit));
                let found: Vec<f64> = bodies.iter().map(|b| f64::from_bits(b.load(Ordering::Relaxed))).collect();
                assert_eq!((n, &found), (n_sweeps, &serial(n_sweeps)), "{threads} threads");
                assert!(left[1] <= left[0] && left[1] > 0.0, "{left:?}");
            }
        }
    }
}
